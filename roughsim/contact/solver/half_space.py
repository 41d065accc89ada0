"""The elastic half space on a periodic grid: S(q) = 2/|q| and its inverse |q|/2, in blocks that fit the cache.

Rows are transformed in pairs (two real rows are one complex line), columns in groups that are multiplied and
transformed back while they are in the cache: 2–3 times as fast as one two-dimensional transform each way.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughsim._kernels import lines as kernels
from roughsim.fourier import Transform, direct
from roughsim.fourier.blocks import POINTS, run
from roughsim.fourier.plans import ALIGNMENT, aligned, line_plans, lines
from roughsim.fourier.plans import PADDING as LINE_PADDING
from roughsim.grid import Grid

CACHED = 1 << 18  # bytes of one group of lines
GROUP = 16  # lines at least: shorter pieces of a column are slow to write
PADDING = 16  # of the rows of the spectrum, so that they do not all fall onto the same places of the cache


class Operator:
    """Products with 2/|q| or |q|/2 in one precision; the spectrum is its only large buffer."""

    def __init__(self, grid: Grid, dtype: Any):
        self.dtype, self.shape = np.dtype(dtype), grid.shape
        self.along, self.across = (np.square(q.ravel()).astype(self.dtype) for q in grid.wavevectors)
        self.factor = self.dtype.type(0.5 / grid.points)
        (rows, columns), half = grid.shape, grid.half_shape[1]
        self.row_group, self.row_blocks = divided((rows + 1) // 2, columns, self.dtype)
        self.column_group, self.column_blocks = divided(half, rows, self.dtype)
        # columns are transformed where they are, in whole groups, each line beginning at a multiple of ALIGNMENT
        distance = rounded_up(rows + PADDING, ALIGNMENT // 8)
        self.whole = aligned((rounded_up(half, self.column_group), 2 * distance), self.dtype)
        self.spectrum = self.whole[:half]
        self.row_plans = line_plans(self.row_group, columns, (columns + LINE_PADDING,) * 2, self.dtype)
        self.column_plans = line_plans(self.column_group, rows, (distance, rows + LINE_PADDING), self.dtype)

    def comply(self, pressure: NDArray[Any], displacement: NDArray[Any]) -> None:
        """Write S p, mean zero; both arrays may be the same."""
        self.multiply(False, pressure, displacement)

    def stiffen(self, displacement: NDArray[Any], pressure: NDArray[Any]) -> None:
        """Write |q|/2 u, mean zero; both arrays may be the same."""
        self.multiply(True, displacement, pressure)

    def multiply(self, stiff: bool, source: NDArray[Any], result: NDArray[Any]) -> None:
        """Write the product with |q|/2 if `stiff`, else with 2/|q|."""
        weights = self.along, self.across, self.factor
        blocks, others = self.row_blocks, self.column_blocks
        if len(blocks) == len(others) == 1 and source.dtype == np.float32:  # one call: each costs more than its work
            rows, columns = (*blocks[0], *self._rows()), (stiff, *others[0], *self._columns(), weights)
            kernels.product(source, result, rows, columns)
            return
        self._each_row(kernels.rows_forward, source)
        self._each_column(lambda *block: kernels.columns_product(stiff, *block), weights)
        self._each_row(kernels.rows_backward, result)

    def forward(self, field: NDArray[Any]) -> NDArray[Any]:
        """Return the transposed half spectrum (1/N) Σ field·exp(−iq·x), complex; it is a view of the buffer."""
        self._each_row(kernels.rows_forward, field)
        self._each_column(kernels.columns_forward, self.factor)
        return self.complex_spectrum

    def inverse(self, field: NDArray[Any]) -> None:
        """Write the field whose transposed half spectrum the buffer holds."""
        self._each_column(kernels.columns_backward)
        self._each_row(kernels.rows_backward, field)

    @property
    def complex_spectrum(self) -> NDArray[Any]:
        """The buffer as complex numbers, shape (columns//2 + 1, rows)."""
        return self.spectrum.view(np.result_type(self.dtype, np.complex64))[:, : self.shape[0]]

    def _each_row(self, kernel: Any, field: NDArray[Any]) -> None:
        run(lambda start, stop: kernel(field, start, stop, *self._rows()), self.row_blocks)

    def _each_column(self, kernel: Any, *arguments: Any) -> None:
        run(lambda start, stop: kernel(start, stop, *self._columns(), *arguments), self.column_blocks)

    def _rows(self) -> tuple[Any, ...]:
        """Group, plans and buffers of this Python thread."""
        group = lines(self.row_group, self.shape[1], self.dtype)
        return self.row_group, self.row_plans.addresses, group.source_pairs, group.result_pairs, self.spectrum

    def _columns(self) -> tuple[Any, ...]:
        result = lines(self.column_group, self.shape[0], self.dtype).result_pairs
        return self.column_group, self.column_plans.addresses, self.whole, result


class PlainOperator(Operator):
    """The same by one two-dimensional transform each way, where compiled code cannot call FFTW."""

    def __init__(self, grid: Grid, dtype: Any):
        self.transform, self.half_wavenumbers = Transform(grid.shape, dtype), 0.5 * grid.wavenumbers
        self.compliance = np.divide(
            1.0, self.half_wavenumbers, out=np.zeros(grid.half_shape), where=self.half_wavenumbers > 0.0
        )

    def multiply(self, stiff: bool, source: NDArray[Any], result: NDArray[Any]) -> None:
        """Write the product with |q|/2 if `stiff`, else with 2/|q|."""
        self.forward(source).T[...] *= self.half_wavenumbers if stiff else self.compliance
        self.inverse(result)

    def forward(self, field: NDArray[Any]) -> NDArray[Any]:
        """Return the transposed half spectrum."""
        self.transform.field[...] = field
        return self.transform.forward().T

    def inverse(self, field: NDArray[Any]) -> None:
        """Write the field of that spectrum."""
        field[...] = self.transform.inverse()

    @property
    def complex_spectrum(self) -> NDArray[Any]:
        """The buffer, shape (columns//2 + 1, rows)."""
        return self.transform.spectrum.T


def half_space(grid: Grid, dtype: Any) -> Operator:
    """Return the faster operator that there is."""
    return Operator(grid, dtype) if direct() else PlainOperator(grid, dtype)


@lru_cache(maxsize=16)
def rms_compliance(grid: Grid) -> float:
    """Root mean square of 2/|q| over all modes, q = 0 left out."""
    qx, qy = grid.wavevectors
    square, rows = 0.0, max((1 << 16) // qy.size, 1)
    for first in range(0, qx.size, rows):
        power = np.square(qx[first : first + rows]) + np.square(qy)
        square += float(np.sum(grid.multiplicity * np.divide(4.0, power, out=np.zeros_like(power), where=power > 0)))
    return float(np.sqrt(square / grid.points))


def divided(count: int, points: int, dtype: np.dtype[Any]) -> tuple[int, list[tuple[int, int]]]:
    """Return how many of `count` complex lines are transformed at a time, and the ranges of lines that make the blocks.

    As many as fit the cache, in groups alike; blocks are whole groups but for the last, of about `POINTS` reals each.
    """
    fitting = max(CACHED // (2 * dtype.itemsize * points), GROUP)
    group = math.ceil(count / max(round(count / fitting), 1))
    number = max(round(2 * count * points / POINTS), 1)
    size = rounded_up(math.ceil(count / number), group)
    return group, [(first, min(first + size, count)) for first in range(0, count, size)]


def rounded_up(count: int, group: int) -> int:
    """Return the least multiple of `group` that is not below `count`."""
    return -(-count // group) * group
