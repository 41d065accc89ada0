"""Snapshots of a slide: the kept maps of a member, its curves, and the highest summits of both faces."""

import warnings
from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from roughsim.errors import RecordError
from roughsim.grid import Array, Grid
from roughsim.planning.realization import slide_problem
from roughsim.results.run import Run
from roughsim.sliding import snapshots
from roughsim.sliding.member import faces
from roughsim.sliding.path import oblique_path
from roughsim.store.member_files import fields_path, read_fields

_SUMMITS = 60  # the highest of each face


@dataclass(frozen=True, slots=True, eq=False)
class MemberSnapshots:
    """Snapshots of one member, in the frame of the resting body."""

    grid: Grid  # of the maps
    maps: snapshots.Snapshots
    curves: dict[
        str, Array
    ]  # over the slid distance, by the names of `roughsim.observables.catalogue.CURVES`
    resting_summits: Array  # the highest summits of the face at rest, m, (summits, 2)
    moving_summits: (
        Array  # of the moving face at each position, m, (positions, summits, 2); none of a flat
    )

    def positions(self, speed: int) -> int:
        """Return the number of positions at the speed with this index, up to the slid distance of that speed."""
        return int(np.isfinite(self.maps.temperature[speed, :, 0, 0]).sum())


def pictured(run: Run) -> list[int]:
    """Return the counted realizations with stored snapshots of their slide."""
    level = run.numerics.slide
    return [] if level is None else run.kept(level, "film_pressure")


def no_snapshots(run: Run, index: int) -> ValueError:
    """Return the error for a realization without snapshots, with the command that makes one."""
    return ValueError(
        f'{run.folder} has no snapshots of realization {index}; run a scene with history = "sliding" into a new folder '
        f"with --keep-fields {index + 1}"
    )


def read_snapshots(run: Run, index: int) -> MemberSnapshots:
    """Read the snapshots of a realization and redraw its faces; ValueError without, RecordError if damaged."""
    level = run.numerics.slide
    if level is None or index not in pictured(run):
        raise no_snapshots(run, index)
    path = fields_path(run.folder, level, index)
    maps = snapshots.Snapshots(*read_fields(path, snapshots.FIELDS)[1].values())
    problem = replace(slide_problem(run.scene, run.numerics), seed=run.seed, index=index)
    way = oblique_path(problem.cell, max(problem.distances))
    steps = np.rint(maps.distance / way.distance[1]).astype(np.intp)
    shape, speeds = snapshots.snapshot_shape(problem.grid.shape), len(run.scene.speeds)
    fits = maps.pressure.shape == (steps.size, *shape) and maps.temperature.shape == (
        speeds,
        steps.size,
        *shape,
    )
    if not fits or steps.min(initial=0) < 0 or steps.max(initial=0) > way.steps:
        raise RecordError(
            f"{path} holds snapshots of other speeds, distances or points than this run: it is not its own"
        )
    with warnings.catch_warnings():
        warnings.filterwarnings(
            "ignore", message="q_min = ", category=RuntimeWarning
        )  # the plan warns of it
        resting, moving = (highest(heights) for heights in faces(problem))
    places = (
        np.asarray(problem.grid.shape) / shape
    )  # a point of the map is the middle of a block of points
    spacing = np.asarray(problem.cell.spacing)

    def in_metres(points: NDArray[np.intp]) -> Array:
        metres: Array = (points % problem.grid.shape - 0.5 * (places - 1)) * spacing
        return metres

    grid = Grid(shape, problem.cell.lengths)
    riding = moving - way.offsets[steps][:, None, :]
    curves = run.members[level, index].curves
    return MemberSnapshots(grid, maps, curves, in_metres(resting), in_metres(riding))


def highest(heights: Array | None) -> NDArray[np.intp]:
    """Return the points of the highest local maxima of a periodic field, (maxima, 2); none of a flat."""
    if heights is None:
        return np.empty((0, 2), np.intp)
    peaks = np.argwhere(heights == scipy.ndimage.maximum_filter(heights, size=3, mode="wrap"))
    order = np.argsort(-heights[tuple(peaks.T)], kind="stable")
    return peaks[order[:_SUMMITS]]
