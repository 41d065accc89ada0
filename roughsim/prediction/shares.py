"""How two bodies share the heat by a rule of the scene, and how both warm."""

from collections.abc import Iterator
from contextlib import contextmanager
from math import inf, nan
from typing import Any

import numpy as np

import theory
from roughsim.grid import Array
from roughsim.prediction.lay import in_directions
from roughsim.prediction.stress import (
    headings_at,
    in_directions_of,
    stress_arguments,
    stress_of_lay,
)
from roughsim.scene import Scene, SceneError
from roughsim.scene.bodies import Conduction
from roughsim.surface.spectrum import Spectrum
from theory.lay import LayStress
from theory.lay_waves import Weighted
from theory.skin import ThermalBody, body_of

FLASH = "flash_temperature"
AT_REST = 1e-150  # m/s, in place of zero: at rest D_flash and the heat share are limits of ratios of moments


def heat_arguments(friction_coefficient: float, bodies: Conduction) -> dict[str, Any]:
    """Return μ, and κ, D, the skin and the depth of the heat of the moving body as arguments of the theory."""
    return {
        "friction_coefficient": friction_coefficient,
        "conductivity": bodies.conductivity,
        "diffusivity": bodies.diffusivity,
        **bodies.layers._asdict(),
    }


def resting_arguments(bodies: Conduction) -> dict[str, Any]:
    """Return κ, D, the skin and the depth of the heat of the resting body as arguments of the theory."""
    skin, depth = bodies.counter_layers
    return {
        "resting_conductivity": bodies.counter_conductivity,
        "resting_diffusivity": bodies.counter_diffusivity,
        "resting_skin": skin,
        "resting_heat_depth": depth,
    }


def thermal_bodies(bodies: Conduction) -> tuple[ThermalBody, ThermalBody | None]:
    """Return the moving and the resting body as the theory has them; None of one that does not conduct."""
    moving = body_of(bodies.conductivity, bodies.diffusivity, *bodies.layers)
    if bodies.counter_conductivity is None:
        return moving, None
    return moving, body_of(
        bodies.counter_conductivity, bodies.counter_diffusivity, *bodies.counter_layers
    )


def warming_lengths(scene: Scene, speed: float, bodies: Conduction) -> tuple[float, float]:
    """Return κT₀/q̇ of the moving and of the resting body, m, as `theory.background.heat_length`.

    Of the resting body under the rule "total", which alone needs it, else 0. SceneError if a skin or a depth of the
    heat has not warmed through.
    """
    sliding = scene.sliding
    nominal = theory.background.nominal_contact(
        sliding.duration, sliding.contact_radius, sliding.track_radius
    )
    moving, resting = thermal_bodies(bodies)
    with _in_words_of(scene):
        length = theory.background.heat_length(moving, nominal, speed)
        if sliding.heat_partition != "total" or resting is None:
            return length, 0.0
        return length, theory.background.heat_length(resting, nominal)


@contextmanager
def _in_words_of(scene: Scene) -> Iterator[None]:
    """Name the key of a scene that a background of the theory refuses; SceneError."""
    try:
        yield
    except ValueError as error:
        key, _, reason = str(error).partition(": ")
        if key not in ("duration", "contact_radius"):
            raise
        lacks = "s is too short" if key == "duration" else "m is too small"
        value = getattr(scene.sliding, key)
        raise SceneError(f"sliding.{key} = {value:.4g} {lacks}: {reason}") from None
    except ArithmeticError as error:
        radius = scene.sliding.contact_radius
        if radius is None:
            raise
        raise SceneError(f"sliding.contact_radius = {radius:.4g} m: {error}") from None


def share_of(
    scene: Scene,
    rule: float | str,
    speed: Array,
    spectrum: Spectrum | None,
    bodies: Conduction,
    stress: Spectrum | LayStress | None = None,
    headings: Array | None = None,
) -> Array:
    """Return the moving body's share by a rule of the scene at speeds (n,), m/s, that have one conduction.

    Of C(q) m⁴, or of the spectrum of the stress, Pa² m², if that is given. `headings` are the directions, radians from
    the grooves; None: as `headings_at`.
    """
    if not isinstance(rule, str) or rule == "all":
        return np.full(speed.shape, 1.0 if rule == "all" else float(rule))
    if bodies.counter_conductivity is None:
        return np.full(speed.shape, nan)
    if in_directions_of(scene, stress):
        at = headings_at(scene, speed) if headings is None else headings
        return _share_of_lay(scene, rule, speed, stress_of_lay(scene, spectrum, stress), bodies, at)
    contact: dict[str, Any] = {"spectrum": spectrum} | stress_arguments(scene)
    if stress is not None:
        contact = {"stress_spectrum": stress, "nominal_pressure": scene.sliding.nominal_pressure}
    with _in_words_of(scene):
        share = theory.partition.moving_share(
            speed,
            **contact,
            conductivity=bodies.conductivity,
            diffusivity=bodies.diffusivity,
            **resting_arguments(bodies),
            **bodies.layers._asdict(),
            rule=rule,
            **(_total_arguments(scene) if rule == "total" else {}),
        )
    return np.asarray(share, dtype=np.float64)


def _share_of_lay(
    scene: Scene, rule: str, speed: Array, stress: Weighted, bodies: Conduction, at: Array
) -> Array:
    """Return the share by the rule "mean" or "total" of faces with a lay, from the temperatures of both bodies.

    The resting body is as hot as one that slides slowly. By "total" it has done so for the duration, both have warmed,
    and a resting body that was hotter gives off heat.
    """
    moving, slow = np.where(speed > 0.0, speed, AT_REST), np.full(speed.shape, AT_REST)
    other = Conduction(*bodies[2:4], layers=bodies.counter_layers)  # type: ignore[arg-type]
    # both temperatures are in proportion to μ, which a difference of the bodies needs, and then it is a number
    total, friction = rule == "total", scene.friction_coefficient(scene.background_temperature)
    time = scene.sliding.duration if total else None
    grown = inf if time is None else AT_REST * time
    flux = friction * scene.sliding.nominal_pressure * moving
    both = []
    for k, (body, slid, since) in enumerate(((bodies, moving, inf), (other, slow, grown))):
        heat = heat_arguments(friction, body)
        heat |= {"nominal_pressure": scene.sliding.nominal_pressure}
        found = in_directions((FLASH,), slid, at, stress, slid_distance=since, **heat)
        flash = found[FLASH] * (moving / slid)
        if total:
            warmed = [warming_lengths(scene, one, bodies)[k] for one in speed.tolist()]
            flash = flash + flux / body.conductivity * np.array(warmed)
        both.append(flash)
    return np.asarray((both[1] + scene.temperature_difference) / (both[0] + both[1]))


def _total_arguments(scene: Scene) -> dict[str, Any]:
    """Return what the rule "total" of the theory adds; bodies of two temperatures have one μ."""
    difference, sliding = scene.temperature_difference, scene.sliding
    return {
        "duration": sliding.duration,
        "contact_radius": sliding.contact_radius,
        "track_radius": sliding.track_radius,
        "temperature_difference": difference,
        "friction_coefficient": scene.friction_coefficient() if difference else None,
    }
