"""A few cheap solves ahead of a run: how much T_flash scatters, how it falls with the cut-off and with the pixel.

They use cut-offs far below those of the run, where a solve takes hundredths of a second, and random streams of their
own; the same scene gives the same pilot. What it measures scales to the run's levels as 1/q_c.
"""

from __future__ import annotations

import time
import warnings
from dataclasses import dataclass
from functools import lru_cache
from math import inf, pi
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from roughsim.contact import methods
from roughsim.errors import ConvergenceError
from roughsim.realization import realize
from roughsim.scene.numerics import Column, Level, Numerics, fast_size

if TYPE_CHECKING:
    from roughsim.scene import Scene

Array = NDArray[np.float64]
MEMBERS = 12  # solves of each level: scatter is then known to a fifth, one standard error
SCATTER_KNOWN = (0.71, 1.70)  # true over measured scatter, 95 % of normal ones: √(11/χ²) with 11 degrees of freedom
POINTS = 512  # points per side that no solve of a pilot exceeds
_SEED = 20  # any number: a pilot must not see the surfaces of the run


@dataclass(frozen=True, slots=True)
class Pilot:
    """What the pilot of one column found, of T_flash: relative to its own mean (scatter) or to its limit (the rest).

    Attributes
    ----------
    scatter : float
        Standard deviation of one realization at the worst speed.
    hot_scatter : float
        The same at the speed with the highest T_flash; so are all others.
    step : float
        Change from `q_max`/2 to `q_max`, of the mean.
    pixel : float
        Change from 4 to 8 pixels per shortest wave at `q_max`/2, of the mean.
    change_scatter : float
        Standard deviation of these changes of one realization.
    q_max : float
        Its highest cut-off, rad/m.
    pace : float
        CPU time of one realization over `work` of its points, s: without what each takes on any grid; never decides.
    """

    scatter: float
    hot_scatter: float
    step: float
    pixel: float
    change_scatter: float
    q_max: float
    pace: float


def work(points: float) -> float:
    """Return how the time of a solve grows with its points: per point as √(points per side), on 512² to 3072²."""
    growth: float = points**1.25
    return growth


def pilot(scene: Scene, column: Column, lengths: tuple[float, float], q_max: float) -> Pilot | None:
    """Measure T_flash at a few low cut-offs.

    Parameters
    ----------
    scene : Scene
        What is to be computed.
    column : {"smoothed", "capped", "elastic"}
        Which contact.
    lengths : (float, float)
        The cell, m.
    q_max : float
        Highest cut-off wanted, rad/m; lowered to what `POINTS` per side resolve with 4 pixels per wave.

    Returns
    -------
    Pilot or None
        None where a solve did not converge.
    """
    cut = min(q_max, POINTS * 2 * pi / (4 * max(lengths)))
    sides = tuple(fast_size(max(16.0, 4 * cut * length / (2 * pi))) for length in lengths)
    half = (max(8, sides[0] // 2), max(8, sides[1] // 2))
    levels = (
        Level(column, half, cut / 2),
        Level(column, (sides[0], sides[1]), cut),
        Level(column, (sides[0], sides[1]), cut / 2),
    )
    numerics = Numerics(levels, lengths, solver=scene.numerics.solver or methods.DEFAULT)
    try:
        return _measured(scene, numerics)
    except ConvergenceError:
        return None


@lru_cache(maxsize=32)
def _measured(scene: Scene, numerics: Numerics) -> Pilot:
    coarse, quick = _flash_temperatures(scene, numerics, 0)
    fine, seconds = _flash_temperatures(scene, numerics, 1)
    finer, other = _flash_temperatures(scene, numerics, 2)
    mean = fine.mean(axis=0)
    hottest = int(np.argmax(mean))
    limit = float((2.0 * fine - coarse).mean(axis=0)[hottest])
    steps, pixels = ((level - coarse)[:, hottest] / limit for level in (fine, finer))
    scatter = np.divide(fine.std(axis=0, ddof=1), mean, out=np.zeros_like(mean), where=mean > 0.0)
    return Pilot(
        float(scatter.max()),
        float(scatter[hottest]),
        abs(float(steps.mean())),
        abs(float(pixels.mean())),
        max(float(change.std(ddof=1)) for change in (steps, pixels)),
        numerics.levels[1].q_max,
        _pace(numerics, quick, min(seconds, other)),
    )


def _pace(numerics: Numerics, coarse: float, fine: float) -> float:
    """CPU time over work from one grid to the next, so that what every realization takes drops out."""
    small, large = (work(numerics.grid(i).points) for i in (0, 1))
    return max((fine - coarse) / (large - small), 0.5 * fine / large)


def _flash_temperatures(scene: Scene, numerics: Numerics, level: int) -> tuple[Array, float]:
    """T_flash of all members (MEMBERS, speeds), and the least CPU time of one, s."""
    rows, least = [], inf
    for index in range(MEMBERS):
        start = time.process_time()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # the run itself says what is to be said
            rows.append(realize(scene, numerics, seed=_SEED, level=level, index=index).observables.flash_temperature)
        least = min(least, time.process_time() - start)
    return np.stack(rows), least
