"""Sharing the heat of a Hertz contact between two bodies: one number for all, or equal temperatures everywhere.

    python experiments/partition.py [--toy] [-o FOLDER]

One body rests, the other moves; both are of the same steel, then the moving one conducts a tenth. Drawn over Pe = vR/D:
the share of the moving body by both rules, how far the one-number rule misses T_flash and T_max, and the largest local
difference |T1 - T2| that it leaves.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

import roughsim as rs

mpl.use("Agg")
mpl.rcParams.update({"font.size": 9, "axes.titlesize": 9, "axes.spines.top": False, "axes.spines.right": False})
mpl.rcParams.update({"legend.frameon": False, "figure.constrained_layout.use": True, "savefig.dpi": 150})
CASES = {
    "equal bodies": (1.0, 0.0),
    "moving body conducts a tenth": (0.1, 0.0),
    "both move, against each other": (1.0, -1.0),
}
COLOURS = ("#0072B2", "#D55E00", "#009E73")


def hertz(pixels):
    """A Hertz source of radius 1 with unit peak, on pixels of 1/`pixels`."""
    count = 2 * pixels + 2
    x = (np.arange(count) - (count - 1) / 2) / pixels
    return np.sqrt(np.maximum(1 - x[:, None] ** 2 - x**2, 0.0)), rs.Grid((count, count), (count / pixels,) * 2)


def both_rules(flux, grid, peclet, ratio, counter):
    moving = rs.Body(conductivity=ratio, diffusivity=ratio, speed=peclet * ratio)
    resting = rs.Body(conductivity=1.0, diffusivity=1.0, speed=counter * peclet)
    return [rs.partition_heat(flux, grid, moving=moving, resting=resting, pointwise=p) for p in (False, True)]


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--toy", action="store_true", help="small and quick, to see it work")
    options.add_argument("-o", "--output", type=Path, default=Path("runs/partition"), help="folder of the figure")
    given = options.parse_args()
    given.output.mkdir(parents=True, exist_ok=True)
    flux, grid = hertz(6 if given.toy else 32)
    peclets = np.geomspace(0.1, 1e4, 3 if given.toy else 21)
    figure = Figure(figsize=(9.5, 3.8))
    share, error, jump = figure.subplots(1, 3)
    print(f"{'':32}{'Pe':>9}{'share':>9}{'pointwise':>11}{'T_flash':>10}{'T_max':>9}{'mismatch':>10}{'steps':>7}")
    for colour, (name, (ratio, counter)) in zip(COLOURS, CASES.items(), strict=True):
        pairs = [both_rules(flux, grid, peclet, ratio, counter) for peclet in peclets]
        flash = np.array([one.flash_temperature / point.flash_temperature - 1 for one, point in pairs])
        hottest = np.array([one.max_temperature / point.max_temperature - 1 for one, point in pairs])
        share.semilogx(peclets, [point.moving_share for _, point in pairs], color=colour, label=name)
        share.semilogx(peclets, [one.moving_share for one, _ in pairs], color=colour, ls="--")
        error.semilogx(peclets, 100 * flash, color=colour)
        error.semilogx(peclets, 100 * hottest, color=colour, ls=":")
        jump.semilogx(peclets, [one.mismatch for one, _ in pairs], color=colour)
        for k in range(0, len(peclets), max(1, len(peclets) // 5)):
            one, point = pairs[k]
            print(
                f"{name:32}{peclets[k]:9.3g}{one.moving_share:9.4f}{point.moving_share:11.4f}{100 * flash[k]:+9.2f}%"
                f"{100 * hottest[k]:+8.2f}%{one.mismatch:10.3f}{point.applications:7d}"
            )
    share.set(title="share of the moving body", xlabel="vR/D")
    share.legend(title="pointwise (dashed: one number)", loc="upper center", bbox_to_anchor=(0.5, -0.2))
    error.set(title="one number against pointwise, %", xlabel="vR/D")
    error.plot([], [], "k-", label="T_flash")
    error.plot([], [], "k:", label="T_max")
    error.legend()
    jump.set(title="largest |T1 - T2| / T_max, one number", xlabel="vR/D", ylim=(0, None))
    figure.savefig(given.output / "partition.png")


if __name__ == "__main__":
    main()
