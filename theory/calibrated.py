"""The stress spectrum of elastic contact, calibrated to boundary-element contacts (experiments/validity.py).

With G(q) = (π/4) E*² ∫ q³ C dq from q_min to q, G₁ its whole, and P = erf(σ₀/2√G):

    later roughness    Ḡ(q) = G + c ∫ (q/k) dG(k) from q to q_max,    P̄ = erf(σ₀/2√Ḡ)
    memory             m_n(q) = ∫ (k/q)ⁿ dG(k) / G(q) from q_min to q, from 1 at q_min downwards
    in the band        W = P^a P̄^(b₀ + b₁ ln m₁ + b₄ ln m₄)
    above q_max        |σ_q|² = e^(t₀ + t₃ ln m₁ + t₄ ln m₄) P₁^t₁ (1 − P₁)^t₂ (q_max/q)⁴ [1 + u (q_max/q)²]
                       × full contact at q_max
    below q_min        |σ_q|² = e^f P̄₀^b₀ (1 − P̄₀) × full contact at q_min, constant

with u = e^(u₀ + u₄ ln m₄), the index 1 for q_max, 0 for q_min: the edges of the contacts, and the shot noise of their
number.

W multiplies the stress of full contact, (E* q/2)² C(q). In full contact P = P̄ = 1: W = 1 exactly, and the tail and
the floor vanish. The paper's W knows neither later roughness nor memory, and ends at q_max. All constants are fitted.
"""

from dataclasses import dataclass, field
from math import exp, inf, log, pi, sqrt
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike

from theory import quadrature
from theory.arguments import Array, Spectrum, breaks_of, density, octaves_of_gaps, positive, real_array


class Constants(NamedTuple):
    """The thirteen fitted numbers, in the letters of the module's formulas."""

    later: float  # c
    present: float  # a
    power: tuple[float, float, float]  # b₀, b₁, b₄
    floor: float  # f
    edge: tuple[float, float, float, float, float]  # t₀ … t₄
    near: tuple[float, float]  # u₀, u₄


CONSTANTS = Constants(
    later=1.901,
    present=0.6019,
    power=(0.877, -0.8781, 0.6338),
    floor=-2.776,
    edge=(-2.138, 0.8043, 1.437, 5.33, -2.523),
    near=(-1.032, -0.9605),
)
LIGHTEST = 0.01  # σ₀/(E*h′); up to full contact
# of what was calibrated: q_max ∫C dq/∫qC dq, which is about q_max/q_roll_off, and the memories m₁, m₄ at q_max
BANDWIDTH, MEMORY, SHARPNESS = (2.3, 80.0), (0.22, 0.66), (0.055, 0.31)
# q_max/q_min: contacts were compared from 7.8 on. With H near 1 and a light load T_flash is 4.2, 4.7, 5.8 and 7.4 % too
# low at 8.2, 6.3, 4.6 and 3.7
WIDTH = (6.0, inf)
GAPS = (0.0, 0.5)  # octaves of waves that add less than FAINT of what waves on both sides of them add to G
FAINT = 0.5
# rms 1.2 %, worst 3.9 % over 15 fresh contacts; of T′, which was compared on the map only, 1.7 % and 7.0 %
ERROR_BANDS = {
    "flash_temperature": 0.05,
    "flash_gradient": 0.07,
    "flash_width": 0.05,
    "slope_length": 0.05,
    "pressure_variance": 0.05,
}
_REACH = 1e8  # the tail is followed to this multiple of q_max: what is beyond is 1e-4 of ∇²T at infinite speed
_DEPTH = 1e3  # and the floor down to q_min over this


@dataclass(frozen=True, slots=True)
class CalibratedSpectrum:
    """|σ_q|² of elastic contact in Pa² m², a callable with `breaks`; made by `persson.calibrated_spectrum`.

    `breaks` reach from q_min/1000 to 10⁸ q_max: the stress neither begins at q_min nor ends at q_max.
    """

    spectrum: Spectrum
    effective_modulus: float
    nominal_pressure: float
    breaks: tuple[float, ...] = field(init=False, compare=False)
    _moments: dict[int, quadrature.Primitive] = field(init=False, repr=False, compare=False)
    _outside: tuple[float, float, float] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        ends = breaks_of(self.spectrum)
        moments = {n: _moment(self.spectrum, ends, n) for n in (0, 1, 2, 3, 4, 7)}
        object.__setattr__(self, "_moments", moments)
        object.__setattr__(self, "breaks", (float(ends[0]) / _DEPTH, *map(float, ends), float(ends[-1]) * _REACH))
        self._check_range()
        object.__setattr__(self, "_outside", self._levels(float(ends[0]), float(ends[-1])))

    def __call__(self, q: ArrayLike) -> Array:
        """Return |σ_q|² at the wavenumbers `q`, rad/m, elementwise, Pa² m²."""
        wavenumber = real_array("q", q, "rad/m")
        low, high = self.breaks[1], self.breaks[-2]
        inside = (wavenumber >= low) & (wavenumber <= high)
        floor, edge, near = self._outside
        result = np.zeros(wavenumber.shape)
        band = wavenumber[inside]
        result[inside] = self._full(band) * self.weight(band)
        below = (wavenumber < low) & (wavenumber >= self.breaks[0])
        result[below] = floor
        above = (wavenumber > high) & (wavenumber <= self.breaks[-1])
        ratio = high / wavenumber[above]
        result[above] = edge * ratio**4 * (1 + near * ratio**2)
        return result

    def weight(self, q: ArrayLike) -> Array:
        """Return W, the share of the full-contact stress spectrum, at wavenumbers from q_min to q_max, rad/m."""
        wavenumber = np.asarray(q, dtype=np.float64)
        here, later, (memory, sharp) = self._features(wavenumber)
        powers = CONSTANTS.power
        exponent = powers[0] + powers[1] * np.log(memory) + powers[2] * np.log(sharp)
        with np.errstate(divide="ignore"):
            log_p = np.log(scipy.special.erf(self.nominal_pressure / (2 * np.sqrt(here))))
            log_later = np.log(scipy.special.erf(self.nominal_pressure / (2 * np.sqrt(here + CONSTANTS.later * later))))
        return np.asarray(np.exp(CONSTANTS.present * log_p + exponent * log_later))

    def _features(self, q: Array) -> tuple[Array, Array, tuple[Array, Array]]:
        """Return G, ∫ (q/k) dG(k) above q, and the memories m₁, m₄."""
        rate = pi / 4 * self.effective_modulus**2
        third = self._moments[3](q)
        with np.errstate(divide="ignore", invalid="ignore"):
            memory, sharp = (np.where(third > 0.0, self._moments[3 + n](q) / (q**n * third), 1.0) for n in (1, 4))
        second = self._moments[2]
        later = q * np.maximum(second(np.full(1, self.breaks[-2])) - second(q), 0.0)
        return rate * third, rate * later, (memory, sharp)

    def _full(self, q: Array) -> Array:
        return np.asarray((self.effective_modulus * q / 2) ** 2 * density(self.spectrum, q))

    def _levels(self, low: float, high: float) -> tuple[float, float, float]:
        """Return |σ_q|² of the floor, and level and steepening of the tail at q_max."""
        ends = np.array([low, high])
        here, later, (memory, sharp) = self._features(ends)
        stress = self._full(ends)
        opening = float(scipy.special.erf(self.nominal_pressure / (2 * sqrt(CONSTANTS.later * later[0]))))
        floor = exp(CONSTANTS.floor) * opening ** CONSTANTS.power[0] * (1 - opening) * stress[0]
        share = float(scipy.special.erf(self.nominal_pressure / (2 * sqrt(here[1]))))
        m, s, p = log(memory[1]), log(sharp[1]), log(share)
        t, u = CONSTANTS.edge, CONSTANTS.near
        edge = exp(t[0] + t[1] * p + t[3] * m + t[4] * s) * (1 - share) ** t[2] * stress[1]
        return float(floor), float(edge), exp(u[0] + u[1] * s)

    def _check_range(self) -> None:
        """Refuse loads and spectra outside the range of the contacts that the law was fitted to."""
        high = np.array([self.breaks[-2]])
        zeroth, first, third, fourth, seventh = (float(self._moments[n](high)[0]) for n in (0, 1, 3, 4, 7))
        slope, top = sqrt(2 * pi * third), float(high[0])
        load = self.nominal_pressure / (self.effective_modulus * slope)
        if load < LIGHTEST:
            raise ValueError(
                f"nominal_pressure = {self.nominal_pressure:.6g} Pa is {load:.3g} E*h′, below the {LIGHTEST:g} E*h′ "
                f"that is calibrated; raise it to {LIGHTEST * self.effective_modulus * slope:.6g} Pa or use the "
                "paper's weight"
            )
        q = np.unique(np.concatenate([np.geomspace(self.breaks[1], top, 401), self.breaks[1:-1]]))
        gaps = octaves_of_gaps(q, q**4 * density(self.spectrum, q), FAINT)
        seen = {
            "octaves of gaps": (gaps, GAPS),
            "width q_max/q_min": (top / self.breaks[1], WIDTH),
            "bandwidth q_max ∫C dq/∫qC dq": (top * zeroth / first, BANDWIDTH),
            "memory m₁ at q_max": (fourth / (top * third), MEMORY),
            "memory m₄ at q_max": (seventh / (top**4 * third), SHARPNESS),
        }
        for name, (value, (least, most)) in seen.items():
            if not least <= value <= most:
                raise ValueError(
                    f"spectrum has the {name} = {value:.3g}, outside {least:g} … {most:g} that is calibrated; use the "
                    "paper's weight for it"
                )


def _moment(spectrum: Spectrum, ends: Array, power: int) -> quadrature.Primitive:
    return quadrature.primitive(lambda q, place: q**power * density(spectrum, q, place), ends)


def calibrated(spectrum: Spectrum, effective_modulus: float, nominal_pressure: float) -> CalibratedSpectrum:
    """Return the calibrated stress spectrum of checked numbers; see `persson.calibrated_spectrum`."""
    modulus = positive("effective_modulus", effective_modulus, "Pa")
    return CalibratedSpectrum(spectrum, modulus, positive("nominal_pressure", nominal_pressure, "Pa"))
