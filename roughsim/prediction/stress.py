"""Contact of a scene as the theory has it: its arguments, C_sm, and the stress in directions of sliding."""

from dataclasses import replace
from functools import lru_cache
from math import inf
from typing import Any

import numpy as np

import theory
from roughsim.grid import Array
from roughsim.prediction.lay import StressOfTheory
from roughsim.scene import Scene
from roughsim.scene.faces import steeper
from roughsim.surface.spectrum import Spectrum
from theory.lay import LayStress
from theory.lay_waves import Weighted
from theory.slope_frame import slope_frame
from theory.yielding import YieldingSpectrum


def modulus_of(scene: Scene) -> float:
    """Return E* of the isotropic contact in theory that a lay stretches, Pa: in proportion to the rms slope."""
    return scene.effective_modulus * steeper(scene.lay)


def load_arguments(scene: Scene) -> dict[str, float]:
    """Return E* and σ₀ as arguments of the theory."""
    return {
        "effective_modulus": modulus_of(scene),
        "nominal_pressure": scene.sliding.nominal_pressure,
    }


def pressure_arguments(scene: Scene) -> dict[str, float]:
    """Return E*, σ₀ and σ_P as arguments of the theory."""
    return load_arguments(scene) | {"penetration_hardness": scene.penetration_hardness}


def law_arguments(scene: Scene) -> dict[str, Any]:
    """Return E*, σ₀ and σ_P, None of elastic contact, as arguments of the calibrated law."""
    hardness = None if scene.elastic else scene.penetration_hardness
    modulus = {"effective_modulus": scene.effective_modulus}  # the law finds what a lay makes of it
    return load_arguments(scene) | modulus | {"penetration_hardness": hardness}


@lru_cache(maxsize=64)  # .01 s: the same in a run and in its comparison
def law_of(spectrum: Spectrum, **arguments: float | None) -> YieldingSpectrum:
    """Return |σ_q|² by the calibrated law, with arguments as of `law_arguments`; ValueError outside its range."""
    law: YieldingSpectrum = theory.clipped.law_of(spectrum, **arguments)
    return law


def stress_arguments(scene: Scene) -> dict[str, Any]:
    """Return E*, σ₀ and γ as arguments of the theory."""
    return load_arguments(scene) | {"gamma": scene.theory.gamma}


@lru_cache(maxsize=64)  # .01 s for each number of the theory of contact that yields
def smoothed_spectrum(scene: Scene) -> Spectrum:
    """Return C_sm of a capped scene (Eq. 27), or C(q) itself of an elastic one: a callable with `breaks`."""
    if scene.elastic:
        return scene.spectrum
    smoothed: Spectrum = theory.plasticity.smoothed_spectrum(
        scene.spectrum, **pressure_arguments(scene)
    )
    return smoothed


def in_directions_of(scene: Scene, stress: Any = None) -> bool:
    """Return whether the theory of a scene, or its `stress` by a law, differs between directions of sliding."""
    return isinstance(stress, LayStress) or (
        bool(scene.directions) and (stress is None or scene.lay > 1.0)
    )


def headings_of_fields(scene: Scene) -> tuple[float, ...]:
    """Return the direction of each speed of a scene in fields, radians from x; of isotropic faces one for all."""
    return scene.headings or (scene.sliding.direction or (0.0,))[:1] * len(scene.speeds)


def headings_at(scene: Scene, speeds: Array) -> Array:
    """Return the direction at each speed, m/s, radians from the grooves: at speeds other than its own the first one."""
    own = np.array(scene.headings)
    return own if own.size == speeds.size else np.full(speeds.shape, own[0])


def stress_of_lay(scene: Scene, spectrum: Spectrum | None, stress_spectrum: Any = None) -> Weighted:
    """Return the stress of faces with a lay by the theory, of all C_sm or of a `spectrum`, or by a law.

    Of scans up to the end of that spectrum, in the frame of their slopes.
    """
    if isinstance(stress_spectrum, LayStress):
        return stress_spectrum
    if stress_spectrum is not None:
        return LayStress(stress_spectrum, scene.lay, scene.effective_modulus)
    if scene.lay > 1.0:
        whole = smoothed_spectrum(scene) if spectrum is None else spectrum
        return StressOfTheory.of(scene.lay, whole, **stress_arguments(scene))
    end = inf if spectrum is None else spectrum.breaks[-1]
    return _stress_of_scan(scene, end)


@lru_cache(maxsize=64)  # .05 s for each quantity at each cut-off
def _stress_of_scan(scene: Scene, end: float) -> StressOfTheory:
    """Return the stress of scans in their directions by the theory, up to a wavenumber, rad/m."""
    whole: Any = scene.spectrum
    frame = slope_frame(whole if end >= whole.breaks[-1] else whole.truncated(q_max=end))
    spectrum: Spectrum = frame.spectrum
    modulus = {"effective_modulus": scene.effective_modulus * steeper(frame.lay)}
    if not scene.elastic:
        spectrum = theory.plasticity.smoothed_spectrum(
            spectrum, **pressure_arguments(scene) | modulus
        )
    stress = StressOfTheory.of(frame.lay, spectrum, **stress_arguments(scene) | modulus)
    return replace(stress, directions=frame.directions, angle=frame.angle)
