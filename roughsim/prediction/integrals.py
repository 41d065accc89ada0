"""The theory of one scene as observables ask for it: integrated over C(q), or summed over the modes of a cell.

Both are the same record, so that an observable says once what the theory makes of it.
"""

from __future__ import annotations

from collections.abc import Callable
from math import inf, nan, pi
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import erf

import theory
from roughsim.grid import Grid, modes_where
from roughsim.observables.record import Theory
from roughsim.observables.stress_spectrum import StressSpectrum
from roughsim.prediction.bodies import conduction, heat_arguments, heat_partition, smoothed_spectrum, stress_arguments
from roughsim.scene import Scene
from roughsim.surface.spectrum import TruncatedSpectrum
from roughsim.surface.synthesis import mean_over_cells, mode_variance

Array = NDArray[np.float64]
OVER_SPEED = ("flash_temperature", "flash_gradient", "flash_laplacian", "flash_width", "slope_length")
_NEAR = 16.0  # mode spacings beyond q_min within which W is averaged over Fourier cells


def integrals(scene: Scene, q_max: float = inf) -> Theory:
    """Return the theory over the whole spectrum, or up to `q_max`, rad/m."""
    whole, stress = smoothed_spectrum(scene), stress_arguments(scene)
    spectrum = TruncatedSpectrum(whole, q_max) if q_max < inf else whole
    rule = "total" if scene.sliding.heat_partition == "total" else "mean"

    def total(weight: Callable[[Array], Array]) -> float:  # 2π ∫ q |σ_q|² weight(q) dq, Eq. (2)
        density = theory.persson.stress_density(spectrum, None, **stress)
        return float(density.weighted() @ weight(density.wavenumber()))

    temperatures = over_speed(scene, np.array(scene.speeds), spectrum)
    share = heat_partition(scene, rule=rule, spectrum=spectrum)
    return Theory(
        {**temperatures, "heat_partition": share, **area_fractions(scene, q_max)},
        correlation_radius=lambda fraction: float(theory.persson.correlation_radius(fraction, spectrum, **stress)),
        total=total,
    )


def summed_over_modes(scene: Scene, spectrum: Any, grid: Grid) -> Theory:
    """Return the theory with ∫ d²q C in Eqs. (2), (4), (7) and (9) replaced by the sum over mode variances of a grid.

    `spectrum` is the one that the surfaces are drawn from, up to their q_c.
    """
    q, stress = mode_stress(scene, spectrum, grid)
    speeds, sliding, bodies = np.array(scene.speeds), scene.sliding, conduction(scene)
    # the sums of Eqs. (4), (7) and (9) without μv/κσ₀, (speeds,)
    even, odd = theory.flash.angular_integrals(speeds[:, None] / (bodies.diffusivity[:, None] * q))
    temperature, gradient = (2 / pi * even) @ (stress / q), (2 / pi * odd) @ stress
    laplacian = -(2 / pi * even) @ (stress * q)
    rate = sliding.friction_coefficient * speeds / (bodies.conductivity * sliding.nominal_pressure)
    with np.errstate(divide="ignore"):
        slope_length = temperature / np.abs(gradient)
    flash = rate * temperature, rate * gradient, rate * laplacian, np.sqrt(-temperature / laplacian), slope_length
    share = np.full(speeds.shape, nan)
    if scene.counterface_conducts:  # the balance of the two bodies, both as κT σ₀/μv of the moving one
        growth, moving_background, resting_background = heat_history(scene, q)
        resting = growth @ (stress / q) + resting_background
        resting *= bodies.conductivity / bodies.counter_conductivity
        share = resting / (resting + temperature + moving_background)
    load = {"effective_modulus": scene.effective_modulus, "nominal_pressure": sliding.nominal_pressure}
    area = float(theory.persson.contact_probability(float(spectrum.breaks[-1]), spectrum, **load))
    temperatures = dict(zip(OVER_SPEED, flash, strict=True))
    return Theory(
        {**temperatures, "heat_partition": share, **area_fractions(scene), "contact_fraction": area},
        correlation_radius=StressSpectrum(q, stress, 0.5 * float(np.hypot(*grid.lengths))).correlation_radius,
        total=lambda weight: float(stress @ weight(q)),
    )


def mode_stress(scene: Scene, spectrum: Any, grid: Grid) -> tuple[Array, Array]:
    """Return the wavenumbers of the modes, rad/m, and their share of ⟨σ²⟩ − σ₀² in the theory, Pa²."""
    variance = mode_variance(spectrum, grid)
    modes = modes_where(grid, variance > 0.0)
    q, ring = np.unique(modes.wavenumber, return_inverse=True)

    def weight(at: Array) -> Any:
        return theory.persson.stress_weight(at, spectrum, **stress_arguments(scene))

    # W at |q| of each mode, but its mean over the Fourier cell near q_min: there W falls from 1 within a mode
    weights = weight(q)[ring]
    near = grid.wavenumbers < spectrum.breaks[0] + _NEAR * 2 * pi / min(grid.lengths)
    weights[near[modes.chosen]] = mean_over_cells(weight, spectrum, grid, near & modes.chosen)
    roughness = np.bincount(ring, modes.multiplicity * (variance[modes.chosen] * weights))
    return q, (0.5 * scene.effective_modulus * q) ** 2 * roughness


def heat_history(scene: Scene, q: Array) -> tuple[Array, Array, Array]:
    """Return what the time of sliding adds to the balance of the two bodies at each speed; q (modes,) in rad/m.

    First the part of the steady temperature that the resting body has reached, (speeds, modes), then the backgrounds
    κT₀ σ₀/μv of the moving and of the resting body, Pa² m, (speeds,). Where time plays no part they are 1, 0 and 0.
    """
    time, bodies = scene.sliding.duration, conduction(scene)
    if scene.sliding.heat_partition != "total" or time is None:
        zero = np.zeros(len(scene.speeds))
        return np.ones((zero.size, q.size)), zero, zero
    square = scene.sliding.nominal_pressure**2
    moving, resting = (
        np.array([theory.background.temperature(time, heat_flux=square, conductivity=1.0, diffusivity=d) for d in each])
        for each in (bodies.diffusivity, bodies.counter_diffusivity)
    )
    return erf(q * np.sqrt(bodies.counter_diffusivity * time)[:, None]), moving, resting


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
