"""Time contact solves side by side: two in two threads against one, against two processes, and one on two threads.

    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python benchmarks/threads.py --sizes 256 512 1024
    ... python benchmarks/threads.py --sizes 1024 2048 --shares

Wall time on an otherwise idle machine of two cores or more; a pair costs the time of one where nothing holds the GIL.
Threads and processes are warm: each keeps its plans, and, as a process of a run does, the memory of its arrays.
Two processes share no GIL: what a pair of them costs is what the machine takes (memory, caches, other work).

With `--shares` one thread solves, and its CPU time says how much of the work threads could share: a table that needs no
idle machine. By Amdahl's law two threads then take at least 1 − share/2 of the time of one.
"""

from __future__ import annotations

import argparse
import multiprocessing
import statistics
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from contact import Problem, problem

import roughsim as rs
from roughsim.fourier import blocks


def solve(task: Problem, times: int, tolerance: float = 1e-6) -> None:
    for _ in range(times):
        rs.solve_contact(
            task.heights, task.grid, rs.Solid(1.0), nominal_pressure=task.load, tolerance=tolerance
        )


def _serve(points: int, times: int, start: Any, done: Any) -> None:
    task = problem(points, 0.1, np.inf)
    solve(task, 1)
    while start.acquire():
        solve(task, times)
        done.release()


def wall(work: Callable[[], None]) -> float:
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin


def in_threads(pool: ThreadPoolExecutor, task: Problem, times: int) -> None:
    for future in [pool.submit(solve, task, times) for _ in range(2)]:
        future.result()


def in_processes(start: Any, done: Any) -> None:
    for signal in (start, done):
        for _ in range(2):
            signal.release() if signal is start else signal.acquire()


def on_two_threads(task: Problem, times: int) -> None:
    rs.set_threads(2)
    solve(task, times)
    rs.set_threads(1)


def shares(points: int, repeats: int) -> None:
    """Print the share of the CPU time of one thread in work that is divided into blocks for all threads."""
    shared = 0.0
    original = blocks.run

    def timed(task: Callable[..., Any], parts: list[Any]) -> list[Any]:
        nonlocal shared
        begin = time.thread_time()
        try:
            return original(task, parts)
        finally:
            shared += time.thread_time() - begin if len(parts) > 1 else 0.0

    task = problem(points, 0.1, np.inf)
    for tolerance in (1e-3, 1e-6):
        solve(task, 1, tolerance)
        modules = [module for name, module in sys.modules.items() if name.startswith("roughsim")]
        users: list[Any] = [module for module in modules if vars(module).get("run") is original]
        for module in users:
            module.run = timed
        shared, begin = 0.0, time.thread_time()
        solve(task, repeats, tolerance)
        whole = time.thread_time() - begin
        for module in users:
            module.run = original
        share = shared / whole
        print(
            f"| {points}² | {tolerance:.0e} | {whole / repeats:.3f} | {share:.2f} | {1 - share / 2:.2f} |",
            flush=True,
        )


def measure(points: int, repeats: int) -> None:
    task, times = problem(points, 0.1, np.inf), max(round(16 * (256 / points) ** 2), 2)
    context = multiprocessing.get_context("spawn")
    pool = ThreadPoolExecutor(2)
    start, done = context.Semaphore(0), context.Semaphore(0)
    pair = [
        context.Process(target=_serve, args=(points, times, start, done), daemon=True)
        for _ in range(2)
    ]
    for process in pair:
        process.start()
    in_processes(start, done)  # waits until both are warm
    runs: dict[str, Callable[[], None]] = {
        "one": lambda: solve(task, times),
        "two in threads": lambda: in_threads(pool, task, times),
        "two in processes": lambda: in_processes(start, done),
        "one on two threads": lambda: on_two_threads(task, times),
    }
    seconds: dict[str, list[float]] = {name: [] for name in runs}
    for work in runs.values():
        work()
    for _ in range(repeats):  # alternating
        for name, work in runs.items():
            seconds[name].append(wall(work))
    for process in pair:
        process.terminate()
    one = statistics.median(seconds["one"])
    for name, values in seconds.items():
        ratio = statistics.median(
            value / base for value, base in zip(values, seconds["one"], strict=True)
        )
        print(
            f"{points}²  {name:20s} {statistics.median(values) / times:8.4f} s  × {ratio:.2f}",
            flush=True,
        )
    print(
        f"{points}²  least of all: pair/one {min(seconds['two in threads']) / min(seconds['one']):.2f}, {one:.3g} s"
    )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sizes", type=int, nargs="+", default=[256, 512, 1024])
    parser.add_argument("--repeats", type=int, default=9)
    parser.add_argument(
        "--shares", action="store_true", help="what threads could share, from one thread"
    )
    options = parser.parse_args()
    if options.shares:
        print(
            "| points | tolerance | CPU s | shared | two threads at best |\n|---|---|---|---|---|"
        )
    for points in options.sizes:
        (shares if options.shares else measure)(points, options.repeats)


if __name__ == "__main__":
    main()
