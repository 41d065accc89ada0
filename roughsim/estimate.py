"""Means with all their errors: statistical, bandwidth, pixel, finite size, solver."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from roughsim.ladder import Values
from roughsim.means import OBSERVABLES

Array = NDArray[np.float64]
LEAST = 12  # realizations before a run may stop: below, the scatter itself is too uncertain

SOURCES = {
    "statistical": "half-width of the 95 % interval (Student t)",
    "bandwidth": "left by the cut-off q_c",
    "pixel": "left by the grid at fixed q_c",
    "size": "a cell of this size holds only some waves: the theory's sum over its modes against the integral",
    "solver": "twice the contact solver's tolerance: moments are quadratic in the pressure",
}


@dataclass(frozen=True, slots=True, eq=False)
class Estimate:
    """The mean of one observable with its errors; arrays over speed, or of one entry.

    Attributes
    ----------
    observable, unit : str
        What it is, and its SI unit.
    mean : ndarray
        In the limit of q_c and the pixel where that exists and the levels tell.
    standard_error, half_width : ndarray
        Statistical: of the mean, and of its 95 % interval (Student t with `effective_n` − 1 degrees of freedom).
    bias : ndarray
        Value at the finest level minus `mean`; zero where nothing is extrapolated.
    total_error : ndarray
        Root of the sum of squares of `budget`; what no level tells is left out of it, and `explain` says so.
    budget : dict of str to ndarray
        The parts by source, the keys of `SOURCES`; NaN where no level tells.
    n : int
        Realizations.
    effective_n : ndarray
        What the statistical error is worth: less than `n` where fine levels were solved for few (Satterthwaite).
    notes : tuple of str
        What `explain` says beyond the numbers.
    """

    observable: str
    unit: str
    mean: Array
    standard_error: Array
    half_width: Array
    bias: Array
    total_error: Array
    budget: dict[str, Array]
    n: int
    effective_n: Array
    notes: tuple[str, ...] = ()

    def explain(self) -> str:
        """Say in plain words where each part of the error comes from."""
        lines = []
        for k, mean in enumerate(self.mean):
            parts = ", ".join(f"{name} {part[k]:.2g}" for name, part in self.budget.items() if np.isfinite(part[k]))
            lines.append(
                f"{mean:.6g} ± {self.total_error[k]:.2g} {self.unit}: {parts}; n = {self.n}, worth "
                f"{self.effective_n[k]:.3g}; finest level {self.bias[k]:+.2g}"
            )
        told = [name for name, part in self.budget.items() if np.all(np.isfinite(part))]
        missing = [f"{name}: no levels tell, not in these figures" for name in self.budget if name not in told]
        return "\n".join([f"{self.observable}:", *lines, *self.notes, *missing])


def estimate(
    observable: str,
    values: Values,
    notes: tuple[str, ...] = (),
    *,
    size: Array | float = 0.0,
    tolerance: float = 0.0,
) -> Estimate:
    """Return mean, errors and bias of an observable from its values.

    Parameters
    ----------
    observable : str
        A key of `roughsim.means.OBSERVABLES`.
    values : Values
        From `roughsim.ladder.observe`.
    notes : tuple of str, optional
        For `Estimate.explain`.
    size : ndarray or float, optional
        Relative error of the finite cell.
    tolerance : float, optional
        Relative pressure error of the contact solves.
    """
    mean = values.extrapolated.mean(axis=0)
    error, freedom = spread(values.extrapolated, values.group)
    with np.errstate(invalid="ignore"):  # slope_length is infinite at rest: its errors are undefined
        budget = {
            "statistical": _half_width(error, freedom),
            "bandwidth": values.bandwidth,
            "pixel": values.pixel,
            "size": np.abs(mean) * size,
            "solver": 2.0 * tolerance * np.abs(mean),
        }
        bias = values.finest.mean(axis=0) - mean
    total = np.sqrt(sum(np.where(np.isnan(part), 0.0, part) ** 2 for part in budget.values()))
    total = np.where(np.isnan(mean), np.nan, total)
    return Estimate(
        observable,
        OBSERVABLES[observable].unit,
        mean,
        error,
        budget["statistical"],
        bias,
        total,
        budget,
        len(values.extrapolated),
        freedom + 1.0,
        notes,
    )


def spread(values: Array, group: NDArray[np.intp] | None = None) -> tuple[Array, Array]:
    """Return the standard error of the mean over axis 0, and its degrees of freedom.

    Rows of one group scatter alike; each group must have two of them, else the error is infinite. Degrees of freedom
    after Satterthwaite. Scatter below rounding counts as none: realizations that agree to all digits have no error.

    Parameters
    ----------
    values : ndarray
        Influence values (n, speeds).
    group : ndarray, optional
        Number of the group of each row (n,); left out, all rows are of one.
    """
    n, shape = len(values), values.shape[1:]
    group = np.zeros(n, dtype=np.intp) if group is None else group
    variance, doubt = np.zeros(shape), np.zeros(shape)
    with np.errstate(invalid="ignore"):  # an undefined observable has an undefined error
        for one in np.unique(group):
            rows = values[group == one]
            count = len(rows)
            if count < 2:
                return np.full(shape, np.inf), np.zeros(shape)
            part = count * rows.var(axis=0, ddof=1) / n**2
            variance, doubt = variance + part, doubt + part**2 / (count - 1)
        freedom = np.divide(variance**2, doubt, out=np.full(shape, n - 1.0), where=doubt > 0.0)
        rounding = 1e-12 * np.abs(values).max(axis=0)
        error: Array = np.where(np.sqrt(n * variance) <= rounding, 0.0, np.sqrt(variance))
    return error, np.minimum(freedom, n - 1.0)


def standard_error(values: Array, group: NDArray[np.intp] | None = None) -> Array:
    """Return the standard error of the mean over axis 0, as `spread`; infinite for one realization."""
    return spread(values, group)[0]


def _half_width(error: Array, freedom: Array) -> Array:
    with np.errstate(invalid="ignore"):
        return np.where(freedom > 0.0, error * student.ppf(0.975, np.maximum(freedom, 1.0)), error)


def paired(above: Values, below: Values) -> NDArray[np.intp]:
    """Return the groups of rows that have the same levels in both columns."""
    return np.unique(np.stack([above.group, below.group]), axis=1, return_inverse=True)[1].astype(np.intp)


def relative_half_width(values: Values) -> float:
    """Return the relative 95 % half-width of the mean at the worst speed; infinite for fewer than two rows."""
    half = _half_width(*spread(values.extrapolated, values.group))
    mean = np.abs(values.extrapolated.mean(axis=0))
    relative = np.divide(half, mean, out=np.zeros_like(half), where=half > 0.0)
    return float(relative.max())


def first_sufficient(targets: Callable[[int], Iterable[tuple[Values, float]]], counts: range) -> int | None:
    """Return the first of `counts` realizations at which every observable meets its target; None if at none.

    Parameters
    ----------
    targets : callable
        Of a number of realizations: pairs of the values of an observable and its relative 95 % half-width.
    counts : range
        To be tried; start at `LEAST` or above.
    """
    for count in counts:
        if all(relative_half_width(values) <= target for values, target in targets(count)):
            return count
    return None


__all__ = [
    "LEAST",
    "SOURCES",
    "Estimate",
    "estimate",
    "first_sufficient",
    "paired",
    "relative_half_width",
    "spread",
    "standard_error",
]
