"""The roofline of one contact solve: what each of its loops reaches, beside what the machine can do. One thread.

    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python benchmarks/roofline.py --points 2048 -o roofline.png

Bytes are those that a loop must move at least: each array that it reads or writes, once. Flops of a transform of n
complex numbers are 5 n log2 n. The roofs are a copy between large arrays, and multiply-adds in float32 from the first
cache, both compiled as the loops are. What fits the last cache may be above the first. Times are CPU times of the
thread, the least of the repeats call by call, so that other work on the machine hardly shows.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from math import log2
from typing import Any, NamedTuple

import matplotlib.pyplot as plt
import numpy as np
from contact import problem

import roughsim as rs
from roughsim._kernels import REORDER, active_set, extension, kernel, lines


class Loop(NamedTuple):
    """A loop of the solver: what it moves and computes for each point of the grid."""

    module: Any
    bytes: float
    flops: float
    points: Callable[..., int]  # of the arguments of one call


def flat(array: Any, *_: Any) -> int:
    return int(array.size)


def of_rows(stages: int, rows: Any, parent_rows: Any, bottom: int, free: Any, *_: Any) -> int:
    return int(rows[1] - rows[0]) * int(free.shape[1])


def of_row_span(start: int, stop: int, free: Any, *_: Any) -> int:
    return (stop - start) * int(free.shape[1])


def of_parents(*arguments: Any) -> int:
    return 2 * of_rows(*arguments)


def of_rows_of_lines(
    stages: int, task: int, execute: Any, field: Any, target: Any, rows: Any, columns: Any
) -> int:
    return 2 * int(rows[1] - rows[0]) * int(field.shape[1])


def of_columns(
    stages: int, task: int, execute: Any, field: Any, target: Any, rows: Any, columns: Any
) -> int:
    return 2 * int(columns[1] - columns[0]) * int(field.shape[0])


def loops(points: int) -> dict[str, Loop]:
    """Bytes and flops by hand: pressure, gap and heights are float64, the rest float32, the free set bytes."""
    return {
        # rows, columns, rows back: each a call of its own on a large grid
        "product 1": Loop(lines, 8, 2.5 * log2(points) + 2, of_rows_of_lines),
        "product 2": Loop(lines, 8, 5 * log2(points) + 4, of_columns),
        "product 4": Loop(lines, 8, 2.5 * log2(points) + 2, of_rows_of_lines),
        "product 7": Loop(lines, 24, 10 * log2(points) + 8, of_rows_of_lines),
        # push and pull, gather and scatter, at the finest level
        "extend 1": Loop(extension, 8, 2, of_rows),
        "extend 8": Loop(extension, 10, 6, of_rows),
        "transpose 1": Loop(extension, 6, 8, of_parents),
        "transpose 8": Loop(extension, 19, 6, of_rows),
        "scatter_load": Loop(extension, 19, 5, of_row_span),
        "classify": Loop(active_set, 21, 14, flat),
        "propose": Loop(active_set, 34, 9, flat),
        "shifted_step": Loop(active_set, 25, 10, flat),
        "curvature": Loop(active_set, 8, 6, flat),
        "advance": Loop(active_set, 40, 9, flat),
    }


@kernel(fastmath=REORDER)
def copy(source: Any, target: Any) -> None:
    for i in range(source.size):
        target[i] = source[i]


@kernel(fastmath=REORDER)
def multiply_adds(values: Any, times: int, factor: Any, more: Any) -> None:
    for _ in range(times):
        for i in range(values.size):
            values[i] = values[i] * factor + more


def least(work: Callable[[], Any], repeats: int = 20) -> float:
    """Least CPU time of a call, s, after one that warms up."""
    seconds = []
    for _ in range(repeats + 1):
        start = time.thread_time()
        work()
        seconds.append(time.thread_time() - start)
    return min(seconds[1:])


def roofs() -> tuple[float, float]:
    """Return GB/s of a copy, and GFLOP/s of multiply-adds."""
    source, target = np.ones(1 << 24), np.zeros(1 << 24)
    values = np.ones(4096, np.float32)
    bandwidth = 2 * source.nbytes / least(lambda: copy(source, target))
    factor, more, times = np.float32(0.999), np.float32(0.001), 10_000
    return bandwidth / 1e9, 2 * times * values.size / least(
        lambda: multiply_adds(values, times, factor, more)
    ) / 1e9


def recorded(points: int, load: float, repeats: int) -> tuple[dict[str, tuple[float, int]], float]:
    """Solve, and return the seconds and points of each loop on the finest grid, and the seconds of the whole solve."""
    task, calls, runs, whole = problem(points, load, np.inf), [], [], []

    table, staged = loops(points), {"product", "extend", "transpose"}

    def timed(name: str, work: Callable[..., Any]) -> Callable[..., Any]:
        def call(*arguments: Any) -> Any:
            start = time.thread_time()
            result = work(*arguments)
            spent, key = (
                time.thread_time() - start,
                f"{name} {arguments[0]}" if name in staged else name,
            )
            if key in table:  # what is left out counts as all else
                calls.append((key, spent, table[key].points(*arguments)))
            return result

        return call

    for module, name in {(loop.module, key.split()[0]) for key, loop in table.items()}:
        setattr(module, name, timed(name, getattr(module, name)))
    for _ in range(repeats + 1):
        calls.clear()
        start = time.thread_time()
        rs.solve_contact(task.heights, task.grid, rs.Solid(1.0), nominal_pressure=load)
        whole.append(time.thread_time() - start)
        runs.append(list(calls))
    seconds = np.min([[call[1] for call in run] for run in runs[1:]], axis=0)
    sums: dict[str, tuple[float, int]] = {}
    for (name, _, count), spent in zip(runs[0], seconds, strict=True):
        before = sums.get(name, (0.0, 0))
        sums[name] = before[0] + float(spent), before[1] + count
    return sums, min(whole[1:])


def chart(
    rows: list[tuple[str, float, float, float]], roof: tuple[float, float], title: str, path: str
) -> None:
    """Draw GFLOP/s over flops per byte; the area of a mark is its share of the time."""
    figure, axes = plt.subplots(figsize=(8, 5), constrained_layout=True)
    intensity = np.geomspace(0.1, 30, 100)
    axes.loglog(intensity, np.minimum(roof[0] * intensity, roof[1]), color="0.3", lw=1)
    axes.annotate(f"copy: {roof[0]:.1f} GB/s", (0.11, 0.13 * roof[0]), color="0.3", fontsize=8)
    axes.annotate(
        f"float32: {roof[1]:.0f} GFLOP/s", (30, 1.08 * roof[1]), color="0.3", fontsize=8, ha="right"
    )
    for k, (name, x, y, share) in enumerate(rows):
        axes.scatter(
            x, y, s=20 + 3000 * share, alpha=0.5, color="tab:blue" if x > 2 else "tab:orange", lw=0
        )
        axes.annotate(
            f"{name} {share:.0%}", (x, y), fontsize=7, ha="center", va="top" if k % 2 else "bottom"
        )
    axes.set(xlabel="flops per byte that must be moved", ylabel="GFLOP/s", title=title)
    figure.savefig(path, dpi=120)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--points", type=int, default=2048, help="along a side")
    parser.add_argument("--load", type=float, default=0.1, help="σ₀/(E* h′)")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("-o", "--output", default="roofline.png")
    options = parser.parse_args()
    roof, table, rows = roofs(), loops(options.points), []
    sums, whole = recorded(options.points, options.load, options.repeats)
    print(
        f"roofs: {roof[0]:.1f} GB/s, {roof[1]:.0f} GFLOP/s; one solve on {options.points}²: {whole:.3f} s"
    )
    print(f"{'loop':18s} {'share':>6s} {'GB/s':>6s} {'GFLOP/s':>8s} {'of its roof':>12s}")
    for name, (seconds, count) in sorted(sums.items(), key=lambda item: -item[1][0]):
        loop = table[name]
        rate, speed = loop.bytes * count / seconds / 1e9, loop.flops * count / seconds / 1e9
        intensity = loop.flops / loop.bytes
        reached = speed / min(roof[1], roof[0] * intensity)
        print(f"{name:18s} {seconds / whole:6.1%} {rate:6.1f} {speed:8.1f} {reached:12.0%}")
        rows.append((name, intensity, speed, seconds / whole))
    print(f"{'all else':18s} {1 - sum(row[3] for row in rows):6.1%}")
    chart(
        rows,
        roof,
        f"One contact solve on {options.points}², load {options.load:g}: {whole:.2f} s",
        options.output,
    )


if __name__ == "__main__":
    main()
