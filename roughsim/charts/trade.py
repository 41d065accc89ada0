"""Error over cost: one panel per observable, methods as lines, the front marked, and the choice of the plan."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from roughsim.charts.style import new_figure, save

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Okabe & Ito without yellow, then greys
_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#222222", "#777777", "#AAAAAA")
_MARKERS = "os^Dv<>PX"
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
        Relative error of the truth itself, by title: errors below it say nothing.
    pair : str, optional
        Name of the unit of cost.
    """
    across = min(len(panels), _ACROSS)
    down = ceil(len(panels) / across)
    with new_figure(path, (3.3 * across + 0.4, 3.9 * down)) as figure:
        axes = figure.subplots(down, across, squeeze=False).ravel()
        for axis, (title, points) in zip(axes, panels.items(), strict=False):
            _panel(axis, points, fronts[title], (known or {}).get(title, 0.0))
            axis.set_title(title)
            axis.set_xlabel(f"cost, {pair}")
        for axis in axes[:: across or 1]:
            axis.set_ylabel("relative error")
        for axis in axes[len(panels) :]:
            axis.remove()
        save(figure, path)


def _panel(axis: Axes, points: Sequence[Priced], front: Sequence[Priced], known: float) -> None:
    for k, method in enumerate(dict.fromkeys(point.method for point in points)):
        line = sorted((p for p in points if p.method == method and p.error > 0.0), key=lambda p: p.pairs)
        style: dict[str, Any] = {"color": _COLOURS[k % 9], "marker": _MARKERS[k % 9], "ms": 3.5, "lw": 0.9}
        axis.plot([p.pairs for p in line], [p.error for p in line], label=method, **style)
    shown = [p for p in front if p.error > 0.0]
    axis.plot([p.pairs for p in shown], [p.error for p in shown], color="k", lw=4, alpha=0.15, label="front", zorder=0)
    for point in (p for p in points if p.chosen and p.error > 0.0):
        label = "choice of the plan" if "choice of the plan" not in axis.get_legend_handles_labels()[1] else None
        axis.plot(point.pairs, point.error, "*", ms=13, mfc="none", mec="k", label=label, zorder=5)
    axis.set(xscale="log", yscale="log")
    if known > 0.0:
        low = axis.get_ylim()[0]
        axis.axhspan(min(low, known / 2), known, color="0.93", lw=0, zorder=-1)
        axis.text(
            0.99,
            known,
            "error of the truth",
            ha="right",
            va="top",
            fontsize=7,
            color="0.4",
            transform=axis.get_yaxis_transform(),
        )
    _costs_above(axis, points)
    axis.legend(fontsize=6.5, loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=2 if len(axis.lines) > 5 else 1)


def _costs_above(axis: Axes, points: Sequence[Priced]) -> None:
    """A second axis in CPU seconds."""
    timed = [p for p in points if p.pairs > 0.0]
    if timed:
        rate = float(np.median([p.seconds / p.pairs for p in timed]))
        above = axis.secondary_xaxis("top", functions=(lambda x: x * rate, lambda x: x / rate))
        above.set_xlabel("CPU s", fontsize=7)
        above.tick_params(labelsize=7)


__all__ = ["Priced", "trade_chart"]
