"""Correlation of the stress of two sliding bodies with the stress at earlier positions."""

import numpy as np

from roughsim.grid import Array, Complex, Grid

_ANCHORS = 8  # positions with which the stress of later ones is correlated


class StressCorrelation:
    """Correlation of the stress at points of the resting body with the stress at several earlier positions."""

    def __init__(self, grid: Grid, positions: int) -> None:
        self.grid = grid
        self.every = 1
        self.taken = 0
        self.anchors: list[tuple[int, Complex]] = []
        self.sums = np.zeros(positions)
        self.counts = np.zeros(positions, np.intp)

    def add(self, stress: Complex) -> None:
        """Take the stress of the next position."""
        if self.taken % self.every == 0:
            self.anchors.append((self.taken, stress))
        if len(self.anchors) > _ANCHORS:  # every other one: they stay spread over the whole way
            self.anchors = self.anchors[::2]
            self.every = 2 * self.every
        square = stress[0, 0].real ** 2
        for position, earlier in self.anchors:
            self.sums[self.taken - position] += mean_product(self.grid, earlier, stress) - square
            self.counts[self.taken - position] += 1
        self.taken += 1

    def mean(self) -> Array:
        """Return the correlation at lags of 1, 2 … steps, relative to the mean variance; NaN without a variance."""
        correlation = self.sums[: self.taken] / self.counts[: self.taken]
        return correlation[1:] / (correlation[0] or np.nan)


def mean_product(grid: Grid, first: Complex, second: Complex) -> float:
    """Return the mean over the cell of the product of two real fields, from their half spectra."""
    edges = (
        [0] if grid.shape[1] % 2 else [0, -1]
    )  # columns that stand for themselves; the others for two
    return float(
        2 * np.vdot(first, second).real
        - sum(np.vdot(first[:, k], second[:, k]).real for k in edges)
    )
