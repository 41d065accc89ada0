"""The stages of a scene one by one: each a few ways to compute the same, their errors and their costs."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import pairwise
from math import inf, nan, pi
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughsim import prediction
from roughsim.charts.error_over_cost import Point
from roughsim.contact import Contact
from roughsim.contact.active_set import solve_contact
from roughsim.errors import ConvergenceError
from roughsim.grid import Grid
from roughsim.heat.half_space import half_space_temperature
from roughsim.heat.periodic import sliding_temperature, uniform_temperature
from roughsim.observables.moments import Sliding, angular_means, measure
from roughsim.pipeline import Problem, solve_problem
from roughsim.realization import level_problem
from roughsim.surface.synthesis import synthesize

if TYPE_CHECKING:
    from roughsim.scene import Scene
    from roughsim.scene.numerics import Numerics

SEED = 21  # any number: surfaces of their own, neither the run's nor the pilot's
SHARES = (0.25, 0.5, 1.0, 2.0)  # sides of a cell over the planned one


def cpu_seconds(work: Callable[[], Any], *, repeats: int = 3, enough: float = 1.0) -> float:
    """Return the least CPU time of up to `repeats` calls, s, after a first one that fills caches; `enough` s end it."""
    start = time.process_time()
    work()
    if time.process_time() - start > enough:
        return time.process_time() - start
    spent: list[float] = []
    while len(spent) < repeats and sum(spent) < enough:
        start = time.process_time()
        work()
        spent.append(time.process_time() - start)
    return min(spent)


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


def body_of(sliding: Sliding) -> tuple[float, float, float]:
    """Return the one speed, m/s, with κ, W/(m K), and D, m²/s, of the body."""
    conductivity, diffusivity = (float(np.ravel(x)[0]) for x in (sliding.conductivity, sliding.diffusivity))
    return float(sliding.speeds[0]), conductivity, diffusivity


def scaled_cell(problem: Problem, share: float) -> tuple[Grid, float]:
    """Return a cell with sides scaled at fixed pixels, and how many of the longest waves it has along x."""
    nx, ny = (max(8, round(share * n)) for n in problem.grid.shape)
    grid = Grid((nx, ny), (share * problem.grid.lengths[0], share * problem.grid.lengths[1]))
    return grid, grid.lengths[0] * problem.spectrum.breaks[0] / (2 * pi)


def surface(scene: Scene, numerics: Numerics, realizations: int) -> Iterator[Point]:
    """Rms height of a drawn surface, over the side of the cell and the kind of amplitudes."""
    problem = base_problem(scene, numerics)
    rms_height = scene.spectrum.truncated(q_max=problem.spectrum.breaks[-1]).rms_height
    for share in SHARES:
        grid, waves = scaled_cell(problem, share)
        for kind in ("fixed", "gaussian"):

            def draw(index: int = 0, grid: Grid = grid, kind: Any = kind) -> NDArray[np.float64]:
                return synthesize(problem.spectrum, grid, np.random.default_rng((SEED, index)), amplitudes=kind)

            ratios = np.array([draw(index).std() for index in range(realizations)]) / rms_height
            error, chosen = float(np.sqrt(np.mean((ratios - 1.0) ** 2))), share == 1 and kind == "fixed"
            setting = f"{waves:.3g} longest waves, {grid.shape[0]}²"
            yield Point("surface", "rms height", f"{kind} amplitudes", setting, error, cpu_seconds(draw), chosen)


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
            values[factor] = flash(finer, solve()), cpu_seconds(solve, repeats=1)
    exact = values.pop(4.0)[0]
    for factor, (value, cost) in values.items():
        setting = f"{factor * planned:.2g} pixels per shortest wave"
        yield Point("contact", "T_flash, any pixel", "one grid", setting, abs(value / exact - 1.0), cost, factor == 1.0)


def heat(scene: Scene, numerics: Numerics, realizations: int) -> Iterator[Point]:
    """T_flash of a Hertz contact as wide as the theory's D_flash at the highest speed, over pixels and methods."""
    radius, peclet, exact = prediction.hertz_like(scene)
    planned = min(max(2, round(radius / base_problem(scene, numerics).grid.spacing[0])), 64)
    for name, (margin, work) in HEAT.items():
        usual = name == "periodic, from rest"  # as runs do it
        for dtype in (np.float64, np.float32) if usual else (np.float64,):
            method = name + (", float32" if dtype is np.float32 else "")
            for count in sorted({4, 8, 16, 32, 64, planned}):
                flux, grid = hertz_source(count, margin, dtype)
                value = float((work(flux, grid, peclet) * flux).sum() / flux.sum())
                cost = cpu_seconds(partial(work, flux, grid, peclet))
                chosen = usual and dtype is np.float64 and count == planned
                setting = f"{count} pixels per radius, vR/D = {peclet:.3g}"
                yield Point("heat", "T_flash of a Hertz contact", method, setting, abs(value / exact - 1), cost, chosen)


def hertz_source(pixels: int, margin: float, dtype: Any) -> tuple[NDArray[Any], Grid]:
    """Return the mean flux of each pixel, from 8² points, and its cell of 2·margin, in units of the radius."""
    x = (np.arange(16 * pixels) - (16 * pixels - 1) / 2) / pixels / 8
    fine = np.sqrt(np.maximum(1 - x[:, None] ** 2 - x**2, 0.0))
    heated = fine.reshape(2 * pixels, 8, 2 * pixels, 8).mean((1, 3)).astype(dtype)
    flux = np.pad(heated, round(pixels * margin) - pixels)
    return flux, Grid(flux.shape, (len(flux) / pixels,) * 2)


UNIT = {"conductivity": 1.0, "diffusivity": 1.0}


def from_rest(flux: NDArray[Any], grid: Grid, speed: float) -> Any:
    """Return the temperature after sliding half a cell, with its mean."""
    mean = uniform_temperature(float(flux.mean()), grid.lengths[0] / 2 / speed, **UNIT)
    return sliding_temperature(flux, grid, speed=speed, **UNIT) + mean


# method → half the side of its cell over the radius, and the temperature of (flux, grid, speed)
HEAT: dict[str, tuple[float, Callable[[NDArray[Any], Grid, float], Any]]] = {
    "periodic, steady": (4.0, lambda f, g, v: sliding_temperature(f, g, speed=v, slid_distance=inf, **UNIT)),
    "periodic, from rest": (4.0, from_rest),
    "free half-space": (1.05, lambda f, g, v: half_space_temperature(f, g, speed=v, **UNIT)),
}


def moments(scene: Scene, numerics: Numerics, realizations: int) -> Iterator[Point]:
    """T_flash of one realization against the mean of many: scatter and bias of the ways to measure it."""
    problem = base_problem(scene, numerics)
    contacts = [solve_problem(replace(problem, index=index)).contact for index in range(realizations)]
    exact = np.mean([flash(problem, one) for one in contacts])

    def along(contact: Contact, count: int) -> float:
        turned = (replace(problem.sliding, direction=pi * k / count) for k in range(count))
        return float(np.mean([flash(replace(problem, sliding=sliding), contact) for sliding in turned]))

    def of_field(contact: Contact, dtype: Any, slid_distance: float | None) -> float:
        flux, (speed, conductivity, diffusivity) = contact.pressure.astype(dtype), body_of(problem.sliding)
        body = {"conductivity": conductivity, "diffusivity": diffusivity}
        temperature: Any = sliding_temperature(flux, problem.grid, speed=speed, slid_distance=slid_distance, **body)
        rate = problem.sliding.friction_coefficient * speed
        return rate * float(np.mean(temperature * flux, dtype=np.float64)) / float(flux.mean())

    ways: dict[str, Callable[[Contact], float]] = {
        "mean over directions": partial(flash, problem),
        "1 direction, steady": partial(along, count=1),
        "4 directions, steady": partial(along, count=4),
        "16 directions, steady": partial(along, count=16),
        "field from rest": partial(of_field, dtype=np.float64, slid_distance=None),
        "field from rest, float32": partial(of_field, dtype=np.float32, slid_distance=None),
        "steady field": partial(of_field, dtype=np.float64, slid_distance=inf),
    }
    for name, way in ways.items():
        error = float(np.sqrt(np.mean([(way(one) / exact - 1.0) ** 2 for one in contacts])))
        cost = cpu_seconds(partial(way, contacts[0]))
        yield Point("moments", "T_flash of one realization", name, "", error, cost, name == "mean over directions")


def theory(scene: Scene, numerics: Numerics, realizations: int) -> Iterator[Point]:
    """T_flash of the theory: its adaptive quadrature, plain Gauss points, and sums over the modes of a cell."""
    problem, what = base_problem(scene, numerics), "T_flash of the theory"
    speeds = np.array([max(scene.speeds)])
    exact = gauss_flash(scene, problem.sliding, panels=8, nodes=32)
    adaptive = partial(prediction.over_speed, scene, speeds)
    error, cost = abs(adaptive()["flash_temperature"][0] / exact - 1), cpu_seconds(adaptive)
    yield Point("theory", what, "package theory", "adaptive, five quantities", error, cost, True)
    for nodes in (4, 8, 16, 32, 64, 128):
        gauss = partial(gauss_flash, scene, problem.sliding, panels=1, nodes=nodes)
        error, cost = abs(gauss() / exact - 1), cpu_seconds(gauss)
        yield Point("theory", what, "Gauss points", f"{nodes} between breaks", error, cost)
    # sums over modes up to the cut-off of the level, against the integral up to there
    whole = float(prediction.over_speed(scene, np.array(scene.speeds), problem.spectrum)["flash_temperature"][-1])
    for share in SHARES:
        grid, waves = scaled_cell(problem, share)
        total = partial(prediction.mode_sums, scene, problem.spectrum, grid)
        error, cost = abs(float(total()["flash_temperature"][-1]) / whole - 1), cpu_seconds(total)
        yield Point("theory", what, "sum over modes", f"cell of {waves:.3g} longest waves", error, cost)


def gauss_flash(scene: Scene, sliding: Sliding, *, panels: int, nodes: int) -> float:
    """Return T_flash of the theory by Gauss points in ln q on equal panels between the breaks, K."""
    x, w = np.polynomial.legendre.leggauss(nodes)
    ends = np.log(np.array(prediction.smoothed_spectrum(scene).breaks))
    edges = np.concatenate([np.linspace(a, b, panels + 1)[:-1] for a, b in pairwise(ends)])
    edges = np.append(edges, ends[-1])
    half = np.diff(edges)[:, None] / 2
    q = np.exp(edges[:-1, None] + half * (1 + x)).ravel()
    speed, conductivity, diffusivity = body_of(sliding)
    even, _ = angular_means(speed / diffusivity / q)
    rate = sliding.friction_coefficient * speed / (conductivity * scene.sliding.nominal_pressure)
    density = 2 * pi * q * prediction.stress_spectrum(scene, q) * even
    return float(rate * np.sum((half * w).ravel() * density))
