"""Elastoplastic contact without hardening: area fractions, plastic smoothing of the spectrum (Eq. 27), where it yields.

The pressure diffuses, as roughness is added, from σ₀ between absorbing walls at 0 (contact lost) and σ_P (yielded).
With s = σ₀/σ_P, g = G/σ_P² and w = 1/2√g, the share that has reached σ_P, the plastic area, is

    Σ_{k≥0} erfc((2k+1−s)w) − erfc((2k+1+s)w)  =  s − (2/π) Σ_{n≥1} (−1)^{n+1} sin(nπs)/n · exp(−n²π²g),

the share that has reached 0 is the same with 1 − s for s, and the elastic rest is

    erf(sw) + Σ_{j≥1} (−1)^j [erfc((j−s)w) − erfc((j+s)w)]  =  (4/π) Σ_{n odd} sin(nπs)/n · exp(−n²π²g).

Images (left) and modes (right) are used where they converge fast; no digits are lost to cancellation in either.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import pi

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import ArrayLike
from scipy.optimize import brentq
from scipy.special import erf, erfcx

from theory.arguments import Array, Spectrum, breaks_of, density, not_negative_array, positive, real_array
from theory.persson import half_variance_table
from theory.quadrature import Primitive

_SWITCH = 0.2  # g: below, images; above, modes: four of the former and five of the latter reach rounding on either side
_IMAGES, _MODES = 7, 6
_POINTS, _WEIGHTS = leggauss(12)
_MILESTONES = (0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 70.0)  # g where the smoothing bends: breaks that help piecewise rules
_BLOCK = 65536  # wavenumbers at a time: stays in the cache


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
    s, rest, hardness = _shares(nominal_pressure, penetration_hardness)
    g = variance / hardness**2
    return reached(rest, s, g), between(min(s, rest), g), reached(s, rest, g)


def stress_distribution(
    stress: ArrayLike, half_variance: float, nominal_pressure: float, penetration_hardness: float
) -> Array:
    """Probability density P(σ, ζ) of the pressure in elastic contact, 1/Pa.

    P = Σ_k [φ(σ − σ₀ − 2kσ_P) − φ(σ + σ₀ + 2kσ_P)], φ the normal density of variance 2G. Its integral over 0 < σ < σ_P
    is the elastic area fraction; the shares without contact (σ = 0) and yielded (σ = σ_P) stand beside it as points.

    Parameters
    ----------
    stress : array_like
        σ of any shape, Pa, from 0 to σ_P.
    half_variance : float
        G at the magnification ζ, Pa², > 0.
    nominal_pressure, penetration_hardness : float
        σ₀ and σ_P, Pa, 0 < σ₀ ≤ σ_P.

    Returns
    -------
    ndarray
        Density in 1/Pa, the shape of `stress`; it vanishes at both ends.

    Raises
    ------
    TypeError, ValueError
        If an argument is not real, finite and of the right sign, σ₀ > σ_P, or a stress exceeds σ_P.
    """
    pressure = not_negative_array("stress", stress, "Pa")
    s, rest, hardness = _shares(nominal_pressure, penetration_hardness)
    g = positive("half_variance", half_variance, "Pa²") / hardness**2
    if (pressure > hardness).any():
        raise ValueError(f"stress = {pressure.max():.6g} Pa exceeds the penetration_hardness {hardness:.6g} Pa")
    t = pressure / hardness
    if g < _SWITCH:
        density_of_t = sum(_image_pair(t, s, 2.0 * k, g) for k in range(-3, 4))
    else:
        small, sign = (s, 1) if s <= rest else (rest, -1)
        modes = range(1, 2 * _MODES)
        density_of_t = 2 * sum(_mode(n, small, sign, t) * np.exp(-((n * pi) ** 2) * g) for n in modes)
    return np.asarray(density_of_t / hardness)


def _image_pair(t: Array, s: float, shift: float, g: float) -> Array:
    norm = 2 * np.sqrt(pi * g)
    with np.errstate(under="ignore"):
        pair = np.exp(-((t - s - shift) ** 2) / (4 * g)) - np.exp(-((t + s + shift) ** 2) / (4 * g))
    return np.asarray(pair / norm)


def _mode(n: int, small: float, sign: int, t: Array) -> Array:
    """Return sin(nπs) sin(nπt), with s = `small` or, for a negative `sign`, 1 − `small`."""
    return np.asarray(sign ** (n + 1) * np.sin(n * pi * small) * np.sin(n * pi * t))


def _shares(nominal_pressure: float, penetration_hardness: float) -> tuple[float, float, float]:
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
        early = g < _SWITCH
        result[early] = _images(s, rest, g[early])
        result[~early] = s * (1 - _missing_late(s, rest, g[~early]))
    return result


def between(s: float, g: Array) -> Array:
    """Return the share that has reached neither wall; symmetric in s ↔ 1 − s, `s` is the smaller one."""
    result = np.empty(g.shape)
    early = g < _SWITCH
    result[early] = _first_wall(s, g[early])
    for j in range(1, _IMAGES + 1):
        result[early] += (-1) ** j * _erfc_drop(j - s, s, g[early])
    result[~early] = 4 * s * sum(np.sinc(n * s) * np.exp(-((n * pi) ** 2) * g[~early]) for n in range(1, _MODES, 2))
    return result


def _first_wall(s: float, g: Array) -> Array:
    """Return erf(s/2√g): the elastic share when the far wall is out of reach."""
    if s == 0.0:
        return np.zeros(g.shape)
    with np.errstate(divide="ignore"):
        return np.asarray(erf(s / (2 * np.sqrt(g))))


def _images(s: float, rest: float, g: Array) -> Array:
    return np.asarray(sum(_erfc_drop(2 * k + rest, s, g) for k in range(_IMAGES // 2 + 1)))


def _erfc_drop(near_side: float, s: float, g: Array) -> Array:
    """Return erfc(near_side/2√g) − erfc((near_side + 2s)/2√g); by quadrature where the two are nearly equal."""
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
        return np.asarray(erfcx(distance / (2 * np.sqrt(g))) * np.exp(-(distance**2) / (4 * g)))


@dataclass(frozen=True, slots=True)
class SmoothedSpectrum:
    """C_sm(q) = [1 − (A_pl/A_pl0)⁶] C(q), m⁴, as made by `smoothed_spectrum`. Eq. (27).

    Equal and equally hashed when all physical arguments (`spectrum`, `effective_modulus`, `nominal_pressure` and
    `penetration_hardness`, Pa) are; `breaks` are those of `spectrum` and those where the
    smoothing bends.
    """

    spectrum: Spectrum
    effective_modulus: float
    nominal_pressure: float
    penetration_hardness: float
    breaks: tuple[float, ...] = field(init=False, compare=False)
    _table: Primitive = field(init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        ends = breaks_of(self.spectrum)
        object.__setattr__(self, "_table", half_variance_table(self.spectrum))
        bends = [self._table.inverse(g / self._rate()) for g in _MILESTONES]
        if bends[-1] <= ends[0]:
            raise ValueError(
                f"penetration_hardness = {self.penetration_hardness:.6g} Pa: the surface has yielded within a relative "
                f"width of 1e-16 above its smallest wavenumber, {ends[0]:.6g} rad/m, so no wave of it is left; raise "
                "penetration_hardness or lower the roughness or the modulus"
            )
        inner = [q for q in bends if ends[0] < q < ends[-1]]
        object.__setattr__(self, "breaks", tuple(sorted({*ends.tolist(), *inner})))

    def __call__(self, q: ArrayLike) -> Array:
        """Return C_sm at the wavenumbers `q`, rad/m, elementwise, m⁴."""
        wavenumber = np.asarray(q, dtype=np.float64)
        flat, result = wavenumber.ravel(), np.empty(wavenumber.size)
        for i in range(0, flat.size, _BLOCK):
            part = slice(i, i + _BLOCK)
            result[part] = self._remaining(self._table(flat[part]))
        return np.asarray(density(self.spectrum, wavenumber) * result.reshape(wavenumber.shape))

    def above(self, q: Array, start: Array, rise: Array) -> Array:
        """Return C_sm at q = start·e^rise, rad/m, elementwise, m⁴: exact also where a layer above q_min yields at once.

        `start` lies within the breaks, and no break of the unsmoothed spectrum between it and q.
        """
        return np.asarray(density(self.spectrum, q, (start, rise)) * self._remaining(self._table.above(start, rise)))

    def _remaining(self, integral: Array) -> Array:
        """Return the factor of Eq. (27) where ∫ q³ C dq has risen to `integral`."""
        s, rest, _ = _shares(self.nominal_pressure, self.penetration_hardness)
        return smoothing(s, rest, self._rate() * integral)

    def _rate(self) -> float:
        """Return what takes ∫ q³ C dq to g = G/σ_P²."""
        return pi / 4 * (self.effective_modulus / self.penetration_hardness) ** 2


def smoothed_spectrum(
    spectrum: Spectrum, *, effective_modulus: float, nominal_pressure: float, penetration_hardness: float
) -> SmoothedSpectrum:
    """Spectrum of the plastically smoothed surface, whose elastic contact area is the elastoplastic one of `spectrum`.

    Parameters
    ----------
    spectrum : callable
        C(q), m⁴, with `breaks`; the result is hashable and picklable when it is.
    effective_modulus, nominal_pressure, penetration_hardness : float
        E*, σ₀ and σ_P, Pa, σ₀ ≤ σ_P.

    Returns
    -------
    SmoothedSpectrum
        C_sm(q), m⁴, with `breaks`: the ends are kept. Eq. (27), [1 − (A_pl/A_pl0)⁶] C(q) with A_pl0/A₀ = σ₀/σ_P.

    Raises
    ------
    TypeError, ValueError
        As `area_fractions`, or the surface yields so soon above q_min that no number lies between.
    """
    modulus = positive("effective_modulus", effective_modulus, "Pa")
    _shares(nominal_pressure, penetration_hardness)
    return SmoothedSpectrum(spectrum, modulus, float(nominal_pressure), float(penetration_hardness))


def smoothing(s: float, rest: float, g: Array) -> Array:
    """Return 1 − (A_pl/s)⁶ with `rest` = 1 − s, to its own relative accuracy: also where it vanishes."""
    missing = np.empty(g.shape)
    early = g < _SWITCH
    missing[early] = _missing_early(s, rest, g[early])
    missing[~early] = _missing_late(s, rest, g[~early])
    with np.errstate(divide="ignore"):
        return np.asarray(-np.expm1(6 * np.log1p(-np.minimum(missing, 1.0))))


def _missing_late(s: float, rest: float, g: Array) -> Array:
    """Return δ = 1 − A_pl/s from the modes; (−1)^(n+1) sin(nπs) = sin(nπ rest)."""
    lesser, sign = (s, -1) if s <= 0.5 else (rest, 1)
    total = np.zeros(g.shape)
    for n in range(1, _MODES + 1):
        total += sign ** (n + 1) * np.sinc(n * lesser) * np.exp(-((n * pi) ** 2) * g)
    return np.asarray(2 * lesser / s * total)


def _missing_early(s: float, rest: float, g: Array) -> Array:
    """Return δ from the images; near full yield they are taken about s = 1, where δ is proportional to `rest`."""
    if s <= 0.5:
        return np.asarray(1 - _images(s, rest, g) / s)
    later = sum(_erfc_drop(2 * k - rest, rest, g) for k in range(1, _IMAGES // 2 + 1))
    return np.asarray((_first_wall(rest, g) - rest + later) / s)


def yield_wavenumber(
    spectrum: Spectrum,
    *,
    effective_modulus: float,
    nominal_pressure: float,
    penetration_hardness: float,
    elastic_share: float = 0.01,
) -> float:
    """Wavenumber q_y up to which roughness must be seen for A_el/(A_el + A_pl) to fall to `elastic_share`, rad/m.

    Parameters, errors: as `smoothed_spectrum`; `elastic_share` between 0 and 1.

    Returns
    -------
    float
        q_y in rad/m; q_min when all is plastic from the start (σ₀ = σ_P), ∞ when q_max comes first.
    """
    share = float(real_array("elastic_share", elastic_share, "1"))
    if not 0.0 < share < 1.0:
        raise ValueError(f"elastic_share = {share:.6g} must lie between 0 and 1")
    modulus = positive("effective_modulus", effective_modulus, "Pa")
    s, rest, hardness = _shares(nominal_pressure, penetration_hardness)
    if rest == 0.0:
        return float(breaks_of(spectrum)[0])

    def excess(log_g: float) -> float:
        g = np.exp(np.array([log_g]))
        elastic, plastic = float(between(min(s, rest), g)[0]), float(reached(s, rest, g)[0])
        return elastic / (elastic + plastic) - share

    g_yield = np.exp(brentq(excess, np.log(1e-30), np.log(70.0), xtol=1e-14))
    return half_variance_table(spectrum).inverse(float(g_yield) * (hardness / modulus) ** 2 * 4 / pi)
