"""The points of a field next to a straight line through a marked point."""

from __future__ import annotations

from math import cos, sin
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughsim.grid import Grid


class Line(NamedTuple):
    """Points of a grid along a line: indices i, j, and distance from its middle, m, positive along the direction."""

    distance: NDArray[np.float64]
    i: NDArray[np.intp]
    j: NDArray[np.intp]


def nearest_point(grid: Grid, x: float, y: float) -> tuple[int, int]:
    """Return the indices of the point of the cell that is next to (x, y), m."""
    i, j = (int(np.clip(round(at / d), 0, n - 1)) for at, d, n in zip((x, y), grid.spacing, grid.shape, strict=True))
    return i, j


def line_through(grid: Grid, point: tuple[int, int], direction: float) -> Line:
    """Return the points next to the line through a point along a direction, rad from axis 0 towards axis 1.

    The line reaches from one side of the cell to the other. Its points are one spacing (the smaller one) apart, so that
    a line along an axis has each point of the grid once.
    """
    unit = np.array([cos(direction), sin(direction)])
    unit[np.abs(unit) < 1e-15] = 0.0
    middle, last = np.array(point, dtype=np.float64), np.array(grid.shape) - 1.0
    pace = unit / np.array(grid.spacing)  # indices per metre
    # distances at which the line meets the four sides; along an axis it meets only two
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = np.sort(np.stack([-middle / pace, (last - middle) / pace]), axis=0)
    ends = ends[:, pace != 0.0]
    step = min(d for d, u in zip(grid.spacing, unit, strict=True) if u != 0.0)
    # whole steps between the sides; 1e-9 keeps a point that lies on a side in spite of rounding
    first, end = np.floor(np.array([ends[0].max(), ends[1].min()]) / step + [1.0 - 1e-9, 1.0 + 1e-9]).astype(int)
    distance = float(step) * np.arange(first, end, dtype=np.float64)
    i, j = (np.rint(middle[k] + pace[k] * distance).astype(np.intp).clip(0, grid.shape[k] - 1) for k in (0, 1))
    return Line(distance, i, j)
