"""The one style of the figures of evidence: width, fonts, a colour for each method, notes on their data.

A figure is 5.2 inches wide and has two panels side by side at most. So its letters have 9 px on a telephone of 390 px.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, LogLocator, NullFormatter

from roughsim.charts.style import letter

WIDTH, DPI = 5.2, 200  # inches, points per inch
ORANGE, BLUE, GREEN, PINK, SKY, AMBER, BLACK = (
    "#D55E00",
    "#0072B2",
    "#009E73",
    "#CC79A7",
    "#56B4E9",
    "#E69F00",
    "#222222",
)  # Okabe & Ito
LOOKS: dict[str, dict[str, Any]] = {  # of each method, in all figures
    "roughsim": {"color": ORANGE, "marker": "o", "lw": 1.8},
    "home-made": {"color": BLACK, "marker": "v"},
    "aspher": {"color": AMBER, "marker": "P"},
    "tamaas": {"color": BLUE, "marker": "s"},
    "ContactMechanics": {"color": GREEN, "marker": "^"},
    "NuMPI": {"color": PINK, "marker": "D"},
    "plain script": {"color": PINK, "marker": "D"},
    "one grid, 2 pixels": {"color": SKY, "marker": "<"},
    "one grid, 4 pixels": {"color": BLUE, "marker": "s"},
    "one grid, 8 pixels": {"color": "#00395A", "marker": ">"},
    "paper's theory": {"color": BLACK, "marker": "X"},
    "calibrated law": {"color": GREEN, "marker": "P"},
    "periodic, steady": {"color": AMBER, "marker": "^"},
    "periodic, from rest": {"color": BLUE, "marker": "s"},
    "free half-space": {"color": GREEN, "marker": "D"},
    "mean over directions": {"color": ORANGE, "marker": "o", "lw": 1.8},
}
HARDNESS = {0.5e9: GREEN, 1.2e9: BLUE, 2.0e9: ORANGE}  # Pa, of the paper's steels, in its colours
SPEEDS = "#440154", "#31688E", "#35B779", "#C8A800"  # from slow to fast
_STYLE: Any = {
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.labelsize": 9,
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
    "legend.fontsize": 8.5,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "0.92",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "lines.linewidth": 1.1,
    "lines.markersize": 3.6,
    "xtick.direction": "in",
    "ytick.direction": "in",
}


@contextmanager
def new_figure(path: Path, height: float, source: str = "") -> Iterator[Figure]:
    """Yield an empty figure of a height in inches; at the end its panels are lettered and it is written."""
    with mpl.rc_context(_STYLE):
        figure = Figure((WIDTH, height), dpi=DPI, layout="constrained")
        yield figure
        letter(figure)
        figure.savefig(path, metadata={"Description": source, "Software": None})


def legend_below(figure: Figure, axes: list[Axes], columns: int) -> None:
    """Put one legend of all panels below them, in the order of `LOOKS`."""
    handles = {
        label: handle
        for panel in axes
        for handle, label in zip(*panel.get_legend_handles_labels(), strict=True)
    }
    names = sorted(
        handles, key=lambda name: list(LOOKS).index(name) if name in LOOKS else len(LOOKS)
    )
    figure.legend(
        [handles[name] for name in names],
        names,
        loc="outside lower center",
        ncols=columns,
        columnspacing=1.4,
    )


def decades(
    axes: Axes, *, x: tuple[float, float] | None = None, y: tuple[float, float] | None = None
) -> None:
    """Set limits of logarithmic axes, with a tick for each decade, or each second one of many."""
    for axis, limits in ((axes.xaxis, x), (axes.yaxis, y)):
        if limits is not None:
            axis.axes.set(**{f"{axis.axis_name}lim": limits})
        axis.set_major_locator(LogLocator(numticks=7))
        axis.set_minor_formatter(NullFormatter())


def plain_sizes(axes: Axes, sizes: list[int]) -> None:
    """Write points per side as 256², …"""
    axes.xaxis.set_major_locator(FixedLocator(sizes))
    axes.set_xticklabels([f"{size}²" for size in sizes])
    axes.xaxis.set_minor_locator(FixedLocator([]))
