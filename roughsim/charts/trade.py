"""Error over cost: one panel per observable, methods as lines, the front marked, and the choice of the plan."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import ceil, log10
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from roughsim.charts.style import new_figure, save

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Okabe & Ito without yellow, then greys and dark shades; the markers tell them apart as well
_COLOURS = (
    "#0072B2",
    "#D55E00",
    "#009E73",
    "#CC79A7",
    "#56B4E9",
    "#E69F00",
    "#222222",
    "#777777",
    "#AAAAAA",
    "#882255",
    "#44AA99",
    "#999933",
)
_MARKERS = "os^Dv<>PXphd"
_ACROSS = 3  # panels side by side


class Priced(Protocol):
    """What a chart asks of a point."""

    @property
    def method(self) -> str:
        """Points of one method form a line."""

    @property
    def error(self) -> float:
        """Relative error; NaN: failed."""

    @property
    def seconds(self) -> float:
        """CPU seconds."""

    @property
    def pairs(self) -> float:
        """The same in pairs of transforms."""

    @property
    def chosen(self) -> bool:
        """Whether it is the choice of the plan."""


def trade_chart(
    panels: Mapping[str, Sequence[Priced]],
    fronts: Mapping[str, Sequence[Priced]],
    path: Path,
    *,
    known: Mapping[str, float] | None = None,
    pair: str = "FFT pairs",
) -> None:
    """Draw error over cost.

    Parameters
    ----------
    panels, fronts : mapping of str to points
        By title: all points, and those that no other one beats.
    path : Path
        The picture: .png, .pdf or .svg.
    known : mapping of str to float, optional
        Relative doubt about the truth itself, by title; it is part of every error.
    pair : str, optional
        Name of the unit of cost.
    """
    across = 2 if len(panels) == 4 else min(len(panels), _ACROSS)
    down = ceil(len(panels) / across)
    with new_figure(path, (3.4 * across + 0.5, 3.7 * down)) as figure:
        axes = figure.subplots(down, across, squeeze=False).ravel()
        for axis, (title, points) in zip(axes, panels.items(), strict=False):
            _panel(axis, points, fronts[title], (known or {}).get(title, 0.0))
            axis.set_title(title)
            axis.set_xlabel(f"cost, {pair}")
        for axis in axes[::across]:
            axis.set_ylabel("relative error")
        for axis in axes[len(panels) :]:
            axis.remove()
        if len({_methods(points) for points in panels.values()}) == 1:
            _legend(figure, axes[0], {"loc": "outside lower center"}, 3 if across > 1 else 2)
        else:
            for axis in axes[: len(panels)]:
                _legend(axis, axis, {"loc": "upper center", "bbox_to_anchor": (0.5, -0.2)}, 2)
        save(figure, path)


def _panel(axis: Axes, points: Sequence[Priced], front: Sequence[Priced], known: float) -> None:
    for k, method in enumerate(_methods(points)):
        line = sorted((p for p in points if p.method == method and p.error > 0.0), key=lambda p: p.pairs)
        style: dict[str, Any] = {"color": _COLOURS[k % 12], "marker": _MARKERS[k % 12], "ms": 3.5, "lw": 0.9}
        axis.plot([p.pairs for p in line], [p.error for p in line], label=method, **style)
    shown = [p for p in front if p.error > 0.0]
    axis.plot([p.pairs for p in shown], [p.error for p in shown], color="k", lw=5, alpha=0.15, label="front", zorder=0)
    stars = [p for p in points if p.chosen and p.error > 0.0]
    xy = [p.pairs for p in stars], [p.error for p in stars]
    axis.plot(*xy, "*", ms=13, mfc="none", mec="k", label="choice of the plan", zorder=5)
    axis.set(xscale="log", yscale="log")
    for limits, change in ((axis.get_xlim(), axis.set_xlim), (axis.get_ylim(), axis.set_ylim)):
        change(*_a_decade(*limits))
    _powers_of_ten(axis)
    if known > 0.0:
        axis.axhline(known, color="0.6", lw=0.8, ls="--", zorder=-1, label="doubt about the limit itself")
    _costs_above(axis, points)


def _powers_of_ten(axis: Axes) -> None:
    """Label the costs at powers of ten alone: narrow panels have no room for more."""
    from matplotlib.ticker import NullFormatter

    axis.xaxis.set_minor_formatter(NullFormatter())


def _methods(points: Sequence[Priced]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(point.method for point in points))


def _a_decade(low: float, high: float) -> tuple[float, float]:
    """Widen limits to a decade at least, so that an axis has a power of ten to be read by."""
    short = max(0.0, 1.05 - log10(high / low)) / 2
    return low / 10**short, high * 10**short


def _legend(holder: Axes | Figure, axis: Axes, below: dict[str, Any], columns: int) -> None:
    handles, labels = axis.get_legend_handles_labels()
    holder.legend(handles, labels, ncols=columns, fontsize=6.5, **below)


def _costs_above(axis: Axes, points: Sequence[Priced]) -> None:
    """A second axis in CPU seconds."""
    timed = [p for p in points if p.pairs > 0.0]
    if timed:
        rate = float(np.median([p.seconds / p.pairs for p in timed]))
        above = axis.twiny()
        above.set_xscale("log")
        above.set_xlim(*(rate * limit for limit in axis.get_xlim()))
        _powers_of_ten(above)
        above.set_xlabel("CPU s", fontsize=7)
        above.tick_params(labelsize=7)
        above.spines["top"].set_visible(True)


__all__ = ["Priced", "trade_chart"]
