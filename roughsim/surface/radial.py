"""The plane of modes reduced to its wavenumbers |q|: who averages over directions counts and sums modes here."""

from __future__ import annotations

from functools import lru_cache
from math import inf, pi
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughsim.grid import Grid

Array = NDArray[np.float64]


class Modes(NamedTuple):
    """Some modes of the half spectrum of a grid, flattened.

    `chosen` says which, shape `half_shape`; `wavenumber` (modes,) is |q| of each, rad/m; `multiplicity` (modes,) is how
    many modes of the full plane each stands for, 1 or 2.
    """

    chosen: NDArray[np.bool_]
    wavenumber: Array
    multiplicity: Array

    def sums(self, ring: NDArray[np.intp], values: Any = 1.0) -> Array:
        """Return the sum of `values`, one for all or (modes,), over the modes of the full plane in each ring.

        `ring` (modes,) is the number of the ring that each mode lies in, from 0.
        """
        return np.bincount(ring, self.multiplicity * values).astype(np.float64, copy=False)


def modes_where(grid: Grid, chosen: NDArray[np.bool_]) -> Modes:
    """Return the modes where `chosen`, shape `half_shape`, is true."""
    return Modes(chosen, grid.wavenumbers[chosen], np.broadcast_to(grid.multiplicity, grid.half_shape)[chosen])


def modes_between(grid: Grid, low: float = 0.0, high: float = inf) -> Modes:
    """Return all modes but q = 0 from `low` to `high`, rad/m, the ends included to rounding."""
    q = grid.wavenumbers
    return modes_where(grid, (q > 0.0) & (q >= low * (1 - 1e-9)) & (q <= high * (1 + 1e-9)))


def quarter_plane(power: Array, grid: Grid) -> Array:
    """Return the sum over the four modes (±q_x, ±q_y), shape (n_x//2 + 1, n_y//2 + 1).

    `power` of the half spectrum, shape `half_shape`, is written over.
    """
    nx = grid.shape[0]
    power *= grid.multiplicity
    quarter = power[: nx // 2 + 1]
    quarter[1 : (nx + 1) // 2] += power[: nx // 2 : -1]  # row −i onto row i
    return quarter


@lru_cache(maxsize=2)
def distinct_wavenumbers(grid: Grid) -> tuple[Array, NDArray[np.intp]]:
    """Return the |q| of the quarter plane, rad/m, 0 first, and the entry of each of its modes, flattened.

    In a square cell many modes share k_x² + k_y²; in any other each mode has an entry of its own.
    """
    nx, ny = (n // 2 + 1 for n in grid.shape)
    qx, qy = (np.abs(q) for q in grid.wavevectors)
    if grid.lengths[0] != grid.lengths[1]:
        return np.hypot(qx[:nx], qy).ravel(), np.arange(nx * ny)
    square = (np.arange(nx)[:, None] ** 2 + np.arange(ny)[None, :] ** 2).ravel()
    present = np.zeros(square.max() + 1, np.bool_)
    present[square] = True
    entry = (np.cumsum(present) - 1)[square]
    return 2 * pi / grid.lengths[0] * np.sqrt(np.flatnonzero(present).astype(np.float64)), entry
