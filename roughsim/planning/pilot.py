"""The pilot of a plan: cheap solves that show how T_flash scatters, and how it falls with the cut-off and the pixel.

Their cut-offs are far below those of the run: a solve takes hundredths of a second. Their random streams are their own:
a pilot must not see the surfaces of the run. The same scene gives the same pilot.
"""

import time
import warnings
from dataclasses import dataclass, replace
from functools import lru_cache
from math import ceil, inf, pi
from typing import NamedTuple, Self

import numpy as np

from roughsim.errors import ConvergenceError
from roughsim.estimate.cell_size import parts_of
from roughsim.estimate.regression import CONTROLS, scatter_at_mean_peak_volume
from roughsim.grid import Array
from roughsim.scene import Scene
from roughsim.scene.numerics import DEFAULT_SOLVER, Column, Level, Numerics

Lengths = tuple[float, float]  # of the cell, m
SOLVES = 12  # of each level: scatter is then known to a fifth, one standard error
SCATTER_KNOWN = (0.70, 1.75)  # true over measured scatter, 95 % of normal ones: √(10/χ²) with 10 degrees of freedom
POINTS = 512  # points per side that no solve of a pilot exceeds
LEAST_POINTS = 8  # points per side of its coarsest grid
# scatter of changes in half the cell over that in the run's: 2 by a quarter of the area; 1.7 … 2.4 were measured
HALF_SCATTER = 2.0
SEED = 20  # any number


@dataclass(frozen=True, slots=True)
class Pilot:
    """What the pilot of one column says of T_flash, relative to its limit; at the hottest speed where none is named."""

    raw_scatter: float  # standard deviation of one realization, at the worst speed
    scatter: float  # the same at the mean peak volume
    hot_scatter: float  # the same at the speed with the highest T_flash
    step: float  # change of the mean from q_max/2 to q_max
    pixel: float  # change of the mean from 4 to 8 pixels per shortest wave, at q_max/2
    change_scatter: float  # standard deviation of these changes from one realization to the next
    q_max: float  # its highest cut-off, rad/m
    pace: float  # CPU time of one realization over `work` of its points, s; never decides
    measured: bool = True
    # of these changes at the speed where they scatter most, relative to T_flash there
    widest_change_scatter: float = 0.0

    def in_cell(self, times: float) -> Self:
        """Return what it says of a cell of so many times its sides: independent parts of a cell scatter apart."""
        names = ("raw_scatter", "scatter", "hot_scatter", "change_scatter", "widest_change_scatter")
        return replace(self, **{name: getattr(self, name) / times for name in names})


# what stands for a pilot whose solves do not converge: about what those of steel say
GUESS = Pilot(0.02, 0.02, 0.02, step=0.2, pixel=0.009, change_scatter=0.004, q_max=inf, pace=1.2e-8, measured=False)


class Solved(NamedTuple):
    """All realizations of a level: T_flash (SOLVES, speeds), K, `CONTROLS`, points, and least CPU time, s."""

    rows: Array
    peak_volumes: dict[str, Array]
    points: int
    seconds: float


def work(points: float) -> float:
    """Return how the time of a solve grows with its points: per point as √(points per side), on 512² to 3072²."""
    return float(points**1.25)


@lru_cache(maxsize=32)
def pilot(scene: Scene, column: Column, lengths: Lengths, q_max: float) -> Pilot:
    """Measure T_flash at a few low cut-offs; a guess where a solve does not converge.

    `lengths` are of the cell, m. `q_max` is the highest cut-off, rad/m; lowered to what `POINTS` per side resolve with
    4 pixels per wave. The changes with cut-off and pixel come from half the cell where it has the same ones.
    """
    parts = min(parts_of(scene, lengths), 2) if column == "capped" else 1
    cut = min(q_max, POINTS * 2 * pi / (4 * max(lengths)))
    x, y = (fast_size(max(2.0 * parts * LEAST_POINTS, 4 * cut * length / (2 * pi))) for length in lengths)
    fine = Level(column, (x // parts, y // parts), cut)
    coarse = Level(column, (fine.shape[0] // 2, fine.shape[1] // 2), cut / 2)  # at the same pixels per wave
    finer = replace(fine, q_max=cut / 2)  # half the pixel of the coarse one at the same cut-off
    solver = scene.numerics.solver or DEFAULT_SOLVER
    small = Numerics((coarse, fine, finer), (lengths[0] / parts, lengths[1] / parts), solver=solver)
    whole = Numerics((replace(fine, shape=(x, y)),), lengths, solver=solver)
    try:
        solved = [flash_temperatures(scene, small, level) for level in range(3)]
        largest = flash_temperatures(scene, whole, 0) if parts > 1 else solved[1]
    except ConvergenceError:
        return replace(GUESS, q_max=cut)
    low, high, refined = (solutions.rows for solutions in solved)
    mean = largest.rows.mean(axis=0)
    hottest = int(np.argmax(mean))
    limit = (2.0 * high - low).mean(axis=0)  # of first order in 1/q_c
    changes = high - low, refined - low
    steps, pixels = (change[:, hottest] / limit[hottest] for change in changes)
    widest = (change.std(axis=0, ddof=1)[limit > 0.0] / limit[limit > 0.0] for change in changes)
    in_whole = HALF_SCATTER if parts > 1 else 1.0
    unit = np.maximum(limit, mean / 2.0)  # where T_flash halves from one cut-off to the next, that limit is no measure
    raw_scatter, scatter = (
        np.divide(scatter_at_mean_peak_volume(largest.rows, numbers), unit, out=np.zeros_like(mean), where=unit > 0.0)
        for numbers in ({}, largest.peak_volumes)
    )
    return Pilot(
        raw_scatter=float(raw_scatter.max()),
        scatter=float(scatter.max()),
        hot_scatter=float(scatter[hottest]),
        step=abs(float(steps.mean())),
        pixel=abs(float(pixels.mean())),
        change_scatter=max(float(change.std(ddof=1)) for change in (steps, pixels)) / in_whole,
        q_max=cut,
        pace=pace(solved[0], largest),
        widest_change_scatter=max(float(scatter.max(initial=0.0)) for scatter in widest) / in_whole,
    )


def pace(small: Solved, large: Solved) -> float:
    """Return CPU time over `work` from one grid to the next, so that what every realization takes drops out, s."""
    few, many = work(small.points), work(large.points)
    return max((large.seconds - small.seconds) / (many - few), 0.5 * large.seconds / many)


def flash_temperatures(scene: Scene, numerics: Numerics, level: int) -> Solved:
    """Solve all realizations of a level."""
    from roughsim.planning.realization import realize  # slow to import: it loads the compiler

    rows, volumes, least = [], [], inf
    for index in range(SOLVES):
        start = time.process_time()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # the run itself says what is to be said
            solution = realize(scene, numerics, seed=SEED, level=level, index=index)
        least = min(least, time.process_time() - start)
        rows.append(solution.observables.flash_temperature)
        volumes.append(solution.peak_volumes)
    controls = dict(zip(CONTROLS, np.array(volumes).T, strict=True))
    return Solved(np.stack(rows), controls, numerics.grid(level).points, least)


def fast_size(points: float) -> int:
    """Return the next size of the form 2^a·{4, 5, 6} ≥ `points` less 2 %: fast to transform, easy to halve."""
    least = max(8, ceil(0.98 * points))
    return min(k << a for a in range(1, least.bit_length()) for k in (4, 5, 6) if k << a >= least)
