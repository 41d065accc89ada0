"""Snapshots of a slide in print: pressure and temperature at a few slid distances, side by side."""

from pathlib import Path

import numpy as np

from roughsim.charts.maps import colour_bar, colour_range, draw_field
from roughsim.charts.style import AT_REST, FIELDS, MARK, Subject, new_figure, scaled
from roughsim.grid import Array
from roughsim.results.snapshots import read_snapshots

_SHOWN = 4  # positions


def snapshots_chart(subject: Subject, path: Path) -> None:
    """Draw a quarter of the cell at the first and the last position and between, with the summits of both faces."""
    snapshots = read_snapshots(subject.run, subject.index or 0)
    k = subject.run.scene.speeds.index(subject.speed or 0.0)
    places = np.rint(np.linspace(0, snapshots.positions(k) - 1, _SHOWN)).astype(int)
    x, y = ((points + 1) // 2 for points in snapshots.grid.shape)
    window = slice(0, x), slice(0, y)
    ends = (np.array([x, y]) - 0.5) * snapshots.grid.spacing
    metres = scaled(float(ends.max()), "m")[0]  # of the axes
    rows = {"pressure": snapshots.maps.pressure, "temperature": snapshots.maps.temperature[k]}
    words = "Both faces slide. Triangles: highest summits of the face at rest; circles: of the face that moves to the left"
    with new_figure(path, (11.6, 6.0), subject.title(words), subject.look) as figure:
        panels = figure.subplots(2, _SHOWN, sharex=True, sharey=True)
        for line, (name, maps) in zip(panels, rows.items(), strict=True):
            _, symbol, si_unit = FIELDS[name]
            shown: Array = maps[places].astype(float)
            factor, prefixed = scaled(float(np.abs(shown).max()), si_unit)
            shown *= factor
            for axes, field, place in zip(line, shown, places, strict=True):
                colours = colour_range(name, shown)
                image = draw_field(axes, field, snapshots.grid, window, colours, bar=False)
                for summits, marker, colour in (
                    (snapshots.resting_summits, "^", AT_REST),
                    (snapshots.moving_summits[place], "o", MARK),
                ):
                    inside = summits[(summits < ends).all(axis=1)] * metres
                    axes.plot(*inside.T, marker, ms=5, mfc="none", mec=colour, mew=1.2)
                if name == "pressure":
                    slid = float(snapshots.maps.distance[place])
                    prefix, unit = scaled(slid, "m")
                    axes.set_title(f"after {prefix * slid:.3g} {unit}")
            above = " above the background" if name == "temperature" else ""
            colour_bar(figure, image, list(line), f"{symbol}{above} ({prefixed})", "right")
        for axes in panels.ravel():
            axes.label_outer()
