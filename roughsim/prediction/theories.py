"""Theory of a scene integrated over C(q): every observable by the paper's weight and by the calibrated law.

All temperatures are with all the heat in the moving body; the heat share is an observable of its own.
"""

from collections.abc import Callable
from functools import lru_cache
from math import inf, nan
from typing import Any

import numpy as np

import theory
from roughsim.grid import Array
from roughsim.observables.record import TheoryOfScene
from roughsim.prediction.areas import area_fractions
from roughsim.prediction.bodies import groups, heat_partition
from roughsim.prediction.camera import seen_in
from roughsim.prediction.law import calibrated
from roughsim.prediction.lay import in_directions
from roughsim.prediction.shares import heat_arguments
from roughsim.prediction.stress import (
    headings_at,
    in_directions_of,
    modulus_of,
    smoothed_spectrum,
    stress_arguments,
    stress_of_lay,
)
from roughsim.prediction.values import NOTHING, Predicted
from roughsim.scene import Scene
from roughsim.surface.spectrum import Spectrum, TruncatedSpectrum
from theory.lay import LayStress
from theory.yielding import YieldingSpectrum

OVER_SPEED = (
    "flash_temperature",
    "flash_gradient",
    "flash_laplacian",
    "flash_width",
    "slope_length",
)


@lru_cache(
    maxsize=1024
)  # .02 s for each row of a comparison, and for each point of a study in each of its tables
def predictions(scene: Scene, q_max: float = inf) -> Predicted:
    """Return every observable over C(q), or over its part up to q_max, rad/m; NaN where there is no theory.

    The arrays over speed, or of one entry, are read-only. Temperatures are with all the heat in the moving body.
    """
    return Predicted(integrals(scene, q_max), scene)


def integrals(scene: Scene, q_max: float = inf) -> TheoryOfScene:
    """Return the theory over the whole spectrum, or up to `q_max`, rad/m."""
    whole = smoothed_spectrum(scene)
    spectrum = TruncatedSpectrum(whole, q_max) if q_max < inf else whole
    rule = "total" if scene.sliding.heat_partition == "total" else "mean"
    temperatures = over_speed(scene, np.array(scene.speeds), spectrum)
    share = heat_partition(scene, rule=rule, spectrum=spectrum)
    values = {**temperatures, "heat_partition": share, **area_fractions(scene, q_max)}
    return _integrated(scene, values, {"spectrum": spectrum, **stress_arguments(scene)})


def _integrated(scene: Scene, values: dict[str, Any], stress: dict[str, Any]) -> TheoryOfScene:
    """Return a theory of these values, with radius and integrals of the stress spectrum that `stress` describes."""

    def total(weight: Callable[[Array], Array]) -> float:  # 2π ∫ q |σ_q|² weight(q) dq, Eq. (2)
        density = theory.persson.stress_density(**stress)
        return float(density.weighted() @ weight(density.wavenumber()))

    pressed = {"nominal_pressure": scene.sliding.nominal_pressure}
    return TheoryOfScene(
        values,
        scene.sliding.nominal_pressure,
        correlation_radius=lambda fraction: (
            nan if scene.lay > 1.0 else float(theory.persson.correlation_radius(fraction, **stress))
        ),
        total=total,
        seen=lambda name: seen_in(scene, name, pressed | stress),
    )


def hot_spot_radius(scene: Scene) -> float:
    """Return r at which g_σ(r) = g_σ(0)/2 in theory, m; of faces with a lay of circles with the area of hot spots."""
    if scene.lay == 1.0:
        return float(predictions(scene)["correlation_radius_50"][0])
    stress = {"spectrum": smoothed_spectrum(scene), **stress_arguments(scene)}
    return float(theory.persson.correlation_radius(0.5, **stress))


def over_speed(
    scene: Scene,
    speeds: Array,
    spectrum: Spectrum | None = None,
    *,
    stress_spectrum: YieldingSpectrum | LayStress | None = None,
    names: tuple[str, ...] = OVER_SPEED,
) -> dict[str, Array]:
    """Return T_flash, T′, ∇²T, D_flash and d_flash at any speeds, m/s, with all heat in the moving body.

    They belong to the whole spectrum, to a `spectrum` C(q), or to a `stress_spectrum` |σ_q|². Of faces with a lay, and
    of scans, they are in the directions of the scene at its own speeds, else in the first direction; by a |σ_q|²
    without directions they are alike in all directions of a scan.
    """
    if in_directions_of(scene, stress_spectrum):
        return _in_directions(scene, speeds, spectrum, stress_spectrum, names)
    if stress_spectrum is not None:
        stress = {
            "stress_spectrum": stress_spectrum,
            "nominal_pressure": scene.sliding.nominal_pressure,
        }
    else:
        stress = {
            "spectrum": smoothed_spectrum(scene) if spectrum is None else spectrum
        } | stress_arguments(scene)
    result = {name: np.empty(speeds.shape) for name in names}
    for indices, constants in groups(scene, speeds):
        for name, values in result.items():
            formula = getattr(theory.flash, name)
            heat = heat_arguments(*constants)
            values[indices] = formula(speeds[indices], **stress, **heat)
    return result


def _in_directions(
    scene: Scene,
    speeds: Array,
    spectrum: Spectrum | None,
    stress_spectrum: YieldingSpectrum | LayStress | None,
    names: tuple[str, ...],
) -> dict[str, Array]:
    """Return `over_speed` of faces with a lay."""
    stress, at = stress_of_lay(scene, spectrum, stress_spectrum), headings_at(scene, speeds)
    result = {name: np.empty(speeds.shape) for name in names}
    for indices, constants in groups(scene, speeds):
        heat = heat_arguments(*constants)
        heat |= {"nominal_pressure": scene.sliding.nominal_pressure}
        found = in_directions(names, speeds[indices], at[indices], stress, **heat)
        for name, values in found.items():
            result[name][indices] = values
    return result


def correlation(scene: Scene, distance: Array) -> Array:
    """Return g_σ(r) over the whole spectrum, Pa², at distances in m. Eq. (2)"""
    if scene.lay > 1.0:
        return np.full(distance.shape, nan)  # there are two curves
    values: Array = theory.persson.pressure_correlation(
        distance, smoothed_spectrum(scene), **stress_arguments(scene)
    )
    return values


def stress_spectrum(scene: Scene, q: Array) -> Array:
    """Return |σ_q|² = (E* q/2)² C(q) W(q), Pa² m², at wavenumbers in rad/m, so that g_σ(0) = 2π ∫ q |σ_q|² dq. Eq. (2)

    C is C_sm where there is a hardness.
    """
    spectrum = smoothed_spectrum(scene)
    density: Array = (0.5 * modulus_of(scene) * q) ** 2 * spectrum(q)
    weight: Array = theory.persson.stress_weight(q, spectrum, **stress_arguments(scene))
    return density * weight


def calibrated_predictions(scene: Scene) -> Predicted:
    """Return every observable by the calibrated law, as `predictions`; NaN where the law does not hold.

    Quantiles of the temperature have an estimate of their own (`roughsim.estimate.fields`).
    """
    return Predicted(calibrated_integrals(scene), scene, calibrated(scene).observables)


def calibrated_integrals(scene: Scene) -> TheoryOfScene:
    """Return the calibrated law as a theory over the whole spectrum; NaN where the law does not hold."""
    law = calibrated(scene).stress_spectrum
    if law is None:
        return NOTHING
    areas = {name: getattr(law, name, nan) for name in ("contact_fraction", "plastic_fraction")}
    temperatures = calibrated_over_speed(scene, np.array(scene.speeds))
    rule = "total" if scene.sliding.heat_partition == "total" else "mean"
    share = heat_partition(scene, rule=rule, stress=calibrated(scene).stress or law)
    values = {**temperatures, "heat_partition": share, **areas}
    return _integrated(scene, values, {"stress_spectrum": law})


def calibrated_share(scene: Scene, speeds: Array | None = None) -> Array:
    """Return the moving body's share of the heat in temperatures by the calibrated law; NaN where it is not known.

    The rule of the scene is applied to the temperatures of both bodies by the law itself. Speeds as `heat_partition`.
    """
    law, rule = calibrated(scene), scene.sliding.heat_partition
    share = heat_partition(scene, speeds, stress=law.stress or law.stress_spectrum)
    return (
        np.full(share.shape, nan)
        if law.stress_spectrum is None and rule in ("mean", "total")
        else share
    )


def calibrated_correlation(scene: Scene, distance: Array) -> Array:
    """Return g_σ(r) by the calibrated law, Pa², at distances in m; NaN where the law does not hold."""
    law = calibrated(scene).stress_spectrum
    nothing = np.full(distance.shape, nan)
    return (
        nothing
        if law is None or scene.directions
        else theory.persson.pressure_correlation(distance, stress_spectrum=law)
    )


def calibrated_over_speed(scene: Scene, speeds: Array) -> dict[str, Array]:
    """Return `over_speed` by the calibrated law at any speeds, m/s; NaN where the law does not hold."""
    law = calibrated(scene)
    names = tuple(name for name in OVER_SPEED if name in law.observables)
    nothing = {name: np.full(speeds.shape, nan) for name in OVER_SPEED}
    stress = law.stress or law.stress_spectrum
    return nothing | over_speed(scene, speeds, stress_spectrum=stress, names=names)
