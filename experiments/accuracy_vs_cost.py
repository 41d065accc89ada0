"""Error over cost: every stage, the whole chain, and all contact solvers on the same surfaces.

    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python experiments/accuracy_vs_cost.py [CHART ...] [--resume] [-o F]

Charts: solvers (contact solvers on three problems; the peers too where installed, `pip install 'roughsim[peers]'`),
and those of `roughsim bench` for a scene: contact, stages (surface, heat, moments, theory), chain. All by default.
Costs are CPU seconds of one thread, and the same in FFT pairs timed in the same run. Everything lies in data.json.
"""

from __future__ import annotations

import importlib.util
import sys
import time
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from script import Command

import roughsim as rs
from roughsim.bench import bench, bench_chart, front, panels
from roughsim.store.rows import Rows

sys.path.append(str(Path(__file__).parents[1] / "benchmarks"))
import contact as solvers

mpl.rcParams.update({"font.size": 9, "axes.titlesize": 9, "axes.titlelocation": "left", "legend.frameon": False})
PROBLEMS = {"load 0.02": (0.02, np.inf), "load 0.1": (0.1, np.inf), "load 0.1, hardness 0.6": (0.1, 0.6)}
SOLVERS = {
    "roughsim": ("#D55E00", "o", 2.0),
    "tamaas": ("#0072B2", "s", 1.2),
    "ContactMechanics": ("#009E73", "^", 1.2),
    "NuMPI": ("#CC79A7", "D", 1.2),
}
CHARTS = {
    "solvers": (),
    "contact": ("contact",),
    "stages": ("surface", "heat", "moments", "theory"),
    "chain": ("chain",),
}
BESIDE = {"textcoords": "offset points", "ha": "right", "fontsize": 8}
LONGEST = 20.0  # CPU seconds of one solve; a solver that takes longer is not asked for more


def toy_numerics():
    """Of the demo, with few points."""
    capped = rs.Level("capped", (64, 64), 4e4), rs.Level("capped", (128, 128), 4e4, 2)
    return rs.Numerics(capped, (4e-3, 4e-3))


def solve(name, task, exact, tolerance):
    """Error and least CPU seconds of up to three solves, or the words of the failure."""
    run = solvers.ours if name == "roughsim" else solvers.PEERS[name][1]
    spent = []
    while len(spent) < 3 and sum(spent) < 2.0:
        start = time.process_time()
        try:
            pressure = run(task, tolerance)
        except (RuntimeError, ValueError) as reason:
            return {"tolerance": tolerance, "error": np.nan, "seconds": time.process_time() - start, "why": str(reason)}
        spent.append(time.process_time() - start)
    error = float(np.linalg.norm(pressure - exact) / np.linalg.norm(exact))
    return {"tolerance": tolerance, "error": error, "seconds": min(spent), "why": ""}


def solver_rows(rows, points, tolerances):
    there = [n for n in SOLVERS if n == "roughsim" or importlib.util.find_spec(solvers.PEERS[n][0]) is not None]
    print("not installed: " + (", ".join(set(SOLVERS) - set(there)) or "none"))
    for title, (load, cap) in PROBLEMS.items():
        tasks = [solvers.problem(size, load, cap) for size in (32, points)]
        warm, exact = (solvers.ours(task, 1e-10) for task in tasks)
        for name in there:
            solve(name, tasks[0], warm, 1e-2)  # compiled, planned and imported by now
            climb(rows, name, title, tasks[1], exact, tolerances)


def climb(rows, name, title, task, exact, tolerances):
    """From the loosest tolerance to the tightest, until one fails or takes too long."""
    for tolerance in tolerances:
        key = f"{title} {name} {tolerance:.1e}"

        def compute(tolerance=tolerance):
            return {"problem": title, "solver": name} | solve(name, task, exact, tolerance)

        row = rows.once("solvers", key, compute)
        print(f"{key:45s} error {row['error']:8.1e}  {row['seconds']:7.2f} s  {row['why']}", flush=True)
        if row["why"] or row["seconds"] > LONGEST:
            break


def solver_chart(rows, folder, points):
    """Error over CPU time of every solver on each problem; a cross where one failed or took too long."""
    figure = Figure((9.6, 3.7), layout="constrained")
    axes = figure.subplots(1, 3, sharey=True)
    found = rows["solvers"].values()
    for axis, title in zip(axes, PROBLEMS, strict=True):
        for name, (colour, marker, width) in SOLVERS.items():
            line = [r for r in found if r["problem"] == title and r["solver"] == name]
            good = [r for r in line if not r["why"]]
            if good:
                xy = [r["seconds"] for r in good], [r["error"] for r in good]
                axis.loglog(*xy, marker=marker, ms=3.5, lw=width, color=colour, label=name)
            for text in {r["why"] for r in line if r["why"]}:
                axis.text(0.97, 0.03, f"{name}: {text}", transform=axis.transAxes, ha="right", color=colour, fontsize=8)
            if good and good[-1]["seconds"] > LONGEST:
                axis.annotate("no tighter ones:\nover 20 s", (xy[0][-1], xy[1][-1]), (0, -26), **BESIDE, color=colour)
        axis.set(title=title, xlabel="CPU time of one solve, s")
        axis.grid(color="0.92", lw=0.6)
    axes[0].set_ylabel("relative error of the pressure")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    figure.suptitle(f"Contact solvers, {points}² points, one thread: each at tolerances from 1e-2 to 1e-8", fontsize=9)
    figure.savefig(folder / "contact_time_error.png", dpi=130)


def speedups(rows, goals=(1e-3, 1e-6)):
    """Print how many times longer than ours each peer takes to the same error."""
    found = rows["solvers"].values()
    for title in PROBLEMS:
        for goal in goals:
            cheapest = {}
            for row in found:
                if row["problem"] == title and row["error"] <= goal:
                    cheapest[row["solver"]] = min(cheapest.get(row["solver"], np.inf), row["seconds"])
            ours = cheapest.get("roughsim", np.nan)
            words = ", ".join(f"{name} {time / ours:.0f}x" for name, time in cheapest.items() if name != "roughsim")
            print(f"{title}: to an error of {goal:g} ours takes {ours:.3f} s; {words}")


def bench_charts(rows, name, scene, numerics, folder, realizations):
    points = bench(scene, numerics=numerics, stages=CHARTS[name], realizations=realizations, rows=rows)
    bench_chart(points, folder / f"{name}.png")
    for title, group in panels(points).items():
        print(title)
        best = front(group)
        for point in sorted({*best, *(p for p in group if p.chosen)}, key=lambda p: p.seconds):
            marks = " | front" * (point in best) + " | plan" * point.chosen
            print(f"   {point.error:8.1e} {point.pairs:9.3g} pairs  {point.method}, {point.setting}{marks}")


def main() -> None:
    command = Command(__file__, __doc__)
    command.add_argument("charts", nargs="*", metavar="CHART", help=f"{', '.join(CHARTS)}; all if left out")
    command.add_argument("--resume", action="store_true", help="keep the rows that are already in data.json")
    command.add_argument("--scene", default="steel-1.2GPa", help="a scene, by name or path")
    command.add_argument("--realizations", type=int, default=None, help="members of the chain and of the moments")
    options = command.parse()
    if unknown := set(options.charts) - set(CHARTS):
        command.error(f"{', '.join(unknown)}: choose from {', '.join(CHARTS)}")
    rows = Rows(options.output / "data.json", resume=options.resume)
    points, tolerances = (
        (64, 10.0 ** -np.arange(2.0, 9.0, 3)) if options.toy else (512, 10.0 ** (-np.arange(4, 17) / 2))
    )
    scene = rs.load_scene("demo" if options.toy else options.scene)
    numerics = toy_numerics() if options.toy else rs.plan(scene)
    for chart in options.charts or CHARTS:
        if chart == "solvers":
            solver_rows(rows, points, tolerances)
            solver_chart(rows, options.output, points)
            speedups(rows)
        else:
            bench_charts(
                rows, chart, scene, numerics, options.output, options.realizations or (4 if options.toy else 16)
            )


if __name__ == "__main__":
    main()
