"""Two rough steel faces that keep what has yielded while they slide: how the next encounter differs from a fresh one.

    python experiments/yielding_on_the_way.py [--toy] [-o FOLDER]

`roughsim.slide` forgets: each position meets fresh surfaces. Here the plastic displacement of each position
(`plastic_deformation`, as `follow_loads` adds it up) stays, half of it on each face, and travels with it. Printed and
drawn, over the slid distance and with memory over without: contact area, yielded area, and the flash temperature of the
contact as it stands (frozen, all heat in one body).
"""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from script import Command

import roughsim as rs
from roughsim.sliding.path import oblique_path

SCENE = rs.load_scene("steel-1.2GPa")
CELL, CUT_OFF, SPEEDS = 3.957912004522574e-3, 1e5, (1.0, 35.0)
COLOURS = {"contact area": "#0072B2", "yielded area": "#D55E00", "T_flash, 1 m/s": "0.6", "T_flash, 35 m/s": "#009E73"}


def march(points: int, distance: float, steps: int | None, seed: int, *, memory: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return the slid distances, m, and contact area, yielded area and T_flash at both speeds at each, (steps, 4)."""
    grid = rs.Grid((points, points), (CELL, CELL))
    spectrum = SCENE.spectrum.scaled(0.5).truncated(q_max=min(CUT_OFF, grid.nyquist / 2))
    streams = np.random.SeedSequence(seed).spawn(2)
    resting, moving = (rs.synthesize(spectrum, grid, np.random.default_rng(stream)) for stream in streams)
    solid = rs.Solid(SCENE.effective_modulus, SCENE.penetration_hardness)
    sliding = rs.Sliding(speeds=SPEEDS, friction_coefficient=0.11, conductivity=30.0, diffusivity=7.6e-6)
    path, contact, rows = oblique_path(grid, distance, steps), None, []
    for offset in path.offsets:
        composite = resting + np.roll(moving, -offset, axis=(0, 1))
        load = SCENE.sliding.nominal_pressure
        contact = rs.solve_contact(composite, grid, solid, nominal_pressure=load, tolerance=1e-4, start=contact)
        temperature = rs.measure(contact, grid, sliding).flash_temperature
        rows.append([contact.contact_fraction, contact.plastic_fraction, *temperature])
        if memory:
            half = 0.5 * rs.plastic_deformation(contact, composite, grid, solid).displacement
            resting = resting - half
            moving = moving - np.roll(half, offset, axis=(0, 1))
    return path.distance, np.array(rows)


def main() -> None:
    options = Command(__file__, __doc__, "a coarse grid and a short way").parse()
    points, steps, seeds = (64, 16, 1) if options.toy else (256, None, 3)  # None: a pixel each
    ratios = []
    for seed in range(seeds):
        distance, fresh = march(points, CELL, steps, seed, memory=False)
        _, kept = march(points, CELL, steps, seed, memory=True)
        # means over tenths of the way: single positions scatter
        tenth = np.minimum((10 * np.arange(len(distance))) // len(distance), 9)
        ratios.append([kept[tenth == k].mean(axis=0) / fresh[tenth == k].mean(axis=0) for k in range(10)])
    mean, spread = np.mean(ratios, axis=0), np.std(ratios, axis=0)
    way = [1e3 * distance[tenth == k].mean() for k in range(10)]
    print("with memory over without, means over tenths of a lap of the cell")
    for k in range(10):
        words = ", ".join(f"{name} {mean[k, i]:.3f} ± {spread[k, i]:.3f}" for i, name in enumerate(COLOURS))
        print(f"{way[k]:5.2f} mm: {words}")
    figure = Figure((6.0, 3.6), layout="constrained")
    axes = figure.subplots()
    for i, (name, colour) in enumerate(COLOURS.items()):
        axes.errorbar(way, mean[:, i], spread[:, i], fmt="o-", ms=4, color=colour, label=name, capsize=2)
    axes.axhline(1.0, color="0.7", lw=0.8)
    axes.set(xlabel="slid distance (mm)", ylabel="with memory / without", ylim=(0.0, None))
    axes.set_title("What has yielded stays: steel 1.2 GPa, both faces rough", fontsize=10, loc="left")
    axes.legend(frameon=False, fontsize=8)
    axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(options.output / "yielding_on_the_way.png", dpi=150)


if __name__ == "__main__":
    main()
