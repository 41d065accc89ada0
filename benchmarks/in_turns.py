"""CPU times of runs of two scenes in turns, for benchmarks of what a scene asks for beside T_flash.

The runs are in one process, which is warm, and end at the same number of realizations. Each turn has speeds of its own,
so that responses that a process keeps for the members of a run are computed by every run.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path
from typing import Any

import roughsim as rs


def options(description: str, times: int, evidence: str) -> argparse.Namespace:
    """Return the scene, the number of times, and whether to write docs/evidence/`evidence`.json."""
    parser = argparse.ArgumentParser(
        description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("scene", nargs="?", default="steel-1.2GPa")
    parser.add_argument("--times", type=int, default=times)
    parser.add_argument(
        "--evidence", action="store_true", help=f"write docs/evidence/{evidence}.json"
    )
    return parser.parse_args()


def seconds(scene: rs.Scene) -> float:
    """Return the CPU time of a run."""
    with tempfile.TemporaryDirectory() as folder:
        begun = time.process_time()
        rs.run(scene, Path(folder) / "run", workers=1, progress=False)
        return time.process_time() - begun


def in_turns(
    scene: str, changes: dict[str, Any], name: str, *, realizations: int, times: int
) -> list[dict[str, float]]:
    """Return the CPU seconds of runs of a scene as it is, "bare", and with changes, under `name`; print each turn."""
    ensemble = {"ensemble.until": {}, "ensemble.max_realizations": realizations}
    speeds = rs.load_scene(scene).speeds
    rows: list[dict[str, float]] = []
    for turn in range(times + 1):
        ensemble["sliding.speed"] = [speed * (1.0 + 1e-3 * turn) for speed in speeds]
        scenes = {
            "bare": rs.load_scene(scene, ensemble),
            name: rs.load_scene(scene, ensemble | changes),
        }
        rows.append({key: seconds(each) for key, each in scenes.items()})
        print(f"{rows[-1]['bare']:.2f} s bare, {rows[-1][name]:.2f} s {name}", flush=True)
    return rows[1:]  # the first turn compiles
