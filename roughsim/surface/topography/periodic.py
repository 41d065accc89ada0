"""Making a map periodic, and leaving its short waves out."""

import numpy as np

from roughsim.grid import Array, Grid


def mirrored(heights: Array) -> Array:
    """Return the map with its mirror images along x, along y and along both: periodic, and without a step.

    At the edges of the map the slope across them changes its sign.
    """
    along_x = np.concatenate([heights, heights[::-1]])
    return np.concatenate([along_x, along_x[:, ::-1]], axis=1)


def band_limited(heights: Array, grid: Grid, shape: tuple[int, int], q_max: float) -> Array:
    """Return the waves of a periodic map up to `q_max`, rad/m, on a grid of another shape in the same cell.

    `heights` are of `grid.shape`; `q_max` is below the Nyquist wavenumber of both grids, so that no wave is lost.
    """
    modes = np.fft.rfft2(heights)
    modes[grid.wavenumbers > q_max * (1 + 1e-9)] = 0.0
    (nx, ny), kept = shape, np.zeros((shape[0], shape[1] // 2 + 1), complex)
    rows, columns = min(nx, grid.shape[0]) // 2, min(ny, grid.shape[1]) // 2
    kept[:rows, :columns] = modes[:rows, :columns]
    kept[-rows:, :columns] = modes[-rows:, :columns]
    kept *= nx * ny / grid.points
    return np.fft.irfft2(kept, shape)
