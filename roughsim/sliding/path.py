"""The way of one rough body over another, in whole pixels, slightly oblique to the cell."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughsim.errors import ResolutionError
from roughsim.grid import Grid

# After each length of the cell the path has moved across by this part of its shorter side, so that a wave meets new
# rows. 1/φ⁴: any number of laps spreads evenly over a square cell.
ACROSS = ((math.sqrt(5.0) - 1.0) / 2.0) ** 4
MOST_STEPS = (
    1_000_000  # over a day of CPU time on 64² points; the curves of all steps stay in memory
)
FURTHEST = 1e12  # pixels
COARSER = 0.75  # points along each side of the coarser grid of a slide: 42 % of the work of the slide itself
_ROUNDING = 1e-9


class Path(NamedTuple):
    """Position of the moving body at each step.

    Attributes
    ----------
    offsets : ndarray
        Pixels along x and y that the moving body has been displaced towards −x and −y, shape (steps + 1, 2), from 0.
    distance : ndarray
        Slid distance, m, shape (steps + 1,), in equal steps.
    """

    offsets: NDArray[np.intp]
    distance: NDArray[np.float64]

    @property
    def steps(self) -> int:
        """How many there are; positions are one more."""
        return self.distance.size - 1

    def steps_to(self, distances: ArrayLike) -> list[int]:
        """Return the steps nearest to slid distances, m; the last one for distances beyond it."""
        within = np.minimum(distances, self.distance[-1])
        return np.rint(within / self.distance[1]).astype(int).tolist()


def coarser_grid(grid: Grid, q_max: float) -> Grid | None:
    """Return a grid of 4/3 of the pixel in the same cell; None if it does not resolve waves up to `q_max`, rad/m.

    A slide on it measures the error of pixel and step.
    """
    x, y = (max(1, round(COARSER * n)) for n in grid.shape)
    coarser = Grid((x, y), grid.lengths)
    return coarser if q_max <= coarser.nyquist and min(x, y) < min(grid.shape) else None


def pixel_of_path(grid: Grid) -> float:
    """Return the distance that goes with one pixel along x, m."""
    return grid.spacing[0] * math.hypot(1.0, slope(grid))


def slope(grid: Grid) -> float:
    """Return dy/dx of the path: 8°, or less in a cell that is longer than wide."""
    return ACROSS * min(1.0, grid.lengths[1] / grid.lengths[0])


def oblique_path(
    grid: Grid, slid_distance: float, steps: int | None = None, *, backwards: bool = False
) -> Path:
    """Return the path along x over `slid_distance`, m, to the nearest whole step.

    Each step is a whole number of pixels along x: one, or as many as bring the number of steps nearest to `steps`.
    Across, the direction is straight and each position the nearest pixel to it. ValueError if the distance, or a step,
    would be under a pixel; ResolutionError above `MOST_STEPS`.
    """
    spacing = pixel_of_path(grid)
    pixels = slid_distance / spacing
    if pixels < 1.0 - _ROUNDING:
        raise ValueError(
            f"slid_distance = {slid_distance:.6g} m is under a step of one pixel, {spacing:.6g} m; slide further or "
            "refine the grid"
        )
    if pixels > FURTHEST:
        raise ValueError(
            f"slid_distance = {slid_distance:.6g} m is {pixels:.3g} pixels; double precision resolves at most "
            f"{FURTHEST:g}: slide less far"
        )
    stride = 1
    if steps is not None:
        if steps > pixels + 0.5:
            raise ValueError(
                f"steps = {steps} over {slid_distance:.6g} m would be shorter than one pixel, {spacing:.6g} m; take at "
                f"most {round(pixels)}, or refine the grid"
            )
        stride = max(1, round(pixels / steps))
    if pixels > MOST_STEPS * stride:
        raise ResolutionError(
            f"slid_distance = {slid_distance:.6g} m is {pixels / stride:.3g} steps of {stride * spacing:.4g} m, of "
            f"which {MOST_STEPS} are the most that are followed; slide less far, or for a shorter time"
        )
    along = stride * np.arange(max(1, round(pixels / stride)) + 1, dtype=float)
    across = along * (slope(grid) * grid.spacing[0] / grid.spacing[1])
    offsets = np.rint(np.stack([along, across], axis=1)).astype(np.intp)
    return Path(-offsets if backwards else offsets, along * spacing)
