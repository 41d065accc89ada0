"""One kept member at hand: its fields, its temperature at any speed, and what is read off them."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, nan, sin
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughsim.explore.views import Field, preview_grid, preview_of
from roughsim.grid import Grid

if TYPE_CHECKING:
    from roughsim.results.run import Run

Array = NDArray[np.float64]
BINS = 80


@dataclass(frozen=True, slots=True, eq=False)
class Specimen:
    """A member and its stored fields, heights in m and pressure in Pa, with the pressure on its preview grid."""

    run: Run
    level: int
    index: int
    grid: Grid
    heights: Field
    pressure: Field
    preview: Field

    @property
    def is_small(self) -> bool:
        """Whether the preview is the whole field."""
        return self.preview.shape == self.pressure.shape

    def temperature(self, speed: float, direction: float) -> Field:
        """Return the temperature above the mean of the cell, K; speed in m/s, direction in rad from axis 0."""
        return self._temperature(self.pressure, self.grid, speed, direction)

    def temperature_preview(self, speed: float, direction: float) -> Field:
        """Return the same on the preview grid: the long waves alone, fast."""
        return self._temperature(self.preview, preview_grid(self.grid), speed, direction)

    def _temperature(self, pressure: Field, grid: Grid, speed: float, direction: float) -> Field:
        factor = self.run.scene.sliding.friction_coefficient * abs(speed)
        return self.run.temperature(pressure * pressure.dtype.type(factor), grid, speed, direction)


def load(run: Run, level: int, index: int) -> Specimen:
    """Read the fields of a member.

    Raises
    ------
    ValueError
        If they were not kept; it says how to keep or recompute them.
    RecordError
        If the file is damaged; it names the file.
    """
    if index not in run.kept(level):
        raise run.not_kept(level, index)
    grid = run.numerics.grid(level)
    heights, pressure = (run.field(level, index, name) for name in ("heights", "pressure"))
    return Specimen(run, level, index, grid, heights, pressure, preview_of(pressure, grid))


class Distribution(NamedTuple):
    """How temperature is distributed over the contact.

    `edges` of the bins, K (n + 1); `area` and `heat`: the share of the contact area, and of the heat, per K (n).
    """

    edges: Array
    area: Array
    heat: Array
    flash_temperature: float
    mean_temperature: float
    max_temperature: float


def distribution(temperature: Field, pressure: Field, bins: int = BINS) -> Distribution:
    """Return the distribution of temperature where the pressure is positive; empty without contact.

    Parameters
    ----------
    temperature, pressure : ndarray
        Fields of one shape, K and Pa; heat is set free in proportion to the pressure.
    bins : int
        Between the lowest and the highest temperature.
    """
    touching = pressure > 0.0
    values, weights = temperature[touching].astype(np.float64), pressure[touching].astype(np.float64)
    if not values.size:
        empty = np.empty(0)
        return Distribution(empty, empty, empty, nan, nan, nan)
    ends = float(values.min()), float(values.max())
    if ends[0] == ends[1]:
        ends = ends[0] - 0.5, ends[1] + 0.5
    counts, edges = np.histogram(values, bins, ends)
    heat, _ = np.histogram(values, bins, ends, weights=weights)
    width = edges[1] - edges[0]
    flash = float(values @ weights / weights.sum())
    shares = counts / (values.size * width), heat / (weights.sum() * width)
    return Distribution(edges, *shares, flash, float(values.mean()), float(values.max()))


class Line(NamedTuple):
    """Points of the grid along a straight line: distance from its middle, m, positive where the source slides."""

    distance: Array
    i: NDArray[np.intp]
    j: NDArray[np.intp]


def nearest(grid: Grid, x: float, y: float) -> tuple[int, int]:
    """Return the point of the grid next to a place, m; inside the cell."""
    i, j = (int(np.clip(round(at / d), 0, n - 1)) for at, d, n in zip((x, y), grid.spacing, grid.shape, strict=True))
    return i, j


def line_through(grid: Grid, point: tuple[int, int], direction: float) -> Line:
    """Return the points next to the line through a point along a direction, from one side of the cell to the other.

    Neighbours are one spacing (the smaller one) apart, so that along an axis each point comes once.

    Parameters
    ----------
    grid : Grid
        Of the field.
    point : (int, int)
        Indices of the middle.
    direction : float
        Radians from axis 0 towards axis 1.
    """
    unit = np.array([cos(direction), sin(direction)])
    unit[np.abs(unit) < 1e-15] = 0.0
    places, reach = np.array(point, dtype=np.float64), np.array(grid.shape) - 1.0
    pace = unit / np.array(grid.spacing)  # indices per metre
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = np.sort(np.stack([-places / pace, (reach - places) / pace]), axis=0)
    ends = ends[:, pace != 0.0]
    step = min(d for d, u in zip(grid.spacing, unit, strict=True) if u != 0.0)
    counts = np.floor(np.array([ends[0].max(), ends[1].min()]) / step + np.array([-1e-9, 1e-9]) + [1.0, 0.0])
    distance = float(step) * np.arange(int(counts[0]), int(counts[1]) + 1, dtype=np.float64)
    indices = [np.rint(places[k] + pace[k] * distance).astype(np.intp) for k in (0, 1)]
    return Line(distance, *(np.clip(index, 0, n - 1) for index, n in zip(indices, grid.shape, strict=True)))


def along(line: Line, **fields: Field | None) -> dict[str, Any]:
    """Return the distance and the values of fields on a line; NaN for a field that is not known yet."""
    values = {
        name: np.full(line.i.shape, nan) if field is None else field[line.i, line.j].astype(np.float64)
        for name, field in fields.items()
    }
    return {"distance": line.distance} | values
