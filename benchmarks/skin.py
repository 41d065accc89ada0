"""CPU time of a run with a skin over that of the same run without one.

    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python benchmarks/skin.py [SCENE] [--times N] [--evidence]

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

OXIDE = {"thickness": "0.3 um", "conductivity": "3 W/(m K)", "density": 5000.0, "heat_capacity": 680.0}
REALIZATIONS = 16


def seconds(scene: rs.Scene) -> float:
    """Return the CPU time of a run."""
    with tempfile.TemporaryDirectory() as folder:
        begun = time.process_time()
        rs.run(scene, Path(folder) / "run", workers=1, progress=False)
        return time.process_time() - begun


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("scene", nargs="?", default="steel-1.2GPa")
    options.add_argument("--times", type=int, default=9)
    options.add_argument("--evidence", action="store_true", help="write docs/evidence/skin_cost.json")
    given = options.parse_args()
    ensemble = {"ensemble.until": {}, "ensemble.max_realizations": REALIZATIONS}
    bare, covered = (rs.load_scene(given.scene, ensemble | more) for more in ({}, {"body.skin": OXIDE}))
    for scene in (bare, covered):
        seconds(scene)  # compiles
    rows: list[dict[str, float]] = []
    for _ in range(given.times):
        rows.append({"bare": seconds(bare), "skin": seconds(covered)})
        print("{bare:.2f} s without, {skin:.2f} s with a skin".format(**rows[-1]), flush=True)
    ratio = median(row["skin"] / row["bare"] for row in rows)
    print(f"ratio {ratio:.3f}, the median of {given.times}")
    if given.evidence:
        write_evidence("skin_cost", "python benchmarks/skin.py --evidence", rows=rows, numbers={"ratio": ratio})


if __name__ == "__main__":
    main()
