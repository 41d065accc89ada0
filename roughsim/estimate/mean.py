"""`Mean`: a mean over surfaces with the deviation of each and the parts of its error.

Sums, products and ratios keep surfaces together.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from roughsim.grid import Array

Influence = Mapping[int, Array]


@dataclass(frozen=True, slots=True, eq=False)
class Mean:
    """One observable, (speeds,) or (1,), its scatter, and its other errors; + - * / are taken to first order in them.

    The other operand may be an exact number, or one at each speed, but for /. Errors of one name have one cause: they
    add.

    Attributes
    ----------
    value : ndarray
        The mean; of a column, extrapolated to the end of C(q) and to a vanishing pixel, if such a limit exists.
    finest : ndarray
        The mean at the highest cut-off on its finest grid, without extrapolation.
    influence : mapping of int to ndarray
        By stream, (realizations, speeds), the influence values: the contribution of each realization to the deviation
        of this mean from the true one (the delta method); its own mean is zero. Realizations of one stream and place
        have one surface.
    errors : mapping of str to ndarray
        All parts of the error but the statistical one, 95 %. Of a column, "bandwidth" and "pixel", NaN if no level
        shows them, and "last step": the change by the last rise of q_c if a limit exists and no extrapolation reaches
        it, else 0. `with_errors` adds those that no level shows.
    way : str
        The extrapolation in words.
    """

    value: Array
    finest: Array
    influence: Influence
    errors: Mapping[str, Array] = field(default_factory=dict)
    way: str = ""

    def __add__(self, other: "Mean | Array | float") -> "Mean":
        if not isinstance(other, Mean):
            return replace(self, value=self.value + other, finest=self.finest + other)
        influence = {**self.influence}
        errors = {**self.errors}
        for stream, rows in other.influence.items():
            influence[stream] = _together(influence[stream], rows) if stream in influence else rows
        for name, part in other.errors.items():
            errors[name] = errors.get(name, 0.0) + part
        value = self.value + other.value
        finest = self.finest + other.finest
        return Mean(value, finest, influence, errors, self.way)

    def __sub__(self, other: "Mean | Array | float") -> "Mean":
        return self + other * -1.0

    def __mul__(self, other: "Mean | Array | float") -> "Mean":
        if not isinstance(other, Mean):
            return self.through(self.value * other, self.finest * other, other)
        both = self * other.value + other * self.value
        value = self.value * other.value
        finest = self.finest * other.finest
        # a product of zero has no error
        errors = {name: np.where(value == 0.0, 0.0, part) for name, part in both.errors.items()}
        return replace(both, value=value, finest=finest, errors=errors)

    def __truediv__(self, other: "Mean") -> "Mean":
        """Return the ratio; not finite if the other mean is zero."""
        with np.errstate(all="ignore"):
            ratio = self.value / other.value
            finest = self.finest / other.finest
            both = self * (1.0 / other.value) + other * (-ratio / other.value)
        return replace(both, value=ratio, finest=finest)

    def through(self, value: Array, finest: Array, slope: Array | float) -> "Mean":
        """Return a function of this mean, whose `slope` there carries its scatter and errors (delta method)."""
        influence = {stream: rows * slope for stream, rows in self.influence.items()}
        errors = {name: np.abs(slope) * part for name, part in self.errors.items()}
        return Mean(value, finest, influence, errors, self.way)

    def where(self, chosen: NDArray[np.bool_], other: "Mean") -> "Mean":
        """Return this mean at the chosen speeds, the other one elsewhere; both are finite or discarded whole."""
        with np.errstate(invalid="ignore"):
            return self._only(chosen) + other._only(~chosen)

    def _only(self, chosen: NDArray[np.bool_]) -> "Mean":
        """Return this mean at the chosen speeds, and zero without an error elsewhere."""
        influence = {stream: np.where(chosen, x, 0.0) for stream, x in self.influence.items()}
        errors = {name: np.where(chosen, part, 0.0) for name, part in self.errors.items()}
        value, finest = (np.where(chosen, x, 0.0) for x in (self.value, self.finest))
        return Mean(value, finest, influence, errors, self.way)

    def with_errors(self, **relative: Array | float) -> "Mean":
        """Return this mean with further parts of its error, over the mean; what is exactly zero has none of them."""
        with np.errstate(invalid="ignore"):  # infinite at rest
            size = np.abs(self.value)
            parts = {name: np.where(size == 0.0, 0.0, size * x) for name, x in relative.items()}
        return replace(self, errors={**self.errors, **parts})

    @property
    def variance(self) -> dict[int, Array]:
        """The variance of the mean by stream; infinite for a single realization."""
        parts = {}
        for stream, rows in self.influence.items():
            n = len(rows)
            unknown = np.full(rows.shape[1:], np.inf)
            parts[stream] = (rows**2).sum(axis=0) * n / (n - 1) if n > 1 else unknown
        return parts


def exact(value: Array) -> Mean:
    """Return a value without an error."""
    return Mean(value, value, {})


def mean_of(stream: int, rows: Array) -> Mean:
    """Return the mean of influence values, (realizations, speeds), of one stream."""
    value = rows.mean(axis=0)
    with np.errstate(invalid="ignore"):  # both infinite
        return Mean(value, value, {stream: (rows - value) / len(rows)})


def _together(first: Array, second: Array) -> Array:
    """Return the sum of the scatter of two means over the same surfaces, of which one may have more than the other."""
    shorter, longer = sorted((first, second), key=len)
    shape = np.broadcast_shapes(longer.shape, (1, *shorter.shape[1:]))
    result = np.array(np.broadcast_to(longer, shape))
    result[: len(shorter)] += shorter
    return result
