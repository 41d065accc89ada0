"""Where methods fail: maps of the error, by contours of equal size, and of solvers cell by cell."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, isnan, nan
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap, to_hex
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke

from .style import new_figure

Row = dict[str, Any]
PER_CENT = (1.0, 3.0, 10.0, 30.0, 100.0)
DECADES = (1e-6, 1e-5, 1e-4, 1e-3, 1e-2)
ONE_BOUND = "one bound only"
# from light, right, to dark, failed: the order is seen in grey and by the colour-blind
COLOURS = [to_hex(colour) for colour in mpl.colormaps["YlGnBu"](np.linspace(0.02, 1.0, 6))]


def limits_of_heat(rows: list[Row], path: Path, source: str = "") -> None:
    """Draw the excess of T_flash of a Hertz contact over the Péclet number and the side of the cell, %."""
    kernels = list(dict.fromkeys(row["kernel"] for row in rows if "kernel" in row))
    with new_figure(path, 6.0, source) as figure:
        panels = figure.subplots(len(kernels), 1, sharex=True, squeeze=False)[:, 0]
        for axes, kernel in zip(panels, kernels, strict=True):
            found = [row for row in rows if row.get("kernel") == kernel]
            contours(axes, found, ("peclet", "side"), [100 * row["excess"] for row in found])
            axes.set(title=kernel, ylabel="cell (radii)")
        panels[-1].set_xlabel("Péclet number $vR/D$")
        figure.suptitle(r"Error of $T_\mathrm{flash}$ (%); dashed: too cold", fontsize=9)
        colour_key(figure, PER_CENT, " %")


def limits_of_solvers(rows: list[Row], path: Path, source: str = "") -> None:
    """Draw the error of the pressure over load and hardness at a tolerance of 1e-6, a map for each solver."""
    solvers = list(dict.fromkeys(row["solver"] for row in rows if "ratio" in row))
    with new_figure(path, 1.0 + 2.0 * -(-len(solvers) // 2), source) as figure:
        grid = figure.subplots(-(-len(solvers) // 2), 2, sharex=True, sharey=True, squeeze=False)
        for axes, solver in zip(grid.flat, solvers, strict=False):
            found = [row for row in rows if row.get("solver") == solver and "ratio" in row]
            cells(axes, found, ("load", "ratio"), [_error_of(row) for row in found])
            axes.set_title(solver)
        for axes in grid[-1]:
            axes.set_xlabel("load $\\sigma_0/(E^* h')$")
        for axes in grid[:, 0]:
            axes.set_ylabel("hardness $\\sigma_P/\\sigma_0$")
        figure.suptitle(
            "Relative error of the pressure at a tolerance of 1e-6;\n×: failed; white: no such solver",
            fontsize=9,
        )
        colour_key(figure, DECADES, "")


def _error_of(row: Row) -> float:
    """Return the error of a solver: ∞ if it failed, NaN if it has no such contact."""
    if row["why"] == ONE_BOUND:
        return nan
    return inf if row["why"] or isnan(row["error"]) else row["error"]


def limits_of_pixel(rows: list[Row], path: Path, source: str = "") -> None:
    """Draw the error of T_flash by the pixel over bandwidth and Hurst exponent, %, a map for each pixel."""
    found = [row for row in rows if row.get("solver") == "roughsim" and "pixels" in row]
    pixels = sorted({row["pixels"] for row in found})
    with new_figure(path, 2.8, source) as figure:
        panels = figure.subplots(1, len(pixels), sharex=True, sharey=True, squeeze=False)[0]
        for axes, pixel in zip(panels, pixels, strict=True):
            chosen = [row for row in found if row["pixels"] == pixel]
            errors = [100 * row["pixel_error"] for row in chosen]
            contours(axes, chosen, ("bandwidth", "hurst"), errors)
            axes.set(title=f"{pixel:g} pixels", xlabel="bandwidth $q_1/q_r$")
        panels[0].set_ylabel("Hurst exponent $H$")
        figure.suptitle(
            r"Error of $T_\mathrm{flash}$ by the pixel (%), by pixels per shortest wave", fontsize=9
        )
        colour_key(figure, PER_CENT, " %")


def limits_of_theory(rows: list[Row], path: Path, source: str = "") -> None:
    """Draw the deviation of T_flash from elastic contacts over load and bandwidth, %, by both formulas."""
    formulas = "paper's theory", "calibrated law"
    peclets = sorted({row["peclet"] for row in rows if "formula" in row})
    with new_figure(path, 1.2 + 2.1 * len(peclets), source) as figure:
        grid = figure.subplots(len(peclets), 2, sharex=True, sharey=True, squeeze=False)
        for line, peclet in zip(grid, peclets, strict=True):
            for axes, formula in zip(line, formulas, strict=True):
                found = [
                    row
                    for row in rows
                    if (row.get("formula"), row.get("peclet")) == (formula, peclet)
                ]
                contours(axes, found, ("load", "bandwidth"), [row["excess"] for row in found])
                axes.set_title(f"{formula}, $v/(Dq_r)$ = {peclet:g}")
        for axes in grid[-1]:
            axes.set_xlabel("load $\\sigma_0/(E^* h')$")
        for axes in grid[:, 0]:
            axes.set_ylabel("bandwidth $q_1/q_r$")
        figure.suptitle(
            "Error of $T_\\mathrm{flash}$ of elastic contact (%), the largest for $H$ from 0.3 to 1;\n"
            "dashed: too cold",
            fontsize=9,
        )
        colour_key(figure, PER_CENT, " %")


def contours(axes: Axes, rows: list[Row], keys: tuple[str, str], errors: Sequence[float]) -> None:
    """Draw errors in % over two keys, with lines where they have the sizes of `PER_CENT`; dashed are negative ones."""
    table = _table(axes, rows, keys, errors)
    if min(table.shape) < 2:
        return
    levels = [*(-level for level in reversed(PER_CENT)), *PER_CENT]
    colours = [*reversed(COLOURS), *COLOURS[1:]]
    axes.contourf(table, [-1e9, *levels, 1e9], colors=colours)
    style: Any = {"colors": "k", "linewidths": 0.8, "negative_linestyles": "dashed"}
    lines = axes.contour(table, levels, **style)
    around, apart = [withStroke(linewidth=3.0, foreground="w")], 0.09 * np.array(table.shape[::-1])
    places: list[np.ndarray] = [np.array([-9e9, -9e9])]
    for text in axes.clabel(
        lines, fmt=lambda level: f"{level:+g}".replace("-", "−"), fontsize=8, inline=False
    ):
        text.set_path_effects(around)
        # the colours name lines whose numbers would lie over others, or beyond the map
        place = np.array(text.get_position())
        steps = np.abs([place - other for other in places]) / apart
        if (steps.max(axis=1) < 1.0).any() or (place < 0.5 * apart).any():
            text.remove()
        else:
            places.append(place)


def cells(axes: Axes, rows: list[Row], keys: tuple[str, str], errors: Sequence[float]) -> None:
    """Draw errors over two keys by colours between `DECADES`, a cross where they are ∞, nothing where NaN."""
    table = _table(axes, rows, keys, errors)
    norm = BoundaryNorm([-1.0, *DECADES, 1e9], len(COLOURS))
    shown = np.where(np.isinf(table), 1.0, table)
    axes.imshow(shown, norm=norm, cmap=ListedColormap(COLOURS), origin="lower", aspect="auto")
    failed = np.argwhere(np.isinf(table))
    axes.plot(*failed.T[::-1], "x", color="w", ms=7, mew=1.6)


def _table(
    axes: Axes, rows: list[Row], keys: tuple[str, str], errors: Sequence[float]
) -> np.ndarray:
    """Return errors over the places of the second key and of the first, which the axes name."""
    x, y = (sorted({row[key] for row in rows}) for key in keys)
    table = np.full((len(y), len(x)), nan)
    for row, error in zip(rows, errors, strict=True):
        table[y.index(row[keys[1]]), x.index(row[keys[0]])] = error
    axes.set_xticks(range(len(x)), [f"{value:g}" for value in x], fontsize=7.5)
    axes.tick_params(axis="x", pad=5)
    axes.set_yticks(range(len(y)), ["∞" if value == inf else f"{value:g}" for value in y])
    axes.grid(visible=False)
    return table


def colour_key(figure: Any, bounds: Sequence[float], unit: str) -> None:
    """Put the meaning of the colours below the maps."""
    numbers = [
        f"{bound:g}" if bound > 1e-3 else f"{bound:.0e}".replace("e-0", "e-") for bound in bounds
    ]
    words = [*(f"≤ {number}{unit}" for number in numbers), "more"]
    handles = [Patch(color=colour, label=word) for colour, word in zip(COLOURS, words, strict=True)]
    figure.legend(
        handles=handles, loc="outside lower center", ncols=6, columnspacing=0.9, handlelength=1.0
    )
