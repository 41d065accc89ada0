"""Heights, pressure and temperature on one line: along the sliding direction, through the hottest point."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from roughsim.charts.style import THEORY, Array, new_figure, scaled
from roughsim.charts.subject import FIELDS, Subject

COLOUR_OF = {"heights": "#0072B2", "pressure": THEORY, "temperature": "#D55E00"}
NEAR = 96  # points of the enlarged part on either side


def profile_chart(subject: Subject, path: Path) -> None:
    """Draw the whole line, and beside it the part around the hottest point; contact is shaded."""
    dx, dy = subject.grid.spacing
    hottest, across, lines = lines_through_hottest_point(subject)
    count = len(lines["heights"])
    parts = [np.arange(count)]
    if count > 6 * NEAR:
        parts.append(np.arange(hottest - NEAR, hottest + NEAR + 1))
    factor, unit = scaled(across * dy, "m")
    where = f"$y$ = {across * dy * factor:.4g} {unit}"
    title = subject.title(f"Along the sliding direction through the hottest point, {where}; contact shaded")
    with new_figure(path, (9.6, 5.6), title) as figure:
        panels = figure.subplots(3, len(parts), sharex="col", sharey="row", squeeze=False)
        for part, column in zip(parts, panels.T, strict=True):
            x = part * dx
            factor, unit = scaled(float(np.abs(x).max()), "m")
            x *= factor
            contact = (lines["pressure"].take(part, mode="wrap") > 0.0).astype(float)  # the cell is periodic
            for axes, (name, colour) in zip(column, COLOUR_OF.items(), strict=True):
                prefix, shown_unit = scaled(float(np.abs(lines[name]).max()), FIELDS[name].unit)
                values = lines[name].take(part, mode="wrap") * prefix
                axes.plot(x, values, color=colour, lw=0.9, ds="steps-mid" if name == "pressure" else "default")
                whole_height = axes.get_xaxis_transform()
                axes.fill_between(x, 0, contact, step="mid", color="0.87", lw=0, transform=whole_height, zorder=0)
                axes.margins(x=0.0)
                if part is parts[0]:
                    axes.set_ylabel(f"{FIELDS[name].symbol}, {shown_unit}")
            column[-1].set_xlabel(f"$x$, {unit}")
        if len(parts) > 1:
            panels[0, 1].set_title("enlarged", color="0.3")


def lines_through_hottest_point(subject: Subject) -> tuple[int, int, dict[str, Array]]:
    """Return the indices of the hottest point along x and y, and the three fields on the line along x through it."""
    temperature = subject.field("temperature")
    hottest, across = (int(i) for i in np.unravel_index(int(temperature.argmax()), temperature.shape))
    lines = {name: subject.field(name)[:, across].copy() for name in ("heights", "pressure")}
    return hottest, across, lines | {"temperature": temperature[:, across].copy()}
