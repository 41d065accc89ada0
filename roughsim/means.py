"""The observables, and each as a smooth function of ensemble means.

The realizations of one level enter through their influence values (the delta method): one row per realization, whose
mean is the observable and whose scatter gives its error. Ratios of observables then keep the pairing of the rows.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import j0, j1

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


class Sample(NamedTuple):
    """The numbers of one level, a row per realization that has it.

    `numbers` has arrays (n, speeds) or (n, 1); `wavenumber` (m,), rad/m, and `spectrum` (n, m), Pa², are the radial
    stress spectra, which hold up to the distance `reach`, m. `side` is the number of points along a side, `rows` (n,)
    the place of each row among all realizations.
    """

    q_max: float
    side: float
    rows: NDArray[np.intp]
    numbers: dict[str, Array]
    wavenumber: Array
    spectrum: Array
    reach: float

    def at(self, rows: NDArray[np.intp]) -> Sample:
        """Return the sample of some of its realizations."""
        chosen = np.isin(self.rows, rows)
        numbers = {name: values[chosen] for name, values in self.numbers.items()}
        return self._replace(rows=self.rows[chosen], numbers=numbers, spectrum=self.spectrum[chosen])


def of_level(observable: str, sample: Sample, resting_ratio: float | Array) -> Array:
    """Return the influence values (n, speeds) of an observable at one level.

    Parameters
    ----------
    observable : str
        A key of `UNITS`.
    sample : Sample
        The level.
    resting_ratio : float or ndarray
        κ of the moving over κ of the resting body, one or (speeds,), for the heat share; NaN without a conducting
        counterface.
    """
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
        return np.full((len(sample.spectrum), 1), np.nan)
    slope = -float((mean * q) @ j1(q * r))
    excess = sample.spectrum @ (j0(q * r) - fraction)
    return (r - excess / slope)[:, None]


def ratio(above: Array, below: Array) -> Array:
    """Influence values of ⟨above⟩/⟨below⟩ with the pairing of the rows kept."""
    return _product(above, below, 1.0)
