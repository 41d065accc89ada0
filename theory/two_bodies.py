"""Flash temperature of two rough bodies that slide over one another, from C(q), without a simulation.

The contact is a clipped Gaussian field, σ = F(z), `theory.clipped`. A part f of C(q) rides with the moving body, so

    z(x, t) = √(1 − f) z₁(x) + √f z₂(x − vt)

in the frame of the body 1 at rest. The heat μvσ is shared by place and time. Heat may cross from one body to the other
wherever they touch, even where σ is low: on all the area A of the law. Let σ̄ be σ₀A₀/A there and 0 outside:

    into body 1: μv[ασ + β(σ̄ − σ) + σ̄(γψ + δEψ + εχ + ηζ)],    into body 2, the moving one: the rest.

ψ = √f z₁ − √(1 − f) z₂ is independent of z at the same place: it is large where the summits are those of the resting
body, which have been hot there for long. E is 1/(z − u + .1), with z = u at the edge of the contact, less its mean over
the contact: there the heat that crosses is singular. χ is the Riesz transform of z along the direction of sliding: it
has opposite signs at the front of a spot, where one body is still cold, and at its rear, where the other is. ζ is the
half-potential of z, less its mean over the contact: it is large where contact is dense. There the body to which the
summits belong has become hottest, and the other one takes more of the heat.

Galerkin's equations, that T₁ − T₂ vanishes in the mean over each W of (σ, σ̄ − σ, σ̄ψ, σ̄Eψ, σ̄χ, σ̄ζ), give the six
numbers at each time. The means of T over σ₀ at the time t, when the heat μvW_j has entered since the start, are

    M_ij(t) = (μv/κσ₀) (g_σ(0)/⟨F²⟩_c) ∫₀ᵗ dτ √(D/πτ) ⟨W_i W′_j⟩_c,

the mean over the normal places r of variance 2Dτ an axis at which the heat of the time τ ago entered, without ⟨F⟩².
There z₁ has the correlation ρ(r) and z₂ ρ(|r + vτ|) in body 1, and exchanged, with −v, in body 2. `theory.memory` has
the means. Those of χ with another are odd, M_ji = −M_ij. Heat that entered from t₁ to t₂ adds M(t − t₁) − M(t − t₂).
So the equations at ages in geometric sequence, with constant shares between, are solved one after the other. With a
skin, or heat released in depth, the heat of the time τ ago counts as `theory.layered_memory` has it.

Waves of z have no negative power, as ρ of the law has at long ones (`ClippedField.possible_correlation`): else the six
numbers could grow without bounds. All M_ij are multiplied by the ratio of M_00 with the g_σ of the law to theirs. Of
what the law lacks of long waves, each body keeps the share that it keeps of the pressure, ⟨F F′⟩_c with ρ = 1 in it and
0 in the other: the law's own ρ < 0 would let it keep long waves of negative power.

Source: docs/sliding.md, which compares it with simulations.
"""

from __future__ import annotations

from math import pi
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from theory.arguments import Array, SpectrumLike, float_if_scalar, positive, real_array
from theory.clipped import PAIRS
from theory.layered_memory import pulses, uniform_rise
from theory.memory import Memory, SeenPairs, memory_of
from theory.skin import BodyLayers, Skin, ThermalBody, body_of

_EXCHANGED = np.array([1.0, 1.0, -1.0, -1.0, -1.0, 1.0])  # bodies exchanged: ψ and χ change sign
_MIRROR = np.array([1.0, 1.0, 1.0, 1.0, -1.0, 1.0])  # places exchanged: χ does
_I, _J = np.array(PAIRS).T
_SHARES = 6
# of the mean over σ of heat as σ̄, 0 in full contact: the least that counts of the one over σ̄ − σ, 0 where all has
# yielded
_EVEN = 1e-6
_AGES = np.append(0.0, np.geomspace(1e-3, 1.0, 32))  # of the time slid: shares are constant between
_EARLIER = np.geomspace(1e-9, 1e-3, 40)[:-1]  # further ages of heat that enters a body with layers


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
    spectrum: SpectrumLike,
    *,
    effective_modulus: float,
    nominal_pressure: float,
    penetration_hardness: float | None = None,
    friction_coefficient: float,
    conductivity: float,
    diffusivity: float,
    resting_conductivity: float | None = None,
    resting_diffusivity: float | None = None,
    skin: Skin | None = None,
    heat_depth: float = 0.0,
    resting_skin: Skin | None = None,
    resting_heat_depth: float = 0.0,
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
    skin, resting_skin : three floats, optional
        Thickness, m, conductivity, W/(m K), and diffusivity, m²/s, of a layer of another material on each body.
    heat_depth, resting_heat_depth : float
        Depth h, m, ≥ 0, in which the heat of each body is released, with the density q̇ e^(−z/h)/h; 0 is the surface.
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
            raise ValueError(
                f"{name} = {values.min():.6g} {unit} must be positive: heat is kept over the way slid"
            )
    part = float(real_array("moving_roughness", moving_roughness, "1"))
    if not 0.0 <= part <= 1.0:
        raise ValueError(f"moving_roughness = {part:.6g} must lie from 0 to 1")
    heating = positive("friction_coefficient", friction_coefficient, "1") * velocity.ravel()
    moving = body_of(conductivity, diffusivity, skin, heat_depth)
    resting = body_of(
        resting_conductivity, resting_diffusivity, resting_skin, resting_heat_depth, like=moving
    )
    pressure = positive("nominal_pressure", nominal_pressure, "Pa")
    memory = memory_of(spectrum, effective_modulus, pressure, penetration_hardness, part)
    time = (distance / velocity).ravel()

    def heated(seen: SeenPairs, body: ThermalBody, sign: Array | float) -> tuple[Array, Array]:
        """Return M_ij and the background of one body with all the heat at each age, K; (speeds, ages, …)."""
        kappa, diffusion, layers = body
        ages = time[:, None] * _AGES
        if layers is None:
            terms = sign * memory.means(seen, velocity.ravel(), ages[:, 1:], diffusion)
            warmed = 2 * np.sqrt(diffusion * ages / pi)
        else:
            terms = sign * _layered_means(memory, seen, velocity.ravel(), time, diffusion, layers)
            warmed = np.array([[0.0, *uniform_rise(layers, diffusion, row[1:])] for row in ages])
        terms *= (heating / (kappa * pressure))[:, None, None]
        flash = np.zeros((*ages.shape, _SHARES, _SHARES))
        flash[:, 1:, _J, _I] = (_MIRROR[_I] * _MIRROR[_J]) * terms
        flash[:, 1:, _I, _J] = terms
        return flash, pressure * (heating / kappa)[:, None] * warmed

    hot, hot_background = heated(memory.moving, moving, _EXCHANGED[_I] * _EXCHANGED[_J])
    cold, cold_background = heated(memory.resting, resting, 1.0)
    return _shared(hot, cold, hot_background, cold_background, velocity.shape)


def _layered_means(
    memory: Memory,
    body: SeenPairs,
    speed: Array,
    time: Array,
    diffusivity: float,
    layers: BodyLayers,
) -> Array:
    """Return `Memory.means` at `_AGES` of a body with layers: the heat of each time counts ρ_j of a bare body's."""
    ages = time[:, None] * np.append(_EARLIER, _AGES[1:])
    middle = np.sqrt(ages[:, 1:] * ages[:, :-1])
    middle = np.concatenate([ages[:, :1] / 4, middle], axis=1)
    several = [pulses(layers, diffusivity, row) for row in middle]
    result = np.zeros((*ages.shape, len(PAIRS)))
    for j, spread in enumerate(several[0][0].tolist()):
        added = np.diff(memory.means(body, speed, ages, spread), axis=1, prepend=0.0)
        strength = np.array([rho[j] for _, rho in several])
        result += np.cumsum(strength[..., None] * added, axis=1)
    return result[:, _EARLIER.size :]


def _shared(
    hot: Array, cold: Array, hot_background: Array, cold_background: Array, shape: Any
) -> SlidingTemperatures:
    """Share the heat by Galerkin's equations at each age; `hot` and `cold` are M_ij of both bodies, K."""
    moving = hot.copy()
    moving[..., 0, 0] += hot_background
    system = moving + cold
    system[..., 0, 0] += cold_background
    system[..., 1, 1] += _EVEN * (hot + cold)[..., 0, :2].sum(axis=-1)
    last = _AGES.size - 1
    into_resting = np.zeros((len(hot), last, _SHARES))
    for n in range(1, last + 1):
        heated = _pulses(system, n)
        known = moving[:, n, :, 0] - np.einsum(
            "snij,snj->si", heated[:, :-1], into_resting[:, : n - 1]
        )
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
    # over √age they change slowly with ln age, and are constant at first
    index = np.log(np.maximum(passed / ages[0], 1.0)) / np.log(ages[1] / ages[0])
    left = np.minimum(index, ages.size - 2).astype(np.intp)
    between, root, first = (
        x.reshape(-1, *(1,) * (values.ndim - 2))
        for x in (np.minimum(index - left, 1.0), np.sqrt(passed), np.sqrt(ages))
    )
    scaled = values[:, 1:] / first
    seen = root * (scaled[:, left] + between * np.diff(scaled, axis=1)[:, left])
    return np.asarray(seen[:, :-1] - seen[:, 1:])
