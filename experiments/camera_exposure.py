"""The hottest track of two rough faces over the exposure, with the camera on the resting block.

    python experiments/camera_exposure.py [--toy] [-o FOLDER] [--evidence]

As experiments/camera.py, whose long exposure this ends in: two rough steels at 35 m/s, share ½, a hole in the heat of
the resting one. The moving face slides by two pixels a step, and each contact is solved. Heat that was released at a
distance a before the end of the picture has left the temperature E(a + step) − E(a), with E of a source that has been
there since; with an exposure over m steps it is the mean of m such pictures, (E(a + step) − E(a + step − m steps))/m.
Heat older than 3 mm is left out.
"""

from __future__ import annotations

from math import ceil
from pathlib import Path

import numpy as np
from camera import (
    BEHIND,
    BODY,
    FRICTION,
    PRESSURE,
    SCENE,
    SHARE,
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

STEP, REACH = 2, 3e-3  # pixels; m
EXPOSURES = (30e-6, 100e-6, 250e-6, 500e-6, 1e-3)  # m


def tracks(grid: rs.Grid, seed: int, exposures: tuple[float, ...]) -> Row:
    """Return the hottest track 20 µm behind the rim, K, by exposure in µm."""
    step = STEP * grid.spacing[0]
    counts = [max(1, round(exposure / step)) for exposure in exposures]
    resting, moving = (face(side, grid, seed, k) for k, side in enumerate(SCENE.sliding_faces))
    solid = rs.Solid(SCENE.effective_modulus, SCENE.penetration_hardness)
    before = outside(grid) * (places(grid)[0][:, None] > 0.0)  # heat of the far side wraps around
    fields, contact = np.zeros((len(counts), *grid.shape)), None
    for k in range(ceil(REACH / step) + max(counts)):  # steps before the end of the picture
        heights = resting + np.roll(moving, k * STEP, axis=0)
        contact = rs.solve_contact(
            heights, grid, solid, nominal_pressure=PRESSURE, tolerance=3e-3, start=contact
        )
        flux = SHARE["two"] * FRICTION * SPEED * contact.pressure * before
        ends = np.array([k + 1, *(max(k + 1 - m, 0) for m in counts)]) * step / SPEED
        since, *left = rs.sliding_temperature(flux, grid, speed=SPEED, time=ends, **BODY)
        fields += [(since - rest) / m for rest, m in zip(left, counts, strict=True)]
    lines = (along_rim(field, grid, BEHIND[1]) for field in fields)
    return {
        f"{1e6 * exposure:g}": hottest(line, grid.spacing[1])
        for exposure, line in zip(exposures, lines, strict=True)
    }


def draw(rows: list[Row], path: Path) -> None:
    """Draw the hottest track over the exposure, with its scatter between pictures."""
    means = [mean_of(rows, key) for key in rows[0]]
    mean, _, scatter = np.array(means).T
    with new_figure(path, 2.4) as figure:
        axes = figure.subplots()
        low, high = (1 - MARGIN) * MEASURED, (1 + MARGIN) * MEASURED
        axes.axhspan(low, high, color="0.88", lw=0)
        axes.text(130, MEASURED, "measured", va="center", fontsize=8.5)
        exposures = [float(key) for key in rows[0]]
        axes.errorbar(exposures, mean, scatter, fmt="o-", color=BLUE, capsize=2.5)
        axes.set(xscale="log", xlabel="slid during the exposure (µm)", ylabel="hottest track (K)")
        axes.set_xticks(exposures, [f"{x:g}" for x in exposures])
        axes.minorticks_off()
        axes.set(xlim=(23, 1300), ylim=(0, None))


def main() -> None:
    options = Command(__file__, __doc__).parse()
    points, pictures = (64, 2) if options.toy else (512, 6)
    grid = rs.Grid((3 * points // 2, points), SIDES)
    rows = Rows(options.output / f"exposures-{points}.json", resume=True)
    found = []
    for seed in range(pictures):
        row = rows.once("two", str(seed), lambda seed=seed: tracks(grid, seed, EXPOSURES))
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
