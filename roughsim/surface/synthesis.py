"""Random surfaces with a given power spectrum.

The modes are drawn in an order that depends on the cell alone, outwards from the origin. So the same random stream
gives the same surface on every grid: a finer grid or a higher q_max only adds modes. Paired solves rest on this. (A
Nyquist mode stands for two modes of a finer grid and equals neither; a spectrum that ends below it has none.)
"""

from math import pi
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughsim.fourier.plans import transform
from roughsim.grid import Array, Grid, Index, need_grid
from roughsim.surface.modes import mode_variance, remembered
from roughsim.surface.spectrum import Spectrum


def synthesize(
    spectrum: Spectrum,
    grid: Grid,
    rng: np.random.Generator,
    *,
    amplitudes: Literal["fixed", "gaussian"] = "fixed",
) -> Array:
    """Draw a surface whose modes have the variance ∫C d²q over their Fourier cells.

    ResolutionError if C(q) reaches beyond the Nyquist wavenumber; TypeError or ValueError if `rng` is no generator,
    `amplitudes` is neither word, or C(q) is negative or not finite. A RuntimeWarning if C(q) begins below the lowest
    mode of the cell: that part is left out.

    Parameters
    ----------
    spectrum : Spectrum
        C(q), m⁴, with `breaks`; its end must not lie beyond the Nyquist wavenumber of the grid.
    grid : Grid
        The periodic cell.
    rng : numpy.random.Generator
        The random stream; the same stream gives the same surface, whatever the grid.
    amplitudes : {"fixed", "gaussian"}
        "fixed": each mode has exactly its standard deviation as amplitude and a random phase, so rms height and slope
        are the same for every draw. "gaussian": complex normal modes, a Gaussian random field.

    Returns
    -------
    ndarray
        Heights, shape `grid.shape`, m, with mean zero.
    """
    need_grid(grid)
    if not isinstance(rng, np.random.Generator):
        raise TypeError(
            f"rng = {rng!r} must be a numpy Generator; make one with np.random.default_rng(seed)"
        )
    if amplitudes not in ("fixed", "gaussian"):
        raise ValueError(f'amplitudes = {amplitudes!r} must be "fixed" or "gaussian"')
    modes = independent_modes(spectrum, grid)
    count = modes.kept.size
    real = modes.real
    if amplitudes == "gaussian":
        normal = rng.standard_normal((count, 2))[modes.kept]
        values = modes.deviation * ((normal[:, 0] + 1j * normal[:, 1]) * np.sqrt(0.5))
        values[real] = modes.deviation[real] * normal[real, 0]
    else:
        turn = rng.random(count)[modes.kept]
        # cos and sin of the phase 2π·turn by the tangent of its half: NumPy has a vectorized tan, but not these two
        tangent = np.tan(pi * turn)
        square = tangent * tangent
        size = modes.deviation / (1.0 + square)
        values = np.empty(turn.shape, complex)
        values.real = (1.0 - square) * size
        values.imag = 2.0 * tangent * size
        values[real] = np.where(turn[real] < 0.5, modes.deviation[real], -modes.deviation[real])
    # the half spectrum, with the conjugate partners that lie in it
    buffers = transform(grid.shape, np.float64)
    buffers.spectrum[...] = 0.0
    flat = buffers.spectrum.reshape(-1)
    flat[modes.place] = values
    flat[modes.partner] = values[modes.paired].conj()
    return buffers.inverse().copy()


class _DrawnModes(NamedTuple):
    """The independent modes of a surface in the order in which they are drawn."""

    kept: NDArray[
        np.bool_
    ]  # of all modes that are drawn: a Nyquist mode of this grid is two modes of a finer one
    place: Index  # flat place in the half spectrum, of those kept
    paired: Index  # which of them have their conjugate in the half spectrum, too
    partner: Index  # flat places of those conjugates
    real: Index  # which modes are their own conjugates
    deviation: Array  # √variance of one mode of the full plane, m


@remembered  # .02 s for each member of a run, a fifth of its time
def independent_modes(spectrum: Spectrum, grid: Grid) -> _DrawnModes:
    """Return the modes of a surface, one of each conjugate pair, in order of the shortest wavenumber of their cells.

    A cell has variance if q_max lies above that wavenumber, so the modes of a lower q_max come first.
    """
    variance = mode_variance(spectrum, grid)
    nx, ny = grid.shape
    half = grid.half_shape
    # signed indices; a Nyquist mode is listed with both signs, as on a finer grid
    kx, ky = np.divmod(np.flatnonzero(variance), half[1])
    half_plane = (ky > 0) | (2 * kx <= nx)
    kx = kx[half_plane]
    ky = ky[half_plane]
    twins = (2 * kx == nx) & (ky > 0)
    kx = np.concatenate([np.where(2 * kx > nx, kx - nx, kx), -kx[twins]])
    ky = np.concatenate([ky, ky[twins]])
    x = np.maximum(abs(kx) - 0.5, 0) / grid.lengths[0]
    y = np.maximum(ky - 0.5, 0) / grid.lengths[1]
    order = np.lexsort((kx, ky, x * x + y * y))
    kx = kx[order]
    ky = ky[order]
    # their places in the half spectrum, and their partners
    kept = (2 * kx != -nx) & ((2 * ky != ny) | (kx >= 0))
    kx = kx[kept] % nx
    ky = ky[kept]
    mirror = (nx - kx) % nx
    lone_column = (ky == 0) | (2 * ky == ny)  # columns that hold both a mode and its conjugate
    own = mirror == kx
    real = np.flatnonzero(lone_column & own)
    paired = np.flatnonzero(lone_column & ~own)
    place = kx * half[1] + ky
    partner = mirror[paired] * half[1] + ky[paired]
    return _DrawnModes(kept, place, paired, partner, real, np.sqrt(variance.flat[place]))
