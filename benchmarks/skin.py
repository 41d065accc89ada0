"""CPU time of a run with a skin over that of the same run without one.

OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python benchmarks/skin.py [SCENE] [--times N] [--evidence]
"""

from __future__ import annotations

import sys
from pathlib import Path
from statistics import median

from in_turns import in_turns, options

sys.path.append(str(Path(__file__).parents[1] / "experiments"))
from script import write_evidence

OXIDE = {
    "thickness": "0.3 um",
    "conductivity": "3 W/(m K)",
    "density": 5000.0,
    "heat_capacity": 680.0,
}


def main() -> None:
    given = options(__doc__, 9, "skin_cost")
    rows = in_turns(given.scene, {"body.skin": OXIDE}, "skin", realizations=16, times=given.times)
    ratio = median(row["skin"] / row["bare"] for row in rows)
    print(f"ratio {ratio:.3f}, the median of {given.times}")
    if given.evidence:
        write_evidence(
            "skin_cost", "python benchmarks/skin.py --evidence", rows=rows, numbers={"ratio": ratio}
        )


if __name__ == "__main__":
    main()
