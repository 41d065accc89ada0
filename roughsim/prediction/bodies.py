"""What the bodies of a scene conduct with, and how they share the heat, at each speed.

Where a conductivity is a table over temperature, one constant stands for it at each speed. It comes from the theory
over the whole spectrum alone, so that it is known before a run and is the same for theory and simulation: ratios of the
two are as clean as with a number.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import lru_cache
from math import isinf, nan
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughsim.heat import effective_temperature

if TYPE_CHECKING:
    from roughsim.scene import Scene
    from roughsim.scene.model import Conduction

Array = NDArray[np.float64]


def smoothed_spectrum(scene: Scene) -> Any:
    """Return C_sm of a capped scene (Eq. 27), or C(q) itself of an elastic one: a callable with `breaks`."""
    from theory import plasticity

    return (
        scene.spectrum if scene.elastic else plasticity.smoothed_spectrum(scene.spectrum, **pressure_arguments(scene))
    )


def pressure_arguments(scene: Scene) -> dict[str, float]:
    """Return E*, σ₀ and σ_P as arguments of the theory."""
    return {
        "effective_modulus": scene.effective_modulus,
        "nominal_pressure": scene.sliding.nominal_pressure,
        "penetration_hardness": scene.penetration_hardness,
    }


def stress_arguments(scene: Scene) -> dict[str, Any]:
    """Return E*, σ₀ and γ as arguments of the theory."""
    return {
        "effective_modulus": scene.effective_modulus,
        "nominal_pressure": scene.sliding.nominal_pressure,
        "gamma": scene.theory.gamma,
    }


class Conductions(NamedTuple):
    """κ, W/(m K), and D, m²/s, of both bodies, `each` with one entry per speed; NaN for an insulating counterface."""

    each: tuple[Conduction, ...]

    @property
    def conductivity(self) -> Array:
        """κ of the moving body, (speeds,)."""
        return np.array([bodies.conductivity for bodies in self.each])

    @property
    def diffusivity(self) -> Array:
        """D of the moving body, (speeds,)."""
        return np.array([bodies.diffusivity for bodies in self.each])

    @property
    def counter_conductivity(self) -> Array:
        """κ of the counterface, (speeds,)."""
        return np.array([bodies.counter_conductivity for bodies in self.each], np.float64)

    @property
    def counter_diffusivity(self) -> Array:
        """D of the counterface, (speeds,)."""
        return np.array([bodies.counter_diffusivity for bodies in self.each], np.float64)

    def groups(self) -> Iterator[tuple[list[int], Conduction]]:
        """Yield the places of the speeds that go with one and the same conduction, and that."""
        places: dict[Conduction, list[int]] = {}
        for k, bodies in enumerate(self.each):
            places.setdefault(bodies, []).append(k)
        return ((place, bodies) for bodies, place in places.items())


def conduction(scene: Scene, speeds: ArrayLike | None = None) -> Conductions:
    """Return the constants κ and D that stand for the bodies of a scene at each speed, the same for all columns.

    Where a κ is a table they are its values at T₀ + 0.75 s T_flash, with the share s of the scene and T_flash of the
    theory over the whole spectrum: both bodies are taken at the temperature of their contact.

    Parameters
    ----------
    scene : Scene
        What is computed.
    speeds : array_like, optional
        m/s, ≥ 0; left out: those of the scene.

    Raises
    ------
    SceneError
        If the contact gets hotter than a table goes.
    """
    wanted = scene.speeds if speeds is None else tuple(np.asarray(speeds, np.float64).ravel().tolist())
    return _conduction(scene, wanted)


@lru_cache(maxsize=64)
def _conduction(scene: Scene, speeds: tuple[float, ...]) -> Conductions:
    if isinf(scene.temperature_range[1]):
        return Conductions((scene.conduction(),) * len(speeds))
    spectrum = smoothed_spectrum(scene)
    return Conductions(tuple(scene.conduction(_contact_temperature(scene, spectrum, speed)) for speed in speeds))


def _contact_temperature(scene: Scene, spectrum: Any, speed: float) -> float:
    """T₀ + 0.75 s T_flash, K, with the conductivities that both bodies have at that temperature."""
    from roughsim.scene import SceneError
    from theory import flash

    high = scene.temperature_range[1]

    def rise(temperature: float) -> float:
        bodies = scene.conduction(min(temperature, high))
        heated = flash.flash_temperature(speed, spectrum, **stress_arguments(scene), **heat_arguments(scene, bodies))
        return float(_used_share(scene, np.array([speed]), spectrum, bodies)[0] * heated)

    result = effective_temperature(rise, background_temperature=scene.sliding.background_temperature or 0.0)
    if result > high:
        raise SceneError(
            f"sliding.speed = {speed:g} m/s heats the contact to T₀ + 0.75 T_flash = {result:.4g} K at constant "
            f"conductivity beyond {high:g} K, where the tables end; extend them or lower the speed"
        )
    return result


def heat_arguments(scene: Scene, bodies: Conduction) -> dict[str, Any]:
    """Return μ, κ and D of the moving body as arguments of the theory."""
    return {
        "friction_coefficient": scene.sliding.friction_coefficient,
        "conductivity": bodies.conductivity,
        "diffusivity": bodies.diffusivity,
    }


def heat_partition(scene: Scene, speeds: ArrayLike | None = None) -> Array:
    """Return the share that temperatures are reported with, per speed: a number, 1, or the theory's rule.

    The speeds, m/s, if None, are those of the scene.
    """
    return _over_groups(scene, speeds, _used_share)


def theoretical_partition(scene: Scene, spectrum: Any = None) -> Array:
    """Return the theory's share per speed, "total" where the scene says so, else "mean"; NaN without a second body.

    `spectrum` stands for the whole C_sm if given.
    """
    rule = "total" if scene.sliding.heat_partition == "total" else "mean"

    def share(*given: Any) -> Array:
        return _theoretical_share(rule, *given)

    return _over_groups(scene, None, share, spectrum)


def _over_groups(
    scene: Scene,
    speeds: ArrayLike | None,
    share: Callable[[Scene, Array, Any, Conduction], Array],
    spectrum: Any = None,
) -> Array:
    """A share at each speed, with the conductivities that go with it."""
    speed = np.asarray(scene.speeds if speeds is None else speeds, np.float64)
    result = np.empty(speed.shape)
    spectrum = smoothed_spectrum(scene) if spectrum is None else spectrum
    for place, bodies in conduction(scene, speed).groups():
        result[place] = share(scene, speed[place], spectrum, bodies)
    return result


def _used_share(scene: Scene, speed: Array, spectrum: Any, bodies: Conduction) -> Array:
    rule = scene.sliding.heat_partition
    if isinstance(rule, str) and rule != "all":
        return _theoretical_share(rule, scene, speed, spectrum, bodies)
    return np.full(speed.shape, 1.0 if rule == "all" else float(rule))


def _theoretical_share(rule: str, scene: Scene, speed: Array, spectrum: Any, bodies: Conduction) -> Array:
    from theory import partition

    if bodies.counter_conductivity is None:
        return np.full(speed.shape, nan)
    duration: dict[str, Any] = {"duration": scene.sliding.duration} if rule == "total" else {}
    share = partition.moving_share(
        speed,
        spectrum,
        **stress_arguments(scene),
        conductivity=bodies.conductivity,
        diffusivity=bodies.diffusivity,
        resting_conductivity=bodies.counter_conductivity,
        resting_diffusivity=bodies.counter_diffusivity,
        rule=rule,
        **duration,
    )
    return np.asarray(share, dtype=np.float64)
