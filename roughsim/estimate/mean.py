"""`Mean`: a mean over surfaces with the deviation of each; sums, products and ratios keep surfaces together."""

from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from roughsim.grid import Array

Scatter = dict[int, Array]


class Mean(NamedTuple):
    """A mean, (speeds,), and its scatter.

    `scatter` has by stream, (realizations, speeds), the contribution of each realization to the deviation of this mean
    from the true one (the delta method); its own mean is zero. Realizations of one stream and place have one surface.
    """

    value: Array
    scatter: Scatter

    def times(self, factor: Array | float) -> Self:
        """Return the mean times an exact number."""
        return self._replace(
            value=self.value * factor,
            scatter={s: rows * factor for s, rows in self.scatter.items()},
        )

    def plus(self, other: "Mean") -> "Mean":
        """Return the sum of two means."""
        scatter = dict(self.scatter)
        for stream, rows in other.scatter.items():
            scatter[stream] = _together(scatter[stream], rows) if stream in scatter else rows
        return Mean(self.value + other.value, scatter)

    def by(self, other: "Mean") -> "Mean":
        """Return the product of two means, to first order in their scatter."""
        return (
            self.times(other.value)
            .plus(other.times(self.value))
            ._replace(value=self.value * other.value)
        )

    def over(self, other: "Mean") -> "Mean":
        """Return the ratio of two means, to first order; not finite if the other one is zero."""
        with np.errstate(all="ignore"):
            ratio = self.value / other.value
            return (
                self.times(1.0 / other.value)
                .plus(other.times(-ratio / other.value))
                ._replace(value=ratio)
            )

    def where(self, chosen: NDArray[np.bool_], other: "Mean") -> "Mean":
        """Return this mean at the chosen speeds, the other one elsewhere; both are finite or discarded whole."""
        with np.errstate(invalid="ignore"):
            scatter = {s: np.where(chosen, rows, 0.0) for s, rows in self.scatter.items()}
            rest = {s: np.where(chosen, 0.0, rows) for s, rows in other.scatter.items()}
        both = Mean(self.value, scatter).plus(Mean(other.value, rest))
        return both._replace(value=np.where(chosen, self.value, other.value))

    @property
    def variance(self) -> dict[int, Array]:
        """The variance of the mean by stream; infinite for a single realization."""
        parts = {}
        for stream, rows in self.scatter.items():
            n = len(rows)
            parts[stream] = (
                (rows**2).sum(axis=0) * n / (n - 1) if n > 1 else np.full(rows.shape[1:], np.inf)
            )
        return parts


def mean_of(stream: int, rows: Array) -> Mean:
    """Return the mean of influence values, (realizations, speeds), of one stream."""
    value = rows.mean(axis=0)
    with np.errstate(invalid="ignore"):  # both infinite
        return Mean(value, {stream: (rows - value) / len(rows)})


def _together(first: Array, second: Array) -> Array:
    """Return the sum of the scatter of two means over the same surfaces, of which one may have more than the other."""
    longer, shorter = (first, second) if len(first) >= len(second) else (second, first)
    result = np.array(
        np.broadcast_to(longer, np.broadcast_shapes(longer.shape, (1, *shorter.shape[1:])))
    )
    result[: len(shorter)] += shorter
    return result
