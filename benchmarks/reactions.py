"""CPU time of a run that stores the distribution of the temperature over that of the same run without it.

OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python benchmarks/reactions.py [SCENE] [--times N] [--evidence]
"""

from __future__ import annotations

import sys
from pathlib import Path
from statistics import median

from in_turns import in_turns, options

sys.path.append(str(Path(__file__).parents[1] / "experiments"))
from script import write_evidence

REALIZATIONS = 6


def main() -> None:
    given = options(__doc__, 7, "reactions_cost")
    asks = {"observables.temperature_distribution": True}
    rows = in_turns(given.scene, asks, "asking", realizations=REALIZATIONS, times=given.times)
    ratio = median(row["asking"] / row["bare"] for row in rows)
    each = median((row["asking"] - row["bare"]) / REALIZATIONS for row in rows)
    print(f"ratio {ratio:.3f}, {each:.3f} s for each realization, medians of {given.times}")
    if given.evidence:
        numbers = {"ratio": ratio, "seconds_each": each}
        write_evidence(
            "reactions_cost",
            "python benchmarks/reactions.py --evidence",
            rows=rows,
            numbers=numbers,
        )


if __name__ == "__main__":
    main()
