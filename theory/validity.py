"""Range of the calibrated law: the contacts that it was compared with, in numbers of C(q) and of the load."""

from dataclasses import dataclass
from math import inf, isinf, sqrt

import numpy as np

from theory.arguments import Array, SpectrumLike, breaks_of, density, octaves_of_gaps
from theory.full_contact import half_variance
from theory.walls import yield_wavenumber

_Ends = tuple[float, float]

_SHARE = (0.005, 0.6)  # σ₀/σ_P
_BAND = (2.0, inf)  # q_max/q_min
_PLATEAU = (1.0, 16.0)  # q_r over the first wave that counts
# power of q, times which C is largest at q_r: above 2, so that a flat q²C ends at q_r
_ROLLED = 2.05
_ROUNDING = 1e-6  # of the largest: of several that are equal but for it, q_r is the last
# H of C ~ q^(−2−2H), the mean from q_r to q_max, or fitted up to _FITTED q_y; of 33 contacts with H above 1, or with a
# tail or a floor after a power law, T_flash was at most 7.5 % off, with 1 to 8 % of scatter
_HURST = (0.3, 2.0)
_FITTED = 2.0
# of the largest part of an octave in G: the last wave with as much ends C(q) for the law
_LAST = 0.01
# of the part of the octave at q_r in T_flash of full contact at rest: the first wave with as much counts
_FIRST = 0.01
_YIELDED = (0.25, 8.0)  # q_y/q_r if all has yielded at q_max
_YIELDING = (1.0, 32.0)  # q_max/q_r if not
# octaves of waves whose part of G is below FAINT of the part of waves on both sides
GAPS = (0.0, 1.5)
FAINT = 0.1
# the range of the elastic contacts
_ELASTIC_HURST = (0.3, 1.0)
_ELASTIC_LOAD = (0.002, inf)  # σ₀/(E*h′): up to full contact, for which the law is exact
_ELASTIC_BAND = (3.7, inf)  # q_max/q_min
_ELASTIC_END = (1.0, 64.0)  # q_max/q_r
_ELASTIC_GAPS = (0.0, 0.5)  # octaves: none with wider gaps was compared
OF_ELASTIC = _ELASTIC_LOAD, _ELASTIC_END
OF_STEPS = (5e-4, inf), (1.0, inf)  # the same two for quotients of T_flash at two ends
_ELASTIC_SHARE = 0.01  # of the contact: below, all has yielded


def in_range(
    spectrum: SpectrumLike,
    modulus: float,
    pressure: float,
    hardness: float,
    elastic: tuple[_Ends, _Ends] = OF_ELASTIC,
) -> SpectrumLike:
    """Return C(q) up to the last wave that counts; σ_P = ∞ is elastic contact.

    ValueError for a contact outside the range that was compared.
    """
    q, level = _waves(spectrum)
    end = float(q[-1])
    if end < breaks_of(spectrum)[-1]:
        spectrum = UpTo(spectrum, end)
    is_elastic = isinf(hardness)
    loads, ends = elastic
    height = q**_ROLLED * level
    roll_off = q[np.flatnonzero(height >= (1 - _ROUNDING) * height.max())[-1]]
    warm = q**3 * level
    first = q[np.flatnonzero((warm >= _FIRST * warm[q == roll_off]) & (q <= roll_off))[0]]
    _inside("q_roll_off/q_min", roll_off / first, _PLATEAU)
    gaps = octaves_of_gaps(q, q**4 * level, FAINT)
    _inside("octaves of gaps in C(q)", gaps, _ELASTIC_GAPS if is_elastic else GAPS)
    q_y = inf
    if is_elastic:
        variance = float(half_variance(end, spectrum, effective_modulus=modulus))
        _inside("nominal_pressure/(E*h′)", pressure / sqrt(8 * variance), loads)  # G = (E*h′)²/8
    else:
        _inside("nominal_pressure/penetration_hardness", pressure / hardness, _SHARE)
        q_y = yield_wavenumber(
            spectrum,
            effective_modulus=modulus,
            nominal_pressure=pressure,
            penetration_hardness=hardness,
            elastic_share=_ELASTIC_SHARE,
        )
    _inside("q_max/q_min", end / q[0], _ELASTIC_BAND if is_elastic else _BAND)
    if q_y <= end:
        _inside("q_y/q_roll_off", q_y / roll_off, _YIELDED)
    else:
        _inside("q_max/q_roll_off", end / roll_off, ends if is_elastic else _YIELDING)
    few = min(end, _FITTED * q_y)
    if few > 1.5 * roll_off:
        _check_slope(q, level, roll_off, few, _ELASTIC_HURST if is_elastic else _HURST)
    return spectrum


def _check_slope(q: Array, level: Array, roll_off: float, few: float, compared: _Ends) -> None:
    """Raise ValueError if H of C ~ q^(−2−2H) is outside the range from the roll-off to `few`, and to the end as well.

    Finer waves than a `few` q_y change yielded contact little, whether or not they follow the same power.
    """
    x, y = np.log(q), np.log(level)
    band = (q >= roll_off) & (q <= few)
    part = q[band] ** 4 * level[band]  # of G: by it each wave counts in the fit
    fitted = np.polyfit(x[band], y[band], 1, w=np.sqrt(part))[0]
    mean = (y[-1] - y[band][0]) / (x[-1] - x[band][0])
    exponents = [(-1 - slope / 2, to) for slope, to in ((fitted, few), (mean, q[-1]))]
    hurst, to = min(exponents, key=lambda one: abs(one[0] - sum(compared) / 2))
    _inside(
        f"Hurst exponent by the slope of C(q) from {roll_off:.3g} to {to:.3g} rad/m",
        hurst,
        compared,
    )


def _waves(spectrum: SpectrumLike) -> tuple[Array, Array]:
    """Return wavenumbers up to the last wave that counts, and C(q) there; ValueError where C(q) is 0."""
    ends = breaks_of(spectrum)
    q = np.unique(np.concatenate([np.geomspace(ends[0], ends[-1], 401), ends]))
    level = density(spectrum, q)
    if not level.all():
        raise ValueError(
            f"C(q) = 0 at q = {q[np.flatnonzero(level == 0.0)[0]]:.6g} rad/m: the calibrated law was compared with "
            "spectra without gaps; use the paper's weight for it"
        )
    rise = q**4 * level  # in proportion to the part of an octave in G
    # C(q) of a filtered map goes on far below
    last = int(np.flatnonzero(rise >= _LAST * rise.max())[-1])
    return q[: last + 1], level[: last + 1]


def octaves_missing(spectrum: SpectrumLike) -> float:
    """Return the octaves of gaps in C(q): of waves whose part of G is below `FAINT` of the part on both sides."""
    q, level = _waves(spectrum)
    return octaves_of_gaps(q, q**4 * level, FAINT)


def _inside(name: str, value: float, compared: _Ends) -> None:
    """Raise ValueError for a number of a contact outside the range that was compared."""
    least, most = compared
    if not least * (1 - 1e-3) <= value <= most * (1 + 1e-3):
        raise ValueError(
            f"{name} = {value:.3g} lies outside {least:g} … {most:g}, the range of the contacts behind the "
            "calibrated law; use the paper's weight for it"
        )


@dataclass(frozen=True, slots=True)
class UpTo:
    """A spectrum up to `end`, rad/m."""

    spectrum: SpectrumLike
    end: float

    @property
    def breaks(self) -> tuple[float, ...]:
        """Ends, kinks and jumps, rad/m."""
        ends = breaks_of(self.spectrum)
        return (*ends[ends < self.end].tolist(), self.end)

    def __call__(self, q: Array) -> Array:
        """Return C at the wavenumbers `q`, rad/m, m⁴."""
        return np.where(q <= self.end, self.spectrum(q), 0.0)
