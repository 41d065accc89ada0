"""Whether the error of a map that is pressed itself holds: maps of known C(q), pressed one by one.

    python experiments/pressed_maps.py [--toy] [-o FOLDER] [--evidence]

Periodic maps are drawn with Gaussian amplitudes and pressed as they are (tile), or with their mirror images as if they
were not known to be periodic. Other maps are cut out of surfaces of twice their side, and pressed with their mirror
images. All have 2 or 4 of their longest waves per side. The mean over many maps is that of 24 surfaces of 8 waves per
side, drawn from the same C(q), at the same cut-offs and pixels. "inside" counts the maps whose total error, 95 %, holds
this mean. The same command goes on after a stop.
"""

from __future__ import annotations

import warnings
from dataclasses import replace
from math import pi

import numpy as np
from matplotlib.figure import Figure
from script import Command, write_evidence

import roughsim as rs

POINTS, PIXEL = 128, 4e-6  # of a map; m
NAMES = ("flash_temperature", "contact_fraction", "pressure_variance")
SPEEDS = (0.01, 35.0)  # m/s
CONTACTS = {"elastic": 0.0, "capped": 3e9}  # hardness, Pa; 0: none
KINDS = {
    "periodic": (1, "tile"),
    "mirrored": (1, "mirror"),
    "cut out": (2, "mirror"),
}  # drawn so much wider, and edges
STEEL = {
    "youngs_modulus": 2.1e11,
    "poisson_ratio": 0.3,
    "conductivity": 30,
    "density": 7900,
    "heat_capacity": 500,
}


def scene_of(surface, hardness, seeds=1, seed=7000):
    """Return a scene of steel that slides on a smooth one; of a map the seed draws the twin."""
    body = STEEL | ({"penetration_hardness": hardness} if hardness else {})
    sliding = {"nominal_pressure": 6e7, "speed": list(SPEEDS), "friction_coefficient": 0.2}
    ensemble = {"max_realizations": seeds, "seed": seed}
    return {
        "surface": surface,
        "body": body,
        "counterface": STEEL,
        "sliding": sliding,
        "ensemble": ensemble,
    }


def face_of(waves, points):
    """Return the C(q) of maps with so many longest waves and so many points per side, four points per shortest wave."""
    q_min = 2 * pi * waves / (points * PIXEL)
    return {"rms_height": 1.2e-6 / waves, "hurst": 0.8, "q_min": q_min, "q_max": 0.5 * pi / PIXEL}


def mean_of_many(face, hardness, pressed, times, seeds):
    """Return means over surfaces so many times as wide as the map of a run, drawn from C(q), at its levels."""
    levels = (
        tuple(  # a map is pressed with all waves of its pixels, of which C(q) has those up to q_max
            replace(
                level,
                shape=tuple(times * n for n in level.shape),
                q_max=min(level.q_max, face["q_max"]),
                first=None,
            )
            for level in pressed.numerics.levels
            if level.column != "quadrants"
        )
    )
    lengths = tuple(times * length for length in pressed.numerics.lengths)
    scene = rs.load_scene(scene_of(face, hardness, seeds))
    scene = replace(scene, numerics=replace(scene.numerics, levels=levels, lengths=lengths))
    run = rs.run(scene, pressed.folder.with_name(f"{pressed.folder.name}-mean"), workers=1)
    return {name: run.estimate(name).mean for name in NAMES}


def pressed(folder, face, hardness, kind, points, seed):
    """Return the run of one map, pressed in a folder or found there."""
    larger, edges = KINDS[kind]
    side = larger * points
    grid = rs.Grid((side, side), (side * PIXEL, side * PIXEL))
    spectrum = rs.load_scene(scene_of(face, hardness)).spectrum
    heights = rs.synthesize(spectrum, grid, np.random.default_rng(seed), amplitudes="gaussian")
    path = folder.parent / "map.npy"
    np.save(path, heights[:points, :points])
    surface = {
        "topography": str(path.resolve()),
        "topography_size": points * PIXEL,
        "topography_unit": "m",
    }
    return rs.press(scene_of(surface, hardness, seed=seed), folder, edges=edges)


def judged(runs, truth):
    """Print how far maps are from the mean over many, and how often their errors hold; return the counts of T_flash."""
    held = []
    for name in NAMES:
        estimates = [run.estimate(name) for run in runs]
        means = np.array([estimate.mean for estimate in estimates])
        errors = np.array([estimate.total_error for estimate in estimates])
        off, inside = means / truth[name] - 1.0, (np.abs(means - truth[name]) <= errors).sum(axis=0)
        for k, speed in enumerate(
            [f" at {v:g} m/s" for v in SPEEDS] if len(truth[name]) == len(SPEEDS) else [""]
        ):
            print(
                f"    {name}{speed}: off by {100 * off[:, k].mean():+.1f} ± {100 * off[:, k].std():.1f} %, "
                f"stated {100 * np.median((errors / means)[:, k]):.0f} %, inside {inside[k]} of {len(runs)}",
                flush=True,
            )
        if name == "flash_temperature":
            held = inside.tolist()
    return held


def main():
    """Print how often the stated errors hold, and draw T_flash of the maps."""
    options = Command(__file__, __doc__, "two maps of each kind").parse()
    count, points, seeds = (2, 64, 4) if options.toy else (24, POINTS, 24)
    warnings.filterwarnings(
        "ignore", message="q_min = ", category=RuntimeWarning
    )  # C(q) goes on beyond a map
    figure = Figure((6.0, 3.2), layout="constrained")
    axes, labels, rows = figure.subplots(), [], []
    for contact, hardness in CONTACTS.items():
        for waves in (2, 4):
            face, truth, tiled = face_of(waves, points), {}, np.array([])
            for kind in KINDS:
                stem = f"{contact}-{waves}-{kind.replace(' ', '-')}-{points}"
                runs = [
                    pressed(options.output / f"{stem}-{seed}", face, hardness, kind, points, seed)
                    for seed in range(100, 100 + count)
                ]
                truth = truth or mean_of_many(face, hardness, runs[0], 8 // waves, seeds)
                print(f"{contact}, {waves} longest waves a side, {kind}:")
                row = {
                    "contact": contact,
                    "waves": waves,
                    "kind": kind,
                    "maps": count,
                    "inside": judged(runs, truth),
                }
                flash = np.array([run.estimate("flash_temperature").mean for run in runs])
                row["over_twin"] = [run.over_twin.tolist() for run in runs]
                if kind == "periodic":
                    tiled = flash
                if kind == "mirrored":
                    change = 100 * np.abs(flash / tiled - 1.0)
                    row["mirror"] = change.mean(axis=0).tolist()
                    print(
                        f"    mirrored edges change T_flash by {row['mirror']} %, at most {change.max(axis=0)} %"
                    )
                rows.append(row)
                off = 100 * (flash[:, -1] / truth["flash_temperature"][-1] - 1)
                axes.plot(np.full(count, len(labels)), off, "o", ms=3)
                labels.append(f"{contact}\n{waves}, {kind}")
    axes.set(ylabel="T_flash of the map at 35 m/s, off by %")
    axes.set_xticks(range(len(labels)), labels, fontsize=4)
    figure.savefig(options.output / "pressed_maps.png", dpi=150)
    numbers = quoted(rows)
    print(numbers)
    if options.evidence:
        write_evidence(
            "pressed_maps",
            "python experiments/pressed_maps.py --evidence",
            rows=rows,
            numbers=numbers,
        )


def quoted(rows):
    """Return the numbers of docs/how-to/topography.md, per cent.

    Least and largest mean change by mirrored edges, of maps of 2 waves; least and largest rms by which T_flash over
    that of the twin is off 1, by kind and speed; and of all `maps` at each speed, `inside` are right.
    """
    mirror = [change for row in rows if row["waves"] == 2 for change in row.get("mirror", [])]
    twin = [100 * np.sqrt(((np.array(row["over_twin"]) - 1.0) ** 2).mean(axis=0)) for row in rows]
    maps, inside = sum(row["maps"] for row in rows), np.sum([row["inside"] for row in rows], axis=0)
    quotes = {"mirror_least": min(mirror), "mirror_most": max(mirror), "twin_least": np.min(twin)}
    quotes |= {"twin_most": np.max(twin), "maps": maps}
    return quotes | {"inside_slow": 100 * inside[0] / maps, "inside_fast": 100 * inside[-1] / maps}


if __name__ == "__main__":
    main()
