"""The pressure of rough contact as a function of a Gaussian field, made from the calibrated law."""

from __future__ import annotations

from dataclasses import dataclass
from math import isinf, log, pi, sqrt

import numpy as np
import scipy
from numpy.polynomial.legendre import leggauss
from numpy.typing import ArrayLike

from theory.arguments import Array, SpectrumLike, breaks_of, density, real_array
from theory.clipped.products import Correlations, Products, products
from theory.persson import calibrated_spectrum, half_variance
from theory.walls import MODES, SWITCH, area_fractions, half_variance_of
from theory.yielding import YieldingSpectrum, stress_spectrum

_STEPS = 48  # of F
_FINE = 4000  # intervals of the pressure where F is inverted
_FAR = 7.0  # standard deviations of full contact above σ₀: no pressure of elastic contact is higher
_FURTHEST = 5.0  # standard deviations of z, of steps of F
_CERTAIN = -30.0  # of the step to a pressure that is everywhere
_RADII = 8192  # distances at which g_σ is found
_ROOM = 1e3  # wavenumbers beyond both ends of |σ_q|², for the transform, which is periodic in ln q
_BIAS = (
    -0.6
)  # power of q that is taken out for the transform: errors, evenly over r, are then 1e-5 of g_σ(0)
_RIESZ_BIAS = (
    0.3,
    -0.5,
)  # the same for its two transforms: errors of N₁/r are then below 1 % down to `_LINEAR`
_HALF_BIAS = 0.0, -0.6  # the same for K: errors below 5e-4
_LINEAR = (
    1e-5  # of the furthest distance: below it N₁ and K₁ are linear in r, and K₀ and K₂ constant
)
_GAUSS = leggauss(3)


@dataclass(frozen=True, slots=True, eq=False)
class ClippedField:
    """A rough contact as σ = F(z); made by `clipped_field`.

    Attributes
    ----------
    levels, heights : ndarray
        F(z) = Σ heights 1(z > levels): the levels of z ascend; the heights add up to the highest pressure, Pa.
    distance : ndarray
        r in geometric sequence, m.
    pressure_correlation : ndarray
        g_σ(r) of the law at these distances, Pa².
    variance : float
        g_σ(0) of the law, Pa².
    products : Products
        Of the steps.
    """

    levels: Array
    heights: Array
    distance: Array
    pressure_correlation: Array
    variance: float
    products: Products

    def pressure(self, z: ArrayLike) -> Array:
        """Return F at the values z, elementwise, Pa; TypeError or ValueError if they are not real and finite."""
        value = real_array("z", z, "1")
        rising = np.append(0.0, np.cumsum(self.heights))
        return np.asarray(rising[np.searchsorted(self.levels, value)])

    def ascending(self, count: int) -> Array:
        """Return the pressures of `count` equal shares of the area, Pa, ascending."""
        return self.pressure(scipy.special.ndtri((np.arange(count) + 0.5) / count))

    def angles(self) -> Array:
        """Return θ(r) = arccos ρ at each `distance`; π where contacts avoid one another more than any ρ allows."""
        of_angle = self.products
        share = (of_angle.joint - of_angle.mean_square) / of_angle.variance
        return np.interp(
            -self.pressure_correlation / self.variance, -share, np.linspace(0.0, pi, share.size)
        )

    def possible_correlation(self, furthest: float) -> Array:
        """Return the correlation of z at each `distance` without negative power; ρ fades beyond `furthest`, m."""
        first, back = _HALF_BIAS
        _, lacking, total = self._waves(furthest, first)
        added = self._transform(lacking, 0, back, furthest)
        return np.asarray((self._faded(furthest) + added) / (1 + total))

    def _transform(self, waves: Array, order: int, bias: float, furthest: float) -> Array:
        """Return ∫ waves J(qr) dq of an order at each `distance`, below `_LINEAR` as its power of r."""
        r = self.distance
        scaled = scipy.fft.fht(waves, log(r[1] / r[0]), order, bias=bias) / r ** (1 + order)
        near = int(np.searchsorted(r, _LINEAR * furthest))
        scaled[:near] = scaled[near]
        return np.asarray(scaled * r**order)

    def _faded(self, furthest: float) -> Array:
        return np.asarray(np.cos(self.angles()) * np.exp(-((self.distance / furthest) ** 4)))

    def _waves(self, furthest: float, bias: float) -> tuple[Array, Array, float]:
        """Return q times the transform of the possible correlation at q = 1/r in reverse order, and what ρ lacks of it.

        Contacts avoid one another at long distances more than those of any Gaussian field. Waves longer than the
        strongest one whose power would be negative are left out. The last number is the power that they lack.
        """
        r = self.distance
        step = log(r[1] / r[0])
        spectrum = scipy.fft.fht(self._faded(furthest) * r, step, 0.0, bias=bias)
        q = 1 / r[::-1]
        longer = np.arange(r.size) < np.argmax(spectrum)
        lacking = np.where(longer, np.maximum(-spectrum, 0.0), 0.0)
        total = float(step * q @ lacking)
        return (spectrum + lacking) / (1 + total), lacking, total

    def riesz(self, furthest: float) -> tuple[Array, Array]:
        """Return N₁ and N₂ of the Riesz transform of z at each `distance`; ρ fades beyond `furthest`, m."""
        r = self.distance
        rho = self.possible_correlation(furthest)
        first, back = _RIESZ_BIAS
        odd = self._transform(self._waves(furthest, first)[0], 1, back, furthest)
        # J₂(x) = 2 J₁(x)/x − J₀(x), so that N₂ + ρ is the mean of ρ over the disk of radius r
        disk = 2 * log(r[1] / r[0]) * (np.cumsum(rho * r**2) - rho * r**2 / 2) + r[0] ** 2
        return odd, disk / r**2 - rho

    def half_potential(self, furthest: float) -> tuple[Array, Array, Array]:
        """Return K₀, K₁ and K₂ of the half-potential of z at each `distance`; ρ fades beyond `furthest`, m."""
        first, back = _HALF_BIAS
        root = np.sqrt(self.distance[::-1])  # q^(−1/2)
        spectrum = self._waves(furthest, first)[0] * root  # √q times the transform of ρ
        height, turned, own = (
            self._transform(waves, order, back, furthest)
            for waves, order in ((spectrum, 0), (spectrum, 1), (spectrum * root, 0))
        )
        unit = sqrt(own[0])  # the variance is 1
        return height / unit, turned / unit, own / unit**2

    def correlation(self, r: ArrayLike) -> Array:
        """Return ρ at the distances `r`, m, elementwise; 1 below the least of `distance` and 0 beyond the last.

        TypeError or ValueError if `r` is not real and finite.
        """
        return self._at(r, np.cos(self.angles()))

    def shape(self, r: ArrayLike) -> Array:
        """Return g_σ(r)/g_σ(0) of the law at the distances `r`, m, elementwise; ends and errors as `correlation`."""
        return self._at(r, self.pressure_correlation / self.variance)

    def _at(self, r: ArrayLike, correlation: Array) -> Array:
        with np.errstate(divide="ignore"):
            place = np.log(real_array("r", r, "m"))
        return np.interp(place, np.log(self.distance), correlation, left=1.0, right=0.0)


def directed_correlations(correlations: Array, cosine: Array) -> Correlations:
    """Correlations of z, of its Riesz transform χ along x and its half-potential ζ, at a distance in the direction φ.

    Parameters
    ----------
    correlations : ndarray
        ρ, N₁, N₂, K₀, K₁ and K₂ at the distance, dimensionless, along the first axis.
    cosine : ndarray
        cos φ with φ the angle to x, of a shape that broadcasts with each of them.

    Returns
    -------
    Correlations
        In the common shape, but those that do not depend on φ in the shape of ρ.
    """
    rho, first, second, height, turned, own = correlations
    even = (rho - second * (2 * cosine**2 - 1)) / 2
    return Correlations(rho, first * cosine, even, height, turned * cosine, own)


def clipped_field(
    spectrum: SpectrumLike,
    *,
    effective_modulus: float,
    nominal_pressure: float,
    penetration_hardness: float | None = None,
) -> ClippedField:
    """Contact of rough surfaces as a clipped Gaussian field.

    Parameters
    ----------
    spectrum : callable
        C(q), m⁴, with `breaks`.
    effective_modulus, nominal_pressure, penetration_hardness : float
        E*, σ₀ and σ_P, Pa, σ₀ ≤ σ_P; without σ_P contact is elastic.

    Raises
    ------
    TypeError, ValueError
        As `plasticity.stress_spectrum` and `persson.calibrated_spectrum`.
    """
    solid = {"effective_modulus": effective_modulus, "nominal_pressure": nominal_pressure}
    stress = law_of(spectrum, **solid, penetration_hardness=penetration_hardness)
    distance, correlation, variance = _correlation(stress)
    most = stress.penetration_hardness
    if isinf(most):
        full = float(
            half_variance(breaks_of(spectrum)[-1], spectrum, effective_modulus=effective_modulus)
        )
        most = float(nominal_pressure) + _FAR * sqrt(2 * full)
    levels, heights = _steps(nominal_pressure / most, variance / most**2)
    edge = float(-scipy.special.ndtri(stress.contact_fraction))
    of_steps = products(levels, most * heights, max(edge, _CERTAIN))
    return ClippedField(levels, most * heights, distance, correlation, variance, of_steps)


def law_of(
    spectrum: SpectrumLike,
    *,
    effective_modulus: float,
    nominal_pressure: float,
    penetration_hardness: float | None,
) -> YieldingSpectrum:
    """Return the calibrated law of the stress spectrum; parameters and errors as `clipped_field`."""
    solid = {"effective_modulus": effective_modulus, "nominal_pressure": nominal_pressure}
    if penetration_hardness is None:
        return calibrated_spectrum(spectrum, **solid)
    return stress_spectrum(spectrum, **solid, penetration_hardness=penetration_hardness)


def _steps(share: float, variance: float) -> tuple[Array, Array]:
    """Return levels and heights of the steps of F, over the highest pressure, of this mean and variance."""
    g = half_variance_of(share, variance)
    reach = 2 * _FURTHEST * sqrt(g)
    fine = np.linspace(max(share - reach, 0.0), min(share + reach, 1.0), _FINE + 1)
    # steps where the pressure is neither certain nor out of reach; what is certain is one step
    low, high = np.interp([-_FURTHEST + 1e-9, _FURTHEST - 1e-9], _levels_of(fine, share, g), fine)
    points, weights = leggauss(_STEPS)
    levels = _levels_of(low + (high - low) * (1 + points) / 2, share, g)
    heights = (high - low) * weights / 2
    return (
        (np.append(_CERTAIN, levels), np.append(low, heights)) if low > 0.0 else (levels, heights)
    )


def _levels_of(t: Array, share: float, g: float) -> Array:
    """Return the z at which the pressure passes t σ_P."""
    above = np.clip(_share_above(t, share, g), 0.0, 1.0)
    return np.asarray(np.clip(-scipy.special.ndtri(above), -_FURTHEST, _FURTHEST))


def _share_above(t: Array, share: float, g: float) -> Array:
    """Return the fraction of the area under a pressure above t σ_P, diffused between the walls from `share` σ_P."""
    yielded = float(area_fractions(np.asarray(g), share, 1.0)[2])
    if g < SWITCH:
        width = 2 * sqrt(g)
        elastic = np.zeros(t.shape)
        for s in (share + 2 * k for k in range(-3, 4)):
            elastic += (scipy.special.erf((1 - s) / width) - scipy.special.erf((t - s) / width)) / 2
            elastic -= (scipy.special.erf((1 + s) / width) - scipy.special.erf((t + s) / width)) / 2
    else:
        order = pi * np.arange(1, 2 * MODES)
        fading = 2 * np.sin(order * share) * np.exp(-(order**2) * g) / order
        elastic = np.asarray((np.cos(order * t[:, None]) - np.cos(order)) @ fading)
    return np.asarray(yielded + elastic)


def _correlation(stress: SpectrumLike) -> tuple[Array, Array, float]:
    """Return distances r in geometric sequence, g_σ there, and g_σ(0), by a fast transform in ln q and ln r."""
    breaks = breaks_of(stress)
    edges = np.linspace(log(breaks[0] / _ROOM), log(breaks[-1] * _ROOM), _RADII + 1)
    # the mean of q²|σ_q|² over each interval of ln q: its kinks and jumps need not lie between intervals
    cuts = np.unique(
        np.concatenate(
            [edges[(edges > log(breaks[0])) & (edges < log(breaks[-1]))], np.log(breaks)]
        )
    )
    points, weights = _GAUSS
    half = np.diff(cuts)[:, None] / 2
    q = np.exp(cuts[:-1, None] + half * (1 + points))
    rising = np.append(0.0, np.cumsum(2 * pi * q**2 * density(stress, q) * half @ weights))
    width = edges[1] - edges[0]
    middle = np.exp((edges[1:] + edges[:-1]) / 2)
    mean = np.diff(np.interp(edges, cuts, rising)) / width
    transformed = scipy.fft.fht(
        mean / middle, width, 0.0, bias=_BIAS
    )  # r g_σ, where r is 1/q in reverse order
    return 1 / middle[::-1], transformed * middle[::-1], float(rising[-1])
