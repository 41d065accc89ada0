"""How temperature is distributed over the contact of one realization."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from roughsim.charts.style import COLOURS, Array, new_figure
from roughsim.charts.subject import Subject
from roughsim.heat.statistics import contact_temperature

BINS = 80
POINTS = 2000  # of a line; a contact has up to millions


def densities(temperatures: Array, heat: Array) -> tuple[Array, Array, Array]:
    """Return edges of bins, K, and the densities of the area and of the heat of contact pixels in them, % per K."""
    low, high = float(temperatures.min()), float(temperatures.max())
    if low == high:  # a bin needs a width
        low, high = low - 0.5, high + 0.5
    counts, edges = np.histogram(temperatures, BINS, (low, high))
    heats, _ = np.histogram(temperatures, BINS, (low, high), weights=heat)
    percent = 100.0 / (edges[1] - edges[0])
    return edges, counts / temperatures.size * percent, heats / heat.sum() * percent


def distribution_chart(subject: Subject, path: Path) -> None:
    """Draw the density of temperature by area and by heat, and the shares that are hotter than a temperature.

    ValueError if the realization has no contact.
    """
    pressure = subject.field("pressure")
    if not pressure.any():
        raise ValueError(f"realization {subject.index} has no contact; there is no temperature of it to draw")
    contact = contact_temperature(subject.field("temperature"), pressure)
    temperatures, colour = contact.temperatures, COLOURS[subject.column]
    title = subject.title(
        rf"Temperature in the contact: $\langle T\sigma\rangle/\langle\sigma\rangle$ = "
        f"{contact.flash_temperature:.4g} K (dashed), mean {contact.mean_temperature:.4g} K, "
        f"highest {contact.max_temperature:.4g} K"
    )
    with new_figure(path, (9.6, 3.9), title) as figure:
        density, hotter = figure.subplots(1, 2)
        edges, area, heat = densities(temperatures, np.diff(contact.cooler, prepend=0.0))
        density.stairs(area, edges, fill=True, color="0.75", label="of the area")
        density.stairs(heat, edges, color=colour, lw=1.2, label="of the heat")
        density.axvline(contact.flash_temperature, color=colour, lw=1.0, ls="--")
        density.set(xlabel="$T$, K", ylabel="% per K", title="Density")
        density.set_ylim(bottom=0.0)
        density.legend(loc="upper right")
        # temperatures are in ascending order: point k has a share (k + 1)/n of the area at or below it
        points = np.unique(np.linspace(0, temperatures.size - 1, POINTS).astype(np.intp))
        hotter.plot(temperatures[points], 100.0 * (1.0 - (points + 1) / temperatures.size), color="0.5", lw=1.2)
        hotter.plot(temperatures[points], 100.0 * (1.0 - contact.cooler[points]), color=colour, lw=1.2)
        hotter.axvline(contact.flash_temperature, color=colour, lw=1.0, ls="--")
        hotter.set(xlabel="$T$, K", ylabel="% hotter than $T$", title="Share that is hotter", ylim=(0.0, 100.0))
