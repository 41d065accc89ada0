"""Maps of fields: the whole cell, and beside it the busiest part of a fine one."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from roughsim.charts.style import Array, new_figure, save, scaled
from roughsim.record.fields import DERIVED_UNITS
from roughsim.record.files import FIELD_UNITS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap

    from roughsim.charts.pictures import Subject

SYMBOLS = {"heights": "$h$", "pressure": r"$\sigma$", "temperature": "$T$", "heat_flux": r"$\mu\sigma v$"}
_PLAIN_UNITS = {"W/m^2": "W/m²"}
_WINDOW = 192  # points per side of the enlarged part
_OUTLINE = "#7fdbff"


def map_chart(subject: Subject, name: str, title: str, path: Path) -> None:
    """Draw a field in colours; a cell of many points is enlarged beside it where it is hottest, or pressed hardest.

    Parameters
    ----------
    subject : Subject
        Whose field.
    name : str
        "heights", "pressure", "heat_flux" or "temperature".
    title : str
        Above the picture.
    path : Path
        Of the picture.
    """
    field, pressure = subject.field(name), subject.field("pressure")
    grid = subject.run.numerics.grid(subject.level)
    factor, unit = scaled(float(np.abs(field).max()), (FIELD_UNITS | DERIVED_UNITS)[name])
    field *= factor
    part = _window(field if name == "temperature" else _coarse(pressure))
    panels = 2 if part is not None else 1
    tall = 3.9 * min(max(grid.lengths[1] / grid.lengths[0], 0.3), 3.0) + 1.25
    with new_figure(path, (4.6 * panels + 0.6, tall)) as figure:
        axes = figure.subplots(1, panels, squeeze=False)[0]
        colours = _colours(name, field)
        whole = (slice(0, grid.shape[0]), slice(0, grid.shape[1]))
        image = _panel(axes[0], field, grid.spacing, whole, colours)
        if part is not None:
            _frame(axes[0], grid, part, "1.0" if name == "temperature" else "0.2")
            _panel(axes[1], field, grid.spacing, part, colours)
            axes[1].set_title("enlarged", fontsize=8, color="0.3")
        if name == "temperature":
            _outlines(axes[-1], pressure, grid, whole if part is None else part)
        _arrow(axes[0], subject)
        bar = figure.colorbar(image, ax=list(axes), pad=0.01, aspect=30, fraction=0.05)
        bar.set_label(f"{SYMBOLS[name]}, {_PLAIN_UNITS.get(unit, unit.replace('^2', '²'))}")
        bar.outline.set_linewidth(0.5)
        figure.suptitle(title, fontsize=9, x=0.01, ha="left")
        save(figure, path)


def _colours(name: str, field: Array) -> dict[str, Any]:
    """Colour map and its ends: heights about their mean plane, everything else from its smallest value."""
    limit = float(np.abs(field).max())
    low, high = (-limit, limit) if name == "heights" else (float(field.min()), float(field.max()))
    return {"cmap": colour_map(name), "vmin": low, "vmax": high}


def colour_map(name: str) -> Colormap:
    """Return the colours of a field, even in lightness for every eye; the smallest pressure (0) is white."""
    from matplotlib import colormaps
    from matplotlib.colors import LinearSegmentedColormap

    if name in ("heights", "temperature"):
        return colormaps["RdBu_r" if name == "heights" else "inferno"]
    shades = colormaps["magma_r"](np.linspace(0.03, 0.9, 255))
    return LinearSegmentedColormap.from_list("pressure", np.vstack([[1.0, 1.0, 1.0, 1.0], shades]))


def palette(name: str) -> list[str]:
    """Return the 256 colours of a field as "#rrggbb", for screens."""
    from matplotlib.colors import to_hex

    return [to_hex(colour) for colour in colour_map(name)(np.arange(256))]


def _panel(axes: Axes, field: Array, spacing: tuple[float, float], part: Any, colours: dict[str, Any]) -> Any:
    """One image; points are centred on their coordinates."""
    edges = [((s.start - 0.5) * d, (s.stop - 0.5) * d) for s, d in zip(part, spacing, strict=True)]
    factor, unit = scaled(max(abs(edge) for pair in edges for edge in pair), "m")
    extent = tuple(edge * factor for pair in edges for edge in pair)
    image = axes.imshow(field[part].T, origin="lower", extent=extent, **colours)
    for side in axes.spines.values():
        side.set_visible(True)
        side.set_linewidth(0.5)
    axes.set(xlabel=f"$x$, {unit}", ylabel=f"$y$, {unit}")
    axes.tick_params(direction="out")
    return image


def _coarse(pressure: Array) -> Array:
    """Pressure averaged over about a window, to find where most contact is."""
    from roughsim import fourier

    kx, ky = (np.fft.fftfreq(pressure.shape[0])[:, None], np.fft.rfftfreq(pressure.shape[1])[None, :])
    keep = np.exp(-2.0 * (0.25 * np.pi * _WINDOW) ** 2 * (kx**2 + ky**2) / 4)
    smooth: Array = fourier.inverse(fourier.forward(pressure) * keep, pressure.shape)
    return smooth


def _window(field: Array) -> tuple[slice, slice] | None:
    """The part around the largest value, inside the cell; None for a cell that is small enough to be seen whole."""
    if min(field.shape) < 2 * _WINDOW:
        return None
    peak = np.unravel_index(int(field.argmax()), field.shape)
    starts = [int(np.clip(at - _WINDOW // 2, 0, n - _WINDOW)) for at, n in zip(peak, field.shape, strict=True)]
    return slice(starts[0], starts[0] + _WINDOW), slice(starts[1], starts[1] + _WINDOW)


def _frame(axes: Axes, grid: Any, part: tuple[slice, slice], colour: str) -> None:
    """Where the enlarged part lies."""
    from matplotlib.patches import Rectangle

    factor, _ = scaled(max(grid.lengths), "m")
    corner = [s.start * d * factor for s, d in zip(part, grid.spacing, strict=True)]
    size = [_WINDOW * d * factor for d in grid.spacing]
    style: Any = {"fill": False, "ec": colour, "lw": 0.8}
    axes.add_patch(Rectangle((corner[0], corner[1]), size[0], size[1], **style))


def _outlines(axes: Axes, pressure: Array, grid: Any, part: tuple[slice, slice]) -> None:
    """The edges of the contact over a temperature."""
    there = (pressure[part] > 0.0).astype(float)
    if there.min() == there.max():
        return
    ends = [(s.stop - 0.5) * d for s, d in zip(part, grid.spacing, strict=True)]
    factor, _ = scaled(max(ends), "m")
    x, y = (np.arange(s.start, s.stop) * d * factor for s, d in zip(part, grid.spacing, strict=True))
    axes.contour(x, y, there.T, levels=[0.5], colors=_OUTLINE, linewidths=0.5)


def _arrow(axes: Axes, subject: Subject) -> None:
    """Which way the source slides through the body."""
    if subject.speed is None:
        return
    ends = ((0.16, 1.03), (0.02, 1.03)) if subject.speed > 0 else ((0.02, 1.03), (0.16, 1.03))
    style: Any = {"arrowstyle": "->", "lw": 1.0}
    axes.annotate("", *ends, xycoords="axes fraction", textcoords="axes fraction", arrowprops=style)
    axes.text(
        0.18,
        1.03,
        "sliding" if subject.speed > 0 else "sliding (−x)",
        transform=axes.transAxes,
        va="center",
        fontsize=8,
    )
