"""A study as a figure: curves over one varied number, and a map over two."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from roughsim.charts.style import THEORY, band, new_figure, plain_ticks
from roughsim.grid import Array
from roughsim.observables.catalogue import UNITS
from roughsim.results.marks import is_whole
from roughsim.scene.numerics import SLIDING
from roughsim.show.table import shown, with_unit
from roughsim.show.text import plain

DARKEST, BRIGHTEST = 0.0, 0.85  # of the colours of curves; the end of the scale is too pale for paper
MOST_CURVES = 8  # of one panel: more cannot be told apart
OFF = (-50.0, -30.0, -20.0, -10.0, -5.0, 5.0, 10.0, 20.0, 30.0, 50.0, 100.0)  # %, of the theory, as lines on a map
HOLLOW = "hollow: at $q_c$, or\na part of ± unknown"
DASHES: Any = (0, (4, 2))
Rows = Sequence[dict[str, Any]]


def study_chart(
    rows: Rows, keys: dict[str, tuple[str, float]], column: str, observable: str, path: Path, *, title: str = ""
) -> None:
    """Draw an observable of a study: curves over the first key, and a map over the first two.

    `rows` are those of the tidy table. `keys` are the varied numbers: name → the words of an axis, and the factor from
    SI to its unit. Curves are those of the speeds where one number is varied, else of the second one at the highest
    speed of each point. ValueError if no number is varied, or nothing is there to draw.
    """
    rows = [row for row in rows if row["observable"] == observable]
    if not keys or not rows:
        what = "no varied key is a number" if not keys else f"no point has {observable} yet"
        raise ValueError(f"there is nothing to draw: {what}")
    highest: dict[str, float] = {}  # speed of each point
    for row in rows:
        if row["speed"] is not None:
            highest[row["point"]] = max(row["speed"], highest.get(row["point"], 0.0))
    at_highest = [row for row in rows if row["speed"] == highest.get(row["point"])]
    names = [*keys]
    mapped = len(keys) > 1 and all(len({row[name] for row in rows}) > 2 for name in names[:2])
    with new_figure(path, (10.0 if mapped else 5.4, 4.0), plain(title).replace("$", r"\$")) as figure:
        panels = figure.subplots(1, 2 if mapped else 1, squeeze=False)[0]
        if len(keys) == 1:
            draw_curves(panels[0], rows, keys, names[0], "speed", column, observable)
        else:
            draw_curves(panels[0], at_highest, keys, names[0], names[1], column, observable)
            if len({*highest.values()}) == 1:
                panels[0].set_title(f"at {at_highest[0]['speed']:g} m/s")
        if mapped:
            draw_map(panels[1], at_highest, keys, column, observable)


def draw_curves(
    axes: Axes, rows: Rows, keys: dict[str, tuple[str, float]], x: str, family: str, column: str, observable: str
) -> None:
    """Draw a curve for each value of `family`: simulation with its error, the slide if there is one, both theories.

    Markers are hollow where the value is at q_c or a part of its error is unknown: no line leads there.
    """
    words, factor = keys[x]
    in_unit = shown(UNITS[observable])[1]
    values = sorted({row[family] for row in rows if row[family] is not None}) or [None]
    if len(values) > MOST_CURVES:
        values = [values[k] for k in np.linspace(0, len(values) - 1, MOST_CURVES).round().astype(int)]
    colours = mpl.colormaps["viridis"](np.linspace(DARKEST, BRIGHTEST, len(values)))
    handles: list[Any] = []
    of_what, in_family_unit = ("speed, m/s", 1.0) if family == "speed" else keys[family]
    for value, colour in zip(values, colours, strict=True):
        same = [row for row in rows if row[family] == value]
        for source, style in (("theory", "-"), ("calibrated", DASHES)):
            at, mean, *_ = curve(same, x, source)
            axes.plot(at * factor, mean * in_unit, color=colour, lw=0.9, ls=style)
        measured = curve(same, x, column)
        draw_points(axes, measured, factor, in_unit, "o", colour)
        draw_points(axes, curve(same, x, SLIDING), factor, in_unit, "D", colour)
        at, mean, error, whole = measured
        band(axes, at * factor, np.where(whole, mean, np.nan) * in_unit, error * in_unit, colour)
        if value is not None:
            handles.insert(0, Line2D([], [], color=colour, marker="o", ms=3.5, label=f"{value * in_family_unit:.4g}"))
    ordered = sorted({row[x] for row in rows})
    if ordered[0] > 0.0 and ordered[-1] > 5.0 * ordered[0]:
        axes.set_xscale("log")
        plain_ticks(axes.xaxis)
    low = min((row["value"] for row in rows if row["column"] == column), default=1.0)
    if low > 0.0:
        axes.set_yscale("log")
        bottom, top = axes.get_ylim()
        if top / bottom < 100.0:
            plain_ticks(axes.yaxis)
    axes.set(xlabel=words, ylabel=with_unit(observable.replace("_", " "), UNITS[observable]))
    handles += meanings_of_lines(rows)
    axes.legend(handles=handles, loc="center left", bbox_to_anchor=(1.0, 0.5), title=of_what, title_fontsize=8)


def draw_points(
    axes: Axes, points: tuple[Array, Array, Array, Array], factor: float, in_unit: float, marker: str, colour: Any
) -> None:
    """Draw what `curve` returned as points with their errors, hollow where they are not whole."""
    at, mean, error, whole = points
    for kind, face in ((True, colour), (False, "white")):
        of_kind = whole == kind
        x, y, half_width = at[of_kind] * factor, mean[of_kind] * in_unit, error[of_kind] * in_unit
        axes.errorbar(x, y, half_width, ls="", marker=marker, ms=3.5, mfc=face, color=colour, elinewidth=0.9, zorder=3)


def meanings_of_lines(rows: Rows) -> list[Line2D]:
    """Return the entries of the legend that hold for all curves."""
    point: Any = {"color": THEORY, "ls": "", "ms": 3.5}
    handles = [
        Line2D([], [], color=THEORY, lw=0.9, label="theory"),
        Line2D([], [], color=THEORY, lw=0.9, ls=DASHES, label="calibrated"),
    ]
    if any(row["column"] == SLIDING for row in rows):
        handles.append(Line2D([], [], marker="D", label=SLIDING, **point))
    if not all(is_whole(row["unknown"], row["note"]) for row in rows):
        handles.append(Line2D([], [], marker="o", mfc="white", label=HOLLOW, **point))
    return handles


def curve(rows: Rows, x: str, column: str) -> tuple[Array, Array, Array, Array]:
    """Return the places, values and errors of a column, ascending, and where they are whole.

    Points that share a place have their mean.
    """
    of_column = [row for row in rows if row["column"] == column]
    places = sorted({row[x] for row in of_column})
    groups = [[row for row in of_column if row[x] == place] for place in places]
    value, error = (
        np.array([np.mean([row[name] for row in group]) for group in groups]) for name in ("value", "total_error")
    )
    whole = np.array([all(is_whole(row["unknown"], row["note"]) for row in group) for group in groups], bool)
    return np.array(places, float), value, np.nan_to_num(error), whole


def draw_map(axes: Axes, rows: Rows, keys: dict[str, tuple[str, float]], column: str, observable: str) -> None:
    """Draw contours of the simulation over the first two keys, and of how far the theory is off."""
    (x, (x_words, x_factor)), (y, (y_words, y_factor)) = [*keys.items()][:2]
    in_unit = shown(UNITS[observable])[1]
    at_x, at_y = (np.array(sorted({row[name] for row in rows})) for name in (x, y))
    values, theory = (table(rows, x, y, at_x, at_y, source) for source in (column, "theory"))
    filled = axes.contourf(at_x * x_factor, at_y * y_factor, values * in_unit, 12, cmap="inferno")
    lines = axes.contour(at_x * x_factor, at_y * y_factor, values * in_unit, 6, colors="white", linewidths=0.7)
    axes.clabel(lines, fmt="%.3g", fontsize=7)
    off = 100.0 * (theory / values - 1.0)
    if np.nanmin(off) < OFF[-1] and np.nanmax(off) > OFF[0]:
        dashed = axes.contour(
            at_x * x_factor, at_y * y_factor, off, OFF, colors="#56B4E9", linestyles="--", linewidths=1.1
        )
        axes.clabel(dashed, fmt="%+g %%", fontsize=7)
    axes.figure.colorbar(filled, ax=axes, label=with_unit(observable.replace("_", " "), UNITS[observable]))
    title = "Simulated; dashed: theory over it"
    marked = [row for row in rows if row["column"] == column and not is_whole(row["unknown"], row["note"])]
    if marked:
        places = ([row[name] * unit for row in marked] for name, unit in ((x, x_factor), (y, y_factor)))
        axes.plot(*places, ls="", marker="o", ms=3.5, mfc="white", color=THEORY, clip_on=False)
        title += "\ncircles: at $q_c$, or a part of ± unknown"
    axes.set(xlabel=x_words, ylabel=y_words, title=title)
    for at, set_scale, axis in ((at_x, axes.set_xscale, axes.xaxis), (at_y, axes.set_yscale, axes.yaxis)):
        if at[0] > 0.0 and at[-1] > 5.0 * at[0]:
            set_scale("log")
            plain_ticks(axis)


def table(rows: Rows, x: str, y: str, at_x: Array, at_y: Array, column: str) -> Array:
    """Return the values of a column over two keys, (y, x); NaN where a point is missing."""
    result = np.full((len(at_y), len(at_x)), np.nan)
    for row in rows:
        if row["column"] == column:
            result[np.searchsorted(at_y, row[y]), np.searchsorted(at_x, row[x])] = row["value"]
    return result
