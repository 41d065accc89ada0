"""Sizes of what a scene leaves out at its surface: a thin skin, and contact that grows by friction."""

from collections.abc import Iterator
from dataclasses import replace
from math import isnan, sqrt
from typing import Any

import numpy as np

import theory
from roughsim.prediction.bodies import heating
from roughsim.prediction.law import calibrated
from roughsim.prediction.shares import heat_arguments
from roughsim.prediction.stress import smoothed_spectrum, stress_arguments
from roughsim.prediction.theories import calibrated_over_speed
from roughsim.scene import Scene
from roughsim.scene.bodies import Layers
from roughsim.show.remarks import Remark

METAL = 10.0  # W/(m K): better conductors with a skin are hotter by much
_OXIDE = (10e-9, 3.0, 3.0 / 3.4e6)  # native, of iron: d, m, κ_s, W/(m K), and D_s, m²/s
_WORKED = 1e-6  # m, of a layer with half the conductivity
_RUBBING = 0.3  # μ from which on growth of the junctions changes T_flash by 20 % and more
_GROWTHS = (9.0, 25.0)  # Tabor's α of metals


def skin_effects(scene: Scene) -> tuple[float, float] | None:
    """Return the relative change of T_flash by 10 nm of oxide, and by 1 µm of half the conductivity of the body.

    At the highest speed, by the calibrated law, or by the theory where that does not hold. None for a body that has a
    skin or a depth of its heat, for a poor conductor, and where nothing slides.
    """
    speed = max(scene.speeds)
    constants = heating(scene, speed)
    kappa, diffusivity = constants.bodies.conductivity, constants.bodies.diffusivity
    if scene.layers[0] != Layers() or kappa < METAL or speed == 0.0:
        return None
    law = calibrated(scene).stress_spectrum
    stress: dict[str, Any] = {
        "stress_spectrum": law,
        "nominal_pressure": scene.sliding.nominal_pressure,
    }
    if law is None:
        stress = {"spectrum": smoothed_spectrum(scene)} | stress_arguments(scene)
    skins = None, _OXIDE, (_WORKED, 0.5 * kappa, 0.5 * diffusivity)
    heat = heat_arguments(*constants)
    bare, oxide, worked = (
        float(theory.flash.flash_temperature(speed, **stress, **heat | {"skin": skin}))
        for skin in skins
    )
    return oxide / bare - 1.0, worked / bare - 1.0


def growth_effects(scene: Scene) -> str:
    """Return in words how much junction growth would change T_flash at the highest speed, by the calibrated law.

    Outside the law it is the area of contact, which grows as √(1 + αμ²) where all of it yields. Empty for a scene that
    has a growth, does not yield, or has little friction.
    """
    friction = scene.sliding.friction_coefficient
    if scene.elastic or scene.sliding.junction_growth is not None or isinstance(friction, tuple):
        return ""
    if friction < _RUBBING:
        return ""
    fastest = np.array([max(scene.speeds)])
    alphas = " and ".join(f"{alpha:g}" for alpha in _GROWTHS)
    scenes = [
        replace(scene, sliding=replace(scene.sliding, junction_growth=alpha))
        for alpha in (0.0, *_GROWTHS)
    ]
    bare, *grown = (calibrated_over_speed(each, fastest)["flash_temperature"][0] for each in scenes)
    if bare and not isnan(sum(grown)):
        sizes = " and ".join(f"{100 * (each / bare - 1):.2g} %" for each in grown)
        return f"sliding.junction_growth = {alphas} would change T_flash at {fastest[0]:g} m/s by {sizes}"
    sizes = " and ".join(f"{sqrt(1 + alpha * friction**2):.2g}" for alpha in _GROWTHS)
    return (
        f"sliding.junction_growth = {alphas} would make the yielded contact {sizes} times as large"
    )


def effects(scene: Scene) -> Iterator[Remark]:
    """Yield each part of the surface that the scene leaves out, with its size."""
    skin = skin_effects(scene)
    if skin is not None:
        sizes = f"10 nm of oxide make T_flash {100 * skin[0]:.2g} % higher, 1 µm of half the conductivity"
        because = f"at {max(scene.speeds):g} m/s {sizes} {100 * skin[1]:.2g} %; no error here contains that"
        yield Remark("assumption", "first micrometre", because, "as the rest of [body]")
    growth = growth_effects(scene)
    if growth:
        yield Remark("assumption", "contact under friction", growth, "as without friction")
