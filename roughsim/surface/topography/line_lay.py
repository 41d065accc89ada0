"""The lay of a face by line scans in several directions.

A face with a lay γ has the structure function D(r) = ⟨(h(x + r) − h(x))²⟩ of an isotropic one at r√f, with
f = cos²δ/γ + γ sin²δ of the angle δ from the grooves. So lines have equal D at lags r with equal r√f.
"""

from collections.abc import Sequence
from math import cos, cosh, degrees, exp, log, pi, remainder, sin, sinh, sqrt
from typing import Any, NamedTuple

import numpy as np

from roughsim.grid import Array

_LEVELS = 24  # of D, at which lags are compared
_LAGS, _LONGEST = 60, 8  # lags of a line, up to this part of its length
_APART = pi / 6  # radians: two directions closer to each other give no lay
_SAME = pi / 36  # and closer ones are the same


class Line(NamedTuple):
    """A levelled line scan."""

    heights: Array  # m
    length: float  # m
    angle: float  # radians from x


def stretch(lay: float, angle: float) -> float:
    """Return √f at an angle from the grooves, radians: distances along it on the isotropic face over those on this."""
    return sqrt(cos(angle) ** 2 / lay + lay * sin(angle) ** 2)


def lay_of_lines(lines: Sequence[Line]) -> tuple[float, float]:
    """Return γ ≥ 1 and the angle of the grooves, radians, by the mean of ln r at equal D.

    With two directions the grooves are taken along the one with longer lags. ValueError without two directions 30°
    apart, or without a common D.
    """
    apart = max(_between(one.angle, lines[0].angle) for one in lines)
    apart = max(apart, *(_between(one.angle, two.angle) for one in lines for two in lines))
    if apart < _APART:
        raise ValueError(
            f"topography_direction has angles up to {degrees(apart):.3g}° apart; a lay needs line scans at 30° or more, "
            "best along and across the grooves; remove it for a face that is alike in all directions"
        )
    curves = [_structure(line) for line in lines]
    low = max(curve[1][0] for curve in curves)
    high = min(curve[1][-1] for curve in curves)
    if not low < high:
        raise ValueError(
            "the line scans have no roughness in common: one is smoother over its whole length than another over one "
            "step; take scans of one face with like steps"
        )
    levels = np.linspace(low, high, _LEVELS)
    lags = np.array([np.interp(levels, curve[1], curve[0]).mean() for curve in curves])
    angles = np.array([line.angle for line in lines])
    first = angles[0]
    near = np.array([_between(angle, first) < _SAME for angle in angles])
    other = angles[~near][0]
    if all(_between(angle, other) < _SAME for angle in angles[~near]):
        ratio = exp(lags[near].mean() - lags[~near].mean())
        grooves, square = (first, ratio**2) if ratio >= 1.0 else (other, ratio**-2)
        across = sin(other - first) ** 2
        return sqrt(1.0 + (square - 1.0) / across), grooves % pi
    return _fitted(lags, angles)


def _between(one: float, other: float) -> float:
    """Return the angle between two lines, radians, 0 to π/2."""
    return abs(remainder(one - other, pi))


def _structure(line: Line) -> tuple[Array, Array]:
    """Return ln r, m, and ln D, m², which does not fall."""
    points = line.heights.size
    variance = float(np.var(line.heights))
    places = np.geomspace(1, points // _LONGEST, _LAGS)
    lags = np.unique(np.rint(places).astype(int))
    squares = [np.mean((line.heights[lag:] - line.heights[:-lag]) ** 2) for lag in lags]
    # up to half of its limit 2⟨h²⟩, where lags scatter
    rising = np.maximum.accumulate(np.maximum(squares, 1e-300))
    rising = np.minimum(rising, variance)
    last = 1 + int(np.argmax(rising))
    return np.log(lags[:last] * (line.length / points)), np.log(rising[:last])


def _fitted(lags: Array, angles: Array) -> tuple[float, float]:
    """Return γ and the angle of the grooves of mean ln r in three directions or more, by least squares."""
    from scipy.optimize import minimize  # slow to import

    def loss(place: Array) -> float:
        size = float(np.hypot(*place))
        turned = 2.0 * angles - np.arctan2(place[1], place[0])
        ln_f = np.log(cosh(size) - sinh(size) * np.cos(turned))
        return float(np.var(lags + 0.5 * ln_f))

    turns = np.arange(8) * (pi / 4)
    starts = [log(3.0) * np.array([np.cos(turn), np.sin(turn)]) for turn in turns]
    options: Any = {"xatol": 1e-6, "fatol": 1e-14}
    found = [minimize(loss, start, method="Nelder-Mead", options=options) for start in starts]
    best = min(found, key=lambda one: float(one.fun)).x
    turn = float(np.arctan2(best[1], best[0]))
    return exp(float(np.hypot(*best))), turn / 2.0 % pi
