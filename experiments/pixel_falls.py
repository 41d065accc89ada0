"""How far the pixel's effect, carried to a higher cut-off, is from the effect there, beside the error told for it.

    OMP_NUM_THREADS=1 python experiments/pixel_falls.py [--toy] [-o FOLDER] [--seed SEED] [--evidence]

Ten drawn scenes (benchmarks/drawn.py) are solved with 3 and with 6 pixels per shortest wave, on the same surfaces, at
the cut-offs of their plans to 1 % that fit into a cell of half a longest wave. The change at each is carried to each
higher one by `change_by_pixel`. A carry holds if it is no further from the change there than its error and the scatter
of both (95 %, added as squares). Changes in FOLDER are not computed again.
"""

import sys
from collections.abc import Iterator
from functools import partial
from itertools import combinations, product
from math import log2, pi
from pathlib import Path
from typing import Any

import numpy as np
from figures.coverage import off_over_error
from numpy.typing import NDArray
from reference import make_deep
from scipy import stats
from script import Command, Rows, write_evidence

import roughsim as rs
from roughsim.estimate.levels import PIXEL_FALL
from roughsim.estimate.mean import exact
from roughsim.estimate.telescoping import LevelMean, change_by_pixel
from roughsim.observables.catalogue import OBSERVABLES

sys.path.append(str(Path(__file__).parents[1] / "benchmarks"))
from drawn import drawn_scenes

Array = NDArray[np.float64]
SEED = 40011  # drawn after all was settled on scenes of 77, 1125, 16128, 23011 and 31007
FIRST = 5000  # seed of the surfaces
PIXELS = 3, 6  # per shortest wave
MOST_SIDE = 1536  # points along a side of the finer grid
MEMBERS, TOY_MEMBERS = (
    (60, 40, 24, 12, 8),
    (4, 3),
)  # at the cut-offs, the last also at all that follow
ALONE = "T_flash, each speed by itself"
SHOWN = {"T_flash": "flash_temperature", "area": "contact_fraction", "g_σ(0)": "pressure_variance"}


def change(case: make_deep.Case, q_max: float, length: float, members: int) -> dict[str, Any]:
    """Return the relative change of each number of `MEASURED` by half the pixel, and its error, 95 %.

    At a cut-off, rad/m, in a cell with sides `length`, m.
    """
    column = "elastic" if case.scene.elastic else "capped"
    sides = [make_deep.side(q_max, length, pixels) for pixels in PIXELS]
    levels = [rs.Level(column, (side, side), q_max) for side in sides]
    rows = [
        [make_deep.moments(case, level, length, k, FIRST) for level in levels]
        for k in range(members)
    ]
    coarse, fine = np.moveaxis(np.array(rows), 1, 0)
    relative = fine / fine.mean(axis=0) - coarse / coarse.mean(axis=0)
    width = stats.t.ppf(0.975, members - 1) / members**0.5
    return {
        "q": q_max,
        "change": (fine.mean(axis=0) / coarse.mean(axis=0) - 1.0).tolist(),
        "error": (width * relative.std(axis=0, ddof=1)).tolist(),
    }


def changes(name: str, case: make_deep.Case, kept: Rows, toy: bool) -> Iterator[dict[str, Any]]:
    """Yield the changes at the cut-offs of the plan of a scene, lowest first, in a quarter of its cell at most."""
    numerics = rs.plan(case.scene, 0.05 if toy else 0.01)
    cut_offs = sorted({level.q_max for level in numerics.levels if level.column != "smoothed"})
    counts = TOY_MEMBERS if toy else MEMBERS + MEMBERS[-1:] * len(cut_offs)
    for q_max, members in zip(cut_offs, counts, strict=False):
        length = numerics.lengths[0] / 4
        while make_deep.side(q_max, length, PIXELS[1]) > MOST_SIDE:
            length /= 2
        if length * case.scene.spectrum.breaks[0] < pi:
            return
        key = f"{q_max:.4g} rad/m, {length:.4g} m, {members} members"
        yield kept.once(name, key, partial(change, case, q_max, length, members))


def carries(name: str, scene: rs.Scene, found: list[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """Yield each carry of each observable: steps of the cut-off, how far it is off, its error, and scatter, relative.

    T_flash also as that of scenes of one speed each.
    """
    column, speeds = "elastic" if scene.elastic else "capped", len(scene.speeds)
    areas = [("area", slice(speeds, speeds + 1)), ("g_σ(0)", slice(speeds + 1, speeds + 2))]
    places = [
        ("T_flash", slice(speeds)),
        *areas,
        *((ALONE, slice(k, k + 1)) for k in range(speeds)),
    ]
    for (shown, place), (low, high) in product(places, combinations(found, 2)):
        record = OBSERVABLES[SHOWN.get(shown, SHOWN["T_flash"])]
        order, fall = record.pixel_orders[column == "capped"], PIXEL_FALL[column]
        slow = [rung(low, slice(-speeds, None))] if record.per_speed else None
        there = change_by_pixel([rung(high, place)], order, fall)
        value = change_by_pixel([rung(low, place)], order, fall, high["q"], slow)
        carried = (low["q"] / high["q"]) ** fall * np.array(low["error"][place])
        yield {
            "scene": name,
            "observable": f"{shown}, {column}",
            "steps": min(round(log2(high["q"] / low["q"])), 3),
            "off": np.abs(value.value - there.value).tolist(),
            "told": value.errors["pixel"].tolist(),
            "scatter": (np.hypot(carried, high["error"][place]) / (1.0 - 2.0**-order)).tolist(),
        }


def rung(row: dict[str, Any], of: slice) -> LevelMean:
    """Return a rung with the change of some numbers by half the pixel."""
    values = exact(np.array(row["change"][of]))
    return LevelMean(row["q"], values, values, values, PIXELS[1] / PIXELS[0])


def all_of(rows: list[dict[str, Any]]) -> tuple[Array, Array]:
    """Return how far carries are off and their errors with the scatter, relative, one number for each speed."""
    off, told, scatter = (
        np.concatenate([row[name] for row in rows]) for name in ("off", "told", "scatter")
    )
    return off, np.hypot(told, scatter)


def table(rows: list[dict[str, Any]]) -> list[list[str]]:
    """Return by observable and steps of the cut-off how many carries there are, how many hold, and the worst."""
    cells = [["observable, contact", "steps", "carries", "hold", "worst: off, %", "error, %"]]
    for key in sorted({(row["observable"], row["steps"]) for row in rows}):
        off, error = all_of([row for row in rows if (row["observable"], row["steps"]) == key])
        worst = int(np.argmax(off - error))
        steps = f"{key[1]}" + " or more" * (key[1] == 3)
        percent = (f"{100 * value[worst]:.2f}" for value in (off, error))
        cells.append([key[0], steps, str(off.size), str(np.sum(off <= error)), *percent])
    return cells


def main() -> None:
    command = Command(__file__, __doc__, "two cut-offs of the first scene that has them")
    command.add_argument("--seed", type=int, default=SEED, help="of the drawn scenes")
    options = command.parse()
    if options.evidence and (options.toy or options.seed != SEED):
        command.error("--evidence is of the full size and its own seed")
    kept, rows = Rows(options.output / f"changes-{options.seed}.json", resume=True), []
    for name, sections in drawn_scenes(options.seed).items():
        case = make_deep.case_of(rs.load_scene(sections))
        found = list(changes(name, case, kept, options.toy))
        print(f"{name}: {len(found)} cut-offs", flush=True)
        rows += carries(name, case.scene, found)
        if options.toy and rows:
            break
    cells = table(rows)
    print("\n".join(" | ".join(row) for row in cells))
    together = [row for row in rows if not row["observable"].startswith(ALONE)]
    groups = {
        shown: all_of([row for row in together if row["observable"].startswith(f"{shown}, ")])
        for shown in SHOWN
    }
    off_over_error(groups, options.output / "pixel_falls.png")
    if options.evidence:
        of_all, alone = (
            all_of([row for row in rows if row["observable"] == f"{shown}, capped"])
            for shown in ("T_flash", ALONE)
        )
        worst = int(np.argmax(alone[0] - alone[1]))
        numbers = {
            "count": of_all[0].size,
            "hold": np.sum(of_all[0] <= of_all[1]),
            "scenes": len({row["scene"] for row in rows if row["observable"] == "T_flash, capped"}),
            "alone": 100 * np.mean(alone[0] <= alone[1]),
            "off_alone": 100 * alone[0][worst],
            "error_alone": 100 * alone[1][worst],
        }
        command_line = "python experiments/pixel_falls.py --evidence"
        write_evidence("pixel_falls", command_line, tables={"held": cells}, numbers=numbers)


if __name__ == "__main__":
    main()
