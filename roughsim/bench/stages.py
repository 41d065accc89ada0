"""The stages of a scene one by one: each a few ways to compute the same, their errors and their costs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import pairwise
from math import inf, pi
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughsim import prediction
from roughsim.bench.timing import cpu_seconds
from roughsim.charts.error_over_cost import Point
from roughsim.contact import Contact
from roughsim.contact.active_set import solve_contact
from roughsim.errors import ConvergenceError
from roughsim.grid import Grid
from roughsim.heat import half_space_temperature, sliding_temperature, uniform_temperature
from roughsim.observables.angular import angular_means
from roughsim.observables.moments import Moments, Sliding, measure
from roughsim.realization import level_problem, realize
from roughsim.scene.numerics import Level, Numerics
from roughsim.surface.synthesis import synthesize

if TYPE_CHECKING:
    from roughsim.scene import Scene

Array = NDArray[np.float64]
_SEED = 21  # any number: surfaces of their own, neither the run's nor the pilot's


def base_level(scene: Scene, numerics: Numerics) -> int:
    """Return the coarsest level of the column that the run is judged by."""
    return numerics.of_column("elastic" if scene.elastic else "capped")[0]


def surface(scene: Scene, numerics: Numerics, realizations: int) -> Iterator[Point]:
    """Rms height of a drawn surface, over the side of the cell and the kind of amplitudes."""
    level = base_level(scene, numerics)
    spectrum, planned = scene.spectrum.truncated(q_max=numerics.levels[level].q_max), numerics.grid(level)
    waves = planned.lengths[0] * spectrum.breaks[0] / (2 * pi)
    exact = spectrum.rms_height
    for share in (0.25, 0.5, 1.0, 2.0):
        shape = tuple(max(8, round(share * n)) for n in planned.shape)
        grid = Grid((shape[0], shape[1]), (share * planned.lengths[0], share * planned.lengths[1]))
        for kind in ("fixed", "gaussian"):
            draw = partial(synthesize, spectrum, grid, amplitudes=kind)
            rms = [float(np.std(_draw(draw, i))) for i in range(realizations)]
            error = float(np.sqrt(np.mean((np.array(rms) / exact - 1.0) ** 2)))
            cost = cpu_seconds(partial(_draw, draw))
            setting = f"{share * waves:.3g} longest waves, {grid.shape[0]}²"
            yield Point(
                "surface", "rms height", f"{kind} amplitudes", setting, error, cost, share == 1 and kind == "fixed"
            )


def _draw(synthesis: Callable[..., Array], index: int = 0) -> Array:
    return synthesis(np.random.default_rng((_SEED, index)))


def contact(scene: Scene, numerics: Numerics, realizations: int) -> Iterator[Point]:
    """Pressure and T_flash of one contact, over tolerance, precision and pixel."""
    level = base_level(scene, numerics)
    heights, grid = _drawn(scene, numerics, level), numerics.grid(level)
    exact = _solved(scene, numerics, level, heights, grid, tolerance=1e-10)
    truth = _flash(scene, exact, grid)
    for precision in ("double", "single"):
        for tolerance in 10.0 ** -np.arange(1.0, 9.0):
            solve = partial(
                _solved, scene, numerics, level, heights, grid, tolerance=float(tolerance), precision=precision
            )
            chosen = precision == numerics.precision and np.isclose(tolerance, numerics.tolerance)
            yield from _contact_points(scene, solve, grid, exact, truth, f"{precision} precision", chosen)
    yield from _pixels(scene, numerics, level)


def _contact_points(
    scene: Scene, solve: Any, grid: Grid, exact: Contact, truth: float, method: str, chosen: bool
) -> Iterator[Point]:
    setting = f"tolerance {solve.keywords['tolerance']:.0e}"
    try:
        found = solve()
        cost = cpu_seconds(solve)
    except ConvergenceError:
        yield Point("contact", "pressure", method, setting + ": failed", np.nan, np.nan, chosen)
        return
    error = float(np.linalg.norm(found.pressure - exact.pressure) / np.linalg.norm(exact.pressure))
    setting += f", {found.transforms / 2:.0f} pairs"
    yield Point("contact", "pressure", method, setting, error, cost, chosen)
    flash = abs(_flash(scene, found, grid) / truth - 1.0)
    yield Point("contact", "T_flash of these pixels", method, setting, flash, cost, chosen)


def _pixels(scene: Scene, numerics: Numerics, level: int) -> Iterator[Point]:
    """T_flash of one contact at a fixed cut-off over the pixels of its shortest wave; 16 stand for none."""
    given = numerics.levels[level]
    planned = given.shape[0] * 2 * pi / (numerics.lengths[0] * given.q_max)
    values: dict[float, tuple[float, float]] = {}
    for factor in (0.5, 0.75, 1.0, 1.5, 2.0, 4.0):
        shape = round(factor * given.shape[0]), round(factor * given.shape[1])
        grid = Grid(shape, numerics.lengths)
        if given.q_max > grid.nyquist:
            continue
        heights = _drawn(scene, replace(numerics, levels=(Level(given.column, shape, given.q_max),)), 0)
        solve = partial(_solved, scene, numerics, level, heights, grid, tolerance=numerics.tolerance)
        values[factor] = _flash(scene, solve(), grid), cpu_seconds(solve, repeats=1)
    truth = values.pop(4.0)[0]
    for factor, (value, cost) in values.items():
        setting = f"{factor * planned:.2g} pixels per shortest wave"
        yield Point("contact", "T_flash, any pixel", "one grid", setting, abs(value / truth - 1.0), cost, factor == 1.0)


def heat(scene: Scene, numerics: Numerics, realizations: int) -> Iterator[Point]:
    """T_flash of a Hertz contact as wide as the theory's D_flash at the highest speed, over pixels and methods."""
    radius, peclet, exact = prediction.hertz_like(scene)
    planned = min(max(2, round(radius / numerics.grid(base_level(scene, numerics)).spacing[0])), 64)
    for name, (margin, work) in HEAT.items():
        for dtype in (np.float64, np.float32):
            for pixels in sorted({4, 8, 16, 32, 64, planned}):
                if dtype is np.float32 and name != "periodic, from rest":
                    continue
                flux, grid = _hertz_source(pixels, margin, dtype)
                value = float((work(flux, grid, peclet) * flux).sum() / flux.sum())
                cost = cpu_seconds(partial(work, flux, grid, peclet))
                method = name + (", float32" if dtype is np.float32 else "")
                chosen = name == "periodic, from rest" and dtype is np.float64 and pixels == planned
                setting = f"{pixels} pixels per radius, vR/D = {peclet:.3g}"
                yield Point("heat", "T_flash of a Hertz contact", method, setting, abs(value / exact - 1), cost, chosen)


def _hertz_source(pixels: int, margin: float, dtype: Any) -> tuple[NDArray[Any], Grid]:
    """Mean flux of each pixel, from 8² points, in units of the radius; the cell is 2·margin wide."""
    x = (np.arange(16 * pixels) - (16 * pixels - 1) / 2) / pixels / 8
    fine = np.sqrt(np.maximum(1 - x[:, None] ** 2 - x**2, 0.0))
    heated = fine.reshape(2 * pixels, 8, 2 * pixels, 8).mean((1, 3)).astype(dtype)
    around = round(pixels * margin) - pixels
    flux = np.pad(heated, around)
    return flux, Grid(flux.shape, (len(flux) / pixels,) * 2)


_UNIT = {"conductivity": 1.0, "diffusivity": 1.0}


def _from_rest(flux: NDArray[Any], grid: Grid, speed: float) -> Any:
    slid = grid.lengths[0] / 2 / speed
    return sliding_temperature(flux, grid, speed=speed, **_UNIT) + uniform_temperature(
        float(flux.mean()), slid, **_UNIT
    )


HEAT: dict[str, tuple[float, Callable[[NDArray[Any], Grid, float], Any]]] = {
    "periodic, steady": (4.0, lambda f, g, v: sliding_temperature(f, g, speed=v, slid_distance=inf, **_UNIT)),
    "periodic, from rest": (4.0, _from_rest),
    "free half-space": (1.05, lambda f, g, v: half_space_temperature(f, g, speed=v, **_UNIT)),
}


def moments(scene: Scene, numerics: Numerics, realizations: int) -> Iterator[Point]:
    """T_flash of one realization against the mean of many: scatter and bias of the ways to measure it."""
    level, speed = base_level(scene, numerics), max(scene.speeds)
    grid = numerics.grid(level)
    plain = replace(numerics, levels=(replace(numerics.levels[level], every=1),))
    solved = [realize(scene, plain, seed=_SEED, index=i).contact for i in range(realizations)]
    ways = _ways(scene, grid, speed)
    truth = np.mean([ways["mean over directions"](one) for one in solved])
    for name, way in ways.items():
        error = float(np.sqrt(np.mean([(way(one) / truth - 1.0) ** 2 for one in solved])))
        cost = cpu_seconds(partial(way, solved[0]))
        yield Point("moments", "T_flash of one realization", name, "", error, cost, name == "mean over directions")


def _ways(scene: Scene, grid: Grid, speed: float) -> dict[str, Callable[[Contact], float]]:
    sliding, (conductivity, diffusivity) = _sliding(scene), _body(scene)

    def along(one: Contact, count: int) -> float:
        turns = [replace(sliding, direction=pi * k / count) for k in range(count)]
        return float(np.mean([measure(one, grid, turn).flash_temperature[-1] for turn in turns]))

    def field(one: Contact, dtype: Any, slid: float | None) -> float:
        flux = one.pressure.astype(dtype)
        heated = sliding_temperature(
            flux, grid, speed=speed, conductivity=conductivity, diffusivity=diffusivity, slid_distance=slid
        )
        rate = scene.sliding.friction_coefficient * speed
        return rate * float(np.mean(heated * flux, dtype=np.float64)) / float(flux.mean())

    return {
        "mean over directions": lambda one: float(measure(one, grid, sliding).flash_temperature[-1]),
        "1 direction, steady": lambda one: along(one, 1),
        "4 directions, steady": lambda one: along(one, 4),
        "16 directions, steady": lambda one: along(one, 16),
        "field from rest": lambda one: field(one, np.float64, None),
        "field from rest, float32": lambda one: field(one, np.float32, None),
        "steady field": lambda one: field(one, np.float64, inf),
    }


def theory(scene: Scene, numerics: Numerics, realizations: int) -> Iterator[Point]:
    """T_flash of the theory: its adaptive quadrature, plain Gauss points, and sums over the modes of a cell."""
    speeds = np.array([max(scene.speeds)])
    exact = _plain_flash(scene, speeds, panels=8, nodes=32)
    what = "T_flash of the theory"
    value = prediction.over_speed(scene, speeds)["flash_temperature"][0]
    cost = cpu_seconds(lambda: prediction.over_speed(scene, speeds))
    yield Point("theory", what, "package theory", "adaptive, five quantities", abs(value / exact - 1), cost, True)
    for nodes in (4, 8, 16, 32, 64, 128):
        value = _plain_flash(scene, speeds, panels=1, nodes=nodes)
        cost = cpu_seconds(partial(_plain_flash, scene, speeds, panels=1, nodes=nodes))
        yield Point("theory", what, "Gauss points", f"{nodes} between breaks", abs(value / exact - 1), cost)
    yield from _modes(scene, numerics, realizations)


def _modes(scene: Scene, numerics: Numerics, realizations: int) -> Iterator[Point]:
    """Sums over modes up to the cut-off of the coarsest level, against the integral up to there."""
    level = base_level(scene, numerics)
    given, spectrum = numerics.levels[level], level_problem(scene, numerics, level).spectrum
    whole = float(prediction.over_speed(scene, np.array(scene.speeds), spectrum)["flash_temperature"][-1])
    for share in (0.25, 0.5, 1.0, 2.0):
        sides = round(share * given.shape[0]), round(share * given.shape[1])
        grid = Grid(sides, (share * numerics.lengths[0], share * numerics.lengths[1]))
        total = partial(prediction.mode_sums, scene, spectrum, grid)
        error = abs(float(total()["flash_temperature"][-1]) / whole - 1)
        waves = grid.lengths[0] * spectrum.breaks[0] / (2 * pi)
        setting = f"cell of {waves:.3g} longest waves"
        yield Point("theory", "T_flash of the theory", "sum over modes", setting, error, cpu_seconds(total))


def _plain_flash(scene: Scene, speeds: Array, *, panels: int, nodes: int) -> float:
    """T_flash by Gauss points in ln q on equal panels between the breaks."""
    x, w = np.polynomial.legendre.leggauss(nodes)
    ends = np.log(np.array(prediction.smoothed_spectrum(scene).breaks))
    edges = np.concatenate([np.linspace(a, b, panels + 1)[:-1] for a, b in pairwise(ends)])
    edges = np.append(edges, ends[-1])
    half = np.diff(edges)[:, None] / 2
    q = np.exp(edges[:-1, None] + half * (1 + x)).ravel()
    conductivity, diffusivity = _body(scene)
    even, _ = angular_means(speeds[-1] / diffusivity / q)
    rate = scene.sliding.friction_coefficient * speeds[-1] / (conductivity * scene.sliding.nominal_pressure)
    density = 2 * pi * q * prediction.stress_spectrum(scene, q) * even
    return float(rate * np.sum((half * w).ravel() * density))


def _drawn(scene: Scene, numerics: Numerics, level: int) -> Array:
    return synthesize(
        level_problem(scene, numerics, level).spectrum, numerics.grid(level), np.random.default_rng(_SEED)
    )


def _solved(
    scene: Scene,
    numerics: Numerics,
    level: int,
    heights: Array,
    grid: Grid,
    *,
    tolerance: float,
    precision: Any = "double",
) -> Contact:
    solid = level_problem(scene, numerics, level).solid
    load = scene.sliding.nominal_pressure
    return solve_contact(heights, grid, solid, nominal_pressure=load, tolerance=tolerance, precision=precision)


def _body(scene: Scene) -> tuple[float, float]:
    """κ and D of the moving body at the highest speed."""
    bodies = prediction.conduction(scene, [max(scene.speeds)])
    return float(bodies.conductivity[0]), float(bodies.diffusivity[0])


def _sliding(scene: Scene) -> Sliding:
    return Sliding([max(scene.speeds)], scene.sliding.friction_coefficient, *_body(scene))


def _flash(scene: Scene, contact: Contact, grid: Grid) -> float:
    seen: Moments = measure(contact, grid, _sliding(scene))
    return float(seen.flash_temperature[-1])
