"""What half the cell changes of the corrections by finer levels: as ratios, which estimates use, and as differences.

    python experiments/half_cell.py [--toy] [-o FOLDER] [--only NAME ...] [--most N]

Capped contact of three steels and at other loads, with one step of the cut-off and one of the pixel: once in the run's
cell of four longest waves, and once in half of it, with four times as many realizations. Printed is what each step
changes, in % of the value, how much that differs in half the cell, for ratios of means and for differences, and the
variance of ratios over that of differences. Runs in FOLDER are not computed again. --toy takes one scene and few
realizations.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from script import Command

import roughsim as rs
from roughsim import prediction
from roughsim.estimate.cell_size import STEP_ERROR
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.planning.levels import fast_size

SCENES = {
    "0.5 GPa": ("steel-0.5GPa", None),
    "1.2 GPa": ("steel-1.2GPa", None),
    "2.0 GPa": ("steel-2.0GPa", None),
    "1.2 GPa, 12 MPa": ("steel-1.2GPa", 12e6),
    "1.2 GPa, 360 MPa": ("steel-1.2GPa", 360e6),
    "0.5 GPa, 5 MPa": ("steel-0.5GPa", 5e6),
    "demo, 4.5 MPa": ("demo", 4.5e6),
}
WAVES, FIRST = 4, 2.0  # longest waves per side of the run's cell; the first cut-off, q_y
SHOWN = ("flash_temperature", "contact_fraction", "correlation_radius_50")
HALF, WHOLE = 2, 1  # parts of the cell per side


def levels_of(scene: rs.Scene, parts: int) -> rs.Numerics:
    """Return two cut-offs with 4 pixels per shortest wave, and the first with 8, in the cell over `parts`."""
    length = WAVES * 2 * np.pi / scene.spectrum.breaks[0]
    cut_off = FIRST * prediction.yield_wavenumber(scene)
    side = fast_size(4 * cut_off * length / (2 * np.pi)) // parts
    levels = [rs.Level("capped", (k * side, k * side), q * cut_off) for k, q in ((1, 1), (2, 1), (2, 2))]
    return rs.Numerics(tuple(levels), (length / parts,) * 2)


def values_of(scene: rs.Scene, folder: Path, count: int, parts: int) -> dict[str, list[np.ndarray]]:
    """Return the rows of each level, by observable: those at the slowest and the hottest speed."""
    numerics = replace(levels_of(scene, parts), keep_fields=0)
    run = rs.run(scene, folder, numerics=numerics, seed=70 + parts, until={}, max_realizations=count)
    samples = run.samples("capped", run.sound(count), spectra=True)
    return {name: [OBSERVABLES[name].of_level(sample)[:, [0, -1]] for sample in samples] for name in SHOWN}


def step(low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return difference over value and ratio − 1, each with the standard deviation of one realization."""
    mean, ratio = low.mean(axis=0), high.mean(axis=0) / low.mean(axis=0)
    return ratio - 1, (high - low).std(axis=0, ddof=1) / mean, (high - ratio * low).std(axis=0, ddof=1) / mean


def compared(name: str, folder: Path, most: int) -> list[tuple[str, float, float, float]]:
    """Print, and return, what each step changes by in half the cell."""
    scene = rs.load_scene(SCENES[name][0])
    if SCENES[name][1]:
        scene = scene.with_("sliding.nominal_pressure", SCENES[name][1])
    stem = name.replace(", ", "-").replace(" ", "-")
    whole = values_of(scene, folder / f"{stem}-whole", most, WHOLE)
    half = values_of(scene, folder / f"{stem}-half", 4 * most, HALF)
    found = []
    for observable in SHOWN:
        for title, a, b in (("pixel", 0, 1), ("q_c", 0, 2)):
            own, of_half = (
                step(whole[observable][a], whole[observable][b]),
                step(half[observable][a], half[observable][b]),
            )
            for k, speed in enumerate(("slowest", "fastest")):
                if k and not OBSERVABLES[observable].per_speed:
                    continue
                scale = half[observable][a].mean(axis=0)[k] / whole[observable][a].mean(axis=0)[k]
                ratio, error = of_half[0][k] - own[0][k], np.hypot(own[2][k], of_half[2][k] / 2) / np.sqrt(most)
                difference = of_half[0][k] * scale - own[0][k]
                doubt = np.hypot(own[1][k], of_half[1][k] / 2) / np.sqrt(most)
                part = f"{observable}, {speed}" if OBSERVABLES[observable].per_speed else observable
                print(
                    f"{name:17s}{title:6s}{part:28s}{100 * own[0][k]:+8.2f} %; in half the cell ratios "
                    f"{100 * ratio:+.2f} ± {100 * error:.2f}, differences {100 * difference:+.2f} ± {100 * doubt:.2f}, "
                    f"variance × {(of_half[2][k] / of_half[1][k]) ** 2:.2f}",
                    flush=True,
                )
                found.append((f"{name}: {title}, {part}", own[0][k], ratio, error))
    return found


def chart(found: list[tuple[str, float, float, float]], path: Path) -> None:
    """Draw what half the cell changes over the size of the step, with two standard errors."""
    figure = Figure((6.4, 4.0), layout="constrained")
    axes = figure.subplots()
    steps = 100 * np.abs([own for _, own, *_ in found])
    changes, errors = (100 * np.array([row[i] for row in found]) for i in (2, 3))
    axes.errorbar(steps, changes, yerr=2 * errors, fmt="o", ms=3, lw=0.8)
    wide = np.array([0.0, steps.max()])
    for sign in (-1, 1):
        axes.plot(wide, sign * STEP_ERROR * wide, color="0.5", lw=0.8)
    axes.set_title(f"lines: {100 * STEP_ERROR:g} % of the change, the least error that runs state", fontsize=9)
    axes.set(xlabel="what a finer level changes (%)", ylabel="half − run's cell (%), ± 2 standard errors")
    figure.savefig(path, dpi=130)


def main() -> None:
    command = Command(__file__, __doc__, "one scene, few realizations")
    command.add_argument("--only", nargs="*", choices=list(SCENES), help="names of scenes")
    command.add_argument("--most", type=int, default=200, help="realizations of the run's cell")
    options = command.parse()
    names = options.only or (["demo, 4.5 MPa"] if options.toy else list(SCENES))
    found = [row for name in names for row in compared(name, options.output, 12 if options.toy else options.most)]
    chart(found, options.output / "half_cell.png")


if __name__ == "__main__":
    main()
