"""The error budget, predicted and found: three steels, ten random scenes, ten of two faces, and what levels are worth.

    python experiments/budget.py [--toy] [-o FOLDER] [--workers N] [--only NAME ...] [--plans]

Each scene is planned for a total error of T_flash (1 % for the steels, 2 % for the random ones, 3 % for those of two
faces with different C(q), one of them with 2 µm), run until the statistical error that the plan names, and set beside
what the plan predicted: realizations, error in all, CPU and wall time. Then the gain of solving fine levels for few
realizations, by observable: the cost of all levels for every realization over that of the best split at equal
statistical error, from the scatter that each steel run has found. --toy takes two quick scenes at 4 %. --plans runs
nothing: it prints what plans of the capped scenes for 1, 2 and 3 % expect with the law for contact that yields, and
without it.
"""

from __future__ import annotations

import resource
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
from matplotlib.figure import Figure
from script import Command

import roughsim as rs
from roughsim import prediction
from roughsim.estimate.ladder import observe
from roughsim.observables.catalogue import UNITS
from roughsim.scene import parse_scene

RANDOM = """
title = "random {number}"
[surface]
rms_height = "{height:.3g} um"
hurst = {hurst:.2f}
q_min = "{q_min:.4g} 1/m"
q_max = "{q_max:.4g} 1/m"
[body]
youngs_modulus = "{modulus:.0f} GPa"
poisson_ratio = 0.3
{hardness}
conductivity = {conductivity:.1f}
density = 7000
heat_capacity = 500
[counterface]
like = "body"
[sliding]
nominal_pressure = "{pressure:.1f} MPa"
friction_coefficient = 0.2
speed = [{slow:.3g}, {fast:.3g}]
heat_partition = 0.8
[ensemble]
max_realizations = 400
"""


def random_scene(number: int) -> rs.Scene:
    """Return a scene with everything drawn at random; every third one is elastic with fewer decades of roughness."""
    draw = np.random.default_rng(1000 + number)
    elastic = number % 3 == 2
    q_min = 10 ** draw.uniform(3, 4)
    decades = draw.uniform(1.0, 1.6) if elastic else draw.uniform(1.8, 3.0)
    hardness = draw.uniform(0.5, 3.0)
    return parse_scene(
        RANDOM.format(
            number=number,
            height=draw.uniform(0.3, 2.0),
            hurst=draw.uniform(0.5, 0.95),
            q_min=q_min,
            q_max=q_min * 10**decades,
            modulus=draw.uniform(60, 300),
            hardness="" if elastic else f'penetration_hardness = "{hardness:.2f} GPa"',
            conductivity=draw.uniform(5, 100),
            pressure=1e3 * hardness * draw.uniform(0.03, 0.3) if not elastic else draw.uniform(20, 200),
            slow=10 ** draw.uniform(-2, 0),
            fast=10 ** draw.uniform(0.5, 1.7),
        )
    )


def two_faces(number: int) -> rs.Scene:
    """Return a scene of two faces, the one of 2 µm, all else drawn at random."""
    draw = np.random.default_rng(2000 + number)
    scene, elastic = random_scene(number), number % 3 == 2
    q_min = 10 ** draw.uniform(3.3, 4.3)
    other = q_min * 10 ** draw.uniform(-0.3, 1.0)
    decades = draw.uniform(1.0, 1.6) if elastic else draw.uniform(1.5, 2.5)
    face = replace(
        scene.surface, rms_height=2e-6, hurst=draw.uniform(0.5, 0.95), q_min=q_min, q_max=q_min * 10**decades
    )
    counterface = replace(
        scene.counterface,
        like=None,
        rms_height=draw.uniform(0.2e-6, 3e-6),
        hurst=draw.uniform(0.4, 0.95),
        q_min=other,
        q_max=other * 10 ** draw.uniform(0.7, 2.0),
        youngs_modulus=draw.uniform(60e9, 300e9),
        poisson_ratio=0.3,
        penetration_hardness=scene.body.penetration_hardness,
        conductivity=scene.body.conductivity,
        density=7000.0,
        heat_capacity=500.0,
    )
    return replace(scene, title=f"two faces {number}", surface=face, counterface=counterface)


@dataclass(frozen=True)
class Row:
    """What was predicted of a scene, and what was found."""

    name: str
    realizations: tuple[int, int]
    error: tuple[float, float]
    cpu: tuple[float, float]
    wall: tuple[float, float]
    parts: dict[str, float]


def used() -> float:
    """CPU seconds of this process and of its ended workers."""
    own, others = resource.getrusage(resource.RUSAGE_SELF), resource.getrusage(resource.RUSAGE_CHILDREN)
    return own.ru_utime + own.ru_stime + others.ru_utime + others.ru_stime


def predicted_and_found(name: str, scene: rs.Scene, target: float, folder: Path, workers: int) -> tuple[Row, Any]:
    numerics = rs.plan(replace(scene, ensemble=replace(scene.ensemble, until={})), target)
    forecast = numerics.forecast
    assert forecast is not None
    systematic = np.nan_to_num(forecast.bandwidth) ** 2 + forecast.pixel**2 + forecast.size**2
    stop = max(target**2 - systematic, 0.1 * target**2) ** 0.5
    cpu, wall = used(), time.perf_counter()
    run = rs.run(scene, folder / name, numerics=numerics, until={"flash_temperature": stop}, workers=workers)
    cpu, wall = used() - cpu, time.perf_counter() - wall
    found = run.estimate("flash_temperature")
    k = int(np.argmax(found.mean))
    wall_both = forecast.wall_seconds(workers), wall
    parts = {source: float(part[k] / found.mean[k]) for source, part in found.budget.items()}
    error = forecast.total, float(found.total_error[k] / found.mean[k])
    return Row(name, (forecast.realizations, found.n), error, (forecast.cpu_seconds, cpu), wall_both, parts), run


def gain(run: Any) -> dict[str, float]:
    """Cost of all levels for every realization over that of the best split, at equal statistical error."""
    level = run.numerics.of_column(run.column(None))
    points = [run.numerics.grid(i).points for i in level]
    few = [i for i in run.sound(run.realizations) if i % run.numerics.levels[level[-1]].every == 0]
    result = {}
    for name in UNITS:
        samples = run.samples(None, few)
        whole = observe(name, samples, capped=True, end=run.scene.spectrum.breaks[-1]).extrapolated
        base = observe(name, samples[:1], capped=True).extrapolated
        with np.errstate(invalid="ignore"):
            v_all, v_base, v_rest = (x.var(axis=0, ddof=1) for x in (whole, base, whole - base))
            split = (np.sqrt(v_base * points[0]) + np.sqrt(v_rest * sum(points[1:]))) ** 2
        ratio = sum(points) * v_all / np.where(split > 0, split, np.nan)
        if np.any(np.isfinite(ratio)):
            result[name] = float(np.nanmedian(ratio))
    return result


def told(rows: list[Row]) -> None:
    print(f"{'scene':14s}{'n':>10s}{'total error':>18s}{'CPU s':>16s}{'wall s':>14s}   parts found, %")
    for row in rows:
        parts = " ".join(f"{name} {100 * part:.2g}" for name, part in row.parts.items())
        n, error, cpu, wall = row.realizations, row.error, row.cpu, row.wall
        print(
            f"{row.name:14s}{n[0]:>5d}/{n[1]:<4d}{100 * error[0]:>9.2f}/{100 * error[1]:<6.2f} %"
            f"{cpu[0]:>9.1f}/{cpu[1]:<7.1f}{wall[0]:>6.1f}/{wall[1]:<7.1f}   {parts}"
        )
    print("predicted/found; the total error is of the highest T_flash; CPU includes starting the workers")


def plans_told(scenes: dict[str, rs.Scene]) -> None:
    """Print top, CPU time and error of plans of the capped scenes, without the law for yielding contact and with it."""
    for name, each in scenes.items():
        scene = replace(each, ensemble=replace(each.ensemble, until={}))
        for target in () if scene.elastic else (0.01, 0.02, 0.03):
            with patch.object(prediction, "yielded_fall", lambda *_: None):
                plans = {"power": rs.plan(scene, target)}
            plans["law"] = rs.plan(scene, target)
            told = ""
            for way, numerics in plans.items():
                forecast, top = numerics.forecast, numerics.levels[-1].q_max / prediction.yield_wavenumber(scene)
                assert forecast is not None
                told += f"   {way}: to {top:.3g} q_y, {forecast.cpu_seconds:.3g} s, ± {100 * forecast.total:.2f} %"
            print(f"{name:14s} for {100 * target:g} %{told}", flush=True)


def chart(rows: list[Row], path: Path) -> None:
    figure = Figure((7.2, 3.4), layout="constrained")
    for axes, title, pairs in zip(
        figure.subplots(1, 2),
        ("total error (%)", "CPU time (s)"),
        ([[100 * x for x in row.error] for row in rows], [row.cpu for row in rows]),
        strict=True,
    ):
        low, high = 0.6 * min(map(min, pairs)), 1.7 * max(map(max, pairs))
        axes.fill_between([low, high], [low / 2, high / 2], [2 * low, 2 * high], color="0.92", label="within 2×")
        axes.plot([low, high], [low, high], color="0.5", lw=0.8)
        for row, pair in zip(rows, pairs, strict=True):
            steel = row.name.startswith("steel")
            axes.plot(*pair, "o" if steel else "s", ms=6, mfc="#d55e00" if steel else "#0072b2", mec="white")
        axes.set(xscale="log", yscale="log", xlim=(low, high), ylim=(low, high))
        axes.set(xlabel=f"{title}, predicted", ylabel=f"{title}, found")
        axes.legend(frameon=False, loc="upper left")
    figure.savefig(path, dpi=130)


def main() -> None:
    command = Command(__file__, __doc__, "two quick scenes at 4 %")
    command.add_argument("--workers", type=int, default=1, help="processes")
    command.add_argument("--only", nargs="*", help="names of scenes, as steel-1.2GPa and random-3")
    command.add_argument("--plans", action="store_true", help="plans alone, with the law and without")
    options = command.parse()
    steels = [] if options.toy else [f"steel-{x}GPa" for x in ("0.5", "1.2", "2.0")]
    scenes = {name: rs.load_scene(name) for name in steels or ["demo"]}
    scenes |= {f"random-{i}": random_scene(i) for i in ((2,) if options.toy else range(1, 11))}
    scenes |= {} if options.toy else {f"faces-{i}": two_faces(i) for i in range(1, 11)}
    scenes = {name: scene for name, scene in scenes.items() if name in (options.only or scenes)}
    if options.plans:
        plans_told(scenes)
        return
    rows, runs = [], {}
    for name, scene in scenes.items():
        target = 0.04 if options.toy else 0.01 if name in steels else 0.03 if name.startswith("faces") else 0.02
        row, runs[name] = predicted_and_found(name, scene, target, options.output, options.workers)
        rows.append(row)
        print(f"{name}: done after {row.wall[1]:.0f} s", flush=True)
    told(rows)
    for name in [name for name in scenes if name in steels or name == "demo"]:
        gains = ", ".join(f"{observable} {value:.2g}" for observable, value in gain(runs[name]).items())
        print(f"{name}, fine levels for few instead of for all: {gains}")
    chart(rows, options.output / "budget.png")


if __name__ == "__main__":
    main()
