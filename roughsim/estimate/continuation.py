"""From the rungs of a ladder to what follows beyond its highest cut-off: with the theory's shape, by a power, or a law.

A rung is one cut-off, as `roughsim.estimate.ladder` has it. Each way gives a remainder for each realization, so that
the scatter of the rungs goes into the statistical error. The error of the remainder itself is that of the bandwidth.
"""

from math import exp, log, nan
from typing import NamedTuple

import numpy as np

from roughsim.grid import Array
from roughsim.observables.record import Sample
from roughsim.observables.special import stdtrit

# where the lowest rung stands at 4 q_y or above, fitted exponents were 0.9…1.4 for H = 0.8, 0.4…0.8 for H = 0.3, and a
# fifth of the remainder was left over in 19 of 20 cases; without a fit half of it is in doubt
DOUBT_FITTED, DOUBT_UNFITTED = 0.2, 0.5
USUAL_SCATTER = 0.3  # how far exponents lie from the usual one
# exponents below that part of the usual one are mostly of rungs that stand too low: the usual one is taken instead, and
# what the fit has beyond it is the doubt, with a quarter to spare
LEAST_EXPONENT, WIDER = 0.7, 1.25
# what the law for contact that yields leaves in doubt: the smaller of a share of the value and of one of what follows
# after it, and a share of that in any case
DOUBT_OF_LAW = (0.005, 0.15, 0.07)
# the doubt about a remainder with the theory's shape held in 156 of 158 comparisons on six ladders, many of them on the
# same surfaces (H = 0.3…0.95, rubber and rock), a quarter of it alone in 119; beyond half of the value none was tried
DOUBT_OF_SHAPE, MOST_OF_SHAPE = 0.25, 0.5
STEP = 1e-5  # of an exponent, for derivatives by central differences


class Rung(NamedTuple):
    """A cut-off: its level, values of all realizations (n, speeds), and those of its partner, `refined` times finer."""

    sample: Sample
    rows: Array
    partner: Array | None = None
    refined: float = 1.0


def remainder_by_theory(ladder: list[Rung], top: Array, theory: Array) -> tuple[Array, Array]:
    """Return the rows that lead from the top rung to the end with the theory's shape, and their error, (speeds,)."""
    with np.errstate(all="ignore"):
        follows = np.where(theory[-1] == theory[-2], 0.0, theory[-1] - theory[-2])  # both infinite at rest
        # one rung: as much of what follows in the theory as the value is of the theory's; all of it is in doubt
        in_proportion = remainder = np.where(follows == 0.0, 0.0, top * (follows / theory[-2]))
        error = np.abs(in_proportion.mean(axis=0))
        if len(ladder) > 1:  # as much of it as the last step was of the theory's
            step = ladder[-1].rows - ladder[-2].rows
            remainder = np.where(follows == 0.0, 0.0, step * (follows / (theory[-2] - theory[-3])))
            size, other = remainder.mean(axis=0), in_proportion.mean(axis=0)
            error = np.maximum(np.abs(size - other), DOUBT_OF_SHAPE * np.abs(size))
        tried = np.abs(remainder.mean(axis=0)) <= MOST_OF_SHAPE * np.abs(top.mean(axis=0))
    return np.where(tried, remainder, 0.0), np.where(tried, error, nan)


def remainder_by_power(ladder: list[Rung], end: float, settled: float, usual: float) -> tuple[Array, Array, Array]:
    """Return the exponent, the rows that lead from the top rung to the limit, and their error; c q_c^(−p) falls."""
    cut_offs, rows = [rung.sample.q_max for rung in ladder[-3:]], [rung.rows for rung in ladder[-3:]]
    step = rows[-1] - rows[-2]

    def remainder_per_step(p: Array) -> Array:
        return np.asarray((1.0 - (cut_offs[-1] / end) ** p) / ((cut_offs[-1] / cut_offs[-2]) ** p - 1.0))

    expected = np.full(step.shape[1:], usual)
    unfitted = step * remainder_per_step(expected)
    if len(ladder) == 2:
        return expected, unfitted, DOUBT_UNFITTED * np.abs(unfitted.mean(axis=0))
    fitted = fitted_exponent(cut_offs, rows, usual)
    influence = influence_on_exponent(cut_offs, rows, fitted)
    # the less the steps show of the exponent, by its scatter, the more it is drawn to the usual one
    trust = np.where(np.isfinite(influence).all(axis=0), 1.0, 0.0)
    influence = np.where(trust, influence, 0.0)
    trust /= 1.0 + (influence**2).sum(axis=0) / (len(influence) * USUAL_SCATTER) ** 2
    exponent = usual + trust * (fitted - usual)
    # each row has its own influence on the exponent, so that the statistical error has that of the fit in it
    slope = (remainder_per_step(exponent + STEP) - remainder_per_step(exponent - STEP)) / (2.0 * STEP)
    remainder = step * remainder_per_step(exponent) + step.mean(axis=0) * slope * trust * influence
    size, other = (np.abs(x.mean(axis=0)) for x in (remainder, unfitted))
    least = np.maximum(DOUBT_FITTED, DOUBT_UNFITTED * np.sqrt(1.0 - trust))
    error = np.maximum(np.abs(size - other), least * size)
    # rungs that stand too low fit too small an exponent: the usual one is taken, and the fit goes into the error
    low = (fitted < LEAST_EXPONENT * usual) | (cut_offs[0] < 0.95 * settled)
    fit = np.abs((step * remainder_per_step(fitted)).mean(axis=0))
    widest = np.maximum(WIDER * np.abs(fit - other), DOUBT_UNFITTED * other)
    return np.where(low, usual, exponent), np.where(low, unfitted, remainder), np.where(low, widest, error)


def the_surer(power: tuple[Array, Array, Array], ladder: list[Rung], law: Array) -> tuple[Array, Array, Array]:
    """Return exponent (NaN by the law), remainder and error of the surer of two ways: a power, or a constant ratio.

    The surer one has the smaller sum of squares of its error and of the scatter that it gives the limit. `law` as in
    `observe`, measured/law is constant. The rungs may refute it: what that has changed over the last step, at the worst
    speed, is part of its error. Where both ways lie further apart than their errors and scatter allow, the power stays,
    and the distance is the error.
    """
    (exponent, remainder, error), below, top = power, ladder[-2].rows, ladder[-1].rows
    mean = top.mean(axis=0)
    with np.errstate(all="ignore"):  # 0/0 at rest, where nothing follows
        by_law = top * (law[2] / law[1] - 1.0)
        change = np.nan_to_num((mean * (law[0] / law[1]) - below.mean(axis=0)) / mean)
    doubt = doubt_of_law(mean, by_law.mean(axis=0), np.abs(change).max() * mean)
    apart = np.abs((remainder - by_law).mean(axis=0))
    scatter, of_power, of_law = (
        rows.std(axis=0) / np.sqrt(len(top)) for rows in (remainder - by_law, top + remainder, top + by_law)
    )
    contrary = apart > np.linalg.norm([error, doubt, 2.0 * scatter], axis=0)
    wide = stdtrit(max(len(ladder[-1].sample.rows) - 1, 1), 0.975)  # few realizations have the highest rung
    chosen = (np.hypot(doubt, wide * of_law) < np.hypot(error, wide * of_power)) & ~contrary
    surest = np.where(contrary, apart, np.where(chosen, doubt, error))
    return np.where(chosen, nan, exponent), np.where(chosen, by_law, remainder), surest


def doubt_of_law(value: Array, follows: Array, change: Array) -> Array:
    """Return the error of what follows after a value by the law, where value/law has changed by `change` before."""
    of_value, least, share = DOUBT_OF_LAW
    parts = np.minimum(of_value * np.abs(value), least * np.abs(follows)), share * follows, change
    return np.asarray(np.linalg.norm(parts, axis=0))


def fitted_exponent(cut_offs: list[float], values: list[Array], usual: float = 1.0) -> Array:
    """Return p of T∞ + c q_c^(−p) through the means at three cut-offs, per speed.

    Between 0.3 and 3; the usual one where the means allow none.
    """
    x, y, z = (-log(q / cut_offs[0]) for q in cut_offs)

    def quotient(p: float) -> float:
        return (exp(p * x) - exp(p * y)) / (exp(p * y) - exp(p * z))

    exponents = []
    for a, b, c in zip(*(np.mean(rows, axis=0).tolist() for rows in values), strict=True):
        exponent = usual
        if (a - b) * (b - c) > 0.0 and quotient(low := 0.3) <= (wanted := (a - b) / (b - c)) <= quotient(high := 3.0):
            while low < (exponent := 0.5 * (low + high)) < high:  # the quotient rises with p: down to the last bit
                low, high = (exponent, high) if quotient(exponent) < wanted else (low, exponent)
        exponents.append(exponent)
    return np.array(exponents)


def influence_on_exponent(cut_offs: list[float], rows: list[Array], p: Array) -> Array:
    """Return the influence of each realization on the fitted exponent p, zero in the mean; NaN where p is no fit."""
    first, second = rows[0] - rows[1], rows[1] - rows[2]
    first_mean, second_mean = first.mean(axis=0), second.mean(axis=0)
    with np.errstate(all="ignore"):
        quotient = first_mean / second_mean
        of_quotient = ((first - first_mean) - quotient * (second - second_mean)) / second_mean
        slope = (quotient_of_steps(cut_offs, p + STEP) - quotient_of_steps(cut_offs, p - STEP)) / (2.0 * STEP)
        fits = np.abs(quotient_of_steps(cut_offs, p) / quotient - 1.0) < 1e-6
        return np.where(fits, of_quotient / slope, nan)


def quotient_of_steps(cut_offs: list[float], p: Array) -> Array:
    """Return the first over the second step of c q_c^(−p) at three cut-offs."""
    x, y, z = (np.asarray((q / cut_offs[0]) ** -p) for q in cut_offs)
    return np.asarray((x - y) / (y - z))
