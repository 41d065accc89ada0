"""Rounds made by hand: their levels, with known scatter and other errors, and the members that take least work."""

from dataclasses import replace

import numpy as np
from scipy import stats

from roughsim.estimate.errors import estimate
from roughsim.estimate.mean import Mean
from roughsim.estimate.rounds import MEMBER, judge, replay
from roughsim.scene.numerics import Level, Numerics

LENGTH, POINTS = 1e-3, 32


def numerics_of(*columns, rungs=3, refined=(0,), slide=None):
    """Numerics whose columns have doubling cut-offs, then refined of these rungs; levels count through the columns."""
    levels = []
    for column in columns:
        points = [POINTS * 2**k for k in range(rungs)]
        own = [Level(column, (n, n), np.pi * n / LENGTH / 2) for n in points]
        own += [replace(own[k], shape=(2 * points[k],) * 2) for k in refined]
        levels += own
    if slide is not None:
        levels.append(Level("sliding", (POINTS, POINTS), levels[0].q_max, first=slide))
    return Numerics(tuple(levels), (LENGTH, LENGTH))


ONE = numerics_of("elastic")  # rungs 0, 1, 2 and the partner 3 of 0


def column_values(numerics, column, counts, scatter, *, mean=2.0, **errors):
    """Values of a column whose levels have these relative standard deviations by a member, (speeds,) or one number.

    `errors` are relative: bandwidth, pixel, last_step.
    """
    rows = {}
    mean = np.atleast_1d(np.asarray(mean, dtype=float))
    for level in numerics.of_column(column):
        n = counts[level]
        if n:
            pattern = np.linspace(-1.0, 1.0, n) if n > 1 else np.zeros(1)
            share = pattern / (np.linalg.norm(pattern) or 1.0) * np.sqrt(n - 1.0) / n
            rows[numerics.stream(level)] = np.outer(share, scatter[level] * mean)
    parts = {name: np.abs(mean) * errors.get(name, 0.0) for name in ("bandwidth", "pixel")}
    parts["last step"] = np.abs(mean) * errors.get("last_step", 0.0)
    return Mean(mean, mean, rows, parts)


def totals_of(numerics, scatter, *, size=0.0, **errors):
    """Totals of any observable, of all columns alike."""

    def totals(observable, column, counts):
        values = column_values(numerics, column, counts, scatter, **errors)
        return values, estimate(observable, values.with_errors(size=size))

    return totals


def cost(numerics, level):
    """Modelled cost of a member: what any takes, and points^1.25 of its grid and of the grid below."""
    grids = [numerics.levels[level]] if numerics.below(level) is None else []
    if numerics.below(level) is not None:
        grids = [numerics.levels[level], numerics.levels[numerics.below(level)]]
    return MEMBER + sum((grid.shape[0] * grid.shape[1]) ** 1.25 for grid in grids)


def quantile_of(parts, counts, times=1.0):
    """Half-width over standard error: Student's t, of Satterthwaite's degrees of freedom, for runs that stop.

    `times` as many degrees of freedom as these members have.
    """
    variances = {level: parts[level] ** 2 / counts[level] for level in parts if counts[level]}
    worth = sum(v**2 / (counts[level] - 1) for level, v in variances.items())
    freedom = times * sum(variances.values()) ** 2 / worth
    return stats.t.ppf(0.975, freedom) * np.sqrt(1.0 + 2.0 / freedom)


SCATTER = {0: 0.3, 1: 0.1, 2: 0.05, 3: 0.02}


def least_work(numerics, counts, goal, scatter=SCATTER):
    """N_l ∝ √(V_l/C_l) so that z² Σ V_l/N_l is goal², with the z of as many degrees of freedom as it takes."""
    used = [level for level in scatter if counts[level]]
    error = np.sqrt(sum(scatter[level] ** 2 / counts[level] for level in used))
    times = (quantile_of(scatter, counts) * error / goal) ** 2
    z = quantile_of(scatter, counts, max(times, 1.0))
    ratio = {level: scatter[level] / np.sqrt(cost(numerics, level)) for level in used}
    scale = (z / goal) ** 2 * sum(scatter[level] ** 2 / ratio[level] for level in used)
    return {level: scale * ratio[level] for level in used}


def half_width(counts, scatter=SCATTER):
    used = [level for level in scatter if counts[level]]
    return quantile_of(scatter, counts) * np.sqrt(
        sum(scatter[level] ** 2 / counts[level] for level in used)
    )


def run(numerics, until, most, totals, available=10**9):
    return replay(
        numerics,
        most,
        (available,) * len(numerics.levels),
        lambda c: judge(numerics, until, most, c, totals),
    )
