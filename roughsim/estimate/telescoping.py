"""The telescoping sum of a column: its mean at each level, and the change by a vanishing pixel."""

from collections.abc import Callable
from math import isnan
from typing import NamedTuple

import numpy as np

from roughsim.estimate.mean import Mean, mean_of
from roughsim.estimate.regression import at_mean_peak_volume
from roughsim.grid import Array
from roughsim.observables.record import Sample
from roughsim.scene.numerics import SAME

# lengths that converge non-monotonically: beyond 8 pixels per wave they changed by .2 to 1.5 of the change from 4 to 8
_TURNING = 1.5
# of the exponent, for the error by the largest change of T_flash at some speed: slower than the change mostly falls, so
# that carries to a higher cut-off hold in drawn scenes (experiments/pixel_falls.py)
_LARGEST_FALL = 1.0 / 3.0


class Pair(NamedTuple):
    """Samples of a level and of the level below on the same surfaces; the latter is None at the lowest level."""

    level: int
    stream: int  # of its surfaces: levels of one stream see the same ones
    sample: Sample
    below: Sample | None

    def of(self, change: Callable[[Sample], Sample]) -> "Pair":
        """Return the pair with both samples changed."""
        below = None if self.below is None else change(self.below)
        return self._replace(sample=change(self.sample), below=below)

    @property
    def is_refined(self) -> bool:
        """Whether it has the cut-off of the level below, on a finer grid."""
        return self.below is not None and self.sample.q_max <= self.below.q_max * (1 + SAME)


class LevelMean(NamedTuple):
    """A cut-off, rad/m, its mean, and relative changes by finer grids: by all, and by the last, `refined` times."""

    q_max: float
    mean: Mean
    finer: Mean | None = None
    last: Mean | None = None
    refined: float = 1.0


def telescoped(of_level: Callable[[Sample], Array], pairs: list[Pair]) -> list[LevelMean]:
    """Return the levels of a column, lowest first; `of_level` gives the influence values of a sample, (n, speeds).

    A step is the ratio of the means if all values have the same sign, else their difference.
    """
    rows = [
        (of_level(pair.sample), None if pair.below is None else of_level(pair.below))
        for pair in pairs
    ]
    values = np.concatenate([level for both in rows for level in both if level is not None])
    with np.errstate(invalid="ignore"):  # infinite at rest
        with_ratio = np.all(np.isfinite(values) & (values * values[0] > 0.0), axis=0)
    levels: list[LevelMean] = []
    for pair, (fine, coarse) in zip(pairs, rows, strict=True):
        if coarse is None or pair.below is None:
            of_peaks = at_mean_peak_volume(fine, pair.sample.numbers)
            levels.append(LevelMean(pair.sample.q_max, mean_of(pair.stream, of_peaks)))
            continue
        upper, lower = mean_of(pair.stream, fine), mean_of(pair.stream, coarse)
        with np.errstate(invalid="ignore"):  # infinite at rest
            ratio, difference = upper / lower, upper - lower
        of_below = (abs(level.q_max / pair.below.q_max - 1) <= SAME for level in levels)
        low = list(of_below).index(True)
        level = levels[low]
        if pair.is_refined:
            with np.errstate(all="ignore"):
                relative = difference * (1.0 / level.mean.value)
            relative = (ratio - 1.0).where(with_ratio, relative)
            finer = relative if level.finer is None else level.finer + relative
            refined = pair.sample.side / pair.below.side
            levels[low] = level._replace(finer=finer, last=relative, refined=refined)
        else:
            with np.errstate(invalid="ignore"):  # infinite at rest, or 0/0 where nothing yields
                mean = (level.mean * ratio).where(with_ratio, level.mean + difference)
            levels.append(LevelMean(pair.sample.q_max, mean))
    return levels


def change_by_pixel(
    levels: list[LevelMean],
    order: float,
    fall: float,
    end: float = 0.0,
    slow: list[LevelMean] | None = None,
) -> tuple[Mean, Array]:
    """Return the change by a vanishing pixel at a cut-off `end`, rad/m, and its error, both relative; NaN if unknown.

    `order` is the order of convergence in the pixel at one cut-off; NaN for lengths that converge non-monotonically:
    their value is from the finest grid, and the expected change by finer grids is their error. Along the levels the
    pixel is a fixed part of the shortest wave, and its effect falls as q_c^(−fall). So the change measured at the
    highest refined level is scaled to `end`, if that is higher, and the whole scaled change counts as error. With a
    temperature comes `slow`, the levels of T_flash of slow contact: at high speeds its change may first grow, or turn,
    so the largest at any of these speeds counts as error at each, and falls more slowly. All are of shape (speeds,) or
    (1,).
    """
    shape = levels[-1].mean.value.shape
    nothing = Mean(np.zeros(shape), {})
    shown = next((level for level in reversed(levels) if level.finer is not None), None)
    if shown is None or shown.finer is None or shown.last is None:
        return nothing, np.full(shape, np.nan)
    beyond = _TURNING if isnan(order) else 1.0 / (shown.refined**order - 1.0)
    unseen = shown.last * beyond
    carried = (shown.q_max / max(end, shown.q_max)) ** fall
    change = shown.finer if isnan(order) else shown.finer + unseen
    known = np.isfinite(change.value)  # 0/0 without yielding, or at rest
    change = change.where(known, nothing)
    if carried > 1.0 - SAME:
        moved = np.zeros(shape)
    elif slow is None:
        moved = np.abs(change.value) * carried
    else:
        of_slow, _ = change_by_pixel(slow, order, fall)
        largest = max(np.abs(one.value).max() for one in (change, of_slow))
        moved = np.full(shape, largest * carried**_LARGEST_FALL)
    return change * carried, np.where(known, np.hypot(carried * unseen.value, moved), 0.0)
