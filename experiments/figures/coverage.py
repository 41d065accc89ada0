"""The figure of the coverage: how far runs of many seeds are from a deep reference."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from .style import BLACK, BLUE, ORANGE, legend_below, new_figure

NAMES = {
    "flash_temperature": r"$T_\mathrm{flash}$",
    "contact_fraction": "contact area",
    "pressure_variance": "$g_\\sigma(0)$",
    "heat_partition": "share",
}


def coverage(rows: list[dict[str, Any]], path: Path, source: str = "") -> None:
    """Draw (run − reference)/error of every run, a panel for each scene; grey is within the total error."""
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    counts = [sum(row["scene"] == scene for row in rows) for scene in scenes]
    lines = [max(counts[k : k + 2]) for k in range(0, len(scenes), 2)]  # of the panels side by side
    with new_figure(path, 0.4 + 0.35 * len(lines) + 0.17 * sum(lines), source) as figure:
        grid = figure.subplots(len(lines), 2, squeeze=False, sharex=True, height_ratios=lines)
        for axes, scene in zip(grid.flat, scenes, strict=False):
            here = [row for row in rows if row["scene"] == scene]
            axes.axvspan(-1, 1, color="0.9")
            for k, row in enumerate(here):
                off = np.clip(np.array(row["off"], dtype=float), -2, 2)
                colour = ORANGE if row["observable"] == "flash_temperature" else BLUE
                axes.plot(off, k + np.linspace(-0.3, 0.3, len(off)), ".", ms=2.5, color=colour)
            axes.set_yticks(range(len(here)), [label(row) for row in here], fontsize=7.5)
            axes.invert_yaxis()
            axes.grid(visible=False)
            axes.set_title(scene)
        for axes in list(grid.flat)[len(scenes) :]:
            axes.set_visible(False)
        for axes in grid[-1]:
            axes.set_xlabel("(run − reference)/error")


def label(row: dict[str, Any]) -> str:
    """Return the observable and its speed."""
    return NAMES[row["observable"]] + (
        f", {row['speed']:g} m/s" if row["speed"] is not None else ""
    )


def off_over_error(groups: dict[str, tuple[Any, Any]], path: Path) -> None:
    """Draw how far values are off over their errors, both relative; below the line they hold.

    `groups` has both by name; one without values is left out.
    """
    with new_figure(path, 3.4) as figure:
        axes = figure.subplots()
        for (name, (off, error)), marker in zip(groups.items(), "o^sD", strict=False):
            if len(off):
                axes.loglog(100 * error, 100 * off, marker, ms=2.5, label=name)
        axes.plot(axes.get_xlim(), axes.get_xlim(), color=BLACK, lw=0.8)
        axes.set(xlabel="error, %", ylabel="off, %", ylim=(1e-3, None))
        legend_below(figure, [axes], 3)
