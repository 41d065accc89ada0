"""CPU time of the whole command to the total error that was asked for, here and in other copies: table and chart.

    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python benchmarks/chain.py [before=DIRECTORY] [plain] now=. [--times 3]
        [--scenes NAME ...] [--drawn SEED] [--targets TARGET ...] [--limit SECONDS] [-o FOLDER] [--evidence]

Each copy is a name and a directory; another commit comes from `git worktree add --detach DIRECTORY COMMIT`. "plain" is
the script of benchmarks/plain.py in this one, and the default is "plain now=.". A point is plan, run, reading and
comparison of a scene by one process, or the script, for a total 95 % error of T_flash at its worst speed. The copies
take turns, so that others on the machine slow them alike; the median of --times counts. At the end each copy before the
last is compared with the last. Scenes are the three steels, the demo, the four others with a deep reference
(experiments/reference/make_deep.py), and the ten of drawn.py, or of another seed of it, which needs another FOLDER.
With --evidence the drawn ones are left out, and the last copy and the script make docs/evidence/chain.json. Each
process is warm: other contacts go ahead, uncounted. FOLDER holds chain.json, whose points are not measured again, and
chain.png. A point that takes more than the limit is ended, and its time is a lower bound.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
from dataclasses import replace
from math import hypot
from pathlib import Path
from statistics import median
from typing import Any

import matplotlib as mpl

mpl.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from drawn import SEED, drawn_scenes
from plain import plain

import roughsim as rs

sys.path.append(str(Path(__file__).parents[1] / "experiments"))
from reference import make_deep
from script import write_evidence

HERE = Path(__file__).resolve().parent.parent
BUNDLED = "demo", "steel-0.5GPa", "steel-1.2GPa", "steel-2.0GPa"
TARGETS = 0.03, 0.02, 0.01, 0.005
NAME = "flash_temperature"
SCRIPT = "plain"  # the copy that is a script
DEFAULT = SCRIPT, "now=."
ENOUGH = 100_000  # realizations: none of these runs ends for their number
CostPoint = dict[str, Any]
Points = dict[str, dict[str, dict[str, CostPoint]]]  # by copy, scene and target


def free(scene: str | dict[str, Any], **changes: Any) -> rs.Scene:
    """Return a scene without targets of its own, with as many realizations as it takes."""
    return rs.load_scene(
        scene, {"ensemble.until": {}, "ensemble.max_realizations": ENOUGH, **changes}
    )


def scenes(seed: int) -> dict[str, rs.Scene]:
    """Return the bundled scenes, those with a deep reference and those drawn with a seed, by name."""
    drawn = {name: free(sections) for name, sections in drawn_scenes(seed).items()}
    return {name: free(name) for name in BUNDLED} | deep_scenes() | drawn


def deep_scenes() -> dict[str, rs.Scene]:
    """Return the scenes with a deep reference that are not bundled."""
    others = {name: case.scene for name, case in make_deep.cases().items() if name not in BUNDLED}
    endless = {"until": {}, "max_realizations": ENOUGH}
    return {
        name: replace(scene, ensemble=replace(scene.ensemble, **endless))
        for name, scene in others.items()
    }


def cpu_seconds() -> float:
    """Return the CPU time of this process and of its ended children."""
    times = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(time.ru_utime + time.ru_stime for time in times)


def asked_of_run(numerics: rs.Numerics, target: float) -> float:
    """Return the `until` of a run for a total error: earlier versions take the statistical one that the plan leaves."""
    forecast = getattr(numerics, "forecast", None)
    if forecast is None:
        return target
    systematic = hypot(*np.nan_to_num([forecast.bandwidth, forecast.pixel, forecast.size]))
    return float(max(target**2 - systematic**2, 0.1 * target**2) ** 0.5)


def measure(scene: rs.Scene, target: float) -> CostPoint:
    """Return CPU seconds of plan, run and comparison of a scene, and mean and total error of T_flash by speed."""
    marks = [cpu_seconds()]
    numerics = rs.plan(scene, target)
    marks.append(cpu_seconds())
    with tempfile.TemporaryDirectory() as folder:
        until = {NAME: asked_of_run(numerics, target)}
        run = rs.run(scene, Path(folder) / "run", numerics=numerics, until=until, workers=1)
        marks.append(cpu_seconds())
        run = rs.open_run(run.folder)
        str(rs.compare(run))
        marks.append(cpu_seconds())
        found = run.estimate(NAME)
    relative = {
        source: float(np.max(np.abs(part / found.mean))) for source, part in found.budget.items()
    }
    return {
        **{stage: marks[i + 1] - marks[i] for i, stage in enumerate(("plan", "run", "compare"))},
        "seconds": marks[-1] - marks[0],
        "mean": found.mean.tolist(),
        "error": (found.total_error / np.abs(found.mean)).tolist(),
        "parts": relative,
        "realizations": run.realizations,
        "lowest": lowest_members(run),
        "met": bool(run.target_met),
    }


def measure_script(scene: rs.Scene, target: float) -> CostPoint:
    """Return CPU seconds of the plain script, and mean and total error of T_flash by speed."""
    begun = cpu_seconds()
    found = plain(scene, target)
    seconds = cpu_seconds() - begun
    return {
        "plan": 0.0,
        "run": seconds,
        "compare": 0.0,
        "seconds": seconds,
        "mean": found.mean.tolist(),
        "error": found.error.tolist(),
        "parts": {
            "statistical": float(found.statistical.max()),
            "bandwidth": float(found.rest.max()),
        },
        "realizations": sum(found.members),
        "lowest": found.members[0],
        "met": bool(found.error.max() <= target),
    }


def lowest_members(run: rs.Run) -> int:
    """Return the members of the lowest level of the capped or elastic column; earlier versions have one count."""
    numerics = run.numerics
    if not hasattr(run, "counts"):
        return run.realizations
    return int(run.counts[numerics.of_column(numerics.columns[-1])[0]])


def warm_up(chosen: str) -> None:
    """Load modules and kernels by a yielding and an elastic scene that are not measured."""
    measure(free("steel-2.0GPa" if chosen == "demo" else "demo"), 0.05)
    measure(free("demo", **{"body.penetration_hardness": None}), 0.05)


def child(copy: str, name: str, seed: int, target: float, limit: float) -> None:
    """Print a point as JSON, or what went wrong."""
    warm_up(name)
    work = measure_script if copy == SCRIPT else measure
    _, hard = resource.getrlimit(resource.RLIMIT_CPU)
    resource.setrlimit(resource.RLIMIT_CPU, (int(cpu_seconds() + limit) + 1, hard))
    try:
        point = work(scenes(seed)[name], target)
    except (rs.RoughsimError, ValueError, MemoryError) as error:
        point = {"failure": f"{type(error).__name__}: {error}"}
    print(json.dumps(point))


def in_process(
    copy: str, tree: Path, name: str, seed: int, target: float, limit: float
) -> CostPoint:
    """Return a point of the package in a directory, or of the script, by a process of its own."""
    command = [sys.executable, __file__, "--child", copy, "--scenes", name, "--drawn", str(seed)]
    command += ["--targets", str(target), "--limit", str(limit)]
    environment = os.environ | {"PYTHONPATH": str(tree)}
    done = subprocess.run(command, check=False, env=environment, capture_output=True, text=True)
    # a run takes the signal as an interrupt
    if done.returncode == -signal.SIGXCPU or done.stderr.rstrip().endswith("KeyboardInterrupt"):
        return {"seconds": limit, "failure": "takes longer"}
    if done.returncode:
        return {
            "failure": done.stderr.strip().splitlines()[-1]
            if done.stderr.strip()
            else f"exit {done.returncode}"
        }
    result: CostPoint = json.loads(done.stdout.splitlines()[-1])
    return result


def in_turns(
    points: Points, trees: dict[str, Path], name: str, target: float, given: argparse.Namespace
) -> bool:
    """Measure the missing points of a scene and target, the copies in turns; return whether there were any."""
    key = f"{target:g}"
    missing = [c for c in trees if key not in points.setdefault(c, {}).setdefault(name, {})]
    found: dict[str, list[CostPoint]] = {copy: [] for copy in missing}
    for _ in range(given.times):
        for copy in missing:
            point = in_process(copy, trees[copy], name, given.drawn, target, given.limit)
            found[copy].append(point)
    for copy, of_copy in found.items():
        of_copy.sort(key=lambda point: point.get("seconds", 0.0))
        points[copy][name][key] = of_copy[len(of_copy) // 2]
    return bool(missing)


def row(copy: str, name: str, target: float, point: CostPoint) -> str:
    """Return a line of the table."""
    if "failure" in point:
        seconds = f"> {point['seconds']:g}" if "seconds" in point else "–"
        return (
            f"| {name} | {100 * target:g} | {copy} | {seconds} | | | | | {point['failure'][:100]} |"
        )
    seconds = " | ".join(f"{point[stage]:.2f}" for stage in ("seconds", "plan", "run", "compare"))
    worst = max(point["parts"], key=point["parts"].__getitem__)
    error = 100 * np.nanmax(point["error"])
    return f"| {name} | {100 * target:g} | {copy} | {seconds} | {error:.2f} | {worst}, n = {point['realizations']} |"


def ratios(points: Points, first: str, last: str) -> None:
    """Print the CPU time of the last copy over that of another, by scene and target, and how far their means lie apart.

    That is over both total errors, added as squares, at the worst speed.
    """
    targets = sorted(
        {target for table in points.values() for of in table.values() for target in of},
        key=float,
        reverse=True,
    )
    print(f"\nCPU time of {last} over {first} (< where {first} was ended); stated total errors, %;")
    print("distance of the means over both errors:")
    print("| scene | " + " | ".join(f"{100 * float(target):g} %" for target in targets) + " |")
    print("|---" * (len(targets) + 1) + "|")
    found: dict[str, list[float]] = {target: [] for target in targets}
    for name in points[last]:
        cells = []
        for target in targets:
            own, other = (points[copy].get(name, {}).get(target, {}) for copy in (last, first))
            if "error" not in own or "seconds" not in other:
                cells.append("–")
                continue
            ratio = own["seconds"] / other["seconds"]
            found[target].append(ratio)
            cell = f"{'< ' * ('failure' in other)}{ratio:.2f}"
            if "error" in other:
                errors = "/".join(f"{100 * np.nanmax(p['error']):.2f}" for p in (own, other))
                cell += f"; {errors}; {distance(own, other):.1f}"
            cells.append(cell)
        print(f"| {name} | " + " | ".join(cells) + " |")
    for words, kind in (("median", median), ("largest", max)):
        cells = [f"{kind(found[target]):.2f}" if found[target] else "–" for target in targets]
        print(f"| {words} | " + " | ".join(cells) + " |")


def distance(own: CostPoint, other: CostPoint) -> float:
    """Return how far the means of two points lie apart over both total errors, at the worst speed."""
    means, errors = (np.array([point[key] for point in (own, other)]) for key in ("mean", "error"))
    apart = np.abs(means[0] - means[1]) / np.hypot(*(means * errors))
    return float(np.nanmax(apart))


def evidence(points: Points, last: str) -> None:
    """Write docs/evidence/chain.json: all points, the CPU seconds of runs and members as a table, and over the script.

    `last` is the copy whose runs are shown.
    """
    table = points[last]
    targets = [f"{target:g}" for target in TARGETS]
    cells = [["scene", *(f"{100 * float(target):g} %" for target in targets)]]
    for name, of_scene in table.items():
        row = [name]
        for target in targets:
            point = of_scene.get(target, {"failure": "not measured"})
            cell = "–"
            if "failure" not in point:
                seconds = np.format_float_positional(
                    point["seconds"], 2, fractional=False, trim="-"
                )
                cell = f"{seconds} ({point['lowest']})"
            if not point.get("met", True):
                cell += f" ends at {100 * np.nanmax(point['error']):.2g} %"
            row.append(cell)
        cells.append(row)
    rows = [
        {"scene": name, "way": way, "target": float(target), **point}
        for way, copy in (("roughsim", last), ("plain script", SCRIPT))
        for name, of_scene in points.get(copy, {}).items()
        for target, point in of_scene.items()
    ]
    numbers = {}
    for target in ("0.03", "0.01"):
        pairs = [
            [points[copy].get(name, {}).get(target, {}) for copy in (last, SCRIPT)]
            for name in table
            if SCRIPT in points
        ]
        over = [own["seconds"] / other["seconds"] for own, other in pairs if "error" in own]
        if over:
            numbers[f"over_script_{target}"] = median(over)
    command = "python benchmarks/chain.py --evidence"
    write_evidence("chain", command, rows=rows, tables={"seconds": cells}, numbers=numbers)


def chart(points: Points, path: Path) -> None:
    """Draw the error asked for over CPU seconds, a panel for each scene and a line for each copy."""
    names = list(dict.fromkeys(name for table in points.values() for name in table))
    columns = min(5, len(names))
    figure, panels = plt.subplots(
        -(-len(names) // columns),
        columns,
        sharex=True,
        sharey=True,
        squeeze=False,
        figsize=(2.1 * columns, 1.9 * -(-len(names) // columns)),
        layout="constrained",
    )
    for axes in panels.flat[len(names) :]:
        axes.set_visible(False)
    for axes, name in zip(panels.flat, names, strict=False):
        for number, copy in enumerate(points):
            line = sorted(
                (float(target), point) for target, point in points[copy].get(name, {}).items()
            )
            done = [(point["seconds"], 100 * target) for target, point in line if "error" in point]
            ended = [
                (point["seconds"], 100 * target)
                for target, point in line
                if "error" not in point and "seconds" in point
            ]
            style = {"color": f"C{number}", "label": copy}
            axes.loglog(*np.reshape(done, (-1, 2)).T, "o-", ms=3, **style)
            axes.loglog(*np.reshape(ended, (-1, 2)).T, ">", ms=4, mfc="none", color=f"C{number}")
        axes.set_title(name, fontsize=9)
        axes.grid(visible=True, color="0.9", linewidth=0.6)
    panels[0, 0].legend(frameon=False, fontsize=8)
    figure.supxlabel("CPU time of plan, run and comparison, s", fontsize=9)
    figure.supylabel("total error asked for, %", fontsize=9)
    figure.savefig(path, dpi=150)


def main() -> None:
    options = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    options.add_argument("copies", nargs="*", metavar="NAME=DIRECTORY")
    options.add_argument("--scenes", nargs="+", help="names; all if left out")
    options.add_argument("--times", type=int, default=1, help="times of each point")
    options.add_argument("--drawn", type=int, default=SEED, help="seed of the drawn scenes")
    options.add_argument("--targets", type=float, nargs="+", default=TARGETS)
    options.add_argument("--limit", type=float, default=100.0, help="CPU seconds of a point")
    options.add_argument("-o", "--output", type=Path, default=Path("runs/chain"), help="folder")
    options.add_argument("--evidence", action="store_true", help="write docs/evidence/chain.json")
    options.add_argument("--child", help=argparse.SUPPRESS)
    given = options.parse_args()
    if given.child is not None:
        child(given.child, given.scenes[0], given.drawn, given.targets[0], given.limit)
        return
    trees = {
        name: Path(path or HERE).resolve()
        for name, _, path in (copy.partition("=") for copy in given.copies or DEFAULT)
    }
    given.output.mkdir(parents=True, exist_ok=True)
    kept = given.output / "chain.json"
    points: Points = json.loads(kept.read_text()) if kept.exists() else {}
    for copy, tree in trees.items():
        in_process(copy, tree, "demo", given.drawn, 0.05, given.limit)  # compiles
    print(
        "| scene | target, % | copy | CPU s | plan | run | compare | total error, % | largest part |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    for name in given.scenes or (
        [*BUNDLED, *deep_scenes()] if given.evidence else scenes(given.drawn)
    ):
        for target in given.targets:
            if in_turns(points, trees, name, target, given):
                kept.write_text(json.dumps(points, indent=1))
            for copy in trees:
                print(row(copy, name, target, points[copy][name][f"{target:g}"]), flush=True)
    *others, last = trees
    for other in others:
        ratios(points, other, last)
    chart(points, given.output / "chain.png")
    if given.evidence:
        evidence(points, last)


if __name__ == "__main__":
    main()
