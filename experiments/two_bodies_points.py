"""Fresh pairs of rough bodies, drawn by chance, to test the theory of `theory.two_bodies` against slides.

    python experiments/two_bodies_points.py [--draw] [--solve] [--toy] [-o FOLDER] [--evidence]

The last part of the list was drawn when the theory had its form, and committed before any pair of it was slid; the
others were seen while the form was chosen. `--draw` writes it again. reference/pairs.py says what the pairs are; E* is
110 GPa.

`--solve` slides what is not there yet, into reference/two_bodies_slides.json: a cell of 4 mm with the longest waves
four times a side, and 256² points; 144² and 160² in the later parts, where C(q) ends sooner. Cells of 8 and 16 mm give
the same. The last two parts, to nearly full contact and of both bodies, have 96² points: 4 or 6 pixels per shortest
wave; 3 of A and of long ways in the first of them. Members are added, 2 to 12, until the standard error of T_flash is
0.8 % or they have taken 1000 steps. Means over the last half of the slid distance are compared with the theory at those
very distances, for C(q) up to the q_max of the slide. The error of the pixel goes with its power 1 to 1.5: one slide
with half the pixel, in the last list over one cell at most, shows it, and ln of the ratio is extrapolated with the mean
of both powers.
"""

from __future__ import annotations

import time
from dataclasses import replace
from functools import partial
from math import exp, inf, sqrt
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from reference.pairs import (
    CELL,
    DENSE,
    FIRST,
    FRESH,
    LATER,
    MODULUS,
    PARTS,
    SECOND,
    Pair,
    drawn,
    points,
    write,
)
from script import Command, Row, Rows, write_evidence

import roughsim as rs
from roughsim.estimate.sliding import ORDERS
from roughsim.sliding.path import oblique_path

LIST = Path(__file__).parent / "reference" / "two_bodies_points.json"
SLIDES = LIST.with_name("two_bodies_slides.json")
SPEEDS = ("slow", "fast")
BODIES = {"": "flash_temperature", " resting": "resting_flash_temperature"}  # the latter later
NAMES = tuple(f"{speed}{body}" for body in BODIES for speed in SPEEDS)
MEMBERS, ENOUGH, STEPS = (
    (2, 12),
    0.008,
    1000,
)  # standard error, and steps of all members, at which there are enough
GOLDEN = (sqrt(5) - 1) / 2
STATED = 0.06  # error of T_flash
LAST = 0.5  # share of the slid distance over which means are taken
COLOURS = {"A": "#0072b2", "B": "#d55e00", "E": "#009e73"}


def late(pair: Pair, points: int) -> np.ndarray:
    """Return the distances of the steps in the last half of the way, m."""
    distance = oblique_path(rs.Grid((points, points), (CELL, CELL)), pair.distance).distance
    return distance[distance > LAST * distance[-1]]


def expected(pair: Pair, points: int) -> np.ndarray:
    """Return T_flash in theory at the steps of a slide, mean over the last half, K, by `NAMES`."""
    distances = late(pair, points)
    few = np.unique(np.linspace(0, distances.size - 1, 8).round().astype(int))  # it varies smoothly
    theory = pair.theory(distances[few], np.array(pair.speeds)[:, None])
    return np.array(
        [
            np.interp(distances, distances[few], row).mean()
            for name in BODIES.values()
            for row in getattr(theory, name)
        ]
    )


def slid(pair: Pair, points: int, member: int) -> rs.Slide:
    """Slide one pair of faces."""
    grid = rs.Grid((points, points), (CELL, CELL))
    streams = np.random.SeedSequence(
        pair.drawn.seed, spawn_key=(ord(pair.kind), int(pair.name[1:]), member)
    ).spawn(2)
    one, two = (
        rs.synthesize(pair.spectrum, grid, np.random.default_rng(stream)) for stream in streams
    )
    return rs.slide(
        sqrt(1 - pair.part) * one,
        grid,
        rs.Solid(MODULUS, inf if pair.hardness is None else pair.hardness),
        nominal_pressure=pair.pressure,
        friction_coefficient=0.1,
        speed=pair.speeds,
        moving=rs.Body(*pair.moving),
        resting=rs.Body(*pair.resting),
        counter_heights=sqrt(pair.part) * two if pair.part else None,
        slid_distance=pair.distance,
    )


def slide(pair: Pair, points: int, member: int) -> np.ndarray:
    """Slide one pair of faces; return T_flash, mean over the last half of the distance, K, by `NAMES`."""
    found, last = slid(pair, points, member), -late(pair, points).size
    return np.concatenate([getattr(found, name)[:, last:].mean(axis=1) for name in BODIES.values()])


def solve(pair: Pair, members: tuple[int, int], points: int | None = None) -> Row:
    """Slide the pair, with members until their scatter is small enough."""
    start = time.process_time()
    points = points or pair.drawn.points
    rows: list[np.ndarray] = []
    while len(rows) < members[1]:
        rows.append(np.log(slide(pair, points, len(rows))))
        error = np.std(rows, axis=0, ddof=1) / sqrt(len(rows)) if len(rows) > 1 else np.full(4, inf)
        walked = len(rows) * pair.distance / CELL * points
        if len(rows) >= members[0] and (error.max() < ENOUGH or walked > STEPS):
            break
    row: Row = {
        "points": float(points),
        "members": float(len(rows)),
        "seconds": time.process_time() - start,
    }
    mean = np.exp(np.mean(rows, axis=0))
    for k, name in enumerate(NAMES):
        row |= {f"{name} flash": mean[k], f"{name} error": error[k]}
    return row


def refine(pair: Pair, points: int | None = None) -> Row:
    """Slide the first member with the pixel and with half of it; return by how much ln T_flash then changes.

    Both are read at slightly different distances, within one cell. What the theory says of that is taken out.
    """
    points = points or pair.drawn.points
    pair = replace(pair, distance=min(pair.distance, CELL))
    coarse, fine = (np.log(slide(pair, n, 0) / expected(pair, n)) for n in (points, 2 * points))
    change = fine - coarse
    return dict(zip(NAMES, change.tolist(), strict=True))


def compared(pair: Pair, row: Row, change: Row) -> dict[str, np.ndarray]:
    """Return ln of slide over theory by `NAMES`, corrected for the pixel and not, and the standard error."""
    names = [name for name in NAMES if f"{name} flash" in row]
    theory = expected(pair, int(row["points"]))[: len(names)]
    raw = np.log([float(row[f"{name} flash"]) for name in names]) - np.log(theory)
    beyond = 1 + np.mean([1 / (2**order - 1) for order in ORDERS])
    return {
        "corrected": raw + beyond * np.array([float(change[name]) for name in names]),
        "as it is": raw,
        "error": np.array([float(row[f"{name} error"]) for name in names]),
    }


def table(found: dict[Pair, dict[str, np.ndarray]]) -> None:
    """Print how the theory compares with each slide, and with all."""
    print(
        "slide over theory of the same modes, ln in %; ± standard error of the slide; in brackets as it is"
    )
    for pair, values in found.items():
        texts = []
        columns = (100 * values[key] for key in ("corrected", "as it is", "error"))
        for speed, corrected, raw, error in zip(2 * pair.speeds, *columns, strict=False):
            texts.append(f"{speed:6.3g} m/s {corrected:+5.1f} ± {error:.1f} ({raw:+5.1f})")
        print(f"{pair.name} f {pair.part:4.2f} {1e3 * pair.distance:6.2f} mm  " + "   ".join(texts))
    chosen: dict[str, list[Pair]] = {}
    for name, several in PARTS.items():
        pairs = [pair for pair in found if pair.drawn is several]
        chosen |= {
            f"{name}, {kind}": [pair for pair in pairs if pair.kind == kind]
            for kind in several.numbers
        }
        for low, high in ((0.1, 1.0), (1.0, 16.0)):
            chosen[f"{name}, {low:g} … {high:g} mm"] = [
                pair for pair in pairs if low <= 1e3 * pair.distance < high
            ]
        chosen[f"{name}, one face smooth"] = [pair for pair in pairs if pair.part in (0.0, 1.0)]
        chosen[f"{name}, both faces rough"] = [pair for pair in pairs if 0.0 < pair.part < 1.0]
        chosen[name] = pairs
    for title, pairs in {**chosen, "all": list(found)}.items():
        texts = []
        for key in ("corrected", "as it is") if pairs else ():
            values = np.concatenate([found[pair][key] for pair in pairs])
            worst = values[np.abs(values).argmax()]
            texts.append(
                f"{key} rms {np.sqrt(np.mean(values**2)):.3f} worst {worst:+.3f} mean {values.mean():+.3f}"
            )
        print(f"{title}, {len(pairs)} pairs: " + "; ".join(texts))


def of_page(found: dict[Pair, dict[str, np.ndarray]]) -> dict[str, float]:
    """Return numbers of docs/sliding.md: T_flash of the theory over that of slides, rms, least and most, %."""
    numbers: dict[str, float] = {}
    off_of = {
        name: -np.concatenate(
            [values["corrected"] for pair, values in found.items() if pair.drawn in parts]
        )
        for name, parts in (
            ("seen", (FIRST, SECOND, FRESH)),
            ("dense", (DENSE,)),
            ("later", (LATER,)),
        )
    }
    for name, logs in off_of.items():
        off, rms = 100 * np.expm1(logs), 100 * np.sqrt(np.mean(logs**2))
        numbers |= {f"{name}_temperatures": logs.size, f"{name}_rms": rms}
        numbers |= {f"{name}_least": off.min(), f"{name}_most": off.max()}
    both = np.concatenate([off_of["dense"], off_of["later"]])
    numbers["within"] = 100 * np.mean(np.abs(np.expm1(both)) <= STATED)
    return numbers


def draw(found: dict[Pair, dict[str, np.ndarray]], path: Path) -> None:
    """Slide over theory, by the slid distance."""
    figure = Figure(figsize=(6.0, 3.2), layout="constrained")
    axes = figure.subplots()
    for pair, values in found.items():
        for k, marker in enumerate("o^sD"[: values["error"].size]):
            ratio, error = exp(values["corrected"][k]), 2 * values["error"][k]
            axes.errorbar(
                1e3 * pair.distance, ratio, error, fmt=marker, ms=4, color=COLOURS[pair.kind]
            )
    axes.axhline(1.0, color="0.6", lw=0.7)
    axes.axhspan(1 - STATED, 1 + STATED, color="0.9", zorder=0)
    axes.set(
        xscale="log", xlabel="slid distance (mm)", ylabel=r"$T_\mathrm{flash}$, slide / theory"
    )
    axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=130)


def main() -> None:
    command = Command(__file__, __doc__, "slide one elastic pair on a small grid over a short way")
    command.add_argument("--draw", action="store_true", help="write the list of pairs again")
    command.add_argument(
        "--solve", action="store_true", help="slide the pairs that have no row yet"
    )
    options = command.parse()
    if options.draw:
        write(drawn(PARTS.values()), LIST)
    pairs, rows = (
        points(LIST),
        Rows(options.output / "slid.json" if options.toy else SLIDES, resume=not options.toy),
    )
    if options.toy:
        pairs = [replace(next(pair for pair in pairs if pair.name == "E01"), distance=4e-4)]
    if options.toy or options.solve:
        # distances evenly, however many pairs there is time for
        ranks = {
            pair.name: rank
            for rank, pair in enumerate(sorted(pairs, key=lambda pair: pair.distance))
        }
        for pair in sorted(pairs, key=lambda pair: GOLDEN * ranks[pair.name] % 1.0):
            number = 64 if options.toy else None
            rows.once(
                "slides",
                pair.name,
                partial(solve, pair, (2, 2) if options.toy else MEMBERS, number),
            )
            rows.once("half the pixel", pair.name, partial(refine, pair, number))
            print(f"{pair.name} slid", flush=True)
    slides, finer = rows["slides"], rows["half the pixel"]
    found = {
        pair: compared(pair, slides[pair.name], finer[pair.name])
        for pair in pairs
        if pair.name in finer
    }
    table(found)
    draw(found, options.output / "two_bodies_points.png")
    if options.evidence:
        command_line = "python experiments/two_bodies_points.py --evidence"
        write_evidence("two_bodies_points", command_line, numbers=of_page(found))


if __name__ == "__main__":
    main()
