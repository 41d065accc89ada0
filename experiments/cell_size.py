"""What a finite cell changes: the same scene in cells of 1, 2, 4, and 8 longest waves per side, pixel and cut-off kept.

    python experiments/cell_size.py [--toy] [-o FOLDER] [--only NAME ...] [--error PERCENT] [--most N]

The scenes are a steel, capped and elastic, random ones of `budget.py`, and the steel with a plateau, C(q) flat below
q_roll_off, where waves of the roll-off are counted: 2, 4, 8, and 16. Each mean is taken until T_flash is known to the
error named (95 %, worst speed), or over the most realizations. Printed is, for each doubling of the cell and each
observable at the hottest speed, how much it changes, with the standard error of the change (cells of different size
share no surfaces), and what the theory's sum over the modes of a cell has over its integral. --toy takes one scene.
"""

from __future__ import annotations

import runpy
from dataclasses import replace
from itertools import pairwise
from math import pi
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from script import Command

import roughsim as rs
from roughsim import prediction
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.surface.spectrum import TruncatedSpectrum

random_scene = runpy.run_path(str(Path(__file__).with_name("budget.py")))["random_scene"]
COLUMNS = [name for name in OBSERVABLES if name not in ("plastic_fraction", "heat_partition")]


def scenes() -> dict[str, rs.Scene]:
    """Return scenes by name; each with a plateau has it in its name."""
    steel = rs.load_scene("steel-1.2GPa")
    flat = replace(steel, surface=replace(steel.surface, roll_off_exponent=0.0, q_min=9.4e4 / 32))
    soft = {
        f"{name}, elastic": replace(scene, body=replace(scene.body, penetration_hardness=None))
        for name, scene in (("steel", steel), ("plateau", flat))
    }
    some = {f"random {i}": random_scene(i) for i in (1, 2, 4, 5, 7, 8, 10)}
    return {"steel": steel, "plateau": flat, **soft, **some}


def numerics(scene: rs.Scene, waves: int, kept: int, longest: float) -> rs.Numerics:
    """Return one level at 4 pixels per shortest wave, the same pixel in every cell."""
    side, column = 4 * kept * waves, "elastic" if scene.elastic else "capped"
    length = waves * longest
    return rs.Numerics((rs.Level(column, (side, side), kept * 2 * pi / longest),), (length, length))


def measured(
    name: str, scene: rs.Scene, folder: Path, error: float, most: int, cells: tuple[int, ...]
) -> dict[int, dict[str, np.ndarray]]:
    """Return mean and standard error of each observable at the hottest speed, by waves per side."""
    scene = replace(scene, ensemble=replace(scene.ensemble, max_realizations=most))
    flat = name.startswith("plateau")
    longest = 2 * pi / (scene.surface.q_roll_off if flat else scene.spectrum.breaks[0])
    result = {}
    for waves in cells or ((2, 4, 8, 16) if flat else (1, 2, 4, 8)):
        chosen = numerics(scene, waves, 8 if flat else 16, longest)
        folder_of = folder / f"{name.replace(', ', '-').replace(' ', '-')}-{waves}"
        run = rs.run(scene, folder_of, numerics=chosen, until={"flash_temperature": error}, workers=1)
        hot = int(np.argmax(run.estimate("flash_temperature").mean))
        print(f"{name}: {waves} waves, n = {run.realizations}, {_mode_sum(run, hot)}", flush=True)
        result[waves] = {}
        for observable in COLUMNS:
            found = run.estimate(observable)
            k = hot if OBSERVABLES[observable].per_speed else 0
            result[waves][observable] = np.array([found.mean[k], found.standard_error[k]])
    return result


def _mode_sum(run: rs.Run, hot: int) -> str:
    """What the theory's sum over the modes has over its integral to the same cut-off."""
    spectrum = TruncatedSpectrum(prediction.smoothed_spectrum(run.scene), run.numerics.levels[0].q_max)
    speeds = np.array(run.scene.speeds)
    sums = prediction.mode_sums(run.scene, spectrum, run.numerics.grid(0))["flash_temperature"][hot]
    whole = prediction.over_speed(run.scene, speeds, spectrum)["flash_temperature"][hot]
    return f"theory: sum over modes/integral − 1 = {100 * (sums / whole - 1):+.2f} %"


def told(name: str, found: dict[int, dict[str, np.ndarray]]) -> None:
    for small, large in pairwise(found):
        parts = []
        for observable in COLUMNS:
            (a, da), (b, db) = found[small][observable], found[large][observable]
            parts.append(f"{100 * (a / b - 1):+.2f} ± {100 * np.hypot(da / a, db / b):.2f}")
        print(f"{name:18s}{small:>3d}:{large:<3d}" + "".join(f"{part:>23s}" for part in parts), flush=True)


def chart(found: dict[str, dict[int, dict[str, np.ndarray]]], path: Path) -> None:
    """Draw the change of T_flash with each doubling; a plateau counts its waves of the roll-off by halves."""
    figure = Figure((6.4, 3.6), layout="constrained")
    axes = figure.subplots()
    axes.axhline(0.0, color="0.5", lw=0.8)
    for number, (name, cells) in enumerate(found.items()):
        waves = np.array(list(cells)[:-1], dtype=float) * 1.03**number
        pairs = [(cells[a]["flash_temperature"], cells[b]["flash_temperature"]) for a, b in pairwise(cells)]
        change = [100 * (a[0] / b[0] - 1) for a, b in pairs]
        error = [100 * np.hypot(a[1] / a[0], b[1] / b[0]) for a, b in pairs]
        axes.errorbar(waves, change, yerr=error, fmt="o-", ms=4, capsize=2, lw=0.8, label=name)
    axes.set_xscale("log", base=2)
    axes.set(
        xlabel="longest waves per side (plateau: of the roll-off)", ylabel="T_flash over that of twice the side − 1 (%)"
    )
    axes.legend(frameon=False, fontsize=7, ncols=2)
    figure.savefig(path, dpi=130)


def main() -> None:
    command = Command(__file__, __doc__, "one scene, few realizations")
    command.add_argument("--only", nargs="*", help="names of scenes")
    command.add_argument("--error", type=float, default=0.3, help="of T_flash in each cell, %%")
    command.add_argument("--most", type=int, default=1600, help="realizations of a cell")
    options = command.parse()
    every = scenes()
    names = options.only or (["random 2"] if options.toy else list(every))
    most = 12 if options.toy else options.most
    cells = (1, 2) if options.toy else ()
    found = {name: measured(name, every[name], options.output, options.error / 100, most, cells) for name in names}
    print(" " * 25 + "".join(f"{name:>23s}" for name in COLUMNS))
    for name, cells in found.items():
        told(name, cells)
    chart(found, options.output / "cell_size.png")


if __name__ == "__main__":
    main()
