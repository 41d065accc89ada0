"""What of a field is sent to a screen: the part in view, averaged over blocks of points, as bytes."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughsim import fourier
from roughsim.grid import Grid

Field = NDArray[Any]
PIXELS = 512  # per side of an image: more would not be seen, and each is sent at every move of the slider
PREVIEW = 1024  # points per side that the temperature is recomputed on while the slider moves


class Part(NamedTuple):
    """Points of a field that are in view, and how many of them, along x and y, make one pixel of the image."""

    x: slice
    y: slice
    step: tuple[int, int]

    @property
    def averaged(self) -> bool:
        """Whether a pixel is the mean of several points."""
        return max(self.step) > 1


class Box(NamedTuple):
    """Where an image lies: its lower left corner and its sides, m."""

    x: float
    y: float
    width: float
    height: float


def part_in_view(grid: Grid, x: tuple[float, float], y: tuple[float, float], pixels: int = PIXELS) -> Part:
    """Return the points whose pixels meet a view, in blocks few enough for an image.

    Blocks start at multiples of their size, so that an image does not shimmer while the view is moved.

    Parameters
    ----------
    grid : Grid
        Of the field; the point of index i covers (i ± ½)·spacing.
    x, y : (float, float)
        Ends of the view, m, in any order; what lies outside the cell is left out, and one point always stays.
    pixels : int
        Most blocks along either side.
    """
    sides = zip(grid.shape, grid.spacing, (x, y), strict=True)
    (x_part, x_step), (y_part, y_step) = (_along(*side, pixels) for side in sides)
    return Part(x_part, y_part, (x_step, y_step))


def _along(count: int, spacing: float, ends: tuple[float, float], pixels: int) -> tuple[slice, int]:
    first, last = (int(np.clip(np.floor(end / spacing + 0.5), 0, count - 1)) for end in sorted(ends))
    step = -(-(last + 1 - first) // pixels)
    while -(-(last + 1) // step) - first // step > pixels:  # whole blocks reach beyond the view
        step += 1
    return slice(first // step * step, min(-(-(last + 1) // step) * step, count)), step


def box_of(grid: Grid, part: Part) -> Box:
    """Return where the image of a part lies; its last blocks may reach beyond the cell."""
    starts = [(side.start - 0.5) * d for side, d in zip(part[:2], grid.spacing, strict=True)]
    sizes = [
        -(-(side.stop - side.start) // step) * step * d
        for side, step, d in zip(part[:2], part.step, grid.spacing, strict=True)
    ]
    return Box(starts[0], starts[1], sizes[0], sizes[1])


def averaged(field: Field, part: Part) -> Field:
    """Return the means of a field over the blocks of a part; the last blocks hold what points there are."""
    return _means(_means(field[part.x, part.y], part.step[0]).T, part.step[1]).T


def _means(lines: Field, step: int) -> Field:
    """Means over groups of `step` neighbouring lines."""
    if step == 1:
        return lines
    whole, rest = divmod(len(lines), step)
    means: Field = lines[: whole * step].reshape(whole, step, -1).mean(axis=1)
    return np.concatenate([means, lines[whole * step :].mean(axis=0, keepdims=True)]) if rest else means


def as_bytes(image: Field, limits: tuple[float, float]) -> NDArray[np.uint8]:
    """Return 0…255 for values from the lower to the upper limit, shape (y, x) as screens draw; flat fields are 0."""
    low, high = limits
    scale = 255.0 / (high - low) if high > low else 0.0
    levels = np.clip((image.T - low) * scale, 0.0, 255.0)
    return np.ascontiguousarray(np.rint(levels).astype(np.uint8))


def preview_grid(grid: Grid) -> Grid:
    """Return the grid of the same cell with at most 1024 points per side."""
    return Grid((min(grid.shape[0], PREVIEW), min(grid.shape[1], PREVIEW)), grid.lengths)


def preview_of(field: Field, grid: Grid) -> Field:
    """Return the field on its preview grid, of the same waves up to the preview's own Nyquist wavenumber.

    The temperature is linear in the heat, wave by wave, so these waves of the preview are those of the full field.
    """
    target = preview_grid(grid)
    if target.shape == grid.shape:
        return field
    spectrum = fourier.forward(field)
    kept = np.zeros(target.half_shape, spectrum.dtype)
    half, columns = -(-target.shape[0] // 2), -(-target.shape[1] // 2)  # the waves at the Nyquist wavenumber stay out
    kept[:half, :columns] = spectrum[:half, :columns]
    if half > 1:
        kept[1 - half :, :columns] = spectrum[1 - half :, :columns]
    return fourier.inverse(kept, target.shape)
