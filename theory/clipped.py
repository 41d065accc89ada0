"""Rough contact as a clipped Gaussian field: σ(x) = F(z(x)), with z Gaussian of mean 0 and variance 1.

F is the pressure of the same rank as z: P(σ > F(z)) = P(z′ > z). Where all has yielded it is one step, from 0 to σ_P.
In general it is a stack of many small ones, F(z) = Σ_i h_i 1(z > u_i). The distribution of the pressure is that of a
diffusion between absorbing walls at 0 and σ_P, with the variance g_σ(0) of the calibrated law. The correlation ρ(r) of
z gives ⟨σ(0)σ(r)⟩ − σ₀² the shape of g_σ(r) of that law.

Source: one step is the clipped random wave of N.F. Berk, Phys. Rev. Lett. 58, 2718 (1987).

Let z and z′ be normal with the correlation p = cos θ, and δ Dirac's. The pairs of steps add up to

    joint      ⟨F F′⟩ = ∬ dF(u) dF(w) P(z > u, z′ > w)
    edge       ⟨F_z F′⟩ = ∬ dF(u) dF(w) φ(u) Φ((pu − w)/sin θ),    edge_level = ⟨z F_z F′⟩, the same with a factor u
    edges      sin θ ⟨F_z F′_z⟩ = ∬ dF(u) dF(w) exp(−(u² + w² − 2puw)/(2 sin²θ))/2π

and edges_level and edges_levels, the same as edges with (u + w)/2 and with uw. ⟨F F′⟩ is found from σ₀² at p = 0 and
d⟨F F′⟩/dp = ⟨F_z F′_z⟩. All are smooth in θ.

Two bodies share the heat by place. That takes a normal ψ too, independent of z at the same place but not at another,
with k = ⟨ψψ′⟩ and m = ⟨zψ′⟩ = ⟨ψz′⟩. By Stein's rule ⟨x G⟩ = Σ_y ⟨x y⟩ ⟨∂G/∂y⟩,

    ⟨F F′⟩;    ⟨F F′ψ′⟩ = m⟨F_z F′⟩;    ⟨F z′F′ψ′⟩ = m⟨F_z z′F′⟩;    ⟨Fψ F′ψ′⟩ = k⟨F F′⟩ + m²⟨F_z F′_z⟩;
    ⟨Fψ z′F′ψ′⟩ = k⟨F z′F′⟩ + m²⟨F_z (z′F′)_z⟩;    ⟨zFψ z′F′ψ′⟩ = k⟨zF z′F′⟩ + m²⟨(zF)_z (z′F′)_z⟩.

A third normal, χ, has opposite signs at the front of a spot and at its rear. It is the Riesz transform of z along x,
each wave times −iq_x/q. With S the spectrum of ρ, r at the angle φ to x, and N_k = ∫ S(q) J_k(qr) d²q, its correlations
are ⟨zχ′⟩ = N₁ cos φ, which is odd, and ⟨χχ′⟩ = (ρ − N₂ cos 2φ)/2. With n = ⟨zχ′⟩, s = ⟨ψχ′⟩ and c = ⟨χχ′⟩

    ⟨F F′χ′⟩ = n⟨F_z F′⟩;    ⟨Fψ F′χ′⟩ = s⟨F F′⟩ + nm⟨F_z F′_z⟩;    ⟨zFψ F′χ′⟩ = s⟨zF F′⟩ + nm⟨(zF)_z F′_z⟩;
    ⟨Fχ F′χ′⟩ = c⟨F F′⟩ − n²⟨F_z F′_z⟩;    the first three change their sign when both places are exchanged.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isinf, log, pi, sqrt

import numpy as np
import scipy
from numpy.polynomial.legendre import leggauss
from numpy.typing import ArrayLike
from scipy.fft import fht

from theory.arguments import Array, Spectrum, breaks_of, density, real_array
from theory.persson import calibrated_spectrum, half_variance
from theory.walls import MODES, SWITCH, area_fractions, half_variance_of
from theory.yielding import stress_spectrum

PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2), (0, 3), (1, 3), (2, 3), (3, 3))  # i, j of ⟨F w_i F′ w′_j⟩
_STEPS = 48  # of F
_FINE = 4000  # intervals of the pressure where F is inverted
_FAR = 7.0  # standard deviations of full contact above σ₀: no pressure of elastic contact is higher
_FURTHEST = 5.0  # standard deviations of z, of steps of F
_CERTAIN = -30.0  # of the step to a pressure that is everywhere
_ANGLES = 256  # intervals of θ
_RADII = 8192  # distances at which g_σ is found
_ROOM = 1e3  # wavenumbers beyond both ends of |σ_q|², for the transform, which is periodic in ln q
_BIAS = -0.6  # power of q that is taken out for the transform: errors, evenly over r, are then 1e-5 of g_σ(0)
_RIESZ_BIAS = 0.3, -0.5  # the same for its two transforms: errors of N₁/r are then below 1 % down to `_LINEAR`
_LINEAR = 1e-5  # of the furthest distance: below it N₁ is linear in r
_GAUSS = leggauss(3)


@dataclass(frozen=True, slots=True, eq=False)
class Products:
    """Means of products of F and its derivatives at two places, over the angle θ = arccos p; see the module.

    Attributes
    ----------
    table : ndarray
        joint, edge, edge_level, edges, edges_level, edges_levels, Pa², shape (6, angles): even ones from 0 to π.
    """

    table: Array

    @property
    def joint(self) -> Array:
        """⟨F F′⟩, Pa²."""
        return np.asarray(self.table[0])

    @property
    def mean_square(self) -> float:
        """⟨F⟩², Pa²: of places far apart, p = 0."""
        return float(self.joint[self.joint.size // 2])

    @property
    def variance(self) -> float:
        """⟨F²⟩ − ⟨F⟩², Pa²."""
        return float(self.joint[0]) - self.mean_square

    def shared(
        self, correlations: tuple[Array, Array], part: float, odd: tuple[Array, Array], even: tuple[Array, Array]
    ) -> Array:
        """Return ⟨F w_i F′ w′_j⟩ − ⟨F w_i⟩⟨F w_j⟩ of two bodies for the `PAIRS` of w = (1, ψ, zψ, χ), Pa².

        z = √(1 − f) z₁ + √f z₂ and ψ = √f z₁ − √(1 − f) z₂, of which z₁ belongs to one body and z₂ to the other.
        χ is a linear transform of z, which is independent of z and ψ at the same place.

        `correlations` are ⟨z₁z₁′⟩ and ⟨z₂z₂′⟩, arrays that broadcast, and `part` is f; `odd` has ⟨zχ′⟩ = −⟨χz′⟩ and
        `even` ⟨χχ′⟩ of z₁ and of z₂.
        """
        own, other = correlations
        p = np.clip((1 - part) * own + part * other, -1.0, 1.0)
        k = part * own + (1 - part) * other  # ⟨ψψ′⟩
        mixed = sqrt(part * (1 - part))
        m = mixed * (own - other)  # ⟨zψ′⟩
        n = (1 - part) * odd[0] + part * odd[1]  # ⟨zχ′⟩
        s = mixed * (odd[0] - odd[1])  # ⟨ψχ′⟩
        c = (1 - part) * even[0] + part * even[1]  # ⟨χχ′⟩
        index = np.arccos(p) * (_ANGLES / pi)
        left = np.minimum(index.astype(np.intp), _ANGLES - 1)
        lower = self.table[:, left]
        values = lower + (index - left) * (self.table[:, left + 1] - lower)
        joint, edge, edge_level, edges, edges_level, edges_levels = values
        sine = np.sqrt(1 - p**2)
        steep = 1 / np.maximum(sine, 1e-3)
        sharp = m**2 * steep
        other_end = p * edge_level + sine * edges  # ⟨F_z z′F′⟩
        return np.stack(
            np.broadcast_arrays(
                joint - self.mean_square,
                m * edge,
                m * other_end,
                k * joint + sharp * edges,
                k * (1 + p) * edge + m**2 * edge + sharp * edges_level,
                k * (other_end + p * (joint + edge_level)) + m**2 * (joint + 2 * edge_level) + sharp * edges_levels,
                n * edge,
                s * joint + n * m * steep * edges,
                s * (1 + p) * edge + n * m * (edge + steep * edges_level),
                c * joint - n**2 * steep * edges,
            )
        )


def products(levels: ArrayLike, heights: ArrayLike) -> Products:
    """Return the means of products of F = Σ h 1(z > u), with the `levels` u of z and the `heights` h of its steps, Pa.

    TypeError or ValueError if they are not real and finite.
    """
    u, h = real_array("levels", levels, "1"), real_array("heights", heights, "Pa")
    angle = np.linspace(0.0, pi, _ANGLES + 1)
    inner = np.clip(angle, 1e-6, pi - 1e-6)[:, None, None]
    weight = h[:, None] * h
    # the exponent is (u − w)²/4(1 − p) + (u + w)²/4(1 + p): nothing cancels where p is near 1
    apart, together = (u[:, None] - u) ** 2 / 8, (u[:, None] + u) ** 2 / 8
    with np.errstate(under="ignore"):
        pair = weight * np.exp(-apart / np.sin(inner / 2) ** 2 - together / np.cos(inner / 2) ** 2) / (2 * pi)
        above = scipy.special.ndtr((u[:, None] - u) / np.sin(inner) - u[:, None] * np.tan(inner / 2))
        normal = np.exp(-(u**2) / 2)[:, None] / sqrt(2 * pi)
    edge = weight * normal * above
    edges = pair.sum(axis=(1, 2))
    edges[0] = 2 * edges[1] - edges[2]  # at θ = 0 itself pairs of unlike levels, however near, add nothing
    rising = np.append(0.0, np.cumsum((edges[1:] + edges[:-1]) / 2) * (pi / _ANGLES))
    joint = float(h @ scipy.special.ndtr(-u)) ** 2 + rising[_ANGLES // 2] - rising
    others = (edge, edge * u[:, None]), (pair * u, pair * u[:, None] * u)
    first, second = ([values.sum(axis=(1, 2)) for values in pairs] for pairs in others)
    return Products(np.stack([joint, *first, edges, *second]))


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

    def angles(self) -> Array:
        """Return θ(r) = arccos ρ at each `distance`; π where contacts avoid one another more than any ρ allows."""
        of_angle = self.products
        share = (of_angle.joint - of_angle.mean_square) / of_angle.variance
        return np.interp(-self.pressure_correlation / self.variance, -share, np.linspace(0.0, pi, share.size))

    def riesz(self, furthest: float) -> tuple[Array, Array]:
        """Return N₁ and N₂ of the Riesz transform of z at each `distance`; ρ fades beyond `furthest`, m."""
        r = self.distance
        rho = np.cos(self.angles()) * np.exp(-((r / furthest) ** 4))
        step = log(r[1] / r[0])
        first, back = _RIESZ_BIAS
        spectrum = fht(rho * r, step, 0.0, bias=first)  # q times the transform of ρ
        slope = fht(spectrum, step, 1.0, bias=back) / r**2  # N₁/r
        near = int(np.searchsorted(r, _LINEAR * furthest))
        slope[:near] = slope[near]
        # J₂(x) = 2 J₁(x)/x − J₀(x), so that N₂ + ρ is the mean of ρ over the disk of radius r
        disk = 2 * step * (np.cumsum(rho * r**2) - rho * r**2 / 2) + r[0] ** 2
        return slope * r, disk / r**2 - rho

    def correlation(self, r: ArrayLike) -> Array:
        """Return ρ at the distances `r`, m, elementwise; 1 below the least of `distance` and 0 beyond the last.

        TypeError or ValueError if `r` is not real and finite.
        """
        radius = real_array("r", r, "m")
        with np.errstate(divide="ignore"):
            place = np.log(radius)
        return np.interp(place, np.log(self.distance), np.cos(self.angles()), left=1.0, right=0.0)


def directed_correlations(correlations: Array, cosine: Array) -> tuple[Array, Array, Array]:
    """Correlations of z, and of its Riesz transform χ along x, at a distance in the direction φ to x.

    Parameters
    ----------
    correlations : ndarray
        ρ, N₁ and N₂ at the distance, dimensionless, along the first axis.
    cosine : ndarray
        cos φ, of a shape that broadcasts with each of them.

    Returns
    -------
    tuple of ndarray
        ⟨zz′⟩, ⟨zχ′⟩ = N₁ cos φ and ⟨χχ′⟩ = (ρ − N₂ cos 2φ)/2, in the common shape, but the first in the shape of ρ.
    """
    rho, first, second = correlations
    return rho, first * cosine, (rho - second * (2 * cosine**2 - 1)) / 2


def clipped_field(
    spectrum: Spectrum, *, effective_modulus: float, nominal_pressure: float, penetration_hardness: float | None = None
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
    if penetration_hardness is None:
        stress = calibrated_spectrum(spectrum, **solid)
    else:
        stress = stress_spectrum(spectrum, **solid, penetration_hardness=penetration_hardness)
    distance, correlation, variance = _correlation(stress)
    most = stress.penetration_hardness
    if isinf(most):
        full = float(half_variance(breaks_of(spectrum)[-1], spectrum, effective_modulus=effective_modulus))
        most = float(nominal_pressure) + _FAR * sqrt(2 * full)
    levels, heights = _steps(nominal_pressure / most, variance / most**2)
    return ClippedField(levels, most * heights, distance, correlation, variance, products(levels, most * heights))


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
    return (np.append(_CERTAIN, levels), np.append(low, heights)) if low > 0.0 else (levels, heights)


def _levels_of(t: Array, share: float, g: float) -> Array:
    """Return the z at which the pressure passes t σ_P."""
    above = np.clip(_share_above(t, share, g), 0.0, 1.0)
    return np.asarray(np.clip(-scipy.special.ndtri(above), -_FURTHEST, _FURTHEST))


def _share_above(t: Array, share: float, g: float) -> Array:
    """Return the share of the area under a pressure above t σ_P, after diffusion between the walls from `share` σ_P."""
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


def _correlation(stress: Spectrum) -> tuple[Array, Array, float]:
    """Return distances r in geometric sequence, g_σ there, and g_σ(0), by a fast transform in ln q and ln r."""
    breaks = breaks_of(stress)
    edges = np.linspace(log(breaks[0] / _ROOM), log(breaks[-1] * _ROOM), _RADII + 1)
    # the mean of q²|σ_q|² over each interval of ln q: its kinks and jumps need not lie between intervals
    cuts = np.unique(np.concatenate([edges[(edges > log(breaks[0])) & (edges < log(breaks[-1]))], np.log(breaks)]))
    points, weights = _GAUSS
    half = np.diff(cuts)[:, None] / 2
    q = np.exp(cuts[:-1, None] + half * (1 + points))
    rising = np.append(0.0, np.cumsum(2 * pi * q**2 * density(stress, q) * half @ weights))
    width = edges[1] - edges[0]
    middle = np.exp((edges[1:] + edges[:-1]) / 2)
    mean = np.diff(np.interp(edges, cuts, rising)) / width
    transformed = fht(mean / middle, width, 0.0, bias=_BIAS)  # r g_σ, where r is 1/q in reverse order
    return 1 / middle[::-1], transformed * middle[::-1], float(rising[-1])
