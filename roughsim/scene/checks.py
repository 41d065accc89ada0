"""Checks of the sections of a scene against each other; each raises a ValueError with the keys, values and limits."""

import math
from collections.abc import Mapping, Sequence

from roughsim.observables.catalogue import ASKED_BY, CAMERA, OBSERVABLES, observables_of
from roughsim.scene.bodies import Bodies
from roughsim.scene.camera import CameraSection
from roughsim.scene.ensemble import EnsembleSection
from roughsim.scene.faces import Faces
from roughsim.scene.numerics import DEFAULT_SOLVER, QUADRANTS, SAME, SLIDING, Level
from roughsim.scene.sections import SAME_ANGLE, SlidingSection
from roughsim.scene.tables import MAX_ROWS, values_of


def check_junction_growth(scene: Bodies) -> None:
    """Refuse a junction growth of contact that does not yield, or whose friction depends on its temperature."""
    sliding = scene.sliding
    if sliding.junction_growth is None:
        return
    growth = f"sliding.junction_growth = {sliding.junction_growth:g}"
    if all(body.penetration_hardness is None for body in scene.bodies):
        raise ValueError(
            f"{growth} lowers a penetration_hardness, and no body has one; add it or remove the growth"
        )
    if isinstance(sliding.friction_coefficient, tuple):
        raise ValueError(
            f"{growth} goes with one friction_coefficient: with a table over temperature each speed would have a "
            "contact of its own; give a number, or remove the growth"
        )


def check_load(scene: Bodies) -> None:
    """Refuse a nominal pressure above the hardness of the softer body."""
    load, hardness = scene.sliding.nominal_pressure, scene.penetration_hardness
    if load > hardness and scene.sliding.junction_growth is not None:
        raise ValueError(
            f"sliding.nominal_pressure = {load:.6g} Pa exceeds {hardness:.6g} Pa, the penetration_hardness lowered by "
            "junction_growth, which no contact can carry; lower the pressure or remove the growth"
        )
    if load > hardness:
        softer = "body" if scene.body.penetration_hardness == hardness else "counterface"
        raise ValueError(
            f"sliding.nominal_pressure = {load:.6g} Pa exceeds {softer}.penetration_hardness = {hardness:.6g} Pa, "
            "which no contact can carry; lower the pressure or raise the hardness"
        )


def check_heat_partition(scene: Bodies) -> None:
    """Refuse a rule of the heat share without the second body, duration or radius that it needs."""
    rule, missing = scene.sliding.heat_partition, scene.missing_second_body
    if rule in ("mean", "total") and missing:
        raise ValueError(
            f'sliding.heat_partition = "{rule}" shares the heat with a second body, but {missing} is missing; add it '
            '(like = "body" for the same material), or write "all" or a number'
        )
    if rule == "total" and not scene.sliding.warms:
        needed = (
            'needs the time since sliding began; add for example duration = "1 ms", or the contact_radius of a contact '
            "that is steady"
        )
        raise ValueError(f'sliding.heat_partition = "total" {needed}')


def check_nominal_contact(sliding: SlidingSection) -> None:
    """Refuse a track without a round contact, or narrower than the contact itself."""
    track, radius = sliding.track_radius, sliding.contact_radius
    if track is None:
        return
    if radius is None:
        raise ValueError(
            f"sliding.track_radius = {track:.6g} m is of a round contact; add its contact_radius, or remove the track"
        )
    if track < radius:
        raise ValueError(
            f"sliding.track_radius = {track:.6g} m must be at least the contact_radius of {radius:.6g} m, or the contact "
            "turns about a point of its own; raise it"
        )


def check_temperatures(scene: Bodies) -> None:
    """Refuse temperatures of single bodies that no second body or no rule weighs."""
    sliding, missing = scene.sliding, scene.missing_second_body
    kelvin = {
        f"{name}.temperature": body.temperature
        for name, body in scene.sections_of_bodies.items()
        if body.temperature is not None
    }
    if not kelvin:
        return
    first, value = next(iter(kelvin.items()))
    if sliding.background_temperature is not None:
        raise ValueError(
            f"sliding.background_temperature = {sliding.background_temperature:g} K is of both bodies and does not go "
            f"with {first} = {value:g} K; give body.temperature and counterface.temperature alone"
        )
    if missing:
        raise ValueError(
            f"{first} = {value:g} K is of one of two bodies that conduct, but {missing} is missing; give "
            "sliding.background_temperature in its place"
        )
    if "body.temperature" not in kelvin:
        raise ValueError(
            f"{first} = {value:g} K needs the temperature of the other body; add body.temperature"
        )
    difference = kelvin.get("counterface.temperature", value) - value
    if difference:
        _check_difference(scene, difference)


def _check_difference(scene: Bodies, difference: float) -> None:
    """Refuse bodies that differ in temperature, K, where no share follows from it."""
    sliding, tables = scene.sliding, list(scene.tables)
    differ = f"counterface.temperature is {difference:+g} K from body.temperature, which"
    even = "give both bodies one temperature"
    if sliding.heat_partition != "total":
        raise ValueError(
            f'{differ} only sliding.heat_partition = "total" weighs; write it, or {even}'
        )
    if sliding.history == SLIDING:
        raise ValueError(f'{differ} history = "sliding" does not follow; write "frozen", or {even}')
    if tables:
        raise ValueError(
            f"{differ} does not go with a {tables[0]} that is a table over temperature; give a number, or {even}"
        )
    if 0.0 in sliding.speed:
        raise ValueError(
            f"{differ} does not go with sliding.speed = 0 m/s: no heat is made to be shared; remove that speed"
        )


def check_background(scene: Bodies, needed: str) -> None:
    """Refuse a background temperature that is missing, or outside a table κ(T) or μ(T).

    `needed` is a section or key that needs an absolute temperature, "" without one.
    """
    kelvin, tables = scene.background_temperature, list(scene.tables)
    low, high = scene.temperature_range
    if kelvin is None:
        if tables:
            raise ValueError(
                f"sliding.background_temperature is missing; a {tables[0]} that is a table over temperature needs it: "
                'add for example background_temperature = "300 K"'
            )
        if needed:
            raise ValueError(
                f"sliding.background_temperature is missing; {needed} needs an absolute temperature: add for example "
                'background_temperature = "300 K"'
            )
        return
    key = "sliding.background_temperature" if scene.body.temperature is None else "body.temperature"
    background = f"{key} = {kelvin:g} K"
    if not low <= kelvin <= high:
        raise ValueError(
            f"{background} must lie between {low:g} K and {high:g} K, the range of the tables over temperature; "
            "extend them"
        )


def check_history(scene: Bodies, solver: str | None) -> None:
    """Refuse a slide of two bodies that lacks a second body or a distance, and a distance without a slide."""
    sliding, missing = scene.sliding, scene.missing_second_body
    if sliding.history == "frozen":
        if sliding.slid_distance is not None:
            raise ValueError(
                f'sliding.slid_distance = {sliding.slid_distance:.6g} m goes with history = "sliding"; add it, or '
                "remove the distance (numerics.slid_distance is for temperature fields)"
            )
        return
    if missing:
        raise ValueError(
            f'sliding.history = "sliding" follows the heat of two bodies, but {missing} is missing; add it '
            '(like = "body" for the same material), or write "frozen"'
        )
    if (sliding.slid_distance is None) == (sliding.duration is None):
        both = "are both given" if sliding.duration is not None else "are both missing"
        raise ValueError(
            f'sliding.slid_distance and sliding.duration {both}; history = "sliding" needs exactly one, for example '
            'slid_distance = "4 mm"'
        )
    if 0.0 in sliding.speed:
        raise ValueError(
            'sliding.speed = 0 m/s does not go with history = "sliding": nothing slides; remove that speed'
        )
    if solver not in (None, DEFAULT_SOLVER):
        raise ValueError(
            f'numerics.solver = "{solver}" does not go with sliding.history = "sliding", whose contacts begin from '
            f'the last one; write "{DEFAULT_SOLVER}" or history = "frozen"'
        )


def check_targets(ensemble: EnsembleSection, asks: frozenset[str]) -> None:
    """Refuse a target of an observable that the scene does not ask for; `asks` as of the scene."""
    for name, _ in ensemble.until:
        if name not in observables_of(asks):
            asked = OBSERVABLES[name].asked
            what = "picture of a camera" if asked == CAMERA else "distribution of the temperature"
            raise ValueError(f"ensemble.until.{name} is of the {what}; add {ASKED_BY[asked]}")


def check_camera(scene: Faces, camera: CameraSection | None) -> None:
    """Refuse a camera where no heat makes a picture, and of a slide of faces with a lay."""
    sliding, lay = scene.sliding, scene.lay
    if camera is None:
        return
    if lay > 1.0 and sliding.history == SLIDING:
        raise ValueError(
            f'camera does not go with surface.lay = {lay:g} and sliding.history = "sliding", whose pictures are of '
            'isotropic faces; write "frozen", or remove the camera'
        )
    if not any(sliding.speed):
        raise ValueError(
            "camera sees nothing: sliding.speed = 0 m/s makes no heat; give a speed, or remove [camera]"
        )
    if camera.behind is not None and 0.0 in sliding.speed:
        raise ValueError(
            f"camera.behind = {camera.behind:.6g} m does not go with sliding.speed = 0 m/s: a contact at rest has no "
            "trailing edge; remove that speed, or behind"
        )


def check_resolution(scene: Faces, camera: CameraSection | None) -> None:
    """Refuse a camera that blurs more than the longest wave: of what is left a cell shows too little."""
    longest = 2 * math.pi / float(scene.spectrum.breaks[0])
    if camera is not None and camera.resolution > longest:
        raise ValueError(
            f"camera.resolution = {camera.resolution:.6g} m is above the longest wave, 2π/q_min = {longest:.6g} m, of "
            "which the picture then has less than 3 %; look more sharply, or lower q_min"
        )


def check_ends(ensemble: EnsembleSection, given: Mapping[str, object]) -> None:
    """Refuse targets and a largest number, by their names as `given`, beside a number of realizations."""
    name = next((name for name, value in given.items() if value is not None), None)
    if ensemble.realizations is not None and name is not None:
        raise ValueError(
            f"{name} = {given[name]} does not go with ensemble.realizations = {ensemble.realizations}, which fixes the "
            "number of members; leave one of the two out"
        )


def check_rows(scene: Faces) -> None:
    """Refuse tables C(q) of both faces with too many rows."""
    rows = sum(len(face.psd or ()) for face in scene.sections_of_faces.values())
    if rows > MAX_ROWS:
        raise ValueError(
            f"counterface.psd and surface.psd together have {rows} rows, above the limit of {MAX_ROWS}; average C over "
            "bins of log q"
        )


def check_lay(scene: Faces, lengths: tuple[float, float] | None) -> None:
    """Refuse a lay where contact slides, a key has a table, or the sides of a stretched cell, m, are given."""
    faces, sliding, tables = scene.sections_of_rough_faces, scene.sliding, list(scene.tables)
    lays = {f"{name}.lay": face.grooves[0] for name, face in faces.items()}
    key, lay = max(lays.items(), key=lambda item: item[1])
    if lay == 1.0:
        return
    differ = len({face.grooves for face in faces.values()}) > 1
    if sliding.history == SLIDING:
        _check_slide(f"{key} = {lay:g}", next(iter(faces.values())).grooves[1], sliding, differ)
    if tables and differ:
        raise ValueError(
            f"{key} = {lay:g} beside a face of another lay does not go with a {tables[0]} that is a table over "
            "temperature: no law has its temperature in each direction; give a number, or both faces one lay"
        )
    if lengths is not None and scene.lay > 1.0:
        raise ValueError(
            f"numerics.lengths = {lengths[0]:.6g} m does not go with {key} = {lay:g}, which stretches a cell of "
            "equal sides; leave it to the plan"
        )


def _check_slide(lay: str, grooves: float, sliding: SlidingSection, differ: bool) -> None:
    """Refuse a slide of faces with a `lay` but in one direction along or across their common `grooves`, radians."""
    if differ:
        raise ValueError(
            f'{lay} beside a face of another lay does not go with sliding.history = "sliding", which follows faces of '
            'one lay; give both the same, or write "frozen"'
        )
    angles = sliding.direction or ()
    if len(angles) != 1 or abs(math.sin(2 * (angles[0] - grooves))) > 2 * SAME_ANGLE:
        along, across = (math.degrees(grooves + turn) for turn in (0.0, math.pi / 2))
        given = ", ".join(f"{math.degrees(angle):.4g}°" for angle in angles) or "missing"
        raise ValueError(
            f'sliding.direction = {given} does not go with {lay} and history = "sliding", whose steps are whole pixels '
            f'along or across the grooves; write direction = "{along:.4g} deg" or "{across:.4g} deg", or '
            'history = "frozen"'
        )


def check_levels(scene: Faces, levels: Sequence[Level]) -> None:
    """Refuse levels of a column that the scene does not have, and cut-offs outside of the C(q) of its rough faces."""
    faces = scene.faces
    for number, level in enumerate(levels):
        key = f"numerics.levels[{number}]"
        if level.column == QUADRANTS or level.lengths is not None:
            raise ValueError(f"{key} is of a pressed map, whose levels follow from it; remove it")
        if level.column == SLIDING and scene.sliding.history != SLIDING:
            raise ValueError(
                f'{key}.column = "{SLIDING}" needs sliding.history = "{SLIDING}"; add it or remove the level'
            )
        if scene.elastic and level.column not in ("elastic", SLIDING):
            raise ValueError(
                f'{key}.column = "{level.column}" needs a body.penetration_hardness; add it or write "elastic"'
            )
        # of two faces that slide, each needs waves
        first = (max if level.column == SLIDING else min)(face.breaks[0] for face in faces)
        last = max(face.breaks[-1] for face in faces)
        cut_off = f"{key}.q_max = {level.q_max:.6g} rad/m"
        if level.q_max <= first:
            below = " and of all levels below it" if level.column == SLIDING else ""
            raise ValueError(
                f"{cut_off} must be above {first:.6g} rad/m, where C(q) begins; raise it{below}"
            )
        if level.q_max > last * (1 + SAME):
            raise ValueError(
                f"{cut_off} must be at most {last:.6g} rad/m, where C(q) ends; lower it"
            )


def check_derived(scene: Faces) -> None:
    """Refuse numbers whose roughness, modulus, or diffusivity at some temperature overflows or vanishes."""
    try:
        derived = [
            ("rms height", scene.spectrum.rms_height, "m"),
            ("rms slope", scene.rms_slope, ""),
            ("effective modulus", scene.effective_modulus, "Pa"),
        ]
        for body, whose in zip(scene.bodies, ("", " of the counterface"), strict=False):
            for kappa in values_of(body.conductivity):
                diffusivity = kappa / (body.density * body.heat_capacity)
                derived.append((f"diffusivity{whose}", diffusivity, "m²/s"))
    except (ArithmeticError, ValueError) as error:
        raise ValueError(
            f"surface or body: numbers beyond the range of floats ({error}); check them"
        ) from None
    for name, value, unit in derived:
        if not 0.0 < value < math.inf:
            raise ValueError(
                f"surface or body: the {name} becomes {value:.6g} {unit}; check the numbers it is made of"
            )
