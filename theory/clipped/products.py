"""Means of products of F(z), a stack of steps of a normal z, at two places.

Let z and z′ be normal with the correlation p = cos θ, and δ Dirac's. The pairs of steps add up to

    joint      ⟨F F′⟩ = ∬ dF(u) dF(w) P(z > u, z′ > w)
    edge       ⟨F_z F′⟩ = ∬ dF(u) dF(w) φ(u) Φ((pu − w)/sin θ),    edge_level = ⟨z F_z F′⟩, the same with a factor u
    edges      sin θ ⟨F_z F′_z⟩ = ∬ dF(u) dF(w) exp(−(u² + w² − 2puw)/(2 sin²θ))/2π

edge_levels with u², and edges_level and edges_levels, the same as edges with (u + w)/2 and with uw. ⟨F F′⟩ is found
from σ₀² at p = 0 and d⟨F F′⟩/dp = ⟨F_z F′_z⟩. All are smooth in θ.

Two bodies share the heat by place. That takes a normal ψ too, independent of z at the same place but not at another,
with k = ⟨ψψ′⟩ and m = ⟨zψ′⟩ = ⟨ψz′⟩. By Stein's rule ⟨x G⟩ = Σ_y ⟨x y⟩ ⟨∂G/∂y⟩,

    ⟨F F′⟩;    ⟨F F′ψ′⟩ = m⟨F_z F′⟩;    ⟨F z′F′ψ′⟩ = m⟨F_z z′F′⟩;    ⟨Fψ F′ψ′⟩ = k⟨F F′⟩ + m²⟨F_z F′_z⟩;
    ⟨Fψ z′F′ψ′⟩ = k⟨F z′F′⟩ + m²⟨F_z (z′F′)_z⟩;    ⟨zFψ z′F′ψ′⟩ = k⟨zF z′F′⟩ + m²⟨(zF)_z (z′F′)_z⟩.

A third normal, χ, has opposite signs at the front of a spot and at its rear. It is the Riesz transform of z along x,
each wave times −iq_x/q. With S the spectrum of ρ, r at the angle φ to x, and N_k = ∫ S(q) J_k(qr) d²q, its correlations
are ⟨zχ′⟩ = N₁ cos φ, which is odd, and ⟨χχ′⟩ = (ρ − N₂ cos 2φ)/2. With n = ⟨zχ′⟩, s = ⟨ψχ′⟩ and c = ⟨χχ′⟩

    ⟨F F′χ′⟩ = n⟨F_z F′⟩;    ⟨Fψ F′χ′⟩ = s⟨F F′⟩ + nm⟨F_z F′_z⟩;    ⟨zFψ F′χ′⟩ = s⟨zF F′⟩ + nm⟨(zF)_z F′_z⟩;
    ⟨Fχ F′χ′⟩ = c⟨F F′⟩ − n²⟨F_z F′_z⟩;    the first three change their sign when both places are exchanged.

A fourth, ζ, is large where contact is dense. It is the half-potential of z, each wave times q^(−1/2) and a constant:
half the way from z to its potential 1/q, the response to heat at rest. Unlike the others it depends on z at the same
place, a = ⟨zζ⟩. K₀, K₁, K₂ are the integrals of S q^(−1/2) J₀, S q^(−1/2) J₁ and S q^(−1) J₀, scaled so that ⟨ζ²⟩ = 1.
With l = ⟨zζ′⟩ = K₀, h = ⟨ψζ′⟩, t = ⟨ζχ′⟩ = K₁ cos φ, ⟨ζζ′⟩ = K₂, b = l − ap, and ⟨F_zz F′⟩ = ⟨zF_z F′⟩ − p⟨F_z F′_z⟩,

    ⟨F F′ζ′⟩ = (l + a)⟨F_z F′⟩;    ⟨Fψ F′ζ′⟩ = h⟨F F′⟩ + m(b⟨F_z F′_z⟩ + a⟨zF_z F′⟩);
    ⟨zFψ F′ζ′⟩ = h⟨zF F′⟩ + m(b⟨(zF)_z F′_z⟩ + a⟨zF z′F′_z⟩);
    ⟨Fζ F′χ′⟩ = t⟨F F′⟩ + n(b⟨F_z F′_z⟩ + a⟨zF_z F′⟩);
    ⟨Fζ F′ζ′⟩ = ⟨ζζ′⟩⟨F F′⟩ + 2al⟨zF_z F′⟩ + (b² + a² sin²θ)⟨F_z F′_z⟩.

The fifth share function is ζ less its mean over the heat, ⟨Fζ⟩/⟨F⟩.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, sqrt
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike

from theory.arguments import Array, real_array

# i, j of ⟨F w_i F′ w′_j⟩
PAIRS = (
    *((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)),
    *((0, 3), (1, 3), (2, 3), (3, 3)),
    *((0, 4), (1, 4), (2, 4), (4, 3), (4, 4)),
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


@dataclass(frozen=True, slots=True, eq=False)
class Products:
    """Means of products of F and its derivatives at two places, over the angle θ = arccos p; see the module.

    Attributes
    ----------
    table : ndarray
        joint, edge, edge_level, edge_levels, edges, edges_level, edges_levels, Pa², shape (7, angles): even ones from 0
        to π.
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

    def share(self, correlation: Array) -> Array:
        """Return (⟨F F′⟩ − ⟨F⟩²)/(⟨F²⟩ − ⟨F⟩²) where z has the `correlation` p, elementwise; dimensionless."""
        share = (self.joint - self.mean_square) / self.variance
        angle = np.arccos(np.clip(correlation, -1.0, 1.0))
        return np.interp(angle, np.linspace(0.0, pi, share.size), share)

    def shared(self, own: Correlations, other: Correlations, part: float, alike: float) -> Array:
        """Return ⟨F w_i F′ w′_j⟩ − ⟨F w_i⟩⟨F w_j⟩ of two bodies for the `PAIRS` of w = (1, ψ, zψ, χ, ζ), Pa².

        z = √(1 − f) z₁ + √f z₂ and ψ = √f z₁ − √(1 − f) z₂, of which z₁ belongs to one body and z₂ to the other.
        χ and ζ are linear transforms of z; ζ counts from its mean over the heat. `own` and `other` are the correlations
        of z₁ and of z₂, `part` is f, and `alike` ⟨zζ⟩ at the same place.
        """
        p, n, c, level, turned, potentials = ((1 - part) * x + part * y for x, y in zip(own, other, strict=True))
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
        joint, edge, edge_level, edge_levels, edges, edges_level, edges_levels = values
        sine = np.sqrt(1 - p**2)
        steep = 1 / np.maximum(sine, 1e-3)
        sharp = m**2 * steep
        other_end = p * edge_level + sine * edges  # ⟨F_z z′F′⟩
        apart = level - alike * p
        sloped = edge + steep * edges_level  # ⟨(zF)_z F′_z⟩
        along = apart * steep * edges + alike * edge_level  # ⟨ζF_z F′⟩
        along_level = apart * sloped + alike * (p * edge_levels + sine * edges_level)
        square = (apart**2 * steep + alike**2 * sine) * edges
        middle = self.joint.size // 2
        mean = alike * self.table[1, middle] / self.mean_square  # ⟨Fζ⟩/⟨F⟩
        uneven = (level + alike) * edge  # ⟨F F′ζ′⟩
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
                s * (1 + p) * edge + n * m * sloped,
                c * joint - n**2 * steep * edges,
                uneven - mean * joint,
                h * joint + m * along - mean * m * edge,
                h * (1 + p) * edge + m * along_level - mean * m * other_end,
                turned * joint + n * along - mean * n * edge,
                potentials * joint + 2 * alike * level * edge_level + square - 2 * mean * uneven + mean**2 * joint,
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
    others = (edge, edge * u[:, None], edge * u[:, None] ** 2), (pair * u, pair * u[:, None] * u)
    first, second = ([values.sum(axis=(1, 2)) for values in pairs] for pairs in others)
    return Products(np.stack([joint, *first, edges, *second]))
