"""The response of one wavelength, averaged over all directions of sliding: the angular integrals of Eqs. (4) and (7).

With s = (1+a²)^(−1/2) and the parameter m = (1−s)/2 ≤ 1/2 of the complete elliptic integrals,

    A(a) = Re ∫₀^{π/2} (1 − ia cosφ)^(−1/2) dφ        =  √s K(m),
    B(a) = Re ∫₀^{π/2} i cosφ (1 − ia cosφ)^(−1/2) dφ = −√s · as/(1+s) · [E(m) − (1−m)K(m)]/m.

One descending Landen step, n = (1−k′)/(1+k′) with k′ = √(1−m), takes m to n² ≤ 0.0295. There the power series of
K and D = (K−E)/m need ten terms for 1e-17, and [E − (1−m)K]/m = ½(1+n)[K(n²) − n D(n²)] cancels nowhere.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def hypergeometric_series(a: Fraction, b: Fraction, c: Fraction, terms: int = 10) -> tuple[float, ...]:
    """Return the coefficients of ₂F₁(a, b; c; x) in powers of x."""
    series = [Fraction(1)]
    for n in range(terms - 1):
        series.append(series[-1] * (a + n) * (b + n) / ((c + n) * (1 + n)))
    return tuple(float(term) for term in series)


_HALF = Fraction(1, 2)
_K_SERIES = hypergeometric_series(_HALF, _HALF, Fraction(1))  # K = (π/2) Σ
_D_SERIES = hypergeometric_series(_HALF, Fraction(3, 2), Fraction(2))  # D = (π/4) Σ


def angular_means(ratio: Array) -> tuple[Array, Array]:
    """Return ((2/π)A(a), (2/π)B(a)) for a = v/(Dq) ≥ 0, dimensionless: A from 1 to 0, B ≤ 0."""
    s = 1.0 / np.hypot(1.0, ratio)
    slid = s * ratio / (1.0 + s)  # as/(1+s) = √(m/(1−m)), without the cancellation of 1−s
    slope = np.sqrt(0.5 * (1.0 + s))  # k′
    landen = (slid * slope / (1.0 + slope)) ** 2  # (1−k′)/(1+k′) = m/(1+k′)², m = slid²k′²
    square = landen * landen
    complete = horner(_K_SERIES, square)
    scale = np.sqrt(s) * (1.0 + landen)
    odd = complete - 0.5 * landen * horner(_D_SERIES, square)
    return scale * complete, -0.5 * scale * slid * odd


def horner(coefficients: tuple[float, ...], x: Array) -> Array:
    """Return the polynomial at x by Horner's rule, in place."""
    result = np.full_like(x, coefficients[-1])
    for coefficient in coefficients[-2::-1]:
        result *= x
        result += coefficient
    return result
