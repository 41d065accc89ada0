"""Fields that follow from the pressure of a contact and the speed: heat, temperature, and what a camera sees of it."""

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughsim import prediction
from roughsim.errors import number
from roughsim.grid import Grid
from roughsim.scene import Scene
from roughsim.store.member_files import KEPT_FIELDS

Field = NDArray[np.float32]
DERIVED_UNITS: Mapping[str, str] = {"heat_flux": "W/m^2", "temperature": "K", "seen": "K"}


class Way(NamedTuple):
    """How the contact slides."""

    speed: float  # m/s; negative: the opposite direction
    direction: float  # radians from axis 0 towards axis 1
    slid_distance: float | None  # since the start from rest, m; None: half the chord of the cell


def heat_flux(scene: Scene, pressure: Field, speed: float) -> Field:
    """Return the frictional heat of both bodies, W/m², by a pressure, Pa, at a speed, m/s."""
    return pressure * np.float32(prediction.heat_per_pressure(scene, speed))


def temperature(scene: Scene, pressure: Field, grid: Grid, way: Way, share: float) -> Field:
    """Return the temperature of the moving body above the mean of the cell, K, with its share of the heat."""
    # slow to import: means need no transforms
    from roughsim.heat.periodic import sliding_temperature

    if scene.directions:
        scene = prediction.turned(scene, way.direction + scene.grooves[1])
    moving = prediction.conduction(scene, (abs(way.speed),)).each[0]
    field: Field = sliding_temperature(
        heat_flux(scene, pressure, way.speed),
        grid,
        speed=way.speed,
        conductivity=moving.conductivity,
        diffusivity=moving.diffusivity,
        **moving.layers._asdict(),
        direction=way.direction,
        slid_distance=way.slid_distance,
    )
    field *= np.float32(share)
    return field


def seen(scene: Scene, pressure: Field, grid: Grid, way: Way, share: float) -> Field:
    """Return the same as the [camera] of the scene sees it; arguments as of `temperature`."""
    from roughsim.observables.camera import pictures  # as above

    at_speed = replace(scene, sliding=replace(scene.sliding, speed=(abs(way.speed),)))
    if scene.directions:
        at_speed = at_speed.towards(way.direction + scene.grooves[1])
    turned = way.direction if way.speed > 0.0 else way.direction + np.pi
    camera = prediction.camera_of(at_speed)._replace(
        direction=turned, slid_distance=way.slid_distance
    )
    (field,) = pictures(pressure, grid, prediction.heat_source(at_speed), camera)
    heat = camera.heating[0] * float(pressure.mean()) * share
    return np.asarray(field * np.float32(heat))


def check_field(name: str, speed: float | None, direction: float) -> None:
    """Refuse a field that there is not, a speed that it does not depend on, and a missing one: ValueError."""
    number("direction", direction, "rad")
    if name not in (*KEPT_FIELDS, *DERIVED_UNITS):
        raise ValueError(
            f"name = {name!r} is no field; choose one of {', '.join((*KEPT_FIELDS, *DERIVED_UNITS))}"
        )
    if speed is not None and name in KEPT_FIELDS:
        raise ValueError(f"speed = {speed!r} m/s: {name} does not depend on it; leave it out")
    if name in DERIVED_UNITS:
        if speed is None:
            raise ValueError(f"speed is missing: {name} depends on it; give speed= in m/s")
        number("speed", speed, "m/s")
