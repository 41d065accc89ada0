"""Speed against accuracy: error and cost of the choices that the plan makes for a scene, and of other choices.

Errors are relative to tightly converged values. Costs are CPU seconds of one thread; divided by the time of one pair of
transforms, measured in the same run, they carry over to other machines.
"""

import time
import warnings
from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import product
from math import ceil, hypot, isnan, nan, pi, sqrt
from timeit import timeit
from typing import Any, NamedTuple

import numpy as np

from roughsim import fourier, prediction
from roughsim.charts.error_over_cost import PAIR_SIDE, CostPoint, front, panels
from roughsim.contact import Contact
from roughsim.contact.active_set import solve_contact
from roughsim.ensemble.run import shown
from roughsim.errors import ConvergenceError
from roughsim.estimate.levels import values_of
from roughsim.estimate.rounds import FIRST, FIRST_STEP, TARGET
from roughsim.grid import Array, Grid
from roughsim.machine import available_memory, workers_that_fit
from roughsim.observables.catalogue import stored_numbers
from roughsim.observables.moments import HeatSource, measure
from roughsim.observables.record import Sample
from roughsim.pipeline import Problem, solve_problem
from roughsim.planning.plan import numerics_of
from roughsim.planning.realization import below_problem, level_problem
from roughsim.scene import Scene, SceneLike, as_scene
from roughsim.scene.numerics import SAME, Numerics
from roughsim.show.table import Cell, Number, Table, json_value, table_of
from roughsim.surface.synthesis import synthesize

SEED = 21  # any number but the seed of the run: the bench has surfaces of its own
_FINEST = 4  # points per side, over the plan's, of the grid that counts as exact
_REACH = 4.0  # over the lowest cut-off: the highest one whose levels are solved
# relative standard errors that members are shared out for
_GOALS = 0.1, 0.05, 0.02, 0.01, 0.005, 0.002
# title of a chart → observable
_OBSERVABLES = {
    "T_flash, fastest": "flash_temperature",
    "T_flash, slowest": "flash_temperature",
    "contact area": "contact_fraction",
    "pressure variance": "pressure_variance",
    "r at g = 0.1 g(0)": "correlation_radius_10",
}


class _Way(NamedTuple):
    """A choice of levels for an ensemble."""

    method: str  # in words
    samples: list[Sample]  # of its levels, lowest first
    seconds: list[float]  # CPU time of a member of each
    chosen: bool = False  # whether they are all levels


def cpu_seconds(work: Callable[[], Any]) -> float:
    """Return the least CPU time of up to three calls after one that fills caches, s; one second in all is enough."""
    spent: list[float] = []
    while len(spent) < 4 and sum(spent) < 1.0:
        spent.append(timeit(work, timer=time.process_time, number=1))
    return min(spent[1:] or spent)


def contact(scene: Scene, numerics: Numerics, realizations: int) -> Iterator[CostPoint]:
    """Yield the errors of pressure and T_flash of one contact over tolerance and precision, then over the pixel."""
    problem = base_problem(scene, numerics)
    why = f"a grid {_FINEST} times as fine as planned"
    workers_that_fit(1, _FINEST**2 * problem.memory, why, available_memory())
    solve_surface = _solver(problem)
    exact = solve_surface(tolerance=1e-10)
    size, hottest = np.linalg.norm(exact.pressure), flash(problem, exact)
    tolerances = {numerics.tolerance, *(float(f"1e-{k}") for k in range(1, 9))}
    for precision, tolerance in product(("double", "single"), sorted(tolerances, reverse=True)):
        method, setting = f"{precision} precision", f"tolerance {tolerance:.0e}"
        solve = partial(solve_surface, tolerance=tolerance, precision=precision)
        chosen = (precision, tolerance) == (numerics.precision, numerics.tolerance)
        try:
            solved, cost = solve(), cpu_seconds(solve)
        except ConvergenceError:
            yield CostPoint("contact", "pressure", method, f"{setting}: failed", nan, nan, chosen)
            continue
        setting += f", {solved.transforms / 2:.0f} pairs"
        error = float(np.linalg.norm(solved.pressure - exact.pressure) / size)
        yield CostPoint("contact", "pressure", method, setting, error, cost, chosen)
        error = abs(flash(problem, solved) / hottest - 1.0)
        yield CostPoint("contact", "T_flash of these pixels", method, setting, error, cost, chosen)
    yield from _pixels(problem)


def _pixels(problem: Problem) -> Iterator[CostPoint]:
    """Yield the error of T_flash at fixed cut-off over pixels per shortest wave; four times the plan's are exact."""
    q_max = problem.spectrum.breaks[-1]
    planned = problem.grid.shape[0] * 2 * pi / (problem.grid.lengths[0] * q_max)
    values: dict[float, tuple[float, float]] = {}
    for factor in (0.5, 0.75, 1.0, 1.5, 2.0, _FINEST):
        nx, ny = (round(factor * n) for n in problem.grid.shape)
        finer = replace(problem, grid=Grid((nx, ny), problem.grid.lengths))
        if q_max <= finer.grid.nyquist:
            solve = partial(_solver(finer), tolerance=problem.tolerance)
            values[factor] = flash(finer, solve()), cpu_seconds(solve)
    exact = values.pop(_FINEST)[0]
    for factor, (value, cost) in values.items():
        setting = f"{factor * planned:.2g} pixels per shortest wave"
        texts = "contact", "T_flash, any pixel", "one grid", setting
        yield CostPoint(*texts, abs(value / exact - 1.0), cost, factor == 1.0)


def base_problem(scene: Scene, numerics: Numerics) -> Problem:
    """Return the contact problem of the coarsest capped (or elastic) level, sliding at the highest speed alone."""
    level = numerics.of_column(numerics.columns[-1])[0]
    speeds = [max(scene.speeds)]
    (friction,), (bodies,) = (
        prediction.friction_coefficient(scene, speeds),
        prediction.conduction(scene, speeds).each,
    )
    sliding = HeatSource(
        speeds, float(friction), bodies.conductivity, bodies.diffusivity, **bodies.layers._asdict()
    )
    return replace(level_problem(scene, numerics, level), sliding=sliding, seed=SEED, stream=0)


def _solver(problem: Problem) -> Callable[..., Contact]:
    """Return `solve_contact` for one surface of the problem; tolerance and precision are still to be given."""
    heights = synthesize(problem.spectrum, problem.grid, np.random.default_rng(SEED))
    load = problem.nominal_pressure
    return partial(solve_contact, heights, problem.grid, problem.solid, nominal_pressure=load)


def flash(problem: Problem, contact: Contact) -> float:
    """Return T_flash of a contact, K, averaged over directions."""
    return float(measure(contact, problem.grid, problem.sliding).flash_temperature[-1])


def chain(scene: Scene, numerics: Numerics, realizations: int) -> Iterator[CostPoint]:
    """Yield the error of the mean of each extrapolated observable over the cost of the ensemble.

    Each choice of levels gives a curve over the statistical error that its members are shared out for. The reference is
    the estimate from all levels and realizations, and its own error is the uncertainty of the points.
    """
    column = numerics.columns[-1]
    ways = ways_of(scene, numerics, realizations)
    everything = next(way.samples for way in ways if way.chosen)
    for title, name in _OBSERVABLES.items():
        speed = _place_of_speed(scene, title)
        fixed = name == "pressure_variance" and not scene.elastic  # by force balance
        if speed is None or fixed:
            continue
        reference = values_of(scene, column, name, everything)
        truth = float(reference.value[speed])
        errors = [part[speed] for part in reference.errors.values()]
        uncertainty = float(np.linalg.norm(np.nan_to_num(errors))) / abs(truth)
        for way in ways:
            values = values_of(scene, column, name, way.samples)
            bias = float(values.value[speed]) / truth - 1.0
            # relative variance by one member; none of a refined level whose place a higher one takes
            variances = {stream: float(part[speed]) for stream, part in values.variance.items()}
            scatter = [
                variances.get(sample.stream, 0.0) * realizations / truth**2
                for sample in way.samples
            ]
            yield from _curve(scene, title, way, scatter, bias, uncertainty)


def _place_of_speed(scene: Scene, title: str) -> int | None:
    """Return the place of the speed of an observable by its title; None if the scene has no slowest speed above 0."""
    fastest, slowest = int(np.argmax(scene.speeds)), int(np.argmin(scene.speeds))
    if title == "T_flash, fastest":
        return fastest
    if title == "T_flash, slowest":
        return slowest if 0.0 < scene.speeds[slowest] < scene.speeds[fastest] else None
    return 0


def _curve(
    scene: Scene, title: str, way: _Way, scatter: list[float], bias: float, uncertainty: float
) -> Iterator[CostPoint]:
    """Yield the points of one choice of levels, with members shared out for smaller and smaller scatter."""
    band = dict(TARGET) | dict(scene.ensemble.until or TARGET)
    aim = band["flash_temperature"] * sqrt(0.5) / 1.96
    planned = shared_out(scatter, way.seconds, aim) if way.chosen else ()
    goals = sorted({*_GOALS, aim}, reverse=True)
    for counts in dict.fromkeys(shared_out(scatter, way.seconds, goal) for goal in goals):
        variance = sum(part / n for part, n in zip(scatter, counts, strict=True))
        cost = sum(part * n for part, n in zip(way.seconds, counts, strict=True))
        setting = f"{' + '.join(map(str, counts))} members"
        error = hypot(bias, sqrt(variance), uncertainty)
        texts = "chain", title, way.method, setting
        yield CostPoint(*texts, error, cost, counts == planned, uncertainty=uncertainty)


def ways_of(scene: Scene, numerics: Numerics, realizations: int) -> list[_Way]:
    """Solve the levels of the main column, and return the choices of levels to compare.

    They are each grid of the run's cell alone, the first cut-offs without refined, and all levels.
    """
    of_column = numerics.of_column(numerics.columns[-1])
    highest = _REACH * numerics.levels[of_column[0]].q_max * (1 + SAME)
    levels = [level for level in of_column if numerics.levels[level].q_max <= highest]
    solved = {level: solve_level(scene, numerics, level, realizations) for level in levels}
    ways = []
    for level, (sample, seconds) in solved.items():
        of_level = numerics.levels[level]
        if of_level.cell is None:
            times = of_level.q_max / numerics.levels[levels[0]].q_max
            method = f"one grid, {times:.3g}× q_c, {of_level.shape[0]}²"
            ways.append(_Way(method, [replace(sample, below=None)], [seconds[0]]))
    coarse = [level for level in numerics.coarse_levels(numerics.columns[-1]) if level in solved]
    choices = {
        f"{k} cut-offs": coarse[:k] for k in range(2, len(coarse) + 1) if coarse[:k] != levels
    }
    for method, used in (choices | {"all levels": levels}).items():
        samples = [solved[level][0] for level in used]
        ways.append(
            _Way(method, samples, [sum(solved[level][1]) for level in used], used is levels)
        )
    return ways


def solve_level(
    scene: Scene, numerics: Numerics, level: int, realizations: int
) -> tuple[Sample, list[float]]:
    """Solve realizations of a level, and of the level below on the same surfaces.

    Return their numbers, and the median CPU time of a solve of each from scratch, s (a run begins each level from the
    contact below it, which takes less). One realization more goes ahead, untimed: it makes the plans of FFTW and
    compiles the kernels.
    """
    above, below = level_problem(scene, numerics, level), below_problem(scene, numerics, level)
    # a grid alone has the control variate of a lowest level, too
    problems = [replace(above, with_peaks=numerics.levels[level].cell is None)]
    if below is not None:
        problems.append(below)
    samples, medians = [], []
    for problem in problems:
        numbers = defaultdict[str, list[Array]](list)
        spectra, seconds = [], []
        solve_problem(replace(problem, seed=SEED, index=realizations))
        for index in range(realizations):
            start = time.process_time()
            solution = solve_problem(replace(problem, seed=SEED, index=index))
            seconds.append(time.process_time() - start)
            for name, number in stored_numbers(solution).items():
                numbers[name].append(number)
            stress = solution.observables.stress_spectrum
            spectra.append(stress.variance)
        samples.append(
            Sample(
                q_max=problem.spectrum.breaks[-1],
                side=float(problem.grid.shape[0]),
                rows=np.arange(realizations),
                numbers={name: np.stack(rows) for name, rows in numbers.items()},
                wavenumber=stress.wavenumber,
                spectrum=np.stack(spectra),
                reach=0.5 * float(np.hypot(*problem.grid.lengths)),
                part=numerics.levels[level].parts > 1,
                level=level,
                stream=numerics.stream(level),
            )
        )
        medians.append(float(np.median(seconds)))
    return replace(samples[0], below=samples[1] if below else None), medians


def shared_out(scatter: Sequence[float], seconds: Sequence[float], goal: float) -> tuple[int, ...]:
    """Return the members of each level that reach a relative standard error at the least cost.

    `scatter` is the relative variance by one member of each level, `seconds` its cost; no level has fewer members than
    those of a first round.
    """
    total = sum(sqrt(part * cost) for part, cost in zip(scatter, seconds, strict=True))
    counts = list[int]()
    for part, cost in zip(scatter, seconds, strict=True):
        least = FIRST_STEP if counts else FIRST
        counts.append(max(ceil(sqrt(part / cost) * total / goal**2), least))
    return tuple(counts)


STAGES: dict[str, Callable[[Scene, Numerics, int], Iterator[CostPoint]]] = {
    "contact": contact,
    "chain": chain,
}


def bench(
    scene: SceneLike,
    *,
    changes: Mapping[str, Any] | None = None,
    numerics: Numerics | None = None,
    stages: Collection[str] = tuple(STAGES),
    realizations: int = 8,
    progress: bool = True,
) -> list[CostPoint]:
    """Measure error and cost of several ways to compute a scene, stage by stage.

    Parameters
    ----------
    scene, changes
        As for `load_scene`.
    numerics : Numerics, optional
        Its choices are marked as chosen. Default: from `plan`.
    stages : collection of {"contact", "chain"}
        Stages to measure.
    realizations : int
        Realizations that scatter and bias are measured over, ≥ 4.
    progress : bool
        As of `run`.

    Returns
    -------
    list of CostPoint
        Each has its `stage`, `observable`, `method`, `setting`, relative `error`, and `seconds` of CPU.

    Raises
    ------
    ValueError
        If a stage is unknown, there are too few realizations, or no speed of the scene is above zero.
    """
    scene = as_scene(scene, changes)
    for name in stages:
        if name not in STAGES:
            raise ValueError(f"stage = {name!r} is unknown; choose one of {', '.join(STAGES)}")
    if max(scene.speeds) <= 0.0:
        raise ValueError(
            "speed = 0 m/s is the highest of the scene, so nothing heats; add a speed above zero"
        )
    if isinstance(realizations, bool) or int(realizations) != realizations or realizations < 4:
        raise ValueError(
            f"realizations = {realizations!r} must be a whole number ≥ 4, to measure scatter and bias"
        )
    numerics = numerics_of(scene) if numerics is None else numerics
    with warnings.catch_warnings():
        # they warn of errors that are measured here
        warnings.simplefilter("ignore", RuntimeWarning)
        with shown(progress, "measuring") as bar:
            points = list[CostPoint]()
            for number, name in enumerate(stages):
                for point in STAGES[name](scene, numerics, realizations):
                    points.append(point)
                    if bar is not None:
                        text = f"{point.stage}: {point.observable}, {point.method}, {point.setting}"
                        bar.show(text, number / len(stages), number)
        return in_pairs(points)


def in_pairs(points: Iterable[CostPoint]) -> list[CostPoint]:
    """Return the points with their costs in pairs of real transforms (forward, inverse) of `PAIR_SIDE`² points."""
    transform = fourier.Transform((PAIR_SIDE, PAIR_SIDE), np.float64)
    transform.field[...] = np.random.default_rng(1).random(transform.field.shape)

    def pair() -> None:
        transform.forward()
        transform.inverse()

    seconds = cpu_seconds(pair)
    return [point._replace(pairs=point.seconds / seconds) for point in points]


def bench_dict(points: list[CostPoint]) -> dict[str, Any]:
    """Return the points as JSON values, NaN as None; `front`: no point of the same chart beats it."""
    best = [point for group in panels(points).values() for point in front(group)]
    return {"points": json_value([point._asdict() | {"front": point in best} for point in points])}


def bench_tables(points: list[CostPoint]) -> list[Table]:
    """Return a table per stage and observable: the Pareto front, the choice of the plan, and failures."""
    tables = []
    for title, group in panels(points).items():
        best = front(group)
        rows: list[dict[str, Cell]] = [
            {
                "error": Number(point.error, digits=2),
                "CPU s": Number(point.seconds, digits=2),
                "FFT pairs": Number(point.pairs, digits=2),
                "method": point.method,
                "setting": point.setting,
                "": ", ".join(["front"] * (point in best) + ["plan"] * point.chosen),
            }
            for point in group
            if point in best or point.chosen or isnan(point.error)
        ]
        tables.append(table_of(rows, title, texts=("method", "setting", "")))
    return tables
