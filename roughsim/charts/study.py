"""Figure of a study: curves over a varied number, and a map over two."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from roughsim.charts.style import (
    DASHES,
    THEORY,
    USUAL,
    Look,
    band,
    log_values,
    new_figure,
    no_formula,
    on_axis,
    plain_ticks,
    scale_colours,
)
from roughsim.grid import Array
from roughsim.results.theories import THEORIES
from roughsim.scene.numerics import SLIDING
from roughsim.show.table import shown, with_unit
from roughsim.table import AT_CUT_OFF, Estimate

_MOST_CURVES = 8  # of one panel: more cannot be distinguished
_DEVIATIONS = (
    -50.0,
    -30.0,
    -20.0,
    -10.0,
    -5.0,
    5.0,
    10.0,
    20.0,
    30.0,
    50.0,
    100.0,
)  # %, of the theory
_THEORIES: dict[str, Any] = dict(zip(THEORIES, ("-", DASHES, ":", "-."), strict=False))
_POINT: Any = {"color": THEORY, "ls": "", "ms": 3.5}  # in a legend, and over a map
_HOLLOW = "hollow: at $q_c$, or\na part of ± unknown"


class Along(NamedTuple):
    """A varied number along an axis: the name of the axis, its title, and the factor from SI to the unit there."""

    name: str
    title: str
    factor: float


class _Points(NamedTuple):
    """A column over a varied number, ascending, in the units of the figure; whole: extrapolated, with all errors."""

    x: Array
    value: Array
    error: Array
    whole: Array


def study_chart(
    path: Path,
    curves: Mapping[str, Estimate],
    x: Along,
    column: str,
    *,
    legend: str = "",
    title: str = "",
    subtitle: str = "",
    y: Along | None = None,
    look: Look = USUAL,
) -> None:
    """Draw an observable of a study over a varied number with its ratio to the theory, or a map over two numbers.

    Parameters
    ----------
    path : Path
        File of the picture: .png, .pdf or .svg.
    curves : mapping
        Label → an observable over the column and the varied numbers; NaN at points that do not belong to the curve.
    x, y : Along
        The varied numbers.
    column : str
        The simulated column.
    legend, title, subtitle : str
        Titles of the legend, of the figure and of the curves.
    look : Look
        Options of the figure.
    """
    compared = y is None and "theory" in {entry["column"] for entry in _entries(curves.values())}
    size = (10.0, 4.0) if y is not None else (5.4, 5.6 if compared else 4.0)
    with new_figure(path, size, no_formula(title), look) as figure:
        if compared:
            above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        else:
            above, *rest = figure.subplots(1, 1 if y is None else 2, squeeze=False)[0]
        drawn = _chosen(curves)
        _draw_curves(above, drawn, x, column, legend)
        above.set_title(subtitle)
        if compared:
            _draw_ratios(below, drawn, x, column)
            below.set_xlabel(above.get_xlabel())
            above.set_xlabel("")
        if y is not None:
            _draw_map(rest[0], curves, x, y, column)


def _entries(curves: Iterable[Estimate], column: str | None = None) -> list[dict[str, Any]]:
    """Return all entries of curves, or their entries in a column, as of `Estimate.rows`."""
    if column is not None:
        curves = [one.sel(column=[column]) for one in curves if column in one.coords["column"]]
    return [entry for one in curves for entry in one.rows()]


def _chosen(curves: Mapping[str, Estimate]) -> Mapping[str, Estimate]:
    """Return as many curves, evenly, as can be distinguished."""
    labels = list(curves)
    if len(labels) <= _MOST_CURVES:
        return curves
    places = np.linspace(0, len(labels) - 1, _MOST_CURVES).round().astype(int)
    return {labels[k]: curves[labels[k]] for k in places}


def _draw_ratios(axes: Axes, curves: Mapping[str, Estimate], x: Along, column: str) -> None:
    """Draw the calibrated theory, slides and the simulation with its error over the theory at the same points."""
    axes.axhline(1.0, color=THEORY, lw=0.9, zorder=0)
    for curve, colour in zip(curves.values(), scale_colours(len(curves)), strict=True):
        theory = _points(curve, x, "theory")
        law = _over(_points(curve, x, "calibrated"), theory)
        axes.plot(law.x, law.value, color=colour, lw=0.9, ls=_THEORIES["calibrated"])
        measured = _over(_points(curve, x, column), theory)
        _draw_points(axes, measured, "o", colour)
        _draw_points(axes, _over(_points(curve, x, SLIDING), theory), "D", colour)
        _draw_band(axes, measured, colour)
    axes.set(ylabel="over the theory")


def _over(points: _Points, theory: _Points) -> _Points:
    """Return points over those of the theory; NaN where it has none."""
    below = np.interp(points.x, theory.x, theory.value) if theory.x.size else np.nan
    with np.errstate(all="ignore"):  # of what is 0 in theory
        return points._replace(value=points.value / below, error=points.error / np.abs(below))


def _draw_curves(
    axes: Axes, curves: Mapping[str, Estimate], x: Along, column: str, legend: str
) -> None:
    """Draw each curve: simulation with its error, slide, and all theories. Hollow points have no line."""
    handles: list[Line2D] = []
    for label, colour in zip(curves, scale_colours(len(curves)), strict=True):
        for source, dashes in _THEORIES.items():
            theory = _points(curves[label], x, source)
            axes.plot(theory.x, theory.value, color=colour, lw=0.9, ls=dashes)
        measured = _points(curves[label], x, column)
        _draw_points(axes, measured, "o", colour)
        _draw_points(axes, _points(curves[label], x, SLIDING), "D", colour)
        _draw_band(axes, measured, colour)
        if label:
            handles.insert(0, Line2D([], [], color=colour, marker="o", ms=3.5, label=label))
    every = _entries(curves.values())
    _log_over_decades(axes, "x", [entry[x.name] for entry in every])
    if all(entry["value"] > 0.0 for entry in every if entry["column"] == column):
        log_values(axes)
    axes.set(xlabel=on_axis(x.title), ylabel=_title(curves))
    axes.legend(
        handles=handles + _common_handles(every, column),
        loc="center left",
        bbox_to_anchor=(1.0, 0.5),
        title=on_axis(legend),
        title_fontsize=8,
    )


def _title(curves: Mapping[str, Estimate]) -> str:
    """Return the title of the observable."""
    one = next(iter(curves.values()))
    return on_axis(with_unit(one.observable.replace("_", " "), one.unit))


def _log_over_decades(axes: Axes, axis: str, places: Iterable[float]) -> None:
    """Make an axis, "x" or "y", logarithmic if the highest of the places is far above the lowest."""
    places = sorted(places)
    if places[-1] > 5.0 * places[0] > 0.0:
        axes.set(**{f"{axis}scale": "log"})
        plain_ticks(getattr(axes, f"{axis}axis"))


def _draw_points(axes: Axes, points: _Points, marker: str, colour: Any) -> None:
    """Draw points with their errors; points at q_c or with unknown parts of the error are hollow."""
    for whole, face in ((True, colour), (False, "white")):
        drawn = points.whole == whole
        style = {
            "ls": "",
            "marker": marker,
            "ms": 3.5,
            "mfc": face,
            "color": colour,
            "elinewidth": 0.9,
            "zorder": 3,
        }
        axes.errorbar(points.x[drawn], points.value[drawn], points.error[drawn], **style)


def _draw_band(axes: Axes, points: _Points, colour: Any) -> None:
    """Draw a line through points with a complete error, and a band of it."""
    band(axes, points.x, np.where(points.whole, points.value, np.nan), points.error, colour)


def _common_handles(entries: list[dict[str, Any]], column: str) -> list[Line2D]:
    """Return the entries of the legend that hold for all curves."""
    drawn = {entry["column"] for entry in entries}
    handles = [
        Line2D([], [], marker="o", label=f"simulated ({column}),\n± total error, 95 %", **_POINT)
    ]
    for name, dashes in _THEORIES.items():
        if name in drawn:
            handles.append(Line2D([], [], color=THEORY, lw=0.9, ls=dashes, label=name))
    if SLIDING in drawn:
        handles.append(Line2D([], [], marker="D", label=SLIDING, **_POINT))
    if not all(map(_is_whole, entries)):
        handles.append(Line2D([], [], marker="o", mfc="white", label=_HOLLOW, **_POINT))
    return handles


def _is_whole(entry: Mapping[str, Any]) -> bool:
    """Return whether a value is extrapolated and has a complete error."""
    return not entry["unknown"] and entry["note"] != AT_CUT_OFF


def _points(curve: Estimate, x: Along, column: str) -> _Points:
    """Return the points of a column."""
    entries = sorted(_entries([curve], column), key=lambda entry: float(entry[x.name]))
    places, value, error = (
        np.array([entry[name] for entry in entries], float)
        for name in (x.name, "value", "total_error")
    )
    whole = np.array([_is_whole(entry) for entry in entries], bool)
    factor = shown(curve.unit)[1]
    # without bars where the error is unknown, or infinite as that of slope lengths at rest
    error = np.where(np.isfinite(error), error, 0.0)
    return _Points(places * x.factor, value * factor, error * factor, whole)


def _draw_map(axes: Axes, curves: Mapping[str, Estimate], x: Along, y: Along, column: str) -> None:
    """Draw contours of the simulation over two numbers, and of the deviation of the theory."""
    every, entries = _entries(curves.values()), _entries(curves.values(), column)
    at_x, at_y = (np.unique([entry[each.name] for entry in every]) for each in (x, y))
    simulated, theory = (
        _over_two(_entries(curves.values(), source), x, y, at_x, at_y)
        for source in (column, "theory")
    )
    values = simulated * shown(next(iter(curves.values())).unit)[1]
    plane = at_x * x.factor, at_y * y.factor
    filled = axes.contourf(*plane, values, 12, cmap="inferno")
    lines = axes.contour(*plane, values, 6, colors="white", linewidths=0.7)
    axes.clabel(lines, fmt="%.3g", fontsize=7)
    deviation = 100.0 * (theory / simulated - 1.0)
    known = deviation[np.isfinite(deviation)]  # reactions have no theory of the simple kind
    if known.size and known.min() < _DEVIATIONS[-1] and known.max() > _DEVIATIONS[0]:
        dashed = axes.contour(
            *plane, deviation, _DEVIATIONS, colors="#56B4E9", linestyles="--", linewidths=1.1
        )
        axes.clabel(dashed, fmt="%+g %%", fontsize=7)
    axes.figure.colorbar(filled, ax=axes, label=_title(curves))
    title = "Simulated; dashed: deviation of the theory"
    marked = [entry for entry in entries if not _is_whole(entry)]
    if marked:
        places = ([entry[each.name] * each.factor for entry in marked] for each in (x, y))
        axes.plot(*places, marker="o", mfc="white", clip_on=False, **_POINT)
        title += "\ncircles: at $q_c$, or a part of ± unknown"
    axes.set(xlabel=on_axis(x.title), ylabel=on_axis(y.title), title=title)
    _log_over_decades(axes, "x", at_x)
    _log_over_decades(axes, "y", at_y)


def _over_two(entries: list[dict[str, Any]], x: Along, y: Along, at_x: Array, at_y: Array) -> Array:
    """Return values over two numbers, (y, x); NaN at a missing point."""
    result = np.full((len(at_y), len(at_x)), np.nan)
    for entry in entries:
        place = np.searchsorted(at_y, entry[y.name]), np.searchsorted(at_x, entry[x.name])
        result[place] = entry["value"]
    return result
