"""Distribution of the temperature over the contact of two sliding bodies, at the last positions of a slide."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from roughsim.grid import Array, Grid
from roughsim.observables.distribution import Distribution
from roughsim.observables.temperatures import distribution_of

if TYPE_CHECKING:  # no circle
    from roughsim.sliding.stepping import Step

POSITIONS = (
    8  # of a slide, at equal distances over the part at its end that all means are taken over
)


class Sampler:
    """Takes the temperatures of the contact at the last positions of a slide, of the moving body above its background.

    `ends` are the last steps at each speed; the positions come after the part `late` of the steps to each.
    """

    def __init__(self, grid: Grid, ends: Sequence[int], late: float) -> None:
        self.shape = grid.shape
        self.steps = [positions(end, late) for end in ends]
        # by speed, an array (points,) for each position
        self.pressures: list[list[Array]] = [[] for _ in ends]
        self.temperatures: list[list[Array]] = [[] for _ in ends]

    def add(self, n: int, step: "Step") -> None:
        """Take step n, if it is among the last positions at a speed."""
        from roughsim import (
            fourier,
        )  # loads the transforms: the names above are read by all who plan a run

        pressure = step.contact.pressure
        for k, (steps, spectrum) in enumerate(zip(self.steps, step.temperatures, strict=True)):
            if n in steps and spectrum is not None:
                above = fourier.inverse(spectrum, self.shape) - spectrum[0, 0].real
                self.temperatures[k].append(above[pressure > 0.0].astype(np.float32))
                self.pressures[k].append(pressure[pressure > 0.0].astype(np.float32))

    @property
    def flash_temperature(self) -> Array:
        """T_flash of the temperatures taken, all positions together, K, (speeds,)."""
        pressures, temperatures = self._joined()
        return np.array(
            [
                np.average(hot, weights=heat)
                for hot, heat in zip(temperatures, pressures, strict=True)
            ]
        )

    def together(self, flash_temperature: Array) -> Distribution:
        """Return the distribution over all positions together, scaled to a T_flash, (speeds,), K."""
        pressures, temperatures = self._joined()
        return distribution_of(temperatures, pressures, flash_temperature)

    def _joined(self) -> list[list[Array]]:
        """Return pressures and temperatures of all positions together, by speed."""
        return [
            [np.concatenate(rows, dtype=np.float32) for rows in kept]
            for kept in (self.pressures, self.temperatures)
        ]


def positions(end: int, late: float) -> frozenset[int]:
    """Return up to `POSITIONS` steps at equal distances, from the first after the part `late` of a slide to its end."""
    first = int(late * end) + 1
    return frozenset(np.rint(np.linspace(first, end, POSITIONS)).astype(int).tolist())
