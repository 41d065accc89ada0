"""Means with their errors: from the numbers of the realizations to one value per observable and speed.

Every observable is a smooth function of ensemble means, so its realizations enter through their influence values
(the delta method): `values` has one row per realization whose mean is the estimate, and whose scatter gives its error.
Ratios of observables then keep the pairing of the realizations. Values solved up to several cut-offs q_c are
extrapolated to q_c → ∞ as T∞ + c q_c^(−p).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import nan, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import j0, j1
from scipy.stats import t as student

from roughsim.observables import StressSpectrum

Array = NDArray[np.float64]

# every observable with its SI unit, in the order of all tables
UNITS = {
    "flash_temperature": "K",
    "flash_gradient": "K/m",
    "flash_laplacian": "K/m^2",
    "flash_width": "m",
    "slope_length": "m",
    "heat_partition": "1",
    "contact_fraction": "1",
    "plastic_fraction": "1",
    "pressure_variance": "Pa^2",
    "correlation_radius_50": "m",
    "correlation_radius_10": "m",
    "correlation_radius_0": "m",
}
RADII = {"correlation_radius_50": 0.5, "correlation_radius_10": 0.1, "correlation_radius_0": 0.0}
PER_SPEED = ("flash_temperature", "flash_gradient", "flash_laplacian", "flash_width", "slope_length", "heat_partition")
# capped contact has steep edges of its plastic patches: these have no limit in q_c and are never extrapolated
NO_LIMIT = ("flash_gradient", "flash_laplacian", "flash_width", "slope_length")
# fixed by force balance where all contact has yielded, at every q_c that a plan chooses: nothing to extrapolate
BY_FORCE_BALANCE = ("contact_fraction", "plastic_fraction", "pressure_variance")
# the exponent of the extrapolation was measured as 0.90…1.15 on three steels, up to four cut-offs; ±0.2 moves the bias
# by a quarter of itself
_BIAS_DOUBT = 0.25


class Sample(NamedTuple):
    """The numbers of one level, a row per realization.

    `numbers` has arrays (n, speeds) or (n, 1); `wavenumber` (m,), rad/m, and `spectrum` (n, m), Pa², are the radial
    stress spectra, which hold up to the distance `reach`, m.
    """

    q_max: float
    numbers: dict[str, Array]
    wavenumber: Array
    spectrum: Array
    reach: float


class Values(NamedTuple):
    """One observable: a row per realization, (n, speeds), extrapolated and at the finest level."""

    extrapolated: Array
    finest: Array
    exponent: float


@dataclass(frozen=True, slots=True, eq=False)
class Estimate:
    """The mean of one observable with its errors; arrays over speed, or of one entry.

    Attributes
    ----------
    observable, unit : str
        What it is, and its SI unit.
    mean : ndarray
        Extrapolated in q_c where that has a limit and several q_c were solved.
    standard_error, half_width : ndarray
        Statistical: of the mean, and of its 95 % interval (Student t).
    bias : ndarray
        Value at the finest level minus `mean`; zero where nothing is extrapolated.
    total_error : ndarray
        √(half_width² + doubt²), the doubt being a quarter of the bias: the exponent of the extrapolation is not exact.
    n : int
        Realizations.
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
    n: int
    notes: tuple[str, ...] = ()

    def explain(self) -> str:
        """Say in plain words where each part of the error comes from."""
        rows = zip(self.mean, self.half_width, self.bias, self.total_error, strict=True)
        lines = [
            f"{mean:.6g} {self.unit}: ± {half:.2g} statistical (95 %, n = {self.n}), finest level {bias:+.2g}, "
            f"± {total:.2g} in all"
            for mean, half, bias, total in rows
        ]
        return "\n".join([f"{self.observable}:", *lines, *self.notes])


def estimate(observable: str, values: Values, notes: tuple[str, ...] = ()) -> Estimate:
    """Return mean, errors and bias of an observable from its values.

    Parameters
    ----------
    observable : str
        A key of `UNITS`.
    values : Values
        From `observe`.
    notes : tuple of str, optional
        For `Estimate.explain`.
    """
    n = len(values.extrapolated)
    mean = values.extrapolated.mean(axis=0)
    error = standard_error(values.extrapolated)
    half = error * float(student.ppf(0.975, n - 1)) if n > 1 else error
    with np.errstate(invalid="ignore"):
        bias = values.finest.mean(axis=0) - mean
    total = np.hypot(half, _BIAS_DOUBT * bias)
    return Estimate(observable, UNITS[observable], mean, error, half, bias, total, n, notes)


def standard_error(values: Array) -> Array:
    """Return the standard error of the mean over axis 0; infinite for one realization.

    Scatter below rounding counts as none: realizations that agree to all digits have no error.
    """
    n = len(values)
    if n < 2:
        return np.full(values.shape[1:], np.inf)
    with np.errstate(invalid="ignore"):  # an undefined observable has an undefined error
        scatter = values.std(axis=0, ddof=1)
    rounding = 1e-12 * np.abs(values).max(axis=0)
    error: Array = np.where(scatter <= rounding, 0.0, scatter) / sqrt(n)
    return error


def observe(observable: str, samples: list[Sample], *, capped: bool, resting_ratio: float = nan) -> Values:
    """Return the values of an observable from the levels of one column.

    Parameters
    ----------
    observable : str
        A key of `UNITS`.
    samples : list of Sample
        The levels of the column, coarsest q_c first; rows are paired.
    capped : bool
        Whether the contact is capped: decides what has a limit in q_c.
    resting_ratio : float, optional
        κ of the moving over κ of the resting body, for the heat share; NaN without a conducting counterface.
    """
    finest = _of_level(observable, samples[-1], resting_ratio)
    if len(samples) == 1 or (capped and observable in (*NO_LIMIT, *BY_FORCE_BALANCE)):
        return Values(finest, finest, nan)
    coarser = _of_level(observable, samples[-2], resting_ratio)
    ratio = samples[-1].q_max / samples[-2].q_max
    exponent = 1.0
    if len(samples) > 2:
        coarsest = _of_level(observable, samples[-3], resting_ratio)
        exponent = fitted_exponent([s.q_max for s in samples[-3:]], [coarsest, coarser, finest])
    return Values(finest + (finest - coarser) / (ratio**exponent - 1.0), finest, exponent)


def fitted_exponent(cutoffs: list[float], values: list[Array]) -> float:
    """Return p of T∞ + c q_c^(−p) through the means at three cut-offs, between 0.3 and 3; 1 where they allow none."""
    a, b, c = (float(np.mean(v)) for v in values)
    if (a - b) * (b - c) <= 0.0:
        return 1.0

    def excess(p: float) -> float:
        x, y, z = (q**-p for q in (np.array(cutoffs) / cutoffs[0]))
        return float((x - y) / (y - z) - (a - b) / (b - c))

    low, high = excess(0.3), excess(3.0)
    return float(brentq(excess, 0.3, 3.0)) if low * high < 0.0 else 1.0


def _of_level(observable: str, sample: Sample, resting_ratio: float) -> Array:
    numbers = sample.numbers
    if observable in RADII:
        return _radius(sample, RADII[observable])
    if observable == "flash_width":
        return _product(numbers["flash_temperature"], -numbers["flash_laplacian"], 0.5)
    if observable == "slope_length":
        return _product(numbers["flash_temperature"], -numbers["flash_gradient"], 1.0)
    if observable == "heat_partition":
        resting = numbers["resting_flash_temperature"] * resting_ratio
        return _share(resting, numbers["flash_temperature"])
    return numbers[observable]


def _product(above: Array, below: Array, power: float) -> Array:
    """Influence values of (⟨above⟩/⟨below⟩)^power."""
    top, bottom = above.mean(axis=0), below.mean(axis=0)
    with np.errstate(all="ignore"):  # what is undefined here is NaN in the end
        value = (top / bottom) ** power
        change: Array = value * (1.0 + power * ((above - top) / top - (below - bottom) / bottom))
    return np.where(np.isfinite(change), change, value)


def _share(resting: Array, moving: Array) -> Array:
    """Influence values of ⟨T_stat⟩/(⟨T_stat⟩ + ⟨T_mov⟩)."""
    still, slid = resting.mean(axis=0), moving.mean(axis=0)
    whole = still + slid
    change: Array = still / whole + (slid * (resting - still) - still * (moving - slid)) / whole**2
    return change


def _radius(sample: Sample, fraction: float) -> Array:
    """Influence values of the smallest r with g(r) = fraction·g(0) of the mean spectrum; NaN if there is none."""
    q, mean = sample.wavenumber, sample.spectrum.mean(axis=0)
    r = StressSpectrum(q, mean, sample.reach).correlation_radius(fraction)
    if not np.isfinite(r):
        return np.full((len(sample.spectrum), 1), nan)
    slope = -float((mean * q) @ j1(q * r))
    excess = sample.spectrum @ (j0(q * r) - fraction)
    return (r - excess / slope)[:, None]


def ratio(above: Array, below: Array) -> Array:
    """Influence values of ⟨above⟩/⟨below⟩ with the pairing of the rows kept."""
    return _product(above, below, 1.0)


def stopping_point(values: list[tuple[Array, float]], *, least: int = 12) -> int | None:
    """Return the smallest n ≥ `least` at which all targets hold on the first n rows; None if at none.

    Each entry is (values (rows, speeds), target): the relative 95 % half-width at the worst speed.
    """
    rows = min(len(rows) for rows, _ in values)
    for n in range(least, rows + 1):
        if all(relative_half_width(rows[:n]) <= target for rows, target in values):
            return n
    return None


def relative_half_width(values: Array) -> float:
    """Return the relative 95 % half-width of the mean at the worst speed; infinite for fewer than two rows."""
    if len(values) < 2:
        return float("inf")
    half = standard_error(values) * float(student.ppf(0.975, len(values) - 1))
    mean = np.abs(values.mean(axis=0))
    relative = np.divide(half, mean, out=np.zeros_like(half), where=half > 0.0)
    return float(relative.max())


__all__ = ["Estimate", "Sample", "Values", "estimate", "observe", "ratio", "stopping_point"]
