"""Moments of one contact for sliding in single directions: sums over the modes of the plane.

A wave of the stress has the weight Re F/|q| in T_flash, F = κT|q|/q̇ by `roughsim.heat.periodic.responses`. It has no
mean over directions here, so that roughness may have a lay.
"""

import math
from collections.abc import Iterator, Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from roughsim.grid import Array, Complex, Grid, Index
from roughsim.heat.periodic import MovingSource, responses

_KEPT = (
    2**23
)  # points times sources up to which their weights are kept, in 32 MB for each of four grids


def sums_in_directions(amplitude: Complex, grid: Grid, sources: Sequence[MovingSource]) -> Array:
    """Return Σ w Re F/|q|, −Σ w Re(i cosφ F), Σ w |q| Re F of each source; shape (3, sources).

    `amplitude` is the transform of the pressure on the half spectrum, Pa, w its square. They are the moments of the
    periodic field: to rounding, or from rest of many sources to 1e-7.
    """
    variance = (amplitude.real**2 + amplitude.imag**2) * grid.multiplicity
    qx, qy = grid.wavevectors
    sums = np.zeros((3, len(sources)))
    if grid.points * len(sources) <= _KEPT and any(math.isfinite(one.spread) for one in sources):
        curved = variance * (qx**2 + qy**2)
        for column, (even, odd) in zip(sums.T, _kept(grid, tuple(sources)), strict=True):
            column[:] = np.sum(variance * even), np.sum(variance * odd), np.sum(curved * even)
        return sums
    for column, source in zip(sums.T, sources, strict=True):
        for rows, response, along in _weights(grid, source):
            even = variance[rows] * response.real
            column[0] += np.sum(even)
            column[1] += np.sum(variance[rows] * response.imag * along)
            column[2] += np.sum(even * (qx[rows] ** 2 + qy**2))
    return sums


def _weights(grid: Grid, source: MovingSource) -> Iterator[tuple[Index, Complex, Array]]:
    """Yield rows of the half spectrum, κT/q̇ there, m, and q along sliding, 0 of waves without a derivative."""
    # an odd derivative of a wave at the Nyquist wavenumber vanishes on the points of the grid
    ax, ay = (
        np.where(2 * np.abs(np.rint(q * length / (2 * math.pi))) == n, 0.0, q)
        for q, length, n in zip(grid.wavevectors, grid.lengths, grid.shape, strict=True)
    )
    rate = math.hypot(*source.drift) or 1.0  # at rest no response is odd
    ux, uy = (part / rate for part in source.drift)
    for rows, response in responses(grid, source):
        yield rows, response, ux * ax[rows] + uy * ay


# responses from rest take five times as long as the contact of 256² points; a level and the one below it come in turn
@lru_cache(maxsize=4)
def _kept(grid: Grid, sources: tuple[MovingSource, ...]) -> list[NDArray[np.float32]]:
    """Return the weights of the first two sums on the half spectrum of each source, (2, …)."""
    kept = []
    for source in sources:
        both = np.empty((2, *grid.half_shape), np.float32)
        for rows, response, along in _weights(grid, source):
            both[:, rows] = response.real, response.imag * along
        kept.append(both)
    return kept
