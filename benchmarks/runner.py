"""The cost of the runner: its overhead beside the computation, and the speed-up of two workers.

    python benchmarks/runner.py [--realizations N]

Capped steel contact at 1024². The overhead is what one process takes beyond the time inside its realizations (files,
locks, stopping rule); the speed-up compares the time between the first and the last file of each run, so that starting
Python in the workers does not count.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import roughsim as rs
from roughsim.record import Run, member_path, read_member


def scene() -> rs.Scene:
    steel = rs.load_scene("steel-0.5GPa")
    level = {"column": "capped", "shape": [1024, 1024], "q_max": 4.06e5}
    return replace(steel, numerics=replace(steel.numerics, levels=(level,), keep_fields=0))


def timed(folder: Path, realizations: int, workers: int) -> tuple[Run, float]:
    began = time.perf_counter()
    run = rs.run(scene(), folder, workers=workers, max_realizations=realizations, until={})
    return run, time.perf_counter() - began


def pace(run: Run) -> float:
    """Seconds per member between the first and the last file."""
    written = sorted(member_path(run.folder, 0, i).stat().st_mtime for i in range(run.realizations))
    return (written[-1] - written[0]) / (len(written) - 1)


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--realizations", type=int, default=24)
    count = options.parse_args().realizations
    with tempfile.TemporaryDirectory() as folder:
        timed(Path(folder) / "warm", 1, 1)
        alone, wall = timed(Path(folder) / "alone", count, 1)
        shared, _ = timed(Path(folder) / "shared", count, 2)
        inside = sum(
            sum(read_member(member_path(alone.folder, 0, i)).provenance["seconds"].values()) for i in range(count)
        )
        print(
            f"one process: {wall:.2f} s, inside realizations {inside:.2f} s, overhead {100 * (wall / inside - 1):.1f} %"
        )
        print(
            f"pace: {pace(alone):.3f} s with one, {pace(shared):.3f} s with two, ratio {pace(alone) / pace(shared):.2f}"
        )


if __name__ == "__main__":
    main()
