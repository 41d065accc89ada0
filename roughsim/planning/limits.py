"""Derived quantities of a scene, and a warning for each number outside the range of the model.

A warning has the value, the limit, and advice. The list of docs/limits.md has the same limits.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from math import hypot, inf, isfinite, isnan, pi, prod, sqrt
from typing import Any

import numpy as np

from roughsim import prediction
from roughsim.grid import Grid
from roughsim.planning.levels import SIDE, cell_of
from roughsim.prediction.bodies import conduction
from roughsim.prediction.camera import FAST, side_of
from roughsim.prediction.facts import YIELDED, Facts, facts_of, gentle_end
from roughsim.prediction.scans import scan_of_hottest, unknown_by
from roughsim.prediction.statements import (
    NO_VALUE,
    UNEVEN,
    ByMean,
    cautions,
    equal_faces,
    statements,
)
from roughsim.scene import Scene
from roughsim.scene.numerics import Numerics
from roughsim.scene.slips import STEEP, steepness
from roughsim.show.remarks import Remark, most_serious_first
from roughsim.show.table import Column, Table

Remarks = Iterator[Remark]
_YIELDS = (
    1 / 3
)  # of the hardness, about the yield stress: above it bodies yield beneath their whole face
_STRAIN = 0.1  # pressure over E*: linear elasticity
_STIFF = 1e9  # Pa, E*: stiffer solids than rubber yield before such a strain
_COMPLETE = 0.9  # contact area over nominal area: such faces adhere
_LEAST_PIXELS = 16.0  # of contact in a cell
_HOTTEST = 4200.0  # K: no material is solid above it
_FREE_PATH = (
    10e-9  # m, free path of electrons and phonons: Fourier's law holds for longer distances
)
_SLOWLY = 0.85  # exponent of T_flash over q_max: H = 0.52
# of endless planes, for 5 %: contact radius over slid distance, and over the depth of heat (experiments/finite_contact)
_SLID, _DEEP = 5.0, 12.0
_THICK = 0.1  # of the side of the cell: thicker layers are bodies of their own


@dataclass(frozen=True)
class Plausibility:
    """A scene with its sizes, None if its theory has no value, and its warnings."""

    scene: Scene
    facts: Facts | None
    remarks: list[Remark]  # the most serious first
    of_run: tuple[Remark, ...] = ()  # statements that a run adds

    @property
    def warnings(self) -> list[str]:
        """The warnings in words, the most serious first."""
        return list(map(str, self.remarks))

    @cached_property  # .02 s, which a run does without
    def statements(self) -> list[Remark]:
        """Its assumptions."""
        return [*statements(self.scene), *self.of_run]

    @property
    def sizes(self) -> list[Remark]:
        """Sizes and assumptions."""
        return [*(self.facts.rows() if self.facts else []), *self.statements]

    def table(self) -> Table:
        """Return sizes and assumptions for people: name, value, and meaning or reason."""
        rows = [remark.row for remark in self.sizes]
        return Table([Column("", name=True), Column("", name=True), Column("")], rows)

    def to_dict(self) -> dict[str, Any]:
        """Return "scene_facts", "scene_statements" and "scene_warnings" as JSON values, and the lay if there is one."""
        names, rows = ("name", "value", "because"), (one.row for one in self.statements)
        grooves = dict(zip(("lay", "lay_direction"), self.scene.grooves, strict=True))
        known = self.scene.directions and not self.scene.lays_differ
        return (grooves if known else {}) | {
            "scene_facts": self.facts and self.facts.to_dict(),
            "scene_statements": [dict(zip(names, row, strict=True)) for row in rows],
            "scene_warnings": self.warnings,
        }


def judge(
    scene: Scene,
    numerics: Numerics | None = None,
    *,
    drawn: bool = True,
    measured: ByMean | None = None,
) -> Plausibility:
    """Return the sizes of a scene, and a warning for each number beyond the model and each easily missed assumption.

    Contact is counted in the cell and in pixels of the finest grid of `numerics`. Without them it is the cell of the
    plan, and the finest grid of the scene's own levels or the largest one of a plan. Where the map itself is pressed in
    place of `drawn` surfaces, the error of C(q) is in no number. `measured` stands for the theory of the share.
    """
    scanned = _scan_remarks(scene) if drawn else ()
    plain = [*scene.slips, *scanned, *cautions(scene, drawn=drawn, measured=measured)]
    try:
        cell = numerics.lengths if numerics else cell_of(prediction.computed(scene))[0]
        known = facts_of(scene, Grid((1, 1), cell).stretched(scene.lay).lengths)
    except NO_VALUE as error:
        text = f"the theory of this scene cannot be evaluated ({error}); contact area and temperature are not checked"
        unknown = Remark("no theory", "theory", " ".join(text.split()))
        remarks = [*steepness(scene.rms_slope), *plain, unknown]
        return Plausibility(scene, None, most_serious_first(remarks))
    remarks = [
        *_slope_remarks(scene, known.rms_slope_before_yield),
        *plain,
        *_load_remarks(scene, known, numerics),
        *_heat_remarks(scene, known),
        *_nominal_contact_remarks(scene, known),
        *_camera_remarks(scene, side_of(hypot(*known.cell), scene.lay)),
        *_layer_remarks(scene, min(known.cell)),
        *_share_remarks(scene, known),
    ]
    return Plausibility(scene, known, most_serious_first(remarks))


def _slope_remarks(scene: Scene, before_yield: float) -> Remarks:
    """Warn of steep slopes; `before_yield` is the rms slope of the waves up to 32 q_y."""
    slope = scene.rms_slope
    if slope <= STEEP:
        return
    end = gentle_end(scene)
    if (
        before_yield <= STEEP
    ):  # at 32 q_y T_flash is 10 to 40 % above its limit with H = 0.3, 2 to 9 % with 0.55
        rough = prediction.usual_exponent(scene, end) < _SLOWLY
        changes = (
            "makes T_flash higher: with so small an H it falls slowly"
            if rough
            else "changes little"
        )
        advice = (
            f"up to {YIELDED:g} q_y it is {before_yield:.3g}, and shorter waves touch at the hardness alone; check the "
            f"units of the roughness, or {_without_waves(scene, end)}, which {changes}"
        )
    else:
        until = (
            f", or {_without_waves(scene, end)}, up to which it is less" if isfinite(end) else ""
        )
        advice = f"check the units of the roughness{until}"
    yield from steepness(slope, advice)


def _without_waves(scene: Scene, q: float) -> str:
    """Return how to leave out the waves above a wavenumber, rad/m."""
    if scene.scanned:
        return f"smooth waves shorter than {2e6 * pi / q:.3g} µm out of the scan: q above {q:.3g} rad/m"
    if any(face.psd for face in scene.sections_of_faces.values()):
        return f"end the table of C(q) at {q:.3g} rad/m"
    return f"lower q_max to {q:.3g} rad/m"


def _scan_remarks(scene: Scene) -> Remarks:
    """Warn of a C(q) from scans whose own error is unknown or large."""
    scan, target = scan_of_hottest(scene), scene.ensemble.ends.get("flash_temperature", inf)
    if scan is not None and isnan(scan):
        text = f"C(q) was measured on a scan, and its error is unknown: {unknown_by(scene)}"
        yield Remark("caution", "error of the scan", text)
    elif scan is not None and scan > target:
        yield Remark(
            "caution",
            "size of the scan",
            f"C(q) was measured on a scan, which by itself leaves {100 * scan:.2g} % of error in the highest T_flash, "
            f"above the target of {100 * target:g} %; take a larger scan, or more of them",
        )


def _load_remarks(scene: Scene, known: Facts, numerics: Numerics | None) -> Remarks:
    """Warn of a nominal pressure or contact area that is too large or too small."""
    pressure = f"sliding.nominal_pressure = {scene.sliding.nominal_pressure:.3g} Pa"
    if known.pressure_over_hardness > _YIELDS:
        yield Remark(
            "limit",
            "pressure over hardness",
            f"{pressure} is {known.pressure_over_hardness:.2g} of the hardness, above {_YIELDS:.2g}: bodies yield "
            "beneath their whole face, but in the model only at the contact; check the units of both",
        )
    if known.pressure_over_modulus > _STRAIN:
        yield Remark(
            "limit",
            "pressure over modulus",
            f"{pressure} is {known.pressure_over_modulus:.2g} of E* = {scene.effective_modulus:.3g} Pa, above "
            f"{_STRAIN:g}, and the model is for small strains; check the units of pressure and youngs_modulus",
        )
    strain = known.contact_pressure / scene.effective_modulus
    if scene.elastic and strain > _STRAIN and scene.effective_modulus > _STIFF:
        yield Remark(
            "limit",
            "contact pressure over modulus",
            f"the mean contact pressure, {known.contact_pressure:.3g} Pa, is {strain:.2g} of E*, above {_STRAIN:g}, "
            "and stiff solids yield before that; give a penetration_hardness, or check the units of roughness and "
            "pressure",
        )
    levels = numerics.levels if numerics else scene.numerics.levels or ()
    (x, y) = max((level.shape for level in levels), key=prod, default=(SIDE, SIDE))
    grid = "the finest grid" + " of a plan" * (not levels)
    pixels = known.contact_fraction * (x * y)
    contact = f"{pressure} makes contact on {known.contact_fraction:.2g} of the area"
    if pixels < _LEAST_PIXELS:
        text = f"{contact}, {pixels:.2g} pixels of {grid}, {x} × {y}, below {_LEAST_PIXELS:g}; check its unit"
        yield Remark("limit", "pixels of contact", text)
    elif known.hot_spots < 1.0:
        yield Remark(
            "limit",
            "hot spots",
            f"{contact}, {known.hot_spots:.2g} of one hot spot of the theory in a cell of {1e3 * known.cell[0]:.3g} "
            "mm; check its unit, or raise numerics.lengths",
        )
    if known.contact_fraction > _COMPLETE:
        yield Remark(
            "limit",
            "contact area",
            f"contact on {known.contact_fraction:.3g} of the area in theory is above {_COMPLETE:g}: such faces adhere, "
            "but not in the model; check the units of roughness, pressure and youngs_modulus",
        )


def _heat_remarks(scene: Scene, known: Facts) -> Remarks:
    """Warn of contact that melts, and of heat that is not diffusive."""
    rise = known.flash_temperature + known.warming
    k = int(np.argmax(rise))
    hottest = known.background_temperature + float(rise[k])
    article = "a" if scene.background_temperature else "an assumed"
    warmed = f" and T₀ = {known.warming[k]:.4g} K" if known.warming[k] else ""
    reached = (
        f"T_flash = {known.flash_temperature[k]:.4g} K{warmed} at {scene.speeds[k]:g} m/s in theory, over {article} "
        f"background of {known.background_temperature:g} K, makes {hottest:.4g} K"
    )
    if hottest > known.melting_temperature:
        yield Remark(
            "limit",
            "melting temperature",
            f"{reached}, above the melting_temperature of {known.melting_temperature:g} K: in the model bodies stay "
            "solid; check the units of heat, load and roughness, or lower the speed",
        )
    elif hottest > _HOTTEST:
        units = "check the units of heat, load and roughness"
        text = f"{reached}, above {_HOTTEST:g} K: no material is solid there; {units}"
        yield Remark("limit", "hottest contact", text)
    fastest = float(known.peclet_number.max())
    if fastest > 1.0 and (depth := known.hot_spot_radius * sqrt(2.0 / fastest)) < _FREE_PATH:
        yield Remark(
            "limit",
            "Péclet number",
            f"at the Péclet number vr/D = {fastest:.3g} the heat of a hot spot goes {depth:.2g} m deep, less than "
            f"{_FREE_PATH:g} m, the free path of electrons and phonons; check the units of speed and conductivity",
        )


def _camera_remarks(scene: Scene, side: float) -> Remarks:
    """Warn of a blur over all of the cell, and of a line so close behind slow contact that heat goes along sliding."""
    if scene.camera is None:
        return
    blur, behind = scene.camera.resolution, scene.camera.behind
    if blur > side:
        yield Remark(
            "limit",
            "camera resolution",
            f"camera.resolution = {blur:.3g} m is above the side of the cell, {side:.3g} m: the waves that are seen are "
            "missing, and seen_rms, seen_99, seen_width are unknown; look more sharply, or raise numerics.lengths",
        )
    moving = [
        (speed * behind / diffusivity, speed)
        for speed, diffusivity in zip(scene.speeds, conduction(scene).diffusivity, strict=True)
        if behind is not None
    ]
    if moving and min(moving)[0] < FAST:
        number, speed = min(moving)
        yield Remark(
            "limit",
            "camera behind",
            f"camera.behind = {behind:.3g} m is v·behind/D = {number:.3g} at {speed:g} m/s, below {FAST:g}: heat that "
            "goes along sliding is left out, which makes the picture 3 % too hot at 2.6 and 7 % at 0.5; look further "
            "behind, or slide faster",
        )


def _nominal_contact_remarks(scene: Scene, known: Facts) -> Remarks:
    """Warn of endless planes that get hot, of a small contact, and of a share beyond all or nothing of the heat."""
    radius, duration = scene.sliding.contact_radius, scene.sliding.duration
    if radius is not None and radius < known.longest_wave:
        yield Remark(
            "limit",
            "contact radius",
            f"sliding.contact_radius = {radius:.3g} m is below the longest wave, 2π/q_min = {known.longest_wave:.3g} m: "
            "such a contact holds no mean of the roughness; raise the radius or q_min",
        )
    k = int(np.argmax(known.warming - known.flash_temperature))
    warm, flash = float(known.warming[k]), float(known.flash_temperature[k])
    if radius is None and duration is not None and warm > flash:
        speed, diffusivity = scene.speeds[k], float(conduction(scene).diffusivity[k])
        slid, deep = _SLID * speed * duration, _DEEP * sqrt(diffusivity * duration)
        yield Remark(
            "limit",
            "endless planes",
            f"T₀ = {warm:.4g} K at {speed:g} m/s in theory is above T_flash = {flash:.4g} K, and is of endless planes; "
            f"right within 5 % only for a contact of radius above {_SLID:g} v·duration = {slid:.2g} m and {_DEEP:g} "
            f"√(D·duration) = {deep:.2g} m: add its sliding.contact_radius",
        )
    share = known.heat_partition
    beyond = (share < 0.0) | (share > 1.0)
    if beyond.any():
        k = int(np.argmax(np.abs(share - 0.5)))
        yield Remark(
            "limit",
            "share of the heat",
            f"the heat share {share[k]:.3g} at {scene.speeds[k]:g} m/s is not within 0 and 1: the "
            f"{'hotter' if share[k] > 1.0 else 'colder'} counterface {'heats' if share[k] > 1.0 else 'cools'} [body] "
            "by more than friction does",
        )


def _layer_remarks(scene: Scene, side: float) -> Remarks:
    """Warn of layers as thick as the roughness is long; `side` is the shorter one of the cell, m."""
    effects = {
        "skin.thickness": "so thick a layer changes the elastic contact, too, which the model leaves out",
        "heat_depth": "so deep the heat of different contact spots is not apart",
    }
    for name, body in scene.sections_of_bodies.items():
        skin = body.skin
        depths = {"skin.thickness": skin and skin.thickness, "heat_depth": body.heat_depth}
        for key, depth in depths.items():
            if depth and depth > _THICK * side:
                yield Remark(
                    "limit",
                    f"{name}.{key}",
                    f"{name}.{key} = {depth:.3g} m is above {_THICK:g} of the cell of {side:.3g} m: {effects[key]}; "
                    "check its unit",
                )


def _share_remarks(scene: Scene, known: Facts) -> Remarks:
    """Warn of a heat share by "mean" or "total" other than 1/2 between equal faces; other shares are stated."""
    k = int(np.argmax(scene.speeds))
    share = float(known.heat_partition[k])
    by_rule = scene.sliding.heat_partition in ("mean", "total") and not scene.temperature_difference
    if not by_rule or abs(share - 0.5) <= UNEVEN or not equal_faces(scene):
        return
    # a table over temperature has another value at another share
    about = "about " if scene.tables else ""
    advice = f"heat_partition = 0.5 makes temperatures {about}{0.5 / share:.3g} times as high"
    if scene.sliding.contact_radius is not None:  # a round contact is not even by itself
        advice = "hot spots rest on neither, so that T_flash is an upper bound"
    yield Remark(
        "caution",
        "heat share",
        f"the heat share {share:.3g} at {scene.speeds[k]:g} m/s is not even, but the faces are; {advice}; "
        "see docs/partition.md",
    )
