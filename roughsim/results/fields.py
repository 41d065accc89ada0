"""Fields of one kept realization: the stored ones, and the temperature that follows from the stored pressure."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from roughsim import prediction
from roughsim.errors import RecordError, number
from roughsim.grid import Grid
from roughsim.heat.periodic import sliding_temperature
from roughsim.scene import Scene
from roughsim.store.member_files import FIELD_UNITS, read_field

Field = NDArray[np.float32]
DERIVED_UNITS = {"heat_flux": "W/m^2", "temperature": "K"}  # of fields that depend on the speed


def checked_speed(name: str, speed: float | None) -> float | None:
    """Return the speed that a field needs, m/s; ValueError for an unknown field, a missing or a useless speed."""
    if name not in (*FIELD_UNITS, *DERIVED_UNITS):
        raise ValueError(f"name = {name!r} is no field; choose one of {', '.join((*FIELD_UNITS, *DERIVED_UNITS))}")
    if name in DERIVED_UNITS:
        if speed is None:
            raise ValueError(f"speed is missing: {name} depends on it; give speed= in m/s")
        return number("speed", speed, "m/s")
    if speed is not None:
        raise ValueError(f"speed = {speed!r} m/s: {name} does not depend on it; leave it out")
    return None


def stored_field(path: Path, name: str, shape: tuple[int, int]) -> Field:
    """Return heights, m, or pressure, Pa, of a member's file; RecordError if it is damaged or of another grid."""
    values = read_field(path, name)
    if values.shape != shape:
        raise RecordError(f"{path} holds {name} of shape {values.shape}, but this run has {shape}: it is not its own")
    return values


def temperature_field(
    flux: Field, grid: Grid, scene: Scene, *, speed: float, direction: float, slid_distance: float | None, share: float
) -> Field:
    """Return the temperature, K, of the moving body, which takes the share of the heat `flux` of both, W/m²."""
    moving = prediction.conduction(scene, (abs(speed),)).each[0]
    temperature: Field = sliding_temperature(
        flux,
        grid,
        speed=speed,
        conductivity=moving.conductivity,
        diffusivity=moving.diffusivity,
        direction=direction,
        slid_distance=slid_distance,
    )
    temperature *= np.float32(share)
    return temperature
