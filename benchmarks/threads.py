"""Time contact solves side by side: two in two threads against one, against two processes, and one on two threads.

    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python benchmarks/threads.py --sizes 256 512 1024

Wall time on an otherwise idle machine of two cores or more; a pair costs the time of one where nothing holds the GIL.
Threads and processes are warm: each keeps its plans.
Two processes share no GIL: what a pair of them costs is what the machine takes (memory, caches, other work).
"""

from __future__ import annotations

import argparse
import multiprocessing
import statistics
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from contact import Problem, problem

import roughsim as rs


def solve(task: Problem, times: int) -> None:
    for _ in range(times):
        rs.solve_contact(task.heights, task.grid, rs.Solid(1.0), nominal_pressure=task.load)


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


def measure(points: int, repeats: int) -> None:
    task, times = problem(points, 0.1, np.inf), max(round(16 * (256 / points) ** 2), 2)
    context = multiprocessing.get_context("spawn")
    pool = ThreadPoolExecutor(2)
    start, done = context.Semaphore(0), context.Semaphore(0)
    pair = [context.Process(target=_serve, args=(points, times, start, done), daemon=True) for _ in range(2)]
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
        ratio = statistics.median(value / base for value, base in zip(values, seconds["one"], strict=True))
        print(f"{points}²  {name:20s} {statistics.median(values) / times:8.4f} s  × {ratio:.2f}", flush=True)
    print(f"{points}²  least of all: pair/one {min(seconds['two in threads']) / min(seconds['one']):.2f}, {one:.3g} s")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sizes", type=int, nargs="+", default=[256, 512, 1024])
    parser.add_argument("--repeats", type=int, default=9)
    options = parser.parse_args()
    for points in options.sizes:
        measure(points, options.repeats)


if __name__ == "__main__":
    main()
