"""Means of products at two places of F(z), a stack of steps of a normal z, of the contact G(z) and of its rim H(z).

G is one step, at the lowest of F's or below. H = G(E − Ē) has E = 1/(z − u + .1), which is large near the edge z = u of
the contact, less its mean over the contact. Let z and z′ be normal with the correlation p = cos θ. A and B, each F, G
or H, are sums of steps; the pairs of steps add up to

    joint   ⟨A B′⟩ = ∬ dA(u) dB(w) P(z > u, z′ > w)
    edge    ⟨A_z B′⟩ = ∬ dA(u) dB(w) φ(u) Φ((pu − w)/sin θ)
    edges   sin θ ⟨A_z B′_z⟩ = ∬ dA(u) dB(w) exp(−(u² + w² − 2puw)/(2 sin²θ))/2π.

⟨A B′⟩ is found from ⟨A⟩⟨B⟩ at p = 0 and d⟨A B′⟩/dp = ⟨A_z B′_z⟩. All are smooth in θ.

Two bodies share the heat by place. That takes a normal ψ too, independent of z at the same place but not at another,
with k = ⟨ψψ′⟩ and m = ⟨zψ′⟩ = ⟨ψz′⟩. By Stein's rule ⟨x A⟩ = Σ_y ⟨x y⟩ ⟨∂A/∂y⟩,

    ⟨F B′ψ′⟩ = m⟨F_z B′⟩;    ⟨Aψ B′ψ′⟩ = k⟨A B′⟩ + m²⟨A_z B′_z⟩    with A and B either G or H.

A third normal, χ, has opposite signs at the front of a spot and at its rear. It is the Riesz transform of z along x,
each wave times −iq_x/q. With S the spectrum of ρ, r at the angle φ to x, and N_k = ∫ S(q) J_k(qr) d²q, its correlations
are ⟨zχ′⟩ = N₁ cos φ, which is odd, and ⟨χχ′⟩ = (ρ − N₂ cos 2φ)/2. With n = ⟨zχ′⟩, s = ⟨ψχ′⟩ and c = ⟨χχ′⟩

    ⟨F G′χ′⟩ = n⟨F_z G′⟩;    ⟨Aψ G′χ′⟩ = s⟨A G′⟩ + nm⟨A_z G′_z⟩;    ⟨Gχ G′χ′⟩ = c⟨G G′⟩ − n²⟨G_z G′_z⟩;

the first two change their sign when both places are exchanged.

A fourth, ζ, is large where contact is dense. It is the half-potential of z, each wave times q^(−1/2) and a constant:
half the way from z to its potential 1/q, the response to heat at rest. Unlike the others it depends on z at the same
place, a = ⟨zζ⟩. K₀, K₁, K₂ are the integrals of S q^(−1/2) J₀, S q^(−1/2) J₁ and S q^(−1) J₀, scaled so that ⟨ζ²⟩ = 1.
With l = ⟨zζ′⟩ = K₀, h = ⟨ψζ′⟩, t = ⟨ζχ′⟩ = K₁ cos φ, ⟨ζζ′⟩ = K₂, b = l − ap, and ⟨A G′_zz⟩ = u⟨A G′_z⟩ − p⟨A_z G′_z⟩,

    ⟨F G′ζ′⟩ = l⟨F_z G′⟩ + a⟨F G′_z⟩;    ⟨Aψ G′ζ′⟩ = h⟨A G′⟩ + m(b⟨A_z G′_z⟩ + au⟨A G′_z⟩);
    ⟨Gζ G′χ′⟩ = t⟨G G′⟩ + n(b⟨G_z G′_z⟩ + au⟨G_z G′⟩);
    ⟨Gζ G′ζ′⟩ = ⟨ζζ′⟩⟨G G′⟩ + 2alu⟨G_z G′⟩ + (b² + a² sin²θ)⟨G_z G′_z⟩.

ζ counts from its mean over the contact, ⟨Gζ⟩/⟨G⟩.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, pi, sqrt
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike

from theory.arguments import Array, real_array

# i, j of ⟨W_i W′_j⟩ for W = (F, G − F, Gψ, Hψ, Gχ, Gζ)
PAIRS = (
    *((0, 0), (0, 1), (0, 2), (0, 3), (0, 4), (0, 5)),
    *((1, 1), (1, 2), (1, 3), (1, 4), (1, 5)),
    *((2, 2), (2, 3), (2, 4), (2, 5), (3, 3), (3, 4), (3, 5)),
    *((4, 4), (5, 4), (5, 5)),
)
_ANGLES = 256  # intervals of θ
_RIM = 0.1  # of z, added to its height above the edge of the contact
_STEPS = 48  # of H
_FURTHEST = 6.0  # of z on both sides, of these steps


class Correlations(NamedTuple):
    """Correlations at two places of z, its Riesz transform χ and its half-potential ζ; arrays that broadcast."""

    height: Array  # ⟨zz′⟩
    odd: Array  # ⟨zχ′⟩ = −⟨χz′⟩
    even: Array  # ⟨χχ′⟩
    potential: Array  # ⟨zζ′⟩
    odd_potential: Array  # ⟨ζχ′⟩ = −⟨χζ′⟩
    potentials: Array  # ⟨ζζ′⟩


@dataclass(frozen=True, slots=True, eq=False)
class Products:
    """Means of products of F, G and H at two places, over the angle θ = arccos p; see the module.

    G has the height with which its mean is ⟨F⟩.

    Attributes
    ----------
    level : float
        u of the step G.
    table : ndarray
        ⟨F F′⟩; joint and edge of F and G; ⟨F G′_z⟩; joint, edge and edges of G; ⟨F_z H′⟩; joint, edge and edges of G
        and H; joint and edges of H; Pa², shape (13, angles), even ones from 0 to π.
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
        """Return ⟨W_i W′_j⟩ − ⟨W_i⟩⟨W_j⟩ of two bodies for the `PAIRS` of W = (F, G − F, Gψ, Hψ, Gχ, Gζ), Pa².

        z = √(1 − f) z₁ + √f z₂ and ψ = √f z₁ − √(1 − f) z₂, of which z₁ belongs to one body and z₂ to the other.
        χ and ζ are linear transforms of z; ζ counts from its mean over the contact. `own` and `other` are the
        correlations of z₁ and of z₂, `part` is f, and `alike` ⟨zζ⟩ at the same place.
        """
        p, n, c, level, turned, potentials = (
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
        pressures, joint_f, edge_f, other_edge_f, joint, edge, edges, *of_rim = values
        rim_edge_f, joint_rim, rim_edge, edges_rim, rims, rim_edges = of_rim
        u, sine = self.level, np.sqrt(1 - p**2)
        not_0 = np.maximum(sine, 1e-3)
        steep, rising = edges / not_0, edges_rim / not_0  # ⟨G_z G′_z⟩, ⟨H_z G′_z⟩
        apart = level - alike * p
        along = apart * steep + alike * u * edge  # ⟨ζG_z G′⟩
        along_rim = apart * rising + alike * u * rim_edge
        middle = self.joint.size // 2
        mean = alike * self.table[5, middle] / self.mean_square  # ⟨Gζ⟩/⟨G⟩
        uneven = (level + alike) * edge  # ⟨G G′ζ′⟩
        uneven_f = level * edge_f + alike * other_edge_f  # ⟨F G′ζ′⟩
        with_pressure = m * edge_f, m * rim_edge_f, n * edge_f, uneven_f - mean * joint_f
        with_contact = m * edge, m * rim_edge, n * edge, uneven - mean * joint
        return np.stack(
            np.broadcast_arrays(
                pressures - self.mean_square,
                joint_f - pressures,
                *with_pressure,
                joint - 2 * joint_f + pressures,
                *(x - y for x, y in zip(with_contact, with_pressure, strict=True)),
                k * joint + m**2 * steep,
                k * joint_rim + m**2 * rising,
                s * joint + n * m * steep,
                h * joint + m * (along - mean * edge),
                k * rims + m**2 * rim_edges / not_0,
                s * joint_rim + n * m * rising,
                h * joint_rim + m * (along_rim - mean * rim_edge),
                c * joint - n**2 * steep,
                turned * joint + n * (along - mean * edge),
                (potentials + mean**2) * joint
                + 2 * (alike * level * u * edge - mean * uneven)
                + apart**2 * steep
                + alike**2 * sine * edges,
            )
        )


def products(levels: ArrayLike, heights: ArrayLike, edge: float = inf) -> Products:
    """Return the means of products of F = Σ h 1(z > u), with the `levels` u of z and the `heights` h of its steps, Pa.

    `edge` is the level of G where it lies below all of F's. TypeError or ValueError if they are not real and finite.
    """
    u, h = real_array("levels", levels, "1"), real_array("heights", heights, "Pa")
    lowest = np.minimum(u.min(keepdims=True), edge)
    contact = lowest, h @ scipy.special.ndtr(-u) / scipy.special.ndtr(-lowest)
    pressure, rim = (u, h), _rim(*contact)
    pressures, *_ = _means(*pressure, *pressure)
    joint_f, edge_f, _ = _means(*pressure, *contact)
    _, other_edge_f, _ = _means(*contact, *pressure)
    _, rim_edge_f, _ = _means(*pressure, *rim)
    rims, _, rim_edges = _means(*rim, *rim)
    of_contact = _means(*contact, *contact)
    with_rim = _means(*contact, *rim)
    table = pressures, joint_f, edge_f, other_edge_f, *of_contact, rim_edge_f, *with_rim
    return Products(float(lowest[0]), np.stack([*table, rims, rim_edges]))


def _rim(edge: Array, height: Array) -> tuple[Array, Array]:
    """Return levels and heights of the steps of H, where G is one step of the `height`, Pa, at the `edge`."""
    origin = max(edge[0], -_FURTHEST) - _RIM
    bounds = np.geomspace(_RIM, max(_FURTHEST - origin, 1.0), _STEPS + 1)
    levels = np.append(edge, origin + np.sqrt(bounds[1:] * bounds[:-1]))
    steps = np.append(1 / _RIM, np.diff(1 / bounds))
    above = scipy.special.ndtr(-levels)
    steps[0] -= steps @ above / above[0]
    return levels, height * steps


def _means(u: Array, h: Array, w: Array, g: Array) -> tuple[Array, Array, Array]:
    """Return joint, edge and edges over θ of A = Σ h 1(z > u) and B = Σ g 1(z > w)."""
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
    return joint, edge.sum(axis=(1, 2)), edges
