"""A root of a function of one number, by Brent's method.

Every step is the one of `scipy.optimize.brentq`, so that the results are the same to the last bit. Importing
scipy.optimize for it takes a sixth of the time in which a command of roughsim starts.
"""

from collections.abc import Callable
from math import copysign, inf, isnan

import numpy as np

_MOST = 100  # steps; halving alone takes some 60
_ROUNDING = 4 * float(np.finfo(float).eps)


def root(
    function: Callable[[float], float],
    low: float,
    high: float,
    *,
    accuracy: float,
    relative: float = _ROUNDING,
) -> float:
    """Return a root of a continuous function between `low` and `high`.

    Parameters
    ----------
    function : callable
        Of one number; its values at both ends have different signs, or one is zero.
    low, high : float
        Ends of the interval.
    accuracy, relative : float
        The error is at most `accuracy` plus `relative` times the root.

    Returns
    -------
    float
        Place of the root.

    Raises
    ------
    ValueError
        If the function has one sign at both ends, or is NaN somewhere.
    RuntimeError
        If a hundred steps do not reach the accuracy: the root is of a high order.
    """
    before, now = low, high  # the last two places
    before_value, value = _number(function, low), _number(function, high)
    if before_value == 0.0:
        return low
    if min(before_value, value) > 0.0 or max(before_value, value) < 0.0:
        raise ValueError(
            f"the function is {before_value:.6g} at {low:.6g} and {value:.6g} at {high:.6g}; the signs must differ"
        )
    across, across_value = before, before_value  # the root lies between `across` and `now`
    step = last_step = now - before
    for _ in range(_MOST):
        if (before_value < 0.0) != (value < 0.0):
            across, across_value = before, before_value
            step = last_step = now - before
        if abs(across_value) < abs(value):
            before, now, across = now, across, now
            before_value, value, across_value = value, across_value, value
        least = (accuracy + relative * abs(now)) / 2
        half = (across - now) / 2
        if value == 0.0 or abs(half) < least:
            return now
        tried = inf
        if abs(last_step) > least and abs(value) < abs(before_value):
            if before == across:
                way = -value * (now - before)
                slope = value - before_value
            else:  # through all three places
                fall = (before_value - value) / (before - now)
                fall_across = (across_value - value) / (across - now)
                way = -value * (across_value * fall_across - before_value * fall)
                slope = fall_across * fall * (across_value - before_value)
            tried = way / slope if slope else inf  # 0 where small values underflow
        # it must stay well inside, and be shorter than half of the last step but one
        if 2 * abs(tried) < min(abs(last_step), 3 * abs(half) - least):
            last_step, step = step, tried
        else:
            last_step = step = half
        before, before_value = now, value
        now += step if abs(step) > least else copysign(least, half)
        value = _number(function, now)
    raise RuntimeError(f"no root between {low:.6g} and {high:.6g} in {_MOST} steps")


def _number(function: Callable[[float], float], place: float) -> float:
    """Return the function at a place; ValueError for NaN."""
    value = float(function(place))
    if isnan(value):
        raise ValueError(f"the function is NaN at {place:.6g}")
    return value
