"""How far means continued from cut ladders are from the levels that they leave out, over their stated errors.

    OMP_NUM_THREADS=1 python experiments/cut_ladders.py [--toy] [-o FOLDER] [--seed SEED] [--evidence]

Each drawn face of one yielding body (benchmarks/drawn.py) yields at three wavenumbers q_y, one in each third of 3 to
1000 q_min, and two bodies are elastic. Their ladders have six cut-offs, from 31 to 1000 q_min, each twice the one
before. A ladder that is cut at some level is continued to each higher one, as if C(q) ended there, and compared with
the mean at that level: T_flash, and the areas and g_σ(0), which yielded contact continues towards their bounds. An
interval holds it if they are no further apart than the bandwidth error and the scatter of their difference (95 %, added
as squares). Runs in FOLDER are not computed again.
"""

import sys
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from figures.coverage import off_over_error
from numpy.typing import NDArray
from scipy import stats
from script import Command, write_evidence

import roughsim as rs
from roughsim.estimate.errors import spread_of
from roughsim.estimate.levels import values_of

sys.path.append(str(Path(__file__).parents[1] / "benchmarks"))
from drawn import drawn_scenes, yielding_at

Array = NDArray[np.float64]
FLASH, BOUNDED = "T_flash", "areas, g_σ(0)"
NAMES = {
    "flash_temperature": FLASH,
    "contact_fraction": BOUNDED,
    "plastic_fraction": BOUNDED,
    "pressure_variance": BOUNDED,
}
SEED = 4099  # drawn after the rules were chosen on scenes of 77 and 1125
LOWEST, CUT_OFFS = 31.25, 6  # q_min; 1000 q_min is the sixth
WAVES, SIDE, MEMBERS = 4, 384, 24  # of the cell, and of the grids; members of the lowest level
YIELDS = np.geomspace(3.0, 1000.0, 4)  # q_min
UNKNOWN = "nothing: unknown"
WAYS = {
    "by the calibrated law": "calibrated law",
    "with the shape": "shape of the theory",
    "as q_c": "power",
    "towards its bound": "bound",
}


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
    shape = {
        name: value for name, value in sections["surface"].items() if not name.startswith("rms_")
    }
    height = (
        scene.spectrum.truncated(q_max=q_max).rms_height / len(scene.faces) ** 0.5
    )  # of one of two equal faces
    return rs.load_scene(sections | {"surface": shape | {"q_max": q_max, "rms_height": height}})


def continuations(name: str, sections: dict[str, Any], run: rs.Run) -> Iterator[dict[str, Any]]:
    """Yield each continuation of each cut ladder: its way, how far it is off, and its errors, relative, by speed."""
    samples, column = run.samples(), run.numerics.columns[0]
    for j in range(1, len(samples)):
        scene = ending(sections, run.scene, samples[j].q_max)
        for observable in list(NAMES)[: 2 if scene.elastic else None]:
            end = values_of(scene, column, observable, samples[: j + 1])
            for k in range(1, j + 1):
                found = values_of(scene, column, observable, samples[:k])
                difference = found - end
                scatter, freedom = spread_of(difference)
                yield {
                    "scene": name,
                    "of": NAMES[observable],
                    "way": next(
                        (words for start, words in WAYS.items() if found.way.startswith(start)),
                        UNKNOWN,
                    ),
                    "steps": min(k - 1, 3),
                    "off": (difference.value / end.value).tolist(),
                    "told": (found.errors["bandwidth"] / end.value).tolist(),
                    "scatter": (scatter * stats.t.ppf(0.975, freedom) / end.value).tolist(),
                }


def off_and_error(rows: list[dict[str, Any]]) -> tuple[Array, Array]:
    """Return how far continuations are off and their errors with the scatter, relative, of all speeds."""
    off, told, scatter = (
        np.concatenate([[], *(row[name] for row in rows)]) for name in ("off", "told", "scatter")
    )
    return np.abs(off), np.hypot(told, scatter)


def over_error(rows: list[dict[str, Any]]) -> Array:
    """Return |off| over the root of the squares of bandwidth error and scatter of all speeds."""
    off, error = off_and_error(rows)
    return off / error


def table(rows: list[dict[str, Any]]) -> list[list[str]]:
    """Return by way and steps of the cut-off how many continuations there are, how many hold, and the worst."""
    cells = [["of", "continued by", "steps", "continuations", "hold", "worst off/error"]]
    groups: dict[tuple[str, str, int], list[dict[str, Any]]] = {}
    for row in rows:
        groups.setdefault((row["of"], row["way"], row["steps"]), []).append(row)
    for (of, way, steps), chosen in sorted(groups.items()):
        ratio = over_error(chosen)
        found = [str(np.sum(ratio <= 1.0)), f"{ratio.max():.2f}"] if way != UNKNOWN else ["–", "–"]
        cells.append([of, way, f"{steps}" + " or more" * (steps == 3), str(ratio.size), *found])
    return cells


def main() -> None:
    command = Command(__file__, __doc__, "one scene, three small levels")
    command.add_argument("--seed", type=int, default=SEED, help="of the drawn scenes")
    options = command.parse()
    rows = []
    for name, sections in scenes(options.seed):
        scene = rs.load_scene(
            sections,
            {"ensemble.until": {}, "ensemble.max_realizations": 6 if options.toy else MEMBERS},
        )
        folder = options.output / f"{options.seed} {name}"
        run = rs.run(scene, folder, numerics=ladder(scene, options.toy), workers=1, progress=False)
        rows += continuations(name, sections, run)
        print(f"{name}: {run.counts} members", flush=True)
        if options.toy:
            break
    cells = table(rows)
    print("\n".join(" | ".join(row) for row in cells))
    groups = {
        way: off_and_error([row for row in rows if row["way"] == way]) for way in WAYS.values()
    }
    off_over_error(groups, options.output / "cut_ladders.png")
    if options.evidence:
        command_line = "python experiments/cut_ladders.py --evidence"
        numbers = {}
        for of, suffix in {FLASH: "", BOUNDED: "_bounds"}.items():
            ratio = over_error([row for row in rows if row["of"] == of and row["way"] != UNKNOWN])
            found = {"count": ratio.size, "held": 100 * np.mean(ratio <= 1.0), "worst": ratio.max()}
            numbers |= {f"{name}{suffix}": value for name, value in found.items()}
        write_evidence("cut_ladders", command_line, tables={"held": cells}, numbers=numbers)


if __name__ == "__main__":
    main()
