"""Where methods fail: one map a method, in five colours from green to failed, with the number in each cell."""

from __future__ import annotations

from collections.abc import Callable
from math import inf, isnan, nan
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch

from .style import new_figure

Row = dict[str, Any]
COLOURS = (
    "#1B7837",
    "#A6DBA0",
    "#FEE08B",
    "#F46D43",
    "#7F0000",
)  # as dark as they are light in grey: ends differ
ONE_BOUND = "one bound only"


def limits_of_heat(rows: list[Row], path: Path, source: str = "") -> None:
    """Draw the excess of T_flash of a Hertz contact over the Péclet number and the side of the cell, %."""
    kernels = list(dict.fromkeys(row["kernel"] for row in rows if "kernel" in row))
    bounds, unit = (1.0, 5.0, 20.0, 100.0), "%"

    def cell(row: Row) -> tuple[float, str]:
        value = 100 * row["excess"]
        return abs(value), f"{value:+.0f}" if abs(value) >= 9.5 else f"{value:+.1f}"

    with new_figure(path, 6.0, source) as figure:
        panels = figure.subplots(len(kernels), 1, sharex=True, squeeze=False)[:, 0]
        for axes, kernel in zip(panels, kernels, strict=True):
            found = [row for row in rows if row.get("kernel") == kernel]
            draw_map(axes, found, ("peclet", "side"), bounds, cell)
            axes.set(title=f"{kernel}: error of $T_{{flash}}$ (%)", ylabel="cell (radii)")
        panels[-1].set_xlabel("Péclet number vR/D")
        colour_key(figure, bounds, unit)


def limits_of_solvers(rows: list[Row], path: Path, source: str = "") -> None:
    """Draw the error of the pressure over load and hardness at a tolerance of 1e-6, a map for each solver."""
    solvers = list(dict.fromkeys(row["solver"] for row in rows if "ratio" in row))
    bounds, unit = (2e-6, 1e-5, 1e-4, 1e-2), ""

    def cell(row: Row) -> tuple[float, str]:
        if row["why"] == ONE_BOUND:
            return nan, "–"
        if row["why"] or isnan(row["error"]):
            return inf, "✗"
        return row["error"], f"{row['error']:.0e}".replace("e-0", "e-").replace("0e+00", "0")

    with new_figure(path, 1.0 + 2.0 * -(-len(solvers) // 2), source) as figure:
        grid = figure.subplots(-(-len(solvers) // 2), 2, sharex=True, sharey=True, squeeze=False)
        for axes, solver in zip(grid.flat, solvers, strict=False):
            found = [row for row in rows if row.get("solver") == solver and "ratio" in row]
            draw_map(axes, found, ("load", "ratio"), bounds, cell)
            axes.set_title(solver)
        for axes in grid[-1]:
            axes.set_xlabel("load $\\sigma_0/(E^* h')$")
        for axes in grid[:, 0]:
            axes.set_ylabel("hardness $\\sigma_P/\\sigma_0$")
        figure.suptitle(
            "Relative error of the pressure at a tolerance of 1e-6; –: no such solver", fontsize=9
        )
        colour_key(figure, bounds, unit)


def limits_of_pixel(rows: list[Row], path: Path, source: str = "") -> None:
    """Draw the error of T_flash by the pixel over bandwidth and Hurst exponent, %, a map for each pixel."""
    found = [row for row in rows if row.get("solver") == "roughsim" and "pixels" in row]
    pixels, bounds = sorted({row["pixels"] for row in found}), (0.5, 1.0, 3.0, 10.0)

    def cell(row: Row) -> tuple[float, str]:
        value = 100 * row["pixel_error"]
        return value, f"{value:.0f}" if value >= 9.5 else f"{value:.1f}"

    with new_figure(path, 2.8, source) as figure:
        panels = figure.subplots(1, len(pixels), sharex=True, sharey=True, squeeze=False)[0]
        for axes, pixel in zip(panels, pixels, strict=True):
            draw_map(
                axes,
                [row for row in found if row["pixels"] == pixel],
                ("bandwidth", "hurst"),
                bounds,
                cell,
            )
            axes.set(title=f"{pixel:g} pixels", xlabel="bandwidth $q_1/q_r$")
        panels[0].set_ylabel("Hurst exponent H")
        figure.suptitle(
            "Error of $T_{flash}$ by the pixel (%), by pixels per shortest wave", fontsize=9
        )
        colour_key(figure, bounds, "%", "more")


def limits_of_theory(rows: list[Row], path: Path, source: str = "") -> None:
    """Draw the deviation of T_flash from elastic contacts over load and bandwidth, %, by both formulas."""
    formulas, bounds = ("paper's theory", "calibrated law"), (1.0, 5.0, 20.0, 100.0)

    def cell(row: Row) -> tuple[float, str]:
        return abs(row["excess"]), f"{round(row['excess']):+d}"

    peclets = sorted({row["peclet"] for row in rows if "formula" in row})
    with new_figure(path, 1.0 + 2.1 * len(peclets), source) as figure:
        grid = figure.subplots(len(peclets), 2, sharex=True, sharey=True, squeeze=False)
        for line, peclet in zip(grid, peclets, strict=True):
            for axes, formula in zip(line, formulas, strict=True):
                found = [
                    row
                    for row in rows
                    if (row.get("formula"), row.get("peclet")) == (formula, peclet)
                ]
                draw_map(axes, found, ("load", "bandwidth"), bounds, cell)
                axes.set_title(f"{formula}, $v/(Dq_r)$ = {peclet:g}")
        for axes in grid[-1]:
            axes.set_xlabel("load $\\sigma_0/(E^* h')$")
        for axes in grid[:, 0]:
            axes.set_ylabel("bandwidth $q_1/q_r$")
        figure.suptitle(
            "Error of $T_{flash}$ of elastic contact (%), the largest for H from 0.3 to 1",
            fontsize=9,
        )
        colour_key(figure, bounds, "%")


def draw_map(
    axes: Axes,
    rows: list[Row],
    keys: tuple[str, str],
    bounds: tuple[float, ...],
    cell: Callable[[Row], tuple[float, str]],
) -> None:
    """Draw rows over two keys; `cell` gives of a row the size of its error and its words."""
    x, y = (sorted({row[key] for row in rows}) for key in keys)
    table = np.full((len(y), len(x)), nan)
    for row in rows:
        i, j = y.index(row[keys[1]]), x.index(row[keys[0]])
        size, words = cell(row)
        table[i, j] = nan if isnan(size) else np.searchsorted(bounds, size)  # of the colour
        dark = not isnan(size) and (size > bounds[-1] or size <= bounds[0])
        axes.text(j, i, words, ha="center", va="center", fontsize=8, color="w" if dark else "k")
    axes.imshow(
        table, vmin=0, vmax=len(bounds), cmap=ListedColormap(COLOURS), origin="lower", aspect="auto"
    )
    axes.set_xticks(range(len(x)), [f"{value:g}" for value in x], fontsize=7.5)
    axes.set_yticks(range(len(y)), ["∞" if value == inf else f"{value:g}" for value in y])
    axes.grid(visible=False)


def colour_key(
    figure: Any, bounds: tuple[float, ...], unit: str, last: str = "more, or failed"
) -> None:
    """Put the meaning of the colours below the maps."""
    space = f" {unit}" if unit else ""
    numbers = (
        f"{bound:g}" if bound > 1e-3 else f"{bound:.0e}".replace("e-0", "e-") for bound in bounds
    )
    words = [*(f"≤ {number}{space}" for number in numbers), last]
    handles = [Patch(color=colour, label=word) for colour, word in zip(COLOURS, words, strict=True)]
    figure.legend(
        handles=handles, loc="outside lower center", ncols=5, columnspacing=0.9, handlelength=1.0
    )
