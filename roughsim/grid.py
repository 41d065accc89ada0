"""The periodic grid: points in real space, modes in Fourier space, and which modes share a wavenumber |q|."""

import operator
from dataclasses import dataclass
from math import inf, pi, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughsim.errors import instance, sized

Array = NDArray[np.float64]
LONGEST = 1e12  # times the shorter side of a cell
Field = NDArray[Any]  # of real or complex numbers, in double or single precision
Complex = NDArray[np.complex128]
Mask = NDArray[np.bool_]
Index = NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class Grid:
    """A periodic rectangular cell with a regular grid of points; axis 0 is x.

    TypeError or ValueError if a count is not a whole number ≥ 1, or a length is not positive, of a size from 1e-100 to
    1e100, or more than 1e12 times the other.

    Parameters
    ----------
    shape : (int, int)
        Number of points along x and y, each ≥ 1.
    lengths : (float, float)
        Side lengths of the cell along x and y, m.
    """

    shape: tuple[int, int]
    lengths: tuple[float, float]

    def __post_init__(self) -> None:
        try:
            shape, lengths = tuple(self.shape), tuple(self.lengths)
        except TypeError:
            raise TypeError(
                f"shape = {self.shape!r} and lengths = {self.lengths!r} must be pairs (x, y)"
            ) from None
        if len(shape) != 2 or len(lengths) != 2:
            raise ValueError(
                f"shape = {shape} and lengths = {lengths} need two entries each, along x and y"
            )
        try:
            counts = tuple(operator.index(n) for n in shape)
        except TypeError:
            raise TypeError(f"shape = {shape} must hold whole numbers") from None
        if min(counts) < 1:
            raise ValueError(f"shape = {shape} must hold numbers of points ≥ 1")
        sides = tuple(sized("lengths", length, "m") for length in lengths)
        object.__setattr__(self, "shape", counts)
        object.__setattr__(self, "lengths", sides)
        ratio = max(self.lengths) / min(self.lengths)
        if ratio > LONGEST:
            raise ValueError(
                f"lengths = {self.lengths[0]:.6g} and {self.lengths[1]:.6g} m have the ratio {ratio:.3g}; it must "
                f"be at most {LONGEST:g}: beyond, waves along one side are lost beside those along the other"
            )

    def stretched(self, lay: float) -> "Grid":
        """Return the cell of the same points whose x is √lay times as long, and whose y is √lay times as short.

        The heights of an isotropic surface on this grid are, on the stretched one, a surface with a lay along x.
        """
        x, y = self.lengths
        return Grid(self.shape, (x * sqrt(lay), y / sqrt(lay)))

    @property
    def spacing(self) -> tuple[float, float]:
        """Distance between neighbouring points along x and y, m."""
        return self.lengths[0] / self.shape[0], self.lengths[1] / self.shape[1]

    @property
    def points(self) -> int:
        """Number of grid points."""
        return self.shape[0] * self.shape[1]

    @property
    def half_shape(self) -> tuple[int, int]:
        """Shape of the half spectrum of a real field."""
        return self.shape[0], self.shape[1] // 2 + 1

    @property
    def nyquist(self) -> float:
        """Highest wavenumber that every direction resolves, rad/m; an axis of one point does not count."""
        sides = zip(self.shape, self.lengths, strict=True)
        return min((pi * n / length for n, length in sides if n > 1), default=inf)

    @property
    def mode_spacing(self) -> tuple[float, float]:
        """Distance between neighbouring modes along q_x and q_y, rad/m."""
        return 2 * pi / self.lengths[0], 2 * pi / self.lengths[1]

    @property
    def wavevectors(self) -> tuple[Array, Array]:
        """(q_x, q_y) of the half spectrum, rad/m, shapes (n_x, 1) and (1, n_y//2 + 1); read-only."""
        (nx, ny), (dx, dy) = self.shape, self.mode_spacing
        qx = dx * np.rint(np.fft.fftfreq(nx) * nx)[:, None]
        qy = dy * np.arange(ny // 2 + 1, dtype=np.float64)[None, :]
        qx.flags.writeable = qy.flags.writeable = False
        return qx, qy

    @property
    def wavenumbers(self) -> Array:
        """|q| of the half spectrum, rad/m, shape `half_shape`; read-only."""
        q = np.hypot(*self.wavevectors)
        q.flags.writeable = False
        return q

    @property
    def multiplicity(self) -> Array:
        """Modes of the full plane that each column of the half spectrum stands for: 1 or 2, shape (1, n_y//2 + 1)."""
        counts = np.full((1, self.shape[1] // 2 + 1), 2.0)
        counts[0, 0] = 1.0
        if self.shape[1] % 2 == 0:
            counts[0, -1] = 1.0
        counts.flags.writeable = False
        return counts


class Modes(NamedTuple):
    """Some modes of the half spectrum of a grid, flattened.

    `chosen` marks them, shape `half_shape`; `wavenumber` (modes,) is |q| of each, rad/m; `multiplicity` (modes,) is how
    many modes of the full plane each stands for, 1 or 2.
    """

    chosen: Mask
    wavenumber: Array
    multiplicity: Array


def modes_where(grid: Grid, chosen: Mask) -> Modes:
    """Return the modes where `chosen`, shape `half_shape`, is true."""
    multiplicity = np.broadcast_to(grid.multiplicity, grid.half_shape)
    return Modes(chosen, grid.wavenumbers[chosen], multiplicity[chosen])


def modes_between(grid: Grid, low: float = 0.0, high: float = inf) -> Modes:
    """Return all modes but q = 0 from `low` to `high`, rad/m, the ends included to rounding."""
    q = grid.wavenumbers
    return modes_where(grid, (q > 0.0) & (q >= low * (1 - 1e-9)) & (q <= high * (1 + 1e-9)))


def distinct_wavenumbers(grid: Grid) -> tuple[Array, Index]:
    """Return the distinct |q| of the quarter plane, rad/m, increasing from 0, and the entry of each mode, flattened.

    The quarter plane has one mode for the four (±q_x, ±q_y), shape (n_x//2 + 1, n_y//2 + 1). In a square cell many
    modes share k_x² + k_y².
    """
    nx, ny = (n // 2 + 1 for n in grid.shape)
    if grid.lengths[0] != grid.lengths[1]:
        qx, qy = (np.abs(q) for q in grid.wavevectors)
        wavenumber, entry = np.unique(np.hypot(qx[:nx], qy).ravel(), return_inverse=True)
        return wavenumber, entry
    square = (np.arange(nx)[:, None] ** 2 + np.arange(ny)[None, :] ** 2).ravel()
    present = np.zeros(square.max() + 1, np.bool_)
    present[square] = True
    entry = (np.cumsum(present) - 1)[square]
    return 2 * pi / grid.lengths[0] * np.sqrt(np.flatnonzero(present).astype(np.float64)), entry


def need_grid(grid: Any) -> None:
    """Raise a TypeError unless the argument is a `Grid`."""
    instance("grid", grid, Grid, "Grid((128, 128), (1e-3, 1e-3))")
