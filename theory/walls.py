"""Diffusion of the pressure between two absorbing walls: shares without contact, in plastic and in elastic contact.

The pressure diffuses, as roughness is added, from σ₀ between absorbing walls at 0 (contact lost) and σ_P (yielded).
With s = σ₀/σ_P, g = G/σ_P² and w = 1/2√g, the share that has reached σ_P, the plastic area, is

    Σ_{k≥0} erfc((2k+1−s)w) − erfc((2k+1+s)w)  =  s − (2/π) Σ_{n≥1} (−1)^{n+1} sin(nπs)/n · exp(−n²π²g),

the share that has reached 0 is the same with 1 − s for s, and the elastic rest is

    erf(sw) + Σ_{j≥1} (−1)^j [erfc((j−s)w) − erfc((j+s)w)]  =  (4/π) Σ_{n odd} sin(nπs)/n · exp(−n²π²g).

Images (left) and modes (right) are used in their ranges of convergence; no digits are lost to cancellation in either.
"""

from __future__ import annotations

from functools import lru_cache
from math import exp, log, pi

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import ArrayLike
from scipy.special import erfcx

from theory.arguments import (
    Array,
    SpectrumLike,
    breaks_of,
    not_negative_array,
    positive,
    real_array,
)
from theory.full_contact import half_variance_table, probability
from theory.roots import root

SWITCH = 0.2  # g: below, images; above, modes: four of the former and five of the latter reach rounding on either side
IMAGES, MODES = 7, 6
_POINTS, _WEIGHTS = leggauss(12)


def area_fractions(
    half_variance: ArrayLike, nominal_pressure: float, penetration_hardness: float
) -> tuple[Array, Array, Array]:
    """Shares of the nominal area without contact, in elastic and in plastic contact.

    Parameters
    ----------
    half_variance : array_like
        G(q) ≥ 0 of any shape, Pa².
    nominal_pressure, penetration_hardness : float
        σ₀ and σ_P, Pa, 0 < σ₀ ≤ σ_P. At σ₀ = σ_P everything is plastic.

    Returns
    -------
    (non_contact, elastic, plastic) : ndarray
        Dimensionless, the shape of `half_variance`, each to about 1e-14 of itself however small.

    Raises
    ------
    TypeError, ValueError
        If an argument is not real, finite and of the right sign, or σ₀ > σ_P: no contact can carry that load.
    """
    variance = not_negative_array("half_variance", half_variance, "Pa²")
    s, rest, hardness = shares(nominal_pressure, penetration_hardness)
    g = variance / hardness**2
    return reached(rest, s, g), between(min(s, rest), g), reached(s, rest, g)


def yield_wavenumber(
    spectrum: SpectrumLike,
    *,
    effective_modulus: float,
    nominal_pressure: float,
    penetration_hardness: float,
    elastic_share: float = 0.01,
) -> float:
    """Wavenumber q_y, rad/m: with roughness up to q_y, A_el/(A_el + A_pl) is `elastic_share`.

    Parameters
    ----------
    spectrum, effective_modulus, nominal_pressure, penetration_hardness
        As in `smoothed_spectrum`.
    elastic_share : float
        Between 0 and 1.

    Returns
    -------
    float
        q_y in rad/m; q_min when all is plastic from the start (σ₀ = σ_P), ∞ when q_max comes first.

    Raises
    ------
    TypeError, ValueError
        If an argument is not real, finite and of the right sign, or σ₀ > σ_P.
    """
    share = float(real_array("elastic_share", elastic_share, "1"))
    if not 0.0 < share < 1.0:
        raise ValueError(f"elastic_share = {share:.6g} must lie between 0 and 1")
    modulus = positive("effective_modulus", effective_modulus, "Pa")
    s, rest, hardness = shares(nominal_pressure, penetration_hardness)
    if rest == 0.0:
        return float(breaks_of(spectrum)[0])
    g_yield = _half_variance_at(share, s, rest)
    return half_variance_table(spectrum).inverse(g_yield * (hardness / modulus) ** 2 * 4 / pi)


@lru_cache(maxsize=64)  # .007 s, the same up to each cut-off of a run
def _half_variance_at(share: float, s: float, rest: float) -> float:
    """Return the G/σ_P² at which A_el/(A_el + A_pl) is `share`."""

    def excess(log_g: float) -> float:
        g = np.exp(np.array([log_g]))
        elastic, plastic = float(between(min(s, rest), g)[0]), float(reached(s, rest, g)[0])
        return elastic / (elastic + plastic) - share

    return exp(root(excess, log(1e-30), log(70.0), accuracy=1e-14))


def half_variance_of(share: float, variance: float) -> float:
    """Return the G/σ_P² at which a pressure between the walls has this `variance`/σ_P², which rises by 2A_el dg."""
    nearer = min(share, 1 - share)
    g = np.concatenate([[0.0], np.geomspace(1e-4 * nearer**2, 10.0, 600)])
    elastic = between(nearer, g)
    rising = np.append(0.0, np.cumsum((elastic[1:] + elastic[:-1]) * np.diff(g)))
    return float(np.interp(variance, rising, g))


def shares(nominal_pressure: float, penetration_hardness: float) -> tuple[float, float, float]:
    """Return σ₀/σ_P, 1 − σ₀/σ_P without cancellation, and σ_P."""
    pressure = positive("nominal_pressure", nominal_pressure, "Pa")
    hardness = positive("penetration_hardness", penetration_hardness, "Pa")
    if pressure > hardness:
        raise ValueError(
            f"nominal_pressure = {pressure:.6g} Pa exceeds the penetration_hardness {hardness:.6g} Pa, "
            "the most that yielded contact carries; lower the load"
        )
    return pressure / hardness, (hardness - pressure) / hardness, hardness


def reached(s: float, rest: float, g: Array) -> Array:
    """Return the share that has reached the wall at distance `rest` = 1 − s from its start, s from 0 to 1."""
    result = np.full(g.shape, s)
    if s > 0.0 and rest > 0.0:
        early = g < SWITCH
        result[early] = images(s, rest, g[early])
        result[~early] = s * (1 - missing_late(s, rest, g[~early]))
    return result


def between(s: float, g: Array) -> Array:
    """Return the share that has reached neither wall; symmetric in s ↔ 1 − s, `s` is the smaller one."""
    result = np.empty(g.shape)
    early = g < SWITCH
    result[early] = probability(g[early], s)
    for j in range(1, IMAGES + 1):
        result[early] += (-1) ** j * erfc_drop(j - s, s, g[early])
    result[~early] = (
        4
        * s
        * sum(np.sinc(n * s) * np.exp(-((n * pi) ** 2) * g[~early]) for n in range(1, MODES, 2))
    )
    return result


def missing_late(s: float, rest: float, g: Array) -> Array:
    """Return δ = 1 − A_pl/s from the modes; (−1)^(n+1) sin(nπs) = sin(nπ rest)."""
    lesser, sign = (s, -1) if s <= 0.5 else (rest, 1)
    total = np.zeros(g.shape)
    for n in range(1, MODES + 1):
        total += sign ** (n + 1) * np.sinc(n * lesser) * np.exp(-((n * pi) ** 2) * g)
    return 2 * lesser / s * total


def images(s: float, rest: float, g: Array) -> Array:
    """Return the share that has reached the wall at distance `rest` from the images that matter while g is small."""
    return np.asarray(sum(erfc_drop(2 * k + rest, s, g) for k in range(IMAGES // 2 + 1)))


def erfc_drop(near_side: float, s: float, g: Array) -> Array:
    """Return erfc(near_side/2√g) − erfc((near_side + 2s)/2√g); by quadrature if the two are nearly equal."""
    centre = near_side + s
    result = _erfc_ratio(near_side, g) - _erfc_ratio(centre + s, g)
    near = centre * s < g
    if near.any():
        width = np.sqrt(g[near])
        c, half = centre / (2 * width), s / (2 * width)
        t = half[:, None] * (1 + _POINTS) / 2
        inner = (np.exp(-(t**2)) * np.cosh(2 * c[:, None] * t)) @ _WEIGHTS
        result[near] = 2 / np.sqrt(pi) * half * np.exp(-(c**2)) * inner
    return result


def _erfc_ratio(distance: float, g: Array) -> Array:
    """Return erfc(distance/2√g), rounding the exponent once: erfc(x) itself errs by x² ε on each step to x."""
    with np.errstate(divide="ignore", under="ignore"):
        return erfcx(distance / (2 * np.sqrt(g))) * np.exp(-(distance**2) / (4 * g))
