"""Means with all parts of their errors: statistical, bandwidth, pixel, finite size, solver."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import scipy

from roughsim.estimate.mean import Mean
from roughsim.grid import Array
from roughsim.observables.catalogue import OBSERVABLES, UNITS
from roughsim.table import Estimate

SOURCES = {
    "statistical": (
        "95 % interval (Student t) at the mean peak volume of the surfaces, widened for runs that stop early; the "
        "variances of independent levels add"
    ),
    "bandwidth": "left by the cut-off q_c",
    "last step": "change by the last step to the highest q_c, if nothing is continued to shorter waves",
    "pixel": "left by the grid at fixed q_c",
    "size": "change by a larger cell, from the number of asperities that carry load, measured on other scenes",
    "solver": "largest change by the contact solver's tolerance in measured contacts: for T_flash 0.3 of it",
    "tail": "share of a rate from the hottest pixels, whose temperature has no limit; unknown above a quarter",
    "slide": "of two bodies that slide: low cut-off, rest of pixel and step, and the distance continued by the theory",
    "form": "of drawn contacts: solved ones are evener, the slower the more",
    "law": "of T_flash, and of the contact area, by the calibrated law, as compared with simulations",
    "scan": "of C(q) measured on maps: few long waves, none longer than a map, and other places than these",
}


def estimate(
    observable: str,
    mean: Mean,
    notes: tuple[str, ...] = (),
    speeds: Sequence[float] = (),
    unit: str | None = None,
) -> Estimate:
    """Return the estimate of an observable with its errors and bias; without `speeds` their labels are NaN.

    `unit` is that of an observable that is not in the catalogue.
    """
    error, freedom = spread_of(mean)
    with np.errstate(
        invalid="ignore"
    ):  # slope_length is infinite at rest: its errors are undefined
        bias = mean.finest - mean.value
    budget = _budget(half_width(error, freedom), mean.errors)
    n = len(next(iter(mean.influence.values())))
    axis = speed_axis(observable, mean.value, speeds)
    return replace(
        Estimate.of(observable, unit or UNITS[observable], mean.value, axis, budget),
        standard_error=error,
        bias=bias,
        n=n,
        effective_n=freedom + 1.0,
        notes=notes,
        sources=SOURCES,
    )


def speed_axis(observable: str, values: Array, speeds: Sequence[float] = ()) -> dict[str, Array]:
    """Return the axis of an observable over speed; NaN if it does not depend on it, or without `speeds`."""
    record = OBSERVABLES.get(observable)
    per_speed = record is None or record.per_speed
    known = per_speed and len(speeds) == len(values) and len(speeds) > 0
    return {"speed": np.array(speeds, float) if known else np.full(len(values), np.nan)}


def _budget(statistical: Array, errors: Mapping[str, Array]) -> dict[str, Array]:
    """Return the parts of the error of a mean by source, "last step" only if it counts."""
    parts = {"statistical": statistical, **errors}
    return {name: part for name, part in parts.items() if name != "last step" or np.any(part)}


def quotient(
    above: Mean,
    below: Mean | Array,
    *,
    size: Array | float = 0.0,
    scanned: bool = False,
) -> Estimate:
    """Return the ratio above/below, (speeds,), of two columns, or of a column and exact values, with its errors.

    `size` is a further relative error by the finite cell; `scanned` whether C(q) was measured on maps. The common
    scatter of shared surfaces cancels. The other parts add as squares, because the columns differ in levels and in the
    kind of contact. Exact values share the cut-off of the column and have no errors: then the error by q_c is zero.
    """
    if isinstance(below, Mean):
        ratio = above / below
        columns = [above, below]
    else:
        with np.errstate(all="ignore"):
            ratio = above * (1.0 / np.broadcast_to(below, above.value.shape))
        nothing = np.zeros_like(above.value)
        known = {"bandwidth": nothing, "last step": nothing}
        columns = [replace(above, errors={**above.errors, **known})]
    value = ratio.value
    error, freedom = spread_of(ratio)
    if not np.any(above.value):  # elastic contact has no plastic area: the ratio is undefined
        value = np.full_like(value, np.nan)
    with np.errstate(all="ignore"):  # 0/0 at rest: the ratio is NaN, and its errors are
        errors = {}
        for name in above.errors:
            relative = np.sqrt(sum((column.errors[name] / column.value) ** 2 for column in columns))
            errors[name] = np.asarray(np.abs(value) * relative)
        errors["size"] = np.hypot(errors["size"], np.abs(value) * size)
        budget = _budget(half_width(error, freedom), errors)
    if scanned:  # both columns use the one C(q), but nothing shows that its error cancels
        budget["scan"] = np.full(value.shape, np.nan)
    ratio_of_means = Estimate.of("ratio", "1", value, speed_axis("ratio", value), budget)
    return replace(ratio_of_means, standard_error=error)


def spread(values: Array) -> tuple[Array, Array]:
    """Return the standard error of the mean over axis 0 of independent rows (n, any), and its degrees of freedom."""
    n = len(values)
    shape = values.shape[1:]
    if n < 2:
        return np.full(shape, np.inf), np.zeros(shape)
    error = np.asarray(values.std(axis=0, ddof=1) / np.sqrt(n))
    return error, np.full(shape, n - 1.0)


def widened(found: Estimate, rows: Array, unit: Array | float = 1.0) -> Estimate:
    """Return an estimate with the scatter of further rows of realizations, (n, any), in some unit, added as squares."""
    error, freedom = spread(rows)
    statistical = np.hypot(found.budget["statistical"], unit * half_width(error, freedom))
    return replace(
        found,
        standard_error=np.hypot(found.standard_error, unit * error),
        budget={**found.budget, "statistical": statistical},
    )


def spread_of(mean: Mean) -> tuple[Array, Array]:
    """Return the standard error of a mean, and its degrees of freedom after Satterthwaite: variances of streams add.

    Influence below rounding counts as none: realizations that agree to all digits have no error.
    """
    variances = mean.variance
    freedoms = {stream: max(len(rows) - 1, 1) for stream, rows in mean.influence.items()}
    with np.errstate(all="ignore"):  # an undefined observable has an undefined error
        variance = np.asarray(sum(variances.values()))
        reciprocal = np.asarray(
            sum(part**2 / freedoms[stream] for stream, part in variances.items())
        )
        most = float(sum(freedoms.values()))
        freedom = np.where(reciprocal > 0.0, variance**2 / reciprocal, most)
        error = np.sqrt(variance)
        error = np.where(error <= 1e-12 * np.abs(mean.value), 0.0, error)
    freedom = np.minimum(np.nan_to_num(freedom, nan=most), most)
    return error, np.where(np.isinf(error), 0.0, freedom)


def quantile(freedom: Array | float) -> Array:
    """Return the half-width of a 95 % interval in standard errors: Student's t, times √(1 + 2/f).

    Runs tend to stop when the scatter is low by chance, which costs about two of the f degrees of freedom (of order
    1/f: M. Woodroofe, Annals of Statistics 5, 984, 1977). Measured by `experiments/coverage.py`.
    """
    freedom = np.maximum(freedom, 1.0)
    return scipy.special.stdtrit(freedom, 0.975) * np.sqrt(1.0 + 2.0 / freedom)


def half_width(error: Array, freedom: Array) -> Array:
    """Return the half-width of the 95 % interval of a mean; its standard error without degrees of freedom."""
    with np.errstate(invalid="ignore"):
        return np.where(freedom > 0.0, error * quantile(freedom), error)
