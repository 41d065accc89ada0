"""From the levels of a column to one value: fine levels as corrections, extrapolation in q_c, and the pixel.

A ladder climbs in the cut-off q_c at fixed pixels per shortest wave; a level with the same q_c on a finer grid is the
partner of its rung. Levels share the modes of each realization, so that the difference between neighbours scatters
little and a few realizations give it: T = ⟨T₀⟩ + ⟨T₁ − T₀⟩ + … over nested subsets (multilevel Monte Carlo, Giles,
Operations Research 56, 607, 2008). Along the ladder the pixel shrinks with 1/q_c, so that T∞ + c q_c^(−p) takes most of
its error along.
"""

from __future__ import annotations

from itertools import pairwise
from math import inf, isnan, nan, pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from roughsim.observables.catalogue import OBSERVABLES
from roughsim.observables.record import Sample

Array = NDArray[np.float64]

# capped contact has steep edges of its plastic patches: these have no limit in q_c and are never extrapolated
NO_LIMIT = tuple(name for name, record in OBSERVABLES.items() if not record.limit)
# where the lowest rung stands at 4 q_y or above, fitted exponents were 0.9…1.4 for H = 0.8, 0.4…0.8 for H = 0.3, and a
# tenth of the remainder was left over at most; the less the steps tell, the more is in doubt
_DOUBT_FITTED, _DOUBT_UNFITTED = 0.1, 0.5
_USUAL = 0.3  # how far exponents lie from the usual one
# exponents below that part of the usual one are mostly of rungs that stand too low: the usual one stands, and what the
# fit has beyond it is the doubt, with a quarter to spare
_LEAST, _WIDER = 0.7, 1.25
# lengths that turn back with the pixel: beyond 8 pixels per wave they went on by 0.2 to 1.5 of the change from 4 to 8
_TURNING = 1.5
# the doubt about a remainder with the theory's shape held in 156 of 158 comparisons on six ladders, many of them on the
# same surfaces (H = 0.3…0.95, rubber and rock), a quarter of it alone in 119; beyond half of the value none was tried
DOUBT_OF_SHAPE, _MOST_OF_SHAPE = 0.25, 0.5


class Values(NamedTuple):
    """One observable: a row per realization, (n, speeds), in the limit and at the finest level, with its doubts.

    Rows with the same number in `group` (n,) have the same levels, those with 0 the coarsest alone. `base` has the rows
    of the coarsest level, moved to the mean of `extrapolated`: the rest of the scatter is that of finer levels.
    `exponent`, `bandwidth` and `pixel` (speeds,) are the fitted p (NaN if nothing was extrapolated), and the errors
    left in the mean by q_c and by the pixel; NaN says that no pair of levels tells.
    """

    extrapolated: Array
    finest: Array
    base: Array
    group: NDArray[np.intp]
    exponent: Array
    bandwidth: Array
    pixel: Array


class _Rung(NamedTuple):
    """A cut-off: its sample, rows for all realizations, and those of its partner with the ratio of the pixels."""

    sample: Sample
    rows: Array
    partner: Array | None
    refined: float


def observe(
    observable: str,
    samples: list[Sample],
    *,
    capped: bool,
    end: float = inf,
    theory: Array | None = None,
    settled: float = 0.0,
    usual: float = 1.0,
) -> Values:
    """Return the values of an observable from the levels of one column.

    Parameters
    ----------
    observable : str
        A key of `roughsim.observables.catalogue.OBSERVABLES`.
    samples : list of Sample
        The levels of the column by q_c, then by points; the first has every realization.
    capped : bool
        Whether the contact is capped: decides what has a limit in q_c.
    end : float, optional
        Where the spectrum itself ends, rad/m: what is extrapolated to.
    theory : ndarray, optional
        What the theory says at each cut-off of the samples and at `end`, (cut-offs + 1, speeds) or of one speed: the
        remainder has its shape. NaN says that nothing tells. Left out: it falls as a power of the cut-off.
    settled : float, optional
        The cut-off from which on steps tell that power, rad/m: p rises on the way up to it.
    usual : float, optional
        The power where the cut-offs do not tell it; left out, first order.
    """
    ladder = _climb(observable, samples)
    unlimited = capped and observable in NO_LIMIT
    order = OBSERVABLES[observable].pixel_orders[capped]
    top = ladder[-1].rows
    group = _patterns(samples)
    unfitted = np.full(top.shape[1:], nan)
    whole = ladder[-1].sample.q_max >= end * (1 - 1e-9)
    if whole or unlimited or theory is not None or len(ladder) == 1:
        mean, finest, pixel = _at_top(ladder, order, unlimited)
        limit, bandwidth = mean, np.full_like(unfitted, 0.0 if whole else nan)
        if theory is not None and not (whole or unlimited):
            remainder, bandwidth = _shaped_remainder(ladder, mean, theory)
            limit = mean + remainder
        return Values(limit, finest, _moved(ladder, limit), group, unfitted, bandwidth, pixel)
    if OBSERVABLES[observable].distance and _within_a_wave(ladder[-2]):
        # no power tells what follows: the value stays, and what would follow at first order, the last step, is doubt
        doubt = np.abs((top - ladder[-2].rows).mean(axis=0))
        return Values(top, top, _moved(ladder, top), group, unfitted, doubt, _pixel_of_limit(ladder, order))
    exponent, remainder, bandwidth = _remainder(ladder, end, settled, usual)
    limit = top + remainder
    return Values(limit, top, _moved(ladder, limit), group, exponent, bandwidth, _pixel_of_limit(ladder, order))


def _within_a_wave(rung: _Rung) -> bool:
    """Whether the distance that a rung measures is shorter than its shortest wave."""
    return bool(rung.rows.mean() * rung.sample.q_max < 2.0 * pi)


def _moved(ladder: list[_Rung], limit: Array) -> Array:
    """Rows of the coarsest level about the mean of the limit."""
    rows, (mean, goal) = ladder[0].rows, (ladder[0].rows.mean(axis=0), limit.mean(axis=0))
    with np.errstate(invalid="ignore"):
        moved: Array = rows + (goal - mean)
    return moved


def _climb(observable: str, samples: list[Sample]) -> list[_Rung]:
    """Rows of each rung for all realizations: those of the rung below, corrected by the known differences."""
    count = len(samples[0].rows)
    ladder: list[_Rung] = []

    def corrected(rows: Array, coarse: Sample, fine: Sample) -> Array:
        values = OBSERVABLES[observable].of_level(fine)
        if len(values) == count:
            return values
        change = values - OBSERVABLES[observable].of_level(coarse.at(fine.rows))
        mean = change.mean(axis=0)
        result: Array = rows + mean
        result[fine.rows] += count / len(change) * (change - mean)
        return result

    for sample in samples:
        if ladder and sample.q_max <= ladder[-1].sample.q_max * (1 + 1e-9):
            rung = ladder[-1]
            partner = corrected(rung.rows, rung.sample, sample)
            ladder[-1] = rung._replace(partner=partner, refined=sample.side / rung.sample.side)
        elif ladder:
            ladder.append(_Rung(sample, corrected(ladder[-1].rows, ladder[-1].sample, sample), None, 1.0))
        else:
            ladder.append(_Rung(sample, OBSERVABLES[observable].of_level(sample), None, 1.0))
    return ladder


def _patterns(samples: list[Sample]) -> NDArray[np.intp]:
    """Number of finer levels that each realization has: levels are nested, so that it names the pattern."""
    count = np.zeros(len(samples[0].rows), dtype=np.intp)
    for sample in samples[1:]:
        count[sample.rows] += 1
    return count


def _at_top(ladder: list[_Rung], order: float, unlimited: bool) -> tuple[Array, Array, Array]:
    """Mean, finest and the error of the pixel at the highest cut-off."""
    top = ladder[-1]
    rung = next((rung for rung in reversed(ladder) if rung.partner is not None), None)
    if rung is None or rung.partner is None:
        return top.rows, top.rows, np.full(top.rows.shape[1:], nan)
    finest = rung.partner if rung is top else top.rows
    change = rung.partner - rung.rows
    left = change * (_whole(order, rung.refined) - 1.0)
    with np.errstate(all="ignore"):
        carried = np.where(rung is top, 1.0, top.rows.mean(axis=0) / rung.rows.mean(axis=0))
        carried = np.where(np.any(change, axis=0), carried, 0.0)  # 0/0 where nothing yields
        if unlimited:  # the relative change is taken over, and nothing corrected
            share = np.abs((change + left).mean(axis=0) / rung.rows.mean(axis=0))
            return finest, finest, share * np.abs(finest.mean(axis=0))
        if isnan(order):
            return top.rows + carried * change, finest, np.abs((carried * (change + left)).mean(axis=0))
        mean = top.rows + carried * (change + left)
        return mean, finest, np.abs((carried * left).mean(axis=0))


def _whole(order: float, refined: float) -> float:
    """What a vanishing pixel changes over what a pixel so many times finer does."""
    return _TURNING if isnan(order) else 1.0 / (1.0 - refined**-order)


def _shaped_remainder(ladder: list[_Rung], top: Array, theory: Array) -> tuple[Array, Array]:
    """What follows up to the end, with the theory's shape, and the doubt about it.

    It is as much of what follows in the theory as the last step was; with one rung, as the value itself is.
    """
    with np.errstate(all="ignore"):
        follows = np.where(theory[-1] == theory[-2], 0.0, theory[-1] - theory[-2])  # both infinite at rest
        in_proportion = remainder = np.where(follows == 0.0, 0.0, top * (follows / theory[-2]))
        doubt = np.abs(in_proportion.mean(axis=0))
        if len(ladder) > 1:
            step = ladder[-1].rows - ladder[-2].rows
            remainder = np.where(follows == 0.0, 0.0, step * (follows / (theory[-2] - theory[-3])))
            size, other = remainder.mean(axis=0), in_proportion.mean(axis=0)
            doubt = np.maximum(np.abs(size - other), DOUBT_OF_SHAPE * np.abs(size))
        told = np.abs(remainder.mean(axis=0)) <= _MOST_OF_SHAPE * np.abs(top.mean(axis=0))
    return np.where(told, remainder, 0.0), np.where(told, doubt, nan)


def _remainder(ladder: list[_Rung], end: float, settled: float, usual: float) -> tuple[Array, Array, Array]:
    """Exponent, the rows that lead from the top rung to the limit, and the doubt about them."""
    cutoffs, rows = [rung.sample.q_max for rung in ladder[-3:]], [rung.rows for rung in ladder[-3:]]
    step = rows[-1] - rows[-2]
    expected = np.full(step.shape[1:], usual)
    unfitted = step * _factor(cutoffs, end, expected)
    if len(ladder) == 2:
        return expected, unfitted, _DOUBT_UNFITTED * np.abs(unfitted.mean(axis=0))
    fitted, scatter = fitted_exponent(cutoffs, rows, usual), _scatter_of_exponent(cutoffs, rows, usual)
    # the less the steps tell of the exponent, the more it is drawn to the usual one
    trust = np.where(np.isfinite(scatter).all(axis=0), 1.0, 0.0)
    scatter = np.where(trust, scatter, 0.0)
    trust /= 1.0 + (scatter**2).sum(axis=0) / (len(scatter) * _USUAL) ** 2
    exponent, small = usual + trust * (fitted - usual), 1e-5
    slope = (_factor(cutoffs, end, exponent + small) - _factor(cutoffs, end, exponent - small)) / (2.0 * small)
    remainder = step * _factor(cutoffs, end, exponent) + step.mean(axis=0) * slope * trust * scatter
    size, other = (np.abs(x.mean(axis=0)) for x in (remainder, unfitted))
    least = np.maximum(_DOUBT_FITTED, _DOUBT_UNFITTED * np.sqrt(1.0 - trust))
    doubt = np.maximum(np.abs(size - other), least * size)
    low = (fitted < _LEAST * usual) | (cutoffs[0] < 0.95 * settled)
    fit = np.abs((step * _factor(cutoffs, end, fitted)).mean(axis=0))
    widest = np.maximum(_WIDER * np.abs(fit - other), _DOUBT_UNFITTED * other)
    return (
        np.where(low, usual, exponent),
        np.where(low, unfitted, remainder),
        np.where(low, widest, doubt),
    )


def _factor(cutoffs: list[float], end: float, p: Array) -> Array:
    """What follows up to the end, over the last step."""
    return np.asarray((1.0 - (cutoffs[-1] / end) ** p) / ((cutoffs[-1] / cutoffs[-2]) ** p - 1.0))


def _scatter_of_exponent(cutoffs: list[float], rows: list[Array], usual: float) -> Array:
    """Influence of each realization on the fitted exponent, zero in the mean; NaN where none can be fitted."""
    first, second = rows[0] - rows[1], rows[1] - rows[2]
    fall, last = first.mean(axis=0), second.mean(axis=0)
    p, small = fitted_exponent(cutoffs, rows, usual), 1e-5
    with np.errstate(all="ignore"):
        quotient = fall / last
        of_quotient = ((first - fall) - quotient * (second - last)) / last
        of_exponent = (_steps(cutoffs, p + small) - _steps(cutoffs, p - small)) / (2.0 * small)
        fits = np.abs(_steps(cutoffs, p) / quotient - 1.0) < 1e-6
        return np.where(fits, of_quotient / of_exponent, nan)


def _steps(cutoffs: list[float], p: Array) -> Array:
    """The first over the second step of c q_c^(−p) at three cut-offs."""
    x, y, z = (np.asarray((q / cutoffs[0]) ** -p) for q in cutoffs)
    return np.asarray((x - y) / (y - z))


def _pixel_of_limit(ladder: list[_Rung], order: float) -> Array:
    """The error of the pixel in the extrapolated value: what a finer pixel changes on lower rungs, less by 1/q_c.

    Most of it goes with 1/q_c and is extrapolated away; two partners on successive rungs show what is left.
    """
    q_top = ladder[-1].sample.q_max
    for below, rung in reversed(list(pairwise(ladder))):
        if below.partner is not None and rung.partner is not None:
            weight = 1.0 / (rung.sample.q_max / below.sample.q_max - 1.0)
            change = (1.0 + weight) * (rung.partner - rung.rows) - weight * (below.partner - below.rows)
            scale = rung.sample.q_max / q_top * _whole(order, rung.refined)
            return np.asarray(scale * np.abs(change.mean(axis=0)))
    for rung in reversed(ladder):
        if rung.partner is not None:
            scale = np.sqrt(rung.sample.q_max / q_top) * _whole(order, rung.refined)
            return np.asarray(scale * np.abs((rung.partner - rung.rows).mean(axis=0)))
    return np.full(ladder[-1].rows.shape[1:], nan)


def fitted_exponent(cutoffs: list[float], values: list[Array], usual: float = 1.0) -> Array:
    """Return p of T∞ + c q_c^(−p) through the means at three cut-offs, per speed.

    Between 0.3 and 3; the usual one where the means allow none.
    """
    means = np.stack([np.mean(v, axis=0) for v in values], axis=-1)
    return np.array([_exponent(cutoffs, usual, *map(float, row)) for row in means])


def _exponent(cutoffs: list[float], usual: float, a: float, b: float, c: float) -> float:
    if not (a - b) * (b - c) > 0.0:
        return usual

    def excess(p: float) -> float:
        return float(_steps(cutoffs, np.asarray(p)) - (a - b) / (b - c))

    low, high = excess(0.3), excess(3.0)
    return float(brentq(excess, 0.3, 3.0)) if low * high <= 0.0 else usual


__all__ = ["DOUBT_OF_SHAPE", "NO_LIMIT", "Values", "fitted_exponent", "observe"]
