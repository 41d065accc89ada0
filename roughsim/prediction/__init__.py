"""What the theory says of a scene: the one door to the package `theory`.

All temperatures here are with all the heat in the moving body; the share is a quantity of its own.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

import theory
from roughsim.grid import Grid
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.observables.record import Sample
from roughsim.prediction.bodies import conduction as conduction
from roughsim.prediction.bodies import heat_partition as heat_partition
from roughsim.prediction.bodies import pressure_arguments, stress_arguments
from roughsim.prediction.bodies import smoothed_spectrum as smoothed_spectrum
from roughsim.prediction.cut_offs import continuation as continuation
from roughsim.prediction.cut_offs import follows_theory as follows_theory
from roughsim.prediction.cut_offs import predictions as predictions
from roughsim.prediction.cut_offs import usual_exponent as usual_exponent
from roughsim.prediction.integrals import area_fractions as area_fractions
from roughsim.prediction.integrals import heat_history, summed_over_modes
from roughsim.prediction.integrals import over_speed as over_speed
from roughsim.scene import Scene

Array = NDArray[np.float64]


@lru_cache(maxsize=64)
def yield_wavenumber(scene: Scene) -> float:
    """Return q_y, rad/m, where 1 % of the theory's contact is still elastic; infinite if C(q) ends before."""
    return float(theory.plasticity.yield_wavenumber(scene.spectrum, **pressure_arguments(scene)))


def correlation(scene: Scene, distance: Array) -> Any:
    """Return g_σ(r) over the whole spectrum, Pa², at distances in m. Eq. (2)"""
    return theory.persson.pressure_correlation(distance, smoothed_spectrum(scene), **stress_arguments(scene))


def stress_spectrum(scene: Scene, q: Array) -> Array:
    """Return |σ_q|² = (E* q/2)² C(q) W(q), Pa² m², at wavenumbers in rad/m, so that g_σ(0) = 2π ∫ q |σ_q|² dq. Eq. (2)

    C is C_sm where there is a hardness.
    """
    spectrum = smoothed_spectrum(scene)
    density: Array = (0.5 * scene.effective_modulus * q) ** 2 * spectrum(q)
    weight: Array = theory.persson.stress_weight(q, spectrum, **stress_arguments(scene))
    return density * weight


def mode_sums(scene: Scene, spectrum: Any, grid: Grid) -> dict[str, Array]:
    """Return every observable summed over the modes of a grid instead of integrated: what a simulation can see.

    `spectrum` is the one that the surfaces are drawn from, up to their q_c.
    """
    view = summed_over_modes(scene, spectrum, grid)
    return {name: record.of_theory(view, len(scene.speeds)) for name, record in OBSERVABLES.items()}


def calibrated(scene: Scene) -> tuple[dict[str, Array], float]:
    """Return T_flash, T′, D_flash, d_flash and g_σ(0) by the calibrated stress spectrum, and their relative error band.

    ValueError if the scene lies outside what is calibrated: elastic contact within a range of loads and C(q).
    """
    from theory.calibrated import ERROR_BAND

    load, modulus = scene.sliding.nominal_pressure, scene.effective_modulus
    spectrum = theory.persson.calibrated_spectrum(scene.spectrum, effective_modulus=modulus, nominal_pressure=load)
    names = ("flash_temperature", "flash_gradient", "flash_width", "slope_length")
    result = over_speed(scene, np.array(scene.speeds), stress_spectrum=spectrum, names=names)
    variance = float(theory.persson.pressure_correlation(0.0, stress_spectrum=spectrum))
    return result | {"pressure_variance": np.array([variance])}, ERROR_BAND


def hertz_like(scene: Scene) -> tuple[float, float, float]:
    """Return R, m, and vR/D of the fast Hertz contact with the theory's D_flash, and its T_flash in q̇₁R/κ."""
    speed = max(scene.speeds)
    width = float(over_speed(scene, np.array([speed]), names=("flash_width",))["flash_width"][0])
    radius = width / theory.hertz.FAST.flash_width
    peclet = speed * radius / float(conduction(scene, [speed]).diffusivity[0])
    return radius, peclet, float(theory.hertz.flash_temperature(peclet))


def balanced(scene: Scene, sample: Sample) -> Sample:
    """Return a level with the temperatures that the two bodies have in common if the heat is shared as the scene says.

    The resting body is measured with the conductivity of the moving one: its temperature is multiplied by κ/κ', NaN
    where it does not conduct. For "total" both include the background T₀ after the sliding duration, and the resting
    body's has grown for that time. The sample needs its stress spectra.
    """
    resting, moving = sample.numbers["resting_flash_temperature"], sample.numbers["flash_temperature"]
    if scene.sliding.heat_partition == "total":
        steady = sample.spectrum / sample.wavenumber
        growth, moving_background, resting_background = heat_history(scene, sample.wavenumber)
        rate = resting / steady.sum(axis=1, keepdims=True)  # μv/κσ₀, also at rest
        resting = rate * (steady @ growth.T + resting_background)
        moving = moving + rate * moving_background
    bodies = conduction(scene)
    resting = resting * (bodies.conductivity / bodies.counter_conductivity)
    common = {"resting_flash_temperature": resting, "flash_temperature": moving}
    return sample._replace(numbers=sample.numbers | common)
