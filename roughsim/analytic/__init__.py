"""What the theory says of a scene: the one door to the package `theory`.

All temperatures here are with all the heat in the moving body; the share is a quantity of its own.
"""

from __future__ import annotations

from math import pi
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import erf

from roughsim.analytic.bodies import (
    conduction,
    heat_arguments,
    heat_partition,
    pressure_arguments,
    smoothed_spectrum,
    stress_arguments,
    theoretical_partition,
)
from roughsim.grid import Grid
from roughsim.means import RADII, Sample
from roughsim.observables import StressSpectrum
from roughsim.spectrum import TruncatedSpectrum
from roughsim.surface import mode_variance

if TYPE_CHECKING:
    from roughsim.scene import Scene

Array = NDArray[np.float64]


def yield_wavenumber(scene: Scene) -> float:
    """Return q_y, rad/m, where 1 % of the theory's contact is still elastic; infinite if C(q) ends before."""
    from theory import plasticity

    return plasticity.yield_wavenumber(scene.spectrum, **pressure_arguments(scene))


def predictions(scene: Scene) -> dict[str, Array]:
    """Return every observable over the whole spectrum, arrays over speed or of one entry."""
    result = over_speed(scene, np.array(scene.speeds)) | _without_speed(scene, smoothed_spectrum(scene))
    result["heat_partition"] = theoretical_partition(scene)
    return result | {name: np.array([value]) for name, value in area_fractions(scene).items()}


def _without_speed(scene: Scene, spectrum: Any) -> dict[str, Array]:
    """⟨σ²⟩ − σ₀² and the radii of g_σ."""
    from theory import persson

    stress = stress_arguments(scene)
    result = {"pressure_variance": np.array([float(persson.pressure_correlation(0.0, spectrum, **stress))])}
    for name, fraction in RADII.items():
        result[name] = np.array([persson.correlation_radius(fraction, spectrum, **stress)])
    return result


def calibrated(scene: Scene) -> dict[str, Array]:
    """Return T_flash, T′, D_flash, d_flash and g_σ(0) by the calibrated stress spectrum of an elastic scene.

    Raises
    ------
    ValueError
        If the scene lies outside what is calibrated.
    """
    from theory import flash, persson

    load = scene.sliding.nominal_pressure
    modulus = scene.effective_modulus
    spectrum = persson.calibrated_spectrum(scene.spectrum, effective_modulus=modulus, nominal_pressure=load)
    speeds = np.array(scene.speeds)
    names = ("flash_temperature", "flash_gradient", "flash_width", "slope_length")
    result = {name: np.empty(speeds.shape) for name in names}
    for place, bodies in conduction(scene, speeds).groups():
        given = {"stress_spectrum": spectrum, "nominal_pressure": load, **heat_arguments(scene, bodies)}
        for name, values in result.items():
            values[place] = getattr(flash, name)(speeds[place], **given)
    variance = float(persson.pressure_correlation(0.0, stress_spectrum=spectrum))
    return result | {"pressure_variance": np.array([variance])}


def calibration_error() -> float:
    """Return the relative error band of `calibrated`."""
    from theory.calibrated import ERROR_BAND

    return ERROR_BAND


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


def hertz_like(scene: Scene) -> tuple[float, float, float]:
    """Return R, m, and vR/D of the fast Hertz contact with the theory's D_flash, and its T_flash in q̇₁R/κ."""
    from theory import hertz

    speed = max(scene.speeds)
    radius = float(over_speed(scene, np.array([speed]))["flash_width"][0]) / hertz.FAST.flash_width
    peclet = speed * radius / float(conduction(scene, [speed]).diffusivity[0])
    return radius, peclet, float(hertz.flash_temperature(peclet))


def size_errors(scene: Scene, grid: Grid, q_max: float) -> dict[str, Array]:
    """Return |sum over the modes of a cell / integral − 1| of every observable in the theory, up to the same q_max.

    It tells what the cell leaves out: waves longer than itself, and all between its modes. Zero where the theory has
    no value.
    """
    spectrum = TruncatedSpectrum(smoothed_spectrum(scene), q_max)
    sums = mode_sums(scene, spectrum, grid)
    whole = over_speed(scene, np.array(scene.speeds), spectrum) | _without_speed(scene, spectrum)
    result = {}
    for name, value in sums.items():
        with np.errstate(all="ignore"):
            error = np.abs(value / whole.get(name, value) - 1.0)
        result[name] = np.where(np.isfinite(error), error, 0.0)
    return result


def area_fractions(scene: Scene) -> dict[str, float]:
    """Return the contact and the plastic share of the area with all roughness."""
    from theory import persson, plasticity

    spectrum, modulus = scene.spectrum, scene.effective_modulus
    load, end = scene.sliding.nominal_pressure, scene.spectrum.breaks[-1]
    if scene.elastic:
        share = persson.contact_probability(end, spectrum, effective_modulus=modulus, nominal_pressure=load)
        return {"contact_fraction": float(share), "plastic_fraction": 0.0}
    variance = persson.half_variance(end, spectrum, effective_modulus=modulus)
    _, elastic, plastic = plasticity.area_fractions(variance, load, scene.penetration_hardness)
    return {"contact_fraction": float(elastic + plastic), "plastic_fraction": float(plastic)}


def correlation(scene: Scene, distance: Array) -> Array:
    """Return g_σ(r) over the whole spectrum, Pa², at distances in m. Eq. (2)."""
    from theory import persson

    return persson.pressure_correlation(distance, smoothed_spectrum(scene), **stress_arguments(scene))


def stress_spectrum(scene: Scene, q: Array) -> Array:
    """Return |σ_q|² = (E* q/2)² C(q) W(q) over the whole spectrum, Pa² m², so that g_σ(0) = 2π ∫ q |σ_q|² dq. Eq. (2).

    Parameters
    ----------
    scene : Scene
        What is computed; C is C_sm where there is a hardness.
    q : ndarray
        Wavenumbers, rad/m.
    """
    from theory import persson

    spectrum = smoothed_spectrum(scene)
    density: Array = (0.5 * scene.effective_modulus * q) ** 2 * spectrum(q)
    return density * persson.stress_weight(q, spectrum, **stress_arguments(scene))


def mode_sums(scene: Scene, spectrum: Any, grid: Grid) -> dict[str, Array]:
    """Return every observable summed over the modes of a grid instead of integrated: what a simulation can see.

    Parameters
    ----------
    scene : Scene
        What is computed.
    spectrum : Spectrum
        The spectrum that the surfaces are synthesized from, up to their q_c.
    grid : Grid
        Their grid.

    Returns
    -------
    dict
        As `predictions`; Eqs. (2), (4), (7) and (9) with ∫ d²q C replaced by the sum over mode variances.
    """
    from theory import flash

    q, stress, probability = _mode_stress(scene, spectrum, grid)
    speeds, bodies = np.array(scene.speeds), conduction(scene)
    rate = scene.sliding.friction_coefficient * speeds / (bodies.conductivity * scene.sliding.nominal_pressure)
    even, odd = flash.angular_integrals(speeds[:, None] / (bodies.diffusivity[:, None] * q))
    temperature, gradient = (2 / pi * even) @ (stress / q), (2 / pi * odd) @ stress
    laplacian = -(2 / pi * even) @ (stress * q)
    with np.errstate(divide="ignore"):
        slope_length = temperature / np.abs(gradient)
    result = {
        "flash_temperature": rate * temperature,
        "flash_gradient": rate * gradient,
        "flash_laplacian": rate * laplacian,
        "flash_width": np.sqrt(-temperature / laplacian),
        "slope_length": slope_length,
        "heat_partition": _mode_share(scene, q, stress / q, temperature),
        "contact_fraction": np.array([probability]),
        "plastic_fraction": np.array([area_fractions(scene)["plastic_fraction"]]),
        "pressure_variance": np.array([float(stress.sum())]),
    }
    modes = StressSpectrum(q, stress, 0.5 * float(np.hypot(*grid.lengths)))
    return result | {name: np.array([modes.correlation_radius(share)]) for name, share in RADII.items()}


def _mode_stress(scene: Scene, spectrum: Any, grid: Grid) -> tuple[Array, Array, float]:
    """Wavenumbers of the modes, their share of ⟨σ²⟩ − σ₀² in the theory, and the contact area at their end."""
    from theory import persson

    variance = mode_variance(spectrum, grid) * grid.multiplicity
    present = variance > 0.0
    q, place = np.unique(grid.wavenumbers[present], return_inverse=True)
    pressures = {"effective_modulus": scene.effective_modulus, "nominal_pressure": scene.sliding.nominal_pressure}
    weight = persson.stress_weight(q, spectrum, **pressures, gamma=scene.theory.gamma)
    roughness = np.bincount(place, variance[present])
    share = persson.contact_probability(float(spectrum.breaks[-1]), spectrum, **pressures)
    return q, (0.5 * scene.effective_modulus * q) ** 2 * roughness * weight, float(share)


def _mode_share(scene: Scene, q: Array, resting: Array, moving: Array) -> Array:
    """Share of the moving body; `resting` (modes,) and `moving` (speeds,) are κT σ₀/μv without the background."""
    if not scene.counterface_conducts:
        return np.full(moving.shape, np.nan)
    heated, bodies = _heating(scene, q), conduction(scene)
    still = heated.growth @ resting + heated.resting
    still *= bodies.conductivity / bodies.counter_conductivity
    share: Array = still / (still + moving + heated.moving)
    return share


class _Heating(NamedTuple):
    """What the time of sliding adds to the balance of the two bodies, at each speed.

    `growth` (speeds, modes) is the part of the steady temperature that the resting body has reached; `moving` and
    `resting` (speeds,) are the backgrounds κT₀ σ₀/μv, Pa² m. With the rule "mean" they are 1, 0 and 0.
    """

    growth: Array
    moving: Array
    resting: Array


def _heating(scene: Scene, q: Array) -> _Heating:
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


def balanced(scene: Scene, sample: Sample) -> Sample:
    """Return a level with the temperatures that the two bodies should have in common for the share of the scene.

    For "total" they include the background T₀ after the sliding duration, and the resting body's has grown for that
    time; for all other scenes they are the flash temperatures as they are.

    Parameters
    ----------
    scene : Scene
        What was computed.
    sample : Sample
        The level, its stress spectra included.
    """
    if scene.sliding.heat_partition != "total":
        return sample
    steady = sample.spectrum / sample.wavenumber
    heated = _heating(scene, sample.wavenumber)
    rate = sample.numbers["resting_flash_temperature"] / steady.sum(axis=1, keepdims=True)  # μv/κσ₀, also at rest
    grown = steady @ heated.growth.T + heated.resting
    numbers = {
        "resting_flash_temperature": rate * grown,
        "flash_temperature": sample.numbers["flash_temperature"] + rate * heated.moving,
    }
    return sample._replace(numbers=sample.numbers | numbers)


__all__ = [
    "area_fractions",
    "balanced",
    "conduction",
    "correlation",
    "heat_partition",
    "mode_sums",
    "over_speed",
    "predictions",
    "size_errors",
    "smoothed_spectrum",
    "stress_spectrum",
    "theoretical_partition",
    "yield_wavenumber",
]
