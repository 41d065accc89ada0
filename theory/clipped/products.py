"""Means of products of F(z), a stack of steps of a normal z, and of the contact G(z), where F > 0, at two places.

G is one step at the lowest of F's. Let z and z′ be normal with the correlation p = cos θ, and δ Dirac's. A and B, each
F or G, are sums of steps; the pairs of steps add up to

    joint   ⟨A B′⟩ = ∬ dA(u) dB(w) P(z > u, z′ > w)
    edge    ⟨A_z B′⟩ = ∬ dA(u) dB(w) φ(u) Φ((pu − w)/sin θ),    edge_level = ⟨z A_z B′⟩, the same with a factor u
    edges   sin θ ⟨A_z B′_z⟩ = ∬ dA(u) dB(w) exp(−(u² + w² − 2puw)/(2 sin²θ))/2π.

⟨A B′⟩ is found from ⟨A⟩⟨B⟩ at p = 0 and d⟨A B′⟩/dp = ⟨A_z B′_z⟩. All are smooth in θ. With A = G, z A_z is u A_z.

Two bodies share the heat by place. That takes a normal ψ too, independent of z at the same place but not at another,
with k = ⟨ψψ′⟩ and m = ⟨zψ′⟩ = ⟨ψz′⟩. By Stein's rule ⟨x A⟩ = Σ_y ⟨x y⟩ ⟨∂A/∂y⟩,

    ⟨F G′ψ′⟩ = m⟨F_z G′⟩;    ⟨F z′G′ψ′⟩ = m⟨F_z z′G′⟩ = m(p⟨zF_z G′⟩ + sin²θ⟨F_z G′_z⟩);
    ⟨Gψ G′ψ′⟩ = k⟨G G′⟩ + m²⟨G_z G′_z⟩;    ⟨Gψ z′G′ψ′⟩ = k⟨G z′G′⟩ + m²⟨G_z (z′G′)_z⟩;
    ⟨zGψ z′G′ψ′⟩ = k⟨zG z′G′⟩ + m²⟨(zG)_z (z′G′)_z⟩.

A third normal, χ, has opposite signs at the front of a spot and at its rear. It is the Riesz transform of z along x,
each wave times −iq_x/q. With S the spectrum of ρ, r at the angle φ to x, and N_k = ∫ S(q) J_k(qr) d²q, its correlations
are ⟨zχ′⟩ = N₁ cos φ, which is odd, and ⟨χχ′⟩ = (ρ − N₂ cos 2φ)/2. With n = ⟨zχ′⟩, s = ⟨ψχ′⟩ and c = ⟨χχ′⟩

    ⟨F G′χ′⟩ = n⟨F_z G′⟩;    ⟨Gψ G′χ′⟩ = s⟨G G′⟩ + nm⟨G_z G′_z⟩;    ⟨zGψ G′χ′⟩ = s⟨zG G′⟩ + nm⟨(zG)_z G′_z⟩;
    ⟨Gχ G′χ′⟩ = c⟨G G′⟩ − n²⟨G_z G′_z⟩;    the first three change their sign when both places are exchanged.

A fourth, ζ, is large where contact is dense. It is the half-potential of z, each wave times q^(−1/2) and a constant:
half the way from z to its potential 1/q, the response to heat at rest. Unlike the others it depends on z at the same
place, a = ⟨zζ⟩. K₀, K₁, K₂ are the integrals of S q^(−1/2) J₀, S q^(−1/2) J₁ and S q^(−1) J₀, scaled so that ⟨ζ²⟩ = 1.
With l = ⟨zζ′⟩ = K₀, h = ⟨ψζ′⟩, t = ⟨ζχ′⟩ = K₁ cos φ, ⟨ζζ′⟩ = K₂, b = l − ap, and ⟨G_zz G′⟩ = ⟨zG_z G′⟩ − p⟨G_z G′_z⟩,

    ⟨F G′ζ′⟩ = l⟨F_z G′⟩ + a⟨F G′_z⟩;    ⟨Gψ G′ζ′⟩ = h⟨G G′⟩ + m(b⟨G_z G′_z⟩ + a⟨zG_z G′⟩);
    ⟨zGψ G′ζ′⟩ = h⟨zG G′⟩ + m(b⟨(zG)_z G′_z⟩ + a⟨zG z′G′_z⟩);
    ⟨Gζ G′χ′⟩ = t⟨G G′⟩ + n(b⟨G_z G′_z⟩ + a⟨zG_z G′⟩);
    ⟨Gζ G′ζ′⟩ = ⟨ζζ′⟩⟨G G′⟩ + 2al⟨zG_z G′⟩ + (b² + a² sin²θ)⟨G_z G′_z⟩.

ζ counts from its mean over the contact, ⟨Gζ⟩/⟨G⟩.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, sqrt
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike

from theory.arguments import Array, real_array

# i, j of ⟨W_i W′_j⟩ for W = (F, G − F, Gψ, zGψ, Gχ, Gζ)
PAIRS = (
    *((0, 0), (0, 1), (0, 2), (0, 3), (0, 4), (0, 5)),
    *((1, 1), (1, 2), (1, 3), (1, 4), (1, 5)),
    *((2, 2), (2, 3), (2, 4), (2, 5), (3, 3), (3, 4), (3, 5)),
    *((4, 4), (5, 4), (5, 5)),
)
_ANGLES = 256  # intervals of θ


class Correlations(NamedTuple):
    """Correlations at two places of z, its Riesz transform χ and its half-potential ζ; arrays that broadcast."""

    height: Array  # ⟨zz′⟩
    odd: Array  # ⟨zχ′⟩ = −⟨χz′⟩
    even: Array  # ⟨χχ′⟩
    potential: Array  # ⟨zζ′⟩
    odd_potential: Array  # ⟨ζχ′⟩ = −⟨χζ′⟩
    potentials: Array  # ⟨ζζ′⟩
    of_pressure: Array  # ⟨zz′⟩ with which ⟨F F′⟩ is that of the contact


@dataclass(frozen=True, slots=True, eq=False)
class Products:
    """Means of products of F and G at two places, over the angle θ = arccos p; see the module.

    G has the height with which its mean is ⟨F⟩.

    Attributes
    ----------
    level : float
        u of the step G.
    table : ndarray
        ⟨F F′⟩; joint, edge, edge_level and edges of F and G; ⟨F G′_z⟩; joint, edge and edges of G; Pa², shape
        (9, angles), even ones from 0 to π.
    """

    level: float
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

    def share(self, correlation: Array) -> Array:
        """Return (⟨F F′⟩ − ⟨F⟩²)/(⟨F²⟩ − ⟨F⟩²) where z has the `correlation` p, elementwise; dimensionless."""
        share = (self.joint - self.mean_square) / self.variance
        angle = np.arccos(np.clip(correlation, -1.0, 1.0))
        return np.interp(angle, np.linspace(0.0, pi, share.size), share)

    def shared(self, own: Correlations, other: Correlations, part: float, alike: float) -> Array:
        """Return ⟨W_i W′_j⟩ − ⟨W_i⟩⟨W_j⟩ of two bodies for the `PAIRS` of W = (F, G − F, Gψ, zGψ, Gχ, Gζ), Pa².

        At last comes ⟨F F′⟩ − ⟨F⟩² of the contact itself.

        z = √(1 − f) z₁ + √f z₂ and ψ = √f z₁ − √(1 − f) z₂, of which z₁ belongs to one body and z₂ to the other.
        χ and ζ are linear transforms of z; ζ counts from its mean over the contact. `own` and `other` are the
        correlations of z₁ and of z₂, `part` is f, and `alike` ⟨zζ⟩ at the same place.
        """
        p, n, c, level, turned, potentials, of_pressure = (
            (1 - part) * x + part * y for x, y in zip(own, other, strict=True)
        )
        p = np.clip(p, -1.0, 1.0)
        k = part * own.height + (1 - part) * other.height  # ⟨ψψ′⟩
        mixed = sqrt(part * (1 - part))
        m = mixed * (own.height - other.height)  # ⟨zψ′⟩
        s = mixed * (own.odd - other.odd)  # ⟨ψχ′⟩
        h = mixed * (own.potential - other.potential)  # ⟨ψζ′⟩
        index = np.arccos(p) * (_ANGLES / pi)
        left = np.minimum(index.astype(np.intp), _ANGLES - 1)
        lower = self.table[:, left]
        values = lower + (index - left) * (self.table[:, left + 1] - lower)
        pressures, joint_f, edge_f, edge_level_f, edges_f, other_edge_f, joint, edge, edges = values
        u, sine = self.level, np.sqrt(1 - p**2)
        steep = edges / np.maximum(sine, 1e-3)  # ⟨G_z G′_z⟩
        rising = edge + u * steep  # ⟨(zG)_z G′_z⟩
        other_end = p * u * edge + sine * edges  # ⟨G_z z′G′⟩
        other_end_f = p * edge_level_f + sine * edges_f  # ⟨F_z z′G′⟩
        apart = level - alike * p
        along = apart * steep + alike * u * edge  # ⟨ζG_z G′⟩
        along_level = apart * rising + alike * u * other_end
        middle = self.joint.size // 2
        mean = alike * self.table[7, middle] / self.mean_square  # ⟨Gζ⟩/⟨G⟩
        uneven = (level + alike) * edge  # ⟨G G′ζ′⟩
        uneven_f = level * edge_f + alike * other_edge_f  # ⟨F G′ζ′⟩
        with_pressure = m * edge_f, m * other_end_f, n * edge_f, uneven_f - mean * joint_f
        with_contact = m * edge, m * other_end, n * edge, uneven - mean * joint
        return np.stack(
            np.broadcast_arrays(
                pressures - self.mean_square,
                joint_f - pressures,
                *with_pressure,
                joint - 2 * joint_f + pressures,
                *(x - y for x, y in zip(with_contact, with_pressure, strict=True)),
                k * joint + m**2 * steep,
                k * (1 + p) * edge + m**2 * rising,
                s * joint + n * m * steep,
                h * joint + m * (along - mean * edge),
                k * (other_end + p * (joint + u * edge))
                + m**2 * (joint + 2 * u * edge + u**2 * steep),
                s * (1 + p) * edge + n * m * rising,
                h * (1 + p) * edge + m * (along_level - mean * other_end),
                c * joint - n**2 * steep,
                turned * joint + n * (along - mean * edge),
                (potentials + mean**2) * joint
                + 2 * (alike * level * u * edge - mean * uneven)
                + apart**2 * steep
                + alike**2 * sine * edges,
                self.variance * self.share(of_pressure),
            )
        )


def products(levels: ArrayLike, heights: ArrayLike) -> Products:
    """Return the means of products of F = Σ h 1(z > u), with the `levels` u of z and the `heights` h of its steps, Pa.

    TypeError or ValueError if they are not real and finite.
    """
    u, h = real_array("levels", levels, "1"), real_array("heights", heights, "Pa")
    lowest = u.min(keepdims=True)
    height = h @ scipy.special.ndtr(-u) / scipy.special.ndtr(-lowest)
    pressures, *_ = _means(u, h, u, h)
    both = _means(u, h, lowest, height)
    _, other_edge, *_ = _means(lowest, height, u, h)
    joint, edge, _, edges = _means(lowest, height, lowest, height)
    return Products(float(lowest[0]), np.stack([pressures, *both, other_edge, joint, edge, edges]))


def _means(u: Array, h: Array, w: Array, g: Array) -> tuple[Array, Array, Array, Array]:
    """Return joint, edge, edge_level and edges over θ of A = Σ h 1(z > u) and B = Σ g 1(z > w)."""
    angle = np.linspace(0.0, pi, _ANGLES + 1)
    inner = np.clip(angle, 1e-6, pi - 1e-6)[:, None, None]
    weight = h[:, None] * g
    # the exponent is (u − w)²/4(1 − p) + (u + w)²/4(1 + p): nothing cancels where p is near 1
    apart, together = (u[:, None] - w) ** 2 / 8, (u[:, None] + w) ** 2 / 8
    with np.errstate(under="ignore"):
        pair = (
            weight
            * np.exp(-apart / np.sin(inner / 2) ** 2 - together / np.cos(inner / 2) ** 2)
            / (2 * pi)
        )
        above = scipy.special.ndtr(
            (u[:, None] - w) / np.sin(inner) - u[:, None] * np.tan(inner / 2)
        )
        normal = np.exp(-(u**2) / 2)[:, None] / sqrt(2 * pi)
    edge = weight * normal * above
    edges = pair.sum(axis=(1, 2))
    edges[0] = (
        2 * edges[1] - edges[2]
    )  # at θ = 0 itself pairs of unlike levels, however near, add nothing
    rising = np.append(0.0, np.cumsum((edges[1:] + edges[:-1]) / 2) * (pi / _ANGLES))
    alone = float(h @ scipy.special.ndtr(-u)) * float(g @ scipy.special.ndtr(-w))
    joint = alone + rising[_ANGLES // 2] - rising
    return joint, edge.sum(axis=(1, 2)), (edge * u[:, None]).sum(axis=(1, 2)), edges
