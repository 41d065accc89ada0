"""Drawn clipped Gaussian fields on a periodic square cell, and the temperature of their heat; no contact is solved."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, pi

import numpy as np
import scipy
from numpy.typing import NDArray

from theory.arguments import Array
from theory.clipped.field import ClippedField

_ITERATIONS = 12  # of the power of z: then 1 to 3 % of the power of the pressure still moves under the lightest load
_FAINT = 1e-4  # of a power: less counts as that much
_FASTEST = 100.0  # factor of an iteration
_STEADY = 40.0  # D q² t: from there on a wave is steady, as e^−40 of its start is left


@dataclass(frozen=True, slots=True)
class Cell:
    """A periodic square cell of `points` × `points` pixels and the side `length`, m."""

    points: int
    length: float

    def wavenumbers(self) -> tuple[Array, Array]:
        """Return q_x and q_y of the modes of `scipy.fft.rfft2`, rad/m, shapes (points, 1) and (points//2 + 1,)."""
        pixel = self.length / self.points
        along, across = np.fft.fftfreq(self.points, pixel), np.fft.rfftfreq(self.points, pixel)
        return np.asarray(2 * pi * along[:, None]), np.asarray(2 * pi * across)


def amplitudes(field: ClippedField, cell: Cell) -> tuple[Array, float]:
    """Return the standard deviation of each wave of z, and the share of the variance of the pressure on wrong waves.

    z is to give the pressure the power of the law on each wave. The transform of ρ does so where it is positive. Else
    the variance of each wave is multiplied by the power that is wanted over the power that it gives, several times;
    what contacts avoid one another more than any Gaussian field can is left as an error. Source: F. Yamazaki and
    M. Shinozuka, J. Eng. Mech. 114, 1183 (1988), with the power in closed form.
    """
    steps = np.minimum(np.arange(cell.points), cell.points - np.arange(cell.points)) * (
        cell.length / cell.points
    )
    distance = np.hypot(steps[:, None], steps)
    wanted = np.maximum(_power(field.shape(distance)), 0.0)
    wanted /= wanted.sum()
    start = _power(field.correlation(distance))
    variance = np.maximum(start, _FAINT * np.abs(start))  # none is 0: it would stay so
    for _ in range(_ITERATIONS):
        variance /= variance.sum()
        given = _given(field, variance)
        ratio = wanted / np.maximum(given, _FAINT * wanted + np.finfo(float).tiny)
        variance *= np.clip(ratio, 1 / _FASTEST, _FASTEST)
    variance /= variance.sum()
    wrong = float(np.abs(_given(field, variance) - wanted).sum()) / 2
    return np.sqrt(variance), wrong


def _power(correlation: Array) -> Array:
    """Return the variance of each wave for a correlation over the cell; none for the mean, as the load is given."""
    power = np.asarray(scipy.fft.fft2(correlation).real / correlation.size)
    power[0, 0] = 0.0
    return power


def _given(field: ClippedField, variance: Array) -> Array:
    """Return the power of the pressure on each wave, for the variance of each wave of z; the sum is 1."""
    rho = scipy.fft.ifft2(variance).real * variance.size
    power = np.maximum(_power(field.products.share(rho)), 0.0)
    return np.asarray(power / power.sum())


def halved(white: Array) -> Array:
    """Return white noise on half of the points a side that has the same long waves."""
    points, fewer = white.shape[0], white.shape[0] // 2
    kept = np.r_[0 : (fewer + 1) // 2, points - fewer // 2 : points]
    waves = scipy.fft.fft2(white)[np.ix_(kept, kept)]
    return np.asarray(scipy.fft.ifft2(waves).real * (fewer / points))


def heights(amplitude: Array, white: Array) -> Array:
    """Return z for the standard deviation of each of its waves and `white` noise, both of shape (points, points)."""
    points = amplitude.shape[0]
    waves = scipy.fft.rfft2(white) * (amplitude[:, : points // 2 + 1] * points)
    return np.asarray(scipy.fft.irfft2(waves, s=amplitude.shape))


def draw_pressure(field: ClippedField, amplitude: Array, white: Array) -> Array:
    """Return the pressure of one field, Pa, for `white` noise: its distribution is that of `field`.

    F is applied to the rank of z in the cell, so that the load of each cell is the nominal one.
    """
    z = heights(amplitude, white).ravel()
    pressure = np.empty(z.size)
    pressure[np.argsort(z)] = field.pressure(
        scipy.special.ndtri((np.arange(z.size) + 0.5) / z.size)
    )
    return pressure.reshape(amplitude.shape)


def heat_response(
    cell: Cell, speed: float, diffusivity: float, slid_distance: float = inf
) -> NDArray[np.complex128]:
    """Response κT/q̇ of each wave to a source that slides along +x at `speed` ≥ 0, m.

    erf(λ√(Dt))/λ with λ = √(q² − iq_x v/D) and t = `slid_distance`/v since both started from rest; 1/λ after an
    infinite way. The waves of `scipy.fft.rfft2`; 0 for the mean.
    """
    along, across = cell.wavenumbers()
    square = along**2 + across**2
    square[0, 0] = 1.0
    rate = np.sqrt(square - 1j * along * (speed / diffusivity))
    spread = diffusivity * slid_distance / speed if speed else inf
    growing = square * spread < _STEADY
    response = 1 / rate
    response[growing] *= scipy.special.erf(rate[growing] * np.sqrt(spread))
    response[0, 0] = 0.0
    if cell.points % 2 == 0:
        middle = cell.points // 2
        response[middle] = response[middle].real  # a wave of two pixels runs both ways along x
    return np.asarray(response)


def temperature(pressure: Array, response: NDArray[np.complex128]) -> Array:
    """Return T without its mean for the heat flux `pressure`, in units of heat flux × m/conductivity."""
    return np.asarray(scipy.fft.irfft2(scipy.fft.rfft2(pressure) * response, s=pressure.shape))
