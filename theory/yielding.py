"""The stress spectrum of rough contact, from elastic to fully yielded, with four fitted constants.

The waves put their pressure at their own wavenumber and beside it, `theory.scattering`. Beyond the sums of two waves,
from ONSET q_max on, the edges of the contacts make a tail,

    (q_max/q)³ / [1 + (ONSET q_max/q)⁸] / [1 + (q/q_max)(σ_P/E*h′)²].

A step of the pressure makes q⁻³. Elastic pressure near an edge rises as E*h′√(s/a), with the distance s, the spot size
a ~ 1/q_max and the slope h′, which makes q⁻⁴; in yielding contact that is the rim of a step, a (σ_P/E*h′)² wide. The
tail has the share EDGE of the sidebands above q_max. It also has the difference to M₁ = σ₀σ_P − σ₀², the variance of
contact which has all yielded, times 1 − exp(−D/(RIM σ_P²)), with D the variance of full contact: the rims of
`theory.interface` are too wide, σ_P/(E*q_max h′). The fourth constant is the ANSWER of the half-space. Elastic contact
is the limit σ_P → ∞: there the tail is q⁻⁴, and nothing is missing.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import ceil, expm1, inf, isinf, log, pi, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from theory.arguments import (
    Array,
    SpectrumLike,
    breaks_of,
    density,
    positive,
    real_array,
)
from theory.full_contact import half_variance
from theory.interface import STEP, UNREACHED, diffuse
from theory.quadrature import WEIGHTS, panels_between
from theory.scattering import ScatteringTable, scatter
from theory.splines import Spline, nearest_spline
from theory.validity import OF_STEPS, in_range
from theory.walls import area_fractions, half_variance_of, shares

_DEPTH = 1e3  # sidebands are followed down to q_min over this, constant at the end
_REACH = 1e3  # times q_max to which the tail is followed
_STEPS = (0.01, 0.5)  # e-folds: finer ones take long, coarser ones leave splines without points

EDGE = 0.4  # share of the sidebands above q_max that lies in the tail of the edges
ONSET = 1.7  # q/q_max at which half of the tail has set in: sums of two waves reach 2
LACKING = 0.09  # share of light elastic contact that the walls lack: of 168 elastic and 66 yielded contacts
RIM = 7.0  # D/σ_P² at which 1/e of the variance missing from full yield is truly missing
# the worst over 91 drawn contacts and 200 on a grid is 4.5 % of T_flash and 2.9 % of g_σ(0), over contacts with gaps in
# C(q) 4.1 % and 5.8 %. The contact area was up to 4.3 % off, with gaps 9.1 %, the yielded area from half to 1.4 times
# as large where little has yielded, A_pl/A ≤ .1; of others no band is known
ERROR_BANDS = {
    "flash_temperature": 0.07,
    "pressure_variance": 0.09,
    "contact_fraction": 0.1,
    "plastic_fraction": 0.5,
}
# the worst over 168 elastic contacts is 4.3, 5.2, 12.4, 5.4, 3.0 and 5.8 %; D_flash was always too small
ELASTIC_BANDS = {
    "flash_temperature": 0.05,
    "flash_gradient": 0.07,
    "flash_width": 0.13,
    "slope_length": 0.07,
    "pressure_variance": 0.05,
    "contact_fraction": 0.06,
}


def stress_spectrum(
    spectrum: SpectrumLike,
    *,
    effective_modulus: float,
    nominal_pressure: float,
    penetration_hardness: float,
    step: float = STEP,
) -> YieldingSpectrum:
    """Stress spectrum of contact that yields, from elastic to fully yielded, beside the paper's W on C_sm.

    Pass it as `stress_spectrum` to `persson.pressure_correlation`, `correlation_radius` and every function of `flash`.

    Parameters
    ----------
    spectrum : callable
        C(q), m⁴, with `breaks`; the result is hashable and picklable when it is.
    effective_modulus, nominal_pressure, penetration_hardness : float
        E*, σ₀ and σ_P, Pa, σ₀ ≤ σ_P.
    step : float
        Of the solution, in ln q, .01 to .5. Its error is some .3 % of T_flash, and .05 % of it in what follows a
        cut-off (rms of 28 yielded and 39 elastic contacts; .23 % at most).

    Returns
    -------
    YieldingSpectrum
        |σ_q|² in Pa² m², with `breaks` beyond both ends of C(q). If no pressure reaches σ_P, which lies seven
        standard deviations of full contact away, it is `persson.calibrated_spectrum`.

    Raises
    ------
    TypeError, ValueError
        If an argument is not real, finite and of the right sign, σ₀ > σ_P, or the contact lies outside the range that
        was compared with boundary-element contacts; the message names the quantity.
    """
    modulus = positive("effective_modulus", effective_modulus, "Pa")
    _, _, hardness = shares(nominal_pressure, penetration_hardness)
    pressure = float(nominal_pressure)
    width = positive("step", step, "e-folds")
    if not _STEPS[0] <= width <= _STEPS[1]:
        raise ValueError(
            f"step = {width:g} e-folds lies outside {_STEPS[0]:g} … {_STEPS[1]:g}: leave it out for {STEP:g}"
        )
    end = breaks_of(spectrum)[-1]
    variance = float(half_variance(end, spectrum, effective_modulus=modulus))
    if pressure + UNREACHED * sqrt(2 * variance) < hardness:
        hardness = inf
    spectrum = in_range(spectrum, modulus, pressure, hardness)
    return YieldingSpectrum(spectrum, modulus, pressure, hardness, width)


def calibrated_spectrum(
    spectrum: SpectrumLike, *, effective_modulus: float, nominal_pressure: float
) -> YieldingSpectrum:
    """Stress spectrum of elastic contact, calibrated to boundary-element contacts, as an alternative to the paper's W.

    It is the law of `plasticity.stress_spectrum` in the limit σ_P → ∞.

    Pass it as `stress_spectrum` to `pressure_correlation`, `correlation_radius` and every function of `flash`.

    Parameters
    ----------
    spectrum : callable
        C(q), m⁴, with `breaks`; the result is hashable and picklable when it is.
    effective_modulus, nominal_pressure : float
        E* and σ₀, Pa, both > 0.

    Returns
    -------
    YieldingSpectrum
        |σ_q|² in Pa² m², with `breaks` beyond both ends of C(q).

    Raises
    ------
    TypeError, ValueError
        If an argument is not real, finite and of the right sign, or the contact lies outside the range that was
        compared with boundary-element contacts.
    """
    modulus = positive("effective_modulus", effective_modulus, "Pa")
    pressure = positive("nominal_pressure", nominal_pressure, "Pa")
    spectrum = in_range(spectrum, modulus, pressure, inf)
    return YieldingSpectrum(spectrum, modulus, pressure, inf)


def elastic_steps(
    spectrum: SpectrumLike, *, effective_modulus: float, nominal_pressure: float
) -> YieldingSpectrum:
    """Return `calibrated_spectrum` for quotients of T_flash at two ends of C(q), in a wider range.

    What T_flash of boundary-element contacts gained up to q_max/q_r = 683 was within 10 % of it, on five wide spectra,
    of one also at the lightest load.
    """
    spectrum = in_range(spectrum, effective_modulus, nominal_pressure, inf, OF_STEPS)
    return YieldingSpectrum(spectrum, effective_modulus, nominal_pressure, inf)


class _Law(NamedTuple):
    """The pressure of the waves, and the walls between which it diffused."""

    mean: float  # σ₀, Pa, in elastic contact up to full contact
    highest: float  # σ_P, or a pressure that no point reaches, Pa
    coherent: Spline  # of ln q: the logarithms of `Scattering`
    sidebands: Spline
    compliance: tuple[Array, Array]  # of `Scattering`


class _Balance(NamedTuple):
    """The tail of the edges, and the limit of force balance."""

    variance: float  # g_σ(0), Pa²
    scale: float  # of the pressure of the waves
    edge: float  # |σ_q|² at q_max of the edges, were they steps
    rim: float  # (E*h′/σ_P)²


@dataclass(frozen=True)
class YieldingSpectrum:
    """|σ_q|² in Pa² m², a callable with `breaks`, by `plasticity.stress_spectrum` or `persson.calibrated_spectrum`.

    `breaks` reach from q_min/1000 to 1000 q_max: unevenness of the contact makes stress on both sides of C(q).
    `contact_fraction` A/A₀ and `plastic_fraction` A_pl/A₀ are shares of the nominal area. At σ_P = ∞ contact is
    elastic.
    """

    spectrum: SpectrumLike
    effective_modulus: float
    nominal_pressure: float
    penetration_hardness: float
    step: float = STEP

    @property
    def _ends(self) -> Array:
        """The breaks of C(q), rad/m."""
        return breaks_of(self.spectrum)

    @cached_property
    def breaks(self) -> tuple[float, ...]:
        """Ends, kinks and jumps, rad/m, ascending."""
        ends = self._ends
        knots = np.exp(self._law.coherent.knots), np.exp(self._law.sidebands.knots)
        beyond = ends[-1:] * np.array([ONSET, 4.0, _REACH])
        rising = np.sort(np.concatenate([ends[:1] / _DEPTH, ends, *knots, beyond]))
        distinct = np.append(True, np.diff(rising) > 1e-9 * rising[1:])
        return tuple(rising[distinct].tolist())

    @cached_property
    def _law(self) -> _Law:
        mean, highest = self.nominal_pressure, self.penetration_hardness
        diffusion = diffuse(self.spectrum, self.effective_modulus, mean, highest, step=self.step)
        if isinf(highest):
            mean = float(diffusion.pressure @ diffusion.probability[0])
            highest = float(diffusion.pressure[-1])
        first = log(self._ends[0])
        found = scatter(diffusion, self.effective_modulus)
        coherent, beside = (_smooth(each, first) for each in (found.coherent, found.sidebands))
        return _Law(mean, highest, coherent, beside, found.compliance)

    @cached_property
    def _balance(self) -> _Balance:
        mean, hardness = self.nominal_pressure, self.penetration_hardness
        q, slope = panels_between(np.array(self.breaks)).nodes()
        variance = 2 * pi * q * self._of_waves(q) * slope @ WEIGHTS
        top = self._ends[-1]
        moved = EDGE / (1 - EDGE) * float(variance[q[:, 0] > top].sum())
        own = float(variance.sum()) + moved
        half = float(half_variance(top, self.spectrum, effective_modulus=self.effective_modulus))
        full = 2 * half / hardness**2
        missing, scale = 0.0, 1.0
        if not isinf(hardness):
            most = mean * (hardness - mean)
            missing = max(most - own, 0.0) * -expm1(-full / RIM)
            scale = min(most / own, 1.0)
        rim = 4 * full
        x, slope = panels_between(np.geomspace(1.0, _REACH, 61)).nodes()
        tail = 2 * pi * top**2 * float((x * edges(x, rim) * slope @ WEIGHTS).sum())
        return _Balance(scale * own + missing, scale, (scale * moved + missing) / tail, rim)

    @property
    def contact_fraction(self) -> float:
        """A/A₀, the fraction of the nominal area in contact: that of `between_walls`, and what it lacks at low σ."""
        elastic, plastic = self.between_walls()
        area = elastic + plastic
        return area * (1 + LACKING * (1 - area**2) * (elastic / area) ** 4)

    @property
    def plastic_fraction(self) -> float:
        """A_pl/A₀, the fraction of the nominal area that has yielded."""
        return 0.0 if isinf(self.penetration_hardness) else self.between_walls()[1]

    def between_walls(self) -> tuple[float, float]:
        """Return A_el/A₀ and A_pl/A₀ of a pressure that diffused between absorbing walls to the variance of this one.

        The walls at 0 and σ_P take what leaves contact and what yields.
        """
        mean, highest, *_ = self._law
        share, variance = mean / highest, self._balance.variance / highest**2
        _, elastic, plastic = area_fractions(half_variance_of(share, variance), share, 1.0)
        return float(elastic), float(plastic)

    def __call__(self, q: ArrayLike) -> Array:
        """Return |σ_q|² at the wavenumbers `q`, rad/m, elementwise, Pa² m²."""
        wavenumber = real_array("q", q, "rad/m")
        high = self._ends[-1]
        result = self._of_waves(wavenumber)
        result *= self._balance.scale
        above = (wavenumber > high) & (wavenumber <= self.breaks[-1])
        result[above] += self._balance.edge * edges(wavenumber[above] / high, self._balance.rim)
        return result

    def _of_waves(self, q: Array) -> Array:
        """Return |σ_q|² without the tail of the edges, nor the limit of force balance."""
        result = self._of_own(q)
        beside = (q >= self.breaks[0]) & (q <= np.exp(self._law.sidebands.knots[-1]))
        result[beside] += np.exp(self._law.sidebands(np.log(q[beside])))
        result[(q > self._ends[-1]) & (q <= self.breaks[-1])] *= 1 - EDGE
        return result

    def _of_own(self, q: Array) -> Array:
        """Return |σ_q|² that waves make at their own wavenumber, before the limit of force balance."""
        ends, result = self._ends, np.zeros(q.shape)
        inside = (q >= ends[0]) & (q <= ends[-1])
        full = (self.effective_modulus * q[inside] / 2) ** 2 * density(self.spectrum, q[inside])
        result[inside] = full * np.exp(self._law.coherent(np.log(q[inside])))
        return result

    def own_share(self, q: Array) -> Array:
        """Return the share of |σ_q|², from 0 to 1, that waves make at their own wavenumbers `q`, rad/m."""
        whole, own = self(q), self._balance.scale * self._of_own(q)
        return np.divide(own, whole, out=np.zeros(q.shape), where=whole > 0.0)

    def compliance(self, q: Array) -> Array:
        """Return the mean compliance ⟨c⟩ of the interface of the waves beyond `q`, rad/m, m/Pa."""
        return np.interp(np.log(q), *self._law.compliance)


def edges(x: Array, rim: float) -> Array:
    """Return the tail of the edges at q = x q_max, in any unit: q⁻³ up to x = `rim`, q⁻⁴ beyond."""
    return x**-3 / (1 + (ONSET / x) ** 8) * (1 + rim) / (x + rim)


def _smooth(table: ScatteringTable, first: float) -> Spline:
    """Return the spline nearest to a table, its knots whole e-folds from `first`."""
    x = table.place
    knots = np.arange(ceil(x[0] - first), ceil(x[-1] - first)) + first
    inner = knots[(knots > x[0] + 0.3) & (knots < x[-1] - 0.3)]
    return nearest_spline(x, table.value, table.weight, inner)
