"""Periodic maps, removal of short waves and its overshoots, and the twin of a map with random phases."""

from math import ceil

import numpy as np

from roughsim.grid import Array, Grid, Mask


def mirrored(heights: Array) -> Array:
    """Return the map with its mirror images along x, along y and along both: periodic, and without a step.

    At the edges of the map the slope across them changes its sign.
    """
    along_x = np.concatenate([heights, heights[::-1]])
    return np.concatenate([along_x, along_x[:, ::-1]], axis=1)


def periodic_part(heights: Array) -> Array:
    """Return a map less the smooth surface that has its steps at the edges, so that it is periodic without a step.

    The discrete Laplacian of that surface is the step between opposite edges, and zero inside (Moisan, Journal of
    Mathematical Imaging and Vision 39, 161, 2011). No point is weighted less than others, as it is under a window.
    """
    steps = np.zeros_like(heights)
    for axis in (0, 1):
        edges = np.moveaxis(steps, axis, 0)
        rows = np.moveaxis(heights, axis, 0)
        edges[0] += rows[-1] - rows[0]
        edges[-1] += rows[0] - rows[-1]
    x, y = (2.0 * np.cos(2.0 * np.pi * np.arange(n) / n) for n in heights.shape)
    laplacian = x[:, None] + y[: heights.shape[1] // 2 + 1] - 4.0
    laplacian[0, 0] = 1.0  # of q = 0: the steps are zero
    smooth = np.fft.rfft2(steps) / laplacian
    smooth[0, 0] = 0.0
    return heights - np.fft.irfft2(smooth, heights.shape)


def gaussian_twin(heights: Array, rng: np.random.Generator) -> Array:
    """Return a map with the same |h(q⃗)| at each wavevector as a periodic map, and random phases.

    With many waves its heights are Gaussian; its lay is the lay of the map. The phases come from white noise, whose
    transform has h(−q⃗) = h*(q⃗), so that heights are real; q = 0 keeps its own.
    """
    modes = np.fft.rfft2(heights)
    noise = np.fft.rfft2(rng.standard_normal(heights.shape))
    turned = np.abs(modes) * noise / np.abs(noise)
    turned[0, 0] = modes[0, 0]
    return np.fft.irfft2(turned, heights.shape)


def refined(heights: Array, shape: tuple[int, int]) -> Array:
    """Return all waves of a periodic map on a grid of more points in the same cell, by padding its modes with zeros.

    Waves at the Nyquist wavenumber are halved between both signs, so that the map keeps its heights at its own points.
    """
    import scipy.signal  # slow to import

    for axis, count in enumerate(shape):
        heights = np.asarray(scipy.signal.resample(heights, count, axis=axis))
    return heights


def band_limited(heights: Array, grid: Grid, shape: tuple[int, int], q_max: float) -> Array:
    """Return the waves of a periodic map up to `q_max`, rad/m, on a grid of another shape in the same cell.

    `heights` are of `grid.shape`. At the Nyquist wavenumber of the map all of its waves are kept, for a grid of as many
    points or more; else `q_max` is below the Nyquist wavenumbers of both grids, so that no wave is lost.
    """
    if q_max >= grid.nyquist * (1 - 1e-9):
        return refined(heights, shape)
    modes = np.fft.rfft2(heights)
    modes[grid.wavenumbers > q_max * (1 + 1e-9)] = 0.0
    nx, ny = shape
    kept = np.zeros((shape[0], shape[1] // 2 + 1), complex)
    rows = min(nx, grid.shape[0]) // 2
    columns = min(ny, grid.shape[1]) // 2
    kept[:rows, :columns] = modes[:rows, :columns]
    kept[-rows:, :columns] = modes[-rows:, :columns]
    kept *= nx * ny / grid.points
    return np.fft.irfft2(kept, shape)


def overshoots(surface: Array, heights: Array, grid: Grid, q_max: float) -> Mask:
    """Return the mask of overshoots: points at which waves up to `q_max` exceed by far the map around them.

    `surface` is `band_limited` of `heights`. Waves of a spike go up and down beside it. Far is twice the median step
    between neighbouring points: Gaussian maps of H = 0.3 to 0.8 up to the Nyquist wavenumber are at most 1.3 above,
    and 1.5 with flattened tops; beside a spike 20 rms deep they are 10 to 30.
    """
    from scipy.ndimage import maximum_filter  # slow to import

    # points: up to half the shortest wave on both sides
    around = 2 * ceil(grid.nyquist / q_max * (1 - 1e-9))
    highest = maximum_filter(heights, around, origin=-1, mode="wrap")
    shapes = zip(surface.shape, heights.shape, strict=True)
    rows, columns = (np.arange(new) * old // new for new, old in shapes)
    along_both = [np.diff(heights, axis=axis).ravel() for axis in (0, 1)]
    steps = np.abs(np.concatenate(along_both))
    far = 0.0
    if steps.any():
        far = 2.0 * float(np.median(steps[steps > 0.0]))
    excess = surface - highest[np.ix_(rows, columns)]
    return excess > far
