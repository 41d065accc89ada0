"""CPU time of a run that stores the distribution of the temperature over that of the same run without it.

    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python benchmarks/reactions.py [SCENE] [--times N] [--evidence]

The runs take turns in one process, which is warm, and end at the same number of realizations.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

import roughsim as rs

sys.path.append(str(Path(__file__).parents[1] / "experiments"))
from script import write_evidence

REALIZATIONS = 6


def seconds(scene: rs.Scene) -> float:
    """Return the CPU time of a run."""
    with tempfile.TemporaryDirectory() as folder:
        begun = time.process_time()
        rs.run(scene, Path(folder) / "run", workers=1)
        return time.process_time() - begun


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("scene", nargs="?", default="steel-1.2GPa")
    options.add_argument("--times", type=int, default=3)
    options.add_argument("--evidence", action="store_true", help="write docs/evidence/reactions_cost.json")
    given = options.parse_args()
    ensemble = {"ensemble.until": {}, "ensemble.max_realizations": REALIZATIONS}
    asks = {"observables.temperature_distribution": True}
    bare, asking = (rs.load_scene(given.scene, ensemble | more) for more in ({}, asks))
    for scene in (bare, asking):
        seconds(scene)  # compiles
    rows: list[dict[str, float]] = []
    for _ in range(given.times):
        rows.append({"bare": seconds(bare), "asking": seconds(asking)})
        print("{bare:.2f} s without, {asking:.2f} s with the distribution".format(**rows[-1]), flush=True)
    ratio = median(row["asking"] / row["bare"] for row in rows)
    each = median((row["asking"] - row["bare"]) / REALIZATIONS for row in rows)
    print(f"ratio {ratio:.3f}, {each:.3f} s for each realization, medians of {given.times}")
    if given.evidence:
        numbers = {"ratio": ratio, "seconds_each": each}
        write_evidence("reactions_cost", "python benchmarks/reactions.py --evidence", rows=rows, numbers=numbers)


if __name__ == "__main__":
    main()
