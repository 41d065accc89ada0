"""The theory of one scene as observables ask for it: integrated over C(q), or summed over the modes of a cell.

Both views offer what `observables.record.Theory` asks for, so that an observable says once what the theory makes of it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from math import inf, nan, pi
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import erf

import theory
from roughsim.grid import Grid
from roughsim.observables.stress_spectrum import StressSpectrum
from roughsim.prediction.bodies import (
    conduction,
    heat_arguments,
    smoothed_spectrum,
    stress_arguments,
    theoretical_partition,
)
from roughsim.scene import Scene
from roughsim.surface.spectrum import TruncatedSpectrum
from roughsim.surface.synthesis import mean_over_cells, mode_variance

Array = NDArray[np.float64]
OVER_SPEED = ("flash_temperature", "flash_gradient", "flash_laplacian", "flash_width", "slope_length")
_NEAR = 16.0  # mode spacings beyond q_min within which W is averaged over Fourier cells


class Integrals:
    """The theory over the whole spectrum, or up to `q_max`, rad/m."""

    def __init__(self, scene: Scene, q_max: float = inf):
        whole = smoothed_spectrum(scene)
        self._scene = scene
        self._end = min(q_max, float(whole.breaks[-1]))
        self._spectrum = TruncatedSpectrum(whole, q_max) if q_max < inf else whole

    @cached_property
    def over_speed(self) -> dict[str, Array]:
        """T_flash, T′, ∇²T, D_flash and d_flash by name, (speeds,). Eqs. (4), (7), (9), (25), (26)"""
        return over_speed(self._scene, np.array(self._scene.speeds), self._spectrum)

    @property
    def heat_partition(self) -> Array:
        """The share of the moving body, (speeds,)."""
        return theoretical_partition(self._scene, self._spectrum)

    @property
    def area_fractions(self) -> dict[str, float]:
        """`contact_fraction` and `plastic_fraction`."""
        return area_fractions(self._scene, self._end)

    def correlation_radius(self, fraction: float) -> float:
        """Return the smallest r, m, with g_σ(r) = fraction·g_σ(0)."""
        return float(theory.persson.correlation_radius(fraction, self._spectrum, **stress_arguments(self._scene)))

    def total(self, weight: Callable[[Array], Array]) -> float:
        """Return 2π ∫ q |σ_q|² weight(q) dq. Eq. (2)"""
        density = theory.persson.stress_density(self._spectrum, None, **stress_arguments(self._scene))
        return float(density.weighted() @ weight(density.wavenumber()))


class ModeSums:
    """The same with ∫ d²q C replaced by the sum over the mode variances of a grid: what a simulation can see.

    `spectrum` is the one that the surfaces are drawn from, up to their q_c.
    """

    def __init__(self, scene: Scene, spectrum: Any, grid: Grid):
        variance = mode_variance(spectrum, grid) * grid.multiplicity
        present = variance > 0.0
        q, place = np.unique(grid.wavenumbers[present], return_inverse=True)
        stress = stress_arguments(scene)

        def weight(at: Array) -> Any:
            return theory.persson.stress_weight(at, spectrum, **stress)

        # W at |q| of each mode, but its mean over the Fourier cell near q_min: there W falls from 1 within a mode
        weights = weight(q)[place]
        near = grid.wavenumbers < spectrum.breaks[0] + _NEAR * 2 * pi / min(grid.lengths)
        weights[near[present]] = mean_over_cells(weight, spectrum, grid, near & present)
        roughness = np.bincount(place, variance[present] * weights)
        self._scene, self._reach = scene, 0.5 * float(np.hypot(*grid.lengths))
        self._wavenumber, self._stress = q, (0.5 * scene.effective_modulus * q) ** 2 * roughness
        del stress["gamma"]
        self._probability = float(theory.persson.contact_probability(float(spectrum.breaks[-1]), spectrum, **stress))

    @cached_property
    def _moments(self) -> tuple[Array, Array, Array]:
        """The sums of Eqs. (4), (7) and (9) without μv/κσ₀, (speeds,)."""
        q, stress = self._wavenumber, self._stress
        diffusivity = conduction(self._scene).diffusivity
        ratio = np.array(self._scene.speeds)[:, None] / (diffusivity[:, None] * q)
        even, odd = theory.flash.angular_integrals(ratio)
        return (2 / pi * even) @ (stress / q), (2 / pi * odd) @ stress, -(2 / pi * even) @ (stress * q)

    @property
    def over_speed(self) -> dict[str, Array]:
        """T_flash, T′, ∇²T, D_flash and d_flash by name, (speeds,)."""
        temperature, gradient, laplacian = self._moments
        sliding = self._scene.sliding
        heating = sliding.friction_coefficient * np.array(self._scene.speeds)
        rate = heating / (conduction(self._scene).conductivity * sliding.nominal_pressure)
        with np.errstate(divide="ignore"):
            slope_length = temperature / np.abs(gradient)
        width = np.sqrt(-temperature / laplacian)
        values = rate * temperature, rate * gradient, rate * laplacian, width, slope_length
        return dict(zip(OVER_SPEED, values, strict=True))

    @property
    def heat_partition(self) -> Array:
        """The share of the moving body, (speeds,); NaN without a second one."""
        moving = self._moments[0]  # κT σ₀/μv, as all temperatures here
        if not self._scene.counterface_conducts:
            return np.full(moving.shape, nan)
        history, bodies = heat_history(self._scene, self._wavenumber), conduction(self._scene)
        still = history.growth @ (self._stress / self._wavenumber) + history.resting
        still *= bodies.conductivity / bodies.counter_conductivity
        share: Array = still / (still + moving + history.moving)
        return share

    @property
    def area_fractions(self) -> dict[str, float]:
        """`contact_fraction` and `plastic_fraction`."""
        return area_fractions(self._scene) | {"contact_fraction": self._probability}

    def correlation_radius(self, fraction: float) -> float:
        """Return the smallest r, m, with g_σ(r) = fraction·g_σ(0); NaN if the cell holds none."""
        return StressSpectrum(self._wavenumber, self._stress, self._reach).correlation_radius(fraction)

    def total(self, weight: Callable[[Array], Array]) -> float:
        """Return Σ |σ_q|² weight(q)."""
        return float(self._stress @ weight(self._wavenumber))


class HeatHistory(NamedTuple):
    """What the time of sliding adds to the balance of the two bodies, at each speed.

    `growth` (speeds, modes) is the part of the steady temperature that the resting body has reached; `moving` and
    `resting` (speeds,) are the backgrounds κT₀ σ₀/μv, Pa² m. Where time plays no part they are 1, 0 and 0.
    """

    growth: Array
    moving: Array
    resting: Array


def heat_history(scene: Scene, q: Array) -> HeatHistory:
    """Return what the time of sliding adds at wavenumbers q of modes, rad/m, (modes,)."""
    time, bodies, none = scene.sliding.duration, conduction(scene), np.zeros(len(scene.speeds))
    if scene.sliding.heat_partition != "total" or time is None:
        return HeatHistory(np.ones((none.size, q.size)), none, none)
    square = scene.sliding.nominal_pressure**2
    moving, resting = (
        np.array([theory.background.temperature(time, heat_flux=square, conductivity=1.0, diffusivity=d) for d in each])
        for each in (bodies.diffusivity, bodies.counter_diffusivity)
    )
    return HeatHistory(erf(q * np.sqrt(bodies.counter_diffusivity * time)[:, None]), moving, resting)


def over_speed(
    scene: Scene,
    speeds: Array,
    spectrum: Any = None,
    *,
    stress_spectrum: Any = None,
    names: tuple[str, ...] = OVER_SPEED,
) -> dict[str, Array]:
    """Return T_flash, T′, ∇²T, D_flash and d_flash at any speeds, m/s, with all heat in the moving body.

    They are those of the whole spectrum, of a `spectrum` C(q), or of a `stress_spectrum` |σ_q|².
    """
    if stress_spectrum is not None:
        stress = {"stress_spectrum": stress_spectrum, "nominal_pressure": scene.sliding.nominal_pressure}
    else:
        stress = {"spectrum": smoothed_spectrum(scene) if spectrum is None else spectrum} | stress_arguments(scene)
    result = {name: np.empty(speeds.shape) for name in names}
    for indices, bodies in conduction(scene, speeds).groups():
        for name, values in result.items():
            formula = getattr(theory.flash, name)
            values[indices] = formula(speeds[indices], **stress, **heat_arguments(scene, bodies))
    return result


def area_fractions(scene: Scene, q_max: float = inf) -> dict[str, float]:
    """Return the contact and the plastic share of the area with all roughness, or with that up to q_max, rad/m."""
    spectrum, modulus = scene.spectrum, scene.effective_modulus
    load, end = scene.sliding.nominal_pressure, min(q_max, float(spectrum.breaks[-1]))
    if scene.elastic:
        probability = theory.persson.contact_probability
        share = probability(end, spectrum, effective_modulus=modulus, nominal_pressure=load)
        return {"contact_fraction": float(share), "plastic_fraction": 0.0}
    variance = theory.persson.half_variance(end, spectrum, effective_modulus=modulus)
    _, elastic, plastic = theory.plasticity.area_fractions(variance, load, scene.penetration_hardness)
    return {"contact_fraction": float(elastic + plastic), "plastic_fraction": float(plastic)}
