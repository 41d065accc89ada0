"""The fields of a member as the page shows them: temperatures at any speed, images of a view, points on a line."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, sin
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughsim import fourier
from roughsim.charts.temperature import densities
from roughsim.grid import Grid
from roughsim.results.run import Run

Field = NDArray[Any]
Ends = tuple[float, float]
PREVIEW = 1024  # points per side that the temperature is computed on while the slider moves
PIXELS = 512  # per side of an image: more would not be seen, and each is sent at every move of the slider


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

    A preview has only the long waves, unless the grid is so small that it is whole. A distribution over the contact is
    that of the whole field; None of a preview, and without contact.
    """

    member: MemberFields
    field: Field
    grid: Grid
    speed: float
    direction: float
    whole: bool
    distribution: Distribution | None


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
        distribution = None if preview else self.distribution(field)
        return Temperature(self, field, grid, speed, direction, grid == self.grid, distribution)

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
    return MemberFields(run, grid, heights, pressure, coarse, long_waves(pressure, coarse))


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


class Image(NamedTuple):
    """Pixels of shape (y, x); left, bottom, width and height, m; the values of 0 and 255; points per pixel."""

    pixels: NDArray[np.uint8]
    box: tuple[float, float, float, float]
    limits: Ends
    step: tuple[int, int]


class Part(NamedTuple):
    """Points of a field that are in view; how many of them, along x and y, make one pixel; and their box as `Image`."""

    x: slice
    y: slice
    step: tuple[int, int]
    box: tuple[float, float, float, float]


def image_of(field: Field, grid: Grid, view: tuple[Ends, Ends], limits: Ends | None) -> Image:
    """Return the image of the part of a field that meets a view (ends along x and y, m); limits None: its own."""
    part = part_in_view(grid, *view)
    means = block_means(field, part)
    low, high = limits or (float(means.min()), float(means.max()))
    return Image(as_bytes(means, (low, high)), part.box, (low, high), part.step)


def part_in_view(grid: Grid, x: Ends, y: Ends, pixels: int = PIXELS) -> Part:
    """Return the points that meet a view, m, in blocks of which at most `pixels` lie along a side.

    The point of index i covers (i ± ½)·spacing. Of a view beyond the cell one point stays. Blocks start at multiples of
    their size, so that an image does not shimmer while the view is moved. The last ones may reach beyond the cell.
    """
    sides = []  # along x and y: the points in view, how many make one pixel, where they begin and how far they reach
    for count, spacing, ends in zip(grid.shape, grid.spacing, (x, y), strict=True):
        first, last = (int(np.clip(np.floor(end / spacing + 0.5), 0, count - 1)) for end in sorted(ends))
        step = 1
        while last // step - first // step >= pixels:
            step += 1
        start, stop = first // step * step, (last // step + 1) * step
        sides.append((slice(start, min(stop, count)), step, (start - 0.5) * spacing, (stop - start) * spacing))
    (x_part, x_step, left, width), (y_part, y_step, bottom, height) = sides
    return Part(x_part, y_part, (x_step, y_step), (left, bottom, width, height))


def block_means(field: Field, part: Part) -> Field:
    """Return the means of a field over the blocks of a part; blocks at the end of the cell may have fewer points."""
    means = field[part.x, part.y]
    for step in part.step:  # along x, then along y; each turn transposes
        whole, rest = divmod(len(means), step)
        if step > 1:
            blocks = means[: whole * step].reshape(whole, step, -1).mean(axis=1)
            last = means[whole * step :].mean(axis=0, keepdims=True) if rest else blocks[:0]
            means = np.concatenate([blocks, last])
        means = means.T
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
    unit = np.array([cos(direction), sin(direction)])
    unit[np.abs(unit) < 1e-15] = 0.0
    middle, last = np.array(point, dtype=np.float64), np.array(grid.shape) - 1.0
    pace = unit / np.array(grid.spacing)  # indices per metre
    # distances at which the line meets the four sides; along an axis it meets only two
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = np.sort(np.stack([-middle / pace, (last - middle) / pace]), axis=0)
    ends = ends[:, pace != 0.0]
    step = min(d for d, u in zip(grid.spacing, unit, strict=True) if u != 0.0)
    # whole steps between the sides; 1e-9 keeps a point that lies on a side in spite of rounding
    first, end = np.floor(np.array([ends[0].max(), ends[1].min()]) / step + [1.0 - 1e-9, 1.0 + 1e-9]).astype(int)
    distance = float(step) * np.arange(first, end, dtype=np.float64)
    i, j = (np.rint(middle[k] + pace[k] * distance).astype(np.intp).clip(0, grid.shape[k] - 1) for k in (0, 1))
    return Line(distance, i, j)
