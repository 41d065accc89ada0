"""The cost of the runner: its overhead beside the computation, and the speed-up of two workers.

    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python benchmarks/runner.py [--realizations N]
    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python benchmarks/runner.py --whole 0.003 [--times 3]

Capped steel contact at 1024². Times are taken between the first and the last member of each run, so that starting
Python and making the plan do not count. The overhead is what a member of a run costs beyond the same member in a plain
loop over `realize`: saving it, the rounds, the hand-over.

With `--whole` the wall time of a run of steel-1.2GPa from start to end at a target, by two workers over one: each turn
runs the command with one, and then with two. It needs two idle cores.
"""

from __future__ import annotations

import argparse
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import roughsim as rs


def scene() -> rs.Scene:
    steel = rs.load_scene("steel-0.5GPa")
    level = {"column": "capped", "shape": [1024, 1024], "q_max": 4.06e5}
    return replace(steel, numerics=replace(steel.numerics, levels=(level,), keep_fields=0))


def timed(folder: Path, realizations: int, workers: int) -> list[float]:
    """The times at which the members of a run were there, s."""
    times: list[float] = []
    rs.run(
        scene(),
        folder,
        workers=workers,
        max_realizations=realizations,
        until={},
        observer=lambda _: times.append(time.perf_counter()),
    )
    return times


def pace(times: list[float]) -> float:
    """Seconds per member between the first and the last one."""
    return (times[-1] - times[0]) / (len(times) - 1)


def loop(realizations: int) -> float:
    """Seconds per member of a plain loop, the first left out."""
    chosen = scene()
    numerics = rs.plan(chosen)
    for index in range(realizations):
        if index == 1:
            began = time.perf_counter()
        rs.realize(chosen, numerics, seed=1, level=0, index=index)
    return (time.perf_counter() - began) / (realizations - 1)


def whole(target: float, workers: int) -> float:
    """Wall time of the command of a run, s."""
    with tempfile.TemporaryDirectory() as folder:
        words = [sys.executable, "-m", "roughsim", "run", "steel-1.2GPa", "-o", f"{folder}/run"]
        words += ["--target-error", str(target), "--workers", str(workers)]
        began = time.perf_counter()
        subprocess.run(words, check=True, capture_output=True)
        return time.perf_counter() - began


def compare(target: float, times: int) -> None:
    """Print the wall times of one worker and of two."""
    ratios = []
    for _ in range(times):
        alone, shared = whole(target, 1), whole(target, 2)
        ratios.append(shared / alone)
        print(f"one {alone:.2f} s, two {shared:.2f} s, {ratios[-1]:.3f}", flush=True)
    print(f"two workers over one: {statistics.median(ratios):.3f} (median of {times})")


def main() -> None:
    options = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    options.add_argument("--realizations", type=int, default=24)
    options.add_argument("--whole", type=float, help="relative total error to run to")
    options.add_argument("--times", type=int, default=3)
    given = options.parse_args()
    if given.whole is not None:
        compare(given.whole, given.times)
        return
    count = given.realizations
    with tempfile.TemporaryDirectory() as folder:
        timed(Path(folder) / "warm", 1, 1)
        alone, shared = (
            timed(Path(folder) / "alone", count, 1),
            timed(Path(folder) / "shared", count, 2),
        )
        bare = loop(count)
        more = 100 * (pace(alone) / bare - 1)
        print(f"a member: {pace(alone):.4f} s, in a plain loop {bare:.4f} s, overhead {more:.1f} %")
        print(
            f"two workers: {pace(shared):.4f} s a member, {pace(alone) / pace(shared):.2f} times one"
        )


if __name__ == "__main__":
    main()
