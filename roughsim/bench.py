"""Speed against accuracy: error and cost of the choices that the plan makes for a scene, and of other choices.

Errors are relative to tightly converged values. Costs are CPU seconds of one thread; divided by the time of one pair of
transforms, measured in the same run, they carry over to other machines.
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
from roughsim.estimate.regression import CONTROLS
from roughsim.grid import Grid
from roughsim.machine import available_memory, workers_that_fit
from roughsim.observables.moments import Sliding, measure
from roughsim.observables.record import Sample
from roughsim.pipeline import Problem, solve_problem
from roughsim.planning.levels import LATER
from roughsim.planning.plan import plan
from roughsim.planning.realization import level_problem
from roughsim.scene import Scene
from roughsim.scene.numerics import Level, Numerics
from roughsim.show.table import Column, Number, Row, Table, json_value
from roughsim.surface.synthesis import synthesize

SEED = 21  # any number but those of the run and the pilot: the bench has surfaces of its own
FINEST = 4  # points per side, over the plan's, of the grid that counts as exact
COUNTS = (4, 8, 16, 32, 64, 128, 256)  # realizations at which the error of an ensemble is forecast
# title of a chart → observable
OBSERVABLES = {
    "T_flash, fastest": "flash_temperature",
    "T_flash, slowest": "flash_temperature",
    "contact area": "contact_fraction",
    "pressure variance": "pressure_variance",
    "r at g = 0.1 g(0)": "correlation_radius_10",
}


class Split(NamedTuple):
    """A choice of levels for an ensemble, in which all but the first are solved for few realizations."""

    method: str  # in words
    levels: tuple[int, ...]  # their positions, coarsest first
    strides: tuple[int, ...]  # each is solved for one realization in so many
    planned: bool = False  # whether the plan chooses it


def cpu_seconds(work: Callable[[], Any]) -> float:
    """Return the least CPU time of up to three calls after one that fills caches, s; one second in all is enough."""
    spent: list[float] = []
    while len(spent) < 4 and sum(spent) < 1.0:
        spent.append(timeit(work, timer=time.process_time, number=1))
    return min(spent[1:] or spent)


def contact(scene: Scene, numerics: Numerics, realizations: int) -> Iterator[Point]:
    """Yield the errors of pressure and T_flash of one contact over tolerance and precision, then over the pixel."""
    problem = base_problem(scene, numerics)
    workers_that_fit(1, FINEST**2 * problem.memory, f"a grid {FINEST} times as fine as planned", available_memory())
    solve_surface = solver(problem)
    exact = solve_surface(tolerance=1e-10)
    for precision in ("double", "single"):
        method = f"{precision} precision"
        for tolerance in sorted({numerics.tolerance, *(float(f"1e-{k}") for k in range(1, 9))}, reverse=True):
            solve = partial(solve_surface, tolerance=tolerance, precision=precision)
            chosen = (precision, tolerance) == (numerics.precision, numerics.tolerance)
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
    """Yield the error of T_flash at fixed cut-off over pixels per shortest wave; four times the plan's are exact."""
    q_max = problem.spectrum.breaks[-1]
    planned = problem.grid.shape[0] * 2 * pi / (problem.grid.lengths[0] * q_max)
    values: dict[float, tuple[float, float]] = {}
    for factor in (0.5, 0.75, 1.0, 1.5, 2.0, FINEST):
        nx, ny = (round(factor * n) for n in problem.grid.shape)
        finer = replace(problem, grid=Grid((nx, ny), problem.grid.lengths))
        if q_max <= finer.grid.nyquist:
            solve = partial(solver(finer), tolerance=problem.tolerance)
            values[factor] = flash(finer, solve()), cpu_seconds(solve)
    exact = values.pop(FINEST)[0]
    for factor, (value, cost) in values.items():
        setting = f"{factor * planned:.2g} pixels per shortest wave"
        yield Point("contact", "T_flash, any pixel", "one grid", setting, abs(value / exact - 1.0), cost, factor == 1.0)


def base_problem(scene: Scene, numerics: Numerics) -> Problem:
    """Return the contact problem of the coarsest capped (or elastic) level, sliding at the highest speed alone."""
    level = numerics.of_column("elastic" if scene.elastic else "capped")[0]
    speeds = [max(scene.speeds)]
    (friction,), (bodies,) = prediction.friction_coefficient(scene, speeds), prediction.conduction(scene, speeds).each
    sliding = Sliding(speeds, float(friction), bodies.conductivity, bodies.diffusivity)
    return replace(level_problem(scene, numerics, level), sliding=sliding, seed=SEED, stream=0)


def solver(problem: Problem) -> Callable[..., Contact]:
    """Return `solve_contact` for one surface of the problem; tolerance and precision are still to be given."""
    heights = synthesize(problem.spectrum, problem.grid, np.random.default_rng(SEED))
    load = problem.nominal_pressure
    return partial(solve_contact, heights, problem.grid, problem.solid, nominal_pressure=load)


def flash(problem: Problem, contact: Contact) -> float:
    """Return T_flash of a contact, K, averaged over directions."""
    return float(measure(contact, problem.grid, problem.sliding).flash_temperature[-1])


def chain(scene: Scene, numerics: Numerics, realizations: int) -> Iterator[Point]:
    """Yield the error of the mean of each extrapolated observable over the cost of the ensemble.

    Each way to share the work among the levels gives a curve over the number of realizations. The reference is the
    estimate from all levels and realizations, and its own error is the doubt of the points.
    """
    levels = numerics.of_column("elastic" if scene.elastic else "capped")
    samples, seconds = [], []
    for number in levels:  # all levels of one cell see the same surfaces
        level = numerics.levels[number]
        stream = len(levels) - 1 if level.cell is None else len(levels)
        problem = replace(level_problem(scene, numerics, number), seed=SEED, stream=stream)
        sample, median = solve_level(problem, level, realizations)
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
        reference = estimate(samples)
        truth = float(reference.extrapolated[:, speed].mean())
        parts = reference.bandwidth[speed], reference.pixel[speed], np.asarray(reference.last_step)[speed]
        doubt = float(np.linalg.norm(np.nan_to_num(parts))) / abs(truth)
        for split in splits:
            chosen = [samples[i] for i in split.levels]
            first, all_levels = (estimate(used).extrapolated[:, speed] for used in (chosen[:1], chosen))
            # T₀ of the first level has n realizations, the correction T − T₀ by the others only n/stride. So n times
            # the variance of the mean is Var T₀ + 2 Cov(T₀, T − T₀) + stride · Var(T − T₀). Where strides differ, the
            # longest has the share of the scatter that the plan expects
            (own, shared), (_, change) = np.cov(first, all_levels - first)
            often, seldom = (pick(split.strides[1:], default=1) for pick in (min, max))
            stride = (often + LATER**2 * seldom) / (1.0 + LATER**2)
            variance = float(own + 2 * shared + stride * change)
            bias, planned = float(all_levels.mean()) - truth, forecast if split.planned else 0
            for n in sorted({*(k for k in COUNTS if k >= 2 * seldom), planned} - {0}):
                error = hypot(hypot(bias, sqrt(variance / n)) / abs(truth), doubt)
                cost = sum(-(-n // every) * seconds[i] for i, every in zip(split.levels, split.strides, strict=True))
                yield Point("chain", title, split.method, f"{n} realizations", error, cost, n == planned, doubt=doubt)


def solve_level(problem: Problem, level: Level, realizations: int) -> tuple[Sample, float]:
    """Solve all realizations of a level; return their numbers, and the median CPU time of one, s.

    One realization more goes ahead, untimed: it makes the plans of FFTW and compiles the kernels.
    """
    solve_problem(replace(problem, index=realizations))
    moments, volumes, seconds = [], [], []
    for index in range(realizations):
        start = time.process_time()
        solution = solve_problem(replace(problem, index=index))
        seconds.append(time.process_time() - start)
        moments.append(solution.observables)
        volumes.append(solution.peak_volumes)
    stored = ("flash_temperature", "contact_fraction", "pressure_variance")
    numbers = {name: np.stack([np.atleast_1d(getattr(m, name)) for m in moments]) for name in stored}
    numbers |= dict(zip(CONTROLS, np.array(volumes).T, strict=True))
    spectra = np.stack([m.stress_spectrum.variance for m in moments])
    reach, side = 0.5 * float(np.hypot(*problem.grid.lengths)), float(level.shape[0])
    wavenumber, rows = moments[0].stress_spectrum.wavenumber, np.arange(realizations, dtype=np.intp)
    sample = Sample(level.q_max, side, rows, numbers, wavenumber, spectra, reach, part=level.parts > 1)
    return sample, float(np.median(seconds))


def splits_of(levels: list[Level]) -> list[Split]:
    """Return the splits to compare: each grid alone, the first k cut-offs, and all levels with ever rarer fine ones.

    Levels in a part of the cell correct others, and are in the last kind alone.
    """
    if len(levels) == 1:
        return [Split("the plan's level", (0,), (1,), planned=True)]
    alone = [level for level in levels if level.cell is None]  # they come first
    cut_offs = [level.q_max for level in alone]
    rungs = [cut_offs.index(q_c) for q_c in sorted(set(cut_offs))]  # the coarsest grid of each cut-off
    splits = [
        Split(f"one grid, {level.q_max / cut_offs[0]:.3g}× q_c, {level.shape[0]}²", (i,), (1,))
        for i, level in enumerate(alone)
    ]
    splits += [Split(f"{k} cut-offs, all levels", tuple(rungs[:k]), (1,) * k) for k in range(2, len(rungs) + 1)]
    planned = tuple(level.every for level in levels)
    for strides in sorted({planned, *((1, *[every] * (len(levels) - 1)) for every in (1, 2, 4))}):
        words = " or ".join(f"{every}" for every in sorted(set(strides[1:])))
        name = "the plan's levels" + (", all of them" if words == "1" else f", fine ones 1 in {words}")
        splits.append(Split(name, tuple(range(len(levels))), strides, strides == planned))
    return splits


STAGES: dict[str, Callable[[Scene, Numerics, int], Iterator[Point]]] = {"contact": contact, "chain": chain}


def bench(
    scene: Scene, *, numerics: Numerics | None = None, stages: Collection[str] = tuple(STAGES), realizations: int = 8
) -> list[Point]:
    """Measure error and cost of several ways to compute a scene, stage by stage.

    `numerics` is the choice that the points mark as chosen; left out, it is that of `plan`. Scatter and bias are
    measured over `realizations` ≥ 4. ValueError if a stage is unknown, there are too few realizations, or no speed of
    the scene is above zero.
    """
    for name in stages:
        if name not in STAGES:
            raise ValueError(f"stage = {name!r} is unknown; choose one of {', '.join(STAGES)}")
    if max(scene.speeds) <= 0.0:
        raise ValueError("speed = 0 m/s is the highest of the scene, so nothing heats; add a speed above zero")
    if isinstance(realizations, bool) or int(realizations) != realizations or realizations < 4:
        raise ValueError(f"realizations = {realizations!r} must be a whole number ≥ 4, to measure scatter and bias")
    numerics = plan(scene) if numerics is None else numerics
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # they warn of the very errors that are measured here
        return in_pairs(point for name in stages for point in STAGES[name](scene, numerics, realizations))


def in_pairs(points: Iterable[Point]) -> list[Point]:
    """Return the points with their costs in pairs of real transforms (forward, inverse) of `PAIR_SIDE`² points."""
    transform = fourier.Transform((PAIR_SIDE, PAIR_SIDE), np.float64)
    transform.field[...] = np.random.default_rng(1).random(transform.field.shape)

    def pair() -> None:
        transform.forward()
        transform.inverse()

    seconds = cpu_seconds(pair)
    return [point._replace(pairs=point.seconds / seconds) for point in points]


def bench_dict(points: list[Point]) -> dict[str, Any]:
    """Return the points as JSON values, NaN as None; `front` says that no point of the same chart beats it."""
    best = [point for group in panels(points).values() for point in front(group)]
    return {"points": [json_value(point._asdict() | {"front": point in best}) for point in points]}


def bench_tables(points: list[Point]) -> list[Table]:
    """Return a table per stage and observable: the points of the front, those that the plan chooses, and failures."""
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
