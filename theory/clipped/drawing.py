"""Drawn clipped Gaussian fields on a periodic square cell; no contact is solved."""

from __future__ import annotations

import numpy as np
import scipy

from theory.arguments import Array
from theory.clipped.field import ClippedField

_ITERATIONS = 12  # of the power of z: then 1 to 3 % of the power of the pressure still moves under the lightest load
_FAINT = 1e-4  # of a power: less counts as that much
_FASTEST = 100.0  # factor of an iteration


def amplitudes(field: ClippedField, points: int, length: float) -> tuple[Array, float]:
    """Return the standard deviation of each wave of z, and the share of the variance of the pressure on wrong waves.

    The periodic cell of the `field` has `points` × `points` pixels and the side `length`, m; the waves are those of a
    full transform.

    z is to give the pressure the power of the law on each wave. The transform of ρ does so where it is positive. Else
    the variance of each wave is multiplied by the power that is wanted over the power that it gives, several times;
    what contacts avoid one another more than any Gaussian field can is left as an error. Source: F. Yamazaki and
    M. Shinozuka, J. Eng. Mech. 114, 1183 (1988), with the power in closed form.
    """
    places = np.arange(points)
    steps = np.minimum(places, points - places) * (length / points)
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
    """Return z for the `amplitude` of each of its waves and `white` noise, both of shape (points, points)."""
    points = amplitude.shape[0]
    waves = scipy.fft.rfft2(white) * (amplitude[:, : points // 2 + 1] * points)
    return np.asarray(scipy.fft.irfft2(waves, s=amplitude.shape))


def ranked(z: Array, ascending: Array) -> Array:
    """Return the pressure of drawn z, Pa, in its shape: F of the rank of z in the cell, so that the load is nominal.

    `ascending` is `ClippedField.ascending` of as many points.
    """
    pressure = np.empty(z.size)
    pressure[np.argsort(z, axis=None)] = ascending
    return pressure.reshape(z.shape)
