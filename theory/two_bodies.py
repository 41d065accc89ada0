"""Flash temperature of two rough bodies that slide over one another, from C(q), without a simulation.

The contact is a clipped Gaussian field, σ = F(z), `theory.clipped`. A part f of C(q) rides with the moving body, so

    z(x, t) = √(1 − f) z₁(x) + √f z₂(x − vt)

in the frame of the body 1 at rest. ψ = √f z₁ − √(1 − f) z₂ is independent of z at the same place: it is large where the
summits are those of the resting body, which have been hot there for long. The heat μvσ is shared by place,

    into body 1: μvσ (α + βψ + γzψ),    into body 2, the moving one: the rest.

Galerkin's equations ⟨(T₁ − T₂)σ⟩ = ⟨(T₁ − T₂)σψ⟩ = ⟨(T₁ − T₂)σzψ⟩ = 0 give the three numbers. With w = (1, ψ, zψ) the
means of T, when the heat μvσw_j enters, are, over σ₀,

    M_ij = (μv/κσ₀) (g_σ(0)/⟨F²⟩_c) ∫₀ᵗ dτ √(D/πτ) ⟨F w_i F′ w′_j⟩_c,

the mean over the normal places r of variance 2Dτ an axis at which the heat of the time τ ago entered, without ⟨F⟩².
There z₁ has the correlation ρ(r) and z₂ ρ(|r − vτ|) in body 1, and exchanged in body 2. `theory.clipped` has the means.

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
from theory.clipped import PAIRS, ClippedField, clipped_field
from theory.persson import is_value

_ODD = np.array([1.0, -1.0, -1.0, 1.0, 1.0, 1.0])  # ψ changes its sign when the bodies are exchanged
_PER_E_FOLD = 9  # distances, of the part that depends on both bodies
_NEAR = 0.03  # rad: θ at the least of them
_FINEST, _FAR = 0.7, 25.0  # over q_min: the widest interval of distances, and the last
_LEAST = 1e-5  # over the first of these distances: of those at which one body alone counts
_EVERY = 2  # of the distances of `ClippedField`
_LAST = 50.0  # over q_min: there waves of the correlation, which cancel, fade
_ANGLES = 20


class SlidingTemperatures(NamedTuple):
    """Temperatures of two rough bodies at the end of the slid distance; arrays over the speed, or floats.

    Attributes
    ----------
    flash_temperature, resting_flash_temperature : ndarray
        ⟨Tσ⟩/⟨σ⟩ of the moving and the resting body above the background of each, K.
    moving_share : ndarray
        Share of the heat that enters the moving body.
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

    def heated(body: _Body, kappa: float, diffusion: float) -> tuple[Array, Array]:
        """Return M_ij and the background of one body with all the heat, K."""
        flash = heating[:, None] / (kappa * pressure) * memory.means(body, velocity.ravel(), time, diffusion)
        return flash, 2 * heating * pressure * np.sqrt(diffusion * time / pi) / kappa

    hot, hot_background = heated(memory.moving, *moving)
    cold, cold_background = heated(memory.resting, resting_kappa, resting_diffusion)
    return _shared(_ODD * hot, cold, hot_background, cold_background, velocity.shape)


@dataclass(frozen=True, slots=True, eq=False)
class _Body:
    """⟨F w_i F′ w′_j⟩_c for the six `PAIRS`, over ⟨F²⟩_c/g_σ(0), as one body sees the summits of both."""

    own: Array  # (terms, radii): of its own summits alone
    other: Array  # (terms, radii): of those of the other body alone
    both: Array  # (terms, places, distances): what both add to that, over r and the slid distance


@dataclass(frozen=True, slots=True, eq=False)
class _Memory:
    """Memory of the contact in both bodies, by place and slid distance; it does not depend on their conductivities."""

    radius: Array  # m, in geometric sequence
    place: Array  # m: r, from 0
    distance: Array  # m: vτ, from 0
    resting: _Body
    moving: _Body

    def means(self, body: _Body, speed: Array, time: Array, diffusivity: float) -> Array:
        """Return (κσ₀/μv) M_ij of one body, Pa² m, shape (speeds, terms)."""
        rates = self.radius * np.log(self.radius[1] / self.radius[0])  # dr
        result = np.empty((speed.size, len(PAIRS)))
        for n, (v, t) in enumerate(zip(speed.tolist(), time.tolist(), strict=True)):
            reach = 2 * sqrt(diffusivity * t)
            still = scipy.special.erfc(self.radius / reach)
            # a source in motion: e^(−z) I₀(z) with z = vr/2D in the steady state
            ahead, behind = (self.radius - v * t) / reach, (self.radius + v * t) / reach
            with np.errstate(under="ignore"):
                begun = scipy.special.erfc(ahead) + scipy.special.erfcx(behind) * np.exp(-(ahead**2))
            passing = scipy.special.i0e(v * self.radius / (2 * diffusivity)) * begun / 2
            result[n] = (
                body.own @ (rates * still) + body.other @ (rates * passing) + self._joint(body, v, t, diffusivity)
            )
        return result

    def _joint(self, body: _Body, speed: float, time: float, diffusivity: float) -> Array:
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
        return sqrt(diffusivity / (pi * speed)) * (mean @ _root_weights(self.distance, speed * time))


def _root_weights(s: Array, last: float) -> Array:
    """Return weights of values at s for ∫ ds/√s from 0 to `last`, of what is linear between."""
    low, high = s[:-1], s[1:]
    stop = np.clip(last, low, high)
    zeroth, first = 2 * (np.sqrt(stop) - np.sqrt(low)), 2 / 3 * (stop**1.5 - low**1.5)
    later = (first - low * zeroth) / (high - low)
    weights = np.zeros(s.size)
    weights[:-1] += zeroth - later
    weights[1:] += later
    return weights


def _shared(hot: Array, cold: Array, hot_background: Array, cold_background: Array, shape: Any) -> SlidingTemperatures:
    """Share the heat by Galerkin's equations; `hot` and `cold` are M_ij of the moving and the resting body, K."""
    moving, resting = (np.zeros((len(m), 3, 3)) for m in (hot, cold))
    for matrix, terms in ((moving, hot), (resting, cold)):
        for column, (i, j) in enumerate(PAIRS):
            matrix[:, i, j] = matrix[:, j, i] = terms[:, column]
    system, known = moving + resting, moving[:, :, 0].copy()
    system[:, 0, 0] += hot_background + cold_background
    known[:, 0] += hot_background
    into_resting = np.linalg.solve(system, known[..., None])[..., 0]
    share = 1 - into_resting[:, 0]
    resting_flash = (resting[:, 0] * into_resting).sum(axis=1)
    flash = moving[:, 0, 0] - (moving[:, 0] * into_resting).sum(axis=1)
    background = share * hot_background
    resting_background = (1 - share) * cold_background
    numbers = flash, resting_flash, share, background, resting_background, flash + background
    return SlidingTemperatures(*(float_if_scalar(values.reshape(shape)) for values in numbers))


@lru_cache(maxsize=64)  # .3 s, the same at all speeds and slid distances
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
    matters = (field.distance > _LEAST * first) & (field.distance < 2 * _LAST * longest)
    radius = field.distance[matters][::_EVERY]
    fading = np.exp(-((radius / (_LAST * longest)) ** 4))
    bodies = {}
    for part in {f, 1 - f}:
        own, other, both = _seen(field, part, place, nearer)
        own, other = (fading * values[:, matters][:, ::_EVERY] for values in (own, other))
        bodies[part] = _Body(own, other, both)
    return _Memory(radius, place, distance, resting=bodies[f], moving=bodies[1 - f])


def _seen(field: ClippedField, part: float, place: Array, nearer: Array) -> tuple[Array, Array, Array]:
    """Return the arrays of `_Body` over all distances; `part` of the roughness is that of the other body."""
    rho = np.cos(field.angles())
    nothing = np.zeros(rho.size)
    means = field.products.shared
    own, other = means(rho, nothing, part), means(nothing, rho, part)
    log_first, step = np.log(field.distance[0]), np.log(field.distance[1] / field.distance[0])

    def at(values: Array, r: Array) -> Array:
        with np.errstate(divide="ignore"):
            index = np.clip((np.log(r) - log_first) / step, 0.0, rho.size - 1.001)
        left = index.astype(np.intp)
        return np.asarray(values[..., left] + (index - left) * (values[..., left + 1] - values[..., left]))

    points, weights = np.polynomial.legendre.leggauss(_ANGLES)
    cosine = np.cos(pi * (1 + points) / 2)
    here, alone = at(rho, place), at(own, place)
    both = np.empty((len(PAIRS), place.size, place.size))
    for n, s in enumerate(place):
        apart = np.sqrt(np.maximum(place[:, None] ** 2 + s**2 - 2 * s * place[:, None] * cosine, 0.0))
        joint = means(here[:, None], at(rho, apart), part) - at(other, apart)
        both[..., n] = joint @ (weights / 2) - alone
    start, second = both[..., :1], both[..., 1:2]
    between = start + (second - start) * (nearer / place[1])
    whole = np.concatenate([start, between, both[..., 1:]], axis=-1)
    scale = field.variance / field.products.variance
    return scale * own, scale * other, scale * whole
