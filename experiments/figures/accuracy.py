"""The figure of one contact in a run: errors over CPU time by tolerance, precision, pixel and way of the mean."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from matplotlib.axes import Axes

from roughsim.charts.style import plain_ticks

from .style import (
    AMBER,
    BLACK,
    BLUE,
    GREEN,
    LOOKS,
    ORANGE,
    PINK,
    SKY,
    decades,
    legend_below,
    new_figure,
)

Row = dict[str, Any]
# of methods without a colour of their own
OTHERS = BLUE, GREEN, BLACK, PINK, SKY, "0.45", "#882255", "#999933", AMBER
MARKERS = "s^oDv<>Ph"
TITLES = {
    "T_flash of these pixels": r"$T_\mathrm{flash}$ of one grid, by tolerance",
    "T_flash, any pixel": r"$T_\mathrm{flash}$ of one contact, by pixel",
    "T_flash of one realization": r"$T_\mathrm{flash}$ of one pressure field",
}


def one_contact(rows: list[Row], path: Path, source: str = "") -> None:
    """Draw the relative error over the CPU time, a panel for each stage and observable; stars as runs compute it."""
    panels = list(dict.fromkeys((row["stage"], row["observable"]) for row in rows))
    methods = [name for name in dict.fromkeys(row["method"] for row in rows) if name not in LOOKS]
    looks = LOOKS | {
        name: {"color": colour, "marker": marker}
        for name, colour, marker in zip(methods, OTHERS, MARKERS, strict=False)
    }
    with new_figure(path, 0.9 + 1.9 * len(panels), source) as figure:
        drawn = list(figure.subplots(len(panels), 1, squeeze=False).flat)
        for axes, (stage, observable) in zip(drawn, panels, strict=True):
            here = [
                row
                for row in rows
                if (row["stage"], row["observable"]) == (stage, observable) and row["error"] > 0
            ]
            for method in dict.fromkeys(row["method"] for row in here):
                draw(axes, [row for row in here if row["method"] == method], method, looks[method])
            star = {"ls": "", "marker": "*", "ms": 12, "mfc": "none", "mec": ORANGE}
            draw(axes, [row for row in here if row["chosen"]], "in runs", star)
            title = TITLES.get(observable, f"{stage}: {observable}")
            axes.set(title=title, ylabel="relative error", xscale="log", yscale="log")
            decades(axes)
            plain_ticks(axes.xaxis)
        drawn[-1].set_xlabel("CPU time (ms)")
        legend_below(figure, drawn, 2)


def draw(axes: Axes, rows: list[Row], label: str, look: dict[str, Any]) -> None:
    """Draw errors over times, in the order of the rows, which is that of tolerances or pixels."""
    times, errors = [1e3 * row["seconds"] for row in rows], [row["error"] for row in rows]
    axes.plot(times, errors, label=label, **look)
