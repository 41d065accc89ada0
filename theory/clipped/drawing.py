"""Drawn clipped Gaussian fields on a periodic square cell, and the temperature of their heat; no contact is solved."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, pi

import numpy as np
import scipy
from numpy.typing import NDArray

from theory.arguments import Array
from theory.clipped.field import ClippedField

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
    """Return the standard deviation of each wave of z, and the share of its variance that was negative.

    The variance is the transform of ρ at the distances on the torus. No Gaussian field has a negative one: it is set
    to 0, and the rest is made smaller, so that z has the variance 1.
    """
    steps = np.minimum(np.arange(cell.points), cell.points - np.arange(cell.points)) * (cell.length / cell.points)
    rho = field.correlation(np.hypot(steps[:, None], steps))
    variance = scipy.fft.fft2(rho).real / cell.points**2
    variance[0, 0] = 0.0  # the load is given
    positive = np.maximum(variance, 0.0)
    whole = float(positive.sum())
    return np.sqrt(positive / whole), 1 - float(variance.sum()) / whole


def draw_pressure(field: ClippedField, amplitude: Array, rng: np.random.Generator) -> Array:
    """Return the pressure of one field, Pa, in the shape of `amplitude`: its distribution is that of `field`.

    F is applied to the rank of z in the cell, so that the load of each cell is the nominal one.
    """
    points = amplitude.shape[0]
    waves = scipy.fft.rfft2(rng.standard_normal(amplitude.shape)) * (amplitude[:, : points // 2 + 1] * points)
    z = scipy.fft.irfft2(waves, s=amplitude.shape).ravel()
    pressure = np.empty(z.size)
    pressure[np.argsort(z)] = field.pressure(scipy.special.ndtri((np.arange(z.size) + 0.5) / z.size))
    return pressure.reshape(amplitude.shape)


def heat_response(cell: Cell, speed: float, diffusivity: float, slid_distance: float = inf) -> NDArray[np.complex128]:
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
