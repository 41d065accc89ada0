"""The two operators of a solver step: the elastic half space on a periodic grid, and the preconditioner.

The half space is S(q) = 2/|q| and its inverse |q|/2. Rows are transformed in pairs (two real rows are one complex
line), columns in groups that are multiplied and transformed back while they are in the cache: 2–3 times as fast as one
two-dimensional transform each way.

The preconditioner is |q|/2 between a harmonic-like extension and its transpose. The inverse of S restricted to the free
points F is exactly Eᵀ (E*|q|/2) E, with E the harmonic extension of a field from F to the whole plane (operator
preconditioning: Steinbach & Wendland 1998, Hiptmair 2006). A push–pull pyramid (Gortler, Grzeszczuk, Szeliski & Cohen
1996) stands in for E at the cost of a few passes over the field. Its cells are kept as square as they can be: for
oblong pixels, only their shorter side is doubled at first.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from roughsim._kernels import extension, lines
from roughsim._kernels.extension import DOWN, FIRST, LAST, UP
from roughsim.fourier import Transform, direct, plans
from roughsim.fourier.blocks import POINTS, run, spans, total
from roughsim.grid import Field, Grid

CACHED = 1 << 18  # bytes of one group of lines
GROUP = 16  # lines in a group, at least: shorter pieces of a column are slow to write
PADDING = 16  # complex numbers between rows of the spectrum, so that these do not all share the same part of the cache
# points of a grid, at most, whose buffers are kept for the next solve: to make them costs as much as some steps there;
# 20 bytes for each point and precision
KEPT = 1 << 18
MOST_KEPT = 12  # grids in each precision, the coarse ones of a cascade among them
_ONCE = [(0, 0)]  # the block of a stage that is not divided
SQUARE = 1.5  # ratio of the sides of a cell of the pyramid up to which both are doubled


class Operator:
    """Products with 2/|q| or |q|/2 in one precision; the spectrum is its only large buffer."""

    def __init__(self, grid: Grid, dtype: Any):
        self.dtype = np.dtype(dtype)
        self.shape = grid.shape
        self.along, self.across = _squares(grid, self.dtype)
        self.factor = self.dtype.type(0.5 / grid.points)
        rows, columns = grid.shape
        half = grid.half_shape[1]
        self.row_group, self.row_blocks = divided((rows + 1) // 2, columns, self.dtype)
        self.column_group, self.column_blocks = divided(half, rows, self.dtype)
        # columns are transformed in place, in whole groups, each line beginning at a multiple of plans.ALIGNMENT
        distance = _rounded_up(rows + PADDING, plans.ALIGNMENT // 8)
        lines = _rounded_up(half, self.column_group)
        self.whole = plans.aligned((lines, 2 * distance), self.dtype)
        self.spectrum = self.whole[:half]
        row_distances = (columns + plans.PADDING, columns + plans.PADDING)
        self.row_plans = plans.LinePlans(self.row_group, columns, row_distances, self.dtype)
        column_distances = (distance, rows + plans.PADDING)
        self.column_plans = plans.LinePlans(self.column_group, rows, column_distances, self.dtype)
        self.single: tuple[Any, ...] | None = None  # the result of `_lines` if there is one block

    def comply(self, pressure: Field, displacement: Field) -> None:
        """Write S p, mean zero; both arrays may be the same."""
        self._multiply(lines.COMPLY, pressure, displacement)

    def stiffen(self, displacement: Field, pressure: Field) -> None:
        """Write |q|/2 u, mean zero; both arrays may be the same."""
        self._multiply(lines.STIFFEN, displacement, pressure)

    def _multiply(self, task: int, source: Field, result: Field) -> None:
        self._stages((lines.ROWS, lines.COLUMNS, lines.BACK), task, source, result)

    def forward(self, field: Field) -> Field:
        """Return the transposed half spectrum (1/N) Σ field·exp(−iq·x), complex; it is a view of the buffer."""
        self._stages((lines.ROWS, lines.COLUMNS), lines.THERE, field, field)
        return self.complex_spectrum

    def inverse(self, field: Field) -> None:
        """Write the field whose transposed half spectrum the buffer holds."""
        self._stages((lines.COLUMNS, lines.BACK), lines.BACKWARD, field, field)

    @property
    def complex_spectrum(self) -> Field:
        """The buffer as complex numbers, shape (columns//2 + 1, rows)."""
        return self.spectrum.view(np.result_type(self.dtype, np.complex64))[:, : self.shape[0]]

    def _stages(self, stages: tuple[int, ...], task: int, source: Field, result: Field) -> None:
        """Do these stages of a product, each on all of its blocks."""
        fields = self.row_plans.execute, source, result
        if len(self.row_blocks) == len(self.column_blocks) == 1:
            # one call: each costs more than its work
            self.single = self.single or self._lines(self.row_blocks[0], self.column_blocks[0])
            lines.product(sum(stages), task, *fields, *self.single)
            return
        for stage in stages:

            def work(first: int, last: int, stage: int = stage) -> None:
                block = first, last
                lines.product(stage, task, *fields, *self._lines(block, block))

            run(work, self.column_blocks if stage == lines.COLUMNS else self.row_blocks)

    def _lines(self, rows: tuple[int, int], columns: tuple[int, int]) -> tuple[Any, ...]:
        """These rows and columns, with groups, plans and the buffers of this Python thread."""
        row = plans.lines(self.row_group, self.shape[1], self.dtype)
        column = plans.lines(self.column_group, self.shape[0], self.dtype).result_pairs
        weights = self.along, self.across, self.factor
        row_plans = self.row_plans.forward, self.row_plans.backward
        column_plans = self.column_plans.forward, self.column_plans.backward
        return (
            (*rows, self.row_group, row_plans, row.source_pairs, row.result_pairs, self.spectrum),
            (*columns, self.column_group, column_plans, self.whole, column, weights),
        )


class PlainOperator(Operator):
    """The same products by two-dimensional transforms, for machines on which compiled code cannot call FFTW."""

    def __init__(self, grid: Grid, dtype: Any):
        self.transform = Transform(grid.shape, dtype)
        self.along, self.across = _squares(grid, dtype)
        stiffness = 0.5 * grid.wavenumbers
        compliance = np.zeros(grid.half_shape)
        np.divide(1.0, stiffness, out=compliance, where=stiffness > 0.0)
        self.factors = {lines.COMPLY: compliance, lines.STIFFEN: stiffness}

    def _multiply(self, task: int, source: Field, result: Field) -> None:
        self.forward(source).T[...] *= self.factors[task]
        self.inverse(result)

    def forward(self, field: Field) -> Field:
        """Return the transposed half spectrum."""
        self.transform.field[...] = field
        return self.transform.forward().T

    def inverse(self, field: Field) -> None:
        """Write the field of that spectrum."""
        field[...] = self.transform.inverse()

    @property
    def complex_spectrum(self) -> Field:
        """The buffer, shape (columns//2 + 1, rows)."""
        return self.transform.spectrum.T


def _squares(grid: Grid, dtype: Any) -> tuple[Field, Field]:
    """Return q² along the columns and the rows of a transposed half spectrum, whose sum is |q|²."""
    along, across = (np.square(q.ravel()).astype(dtype) for q in grid.wavevectors)
    return along, across


def half_space(grid: Grid, dtype: Any) -> Operator:
    """Return the fastest operator that works on this machine."""
    return Operator(grid, dtype) if direct() else PlainOperator(grid, dtype)


def kept_half_space(grid: Grid, dtype: Any) -> Operator:
    """Return `half_space`; on a small grid it is made once in a Python thread, and all callers share its buffer."""
    return kept(half_space, grid, np.dtype(dtype))


def kept(make: Callable[..., plans.Made], grid: Grid, *others: Any) -> plans.Made:
    """Return ``make(grid, *others)``; on a small grid, the earlier result of this Python thread."""
    if grid.points > KEPT:
        return make(grid, *others)
    key = grid, *others, plans.get_threads()
    return plans.thread_cache(make.__name__, key, lambda: make(grid, *others), most=MOST_KEPT)


def rms_compliance(grid: Grid) -> float:
    """Root mean square of 2/|q| over all modes, q = 0 left out."""
    qx, qy = grid.wavevectors
    rows = max((1 << 16) // qy.size, 1)
    total = 0.0
    for first in range(0, qx.size, rows):
        square = np.square(qx[first : first + rows]) + np.square(qy)
        power = np.divide(4.0, square, out=np.zeros_like(square), where=square > 0)
        total += float(np.sum(grid.multiplicity * power))
    return float(np.sqrt(total / grid.points))


def divided(count: int, points: int, dtype: np.dtype[Any]) -> tuple[int, list[tuple[int, int]]]:
    """Return how many of `count` complex lines form a group, and the ranges of lines that form the blocks.

    A group is transformed at a time: it fits the cache, and all groups are about equally large. A block is the work of
    one thread: whole groups, about `POINTS` reals; the last block may end within a group. Blocks change no bit, so a
    plane of `POINTS` is divided too if there are threads for it; for one thread each call would cost more than it
    brings.
    """
    fitting = max(CACHED // (2 * dtype.itemsize * points), GROUP)
    group = math.ceil(count / max(round(count / fitting), 1))
    number = round(2 * count * points / POINTS)
    number = max(number, plans.get_threads() if number else 1)
    size = _rounded_up(math.ceil(count / number), group)
    return group, [(first, min(first + size, count)) for first in range(0, count, size)]


def _rounded_up(count: int, group: int) -> int:
    """Return the least multiple of `group` that is not below `count`."""
    return -(-count // group) * group


class Extension:
    """Extension of a field from the free points to the plane, and its exact transpose; buffers included."""

    def __init__(self, grid: Grid, dtype: Any):
        shapes = _shapes(grid)
        # level 0 is the caller's free set and field if both axes are halved above it, else a copy
        self.bottom = int(len(shapes) > 1 and all(b < a for a, b in zip(*shapes[:2], strict=True)))
        sizes = [rows * columns for rows, columns in shapes]
        sizes[0] *= 1 - self.bottom
        starts = np.cumsum([0, *sizes[:-1]])
        weights = np.zeros(sum(sizes), dtype)
        inverses = np.zeros(sum(sizes), dtype)
        values = np.zeros(sum(sizes), dtype)
        self.pyramid = np.column_stack((starts, shapes)), weights, inverses, values
        first = starts[self.bottom]
        level = slice(first, first + sizes[self.bottom])
        shape = shapes[self.bottom]
        self.parents = tuple(flat[level].reshape(shape) for flat in (weights, values, inverses))
        self.rows = spans(*grid.shape)
        self.parent_rows = [(a // 2, (b + 1) // 2) for a, b in self.rows]
        self.line = np.empty(2 * shape[1] + 2, dtype)

    def extend(self, free: Field, field: Field) -> None:
        """Fill `field`, zero off the free points, over the whole plane, in place."""
        work = free, field, self.parents, self.pyramid
        if self.bottom == 0:
            self.parents[0][...] = free
            self.parents[1][...] = field
            self._stages(extension.extend, [(UP + DOWN, _ONCE)], *work)
            field[...] = self.parents[1]
        else:
            stages = [(FIRST, self.rows), (UP + DOWN, _ONCE), (LAST, self.rows)]
            self._stages(extension.extend, stages, *work)

    def transpose(
        self, free: Field, field: Field, step: Field, response: Field
    ) -> tuple[float, float]:
        """Gather `field` from the whole plane onto the free points, in place: the transpose of `extend`.

        Return the products ⟨field, response⟩ and ⟨step, response⟩ over the free points.
        """
        work = free, field, self.parents, self.pyramid, step, response
        if self.bottom == 0:
            self.parents[1][...] = field
            self._stages(extension.transpose, [(UP + DOWN, _ONCE)], *work)
            np.multiply(self.parents[1], free, out=field)
            products = field * response, free * step * response
            cross, own = (float(np.sum(product, dtype=float)) for product in products)
            return cross, own
        stages = [(FIRST, self.parent_rows), (UP + DOWN, _ONCE), (LAST, self.rows)]
        cross, own = total(self._stages(extension.transpose, stages, *work))
        return cross, own

    def gather_load(
        self, free: Field, load: Field, pressure: Field, cap: float, change: Field
    ) -> tuple[float, int]:
        """Take the load of the points that are not free from the change of the free points around them.

        The transpose of `extend` spreads it: close by, and without loss. Return Σ clip(pressure + change, 0, cap), and
        how many free points stay between the bounds.
        """
        work = free, load, self.parents, self.pyramid
        if self.bottom == 0:
            self.parents[0][...] = free
            self.parents[1][...] = 0.0
            self._stages(extension.extend, [(UP, _ONCE)], *work)
            self.parents[1][...] = load
            self._stages(extension.transpose, [(UP + DOWN, _ONCE)], *work, load, load)
            change -= self.parents[1] * free
            trial = pressure + change
            clipped = np.clip(trial, 0.0, cap)
            return float(clipped.sum()), int(np.count_nonzero((clipped == trial) & (free > 0)))
        self._stages(extension.extend, [(FIRST, self.rows), (UP, _ONCE)], *work)
        self._stages(
            extension.transpose, [(FIRST, self.parent_rows), (UP + DOWN, _ONCE)], *work, load, load
        )
        parents = self.parents[1], self.parents[2]

        def task(start: int, stop: int) -> Any:
            line = np.empty_like(self.line)
            return extension.scatter_load(start, stop, line, free, *parents, pressure, cap, change)

        clipped_sum, count = total(run(task, self.rows))
        return clipped_sum, count

    def _stages(
        self, kernel: Any, stages: list[tuple[int, list[tuple[int, int]]]], *work: Any
    ) -> list[Any]:
        """Do each stage on all of its blocks; return the results of the last one."""
        if len(self.rows) == len(self.parent_rows) == 1:
            # one call: each costs more than its work on a small grid
            together = sum(stage for stage, _ in stages)
            rows = self.rows[0] + self.parent_rows[0]
            return [kernel(together, rows, self.line, self.bottom, *work)]
        for stage, blocks in stages:

            def task(start: int, stop: int, stage: int = stage) -> Any:
                line = np.empty_like(self.line)  # each thread has its own
                return kernel(stage, (start, stop, start, stop), line, self.bottom, *work)

            parts = run(task, blocks)
        return parts


def _shapes(grid: Grid) -> list[tuple[int, int]]:
    """The shapes of the levels, finest first, down to one cell."""
    rows, columns = grid.shape
    height, width = grid.spacing
    shapes = [(rows, columns)]
    while rows > 1 or columns > 1:
        high = rows > 1 and (columns == 1 or height <= SQUARE * width)
        wide = columns > 1 and (rows == 1 or width <= SQUARE * height)
        rows, height = ((rows + 1) // 2, 2 * height) if high else (rows, height)
        columns, width = ((columns + 1) // 2, 2 * width) if wide else (columns, width)
        shapes.append((rows, columns))
    return shapes
