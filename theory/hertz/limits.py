"""Exact limits of the moving sources at rest and when fast; maps of the Hertz source; its pair correlation."""

from dataclasses import dataclass
from math import inf, pi, sqrt
from typing import overload

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ellipe, ellipk, hyp2f1

from theory.arguments import (
    Array,
    Several,
    float_if_scalar,
    not_negative_array,
    of_place,
    real_array,
)

_PER_POWER = 3 / 2 / pi  # q̇₁R² of the total power Q̇, Eq. (12)
_FAR = 6.0  # from here on series: the closed forms cancel


@dataclass(frozen=True, slots=True)
class Limit:
    """Limit of the Hertz source: when fast, temperatures, gradients and Laplacians are times Pe^(−1/2).

    Attributes
    ----------
    flash_temperature, max_temperature, mean_temperature : float
        In q̇₁R/κ. Eqs. (14), (15) and (16).
    flash_gradient, flash_laplacian : float
        The weighted slope, q̇₁/κ, and curvature, q̇₁/κR.
    flash_width, slope_length : float
        In R. Eqs. (25) and (26).
    hottest_point : float
        x in R, < 0 behind the centre.
    """

    flash_temperature: float
    max_temperature: float
    mean_temperature: float
    flash_gradient: float
    flash_laplacian: float
    flash_width: float
    slope_length: float
    hottest_point: float

    def per_power(self, temperature: float) -> float:
        """Take a temperature to the unit in which Eqs. (14) to (16) and (21) to (23) print it.

        Parameters
        ----------
        temperature : float
            In q̇₁R/κ.

        Returns
        -------
        float
            In Q̇/κR, with the power Q̇ of the source.
        """
        return _PER_POWER * temperature


@dataclass(frozen=True, slots=True)
class UniformLimit:
    """Limit of a uniform source: when fast, temperatures are times Pe^(−1/2).

    Attributes
    ----------
    max_temperature, mean_temperature : float
        In q̇R/κ.
    hottest_point : float
        x in R.
    """

    max_temperature: float
    mean_temperature: float
    hottest_point: float


STATIC = Limit(pi / 5, pi / 4, 3 * pi / 16, 0.0, -pi / 2, sqrt(0.4), inf, 0.0)  # Eqs. (14)-(18)
_FAST_FLASH = 0.7438575075933168  # f_flash/√π; the reference script has 30 digits of each
FAST = Limit(
    _FAST_FLASH,
    1.2346198309610956,
    0.6765062816542482,
    -0.7343784338214594 * _FAST_FLASH,
    -81 / 16 * _FAST_FLASH,
    4 / 9,
    1.3616957605853632,
    -0.6522295319699407,
)
DISC_STATIC = UniformLimit(1.0, 8 / 3 / pi, 0.0)
DISC_FAST = UniformLimit(2 * sqrt(2 / pi), 0.9737507822395868, -1.0)
SQUARE_STATIC = UniformLimit(
    1.1221997046783603, 0.946402008818677, 0.0
)  # (4/π) asinh 1, and less (4/3π)(√2 − 1)
SQUARE_FAST = UniformLimit(2 * sqrt(2 / pi), 4 / 3 * sqrt(2 / pi), -1.0)


@of_place
def static_temperature(x: ArrayLike, y: ArrayLike) -> Array | float:
    """Temperature of the resting Hertz source on the whole surface. Eq. (13) inside the contact.

    T = (π/8)(2 − r²) for r ≤ 1 and [(2 − r²) arcsin(1/r) + √(r² − 1)]/4 beyond.

    Parameters
    ----------
    x, y : array_like
        Position in R from the centre of contact; broadcast against each other.

    Returns
    -------
    ndarray or float
        In q̇₁R/κ, the common shape of `x` and `y`.

    Raises
    ------
    TypeError, ValueError
        If a coordinate is not real and finite.
    """
    r = np.hypot(real_array("x", x, "R"), real_array("y", y, "R"))
    outside = np.maximum(r, 1.0)
    beyond = np.sqrt((outside - 1) * (outside + 1))
    result = np.where(
        r <= 1.0, pi / 8 * (2 - r**2), ((2 - outside**2) * np.arcsin(1 / outside) + beyond) / 4
    )
    far = np.maximum(r, _FAR)
    multipoles = hyp2f1(0.5, 0.5, 2.5, far**-2) / (3 * far)  # 1/3r + 1/30r³ + ...
    return float_if_scalar(np.where(r < _FAR, result, multipoles))


@of_place
def fast_temperature(x: ArrayLike, y: ArrayLike) -> Array | float:
    """Temperature of the fast Hertz source, in q̇₁R/κ · Pe^(−1/2), on the whole surface. Eqs. (19) and (20).

    T = f(−x, y)/√π: the source moves along +x, so the wake lies at x < 0. With s = √(1 − y²) and t = −x/s,
    f = s^(3/2) F(t), F = (4√2/3)[(2m−1)E(m) + (1−m)K(m)], m = (1+t)/2 within the contact, and
    F = (4/3)√(t+1) [t E(m) − (t−1) K(m)], m = 2/(1+t) in the wake, t > 1. Ahead and beside T = 0.

    Parameters
    ----------
    x, y : array_like
        Position in R from the centre of contact; broadcast against each other.

    Returns
    -------
    ndarray or float
        In q̇₁R/κ · Pe^(−1/2), the common shape of `x` and `y`.

    Raises
    ------
    TypeError, ValueError
        As `static_temperature`.
    """
    behind, beside = np.broadcast_arrays(-real_array("x", x, "R"), real_array("y", y, "R"))
    square = (1 - beside) * (1 + beside)
    result = np.zeros(square.shape)
    half = np.sqrt(np.maximum(square, 0.0))
    hot = (square > 0.0) & (behind > -half)
    t = behind[hot] / half[hot]
    shape = np.where(t <= 1.0, _within(np.minimum(t, 1.0)), _wake(np.maximum(t, 1.0)))
    result[hot] = half[hot] ** 1.5 * shape
    return float_if_scalar(result / sqrt(pi))


def _within(t: Array) -> Array:
    m = (1 + t) / 2
    second = np.where(m < 1.0, (1 - m) * ellipk(_below_one(m)), 0.0)
    return 4 / 3 * sqrt(2) * ((2 * m - 1) * ellipe(m) + second)


def _wake(t: Array) -> Array:
    m = 2 / (1 + t)
    near = 4 / 3 * np.sqrt(t + 1) * (t * ellipe(m) - (t - 1) * ellipk(_below_one(m)))
    far = np.maximum(t, _FAR)
    return np.where(t < _FAR, near, pi / 2 / np.sqrt(far) * hyp2f1(0.25, 0.75, 2.0, far**-2))


def _below_one(m: Array) -> Array:
    """Keep K(m) finite at m = 1, the zero of its factor."""
    return np.minimum(m, np.nextafter(1.0, 0.0))


@overload
def pressure_correlation(distance: float) -> float: ...
@overload
def pressure_correlation(distance: Several) -> Array: ...
def pressure_correlation(distance: ArrayLike) -> Array | float:
    """Pair correlation of the Hertz pressure, ∫σ(x)σ(x + r)d²x over its value at r = 0; zero beyond 2R (Sec. 2).

    [(8 + r²)√(4 − r²) − r²(8 − r²/2) arcosh(2/r)]/16: along a line the pressure adds up to a parabola, and the Abel
    transform takes the correlation of two of them back to r.

    Parameters
    ----------
    distance : array_like
        r in R, at least 0.

    Returns
    -------
    ndarray or float
        From 1 to 0, the shape of `distance`.

    Raises
    ------
    TypeError, ValueError
        If a distance is not real and finite, or is negative.
    """
    r = np.minimum(not_negative_array("distance", distance, "R"), 2.0)
    logarithm = np.arccosh(2 / np.maximum(r, 1e-300))  # its factor is 0 at r = 0
    result = ((8 + r**2) * np.sqrt((2 - r) * (2 + r)) - r**2 * (8 - r**2 / 2) * logarithm) / 16
    return float_if_scalar(np.maximum(result, 0.0))  # rounding next to 2R
