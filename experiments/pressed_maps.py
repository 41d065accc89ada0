"""Whether the error of a map that is pressed itself holds: maps of known C(q), pressed one by one.

    python experiments/pressed_maps.py [--toy] [-o FOLDER]

Periodic maps are drawn with Gaussian amplitudes and pressed as they are (tile), or with their mirror images as if they
were not known to be periodic. Other maps are cut out of surfaces of twice their side, and pressed with their mirror
images. All have 2 or 4 of their longest waves per side. The mean over many maps is that of 24 surfaces of 8 waves per
side, drawn from the same C(q), at the same cut-offs and pixels. "inside" counts the maps whose total error, 95 %, holds
this mean.
"""

from __future__ import annotations

import warnings
from dataclasses import replace
from math import pi

import numpy as np
from matplotlib.figure import Figure
from script import Command

import roughsim as rs

POINTS, PIXEL = 128, 4e-6  # of a map; m
NAMES = ("flash_temperature", "contact_fraction", "pressure_variance")
STEEL = {"youngs_modulus": 2.1e11, "poisson_ratio": 0.3, "conductivity": 30, "density": 7900, "heat_capacity": 500}


def scene_of(surface, hardness, seeds=1):
    """Return a scene of steel that slides on a smooth one."""
    body = STEEL | ({"penetration_hardness": hardness} if hardness else {})
    sliding = {"nominal_pressure": 6e7, "speed": [0.01, 35.0], "friction_coefficient": 0.2}
    ensemble = {"max_realizations": seeds, "seed": 7000}
    return {"surface": surface, "body": body, "counterface": STEEL, "sliding": sliding, "ensemble": ensemble}


def face_of(waves, points):
    """Return the C(q) of maps with so many longest waves and so many points per side, four points per shortest wave."""
    q_min = 2 * pi * waves / (points * PIXEL)
    return {"rms_height": 1.2e-6 / waves, "hurst": 0.8, "q_min": q_min, "q_max": 0.5 * pi / PIXEL}


def mean_of_many(face, hardness, pressed, times, seeds):
    """Return means over surfaces so many times as wide as the map of a run, drawn from C(q), at its levels."""
    levels = tuple(replace(level, shape=tuple(times * n for n in level.shape)) for level in pressed.numerics.levels)
    lengths = tuple(times * length for length in pressed.numerics.lengths)
    scene = rs.load_scene(scene_of(face, hardness, seeds))
    scene = replace(scene, numerics=replace(scene.numerics, levels=levels, lengths=lengths))
    run = rs.run(scene, pressed.folder.with_name(f"{pressed.folder.name}-mean"), workers=1)
    return {name: run.estimate(name).mean for name in NAMES}


def main():
    """Print how often the stated errors hold, and draw T_flash of the maps."""
    options = Command(__file__, __doc__, "two maps of each kind").parse()
    count, points, seeds = (2, 64, 4) if options.toy else (60, POINTS, 24)
    warnings.filterwarnings("ignore", message="q_min = ", category=RuntimeWarning)  # C(q) goes on beyond a map
    figure = Figure(figsize=(6, 3.2), layout="constrained")
    axes, labels = figure.subplots(), []
    for hardness, contact in ((0.0, "elastic"), (3e9, "capped")):
        for waves in (2, 4):
            face, truth, tiled = face_of(waves, points), {}, []
            spectrum = rs.load_scene(scene_of(face, hardness)).spectrum
            for kind, larger, edges in (("periodic", 1, "tile"), ("mirrored", 1, "mirror"), ("cut out", 2, "mirror")):
                side = larger * points
                grid = rs.Grid((side, side), (side * PIXEL, side * PIXEL))
                found = []
                for seed in range(100, 100 + count):
                    heights = rs.synthesize(spectrum, grid, np.random.default_rng(seed), amplitudes="gaussian")
                    path = options.output / "map.npy"
                    np.save(path, heights[:points, :points])
                    size = {"topography_size": points * PIXEL, "topography_unit": "m"}
                    name = f"{contact}-{waves}-{kind.replace(' ', '-')}-{points}-{seed}"
                    scene = scene_of({"topography": str(path.resolve()), **size}, hardness)
                    run = rs.press(scene, options.output / name, edges=edges)
                    found.append({name: run.estimate(name) for name in NAMES})
                    if not truth:
                        truth = mean_of_many(face, hardness, run, 8 // waves, seeds)
                print(f"{contact}, {waves} longest waves a side, {kind}:")
                for name in NAMES:
                    means = np.array([estimates[name].mean for estimates in found])
                    errors = np.array([estimates[name].total_error for estimates in found])
                    off, inside = means / truth[name] - 1.0, np.abs(means - truth[name]) <= errors
                    for k, speed in enumerate((" at 0.01 m/s", " at 35 m/s") if len(truth[name]) == 2 else ("",)):
                        print(
                            f"    {name}{speed}: off by {100 * off[:, k].mean():+.1f} ± "
                            f"{100 * off[:, k].std():.1f} %, stated {100 * np.median((errors / means)[:, k]):.0f} %, "
                            f"inside {inside[:, k].sum()} of {count}",
                            flush=True,
                        )
                flash = np.array([estimates["flash_temperature"].mean for estimates in found])
                if kind == "periodic":
                    tiled = flash
                if kind == "mirrored":
                    change = 100 * np.abs(flash / tiled - 1.0)
                    print(
                        f"    mirrored edges change T_flash by {change.mean(axis=0)} %, at most {change.max(axis=0)} %"
                    )
                axes.plot(
                    np.full(count, len(labels)), 100 * (flash[:, -1] / truth["flash_temperature"][-1] - 1), "o", ms=3
                )
                labels.append(f"{contact}\n{waves}, {kind}")
    axes.set(ylabel="T_flash of the map at 35 m/s, off by %")
    axes.set_xticks(range(len(labels)), labels, fontsize=4)
    figure.savefig(options.output / "pressed_maps.png", dpi=150)


if __name__ == "__main__":
    main()
