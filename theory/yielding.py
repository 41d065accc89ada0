"""The stress spectrum of rough contact that yields, from elastic to fully yielded, with one fitted constant.

With κ and P of `theory.interface`, a wave of q and height dh makes the pressure κ dh. κ differs from place to place
with the coarser waves, so that the wave makes pressure at its own q and at |q + k|, k < q:

    coherent     C ⟨κ⟩² [1 + 2 Σ_k V (ρ − 1)/⟨κ⟩²],   ρ = mean over angles of g(|q + k|)/g(q)
    sidebands    2πqC dq V(q, k) at Q = |q + k|, times [g(Q)/g(q)]²,   uniform in angle

V(q, k) is the variance of κ(q) that shell k makes, g(Q) = 1/(⟨c⟩ + 2/E*Q) the response of the half-space behind a mean
interface, ⟨c⟩ = ⟨κ⟩/⟨κ²⟩ − 2/E*q. Both terms are of the second order of the response to an uneven interface.

Above q_max the edges of the contacts make a tail, EDGE |σ_q|²(q_max) (q_max/q)³. EDGE is the one fitted constant. The
variance of the whole lies between M, that of P, and M₁ = σ₀σ_P − σ₀², that of contact which has all yielded, where
force balance leaves no choice: the tail is higher or lower where it must be. docs/yielding.md derives all of it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from math import ceil, inf, log, pi, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import BSpline, make_lsq_spline
from scipy.linalg.lapack import dgtsv

from theory.arguments import Array, Spectrum, breaks_of, density, positive, real_array
from theory.calibrated import CalibratedSpectrum, calibrated
from theory.interface import STEP, UNREACHED, Diffusion, between_shells, diffuse
from theory.persson import half_variance
from theory.quadrature import WEIGHTS, panels_between
from theory.walls import area_fractions, between, shares, yield_wavenumber

ANGLES = 24
_FEWEST = 16  # shells
_BELOW = 1.0  # e-folds below q_min to which sidebands are told apart; they are constant from there on
_DEPTH = 1e3  # and followed down to q_min over this
_REACH = 1e3  # times q_max to which the rest of the variance is followed, as q⁻³
_DEGREE = 5  # of the splines, whose knots are an e-fold apart
_LAST = 1e-4  # of the sidebands is cut off at the upper end
_FAINT = 1e-2  # the least weight of a bin of sidebands, those that hardly a wave reaches
_NOTHING = (
    1e-14  # of the largest variance of a bin: full contact has no sidebands, and they have a logarithm all the same
)

# the range of the contacts that the law was compared with
SHARE = (0.005, 0.6)  # σ₀/σ_P
BAND = (2.0, inf)  # q_max/q_min
PLATEAU = (1.0, 16.0)  # q_r/q_min, with q²C largest at q_r
HURST = (0.3, 1.0)  # H of C ~ q^(−2−2H) from q_r to q_max
YIELDED = (0.25, 8.0)  # q_y/q_r where all has yielded at q_max
YIELDING = (1.0, 32.0)  # q_max/q_r where it has not

ELASTIC_SHARE = 0.01  # of the contact: below, all has yielded
EDGE = 0.05  # of |σ_q|² at q_max: the level at which the tail of the edges begins there
# the worst over 40 drawn contacts and the map is 7.0 % of T_flash and 11 % of g_σ(0); of others no band is known
ERROR_BANDS = {"flash_temperature": 0.07, "pressure_variance": 0.12}


def stress_spectrum(
    spectrum: Spectrum,
    *,
    effective_modulus: float,
    nominal_pressure: float,
    penetration_hardness: float,
    step: float = STEP,
) -> YieldingSpectrum | CalibratedSpectrum:
    """Stress spectrum of contact that yields, from elastic to fully yielded, beside the paper's W on C_sm.

    Pass it as `stress_spectrum` to `persson.pressure_correlation`, `correlation_radius` and every function of `flash`.

    Parameters
    ----------
    spectrum : callable
        C(q), m⁴, with `breaks`; the result is hashable and picklable when it is.
    effective_modulus, nominal_pressure, penetration_hardness : float
        E*, σ₀ and σ_P, Pa, σ₀ ≤ σ_P.
    step : float
        Of the solution, in ln q. The error of the steps in T_flash, some .3 %, jumps with the end of C(q): quotients of
        two ends want finer ones.

    Returns
    -------
    YieldingSpectrum or CalibratedSpectrum
        |σ_q|² in Pa² m², with `breaks` beyond both ends of C(q). Where no pressure reaches σ_P, which lies seven
        standard deviations of full contact away, it is `persson.calibrated_spectrum`.

    Raises
    ------
    TypeError, ValueError
        If an argument is not real, finite and of the right sign, σ₀ > σ_P, or the contact lies outside the range that
        was compared with boundary-element contacts: the message names what does.
    """
    modulus = positive("effective_modulus", effective_modulus, "Pa")
    share, _, hardness = shares(nominal_pressure, penetration_hardness)
    pressure = float(nominal_pressure)
    ends = breaks_of(spectrum)
    q = np.unique(np.concatenate([np.geomspace(ends[0], ends[-1], 401), ends]))
    height = q**2 * density(spectrum, q)
    if not height.all():
        raise ValueError(
            f"C(q) = 0 at q = {q[np.flatnonzero(height == 0.0)[0]]:.6g} rad/m: the law for contact that yields was "
            "compared with spectra without gaps; use the paper's weight for it"
        )
    roll_off = q[int(np.argmax(height))]
    reach = np.array([*(min(r * roll_off, ends[-1]) for r in YIELDED), ends[-1]])
    variance = half_variance(reach, spectrum, effective_modulus=modulus)
    if pressure + UNREACHED * sqrt(2 * variance[-1]) < hardness:
        return calibrated(spectrum, modulus, pressure)
    _, elastic, plastic = area_fractions(variance, pressure, hardness)
    yielded = elastic < ELASTIC_SHARE * (elastic + plastic)
    solid = {"effective_modulus": modulus, "nominal_pressure": pressure, "penetration_hardness": hardness}
    seen = {
        "nominal_pressure/penetration_hardness": (share, SHARE),
        "q_max/q_min": (ends[-1] / ends[0], BAND),
        "q_roll_off/q_min": (roll_off / ends[0], PLATEAU),
    }
    if ends[-1] > 1.5 * roll_off:
        seen["Hurst exponent"] = (log(height.max() / height[-1]) / log(ends[-1] / roll_off) / 2, HURST)
    if not yielded[-1]:
        seen["q_max/q_roll_off"] = (ends[-1] / roll_off, YIELDING)
    elif yielded[0] or not yielded[1]:
        seen["q_y/q_roll_off"] = (yield_wavenumber(spectrum, **solid) / roll_off, YIELDED)
    for name, (value, (least, most)) in seen.items():
        if not least * (1 - 1e-3) <= value <= most * (1 + 1e-3):
            raise ValueError(
                f"{name} = {value:.3g} lies outside {least:g} … {most:g}, where the law for contact that yields was "
                "compared with contacts; use the paper's weight for it"
            )
    return YieldingSpectrum(spectrum, **solid, step=positive("step", step, "e-folds"))


@dataclass(frozen=True, slots=True)
class YieldingSpectrum:
    """|σ_q|² in Pa² m², a callable with `breaks`; made by `plasticity.stress_spectrum`.

    `breaks` reach from q_min/1000 to 1000 q_max: unevenness of the contact makes stress on both sides of C(q).
    `contact_fraction` A/A₀ and `plastic_fraction` A_pl/A₀ are shares of the nominal area: those of a pressure that
    diffused between absorbing walls at 0 and σ_P until it had the variance of this spectrum.
    """

    spectrum: Spectrum
    effective_modulus: float
    nominal_pressure: float
    penetration_hardness: float
    step: float = STEP
    breaks: tuple[float, ...] = field(init=False, compare=False)
    _whole: float = field(init=False, repr=False, compare=False)  # g_σ(0)/σ_P²
    _coherent: BSpline = field(init=False, repr=False, compare=False)
    _sidebands: BSpline = field(init=False, repr=False, compare=False)
    _scale: float = field(init=False, repr=False, compare=False)
    _edge: float = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        solid = self.effective_modulus, self.nominal_pressure, self.penetration_hardness
        diffusion = diffuse(self.spectrum, *solid, step=self.step)
        scattering = scatter(diffusion, self.effective_modulus, self.step)
        ends = breaks_of(self.spectrum)
        coherent, sidebands = (_smooth(table, log(ends[0])) for table in scattering)
        inner = np.concatenate([ends, np.exp(coherent.t), np.exp(sidebands.t)])
        breaks = np.concatenate([ends[:1] / _DEPTH, inner, ends[-1:] * _REACH])
        values = {"_coherent": coherent, "_sidebands": sidebands, "_scale": 1.0, "_edge": 0.0}
        for name, value in {**values, "breaks": tuple(_distinct(breaks).tolist())}.items():
            object.__setattr__(self, name, value)
        self._balance(diffusion)

    def _balance(self, diffusion: Diffusion) -> None:
        """Give the edges of the contacts their tail, within what the variance of P and force balance leave."""
        mean, hardness = self.nominal_pressure, self.penetration_hardness
        most = mean * (hardness - mean)
        whole = min(float(diffusion.probability[-1] @ (diffusion.pressure - mean) ** 2), most)
        q, slope = panels_between(np.array(self.breaks)).nodes()
        own = float(np.sum(2 * pi * q * self(q) * slope @ WEIGHTS))
        top = breaks_of(self.spectrum)[-1]
        room = 2 * pi * top**2 * (1 - 1 / _REACH)  # the variance of a tail of unit level
        wanted = EDGE * float(self(np.array([top]))[0]) * room
        tail = min(max(wanted, whole - own), max(most - own, 0.0))
        object.__setattr__(self, "_edge", tail / room)
        object.__setattr__(self, "_scale", min(most / own, 1.0))
        object.__setattr__(self, "_whole", float(min(own, most) + tail) / hardness**2)

    @property
    def contact_fraction(self) -> float:
        """A/A₀, the share of the nominal area in contact."""
        return sum(_areas(self.nominal_pressure / self.penetration_hardness, self._whole))

    @property
    def plastic_fraction(self) -> float:
        """A_pl/A₀, the share of the nominal area that has yielded."""
        return _areas(self.nominal_pressure / self.penetration_hardness, self._whole)[1]

    def __call__(self, q: ArrayLike) -> Array:
        """Return |σ_q|² at the wavenumbers `q`, rad/m, elementwise, Pa² m²."""
        wavenumber = real_array("q", q, "rad/m")
        ends = breaks_of(self.spectrum)
        low, high = ends[0], ends[-1]
        result = np.zeros(wavenumber.shape)
        beside = (wavenumber >= self.breaks[0]) & (wavenumber <= np.exp(self._sidebands.t[-1]))
        result[beside] = _value(self._sidebands, wavenumber[beside])
        inside = (wavenumber >= low) & (wavenumber <= high)
        band = wavenumber[inside]
        full = (self.effective_modulus * band / 2) ** 2 * density(self.spectrum, band)
        result[inside] += full * _value(self._coherent, band)
        result *= self._scale
        above = (wavenumber > high) & (wavenumber <= self.breaks[-1])
        result[above] += self._edge * (high / wavenumber[above]) ** 3
        return result


@lru_cache(maxsize=64)  # of one contact both areas are asked for
def _areas(share: float, variance: float) -> tuple[float, float]:
    """Return A_el/A₀ and A_pl/A₀ of a pressure between absorbing walls; `variance`, over σ_P², rises by 2A_el dg."""
    g = np.concatenate([[0.0], np.geomspace(1e-4 * share**2, 10.0, 600)])
    elastic = between(min(share, 1 - share), g)
    rising = np.append(0.0, np.cumsum((elastic[1:] + elastic[:-1]) * np.diff(g)))
    _, left, plastic = area_fractions(np.interp(variance, rising, g), share, 1.0)
    return float(left), float(plastic)


def _value(spline: BSpline, q: Array) -> Array:
    return np.asarray(np.exp(spline(np.clip(np.log(q), spline.t[0], spline.t[-1]))))


class Table(NamedTuple):
    """A logarithm over ln q, and how much each entry counts in a fit."""

    place: Array  # ln q, rising
    value: Array
    weight: Array


class Scattering(NamedTuple):
    """Where the waves put their pressure."""

    coherent: Table  # |σ_q|²/[(E*q/2)² C]
    sidebands: Table  # |σ_Q|², Pa² m²


def scatter(diffusion: Diffusion, modulus: float, step: float = STEP) -> Scattering:
    """Return what the waves make at their own wavenumber and beside it; E* in Pa, shells of at most `step` in ln q."""
    logs = np.log(diffusion.wavenumber)
    edges = np.linspace(logs[0], logs[-1], max(ceil((logs[-1] - logs[0]) / step), _FEWEST) + 1)
    width, x = edges[1] - edges[0], (edges[1:] + edges[:-1]) / 2
    q = np.exp(x)
    total = diffusion.probability @ (diffusion.pressure - diffusion.pressure @ diffusion.probability[0]) ** 2
    grown = np.diff(np.interp(edges, logs, total))  # by which each shell raises the variance of the pressure
    whole = (modulus * diffusion.wavenumber / 2) ** 2
    steps = between_shells(whole, diffusion.variance)
    full = np.diff(np.interp(edges, logs, np.append(0.0, np.cumsum(steps))))  # the same in full contact
    variance = stiffness_variance(diffusion, x, edges)
    mean = np.interp(x, logs, np.einsum("ij,ij->i", diffusion.probability, diffusion.stiffness))
    square = np.interp(x, logs, np.einsum("ij,ij->i", diffusion.probability, diffusion.stiffness**2))
    shells = np.diff(variance, axis=1)  # V(q, k), k in the same shells
    row, column = np.tril_indices(q.size)  # each wave and those before it, k ≤ q: V(q, k) of others is 0
    this, before = q[row, None], q[column, None]
    other = np.sqrt(this**2 + before**2 + 2 * this * before * np.cos((np.arange(ANGLES) + 0.5) * pi / ANGLES))
    soft = np.maximum(mean / square - 2 / (modulus * q), 0.0)[row, None]
    response = (soft + 2 / (modulus * this)) / (soft + 2 / (modulus * other))  # g(Q)/g(q)
    pairs = shells[row, column]
    beside = np.maximum(shells.sum(axis=1), np.finfo(float).tiny)
    change = 2 * np.bincount(row, pairs * (response.mean(axis=1) - 1)) / mean**2
    own = mean**2 / (mean**2 + beside)  # before the response g, coherent part and sidebands add up to what has grown
    coherent = own * grown / full * np.where(change < 0.0, 1 / (1 + np.abs(change)), 1 + change)
    source = (1 - own) * grown / beside
    power = (source[row] * pairs)[:, None] * response**2 / ANGLES
    ends = np.concatenate([edges[:1], x, edges[-1:]])
    values = np.log(coherent)
    wide = np.concatenate([[1.5 * values[0] - 0.5 * values[1]], values, [1.5 * values[-1] - 0.5 * values[-2]]])
    return Scattering(
        Table(ends, wide, np.ones(ends.size)), _density(np.log(other).ravel(), power.ravel(), logs[0] - _BELOW, width)
    )


def stiffness_variance(diffusion: Diffusion, x: Array, edges: Array) -> Array:
    """Return the variance of κ at ln q = x that waves up to each of `edges` make, shape (x, edges), (Pa/m)².

    `edges` in ln q bound the shells, and each x is the middle of one. κ there is carried back as its mean at each
    coarser q, given the pressure there, by implicit steps of the first order: those of the second change T_flash by
    .25 % at most.
    """
    logs = np.log(diffusion.wavenumber)
    up, down = diffusion.rates
    place = np.minimum(np.searchsorted(logs, x, side="right") - 1, logs.size - 2)
    share = ((x - logs[place]) / (logs[place + 1] - logs[place]))[:, None]
    carried = np.asfortranarray(((1 - share) * diffusion.stiffness[place] + share * diffusion.stiffness[place + 1]).T)
    there = (1 - share) * diffusion.probability[place] + share * diffusion.probability[place + 1]
    carried_there = carried.copy()
    square_there = np.einsum("ij,ji->i", there, carried**2)
    grown = np.empty((x.size, logs.size))
    for i in range(logs.size - 1, -1, -1):
        since = int(np.searchsorted(place, i))  # the columns from here on have been reached
        grown[:, i] = diffusion.probability[i] @ carried**2
        if i and since < x.size:
            power = diffusion.growth[i - 1]
            matrix = (-(power * down)[1:], 1 + power * (up + down), -(power * up)[:-1])
            carried[:, since:] = dgtsv(*matrix, carried[:, since:])[3]
    result = np.array([np.interp(edges, logs, row) for row in grown])
    for m, row in enumerate(result):
        row[m + 1 :] = square_there[m]
    mean = np.einsum("ij,ji->i", there, carried_there)
    return np.maximum.accumulate(np.maximum(result - mean[:, None] ** 2, 0.0), axis=1)


def _density(logs: Array, power: Array, first: float, width: float) -> Table:
    """Return ln q on a uniform grid and ln of the density per area of wavenumbers of `power` at `logs`."""
    place = np.maximum((logs - first) / width, 0.0)
    low = place.astype(np.intp)
    count = int(low.max()) + 2
    share = place - low
    held = np.bincount(low, power * (1 - share), count) + np.bincount(low + 1, power * share, count)
    last = int(np.searchsorted(np.cumsum(held), (1 - _LAST) * held.sum())) + 1
    x: Array = first + width * np.arange(last, dtype=np.float64)
    area = 2 * pi * np.exp(2 * x) * width
    area[0] = pi * np.exp(2 * x[0])  # of the whole disc below
    values = np.maximum(held[:last], _NOTHING * held.max() + np.finfo(float).tiny) / area
    weight = np.sqrt(np.maximum(held[:last] / held.max(), _FAINT**2)) if held.any() else np.ones(last)
    return Table(x, np.log(values), weight)


def _smooth(table: Table, first: float) -> BSpline:
    """Return the spline of degree 5 nearest to a table, its knots whole e-folds from `first`."""
    x = table.place
    inner = np.arange(ceil(x[0] - first), ceil(x[-1] - first)) + first
    inner = inner[(inner > x[0] + 0.3) & (inner < x[-1] - 0.3)]
    knots = np.concatenate([np.full(_DEGREE + 1, x[0]), inner, np.full(_DEGREE + 1, x[-1])])
    return make_lsq_spline(x, table.value, knots, k=_DEGREE, w=table.weight)


def _distinct(breaks: Array) -> Array:
    rising = np.sort(breaks)
    return np.asarray(rising[np.append(True, np.diff(rising) > 1e-9 * rising[1:])])
