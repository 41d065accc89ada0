"""The whole chain: error of the ensemble's estimates over their cost, for every split of the same members.

All levels are solved for the same few realizations. Scatter and bias found there give the error of any number n of
realizations, of single grids, and of ladders with few fine members: error² = bias² + variance/n + doubt². The bias is
against all levels and members; the doubt is what their extrapolation and their pixels leave.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace
from math import hypot, nan, sqrt
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from roughsim.bench.stages import SEED
from roughsim.charts.error_over_cost import Point
from roughsim.estimate.ladder import observe
from roughsim.observables.record import Sample
from roughsim.pipeline import Problem, solve_problem
from roughsim.realization import level_problem

if TYPE_CHECKING:
    from roughsim.scene import Scene
    from roughsim.scene.numerics import Level, Numerics

KNOWN = "doubt"  # the method of a point that says how well the limit itself is known
COUNTS = (4, 8, 16, 32, 64, 128, 256)
# title of a chart → observable
OBSERVABLES = {
    "T_flash, fastest": "flash_temperature",
    "T_flash, slowest": "flash_temperature",
    "contact area": "contact_fraction",
    "pressure variance": "pressure_variance",
    "r at g = 0.1 g(0)": "correlation_radius_10",
}


class Split(NamedTuple):
    """A choice of levels; all but the first are solved for every `every`-th realization."""

    method: str
    levels: tuple[int, ...]
    every: int = 1
    planned: bool = False


class Solved(NamedTuple):
    """The numbers of a level over all realizations, and the median CPU seconds of one."""

    sample: Sample
    seconds: float


def chain(scene: Scene, numerics: Numerics, realizations: int) -> Iterator[Point]:
    """Every observable that has a limit in the cut-off, over the splits of the cost that a ladder allows."""
    levels = numerics.of_column("elastic" if scene.elastic else "capped")
    solved = []
    for number in levels:  # all on the same surfaces
        problem = replace(level_problem(scene, numerics, number), seed=SEED, stream=len(levels) - 1)
        solved.append(solve_level(problem, numerics.levels[number], realizations))
    splits = splits_of([numerics.levels[level] for level in levels])
    forecast = 0 if numerics.forecast is None else numerics.forecast.realizations
    fastest, slowest = int(np.argmax(scene.speeds)), int(np.argmin(scene.speeds))
    for title, name in OBSERVABLES.items():
        if name == "pressure_variance" and not scene.elastic:
            continue  # fixed by force balance
        if title == "T_flash, slowest" and not 0.0 < scene.speeds[slowest] < scene.speeds[fastest]:
            continue
        speed = {"T_flash, fastest": fastest, "T_flash, slowest": slowest}.get(title, 0)
        yield from curves(title, name, speed, solved, splits, forecast, scene)


def solve_level(problem: Problem, level: Level, realizations: int) -> Solved:
    """Solve all realizations of a level, after one more that makes plans and compiles kernels."""
    solve_problem(replace(problem, index=realizations))
    moments, seconds = [], []
    for index in range(realizations):
        start = time.process_time()
        moments.append(solve_problem(replace(problem, index=index)).observables)
        seconds.append(time.process_time() - start)
    numbers = {
        "flash_temperature": np.stack([m.flash_temperature for m in moments]),
        "contact_fraction": np.array([[m.contact_fraction] for m in moments]),
        "pressure_variance": np.array([[m.pressure_variance] for m in moments]),
    }
    spectra = np.stack([m.stress_spectrum.variance for m in moments])
    reach, side = 0.5 * float(np.hypot(*problem.grid.lengths)), float(level.shape[0])
    wavenumber, rows = moments[0].stress_spectrum.wavenumber, np.arange(realizations, dtype=np.intp)
    sample = Sample(level.q_max, side, rows, numbers, wavenumber, spectra, reach)
    return Solved(sample, float(np.median(seconds)))


def splits_of(levels: list[Level]) -> list[Split]:
    """Return each grid alone, each ladder from the first rung up, and the whole ladder with few fine members."""
    if len(levels) == 1:
        return [Split("the plan's level", (0,), planned=True)]
    cut_offs = [level.q_max for level in levels]
    rungs = [cut_offs.index(q_c) for q_c in sorted(set(cut_offs))]  # of each cut-off the coarsest grid
    splits = [
        Split(f"one grid, {level.q_max / cut_offs[0]:.3g}× q_c, {level.shape[0]}²", (i,))
        for i, level in enumerate(levels)
    ]
    splits += [Split(f"{k} cut-offs, all levels", tuple(rungs[:k])) for k in range(2, len(rungs) + 1)]
    planned = levels[-1].every
    for every in sorted({1, 2, 4, planned}):
        name = "the plan's levels" + (f", fine ones 1 in {every}" if every > 1 else ", all of them")
        splits.append(Split(name, tuple(range(len(levels))), every, every == planned))
    return splits


def curves(
    title: str, name: str, speed: int, solved: list[Solved], splits: list[Split], forecast: int, scene: Scene
) -> Iterator[Point]:
    """A curve over the number of realizations for each split; the truth is that of all levels and realizations."""
    end = scene.spectrum.breaks[-1]
    whole = observe(name, [level.sample for level in solved], capped=not scene.elastic, end=end)
    truth = float(whole.extrapolated[:, speed].mean())
    doubt = float(np.hypot(*np.nan_to_num([whole.bandwidth[speed], whole.pixel[speed]])))
    yield Point("chain", title, KNOWN, "", doubt / abs(truth), nan)
    for split in splits:
        first, whole_split = (
            observe(name, [solved[i].sample for i in levels], capped=not scene.elastic, end=end).extrapolated[:, speed]
            for levels in (split.levels[:1], split.levels)
        )
        # ⟨T₀⟩ over all realizations + ⟨T − T₀⟩ over few of them: the variance of the mean, times the realizations
        (own, shared), (_, change) = np.cov(first, whole_split - first)
        variance = float(own + 2 * shared + split.every * change)
        bias, planned = float(whole_split.mean()) - truth, forecast if split.planned else 0
        for n in sorted({*(k for k in COUNTS if k >= 2 * split.every), planned} - {0}):
            error = hypot(bias, sqrt(variance / n), doubt) / abs(truth)
            few = -(-n // split.every)
            cost = sum((n if i == split.levels[0] else few) * solved[i].seconds for i in split.levels)
            yield Point("chain", title, split.method, f"{n} realizations", error, cost, n == planned)
