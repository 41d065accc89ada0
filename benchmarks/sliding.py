"""The cost of two sliding bodies: one cell slid once over, its contacts begun from the last one and anew.

    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python benchmarks/sliding.py [--points 512] [--steps N] [--share 0.1]
    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python benchmarks/sliding.py --continued [--evidence]

steel-1.2GPa at 35 m/s, roughness up to 1e5 1/m. CPU seconds of one thread for the whole length of the cell. Measured is
the first `--share` of it, after a slide of a few steps that loads all kernels.
--continued: runs of both faces over 16 mm at 1 and 35 m/s, with slides that are followed to the end, and once around
their cell; of each as few as bring the total error of T_flash to 4.3 %.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path as FilePath

import numpy as np

import roughsim as rs
from roughsim.sliding.path import Path, oblique_path
from roughsim.sliding.stepping import Motion, contacts, walk
from roughsim.surface.synthesis import synthesize

sys.path.append(str(FilePath(__file__).parents[1] / "experiments"))
from script import write_evidence

CELL, SPEED = 4e-3, 35.0  # m, m/s
TOLERANCE = 3e-3  # of the contacts
STEEL = {"conductivity": 30.0, "diffusivity": 7.6e-6}


def cpu(work) -> float:
    """CPU seconds to the end of an iterator."""
    began = time.process_time()
    for _ in work:
        pass
    return time.process_time() - began


SLIDES = {
    "whole": (4, None),
    "followed": (5, CELL),
}  # members, and the distance over which they are followed, m


def continued(*, evidence: bool) -> None:
    """Print CPU seconds and total error of runs with slides that are followed to the end, or once around the cell."""
    numbers = {}
    for name, (members, followed) in SLIDES.items():
        slide = {"column": "sliding", "shape": [144, 144], "q_max": 5.5e4, "first": members}
        contacts_of = [
            {"column": "capped", "shape": [n, n], "q_max": 1e5 * n / 256} for n in (256, 512)
        ]
        changes = {
            "sliding.speed": [1.0, SPEED],
            "sliding.history": "sliding",
            "sliding.slid_distance": "16 mm",
            "numerics.lengths": [CELL, CELL],
            "numerics.levels": [*contacts_of, slide | ({"followed": followed} if followed else {})],
            "ensemble.max_realizations": 40,
            "ensemble.until": {},
        }
        with tempfile.TemporaryDirectory() as folder:
            began = time.process_time()
            run = rs.run(rs.load_scene("steel-1.2GPa", changes), f"{folder}/run", workers=1)
            seconds = time.process_time() - began
            found = run.estimate("flash_temperature", "sliding")
        error = 100 * float(np.max(found.total_error / found.mean))
        numbers |= {f"{name}_seconds": seconds, f"{name}_error": error}
        print(
            f"{members} slides, {name}: {seconds:.0f} CPU s, total error {error:.1f} %, T_flash {found.mean.round(1)} K"
        )
    if evidence:
        numbers["times"] = numbers["whole_seconds"] / numbers["followed_seconds"]
        write_evidence(
            "sliding_continued",
            "python benchmarks/sliding.py --continued --evidence",
            numbers=numbers,
        )


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--points", type=int, default=512)
    options.add_argument(
        "--steps", type=int, help="of the whole length; one pixel each if left out"
    )
    options.add_argument("--share", type=float, default=0.1)
    options.add_argument(
        "--continued",
        action="store_true",
        help="time runs that continue their slides by the theory",
    )
    options.add_argument(
        "--evidence", action="store_true", help="write docs/evidence/sliding_continued.json, too"
    )
    chosen = options.parse_args()
    if chosen.continued:
        continued(evidence=chosen.evidence)
        return
    scene = rs.load_scene("steel-1.2GPa")
    grid = rs.Grid((chosen.points, chosen.points), (CELL, CELL))
    spectrum = scene.faces[0].truncated(q_max=1e5)
    first, second = (synthesize(spectrum, grid, np.random.default_rng(seed)) for seed in (1, 2))
    solid = rs.Solid(scene.effective_modulus, scene.penetration_hardness)
    load = scene.sliding.nominal_pressure
    whole = oblique_path(grid, CELL, chosen.steps)
    count = max(4, round(chosen.share * whole.steps))
    part = Path(whole.offsets[: count + 1], whole.distance[: count + 1])
    motions = [Motion(SPEED, 0.11, rs.Body(**STEEL), rs.Body(**STEEL))]
    few = Path(whole.offsets[:5], whole.distance[:5])
    cpu(walk(contacts(first, second, grid, solid, load, few, TOLERANCE), grid, few, motions))

    def anew():
        for offset in part.offsets:
            composite = first + np.roll(second, -offset, axis=(0, 1))
            yield rs.solve_contact(
                composite, grid, solid, nominal_pressure=load, tolerance=TOLERANCE
            )

    times = whole.steps / count
    slid = times * cpu(
        walk(contacts(first, second, grid, solid, load, part, TOLERANCE), grid, part, motions)
    )
    begun = times * cpu(contacts(first, second, grid, solid, load, part, TOLERANCE))
    cold = times * cpu(anew())
    print(f"{chosen.points}², {whole.steps} steps over one cell of {1e3 * CELL:g} mm, CPU seconds")
    print(f"contacts, each begun from the last: {begun:6.1f}")
    print(f"contacts, each anew:                {cold:6.1f}   {cold / begun:.2f} times as many")
    print(f"the slide, one speed:               {slid:6.1f}   of it heat {slid - begun:.1f}")
    print(
        f"with contacts anew:                 {slid - begun + cold:6.1f}   {(slid - begun + cold) / slid:.2f}"
    )


if __name__ == "__main__":
    main()
