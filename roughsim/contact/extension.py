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


class Extension:
    """Extension of a field from the free points to the plane, and its exact transpose; buffers included."""

    def __init__(self, shape: tuple[int, int], dtype: Any = np.float64):
        shapes = [shape]
        while max(shapes[-1]) > 1:
            shapes.append(((shapes[-1][0] + 1) // 2, (shapes[-1][1] + 1) // 2))
        # entry l belongs to level l; level 0 is handed in by the caller, its places hold nothing
        self.weights, self.inverses, self.values, self.sources = (
            [np.zeros(s if level else (0, 0), dtype) for level, s in enumerate(shapes)] for _ in range(4)
        )

    def extend(self, free: NDArray[np.int8], field: NDArray[Any]) -> None:
        """Fill `field`, given on the free points, over the whole plane, in place."""
        top = len(self.values) - 1
        for level in range(top):
            weight, value = (self.weights[level], self.values[level]) if level else (free, field)
            kernels.push(weight, value, self.weights[level + 1], self.values[level + 1], self.inverses[level + 1])
        for level in range(top - 1, -1, -1):
            weight, value = (self.weights[level], self.values[level]) if level else (free, field)
            kernels.pull(weight, value, self.values[level + 1], value)

    def transpose(self, free: NDArray[np.int8], field: NDArray[Any]) -> None:
        """Gather `field` from the whole plane onto the free points, in place: the transpose of `extend`."""
        top = len(self.values) - 1
        for level in range(top):
            weight, source = (self.weights[level], self.sources[level]) if level else (free, field)
            kernels.pull_transposed(weight, source, self.sources[level + 1])
        for level in range(top - 1, -1, -1):
            weight, source = (self.weights[level], self.sources[level]) if level else (free, field)
            kernels.push_transposed(weight, source, self.sources[level + 1], self.inverses[level + 1], source)
