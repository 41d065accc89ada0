"""Fields of the kept realizations: the stored ones, and those that follow from the stored pressure."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from roughsim import prediction
from roughsim.errors import RecordError, number
from roughsim.heat import sliding_temperature, unit_vector
from roughsim.store.member_files import FIELD_UNITS, member_path, read_field

if TYPE_CHECKING:
    from roughsim.grid import Grid
    from roughsim.results.run import Run

Field = NDArray[np.float32]
DERIVED_UNITS = {"heat_flux": "W/m^2", "temperature": "K"}


def stream(
    run: Run, name: str, column: str | None, speed: float | None, direction: float
) -> Iterator[tuple[int, Field]]:
    """Return what `Run.fields` says, refusing wrong arguments at once."""
    speed = checked_speed(name, speed)
    unit_vector(direction)
    level = run.numerics.of_column(run.column(column))[-1]
    indices = kept(run, level)
    if not indices:
        raise not_kept(run, level)
    return ((index, member_field(run, level, index, name, speed=speed, direction=direction)) for index in indices)


def checked_speed(name: str, speed: float | None) -> float | None:
    """Return the speed that a field needs, m/s; ValueError for an unknown field, or a speed missing or too many."""
    if name not in (*FIELD_UNITS, *DERIVED_UNITS):
        raise ValueError(f"name = {name!r} is no field; choose one of {', '.join((*FIELD_UNITS, *DERIVED_UNITS))}")
    if name in DERIVED_UNITS:
        if speed is None:
            raise ValueError(f"speed is missing: {name} depends on it; give speed= in m/s")
        return number("speed", speed, "m/s")
    if speed is not None:
        raise ValueError(f"speed = {speed!r} m/s: {name} does not depend on it; leave it out")
    return None


def kept(run: Run, level: int) -> list[int]:
    """Return the sound realizations that count and whose fields are stored at a level."""
    there = np.array(run.sound(run.realizations), np.int64)
    there = there[there % run.numerics.levels[level].every == 0]
    return [int(index) for index in there[run.members.fixed(level, "kept", there) > 0]]


def not_kept(run: Run, level: int, index: int | None = None) -> ValueError:
    """Return the error that says how to come by the fields of a realization, or, without an index, of any."""
    if index is not None and (level, index) in run.damaged:
        return RecordError(run.damaged[level, index])
    missing = "has kept no fields" if index is None else f"has not kept the fields of realization {index}"
    wanted = index or 0
    return ValueError(
        f"{run.folder} {missing} at level {level}; run the scene into a new folder with --keep-fields {wanted + 1}, or "
        f"recompute one: rs.realize(run.scene, run.numerics, seed={run.seed}, level={level}, index={wanted})"
    )


def member_field(
    run: Run, level: int, index: int, name: str, *, speed: float | None = None, direction: float = 0.0
) -> Field:
    """Return one field of one kept realization; arguments as in `Run.fields`."""
    path = member_path(run.folder, level, index)
    if name in FIELD_UNITS:
        return _of_shape(path, name, run.numerics.grid(level).shape)
    speed = checked_speed(name, speed) or 0.0
    flux = _of_shape(path, "pressure", run.numerics.grid(level).shape)
    flux *= np.float32(run.scene.sliding.friction_coefficient * abs(speed))
    return flux if name == "heat_flux" else temperature_of(run, run.numerics.grid(level), flux, speed, direction)


def _of_shape(path: Path, name: str, shape: tuple[int, ...]) -> Field:
    values = read_field(path, name)
    if values.shape != shape:
        raise RecordError(f"{path} holds {name} of shape {values.shape}, but this run has {shape}: it is not its own")
    return values


def temperature_of(run: Run, grid: Grid, flux: Field, speed: float, direction: float = 0.0) -> Field:
    """Return the temperature, K, that the frictional heat of both bodies (W/m², on any grid of the cell) leaves."""
    bodies = prediction.conduction(run.scene, (abs(speed),)).each[0]
    temperature: Field = sliding_temperature(
        flux,
        grid,
        speed=speed,
        conductivity=bodies.conductivity,
        diffusivity=bodies.diffusivity,
        direction=direction,
        slid_distance=run.numerics.slid_distance,
    )
    temperature *= np.float32(heat_share(run, speed))
    return temperature


def heat_share(run: Run, speed: float) -> float:
    """Return the share of the heat that temperatures are reported with, at any speed, m/s."""
    if abs(speed) in run.scene.speeds:
        return float(run.heat_partition[run.scene.speeds.index(abs(speed))])
    return float(prediction.heat_partition(run.scene, (abs(speed),))[0])
