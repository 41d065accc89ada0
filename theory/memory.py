"""Memory of a rough contact that slides: its products with itself at earlier times, in the frame of either body.

The contact is a clipped Gaussian field, σ = F(z), with z = √(1 − f) z₁(x) + √f z₂(x − vt), `theory.clipped`. Heat that
entered a body the time τ ago came from the normal place r, of variance 2Dτ an axis. There the heights of that body have
the correlation ρ(r), and those of the other one ρ(|r + s|), with s = vτ along x. Means over r and τ of

    ⟨W_i W′_j⟩ − ⟨W_i⟩⟨W_j⟩,    W = (F, G − F, Gψ, Hψ, Gχ, Gζ),    G constant in the contact, and 0 outside,

have three parts. What depends on the heights of one body alone is one integral over r with the kernel of a source at
rest or in motion, in closed form. The rest vanishes where r or s is long, and its mean over the angle between both
depends neither on the speed nor on the bodies.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, sqrt

import numpy as np
from scipy.special import erf, erfc, erfcx, i0e, ive

from theory.arguments import Array, SpectrumLike, breaks_of, kept_for_values
from theory.clipped import PAIRS, ClippedField, Correlations, clipped_field, directed_correlations

_TURNS = np.array([1.0, 0.0, -1.0])  # cos φ, at which functions a₀ + a₁ cos φ + a₂ cos 2φ are found
_ORDERS = np.array(
    [[0.25, 0.5, 0.25], [0.5, 0.0, -0.5], [0.25, -0.5, 0.25]]
)  # a₀, a₁, a₂ from their values there
_PER_E_FOLD = 9  # distances, of the part that depends on both bodies
_NEAR = 0.03  # rad: θ at the least of them
_FINEST, _FAR = 0.7, 25.0  # over q_min: the widest interval of distances, and the last
_LEAST = 1e-5  # over the first of these distances: of those at which one body alone counts
_TOGETHER = 16  # distances of `ClippedField`, 0.2 % apart: their heat is taken as that of one
_LAST = 50.0  # over q_min: there waves of the correlation, which cancel, fade
_ANGLES = 20


@dataclass(frozen=True, slots=True, eq=False)
class SeenPairs:
    """⟨W_i W′_j⟩_c for the `PAIRS`, over ⟨F²⟩_c/g_σ(0), in the frame of one body; Pa².

    In `Memory` the first two are times dr, summed over `_TOGETHER` distances.

    Attributes
    ----------
    own : ndarray
        Of the heights of this body alone, mean over φ, shape (terms, radii).
    other : ndarray
        Terms in 1, cos φ and cos 2φ of the heights of the other body alone, shape (3, terms, radii).
    both : ndarray
        Addition by the heights of both bodies together, over r and the slid distance, mean over the angle between
        both, shape (terms, places, distances).

    The last term is ⟨F F′⟩_c with the g_σ of the law, whose long waves are weaker than those of any Gaussian heights:
    contacts avoid one another. The difference is divided as all the pressure is, that at r = 0. So it stays with each
    body in part, but never more of a wave than there is.
    """

    own: Array
    other: Array
    both: Array


@dataclass(frozen=True, slots=True, eq=False)
class Memory:
    """Memory of the contact in both bodies, by place and slid distance; it does not depend on their conductivities."""

    radius: Array  # m, in geometric sequence
    place: Array  # m: r, from 0
    distance: Array  # m: vτ, from 0
    resting: SeenPairs
    moving: SeenPairs

    def means(self, body: SeenPairs, speed: Array, ages: Array, diffusivity: float) -> Array:
        """Return (κσ₀/μv) M_ij of one body, Pa² m, shape (speeds, ages, terms)."""
        result = np.empty((*ages.shape, len(PAIRS)))
        for n, (v, times) in enumerate(zip(speed.tolist(), ages, strict=True)):
            reach = 2 * np.sqrt(diffusivity * times)[:, None]
            still = erfc(self.radius / reach)
            # a source in motion: e^(−z) I₀(z) with z = vr/2D in the steady state, and I_k(z) for cos kφ
            way = v * times[:, None]
            ahead, behind = (self.radius - way) / reach, (self.radius + way) / reach
            with np.errstate(under="ignore"):
                begun = erfc(ahead) + erfcx(behind) * np.exp(-(ahead**2))
            # SciPy's scaled I_k is NaN above 2e9; from 1e8 on all orders are I₀ to 1e-8
            z = v * self.radius / (2 * diffusivity)
            orders = [np.where(z < 1e8, ive(k, z), i0e(z)) for k in range(len(_ORDERS))]
            passing = np.einsum("kir,kr->ri", body.other, np.array(orders) / 2)
            terms = still @ body.own.T + begun @ passing + self._joint(body, v, times, diffusivity)
            # as much of all as of the pressure with the g_σ of the law
            result[n] = terms[:, :-1] * (terms[:, -1:] / terms[:, :1])
        return result

    def _joint(self, body: SeenPairs, speed: float, times: Array, diffusivity: float) -> Array:
        """Return the part of the summits of both bodies together, ∫ds √(D/πvs) of the mean over r of `both`."""
        spread = np.sqrt(
            4 * diffusivity * self.distance[1:] / speed
        )  # √2 times the standard deviation of r
        ratio = self.place[:, None] / spread
        # `both` is linear between places: ∫ of r/w² e^(−r²/2w²) over each interval, and its share of the upper end
        with np.errstate(under="ignore"):
            left = np.exp(-(ratio**2))
        beyond = sqrt(pi) / 2 * spread * erf(ratio)
        whole = left[:-1] - left[1:]
        width = np.diff(self.place)[:, None]
        later = (np.diff(beyond, axis=0) - width * left[1:]) / width
        weight = np.zeros(left.shape)
        weight[:-1] += whole - later
        weight[1:] += later
        mean = np.einsum("kij,ij->kj", body.both[:, :, 1:], weight)
        mean = np.concatenate([body.both[:, :1, 0], mean], axis=1)
        return np.asarray(
            sqrt(diffusivity / (pi * speed))
            * _root_weights(self.distance, speed * times[:, None])
            @ mean.T
        )


def _root_weights(s: Array, last: Array) -> Array:
    """Return weights of values at s for ∫ ds/√s from 0 to `last`, of what is linear between; (lasts, distances)."""
    low, high = s[:-1], s[1:]
    stop = np.clip(last, low, high)
    zeroth, first = 2 * (np.sqrt(stop) - np.sqrt(low)), 2 / 3 * (stop**1.5 - low**1.5)
    later = (first - low * zeroth) / (high - low)
    weights = np.zeros((last.size, s.size))
    weights[:, :-1] += zeroth - later
    weights[:, 1:] += later
    return weights


@kept_for_values  # .4 s, the same at all speeds and slid distances
def memory_of(
    spectrum: SpectrumLike,
    effective_modulus: float,
    nominal_pressure: float,
    penetration_hardness: float | None,
    f: float,
) -> Memory:
    """Return the memory of a contact; errors as `clipped_field`. `f` is the part of C(q) on the moving body."""
    field = clipped_field(
        spectrum,
        effective_modulus=effective_modulus,
        nominal_pressure=nominal_pressure,
        penetration_hardness=penetration_hardness,
    )
    longest = 1 / breaks_of(spectrum)[0]
    first = float(np.interp(_NEAR, field.angles(), field.distance))
    middle = _FINEST * _PER_E_FOLD * longest  # where even steps set in
    near = np.geomspace(first, middle, round(_PER_E_FOLD * np.log(middle / first)))
    place = np.concatenate([[0.0], near[:-1], np.arange(middle, _FAR * longest, _FINEST * longest)])
    nearer = first * np.geomspace(1e-5, 1.0, 40)[:-1]
    distance = np.concatenate([[0.0], nearer, place[1:]])
    count = np.flatnonzero(
        (field.distance > _LEAST * first) & (field.distance < 2 * _LAST * longest)
    )
    matters = count[: count.size // _TOGETHER * _TOGETHER]
    r = field.distance[matters]
    radius = np.exp(np.log(r).reshape(-1, _TOGETHER).mean(axis=1))
    weight = r * np.log(r[1] / r[0]) * np.exp(-((r / (_LAST * longest)) ** 4))  # dr, and waves fade
    furthest = _LAST * longest
    transforms = (
        field.possible_correlation(furthest),
        *field.riesz(furthest),
        *field.half_potential(furthest),
    )
    bodies = {}
    for part in {f, 1 - f}:
        seen = seen_pairs(field, transforms, part, place, nearer)
        own, other = (
            (weight * values[..., matters]).reshape(*values.shape[:-1], -1, _TOGETHER).sum(axis=-1)
            for values in (seen.own, seen.other)
        )
        bodies[part] = SeenPairs(own, other, seen.both)
    return Memory(radius, place, distance, resting=bodies[f], moving=bodies[1 - f])


def seen_pairs(
    field: ClippedField, transforms: tuple[Array, ...], part: float, place: Array, nearer: Array
) -> SeenPairs:
    """Products of the contact with itself earlier, in the frame of one body.

    Parameters
    ----------
    field : ClippedField
        The contact.
    transforms : tuple of ndarray
        ρ, N₁, N₂, K₀, K₁ and K₂ at its distances: `possible_correlation`, `riesz` and `half_potential` of the field.
    part : float
        Part of the roughness on the other body.
    place : ndarray
        r, m, ascending from 0.
    nearer : ndarray
        Slid distances between 0 and the first other place, m, ascending; the others are the places.

    Returns
    -------
    SeenPairs
        `own` and `other` at the distances of the field, `both` at the places.
    """
    known = np.stack(transforms)
    alike = float(transforms[3][0])
    log_first, step = np.log(field.distance[0]), np.log(field.distance[1] / field.distance[0])

    def at(values: Array, r: Array) -> Array:
        beyond = np.log(np.maximum(r, field.distance[0])) - log_first
        index = np.minimum(beyond / step, values.shape[-1] - 1.001)
        left = index.astype(np.intp)
        low = values[..., left]
        return np.asarray(low + (index - left) * (values[..., left + 1] - low))

    def means(own: Correlations, other: Correlations) -> Array:
        return field.products.shared(own, other, part, alike)

    nothing = Correlations(*(np.zeros((1, 1)),) * 6)
    alone = directed_correlations(known[:, :, None], _TURNS)
    own = means(alone, nothing) @ _ORDERS[0]
    other = np.moveaxis(means(nothing, alone) @ _ORDERS.T, -1, 0)
    points, weights = np.polynomial.legendre.leggauss(_ANGLES)
    cosine = np.cos(pi * (1 + points) / 2)
    here = directed_correlations(at(known, place)[:, :, None], cosine)
    mean_alone = at(own, place)
    both = np.empty((len(PAIRS), place.size, place.size))
    for n, s in enumerate(place):
        apart = np.sqrt(place[:, None] ** 2 + s**2 + 2 * s * place[:, None] * cosine)
        turned = np.clip(
            (s + place[:, None] * cosine) / np.maximum(apart, 1e-3 * nearer[0]), -1.0, 1.0
        )
        order = at(other, apart)
        passing = order[0] + order[1] * turned + order[2] * (2 * turned**2 - 1)
        joint = means(here, directed_correlations(at(known, apart), turned)) - passing
        both[..., n] = joint @ (weights / 2) - mean_alone
    start, second = both[..., :1], both[..., 1:2]
    between = start + (second - start) * (nearer / place[1])
    whole = np.concatenate([start, between, both[..., 1:]], axis=-1)
    # what any heights lack of the g_σ of the law, over g_σ(0), is divided as all is at r = 0
    lacking = field.pressure_correlation / field.variance - field.products.share(transforms[0])
    own = np.concatenate([own, own[:1] + lacking * own[:1, :1]])
    other = np.concatenate([other, other[:, :1] + lacking * other[:, :1, :1]], axis=1)
    added = at(lacking, place)[:, None] * whole[:1, :1]
    whole = np.concatenate([whole, whole[:1] + added])
    scale = field.variance / field.products.variance
    return SeenPairs(scale * own, scale * other, scale * whole)
