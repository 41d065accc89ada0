"""Means with all parts of their errors: statistical, bandwidth, pixel, finite size, solver."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np
import scipy

from roughsim.estimate.levels import Values
from roughsim.estimate.mean import Mean
from roughsim.grid import Array
from roughsim.observables.catalogue import UNITS
from roughsim.show.markup import in_notebook
from roughsim.show.table import Column, Number, Row, Table, shown, with_unit

SOURCES = {
    "statistical": (
        "95 % interval (Student t) at the mean peak volume of the surfaces, widened for runs that stop early; the "
        "variances of independent levels add"
    ),
    "bandwidth": "left by the cut-off q_c",
    "last step": "change by the last step to the highest q_c, if nothing is continued to shorter waves",
    "pixel": "left by the grid at fixed q_c",
    "size": "change by a larger cell, from the number of hills that carry load, measured on other scenes",
    "solver": "largest change by the contact solver's tolerance in measured contacts: for T_flash 0.3 of it",
    "tail": "share of a rate from the hottest pixels, whose temperature has no limit; unknown above a quarter",
    "slide": "of two bodies that slide: low cut-off, rest of pixel and step, and the distance continued by the theory",
    "form": "of drawn contacts: solved ones are evener, the slower the more",
    "law": "of T_flash, and of the contact area, by the calibrated law, as compared with simulations",
    "scan": "of C(q) measured on maps: few long waves, none longer than a map, and other places than these",
}


@dataclass(frozen=True, slots=True, eq=False)
class Uncertain:
    """A mean, or a ratio of two, with its errors; arrays over speed, or of one entry.

    Attributes
    ----------
    mean : ndarray
        Extrapolated in q_c and the pixel if a limit exists and the levels show it.
    standard_error : ndarray
        Of the mean, statistical.
    budget : dict of str to ndarray
        The parts of the 95 % error by source, keys of `SOURCES`; NaN: unknown. "scan" is there only if C(q) was
        measured on maps, "last step" only if it counts at some speed.
    """

    mean: Array
    standard_error: Array
    budget: dict[str, Array]

    @property
    def total_error(self) -> Array:
        """Root of the sum of squares of the known parts of `budget`; NaN for an undefined mean."""
        total = np.sqrt(
            sum(np.where(np.isnan(part), 0.0, part) ** 2 for part in self.budget.values())
        )
        return np.where(np.isnan(self.mean), np.nan, total)

    def unknown_at(self, k: int) -> tuple[str, ...]:
        """The unknown parts of `budget` at entry k; none if the mean is undefined or exactly zero."""
        has_error = np.isfinite(self.mean[k]) and self.mean[k] != 0.0
        return tuple(name for name, part in self.budget.items() if has_error and np.isnan(part[k]))


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Estimate(Uncertain):
    """The mean of one observable with its errors; arrays over speed, or of one entry.

    Attributes
    ----------
    mean, standard_error, budget
        As of `Uncertain`.
    observable : str
        Its name.
    unit : str
        SI unit.
    bias : ndarray
        Value at the finest level minus `mean`; zero without extrapolation.
    n : int
        Number of realizations.
    effective_n : ndarray
        Independent realizations that would give the same interval: degrees of freedom and one.
    notes : tuple of str
        Sentences on extrapolation and missing levels, for `explain`.
    speeds : tuple of float
        Of the entries, m/s; empty for an observable that does not depend on the speed.
    sources : mapping of str to str
        Meaning of each part of `budget`.
    """

    observable: str
    unit: str
    bias: Array
    n: int
    effective_n: Array
    notes: tuple[str, ...] = ()
    speeds: tuple[float, ...] = ()
    sources: Mapping[str, str] = field(default_factory=SOURCES.copy)

    @property
    def half_width(self) -> Array:
        """Half-width of the 95 % interval of the scatter (`quantile` with `effective_n` − 1 degrees of freedom)."""
        return self.budget["statistical"]

    @property
    def unknown(self) -> tuple[str, ...]:
        """The unknown parts of `budget` at any entry, by `unknown_at`; `total_error` excludes them."""
        found = {name for k in range(len(self.mean)) for name in self.unknown_at(k)}
        return tuple(name for name in self.budget if name in found)

    def number(self, k: int) -> Number:
        """Return entry k as it is shown, with its total error."""
        return Number(
            float(self.mean[k]), self.unit, float(self.total_error[k]), self.unknown_at(k)
        )

    def parts(self, k: int, names: Iterable[str] | None = None) -> list[Number]:
        """Return the parts of the error of entry k, and the value at the finest level minus the mean, for tables.

        `names` are the columns of the table; a part that `budget` lacks is zero. Default: the names of `budget`.
        """
        errors = [
            float(self.budget[name][k]) if name in self.budget else 0.0
            for name in names or self.budget
        ]
        return [Number(error, self.unit, digits=2) for error in (*errors, float(self.bias[k]))]

    def table(self) -> Table:
        """Return the mean with its total error and the parts of the error, a row per speed."""
        titles = ["mean ± total error", *self.budget, "finest − mean"]
        rows: list[Row] = [[self.number(k), *self.parts(k)] for k in range(len(self.mean))]
        if self.speeds:
            titles = ["speed, m/s", *titles]
            rows = [[f"{speed:g}", *row] for speed, row in zip(self.speeds, rows, strict=True)]
        columns = [Column(title, number=True) for title in titles]
        title = f"{with_unit(self.observable, self.unit)}: {self.n} realizations"
        return Table(
            columns,
            rows,
            title,
            (*self.notes, *(f"{name}: {self.sources[name]}" for name in self.budget)),
        )

    def __repr__(self) -> str:
        means = ", ".join(str(self.number(k)) for k in range(len(self.mean)))
        at = f" at {', '.join(f'{speed:g}' for speed in self.speeds)} m/s" if self.speeds else ""
        return f"<Estimate of {with_unit(self.observable, self.unit)}: {means}{at}; n = {self.n}>"

    def _repr_html_(self) -> str:
        return in_notebook(self.table())

    def explain(self) -> str:
        """Explain the source of each part of the error."""
        lines, (unit, factor) = [], shown(self.unit)
        for k in range(len(self.mean)):
            known = {
                name: part[k] * factor for name, part in self.budget.items() if np.isfinite(part[k])
            }
            parts = ", ".join(f"{name} {part:.2g}" for name, part in known.items())
            lines.append(
                f"{self.number(k)} {unit}".rstrip()
                + f": {parts}; n = {self.n} realizations of the lowest "
                f"level; interval with {self.effective_n[k] - 1:.3g} degrees of freedom; value at the finest level "
                f"{self.bias[k] * factor:+.2g}"
            )
        sources = [
            f"{name}: {self.sources[name]}" for name in self.budget if name not in self.unknown
        ]
        why = dict.fromkeys(self.unknown, "no level of the run shows it")
        if "bandwidth" in why and "last step" in self.budget:
            why["bandwidth"] = (
                "the waves above the highest q_c may change more than the last step to it did"
            )
        missing = [
            f"{name}: unknown: {reason}; not in these figures" for name, reason in why.items()
        ]
        return "\n".join([f"{self.observable}:", *lines, *self.notes, *sources, *missing])


def estimate(observable: str, values: Values, notes: tuple[str, ...] = ()) -> Estimate:
    """Return mean, errors and bias of an observable from its values."""
    mean = values.mean
    error, freedom = spread_of(values.scattered)
    with np.errstate(
        invalid="ignore"
    ):  # slope_length is infinite at rest: its errors are undefined
        bias = values.finest - mean
    budget = _budget(half_width(error, freedom), values.errors)
    n = len(next(iter(values.scatter.values())))
    return Estimate(
        mean, error, budget, observable, UNITS[observable], bias, n, freedom + 1.0, notes
    )


def _budget(statistical: Array, errors: dict[str, Array]) -> dict[str, Array]:
    """Return the parts of the error of a mean by source, "last step" only if it counts."""
    parts = {"statistical": statistical, **errors}
    return {name: part for name, part in parts.items() if name != "last step" or np.any(part)}


def quotient(
    above: Values,
    below: Values | Array,
    *,
    size: Array | float = 0.0,
    scanned: bool = False,
) -> Uncertain:
    """Return the ratio above/below, (speeds,), of two columns, or of a column and exact values, with its errors.

    `size` is a further relative error by the finite cell; `scanned` whether C(q) was measured on maps. The common
    scatter of shared surfaces cancels. The other parts add as squares, because the columns differ in levels and in the
    kind of contact. Exact values share the cut-off of the column and have no errors: then the error by q_c is zero.
    """
    if isinstance(below, Values):
        ratio, columns = above.scattered.over(below.scattered), [above, below]
    else:
        with np.errstate(all="ignore"):
            ratio = above.scattered.times(1.0 / np.broadcast_to(below, above.mean.shape))
        nothing = np.zeros_like(above.mean)
        columns = [
            above._replace(errors=above.errors | {"bandwidth": nothing, "last step": nothing})
        ]
    value = ratio.value
    error, freedom = spread_of(ratio)
    if not np.any(above.mean):  # elastic contact has no plastic area: the ratio is undefined
        value = np.full_like(value, np.nan)
    with np.errstate(all="ignore"):  # 0/0 at rest: the ratio is NaN, and its errors are
        errors = {}
        for name in above.errors:
            relative = np.sqrt(sum((column.errors[name] / column.mean) ** 2 for column in columns))
            errors[name] = np.asarray(np.abs(value) * relative)
        errors["size"] = np.hypot(errors["size"], np.abs(value) * size)
        budget = _budget(half_width(error, freedom), errors)
    if scanned:  # both columns use the one C(q), but nothing shows that its error cancels
        budget["scan"] = np.full(value.shape, np.nan)
    return Uncertain(value, error, budget)


def spread(values: Array) -> tuple[Array, Array]:
    """Return the standard error of the mean over axis 0 of independent rows (n, any), and its degrees of freedom."""
    n, shape = len(values), values.shape[1:]
    if n < 2:
        return np.full(shape, np.inf), np.zeros(shape)
    return np.asarray(values.std(axis=0, ddof=1) / np.sqrt(n)), np.full(shape, n - 1.0)


def spread_of(mean: Mean) -> tuple[Array, Array]:
    """Return the standard error of a mean, and its degrees of freedom after Satterthwaite: variances of streams add.

    Scatter below rounding counts as none: realizations that agree to all digits have no error.
    """
    variances = mean.variance
    freedoms = {stream: max(len(rows) - 1, 1) for stream, rows in mean.scatter.items()}
    with np.errstate(all="ignore"):  # an undefined observable has an undefined error
        variance = np.asarray(sum(variances.values()))
        doubt = np.asarray(sum(part**2 / freedoms[stream] for stream, part in variances.items()))
        most = float(sum(freedoms.values()))
        freedom = np.where(doubt > 0.0, variance**2 / doubt, most)
        error = np.sqrt(variance)
        error = np.where(error <= 1e-12 * np.abs(mean.value), 0.0, error)
    freedom = np.where(np.isinf(error), 0.0, np.minimum(np.nan_to_num(freedom, nan=most), most))
    return error, freedom


def quantile(freedom: Array | float) -> Array:
    """Return the half-width of a 95 % interval in standard errors: Student's t, times √(1 + 2/f).

    Runs tend to stop when the scatter is low by chance, which costs about two of the f degrees of freedom (of order
    1/f: M. Woodroofe, Annals of Statistics 5, 984, 1977). Measured by `experiments/coverage.py`.
    """
    freedom = np.maximum(freedom, 1.0)
    factor: Array = scipy.special.stdtrit(freedom, 0.975) * np.sqrt(1.0 + 2.0 / freedom)
    return factor


def half_width(error: Array, freedom: Array) -> Array:
    """Return the half-width of the 95 % interval of a mean; its standard error without degrees of freedom."""
    with np.errstate(invalid="ignore"):
        return np.where(freedom > 0.0, error * quantile(freedom), error)
