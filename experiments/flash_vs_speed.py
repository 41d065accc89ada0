"""Flash temperature over sliding speed for the three steel hardnesses: theory, smoothed and capped contact.

    python experiments/flash_vs_speed.py [--toy] [-o FOLDER] [--workers N] [--evidence]

Runs the bundled steel scenes (resuming what is there), prints T_flash at 35 m/s beside the theory, and draws one figure
per scene. --evidence writes table and picture of README.md. --toy computes a few small realizations, to see it work.
"""

from __future__ import annotations

import shutil
from dataclasses import replace

from script import EVIDENCE, Command, write_evidence

import roughsim as rs

SCENES = ("steel-0.5GPa", "steel-1.2GPa", "steel-2.0GPa")
SPEED = 35.0
EVEN = 0.5  # the share by symmetry, of two equally rough faces of one material


def toy(scene: rs.Scene) -> rs.Scene:
    levels = (
        {"column": "smoothed", "shape": [64, 64], "q_max": 3e4},
        {"column": "capped", "shape": [64, 64], "q_max": 4e4},
        {"column": "capped", "shape": [128, 128], "q_max": 8e4},
    )
    return replace(
        scene,
        numerics=replace(scene.numerics, lengths=(4e-3, 4e-3), levels=levels),
        ensemble=replace(scene.ensemble, max_realizations=3, until={}),
    )


HEADS = [
    "hardness",
    "theory, γ = 0.294",
    "smoothed: elastic contact on C_sm",
    "capped: p ≤ σ_P",
    "theory, share 1/2",
    "capped, share 1/2",
    "smoothed/theory",
    "capped/smoothed",
]


def main() -> None:
    command = Command(__file__, __doc__)
    command.add_argument("--workers", type=int, default=1, help="processes")
    options = command.parse()
    table, numbers = [HEADS], {}

    print(f"T_flash at {SPEED:g} m/s, K, with the scene's heat share (± total error, 95 %)")
    print(
        f"{'scene':14}{'theory':>8}{'smoothed':>16}{'capped':>16}{'smoothed/theory':>18}{'capped/smoothed':>18}"
    )
    for name in SCENES:
        scene = rs.load_scene(name)
        run = rs.run(
            toy(scene) if options.toy else scene, options.output / name, workers=options.workers
        )
        comparison = rs.compare(run)
        comparison.chart(options.output / f"{name}.png")
        row = next(
            r for r in comparison.rows if r.observable == "flash_temperature" and r.speed == SPEED
        )
        cells = [str(cell.number()) for cell in row.columns.values()]
        ratios = [str(ratio.number()) for ratio in row.ratios.values()]
        print(
            f"{name:14}{row.theory:8.1f}{cells[0]:>16}{cells[1]:>16}{ratios[0]:>18}{ratios[1]:>18}"
        )
        hardness = name.removeprefix("steel-").replace("GPa", " GPa")
        part = EVEN / scene.sliding.heat_partition  # the temperatures are in proportion to it
        even = [f"{part * row.theory:.1f}", str(row.columns["capped"].times(part).number())]
        table.append([hardness, f"{row.theory:.1f}", *cells, *even, *ratios])
        numbers[f"{name}_theory"] = row.theory
        numbers |= {f"{name}_{column}": float(cell.mean) for column, cell in row.columns.items()}
    if options.evidence:
        command_line = "python experiments/flash_vs_speed.py --evidence"
        write_evidence("flash_vs_speed", command_line, numbers=numbers, tables={"flash": table})
        chart = f"{SCENES[1]}.png"
        shutil.copyfile(options.output / chart, EVIDENCE.parent / chart)


if __name__ == "__main__":
    main()
