"""The figure of a contact of finite size: U over Pe, and the temperature of the steel contact over time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from .style import BLACK, BLUE, GREEN, SKY, decades, new_figure

RISES = {
    "steady": (BLUE, "-"),
    "steady, on a track of 8 a": (GREEN, "-"),
    "Dt = 0.1 a²": (SKY, "--"),
    "Dt = 0.01 a²": (SKY, ":"),
}
TOTALS = {
    "endless planes": (BLACK, "--"),
    "disc of 3 mm": (BLUE, "-"),
    "on a track of 25 mm": (GREEN, "-"),
}


def finite_contact(rows: list[dict[str, Any]], path: Path, source: str = "") -> None:
    """Draw the mean temperature of a disc over Pe, and T₀ + T_flash of the steel contact over the time of sliding."""
    with new_figure(path, 3.6, source) as figure:
        left, right = figure.subplots(1, 2)
        panels = (left, RISES, "peclet", "rise"), (right, TOTALS, "time", "total")
        for axes, looks, x, y in panels:
            for name, (colour, style) in looks.items():
                found = [row for row in rows if row["curve"] == name]
                axes.loglog(
                    [r[x] for r in found], [r[y] for r in found], c=colour, ls=style, label=name
                )
        left.set_title(r"mean $T$ of a disc, $\dot{q}a/\kappa$")
        left.set_xlabel("$va/D$")
        decades(left, x=(1e-2, 1e4), y=(5e-3, 1.3))
        right.set_title(r"steel at 1 m/s: $T_0 + T_\mathrm{flash}$ (K)")
        right.set_xlabel("time of sliding (s)")
        decades(right, x=(1e-5, 1e4), y=(10, 1e5))
        for axes in (left, right):
            axes.legend(loc="upper center", bbox_to_anchor=(0.45, -0.2))
