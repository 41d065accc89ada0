"""`press`: contact of a measured map itself, in place of random surfaces.

T_flash is also computed by the direction of sliding, and relative to a Gaussian twin of the map.
"""

import hashlib
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from math import ceil, pi
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from roughsim import prediction
from roughsim.ensemble.executors import Workers
from roughsim.ensemble.run import begin, complete, shown
from roughsim.ensemble.sources import DrawnSurfaces
from roughsim.errors import ConvergenceError, RecordError, ResolutionError
from roughsim.grid import Array, Grid
from roughsim.machine import exceeds
from roughsim.observables.directions import flash_temperature_along
from roughsim.observables.moments import measure
from roughsim.pipeline import Problem, Solution, solve_problem
from roughsim.planning.realization import below_problem, largest_member, level_problem
from roughsim.results.description import MAP, QUARTERS
from roughsim.results.folder import open_run
from roughsim.results.pressed import DIRECTIONS, OVERSHOOT
from roughsim.results.run import Run
from roughsim.scene import Scene, SceneError, SceneSource
from roughsim.scene.files import load_map
from roughsim.scene.numerics import SLIDING, Column, Level, Numerics
from roughsim.show.remarks import Remark, warn_of
from roughsim.show.text import note
from roughsim.store.disk import set_aside
from roughsim.surface.topography import Topography
from roughsim.surface.topography.periodic import (
    band_limited,
    gaussian_twin,
    mirrored,
    overshoots,
    periodic_part,
)
from roughsim.surface.topography.sums import sum_of_faces

_LEAST_SIDE = 64  # points of a map
MOST_SIDE = 2048  # points per side of the contact of a map
_PIXELS = 4  # per shortest wave of a map of few points, on the coarser of its grids
_BYTES_PER_POINT = 64.0  # of the map with its mirror images
_TWIN_STREAM = 2**32 - 1  # of the random phases of the twin; no level of a run has it
_EDGES = {
    "mirror": "made periodic by its mirror images: no step, but the slope changes its sign at the edges",
    "tile": "repeated side by side: unequal opposite edges make a step, which carries load",
}
Edges = Literal["mirror", "tile"]


def press(
    scene: SceneSource,
    folder: str | Path,
    *,
    edges: Edges | None = None,
    changes: Mapping[str, Any] | None = None,
    workers: int | None = 1,
    progress: bool = True,
) -> Run:
    """Press the measured map of a scene itself, or the sum of the maps of both faces; its quarters give the scatter.

    All waves of the map are pressed, on two grids of finer points, and the value is extrapolated to a vanishing pixel.
    Maps above 2048 points per side lose their shortest waves; the change from half the cut-off is then part of the
    error. T_flash is a mean over all directions of sliding. On the finest grid it is also computed along and across the
    lay of the map, in `sliding.direction`, and for a Gaussian twin: a map with the same |h(q)| and random phases.

    Parameters
    ----------
    scene : str, path or mapping
        As for `load_scene`; its [surface] names one map, and the counterface is smooth or names one of its own: then
        their sum is pressed, see `roughsim.surface.topography.sums`.
    folder : str or Path
        Folder of the run; the same call resumes it.
    edges : {"mirror", "tile"}, optional
        Way to make the map periodic. "mirror": with its mirror images, in a cell of twice its sides, without a step.
        "tile": repeated side by side, with steps at unequal opposite edges. Default: tile if the file marks the map as
        periodic, else mirror.
    changes : mapping, optional
        Other values of some keys of the scene, as for `load_scene`.
    workers : int, optional
        As of `roughsim.run`.
    progress : bool
        As of `roughsim.run`.

    Returns
    -------
    Run
        As from `run`.

    Raises
    ------
    SceneError, RecordError, ResolutionError
        If the scene or the map cannot be pressed, or the folder holds another run.
    ConvergenceError
        If a contact misses the tolerance.
    """
    allowed = Workers(workers)
    loaded, maps = load_map(scene, changes)
    loaded = prediction.computed(loaded)
    topography = maps[0] if len(maps) == 1 else sum_of_faces(*maps)
    _refuse(loaded, len(maps), topography.grid, edges)
    edges = edges or ("tile" if topography.periodic else "mirror")
    whole = cell_of(topography.heights, topography.grid, edges)
    resolution = resolution_of(loaded, whole.grid)
    digest = hashlib.sha256(topography.heights.tobytes()).hexdigest()
    folder = Path(folder)
    parts = [
        (MAP, folder, [whole], edges),
        (QUARTERS, folder / QUARTERS, quarters(topography), "mirror"),
    ]
    begun = []
    for kind, home, cells, joined in parts:
        own = replace(loaded, ensemble=replace(loaded.ensemble, realizations=len(cells)))
        numerics = _numerics(own, cells[0].grid, resolution, joined)
        if len(maps) > 1:
            numerics = replace(
                numerics,
                reasons=(
                    *numerics.reasons,
                    Remark("choice", "map", topography.taken, "of both faces"),
                ),
            )
        allowed.fit(*largest_member(own, numerics), numerics.threads)
        numerics = _begin(own, home, numerics, {"of": kind, "edges": joined, "heights": digest})
        source = partial(map_cells, kind, topography, tuple(cells), joined)
        begun.append(((own, numerics, home), source))
    with allowed, shown(progress, "pressing") as bar:
        for one, source in reversed(begun):  # the quarters first: they give the errors of the map
            (run,) = complete([one], allowed, None if bar is None else bar.update, source=source)
            for member in run.members.values():
                if member.failure:
                    about = member.provenance
                    raise ConvergenceError(member.failure, about["residual"], about["iterations"])
    run = open_run(folder)
    warn_of(run.remarks)
    return run


def _begin(scene: Scene, home: Path, numerics: Numerics, about: Mapping[str, str]) -> Numerics:
    """Begin the run of a map, or of its quarters; other content in the place of the quarters is moved aside."""
    try:
        return begin(scene, home, numerics, press=about)
    except RecordError as error:
        if about["of"] == MAP or not home.exists():
            raise
        kept = set_aside(home, home.parent / "damaged")
        reason = str(error).partition(";")[0]
        words = f"{reason}; it was moved to {kept}, and the quarters are pressed again"
        warnings.warn(words, RuntimeWarning, stacklevel=3)
    return begin(scene, home, numerics, press=about)


def _refuse(scene: Scene, maps: int, grid: Grid, edges: str | None) -> None:
    """Refuse a rough face without a map, sliding contacts, maps that are too small or too large, and unknown edges."""
    if edges not in (None, *_EDGES):
        raise ValueError(f'edges = {edges!r} is not known; write "mirror" or "tile"')
    if len(scene.faces) > maps:
        raise SceneError(
            "counterface is rough, but there is one map; to press it give the counterface its material alone, without "
            'like = "body" and without keys of roughness, or a map of its own as topography'
        )
    if scene.sliding.history == SLIDING:
        raise SceneError(
            'sliding.history = "sliding" does not go with a map that is pressed; write "frozen"'
        )
    if min(grid.shape) < _LEAST_SIDE:
        raise ResolutionError(
            f"the map has {grid.shape} points; to press it takes {_LEAST_SIDE} along each side"
        )
    needed = 4 * _BYTES_PER_POINT * grid.points
    if exceeds(needed, 0.5):
        raise ResolutionError(
            f"the map of {grid.shape} points needs {1e-9 * needed:.3g} GB with its mirror images, above half of the "
            "available memory; crop it or make it coarser"
        )


def cell_of(heights: Array, grid: Grid, edges: str) -> Topography:
    """Return a map made periodic."""
    if edges == "mirror":
        (nx, ny), (x, y) = grid.shape, grid.lengths
        heights, grid = mirrored(heights), Grid((2 * nx, 2 * ny), (2 * x, 2 * y))
    return Topography(heights, grid, periodic=True)


def quarters(topography: Topography) -> list[Topography]:
    """Return the four quarters of a map with their mirror images; of an odd number of points the last is left out."""
    nx, ny = (n // 2 for n in topography.grid.shape)
    dx, dy = topography.grid.spacing
    grid = Grid((nx, ny), (nx * dx, ny * dy))
    parts = [topography.heights[i : i + nx, j : j + ny] for i in (0, nx) for j in (0, ny)]
    return [cell_of(part, grid, "mirror") for part in parts]


class Resolution(NamedTuple):
    """The cut-off of a map, and the points of its grids."""

    q_max: float  # rad/m
    pixels: float  # per shortest wave, of the coarser of two grids; the finer one has twice as many
    whole: bool  # whether no wave of the map is left out


def resolution_of(scene: Scene, grid: Grid) -> Resolution:
    """Return cut-off and pixels of a cell for at most 2048 points per side, and twice as many on the finer grid.

    Maps of few points have 4 and 8 pixels per shortest wave. Others have 2 and 4, without their shortest waves if the
    points do not suffice.
    """
    longest = max(n * max(grid.spacing) for n in grid.shape)  # with square pixels
    all_waves = min(grid.nyquist, float(scene.spectrum.breaks[-1]))
    if 2 * _PIXELS * all_waves * longest / (2 * pi) <= MOST_SIDE * (1 + 1e-9):
        return Resolution(all_waves, _PIXELS, whole=True)
    most = pi * MOST_SIDE / longest
    # a mode at the Nyquist wavenumber of a coarser grid would lose half of itself
    return Resolution(
        min(all_waves, most * (1 - 1e-6)), _PIXELS / 2, whole=all_waves <= most * (1 + 1e-9)
    )


def _numerics(scene: Scene, grid: Grid, resolution: Resolution, edges: str) -> Numerics:
    """Return the levels of a map: the cut-off on two grids, and half of it on two more if waves are left out."""
    column: Column = "elastic" if scene.elastic else "capped"
    q_max, pixels, whole = resolution
    factor = (
        pixels * q_max * max(grid.spacing) / (2 * pi)
    )  # points of the level per point of the map
    x, y = (4 * ceil(n * factor / 4 - 1e-4) for n in grid.shape)
    levels = [Level(column, (x, y), q_max), Level(column, (2 * x, 2 * y), q_max)]
    if not whole:
        lower = [Level(column, (x // 2, y // 2), q_max / 2), Level(column, (x, y), q_max / 2)]
        levels = [*lower, *levels]
    given = {
        key: getattr(scene.numerics, key)
        for key in ("tolerance", "precision", "threads", "keep_fields")
    }
    chosen: dict[str, Any] = {key: value for key, value in given.items() if value is not None}
    waves = "all waves of the map; none are added beyond"
    if not whole:
        waves = "too many points for the shortest waves; half the cut-off shows their effect"
    reasons = (
        Remark("choice", "surface", _EDGES[edges], f"{grid.shape[0]} × {grid.shape[1]} points"),
        Remark("choice", "cut-off", waves, f"{q_max:.3g} rad/m"),
        Remark(
            "choice",
            "pixels",
            "their difference gives the pixel error",
            f"{pixels:g} and {2 * pixels:g} per shortest wave",
        ),
        Remark(
            "choice",
            "realizations",
            "the map itself; its four quarters, pressed alike, give the scatter",
            "1",
        ),
    )
    return Numerics(levels=tuple(levels), lengths=grid.lengths, **chosen, reasons=reasons)


@dataclass(frozen=True, slots=True, eq=False)
class MapCells(DrawnSurfaces):
    """Surfaces of a pressed map: each realization is one of its cells, at all levels."""

    kind: str  # `MAP` or `QUARTERS`
    topography: Topography
    cells: tuple[Topography, ...]  # made periodic
    edges: str
    direction: float | None  # of sliding in the scene, radians
    last: bool  # whether it is the level of the directions

    def heights(self, problem: Problem) -> Array:
        """Return a cell with the waves of the level, m, on its grid."""
        cell = self.cells[problem.index]
        return band_limited(
            cell.heights, cell.grid, problem.grid.shape, float(problem.spectrum.breaks[-1])
        )

    def about(self, problem: Problem, solution: Solution) -> dict[str, Any]:
        """Return the additions of the last level: T_flash by direction, and the share of the load beside spikes."""
        if not self.last:
            return {}
        lay = self.topography.texture.lay
        angles = {"along": lay, "across": (lay + 0.5 * pi) % pi}
        if self.direction is not None:
            angles["asked"] = self.direction
        ratios: dict[str, Any] = {
            "angles": angles,
            "over_mean": over_mean(problem, solution, angles, self.edges),
        }
        if self.kind == MAP:
            note("the map and its Gaussian twin")
            ratios["over_twin"] = _over_twin(problem, self.topography)
        cell, pressure = self.cells[problem.index], solution.contact.pressure
        beside = overshoots(
            solution.heights, cell.heights, cell.grid, float(problem.spectrum.breaks[-1])
        )
        return {DIRECTIONS: ratios, OVERSHOOT: float(pressure[beside].sum() / pressure.sum())}


def map_cells(
    kind: str,
    topography: Topography,
    cells: tuple[Topography, ...],
    edges: str,
    run: Run,
    level: int,
) -> MapCells:
    """Return the source of a level of a map, or of its quarters."""
    scene, numerics = run.scene, run.numerics
    return MapCells(
        level,
        level_problem(scene, numerics, level),
        below_problem(scene, numerics, level),
        kind,
        topography,
        cells,
        edges,
        scene.sliding.direction,
        level == len(numerics.levels) - 1,
    )


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


def _over_twin(problem: Problem, topography: Topography) -> list[float]:
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
        solved = solve_problem(
            replace(problem, grid=grid), heights=band_limited(surface, own, grid.shape, q_max)
        )
        temperatures.append(solved.observables.flash_temperature)
    ratio: list[float] = (temperatures[0] / temperatures[1]).tolist()
    return ratio
