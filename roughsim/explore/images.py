"""The part of a field that is in view, as an image for the screen: few pixels, a byte each."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughsim.grid import Grid

Field = NDArray[Any]
Ends = tuple[float, float]
PIXELS = 512  # per side of an image: more would not be seen, and each is sent at every move of the slider


class Part(NamedTuple):
    """Points of a field that are in view, and how many of them, along x and y, make one pixel."""

    x: slice
    y: slice
    step: tuple[int, int]


class Image(NamedTuple):
    """Pixels of shape (y, x); left, bottom, width and height, m; the values of 0 and 255; points per pixel."""

    pixels: NDArray[np.uint8]
    box: tuple[float, float, float, float]
    limits: Ends
    step: tuple[int, int]


def image_of(field: Field, grid: Grid, view: tuple[Ends, Ends], limits: Ends | None) -> Image:
    """Return the image of the part of a field that meets a view (ends along x and y, m); limits None: its own."""
    part = part_in_view(grid, *view)
    means = block_means(field, part)
    low, high = limits or (float(means.min()), float(means.max()))
    return Image(as_bytes(means, (low, high)), box_of(grid, part), (low, high), part.step)


def part_in_view(grid: Grid, x: Ends, y: Ends, pixels: int = PIXELS) -> Part:
    """Return the points that meet a view, m, in blocks of which at most `pixels` lie along a side.

    The point of index i covers (i ± ½)·spacing. Of a view beyond the cell one point stays. Blocks start at multiples of
    their size, so that an image does not shimmer while the view is moved.
    """
    sides = []  # along x and y: the points in view, and how many of them make one pixel
    for count, spacing, ends in zip(grid.shape, grid.spacing, (x, y), strict=True):
        # the first and the last point in view, and the smallest block that needs few enough pixels
        first, last = (int(np.clip(np.floor(end / spacing + 0.5), 0, count - 1)) for end in sorted(ends))
        step = -(-(last + 1 - first) // pixels)
        while -(-(last + 1) // step) - first // step > pixels:  # whole blocks reach beyond the view
            step += 1
        sides.append((slice(first // step * step, min(-(-(last + 1) // step) * step, count)), step))
    (x_part, x_step), (y_part, y_step) = sides
    return Part(x_part, y_part, (x_step, y_step))


def box_of(grid: Grid, part: Part) -> tuple[float, float, float, float]:
    """Return left, bottom, width and height of the image of a part, m; the last blocks may reach beyond the cell."""
    (left, width), (bottom, height) = (
        ((side.start - 0.5) * d, -(-(side.stop - side.start) // step) * step * d)
        for side, step, d in zip(part[:2], part.step, grid.spacing, strict=True)
    )
    return left, bottom, width, height


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
