"""The theory of one scene as observables ask for it: integrated over C(q), or summed over the modes of a cell.

Both views have the same attributes, so that an observable says once what the theory makes of it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from math import inf, nan, pi
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.special import erf

from roughsim.grid import Grid
from roughsim.observables.moments import StressSpectrum
from roughsim.prediction.bodies import (
    conduction,
    heat_arguments,
    smoothed_spectrum,
    stress_arguments,
    theoretical_partition,
)
from roughsim.surface.spectrum import TruncatedSpectrum
from roughsim.surface.synthesis import mean_over_cells, mode_variance

if TYPE_CHECKING:
    from roughsim.scene import Scene

Array = NDArray[np.float64]
_NEAR = 16.0  # mode spacings beyond q_min within which W is averaged over Fourier cells


class Theory(Protocol):
    """What an observable may ask of the theory of `scene`; all the heat goes into the moving body."""

    scene: Scene

    @property
    def over_speed(self) -> dict[str, Array]:
        """T_flash, T′, ∇²T, D_flash and d_flash by name, (speeds,)."""

    @property
    def heat_partition(self) -> Array:
        """The share of the moving body, (speeds,); NaN without a second one."""

    @property
    def area_fractions(self) -> dict[str, float]:
        """`contact_fraction` and `plastic_fraction`."""

    def correlation_radius(self, fraction: float) -> float:
        """Return the smallest r, m, with g_σ(r) = fraction·g_σ(0); NaN if there is none."""

    def total(self, weight: Callable[[Array], Array]) -> float:
        """Return the sum or integral of weight(q) over the variance of the pressure, Pa² times its unit.

        `weight` takes wavenumbers in rad/m and is smooth in ln q; with 1 it gives g_σ(0).
        """


class Integrals:
    """The theory over the whole spectrum, or up to `q_max`, rad/m."""

    def __init__(self, scene: Scene, q_max: float = inf):
        self.scene = scene
        whole = smoothed_spectrum(scene)
        self._end = min(q_max, float(whole.breaks[-1]))
        self._spectrum = TruncatedSpectrum(whole, q_max) if q_max < inf else whole

    @cached_property
    def over_speed(self) -> dict[str, Array]:
        """T_flash, T′, ∇²T, D_flash and d_flash by name, (speeds,). Eqs. (4), (7), (9), (25), (26)"""
        return over_speed(self.scene, np.array(self.scene.speeds), self._spectrum)

    @property
    def heat_partition(self) -> Array:
        """The share of the moving body, (speeds,)."""
        return theoretical_partition(self.scene, self._spectrum)

    @property
    def area_fractions(self) -> dict[str, float]:
        """`contact_fraction` and `plastic_fraction`."""
        return area_fractions(self.scene, self._end)

    def correlation_radius(self, fraction: float) -> float:
        """Return the smallest r, m, with g_σ(r) = fraction·g_σ(0)."""
        from theory import persson

        return persson.correlation_radius(fraction, self._spectrum, **stress_arguments(self.scene))

    def total(self, weight: Callable[[Array], Array]) -> float:
        """Return 2π ∫ q |σ_q|² weight(q) dq. Eq. (2)"""
        from theory import persson

        stress = stress_arguments(self.scene)
        density = persson.stress_density(
            self._spectrum, None, stress["effective_modulus"], stress["nominal_pressure"], stress["gamma"]
        )
        return float(density.weighted() @ weight(density.wavenumber()))


class ModeSums:
    """The same with ∫ d²q C replaced by the sum over the mode variances of a grid: what a simulation can see."""

    def __init__(self, scene: Scene, spectrum: Any, grid: Grid):
        self.scene = scene
        self._reach = 0.5 * float(np.hypot(*grid.lengths))
        self._wavenumber, self._stress, self._probability = _mode_stress(scene, spectrum, grid)

    @cached_property
    def _moments(self) -> tuple[Array, Array, Array]:
        """The sums of Eqs. (4), (7) and (9) without μv/κσ₀, (speeds,)."""
        from theory import flash

        q, stress = self._wavenumber, self._stress
        diffusivity = conduction(self.scene).diffusivity
        even, odd = flash.angular_integrals(np.array(self.scene.speeds)[:, None] / (diffusivity[:, None] * q))
        return (2 / pi * even) @ (stress / q), (2 / pi * odd) @ stress, -(2 / pi * even) @ (stress * q)

    @property
    def over_speed(self) -> dict[str, Array]:
        """T_flash, T′, ∇²T, D_flash and d_flash by name, (speeds,)."""
        temperature, gradient, laplacian = self._moments
        sliding = self.scene.sliding
        heating = sliding.friction_coefficient * np.array(self.scene.speeds)
        rate = heating / (conduction(self.scene).conductivity * sliding.nominal_pressure)
        with np.errstate(divide="ignore"):
            slope_length = temperature / np.abs(gradient)
        return {
            "flash_temperature": rate * temperature,
            "flash_gradient": rate * gradient,
            "flash_laplacian": rate * laplacian,
            "flash_width": np.sqrt(-temperature / laplacian),
            "slope_length": slope_length,
        }

    @property
    def heat_partition(self) -> Array:
        """The share of the moving body, (speeds,); NaN without a second one."""
        moving = self._moments[0]  # κT σ₀/μv, as all temperatures here
        if not self.scene.counterface_conducts:
            return np.full(moving.shape, nan)
        heated, bodies = heating(self.scene, self._wavenumber), conduction(self.scene)
        still = heated.growth @ (self._stress / self._wavenumber) + heated.resting
        still *= bodies.conductivity / bodies.counter_conductivity
        share: Array = still / (still + moving + heated.moving)
        return share

    @property
    def area_fractions(self) -> dict[str, float]:
        """`contact_fraction` and `plastic_fraction`."""
        return area_fractions(self.scene) | {"contact_fraction": self._probability}

    def correlation_radius(self, fraction: float) -> float:
        """Return the smallest r, m, with g_σ(r) = fraction·g_σ(0); NaN if the cell holds none."""
        return StressSpectrum(self._wavenumber, self._stress, self._reach).correlation_radius(fraction)

    def total(self, weight: Callable[[Array], Array]) -> float:
        """Return Σ |σ_q|² weight(q)."""
        return float(self._stress @ weight(self._wavenumber))


def _mode_stress(scene: Scene, spectrum: Any, grid: Grid) -> tuple[Array, Array, float]:
    """Wavenumbers of the modes, their share of ⟨σ²⟩ − σ₀² in the theory, and the contact area at their end.

    W is that at |q| of a mode, but its mean over the Fourier cell near q_min: there W falls from 1 within a mode.
    """
    from theory import persson

    variance = mode_variance(spectrum, grid) * grid.multiplicity
    present = variance > 0.0
    q, place = np.unique(grid.wavenumbers[present], return_inverse=True)
    stress = stress_arguments(scene)

    def weight(at: Array) -> Array:
        return persson.stress_weight(at, spectrum, **stress)

    weights = weight(q)[place]
    near = grid.wavenumbers < spectrum.breaks[0] + _NEAR * 2 * pi / min(grid.lengths)
    weights[near[present]] = mean_over_cells(weight, spectrum, grid, near & present)
    roughness = np.bincount(place, variance[present] * weights)
    pressures = {key: stress[key] for key in ("effective_modulus", "nominal_pressure")}
    share = persson.contact_probability(float(spectrum.breaks[-1]), spectrum, **pressures)
    return q, (0.5 * scene.effective_modulus * q) ** 2 * roughness, float(share)


class _Heating(NamedTuple):
    """What the time of sliding adds to the balance of the two bodies, at each speed.

    `growth` (speeds, modes) is the part of the steady temperature that the resting body has reached; `moving` and
    `resting` (speeds,) are the backgrounds κT₀ σ₀/μv, Pa² m. With the rule "mean" they are 1, 0 and 0.
    """

    growth: Array
    moving: Array
    resting: Array


def heating(scene: Scene, q: Array) -> _Heating:
    """Return what the time of sliding adds to the balance of the two bodies.

    Parameters
    ----------
    scene : Scene
        What is computed.
    q : ndarray
        Wavenumbers of the modes, rad/m, (modes,).
    """
    from theory import background

    time, bodies, none = scene.sliding.duration, conduction(scene), np.zeros(len(scene.speeds))
    if scene.sliding.heat_partition != "total" or time is None:
        return _Heating(np.ones((none.size, q.size)), none, none)
    square = scene.sliding.nominal_pressure**2
    moving, resting = (
        np.array([background.temperature(time, heat_flux=square, conductivity=1.0, diffusivity=d) for d in each])
        for each in (bodies.diffusivity, bodies.counter_diffusivity)
    )
    return _Heating(erf(q * np.sqrt(bodies.counter_diffusivity * time)[:, None]), moving, resting)


def over_speed(scene: Scene, speeds: Array, spectrum: Any = None) -> dict[str, Array]:
    """Return T_flash, T′, ∇²T, D_flash and d_flash at any speeds, m/s, over the whole spectrum or a given one."""
    from theory import flash

    spectrum = smoothed_spectrum(scene) if spectrum is None else spectrum
    names = ("flash_temperature", "flash_gradient", "flash_laplacian", "flash_width", "slope_length")
    result = {name: np.empty(speeds.shape) for name in names}
    for place, bodies in conduction(scene, speeds).groups():
        given = stress_arguments(scene) | heat_arguments(scene, bodies)
        for name, values in result.items():
            values[place] = getattr(flash, name)(speeds[place], spectrum, **given)
    return result


def area_fractions(scene: Scene, q_max: float = inf) -> dict[str, float]:
    """Return the contact and the plastic share of the area with all roughness, or with that up to q_max, rad/m."""
    from theory import persson, plasticity

    spectrum, modulus = scene.spectrum, scene.effective_modulus
    load, end = scene.sliding.nominal_pressure, min(q_max, float(scene.spectrum.breaks[-1]))
    if scene.elastic:
        share = persson.contact_probability(end, spectrum, effective_modulus=modulus, nominal_pressure=load)
        return {"contact_fraction": float(share), "plastic_fraction": 0.0}
    variance = persson.half_variance(end, spectrum, effective_modulus=modulus)
    _, elastic, plastic = plasticity.area_fractions(variance, load, scene.penetration_hardness)
    return {"contact_fraction": float(elastic + plastic), "plastic_fraction": float(plastic)}
