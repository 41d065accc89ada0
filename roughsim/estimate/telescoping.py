"""The telescoping sum of a column: its mean at each level, and the change by a vanishing pixel."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import isnan
from typing import NamedTuple

import numpy as np
import scipy

from roughsim.estimate.mean import Mean, exact, mean_of
from roughsim.estimate.regression import at_mean_peak_volume
from roughsim.grid import Array
from roughsim.observables.record import Sample
from roughsim.scene.numerics import SAME

# lengths that converge non-monotonically: beyond 8 pixels per wave they changed by .2 to 1.5 of the change from 4 to 8
_TURNING = 1.5
# of the exponent, for the error by the largest change of T_flash at some speed: slower than the change mostly falls, so
# that carries to a higher cut-off hold in drawn scenes (experiments/pixel_falls.py)
_LARGEST_FALL = 1.0 / 3.0


class LevelMean(NamedTuple):
    """A cut-off, rad/m, its mean, and relative changes by finer grids: by all, and by the last, `refined` times."""

    q_max: float
    mean: Mean
    finer: Mean | None = None
    last: Mean | None = None
    refined: float = 1.0


def is_refined(sample: Sample) -> bool:
    """Return whether a level has the cut-off of the level below, on a finer grid."""
    return sample.below is not None and sample.q_max <= sample.below.q_max * (1 + SAME)


def telescoped(of_level: Callable[[Sample], Array], samples: Sequence[Sample]) -> list[LevelMean]:
    """Return the levels of a column, lowest first; `of_level` gives the influence values of a sample, (n, speeds).

    A step is the ratio of the means if all values have the same sign, else their difference.
    """
    rows = [[of_level(each) for each in (one, one.below) if each is not None] for one in samples]
    values = np.concatenate([level for both in rows for level in both])
    with np.errstate(invalid="ignore"):  # infinite at rest
        with_ratio = np.all(np.isfinite(values) & (values * values[0] > 0.0), axis=0)
    levels: list[LevelMean] = []
    for sample, both in zip(samples, rows, strict=True):
        if sample.below is None:
            of_peaks = at_mean_peak_volume(both[0], sample.numbers)
            levels.append(LevelMean(sample.q_max, mean_of(sample.stream, of_peaks)))
            continue
        upper, lower = (mean_of(sample.stream, each) for each in both)
        with np.errstate(invalid="ignore"):  # infinite at rest
            ratio = upper / lower
            difference = upper - lower
        of_below = (abs(level.q_max / sample.below.q_max - 1) <= SAME for level in levels)
        low = list(of_below).index(True)
        level = levels[low]
        if is_refined(sample):
            with np.errstate(all="ignore"):
                relative = difference * (1.0 / level.mean.value)
            relative = (ratio - 1.0).where(with_ratio, relative)
            finer = relative if level.finer is None else level.finer + relative
            refined = sample.side / sample.below.side
            levels[low] = level._replace(finer=finer, last=relative, refined=refined)
        else:
            with np.errstate(invalid="ignore"):  # infinite at rest, or 0/0 where nothing yields
                mean = (level.mean * ratio).where(with_ratio, level.mean + difference)
            levels.append(LevelMean(sample.q_max, mean))
    return levels


def correlation_of(samples: Sequence[Sample], distance: Array) -> Mean:
    """Return g_σ(r) at the highest cut-off of a column, Pa², over r in place of the speed.

    `distance` is r, m, one-dimensional. Steps add. Levels in a part of the cell change it up to half the diagonal of
    their cell: the short waves that they add have lost their correlation there.
    """

    def of_level(sample: Sample) -> Array:
        values = sample.spectrum @ scipy.special.j0(np.multiply.outer(sample.wavenumber, distance))
        return np.where(distance <= sample.reach, values, 0.0) if sample.part else values

    lowest, *others = samples
    total = mean_of(lowest.stream, at_mean_peak_volume(of_level(lowest), lowest.numbers))
    top = max(sample.q_max for sample in samples)
    for sample in others:
        if sample.below is not None and (not is_refined(sample) or sample.q_max == top):
            total += mean_of(sample.stream, of_level(sample) - of_level(sample.below))
    return total


def change_by_pixel(
    levels: list[LevelMean],
    order: float,
    fall: float,
    end: float = 0.0,
    slow: list[LevelMean] | None = None,
) -> Mean:
    """Return the relative change by a vanishing pixel at a cut-off `end`, rad/m; its error, "pixel", is NaN if unknown.

    `order` is the order of convergence in the pixel at one cut-off; NaN for lengths that converge non-monotonically:
    their value is from the finest grid, and the expected change by finer grids is their error. Along the levels the
    pixel is a fixed part of the shortest wave, and its effect falls as q_c^(−fall). So the change measured at the
    highest refined level is scaled to `end`, if that is higher, and the whole scaled change counts as error. With a
    temperature comes `slow`, the levels of T_flash of slow contact: at high speeds its change may first grow, or turn,
    so the largest at any of these speeds counts as error at each, and falls more slowly. All are of shape (speeds,) or
    (1,).
    """
    shape = levels[-1].mean.value.shape
    nothing = exact(np.zeros(shape))
    shown = next((level for level in reversed(levels) if level.finer is not None), None)
    if shown is None or shown.finer is None or shown.last is None:
        return replace(nothing, errors={"pixel": np.full(shape, np.nan)})
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
        both = change, change_by_pixel(slow, order, fall)
        largest = max(np.abs(one.value).max() for one in both)
        moved = np.full(shape, largest * carried**_LARGEST_FALL)
    error = np.where(known, np.hypot(carried * unseen.value, moved), 0.0)
    return replace(change * carried, errors={"pixel": error})
