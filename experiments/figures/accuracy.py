"""The figure of one contact in a run: errors over CPU time by tolerance, precision, pixel and way of the mean."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from roughsim.charts.style import legend_below, plain_ticks

from .style import BLUE, GREEN, LOOKS, ORANGE, PINK, SKY, decades, new_figure

Row = dict[str, Any]
OTHERS = (
    BLUE,
    GREEN,
    PINK,
    SKY,
    "0.45",
    "#882255",
    "#999933",
)  # methods without a colour of their own
MARKERS = "s^Dv<>P"
TITLES = {
    "T_flash of these pixels": "$T_{flash}$ of one grid, by tolerance",
    "T_flash, any pixel": "$T_{flash}$ of one contact, by pixel",
    "T_flash of one realization": "$T_{flash}$ of one pressure field",
}


def one_contact(rows: list[Row], path: Path, source: str = "") -> None:
    """Draw the relative error over the CPU time, a panel for each stage and observable; stars as runs compute it."""
    panels = list(dict.fromkeys((row["stage"], row["observable"]) for row in rows))
    with new_figure(path, 2.8 * len(panels), source) as figure:
        for axes, (stage, observable) in zip(figure.subplots(len(panels), 1), panels, strict=True):
            here = [
                row
                for row in rows
                if (row["stage"], row["observable"]) == (stage, observable) and row["error"] > 0
            ]
            methods = list(dict.fromkeys(row["method"] for row in here))
            for method, colour, marker in zip(methods, OTHERS, MARKERS, strict=False):
                line = sorted(
                    (row for row in here if row["method"] == method), key=lambda row: row["seconds"]
                )
                look = LOOKS.get(method, {"color": colour, "marker": marker})
                axes.loglog(
                    [1e3 * row["seconds"] for row in line],
                    [row["error"] for row in line],
                    label=method,
                    **look,
                )
            chosen = [row for row in here if row["chosen"]]
            star = {
                "ls": "",
                "marker": "*",
                "ms": 12,
                "mfc": "none",
                "mec": ORANGE,
                "label": "in runs",
            }
            axes.plot(
                [1e3 * row["seconds"] for row in chosen], [row["error"] for row in chosen], **star
            )
            axes.set(
                title=TITLES.get(observable, f"{stage}: {observable}"), ylabel="relative error"
            )
            decades(axes)
            plain_ticks(axes.xaxis)
            axes.set_xlabel("CPU time (ms)")
            legend_below(axes, columns=2)
