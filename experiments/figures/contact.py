"""Figures of the contact solvers: error of the pressure over CPU time, and CPU time over points."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from .style import LOOKS, decades, legend_below, new_figure, plain_sizes

SOLVERS = ("roughsim", "home-made", "aspher", "tamaas", "ContactMechanics", "NuMPI")
ONE_BOUND = "one bound only"  # what a solver is not made for is no failure of it
Row = dict[str, Any]


def contact_error(rows: list[Row], path: Path, source: str = "", points: int = 512) -> None:
    """Draw the error of the pressure over the CPU time of a solve, a panel for each problem, at one size."""
    problems = list(dict.fromkeys(row["problem"] for row in rows))
    points = (
        points
        if any(row["points"] == points for row in rows)
        else max(row["points"] for row in rows)
    )
    with new_figure(path, 5.6, source) as figure:
        grid = figure.subplots(2, 2, sharex=True, sharey=True)
        panels = grid.ravel()
        for axes, problem in zip(panels, problems, strict=False):
            for name in SOLVERS:
                line = [
                    r
                    for r in rows
                    if (r["solver"], r["problem"], r["points"]) == (name, problem, points)
                ]
                done = [r for r in line if r["error"] is not None]
                if done:
                    axes.loglog(
                        [r["seconds"] for r in done],
                        [r["error"] for r in done],
                        label=name,
                        **LOOKS[name],
                    )
                failed = [r for r in line if r["why"] and r["why"] != ONE_BOUND]
                if failed and done:  # a cross where the next tolerance was not met
                    axes.plot(
                        done[-1]["seconds"],
                        done[-1]["error"],
                        "x",
                        ms=9,
                        mew=1.5,
                        color=LOOKS[name]["color"],
                    )
            axes.set_title(problem)
            decades(axes, y=(1e-9, 1))
        for axes in grid[-1]:
            axes.set_xlabel("CPU time of one solve (s)")
        figure.supylabel("relative error of the pressure", fontsize=9)
        figure.suptitle(
            f"Contact of {points}² points, one thread; tolerances from 1e-2 to 1e-8", fontsize=9
        )
        legend_below(figure, list(panels), 3)


def contact_cost(rows: list[Row], path: Path, source: str = "", goal: float = 1e-3) -> None:
    """Draw the least CPU time to an error over the points of the grid, with slopes, a panel for each problem."""
    problems = list(dict.fromkeys(row["problem"] for row in rows))
    sizes = sorted({row["points"] for row in rows})
    with new_figure(path, 5.6, source) as figure:
        grid = figure.subplots(2, 2, sharex=True, sharey=True)
        panels = grid.ravel()
        for axes, problem in zip(panels, problems, strict=False):
            slopes = {}
            for name in SOLVERS:
                line = sorted(least_times(rows, name, problem, goal).items())
                if line:
                    x, y = np.array(line).T
                    axes.loglog(x, y, label=name, **LOOKS[name])
                if len(line) > 1:
                    slopes[name] = float(np.polyfit(np.log(x**2), np.log(y), 1)[0]), x[-1], y[-1]
            write_slopes(axes, slopes)
            axes.set_title(problem)
            decades(axes)
            plain_sizes(axes, sizes)
            axes.set_xlim(sizes[0] / 1.2, sizes[-1] * 1.9)
        for axes in grid[-1]:
            axes.set_xlabel("points of the grid")
        figure.supylabel(f"CPU time to an error of {goal:g} (s)", fontsize=9)
        figure.suptitle(
            "CPU time over points; numbers are exponents of the number of points", fontsize=9
        )
        legend_below(figure, list(panels), 3)


def write_slopes(axes: Axes, slopes: dict[str, tuple[float, float, float]]) -> None:
    """Write the exponent of each line to the right of its end, of lines with one end further up where they overlap."""
    free: dict[float, float] = {}  # the lowest free height beside each end
    for name, (slope, x, y) in sorted(slopes.items(), key=lambda item: item[1][2]):
        height = max(y, free.get(x, 0.0))
        free[x] = 1.6 * height
        axes.text(
            1.12 * x,
            height,
            f"{slope:.2f}",
            va="center",
            fontsize=8,
            color=LOOKS[name]["color"],
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.5},
        )


def least_times(rows: list[Row], name: str, problem: str, goal: float) -> dict[int, float]:
    """Return the least CPU seconds of a solver to an error, by points per side."""
    found: dict[int, float] = {}
    for row in rows:
        if (
            (row["solver"], row["problem"]) == (name, problem)
            and row["error"] is not None
            and row["error"] <= goal
        ):
            found[row["points"]] = min(found.get(row["points"], np.inf), row["seconds"])
    return found
