"""The fields of a member as the page shows them: temperatures at any speed, images of a view, points on a line."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, sin
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.signal import resample

from roughsim.grid import Grid
from roughsim.heat.statistics import ContactTemperature, contact_temperature
from roughsim.results.run import Run

Field = NDArray[Any]
Ends = tuple[float, float]
PREVIEW = 1024  # points per side that the temperature is computed on while the slider moves
PIXELS = 512  # per side of an image: more would not be seen, and each is sent at every move of the slider


class Temperature(NamedTuple):
    """A temperature of a member above the mean of the cell, K, at a speed, m/s, and direction, rad from axis 0.

    A preview has no distribution over the contact, and of a large field only the long waves.
    """

    member: MemberFields
    field: Field
    grid: Grid
    speed: float
    direction: float
    contact: ContactTemperature | None

    @property
    def preview(self) -> bool:
        """Whether the whole field is still to come."""
        return self.contact is None


@dataclass(frozen=True, slots=True, eq=False)
class MemberFields:
    """Heights, m, and pressure, Pa, of one member, and its pressure on the grid of the preview."""

    run: Run
    grid: Grid
    heights: Field
    pressure: Field
    preview_grid: Grid
    preview_pressure: Field

    def temperature(self, speed: float, direction: float, *, preview: bool = False) -> Temperature:
        """Return the temperature at a speed, m/s, and direction, rad, on the whole grid or on that of the preview."""
        pressure, grid = (self.preview_pressure, self.preview_grid) if preview else (self.pressure, self.grid)
        friction = pressure.dtype.type(self.run.scene.sliding.friction_coefficient * abs(speed))
        field = self.run.temperature(pressure * friction, grid, speed, direction)
        # the heat that a pixel sets free is in proportion to its pressure
        contact = None if preview else contact_temperature(field, pressure)
        return Temperature(self, field, grid, speed, direction, contact)


def load_fields(run: Run, level: int, index: int) -> MemberFields:
    """Read the fields of a member; ValueError if they were not kept, RecordError if its file is damaged."""
    if index not in run.kept(level):
        raise run.not_kept(level, index)
    grid = run.numerics.grid(level)
    heights, pressure = (run.field(level, index, name) for name in ("heights", "pressure"))
    # the temperature is linear in the heat, wave by wave: the long waves of the pressure give those of the temperature
    coarse, waves = Grid((min(grid.shape[0], PREVIEW), min(grid.shape[1], PREVIEW)), grid.lengths), pressure
    for axis in (0, 1):
        if coarse.shape[axis] < grid.shape[axis]:
            waves = resample(waves, coarse.shape[axis], axis=axis)
    return MemberFields(run, grid, heights, pressure, coarse, waves)


class Image(NamedTuple):
    """Pixels of shape (y, x); left, bottom, width and height, m; the values of 0 and 255; points per pixel."""

    pixels: NDArray[np.uint8]
    box: tuple[float, float, float, float]
    limits: Ends
    step: tuple[int, int]


def image_of(field: Field, grid: Grid, view: tuple[Ends, Ends], limits: Ends | None, pixels: int = PIXELS) -> Image:
    """Return the image of the part of a field that meets a view (ends along x and y, m); limits None: its own.

    The point of index i covers (i ± ½)·spacing. At most `pixels` blocks of points lie along a side; each is shown as
    its mean. Of a view beyond the cell one point stays. Blocks start at multiples of their size, so that an image does
    not shimmer while the view is moved. The last ones may reach beyond the cell; their means are over fewer points.
    """
    means, sides = field, []  # along x and y: where the blocks begin, how far they reach, how many points each has
    for count, spacing, ends in zip(grid.shape, grid.spacing, view, strict=True):
        first, last = (int(np.clip(np.floor(end / spacing + 0.5), 0, count - 1)) for end in sorted(ends))
        step = 1
        while last // step - first // step >= pixels:
            step += 1
        start, stop = first // step * step, (last // step + 1) * step
        means = block_means(means[start:stop], step).T  # the second turn transposes back
        sides.append(((start - 0.5) * spacing, (stop - start) * spacing, step))
    (left, width, x_step), (bottom, height, y_step) = sides
    low, high = limits or (float(means.min()), float(means.max()))
    return Image(as_bytes(means, (low, high)), (left, bottom, width, height), (low, high), (x_step, y_step))


def block_means(rows: Field, step: int) -> Field:
    """Return the means of each `step` rows; the last block may have fewer."""
    if step == 1:
        return rows
    starts = np.arange(0, len(rows), step)
    counts = np.diff(starts, append=len(rows)).astype(rows.dtype)
    means: Field = np.add.reduceat(rows, starts, axis=0) / counts[:, None]
    return means


def as_bytes(field: Field, limits: Ends) -> NDArray[np.uint8]:
    """Return 0…255 for values from the lower to the upper limit, shape (y, x) as screens draw; flat fields are 0."""
    low, high = limits
    scale = 255.0 / (high - low) if high > low else 0.0
    return np.ascontiguousarray(np.rint(np.clip((field.T - low) * scale, 0.0, 255.0)).astype(np.uint8))


class Line(NamedTuple):
    """Points of a grid along a line: indices i, j, and distance from its middle, m, positive along the direction."""

    distance: NDArray[np.float64]
    i: NDArray[np.intp]
    j: NDArray[np.intp]


def nearest_point(grid: Grid, x: float, y: float) -> tuple[int, int]:
    """Return the indices of the point of the cell that is next to (x, y), m."""
    i, j = (int(np.clip(round(at / d), 0, n - 1)) for at, d, n in zip((x, y), grid.spacing, grid.shape, strict=True))
    return i, j


def line_through(grid: Grid, point: tuple[int, int], direction: float) -> Line:
    """Return the points next to the line through a point along a direction, rad from axis 0 towards axis 1.

    The line reaches from one side of the cell to the other. Its points are one spacing (the smaller one) apart, so that
    a line along an axis has each point of the grid once.
    """
    unit = np.round([cos(direction), sin(direction)], 15)  # exactly 0 along an axis
    step = min(d for d, u in zip(grid.spacing, unit, strict=True) if u != 0.0)
    reach = int(np.hypot(*grid.lengths) / step)
    distance = step * np.arange(-reach, reach + 1.0)
    places = np.reshape(point, (2, 1)) + np.outer(unit / grid.spacing, distance)  # in indices
    last = np.reshape(grid.shape, (2, 1)) - 1
    # a point that lies on a side stays in spite of rounding
    inside = ((places > -1e-6) & (places < last + 1e-6)).all(axis=0)
    i, j = np.rint(places[:, inside]).astype(np.intp)
    return Line(distance[inside], i, j)
