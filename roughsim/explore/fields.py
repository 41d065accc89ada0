"""The stored fields of one member, and its temperature at any speed and direction: whole, or a quick preview."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughsim import fourier
from roughsim.charts.temperature import densities
from roughsim.grid import Grid

if TYPE_CHECKING:
    from roughsim.results.run import Run

Field = NDArray[Any]
PREVIEW = 1024  # points per side that the temperature is computed on while the slider moves


class Distribution(NamedTuple):
    """Temperatures of a contact, K, and their densities by area and by heat between edges, % per K."""

    flash_temperature: float
    mean_temperature: float
    max_temperature: float
    edges: Field
    area: Field
    heat: Field


class Temperature(NamedTuple):
    """A temperature of a member above the mean of the cell, K, at a speed, m/s, and direction, rad from axis 0.

    A whole field has its distribution over the contact, None without contact. A preview has only the long waves.
    """

    member: MemberFields
    field: Field
    grid: Grid
    speed: float
    direction: float
    whole: bool
    distribution: Distribution | None = None


@dataclass(frozen=True, slots=True, eq=False)
class MemberFields:
    """Heights, m, and pressure, Pa, of one member, and its pressure on the grid of the preview."""

    run: Run
    level: int
    index: int
    grid: Grid
    heights: Field
    pressure: Field
    preview_grid: Grid
    preview_pressure: Field

    @property
    def preview_is_whole(self) -> bool:
        """Whether the grid is so small that the preview is the whole field."""
        return self.preview_grid.shape == self.grid.shape

    def temperature(self, speed: float, direction: float, *, preview: bool = False) -> Temperature:
        """Return the temperature at a speed, m/s, and direction, rad, on the whole grid or on that of the preview."""
        pressure, grid = (self.preview_pressure, self.preview_grid) if preview else (self.pressure, self.grid)
        friction = pressure.dtype.type(self.run.scene.sliding.friction_coefficient * abs(speed))
        field = self.run.temperature(pressure * friction, grid, speed, direction)
        if preview:
            return Temperature(self, field, grid, speed, direction, whole=self.preview_is_whole)
        return Temperature(self, field, grid, speed, direction, True, self.distribution(field))

    def distribution(self, temperature: Field) -> Distribution | None:
        """Return how a temperature on the whole grid, K, is distributed over the contact; None without contact."""
        touching = self.pressure > 0.0
        if not touching.any():
            return None
        # the heat that a pixel sets free is in proportion to its pressure
        values, heat = temperature[touching].astype(np.float64), self.pressure[touching].astype(np.float64)
        flash = float(values @ heat / heat.sum())
        return Distribution(flash, float(values.mean()), float(values.max()), *densities(values, heat))


def load_fields(run: Run, level: int, index: int) -> MemberFields:
    """Read the fields of a member; ValueError if they were not kept, RecordError if its file is damaged."""
    if index not in run.kept(level):
        raise run.not_kept(level, index)
    grid = run.numerics.grid(level)
    heights, pressure = (run.field(level, index, name) for name in ("heights", "pressure"))
    coarse = Grid((min(grid.shape[0], PREVIEW), min(grid.shape[1], PREVIEW)), grid.lengths)
    return MemberFields(run, level, index, grid, heights, pressure, coarse, long_waves(pressure, coarse))


def long_waves(field: Field, coarse: Grid) -> Field:
    """Return a field on a coarse grid of its cell: its waves below the Nyquist wavenumber of that grid.

    The temperature is linear in the heat, wave by wave. So these waves of a preview are those of the whole field.
    """
    if coarse.shape == field.shape:
        return field
    spectrum = fourier.forward(field)
    waves = np.zeros(coarse.half_shape, spectrum.dtype)
    # along axis 0 positive and negative wavenumbers; those at the Nyquist wavenumber itself stay zero
    rows, columns = -(-coarse.shape[0] // 2), -(-coarse.shape[1] // 2)
    waves[:rows, :columns] = spectrum[:rows, :columns]
    if rows > 1:
        waves[1 - rows :, :columns] = spectrum[1 - rows :, :columns]
    return fourier.inverse(waves, coarse.shape)
