"""Assumptions of a scene without a number of their own: the rough body, the texture, and the path of the heat.

Each statement is made here once; `plan`, `theory`, `compare` and the report print the same ones.
"""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from math import degrees
from typing import NamedTuple

import numpy as np

from roughsim.grid import Array
from roughsim.prediction.bodies import contact_temperatures, turned
from roughsim.prediction.first_micrometre import effects
from roughsim.prediction.theories import predictions
from roughsim.scene import Scene
from roughsim.scene.numerics import SLIDING
from roughsim.show.remarks import Remark

UNEVEN = 0.02  # distance of the heat share from 1/2
NO_VALUE = ValueError, ArithmeticError, RuntimeError  # of a theory without a value
_LIKE = 2.0  # ratio of the rms heights of two faces that count as equally rough


class ByMean(NamedTuple):
    """T_flash with all the heat in the moving body, K, and the share and T_flash by the rule "mean", over speeds."""

    source: str  # theory, or a column
    all_heat: Array
    share: Array
    flash: Array


def statements(scene: Scene) -> list[Remark]:
    """Return the assumptions of a scene, in printed order."""
    result = [
        *_of_roughness(scene),
        *_of_scans(scene),
        *_of_textures(scene),
        *_of_heat(scene),
        *_of_nominal_contact(scene),
        *_of_tables(scene),
    ]
    with suppress(*NO_VALUE):  # refused where it is needed
        result += effects(scene)
    return result


def _of_roughness(scene: Scene) -> Iterator[Remark]:
    """Yield the body that carries the roughness."""
    slides, two = scene.sliding.history == SLIDING, len(scene.faces) == 2
    if slides and two:
        value = "on both faces"
        because = (
            "in the column sliding [surface] moves with [body] and [counterface] rests; in the others all roughness "
            "rests on the counterface"
        )
    else:
        value = "of both faces, on the resting face" if two else "on the resting face"
        of_what = 'with history = "frozen" the contact' if two else "a lone rough face"
        because = f"{of_what} rests on the counterface: its hot spots slide over [body]"
    yield Remark("assumption", "roughness", because, value)
    because = (
        "C(q) is stretched so along the grooves, which widens and narrows hot spots by its root"
    )
    for name, face in scene.sections_of_rough_faces.items():
        lay, angle = face.grooves
        if lay > 1.0 and (scene.lays_differ or name == "surface"):
            of_face = f"lay of [{name}]" if scene.lays_differ else "lay"
            yield Remark(
                "assumption", of_face, because, f"{lay:g}, at {degrees(angle):.4g}° from x"
            )


def _of_scans(scene: Scene) -> Iterator[Remark]:
    """Yield what was read of the files of each face: channel and units."""
    for name, face in scene.sections_of_faces.items():
        for scan in face.psd_scans or ():
            yield Remark("assumption", f"scan of [{name}]", "C(q) is measured on it", scan)


def _of_textures(scene: Scene) -> Iterator[Remark]:
    """Yield for each map that C(q) was measured on its lay, and the distribution of its heights."""
    for face, maps in scene.textures.items():
        for number, texture in enumerate(maps, start=1):
            of_face = f" of [{face}]" * (len(scene.textures) > 1)
            of = f" of map {number}" * (len(maps) > 1) + of_face
            drawn = "of the map; drawn surfaces are isotropic"
            if (
                scene.directed_angle is not None
                and scene.sections_of_faces[face].directed is not None
            ):
                drawn = (
                    "of the map, whose directions drawn surfaces have, but not its shape: `roughsim press` gives the "
                    "ratio of both"
                )
            yield Remark("assumption", f"texture{of}", drawn, texture.waves())
            gaussian = f"Gaussian 0 and 3; {texture.extremes()}"
            yield Remark("assumption", f"heights{of}", gaussian, texture.heights())


def _of_heat(scene: Scene) -> Iterator[Remark]:
    """Yield the body that takes the heat of the temperatures."""
    rule = scene.sliding.heat_partition
    if rule == "all" and not scene.counterface_conducts:
        value, because = "all into the moving body", "there is no second body that takes heat"
    elif rule == "all":
        value, because = "all into the moving body", 'heat_partition is "all", the default'
    elif isinstance(rule, str):
        equal = "T_flash" if rule == "mean" else "T₀ + T_flash"
        value, because = (
            f'by the rule "{rule}"',
            f"the share of each speed makes {equal} of the two bodies equal",
        )
        because += " in each column, theory and calibrated too"
    else:
        value, because = f"{rule:.4g} into the moving body", "heat_partition states it"
        if abs(rule - 0.5) > UNEVEN and equal_faces(scene):
            about = (
                "about " if scene.tables else ""
            )  # a table over temperature has another value at another share
            because += f"; equal faces share evenly: 0.5 makes temperatures {about}{0.5 / rule:.3g} times as high"
    if scene.sliding.history == SLIDING:
        because += "; the column sliding has its own share"
    yield Remark("assumption", "heat", because, value)


def _of_nominal_contact(scene: Scene) -> Iterator[Remark]:
    """Yield the round contact that warms both bodies, and where it does not count."""
    sliding = scene.sliding
    if sliding.contact_radius is None:
        return
    track = sliding.track_radius
    way = "straight" if track is None else f"round a track of radius {1e3 * track:.4g} mm"
    when = "steady" if sliding.duration is None else f"after {sliding.duration:.4g} s"
    because = f"the counterface carries it, [body] slides under it {way}; T₀ {when}, mean over the contact"
    if sliding.history == SLIDING:
        because += "; the column sliding warms endless planes"
    value = f"round, of radius {1e3 * sliding.contact_radius:.4g} mm"
    yield Remark("assumption", "nominal contact", because, value)


def equal_faces(scene: Scene) -> bool:
    """Return whether both faces conduct alike and are about equally rough, so that each takes half of the heat."""
    if len(scene.faces) < 2 or not scene.counterface_conducts:
        return False
    moving, resting = (
        (body.conductivity, body.density * body.heat_capacity) for body in scene.bodies
    )
    first, second = (face.rms_height for face in scene.faces)
    return moving == resting and 1 / _LIKE <= first / second <= _LIKE


def _of_tables(scene: Scene) -> Iterator[Remark]:
    """Yield the temperature of the contact for each speed with several solutions of the heat balance."""
    for case in scene.cases if scene.tables else ():
        speed, found = case["speed"], list[str]()
        with suppress(*NO_VALUE):  # refused where it is needed
            there = turned(scene, case["direction"]) if "direction" in case else scene
            found = [f"{kelvin:.4g}" for kelvin in contact_temperatures(there, speed)]
        if len(found) > 1:
            others = " and ".join(found[1:])
            because = f"{others} K solve the balance with these tables, too; a cold contact reaches the coldest first"
            value = f"{found[0]} K, the coldest of {len(found)}"
            way = f" and {degrees(case['direction']):.4g}°" if "direction" in case else ""
            yield Remark("assumption", f"contact at {speed:g} m/s{way}", because, value)


def cautions(
    scene: Scene, *, drawn: bool = True, measured: ByMean | None = None
) -> Iterator[Remark]:
    """Yield a warning for each assumption that is easily missed, or that a map does not fulfil.

    `drawn` is False where the map itself is pressed: then its texture and the direction of sliding count. `measured`
    stands for the theory of the share.
    """
    if drawn:
        yield from texture_warnings(scene)
    if drawn and scene.sliding.direction is not None and not scene.directions:
        angles = ", ".join(f"{degrees(angle):.4g}°" for angle in scene.sliding.direction)
        yield Remark(
            "caution",
            "sliding.direction",
            f"sliding.direction = {angles} changes nothing in the theory and on drawn "
            "surfaces, which are isotropic; `roughsim press` gives T_flash in this direction",
        )
    yield from _caution_of_heat(scene, measured)


def texture_warnings(scene: Scene) -> Iterator[Remark]:
    """Yield a warning for each difference between surfaces drawn from C(q) and the map that it was measured on."""
    for face, maps in scene.textures.items():
        drawn = (
            scene.directed_angle is not None and scene.sections_of_faces[face].directed is not None
        )
        lines = (line for texture in maps for line in texture.warnings(face, drawn=drawn))
        yield from dict.fromkeys(lines)


def takes_all(scene: Scene) -> bool:
    """Return whether all the heat is in the moving body although the counterface takes heat, too."""
    return scene.counterface_conducts and scene.sliding.heat_partition == "all"


def _caution_of_heat(scene: Scene, measured: ByMean | None) -> Iterator[Remark]:
    """Yield a warning of all the heat in one body where the other takes heat, too, and what "mean" makes of it."""
    if not takes_all(scene):
        return
    found = measured or _by_mean(scene)
    mean = ""
    if found is not None:
        k = int(np.argmax(found.all_heat))
        mean = (
            f': by "mean" the share is {found.share[k]:.3g} and T_flash {found.flash[k]:.4g} K in {found.source} at '
            f"{scene.speeds[k]:g} m/s, not {found.all_heat[k]:.4g} K"
        )
    even = "0.5 between equal faces, " if equal_faces(scene) else ""
    lone = "; if the rough face is the moving one, exchange [body] and [counterface]"
    yield Remark(
        "caution",
        "sliding.heat_partition",
        f'sliding.heat_partition is "all", the default, but the counterface takes heat, too{mean}; write "mean", or a '
        f"number ({even}1 for all){lone if len(scene.faces) == 1 else ''}; see docs/partition.md",
    )


def _by_mean(scene: Scene) -> ByMean | None:
    """Return what the rule "mean" makes of the theory; None where it has no value."""
    shared = replace(scene, sliding=replace(scene.sliding, heat_partition="mean"))
    try:
        flash, by_mean = predictions(scene)["flash_temperature"], predictions(shared)
        share = by_mean["heat_partition"]
        # tables over temperature have other values with another share
        return ByMean("theory", flash, share, share * by_mean["flash_temperature"])
    except NO_VALUE:
        return None
