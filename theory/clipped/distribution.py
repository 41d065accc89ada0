"""Statistics of the temperature at the points of drawn contacts: quantiles, deviation, and rates of reactions.

Each value is found from all fields, and its standard error from what it is without one of them (jackknife).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from theory.arguments import Array, not_negative_array, positive, real_array

BOLTZMANN = 1.380649e-23  # J/K
_COLDEST = 1e-3  # K: colder points, of a contact far below its mean, do not react either
_ITERATIONS = 60  # of Newton's method; a few suffice
_SHIFT = 1.4  # of all temperatures, over T_flash and the doubt: contact that the law lacks is cold
_AT_ONE, _PER_E_FOLD, _DOUBTS = (
    0.17,
    0.02,
    (0.06, 0.24),
)  # of `form_doubt`: at 1, its fall, least and most

Weight = Literal["heat", "area"]
Numbers = NDArray[np.intp]
Fields = NDArray[np.bool_]  # which of the fields are kept, or which of the points


class Estimate(NamedTuple):
    """A value with its standard error by the jackknife over the drawn fields, NaN of one; arrays of one shape."""

    value: Array
    standard_error: Array


@dataclass(frozen=True, slots=True, eq=False)
class TemperatureDistribution:
    """Temperatures at the points of drawn contacts; made by `temperature_distribution`.

    Attributes
    ----------
    flash_temperature : ndarray
        T_flash of the calibrated law with all the heat in the body, K, shape (speeds,).
    contact_fraction : float
        A/A₀ of the calibrated law.
    ratio : ndarray
        T/T_flash at each point of contact of all fields, shape (speeds, points). Its mean over the heat is 1.
    pressure : ndarray
        Pa at these points, shape (points,).
    field : ndarray
        Number of the field to which each point belongs, shape (points,).
    wrong_share : float
        Share of the variance of the pressure that no clipped Gaussian field has on the waves of the law.
    doubt : ndarray or float
        Of T/T_flash by the form of the fields, at each speed (`form_doubt`); 0: the contacts are solved. `doubted`
        applies it.
    """

    flash_temperature: Array
    contact_fraction: float
    ratio: Array
    pressure: Array
    field: Numbers
    wrong_share: float
    doubt: Array | float = 0.0

    def doubted(self) -> tuple[Self, ...]:
        """Return three distributions as far from this one as its form is in doubt, 95 %.

        At the distance x from T_flash, over T_flash, the hotter, or the colder points, are nearer to it by
        `doubt`·x^(3/2); or all are hotter by 1.4 `doubt`. The changes of a value by the three add as squares.
        """
        doubt = np.broadcast_to(self.doubt, self.flash_temperature.shape)[:, None]
        with np.errstate(
            divide="ignore"
        ):  # the order of the points stays: further out all come to the same
            apart = np.minimum(np.abs(self.ratio - 1.0), 4.0 / 9.0 / doubt**2)
        evened = 1.0 + np.sign(self.ratio - 1.0) * (apart - doubt * apart**1.5)
        warmer = self.flash_temperature * (1.0 + _SHIFT * doubt[:, 0])
        sides = [
            np.where(side, evened, self.ratio) for side in (self.ratio > 1.0, self.ratio < 1.0)
        ]
        return (
            *(replace(self, ratio=ratio) for ratio in sides),
            replace(self, flash_temperature=warmer),
        )

    def quantiles(self, shares: ArrayLike, by: Weight = "heat") -> Estimate:
        """Temperatures that these shares of the heat, or of the contact area, do not exceed.

        Parameters
        ----------
        shares : array_like
            Numbers from 0 to 1, shape (n,).
        by : {"heat", "area"}
            Weight of each point: its heat, μvσ, or its area.

        Returns
        -------
        Estimate
            K above the background, with all the heat in the body, shape (n, speeds).

        Raises
        ------
        TypeError, ValueError
            If `shares` are not numbers from 0 to 1, or `by` is neither.
        """
        levels = np.atleast_1d(not_negative_array("shares", shares, "1"))
        if (levels > 1.0).any():
            raise ValueError(f"shares = {levels.max():.6g} must lie from 0 to 1")
        weight = self._weight(by)
        columns = []
        for ratio, flash in zip(self.ratio, self.flash_temperature.tolist(), strict=True):
            order = np.argsort(ratio)
            points = ratio[order], weight[order], self.pressure[order], self.field[order]
            columns.append(self._jackknife(partial(_quantiles, points, levels, flash)))
        return Estimate(*(np.stack(values, axis=-1) for values in zip(*columns, strict=True)))

    def deviation(self, by: Weight = "heat") -> Estimate:
        """Standard deviation of the temperature over the contact, K, shape (speeds,).

        `by` as in `quantiles`. ValueError if it is neither "heat" nor "area".
        """
        weight = self._weight(by)

        def spread(kept: Fields) -> Array:
            held = kept[self.field]
            mean = self.ratio @ (weight * held) / (weight @ held)
            square = (self.ratio - mean[:, None]) ** 2 @ (weight * held) / (weight @ held)
            return np.asarray(self.flash_temperature * np.sqrt(square) / self._scale(held))

        return self._jackknife(spread)

    def share_above(self, temperature: ArrayLike, by: Weight = "heat") -> Estimate:
        """Share of the heat, or of the contact area, where the body is hotter than a temperature.

        `temperature` is K above the background with all the heat in the body, one number, or one for each speed; `by`
        as in `quantiles`. Returns shape (speeds,). TypeError or ValueError if it is not real and finite, or `by` is
        neither "heat" nor "area".
        """
        weight = self._weight(by)
        limit = np.broadcast_to(
            real_array("temperature", temperature, "K"), self.flash_temperature.shape
        )

        def share(kept: Fields) -> Array:
            held = kept[self.field]
            hot = (
                self.flash_temperature[:, None] * self.ratio / self._scale(held)[:, None]
                > limit[:, None]
            )
            return np.asarray(hot @ (weight * held) / (weight @ held))

        return self._jackknife(share)

    def reaction_rate(
        self,
        activation_energy: ArrayLike,
        *,
        background_temperature: ArrayLike,
        heat_partition: ArrayLike = 1.0,
        prefactor: float = 1.0,
        activation_volume: float = 0.0,
    ) -> Estimate:
        """Rate of a thermally activated reaction, (A/A₀) ⟨ν exp(−(E − σV)/k_B T)⟩, the mean over the contact area.

        Parameters
        ----------
        activation_energy : array_like
            E, J, shape (n,).
        background_temperature : array_like
            Absolute mean temperature of the surface, K: one number, or one for each speed.
        heat_partition : array_like
            Share of the heat that enters the body, one number, or one for each speed.
        prefactor : float
            ν, 1/s.
        activation_volume : float
            V, m³, of either sign.

        Returns
        -------
        Estimate
            1/s per nominal area, shape (n, speeds).

        Raises
        ------
        TypeError, ValueError
            If an argument is not real, finite and of the right sign.
        """
        mean = self._arrhenius(
            activation_energy, background_temperature, heat_partition, activation_volume
        )
        factor = self.contact_fraction * positive("prefactor", prefactor, "1/s")
        logarithm, error = self._jackknife(mean)
        rate = factor * np.exp(logarithm)
        return Estimate(rate, rate * error)

    def activation_temperature(
        self,
        activation_energy: ArrayLike,
        *,
        background_temperature: ArrayLike,
        heat_partition: ArrayLike = 1.0,
        activation_volume: float = 0.0,
    ) -> Estimate:
        """Absolute temperature at which a contact of even temperature, with the same pressures, reacts as fast, K.

        ⟨exp((σV − E)/k_B T_act)⟩ = ⟨exp((σV − E)/k_B T)⟩ over the contact area. Shape (n, speeds); NaN without a
        barrier, E = 0. Parameters, errors: as `reaction_rate`.
        """
        mean = self._arrhenius(
            activation_energy, background_temperature, heat_partition, activation_volume
        )
        logarithm, error = self._jackknife(mean)
        pressure, count = np.unique(self.pressure, return_counts=True)
        result = np.full((2, *logarithm.shape), np.nan)
        for n, energy in enumerate(np.atleast_1d(activation_energy)):
            for m, known in enumerate(logarithm[n]):
                inverse, barrier = _even(
                    activation_volume * pressure - energy, count / count.sum(), known
                )
                if barrier > 0.0:
                    kelvin = 1 / (BOLTZMANN * inverse)
                    result[:, n, m] = kelvin, BOLTZMANN * kelvin**2 / barrier * error[n, m]
        return Estimate(*result)

    def _arrhenius(
        self,
        activation_energy: ArrayLike,
        background: ArrayLike,
        partition: ArrayLike,
        volume: float,
    ) -> Callable[[Fields], Array]:
        """Return the function that gives ln ⟨exp(−(E − σV)/k_B T)⟩ over the kept fields, shape (energies, speeds)."""
        energy = np.atleast_1d(not_negative_array("activation_energy", activation_energy, "J"))
        speeds = self.flash_temperature.shape
        start = np.broadcast_to(
            not_negative_array("background_temperature", background, "K"), speeds
        )
        share = np.broadcast_to(real_array("heat_partition", partition, "1"), speeds)
        lowered = float(real_array("activation_volume", volume, "m³")) * self.pressure

        def mean(kept: Fields) -> Array:
            held = kept[self.field]
            scale = share * self.flash_temperature / self._scale(held)
            result = np.empty((energy.size, *speeds))
            for n, ratio in enumerate(self.ratio):
                kelvin = np.maximum(start[n] + scale[n] * ratio[held], _COLDEST)
                for m, barrier in enumerate(energy):
                    exponent = -(barrier - lowered[held]) / (BOLTZMANN * kelvin)
                    highest = exponent.max()
                    result[m, n] = highest + np.log(np.exp(exponent - highest).mean())
            return result

        return mean

    def _weight(self, by: Weight) -> Array:
        if by not in ("heat", "area"):
            raise ValueError(f'by = {by!r} must be "heat" or "area"')
        return self.pressure if by == "heat" else np.ones(self.pressure.shape)

    def _scale(self, held: Fields) -> Array:
        """Return the mean of `ratio` over the heat of the points that are held: T_flash of their fields."""
        return np.asarray(self.ratio[:, held] @ self.pressure[held] / self.pressure[held].sum())

    def _jackknife(self, estimate: Callable[[Fields], Array]) -> Estimate:
        """Return an estimate from all fields, and its standard error from those without one of them."""
        count = int(self.field[-1]) + 1
        if count == 1:
            value = estimate(np.ones(1, bool))
            return Estimate(value, np.full_like(value, np.nan))
        without = np.stack([estimate(np.arange(count) != k) for k in range(count)])
        error = np.sqrt((count - 1) * without.var(axis=0))
        return Estimate(estimate(np.ones(count, bool)), np.asarray(error))


def form_doubt(peclet_number: ArrayLike) -> Array:
    """Return `TemperatureDistribution.doubt` of drawn fields at `peclet_number`, v h_rms/(D h′), dimensionless.

    Solved contacts are evener than the fields, the slower the more: at rest the surface bounds their temperature, while
    the fields do not know it. That they yield makes little difference. Set on 29 contacts that were drawn by chance,
    tested on 13 others (experiments/reactions.py).
    """
    with np.errstate(divide="ignore"):
        return np.asarray(np.clip(_AT_ONE - _PER_E_FOLD * np.log(peclet_number), *_DOUBTS))


def _quantiles(
    points: tuple[Array, Array, Array, NDArray[np.intp]], levels: Array, flash: float, kept: Fields
) -> Array:
    """Return quantiles of the temperature, K, at points of ascending T/T_flash with weight, pressure and field."""
    ratio, weight, pressure, field = points
    held = kept[field]
    kept_weight = weight * held
    below = np.cumsum(kept_weight)
    middle = (below - kept_weight / 2) / below[-1]
    return np.asarray(
        flash * np.interp(levels, middle, ratio) / np.average(ratio, weights=pressure * held)
    )


def _even(released: Array, share: Array, known: float) -> tuple[float, float]:
    """Return the 1/k_B T at which ln ⟨exp(x/k_B T)⟩ = `known`, and the mean of −x there, weighted by exp(x/k_B T).

    x = σV − E, J, has the shares of the area.
    """
    inverse = barrier = 0.0
    for _ in range(_ITERATIONS):
        exponent = inverse * released
        terms = share * np.exp(exponent - exponent.max())
        barrier = -float(terms @ released / terms.sum())
        if barrier == 0.0:
            break
        step = (float(np.log(terms.sum()) + exponent.max()) - known) / barrier
        inverse += step
        if abs(step) <= 1e-13 * abs(inverse):
            break
    return inverse, barrier
