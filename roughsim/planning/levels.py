"""Which levels a scene gets: cut-offs and grids, each with its reason, and the systematic errors that they leave.

- Contact that yields needs no resolution of its own: the yield wavenumber q_y sets the scale, not q_max.
- Contact on the smoothed spectrum C_sm converges by itself: one cut-off a little above q_y, on two grids.
- Capped contact errs by the cut-off more than by the pixel: three cut-offs, continued as T∞ + c q_c^(−p), the lower two
  also at half the pixel.
- Where no grid holds C(q), or reaches q_y: three cut-offs, continued with the theory's shape.
"""

from __future__ import annotations

from dataclasses import replace
from math import hypot, inf, isfinite, nan, pi
from typing import NamedTuple

import numpy as np

from roughsim import prediction
from roughsim.estimate.ladder import DOUBT_OF_SHAPE
from roughsim.planning.pilot import Pilot, fast_size
from roughsim.scene import Scene
from roughsim.scene.numerics import Column, Level

Lengths = tuple[float, float]  # of the cell, m
ELASTIC_SIDE, CAPPED_SIDE = 2048, 4096  # points per side of the finest grids of a plan; beyond, C(q) is cut
PIXELS = 4  # per shortest wave of a level; its partner at half the pixel has twice as many
SYSTEMATIC = 0.6  # share of the target that bandwidth and pixel may take; the rest is for the scatter

# cut-offs and doubts of capped contact, measured on steel: docs/errors.md
SMOOTHED_TOP = 1.5  # q_y: the end of C_sm
CAPPED_TOPS = (8, 16, 32)  # q_y: tops of ladders to choose from
FITTED_TOP = 16  # q_y: from there on the lowest rung stands at 4 q_y, and the rungs tell an exponent
SLOW_FALL = 0.75  # exponent below which three rungs do not tell it well: H = 0.43
UNFITTED_DOUBT, SLOW_DOUBT, FITTED_DOUBT = 1.0, 0.5, 0.12  # share of the remainder beyond the top that is in doubt
UNCUT_PIXEL = 0.6  # of the pilot's change, what the pixel leaves where all of C(q) is solved; falls as 1/√q_c


class Rung(NamedTuple):
    """A level, and why it is there."""

    level: Level
    reason: str


class Ladder(NamedTuple):
    """The rungs of a scene, and the relative errors to expect of T_flash; NaN is a bandwidth that no level tells."""

    rungs: list[Rung]
    bandwidth: float
    pixel: float

    def levels(self, every: int) -> tuple[Level, ...]:
        """Return the levels; those that correct the first of their column are solved for one realization in `every`."""
        first = {rung.level.column: rung.level for rung in reversed(self.rungs)}
        return tuple(a if a is first[a.column] else replace(a, every=every) for a, _ in self.rungs)


def highest_cut_off(lengths: Lengths, side: int) -> float:
    """Return the cut-off up to which a grid of `side`² points has `PIXELS` per wave, rad/m."""
    return side * 2 * pi / (PIXELS * max(lengths))


def yield_scale(scene: Scene) -> tuple[float, str]:
    """Return q_y, or q_max where the theory's contact does not yield before, and what to call it."""
    q_yield = prediction.yield_wavenumber(scene)
    if isfinite(q_yield):
        return q_yield, f"q_y = {q_yield:.3g} rad/m, where 99 % of the contact has yielded"
    q_max = scene.spectrum.breaks[-1]
    return q_max, f"q_max = {q_max:.3g} rad/m: 99 % yielding is not reached"


def elastic_ladder(scene: Scene, lengths: Lengths, target: float, pilot: Pilot) -> Ladder:
    """Return all of C(q) on two grids, or three cut-offs where that takes more points than a plan allows."""
    q_max = scene.spectrum.breaks[-1]
    if q_max > highest_cut_off(lengths, ELASTIC_SIDE) / 2:  # the partner has half the pixel
        first = f"the whole of C(q), to {q_max:.3g} rad/m, is more than a grid holds"
        return cut_ladder(scene, ("elastic",), lengths, pilot, first)
    # the error of the pixel is of second order: a third of what half the pixel changes is left, then a quarter of that
    fine = pilot.pixel / 3 > SYSTEMATIC * target
    pixels, pixel_error = (2 * PIXELS, pilot.pixel / 12) if fine else (PIXELS, pilot.pixel / 3)
    return Ladder(pair("elastic", lengths, q_max, pixels, f"{pixels} pixels per shortest wave"), 0.0, pixel_error)


def capped_ladder(scene: Scene, lengths: Lengths, target: float, pilot: Pilot) -> Ladder:
    """Return the smoothed surface on two grids, and a ladder of capped contact up to 8, 16 or 32 q_y."""
    q_max = scene.spectrum.breaks[-1]
    q_yield, where = yield_scale(scene)
    limit = highest_cut_off(lengths, CAPPED_SIDE)
    smoothed_top = min(SMOOTHED_TOP * q_yield, q_max)
    if smoothed_top > limit / 2:  # both columns up to the same cut-offs
        return cut_ladder(scene, ("smoothed", "capped"), lengths, pilot, f"yields beyond any grid ({where})")
    whole = f"{SMOOTHED_TOP:g} × {where}; {PIXELS} pixels per shortest wave"
    smoothed = pair("smoothed", lengths, smoothed_top, PIXELS, whole)
    for factor in CAPPED_TOPS:
        top = min(factor * q_yield, q_max, limit)
        exponent = prediction.usual_exponent(scene, top)
        doubt = UNFITTED_DOUBT if factor < FITTED_TOP else FITTED_DOUBT if exponent > SLOW_FALL else SLOW_DOUBT
        errors = capped_errors(top, top < q_max, pilot, exponent, doubt)
        if hypot(*errors) <= SYSTEMATIC * target or top < factor * q_yield:
            break
    height = f"{top / q_yield:.3g} q_y"
    if top >= q_max:
        whole = f"all of C(q), {height}, at {PIXELS} pixels per shortest wave"
        return Ladder([*smoothed, *pair("capped", lengths, top, PIXELS, whole)], *errors)
    first = f"{top / 4 / q_yield:.3g} q_y at {PIXELS} pixels per shortest wave"
    last = height + (f": the limit of {CAPPED_SIDE} points per side" if top == limit else "")
    last += ": how that falls, T∞ + c q_c^(−p)"
    return Ladder([*smoothed, *climb("capped", lengths, top, first, last, halved=(4, 2))], *errors)


def capped_errors(top: float, cut: bool, pilot: Pilot, exponent: float, doubt: float) -> tuple[float, float]:
    """Return bandwidth and pixel error to expect of capped T_flash, which falls as q_c^(−exponent).

    `doubt` is the share of the remainder beyond the top that is in doubt; nothing remains where C(q) is not cut.
    """
    if not cut:
        return 0.0, UNCUT_PIXEL * pilot.pixel * min(pilot.q_max / top, 1.0) ** 0.5
    # the pilot's step from q_max/2 to q_max is (2^p − 1) of what remains beyond q_max
    remainder = pilot.step / (2.0**exponent - 1.0) * (pilot.q_max / top) ** exponent
    return doubt * remainder, pilot.pixel * pilot.q_max / top


def rung(column: Column, lengths: Lengths, q_c: float, pixels: int, reason: str) -> Rung:
    """Return a level on the next larger grid of a fast transform, with so many pixels per shortest wave."""
    x, y = (fast_size(pixels * q_c * length / (2 * pi)) for length in lengths)
    return Rung(Level(column, (x, y), q_c), reason)


def pair(column: Column, lengths: Lengths, q_c: float, pixels: int, reason: str) -> list[Rung]:
    """Return one cut-off on two grids."""
    finer = "half the pixel: shows the error of the pixel, which is taken off"
    return [rung(column, lengths, q_c, pixels, reason), rung(column, lengths, q_c, 2 * pixels, finer)]


def climb(
    column: Column, lengths: Lengths, top: float, first: str, last: str, *, halved: tuple[int, ...]
) -> list[Rung]:
    """Return three cut-offs, top/4, top/2 and top, those of `halved` also at half the pixel."""
    rungs = []
    for part, reason in ((4, first), (2, "twice the q_c: what shorter waves change"), (1, last)):
        rungs.append(rung(column, lengths, top / part, PIXELS, reason))
        if part in halved:
            finer = "half the pixel: shows the error of the pixel"
            rungs.append(rung(column, lengths, top / part, 2 * PIXELS, finer))
    return rungs


def cut_ladder(scene: Scene, columns: tuple[Column, ...], lengths: Lengths, pilot: Pilot, first: str) -> Ladder:
    """Return three cut-offs of each column where no grid holds C(q), and the errors of T_flash in the last column."""
    q_max = scene.spectrum.breaks[-1]
    top = min(highest_cut_off(lengths, ELASTIC_SIDE), q_max)
    rungs = []
    for column in columns:
        last = "all of C(q): nothing is left out"
        if top < q_max:
            last = f"C(q) cut at q_c = {top:.3g} rad/m (q_max = {q_max:.3g}): what is left to q_max "
            if prediction.follows_theory(scene, column, top):
                last += "follows the theory's shape, scaled by the last step"
            else:
                last += "is unknown: the contact yields at shorter waves than any grid holds"
        rungs += climb(column, lengths, top, f"{first}; {PIXELS} pixels per shortest wave", last, halved=(4,))
    # the pixel is of second order, as in elastic contact
    return Ladder(rungs, cut_bandwidth(scene, columns[-1], top, pilot), pilot.pixel / 3)


def cut_bandwidth(scene: Scene, column: Column, top: float, pilot: Pilot) -> float:
    """Return the relative error to expect of the highest T_flash by a cut at `top`; NaN where it is unknown."""
    if top >= scene.spectrum.breaks[-1]:
        return 0.0
    if not prediction.follows_theory(scene, column, top):
        return nan
    temperatures = prediction.predictions(scene, inf)["flash_temperature"]
    hottest = int(np.argmax(temperatures))
    if not temperatures[hottest]:  # at rest, at every speed of the scene
        return 0.0

    def theory(q: float) -> float:
        return float(prediction.predictions(scene, q)["flash_temperature"][hottest])

    step = theory(pilot.q_max) - theory(pilot.q_max / 2)
    # as much of what follows in the theory as the pilot's step is of the theory's
    return DOUBT_OF_SHAPE * (pilot.step * (theory(inf) - theory(top)) / step)
