"""Conductivity and diffusivity of the two bodies at each speed, how they share the heat, and arguments of the theory.

Where a conductivity is a table over temperature, one constant replaces it at each speed. It comes from the theory over
the whole spectrum. So it is known before a run, and it is the same for theory and simulation: it does not disturb their
ratio.
"""

from collections.abc import Iterator
from functools import lru_cache
from math import inf, nan
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

import theory
from roughsim.grid import Array
from roughsim.heat.statistics import effective_temperature
from roughsim.scene import Scene, SceneError
from roughsim.scene.model import Conduction


def load_arguments(scene: Scene) -> dict[str, float]:
    """Return E* and σ₀ as arguments of the theory."""
    return {"effective_modulus": scene.effective_modulus, "nominal_pressure": scene.sliding.nominal_pressure}


def pressure_arguments(scene: Scene) -> dict[str, float]:
    """Return E*, σ₀ and σ_P as arguments of the theory."""
    return load_arguments(scene) | {"penetration_hardness": scene.penetration_hardness}


def stress_arguments(scene: Scene) -> dict[str, Any]:
    """Return E*, σ₀ and γ as arguments of the theory."""
    return load_arguments(scene) | {"gamma": scene.theory.gamma}


def heat_arguments(scene: Scene, bodies: Conduction) -> dict[str, float]:
    """Return μ, κ and D of the moving body as arguments of the theory."""
    return {
        "friction_coefficient": scene.sliding.friction_coefficient,
        "conductivity": bodies.conductivity,
        "diffusivity": bodies.diffusivity,
    }


@lru_cache(maxsize=64)
def smoothed_spectrum(scene: Scene) -> Any:
    """Return C_sm of a capped scene (Eq. 27), or C(q) itself of an elastic one: a callable with `breaks`."""
    if scene.elastic:
        return scene.spectrum
    return theory.plasticity.smoothed_spectrum(scene.spectrum, **pressure_arguments(scene))


class Conductions(NamedTuple):
    """κ, W/(m K), and D, m²/s, of both bodies as arrays (speeds,); those of an insulating counterface hold NaN."""

    each: tuple[Conduction, ...]  # the same as a record for each speed
    conductivity: Array
    diffusivity: Array
    counter_conductivity: Array
    counter_diffusivity: Array

    def groups(self) -> Iterator[tuple[list[int], Conduction]]:
        """Yield the indices of the speeds that share a conduction, and that conduction."""
        indices: dict[Conduction, list[int]] = {}
        for k, bodies in enumerate(self.each):
            indices.setdefault(bodies, []).append(k)
        return ((speeds, bodies) for bodies, speeds in indices.items())


def conduction(scene: Scene, speeds: ArrayLike | None = None) -> Conductions:
    """Return the constants κ and D of the bodies of a scene at each speed, the same for all columns.

    Where a κ is a table they are its values at T₀ + 0.75 s T_flash, with the share s of the scene and T_flash of the
    theory over the whole spectrum: both bodies are taken at the temperature of their contact.

    The speeds, m/s, ≥ 0, if None, are those of the scene. SceneError if the contact gets hotter than a table goes.
    """
    speed: list[float] = np.ravel(scene.speeds if speeds is None else speeds).tolist()
    if scene.temperature_range[1] == inf:
        each = (scene.conduction(),) * len(speed)
    else:
        each = tuple(scene.conduction(contact_temperature(scene, v)) for v in speed)
    return Conductions(each, *np.array(list(zip(*each, strict=True)), dtype=np.float64))  # None becomes NaN


@lru_cache(maxsize=1024)
def contact_temperature(scene: Scene, speed: float) -> float:
    """Return T₀ + 0.75 s T_flash, K, with the conductivities that both bodies have at that temperature."""
    high, spectrum = scene.temperature_range[1], smoothed_spectrum(scene)

    def rise(temperature: float) -> float:
        bodies = scene.conduction(min(temperature, high))
        arguments = stress_arguments(scene) | heat_arguments(scene, bodies)
        flash_temperature = theory.flash.flash_temperature(speed, spectrum, **arguments)
        share = share_of(scene, scene.sliding.heat_partition, np.array([speed]), spectrum, bodies)
        return float(share[0] * flash_temperature)

    result = effective_temperature(rise, background_temperature=scene.sliding.background_temperature or 0.0)
    if result > high:
        raise SceneError(
            f"sliding.speed = {speed:g} m/s heats the contact to T₀ + 0.75 T_flash = {result:.4g} K at constant "
            f"conductivity beyond {high:g} K, where the tables end; extend them or lower the speed"
        )
    return result


def heat_partition(
    scene: Scene, speeds: ArrayLike | None = None, *, rule: float | str | None = None, spectrum: Any = None
) -> Array:
    """Return the moving body's share of the heat at each speed, m/s: those of the scene if None.

    `rule` is a number, "all" (1), or the theory's "mean" or "total", NaN without a second body; None is that of the
    scene, with which temperatures are reported. `spectrum` stands for the whole C_sm if given.
    """
    speed = np.asarray(scene.speeds if speeds is None else speeds, np.float64)
    rule = scene.sliding.heat_partition if rule is None else rule
    spectrum = smoothed_spectrum(scene) if spectrum is None else spectrum
    result = np.empty(speed.shape)
    for indices, bodies in conduction(scene, speed).groups():
        result[indices] = share_of(scene, rule, speed[indices], spectrum, bodies)
    return result


def share_of(scene: Scene, rule: float | str, speed: Array, spectrum: Any, bodies: Conduction) -> Array:
    """Return the moving body's share by a rule of the scene at speeds (n,), m/s, that have one conduction."""
    if not isinstance(rule, str) or rule == "all":
        return np.full(speed.shape, 1.0 if rule == "all" else float(rule))
    if bodies.counter_conductivity is None:
        return np.full(speed.shape, nan)
    share = theory.partition.moving_share(
        speed,
        spectrum,
        **stress_arguments(scene),
        conductivity=bodies.conductivity,
        diffusivity=bodies.diffusivity,
        resting_conductivity=bodies.counter_conductivity,
        resting_diffusivity=bodies.counter_diffusivity,
        rule=rule,
        **({"duration": scene.sliding.duration} if rule == "total" else {}),
    )
    return np.asarray(share, dtype=np.float64)
