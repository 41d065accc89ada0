"""Speed against accuracy: error and cost of the choices that the plan makes for a scene, and of other choices.

Errors are against tightly converged values, costs are CPU seconds of one thread. Their ratio to one pair of transforms,
timed in the same run, is what carries over to other machines.
"""

import time
import warnings
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import replace
from functools import partial
from math import hypot, isnan, nan, pi, sqrt
from timeit import timeit
from typing import Any, NamedTuple

import numpy as np

from roughsim import fourier, prediction
from roughsim.charts.error_over_cost import PAIR_SIDE, Point, front, panels
from roughsim.contact import Contact
from roughsim.contact.active_set import solve_contact
from roughsim.errors import ConvergenceError
from roughsim.estimate.ladder import observe
from roughsim.grid import Grid
from roughsim.observables.moments import Sliding, measure
from roughsim.observables.record import Sample
from roughsim.pipeline import Problem, solve_problem
from roughsim.planning.plan import plan
from roughsim.planning.realization import level_problem
from roughsim.scene import Scene
from roughsim.scene.numerics import Level, Numerics
from roughsim.show.table import Column, Number, Row, Table, json_value
from roughsim.surface.synthesis import synthesize

SEED = 21  # any number: surfaces of their own, neither the run's nor the pilot's
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


def cpu_seconds(work: Callable[[], Any]) -> float:
    """Return the least CPU time of up to three calls, s, after one that fills caches; a second in all is enough."""
    spent: list[float] = []
    while len(spent) < 4 and sum(spent) < 1.0:
        spent.append(timeit(work, timer=time.process_time, number=1))
    return min(spent[1:] or spent)


def contact(scene: Scene, numerics: Numerics, realizations: int) -> Iterator[Point]:
    """Pressure and T_flash of one contact, over tolerance, precision and pixel."""
    problem = base_problem(scene, numerics)
    press = solver(problem)
    exact = press(tolerance=1e-10)
    for precision in ("double", "single"):
        method = f"{precision} precision"
        for tolerance in 10.0 ** -np.arange(1.0, 9.0):
            solve = partial(press, tolerance=float(tolerance), precision=precision)
            chosen = precision == numerics.precision and bool(np.isclose(tolerance, numerics.tolerance))
            setting = f"tolerance {tolerance:.0e}"
            try:
                solved, cost = solve(), cpu_seconds(solve)
            except ConvergenceError:
                yield Point("contact", "pressure", method, f"{setting}: failed", nan, nan, chosen)
                continue
            setting += f", {solved.transforms / 2:.0f} pairs"
            error = float(np.linalg.norm(solved.pressure - exact.pressure) / np.linalg.norm(exact.pressure))
            yield Point("contact", "pressure", method, setting, error, cost, chosen)
            error = abs(flash(problem, solved) / flash(problem, exact) - 1.0)
            yield Point("contact", "T_flash of these pixels", method, setting, error, cost, chosen)
    yield from pixels(problem)


def pixels(problem: Problem) -> Iterator[Point]:
    """T_flash of one contact at a fixed cut-off over the pixels of its shortest wave; four times as many are exact."""
    q_max = problem.spectrum.breaks[-1]
    planned = problem.grid.shape[0] * 2 * pi / (problem.grid.lengths[0] * q_max)
    values: dict[float, tuple[float, float]] = {}
    for factor in (0.5, 0.75, 1.0, 1.5, 2.0, 4.0):
        nx, ny = (round(factor * n) for n in problem.grid.shape)
        finer = replace(problem, grid=Grid((nx, ny), problem.grid.lengths))
        if q_max <= finer.grid.nyquist:
            solve = partial(solver(finer), tolerance=problem.tolerance)
            values[factor] = flash(finer, solve()), cpu_seconds(solve)
    exact = values.pop(4.0)[0]
    for factor, (value, cost) in values.items():
        setting = f"{factor * planned:.2g} pixels per shortest wave"
        yield Point("contact", "T_flash, any pixel", "one grid", setting, abs(value / exact - 1.0), cost, factor == 1.0)


def base_problem(scene: Scene, numerics: Numerics) -> Problem:
    """Return the contact problem of the coarsest level that a run is judged by, sliding at the highest speed alone."""
    level = numerics.of_column("elastic" if scene.elastic else "capped")[0]
    bodies = prediction.conduction(scene, [max(scene.speeds)])
    conductivity, diffusivity = float(bodies.conductivity[0]), float(bodies.diffusivity[0])
    sliding = Sliding([max(scene.speeds)], scene.sliding.friction_coefficient, conductivity, diffusivity)
    return replace(level_problem(scene, numerics, level), sliding=sliding, seed=SEED, stream=0)


def solver(problem: Problem) -> Callable[..., Contact]:
    """Return `solve_contact` for one surface of the problem; tolerance and precision are left open."""
    heights = synthesize(problem.spectrum, problem.grid, np.random.default_rng(SEED))
    load = problem.nominal_pressure
    return partial(solve_contact, heights, problem.grid, problem.solid, nominal_pressure=load)


def flash(problem: Problem, contact: Contact) -> float:
    """Return T_flash of a contact, K, averaged over directions."""
    return float(measure(contact, problem.grid, problem.sliding).flash_temperature[-1])


def chain(scene: Scene, numerics: Numerics, realizations: int) -> Iterator[Point]:
    """Every observable that has a limit in the cut-off, over the splits of the cost that a ladder allows.

    There is a curve over the number of realizations for each split; the truth is that of all levels and realizations.
    """
    levels = numerics.of_column("elastic" if scene.elastic else "capped")
    samples, seconds = [], []
    for number in levels:  # all on the same surfaces
        problem = replace(level_problem(scene, numerics, number), seed=SEED, stream=len(levels) - 1)
        sample, median = solve_level(problem, numerics.levels[number], realizations)
        samples.append(sample)
        seconds.append(median)
    splits = splits_of([numerics.levels[level] for level in levels])
    forecast = 0 if numerics.forecast is None else numerics.forecast.realizations
    fastest, slowest = int(np.argmax(scene.speeds)), int(np.argmin(scene.speeds))
    for title, name in OBSERVABLES.items():
        if name == "pressure_variance" and not scene.elastic:
            continue  # fixed by force balance
        if title == "T_flash, slowest" and not 0.0 < scene.speeds[slowest] < scene.speeds[fastest]:
            continue
        speed = {"T_flash, fastest": fastest, "T_flash, slowest": slowest}.get(title, 0)
        estimate = partial(observe, name, capped=not scene.elastic, end=scene.spectrum.breaks[-1])
        whole = estimate(samples)
        truth = float(whole.extrapolated[:, speed].mean())
        doubt = float(np.hypot(*np.nan_to_num([whole.bandwidth[speed], whole.pixel[speed]]))) / abs(truth)
        for split in splits:
            chosen = [samples[i] for i in split.levels]
            first, last = (estimate(some).extrapolated[:, speed] for some in (chosen[:1], chosen))
            # ⟨T₀⟩ over all realizations + ⟨T − T₀⟩ over few of them: the variance of the mean, times the realizations
            (own, shared), (_, change) = np.cov(first, last - first)
            variance = float(own + 2 * shared + split.every * change)
            bias, planned = float(last.mean()) - truth, forecast if split.planned else 0
            for n in sorted({*(k for k in COUNTS if k >= 2 * split.every), planned} - {0}):
                error = hypot(hypot(bias, sqrt(variance / n)) / abs(truth), doubt)
                few = -(-n // split.every)
                cost = sum((n if i == split.levels[0] else few) * seconds[i] for i in split.levels)
                yield Point("chain", title, split.method, f"{n} realizations", error, cost, n == planned, doubt=doubt)


def solve_level(problem: Problem, level: Level, realizations: int) -> tuple[Sample, float]:
    """Solve all realizations of a level, after one more that makes plans and compiles kernels.

    Return their numbers, and the median CPU seconds of one.
    """
    solve_problem(replace(problem, index=realizations))
    moments, seconds = [], []
    for index in range(realizations):
        start = time.process_time()
        moments.append(solve_problem(replace(problem, index=index)).observables)
        seconds.append(time.process_time() - start)
    stored = ("flash_temperature", "contact_fraction", "pressure_variance")
    numbers = {name: np.stack([np.atleast_1d(getattr(m, name)) for m in moments]) for name in stored}
    spectra = np.stack([m.stress_spectrum.variance for m in moments])
    reach, side = 0.5 * float(np.hypot(*problem.grid.lengths)), float(level.shape[0])
    wavenumber, rows = moments[0].stress_spectrum.wavenumber, np.arange(realizations, dtype=np.intp)
    return Sample(level.q_max, side, rows, numbers, wavenumber, spectra, reach), float(np.median(seconds))


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


STAGES: dict[str, Callable[[Scene, Numerics, int], Iterator[Point]]] = {"contact": contact, "chain": chain}


def bench(
    scene: Scene, *, numerics: Numerics | None = None, stages: Collection[str] = tuple(STAGES), realizations: int = 8
) -> list[Point]:
    """Measure error and cost of the ways to compute a scene, stage by stage.

    `numerics` is the choice that is marked, what `plan` makes of the scene if left out. Scatter and bias are measured
    over `realizations` ≥ 4. ValueError if a stage is unknown, there are too few realizations, or nothing slides.
    """
    for name in stages:
        if name not in STAGES:
            raise ValueError(f"stage = {name!r} is unknown; choose one of {', '.join(STAGES)}")
    if max(scene.speeds) <= 0.0:
        raise ValueError("speed = 0 m/s is the highest of the scene; nothing heats, give one above zero")
    if isinstance(realizations, bool) or int(realizations) != realizations or realizations < 4:
        raise ValueError(f"realizations = {realizations!r} must be a whole number ≥ 4: it gives scatter and bias")
    numerics = plan(scene) if numerics is None else numerics
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # the errors that they warn of are what is charted
        return in_pairs(point for name in stages for point in STAGES[name](scene, numerics, realizations))


def in_pairs(points: Iterable[Point]) -> list[Point]:
    """Return points with their costs in forward and inverse real transforms of `PAIR_SIDE`² points, float64."""
    transform = fourier.Transform((PAIR_SIDE, PAIR_SIDE), np.float64)
    transform.field[...] = np.random.default_rng(1).random(transform.field.shape)

    def pair() -> None:
        transform.forward()
        transform.inverse()

    seconds = cpu_seconds(pair)
    return [point._replace(pairs=point.seconds / seconds) for point in points]


def bench_dict(points: list[Point]) -> dict[str, Any]:
    """Return points as JSON values, NaN as None, with `front` where no other one of its chart is better."""
    best = [point for group in panels(points).values() for point in front(group)]
    return {"points": [json_value(point._asdict() | {"front": point in best}) for point in points]}


def bench_tables(points: list[Point]) -> list[Table]:
    """Return a table per stage and observable: the front, the choice of the plan, and what failed."""
    tables = []
    for title, group in panels(points).items():
        best = front(group)
        rows: list[Row] = [
            (
                *(Number(x, digits=2) for x in (point.error, point.seconds, point.pairs)),
                point.method,
                point.setting,
                ", ".join(["front"] * (point in best) + ["plan"] * point.chosen),
            )
            for point in group
            if point in best or point.chosen or isnan(point.error)
        ]
        columns = [Column(name, number=True) for name in ("error", "CPU s", "FFT pairs")]
        tables.append(Table([*columns, Column("method"), Column("setting"), Column("")], rows, title))
    return tables
