"""Maps of fields: the whole cell, and beside it the busiest part of a fine one."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from roughsim.charts.style import Array, new_figure, save, scaled
from roughsim.errors import number
from roughsim.results.fields import DERIVED_UNITS
from roughsim.store.member_files import FIELD_UNITS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap
    from matplotlib.figure import Figure

    from roughsim.charts.pictures import Subject
    from roughsim.grid import Grid

SYMBOLS = {"heights": "$h$", "pressure": r"$\sigma$", "temperature": "$T$", "heat_flux": r"$\mu\sigma v$"}
_PLAIN_UNITS = {"W/m^2": "W/m²"}
Zoom = tuple[tuple[float, float], tuple[float, float]]
_LEAST = 8  # points along a side of a picture
_WINDOW = 192  # points per side of the enlarged part
_OUTLINE = "#7fdbff"


class Window(NamedTuple):
    """What a map shows: a part of the points of a grid."""

    x: slice
    y: slice


def map_chart(subject: Subject, name: str, title: str, path: Path, zoom: Zoom | None = None) -> None:
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
    zoom : ((float, float), (float, float)), optional
        Ends along x and along y, m, of the part that is drawn, alone.
    """
    field, pressure = subject.field(name), subject.field("pressure")
    grid = subject.run.numerics.grid(subject.level)
    shown = whole_of(grid) if zoom is None else zoomed(grid, zoom)
    factor, unit = scaled(float(np.abs(field[shown]).max()), (FIELD_UNITS | DERIVED_UNITS)[name])
    field *= factor
    part = _window(field if name == "temperature" else _coarse(pressure)) if zoom is None else None
    panels = 2 if part is not None else 1
    with new_figure(path, (4.6 * panels + 0.6, 3.9 * _tallness(grid, shown) + 1.25)) as figure:
        axes = figure.subplots(1, panels, squeeze=False)[0]
        colours = _colours(name, field[shown])
        image = _panel(axes[0], field, grid.spacing, shown, colours)
        if part is not None:
            _frame(axes[0], grid, part, "1.0" if name == "temperature" else "0.2")
            _panel(axes[1], field, grid.spacing, part, colours)
            axes[1].set_title("enlarged", fontsize=8, color="0.3")
        if name == "temperature":
            _outlines(axes[-1], pressure, grid, shown if part is None else part)
        for panel in axes:
            scale_bar(panel)
        _arrow(axes[0], subject)
        _bar(figure, image, list(axes), name, unit)
        figure.suptitle(title, fontsize=9, x=0.01, ha="left")
        save(figure, path)


def side_by_side_chart(
    subject: Subject, names: tuple[str, ...], title: str, path: Path, zoom: Zoom | None = None
) -> None:
    """Draw several fields of one part beside each other, the contact outlined on all but the pressure.

    Parameters
    ----------
    subject, title, path, zoom
        As in `map_chart`.
    names : tuple of str
        Fields, left to right.
    """
    grid, pressure = subject.run.numerics.grid(subject.level), subject.field("pressure")
    shown = whole_of(grid) if zoom is None else zoomed(grid, zoom)
    with new_figure(path, (3.9 * len(names), 3.3 * _tallness(grid, shown) + 1.35)) as figure:
        for axes, name in zip(figure.subplots(1, len(names), squeeze=False)[0], names, strict=True):
            field = subject.field(name)
            factor, unit = scaled(float(np.abs(field[shown]).max()), (FIELD_UNITS | DERIVED_UNITS)[name])
            field *= factor
            image = _panel(axes, field, grid.spacing, shown, _colours(name, field[shown]))
            if name != "pressure" and zoom is not None:  # on a whole cell they would hide what they enclose
                _outlines(axes, pressure, grid, shown, "0.0" if name == "heights" else _OUTLINE)
            scale_bar(axes)
            _bar(figure, image, axes, name, unit, below=True)
            if name in DERIVED_UNITS:
                _arrow(axes, subject)
        figure.suptitle(title, fontsize=9, x=0.01, ha="left")
        save(figure, path)


def whole_of(grid: Grid) -> Window:
    """Return all points of a grid."""
    return Window(slice(0, grid.shape[0]), slice(0, grid.shape[1]))


def zoomed(grid: Grid, zoom: Zoom) -> Window:
    """Return the points between the ends of a zoom, m.

    Raises
    ------
    ValueError
        If an end lies outside the cell, or fewer than 8 points lie between two ends.
    """
    sides = []
    for axis, ends, count, length in zip("xy", zoom, grid.shape, grid.lengths, strict=True):
        low, high = (number("zoom", end, "m") for end in ends)
        if not 0.0 <= low < high <= length * (1 + 1e-9):
            raise ValueError(
                f"zoom = {low:.4g}:{high:.4g} m along {axis} must rise and lie in the cell, 0:{length:.4g} m"
            )
        first, last = round(low / length * count), round(high / length * count)
        if last - first < _LEAST:
            raise ValueError(
                f"zoom = {low:.4g}:{high:.4g} m along {axis} holds {last - first} points of {length / count:.4g} m; "
                f"at least {_LEAST} make a picture"
            )
        sides.append(slice(first, last))
    return Window(*sides)


def _tallness(grid: Grid, shown: Window) -> float:
    width, height = ((s.stop - s.start) * d for s, d in zip(shown, grid.spacing, strict=True))
    return float(min(max(height / width, 0.3), 3.0))


def _bar(figure: Figure, image: Any, axes: Any, name: str, unit: str, *, below: bool = False) -> None:
    """The colours and what they mean."""
    place = "bottom" if below else "right"
    bar = figure.colorbar(image, ax=axes, pad=0.01, aspect=30, fraction=0.05, location=place)
    bar.set_label(f"{SYMBOLS[name]}, {_PLAIN_UNITS.get(unit, unit.replace('^2', '²'))}")
    bar.outline.set_linewidth(0.5)


def scale_bar(axes: Axes) -> None:
    """Draw a bar of a round length, about a fifth of the width, with its length; legible on any colour."""
    from matplotlib.patheffects import withStroke

    unit = axes.get_xlabel().rpartition(" ")[2]
    left, right = axes.get_xlim()
    length = round_length(0.22 * (right - left))
    start, place = 0.04, axes.get_xaxis_transform()
    x = left + start * (right - left)
    halo = [withStroke(linewidth=3.0, foreground="white")]
    axes.plot([x, x + length], [0.045, 0.045], transform=place, color="black", lw=2.0, path_effects=halo)
    style: Any = {"ha": "center", "va": "bottom", "fontsize": 8, "path_effects": halo}
    axes.text(x + length / 2, 0.06, f"{length:g} {unit}", transform=place, **style)


def round_length(length: float) -> float:
    """Return the largest of 1, 2, 5 times a power of ten that is not above a length."""
    power = 10.0 ** np.floor(np.log10(length) + 1e-12)
    return float(max(k for k in (1, 2, 5) if k * power <= length * (1 + 1e-9)) * power)


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


def _outlines(axes: Axes, pressure: Array, grid: Any, part: tuple[slice, slice], colour: str = _OUTLINE) -> None:
    """The edges of the contact over a temperature."""
    there = (pressure[part] > 0.0).astype(float)
    if there.min() == there.max():
        return
    ends = [(s.stop - 0.5) * d for s, d in zip(part, grid.spacing, strict=True)]
    factor, _ = scaled(max(ends), "m")
    x, y = (np.arange(s.start, s.stop) * d * factor for s, d in zip(part, grid.spacing, strict=True))
    axes.contour(x, y, there.T, levels=[0.5], colors=colour, linewidths=0.5)


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
