"""Classical flash temperatures of a single contact, to set against the exact values of `theory.hertz`.

All take Pe = vR/D, of either sign, and give q̇R/κ: R is the radius or half the side, q̇ the flux (for the Hertz source
q̇₁ at its centre). Several authors write L = vR/2D = Pe/2. Errors stated are measured against the exact solution, over
all speeds.
"""

from math import pi
from typing import overload

import numpy as np
from numpy.typing import ArrayLike

from theory.arguments import Array, Several, float_if_scalar, of_peclet, real_array
from theory.hertz.limits import DISC_FAST, DISC_STATIC, FAST, SQUARE_FAST, SQUARE_STATIC, STATIC

_SLOW, _QUICK = 0.1, 5.0  # L, bounds of the regimes of Jaeger and Archard
_TIAN_KENNEDY = {
    "disc": (2.0, 1.273, 1.0),
    "square": (2.0, 1.011, 1.0),
    "hertz": (2.32, 1.234, 2 / 3),
}
_LIMITS = {
    ("hertz", "flash"): (STATIC.flash_temperature, FAST.flash_temperature),
    ("hertz", "max"): (STATIC.max_temperature, FAST.max_temperature),
    ("hertz", "mean"): (STATIC.mean_temperature, FAST.mean_temperature),
    ("disc", "max"): (DISC_STATIC.max_temperature, DISC_FAST.max_temperature),
    ("disc", "mean"): (DISC_STATIC.mean_temperature, DISC_FAST.mean_temperature),
    ("square", "max"): (SQUARE_STATIC.max_temperature, SQUARE_FAST.max_temperature),
    ("square", "mean"): (SQUARE_STATIC.mean_temperature, SQUARE_FAST.mean_temperature),
}


@of_peclet
def jaeger(peclet: ArrayLike) -> Array | float:
    """Mean temperature of a uniform square by Jaeger's two formulas: 0.946 when slow, 1.064 Pe^(−1/2) when fast.

    Between them Jaeger gives curves; here the lesser counts, so the value is an upper bound. Its error is
    largest at their intersection: +39 % at Pe = 1.26, +8.5 % at L = 5; beyond, it falls to 0.

    Source: J.C. Jaeger, Proc. Roy. Soc. NSW 56, 203 (1942).

    Parameters
    ----------
    peclet : array_like
        Pe = vR/D, dimensionless, of either sign and any shape.

    Returns
    -------
    ndarray or float
        In q̇l/κ, l half the side, the shape of `peclet`; a float for one number.

    Raises
    ------
    TypeError, ValueError
        If `peclet` is not real and finite.
    """
    magnitude = np.abs(real_array("peclet", peclet, "1"))
    with np.errstate(divide="ignore"):
        return float_if_scalar(np.minimum(0.946, 1.064 / np.sqrt(magnitude)))


@of_peclet
def archard(peclet: ArrayLike) -> Array | float:
    """Mean temperature of a uniform disc by Archard's regimes, Q̇ = πq̇R² the power.

    0.25 Q̇/κR for L < 0.1, 0.31 (Q̇/κR)(D/vR)^(1/2) for L > 5, and between them 0.25 α Q̇/κR with α from 0.85 at
    L = 0.1 to 0.35 at L = 5, here straight in log L in place of the curve of Archard. Errors: −7.5 % at rest, −24 % at
    Pe = 0.9, +4.6 % just above L = 5, 0.02 % when fast; it jumps at both bounds.

    Source: J.F. Archard, Wear 2, 438 (1959).

    Parameters
    ----------
    peclet : array_like
        Pe = vR/D, dimensionless, of either sign and any shape.

    Returns
    -------
    ndarray or float
        In q̇R/κ, the shape of `peclet`.

    Raises
    ------
    TypeError, ValueError
        As `jaeger`.
    """
    magnitude = np.abs(real_array("peclet", peclet, "1"))
    middle = np.interp(
        np.log(np.clip(magnitude / 2, _SLOW, _QUICK)), np.log([_SLOW, _QUICK]), [0.85, 0.35]
    )
    fast = 0.31 * pi / np.sqrt(np.maximum(magnitude, 2 * _QUICK))
    slower = np.where(magnitude < 2 * _SLOW, pi / 4, pi / 4 * middle)
    return float_if_scalar(np.where(magnitude > 2 * _QUICK, fast, slower))


@overload
def greenwood(peclet: float, *, source: str = ..., quantity: str = ...) -> float: ...
@overload
def greenwood(peclet: Several, *, source: str = ..., quantity: str = ...) -> Array: ...
def greenwood(
    peclet: ArrayLike, *, source: str = "hertz", quantity: str = "flash"
) -> Array | float:
    """Interpolation between the exact limits, T^(−2) = T_static^(−2) + T_fast^(−2).

    Errors: Hertz −4.7 % (flash), −1.1 % (max), −4.6 % (mean); disc +2.3 % (max), −3.8 % (mean);
    square −2.6 % (max), +2.7 % (mean).

    Source: J.A. Greenwood, Wear 150, 153 (1991).

    Parameters
    ----------
    peclet : array_like
        Pe = vR/D, dimensionless, of either sign and any shape.
    source : {"hertz", "disc", "square"}
        Shape of the source.
    quantity : {"flash", "max", "mean"}
        T_flash (of the Hertz source only; for a uniform one it is the mean), T_max or T_av.

    Returns
    -------
    ndarray or float
        In q̇R/κ (q̇₁R/κ for "hertz"), the shape of `peclet`.

    Raises
    ------
    TypeError, ValueError
        If `peclet` is not real and finite, or the source and the quantity are none of these.
    """
    if (source, quantity) not in _LIMITS:
        raise ValueError(
            f"source = {source!r}, quantity = {quantity!r} must be one of {sorted(_LIMITS)}"
        )
    static, fast = _LIMITS[source, quantity]
    magnitude = np.abs(real_array("peclet", peclet, "1"))
    return float_if_scalar(1 / np.sqrt(static**-2 + magnitude / fast**2))


@overload
def tian_kennedy(peclet: float, *, source: str = ...) -> float: ...
@overload
def tian_kennedy(peclet: Several, *, source: str = ...) -> Array: ...
def tian_kennedy(peclet: ArrayLike, *, source: str = "hertz") -> Array | float:
    """Highest temperature of a moving source by the formula of Tian and Kennedy.

    T_max = c q̄R/κ [π(b + L)]^(−1/2), L = Pe/2, q̄ the mean flux; c = 2 and b = 1.273 (disc), 2 and 1.011 (square), 2.32
    and 1.234 (parabolic: the Hertz source). That is Greenwood's interpolation with rounded constants: errors +2.3 %
    (disc), −2.6 % (square), −1.1 % (Hertz).

    Source: X. Tian and F.E. Kennedy, J. Tribology 116, 167 (1994). The constants were checked against the exact
    limits, which they meet to 5e-4.

    Parameters
    ----------
    peclet : array_like
        Pe = vR/D, dimensionless, of either sign and any shape.
    source : {"hertz", "disc", "square"}
        Shape of the source.

    Returns
    -------
    ndarray or float
        In q̇R/κ (q̇₁R/κ for "hertz"), the shape of `peclet`; a float for one number.

    Raises
    ------
    TypeError, ValueError
        If `peclet` is not real and finite, or the source is none of these.
    """
    if source not in _TIAN_KENNEDY:
        raise ValueError(f"source = {source!r} must be one of {sorted(_TIAN_KENNEDY)}")
    factor, offset, mean_flux = _TIAN_KENNEDY[source]
    magnitude = np.abs(real_array("peclet", peclet, "1"))
    return float_if_scalar(mean_flux * factor / np.sqrt(pi * (offset + magnitude / 2)))
