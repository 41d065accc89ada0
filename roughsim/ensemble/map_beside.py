"""The measured map of a run, pressed once beside the surfaces that are drawn from its C(q)."""

from dataclasses import replace
from math import prod
from typing import TYPE_CHECKING

import numpy as np
import scipy

from roughsim.ensemble.map_cells import over_twins, points_of
from roughsim.errors import ConvergenceError
from roughsim.grid import Grid
from roughsim.planning.realization import level_problem
from roughsim.results.map_ratio import TWINS, MapRatio
from roughsim.results.run import Run
from roughsim.show.text import note

if TYPE_CHECKING:
    from roughsim.surface.topography.reading import Topography

_PIXELS = 4  # per shortest wave: twice the points of the map; with its own alone, worn summits make it 30 % too cold
_SIDES = 1024, 2048  # points of a cheap grid, and of the largest one


def press_beside(run: Run, topography: "Topography | None") -> None:
    """Store T_flash of a map over that of its phase-randomized twins in the folder of a run, unless it is there.

    The interval is of one more twin, by Student's t: 95 % of Gaussian maps have 1 in it. A large grid is left out that
    takes more points in all than the run itself.
    """
    stored = MapRatio.read(run.folder, len(run.scene.speeds))
    if topography is None or not run.independent or (stored is not None and not stored.reason):
        return
    own, scene = topography.grid, run.scene
    q_max = min(own.nyquist, float(scene.spectrum.breaks[-1]))
    grid = Grid(points_of(own, _PIXELS, q_max), own.lengths)
    nothing = np.array([])
    spent = sum(
        n * prod(level.shape) for n, level in zip(run.counts, run.numerics.levels, strict=True)
    )
    cheap, most = ((1 + TWINS) * side**2 for side in _SIDES)
    if (1 + TWINS) * grid.points > min(max(spent, cheap), most):
        MapRatio(nothing, nothing, grid.shape, "this takes longer than the run").write(run.folder)
        return
    note("pressing the map itself, and maps with its waves and random phases")
    level = run.numerics.of_column(run.column(None))[-1]
    problem = replace(
        level_problem(scene, run.numerics, level),
        spectrum=scene.spectrum.truncated(q_max=q_max),
        grid=grid,
        distribution=None,
        camera=None,
    )
    try:
        over = 1.0 / over_twins(problem, topography, TWINS)
    except ConvergenceError as error:
        MapRatio(nothing, nothing, grid.shape, str(error)).write(run.folder)
        return
    mean = over.mean(axis=0)
    scatter = over.std(axis=0, ddof=1) * np.sqrt(1 + 1 / TWINS) / mean
    quantile = float(scipy.special.stdtrit(TWINS - 1, 0.975))
    MapRatio(1.0 / mean, quantile * scatter / mean, grid.shape).write(run.folder)
