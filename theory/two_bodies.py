"""Flash temperature of two rough bodies that slide over one another, from C(q), without a simulation.

The contact is a clipped Gaussian field, σ = F(z), `theory.clipped`. A part f of C(q) rides with the moving body, so

    z(x, t) = √(1 − f) z₁(x) + √f z₂(x − vt)

in the frame of the body 1 at rest. ψ = √f z₁ − √(1 − f) z₂ is independent of z at the same place: it is large where the
summits are those of the resting body, which have been hot there for long. χ is the Riesz transform of z along the
direction of sliding: it has opposite signs at the front of a spot, where one body is still cold, and at its rear, where
the other is. The heat μvσ is shared by place and time,

    into body 1: μvσ (α + βψ + γzψ + δχ),    into body 2, the moving one: the rest.

Galerkin's equations, that T₁ − T₂ vanishes in the mean over σ, σψ, σzψ and σχ, give the four numbers at each time. With
w = (1, ψ, zψ, χ) the means of T at the time t, when the heat μvσw_j has entered since the start, are, over σ₀,

    M_ij(t) = (μv/κσ₀) (g_σ(0)/⟨F²⟩_c) ∫₀ᵗ dτ √(D/πτ) ⟨F w_i F′ w′_j⟩_c,

the mean over the normal places r of variance 2Dτ an axis at which the heat of the time τ ago entered, without ⟨F⟩².
There z₁ has the correlation ρ(r) and z₂ ρ(|r + vτ|) in body 1, and exchanged, with −v, in body 2. `theory.clipped` has
the means. M₀₃, M₁₃ and M₂₃ are odd, M_ji = −M_ij. Heat that entered from t₁ to t₂ adds M(t − t₁) − M(t − t₂). So the
equations at ages in geometric sequence, with constant shares between, are solved one after the other.

What depends on ρ₁ alone, or on ρ₂ alone, is one integral over r with the kernel of a source at rest or in motion, in
closed form. The rest vanishes where r or vτ is long. Its mean over the angle between r and vτ depends neither on the
speed nor on the bodies.

Source: docs/sliding.md, which compares it with simulations.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import pi, sqrt
from typing import Any, NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike

from theory.arguments import Array, Spectrum, breaks_of, float_if_scalar, positive, real_array
from theory.clipped import PAIRS, ClippedField, clipped_field, directed_correlations
from theory.persson import is_value

_MIRRORED = np.array([1.0, -1.0, -1.0, 1.0, 1.0, 1.0, -1.0, 1.0, 1.0, 1.0])  # bodies exchanged: ψ and χ change sign
_MIRROR = np.array([1.0, 1.0, 1.0, -1.0])  # places exchanged
_SHARES = 4
_AGES = np.append(0.0, np.geomspace(1e-3, 1.0, 32))  # of the time slid: shares are constant between
_TURNS = np.array([1.0, 0.0, -1.0])  # cos φ, at which functions a₀ + a₁ cos φ + a₂ cos 2φ are found
_ORDERS = np.array([[0.25, 0.5, 0.25], [0.5, 0.0, -0.5], [0.25, -0.5, 0.25]])  # a₀, a₁, a₂ from their values there
_PER_E_FOLD = 9  # distances, of the part that depends on both bodies
_NEAR = 0.03  # rad: θ at the least of them
_FINEST, _FAR = 0.7, 25.0  # over q_min: the widest interval of distances, and the last
_LEAST = 1e-5  # over the first of these distances: of those at which one body alone counts
_TOGETHER = 16  # distances of `ClippedField`, 0.2 % apart: their heat is taken as that of one
_LAST = 50.0  # over q_min: there waves of the correlation, which cancel, fade
_ANGLES = 20


class SlidingTemperatures(NamedTuple):
    """Temperatures of two rough bodies at the end of the slid distance; arrays over the speed, or floats.

    Attributes
    ----------
    flash_temperature, resting_flash_temperature : ndarray
        ⟨Tσ⟩/⟨σ⟩ of the moving and the resting body above the background of each, K.
    moving_share : ndarray
        Share of the heat at the end of the slid distance that enters the moving body.
    background, resting_background : ndarray
        Mean temperature of the surface of each, K above the start.
    contact_temperature : ndarray
        ⟨Tσ⟩/⟨σ⟩, background included, K: of both bodies.
    """

    flash_temperature: Array | float
    resting_flash_temperature: Array | float
    moving_share: Array | float
    background: Array | float
    resting_background: Array | float
    contact_temperature: Array | float


def sliding_temperatures(  # noqa: PLR0913  (two bodies)
    speed: ArrayLike,
    spectrum: Spectrum,
    *,
    effective_modulus: float,
    nominal_pressure: float,
    penetration_hardness: float | None = None,
    friction_coefficient: float,
    conductivity: float,
    diffusivity: float,
    resting_conductivity: float | None = None,
    resting_diffusivity: float | None = None,
    moving_roughness: float = 0.5,
    slid_distance: ArrayLike,
) -> SlidingTemperatures:
    """Flash temperatures, backgrounds and share of heat of two rough bodies that slide over one another.

    Parameters
    ----------
    speed : array_like
        v, m/s, of either sign and any shape, not 0.
    spectrum : callable
        C(q) of both faces together, m⁴, with `breaks`.
    effective_modulus, nominal_pressure, penetration_hardness : float
        E*, σ₀ and σ_P, Pa; without σ_P contact is elastic.
    friction_coefficient : float
        μ, dimensionless, > 0.
    conductivity, diffusivity : float
        κ, W/(m K), and D, m²/s, of the moving body.
    resting_conductivity, resting_diffusivity : float, optional
        The same of the resting body; None: as the moving one.
    moving_roughness : float
        f, the part of C(q) that rides with the moving body, from 0 to 1.
    slid_distance : array_like
        m since both bodies were cold, > 0; one number, or one for each speed.

    Returns
    -------
    SlidingTemperatures
        Arrays in the common shape of `speed` and `slid_distance`; floats for one of each.

    Raises
    ------
    TypeError, ValueError
        If an argument is not real, finite and of the right sign, or the contact lies outside the range of the law of
        its stress spectrum, as `plasticity.stress_spectrum` and `persson.calibrated_spectrum` explain.
    """
    velocity, distance = np.broadcast_arrays(
        np.abs(real_array("speed", speed, "m/s")), real_array("slid_distance", slid_distance, "m")
    )
    for name, values, unit in (("speed", velocity, "m/s"), ("slid_distance", distance, "m")):
        if not (values > 0.0).all():
            raise ValueError(f"{name} = {values.min():.6g} {unit} must be positive: heat is kept over the way slid")
    part = float(real_array("moving_roughness", moving_roughness, "1"))
    if not 0.0 <= part <= 1.0:
        raise ValueError(f"moving_roughness = {part:.6g} must lie from 0 to 1")
    heating = positive("friction_coefficient", friction_coefficient, "1") * velocity.ravel()
    moving = positive("conductivity", conductivity, "W/(m K)"), positive("diffusivity", diffusivity, "m²/s")
    resting_kappa, resting_diffusion = moving
    if resting_conductivity is not None:
        resting_kappa = positive("resting_conductivity", resting_conductivity, "W/(m K)")
    if resting_diffusivity is not None:
        resting_diffusion = positive("resting_diffusivity", resting_diffusivity, "m²/s")
    pressure = positive("nominal_pressure", nominal_pressure, "Pa")
    remembered: Any = _memory if is_value(spectrum) else _memory.__wrapped__
    memory = remembered(spectrum, effective_modulus, pressure, penetration_hardness, part)
    time = (distance / velocity).ravel()

    def heated(body: _Body, kappa: float, diffusion: float, sign: Array) -> tuple[Array, Array]:
        """Return M_ij and the background of one body with all the heat at each age, K; (speeds, ages, …)."""
        ages = time[:, None] * _AGES
        terms = sign * memory.means(body, velocity.ravel(), ages[:, 1:], diffusion)
        terms *= (heating / (kappa * pressure))[:, None, None]
        flash = np.zeros((*ages.shape, _SHARES, _SHARES))
        for column, (i, j) in enumerate(PAIRS):
            flash[:, 1:, j, i] = _MIRROR[i] * _MIRROR[j] * terms[..., column]
            flash[:, 1:, i, j] = terms[..., column]
        return flash, 2 * pressure * (heating / kappa)[:, None] * np.sqrt(diffusion * ages / pi)

    hot, hot_background = heated(memory.moving, *moving, _MIRRORED)
    cold, cold_background = heated(memory.resting, resting_kappa, resting_diffusion, np.ones(len(PAIRS)))
    return _shared(hot, cold, hot_background, cold_background, velocity.shape)


@dataclass(frozen=True, slots=True, eq=False)
class _Body:
    """⟨F w_i F′ w′_j⟩_c for the `PAIRS`, over ⟨F²⟩_c/g_σ(0), as one body sees the summits of both."""

    own: Array  # (terms, radii): of its own summits alone, times dr
    other: Array  # (orders, terms, radii): the terms in cos kφ of those of the other body alone, times dr
    both: Array  # (terms, places, distances): what both add to that, over r and the slid distance


@dataclass(frozen=True, slots=True, eq=False)
class _Memory:
    """Memory of the contact in both bodies, by place and slid distance; it does not depend on their conductivities."""

    radius: Array  # m, in geometric sequence
    place: Array  # m: r, from 0
    distance: Array  # m: vτ, from 0
    resting: _Body
    moving: _Body

    def means(self, body: _Body, speed: Array, ages: Array, diffusivity: float) -> Array:
        """Return (κσ₀/μv) M_ij of one body, Pa² m, shape (speeds, ages, terms)."""
        result = np.empty((*ages.shape, len(PAIRS)))
        for n, (v, times) in enumerate(zip(speed.tolist(), ages, strict=True)):
            reach = 2 * np.sqrt(diffusivity * times)[:, None]
            still = scipy.special.erfc(self.radius / reach)
            # a source in motion: e^(−z) I₀(z) with z = vr/2D in the steady state, and I_k(z) for cos kφ
            way = v * times[:, None]
            ahead, behind = (self.radius - way) / reach, (self.radius + way) / reach
            with np.errstate(under="ignore"):
                begun = scipy.special.erfc(ahead) + scipy.special.erfcx(behind) * np.exp(-(ahead**2))
            # SciPy's scaled I_k is NaN above 2e9; from 1e8 on all orders are I₀ to 1e-8
            z = v * self.radius / (2 * diffusivity)
            orders = [np.where(z < 1e8, scipy.special.ive(k, z), scipy.special.i0e(z)) for k in range(len(_ORDERS))]
            passing = np.einsum("kir,kr->ri", body.other, np.array(orders) / 2)
            result[n] = still @ body.own.T + begun @ passing + self._joint(body, v, times, diffusivity)
        return result

    def _joint(self, body: _Body, speed: float, times: Array, diffusivity: float) -> Array:
        """Return the part of the summits of both bodies together, ∫ds √(D/πvs) of the mean over r of `both`."""
        spread = np.sqrt(4 * diffusivity * self.distance[1:] / speed)  # √2 times the standard deviation of r
        ratio = self.place[:, None] / spread
        # `both` is linear between places: ∫ of r/w² e^(−r²/2w²) over each interval, and its share of the upper end
        with np.errstate(under="ignore"):
            left = np.exp(-(ratio**2))
        beyond = sqrt(pi) / 2 * spread * scipy.special.erf(ratio)
        whole = left[:-1] - left[1:]
        width = np.diff(self.place)[:, None]
        later = (np.diff(beyond, axis=0) - width * left[1:]) / width
        weight = np.zeros(left.shape)
        weight[:-1] += whole - later
        weight[1:] += later
        mean = np.einsum("kij,ij->kj", body.both[:, :, 1:], weight)
        mean = np.concatenate([body.both[:, :1, 0], mean], axis=1)
        return np.asarray(
            sqrt(diffusivity / (pi * speed)) * _root_weights(self.distance, speed * times[:, None]) @ mean.T
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


def _shared(hot: Array, cold: Array, hot_background: Array, cold_background: Array, shape: Any) -> SlidingTemperatures:
    """Share the heat by Galerkin's equations at each age; `hot` and `cold` are M_ij of both bodies, K."""
    moving = hot.copy()
    moving[..., 0, 0] += hot_background
    system = moving + cold
    system[..., 0, 0] += cold_background
    last = _AGES.size - 1
    into_resting = np.zeros((len(hot), last, _SHARES))
    for n in range(1, last + 1):
        heated = _pulses(system, n)
        known = moving[:, n, :, 0] - np.einsum("snij,snj->si", heated[:, :-1], into_resting[:, : n - 1])
        into_resting[:, n - 1] = np.linalg.solve(heated[:, -1], known[..., None])[..., 0]
    resting_flash = np.einsum("snj,snj->s", _pulses(cold, last)[:, :, 0], into_resting)
    flash = hot[:, -1, 0, 0] - np.einsum("snj,snj->s", _pulses(hot, last)[:, :, 0], into_resting)
    share = 1 - into_resting[..., 0]
    background = (_pulses(hot_background, last) * share).sum(axis=1)
    resting_background = (_pulses(cold_background, last) * (1 - share)).sum(axis=1)
    numbers = flash, resting_flash, share[:, -1], background, resting_background, flash + background
    return SlidingTemperatures(*(float_if_scalar(values.reshape(shape)) for values in numbers))


def _pulses(values: Array, n: int) -> Array:
    """Return what the heat between two ages adds at the age n, for `values` of all the heat since the start."""
    ages = _AGES[1:]
    passed = _AGES[n] - _AGES[: n + 1]
    with np.errstate(divide="ignore"):
        index = np.log(passed / ages[0]) / np.log(ages[1] / ages[0])
    left = np.clip(index, 0, ages.size - 2).astype(np.intp)
    tail = (1,) * (values.ndim - 2)
    between, root = (x.reshape(-1, *tail) for x in (np.clip(index - left, 0.0, 1.0), np.sqrt(passed)))
    # over √age they change slowly with ln age, and are constant at first
    scaled = values[:, 1:] / np.sqrt(ages).reshape(-1, *tail)
    seen = root * (scaled[:, left] + between * (scaled[:, left + 1] - scaled[:, left]))
    return np.asarray(seen[:, :-1] - seen[:, 1:])


@lru_cache(maxsize=64)  # .4 s, the same at all speeds and slid distances
def _memory(
    spectrum: Spectrum, effective_modulus: float, nominal_pressure: float, penetration_hardness: float | None, f: float
) -> _Memory:
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
    count = np.flatnonzero((field.distance > _LEAST * first) & (field.distance < 2 * _LAST * longest))
    matters = count[: count.size // _TOGETHER * _TOGETHER]
    r = field.distance[matters]
    radius = np.exp(np.log(r).reshape(-1, _TOGETHER).mean(axis=1))
    weight = r * np.log(r[1] / r[0]) * np.exp(-((r / (_LAST * longest)) ** 4))  # dr, and waves fade
    riesz = field.riesz(_LAST * longest)
    bodies = {}
    for part in {f, 1 - f}:
        own, other, both = _seen(field, riesz, part, place, nearer)
        own, other = (
            (weight * values[..., matters]).reshape(*values.shape[:-1], -1, _TOGETHER).sum(axis=-1)
            for values in (own, other)
        )
        bodies[part] = _Body(own, other, both)
    return _Memory(radius, place, distance, resting=bodies[f], moving=bodies[1 - f])


def _seen(
    field: ClippedField, riesz: tuple[Array, Array], part: float, place: Array, nearer: Array
) -> tuple[Array, Array, Array]:
    """Return the arrays of `_Body` over all distances; `part` of the roughness is that of the other body."""
    known = np.stack([np.cos(field.angles()), *riesz])
    log_first, step = np.log(field.distance[0]), np.log(field.distance[1] / field.distance[0])

    def at(values: Array, r: Array) -> Array:
        with np.errstate(divide="ignore"):
            index = np.clip((np.log(r) - log_first) / step, 0.0, values.shape[-1] - 1.001)
        left = index.astype(np.intp)
        return np.asarray(values[..., left] + (index - left) * (values[..., left + 1] - values[..., left]))

    def means(own: tuple[Array, Array, Array], other: tuple[Array, Array, Array]) -> Array:
        rho, odd, even = zip(own, other, strict=True)
        return field.products.shared(rho, part, odd, even)

    nothing = (np.zeros((1, 1)),) * 3
    alone = directed_correlations(known[:, :, None], _TURNS)
    own = means(alone, nothing) @ _ORDERS[0]
    other = np.moveaxis(means(nothing, alone) @ _ORDERS.T, -1, 0)
    points, weights = np.polynomial.legendre.leggauss(_ANGLES)
    cosine = np.cos(pi * (1 + points) / 2)
    here, mean_alone = directed_correlations(at(known, place)[:, :, None], cosine), at(own, place)
    both = np.empty((len(PAIRS), place.size, place.size))
    for n, s in enumerate(place):
        apart = np.sqrt(place[:, None] ** 2 + s**2 + 2 * s * place[:, None] * cosine)
        turned = np.clip((s + place[:, None] * cosine) / np.maximum(apart, 1e-3 * nearer[0]), -1.0, 1.0)
        order = at(other, apart)
        passing = order[0] + order[1] * turned + order[2] * (2 * turned**2 - 1)
        joint = means(here, directed_correlations(at(known, apart), turned)) - passing
        both[..., n] = joint @ (weights / 2) - mean_alone
    start, second = both[..., :1], both[..., 1:2]
    between = start + (second - start) * (nearer / place[1])
    whole = np.concatenate([start, between, both[..., 1:]], axis=-1)
    scale = field.variance / field.products.variance
    return scale * own, scale * other, scale * whole
