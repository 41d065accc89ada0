"""Hottest point of a moving source: the temperature on its centre line by rays from the point, maximised over x.

From a point p of the contact the source is seen along rays r at the angle φ from +x,
T(p) = (1/2π) ∫dφ ∫dr q̇(p + r) e^(−ar), a = Pe sin²(φ/2): no singularity is left, and heat comes from within an
angle Pe^(−1/2) of the direction of motion.
"""

from collections.abc import Callable
from math import pi

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import minimize_scalar

from theory.arguments import Array, real_array
from theory.hertz.graded import rule, towards_zero
from theory.hertz.limits import DISC_FAST, FAST, SQUARE_FAST

_FASTEST = 1e12  # Pe: the fast limit of a maximum is reached as 1/Pe
_Line = Callable[
    [float, float], float
]  # δ, the distance from the trailing edge, and Pe ≥ 0 to the temperature


def max_temperature(peclet: ArrayLike) -> Array | float:
    """Highest temperature of the Hertz source, q̇₁R/κ. Eqs. (15) and (22) are its limits.

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
    return _hottest(peclet, _hertz_line, FAST.max_temperature, FAST.hottest_point)[0]


def hottest_point(peclet: ArrayLike) -> Array | float:
    """Position x/R of the highest temperature of the Hertz contact: behind the centre, x < 0 for Pe > 0. To about 1e-7.

    Parameters, errors: as `max_temperature`.
    """
    return _hottest(peclet, _hertz_line, FAST.max_temperature, FAST.hottest_point)[1]


def disc_max_temperature(peclet: ArrayLike) -> Array | float:
    """Highest temperature of a uniform moving disc, q̇R/κ. Parameters, errors: as `max_temperature`."""
    return _hottest(peclet, _disc_line, DISC_FAST.max_temperature, DISC_FAST.hottest_point)[0]


def disc_hottest_point(peclet: ArrayLike) -> Array | float:
    """Position x/R of the highest temperature of a uniform moving disc. Parameters, errors: as `max_temperature`."""
    return _hottest(peclet, _disc_line, DISC_FAST.max_temperature, DISC_FAST.hottest_point)[1]


def square_max_temperature(peclet: ArrayLike) -> Array | float:
    """Highest temperature of a uniform square of side 2l moving along a side, q̇l/κ, Pe = vl/D.

    Parameters, errors: as `max_temperature`.
    """
    return _hottest(peclet, _square_line, SQUARE_FAST.max_temperature, SQUARE_FAST.hottest_point)[0]


def square_hottest_point(peclet: ArrayLike) -> Array | float:
    """Position x/l of the highest temperature of a uniform square. Parameters, errors: as `max_temperature`."""
    return _hottest(peclet, _square_line, SQUARE_FAST.max_temperature, SQUARE_FAST.hottest_point)[1]


def _hottest(
    peclet: ArrayLike, line: _Line, fast: float, where: float
) -> tuple[Array | float, Array | float]:
    number = real_array("peclet", peclet, "1")
    top, place = np.empty(number.shape), np.empty(number.shape)
    for index, value in np.ndenumerate(number):
        magnitude = abs(float(value))
        top[index], x = (
            _search(line, magnitude) if magnitude < _FASTEST else (fast / np.sqrt(magnitude), where)
        )
        place[index] = x * (1 if value > 0.0 else -1) + 0.0
    return (float(top), float(place)) if number.ndim == 0 else (top, place)


def _search(line: _Line, peclet: float) -> tuple[float, float]:
    """Return the maximum and its x, by δ = e^(−s): when fast, discs and squares are hottest at δ ~ 1/Pe."""
    if peclet == 0.0:
        return line(1.0, 0.0), 0.0
    limits = (
        0.0,
        1.2 if line is _hertz_line else np.log(peclet + 1) + 3,
    )  # the Hertz source: never beyond x = −0.66

    def cold(s: float) -> float:
        return -line(np.exp(-s), peclet)

    found = minimize_scalar(cold, bounds=limits, method="bounded", options={"xatol": 1e-7})
    return -float(found.fun), float(np.expm1(-found.x))


def _hertz_line(delta: float, peclet: float) -> float:
    x = delta - 1
    angles = rule(
        np.concatenate([towards_zero(0.5 / np.sqrt(peclet + 1), pi / 2), [3 * pi / 4, pi]])
    )
    near = rule(
        towards_zero(0.5 / (peclet + 1), 0.5)
    )  # in r/reach; r = reach(1 − w²) at the far end, where q̇ ~ w
    along = near.joined(
        rule(np.array([0.0, np.sqrt(0.5)])).mapped(lambda w: 1 - w**2, lambda w: 2 * w)
    )

    def ray(angle: Array) -> Array:
        c = np.cos(angle)[:, None]
        root = np.sqrt(delta * (2 - delta) + (x * c) ** 2)
        reach, back = root - x * c, root + x * c
        decay = peclet * np.sin(angle / 2)[:, None] ** 2 * reach

        def flux(t: Array) -> Array:
            return np.asarray(np.sqrt((1 - t) * reach * (back + t * reach)) * np.exp(-decay * t))

        return np.asarray(reach[:, 0] * along.integral(flux))

    return float(angles.integral(ray) / pi)


def _disc_line(delta: float, peclet: float) -> float:
    """Return the temperature of a uniform disc on its centre line, `delta` from its trailing edge."""
    front = rule(towards_zero(0.5 / np.sqrt(peclet + 1), pi / 4))
    aside = rule(towards_zero(0.25 * np.sqrt(delta), pi / 4))
    back = rule(np.array([0.0, pi / 4]))
    half = delta * (2 - delta)

    def ray(c: Array, haversine: Array) -> Array:
        """Integral along a ray, c the cosine of its direction, haversine = (1 − c)/2."""
        root = np.sqrt(half + ((1 - delta) * c) ** 2)
        ahead = root + (1 - delta) * c
        behind = half / (root + (1 - delta) * np.abs(c))
        reach = np.where(c > 0, ahead, behind)
        return _through(reach, peclet * haversine)

    def forwards(phi: Array) -> Array:
        return ray(np.cos(phi), np.sin(phi / 2) ** 2)

    def aside_ahead(psi: Array) -> Array:
        sine = np.sin(psi)
        return ray(sine, (1 - sine) / 2)

    def aside_behind(psi: Array) -> Array:
        sine = np.sin(psi)
        return ray(-sine, (1 + sine) / 2)

    def backwards(psi: Array) -> Array:
        return ray(-np.cos(psi), np.cos(psi / 2) ** 2)

    total = front.integral(forwards)
    total += aside.integral(aside_ahead)
    total += aside.integral(aside_behind)
    total += back.integral(backwards)
    return float(total / pi)


def _square_line(delta: float, peclet: float) -> float:
    """Return the temperature of a uniform square on its centre line, `delta` from its trailing edge."""
    corner = np.arctan(1 / (2 - delta))
    front = rule(towards_zero(0.5 / np.sqrt(peclet + 1), corner))
    side = rule(np.linspace(corner, pi / 2 + np.arctan(delta), 5))
    farthest = np.arcsinh(1 / delta)
    back = rule(np.append(np.arange(0.0, farthest), farthest))  # in w, reach = δ cosh w

    def forwards(phi: Array) -> Array:
        decay = peclet * np.sin(phi / 2) ** 2
        return _through((2 - delta) / np.cos(phi), decay)

    def sideways(phi: Array) -> Array:
        decay = peclet * np.sin(phi / 2) ** 2
        return _through(1 / np.sin(phi), decay)

    def backwards(w: Array) -> Array:
        stretch = np.cosh(w)
        decay = peclet * (1 + 1 / stretch) / 2
        return _through(delta * stretch, decay) / stretch

    total = front.integral(forwards)
    total += side.integral(sideways)
    total += back.integral(backwards)
    return float(total / pi)


def _through(reach: Array, decay: Array) -> Array:
    """Return ∫ e^(−decay r) dr up to `reach`."""
    exponent = decay * reach
    with np.errstate(under="ignore"):
        return np.asarray(
            reach
            * np.where(exponent > 1e-30, -np.expm1(-exponent) / np.maximum(exponent, 1e-300), 1.0)
        )
