"""How many realizations a statistical target takes, and for every how many of them the fine levels are solved."""

from __future__ import annotations

from collections.abc import Iterable
from math import inf, sqrt

from roughsim.estimate.errors import quantile
from roughsim.estimate.stop import LEAST, LEAST_FINE
from roughsim.planning.levels import Ladder, Lengths
from roughsim.planning.pilot import work
from roughsim.scene.numerics import Level

STRIDES = tuple(2**k for k in range(10))  # powers of two, so that all fine levels share their realizations


def half_width(count: int, scatter: float, change: float, every: int) -> float:
    """Return the relative 95 % half-width of a mean after `count` realizations.

    `scatter` is the relative standard deviation of the coarsest level, `change` that of the corrections by the fine
    levels, which are solved for one in `every`.
    """
    if count == 1:
        return inf  # one realization shows no scatter
    fine = -(-count // every)
    common, added = scatter**2 / count, change**2 / fine
    doubt = common**2 / (count - 1) + added**2 / max(fine - 1, 1)  # Satterthwaite, as in the estimate
    freedom = min((common + added) ** 2 / doubt, count - 1.0) if doubt > 0.0 else count - 1.0
    return float(quantile(freedom)) * sqrt(common + added)


def realizations_for(goal: float, scatter: float, change: float, every: int) -> int:
    """Return how many realizations bring the half-width to the goal; above 50 in steps of 2 %."""
    count = max(LEAST, (LEAST_FINE - 1) * every + 1)
    while half_width(count, scatter, change, every) > goal and count < 1_000_000_000:
        count += max(1, count // 50)
    return count


def choose_stride(ladder: Ladder, lengths: Lengths, goal: float, scatter: float, change: float, most: int) -> int:
    """Return the cheapest stride of the fine levels that leaves three fine realizations of the `most` allowed."""
    cost: dict[int, float] = {}
    for every in STRIDES:
        count = realizations_for(goal, scatter, change, every)  # all that the goal takes, allowed or not
        if every == 1 or (LEAST_FINE - 1) * every < min(count, most):
            cost[every] = total_work(ladder.levels(lengths, every), count)
    return min(cost, key=cost.__getitem__)


def total_work(levels: Iterable[Level], count: int) -> float:
    """Return the `work` of all solves of so many realizations."""
    return sum(work(level.shape[0] * level.shape[1]) * -(-count // level.every) for level in levels)
