"""Two rough steel faces that keep what has yielded while they slide: how the next encounter differs from a fresh one.

    python experiments/sliding_yielding.py [--toy] [-o FOLDER] [--evidence]

`roughsim.slide` forgets: each position meets fresh surfaces. Here the plastic displacement of each position
(`plastic_deformation`, as `follow_loads` adds it up) stays, half of it on each face, and travels with it. Printed and
drawn, over the slid distance and with memory over without: contact area, yielded area, and the flash temperature twice:
of the contact as it stands (frozen, all heat in one body), and of the slide with both bodies in motion, which share the
heat at every point.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path as FilePath

import numpy as np
from matplotlib.figure import Figure
from script import Command, write_evidence

import roughsim as rs
from roughsim.sliding.history import SlideHistory, follow
from roughsim.sliding.path import Path, oblique_path
from roughsim.sliding.stepping import Motion

SCENE = rs.load_scene("steel-1.2GPa")
STEEL = rs.Body(conductivity=30.0, diffusivity=30.0 / (7900.0 * 500.0))
CELL, CUT_OFF, SPEEDS, LAPS = 3.957912004522574e-3, 1e5, (1.0, 5.0, 35.0), 4
FRICTION = 0.11
COLOURS = {"contact area": "#0072B2", "yielded area": "#D55E00"}
COLOURS |= {
    f"frozen T_flash, {v:g} m/s": colour
    for v, colour in zip(SPEEDS, ("0.85", "0.7", "0.5"), strict=True)
}
COLOURS |= {
    f"T_flash, {v:g} m/s": c for v, c in zip(SPEEDS, ("#35b779", "#31688e", "#440154"), strict=True)
}


def contacts(grid: rs.Grid, path: Path, seed: int, *, memory: bool) -> Iterator[rs.Contact]:
    """Yield the contact at each position, the faces with or without what has yielded at those before."""
    spectrum = SCENE.spectrum.scaled(0.5).truncated(q_max=min(CUT_OFF, grid.nyquist / 2))
    streams = np.random.SeedSequence(seed).spawn(2)
    resting, moving = (
        rs.synthesize(spectrum, grid, np.random.default_rng(stream)) for stream in streams
    )
    solid = rs.Solid(SCENE.effective_modulus, SCENE.penetration_hardness)
    load, contact = SCENE.sliding.nominal_pressure, None
    for offset in path.offsets:
        composite = resting + np.roll(moving, -offset, axis=(0, 1))
        contact = rs.solve_contact(
            composite, grid, solid, nominal_pressure=load, tolerance=1e-4, start=contact
        )
        yield contact
        if memory:
            half = 0.5 * rs.plastic_deformation(contact, composite, grid, solid).displacement
            resting = resting - half
            moving = moving - np.roll(half, offset, axis=(0, 1))


def slide(
    points: int, distance: float, steps: int | None, seed: int, *, memory: bool
) -> SlideHistory:
    """Slide one face over the other, with or without memory of what has yielded."""
    grid = rs.Grid((points, points), (CELL, CELL))
    path = oblique_path(grid, distance, steps)
    motions = [Motion(v, FRICTION, STEEL, STEEL) for v in SPEEDS]
    return follow(contacts(grid, path, seed, memory=memory), grid, path, motions)


def rows_of(history: SlideHistory) -> np.ndarray:
    """Return the numbers of `COLOURS` at each step, (steps, numbers)."""
    fractions = history.curves["contact_fraction"], history.curves["plastic_fraction"]
    return np.stack(
        [
            *fractions,
            *history.curves["frozen_flash_temperature"],
            *history.curves["flash_temperature"],
        ],
        axis=1,
    )


def main() -> None:
    options = Command(__file__, __doc__, "a coarse grid and a short way").parse()
    points, laps, steps, seeds = (
        (64, 1, 16, 1) if options.toy else (256, LAPS, None, 2)
    )  # None: a pixel each
    ratios, parts = [], 5 * laps
    for seed in range(seeds):
        fresh, kept = (
            slide(points, laps * CELL, steps, seed, memory=memory) for memory in (False, True)
        )
        distance = fresh.curves["slid_distance"]
        # means over fifths of a lap: single positions scatter
        part = (parts * np.arange(len(distance))) // len(distance)
        means = [
            [rows_of(history)[part == k].mean(axis=0) for k in range(parts)]
            for history in (fresh, kept)
        ]
        ratios.append(np.array(means[1]) / np.array(means[0]))
    mean, spread = np.mean(ratios, axis=0), np.std(ratios, axis=0)
    way = [1e3 * distance[part == k].mean() for k in range(parts)]
    print("with memory over without, means over fifths of a lap of the cell")
    for k in range(parts):
        words = ", ".join(
            f"{name} {mean[k, i]:.3f} ± {spread[k, i]:.3f}" for i, name in enumerate(COLOURS)
        )
        print(f"{way[k]:5.2f} mm: {words}")
    draw(way, mean, spread, options.output / "sliding_yielding.png")
    if options.evidence:
        rows = [
            {"way": w, "mean": m, "spread": s}
            for w, m, s in zip(way, mean.tolist(), spread.tolist(), strict=True)
        ]
        command = "python experiments/sliding_yielding.py --evidence"
        write_evidence("sliding_yielding", command, rows=rows, numbers=quoted(way, mean))


def quoted(way: list[float], mean: np.ndarray) -> dict[str, float]:
    """Return the numbers of docs/sliding.md: the slid distance, mm, and its last numbers over those without memory."""
    last = dict(zip(COLOURS, mean[-1].tolist(), strict=True))
    numbers = {
        "distance": way[-1],
        "contact": last["contact area"],
        "yielded": last["yielded area"],
    }
    numbers |= {f"flash_{v:g}": last[f"T_flash, {v:g} m/s"] for v in SPEEDS}
    fastest = mean[:, list(COLOURS).index(f"T_flash, {SPEEDS[-1]:g} m/s")]
    return numbers | {"fastest_off": 100 * np.abs(fastest - 1.0).max()}


def draw(way: list[float], mean: np.ndarray, spread: np.ndarray, path: FilePath) -> None:
    figure = Figure((7.0, 3.6), layout="constrained")
    axes = figure.subplots()
    for i, (name, colour) in enumerate(COLOURS.items()):
        axes.errorbar(
            way, mean[:, i], spread[:, i], fmt="o-", ms=4, color=colour, label=name, capsize=2
        )
    axes.axhline(1.0, color="0.7", lw=0.8)
    axes.set(xlabel="slid distance (mm)", ylabel="with memory / without", ylim=(0.0, None))
    axes.set_title(
        "What has yielded stays: steel 1.2 GPa, both faces rough", fontsize=10, loc="left"
    )
    axes.legend(frameon=False, fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))
    axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=150)


if __name__ == "__main__":
    main()
