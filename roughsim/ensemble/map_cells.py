"""Cells of a pressed map, the source of its members: the map itself and its four quadrants, made periodic."""

from dataclasses import dataclass, replace
from math import ceil, pi
from typing import Any

import numpy as np

from roughsim.ensemble.sources import DrawnSurfaces
from roughsim.grid import Array, Grid
from roughsim.observables.moments import measure
from roughsim.observables.temperatures import flash_temperature_along
from roughsim.pipeline import Problem, Solution, solve_problem
from roughsim.results.pressed import DIRECTIONS, OVERSHOOT
from roughsim.show.text import note
from roughsim.surface.topography.periodic import (
    band_limited,
    gaussian_twin,
    mirrored,
    overshoots,
    periodic_part,
)
from roughsim.surface.topography.reading import Topography

# of the random phases of the surrogate; no level of a run has it
_SURROGATE_STREAM = 2**32 - 1


def cell_of(heights: Array, grid: Grid, edges: str) -> Topography:
    """Return a map made periodic."""
    if edges == "mirror":
        (nx, ny), (x, y) = grid.shape, grid.lengths
        heights, grid = mirrored(heights), Grid((2 * nx, 2 * ny), (2 * x, 2 * y))
    return Topography(heights, grid, periodic=True)


def quadrants(topography: Topography) -> tuple[Topography, ...]:
    """Return the four quadrants of a map with their mirror images; of an odd number of points the last is left out."""
    nx, ny = (n // 2 for n in topography.grid.shape)
    dx, dy = topography.grid.spacing
    grid = Grid((nx, ny), (nx * dx, ny * dy))
    parts = [topography.heights[i : i + nx, j : j + ny] for i in (0, nx) for j in (0, ny)]
    return tuple(cell_of(part, grid, "mirror") for part in parts)


@dataclass(frozen=True, slots=True, eq=False)
class MapCells(DrawnSurfaces):
    """Surfaces of a pressed map: each realization is one of its cells, at all levels."""

    topography: Topography
    cells: tuple[Topography, ...]  # made periodic: the map alone, or its quadrants
    edges: str
    directions: tuple[float, ...]  # of sliding in the scene, radians
    last: bool  # whether it is the level of the directions

    def heights(self, problem: Problem) -> Array:
        """Return a cell with the waves of the level, m, on its grid."""
        cell = self.cells[problem.index]
        q_max = float(problem.spectrum.breaks[-1])
        return band_limited(cell.heights, cell.grid, problem.grid.shape, q_max)

    def about(self, problem: Problem, solution: Solution) -> dict[str, Any]:
        """Return the additions of the last level: T_flash by direction, and the share of the load beside spikes."""
        if not self.last:
            return {}
        lay = self.topography.texture.lay
        angles = {"along": lay, "across": (lay + 0.5 * pi) % pi}
        for number, angle in enumerate(self.directions, start=1):
            angles["asked" if len(self.directions) == 1 else f"asked_{number}"] = angle
        ratios: dict[str, Any] = {
            "angles": angles,
            "over_mean": over_mean(problem, solution, angles, self.edges),
        }
        if len(self.cells) == 1:
            note("the map and its phase-randomized surrogate")
            own = self.topography.grid
            sides = zip(own.lengths, problem.grid.lengths, problem.grid.shape, strict=True)
            nx, ny = (round(n * side / cell) for side, cell, n in sides)
            alone = replace(problem, grid=Grid((nx, ny), own.lengths))
            ratios["over_twin"] = over_twins(alone, self.topography, 1)[0].tolist()
        cell, pressure = self.cells[problem.index], solution.contact.pressure
        q_max = float(problem.spectrum.breaks[-1])
        beside = overshoots(solution.heights, cell.heights, cell.grid, q_max)
        return {DIRECTIONS: ratios, OVERSHOOT: float(pressure[beside].sum() / pressure.sum())}


def over_mean(
    problem: Problem, solution: Solution, angles: dict[str, float], edges: str
) -> dict[str, list[float]]:
    """Return T_flash in each direction over the mean over all directions, at each speed, of one contact.

    Mirror images turn an oblique lay to the other side. So of a mirrored cell the pressure on the map itself is
    continued periodically: heat may have steps at the edges.
    """
    pressure = np.asarray(solution.contact.pressure, np.float64)
    grid = problem.grid
    if edges == "mirror":
        nx, ny = (n // 2 for n in grid.shape)
        x, y = (side / 2 for side in grid.lengths)
        pressure = pressure[:nx, :ny].copy()
        grid = Grid((nx, ny), (x, y))
    mean = measure(
        replace(solution.contact, pressure=pressure), grid, problem.sliding
    ).flash_temperature
    result = {}
    for name, angle in angles.items():
        with np.errstate(invalid="ignore", divide="ignore"):  # 0/0 at rest
            ratio = flash_temperature_along(pressure, grid, problem.sliding, angle) / mean
        result[name] = np.where(np.isfinite(ratio), ratio, 1.0).tolist()
    return result


def points_of(grid: Grid, pixels: float, q_max: float) -> tuple[int, int]:
    """Return the points of a cell with so many pixels per shortest wave, 2π/`q_max`, along its coarser side."""
    factor = pixels * q_max * max(grid.spacing) / (2 * pi)
    x, y = (4 * ceil(n * factor / 4 - 1e-4) for n in grid.shape)
    return x, y


def over_twins(problem: Problem, topography: Topography, draws: int) -> Array:
    """Return T_flash of a map over T_flash of each of its phase-randomized twins, shape (`draws`, speeds).

    The grid of `problem` has the map's own sides. A map that is not periodic is replaced by its periodic part, so that
    all have the same |h(q⃗)| without a step, and without crossed lays.
    """
    own = topography.grid
    heights = topography.heights if topography.periodic else periodic_part(topography.heights)
    rng = np.random.default_rng(
        np.random.SeedSequence(problem.seed, spawn_key=(_SURROGATE_STREAM,))
    )
    q_max = float(problem.spectrum.breaks[-1])

    def flash(surface: Array) -> Array:
        fine = band_limited(surface, own, problem.grid.shape, q_max)
        return solve_problem(problem, heights=fine).observables.flash_temperature

    of_map = flash(heights)
    return np.array([of_map / flash(gaussian_twin(heights, rng)) for _ in range(draws)])
