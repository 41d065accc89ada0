"""How long the command line takes to start: import, first line of each verb, first member, compiled code kept or not.

    python benchmarks/startup.py [--times N] [--scene NAME]

CPU time of the process and its children, s, and its multiple of `import numpy`. Each round times all of them once, so
that a busy machine weighs on all alike; the median of the rounds. The first member is timed once without compiled code
in the cache, and once with it; Python has the bytecode of all modules, as after an installation. Wall time stands
beside: it says something on an idle machine only.
"""

from __future__ import annotations

import argparse
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

COMMAND = ["-m", "roughsim"]
LIMIT = 1.3


class Times(NamedTuple):
    """CPU time of a process to its end, wall time to its first line and to its end, s."""

    cpu: float
    first: float
    end: float


def timed(words: list[str], cache: Path | None = None) -> Times:
    """Run Python with these words; `cache` is where compiled code is kept."""
    environment = os.environ | ({} if cache is None else {"NUMBA_CACHE_DIR": str(cache)})
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    used, began = cpu_of_children(), time.monotonic()
    process = subprocess.Popen(
        [sys.executable, *words], env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    assert process.stdout is not None
    text = process.stdout.readline()
    first = time.monotonic() - began
    text += process.stdout.read()
    if process.wait():
        raise SystemExit(f"{' '.join(words)} failed: {text.decode()}")
    return Times(cpu_of_children() - used, first, time.monotonic() - began)


def cpu_of_children() -> float:
    """CPU time of all children so far, s."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def verbs(run: Path, scene: str) -> dict[str, list[str]]:
    """Return what is started; `run` is where a run is, or will be when the others read it."""
    words = {
        "python": ["-c", "pass"],
        "import numpy": ["-c", "import numpy"],
        "import roughsim": ["-c", "import roughsim"],
        "roughsim --help": [*COMMAND, "--help"],
        "roughsim new": [*COMMAND, "new"],
        "roughsim theory": [*COMMAND, "theory", scene],
        "roughsim plan": [*COMMAND, "plan", scene],
        "roughsim run": [*COMMAND, "run", scene, "-o", str(run), "--max", "4", "--workers", "1"],
    }
    for verb in ("status", "compare", "report"):
        words[f"roughsim {verb}"] = [*COMMAND, verb, str(run)]
    words["roughsim plot"] = [*COMMAND, "plot", str(run), "pressure"]
    words["roughsim export"] = [*COMMAND, "export", str(run), "-o", str(run.with_suffix(".h5"))]
    words["roughsim doctor"] = [*COMMAND, "doctor"]
    return words


def main() -> int:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--times", type=int, default=5, help="rounds")
    options.add_argument("--scene", default="demo", help="a bundled scene")
    chosen = options.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder)
        os.environ["PYTHONPYCACHEPREFIX"] = str(home / "bytecode")
        timed(
            [*COMMAND, "run", chosen.scene, "-o", str(home / "before"), "--max", "1"],
            home / "before-compiled",
        )
        print(f"{'':30}   CPU s   × import numpy   wall s: first line   end")
        for name in ("cold", "warm"):
            words = [
                *COMMAND,
                "run",
                chosen.scene,
                "-o",
                str(home / name),
                "--max",
                "1",
                "--workers",
                "1",
            ]
            show(f"first member of {chosen.scene}, {name}", timed(words, home / "compiled"))
        words = verbs(home / "warm", chosen.scene)
        rounds = [
            [timed(start, home / "compiled") for start in words.values()]
            for _ in range(chosen.times + 1)
        ][1:]
        medians = [
            Times(*map(statistics.median, zip(*times, strict=True)))
            for times in zip(*rounds, strict=True)
        ]
    seconds = dict(zip(words, medians, strict=True))
    for name, value in seconds.items():
        show(name, value, seconds["import numpy"].cpu)
    ratio = seconds["roughsim --help"].cpu / seconds["import numpy"].cpu
    print(f"roughsim --help: {ratio:.2f} × import numpy, limit {LIMIT}")
    return 0 if ratio <= LIMIT else 1


def show(name: str, times: Times, unit: float | None = None) -> None:
    """Print one row."""
    multiple = "" if unit is None else f"{times.cpu / unit:.2f}"
    print(
        f"{name:30} {times.cpu:7.2f}   {multiple:>14}   {times.first:18.2f}   {times.end:3.2f}",
        flush=True,
    )


if __name__ == "__main__":
    sys.exit(main())
