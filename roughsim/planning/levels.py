"""Which levels a scene gets: cut-offs and grids, each with its reason, and the systematic errors that they leave.

A pilot goes ahead: a few cheap solves show how much T_flash scatters, and how it falls with the cut-off and the pixel.
Their cut-offs are far below those of the run: a solve takes hundredths of a second. Their random streams are
their own; the same scene gives the same pilot. What it measures scales to the run's levels as 1/q_c. The rules:

- Contact that yields needs no resolution of its own: the yield wavenumber q_y sets the scale, not q_max.
- Contact on the smoothed spectrum C_sm converges by itself: one cut-off a little above q_y, on two grids.
- Capped contact errs by the cut-off more than by the pixel: three cut-offs, continued as T∞ + c q_c^(−p) or by the law
  for contact that yields, the lower two also at half the pixel.
- Where no grid holds C(q), or reaches q_y: three cut-offs, continued with the theory's shape.
- Corrections of capped contact may come from half the cell: docs/errors.md. Those of elastic contact do not.
"""

from __future__ import annotations

import time
import warnings
from dataclasses import dataclass, replace
from functools import lru_cache
from math import ceil, hypot, inf, isfinite, nan, pi
from typing import NamedTuple

import numpy as np

from roughsim import prediction
from roughsim.errors import ConvergenceError
from roughsim.estimate.cell_size import SIZE_ERROR, size_error
from roughsim.estimate.continuation import DOUBT_OF_LAW, DOUBT_OF_SHAPE
from roughsim.estimate.ladder import SAME
from roughsim.estimate.regression import at_zero_skewness
from roughsim.grid import Array
from roughsim.planning.realization import realize
from roughsim.scene import Scene
from roughsim.scene.numerics import DEFAULT_SOLVER, Column, Level, Numerics
from roughsim.surface.skewness import long_wave_skewness

Lengths = tuple[float, float]  # of the cell, m
SOLVES = 12  # of each level: scatter is then known to a fifth, one standard error
SCATTER_KNOWN = (0.70, 1.75)  # true over measured scatter, 95 % of normal ones: √(10/χ²) with 10 degrees of freedom
POINTS = 512  # points per side that no solve of a pilot exceeds
LEAST_POINTS = 8  # points per side of its coarsest grid
PILOT_TOP = 4.0  # q_y: highest cut-off of a pilot of capped contact, the lowest rung of most ladders
SEED = 20  # any number: a pilot must not see the surfaces of the run
ELASTIC_SIDE, CAPPED_SIDE = 2048, 4096  # points per side of the finest grids of a plan; beyond, C(q) is cut
PIXELS = 4  # per shortest wave of a level; its partner at half the pixel has twice as many
SYSTEMATIC = 0.6  # share of the target that the pixel may take; the rest is for the scatter
SYSTEMATIC_CUT = 0.75  # with the bandwidth, where another rung costs more than many realizations of the lowest one

# cut-offs and doubts of capped contact, measured on steel: docs/errors.md
SMOOTHED_TOP = 1.5  # q_y: the end of C_sm
CAPPED_TOPS = (8, 16, 32)  # q_y: tops of ladders to choose from
NEAR_END = 1.25  # times a top: C(q) that ends below is solved to its end
FITTED_TOP = 16  # q_y: from there on the lowest rung stands at 4 q_y, and the rungs tell an exponent
SLOW_FALL = 0.75  # exponent below which three rungs do not tell it well: H = 0.43
UNFITTED_DOUBT, SLOW_DOUBT, FITTED_DOUBT = 1.0, 0.5, 0.2  # share of the remainder beyond the top that is in doubt
UNCUT_PIXEL = 0.6  # of the pilot's change, what the pixel leaves where all of C(q) is solved; falls as 1/√q_c


@dataclass(frozen=True, slots=True)
class Pilot:
    """What the pilot of one column says of T_flash, relative to its limit at the speed with the highest T_flash."""

    raw_scatter: float  # standard deviation of one realization over its mean, at the worst speed
    scatter: float  # the same at zero skewness
    hot_scatter: float  # the same at the speed with the highest T_flash
    step: float  # change of the mean from q_max/2 to q_max
    pixel: float  # change of the mean from 4 to 8 pixels per shortest wave, at q_max/2
    change_scatter: float  # standard deviation of these changes from one realization to the next
    q_max: float  # its highest cut-off, rad/m
    pace: float  # CPU time of one realization over `work` of its points, s; never decides
    measured: bool = True
    # of these changes at the speed where they scatter most, relative to T_flash there
    widest_change_scatter: float = 0.0


# what stands for a pilot whose solves do not converge: about what those of steel say
GUESS = Pilot(0.02, 0.02, 0.02, step=0.2, pixel=0.009, change_scatter=0.004, q_max=inf, pace=1.2e-8, measured=False)


def work(points: float) -> float:
    """Return how the time of a solve grows with its points: per point as √(points per side), on 512² to 3072²."""
    return float(points**1.25)


@lru_cache(maxsize=32)
def pilot(scene: Scene, column: Column, lengths: Lengths, q_max: float) -> Pilot:
    """Measure T_flash at a few low cut-offs; a guess where a solve does not converge.

    `lengths` are of the cell, m. `q_max` is the highest cut-off, rad/m; lowered to what `POINTS` per side resolve with
    4 pixels per wave.
    """
    cut = min(q_max, POINTS * 2 * pi / (4 * max(lengths)))
    x, y = (fast_size(max(2.0 * LEAST_POINTS, 4 * cut * length / (2 * pi))) for length in lengths)
    levels = (
        Level(column, (x // 2, y // 2), cut / 2),
        Level(column, (x, y), cut),  # twice the cut-off at the same pixels per wave
        Level(column, (x, y), cut / 2),  # half the pixel at the same cut-off
    )
    numerics = Numerics(levels, lengths, solver=scene.numerics.solver or DEFAULT_SOLVER)
    try:
        levels_of_pilot = (flash_temperatures(scene, numerics, k) for k in range(3))
        (coarse, _, quick), (fine, skewness, seconds), (finer, _, other) = levels_of_pilot
    except ConvergenceError:
        return replace(GUESS, q_max=cut)
    mean = fine.mean(axis=0)
    hottest = int(np.argmax(mean))
    limit = (2.0 * fine - coarse).mean(axis=0)  # of first order in 1/q_c
    changes = fine - coarse, finer - coarse
    steps, pixels = (change[:, hottest] / limit[hottest] for change in changes)
    widest = (change.std(axis=0, ddof=1)[limit > 0.0] / limit[limit > 0.0] for change in changes)
    raw_scatter, scatter = (
        np.divide(rows.std(axis=0, ddof=1), mean, out=np.zeros_like(mean), where=mean > 0.0)
        for rows in (fine, at_zero_skewness(fine, skewness))
    )
    return Pilot(
        raw_scatter=float(raw_scatter.max()),
        scatter=float(scatter.max()),
        hot_scatter=float(scatter[hottest]),
        step=abs(float(steps.mean())),
        pixel=abs(float(pixels.mean())),
        change_scatter=max(float(change.std(ddof=1)) for change in (steps, pixels)),
        q_max=cut,
        pace=pace(numerics, quick, min(seconds, other)),
        widest_change_scatter=max(float(scatter.max(initial=0.0)) for scatter in widest),
    )


def pace(numerics: Numerics, coarse: float, fine: float) -> float:
    """Return CPU time over work from one grid to the next, so that what every realization takes drops out, s."""
    small, large = (work(numerics.grid(i).points) for i in (0, 1))
    return max((fine - coarse) / (large - small), 0.5 * fine / large)


def flash_temperatures(scene: Scene, numerics: Numerics, level: int) -> tuple[Array, Array, float]:
    """Return T_flash (SOLVES, speeds) and skewness (SOLVES,) of all realizations, and the least CPU time of one, s."""
    rows, skewness, least = [], [], inf
    for index in range(SOLVES):
        start = time.process_time()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # the run itself says what is to be said
            solution = realize(scene, numerics, seed=SEED, level=level, index=index)
        least = min(least, time.process_time() - start)
        rows.append(solution.observables.flash_temperature)
        skewness.append(long_wave_skewness(solution.heights, solution.grid))
    return np.stack(rows), np.array(skewness), least


def fast_size(points: float) -> int:
    """Return the next size of the form 2^a·{4, 5, 6} ≥ `points` less 2 %: fast to transform, easy to halve."""
    least = max(8, ceil(0.98 * points))
    return min(k << a for a in range(1, least.bit_length()) for k in (4, 5, 6) if k << a >= least)


class Rung(NamedTuple):
    """A level, and why it is there."""

    level: Level
    reason: str


class Ladder(NamedTuple):
    """The rungs of a scene, and the relative errors to expect of T_flash; NaN is a bandwidth that no level tells.

    `correction` is the share of T_flash that the capped levels above the first add, where half the cell may give it;
    else 0.
    """

    rungs: list[Rung]
    bandwidth: float
    pixel: float
    correction: float = 0.0

    def divided(self, every: int, half: bool) -> list[Rung]:
        """Return the rungs, those that correct the first of their column for one realization in `every`.

        With `half` those of capped contact lie in half the cell, and so does a repetition of the first.
        """
        rungs: list[Rung] = []
        for level, reason in self.rungs:
            first = level.column not in (rung.level.column for rung in rungs)
            rungs.append(Rung(level, reason) if first else Rung(replace(level, every=every), reason))
            if half and level.column == "capped":
                again = "the first again: only differences from it count, which hardly depend on the cell"
                (x, y), kept = level.shape, rungs if first else rungs[:-1]
                small = replace(level, shape=(x // 2, y // 2), every=every, cell="half")
                rungs = [*kept, Rung(small, again if first else reason)]
        return rungs

    def levels(self, every: int, half: bool = False) -> tuple[Level, ...]:
        """Return the levels of the rungs `divided`."""
        return tuple(rung.level for rung in self.divided(every, half))


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


def ladder_of(scene: Scene, lengths: Lengths, target: float) -> tuple[Ladder, Pilot]:
    """Return the levels of a scene for a relative error, and what its pilot has seen."""
    q_max = scene.spectrum.breaks[-1]
    if scene.elastic:
        seen = pilot(scene, "elastic", lengths, q_max)
        return elastic_ladder(scene, lengths, target, seen), seen
    seen = pilot(scene, "capped", lengths, min(q_max, PILOT_TOP * yield_scale(scene)[0]))
    return capped_ladder(scene, lengths, target, seen), seen


def elastic_ladder(scene: Scene, lengths: Lengths, target: float, seen: Pilot) -> Ladder:
    """Return all of C(q) on two grids, or three cut-offs where that takes more points than a plan allows."""
    q_max = scene.spectrum.breaks[-1]
    if q_max > highest_cut_off(lengths, ELASTIC_SIDE) / 2:  # the partner has half the pixel
        first = f"the whole of C(q), to {q_max:.3g} rad/m, is more than a grid holds"
        return cut_ladder(scene, ("elastic",), lengths, seen, first)
    # the error of the pixel is of second order: a third of what half the pixel changes is left, then a quarter of that
    fine = seen.pixel / 3 > SYSTEMATIC * target
    pixels, pixel_error = (2 * PIXELS, seen.pixel / 12) if fine else (PIXELS, seen.pixel / 3)
    return Ladder(pair("elastic", lengths, q_max, pixels, f"{pixels} pixels per shortest wave"), 0.0, pixel_error)


def capped_ladder(scene: Scene, lengths: Lengths, target: float, seen: Pilot) -> Ladder:
    """Return the smoothed surface on two grids, and a ladder of capped contact up to 8, 16 or 32 q_y."""
    q_max = scene.spectrum.breaks[-1]
    q_yield, where = yield_scale(scene)
    limit = highest_cut_off(lengths, CAPPED_SIDE)
    smoothed_top = min(SMOOTHED_TOP * q_yield, q_max)
    if smoothed_top > limit / 2:  # both columns up to the same cut-offs
        return cut_ladder(scene, ("smoothed", "capped"), lengths, seen, f"yields beyond any grid ({where})")
    whole = f"{SMOOTHED_TOP:g} × {where}; {PIXELS} pixels per shortest wave"
    smoothed = pair("smoothed", lengths, smoothed_top, PIXELS, whole)
    may_halve = size_error(scene, lengths) <= SIZE_ERROR * (1.0 + SAME)
    for factor in CAPPED_TOPS:
        top = min(factor * q_yield, q_max, limit)
        if q_max <= min(limit, NEAR_END * top):  # little is left out: all of C(q), which serves every observable
            top = q_max
        exponent = prediction.usual_exponent(scene, top)
        doubt = UNFITTED_DOUBT if factor < FITTED_TOP else FITTED_DOUBT if exponent > SLOW_FALL else SLOW_DOUBT
        errors = capped_errors(top, top < q_max, seen, exponent, doubt)
        if top < q_max and seen.measured:
            errors = min(errors[0], law_error(scene, top)), errors[1]
        if hypot(*errors) <= SYSTEMATIC_CUT * target or top < factor * q_yield:
            break
    height = f"{top / q_yield:.3g} q_y"
    if top >= q_max:
        whole = f"all of C(q), {height}, at {PIXELS} pixels per shortest wave"
        return Ladder([*smoothed, *pair("capped", lengths, top, PIXELS, whole)], *errors, may_halve * seen.pixel)
    first = f"{top / 4 / q_yield:.3g} q_y at {PIXELS} pixels per shortest wave"
    last = height + (f": the limit of {CAPPED_SIDE} points per side" if top == limit else "")
    last += ": how that falls, T∞ + c q_c^(−p), or by the law for contact that yields"
    correction = may_halve * remainder(seen, top / 4, exponent)
    return Ladder([*smoothed, *climb("capped", lengths, top, first, last, halved=(4, 2))], *errors, correction)


def capped_errors(top: float, cut: bool, seen: Pilot, exponent: float, doubt: float) -> tuple[float, float]:
    """Return bandwidth and pixel error to expect of capped T_flash, which falls as q_c^(−exponent).

    `doubt` is the share of the remainder beyond the top that is in doubt; nothing remains where C(q) is not cut.
    """
    if not cut:
        return 0.0, UNCUT_PIXEL * seen.pixel * min(seen.q_max / top, 1.0) ** 0.5
    return doubt * remainder(seen, top, exponent), seen.pixel * seen.q_max / top


def remainder(seen: Pilot, q_c: float, exponent: float) -> float:
    """Return what remains beyond a cut-off, relative: T_flash falls as q_c^(−exponent)."""
    # the pilot's step from q_max/2 to q_max is (2^p − 1) of what remains beyond q_max
    return float(seen.step / (2.0**exponent - 1.0) * (seen.q_max / q_c) ** exponent)


def law_error(scene: Scene, top: float) -> float:
    """Return the bandwidth error to expect of the highest T_flash by the law for contact that yields; else infinite."""
    law = prediction.yielded_fall(scene, (top / 2, top))
    if law is None or not law.any():  # outside its range, or at rest
        return inf
    hottest = int(np.argmax(law[-1]))
    return hypot(DOUBT_OF_LAW[0], DOUBT_OF_LAW[1] * (1.0 - float(law[-1, hottest] / law[-2, hottest])))


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


def cut_ladder(scene: Scene, columns: tuple[Column, ...], lengths: Lengths, seen: Pilot, first: str) -> Ladder:
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
    return Ladder(rungs, cut_bandwidth(scene, columns[-1], top, seen), seen.pixel / 3)


def cut_bandwidth(scene: Scene, column: Column, top: float, seen: Pilot) -> float:
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

    step = theory(seen.q_max) - theory(seen.q_max / 2)
    # as much of what follows in the theory as the pilot's step is of the theory's
    return DOUBT_OF_SHAPE * (seen.step * (theory(inf) - theory(top)) / step)
