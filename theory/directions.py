"""Means over the direction of sliding, in closed form: of a bare half-space that is heated in its plane."""

import numpy as np
from numpy.polynomial.chebyshev import Chebyshev, cheb2poly
from numpy.polynomial.polynomial import polyval
from numpy.typing import ArrayLike
from scipy.special import ellipk, ellipkm1, elliprd

from theory.arguments import Array, real_array

_DEGREE = 24  # K − D has its singularity at m = 1, far from 0 ≤ m ≤ 1/2: the interpolation errs by 6^(−24)


def _k_less_d() -> Array:
    """Return the coefficients of K(m) − D(m) in powers of 4m − 1: R_D costs ten times as much at each node."""
    interpolant = Chebyshev.interpolate(
        lambda m: ellipk(m) - elliprd(0.0, 1 - m, 1.0) / 3,
        _DEGREE,
        domain=[0.0, 0.5],
    )
    return np.asarray(cheb2poly(interpolant.coef))


_K_LESS_D = _k_less_d()


def angular_integrals(a: ArrayLike) -> tuple[Array, Array]:
    """Integrals over the sliding direction in Eqs. (4) and (7), a = v/Dq.

    A = Re ∫₀^{π/2} (1 − ia cos φ)^(−1/2) dφ and B = Re ∫₀^{π/2} i cos φ (1 − ia cos φ)^(−1/2) dφ. With h = √(1 + a²)
    and m = (h − 1)/2h: A = K(m)/√h and B = −a [K(m) − D(m)]/(√h (h + 1)), D = (K − E)/m by Carlson's R_D; no term
    cancels at any a. A is even and falls from π/2 as 1.854 |a|^(−1/2); B is odd, −πa/8 first, then −0.847 |a|^(−1/2).

    Parameters
    ----------
    a : array_like
        v/Dq, dimensionless, finite, of either sign and any shape.

    Returns
    -------
    (A, B) : ndarray, ndarray
        Dimensionless, the shape of `a`.

    Raises
    ------
    TypeError, ValueError
        If `a` is not real and finite.
    """
    ratio = real_array("a", a, "1")
    return np.asarray(even_integral(ratio)), np.asarray(odd_integral(ratio))


def even_integral(a: Array) -> Array:
    """Return A of checked ratios a = v/Dq."""
    h = np.hypot(1.0, a)
    return ellipk(_parameter(a, h)) / np.sqrt(h)


def odd_integral(a: Array) -> Array:
    """Return B of checked ratios a = v/Dq."""
    h = np.hypot(1.0, a)
    return np.asarray(-a / (h + 1) * polyval(4 * _parameter(a, h) - 1, _K_LESS_D) / np.sqrt(h))


def square_integral(a: Array) -> Array:
    """Return ∫₀^{π/2} (1 + a² cos²φ)^(−1/2) dφ = K(−a²) of checked ratios a = v/Dq: π/2 at rest, then ln(4|a|)/|a|."""
    h = np.hypot(1.0, a)
    # K(−a²) = K(1 − 1/h²)/h; for large h, before h² overflows, K(1 − 1/h²) is ln 4h to rounding
    return np.where(h < 1e9, ellipkm1(np.minimum(h, 1e9) ** -2.0), np.log(4.0 * h)) / h


def _parameter(a: Array, h: Array) -> Array:
    return (a / h) * (a / (h + 1)) / 2
