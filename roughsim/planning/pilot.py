"""A few cheap solves ahead of a run: how much T_flash scatters, how it falls with the cut-off and with the pixel.

They use cut-offs far below those of the run, where a solve takes hundredths of a second, and random streams of their
own; the same scene gives the same pilot. What it measures scales to the run's levels as 1/q_c.
"""

from __future__ import annotations

import time
import warnings
from dataclasses import dataclass, replace
from functools import lru_cache
from math import ceil, inf, pi

import numpy as np
from numpy.typing import NDArray

from roughsim.errors import ConvergenceError
from roughsim.realization import realize
from roughsim.scene import Scene
from roughsim.scene.numerics import DEFAULT_SOLVER, Column, Level, Numerics

Array = NDArray[np.float64]
SOLVES = 12  # of each level: scatter is then known to a fifth, one standard error
SCATTER_KNOWN = (0.71, 1.70)  # true over measured scatter, 95 % of normal ones: √(11/χ²) with 11 degrees of freedom
POINTS = 512  # points per side that no solve of a pilot exceeds
LEAST_POINTS = 8  # points per side of its coarsest grid
SEED = 20  # any number: a pilot must not see the surfaces of the run


@dataclass(frozen=True, slots=True)
class Pilot:
    """What the pilot of one column says of T_flash, relative to its limit at the speed with the highest T_flash."""

    scatter: float  # standard deviation of one realization over its mean, at the worst speed
    hot_scatter: float  # the same at the speed with the highest T_flash
    step: float  # change of the mean from q_max/2 to q_max
    pixel: float  # change of the mean from 4 to 8 pixels per shortest wave, at q_max/2
    change_scatter: float  # standard deviation of these changes from one realization to the next
    q_max: float  # its highest cut-off, rad/m
    pace: float  # CPU time of one realization over `work` of its points, s; never decides
    measured: bool = True


# what stands for a pilot whose solves do not converge: about what those of steel say
GUESS = Pilot(0.02, 0.02, step=0.2, pixel=0.009, change_scatter=0.004, q_max=inf, pace=1.2e-8, measured=False)


def work(points: float) -> float:
    """Return how the time of a solve grows with its points: per point as √(points per side), on 512² to 3072²."""
    return float(points**1.25)


@lru_cache(maxsize=32)
def pilot(scene: Scene, column: Column, lengths: tuple[float, float], q_max: float) -> Pilot:
    """Measure T_flash at a few low cut-offs; a guess where a solve does not converge.

    `lengths` are of the cell, m. `q_max` is the highest cut-off, rad/m; lowered to what `POINTS` per side resolve with
    4 pixels per wave.
    """
    cut = min(q_max, POINTS * 2 * pi / (4 * max(lengths)))
    x, y = (fast_size(max(2.0 * LEAST_POINTS, 4 * cut * length / (2 * pi))) for length in lengths)
    levels = (
        Level(column, (x // 2, y // 2), cut / 2),
        Level(column, (x, y), cut),  # twice the cut-off at the same pixels per wave
        Level(column, (x, y), cut / 2),  # half the pixel at the same cut-off
    )
    numerics = Numerics(levels, lengths, solver=scene.numerics.solver or DEFAULT_SOLVER)
    try:
        (coarse, quick), (fine, seconds), (finer, other) = (flash_temperatures(scene, numerics, k) for k in range(3))
    except ConvergenceError:
        return replace(GUESS, q_max=cut)
    mean = fine.mean(axis=0)
    hottest = int(np.argmax(mean))
    limit = float((2.0 * fine - coarse).mean(axis=0)[hottest])  # of first order in 1/q_c
    steps, pixels = ((level - coarse)[:, hottest] / limit for level in (fine, finer))
    scatter = np.divide(fine.std(axis=0, ddof=1), mean, out=np.zeros_like(mean), where=mean > 0.0)
    return Pilot(
        scatter=float(scatter.max()),
        hot_scatter=float(scatter[hottest]),
        step=abs(float(steps.mean())),
        pixel=abs(float(pixels.mean())),
        change_scatter=max(float(change.std(ddof=1)) for change in (steps, pixels)),
        q_max=cut,
        pace=pace(numerics, quick, min(seconds, other)),
    )


def pace(numerics: Numerics, coarse: float, fine: float) -> float:
    """Return CPU time over work from one grid to the next, so that what every realization takes drops out, s."""
    small, large = (work(numerics.grid(i).points) for i in (0, 1))
    return max((fine - coarse) / (large - small), 0.5 * fine / large)


def flash_temperatures(scene: Scene, numerics: Numerics, level: int) -> tuple[Array, float]:
    """Return T_flash of all realizations (SOLVES, speeds), and the least CPU time of one, s."""
    rows, least = [], inf
    for index in range(SOLVES):
        start = time.process_time()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # the run itself says what is to be said
            rows.append(realize(scene, numerics, seed=SEED, level=level, index=index).observables.flash_temperature)
        least = min(least, time.process_time() - start)
    return np.stack(rows), least


def fast_size(points: float) -> int:
    """Return the next size of the form 2^a·{4, 5, 6} ≥ `points` less 2 %: fast to transform, easy to halve."""
    least = max(8, ceil(0.98 * points))
    return min(k << a for a in range(1, least.bit_length()) for k in (4, 5, 6) if k << a >= least)
