"""The data of a figure as CSV: curves with their errors, or the points of maps, in the units of the axes."""

import csv
import io
import re
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import StepPatch

from roughsim.store.disk import place_bytes

_TITLES = ("panel", "curve", "x_axis", "y_axis", "x", "y", "error")
MARKS = "marks"  # name of markers that repeat the points of a curve, which are not written twice
PART = "enlarged"  # title of a panel that shows a part of another one
_SIGNS = {
    r"\langle": "⟨", r"\rangle": "⟩", r"\sigma": "σ", r"\mu": "µ", r"\pi": "π", r"\gamma": "γ", r"\ln": "ln ",
    r"\leq": "≤",
}  # fmt: skip


def write_numbers(figure: Figure, path: Path) -> None:
    """Write the maps of a figure, or else its curves, whole or not at all; OSError, naming the path."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    maps = [axes for axes in figure.axes if axes.images and axes.get_title("left") != PART]
    if maps:
        rows.writerows(chain(*map(_rows_of_map, maps)))
    else:
        rows.writerow(_TITLES)
        rows.writerows(chain(*(_rows_of_curves(axes) for axes in figure.axes)))
    path.parent.mkdir(parents=True, exist_ok=True)
    place_bytes(path, text.getvalue().encode())


def _rows_of_map(axes: Axes) -> Iterator[list[Any]]:
    """Yield a line of words, one of y, and for each x a line with the values; axis 0 of the field is x."""
    image = axes.images[0]
    # panels of the same colours share a bar
    bar = next(
        other.colorbar.ax
        for panel in axes.figure.axes
        for other in panel.images
        if other.colorbar and (other.cmap, other.get_clim()) == (image.cmap, image.get_clim())
    )
    label = bare(bar.get_ylabel() or bar.get_xlabel())
    yield [
        f"# {label}; {bare(axes.get_xlabel())} in the first column; {bare(axes.get_ylabel())} in the first line"
    ]
    values = np.asarray(image.get_array()).T
    left, right, bottom, top = image.get_extent()
    x, y = (
        np.round(low + (np.arange(count) + 0.5) * ((high - low) / count), 9)
        for low, high, count in zip((left, bottom), (right, top), values.shape, strict=True)
    )
    yield ["", *(f"{value:.7g}" for value in y)]
    for place, row in zip(x, values, strict=True):
        yield [f"{place:.7g}", *(f"{value:.7g}" for value in row)]


def _rows_of_curves(axes: Axes) -> Iterator[list[Any]]:
    """Yield a line for each point of each curve and each bin of a histogram (its lower edge)."""
    place = [bare(axes.get_title("left") or axes.get_ylabel())]
    below = (
        other.get_xlabel() for other in axes.get_shared_x_axes().get_siblings(axes)
    )  # one names x for all
    labels = [bare(axes.get_xlabel() or next(filter(None, below), "")), bare(axes.get_ylabel())]
    for number, (curve, x, y) in enumerate(_curves_of(axes)):
        label = str(curve.get_label())
        name = curve.get_gid() or (f"curve {number}" if label.startswith("_") else bare(label))
        error = np.broadcast_to(getattr(curve, "half_width", np.nan), np.shape(x))
        for point in zip(np.asarray(x, float), np.asarray(y, float), error, strict=True):
            yield [
                *place,
                name,
                *labels,
                *("" if np.isnan(value) else f"{value:.7g}" for value in point),
            ]


def _curves_of(axes: Axes) -> Iterator[tuple[Any, Any, Any]]:
    """Yield each curve over the data with its x and y, then each histogram with the lower edges and the heights."""
    for line in axes.lines:
        if line.get_transform() == axes.transData and line.get_gid() != MARKS:
            yield line, *line.get_data()
    for patch in axes.patches:
        if isinstance(patch, StepPatch):
            heights, edges, _ = patch.get_data()
            yield patch, edges[:-1], heights


def bare(text: str) -> str:
    """Return a label without the signs of formulas: "T_flash, K"."""
    for sign, letter in _SIGNS.items():
        text = text.replace(f"{sign} ", letter).replace(sign, letter)
    return re.sub(r"\\mathrm\{(.*?)\}|[${}\\]", r"\1", text).replace("\n", " ").strip()
