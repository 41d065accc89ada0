"""The preconditioner of the contact solve: |q|/2 between a harmonic-like extension and its transpose.

The inverse of S restricted to the free points F is exactly Eᵀ (E*|q|/2) E, with E the harmonic extension of a field
from F to the whole plane (operator preconditioning: Steinbach & Wendland 1998, Hiptmair 2006). A push–pull pyramid
(Gortler, Grzeszczuk, Szeliski & Cohen 1996) stands in for E at the cost of a few passes over the field.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughsim._kernels import extension as kernels
from roughsim.contact.blocks import run, spans, total


class Extension:
    """Extension of a field from the free points to the plane, and its exact transpose; buffers included."""

    def __init__(self, shape: tuple[int, int], dtype: Any):
        shapes = [shape]
        while max(shapes[-1]) > 1:
            shapes.append(((shapes[-1][0] + 1) // 2, (shapes[-1][1] + 1) // 2))
        sizes = [0] + [rows * columns for rows, columns in shapes[1:]]  # the finest level belongs to the caller
        self.shapes = np.array(shapes)
        self.starts = np.cumsum([0, *sizes[:-1]])
        self.weights, self.inverses, self.values = (np.zeros(sum(sizes), dtype) for _ in range(3))
        self.trivial = len(shapes) == 1
        if not self.trivial:
            self.parents = [flat[: sizes[1]].reshape(shapes[1]) for flat in (self.weights, self.values, self.inverses)]
            self.rows, self.parent_rows = spans(*shape), spans(*shapes[1])

    def extend(self, free: NDArray[np.int8], field: NDArray[Any]) -> None:
        """Fill `field`, zero off the free points, over the whole plane, in place."""
        if self.trivial:
            return
        run(lambda a, b: kernels.push_finest(a, b, free, field, *self.parents), self.rows)
        kernels.extend_coarse(self.shapes, self.starts, self.weights, self.inverses, self.values)
        run(lambda a, b: kernels.pull_finest(a, b, free, self.parents[1], field), self.rows)

    def transpose(
        self, free: NDArray[np.int8], field: NDArray[Any], step: NDArray[Any], response: NDArray[Any]
    ) -> tuple[float, float]:
        """Gather `field` from the whole plane onto the free points, in place: the transpose of `extend`.

        Return the products ⟨field, response⟩ and ⟨step, response⟩ over the free points.
        """
        if self.trivial:
            field *= free
            return float(np.sum(field * response)), float(np.sum(free * step * response))
        run(lambda a, b: kernels.gather_finest(a, b, free, field, self.parents[1]), self.parent_rows)
        kernels.transpose_coarse(self.shapes, self.starts, self.weights, self.inverses, self.values)
        parents = self.parents[1], self.parents[2]
        task = lambda a, b: kernels.scatter_finest(a, b, free, *parents, step, response, field)  # noqa: E731
        cross, own = total(run(task, self.rows))
        return cross, own
