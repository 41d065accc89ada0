"""`Mean`: a mean over surfaces with the deviation of each; sums, products and ratios keep surfaces together."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughsim.grid import Array

Influence = dict[int, Array]


@dataclass(frozen=True, slots=True, eq=False)
class Mean:
    """A mean, (speeds,), and its scatter; + - * / of two means are taken to first order in it.

    `influence` has by stream, (realizations, speeds), the influence values: the contribution of each realization to the
    deviation of this mean from the true one (the delta method); its own mean is zero. Realizations of one stream and
    place have one surface. The other operand may be an exact number, or one at each speed, but for /.
    """

    value: Array
    influence: Influence

    def __add__(self, other: "Mean | Array | float") -> "Mean":
        if not isinstance(other, Mean):
            return Mean(self.value + other, self.influence)
        influence = dict(self.influence)
        for stream, rows in other.influence.items():
            influence[stream] = _together(influence[stream], rows) if stream in influence else rows
        return Mean(self.value + other.value, influence)

    def __sub__(self, other: "Mean | Array | float") -> "Mean":
        return self + other * -1.0

    def __mul__(self, other: "Mean | Array | float") -> "Mean":
        if isinstance(other, Mean):
            both = self * other.value + other * self.value
            return Mean(self.value * other.value, both.influence)
        influence = {stream: rows * other for stream, rows in self.influence.items()}
        return Mean(self.value * other, influence)

    def __truediv__(self, other: "Mean") -> "Mean":
        """Return the ratio; not finite if the other mean is zero."""
        with np.errstate(all="ignore"):
            ratio = self.value / other.value
            both = self * (1.0 / other.value) + other * (-ratio / other.value)
        return Mean(ratio, both.influence)

    def where(self, chosen: NDArray[np.bool_], other: "Mean") -> "Mean":
        """Return this mean at the chosen speeds, the other one elsewhere; both are finite or discarded whole."""
        with np.errstate(invalid="ignore"):
            influence = {s: np.where(chosen, rows, 0.0) for s, rows in self.influence.items()}
            rest = {s: np.where(chosen, 0.0, rows) for s, rows in other.influence.items()}
        both = Mean(self.value, influence) + Mean(other.value, rest)
        return Mean(np.where(chosen, self.value, other.value), both.influence)

    @property
    def variance(self) -> dict[int, Array]:
        """The variance of the mean by stream; infinite for a single realization."""
        parts = {}
        for stream, rows in self.influence.items():
            n = len(rows)
            unknown = np.full(rows.shape[1:], np.inf)
            parts[stream] = (rows**2).sum(axis=0) * n / (n - 1) if n > 1 else unknown
        return parts


def mean_of(stream: int, rows: Array) -> Mean:
    """Return the mean of influence values, (realizations, speeds), of one stream."""
    value = rows.mean(axis=0)
    with np.errstate(invalid="ignore"):  # both infinite
        return Mean(value, {stream: (rows - value) / len(rows)})


def _together(first: Array, second: Array) -> Array:
    """Return the sum of the scatter of two means over the same surfaces, of which one may have more than the other."""
    shorter, longer = sorted((first, second), key=len)
    shape = np.broadcast_shapes(longer.shape, (1, *shorter.shape[1:]))
    result = np.array(np.broadcast_to(longer, shape))
    result[: len(shorter)] += shorter
    return result
