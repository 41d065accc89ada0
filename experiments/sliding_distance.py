"""How well the theory continues slides that are followed once around their cell, on pairs drawn by chance.

    python experiments/sliding_distance.py [--draw] [--solve] [--toy] [-o FOLDER] [--evidence]

A run follows a slide over one length of its cell, and multiplies its numbers by those of `theory.two_bodies` at the
whole slid distance over those at that length (`roughsim.prediction.sliding_continuation`). The pairs are drawn as those
of experiments/two_bodies_points.py, but slide 1.5 to 16 lengths of the cell. The list was committed when the rule
was, and before any pair of it slid; `--draw` writes it again. `--solve` slides the pairs that have no row yet, four
members each, over the whole distance, and keeps the numbers at one length and at the end: T_flash over that of the
frozen contacts and the share of the heat, means over the last half, and the background of the moving body.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from math import sqrt
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter
from numpy.polynomial.legendre import leggauss
from reference.pairs import CELL, FAR, Pair, drawn, points, write
from script import Command, Row, Rows, write_evidence
from two_bodies_points import LAST, SPEEDS, slid

from roughsim.prediction.sliding import CONTINUED

LIST = Path(__file__).parent / "reference" / "sliding_distance_points.json"
SLIDES = LIST.with_name("sliding_distance_slides.json")
MEMBERS = 4
NUMBERS = ("ratio", "share", "background")
TITLES = {"ratio": "T_flash", "share": "share", "background": "background"}


def member(pair: Pair, points: int, index: int) -> np.ndarray:
    """Slide one pair of faces; return ln of the `NUMBERS` after one length of the cell and at the end.

    Shape (2, numbers, speeds).
    """
    slide = slid(pair, points, index)
    rows = []
    for end in (CELL, slide.slid_distance[-1]):
        last = int(np.argmin(np.abs(slide.slid_distance - end)))
        reached = slide.slid_distance[last]
        late = (slide.slid_distance > LAST * reached) & (slide.slid_distance <= reached)
        flash, frozen, share = (
            values[:, late].mean(axis=1)
            for values in (
                slide.flash_temperature,
                slide.frozen_flash_temperature,
                slide.moving_share,
            )
        )
        rows.append([flash / frozen, share, slide.background[:, last]])
    return np.log(rows)


def solve(pair: Pair, points: int, members: int) -> Row:
    """Slide all members of a pair; return ln of each number at the end over that after one length, and its error."""
    changes = [
        after - before
        for before, after in (member(pair, points, index) for index in range(members))
    ]
    mean = np.mean(changes, axis=0)
    error = (
        np.std(changes, axis=0, ddof=1) / sqrt(members)
        if members > 1
        else np.full(mean.shape, np.nan)
    )
    return {
        f"{speed} {name} {what}": float(values[i, k])
        for what, values in (("change", mean), ("error", error))
        for i, name in enumerate(NUMBERS)
        for k, speed in enumerate(SPEEDS)
    }


def expected(pair: Pair) -> np.ndarray:
    """Return ln of the numbers of the theory at the end over those after one length, shape (numbers, speeds)."""
    nodes, weights = leggauss(3)
    at = []
    for end in (CELL, pair.distance):
        late = pair.theory(end * (1 - (1 - LAST) * (1 - nodes) / 2)[:, None], np.array(pair.speeds))
        last = pair.theory(end)
        at.append(
            [weights @ late.flash_temperature / 2, weights @ late.moving_share / 2, last.background]
        )
    return np.log(at[1]) - np.log(at[0])


def errors(pairs: list[Pair], rows: dict[str, Row]) -> dict[str, np.ndarray]:
    """Return by number the errors of short slides, (pairs, speeds, 3): continued, as they are, and ± of both."""
    found = {name: np.empty((len(pairs), len(SPEEDS), 3)) for name in NUMBERS}
    for n, pair in enumerate(pairs):
        theory = expected(pair)
        for i, name in enumerate(NUMBERS):
            for k, speed in enumerate(SPEEDS):
                change, error = (
                    float(rows[pair.name][f"{speed} {name} {what}"]) for what in ("change", "error")
                )
                found[name][n, k] = np.expm1(theory[i, k] - change), np.expm1(-change), error
    return found


def table(pairs: list[Pair], found: dict[str, np.ndarray]) -> None:
    """Print how the continued slides differ from those that were followed, and from not continuing."""
    print(
        "slides continued by the theory over slides followed to the end, in %; ± standard error; (not continued)"
    )
    for n, pair in enumerate(pairs):
        for k, speed in enumerate(pair.speeds):
            values = {name: 100 * found[name][n, k] for name in NUMBERS}
            texts = [
                f"{TITLES[name]} {x[0]:+5.2f} ± {x[2]:.2f} ({x[1]:+.1f})"
                for name, x in values.items()
            ]
            print(
                f"{pair.name} f {pair.part:4.2f} {1e3 * pair.distance:5.1f} mm {speed:6.3g} m/s",
                "; ".join(texts),
            )
    for name, (rms, worst, plain) in summary(found).items():
        print(
            f"{TITLES[name]}: continued rms {rms:.2f} %, worst {worst:.2f} %; not continued, worst {plain:.1f} %"
        )


def summary(found: dict[str, np.ndarray]) -> dict[str, tuple[float, float, float]]:
    """Return by number the rms and the largest error of continued slides, and the largest without theory, in %."""
    result = {}
    for name, values in found.items():
        continued, plain = 100 * values[..., 0], 100 * values[..., 1]
        result[name] = (
            float(np.sqrt(np.mean(continued**2))),
            float(np.abs(continued).max()),
            float(np.abs(plain).max()),
        )
    return result


def draw(pairs: list[Pair], found: dict[str, np.ndarray], path: Path) -> None:
    """Draw T_flash of short slides, continued and as it is, over that of whole ones, by the slid distance."""
    figure = Figure(figsize=(6.0, 3.2), layout="constrained")
    axes = figure.subplots()
    lengths = [pair.distance / CELL for pair in pairs]
    for k, marker in enumerate("o^"):
        continued, plain, error = found["ratio"][:, k].T
        axes.plot(
            lengths, 100 * plain, marker, mfc="none", color="0.5", label=f"as it is, {SPEEDS[k]}"
        )
        axes.errorbar(
            lengths,
            100 * continued,
            200 * error,
            fmt=marker,
            color="#0072b2",
            label=f"continued, {SPEEDS[k]}",
        )
    axes.axhspan(-100 * CONTINUED, 100 * CONTINUED, color="0.9", zorder=0)
    axes.set(
        xscale="log",
        xlabel="slid distance (lengths of the cell)",
        ylabel=r"error of $T_\mathrm{flash}$ (%)",
    )
    axes.set_xticks([2, 4, 8, 16], ["2", "4", "8", "16"])
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, fontsize=8)
    figure.savefig(path, dpi=130)


def main() -> None:
    command = Command(__file__, __doc__, "slide one elastic pair on a small grid")
    command.add_argument("--draw", action="store_true", help="write the list of pairs again")
    command.add_argument(
        "--solve", action="store_true", help="slide the pairs that have no row yet"
    )
    options = command.parse()
    if options.draw:
        write(drawn([FAR]), LIST)
    pairs, rows = (
        points(LIST),
        Rows(options.output / "slid.json" if options.toy else SLIDES, resume=not options.toy),
    )
    if options.toy:
        pairs = [replace(next(pair for pair in pairs if pair.kind == "E"), distance=1.5 * CELL)]
    if options.toy or options.solve:
        for pair in sorted(pairs, key=lambda pair: pair.distance):
            size, members = (64, 1) if options.toy else (FAR.points, MEMBERS)
            rows.once("slides", pair.name, partial(solve, pair, size, members))
            print(f"{pair.name} slid", flush=True)
    whole = [pair for pair in pairs if pair.name in rows["slides"]]
    if not whole:
        print("no pair has slid yet: --solve slides them")
        return
    found = errors(whole, rows["slides"])
    table(whole, found)
    draw(whole, found, options.output / "sliding_distance.png")
    if options.evidence:
        numbers = {
            f"{name}_{what}": value
            for name, values in summary(found).items()
            for what, value in zip(("rms", "worst", "without"), values, strict=True)
        }
        command_line = "python experiments/sliding_distance.py --evidence"
        write_evidence("sliding_distance", command_line, numbers=numbers | {"pairs": len(whole)})


if __name__ == "__main__":
    main()
