"""Inverse Laplace transforms of functions without singularities off p ≤ 0, and interpolation over many decades.

The contour of the inversion is that of J. A. C. Weideman, SIAM J. Numer. Anal. 44, 2342 (2006).
"""

import math
from collections.abc import Callable

import numpy as np

from roughsim.grid import Array, Complex

_ACCURACY = 18.0  # −ln of the error of interpolation
_POINTS = 24  # of the contour, half of them above the real axis: errors of 1e-13
_THETA = (2 * np.arange(_POINTS // 2) + 1) * math.pi / _POINTS
_SLOPE = (
    0.5017 / np.tan(0.6407 * _THETA)
    - 0.5017 * 0.6407 * _THETA / np.sin(0.6407 * _THETA) ** 2
    + 0.2645j
)
NODES = _POINTS * (0.5017 * _THETA / np.tan(0.6407 * _THETA) - 0.6122 + 0.2645j * _THETA)  # p t
WEIGHTS = -2j * _SLOPE * np.exp(NODES)


def inverse(transform: Callable[[Complex], Complex], time: Array) -> Array:
    """Return the real function of time > 0 that has a Laplace transform; p has the shape of `time` and an axis more."""
    p = np.asarray(NODES / time[:, None], complex)
    return (WEIGHTS * transform(p)).real.sum(axis=-1) / time


def interpolation(
    low: float, high: float
) -> tuple[Array, Callable[[Array], Callable[[Array], Array]]]:
    """Return nodes from `low` to `high`, and a function that turns values at them, (nodes, columns), into a function.

    Functions of q² + p/D, and of time, are analytic within ±iπ/4 in the logarithm of q, or of √time.
    """
    extent = max(math.log(high / low), 1.0)
    orders = np.arange(math.ceil(_ACCURACY / math.asinh(0.5 * math.pi / extent)))
    angles = (orders + 0.5) * math.pi / orders.size
    nodes = low * np.exp(extent * (1 - np.cos(angles)) / 2)

    def interpolated(values: Array) -> Callable[[Array], Array]:
        # Chebyshev polynomials, orthogonal over the nodes
        coefficients = 2 / orders.size * np.cos(np.outer(orders, angles)) @ values
        coefficients[0] /= 2

        def function(at: Array) -> Array:
            place = 1 - 2 * np.log(at / low) / extent
            return np.cos(np.outer(np.arccos(np.clip(place, -1, 1)), orders)) @ coefficients

        return function

    return nodes, interpolated
