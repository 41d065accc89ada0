"""Means over the distribution of the temperature of the contact, continued to the end of C(q), with their errors.

Relative to T_flash the distribution depends little on the cut-off and the pixel. So the bins of each level are scaled
until its mean T_flash is the continued one, and the levels show the little that is left. A rate of reaction,
ν⟨exp(−(E − σV)/k_B T)⟩ over the contact, depends steeply on the temperature: its errors follow from those of T_flash by
its slope over ln T_flash.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from roughsim import prediction
from roughsim.estimate.contacts import SETTLED, Contacts, factor_of
from roughsim.estimate.levels import FLASH
from roughsim.estimate.limit import by_steps
from roughsim.estimate.mean import Mean, exact, mean_of
from roughsim.estimate.sliding import UNCERTAINTY_OF_DISTRIBUTION
from roughsim.estimate.telescoping import LevelMean, change_by_pixel, is_refined, telescoped
from roughsim.grid import Array
from roughsim.observables.distribution import (
    Bins,
    areas_of,
    shares_of,
    two_pressures,
)
from roughsim.observables.record import Sample, bins_of
from roughsim.scene import Scene
from roughsim.scene.numerics import SAME

BOLTZMANN = 1.380649e-23  # J/K
ELECTRONVOLT = 1.602176634e-19  # J
LEAST_MEMBERS = 4.0  # effective ones that carry a mean: of fewer the scatter is unknown
_MOST_OF_TAIL = 0.25  # share of a mean from the hottest pixels, beyond which it is unknown
_COLDEST = 1e-3  # K, absolute: colder bins, of a field below its mean, do not react either
_ROUNDING = 1e-6  # of the temperature, relative, of bins within one pixel
_STEP = 1e-3  # of ln T_flash, for slopes
_ITERATIONS = 50  # of Newton's method for a uniform temperature; a few suffice
OverBins = Callable[
    [Bins, Array], Array
]  # bins and the factor of their temperatures → values of bins
OfMean = Callable[
    [Bins, Array], tuple[Array, Array, Array]
]  # bins and influence values of their mean → as of `Activation.uniform_temperature`


class Activation(NamedTuple):
    """The barrier of a reaction, and the absolute temperature on which the contact's own comes.

    Rates are over exp(`scale`), their largest exponent, so that none overflows. `factor`, (speeds,), multiplies the
    temperatures of bins.
    """

    energy: float  # E, J
    volume: float  # V, m³
    base: Array  # K, (speeds,)
    scale: Array = np.zeros(1)  # (speeds,)

    def energies_of(self, bins: Bins) -> tuple[Array, Array]:
        """Return σV − E, J, of the two pressures of each bin, and their shares of its area, (2, ..., speeds, bins)."""
        pressures, shares = (np.array(pair) for pair in zip(*two_pressures(bins), strict=True))
        return pressures * self.volume - self.energy, shares

    def exponents(self, bins: Bins, factor: Array) -> tuple[Array, Array]:
        """Return (σV − E)/k_B T of the two pressures of each bin, and their shares, as of `energies_of`."""
        own = factor[:, None] * bins.temperature
        temperature = np.maximum(self.base[:, None] + own, _COLDEST)
        energies, shares = self.energies_of(bins)
        return energies / (BOLTZMANN * temperature), shares

    def log_scale(self, bins: Bins, factor: Array) -> Array:
        """Return the largest exponent of any bin at each speed, (speeds,)."""
        of_bins, _ = self.exponents(bins, factor)
        return of_bins.max(axis=(*range(of_bins.ndim - 2), -1))

    def rates(self, bins: Bins, factor: Array) -> Array:
        """Return the mean of exp((σV − E)/k_B T − scale) over each bin, (..., speeds, bins)."""
        of_bins, shares = self.exponents(bins, factor)
        return (shares * np.exp(of_bins - self.scale[:, None])).sum(axis=0)

    def uniform_temperature(self, bins: Bins, rows: Array) -> tuple[Array, Array, Array]:
        """Return the absolute temperature, K, at which all bins together have the mean of `rates`, (speeds,).

        `rows` are influence values of the mean, (n, speeds). Beside the temperature are its slope over the mean,
        (speeds,), and its influence values, (n, speeds). With b = 1/k_B T, ln⟨exp(b(σV − E))⟩ = L is solved by
        Newton's method; without V it is linear in b. NaN without a barrier: then no temperature is singled out.
        """
        mean = rows.mean(axis=0)
        energies, shares = self.energies_of(bins)
        areas = shares * areas_of(bins)
        with np.errstate(all="ignore"):  # without a barrier all is NaN
            log_mean = np.log(mean) + self.scale
            inverse = log_mean / (areas * energies).mean(axis=1).sum(axis=(0, 2))
            for _ in range(_ITERATIONS if self.volume else 1):
                exponents = inverse[:, None] * energies
                largest = exponents.max(axis=(0, 1, 3))
                terms = areas * np.exp(exponents - largest[:, None]) / energies.shape[1]
                total = terms.sum(axis=(0, 1, 3))
                barrier = -(terms * energies).sum(axis=(0, 1, 3)) / total
                inverse = inverse + (np.log(total) + largest - log_mean) / barrier
            # the mean of each contact at this temperature
            exponents = inverse[:, None] * energies - self.scale[:, None]
            uniform = (areas * np.exp(exponents)).sum(axis=(0, 3))
            uniform -= mean * (areas.sum(axis=(0, 3)) - 1.0)
            temperature = np.where(barrier > 0.0, 1.0 / (BOLTZMANN * inverse), np.nan)
            slope = BOLTZMANN * temperature**2 / (barrier * mean)
        return temperature, slope, temperature + slope * (rows - uniform)

    def of_uniform_temperature(self, warm: Mean, sample: Sample) -> Mean:
        """Return the mean of `rates` at an activation temperature.

        Along the levels T_act follows T_flash nearly in a straight line, and the rate does not: so T_act is continued,
        and the rate follows from it.
        """
        bins = bins_of(sample)
        energies, shares = self.energies_of(bins)

        def mean_at(temperature: Array) -> Array:
            exponent = energies / (BOLTZMANN * temperature[:, None]) - self.scale[:, None]
            return (shares * areas_of(bins) * np.exp(exponent)).mean(axis=1).sum(axis=(0, 2))

        mean = mean_at(warm.value)
        with np.errstate(all="ignore"):
            slope = 1.0 / self.uniform_temperature(bins, mean[None])[1]
        return warm.through(mean, mean_at(warm.finest), slope)


def heat_above(bins: Bins, factor: Array, excess: Array) -> Array:
    """Return the share of the heat of the contact where it is hotter than an excess over the background, K.

    `excess` is (speeds,), the result (n, speeds). Between the middles of two bins the share is linear in the
    temperature.
    """
    scaled = bins._replace(temperature=factor[:, None] * bins.temperature)
    return 1.0 - shares_of(scaled, "heat").colder(excess[:, None])[..., 0]


def _itself(bins: Bins, rows: Array) -> tuple[Array, Array, Array]:
    """Return a mean as a function of itself, as `Activation.uniform_temperature`."""
    mean = rows.mean(axis=0)
    return mean, np.ones_like(mean), rows


class ContactMean(NamedTuple):
    """A mean over the contact of a function of its bins, or a function of this mean, at the continued T_flash."""

    of_bins: OverBins
    flash: Mean  # reported T_flash, to which the bins of each level are scaled
    of_mean: OfMean = _itself
    # whether `of_bins` gives the mean of each contact by heat, (n, speeds), not of each bin
    by_contact: bool = False

    def scaled(self, sample: Sample, step: float = 0.0) -> Array:
        """Return the function of the bins of a sample, T_flash (1 + step) times the continued one."""
        return self.of_bins(bins_of(sample), factor_of(sample, self.flash) * (1.0 + step))

    def mean(self, sample: Sample, step: float = 0.0) -> Array:
        """Return the mean of each contact, times its area over the mean area, (n, speeds)."""
        values = self.scaled(sample, step)
        return values if self.by_contact else (values * areas_of(bins_of(sample))).sum(axis=-1)

    def slope(self, sample: Sample) -> Array:
        """Return the slope of the mean over ln T_flash, (speeds,)."""
        rise = (self.mean(sample, _STEP) - self.mean(sample, -_STEP)).mean(axis=0)
        return rise / (2.0 * _STEP)

    def influence(self, sample: Sample) -> Array:
        """Return influence values, (n, speeds): each level has its own mean T_flash, and its own mean area."""
        bins, own, rows = bins_of(sample), sample.numbers[FLASH], self.mean(sample)
        if not self.by_contact:
            rows = rows - rows.mean(axis=0) * (areas_of(bins).sum(axis=-1) - 1.0)
        rows = rows - self.slope(sample) * (own / own.mean(axis=0) - 1.0)
        return self.of_mean(bins, rows)[2]

    def value(self, sample: Sample) -> Array:
        """Return the mean over all contacts, or the function of it, (speeds,)."""
        return self.of_mean(bins_of(sample), self.mean(sample))[0]

    def derivative(self, sample: Sample) -> Array:
        """Return the derivative of the function of the mean, (speeds,); 1 without one."""
        return self.of_mean(bins_of(sample), self.mean(sample))[1]

    def tail(self, sample: Sample) -> Array:
        """Return the share of the mean from bins within the hottest pixel of each contact, (speeds,)."""
        if self.by_contact:
            return np.zeros(self.flash.value.shape)
        temperature = bins_of(sample).temperature
        hottest = temperature >= temperature[..., -1:] * (1.0 - _ROUNDING)
        of_areas = self.scaled(sample) * areas_of(bins_of(sample))
        return (of_areas * hottest).sum(axis=(0, -1)) / of_areas.sum(axis=(0, -1))

    def members(self, sample: Sample) -> Array:
        """Return the effective number of members that carry the mean, (Σ y)²/Σ y², (speeds,)."""
        rows = self.mean(sample)
        with np.errstate(invalid="ignore"):  # 0/0 of a share that no member has
            return rows.sum(axis=0) ** 2 / (rows**2).sum(axis=0)


def mean_over_contact(contacts: Contacts, of_level: ContactMean) -> Mean:
    """Return a mean over the contacts of a column, at the T_flash of `of_level`, and its errors.

    What of it changes with the cut-off at one T_flash follows the law of T_flash by steps. All of this rest counts as
    an error, since it is small and only a guess. The change by the continued distribution of slides counts as an error,
    since it is that of frozen contacts. Those by T_flash follow from the slope over it.
    """
    top = contacts.samples[-1]
    flash = of_level.flash
    derivative = of_level.derivative(top)
    slope = derivative * of_level.slope(top)
    if contacts.stretch is not None:
        mean = mean_of(top.stream, of_level.influence(top))
        narrow = mean_of(top.stream, of_level.influence(top.below or top)).value
        mean = replace(mean, finest=narrow)
        own = {"slide": np.hypot(UNCERTAINTY_OF_DISTRIBUTION * slope, mean.value - narrow)}
    else:
        levels = telescoped(of_level.influence, contacts.samples)
        rest = rest_of(levels, contacts.law)
        mean = replace(levels[-1].mean + rest, finest=levels[-1].mean.value)
        own = {**rest.errors}
        if contacts.fall is not None:
            change = change_by_pixel(levels, np.nan, contacts.fall, contacts.end)
            mean = replace(mean * (change + 1.0), finest=mean.finest)
            own["pixel"] = np.abs(mean.value) * change.errors["pixel"]
    with np.errstate(all="ignore"):  # T_flash is zero at rest
        by_flash = np.nan_to_num(slope / flash.value, posinf=0.0, neginf=0.0)
    nothing = np.zeros_like(slope)
    found = replace(mean, errors={}) + flash.through(nothing, nothing, by_flash)
    errors = {name: np.hypot(own.get(name, 0.0), part) for name, part in found.errors.items()}
    tail = of_level.tail(top)
    of_tail = np.abs(derivative) * tail * of_level.mean(top).mean(axis=0)
    errors["tail"] = np.where(tail > _MOST_OF_TAIL, np.nan, of_tail)
    if contacts.form is not None:
        errors["form"] = contacts.by_form(of_level.value)
    return replace(found, errors=errors, way=flash.way)


def law_of_flash(scene: Scene, column: str, samples: Sequence[Sample], end: float) -> Array | None:
    """Return the law that T_flash of a simulated column follows up to the cut-off `end`, rad/m, as of `Contacts`."""
    q = tuple(sample.q_max for sample in samples if not is_refined(sample))
    if len(q) < 2 or q[-1] >= end * (1.0 - SAME):  # the rest of one level is that of T_flash
        return SETTLED
    law = prediction.calibrated_flash(scene, column, q)
    return prediction.continuation(scene, column, q, FLASH) if law is None else law


def rest_of(levels: list[LevelMean], law: Array | None) -> Mean:
    """Return the rest beyond the highest cut-off by steps of a law, and all of it as its error; NaN without a law."""
    if law is None or not np.isfinite(law).all():
        nothing = np.zeros_like(levels[-1].mean.value)
        return replace(exact(nothing), errors={"bandwidth": np.full_like(nothing, np.nan)})
    rest = by_steps(levels, law)
    return replace(rest, errors={"bandwidth": np.abs(rest.value)})
