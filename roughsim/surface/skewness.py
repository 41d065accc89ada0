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
    coarse = Grid(thinned.shape, grid.lengths)
    spectrum = fourier.forward(thinned)
    longest = LONG_WAVES * 2 * pi / max(grid.lengths)
    spectrum[(coarse.wavenumbers > longest * (1 + 1e-9)) | (coarse.wavenumbers == 0.0)] = 0.0
    waves = fourier.inverse(spectrum, coarse.shape)
    variance = float((waves**2).mean())
    rounding = 1e-12 * float(np.abs(thinned).max())
    return float((waves**3).mean()) / variance**1.5 if variance > rounding**2 else 0.0
