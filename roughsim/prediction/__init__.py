"""What the theory says of a scene: the one door to the package `theory`.

All temperatures here are with all the heat in the moving body; the share is a quantity of its own.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughsim.grid import Grid
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.observables.record import Sample
from roughsim.prediction.bodies import (
    conduction,
    heat_arguments,
    heat_partition,
    pressure_arguments,
    smoothed_spectrum,
    stress_arguments,
    theoretical_partition,
)
from roughsim.prediction.cut_offs import continuation, follows_theory, up_to, usual_exponent
from roughsim.prediction.views import Integrals, ModeSums, Theory, area_fractions, heating, over_speed

if TYPE_CHECKING:
    from roughsim.scene import Scene

Array = NDArray[np.float64]


@lru_cache(maxsize=64)
def yield_wavenumber(scene: Scene) -> float:
    """Return q_y, rad/m, where 1 % of the theory's contact is still elastic; infinite if C(q) ends before."""
    from theory import plasticity

    return plasticity.yield_wavenumber(scene.spectrum, **pressure_arguments(scene))


def predictions(scene: Scene) -> dict[str, Array]:
    """Return every observable over the whole spectrum, arrays over speed or of one entry; NaN without a theory."""
    return _seen(Integrals(scene))


def _seen(theory: Theory) -> dict[str, Array]:
    """Every observable in one view of the theory."""
    result = {}
    for name, observable in OBSERVABLES.items():
        missing = np.full(len(theory.scene.speeds) if observable.per_speed else 1, np.nan)
        result[name] = missing if observable.theory is None else np.atleast_1d(observable.theory(theory))
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


def hertz_like(scene: Scene) -> tuple[float, float, float]:
    """Return R, m, and vR/D of the fast Hertz contact with the theory's D_flash, and its T_flash in q̇₁R/κ."""
    from theory import hertz

    speed = max(scene.speeds)
    radius = float(over_speed(scene, np.array([speed]))["flash_width"][0]) / hertz.FAST.flash_width
    peclet = speed * radius / float(conduction(scene, [speed]).diffusivity[0])
    return radius, peclet, float(hertz.flash_temperature(peclet))


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
    return _seen(ModeSums(scene, spectrum, grid))


def balanced(scene: Scene, sample: Sample) -> Sample:
    """Return a level with the temperatures that the two bodies have in common if the heat is shared as the scene says.

    The resting body is measured with the conductivity of the moving one: its temperature is multiplied by κ/κ', NaN
    where it does not conduct. For "total" both include the background T₀ after the sliding duration, and the resting
    body's has grown for that time.

    Parameters
    ----------
    scene : Scene
        What was computed.
    sample : Sample
        The level, its stress spectra included.
    """
    resting, moving = sample.numbers["resting_flash_temperature"], sample.numbers["flash_temperature"]
    if scene.sliding.heat_partition == "total":
        steady = sample.spectrum / sample.wavenumber
        heated = heating(scene, sample.wavenumber)
        rate = resting / steady.sum(axis=1, keepdims=True)  # μv/κσ₀, also at rest
        resting = rate * (steady @ heated.growth.T + heated.resting)
        moving = moving + rate * heated.moving
    bodies = conduction(scene)
    resting = resting * (bodies.conductivity / bodies.counter_conductivity)
    common = {"resting_flash_temperature": resting, "flash_temperature": moving}
    return sample._replace(numbers=sample.numbers | common)


__all__ = [
    "Theory",
    "area_fractions",
    "balanced",
    "conduction",
    "continuation",
    "correlation",
    "follows_theory",
    "heat_partition",
    "mode_sums",
    "over_speed",
    "predictions",
    "smoothed_spectrum",
    "stress_spectrum",
    "theoretical_partition",
    "up_to",
    "usual_exponent",
    "yield_wavenumber",
]
