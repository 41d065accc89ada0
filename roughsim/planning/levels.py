"""Which levels a scene gets: cut-offs and grids, each with its reason, and the systematic errors that they leave.

A pilot goes ahead (`roughsim.planning.pilot`). What it measures scales to the run's levels as 1/q_c. The rules:

- Contact that yields needs no resolution of its own: the yield wavenumber q_y sets the scale, not q_max.
- Contact on the smoothed spectrum C_sm converges by itself: one cut-off a little above q_y, on two grids.
- Capped contact errs by the cut-off more than by the pixel: cut-offs from 4 q_y on, three at least, continued as
  T∞ + c q_c^(−p) or by the law for contact that yields, the lower two also at half the pixel.
- Where no grid holds C(q), or reaches q_y: three cut-offs, continued with the theory's shape.
- Corrections of capped contact may come from a part of the cell: docs/errors.md. Those of elastic contact do not.
"""

from __future__ import annotations

from dataclasses import replace
from math import hypot, inf, isfinite, log2, nan, pi
from typing import Literal, NamedTuple

import numpy as np

from roughsim import prediction
from roughsim.estimate.cell_size import enough_length, parts_of
from roughsim.estimate.continuation import DOUBT_OF_SHAPE, doubt_of_law
from roughsim.estimate.ladder import SAME
from roughsim.planning.pilot import Lengths, Pilot, fast_size, pilot
from roughsim.scene import Scene
from roughsim.scene.numerics import Column, Level

PILOT_TOP = 4.0  # q_y: highest cut-off of a pilot of capped contact, the lowest rung of most ladders
# points per side of the finest grids of a plan, the last in a part of the cell; beyond, C(q) is cut
ELASTIC_SIDE, CAPPED_SIDE, PART_SIDE = 2048, 4096, 6144
PIXELS = 4  # per shortest wave of a level; its partner at half the pixel has twice as many
LATER = 0.45  # scatter of the correction by a cut-off over that by the one before: 0.37 … 0.52 on the steels
SYSTEMATIC = 0.6  # share of the target that the pixel may take; the rest is for the scatter
SYSTEMATIC_CUT = 0.85  # with the bandwidth, where another rung costs more than many realizations of the lowest one

# cut-offs and doubts of capped contact, measured on steel: docs/errors.md
# what measured/law changes over the last step, at the worst speed, over what follows after it: from FITTED_TOP on the
# rms of the steels, .03 ... .2; below what nine of ten have of the steels with six exponents H and three loads
CHANGE_OF_LAW, EARLY_CHANGE = 0.1, 0.15
SMOOTHED_TOP = 1.5  # q_y: the end of C_sm
CAPPED_TOPS = (8, 16, 32, 64, 128)  # q_y: tops of ladders to choose from
LOWEST = 4.0  # q_y: the lowest rung of ladders to 16 q_y and higher; from there on steps tell an exponent
NEAR_END = 1.25  # times a top: C(q) that ends below is solved to its end
FITTED_TOP = 16  # q_y: from there on the lowest rung stands at 4 q_y, and the rungs tell an exponent
SLOW_FALL = 0.75  # exponent below which three rungs do not tell it well: H = 0.43
UNFITTED_DOUBT, SLOW_DOUBT, FITTED_DOUBT = 1.0, 0.5, 0.2  # share of the remainder beyond the top that is in doubt
UNCUT_PIXEL = 0.6  # of the pilot's change, what the pixel leaves where all of C(q) is solved; falls as 1/√q_c


class Rung(NamedTuple):
    """A level, why it is there, and the scatter of what it corrects, over that of the first correction of its column.

    0 for a level that only shows an error.
    """

    level: Level
    reason: str
    scatter: float = 0.0


class Ladder(NamedTuple):
    """The rungs of a scene, and the relative errors to expect of T_flash; NaN is a bandwidth that no level tells.

    `correction` is the share of T_flash that the capped levels above the first add, where a part of the cell may give
    it, and `parts` is how many of its sides make one of the run's; else 0 and 1. With `only_part` the highest levels
    need more points in the run's cell than a plan allows.
    """

    rungs: list[Rung]
    bandwidth: float
    pixel: float
    correction: float = 0.0
    parts: int = 1
    only_part: bool = False

    def divided(self, every: int, seldom: int, *, in_part: bool) -> list[Rung]:
        """Return the rungs with their strides: 1 for the first of a column, `every` for its first correction.

        The next ones have four times as much each, but at most `seldom`; the highest, and those that only show an
        error, have `seldom`. With `in_part` those that correct capped contact lie in a part of the cell, and so does a
        repetition of the first.
        """
        rungs: list[Rung] = []
        for first, *finer in self.columns():
            rungs.append(first)
            apart = in_part and first.level.column == "capped"
            if apart:
                again = "the first again: only ratios to it count, which hardly depend on the cell"
                rungs.append(Rung(self.smaller(replace(first.level, every=every)), again))
            stride, top = every, max((rung.level.q_max for rung in finer), default=0.0)
            for rung in finer:
                corrects = rung.scatter == 1.0 or (rung.scatter > 0.0 and rung.level.q_max < top)
                level = replace(rung.level, every=stride if corrects else seldom)
                rungs.append(rung._replace(level=self.smaller(level) if apart else level))
                stride = min(4 * stride, seldom) if corrects else stride
        return rungs

    def smaller(self, level: Level) -> Level:
        """Return a level in the part of the cell, with the same pixel."""
        x, y = level.shape
        cell: Literal["half", "quarter"] = "half" if self.parts == 2 else "quarter"
        return replace(level, shape=(x // self.parts, y // self.parts), cell=cell)

    def fallen(self, seen: Pilot) -> float:
        """Return the scatter of changes from the first rung of the last column over that of the pilot's changes."""
        first = self.columns()[-1][0].level
        return seen.q_max / first.q_max if first.column == "capped" else 1.0

    def columns(self) -> list[list[Rung]]:
        """Return the rungs of each column."""
        names = dict.fromkeys(rung.level.column for rung in self.rungs)
        return [[rung for rung in self.rungs if rung.level.column == name] for name in names]

    def levels(self, every: int, seldom: int, *, in_part: bool = False) -> tuple[Level, ...]:
        """Return the levels of the rungs `divided`."""
        return tuple(rung.level for rung in self.divided(every, seldom, in_part=in_part))


def highest_cut_off(lengths: Lengths, side: int) -> float:
    """Return the cut-off up to which a grid of `side`² points has `PIXELS` per wave, rad/m."""
    return side * 2 * pi / (PIXELS * max(lengths))


def highest_of_parts(scene: Scene, lengths: Lengths) -> float:
    """Return the highest cut-off of capped contact, rad/m: in a part of the cell, where one serves, grids are finer."""
    whole, parts = highest_cut_off(lengths, CAPPED_SIDE), parts_of(scene, lengths)
    return max(whole, parts * highest_cut_off(lengths, PART_SIDE)) if parts > 1 else whole


def yield_scale(scene: Scene) -> tuple[float, str]:
    """Return q_y, or q_max where the theory's contact does not yield before, and what to call it."""
    q_yield = prediction.yield_wavenumber(scene)
    if isfinite(q_yield):
        return q_yield, f"q_y = {q_yield:.3g} rad/m, where 99 % of the contact has yielded"
    q_max = scene.spectrum.breaks[-1]
    return q_max, f"q_max = {q_max:.3g} rad/m: 99 % yielding is not reached"


def ladders_of(scene: Scene, lengths: Lengths, target: float, *, lowest: bool = False) -> tuple[list[Ladder], Pilot]:
    """Return the levels that serve a scene for a relative error, and what its pilot has seen.

    The lowest ones come first; with `lowest` they are the only ones.
    """
    q_max = scene.spectrum.breaks[-1]
    # a cell of twice the sides that suffice needs no pilot of its own
    times = 2.0 if min(lengths) >= 2.0 * enough_length(scene)[0] * (1 - SAME) else 1.0
    small = (lengths[0] / times, lengths[1] / times)
    if scene.elastic:
        seen = pilot(scene, "elastic", small, q_max).in_cell(times)
        return [elastic_ladder(scene, lengths, target, seen)], seen
    seen = pilot(scene, "capped", small, min(q_max, PILOT_TOP * yield_scale(scene)[0])).in_cell(times)
    return capped_ladders(scene, lengths, target, seen, lowest=lowest), seen


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


def capped_ladders(scene: Scene, lengths: Lengths, target: float, seen: Pilot, *, lowest: bool = False) -> list[Ladder]:
    """Return the smoothed surface on two grids, with capped contact up to 8, 16, 32 … q_y: those that serve."""
    q_max = scene.spectrum.breaks[-1]
    q_yield, where = yield_scale(scene)
    limit = highest_of_parts(scene, lengths)
    smoothed_top = min(SMOOTHED_TOP * q_yield, q_max)
    if smoothed_top > limit / 2:  # both columns up to the same cut-offs
        return [cut_ladder(scene, ("smoothed", "capped"), lengths, seen, f"yields beyond any grid ({where})")]
    whole = f"{SMOOTHED_TOP:g} × {where}; {PIXELS} pixels per shortest wave"
    smoothed = pair("smoothed", lengths, smoothed_top, PIXELS, whole, scatter=LATER)
    ladders: list[Ladder] = []
    for factor in CAPPED_TOPS:
        top = min(factor * q_yield, q_max, limit)
        if q_max <= min(limit, NEAR_END * top):  # little is left out: all of C(q), which serves every observable
            top = q_max
        ladder = capped_ladder(scene, lengths, seen, factor, top)
        last = factor * q_yield * (1 + SAME) >= min(q_max, limit) or factor == CAPPED_TOPS[-1]
        if hypot(ladder.bandwidth, ladder.pixel) <= SYSTEMATIC_CUT * target or (last and not ladders):
            ladders.append(ladder._replace(rungs=[*smoothed, *ladder.rungs]))
        if last or (lowest and ladders):
            break
    return ladders


def capped_ladder(scene: Scene, lengths: Lengths, seen: Pilot, factor: float, top: float) -> Ladder:
    """Return the levels of capped contact up to a top, rad/m, that was to be `factor` q_y."""
    q_max, q_yield = scene.spectrum.breaks[-1], yield_scale(scene)[0]
    exponent = prediction.usual_exponent(scene, top)
    doubt = UNFITTED_DOUBT if factor < FITTED_TOP else FITTED_DOUBT if exponent > SLOW_FALL else SLOW_DOUBT
    errors = capped_errors(top, top < q_max, seen, exponent, doubt)
    by_law = inf
    if top < q_max and seen.measured:
        by_law = law_error(scene, top, EARLY_CHANGE if factor < FITTED_TOP else CHANGE_OF_LAW)
    if isfinite(by_law):  # then runs took the law: the scatter of their steps made the power less sure
        errors = by_law, errors[1]
    height, parts = f"{top / q_yield:.3g} q_y", parts_of(scene, lengths)
    only_part = top > highest_cut_off(lengths, CAPPED_SIDE)
    if top >= q_max:
        whole = f"all of C(q), {height}, at {PIXELS} pixels per shortest wave"
        rungs, correction = pair("capped", lengths, top, PIXELS, whole), seen.pixel
    else:
        # grids hold a little less than 64 q_y: from 4 q_y less 2 % on all the same, as `fast_size` takes grids
        steps = max(2, int(log2(1.02 * top / (LOWEST * q_yield))))
        first = f"{top / 2**steps / q_yield:.3g} q_y at {PIXELS} pixels per shortest wave"
        side, at_limit = PART_SIDE if only_part else CAPPED_SIDE, top == highest_of_parts(scene, lengths)
        last = height + (f": the limit of {side} points per side" if at_limit else "")
        last += ": how that falls, T∞ + c q_c^(−p), or by the law for contact that yields"
        rungs = climb("capped", lengths, top, first, last, steps=steps, partners=2)
        correction = remainder(seen, top / 2**steps, exponent)
    return Ladder(rungs, *errors, (parts > 1) * correction, parts, only_part)


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


def law_error(scene: Scene, top: float, change: float) -> float:
    """Return the bandwidth error to expect of the highest T_flash by the law for contact that yields; else infinite.

    `change` is what measured/law changes over the last step, over what follows after it.
    """
    law = prediction.yielded_fall(scene, (top / 2, top))
    if law is None or not law.any():  # outside its range, or at rest
        return inf
    hottest = int(np.argmax(law[-1]))
    follows = 1.0 - float(law[-1, hottest] / law[-2, hottest])
    return float(doubt_of_law(np.ones(1), np.array([follows]), np.array([change * follows]))[0])


def rung(column: Column, lengths: Lengths, q_c: float, pixels: int, reason: str, scatter: float = 0.0) -> Rung:
    """Return a level on the next larger grid of a fast transform, with so many pixels per shortest wave."""
    x, y = (fast_size(pixels * q_c * length / (2 * pi)) for length in lengths)
    return Rung(Level(column, (x, y), q_c), reason, scatter)


def pair(column: Column, lengths: Lengths, q_c: float, pixels: int, reason: str, *, scatter: float = 1.0) -> list[Rung]:
    """Return one cut-off on two grids; `scatter` as in `Rung` is that of the finer one."""
    finer = "half the pixel: shows the error of the pixel, which is taken off"
    return [rung(column, lengths, q_c, pixels, reason), rung(column, lengths, q_c, 2 * pixels, finer, scatter)]


def climb(
    column: Column, lengths: Lengths, top: float, first: str, last: str, *, steps: int, partners: int
) -> list[Rung]:
    """Return cut-offs that double up to a top, `steps` times; the lowest ones, `partners`, also at half the pixel."""
    rungs = []
    for k in range(steps + 1):
        q_c, reason = top / 2 ** (steps - k), first if k == 0 else last
        if 0 < k < steps:
            reason = "twice the q_c: what shorter waves change"
        rungs.append(rung(column, lengths, q_c, PIXELS, reason, LATER ** (k - 1) if k else 0.0))
        if k < partners:
            rungs.append(rung(column, lengths, q_c, 2 * PIXELS, "half the pixel: shows the error of the pixel"))
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
        rungs += climb(column, lengths, top, f"{first}; {PIXELS} pixels per shortest wave", last, steps=2, partners=1)
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
