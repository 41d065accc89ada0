"""The theory of a scene: the only place that calls the package `theory`.

All temperatures here are with all the heat in the moving body; the heat share is an observable of its own. The theory
is integrated over C(q), over all of it or up to a cut-off, or it is summed over the modes of a cell. Both give the same
record (`Theory`), from which an observable takes its value.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from math import inf, nan, pi
from typing import Any

import numpy as np
import scipy

import theory
from roughsim.grid import Array, Grid, modes_where
from roughsim.observables.record import Sample, Theory
from roughsim.observables.stress_spectrum import StressSpectrum
from roughsim.prediction.areas import REMEMBERED as REMEMBERED
from roughsim.prediction.areas import area_fractions as area_fractions
from roughsim.prediction.areas import computed as computed
from roughsim.prediction.areas import yield_wavenumber as yield_wavenumber
from roughsim.prediction.areas import yielded_share as yielded_share
from roughsim.prediction.bodies import background as background
from roughsim.prediction.bodies import conduction as conduction
from roughsim.prediction.bodies import friction_coefficient as friction_coefficient
from roughsim.prediction.bodies import groups, heat_arguments, load_arguments, pressure_arguments, stress_arguments
from roughsim.prediction.bodies import heat_partition as heat_partition
from roughsim.prediction.bodies import heat_per_pressure as heat_per_pressure
from roughsim.prediction.bodies import smoothed_spectrum as smoothed_spectrum
from roughsim.prediction.law import calibrated as calibrated
from roughsim.prediction.sliding import sliding_prediction as sliding_prediction
from roughsim.prediction.values import NOTHING, Predicted
from roughsim.scene import Scene
from roughsim.surface.modes import mean_over_cells, mode_variance
from roughsim.surface.spectrum import TruncatedSpectrum

OVER_SPEED = ("flash_temperature", "flash_gradient", "flash_laplacian", "flash_width", "slope_length")
_NEAR = 16.0  # mode spacings above q_min up to which W is averaged over Fourier cells
# share of the theory's contact that has yielded at a cut-off: from the first value on, T_flash falls with the cut-off.
# Below it T_flash follows the theory if up to q_max at most the second is added (measured on rocks of 1 to 30 GPa)
_YIELDED, _ADDED = 0.99, 0.1
# T_flash of yielded contact falls as q_c^−(0.3 + 1.05 H) between slow and fast sliding; from H = 2/3 on the exponent 1
# fits as well, and extrapolates less
_FALL = (0.3, 1.05)
_SLOW = 1e-12  # m/s: T_flash of so slow bodies is proportional to their speed
_STEP = 0.1  # of the law for contact that yields: coarser ones move T_flash by .3 % from one cut-off to the next


@lru_cache(maxsize=REMEMBERED)
def predictions(scene: Scene, q_max: float = inf) -> Predicted:
    """Return every observable over C(q), or over its part up to q_max, rad/m; NaN where there is no theory.

    The arrays over speed, or of one entry, are read-only. Temperatures are with all the heat in the moving body.
    """
    return Predicted(integrals(scene, q_max), scene)


def mode_sums(scene: Scene, spectrum: Any, grid: Grid) -> Predicted:
    """Return every observable by the theory summed over the modes of a grid, those that a simulation has.

    `spectrum` is the one that the surfaces are drawn from, up to their q_c.
    """
    return Predicted(summed_over_modes(scene, spectrum, grid), scene)


def integrals(scene: Scene, q_max: float = inf) -> Theory:
    """Return the theory over the whole spectrum, or up to `q_max`, rad/m."""
    whole = smoothed_spectrum(scene)
    spectrum = TruncatedSpectrum(whole, q_max) if q_max < inf else whole
    rule = "total" if scene.sliding.heat_partition == "total" else "mean"
    temperatures = over_speed(scene, np.array(scene.speeds), spectrum)
    share = heat_partition(scene, rule=rule, spectrum=spectrum)
    values = {**temperatures, "heat_partition": share, **area_fractions(scene, q_max)}
    return integrated(scene, values, {"spectrum": spectrum, **stress_arguments(scene)})


def integrated(scene: Scene, values: dict[str, Any], stress: dict[str, Any]) -> Theory:
    """Return a theory of these values, with radius and integrals of the stress spectrum that `stress` describes."""

    def total(weight: Callable[[Array], Array]) -> float:  # 2π ∫ q |σ_q|² weight(q) dq, Eq. (2)
        density = theory.persson.stress_density(**stress)
        return float(density.weighted() @ weight(density.wavenumber()))

    return Theory(
        values,
        scene.sliding.nominal_pressure,
        correlation_radius=lambda fraction: float(theory.persson.correlation_radius(fraction, **stress)),
        total=total,
    )


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
    for indices, constants in groups(scene, speeds):
        for name, values in result.items():
            formula = getattr(theory.flash, name)
            values[indices] = formula(speeds[indices], **stress, **heat_arguments(*constants))
    return result


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


@lru_cache(maxsize=REMEMBERED)
def calibrated_predictions(scene: Scene) -> Predicted:
    """Return every observable by the calibrated law, as `predictions`; NaN where the law does not hold."""
    return Predicted(calibrated_integrals(scene), scene, calibrated(scene).observables)


def calibrated_integrals(scene: Scene) -> Theory:
    """Return the calibrated law as a theory over the whole spectrum; NaN where the law does not hold."""
    law = calibrated(scene).stress_spectrum
    if law is None:
        return NOTHING
    areas = {name: getattr(law, name, nan) for name in ("contact_fraction", "plastic_fraction")}
    temperatures = calibrated_over_speed(scene, np.array(scene.speeds))
    return integrated(scene, {**temperatures, **areas}, {"stress_spectrum": law})


def calibrated_correlation(scene: Scene, distance: Array) -> Array:
    """Return g_σ(r) by the calibrated law, Pa², at distances in m; NaN where the law does not hold."""
    law = calibrated(scene).stress_spectrum
    nothing = np.full(distance.shape, nan)
    return nothing if law is None else theory.persson.pressure_correlation(distance, stress_spectrum=law)


def calibrated_over_speed(scene: Scene, speeds: Array) -> dict[str, Array]:
    """Return `over_speed` by the calibrated law at any speeds, m/s; NaN where the law does not hold."""
    law = calibrated(scene)
    names = tuple(name for name in OVER_SPEED if name in law.observables)
    nothing = {name: np.full(speeds.shape, nan) for name in OVER_SPEED}
    return nothing | over_speed(scene, speeds, stress_spectrum=law.stress_spectrum, names=names)


# How a run is extrapolated from its cut-offs to q_max. T_flash of contact that does not yield goes on rising with the
# cut-off in the shape of the theory: the ratio of its steps to those of the theory changes slowly. T_flash of contact
# that has yielded falls with the cut-off, and the theory does not describe that. In between neither rule is known.


def continuation(scene: Scene, column: str, cut_offs: tuple[float, ...], observable: str) -> Array | None:
    """Return an observable of the theory up to each cut-off and over all of C(q), shape (cut-offs + 1, speeds).

    `cut_offs` are those of the levels of the column, rad/m, ascending. All NaN where it is not known whether the column
    follows the theory; None where it falls as a power of the cut-off.
    """
    follows = follows_theory(scene, column, cut_offs[-1])
    if follows is False:
        return None
    theories = *(predictions(scene, q) for q in cut_offs), predictions(scene)
    values = np.stack([theory[observable] for theory in theories])
    return values if follows else np.full_like(values, nan)


@lru_cache(maxsize=REMEMBERED)
def follows_theory(scene: Scene, column: str, q_max: float) -> bool | None:
    """Return whether a column follows the theory from the cut-off q_max, rad/m, to the end of the spectrum.

    False where it falls as a power of the cut-off, None where it is not known.
    """
    if column != "capped":
        return True
    now, at_the_end = yielded_share(scene, q_max), yielded_share(scene)
    if now >= _YIELDED:
        return False
    return True if at_the_end - now <= _ADDED else None


def yielded_fall(scene: Scene, cut_offs: tuple[float, ...]) -> Array | None:
    """Return T_flash, K, by the law for contact that yields up to each cut-off, rad/m, and over all of C(q).

    Its shape is (cut-offs + 1, speeds), with all heat in the moving body; None outside the range of the law.
    """
    name, speeds, rows = "flash_temperature", np.array(scene.speeds), []
    try:
        for q_max in (*cut_offs, inf):
            law = _yielded_law(scene.spectrum, q_max, **pressure_arguments(scene))
            if law is None:
                return None
            rows.append(over_speed(scene, speeds, stress_spectrum=law, names=(name,))[name])
    except theory.quadrature.QuadratureError:
        return None
    return np.stack(rows)


@lru_cache(maxsize=64)  # .04 s each: the same for both bodies, and in each round
def _yielded_law(spectrum: Any, q_max: float, **pressures: float) -> Any:
    """Return |σ_q|² by the law for contact that yields up to one cut-off, rad/m; None outside its range."""
    try:
        cut = TruncatedSpectrum(spectrum, q_max) if q_max < inf else spectrum
        return theory.plasticity.stress_spectrum(cut, **pressures, step=_STEP)
    except (ValueError, theory.quadrature.QuadratureError):
        return None


def usual_exponent(scene: Scene, q_c: float) -> float:
    """Return the usual exponent of the fall of T_flash beyond a cut-off, rad/m, for yielded contact of the H there."""
    end = scene.spectrum.breaks[-1]
    if q_c >= end * (1 - 1e-9):  # the cut-off of a map and the end of its C(q) differ by rounding
        return 1.0
    q = np.array([q_c, min(end, 16.0 * q_c)])
    first, last = np.log(q), np.log(scene.spectrum(q))
    hurst = -0.5 * float((last[1] - last[0]) / (first[1] - first[0])) - 1.0
    return min(1.0, _FALL[0] + _FALL[1] * min(max(hurst, 0.0), 1.0))


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
    rate = friction_coefficient(scene) * speeds / (bodies.conductivity * sliding.nominal_pressure)
    with np.errstate(divide="ignore"):
        slope_length = temperature / np.abs(gradient)
    flash = rate * temperature, rate * gradient, rate * laplacian, np.sqrt(-temperature / laplacian), slope_length
    share = np.full(speeds.shape, nan)
    if scene.counterface_conducts:  # the balance of the two bodies, both as κT σ₀/μv of the moving one
        growth, moving_background, resting_background = heat_history(scene, q)
        resting = growth @ (stress / q) + resting_background
        resting *= bodies.conductivity / bodies.counter_conductivity
        share = resting / (resting + temperature + moving_background)
    area = float(theory.persson.contact_probability(float(spectrum.breaks[-1]), spectrum, **load_arguments(scene)))
    temperatures = dict(zip(OVER_SPEED, flash, strict=True))
    return Theory(
        {**temperatures, "heat_partition": share, **area_fractions(scene), "contact_fraction": area},
        sliding.nominal_pressure,
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
    """Return the terms by which the time of sliding enters the heat balance at each speed; q (modes,) in rad/m.

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
    return scipy.special.erf(q * np.sqrt(bodies.counter_diffusivity * time)[:, None]), moving, resting


def balanced(scene: Scene, sample: Sample) -> Sample:
    """Return a level with the flash temperatures of both bodies that the rule of the scene makes equal.

    The resting body is measured with the conductivity of the moving one: its temperature is multiplied by κ/κ', NaN
    where it does not conduct. For "total" it has grown for the sliding duration, and `backgrounds` come on top. The
    sample needs its stress spectra then.
    """
    resting = sample.numbers["resting_flash_temperature"]
    if scene.sliding.heat_partition == "total":
        steady = sample.spectrum / sample.wavenumber
        growth = heat_history(scene, sample.wavenumber)[0]
        resting = resting / steady.sum(axis=1, keepdims=True) * (steady @ growth.T)
    bodies = conduction(scene)
    resting = resting * (bodies.conductivity / bodies.counter_conductivity)
    return replace(sample, numbers=sample.numbers | {"resting_flash_temperature": resting})


def backgrounds(scene: Scene, sample: Sample) -> tuple[Array, Array]:
    """Return the mean temperatures T₀ of the moving and of the resting body, each with all the heat, K, (speeds,).

    They are of the sliding duration under the rule "total", else zero. The sample is any of the scene.
    """
    if scene.sliding.heat_partition != "total":
        return np.zeros(len(scene.speeds)), np.zeros(len(scene.speeds))
    _, moving, resting = heat_history(scene, sample.wavenumber)
    steady = (sample.spectrum[0] / sample.wavenumber).sum()
    rate = sample.numbers["resting_flash_temperature"][0] / steady  # μv/κσ₀, also at rest
    bodies = conduction(scene)
    return rate * moving, rate * resting * (bodies.conductivity / bodies.counter_conductivity)


def slow(scene: Scene) -> Scene:
    """Return a scene whose speeds are slow, one for each of its own: T_flash grows in proportion to them."""
    speeds = tuple(_SLOW * (1 + k) for k in range(len(scene.speeds)))
    return replace(scene, sliding=replace(scene.sliding, speed=speeds))


def in_motion(scene: Scene) -> Scene:
    """Return a scene that slides slowly where it is at rest: the theory tells nothing of a ratio of zeros."""
    speeds = tuple(speed or _SLOW for speed in scene.speeds)
    return replace(scene, sliding=replace(scene.sliding, speed=speeds))
