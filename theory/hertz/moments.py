"""Averages over a moving source, from its autocorrelation: one integral over distance, at any Péclet number.

A steady point source leaves T = e^(−β(r+x))/2πκr, β = v/2D. Averaged over the sliding direction it meets the
autocorrelation g(r) of the source, so with z = Pe r/2 and ⟨q̇⟩ = 2π/3 the Hertz source (R = 1) has
T_flash = (3/2π) ∫₀² g e^(−z)I₀(z) dr, T′_flash = (3/2π) ∫ g′ e^(−z)I₁(z) dr, ∇²T_flash = (3/2π) ∫ ∇²g e^(−z)I₀(z) dr.

Here s = √(4−r²) and L = arcosh(2/r): g = (π/4)[s(1 + r²/8) − r²(1 − r²/16)L], g′ = (π/4) r[s/2 − (2 − r²/4)L],
∇²g = (π/4)[2s − s²L].
"""

from collections.abc import Callable
from math import pi

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ellipe, ellipk, factorial, gammainc, i0e, i1e

from theory.arguments import Array, float_if_scalar, in_blocks, of_peclet, real_array
from theory.hertz.graded import rule, towards_zero
from theory.hertz.limits import DISC_FAST, FAST, SQUARE_FAST

_Function = Callable[[Array], Array]
_FASTEST = 1e30  # Pe: from here on the fast limit differs by less than rounding


# 0 ≤ r ≤ 2: graded towards 0, and with r = 2 − w² near 2, for the powers of √(2 − r) of g
_DISTANCE = rule(towards_zero(1e-33, 1.0)).joined(
    rule(np.array([0.0, 0.5, 1.0])).mapped(lambda w: 2 - w**2, lambda w: 2 * w)
)
_ANGLE = rule(towards_zero(1e-17, pi / 4)).joined(
    rule(np.linspace(pi / 4, pi, 7))
)  # the corners at odd π/4


@of_peclet
def flash_temperature(peclet: ArrayLike) -> Array | float:
    """Weighted average temperature T_flash = ⟨Tσ⟩/⟨σ⟩ of the Hertz source. Eqs. (14) and (21) are its limits.

    Parameters
    ----------
    peclet : array_like
        Pe = vR/D, dimensionless, of either sign and any shape.

    Returns
    -------
    ndarray or float
        In q̇₁R/κ, the shape of `peclet`; a float for one number. Even in Pe.

    Raises
    ------
    TypeError, ValueError
        If `peclet` is not real and finite.
    theory.quadrature.QuadratureError
        If the integral does not reach its accuracy, 1e-11.
    """
    return _over_distance(peclet, _autocorrelation, i0e, FAST.flash_temperature)


@of_peclet
def flash_gradient(peclet: ArrayLike) -> Array | float:
    """Weighted slope T′_flash = ⟨∂ₓT σ⟩/⟨σ⟩ of the Hertz source, q̇₁/κ; negative for Pe > 0, odd in Pe. Eq. (A7).

    Parameters
    ----------
    peclet : array_like
        Pe = vR/D, dimensionless, of either sign and any shape.

    Returns
    -------
    ndarray or float
        In q̇₁/κ, the shape of `peclet`; a float for one number.

    Raises
    ------
    TypeError, ValueError, theory.quadrature.QuadratureError
        As `flash_temperature`.
    """
    magnitude = _over_distance(peclet, _slope, i1e, FAST.flash_gradient)
    return float_if_scalar(magnitude * np.sign(peclet))


@of_peclet
def flash_laplacian(peclet: ArrayLike) -> Array | float:
    """Weighted Laplacian in the plane ∇²T_flash = ⟨∇²T σ⟩/⟨σ⟩ of the Hertz source, q̇₁/κR. Eqs. (17) and (A6).

    Parameters
    ----------
    peclet : array_like
        Pe = vR/D, dimensionless, of either sign and any shape.

    Returns
    -------
    ndarray or float
        In q̇₁/κR, the shape of `peclet`; a float for one number.

    Raises
    ------
    TypeError, ValueError, theory.quadrature.QuadratureError
        As `flash_temperature`.
    """
    return _over_distance(peclet, _laplacian, i0e, FAST.flash_laplacian)


@of_peclet
def flash_width(peclet: ArrayLike) -> Array | float:
    """Width D_flash/R = √(−T_flash/∇²T_flash)/R of the Hertz source: √0.4 at rest, 4/9 when fast. Eq. (25).

    Parameters
    ----------
    peclet : array_like
        Pe = vR/D, dimensionless, of either sign and any shape.

    Returns
    -------
    ndarray or float
        In R, the shape of `peclet`; a float for one number.

    Raises
    ------
    TypeError, ValueError, theory.quadrature.QuadratureError
        As `flash_temperature`.
    """
    return float_if_scalar(np.sqrt(-np.divide(flash_temperature(peclet), flash_laplacian(peclet))))


@of_peclet
def slope_length(peclet: ArrayLike) -> Array | float:
    """Slope length d_flash/R = T_flash/R|T′_flash| of the Hertz source: 4/|Pe| for Pe → 0, ∞ at rest. Eq. (26).

    Parameters
    ----------
    peclet : array_like
        Pe = vR/D, dimensionless, of either sign and any shape.

    Returns
    -------
    ndarray or float
        In R, the shape of `peclet`; a float for one number.

    Raises
    ------
    TypeError, ValueError, theory.quadrature.QuadratureError
        As `flash_temperature`.
    """
    with np.errstate(divide="ignore"):
        length = np.divide(flash_temperature(peclet), np.abs(flash_gradient(peclet)))
    return float_if_scalar(length)


@of_peclet
def mean_temperature(peclet: ArrayLike) -> Array | float:
    """Plain average T_av of the temperature over the Hertz contact, q̇₁R/κ. Eqs. (16) and (23) are its limits.

    T_av = −(1/π) ∫ c′ r[I₀(z) + I₁(z)]e^(−z) dr, where c(r) is the correlation of the source with the disc of contact,
    c′ = −(8/3)√r [(2m−1)E(m) + (1−m)K(m)], m = (2−r)/4, and the bracket is the primitive of e^(−z)I₀(z).

    Parameters
    ----------
    peclet : array_like
        Pe = vR/D, dimensionless, of either sign and any shape.

    Returns
    -------
    ndarray or float
        In q̇₁R/κ, the shape of `peclet`; a float for one number.

    Raises
    ------
    TypeError, ValueError, theory.quadrature.QuadratureError
        As `flash_temperature`.
    """

    def correlation(r: Array) -> Array:
        m = (2 - r) / 4
        elliptic = (2 * m - 1) * ellipe(m) + (1 - m) * ellipk(m)
        return 8 / 3 / pi * r**1.5 * elliptic

    return _over_distance(peclet, correlation, lambda z: i0e(z) + i1e(z), FAST.mean_temperature)


@of_peclet
def disc_mean_temperature(peclet: ArrayLike) -> Array | float:
    """Average temperature over a uniform moving disc, q̇R/κ.

    T_av = (1/π) ∫₀² [2 arccos(r/2) − rs/2] e^(−z)I₀(z) dr.

    Parameters
    ----------
    peclet : array_like
        Pe = vR/D, dimensionless, of either sign and any shape.

    Returns
    -------
    ndarray or float
        In q̇R/κ, the shape of `peclet`; a float for one number.

    Raises
    ------
    TypeError, ValueError, theory.quadrature.QuadratureError
        As `flash_temperature`.
    """

    def correlation(r: Array) -> Array:
        return (2 * np.arccos(r / 2) - r / 2 * np.sqrt((2 - r) * (2 + r))) / pi

    return _over_distance(peclet, correlation, i0e, DISC_FAST.mean_temperature)


@of_peclet
def square_mean_temperature(peclet: ArrayLike) -> Array | float:
    """Average temperature over a uniform square of side 2l that moves along a side, q̇l/κ, Pe = vl/D.

    T_av = (1/8π) ∫dφ ∫dr (2 − r|cos φ|)(2 − r|sin φ|) e^(−ar), a = Pe sin²(φ/2); the inner integral is closed.

    Parameters
    ----------
    peclet : array_like
        Pe = vl/D, dimensionless, of either sign and any shape.

    Returns
    -------
    ndarray or float
        In q̇l/κ, the shape of `peclet`; a float for one number.

    Raises
    ------
    TypeError, ValueError, theory.quadrature.QuadratureError
        As `flash_temperature`.
    """

    def integral(magnitude: Array) -> Array:
        return _ANGLE.integral(lambda angle: ray(angle, magnitude)) / 4 / pi

    def ray(angle: Array, magnitude: Array) -> Array:
        c, s = np.abs(np.cos(angle)), np.abs(np.sin(angle))
        reach = 2 / np.maximum(c, s)
        b = magnitude * np.sin(angle / 2) ** 2 * reach
        parts = (
            4 * _moment(0, b)
            - 2 * reach * (c + s) * _moment(1, b)
            + reach**2 * c * s * _moment(2, b)
        )
        return np.asarray(reach * parts)

    return _at_each(peclet, integral, SQUARE_FAST.mean_temperature)


def _autocorrelation(r: Array) -> Array:
    """Return (3/2π) g, as the others times the factor of T_flash."""
    root = np.sqrt((2 - r) * (2 + r))
    return 3 / 8 * (root * (1 + r**2 / 8) - r**2 * (1 - r**2 / 16) * np.arccosh(2 / r))


def _slope(r: Array) -> Array:
    root = np.sqrt((2 - r) * (2 + r))
    return 3 / 8 * r * (root / 2 - (2 - r**2 / 4) * np.arccosh(2 / r))


def _laplacian(r: Array) -> Array:
    square = (2 - r) * (2 + r)
    return 3 / 8 * (2 * np.sqrt(square) - square * np.arccosh(2 / r))


def _moment(power: int, b: Array) -> Array:
    """Return ∫₀¹ t^power e^(−bt) dt, b ≥ 0."""
    small = b < 1e-9
    safe = np.where(small, 1.0, b)
    large = factorial(power) * gammainc(power + 1, safe) / safe ** (power + 1)
    return np.where(small, 1 / (power + 1) - b / (power + 2), large)


def _over_distance(
    peclet: ArrayLike, correlation: _Function, wake: _Function, fast: float
) -> Array | float:
    """Return ∫ correlation(r) wake(|Pe| r/2) dr."""

    def integral(magnitude: Array) -> Array:
        return _DISTANCE.integral(lambda r: correlation(r) * wake(magnitude * r / 2))

    return _at_each(peclet, integral, fast)


def _at_each(peclet: ArrayLike, integral: _Function, fast: float) -> Array | float:
    """Return the integral at each |Pe|; beyond _FASTEST the limit `fast` Pe^(−1/2)."""
    magnitude = np.abs(real_array("peclet", peclet, "1"))
    values = in_blocks(integral, np.minimum(magnitude, _FASTEST))
    limit = fast / np.sqrt(np.maximum(magnitude, _FASTEST))
    return float_if_scalar(np.where(magnitude < _FASTEST, values, limit))
