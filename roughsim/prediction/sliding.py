"""Two rough bodies that slide over one another, by the theory: the column calibrated beside the column sliding."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import nan
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial.legendre import leggauss

import theory
from roughsim.grid import Array
from roughsim.prediction.bodies import Heating, conduction, groups
from roughsim.prediction.law import calibrated
from roughsim.prediction.shares import heat_arguments, resting_arguments
from roughsim.prediction.stress import law_arguments
from roughsim.scene import Scene
from theory.arguments import density

_ERROR = 0.06  # of T_flash, 95 %, of both bodies of 62 pairs from A = .06 to .95, κ up to 1:25 (docs/sliding.md)
# of a number over that at another slid distance, 95 %: of 16 mm over 1, 2 and 4 mm, at seven pairs of steels with four
# speeds each, T_flash errs by at most 2.7 %, rms 0.9 %; of 16 drawn pairs by 2.3 %, rms 1.1 %, the share by 2.1 %
CONTINUED = 0.025
FURTHEST = 16.0  # whole slid distance over the followed one: further was not compared
# κ of the resting over that of the moving body. Elastic contact of a flat moving face, from one length of the cell to
# eight: T_flash errs by up to 0.9, 1.8, 4.3 % at 3, 10 and 100, the share by 2.2, 3.3, 5.2 %; to sixteen the share
# by 1.9 % at 1.4 and 3.2 % at 3. Of two faces equally rough the share errs by 3.6 % at 100. As in
# tests/sliding/test_slides_continued.py
_CONTRAST = 2.0
# part of C(q) on the moving face: at 0.92 T_flash and share err by 2 % (pair E44, experiments/sliding_distance.py); on
# a flat resting face at 30 m/s, by 2 % after eight lengths of the cell, and T_flash by 3.1 … 3.5 % after sixteen
_MOVING_PART = 0.95
_LEAST_OF_CELL = 0.5  # followed at least: from a quarter the share errs by up to 2.9 %
_LATE = 0.5  # share of the slid distance, at its end, over which the means of the column sliding are taken
_POINTS = 3  # of Gauss in that share: T grows as a root of the distance at most


@dataclass(frozen=True, slots=True)
class SlidingPrediction:
    """The theory of two bodies that slide, in a scene, at each of its speeds; arrays (speeds,).

    Attributes
    ----------
    slid_distance : ndarray
        m.
    flash_temperature, heat_partition : ndarray
        T_flash of the moving body, K, and its share of the heat: means over the last half of the distance.
    contact_temperature : ndarray
        Background of the moving body at the end of the distance, and that T_flash, K.
    """

    slid_distance: Array
    flash_temperature: Array
    heat_partition: Array
    contact_temperature: Array


class SlidingContinuation(NamedTuple):
    """Factors from the distance that slides are followed to the whole slid distance, and their error; (speeds,)."""

    flash_temperature: Array
    heat_partition: Array
    background: Array
    error: Array  # 95 %, relative, of each factor; 0 at the whole distance


_SAME = np.ones(1)
WHOLE = SlidingContinuation(
    _SAME, _SAME, _SAME, np.zeros(1)
)  # slides that are followed to their end


@lru_cache(maxsize=16)  # .1 s to .5 s, for each observable of the column sliding
def sliding_continuation(scene: Scene, followed: float | None) -> SlidingContinuation:
    """Return how the theory continues slides that are followed over a distance, m; None: over all.

    ValueError if slides end sooner where the theory does not hold.
    """
    distances = np.array(scene.sliding.distances)
    if followed is None or followed >= distances.max():
        return WHOLE
    whole, part = (
        sliding_prediction(scene),
        sliding_prediction(scene, np.minimum(distances, followed)),
    )
    if whole is None or part is None:
        raise ValueError(_refusal(scene, followed, continuation_fault(scene)))
    flash, share = (
        getattr(whole, name) / getattr(part, name)
        for name in ("flash_temperature", "heat_partition")
    )
    warmed, before = (
        found.contact_temperature - found.flash_temperature for found in (whole, part)
    )
    return SlidingContinuation(
        flash, share, warmed / before, np.where(distances > followed, CONTINUED, 0.0)
    )


def check_continuation(scene: Scene, followed: float | None, length: float) -> None:
    """Refuse, by a ValueError, a distance that slides are followed, m, from which the theory cannot continue them.

    `length` is the side of their cell along the slide, m.
    """
    whole = max(scene.sliding.distances)
    if followed is None or followed >= whole:
        return
    if fault := continuation_fault(scene):
        raise ValueError(_refusal(scene, followed, fault))
    least = max(whole / FURTHEST, _LEAST_OF_CELL * length)
    if followed < least * (1 - 1e-9):
        raise ValueError(
            f"followed = {followed:.4g} m is less than {least:.4g} m, which is 1/{FURTHEST:g} of the slid distance or "
            f"{_LEAST_OF_CELL:g} of the side of the cell; the error of the theory that continues it is unknown: follow "
            "the slide further"
        )


def continuation_fault(scene: Scene) -> str:
    """Return why the theory cannot continue the slides of a scene; empty if it can."""
    if scene.directions:
        return f"no theory continues slides of faces with a lay, here {scene.lay:g}"
    if calibrated(scene).stress_spectrum is None:
        return f"the theory of two sliding faces cannot continue it: {calibrated(scene).range}"
    if scene.distribution:
        return "no theory continues the distribution of the temperature, which the scene asks for"
    bodies = conduction(scene)
    contrast = float(np.max(bodies.counter_conductivity / bodies.conductivity))
    if contrast > _CONTRAST:
        return (
            f"the resting body conducts {contrast:.3g} times as well as the moving one, over {_CONTRAST:g} times, "
            f"where the theory that continues it errs by more than {100 * CONTINUED:.2g} %"
        )
    if moving_roughness(scene) > _MOVING_PART:
        return (
            f"over {100 * _MOVING_PART:.0f} % of C(q) is on the moving face, where the theory that continues it errs by more "
            f"than {100 * CONTINUED:.2g} %"
        )
    return ""


def _refusal(scene: Scene, followed: float, fault: str) -> str:
    """Return why slides may not end sooner."""
    whole = max(scene.sliding.distances)
    return f"followed = {followed:.4g} m is less than the slid distance of {whole:.4g} m, and {fault}; leave out followed"


def sliding_prediction(
    scene: Scene, slid_distance: Array | None = None
) -> SlidingPrediction | None:
    """Return the theory of a scene with `history = "sliding"`; None where the calibrated law does not hold.

    None of faces with a lay, too. `slid_distance`, (speeds,), m, replaces that of the scene.
    """
    if calibrated(scene).stress_spectrum is None or scene.directions:
        return None
    speeds = np.array(scene.speeds)
    distances = np.array(scene.sliding.distances) if slid_distance is None else slid_distance
    points, weights = leggauss(_POINTS)
    late = 1.0 - 0.5 * _LATE * (1.0 - points)
    flash, share, contact = np.zeros((3, speeds.size))
    for indices, constants in groups(scene, speeds):
        arguments = _pair_arguments(scene, constants)
        slid = late[:, None] * distances[indices]
        contacts_along = theory.two_bodies.sliding_temperatures(
            speeds[indices], scene.spectrum, slid_distance=slid, **arguments
        )
        at_the_end = theory.two_bodies.sliding_temperatures(
            speeds[indices], scene.spectrum, slid_distance=distances[indices], **arguments
        )
        flash[indices] = 0.5 * weights @ contacts_along.flash_temperature
        share[indices] = 0.5 * weights @ contacts_along.moving_share
        contact[indices] = flash[indices] + at_the_end.background
    return SlidingPrediction(distances, flash, share, contact)


def sliding_error(scene: Scene) -> float:
    """Return the relative error, 95 %, of T_flash by `sliding_prediction`, at any speed; NaN where it is not known."""
    unknown = calibrated(scene).stress_spectrum is None or scene.directions
    return nan if unknown else _ERROR


def _pair_arguments(scene: Scene, constants: Heating) -> dict[str, Any]:
    """Return contact, μ, both bodies, and the moving part of C(q), as arguments of the theory."""
    both = heat_arguments(*constants) | resting_arguments(constants.bodies)
    return law_arguments(scene) | both | {"moving_roughness": moving_roughness(scene)}


def moving_roughness(scene: Scene) -> float:
    """Return the moving face's part of C(q): its mean over |σ_q|², if it depends on q."""
    resting, moving = scene.sliding_faces
    if moving is None:
        return 0.0
    stress = theory.persson.stress_density(stress_spectrum=calibrated(scene).stress_spectrum)
    q, variance = stress.wavenumber(), stress.weighted()
    riding, still = (
        np.where((q >= face.breaks[0]) & (q <= face.breaks[-1]), density(face, q), 0.0)
        for face in (moving, resting)
    )
    rough = riding + still > 0.0
    return float(np.average(riding[rough] / (riding + still)[rough], weights=variance[rough]))
