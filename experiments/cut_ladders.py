"""How far continuations of cut ladders are from the levels that they leave out, over the error that they state.

    OMP_NUM_THREADS=1 python experiments/cut_ladders.py [--toy] [-o FOLDER] [--seed SEED] [--evidence]

Each drawn face of one yielding body (benchmarks/drawn.py) yields at three wavenumbers q_y, one in each third of 3 to
1000 q_min, and two bodies are elastic. Their ladders have six cut-offs, from 31 to 1000 q_min, each twice the one
before. A ladder that is cut at some level is continued to each higher one, as if C(q) ended there, and compared with
the mean at that level. An interval holds it if they are no further apart than the bandwidth error and the scatter of
the levels in between (95 %, added as squares). Runs in FOLDER are not computed again.
"""

import sys
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from script import Command, write_evidence

import roughsim as rs
from roughsim.estimate.ladder import climb
from roughsim.estimate.levels import values_of
from roughsim.observables.catalogue import OBSERVABLES

sys.path.append(str(Path(__file__).parents[1] / "benchmarks"))
from drawn import SECOND_SEED, drawn_scenes, yielding_at

OBSERVED = "flash_temperature", "contact_fraction", "pressure_variance"
LOWEST, CUT_OFFS = 31.25, 6  # q_min; 1000 q_min is the sixth
WAVES, SIDE, LEAST_SIDE, MEMBERS = 4, 384, 192, 24  # of the cell, and of the grids; members of the lowest level
YIELDS = np.geomspace(3.0, 1000.0, 4)  # q_min
WAYS = {"by the law": "law of contact that yields", "with the shape": "shape of the theory", "as q_c": "power"}


def scenes(seed: int) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield names and sections; q_y is drawn with the same seed."""
    draw = np.random.default_rng(seed)
    for name, sections in drawn_scenes(seed).items():
        q_min = sections["surface"]["q_min"]
        surface = sections["surface"] | {"q_max": LOWEST * 2 ** (CUT_OFFS - 1) * q_min}
        changed = sections | {"surface": surface}
        if name.startswith("elastic"):
            yield name, changed
        elif name.startswith("yielding"):
            for least, most in pairwise(YIELDS):
                times = float(least * (most / least) ** draw.uniform())
                yield f"{name}, q_y = {times:.3g} q_min", yielding_at(changed, times * q_min)


def ladder(scene: rs.Scene, toy: bool) -> rs.Numerics:
    """Return levels at three pixels per shortest wave, those above the lowest in a quarter of the cell."""
    q_min = scene.spectrum.breaks[0]
    column, side = "elastic" if scene.elastic else "capped", 64 if toy else SIDE
    steps = range(1, 3 if toy else CUT_OFFS)
    lowest = LOWEST * side / SIDE * q_min
    levels = [rs.Level(column, (side, side), lowest)]
    levels += [rs.Level(column, (side // 4 << k,) * 2, lowest * 2**k, "quarter") for k in steps]
    return rs.Numerics(tuple(levels), (WAVES * 2 * np.pi / q_min,) * 2)


def ending(sections: dict[str, Any], scene: rs.Scene, q_max: float) -> rs.Scene:
    """Return a scene whose C(q) ends at a wavenumber, rad/m, and is the same up to there."""
    shape = {name: value for name, value in sections["surface"].items() if not name.startswith("rms_")}
    height = scene.spectrum.truncated(q_max=q_max).rms_height / len(scene.faces) ** 0.5  # of one of two equal faces
    return rs.load_scene(sections | {"surface": shape | {"q_max": q_max, "rms_height": height}})


def continuations(name: str, sections: dict[str, Any], run: rs.Run) -> Iterator[dict[str, Any]]:
    """Yield each continuation of each cut ladder: its way, how far it is off, and its errors, relative, by speed."""
    pairs = run.pairs()
    for j in range(1, len(pairs)):
        scene = ending(sections, run.scene, pairs[j].sample.q_max)
        for observable in OBSERVED:
            end = climb(OBSERVABLES[observable].of_level, pairs[: j + 1])[-1].mean
            for k in range(1, j + 1):
                found = values_of(scene, run.numerics.columns[0], observable, pairs[:k])
                between = [variance for stream, variance in end.variance.items() if stream not in found.scatter]
                way = next((words for start, words in WAYS.items() if found.way.startswith(start)), "none")
                yield {
                    "scene": name,
                    "observable": observable,
                    "way": way,
                    "cut-offs": k,
                    "times": pairs[j].sample.q_max / pairs[k - 1].sample.q_max,
                    "off": (found.mean / end.value - 1.0).tolist(),
                    "told": (found.errors["bandwidth"] / end.value).tolist(),
                    "scatter": (np.sqrt(sum(between)) / end.value).tolist(),
                }


def table(rows: list[dict[str, Any]]) -> list[list[str]]:
    """Return by observable, way and cut-offs how many there are, how many hold, and the worst of the others."""
    cells = [["", "continued by", "cut-offs", "continuations", "hold", "worst off/told"]]
    groups: dict[tuple[str, str, int], list[dict[str, Any]]] = {}
    for row in rows:
        groups.setdefault((row["observable"], row["way"], min(row["cut-offs"], 4)), []).append(row)
    for (observable, way, count), chosen in sorted(groups.items()):
        off, told, scatter = (np.concatenate([row[name] for row in chosen]) for name in ("off", "told", "scatter"))
        known = np.isfinite(told)
        within = np.hypot(told, 1.96 * scatter)[known]
        held = np.abs(off[known]) <= within
        if way == "none":
            cells.append([observable, "unknown", str(count), str(len(off)), "–", "–"])
            continue
        worst = np.max(np.abs(off[known]) / within, initial=0.0)
        cells.append([observable, way, str(count), str(known.sum()), str(held.sum()), f"{worst:.2f}"])
    return cells


def main() -> None:
    command = Command(__file__, __doc__, "one scene, three small levels")
    command.add_argument("--seed", type=int, default=SECOND_SEED, help="of the drawn scenes")
    options = command.parse()
    rows = []
    for name, sections in scenes(options.seed):
        scene = rs.load_scene(
            sections, {"ensemble.until": {}, "ensemble.max_realizations": 6 if options.toy else MEMBERS}
        )
        folder = options.output / f"{options.seed} {name}"
        run = rs.run(scene, folder, numerics=ladder(scene, options.toy), workers=1, progress=False)
        rows += continuations(name, sections, run)
        print(f"{name}: {run.counts} members", flush=True)
        if options.toy:
            break
    cells = table(rows)
    print("\n".join(" | ".join(row) for row in cells))
    if options.evidence:
        command_line = "python experiments/cut_ladders.py --evidence"
        write_evidence("cut_ladders", command_line, tables={"held": cells})


if __name__ == "__main__":
    main()
