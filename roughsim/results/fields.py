"""Fields of members: stored ones are read, the heat and the temperature follow from the stored pressure."""

import numpy as np
from numpy.typing import NDArray

from roughsim import prediction
from roughsim.errors import number
from roughsim.grid import Grid
from roughsim.scene import Scene
from roughsim.store.member_files import KEPT_FIELDS

Field = NDArray[np.float32]
DERIVED_UNITS = {"heat_flux": "W/m^2", "temperature": "K"}  # of fields that depend on the speed


def check_field(name: str, speed: float | None, direction: float = 0.0) -> None:
    """Refuse an unknown field, a missing or an unneeded speed, or a direction that is no number: ValueError."""
    number("direction", direction, "rad")
    if name not in (*KEPT_FIELDS, *DERIVED_UNITS):
        raise ValueError(f"name = {name!r} is no field; choose one of {', '.join((*KEPT_FIELDS, *DERIVED_UNITS))}")
    if name in DERIVED_UNITS:
        if speed is None:
            raise ValueError(f"speed is missing: {name} depends on it; give speed= in m/s")
        number("speed", speed, "m/s")
    elif speed is not None:
        raise ValueError(f"speed = {speed!r} m/s: {name} does not depend on it; leave it out")


def temperature_of(
    scene: Scene, flux: Field, grid: Grid, speed: float, *, direction: float, share: float, slid_distance: float | None
) -> Field:
    """Return the temperature, K, of the moving body with a share of the frictional heat of both bodies, W/m²."""
    from roughsim.heat.periodic import sliding_temperature  # slow to import: means need no transforms

    moving = prediction.conduction(scene, (abs(speed),)).each[0]
    temperature: Field = sliding_temperature(
        flux,
        grid,
        speed=speed,
        conductivity=moving.conductivity,
        diffusivity=moving.diffusivity,
        **moving.layers._asdict(),
        direction=direction,
        slid_distance=slid_distance,
    )
    temperature *= np.float32(share)
    return temperature
