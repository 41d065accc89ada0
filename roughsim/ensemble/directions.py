"""T_flash of a pressed map by the direction of sliding, and relative to a Gaussian twin."""

from dataclasses import replace

import numpy as np

from roughsim.grid import Grid
from roughsim.observables.directions import flash_temperature_along
from roughsim.observables.moments import measure
from roughsim.pipeline import Problem, Solution, solve_problem
from roughsim.surface.topography import Topography
from roughsim.surface.topography.periodic import band_limited, gaussian_twin, periodic_part

_TWIN_STREAM = 2**32 - 1  # of the random phases; no level of a run has it


def over_mean(problem: Problem, solution: Solution, angles: dict[str, float], edges: str) -> dict[str, list[float]]:
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
    mean = measure(replace(solution.contact, pressure=pressure), grid, problem.sliding).flash_temperature
    result = {}
    for name, angle in angles.items():
        with np.errstate(invalid="ignore", divide="ignore"):  # 0/0 at rest
            ratio = flash_temperature_along(pressure, grid, problem.sliding, angle) / mean
        result[name] = np.where(np.isfinite(ratio), ratio, 1.0).tolist()
    return result


def over_twin(problem: Problem, topography: Topography) -> list[float]:
    """Return T_flash of a map over T_flash of its Gaussian twin, at each speed, by two solves.

    The cell has the map's own sides, with pixels and cut-off of `problem`. A map that is not periodic is replaced by
    its periodic part, so that both have the same |h(q⃗)| without a step, and without crossed lays.
    """
    own = topography.grid
    heights = topography.heights if topography.periodic else periodic_part(topography.heights)
    sides = zip(own.lengths, problem.grid.lengths, problem.grid.shape, strict=True)
    nx, ny = (round(n * side / cell) for side, cell, n in sides)
    grid = Grid((nx, ny), own.lengths)
    rng = np.random.default_rng(np.random.SeedSequence(problem.seed, spawn_key=(_TWIN_STREAM,)))
    q_max = float(problem.spectrum.breaks[-1])
    temperatures = []
    for surface in (heights, gaussian_twin(heights, rng)):
        solved = solve_problem(replace(problem, grid=grid), heights=band_limited(surface, own, grid.shape, q_max))
        temperatures.append(solved.observables.flash_temperature)
    ratio: list[float] = (temperatures[0] / temperatures[1]).tolist()
    return ratio
