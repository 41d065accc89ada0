"""`press`: contact of a measured map itself, in place of random surfaces.

T_flash is also computed by the direction of sliding, and relative to a phase-randomized surrogate of the map.
"""

import hashlib
from collections.abc import Mapping
from dataclasses import replace
from math import pi
from pathlib import Path
from typing import Any, Literal, NamedTuple

from roughsim import prediction
from roughsim.ensemble.executors import Workers
from roughsim.ensemble.map_cells import MapCells, cell_of, points_of, quadrants
from roughsim.ensemble.run import begin, complete, shown
from roughsim.errors import ConvergenceError, ResolutionError
from roughsim.grid import Grid
from roughsim.machine import exceeds
from roughsim.planning.plan import largest_member
from roughsim.planning.realization import below_problem, level_problem
from roughsim.results.folder import open_run
from roughsim.results.pressed import PARTS
from roughsim.results.run import Run
from roughsim.scene import Scene, SceneError, SceneSource
from roughsim.scene.files import load_map
from roughsim.scene.numerics import QUADRANTS, SLIDING, Column, Level, Numerics
from roughsim.show.remarks import Remark, warn_of
from roughsim.surface.topography.sums import sum_of_faces

_LEAST_SIDE = 64  # points of a map
MOST_SIDE = 2048  # points per side of the contact of a map
_PIXELS = 4  # per shortest wave of a map of few points, on the coarser of its grids
_BYTES_PER_POINT = 64.0  # of the map with its mirror images
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
    """Press the measured map of a scene itself, or the sum of the maps of both faces; its quadrants give the scatter.

    All waves of the map are pressed, on two grids of finer points, and the value is extrapolated to a vanishing pixel.
    Maps above 2048 points per side lose their shortest waves; the change from half the cut-off is then part of the
    error. T_flash is a mean over all directions of sliding. On the finest grid it is also computed along and across the
    lay of the map, in `sliding.direction`, and for a phase-randomized surrogate, a map with the same
    |h(q)| and random phases.

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
    cells = cell_of(topography.heights, topography.grid, edges), *quadrants(topography)
    own = replace(loaded, ensemble=replace(loaded.ensemble, realizations=PARTS))
    numerics = _numerics(own, cells[0].grid, cells[1].grid, edges)
    if len(maps) > 1:
        reason = Remark("choice", "map", topography.taken, "of both faces")
        numerics = replace(numerics, reasons=(*numerics.reasons, reason))
    allowed.fit(*largest_member(own, numerics), numerics.threads)
    folder = Path(folder)
    digest = hashlib.sha256(topography.heights.tobytes()).hexdigest()
    numerics = begin(own, folder, numerics, press={"edges": edges, "heights": digest})

    def source(run: Run, level: int) -> MapCells:
        column = numerics.levels[level].column
        quartered = column == QUADRANTS
        return MapCells(
            level,
            level_problem(run.scene, numerics, level),
            below_problem(run.scene, numerics, level),
            topography,
            cells[1:] if quartered else cells[:1],
            "mirror" if quartered else edges,
            loaded.sliding.direction or (),
            last=level == numerics.of_column(column)[-1],
        )

    with allowed, shown(progress, "pressing") as bar:
        observer = None if bar is None else bar.update
        (run,) = complete(
            [(own, numerics, folder)], allowed, observer, source=source, began=observer
        )
    for member in run.members.values():
        if member.failure:
            about = member.provenance
            raise ConvergenceError(member.failure, about["residual"], about["iterations"])
    run = open_run(folder)
    warn_of(run.remarks)
    return run


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


def _numerics(scene: Scene, whole: Grid, part: Grid, edges: str) -> Numerics:
    """Return the levels of a map and of its quadrants, whose cells have these points.

    The cut-off is on two grids; if waves are left out, half of it is on two more.
    """
    resolution = resolution_of(scene, whole)
    column: Column = "elastic" if scene.elastic else "capped"
    levels = [
        *_levels(column, whole, resolution, first=1),
        *_levels(QUADRANTS, part, resolution, first=PARTS, lengths=part.lengths),
    ]
    given = {
        key: getattr(scene.numerics, key)
        for key in ("tolerance", "precision", "threads", "keep_fields")
    }
    chosen: dict[str, Any] = {key: value for key, value in given.items() if value is not None}
    waves = "all waves of the map; none are added beyond"
    if not resolution.whole:
        waves = "too many points for the shortest waves; half the cut-off shows their effect"
    choices = {
        "surface": (_EDGES[edges], f"{whole.shape[0]} × {whole.shape[1]} points"),
        "cut-off": (waves, f"{resolution.q_max:.3g} rad/m"),
        "pixels": (
            "their difference gives the pixel error",
            f"{resolution.pixels:g} and {2 * resolution.pixels:g} per shortest wave",
        ),
        "realizations": (
            "the map itself; its four quadrants, pressed alike, give the scatter",
            "1",
        ),
        QUADRANTS: (_EDGES["mirror"], f"{part.shape[0]} × {part.shape[1]} points"),
    }
    reasons = tuple(Remark("choice", name, *about) for name, about in choices.items())
    return Numerics(levels=tuple(levels), lengths=whole.lengths, **chosen, reasons=reasons)


def _levels(column: Column, grid: Grid, resolution: Resolution, **about: Any) -> list[Level]:
    """Return the levels of a cell with the points of a map."""
    q_max, pixels, whole = resolution
    x, y = points_of(grid, pixels, q_max)
    steps = [(1, 1.0), (2, 1.0)] if whole else [(0.5, 0.5), (1, 0.5), (1, 1.0), (2, 1.0)]
    return [
        Level(column, (int(times * x), int(times * y)), part * q_max, **about)
        for times, part in steps
    ]
