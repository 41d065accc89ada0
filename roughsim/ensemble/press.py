"""`press`: a measured map itself in contact, in a run folder that reads like that of drawn surfaces."""

import hashlib
import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import ceil, pi
from pathlib import Path
from typing import Any, Literal, NamedTuple

from roughsim import prediction
from roughsim.ensemble.directions import by_direction
from roughsim.ensemble.executors import Workers, interrupted_by_signals
from roughsim.ensemble.run import begin, complete, fit
from roughsim.errors import ConvergenceError, ResolutionError
from roughsim.grid import Array, Grid
from roughsim.machine import exceeds
from roughsim.pipeline import Problem, Solution
from roughsim.planning.levels import PIXELS
from roughsim.results.folder import folder_state, open_run
from roughsim.results.pressed import DIRECTIONS, OVERSHOOT
from roughsim.results.run import Run
from roughsim.scene import Scene, SceneError
from roughsim.scene.files import load_map
from roughsim.scene.numerics import SLIDING, Column, Level, Numerics, Reason
from roughsim.show.text import note
from roughsim.store.kinds import MAP, QUARTERS
from roughsim.surface.topography import Topography
from roughsim.surface.topography.periodic import band_limited, mirrored, overshoots

LEAST_SIDE = 64  # points of a map
MOST_SIDE = 2048  # points per side of the contact of a map
BYTES_PER_POINT = 64.0  # of the map with its mirror images
EDGES = {
    "mirror": "made periodic by its mirror images: no step, but the slope changes its sign at the edges",
    "tile": "side by side as it is: where opposite edges differ there is a step, which carries load",
}
ALL_WAVES = "all waves that the map shows; none are added beyond"
FEWER_WAVES = "too many points for the shortest waves; what half the cut-off changes shows what they may do"
Edges = Literal["mirror", "tile"]


def press(
    scene: str | os.PathLike[str] | Mapping[str, Any],
    folder: str | Path,
    *,
    edges: Edges | None = None,
    changes: Mapping[str, Any] | None = None,
    workers: int | None = 1,
) -> Run:
    """Press the very map that [surface] topography of a scene names, and each of its quarters.

    The run has one realization, the map, with all of its waves and no shorter ones: nothing is continued beyond its
    Nyquist wavenumber. Its waves are put on finer points, at two pixels, and the value is that of a vanishing pixel.
    Cells above 2048 points per side lose their shortest waves; what the last step of the cut-off changed is then part
    of the error. The statistical error is that of the four quarters, pressed alike. T_flash is a mean over all
    directions of sliding. On the finest points it is also known along and across the lay of the map and in
    `sliding.direction`, and over T_flash of a Gaussian twin of the map: with the same |h(q)|, and random phases.

    Parameters
    ----------
    scene : str, path or mapping
        As for `load_scene`; its [surface] names one map, and the counterface is smooth.
    folder : str or Path
        Where the run goes; the same call goes on where it was stopped.
    edges : {"mirror", "tile"}, optional
        How the map is made periodic. "mirror": with its mirror images, in a cell of twice its sides, without a step.
        "tile": as it is, side by side; where opposite edges differ there is a step, which carries load. Left out: tile
        if the file says that the map is periodic, else mirror.
    changes : mapping, optional
        Other values of some keys of the scene, as for `load_scene`.
    workers : int, optional
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
    loaded, topography = load_map(scene, changes)
    loaded = prediction.computed(loaded)
    refuse(loaded, topography.grid, edges)
    edges = edges or ("tile" if topography.periodic else "mirror")
    whole, parts = cell_of(topography.heights, topography.grid, edges), quarters(topography)
    resolution = resolution_of(loaded, whole.grid)
    digest = hashlib.sha256(topography.heights.tobytes()).hexdigest()
    begun = []
    for kind, home, cells, how in (
        (MAP, Path(folder), [whole], edges),
        (QUARTERS, Path(folder) / QUARTERS, parts, "mirror"),
    ):
        own = replace(loaded, ensemble=replace(loaded.ensemble, until=(), max_realizations=len(cells)))
        numerics = None if folder_state(home) == "run" else numerics_of(own, cells[0].grid, resolution, how)
        if numerics is not None:
            fit(allowed, [(own, numerics)])
        numerics = begin(own, home, numerics, pressed={"of": kind, "edges": how, "heights": digest})
        surfaces = MapSurfaces(kind, topography, tuple(cells), how, loaded.sliding.direction, len(numerics.levels) - 1)
        begun.append(((own, numerics, home), surfaces))
    with interrupted_by_signals(), allowed:
        for one, surfaces in reversed(begun):  # the errors of the map are those of its quarters
            (run,) = complete([one], allowed, surfaces=surfaces)
            for member in run.members.values():
                if member.failure:
                    about = member.provenance
                    raise ConvergenceError(member.failure, about["residual"], about["iterations"])
    return open_run(folder)


def refuse(scene: Scene, grid: Grid, edges: str | None) -> None:
    """Refuse what is no single map against a smooth face, a map that is too small or too large, and unknown edges."""
    if edges not in (None, "mirror", "tile"):
        raise ValueError(f'edges = {edges!r} is not known; write "mirror" or "tile"')
    if len(scene.faces) > 1:
        raise SceneError(
            "counterface is rough, but there is one map; to press it give the counterface its material alone, without "
            'like = "body" and without keys of roughness; if you have maps of both faces, name the map of their sum'
        )
    if scene.sliding.history == SLIDING:
        raise SceneError('sliding.history = "sliding" does not go with a map that is pressed; write "frozen"')
    if min(grid.shape) < LEAST_SIDE:
        raise ResolutionError(f"the map has {grid.shape} points; to press it takes {LEAST_SIDE} along each side")
    if exceeds(needed := BYTES_PER_POINT * 4 * grid.points, 0.5):
        raise ResolutionError(
            f"the map of {grid.shape} points needs {1e-9 * needed:.3g} GB with its mirror images, above half of the "
            "available memory; crop it or make it coarser"
        )


class Cell(NamedTuple):
    """A periodic map."""

    heights: Array  # m
    grid: Grid


def cell_of(heights: Array, grid: Grid, edges: str) -> Cell:
    """Return a map made periodic."""
    if edges == "tile":
        return Cell(heights, grid)
    (nx, ny), (x, y) = grid.shape, grid.lengths
    return Cell(mirrored(heights), Grid((2 * nx, 2 * ny), (2 * x, 2 * y)))


def quarters(topography: Topography) -> list[Cell]:
    """Return the four quarters of a map with their mirror images; of an odd number of points the last is left out."""
    (nx, ny), (dx, dy) = (n // 2 for n in topography.grid.shape), topography.grid.spacing
    grid = Grid((nx, ny), (nx * dx, ny * dy))
    parts = (topography.heights[i : i + nx, j : j + ny] for i in (0, nx) for j in (0, ny))
    return [cell_of(part, grid, "mirror") for part in parts]


class Resolution(NamedTuple):
    """The waves of a map that are pressed, and the points that they are pressed on."""

    q_max: float  # rad/m
    pixels: float  # per shortest wave, of the coarser of two grids; the finer one has twice as many
    whole: bool  # whether these are all waves of the map


def resolution_of(scene: Scene, grid: Grid) -> Resolution:
    """Return the waves and the pixels of a cell, for at most 2048 points per side, and twice that on the finer grid.

    Maps of few points have 4 and 8 pixels per shortest wave; others 2 and 4, with their shortest waves left out where
    the points do not suffice.
    """
    longest = max(n * max(grid.spacing) for n in grid.shape)  # with square pixels
    all_waves = min(grid.nyquist, float(scene.spectrum.breaks[-1]))
    if 2 * PIXELS * all_waves * longest / (2 * pi) <= MOST_SIDE * (1 + 1e-9):
        return Resolution(all_waves, PIXELS, whole=True)
    most = pi * MOST_SIDE / longest
    # a mode at the Nyquist wavenumber of a coarser grid would lose half of itself
    return Resolution(min(all_waves, most * (1 - 1e-6)), PIXELS / 2, whole=all_waves <= most * (1 + 1e-9))


def numerics_of(scene: Scene, grid: Grid, resolution: Resolution, edges: str) -> Numerics:
    """Return the levels of a map: its waves on two grids, and where it is not all of them half the cut-off, too."""
    column: Column = "elastic" if scene.elastic else "capped"
    given, (q_max, pixels, whole) = scene.numerics, resolution
    per_point = pixels * q_max * max(grid.spacing) / (2 * pi)  # points of the level per point of the map
    x, y = (4 * ceil(n * per_point / 4 - 1e-4) for n in grid.shape)
    levels = [((x, y), q_max), ((2 * x, 2 * y), q_max)]
    if not whole:
        levels = [((x // 2, y // 2), q_max / 2), ((x, y), q_max / 2), *levels]
    chosen: dict[str, Any] = {key: getattr(given, key) for key in ("tolerance", "precision", "threads", "keep_fields")}
    reasons = (
        Reason("surface", f"{grid.shape[0]} × {grid.shape[1]} points", EDGES[edges]),
        Reason("cut-off", f"{q_max:.3g} rad/m", ALL_WAVES if whole else FEWER_WAVES),
        Reason("pixels", f"{pixels:g} and {2 * pixels:g} per shortest wave", "their difference shows what is left"),
        Reason("realizations", "1", "the map itself; its four quarters, pressed alike, show the scatter"),
    )
    return Numerics(
        levels=tuple(Level(column, shape, q) for shape, q in levels),
        lengths=grid.lengths,
        **{key: value for key, value in chosen.items() if value is not None},
        reasons=reasons,
    )


@dataclass(frozen=True, slots=True, eq=False)
class MapSurfaces:
    """Surfaces of the members of a pressed map: each realization is one of its cells, at all levels."""

    kind: str  # `MAP` or `QUARTERS`
    topography: Topography
    cells: tuple[Cell, ...]
    edges: str
    direction: float | None  # of sliding, radians, if the scene has one
    last: int  # level, at which the directions are found

    def heights(self, problem: Problem) -> Array:
        """Return a cell with the waves that the level has, m, on its grid."""
        name = "map" if self.kind == MAP else f"quarter {problem.index + 1}"
        note(f"{name}: {problem.grid.shape[0]} × {problem.grid.shape[1]} points")
        return band_limited(*self.cells[problem.index], problem.grid.shape, float(problem.spectrum.breaks[-1]))

    def about(self, level: int, problem: Problem, solution: Solution) -> dict[str, Any]:
        """Return what the last level adds: T_flash by direction, and the share of the load beside spikes."""
        if level != self.last:
            return {}
        twin = self.kind == MAP
        more = by_direction(self.direction, self.topography, problem, solution, self.edges, twin=twin)
        pressure = solution.contact.pressure
        beside = overshoots(solution.heights, *self.cells[problem.index], float(problem.spectrum.breaks[-1]))
        return {DIRECTIONS: more, OVERSHOOT: float(pressure[beside].sum() / pressure.sum())}
