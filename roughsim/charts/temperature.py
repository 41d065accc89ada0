"""The temperature of one realization: its distribution over the contact, and a line through its hottest point."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.colors import LogNorm

from roughsim.charts.style import (
    COLOURS,
    FIELDS,
    THEORY,
    Subject,
    new_figure,
    row_of_panels,
    scaled,
)
from roughsim.grid import Array
from roughsim.heat.statistics import (
    ContactTemperature,
    contact_temperature,
    hottest_pixel,
    joint_distribution,
)

_BINS = 80
_POINTS = 2000  # of a line; a contact has up to millions
COLOUR_OF = {"heights": "#0072B2", "pressure": THEORY, "temperature": "#D55E00"}
_NEAR = 96  # points of the enlarged part of a profile on either side


def densities(contact: ContactTemperature) -> tuple[Array, Array, Array]:
    """Return edges of bins, K, and the densities of the area and of the heat of contact pixels in them, % per K."""
    temperatures, heat = contact.temperatures, np.diff(contact.cooler, prepend=0.0)
    low, high = float(temperatures[0]), float(temperatures[-1])
    if low == high:  # a bin needs a width
        low, high = low - 0.5, high + 0.5
    counts, edges = np.histogram(temperatures, _BINS, (low, high))
    heats, _ = np.histogram(temperatures, _BINS, (low, high), weights=heat)
    percent = 100.0 / (edges[1] - edges[0])
    return edges, counts / temperatures.size * percent, heats / heat.sum() * percent


def distribution_chart(subject: Subject, path: Path) -> None:
    """Draw the density of temperature by area and by heat, the shares that are hotter, and temperature over pressure.

    ValueError if the realization has no contact.
    """
    pressure = subject.field("pressure")
    if not pressure.any():
        raise ValueError(
            f"realization {subject.index} has no contact; there is no temperature of it to draw"
        )
    contact = contact_temperature(subject.field("temperature"), pressure)
    temperatures, colour = contact.temperatures, COLOURS[subject.column]
    title = subject.title(
        rf"Temperature in the contact: $\langle T\sigma\rangle/\langle\sigma\rangle$ = "
        f"{contact.flash_temperature:.4g} K (dashed), mean {contact.mean_temperature:.4g} K, "
        f"highest {contact.max_temperature:.4g} K"
    )
    with new_figure(path, (13.2, 3.9), title, subject.look) as figure:
        density, hotter, both = row_of_panels(figure, 3)
        edges, area, heat = densities(contact)
        density.stairs(area, edges, fill=True, color="0.75", label="of the area")
        density.stairs(heat, edges, color=colour, lw=1.2, label="of the heat")
        density.set(xlabel="$T$ (K)", ylabel="% per K", title="Density")
        density.set_ylim(bottom=0.0)
        density.legend(loc="upper right")
        # temperatures are in ascending order: point k has a share (k + 1)/n of the area at or below it
        points = np.unique(np.linspace(0, temperatures.size - 1, _POINTS).astype(np.intp))
        area_below, heat_below = (points + 1) / temperatures.size, contact.cooler[points]
        for below, own in ((area_below, "0.5"), (heat_below, colour)):
            hotter.plot(temperatures[points], 100.0 * (1.0 - below), color=own, lw=1.2)
        for axes in (density, hotter):
            axes.axvline(contact.flash_temperature, color=colour, lw=1.0, ls="--")
        hotter.set(
            xlabel="$T$ (K)",
            ylabel="% hotter than $T$",
            title="Share that is hotter",
            ylim=(0.0, 100.0),
        )
        joint = joint_distribution(subject.field("temperature"), pressure, bins=_BINS)
        percent = np.ma.masked_equal(100.0 * joint.share.T, 0.0)  # bins without contact stay empty
        factor, unit = scaled(float(joint.pressure[-1]), "Pa")
        colours = LogNorm(percent.min(), percent.max())
        mesh = both.pcolormesh(
            joint.pressure * factor, joint.temperature, percent, cmap="viridis", norm=colours
        )
        figure.colorbar(
            mesh, ax=both, label=f"% of the contact area\nin one of {_BINS} × {_BINS} bins"
        )
        both.set(
            xlabel=rf"$\sigma$ ({unit})",
            ylabel="$T$ (K)",
            title="Pressure and temperature together",
        )


def profile_chart(subject: Subject, path: Path) -> None:
    """Draw the fields along the line, and an enlarged part around the hottest point; contact is shaded."""
    dx, dy = subject.grid.spacing
    hottest, across, lines = lines_through_hottest_point(subject)
    count = len(lines["heights"])
    parts = [np.arange(count)]
    if count > 6 * _NEAR:
        parts.append(np.arange(hottest - _NEAR, hottest + _NEAR + 1))
    factor, unit = scaled(across * dy, "m")
    where = f"$y$ = {across * dy * factor:.4g} {unit}"
    title = subject.title(
        f"Along the sliding direction through the hottest point, {where}; contact shaded"
    )
    with new_figure(path, (9.6, 5.6), title, subject.look) as figure:
        panels = figure.subplots(3, len(parts), sharex="col", sharey="row", squeeze=False)
        for part, column in zip(parts, panels.T, strict=True):
            x = part * dx
            factor, unit = scaled(float(np.abs(x).max()), "m")
            x *= factor
            # the cell is periodic
            contact = (lines["pressure"].take(part, mode="wrap") > 0.0).astype(float)
            for axes, (name, colour) in zip(column, COLOUR_OF.items(), strict=True):
                _, symbol, si_unit = FIELDS[name]
                prefix, shown_unit = scaled(float(np.abs(lines[name]).max()), si_unit)
                values = lines[name].take(part, mode="wrap") * prefix
                steps = "steps-mid" if name == "pressure" else "default"
                axes.plot(x, values, color=colour, lw=0.9, ds=steps)
                shade: Any = {"step": "mid", "color": "0.87", "lw": 0, "zorder": 0}
                axes.fill_between(x, 0, contact, transform=axes.get_xaxis_transform(), **shade)
                axes.margins(x=0.0)
                if part is parts[0]:
                    axes.set_ylabel(f"{symbol} ({shown_unit})")
            column[-1].set_xlabel(f"$x$ ({unit})")
        if len(parts) > 1:
            panels[0, 1].set_title("enlarged", color="0.3")


def lines_through_hottest_point(subject: Subject) -> tuple[int, int, dict[str, Array]]:
    """Return the indices of the hottest point along x and y, and the three fields on the line along x through it."""
    temperature = subject.field("temperature")
    hottest, across = hottest_pixel(temperature)
    fields = {name: subject.field(name) for name in ("heights", "pressure")}
    fields["temperature"] = temperature
    return hottest, across, {name: field[:, across].copy() for name, field in fields.items()}
