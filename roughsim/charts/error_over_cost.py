"""Error over cost: one panel per observable, methods as lines, the front marked, and the choice of the plan."""

from collections.abc import Iterable, Sequence
from math import ceil, inf, log10, nan
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import NullFormatter

from roughsim.charts.style import new_figure

# Okabe & Ito without yellow, then greys and dark shades; the markers differ, too
_HUES = (
    "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00",
    "#222222", "#777777", "#AAAAAA", "#882255", "#44AA99", "#999933",
)  # fmt: skip
_SHAPES = "os^Dv<>PXphd"
_ACROSS = 3  # panels side by side
PAIR_SIDE = 512  # points per side of the transforms that costs are compared with


class CostPoint(NamedTuple):
    """One method at one setting: its relative error (NaN: it failed) and its cost. Points of one method form a line."""

    stage: str
    observable: str
    method: str
    setting: str
    error: float
    seconds: float  # CPU time of one thread
    chosen: bool = False  # whether the plan computes it so
    pairs: float = nan  # the same cost in pairs of real transforms of `PAIR_SIDE`² points
    uncertainty: float = (
        0.0  # how well the truth itself is known, relative; it is part of the error
    )


def panels(points: Iterable[CostPoint]) -> dict[str, list[CostPoint]]:
    """Return the points of each chart: one per stage and observable."""
    result: dict[str, list[CostPoint]] = {}
    for point in points:
        result.setdefault(f"{point.stage}: {point.observable}", []).append(point)
    return result


def front(points: Sequence[CostPoint]) -> list[CostPoint]:
    """Return the points that no other point beats in both cost and error, cheapest first; never a failure."""
    best, result = inf, []
    for point in sorted(points, key=lambda p: (p.seconds, p.error)):
        if point.error < best:
            best = point.error
            result.append(point)
    return result


def error_over_cost_chart(points: Iterable[CostPoint], path: Path) -> None:
    """Draw error over cost into one picture: a panel per stage and observable, the front, and the plan's choice."""
    charts = panels(points)
    across = 2 if len(charts) == 4 else min(len(charts), _ACROSS)
    down = ceil(len(charts) / across)
    with new_figure(path, (3.4 * across + 0.5, 3.7 * down)) as figure:
        axes = figure.subplots(down, across, squeeze=False).ravel()
        for axis, (title, group) in zip(axes, charts.items(), strict=False):
            _draw_panel(axis, group)
            axis.set_title(title)
            axis.set_xlabel(f"cost, FFT pairs of {PAIR_SIDE}²")
        for axis in axes[::across]:
            axis.set_ylabel("relative error")
        for axis in axes[len(charts) :]:
            axis.remove()
        # one legend for all panels if their methods are the same
        methods = [list(dict.fromkeys(p.method for p in group)) for group in charts.values()]
        if all(names == methods[0] for names in methods):
            handles, columns = axes[0].get_legend_handles_labels(), 3 if across > 1 else 2
            figure.legend(*handles, ncols=columns, fontsize=6.5, loc="outside lower center")
        else:
            for axis in axes[: len(charts)]:
                axis.legend(ncols=2, fontsize=6.5, loc="upper center", bbox_to_anchor=(0.5, -0.2))


def _draw_panel(axis: Axes, points: Sequence[CostPoint]) -> None:
    """Draw a line for each method, the front behind the lines, and a star at the choice of the plan."""
    for k, method in enumerate(dict.fromkeys(point.method for point in points)):
        of_method = (point for point in points if point.method == method and point.error > 0.0)
        line = sorted(of_method, key=lambda point: point.pairs)
        style: dict[str, Any] = {"color": _HUES[k % 12], "marker": _SHAPES[k % 12]}
        axis.plot(*_costs_and_errors(line), label=method, ms=3.5, lw=0.9, **style)
    best = _costs_and_errors(front(points))
    axis.plot(*best, color="k", lw=5, alpha=0.15, label="front", zorder=0)
    stars = _costs_and_errors([point for point in points if point.chosen])
    axis.plot(*stars, "*", ms=13, mfc="none", mec="k", label="choice of the plan", zorder=5)
    axis.set(xscale="log", yscale="log")
    axis.set_xlim(*_at_least_a_decade(*axis.get_xlim()))
    axis.set_ylim(*_at_least_a_decade(*axis.get_ylim()))
    # narrow panels have room for powers of ten alone
    axis.xaxis.set_minor_formatter(NullFormatter())
    if points[0].uncertainty > 0.0:
        grey: Any = {"color": "0.6", "lw": 0.8, "ls": "--", "zorder": -1}
        axis.axhline(points[0].uncertainty, label="uncertainty about the limit itself", **grey)
    _add_seconds(axis, points)


def _costs_and_errors(points: Iterable[CostPoint]) -> tuple[list[float], list[float]]:
    """Return the coordinates of points; those without an error have no place on a logarithmic axis."""
    drawn = [point for point in points if point.error > 0.0]
    return [point.pairs for point in drawn], [point.error for point in drawn]


def _at_least_a_decade(low: float, high: float) -> tuple[float, float]:
    """Return the ends of a logarithmic axis, widened until it shows a power of ten."""
    lacking = max(0.0, 1.05 - log10(high / low)) / 2
    return low / 10**lacking, high * 10**lacking


def _add_seconds(axis: Axes, points: Sequence[CostPoint]) -> None:
    """Add an axis in CPU seconds above, by the median time of a pair of transforms; none without costs."""
    rates = [point.seconds / point.pairs for point in points if point.pairs > 0.0]
    if not rates:
        return
    rate = float(np.median(rates))
    above = axis.twiny()
    above.set_xscale("log")
    above.set_xlim(*(rate * limit for limit in axis.get_xlim()))
    above.xaxis.set_minor_formatter(NullFormatter())
    above.set_xlabel("CPU s", fontsize=7)
    above.tick_params(labelsize=7)
    above.spines["top"].set_visible(True)
