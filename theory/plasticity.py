"""Elastoplastic contact without hardening: area fractions, yield wavenumber, plastic smoothing of C(q) (Eq. 27).

The area fractions come from `theory.walls`, the law of the stress spectrum of contact that yields from
`theory.yielding`.
"""

from dataclasses import dataclass, field
from math import pi

import numpy as np
from numpy.typing import ArrayLike

from theory.arguments import Array, SpectrumLike, breaks_of, density, not_negative_array, positive
from theory.full_contact import half_variance_table, probability
from theory.quadrature import Primitive
from theory.walls import (
    IMAGES,
    MODES,
    SWITCH,
    area_fractions,
    erfc_drop,
    images,
    missing_late,
    shares,
    yield_wavenumber,
)
from theory.yielding import stress_spectrum

__all__ = [
    "SmoothedSpectrum",
    "area_fractions",
    "smoothed_spectrum",
    "smoothing",
    "stress_distribution",
    "stress_spectrum",
    "yield_wavenumber",
]

_MILESTONES = (
    0.03,
    0.1,
    0.3,
    1.0,
    3.0,
    10.0,
    70.0,
)  # g, bends of the smoothing: breaks that help piecewise rules
_BLOCK = 65536  # wavenumbers at a time: stays in the cache


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
    s, rest, hardness = shares(nominal_pressure, penetration_hardness)
    g = positive("half_variance", half_variance, "Pa²") / hardness**2
    if (pressure > hardness).any():
        raise ValueError(
            f"stress = {pressure.max():.6g} Pa exceeds the penetration_hardness {hardness:.6g} Pa"
        )
    t = (pressure / hardness)[..., None]
    if g < SWITCH:
        start = s + 2.0 * np.arange(-3, 4)
        with np.errstate(under="ignore"):
            pairs = np.exp(-((t - start) ** 2) / (4 * g)) - np.exp(-((t + start) ** 2) / (4 * g))
        terms = pairs / (2 * np.sqrt(pi * g))
    else:
        n = np.arange(1, 2 * MODES)
        # sin(nπs), from 1 − s if that is less
        sines = np.sin(n * pi * s) if s <= rest else (-1) ** (n + 1) * np.sin(n * pi * rest)
        terms = 2 * sines * np.sin(n * pi * t) * np.exp(-((n * pi) ** 2) * g)
    return np.asarray(terms.sum(axis=-1) / hardness)


@dataclass(frozen=True, slots=True)
class SmoothedSpectrum:
    """C_sm(q) = [1 − (A_pl/A_pl0)⁶] C(q), m⁴, as made by `smoothed_spectrum`. Eq. (27).

    Two of them are equal if all but their breaks are.

    Attributes
    ----------
    spectrum : callable
        C(q), m⁴, with `breaks`.
    effective_modulus, nominal_pressure, penetration_hardness : float
        E*, σ₀ and σ_P, Pa.
    breaks : tuple of float
        Breaks of `spectrum` and bends of the smoothing, rad/m.
    """

    spectrum: SpectrumLike
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
                "penetration_hardness or lower the roughness or the modulus; check the units of the roughness, too: "
                "C(q) is in m⁴, and 1 µm⁴ is 1e-24 m⁴"
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
        """Smoothed spectrum close above a break: exact also if a layer above q_min yields at once. Eq. (27).

        Parameters
        ----------
        q, start, rise : ndarray
            q = start·e^rise in rad/m; `start` lies within the breaks, and no break of `spectrum` between it and q.

        Returns
        -------
        ndarray
            C_sm in m⁴, the shape of `q`.
        """
        return density(self.spectrum, q, (start, rise)) * self._remaining(
            self._table.above(start, rise)
        )

    def _remaining(self, integral: Array) -> Array:
        """Return the factor of Eq. (27) at ∫ q³ C dq = `integral`."""
        s, rest, _ = shares(self.nominal_pressure, self.penetration_hardness)
        return smoothing(s, rest, self._rate() * integral)

    def _rate(self) -> float:
        """Return the factor from ∫ q³ C dq to g = G/σ_P²."""
        return pi / 4 * (self.effective_modulus / self.penetration_hardness) ** 2


def smoothed_spectrum(
    spectrum: SpectrumLike,
    *,
    effective_modulus: float,
    nominal_pressure: float,
    penetration_hardness: float,
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
    shares(nominal_pressure, penetration_hardness)
    return SmoothedSpectrum(spectrum, modulus, float(nominal_pressure), float(penetration_hardness))


def smoothing(s: float, rest: float, g: Array) -> Array:
    """Return 1 − (A_pl/s)⁶ with `rest` = 1 − s, to its own relative accuracy, also near 0."""
    missing = np.empty(g.shape)
    early = g < SWITCH
    missing[early] = _missing_early(s, rest, g[early])
    missing[~early] = missing_late(s, rest, g[~early])
    with np.errstate(divide="ignore"):
        return np.asarray(-np.expm1(6 * np.log1p(-np.minimum(missing, 1.0))))


def _missing_early(s: float, rest: float, g: Array) -> Array:
    """Return δ from the images; near full yield they are taken about s = 1, since δ is proportional to `rest` there."""
    if s <= 0.5:
        return 1 - images(s, rest, g) / s
    later = sum(erfc_drop(2 * k - rest, rest, g) for k in range(1, IMAGES // 2 + 1))
    return (probability(g, rest) - rest + later) / s
