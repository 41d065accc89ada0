"""Maps of fields: the whole cell, and an enlarged part for a cell of many points."""

from math import inf
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, LinearSegmentedColormap, to_hex
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.image import AxesImage
from matplotlib.patches import Rectangle
from mpl_toolkits.axes_grid1.anchored_artists import AnchoredSizeBar  # type: ignore[import-untyped]

from roughsim import fourier
from roughsim.charts.numbers import PART
from roughsim.charts.style import FIELDS, Subject, new_figure, scaled
from roughsim.errors import number
from roughsim.grid import Array, Grid
from roughsim.results.heated import DERIVED_UNITS
from roughsim.scene import Scene

Zoom = tuple[tuple[float, float], tuple[float, float]]  # ends along x and along y, m
_Window = tuple[slice, slice]  # points of a grid along x and along y
_TWO_PANELS = 5.0  # inches: a narrower figure has no enlarged part
_LEAST = 8  # points along a side of a picture
ENLARGED = 192  # points per side of the enlarged part
_OUTLINE = "#7fdbff"
HARD = "#7f8796"  # of contact at the hardness
_AT_HARDNESS = 1e-5  # relative; fields are stored in single precision


def map_chart(subject: Subject, name: str, path: Path, zoom: Zoom | None = None) -> None:
    """Draw a field in colours, with an enlarged view of the hottest, or most loaded, part of a large cell."""
    field, pressure, grid = subject.field(name), subject.field("pressure"), subject.grid
    window, hot = _window_of(grid, zoom), name in ("temperature", "seen")
    narrow = subject.look.size is not None and subject.look.size[0] < _TWO_PANELS
    enlarged = (
        None if narrow or zoom is not None else busiest_part(field if hot else averaged(pressure))
    )
    field, colours, label, hard = _with_colours(subject, name, field, pressure, window)
    windows = [window] if enlarged is None else [window, enlarged]
    # on a small map of the whole cell it would hide the spots, and a line behind the contact has none
    camera = subject.run.scene.camera
    behind = name == "seen" and camera is not None and camera.behind is not None
    outlined = pressure if hot and not (narrow and zoom is None) and not behind else None
    title = FIELDS[name][0]
    if hard:
        title += f"; grey: {100 * hard:.3g} % of it, at the hardness"
    size = 4.6 * len(windows) + 0.6, 3.9 * _height_over_width(grid, window) + 1.25
    with new_figure(path, size, subject.title(title), subject.look) as figure:
        panels = list(figure.subplots(1, len(windows), squeeze=False)[0])
        for axes, part in zip(panels, windows, strict=True):
            # the contact is outlined on the most enlarged map
            image = draw_field(
                axes, field, grid, part, colours, outlined if part is windows[-1] else None
            )
        if enlarged is not None:
            factor = scaled(max(grid.lengths), "m")[0]
            steps = np.array(grid.spacing) * factor
            corner = steps * [part.start for part in enlarged]
            frame: Any = {"fill": False, "ec": "1.0" if hot else "0.2", "lw": 0.8}
            panels[0].add_patch(Rectangle(tuple(corner), *(ENLARGED * steps), **frame))
            panels[1].set_title(PART, fontsize=8, color="0.3")
        _sliding_arrow(panels[0], subject.speed)
        colour_bar(figure, image, panels, label, "right")


def _with_colours(
    subject: Subject, name: str, field: Array, pressure: Array, window: _Window
) -> tuple[Array, dict[str, Any], str, float]:
    """Return a field in a unit that suits a window, its colours and label there, and the share of contact in grey.

    This is the contact at the hardness, on maps of pressure and heat flux.
    """
    _, symbol, si_unit = FIELDS[name]
    factor, unit = scaled(float(np.abs(field[window]).max()), si_unit)
    field = field * factor
    hard = 0.0
    if name in ("pressure", "heat_flux"):
        hard = share_at_hardness(pressure, subject.run.scene, subject.column)
    below = " below the hardness" if hard else ""
    return field, colour_range(name, field[window], hard), f"{symbol}{below} ({unit})", hard


def side_by_side_chart(subject: Subject, third: str, path: Path, zoom: Zoom | None = None) -> None:
    """Draw heights, pressure and a third field side by side; the contact is outlined on all but the pressure."""
    grid, pressure = subject.grid, subject.field("pressure")
    window, names = _window_of(grid, zoom), ("heights", "pressure", third)
    size = 3.9 * len(names), 3.3 * _height_over_width(grid, window) + 1.35
    title = subject.title(f"Heights, pressure and {third.replace('_', ' ')}")
    with new_figure(path, size, title, subject.look) as figure:
        for axes, name in zip(figure.subplots(1, len(names)), names, strict=True):
            field, colours, label, _ = _with_colours(
                subject, name, subject.field(name), pressure, window
            )
            # on a whole cell the outlines would hide the spots
            outlined = pressure if name != "pressure" and zoom is not None else None
            edge = "0.0" if name == "heights" else _OUTLINE
            image = draw_field(axes, field, grid, window, colours, outlined, edge)
            colour_bar(figure, image, axes, label, "bottom")
            if name in DERIVED_UNITS:
                _sliding_arrow(axes, subject.speed)


def _window_of(grid: Grid, zoom: Zoom | None) -> _Window:
    """Return the points between the ends of a zoom, or all.

    ValueError if an end lies outside the cell, or fewer than 8 points lie between two ends.
    """
    if zoom is None:
        return slice(0, grid.shape[0]), slice(0, grid.shape[1])
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
    return sides[0], sides[1]


def busiest_part(field: Array) -> _Window | None:
    """Return the part around the largest value, inside the cell; None for a cell small enough to be seen whole."""
    if min(field.shape) < 2 * ENLARGED:
        return None
    peak = np.unravel_index(int(field.argmax()), field.shape)
    x, y = (
        int(np.clip(at - ENLARGED // 2, 0, n - ENLARGED))
        for at, n in zip(peak, field.shape, strict=True)
    )
    return slice(x, x + ENLARGED), slice(y, y + ENLARGED)


def averaged(pressure: Array) -> Array:
    """Return the pressure averaged over about the size of an enlarged part: its peak is at the largest contact."""
    # a Gaussian, by its spectrum over cycles per pixel: loading scipy.ndimage for it takes .05 s
    along, across = np.fft.fftfreq(pressure.shape[0])[:, None], np.fft.rfftfreq(pressure.shape[1])
    weights = np.exp(-2.0 * (np.pi * ENLARGED / 8) ** 2 * (along**2 + across**2))
    smooth: Array = fourier.inverse(fourier.forward(pressure) * weights, pressure.shape)
    return smooth


def _height_over_width(grid: Grid, window: _Window) -> float:
    """Return height over width of the part of a map that is drawn, between 0.3 and 3."""
    width, height = ((s.stop - s.start) * d for s, d in zip(window, grid.spacing, strict=True))
    return float(min(max(height / width, 0.3), 3.0))


def draw_field(
    axes: Axes,
    field: Array,
    grid: Grid,
    window: _Window,
    colours: dict[str, Any],
    pressure: Array | None = None,
    edge: str = _OUTLINE,
    *,
    bar: bool = True,
) -> AxesImage:
    """Draw a field with a scale `bar`, and, if `pressure` is given, the edges of the contact."""
    # points are centred on their coordinates; axis 0 of the field is x
    ends = [
        ((s.start - 0.5) * d, (s.stop - 0.5) * d) for s, d in zip(window, grid.spacing, strict=True)
    ]
    factor, unit = scaled(max(abs(end) for pair in ends for end in pair), "m")
    left, right, bottom, top = (end * factor for pair in ends for end in pair)
    image = axes.imshow(
        field[window].T, origin="lower", extent=(left, right, bottom, top), **colours
    )
    for side in axes.spines.values():
        side.set_visible(True)
        side.set_linewidth(0.5)
    axes.set(xlabel=f"$x$ ({unit})", ylabel=f"$y$ ({unit})")
    axes.tick_params(direction="out")
    if pressure is not None:
        contact = (pressure[window] > 0.0).astype(float)
        if contact.min() < contact.max():
            x, y = (
                np.arange(s.start, s.stop) * d * factor
                for s, d in zip(window, grid.spacing, strict=True)
            )
            axes.contour(x, y, contact.T, levels=[0.5], colors=edge, linewidths=0.5)
    if bar:
        scale_bar(axes, unit)
    return image


def scale_bar(axes: Axes, unit: str) -> None:
    """Draw a bar about a fifth of the map wide, 1, 2 or 5 times a power of ten long, with its length, on a plate."""
    left, right = axes.get_xlim()
    longest = 0.22 * (right - left)
    power = 10.0 ** np.floor(np.log10(longest) + 1e-12)
    length = float(max(k for k in (1, 2, 5) if k * power <= longest * (1 + 1e-9)) * power)
    bottom, top = axes.get_ylim()
    thick = 0.008 * (top - bottom)
    style: Any = {"pad": 0.35, "borderpad": 0.5, "sep": 3, "size_vertical": thick, "color": "black"}
    words = FontProperties(size=8)
    bar = AnchoredSizeBar(
        axes.transData, length, f"{length:g} {unit}", "lower left", fontproperties=words, **style
    )
    bar.patch.set(alpha=0.85, lw=0.0)  # a plate, so that it can be read over any map
    axes.add_artist(bar)


def _sliding_arrow(axes: Axes, speed: float | None) -> None:
    """Show above a map which way the source slides through the body."""
    if speed is None:
        return
    # to the right of the letter of the panel
    tail, tip = sorted([(0.10, 1.03), (0.24, 1.03)], reverse=speed < 0.0)
    style: Any = {"arrowprops": {"arrowstyle": "->", "lw": 1.0}}
    axes.annotate("", tip, tail, xycoords="axes fraction", textcoords="axes fraction", **style)
    words = "sliding" if speed > 0.0 else "sliding (−x)"
    axes.text(0.26, 1.03, words, transform=axes.transAxes, va="center", fontsize=8)


def colour_bar(figure: Figure, image: Any, axes: Any, label: str, side: str) -> None:
    """Draw the colour bar beside axes, or below them."""
    extend: Any = "max" if np.max(image.get_array()) > image.norm.vmax else "neither"
    bar = figure.colorbar(
        image, ax=axes, pad=0.01, aspect=30, fraction=0.05, location=side, extend=extend
    )
    bar.set_label(label)
    bar.outline.set_linewidth(0.5)


def share_at_hardness(pressure: Array, scene: Scene, column: str) -> float:
    """Return the share of the contact at the penetration hardness; 0 without any, or in elastic contact."""
    hardness = scene.penetration_hardness if column == "capped" else inf
    hard = pressure >= hardness * (1.0 - _AT_HARDNESS)
    return float(hard.sum()) / max(float((pressure > 0.0).sum()), 1.0)


def colour_range(name: str, field: Array, hard: float = 0.0) -> dict[str, Any]:
    """Return colour map and limits: symmetric about the mean plane for heights, else from the smallest value.

    If a share `hard` of the contact is at the hardness, it is grey, and the colours show the rest: otherwise nearly all
    of it would have the same colour.
    """
    limit = float(np.abs(field).max())
    if hard:
        shades = LinearSegmentedColormap.from_list(
            "elastic", _colour_map(name)(np.linspace(0.22, 0.66, 256))
        )
        smallest = limit * _AT_HARDNESS  # below there is no contact
        colours = shades.with_extremes(under="white", over=HARD)
        return {"cmap": colours, "vmin": smallest, "vmax": limit * (1.0 - 2 * _AT_HARDNESS)}
    low, high = (-limit, limit) if name == "heights" else (float(field.min()), float(field.max()))
    return {"cmap": _colour_map(name), "vmin": low, "vmax": high}


def _colour_map(name: str) -> Colormap:
    """Return the colours of a field, even in lightness for every eye; the smallest pressure (0) is white."""
    if name in ("heights", "temperature", "seen"):
        return colormaps["RdBu_r" if name == "heights" else "inferno"]
    shades = colormaps["magma_r"](np.linspace(0.03, 0.9, 255))
    return LinearSegmentedColormap.from_list("pressure", np.vstack([[1.0, 1.0, 1.0, 1.0], shades]))


def palette(name: str) -> list[str]:
    """Return the 256 colours of a field, or of a colour map of matplotlib, as "#rrggbb", for screens."""
    colours = colormaps[name] if name in colormaps else _colour_map(name)
    return [to_hex(colour) for colour in colours(np.arange(256))]
