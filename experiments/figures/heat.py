"""The figure of the heat: error of T_flash over CPU time, for a Hertz contact and a rough one."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from .style import LOOKS, decades, legend_below, new_figure

METHODS = "mean over directions", "periodic, steady", "periodic, from rest", "free half-space"
ROUNDING = 1e-9
SHOWN = 0.1, 10.0, 1e4  # Péclet numbers


def heat(rows: list[dict[str, Any]], path: Path, source: str = "") -> None:
    """Draw the error of T_flash over CPU time, rows of panels by the Péclet number, columns by the source."""
    peclets = [value for value in SHOWN if any(row["peclet"] == value for row in rows)]
    with new_figure(path, 1.1 + 1.9 * len(peclets), source) as figure:
        grid = figure.subplots(len(peclets), 2, sharex=True, sharey=True, squeeze=False)
        for line, peclet in zip(grid, peclets, strict=True):
            for axes, what in zip(line, ("Hertz", "rough"), strict=True):
                for method in METHODS:
                    here = {"source": what, "method": method, "peclet": peclet}.items()
                    known = (
                        r for r in rows if here <= r.items() and r["error"] > ROUNDING
                    )  # not the reference
                    found = sorted(known, key=lambda r: r["pixels"])
                    if found:
                        x, y = (
                            [1e3 * r["seconds"] for r in found],
                            [100 * r["error"] for r in found],
                        )
                        axes.loglog(x, y, label=method, **LOOKS[method])
                number = "$vR/D$" if what == "Hertz" else "$v/(Dq_r)$"
                axes.set_title(f"{what} contact, {number} = {peclet:g}")
                axes.axhline(1.0, color="0.6", lw=0.8, ls="--", zorder=0)
                decades(axes, y=(3e-3, 3e3))
        for axes in grid[-1]:
            axes.set_xlabel("CPU time of one field (ms)")
        figure.supylabel(r"error of $T_\mathrm{flash}$ (%)", fontsize=9)
        legend_below(figure, list(grid.flat), 2)
