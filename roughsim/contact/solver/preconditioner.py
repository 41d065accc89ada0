"""The preconditioner of the contact solve: |q|/2 between a harmonic-like extension and its transpose.

The inverse of S restricted to the free points F is exactly Eᵀ (E*|q|/2) E, with E the harmonic extension of a field
from F to the whole plane (operator preconditioning: Steinbach & Wendland 1998, Hiptmair 2006). A push–pull pyramid
(Gortler, Grzeszczuk, Szeliski & Cohen 1996) stands in for E at the cost of a few passes over the field. Its cells are
kept as square as they can be: where the pixels are oblong, only their shorter side is doubled at first.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughsim._kernels import extension as kernels
from roughsim.fourier.blocks import run, spans, total
from roughsim.grid import Grid

SQUARE = 1.5  # ratio of the sides of a cell up to which both are doubled


class Extension:
    """Extension of a field from the free points to the plane, and its exact transpose; buffers included."""

    def __init__(self, grid: Grid, dtype: Any):
        shapes = _shapes(grid)
        # level 0 is the caller's free set and field where both axes are halved above it, a copy elsewhere
        self.bottom = int(len(shapes) > 1 and all(b < a for a, b in zip(*shapes[:2], strict=True)))
        sizes = [rows * columns for rows, columns in shapes]
        sizes[0] *= 1 - self.bottom
        self.starts = np.cumsum([0, *sizes[:-1]])
        self.pyramid = np.array(shapes), self.starts, *(np.zeros(sum(sizes), dtype) for _ in range(3))
        weights, inverses, values = self.pyramid[2:]
        level = slice(self.starts[self.bottom], self.starts[self.bottom] + sizes[self.bottom])
        self.parents = tuple(flat[level].reshape(shapes[self.bottom]) for flat in (weights, values, inverses))
        self.rows, self.parent_rows = spans(*grid.shape), spans(*shapes[self.bottom])

    def extend(self, free: NDArray[np.int8], field: NDArray[Any]) -> None:
        """Fill `field`, zero off the free points, over the whole plane, in place."""
        if self.bottom == 0:
            self.parents[0][...], self.parents[1][...] = free, field
            kernels.extend_coarse(self.bottom, *self.pyramid)
            field[...] = self.parents[1]
            return
        if len(self.rows) == 1:  # one call: each costs more than its work on a small grid
            kernels.extend(self.rows[0], self.bottom, free, field, self.parents, self.pyramid)
            return
        run(lambda a, b: kernels.push_finest(a, b, free, field, *self.parents), self.rows)
        kernels.extend_coarse(self.bottom, *self.pyramid)
        run(lambda a, b: kernels.pull(a, b, free, self.parents[1], field), self.rows)

    def transpose(
        self, free: NDArray[np.int8], field: NDArray[Any], step: NDArray[Any], response: NDArray[Any]
    ) -> tuple[float, float]:
        """Gather `field` from the whole plane onto the free points, in place: the transpose of `extend`.

        Return the products ⟨field, response⟩ and ⟨step, response⟩ over the free points.
        """
        if self.bottom == 0:
            self.parents[1][...] = field
            kernels.transpose_coarse(self.bottom, *self.pyramid)
            np.multiply(self.parents[1], free, out=field)
            return float(np.sum(field * response, dtype=float)), float(np.sum(free * step * response, dtype=float))
        run(lambda a, b: kernels.gather(a, b, free, field, self.parents[1]), self.parent_rows)
        kernels.transpose_coarse(self.bottom, *self.pyramid)
        parents = self.parents[1], self.parents[2]
        task = lambda a, b: kernels.scatter_finest(a, b, free, *parents, step, response, field)  # noqa: E731
        cross, own = total(run(task, self.rows))
        return cross, own


def _shapes(grid: Grid) -> list[tuple[int, int]]:
    """The shapes of the levels, finest first, down to one cell."""
    (rows, columns), (height, width) = grid.shape, grid.spacing
    shapes = [(rows, columns)]
    while rows > 1 or columns > 1:
        high = rows > 1 and (columns == 1 or height <= SQUARE * width)
        wide = columns > 1 and (rows == 1 or width <= SQUARE * height)
        rows, height = ((rows + 1) // 2, 2 * height) if high else (rows, height)
        columns, width = ((columns + 1) // 2, 2 * width) if wide else (columns, width)
        shapes.append((rows, columns))
    return shapes
