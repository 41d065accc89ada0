"""Quantiles of the temperature over light contacts, whose cells have few hot spots: runs against many cells together.

    python experiments/few_spots.py [--toy] [-o FOLDER] [--runs N] [--cells N] [--evidence]

Nine scenes are drawn with a seed, two of them elastic; C(q) ends at the highest cut-off of their runs, and the pixel is
that of the reference, so that only scatter and bias are left. The reference puts the pixels of N cells together, each
with twice the sides of those of a run, and sorts them. "own" are the quantiles of each realization, averaged. Runs have
24 realizations, or 80, by turns; those in FOLDER are not computed again. An interval holds the reference if they are no
further apart than both errors (95 %, added as squares).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import inf, pi
from pathlib import Path
from typing import Any

import numpy as np
from figures.style import BLUE, ORANGE, legend_below, new_figure
from script import Command, Row, Rows, write_evidence

import roughsim as rs

SEED = 20270523  # drawn after the rule on unknown scatter was set
SCENES, PERIODS, CELL, SPEEDS = 9, 6, 2e-3, (0.5, 30.0)
SHARES = {"50": 0.5, "90": 0.9, "99": 0.99, "999": 0.999}
NAMES = [f"temperature_quantile_{of}{name}" for of in ("", "area_") for name in SHARES]
BLOCKS = 10  # of a reference, for its error
FRICTION, CONDUCTIVITY, DENSITY, HEAT = 0.1, 30.0, 7900.0, 500.0


def drawn() -> list[dict[str, Any]]:
    """Draw modulus, hardness, load, roll-off, slope and H."""
    rng = np.random.default_rng(SEED)
    scenes = []
    for number in range(SCENES):
        hardness = 1e9 * 4.0 ** rng.uniform()
        scenes.append(
            {
                "modulus": 1e11 * 2.0 ** rng.uniform(),
                "hardness": None if number >= SCENES - 2 else hardness,
                "pressure": hardness * 0.02 * 4.0 ** rng.uniform(),
                "plateau": 1.5 * 2.0 ** rng.uniform(),  # q_r/q_min
                "slope": 0.1 * 3.0 ** rng.uniform(),
                "hurst": rng.uniform(0.5, 0.9),
            }
        )
    return scenes


def sections_of(one: dict[str, Any], points: int) -> dict[str, Any]:
    """Return the sections of the scene of a run, with two levels up to the end of C(q)."""
    q_min, top = 2 * pi * PERIODS / CELL, 2 * pi * points / CELL / 4
    body = {
        "youngs_modulus": one["modulus"],
        "poisson_ratio": 0.3,
        "conductivity": CONDUCTIVITY,
        "density": DENSITY,
        "heat_capacity": HEAT,
    }
    return {
        "surface": {
            "rms_slope": one["slope"],
            "hurst": one["hurst"],
            "q_min": q_min,
            "q_roll_off": one["plateau"] * q_min,
            "roll_off_exponent": 0.0,
            "q_max": top,
        },
        "body": body | ({"penetration_hardness": one["hardness"]} if one["hardness"] else {}),
        "sliding": {
            "nominal_pressure": one["pressure"],
            "friction_coefficient": FRICTION,
            "speed": [*SPEEDS],
        },
        "observables": {"temperature_distribution": True},
        "numerics": {
            "lengths": [CELL, CELL],
            "tolerance": 1e-3,
            "levels": [
                {
                    "column": "capped" if one["hardness"] else "elastic",
                    "shape": [points // k, points // k],
                    "q_max": top / k,
                }
                for k in (2, 1)
            ],
        },
    }


def scene_of(one: dict[str, Any], points: int) -> rs.Scene:
    """Return the scene of a run."""
    return rs.load_scene(sections_of(one, points))


def reference(one: dict[str, Any], points: int, cells: int) -> Row:
    """Return quantiles of many cells together, K, and their errors, 95 %, by the scatter of blocks of cells."""
    spectrum = scene_of(one, points).spectrum
    grid = rs.Grid((2 * points, 2 * points), (2 * CELL, 2 * CELL))
    solid = rs.Solid(one["modulus"] / (1 - 0.3**2), one["hardness"] or inf)
    diffusivity = CONDUCTIVITY / DENSITY / HEAT
    source = rs.HeatSource([*SPEEDS], FRICTION, CONDUCTIVITY, diffusivity)
    fields: list[list[tuple[np.ndarray, ...]]] = [[] for _ in SPEEDS]
    for stream in np.random.SeedSequence(SEED + 1).spawn(cells):
        heights = rs.synthesize(spectrum, grid, np.random.default_rng(stream))
        contact = rs.solve_contact(
            heights, grid, solid, nominal_pressure=one["pressure"], tolerance=1e-3
        )
        flash = rs.measure(contact, grid, source).flash_temperature
        touching = contact.pressure > 0.0
        for k, speed in enumerate(SPEEDS):
            hot = rs.sliding_temperature(
                FRICTION * speed * contact.pressure,
                grid,
                speed=speed,
                conductivity=CONDUCTIVITY,
                diffusivity=diffusivity,
            )
            fields[k].append((hot[touching], contact.pressure[touching], flash[k]))
    row: Row = {}
    for k, speed in enumerate(SPEEDS):
        blocks = [fields[k][b::BLOCKS] for b in range(min(BLOCKS, cells))]
        whole = quantiles(fields[k])
        others = np.array(
            [
                quantiles([cell for other in blocks if other is not block for cell in other])
                for block in blocks
            ]
        )
        error = np.sqrt((len(blocks) - 1) * others.var(axis=0))  # jackknife
        for name, value, part in zip(NAMES, whole, error, strict=True):
            row[f"{speed:g} {name}"], row[f"{speed:g} {name} error"] = value, 2.3 * part
    return row


def quantiles(cells: list[tuple[np.ndarray, ...]]) -> np.ndarray:
    """Return quantiles of sorted pixels of cells, by heat and by area, at the mean T_flash over directions."""
    temperature, pressure = (np.concatenate([cell[k] for cell in cells]) for k in (0, 1))
    order = np.argsort(temperature)
    unit = np.mean([cell[2] for cell in cells]) / np.average(temperature, weights=pressure)
    found = []
    for weight in (pressure[order], np.ones(order.size)):
        place = np.cumsum(weight) / weight.sum()
        found += [temperature[order][np.searchsorted(place, share)] for share in SHARES.values()]
    return unit * np.array(found)


def run_of(scene: rs.Scene, seed: int, most: int, folder: Path) -> Row:
    """Return quantiles of a run, K, their errors by scatter and cell, and the means of those of each realization."""
    run = rs.run(scene, folder, seed=seed, until={}, max_realizations=most)
    low, high = run.samples()
    row: Row = {}
    for name in NAMES:
        found = run.estimate(name)
        own = low.numbers[name].mean(axis=0) * high.numbers[name].mean(axis=0)
        own /= high.below.numbers[name].mean(axis=0)
        for k, speed in enumerate(SPEEDS):
            row[f"{speed:g} {name}"] = float(found.mean[k])
            parts = [found.budget[part][k] for part in ("statistical", "size")]
            row[f"{speed:g} {name} error"] = float(np.linalg.norm(parts))
            row[f"{speed:g} {name} own"] = float(own[k])
    return row


def judged(rows: Rows, runs: int) -> dict[str, float]:
    """Print and return departures from the references in %, and how many intervals hold them."""
    numbers: dict[str, float] = {}
    for name in NAMES:
        bias, before, held, unknown = [], [], [], 0
        for place in range(SCENES):
            if str(place) not in rows["reference"]:
                continue
            exact = rows["reference"][str(place)]
            for seed in range(runs):
                found = rows["runs"][f"{place} {seed}"]
                for key in (f"{speed:g} {name}" for speed in SPEEDS):
                    value, truth, own = (
                        float(x) for x in (found[key], exact[key], found[f"{key} own"])
                    )
                    errors = [float(row[f"{key} error"]) for row in (found, exact)]
                    bias.append(100 * (value / truth - 1))
                    before.append(100 * (own / truth - 1))
                    if np.isnan(errors[0]):
                        unknown += 1
                    else:
                        held.append(abs(value - truth) <= np.hypot(*errors))
        print(
            f"{name:28s} own {np.mean(before):+6.1f} %, together {np.mean(bias):+6.1f} % (rms {np.std(bias):.1f}), "
            f"{sum(held)} of {len(held)} hold, {unknown} unknown"
        )
        short = name.removeprefix("temperature_quantile_")
        numbers |= {
            f"{short}_own": float(np.mean(before)),
            f"{short}_together": float(np.mean(bias)),
            f"{short}_held": int(sum(held)),
            f"{short}_known": len(held),
        }
    for key in ("held", "known"):
        numbers[key] = sum(number for name, number in numbers.items() if name.endswith(f"_{key}"))
    return numbers


def draw(rows: Rows, path: Path) -> None:
    """Departures of the 99 % quantile by heat of each run, beside those of its realizations."""
    with new_figure(path, 2.8) as figure:
        axes = figure.subplots()
        for key, colour, words in (
            ("", BLUE, "together"),
            (" own", ORANGE, "of each realization, averaged"),
        ):
            points = [
                (
                    int(name.split()[0]),
                    float(found[f"{SPEEDS[-1]:g} {NAMES[2]}{key}"])
                    / float(rows["reference"][name.split()[0]][f"{SPEEDS[-1]:g} {NAMES[2]}"]),
                )
                for name, found in rows["runs"].items()
            ]
            axes.plot(*np.transpose(points), "o", color=colour, label=words)
        axes.axhline(1.0, color="0.6", lw=0.8)
        axes.set(xlabel="scene", ylabel="99 % quantile / reference")
        legend_below(figure, [axes], 2)


def fill(
    rows: Rows,
    scenes: list[rs.Scene],
    runs: int,
    reference: Callable[[int], Row],
    run: Callable[[rs.Scene, int, str], Row],
) -> None:
    """Add the missing rows: the reference of each scene by its place, and runs by scene, seed and a name."""
    for place, scene in enumerate(scenes):
        rows.once("reference", str(place), partial(reference, place))
        for seed in range(runs):
            rows.once("runs", f"{place} {seed}", partial(run, scene, seed, f"{place}-{seed}"))


def main() -> None:
    command = Command(__file__, __doc__, "two runs of one scene, of 64² points")
    command.add_argument("--runs", type=int, default=6, help="runs of each scene")
    command.add_argument("--cells", type=int, default=200, help="cells of a reference")
    options = command.parse()
    points, most, runs, cells = (
        (64, (6, 6), 2, 6) if options.toy else (128, (24, 80), options.runs, options.cells)
    )
    rows = Rows(options.output / "few_spots.json", resume=not options.toy)
    scenes = drawn()[: 1 if options.toy else None]
    fill(
        rows,
        [scene_of(one, points) for one in scenes],
        runs,
        lambda place: reference(scenes[place], points, cells),
        lambda scene, seed, name: run_of(scene, seed, most[seed % 2], options.output / name),
    )
    numbers = judged(rows, runs)
    draw(rows, options.output / "few_spots.png")
    if options.evidence:
        write_evidence("few_spots", "python experiments/few_spots.py --evidence", numbers=numbers)


if __name__ == "__main__":
    main()
