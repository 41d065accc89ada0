"""Shared by all figures: the data to draw (`Subject`), colours for the colour-blind, fonts, units, files."""

import re
import warnings
from base64 import b64encode
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from math import ceil, floor, log10
from pathlib import Path
from string import ascii_lowercase
from tempfile import TemporaryDirectory
from textwrap import fill, shorten
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backend_bases import get_registered_canvas_class
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, get_font
from matplotlib.text import Text
from matplotlib.ticker import EngFormatter, FuncFormatter, LogLocator, NullFormatter
from matplotlib.transforms import ScaledTranslation

from roughsim.charts.numbers import write_numbers
from roughsim.grid import Array, Grid
from roughsim.results.heated import DERIVED_UNITS
from roughsim.results.run import Run
from roughsim.show.text import plain

MARK = "#00b7c7"  # of points on maps and of summits of the moving face: visible on white, blue, red and black
AT_REST = "#3fae2a"  # of summits of the face at rest: visible on white, black and yellow
THEORY, CALIBRATED = "#222222", "#009E73"
DASHES: Any = (0, (4, 2))  # of the calibrated line, so that a line below it can be seen
# Okabe & Ito
COLOURS = {"smoothed": "#0072B2", "capped": "#D55E00", "elastic": "#0072B2", "sliding": "#CC79A7"}
MARKERS = {"smoothed": "o", "capped": "s", "elastic": "o", "sliding": "D"}
# field → the words above a map of it, its symbol, and its unit
FIELDS = {
    "heights": ("Composite heights", "$h$", "m"),
    "pressure": ("Contact pressure", r"$\sigma$", "Pa"),
    "temperature": ("Temperature above the mean of the cell", "$T$", "K"),
    "seen": ("Temperature above the mean of the cell as the camera sees it", "$T$", "K"),
    "heat_flux": ("Frictional heat of both bodies", r"$\mu\sigma v$", "W/m²"),
}
_SMALLEST, _LARGEST = 1.5, 40.0  # sides of a figure, inches
_NARROWEST = 2.4  # width of a panel that can be read, inches
_BELOW = 0.42  # from an axis to the legend below it, inches
_LETTERS = 15  # of a title to an inch
_FEWEST, _MOST = 30, 1200  # pixels per inch
_FORMATS = (".png", ".pdf", ".svg")
_MEDIA_TYPES = {".svg": "image/svg+xml", ".png": "image/png"}
_STYLE: Any = {
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.titlelocation": "left",
    "axes.titley": 1.0,  # else matplotlib looks for ticks above each panel, a tenth of the time
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "svg.fonttype": "none",
    "pdf.fonttype": 42,
    "text.usetex": False,  # a title must not run TeX, which could read files
}


@dataclass(frozen=True, slots=True)
class Look:
    """Options of a figure: its title, its size in inches, dots per inch, and a file of its numbers.

    Without a `size` the figure has its own. `csv` is a file for the numbers drawn. ValueError if it cannot be so.
    """

    title: bool = True
    size: tuple[float, float] | None = None
    dpi: int = 160  # of .png
    csv: str | Path | None = None

    def __post_init__(self) -> None:
        if self.size is not None and not all(_SMALLEST <= side <= _LARGEST for side in self.size):
            words = " × ".join(f"{side:g}" for side in self.size)
            raise ValueError(
                f"size = {words} inches: each side must be {_SMALLEST:g} to {_LARGEST:g} inches"
            )
        if not _FEWEST <= self.dpi <= _MOST:
            raise ValueError(f"dpi = {self.dpi} must be {_FEWEST} to {_MOST} pixels per inch")
        if self.csv is not None and Path(self.csv).suffix.lower() != ".csv":
            raise ValueError(f"csv = {str(self.csv)!r} must end in .csv")


USUAL = Look()


@dataclass(frozen=True, slots=True, eq=False)
class Subject:
    """The data of a figure: a run, a column and its finest level in the run's cell, a realization, and a speed, m/s.

    The realization is None for all of them.
    """

    run: Run
    column: str
    level: int
    index: int | None
    speed: float | None
    look: Look = USUAL

    @property
    def grid(self) -> Grid:
        """The grid of the fields."""
        return self.run.grid(self.level)

    def field(self, name: str) -> Array:
        """Return a field of the realization."""
        speed = self.speed if name in DERIVED_UNITS else None
        return self.run.field(self.level, self.index or 0, name, speed=speed).astype(float)

    def title(self, what: str) -> str:
        """Return scene, quantity, column, realization and speed in at most three lines."""
        mantissa, _, exponent = f"{self.run.numerics.levels[self.level].q_max:.2e}".partition("e")
        which = [
            rf"{self.column} contact, $q_c$ = {mantissa}$\times$10$^{{{int(exponent)}}}$ rad/m"
        ]
        if self.index is not None:
            whole = "the map and its mirror images" if self.run.edges == "mirror" else "the map"
            which.append(f"realization {self.index}" if self.run.drawn else whole)
        if self.speed is not None:
            which.append(f"$v$ = {self.speed:g} m/s")
        title = shorten(self.run.scene.title, 90, placeholder=" …")
        return under_title(title, what, ", ".join(which))


def under_title(title: str, *lines: str) -> str:
    """Return lines below the title of a scene, if it has one."""
    return "\n".join(filter(None, (no_formula(title), *lines)))


def no_formula(text: str) -> str:
    """Return a text that is drawn as it is, in one line."""
    return plain(text).replace("$", r"\$")


def scale_colours(count: int) -> list[str]:
    """Return colours for an ascending number, as a speed, as "#rrggbb"."""
    # the end of the scale is too pale for paper
    return [to_hex(colour) for colour in mpl.colormaps["viridis"](np.linspace(0.0, 0.85, count))]


def beside(folder: Path, *words: str) -> Path:
    """Return a .png beside a folder, named after it and after words."""
    folder = folder.resolve()
    return folder.with_name("-".join((folder.name, *words)) + ".png")


def check_ending(path: Path) -> None:
    """Raise ValueError unless a picture is to be .png, .pdf or .svg."""
    if path.suffix.lower() not in _FORMATS:
        raise ValueError(f"chart = {str(path)!r} must end in {', '.join(_FORMATS)}")


@contextmanager
def new_figure(
    path: str | Path | None, size: tuple[float, float], title: str = "", look: Look = USUAL
) -> Iterator[Figure]:
    """Yield an empty figure of a size in inches, in the common style; at the end it is written to `path`, if any."""
    if path is not None:
        path = Path(path)
        check_ending(path)
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=look.size or size, dpi=look.dpi, layout="constrained")
        if title and look.title:
            figure.suptitle(_wrapped(title, look.size), fontsize=9, x=0.01, ha="left")
        yield figure
        if look.csv is not None:
            write_numbers(figure, Path(look.csv))
        letter(figure)
        if path is not None:
            save(figure, path)


def row_of_panels(figure: Figure, count: int) -> list[Axes]:
    """Return axes side by side; in a figure too narrow for that, in rows below one another, each of its height."""
    width, height = figure.get_size_inches()
    columns = min(count, max(1, int(width / _NARROWEST)))
    rows = ceil(count / columns)
    figure.set_size_inches(width, rows * height)
    return [figure.add_subplot(rows, columns, k + 1) for k in range(count)]


def _wrapped(title: str, size: tuple[float, float] | None) -> str:
    """Return a title broken at the width of a figure of a given size, but not within a formula."""
    if size is None:
        return title
    whole = re.sub(r"\$[^$]*\$", lambda formula: formula.group().replace(" ", "\0"), title)
    lines = (fill(line, int(_LETTERS * size[0])) for line in whole.split("\n"))
    return "\n".join(lines).replace("\0", " ")


def data_url(draw: Callable[[Path], object], ending: str) -> str:
    """Return a picture that `draw` writes to a path, .png or .svg, as a data URL for a page."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / f"picture{ending}"
        draw(path)
        content = b64encode(path.read_bytes()).decode()
    return f"data:{_MEDIA_TYPES[ending]};base64,{content}"


def save(figure: Figure, path: Path) -> None:
    """Write a figure; letters that its font lacks are named in one warning."""
    path.parent.mkdir(parents=True, exist_ok=True)
    font = get_font(findfont(FontProperties()))
    letters = {
        letter
        for text in figure.findobj(Text)
        for letter in text.get_text()
        if letter.isprintable()
    }
    if lacking := sorted(letter for letter in letters if not font.get_char_index(ord(letter))):
        warnings.warn(
            f"the font of the pictures has no {' '.join(lacking)}: boxes are drawn instead",
            stacklevel=2,
        )
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", r"Glyph \d+ .*missing from font")
        # savefig would draw twice, first for the layout
        ending = path.suffix[1:].lower()
        canvas: Any = get_registered_canvas_class(ending)(figure)
        getattr(canvas, f"print_{ending}")(path)


def band(
    axes: Axes, x: Array, mean: Array, error: Array, colour: Any, name: str = "measured"
) -> None:
    """Draw a mean with the half-width of its 95 % interval; `name` is its name in the file of the numbers."""
    axes.fill_between(x, mean - error, mean + error, color=colour, alpha=0.25, lw=0)
    (line,) = axes.plot(x, mean, color=colour, lw=1.0)
    line.set_gid(name)
    line.half_width = error  # type: ignore[attr-defined]  # for the file of the numbers


def legend_below(axes: Axes, *, title: str | None = None, columns: int = 1) -> None:
    """Put the legend of a panel below its axis, where it hides no data."""
    below = axes.transAxes + ScaledTranslation(0.0, -_BELOW, axes.figure.dpi_scale_trans)
    place: dict[str, Any] = {
        "loc": "upper left",
        "bbox_to_anchor": (0.0, 0.0),
        "bbox_transform": below,
    }
    axes.legend(
        title=title, ncols=columns, columnspacing=1.2, alignment="left", borderaxespad=0.0, **place
    )


def on_axis(title: str) -> str:
    """Return the title of a column as the label of an axis: "T_flash (K)" of "T_flash, K"."""
    name, comma, unit = title.rpartition(", ")
    return f"{name} ({unit})" if comma else title


def letter(figure: Figure) -> None:
    """Put (a), (b), … before the titles of the panels of a figure that has several."""
    # a colour bar has no place among the panels
    panels = [
        axes
        for axes in figure.axes
        if axes.axison and axes.get_visible() and axes.get_subplotspec() is not None
    ]
    for axes, name in zip(panels, ascii_lowercase if len(panels) > 1 else "", strict=False):
        axes.set_title(f"({name}) {axes.get_title('left')}")


def plain_ticks(axis: Axis) -> None:
    """Write the ticks of a logarithmic axis as 0.1, 0.2, 0.5, 1; over more than three decades as powers of ten."""
    low, high = axis.get_view_interval()
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high <= 1e3 * low else (1.0,)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def log_values(axes: Axes) -> None:
    """Make the axis of the values logarithmic; over less than two decades with ticks as 20, 50, 100."""
    axes.set_yscale("log")
    low, high = axes.get_ylim()
    if high / low < 100.0:
        plain_ticks(axes.yaxis)


def scaled(largest: float, unit: str) -> tuple[float, str]:
    """Return the factor to a unit with an SI prefix in which `largest` lies between 1 and 1000, and that unit."""
    if not largest > 0.0 or unit == "K":
        return 1.0, unit
    power = min(max(3 * floor(log10(largest) / 3), -12), 12)
    return 10.0**-power, EngFormatter.ENG_PREFIXES[power] + unit
