"""The figures of the page, empty: maps with linked views, the dial, the line, the distribution, the curves."""

from __future__ import annotations

from typing import Any, NamedTuple

from bokeh.models import (
    ColorBar,
    ColumnDataSource,
    CrosshairTool,
    CustomJSTickFormatter,
    LinearColorMapper,
    Range1d,
    Span,
)
from bokeh.plotting import figure

from roughsim.charts.maps import palette
from roughsim.charts.style import COLOURS, THEORY

SIDE = 336  # pixels of the screen along the longer side of a map: three fit side by side on a small one
TITLES = {"heights": "Composite heights", "pressure": "Contact pressure", "temperature": "Temperature"}
IMAGE: dict[str, list[Any]] = {name: [] for name in ("image", "x", "y", "dw", "dh")}
MARK = "#00b7c7"  # seen on white, blue, red and black alike
LETTERS = {"heights": "h", "pressure": "σ", "temperature": "T"}
LINE = {"heights": "#0072B2", "pressure": THEORY, "temperature": "#D55E00"}  # as in the printed profiles


class Map(NamedTuple):
    """One field: its figure, the image on it, and the scale of its colour bar."""

    figure: Any
    image: ColumnDataSource
    scale: LinearColorMapper


class Chart(NamedTuple):
    """A figure and the sources of its lines, by name."""

    figure: Any
    sources: dict[str, ColumnDataSource]


def maps(lengths: tuple[float, float], unit: str, mark: ColumnDataSource, line: ColumnDataSource) -> dict[str, Map]:
    """Return the three maps over one view; lengths in the unit of the axes."""
    longest = max(lengths)
    width, height = (max(int(SIDE * side / longest), 90) for side in lengths)
    ranges = [Range1d(0, side, bounds=(-0.02 * side, 1.02 * side)) for side in lengths]
    made = {}
    for name, title in TITLES.items():
        plot = figure(
            title=title,
            x_range=ranges[0],
            y_range=ranges[1],
            frame_width=width,
            frame_height=height,
            tools="pan,wheel_zoom,box_zoom,tap,reset",
            active_scroll="wheel_zoom",
            x_axis_label=f"x, {unit}",
            y_axis_label=f"y, {unit}",
            name=name,
        )
        plot.grid.visible = False
        made[name] = _map(plot, name)
        plot.line("x", "y", source=line, color=MARK, line_width=1, line_alpha=0.7, line_dash="dashed")
        plot.scatter("x", "y", source=mark, marker="circle_cross", size=13, color=MARK, fill_alpha=0, line_width=2)
        _quiet(plot)
    return made


def _map(plot: Any, name: str) -> Map:
    colours = palette(name)
    source = ColumnDataSource(IMAGE)
    # bytes 0…255 are sent; the bar beside them has the real limits
    mapper = LinearColorMapper(palette=colours, low=0, high=255)
    glyph = {"image": "image", "x": "x", "y": "y", "dw": "dw", "dh": "dh", "source": source}
    plot.image(**glyph, color_mapper=mapper, level="underlay")
    scale = LinearColorMapper(palette=colours, low=0, high=1)
    plot.add_layout(ColorBar(color_mapper=scale, height=10, padding=2, title=None, name=f"{name}_bar"), "below")
    return Map(plot, source, scale)


def _quiet(plot: Any) -> None:
    plot.toolbar.logo = None
    plot.toolbar.autohide = True
    plot.title.text_font_size = "12px"
    plot.title.text_font_style = "normal"
    for axis in plot.axis:
        axis.axis_label_text_font_style = "normal"
        axis.axis_label_standoff = 2
    plot.outline_line_color = None


def dial(source: ColumnDataSource) -> Any:
    """Return the dial of the sliding direction: a hand over a circle that follows the pointer."""
    reach = (-1.45, 1.45)
    plot = figure(width=112, height=112, x_range=reach, y_range=reach, tools="", toolbar_location=None, name="dial")
    plot.axis.visible = plot.grid.visible = False
    plot.outline_line_color = None
    plot.min_border = 0
    plot.circle(0, 0, radius=1.0, fill_color="#f2f2f2", line_color="#888888")
    plot.scatter([1, 0, -1, 0], [0, 1, 0, -1], size=4, color="#888888")
    names = {"text": ["x", "y"], "text_font_size": "11px", "text_align": "center", "text_baseline": "middle"}
    plot.text([1.28, 0.0], [0.0, 1.28], **names)
    plot.line("x", "y", source=source, line_width=3, color=LINE["temperature"])
    tip = {"x": "tip_x", "y": "tip_y", "angle": "angle"}
    plot.scatter(**tip, marker="triangle", size=13, color=LINE["temperature"], source=source)
    return plot


def profiles(unit: str) -> tuple[list[Any], ColumnDataSource]:
    """Return three panels over one line through the cell: heights, pressure, temperature; contact is shaded."""
    names = ("heights", "pressure", "temperature", "contact", "width")
    source = ColumnDataSource({"distance": [], **{name: [] for name in names}})
    panels: list[Any] = []
    for name in TITLES:
        shared = {"x_range": panels[0].x_range} if panels else {}
        last = name == "temperature"
        plot = figure(
            width=690, height=150 if last else 112, tools="xpan,xwheel_zoom,reset", name=f"profile_{name}", **shared
        )
        plot.extra_y_ranges = {"share": Range1d(0, 1)}
        # bars: a stepped area of no points keeps BokehJS 3.9 busy for ever
        plot.vbar("distance", "width", "contact", 0, source=source, y_range_name="share", color="#dddddd")
        drawn = {"x": "distance", "y": name, "source": source, "color": LINE[name]}
        if name == "pressure":
            plot.step(**drawn, mode="center")
        else:
            plot.line(**drawn)
        _quiet(plot)
        plot.add_layout(Span(location=0, dimension="height", line_color=MARK, line_width=1))
        plot.xaxis.visible = last
        panels.append(plot)
    panels[-1].xaxis.axis_label = f"distance from the marked point along sliding, {unit}"
    panels[0].add_tools(CrosshairTool(dimensions="height"))
    return panels, source


def distribution() -> Chart:
    """Return the figure of the temperature over the contact, by area and by heat."""
    plot = figure(width=560, height=374, tools="xpan,xwheel_zoom,reset", x_axis_label="T, K", name="distribution")
    source = ColumnDataSource({"left": [], "right": [], "area": [], "middle": [], "heat": []})
    plot.quad(
        "left", "right", "area", 0, source=source, color="#bbbbbb", line_color=None, legend_label="of the contact area"
    )
    plot.line("middle", "heat", source=source, color=LINE["temperature"], line_width=2, legend_label="of the heat")
    flash = ColumnDataSource({"x": [], "y0": [], "y1": []})
    plot.segment("x", "y0", "x", "y1", source=flash, color=LINE["temperature"], line_dash="dashed", line_width=2)
    plot.yaxis.axis_label = "% per K"
    plot.y_range.start = 0
    _quiet(plot)
    _legend(plot)
    return Chart(plot, {"bins": source, "flash": flash})


def curve(title: str, x_label: str, y_label: str, columns: tuple[str, ...], now: Span | None) -> Chart:
    """Return an empty curve: a line of the theory, and a band with points for every column.

    Over speed, `now` is a line at the chosen one, and the axes are logarithmic.
    """
    logarithmic = now is not None
    kind = "log" if logarithmic else "linear"
    plot = figure(
        title=title,
        width=330,
        height=270,
        x_axis_type=kind,
        y_axis_type=kind,
        x_axis_label=x_label,
        y_axis_label=y_label,
        tools="pan,wheel_zoom,box_zoom,reset",
    )
    sources = {"theory": ColumnDataSource({"x": [], "y": []})}
    plot.line("x", "y", source=sources["theory"], color=THEORY, line_width=1.5, legend_label="theory")
    for column in columns:
        source = sources[column] = ColumnDataSource({"x": [], "y": [], "low": [], "high": []})
        plot.varea("x", "low", "high", source=source, color=COLOURS[column], alpha=0.3, legend_label=column)
        plot.line("x", "y", source=source, color=COLOURS[column], legend_label=column)
        if logarithmic:
            plot.scatter("x", "y", source=source, color=COLOURS[column], size=5, legend_label=column)
    _quiet(plot)
    if now is None:  # one legend is enough for the row
        _legend(plot)
    else:
        plot.legend.visible = False
        plot.add_layout(now)
    return Chart(plot, sources)


def _legend(plot: Any) -> None:
    plot.legend.label_text_font_size = "11px"
    plot.legend.border_line_color = None
    plot.legend.background_fill_alpha = 0.6
    plot.legend.padding = plot.legend.margin = 4
    plot.legend.spacing = 0


def speed_line(speed: float) -> Span:
    """Return a line at a speed, m/s."""
    return Span(location=speed, dimension="height", line_color=MARK, line_width=1)


def as_speed() -> CustomJSTickFormatter:
    """Return how a slider over log10 v writes v."""
    return CustomJSTickFormatter(code="return Number(Math.pow(10, tick).toPrecision(3)) + ' m/s'")
