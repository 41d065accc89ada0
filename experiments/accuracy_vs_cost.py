"""Error over cost: every stage, and the whole chain.

    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python experiments/accuracy_vs_cost.py [CHART ...] [--resume] [-o F]

Charts: those of `roughsim bench` for a scene (contact, chain), and stages: the ways to compute surface, heat, moments
and theory, of which roughsim always takes the same one. All by default. --evidence draws accuracy_contact.png for
docs/accuracy.md: errors of T_flash of one contact over the CPU time, which an idle machine measures in ten seconds.
Costs are CPU seconds of one thread, and the same in FFT pairs timed in the same run. Everything lies in data.json.
"""

from __future__ import annotations

import warnings
from dataclasses import replace
from functools import partial
from itertools import pairwise
from math import inf, pi

import figures
import numpy as np
from script import Command, Rows, show_on_pages

import roughsim as rs
from roughsim import prediction
from roughsim.charts.error_over_cost import CostPoint, error_over_cost_chart, front, panels
from roughsim.error_over_cost import SEED, STAGES, base_problem, bench, cpu_seconds, flash, in_pairs
from roughsim.heat.periodic import uniform_temperature
from roughsim.observables.moments import angular_means
from roughsim.pipeline import solve_problem
from theory import hertz

CHARTS = {
    "contact": ("contact",),
    "stages": ("surface", "heat", "moments", "theory"),
    "chain": ("chain",),
}
SHARES = (0.25, 0.5, 1.0, 2.0)  # sides of a cell over the planned one
UNIT = {"conductivity": 1.0, "diffusivity": 1.0}


def toy_numerics():
    """Of the demo, with few points."""
    capped = rs.Level("capped", (64, 64), 4e4), rs.Level("capped", (128, 128), 8e4)
    return rs.Numerics(capped, (4e-3, 4e-3))


# the stages: each a few ways to compute the same, as generators of points


def scaled_cell(problem, share):
    """A cell with sides scaled at fixed pixels, and how many of the longest waves it has along x."""
    nx, ny = (max(8, round(share * n)) for n in problem.grid.shape)
    grid = rs.Grid((nx, ny), (share * problem.grid.lengths[0], share * problem.grid.lengths[1]))
    return grid, grid.lengths[0] * problem.spectrum.breaks[0] / (2 * pi)


def surface(scene, problem, realizations):
    """Rms height of a drawn surface, over the side of the cell and the kind of amplitudes."""
    rms_height = scene.spectrum.truncated(q_max=problem.spectrum.breaks[-1]).rms_height
    for share in SHARES:
        grid, waves = scaled_cell(problem, share)
        for kind in ("fixed", "gaussian"):

            def draw(index=0, grid=grid, kind=kind):
                return rs.synthesize(
                    problem.spectrum, grid, np.random.default_rng((SEED, index)), amplitudes=kind
                )

            ratios = np.array([draw(index).std() for index in range(realizations)]) / rms_height
            error, chosen = (
                float(np.sqrt(np.mean((ratios - 1.0) ** 2))),
                share == 1 and kind == "fixed",
            )
            setting = f"{waves:.3g} longest waves, {grid.shape[0]}²"
            yield CostPoint(
                "surface",
                "rms height",
                f"{kind} amplitudes",
                setting,
                error,
                cpu_seconds(draw),
                chosen,
            )


def hertz_like(scene):
    """R, m, and vR/D of the fast Hertz contact with the theory's D_flash, and its T_flash in q̇₁R/κ."""
    speed = max(scene.speeds)
    width = float(
        prediction.over_speed(scene, np.array([speed]), names=("flash_width",))["flash_width"][0]
    )
    radius = width / hertz.FAST.flash_width
    peclet = speed * radius / float(prediction.conduction(scene, [speed]).diffusivity[0])
    return radius, peclet, float(hertz.flash_temperature(peclet))


def heat(scene, problem, realizations):
    """T_flash of a Hertz contact as wide as the theory's D_flash at the highest speed, over pixels and methods."""
    radius, peclet, exact = hertz_like(scene)
    planned = min(max(2, round(radius / problem.grid.spacing[0])), 64)
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
                yield CostPoint(
                    "heat",
                    "T_flash of a Hertz contact",
                    method,
                    setting,
                    abs(value / exact - 1),
                    cost,
                    chosen,
                )


def hertz_source(pixels, margin, dtype):
    """The mean flux of each pixel, from 8² points, and its cell of 2·margin, in units of the radius."""
    x = (np.arange(16 * pixels) - (16 * pixels - 1) / 2) / pixels / 8
    fine = np.sqrt(np.maximum(1 - x[:, None] ** 2 - x**2, 0.0))
    heated = fine.reshape(2 * pixels, 8, 2 * pixels, 8).mean((1, 3)).astype(dtype)
    flux = np.pad(heated, round(pixels * margin) - pixels)
    return flux, rs.Grid(flux.shape, (len(flux) / pixels,) * 2)


def from_rest(flux, grid, speed):
    """The temperature after sliding half a cell, with its mean."""
    mean = uniform_temperature(float(flux.mean()), grid.lengths[0] / 2 / speed, **UNIT)
    return rs.sliding_temperature(flux, grid, speed=speed, **UNIT) + mean


# method → half the side of its cell over the radius, and the temperature of (flux, grid, speed)
HEAT = {
    "periodic, steady": (
        4.0,
        lambda f, g, v: rs.sliding_temperature(f, g, speed=v, slid_distance=inf, **UNIT),
    ),
    "periodic, from rest": (4.0, from_rest),
    "free half-space": (1.05, lambda f, g, v: rs.half_space_temperature(f, g, speed=v, **UNIT)),
}


def body_of(sliding):
    """The one speed, m/s, with μ, and κ, W/(m K), and D, m²/s, of the body."""
    values = sliding.speeds, sliding.friction_coefficient, sliding.conductivity, sliding.diffusivity
    return tuple(float(np.ravel(x)[0]) for x in values)


def moments(scene, problem, realizations):
    """T_flash of one realization against the mean of many: scatter and bias of the ways to measure it."""
    contacts = [
        solve_problem(replace(problem, index=index)).contact for index in range(realizations)
    ]
    exact = np.mean([flash(problem, one) for one in contacts])

    def along(contact, count):
        turned = (replace(problem.sliding, direction=pi * k / count) for k in range(count))
        return float(
            np.mean([flash(replace(problem, sliding=sliding), contact) for sliding in turned])
        )

    def of_field(contact, dtype, slid_distance):
        flux, (speed, friction, conductivity, diffusivity) = (
            contact.pressure.astype(dtype),
            body_of(problem.sliding),
        )
        body = {"speed": speed, "conductivity": conductivity, "diffusivity": diffusivity}
        temperature = rs.sliding_temperature(
            flux, problem.grid, slid_distance=slid_distance, **body
        )
        rate = friction * speed
        return rate * float(np.mean(temperature * flux, dtype=np.float64)) / float(flux.mean())

    ways = {
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
        yield CostPoint(
            "moments",
            "T_flash of one realization",
            name,
            "",
            error,
            cost,
            name == "mean over directions",
        )


def theory(scene, problem, realizations):
    """T_flash of the theory: its adaptive quadrature, plain Gauss points, and sums over the modes of a cell."""
    what, speeds = "T_flash of the theory", np.array([max(scene.speeds)])
    exact = gauss_flash(scene, problem.sliding, panels=8, nodes=32)
    adaptive = partial(prediction.over_speed, scene, speeds)
    error, cost = abs(adaptive()["flash_temperature"][0] / exact - 1), cpu_seconds(adaptive)
    yield CostPoint(
        "theory", what, "package theory", "adaptive, five quantities", error, cost, True
    )
    for nodes in (4, 8, 16, 32, 64, 128):
        gauss = partial(gauss_flash, scene, problem.sliding, panels=1, nodes=nodes)
        error, cost = abs(gauss() / exact - 1), cpu_seconds(gauss)
        yield CostPoint("theory", what, "Gauss points", f"{nodes} between breaks", error, cost)
    # sums over modes up to the cut-off of the level, against the integral up to there
    whole = float(
        prediction.over_speed(scene, np.array(scene.speeds), problem.spectrum)["flash_temperature"][
            -1
        ]
    )
    for share in SHARES:
        grid, waves = scaled_cell(problem, share)
        total = partial(prediction.mode_sums, scene, problem.spectrum, grid)
        error, cost = abs(float(total()["flash_temperature"][-1]) / whole - 1), cpu_seconds(total)
        yield CostPoint(
            "theory", what, "sum over modes", f"cell of {waves:.3g} longest waves", error, cost
        )


def gauss_flash(scene, sliding, *, panels, nodes):
    """T_flash of the theory by Gauss points in ln q on equal panels between the breaks, K."""
    x, w = np.polynomial.legendre.leggauss(nodes)
    ends = np.log(np.array(prediction.smoothed_spectrum(scene).breaks))
    edges = np.concatenate([np.linspace(a, b, panels + 1)[:-1] for a, b in pairwise(ends)])
    edges = np.append(edges, ends[-1])
    half = np.diff(edges)[:, None] / 2
    q = np.exp(edges[:-1, None] + half * (1 + x)).ravel()
    speed, friction, conductivity, diffusivity = body_of(sliding)
    even, _ = angular_means(speed / diffusivity / q)
    rate = friction * speed / (conductivity * scene.sliding.nominal_pressure)
    density = 2 * pi * q * prediction.stress_spectrum(scene, q) * even
    return float(rate * np.sum((half * w).ravel() * density))


WAYS = {"surface": surface, "heat": heat, "moments": moments, "theory": theory}


def measured(rows, stage, scene, numerics, realizations):
    """The points of a stage: those in the file, or new ones, which are stored."""
    if not rows[stage]:
        if stage in STAGES:
            points = bench(scene, numerics=numerics, stages=[stage], realizations=realizations)
        else:
            with warnings.catch_warnings():
                warnings.simplefilter(
                    "ignore", RuntimeWarning
                )  # the errors that they warn of are what is charted
                points = in_pairs(WAYS[stage](scene, base_problem(scene, numerics), realizations))
        rows.extend(
            stage, {f"{p.observable} | {p.method} | {p.setting}": p._asdict() for p in points}
        )
    return [CostPoint(**row) for row in rows[stage].values()]


def cost_chart(rows, name, scene, numerics, folder, realizations):
    points = [
        point
        for stage in CHARTS[name]
        for point in measured(rows, stage, scene, numerics, realizations)
    ]
    error_over_cost_chart(points, folder / f"{name}.png")
    for title, group in panels(points).items():
        print(title)
        best = front(group)
        for point in sorted({*best, *(p for p in group if p.chosen)}, key=lambda p: p.seconds):
            marks = " | front" * (point in best) + " | plan" * point.chosen
            print(
                f"   {point.error:8.1e} {point.pairs:9.3g} pairs  {point.method}, {point.setting}{marks}"
            )


def main() -> None:
    command = Command(__file__, __doc__)
    command.add_argument(
        "charts", nargs="*", metavar="CHART", help=f"{', '.join(CHARTS)}; all if left out"
    )
    command.add_argument(
        "--resume", action="store_true", help="keep the rows that are already in data.json"
    )
    command.add_argument("--scene", default="steel-1.2GPa", help="a scene, by name or path")
    command.add_argument(
        "--realizations", type=int, default=None, help="members of the chain and of the moments"
    )
    options = command.parse()
    if unknown := set(options.charts) - set(CHARTS):
        command.error(f"{', '.join(unknown)}: choose from {', '.join(CHARTS)}")
    rows = Rows(options.output / "data.json", resume=options.resume)
    scene = rs.load_scene("demo" if options.toy else options.scene)
    numerics = toy_numerics() if options.toy else rs.plan(scene)
    realizations = options.realizations or (4 if options.toy else 16)
    for chart in options.charts or CHARTS:
        cost_chart(rows, chart, scene, numerics, options.output, realizations)
    if options.evidence:
        points = measured(rows, "contact", scene, numerics, realizations)
        points += measured(rows, "moments", scene, numerics, realizations)
        picture = options.output / "accuracy_contact.png"
        figures.one_contact(
            [point._asdict() for point in points if point.observable != "pressure"], picture
        )
        show_on_pages(picture)


if __name__ == "__main__":
    main()
