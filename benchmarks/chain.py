"""Error over cost of the whole chain (plan, run, comparison), here and in another copy of the package: table and chart.

    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python benchmarks/chain.py --before DIRECTORY [--more TARGET ...] [-o FILE]

The directory is a checkout of another commit (`git worktree add --detach DIRECTORY COMMIT`). Each point is a run of a
scene for one target of the total error of T_flash, at one thread, in a process of its own. Both copies take turns, so
that others on the machine slow both alike. The error is the total one that the run itself states, at 35 m/s: its parts
are statistics, bandwidth, pixel, cell and solver. Each process is warm: another scene goes ahead, untimed.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from math import hypot
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
from matplotlib.ticker import FixedLocator

import roughsim as rs

SPEED = 35.0  # m/s
WARM_UP = "steel-1.2GPa", "steel-2.0GPa"  # the first of them that is not measured
HERE = Path(__file__).resolve().parent.parent


def measure(name: str, target: float, most: int | None) -> dict[str, Any]:
    """Return CPU seconds of plan, run and comparison of a scene, and mean, K, and relative total error of T_flash."""
    scene = rs.load_scene(name)
    scene = replace(scene, ensemble=replace(scene.ensemble, until={}))
    marks = [time.process_time()]
    numerics = rs.plan(scene, target)
    marks.append(time.process_time())
    forecast = numerics.forecast
    assert forecast is not None
    # what the systematic errors leave of the target
    stop = max(target**2 - hypot(forecast.bandwidth, forecast.pixel, forecast.size) ** 2, 0.1 * target**2) ** 0.5
    with tempfile.TemporaryDirectory() as folder:
        until = {"flash_temperature": stop}
        run = rs.run(scene, Path(folder) / "run", numerics=numerics, until=until, max_realizations=most)
        marks.append(time.process_time())
        run = rs.open_run(run.folder)
        if most is None:
            str(rs.compare(run))
        marks.append(time.process_time())
        found = run.estimate("flash_temperature")
    k = scene.speeds.index(SPEED)
    seconds = {stage: marks[i + 1] - marks[i] for i, stage in enumerate(("plan", "run", "compare"))}
    mean = float(found.mean[k])
    return seconds | {"mean": mean, "error": float(found.total_error[k]) / mean, "realizations": run.realizations}


def in_process(tree: Path, name: str, target: float, most: int | None = None) -> dict[str, Any]:
    """Return `measure` of the package in a directory, by a process of its own."""
    command = [sys.executable, __file__, "--scene", name, "--child", str(target)]
    command += [] if most is None else ["--most", str(most)]
    said = subprocess.run(
        command, check=True, env=os.environ | {"PYTHONPATH": str(tree)}, capture_output=True, text=True
    )
    result: dict[str, Any] = json.loads(said.stdout.splitlines()[-1])
    return result


def chart(points: dict[str, list[dict[str, Any]]], title: str, path: Path) -> None:
    """Draw total error over CPU seconds, a line for each copy."""
    figure, axes = plt.subplots(figsize=(5.2, 3.6), layout="constrained")
    for (label, line), marker, colour in zip(
        points.items(), ("s--", "o-")[-len(points) :], ("#888888", "#0072b2")[-len(points) :], strict=True
    ):
        seconds = [point["plan"] + point["run"] + point["compare"] for point in line]
        errors = [100 * point["error"] for point in line]
        axes.loglog(seconds, errors, marker, color=colour, label=label)
        for x, y, point in zip(seconds, errors, line, strict=True):
            text = f"for {100 * point['target']:g} %"
            axes.annotate(text, (x, y), (5, 5), textcoords="offset points", fontsize=8, color=colour)
    axes.set(xlabel="CPU time of plan, run and comparison, s", ylabel=f"total error of T_flash({SPEED:g} m/s), %")
    axes.set_title(title, fontsize=10)
    for axis, ticks in (
        (axes.xaxis, (1, 2, 3, 5, 10, 20, 50, 100, 200)),
        (axes.yaxis, (0.2, 0.3, 0.5, 0.7, 1, 1.5, 2, 3, 5)),
    ):
        axis.set_major_locator(FixedLocator(ticks))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_locator(FixedLocator([]))
    costs = [point["plan"] + point["run"] + point["compare"] for line in points.values() for point in line]
    axes.set_xlim(0.7 * min(costs), 1.7 * max(costs))
    axes.set_ylim(min(*axes.get_ylim(), 0.7), max(*axes.get_ylim(), 2))
    axes.grid(visible=True, color="#dddddd", linewidth=0.6)
    axes.legend(frameon=False)
    figure.savefig(path, dpi=150)


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--scene", default="steel-1.2GPa")
    options.add_argument("--before", type=Path, help="a checkout of another commit")
    options.add_argument("--targets", type=float, nargs="+", default=[0.04, 0.02, 0.014, 0.01])
    options.add_argument("--more", type=float, nargs="*", default=[], help="targets of this copy alone, after those")
    options.add_argument("-o", "--output", type=Path, default=Path("chain.png"))
    options.add_argument("--child", type=float, help=argparse.SUPPRESS)
    options.add_argument("--most", type=int, help=argparse.SUPPRESS)
    given = options.parse_args()
    if given.child is not None:
        if given.most is None:  # loads modules and kernels; another surface, for results of this one might be kept
            measure(WARM_UP[given.scene == WARM_UP[0]], 0.02, None)
        print(json.dumps(measure(given.scene, given.child, given.most)))
        return
    trees = {"now": HERE} if given.before is None else {"before": given.before.resolve(), "now": HERE}
    points: dict[str, list[dict[str, Any]]] = {name: [] for name in trees}
    for tree in trees.values():
        in_process(tree, given.scene, 0.05, most=1)  # compiles
    print("| | target, % | plan, s | run, s | compare, s | all, s | T_flash, K | total error, % | realizations |")
    print("|---|---|---|---|---|---|---|---|---|")
    for target in (*given.targets, *given.more):
        for name, tree in trees.items() if target in given.targets else [("now", HERE)]:
            point = in_process(tree, given.scene, target) | {"target": target}
            points[name].append(point)
            seconds = [point[stage] for stage in ("plan", "run", "compare")]
            times = " | ".join(f"{value:.1f}" for value in (*seconds, sum(seconds)))
            print(
                f"| {name} | {100 * target:g} | {times} | {point['mean']:.1f} | {100 * point['error']:.2f} | "
                f"{point['realizations']} |",
                flush=True,
            )
    chart(points, rs.load_scene(given.scene).title, given.output)


if __name__ == "__main__":
    main()
