"""How long the command line takes to start, as a multiple of `import numpy`, measured side by side.

    python benchmarks/startup.py [--times N]

Each round times all of them once, so that a busy machine weighs on all alike; CPU time of the process, the median.
"""

from __future__ import annotations

import argparse
import resource
import statistics
import subprocess
import sys

WORDS = {
    "python": ["-c", "pass"],
    "import numpy": ["-c", "import numpy"],
    "import roughsim": ["-c", "import roughsim"],
    "roughsim --help": ["-m", "roughsim.cli", "--help"],
    "roughsim new": ["-m", "roughsim.cli", "new"],
}
LIMIT = 1.3


def cpu_seconds(words: list[str]) -> float:
    """CPU time of one process, s."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, *words], stdout=subprocess.DEVNULL, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def measured(times: int) -> dict[str, float]:
    """Median CPU time of each, s; the first round, which may still write byte code, does not count."""
    rounds = [[cpu_seconds(words) for words in WORDS.values()] for _ in range(times + 1)][1:]
    return dict(zip(WORDS, map(statistics.median, zip(*rounds, strict=True)), strict=True))


def main() -> int:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--times", type=int, default=15, help="rounds")
    seconds = measured(options.parse_args().times)
    for name, value in seconds.items():
        print(f"{name:16} {1e3 * value:6.0f} ms of CPU   {value / seconds['import numpy']:5.2f} × import numpy")
    ratio = seconds["roughsim --help"] / seconds["import numpy"]
    print(f"roughsim --help: {ratio:.2f}, limit {LIMIT}")
    return 0 if ratio <= LIMIT else 1


if __name__ == "__main__":
    sys.exit(main())
