"""The skewness of the long waves of a surface: a number that costs one small transform and says much of its contact."""

from math import pi

import numpy as np

from roughsim import fourier
from roughsim.grid import Array, Grid

LONG_WAVES = 32  # along the longest side of the cell; with 16 to 64, T_flash of steel scatters hardly more around it
ENOUGH_POINTS = 8 * LONG_WAVES  # per side: finer grids are thinned out, as the waves in between are low


def long_wave_skewness(heights: Array, grid: Grid) -> float:
    """Return ⟨h³⟩/⟨h²⟩^(3/2) of the waves of which at most `LONG_WAVES` fit along the longest side of the cell.

    Its mean over surfaces of a power spectrum is exactly zero: −h is as probable as h, and has the opposite skewness.
    Where the peaks of a surface stand out more than its valleys, it is positive, and the contact is made of fewer and
    hotter spots.

    Parameters
    ----------
    heights : ndarray
        h, shape `grid.shape`, m.
    grid : Grid
        The periodic cell.

    Returns
    -------
    float
        The skewness; 0 where there are no such waves.
    """
    steps = [1, 1]
    for axis, points in enumerate(grid.shape):
        while points % (2 * steps[axis]) == 0 and points // (2 * steps[axis]) >= ENOUGH_POINTS:
            steps[axis] *= 2
    thinned = np.ascontiguousarray(heights[:: steps[0], :: steps[1]])
    rounding = 1e-12 * max(float(thinned.max()), -float(thinned.min()))
    # the long waves alone, on a grid where the product of three of them meets no alias at q = 0
    longest = LONG_WAVES * 2 * pi / max(grid.lengths) * (1 + 1e-9)
    most = [int(longest * length / (2 * pi)) for length in grid.lengths]
    coarse = Grid(tuple(min(n, 4 * k + 4) for n, k in zip(thinned.shape, most, strict=True)), grid.lengths)
    rows = np.r_[: coarse.shape[0] - coarse.shape[0] // 2, -(coarse.shape[0] // 2) : 0]
    spectrum = fourier.forward(thinned)[rows, : coarse.half_shape[1]]
    spectrum[(coarse.wavenumbers > longest) | (coarse.wavenumbers == 0.0)] = 0.0
    waves = fourier.inverse(spectrum, coarse.shape)
    squares = waves * waves
    variance = float(squares.mean())
    return float((squares * waves).mean()) / variance**1.5 if variance > rounding**2 else 0.0
