"""Heights, pressure and temperature on one line: along the sliding direction, through the hottest point."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughsim.charts.style import THEORY, Array, new_figure, save, scaled

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from roughsim.charts.pictures import Subject

LINES = {
    "heights": ("$h$", "m", "#0072B2"),
    "pressure": (r"$\sigma$", "Pa", THEORY),
    "temperature": ("$T$", "K", "#D55E00"),
}
_NEAR = 96  # points of the enlarged part on either side


def profile_chart(subject: Subject, path: Path) -> None:
    """Draw the whole line, and beside it the part around the hottest point; contact is shaded.

    Parameters
    ----------
    subject : Subject
        Which member, and its speed.
    path : Path
        Of the picture.
    """
    spacing = subject.run.numerics.grid(subject.level).spacing
    hottest, across, lines = _lines(subject)
    points = len(lines["heights"])
    parts = [np.arange(points)]
    if points > 6 * _NEAR:
        parts.append(np.arange(hottest - _NEAR, hottest + _NEAR + 1))
    with new_figure(path, (9.6, 5.6)) as figure:
        axes = figure.subplots(3, len(parts), sharex="col", sharey="row", squeeze=False)
        for part, panels in zip(parts, axes.T, strict=True):
            _column(list(panels), lines, part, spacing[0])
        for panel, (name, (symbol, unit, _)) in zip(axes[:, 0], LINES.items(), strict=True):
            panel.set_ylabel(f"{symbol}, {scaled(float(np.abs(lines[name]).max()), unit)[1]}")
        if len(parts) > 1:
            axes[0, 1].set_title("enlarged", color="0.3")
        factor, unit = scaled(across * spacing[1], "m")
        place = f"$y$ = {across * spacing[1] * factor:.4g} {unit}"
        what = f"Along the sliding direction through the hottest point, {place}; contact shaded"
        figure.suptitle(subject.title(what), fontsize=9, x=0.01, ha="left")
        save(figure, path)


def _lines(subject: Subject) -> tuple[int, int, dict[str, Array]]:
    """Where the hottest point is, and the three fields on the line along x through it."""
    temperature = subject.field("temperature")
    hottest, across = (int(i) for i in np.unravel_index(int(temperature.argmax()), temperature.shape))
    lines = {name: subject.field(name)[:, across].copy() for name in ("heights", "pressure")}
    return hottest, across, lines | {"temperature": temperature[:, across].copy()}


def _column(panels: list[Axes], lines: dict[str, Array], part: NDArray[np.intp], step: float) -> None:
    """Three panels over one stretch of the line; the cell is periodic."""
    x = part * step
    factor, unit = scaled(float(np.abs(x).max()), "m")
    contact = (lines["pressure"].take(part, mode="wrap") > 0.0).astype(float)
    for panel, (name, (_, own, colour)) in zip(panels, LINES.items(), strict=True):
        prefix = scaled(float(np.abs(lines[name]).max()), own)[0]
        values = lines[name].take(part, mode="wrap") * prefix
        panel.plot(x * factor, values, color=colour, lw=0.9, ds="steps-mid" if name == "pressure" else "default")
        place: Any = {"transform": panel.get_xaxis_transform(), "zorder": 0}
        panel.fill_between(x * factor, 0, contact, step="mid", color="0.87", lw=0, **place)
        panel.margins(x=0.0)
    panels[-1].set_xlabel(f"$x$, {unit}")
