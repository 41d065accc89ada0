"""How temperature is distributed over the contact of one member."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from roughsim.charts.style import COLOURS, new_figure, save
from roughsim.heat.statistics import ContactTemperature, contact_temperature

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from roughsim.charts.pictures import Subject

_BINS = 80
AREA = "0.75"


def distribution_chart(subject: Subject, path: Path) -> None:
    """Draw the density of temperature by area and by heat, and the shares that are hotter than a temperature.

    Raises
    ------
    ValueError
        If the member has no contact.
    """
    pressure = subject.field("pressure")
    if not pressure.any():
        raise ValueError(f"realization {subject.index} has no contact; there is no temperature of it to draw")
    found = contact_temperature(subject.field("temperature"), pressure)
    with new_figure(path, (9.6, 3.9)) as figure:
        left, right = figure.subplots(1, 2)
        _density(left, found, COLOURS[subject.column])
        _hotter(right, found, COLOURS[subject.column])
        what = (
            rf"Temperature in the contact: $\langle T\sigma\rangle/\langle\sigma\rangle$ = "
            f"{found.flash_temperature:.4g} K (dashed), mean {found.mean_temperature:.4g} K, "
            f"highest {found.max_temperature:.4g} K"
        )
        figure.suptitle(subject.title(what), fontsize=9, x=0.01, ha="left")
        save(figure, path)


def _density(axes: Axes, found: ContactTemperature, colour: str) -> None:
    values, heat = found.temperatures, np.diff(found.cooler, prepend=0.0)
    edges = np.linspace(values[0], max(values[-1], values[0] + 1e-9), _BINS + 1)
    percent = 100.0 / (edges[1] - edges[0])
    area = np.histogram(values, edges)[0] / values.size * percent
    axes.stairs(area, edges, fill=True, color=AREA, label="of the area")
    axes.stairs(
        np.histogram(values, edges, weights=heat)[0] * percent, edges, color=colour, lw=1.2, label="of the heat"
    )
    axes.axvline(found.flash_temperature, color=colour, lw=1.0, ls="--")
    axes.set(xlabel="$T$, K", ylabel="% per K", title="Density")
    axes.set_ylim(bottom=0.0)
    axes.legend(loc="upper right")


def _hotter(axes: Axes, found: ContactTemperature, colour: str) -> None:
    values, n = found.temperatures, found.temperatures.size
    few = np.unique(np.linspace(0, n - 1, 2000).astype(np.intp))  # of up to millions of points
    axes.plot(values[few], 100.0 * (1.0 - (few + 1) / n), color="0.5", lw=1.2)
    axes.plot(values[few], 100.0 * (1.0 - found.cooler[few]), color=colour, lw=1.2)
    axes.axvline(found.flash_temperature, color=colour, lw=1.0, ls="--")
    axes.set(xlabel="$T$, K", ylabel="% hotter than $T$", title="Share that is hotter", ylim=(0.0, 100.0))
