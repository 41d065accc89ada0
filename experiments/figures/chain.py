"""The figure of the chain: error of T_flash over CPU time, by runs, by one grid, and by formulas."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from .style import BLACK, LOOKS, decades, legend_below, new_figure

Row = dict[str, Any]
GRIDS = "one grid, 2 pixels", "one grid, 4 pixels", "one grid, 8 pixels"
RUNS = "roughsim", "plain script"
FORMULAS = "paper's theory", "calibrated law"


def chain(runs: list[Row], ways: list[Row], path: Path, source: str = "") -> None:
    """Draw the error of T_flash over CPU time, a panel for each scene; a cross is where more members no longer help.

    `runs` has the total errors that runs and the plain script state. The error of one grid is its deviation from the
    reference and the 95 % half-width of its scatter, of formulas the deviation, at the worst speed each.
    """
    scenes = list(dict.fromkeys(row["scene"] for row in ways))
    rows = -(-len(scenes) // 2)
    with new_figure(path, 1.1 + 1.9 * rows, source) as figure:
        figure.set_layout_engine("compressed")
        grid = figure.subplots(rows, 2, sharex=True, sharey=True, squeeze=False)
        panels = list(grid.flat)
        for axes, scene in zip(panels, scenes, strict=False):
            for row in (row for row in ways if row["scene"] == scene):
                draw_way(axes, row)
            for way in RUNS:
                draw_runs(axes, way, [row for row in runs if row["scene"] == scene])
            axes.set_title(scene)
            decades(axes, x=(1e-2, 4e2), y=(0.1, 400))
            axes.set_aspect("equal")  # a decade is as long on both axes
        for axes in panels[len(scenes) :]:
            axes.set_visible(False)
        panels[0].plot([], [], "x", ms=6, mew=1.6, color=BLACK, label="no gain by more members")
        for axes in grid[-1]:
            axes.set_xlabel("CPU time (s)")
        figure.supylabel("error of the flash temperature (%)", fontsize=9)
        legend_below(figure, panels, 2)


def draw_runs(axes: Any, way: str, runs: list[Row]) -> None:
    """Draw what runs, or the script, state over their CPU time, in the order of their targets."""
    done = sorted(
        (row for row in runs if row.get("way", RUNS[0]) == way and "error" in row),
        key=lambda row: row["target"],
    )
    for met, words, look in (
        (True, way, LOOKS[way]),
        (False, f"{way}, target out of reach", {**LOOKS[way], "ls": "", "mfc": "none"}),
    ):
        points = [
            (row["seconds"], 100 * np.nanmax(row["error"])) for row in done if row["met"] == met
        ]
        if points:
            axes.loglog(*np.transpose(points), label=words, **look)


def draw_way(axes: Any, row: Row) -> None:
    """Draw one grid as a line over the number of its members up to where its bias is left, a formula as a point."""
    name, bias = row["way"], np.abs(row["bias"])
    if name in FORMULAS:
        if np.isfinite(bias).all():
            axes.loglog(
                row["seconds"], 100 * bias.max(), label=name, ls="", **{**LOOKS[name], "ms": 7}
            )
        return
    scatter = np.array(row["scatter"])
    members = np.geomspace(2, 1000, 25)
    error = np.hypot(bias, 1.96 * scatter / np.sqrt(members)[:, None]).max(axis=1)
    useful = error > 1.1 * bias.max()  # within a tenth of the bias no member helps
    last = int(useful.sum())
    x, y = members[: last + 1] * row["seconds"], 100 * error[: last + 1]
    look = {**LOOKS[name], "marker": ""}
    axes.loglog(x, y, label=name, **look)
    known = bias.max() > 1.96 * scatter.max() / np.sqrt(
        row["members"]
    )  # else the scatter hides where it ends
    if known and last < len(members):
        axes.plot(x[-1], y[-1], "x", ms=6, mew=1.6, color=look["color"])
