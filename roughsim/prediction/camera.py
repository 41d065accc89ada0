"""What the camera of a scene sees, by a stress spectrum of the theory, and its numbers for simulations."""

from contextlib import suppress
from functools import lru_cache
from math import inf, nan, pi, sqrt
from typing import Any

import numpy as np

from roughsim.grid import Array
from roughsim.observables.catalogue import CAMERA, OBSERVABLES
from roughsim.observables.record import Observable, Sample
from roughsim.prediction.bodies import conduction, friction_coefficient, groups, heat_source
from roughsim.prediction.law import calibrated
from roughsim.prediction.shares import heat_arguments
from roughsim.prediction.stress import headings_of_fields, stress_of_lay
from roughsim.scene import Scene
from roughsim.scene.bodies import Layers
from roughsim.scene.numerics import SLIDING
from theory.camera import ERROR_BANDS, View, error_band, seen_rms, seen_width
from theory.yielding import YieldingSpectrum

_MOST_BEYOND = 0.5
FAST = 5.0  # v·behind/D: below, what a camera sees behind the contact is some percent too hot
FORMULAS = {"seen_rms": seen_rms, "seen_width": seen_width}


def slid_distances(scene: Scene) -> tuple[float, ...]:
    """Return how far the contact has slid since the start from rest at each speed, m; ∞ in the steady state."""
    if scene.sliding.history == SLIDING:
        return scene.sliding.distances
    duration = scene.sliding.duration
    return tuple(inf if duration is None else speed * duration for speed in scene.speeds)


def views(scene: Scene) -> list[View]:
    """Return what the camera of a scene looks at, and how sharply, at each speed."""
    camera, radius = scene.camera, scene.sliding.contact_radius
    if camera is None:
        raise ValueError("the scene has no [camera]")
    length = inf if radius is None else 2.0 * radius
    return [
        View(
            camera.resolution,
            camera.smear(speed),
            slid or inf,  # at rest all is steady
            camera.behind,
            length,
        )
        for speed, slid in zip(scene.speeds, slid_distances(scene), strict=True)
    ]


def seen_in(scene: Scene, name: str, stress: dict[str, Any]) -> Array:
    """Return an observable of the picture over the speed, (speeds,), with all heat in the body; NaN where unknown.

    `stress` has the arguments of `theory.camera.seen_rms` on the stress. The start from rest of a body with a skin, and
    faces of two lays or scans with one, are not known.
    """
    result = np.full(len(scene.speeds), nan)
    directed = scene.headings is not None
    if scene.camera is None or name not in FORMULAS or (directed and scene.lay == 1.0):
        return result
    if directed:
        load = {"nominal_pressure": scene.sliding.nominal_pressure}
        spectra = (stress.get(kind) for kind in ("spectrum", "stress_spectrum"))
        stress = load | {"stress": stress_of_lay(scene, *spectra)}
    headings = scene.headings or (0.0,) * len(scene.speeds)
    looks, speeds = views(scene), np.array(scene.speeds)
    for indices, constants in groups(scene, speeds):
        heat = heat_arguments(*constants)
        layered = constants.bodies.layers != Layers()
        for k in np.arange(speeds.size)[indices].tolist():
            if layered and (looks[k].slid_distance < inf or looks[k].behind is not None):
                continue
            with suppress(ValueError):  # an even picture has no width
                towards = {"view": looks[k], "direction": headings[k]}
                result[k] = FORMULAS[name](scene.speeds[k], **towards, **stress, **heat)
    return result


def error_of_law(scene: Scene, name: str) -> Array | None:
    """Return the relative error of an observable of the picture by the law, (speeds,); None where none is known.

    NaN on a line so close behind a slow contact that heat goes along sliding.
    """
    if scene.camera is None or name not in ERROR_BANDS:
        return None
    band = np.full(len(scene.speeds), error_band(name, scene.lay))
    if scene.camera.behind is not None:
        near = np.array(scene.speeds) * scene.camera.behind
        band[near < FAST * conduction(scene).diffusivity] = nan
    return band


def camera_of(scene: Scene) -> Any:
    """Return the `roughsim.observables.camera.Camera` of a scene; None without one."""
    if scene.camera is None:
        return None
    from roughsim.heat.camera import Lens  # loads the transforms
    from roughsim.heat.periodic import MovingSource, unit_vector
    from roughsim.observables.camera import Camera

    source, sources = heat_source(scene), []
    bodies, friction = conduction(scene), friction_coefficient(scene)
    headings = scene.headings or (0.0,) * len(source.speeds)
    for view, rate, layers, angle in zip(
        views(scene), source.rates, source.layers, headings, strict=True
    ):
        lens = Lens(
            view.resolution,
            view.smear,
            view.behind,
            min(view.contact_length, view.slid_distance),
        )
        spread = view.slid_distance / rate  # D t
        ahead, aside = unit_vector(angle)
        drift = rate * ahead, rate * aside
        sources.append(MovingSource(drift, spread, layers=layers, lens=lens))
    heating = friction * np.array(source.speeds) / bodies.conductivity
    return Camera(
        tuple(sources),
        tuple(heating.tolist()),
        headings_of_fields(scene),
        scene.numerics.slid_distance,
        directed=scene.headings is not None,
    )


def of_level(scene: Scene, record: Observable, sample: Sample) -> Array:
    """Return the influence values of an observable at a level, with the camera of the scene where it needs one.

    NaN of a picture that the camera blurs over more than the cell.
    """
    if record.asked != CAMERA or scene.camera is None:
        return record.of_level(sample)
    if scene.camera.resolution > side_of(2.0 * sample.reach, scene.lay):
        return np.full((len(sample.spectrum), len(scene.speeds)), nan)
    if record.stored:
        return record.of_level(sample)
    from roughsim.observables import camera

    formula = camera.seen_rms if record.name == "seen_rms" else camera.seen_width
    return sample.kept(record.name, lambda one: formula(one, camera_of(scene)))


def side_of(diagonal: float, lay: float = 1.0) -> float:
    """Return the side of a cell with this diagonal, m; of one that is longer than wide the root mean square.

    Of one that a lay stretches it is the shorter side.
    """
    return diagonal / sqrt(1.0 + lay**2)


def seen_by(scene: Scene, name: str, q: Array, stress: Array, reach: float) -> Array:
    """Return an observable of the picture of a stress spectrum on modes, as a level with this one member has it."""
    if scene.camera is None or name not in FORMULAS or scene.headings is not None:
        return np.full(len(scene.speeds), nan)
    sample = Sample(inf, 0.0, np.zeros(1, np.intp), {}, q, stress[None], reach)
    row: Array = of_level(scene, OBSERVABLES[name], sample)[0]
    return row


class _Shorter:
    """A stress spectrum without waves longer than a cell."""

    def __init__(self, whole: YieldingSpectrum, start: float):
        self._whole = whole
        self.own_share, self.compliance = whole.own_share, whole.compliance
        self.breaks = (start, *(kink for kink in whole.breaks if kink > start))

    def __call__(self, q: Array) -> Array:
        values: Array = self._whole(q)
        return values


@lru_cache(maxsize=64)  # .1 s at each speed, for each observable in each round
def beyond_cell(scene: Scene, side: float) -> Array:
    """Return the share of the rms of the picture by waves longer than the side of a cell, m, (speeds,), by the law.

    NaN where no law holds, and above a half, where the picture is not of the cell.
    """
    law = calibrated(scene).stress_spectrum
    if law is None:
        return np.full(len(scene.speeds), nan)
    load = {"nominal_pressure": scene.sliding.nominal_pressure}
    whole = seen_in(scene, "seen_rms", {"stress_spectrum": law, **load})
    start = max(2 * pi / side, law.breaks[0])
    within = seen_in(scene, "seen_rms", {"stress_spectrum": _Shorter(law, start), **load})
    with np.errstate(all="ignore"):  # 0/0 at rest
        share = np.where(whole > 0.0, 1.0 - within / whole, 0.0 * whole)
    share[share > _MOST_BEYOND] = nan
    return share
