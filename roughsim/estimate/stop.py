"""The stop rule: a run ends at the first number of realizations at which the mean of every target is sure enough."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from math import inf

import numpy as np

from roughsim.estimate.errors import half_width, spread
from roughsim.estimate.ladder import Values

LEAST = 12  # realizations before a run may stop: below, the scatter itself is too uncertain
LEAST_FINE = 3  # of these with the finest level


def first_sufficient(targets: Callable[[int], Iterable[tuple[Values, float]]], counts: range) -> int | None:
    """Return the first of `counts` at which every observable meets its target, None if at none.

    `targets` gives, for a number of realizations, pairs of an observable's values and its relative 95 % half-width.
    `counts` starts at `LEAST` or above.
    """
    for count in counts:
        if all(relative_half_width(values) <= target for values, target in targets(count)):
            return count
    return None


def relative_half_width(values: Values) -> float:
    """Return the relative 95 % half-width of the mean at the worst speed.

    Infinite for fewer than two rows, and while fewer than `LEAST_FINE` have the finest level: two can agree by chance.
    """
    with_finest = np.count_nonzero(values.group == values.group.max())
    if with_finest < min(LEAST_FINE, len(values.group)):
        return inf
    half = half_width(*spread(values.extrapolated, values.base, values.group))
    mean = np.abs(values.extrapolated.mean(axis=0))
    relative = np.divide(half, mean, out=np.zeros_like(half), where=half > 0.0)
    return float(relative.max())
