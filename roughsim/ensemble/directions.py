"""What the press of a map adds to its contact: T_flash by the direction of sliding, and over a Gaussian twin."""

from dataclasses import replace
from math import pi
from typing import Any

import numpy as np

from roughsim.grid import Array, Grid
from roughsim.observables.directions import flash_temperature_along
from roughsim.observables.moments import measure
from roughsim.pipeline import Problem, Solution, solve_problem
from roughsim.show.text import note
from roughsim.surface.topography import Topography
from roughsim.surface.topography.periodic import band_limited, gaussian_twin, periodic_part

TWIN_STREAM = 2**32 - 1  # of the random phases; no level of a run has it


def by_direction(
    asked: float | None, topography: Topography, problem: Problem, solution: Solution, edges: str, *, twin: bool
) -> dict[str, Any]:
    """Return what a member stores: the directions, radians, and T_flash over its mean; with `twin` over that of one.

    The directions are along and across the lay of the whole map, and the one that is asked for, if any.
    """
    lay = topography.texture.lay
    angles = {"along": lay, "across": (lay + 0.5 * pi) % pi}
    if asked is not None:
        angles["asked"] = asked
    found: dict[str, Any] = {"angles": angles, "over_mean": over_mean(problem, solution, angles, edges)}
    if twin:
        note("the map and its Gaussian twin")
        found["over_twin"] = over_twin(problem, topography)
    return found


def over_mean(problem: Problem, solution: Solution, angles: dict[str, float], edges: str) -> dict[str, list[float]]:
    """Return T_flash in each direction over the mean over all directions, at each speed, of one contact.

    Mirror images turn an oblique lay to the other side. So of a mirrored cell the pressure on the map itself is taken,
    and continued periodically: heat may have steps at the edges.
    """
    pressure, grid = np.asarray(solution.contact.pressure, np.float64), problem.grid
    if edges == "mirror":
        (nx, ny), (x, y) = grid.shape, grid.lengths
        pressure, grid = pressure[: nx // 2, : ny // 2].copy(), Grid((nx // 2, ny // 2), (x / 2, y / 2))
    mean = measure(replace(solution.contact, pressure=pressure), grid, problem.sliding).flash_temperature
    found = {}
    for name, angle in angles.items():
        with np.errstate(invalid="ignore", divide="ignore"):  # 0/0 at rest
            ratio = flash_temperature_along(pressure, grid, problem.sliding, angle) / mean
        found[name] = np.where(np.isfinite(ratio), ratio, 1.0).tolist()
    return found


def over_twin(problem: Problem, topography: Topography) -> list[float]:
    """Return T_flash of a map over that of its Gaussian twin, at each speed, by two solves.

    Both are in a cell of the map's own sides, with pixels and cut-off of `problem`. A map that is not periodic is taken
    by its periodic part there, so that both have the same |h(q⃗)| without a step, and without crossed lays.
    """
    heights, own = topography.heights, topography.grid
    if not topography.periodic:
        heights = periodic_part(heights)
    sides = zip(own.lengths, problem.grid.lengths, problem.grid.shape, strict=True)
    nx, ny = (round(n * side / cell) for side, cell, n in sides)
    grid = Grid((nx, ny), own.lengths)
    rng = np.random.default_rng(np.random.SeedSequence(problem.seed, spawn_key=(TWIN_STREAM,)))
    q_max, found = float(problem.spectrum.breaks[-1]), list[Array]()
    for surface in (heights, gaussian_twin(heights, rng)):
        solved = solve_problem(replace(problem, grid=grid), heights=band_limited(surface, own, grid.shape, q_max))
        found.append(solved.observables.flash_temperature)
    ratio: list[float] = (found[0] / found[1]).tolist()
    return ratio
