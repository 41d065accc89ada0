"""How far the pixel's effect, carried to a higher cut-off, is from the effect there, over what is charged for it.

    OMP_NUM_THREADS=1 python experiments/pixel_falls.py [--toy] [-o FOLDER] [--seed SEED] [--evidence]

Ten drawn scenes (benchmarks/drawn.py) are solved with 3 and with 6 pixels per shortest wave, on the same surfaces, at
each cut-off of their plans to 1 %, in a quarter of the planned cell or less. The change at each cut-off is carried to
each higher one as `change_by_pixel` does it. A carry holds if it is no further from the change there than its error and
the scatter of both (95 %, added as squares). Cut-offs in FOLDER are not computed again.
"""

import sys
from functools import partial
from itertools import combinations
from math import log2
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from reference import make_deep
from script import Command, Rows, write_evidence

import roughsim as rs
from roughsim.estimate.ladder import Rung, change_by_pixel
from roughsim.estimate.levels import PIXEL_FALL
from roughsim.estimate.mean import Mean
from roughsim.observables.catalogue import OBSERVABLES

sys.path.append(str(Path(__file__).parents[1] / "benchmarks"))
from drawn import drawn_scenes

Array = NDArray[np.float64]
SEED = 31007  # drawn after the rule was chosen on scenes of 77, 1125, 16128 and 23011
FIRST = 5000  # seed of the surfaces
MOST_SIDE = 1536  # points along a side of the finer grid
PIXELS = 3, 6  # per shortest wave
MEMBERS, TOY_MEMBERS = (60, 40, 24, 12, 8), (4, 3)  # at the cut-offs, the last also at all that follow
SHOWN = {"T_flash": "flash_temperature", "area": "contact_fraction", "g(0)": "pressure_variance"}


def change(case: make_deep.Case, q_max: float, length: float, members: int) -> dict[str, Any]:
    """Return the relative change of each number of `MEASURED` by half the pixel in a cell, and its standard error."""
    column = "elastic" if case.scene.elastic else "capped"
    sides = [make_deep.side(q_max, length, pixels) for pixels in PIXELS]
    levels = [rs.Level(column, (side, side), q_max) for side in sides]
    rows = [[make_deep.moments(case, level, length, k, FIRST) for level in levels] for k in range(members)]
    coarse, fine = np.moveaxis(np.array(rows), 1, 0)
    relative = fine / fine.mean(axis=0) - coarse / coarse.mean(axis=0)
    return {
        "q": q_max,
        "change": (fine.mean(axis=0) / coarse.mean(axis=0) - 1.0).tolist(),
        "error": (relative.std(axis=0, ddof=1) / members**0.5).tolist(),
    }


def measured(name: str, case: make_deep.Case, rows: Rows, toy: bool) -> list[dict[str, Any]]:
    """Return the changes at the cut-offs of the plan of a scene, lowest first."""
    numerics = rs.plan(case.scene, 0.05 if toy else 0.01)
    cut_offs = sorted({level.q_max for level in numerics.levels if level.column != "smoothed"})
    counts = TOY_MEMBERS if toy else MEMBERS + MEMBERS[-1:] * len(cut_offs)
    found = []
    for q_max, members in zip(cut_offs, counts, strict=False):
        length = numerics.lengths[0] / 4
        while make_deep.side(q_max, length, PIXELS[1]) > MOST_SIDE:
            length /= 2
        found.append(rows.once(name, f"{q_max:.4g}", partial(change, case, q_max, length, members)))
    return found


def carried(name: str, scene: rs.Scene, found: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return each carry of each observable: steps of the cut-off, how far it is off, and its error, relative."""
    column, speeds = "elastic" if scene.elastic else "capped", len(scene.speeds)
    places = dict(zip(SHOWN, (slice(speeds), slice(speeds, speeds + 1), slice(speeds + 1, speeds + 2)), strict=True))
    results = []
    for (shown, place), (low, high) in ((item, pair) for item in places.items() for pair in combinations(found, 2)):
        order, fall = OBSERVABLES[SHOWN[shown]].pixel_orders[column == "capped"], PIXEL_FALL[column]

        def rung(row: dict[str, Any], of: slice) -> Rung:
            values = Mean(np.array(row["change"][of]), {})
            return Rung(row["q"], values, values, values, PIXELS[1] / PIXELS[0])

        slow = change_by_pixel([rung(low, slice(-speeds, None))], order, fall)[0].value
        there = change_by_pixel([rung(high, place)], order, fall)[0].value
        least = np.abs(slow).max() if shown == "T_flash" else 0.0
        change_there, error = change_by_pixel([rung(low, place)], order, fall, high["q"], least)
        scatter = np.hypot(low["error"][place], high["error"][place]) * 2.0 / (1.0 - 2.0**-order)
        results.append(
            {
                "scene": name,
                "observable": f"{shown}, {column}",
                "steps": min(round(log2(high["q"] / low["q"])), 3),
                "off": np.abs(change_there.value - there).tolist(),
                "told": np.hypot(error, scatter).tolist(),
            }
        )
    return results


def table(results: list[dict[str, Any]]) -> list[list[str]]:
    """Return by observable and steps of the cut-off how many carries there are, how many hold, and the worst."""
    cells = [["observable, contact", "steps", "carries", "hold", "worst off, %", "error then, %"]]
    for key in sorted({(row["observable"], row["steps"]) for row in results}):
        off, told = all_of([row for row in results if (row["observable"], row["steps"]) == key])
        worst = int(np.argmax(off / told))
        steps = f"{key[1]}" + " or more" * (key[1] == 3)
        found = str(off.size), str(np.sum(off <= told)), f"{100 * off[worst]:.2f}", f"{100 * told[worst]:.2f}"
        cells.append([key[0], steps, *found])
    return cells


def all_of(results: list[dict[str, Any]]) -> tuple[Array, Array]:
    """Return how far carries are off and what is told, of all speeds."""
    off, told = (np.concatenate([row[name] for row in results]) for name in ("off", "told"))
    return off, told


def main() -> None:
    command = Command(__file__, __doc__, "one scene, two cut-offs")
    command.add_argument("--seed", type=int, default=SEED, help="of the drawn scenes")
    options = command.parse()
    kept, results = Rows(options.output / f"changes-{options.seed}.json", resume=True), []
    for name, sections in drawn_scenes(options.seed).items():
        case = make_deep.case_of(rs.load_scene(sections))
        found = measured(f"{name}{' (toy)' * options.toy}", case, kept, options.toy)
        print(f"{name}: {len(found)} cut-offs", flush=True)
        results += carried(name, case.scene, found)
        if options.toy:
            break
    cells = table(results)
    print("\n".join(" | ".join(row) for row in cells))
    if options.evidence:
        off, told = all_of([row for row in results if row["observable"] == "T_flash, capped"])
        numbers = {"count": off.size, "held": 100 * np.mean(off <= told), "worst": 100 * np.max(off - told)}
        command_line = "python experiments/pixel_falls.py --evidence"
        write_evidence("pixel_falls", command_line, tables={"held": cells}, numbers=numbers)


if __name__ == "__main__":
    main()
