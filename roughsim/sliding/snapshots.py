"""Maps of a few positions of a slide: the pressure, and the temperature of the moving body, to look at."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from roughsim.grid import Grid
from roughsim.sliding.path import Path

if TYPE_CHECKING:  # as in `add`
    from roughsim.sliding.stepping import Step

MOST_POINTS = 256  # along a side: of more points, blocks are averaged
LEAST_POINTS = 128  # along a side: rather than to fewer, nothing is averaged
Frames = NDArray[np.float32]


AXIS = "film_distance"
FIELDS = {  # unit, axes and description of each array in the file of a member
    AXIS: ("m", (AXIS,), "slid distance of the positions of the snapshots"),
    "film_pressure": ("Pa", (AXIS, "x", "y"), "contact pressure, in the frame of the resting body"),
    "film_temperature": (
        "K",
        ("speed", AXIS, "x", "y"),
        "surface of the moving body above its background, at its position then",
    ),
}


@dataclass(frozen=True, slots=True, eq=False)
class Snapshots:
    """Maps of both bodies' contact at a few positions, in the frame of the resting body.

    Attributes
    ----------
    distance : ndarray
        Slid until then, m, shape (positions,).
    pressure : ndarray
        Pa, shape (positions, points along x, along y); means over blocks of points if the grid is larger.
    temperature : ndarray
        Of the surface of the moving body above its background, K, shape (speeds, positions, …); NaN after the distance
        of a speed.
    """

    distance: Frames
    pressure: Frames
    temperature: Frames


class Projector:
    """Takes the fields of the steps `pictured` of a slide, ascending and from 1 on."""

    def __init__(self, grid: Grid, speeds: int, pictured: Sequence[int]) -> None:
        self.shape = grid.shape
        self.pictured = {step: place for place, step in enumerate(pictured)}
        sides = snapshot_shape(grid.shape)
        self.pressure = np.empty((len(pictured), *sides), np.float32)
        self.temperature = np.full((speeds, *self.pressure.shape), np.nan, np.float32)

    def add(self, n: int, step: "Step") -> None:
        """Take step n, if it is one of the snapshots."""
        from roughsim import (
            fourier,
        )  # loads the transforms: the names above are read by all who open a run

        if n not in self.pictured:
            return
        place = self.pictured[n]
        sides = self.pressure.shape[1:]
        self.pressure[place] = in_blocks(step.contact.pressure, sides)
        for k, spectrum in enumerate(step.temperatures):
            if spectrum is not None:
                surface = fourier.inverse(spectrum, self.shape)
                self.temperature[k, place] = in_blocks(surface - spectrum[0, 0].real, sides)

    def fields(self, path: Path) -> dict[str, Frames]:
        """Return the arrays of `Snapshots` by the names of `FIELDS`; none if no step was selected."""
        if not self.pictured:
            return {}
        distance = path.distance[list(self.pictured)].astype(np.float32)
        return dict(zip(FIELDS, (distance, self.pressure, self.temperature), strict=True))


def snapshot_shape(shape: tuple[int, int]) -> tuple[int, int]:
    """Return the points of a snapshot of fields of this shape: at most `MOST_POINTS` a side if whole blocks do."""
    x, y = (
        count
        // next(
            (
                n
                for n in range(ceil(count / MOST_POINTS), count // LEAST_POINTS + 1)
                if count % n == 0
            ),
            1,
        )
        for count in shape
    )
    return x, y


def in_blocks(field: NDArray[np.float64], sides: tuple[int, ...]) -> NDArray[np.float64]:
    """Return the means over equal blocks, as many as `sides`."""
    nx, ny = field.shape
    x, y = sides
    return field.reshape(x, nx // x, y, ny // y).mean(axis=(1, 3))
