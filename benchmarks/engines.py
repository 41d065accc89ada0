"""What it costs to hand members out to 1 to 64 workers, by engine: process pools, threads, dask and MPI.

    python benchmarks/engines.py [--engines NAME ...] [--workers N ...] [--seconds S ...]

Nothing is solved: a member sleeps, and returns random numbers. So many workers share few cores. The folder is a
temporary one. Each row has:

- alone: CPU time of the leading process for each member that the engine hands out and takes back without roughsim. The
  calls sleep as long as those of the run, and return the same;
- run: the same with a run: job, claim, part, rounds judged. The difference to "alone" is what roughsim adds;
- thread adds: the part of it in the thread that calls `run`. The other threads are those of the engine: what differs
  there is noise, or what the engine needs for the larger arguments;
- of the ideal: the wall time of the run over that of workers that never wait.

An engine that is not installed is named and skipped. MPI needs `mpiexec` on the path.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    Executor,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
    wait,
)
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

import roughsim as rs
from roughsim.ensemble.workers import Job, Wanted
from roughsim.observables.catalogue import NUMBERS
from roughsim.observables.member import Member, StoredMoments
from roughsim.pipeline import versions

MODES = 509  # wavenumbers of the stress spectrum of a grid of 1024²
LASTS = 3.0  # s that a measurement takes, if the engine keeps up
LEAST, MOST = 4, 1000  # members for each worker, and in all
NEEDS = {"dask threads": "distributed", "dask processes": "distributed", "mpi": "mpi4py"}
ENGINES = ("threads", "processes", "dask threads", "dask processes", "mpi")


def scene() -> rs.Scene:
    """A scene of one level."""
    steel = rs.load_scene("steel-0.5GPa")
    level = {"column": "capped", "shape": [1024, 1024], "q_max": 4.06e5}
    return replace(steel, numerics=replace(steel.numerics, levels=(level,), keep_fields=0))


def simulated_member(index: int, speeds: tuple[float, ...], seconds: float) -> Member:
    """Return a member with random numbers, as long as a real one, after a sleep."""
    time.sleep(lasting(index, seconds))
    rng = np.random.default_rng(index)
    numbers = {
        name: 1.0 + 0.1 * rng.random(len(speeds) if one.per_speed else 1)
        for name, one in NUMBERS.items()
    }
    stages = ("surface", "contact", "observables")
    return Member(
        0,
        index,
        moments=(StoredMoments(numbers, np.arange(1.0, MODES + 1.0), rng.random(MODES)),),
        lengths=(1e-3, 1e-3),
        speeds=speeds,
        provenance={
            "residual": float(rng.random()),
            "iterations": 20,
            "seconds": {stage: float(rng.random()) for stage in stages},
            "seed": 1,
            "stream": 0,
            "threads": 1,
            "versions": known_versions(),
            "written": "2026-01-31T12:00:00Z",
        },
    )


@cache
def known_versions() -> dict[str, str]:
    return versions()


def lasting(index: int, seconds: float) -> float:
    """How long a member sleeps, s: like real ones, no two come back at the same moment, which would help an engine."""
    return seconds * random.Random(index).uniform(0.75, 1.25)


def simulate(jobs: dict[int, Job], wanted: Wanted, seconds: float) -> list[tuple[int, Member]]:
    """What a worker does in place of a solve."""
    return [
        (number, simulated_member(index, jobs[number].speeds, seconds))
        for index, numbers in wanted
        for number in numbers
    ]


class Simulated(Executor):
    """An executor whose workers solve nothing."""

    def __init__(self, inner: Executor, seconds: float):
        self.inner, self.seconds = inner, seconds

    def submit(self, function: Callable[..., Any], /, *arguments: Any, **_: Any) -> Future[Any]:
        """Hand out a sleep."""
        return self.inner.submit(simulate, *arguments, self.seconds)


@contextmanager
def started(engine: str, workers: int) -> Iterator[Executor]:
    """Start an engine with so many workers."""
    if engine == "threads":
        with ThreadPoolExecutor(workers) as pool:
            yield pool
    elif engine == "processes":
        with ProcessPoolExecutor(workers, get_context("spawn")) as pool:
            yield pool
    elif engine == "mpi":
        from mpi4py.futures import MPIPoolExecutor

        with MPIPoolExecutor() as pool:
            yield pool
    else:
        from dask.distributed import Client, LocalCluster

        processes = engine == "dask processes"
        shape = (
            {"n_workers": workers, "threads_per_worker": 1}
            if processes
            else {"n_workers": 1, "threads_per_worker": workers}
        )
        cluster = LocalCluster(processes=processes, dashboard_address=None, **shape)
        with cluster, Client(cluster, timeout=120) as client:
            client.wait_for_workers(shape["n_workers"], timeout=300)
            yield client.get_executor(pure=False)


def now() -> tuple[float, float, float]:
    """Return CPU time of this process, that of this thread, and the time, s."""
    return time.process_time(), time.thread_time(), time.perf_counter()


def alone(pool: Executor, workers: int, seconds: float, count: int) -> list[float]:
    """CPU seconds of this process, and of this thread, for each of `count` calls without roughsim."""
    speeds = scene().speeds
    pending: set[Future[Any]] = set()
    began = now()
    for index in range(count):
        if len(pending) >= 2 * workers:
            pending = set(wait(pending, return_when=FIRST_COMPLETED).not_done)
        pending.add(pool.submit(simulated_member, index, speeds, seconds))
    wait(pending)
    return [(end - begin) / count for begin, end in zip(began, now(), strict=True)][:2]


def of_run(pool: Executor, workers: int, seconds: float, count: int, folder: Path) -> list[float]:
    """CPU seconds of this process, and of this thread, for each member of a run, and the wall time over the ideal one.

    All count from the first member that came back to the last one.
    """
    marks: list[tuple[float, float, float]] = []
    executor, observer = Simulated(pool, seconds), lambda _: marks.append(now())
    rs.run(
        scene(),
        folder,
        until={},
        max_realizations=count,
        workers=workers,
        executor=executor,
        observer=observer,
    )
    process, thread, wall = (
        (end - begin) / (count - 1) for begin, end in zip(marks[0], marks[-1], strict=True)
    )
    return [process, thread, wall * workers / seconds]


def measure(engine: str, workers: int, durations: list[float]) -> list[dict[str, Any]]:
    """Measure one engine with so many workers, in this process."""
    rows = []
    with tempfile.TemporaryDirectory() as folder, started(engine, workers) as pool:
        warm = Path(folder) / "warm"
        rs.run(scene(), warm, until={}, max_realizations=2, executor=Simulated(pool, 0.0))
        alone(pool, workers, 0.5, 2 * workers)  # until all workers have started
        for seconds in durations:
            count = int(
                min(max(LEAST * workers, LASTS * workers / seconds), max(MOST, LEAST * workers))
            )
            handing, thread = alone(pool, workers, seconds, count)
            whole, of_thread, ideal = of_run(
                pool, workers, seconds, count, Path(folder) / f"{seconds}"
            )
            row = {
                "engine": engine,
                "workers": workers,
                "seconds": seconds,
                "members": count,
                "alone": handing,
            }
            rows.append(row | {"run": whole, "thread": of_thread - thread, "ideal": ideal})
    return rows


def missing(engine: str) -> str:
    """Why an engine cannot be measured here; empty if it can."""
    module = NEEDS.get(engine)
    if module is not None and importlib.util.find_spec(module) is None:
        return f"{module} is not installed"
    return (
        "mpiexec is not on the path" if engine == "mpi" and shutil.which("mpiexec") is None else ""
    )


def main() -> None:
    options = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    options.add_argument("--engines", nargs="+", choices=ENGINES, default=list(ENGINES))
    options.add_argument("--workers", nargs="+", type=int, default=[1, 2, 4, 8, 16, 32, 64])
    options.add_argument("--seconds", nargs="+", type=float, default=[0.01, 0.1, 1.0])
    options.add_argument(
        "--inside", action="store_true", help=argparse.SUPPRESS
    )  # measure here: one engine, one number
    given = options.parse_args()
    if given.inside:
        print(json.dumps(measure(given.engines[0], given.workers[0], given.seconds)))
        return
    print(
        "| engine | workers | a member, s | members | alone, ms | run, ms | roughsim adds, ms | thread adds, ms | "
        "of the ideal |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    for engine in given.engines:
        if reason := missing(engine):
            print(f"| {engine} | skipped: {reason} | | | | | | | |")
            continue
        for workers in given.workers:
            words = [__file__, "--inside", "--engines", engine, "--workers", str(workers)]
            words += ["--seconds", *(str(seconds) for seconds in given.seconds)]
            start = [sys.executable]
            if engine == "mpi":  # one rank leads
                start = ["mpiexec", "-n", str(workers + 1), sys.executable, "-m", "mpi4py.futures"]
            done = subprocess.run([*start, *words], stdout=subprocess.PIPE, text=True, check=True)
            for row in json.loads(done.stdout.splitlines()[-1]):
                added = row["run"] - row["alone"]
                print(
                    f"| {engine} | {workers} | {row['seconds']:g} | {row['members']} | {1e3 * row['alone']:.2f} | "
                    f"{1e3 * row['run']:.2f} | {1e3 * added:.2f} | {1e3 * row['thread']:.2f} | {row['ideal']:.2f} |",
                    flush=True,
                )


if __name__ == "__main__":
    main()
