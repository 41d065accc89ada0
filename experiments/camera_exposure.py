"""The hottest track of two rough faces over the exposure, with the camera on the resting block.

    python experiments/camera_exposure.py [--toy] [-o FOLDER] [--evidence]

As experiments/camera.py, but step by step: two rough steels at 35 m/s, each contact solved. Both bodies have one
temperature at each point of the contact, so that no share is given. Stress inside the hole, and behind it, releases no
heat. A picture is the mean temperature of the moving face over the last steps, seen from the resting block.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from camera import (
    BEHIND,
    BODY,
    FRICTION,
    PRESSURE,
    SCENE,
    SIDES,
    SPEED,
    along_rim,
    face,
    hottest,
    mean_of,
    outside,
    places,
)
from figures.camera import MARGIN, MEASURED
from figures.style import BLUE, new_figure
from script import Command, Row, Rows, show_on_pages, write_evidence

import roughsim as rs
from roughsim import fourier
from roughsim.sliding.path import Path as Way
from roughsim.sliding.stepping import Motion, walk

STEP, SLID = 2, 6e-3  # pixels; m
EXPOSURES = (30e-6, 100e-6, 250e-6, 500e-6, 1e-3, 3e-3)  # m


def contacts(grid: rs.Grid, seed: int, steps: int) -> Iterator[SimpleNamespace]:
    """Yield the pressure that releases heat at each position, Pa."""
    resting, moving = (face(side, grid, seed, k) for k, side in enumerate(SCENE.sliding_faces))
    solid = rs.Solid(SCENE.effective_modulus, SCENE.penetration_hardness)
    before = outside(grid) * (places(grid)[0][:, None] > 0.0)
    load, contact = {"nominal_pressure": PRESSURE, "tolerance": 3e-3}, None
    for k in range(steps + 1):
        heights = resting + np.roll(moving, -k * STEP, axis=0)
        contact = rs.solve_contact(heights, grid, solid, start=contact, **load)
        yield SimpleNamespace(pressure=contact.pressure * before)


def tracks(grid: rs.Grid, seed: int) -> Row:
    """Return the hottest track 20 µm behind the rim, K, by exposure in µm."""
    step = STEP * grid.spacing[0]
    steps = round(SLID / step)
    counts = [max(1, round(exposure / step)) for exposure in EXPOSURES]
    offsets = np.outer(np.arange(steps + 1) * STEP, (1, 0))
    way, body = Way(offsets, np.arange(steps + 1) * step), rs.Body(**BODY)
    motion = Motion(SPEED, FRICTION, body, body)
    pictures = np.zeros((len(counts), *grid.shape))
    for k, position in enumerate(walk(contacts(grid, seed, steps), grid, way, [motion])):
        if k > steps - max(counts):
            field = fourier.inverse(position.temperatures[0], grid.shape)
            for number, count in enumerate(counts):
                if k > steps - count:
                    pictures[number] += field / count
    lines = (along_rim(picture, grid, BEHIND[1]) for picture in pictures)
    return {
        f"{1e6 * exposure:g}": hottest(line, grid.spacing[1])
        for exposure, line in zip(EXPOSURES, lines, strict=True)
    }


def draw(rows: list[Row], path: Path) -> None:
    """Draw the hottest track over the exposure, with its scatter between pictures."""
    means = [mean_of(rows, key) for key in rows[0]]
    mean, _, scatter = np.array(means).T
    with new_figure(path, 2.4) as figure:
        axes = figure.subplots()
        low, high = (1 - MARGIN) * MEASURED, (1 + MARGIN) * MEASURED
        axes.axhspan(low, high, color="0.88", lw=0)
        axes.text(50, MEASURED, "measured", va="center", fontsize=8.5)
        exposures = [float(key) for key in rows[0]]
        axes.errorbar(exposures, mean, scatter, fmt="o-", color=BLUE, capsize=2.5)
        axes.set(xscale="log", xlabel="slid during the exposure (µm)", ylabel="hottest track (K)")
        axes.set_xticks(exposures, [f"{x:g}" for x in exposures])
        axes.minorticks_off()
        axes.set(xlim=(23, 3900), ylim=(0, None))


def main() -> None:
    options = Command(__file__, __doc__).parse()
    points, pictures = (64, 2) if options.toy else (512, 6)
    grid = rs.Grid((3 * points // 2, points), SIDES)
    rows = Rows(options.output / f"exposed-{points}.json", resume=True)
    found = []
    for seed in range(pictures):
        row = rows.once("two", str(seed), lambda seed=seed: tracks(grid, seed))
        print(*(f"{key} µm: {value:.0f} K" for key, value in row.items()), sep="  ", flush=True)
        found.append(row)
    numbers = {}
    for key in found[0]:
        mean, error, scatter = mean_of(found, key)
        numbers |= {key: mean, f"{key}_error": error, f"{key}_scatter": 100 * scatter / mean}
    print(*(f"{name}: {value:.4g}" for name, value in numbers.items()), sep="\n")
    draw(found, options.output / "camera_exposure.png")
    if options.evidence:
        command = "python experiments/camera_exposure.py --evidence"
        write_evidence("camera_exposure", command, numbers=numbers)
        show_on_pages(options.output / "camera_exposure.png")


if __name__ == "__main__":
    main()
