"""The map of two faces in contact: the sum of their maps."""

from functools import partial
from math import floor

import numpy as np

from roughsim.grid import Array, Grid
from roughsim.surface.topography.measured import levelled
from roughsim.surface.topography.periodic import band_limited, mirrored, refined
from roughsim.surface.topography.reading import Topography


def sum_of_faces(first: Topography, second: Topography) -> Topography:
    """Return the sum of two maps, the second one turned about x, as it faces the first: h₁(x, y) + h₂(x, −y).

    Both are taken about their middles, on the common part of their sides, at the smaller of their steps. A map of
    larger steps is interpolated by a cubic spline, or by its waves if both are periodic with the same sides. Waves of
    a map beyond its own cut-off are left out.
    """
    first = _resolved(first)
    second = _resolved(second)
    turned = second._replace(heights=second.heights[:, ::-1])
    alike = np.allclose(first.grid.lengths, second.grid.lengths, rtol=1e-6)
    periodic = first.periodic and second.periodic and alike
    nx, ny = (max(pair) for pair in zip(first.grid.shape, second.grid.shape, strict=True))
    if periodic:
        grid = Grid((nx, ny), first.grid.lengths)
        heights = refined(first.heights, grid.shape) + refined(turned.heights, grid.shape)
    else:
        grid = _common(first.grid, second.grid)
        heights = _on_grid(first, grid) + _on_grid(turned, grid)
    size = " × ".join(f"{length:.4g}" for length in grid.lengths)
    points = " × ".join(map(str, grid.shape))
    return Topography(
        levelled(heights, periodic),
        grid,
        periodic,
        max(first.reliable, second.reliable),
        max(first.undefined, second.undefined),
        f"sum of both maps about their middles, the second one turned about x: {points} points on {size} m",
    )


def _resolved(face: Topography) -> Topography:
    """Return a face without the waves that its instrument does not resolve."""
    if face.reliable >= face.grid.nyquist:
        return face
    nx, ny = face.grid.shape
    x, y = face.grid.lengths
    if face.periodic:
        heights = band_limited(face.heights, face.grid, face.grid.shape, face.reliable)
    else:
        cell = Grid((2 * nx, 2 * ny), (2 * x, 2 * y))
        heights = band_limited(mirrored(face.heights), cell, cell.shape, face.reliable)[:nx, :ny]
    return face._replace(heights=heights)


def _common(first: Grid, second: Grid) -> Grid:
    """Return the grid of the smaller steps over the smaller distances of the first and the last points."""
    shape = []
    lengths = []
    for axis in (0, 1):
        step = min(first.spacing[axis], second.spacing[axis])
        span = min((one.shape[axis] - 1) * one.spacing[axis] for one in (first, second))
        shape.append(floor(span / step + 1e-6) + 1)
        lengths.append(shape[axis] * step)
    return Grid((shape[0], shape[1]), (lengths[0], lengths[1]))


def _on_grid(face: Topography, grid: Grid) -> Array:
    """Return the heights of a face at the points of a grid with the same middle."""
    from scipy.interpolate import RectBivariateSpline  # slow to import

    old, new = (
        [
            (np.arange(n) - 0.5 * (n - 1)) * step
            for n, step in zip(one.shape, one.spacing, strict=True)
        ]
        for one in (face.grid, grid)
    )
    if face.grid.shape == grid.shape and all(map(partial(np.allclose, rtol=1e-6), old, new)):
        return face.heights
    return RectBivariateSpline(old[0], old[1], face.heights)(new[0], new[1])
