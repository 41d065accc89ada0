"""The figures of the page, each with what it shows: maps, the dial, the line, the distribution, the curves."""

from __future__ import annotations

from math import cos, sin
from typing import Any

import numpy as np
from bokeh.models import Arrow, ColorBar, ColumnDataSource, CrosshairTool, LinearColorMapper, NormalHead, Range1d, Span
from bokeh.plotting import figure
from bokeh.themes import Theme

from roughsim.charts.maps import palette
from roughsim.charts.style import COLOURS, THEORY, scaled
from roughsim.charts.temperature import COLOUR_OF
from roughsim.explore.fields import Distribution, Field, Image
from roughsim.explore.watched_run import CORRELATION, Curve
from roughsim.show.table import shown, with_unit

MARK = "#00b7c7"  # seen on white, blue, red and black alike
HEAT = COLOUR_OF["temperature"]
# title of the map, letter, SI unit
FIELDS = {
    "heights": ("Composite heights", "h", "m"),
    "pressure": ("Contact pressure", "σ", "Pa"),
    "temperature": ("Temperature", "T", "K"),
}
# title, letter and SI unit along x, letter and SI unit along y
CURVES = {
    CORRELATION: ("Stress correlation g_σ(r)", "r", "m", "g_σ", "Pa^2"),
    "flash_temperature": ("Flash temperature", "v", "m/s", "T_flash", "K"),
    "flash_width": ("Hot-spot width", "v", "m/s", "D_flash", "m"),
    "slope_length": ("Slope length", "v", "m/s", "d_flash", "m"),
}
LEGEND = {"label_text_font_size": "11px", "border_line_color": None, "background_fill_alpha": 0.6}
STYLE = {
    "Plot": {"outline_line_color": None},
    "Toolbar": {"logo": None, "autohide": True},
    "Title": {"text_font_size": "12px", "text_font_style": "normal"},
    "Axis": {"axis_label_text_font_style": "normal", "axis_label_standoff": 2},
    "Legend": LEGEND | {"padding": 4, "margin": 4, "spacing": 0},
}
THEME = Theme(json={"attrs": STYLE})


def empty_source(*names: str) -> ColumnDataSource:
    """Return a source of data whose columns are empty."""
    return ColumnDataSource({name: [] for name in names})


def clear(*sources: ColumnDataSource) -> None:
    """Empty sources."""
    for source in sources:
        source.data = {name: [] for name in source.data}


class MapPanel:
    """One field in colours. Maps of the same ranges are zoomed and moved together."""

    def __init__(self, name: str, unit: str, ranges: tuple[Range1d, Range1d], size: tuple[int, int]):
        self.name = name
        self.figure = figure(
            title=FIELDS[name][0],
            x_range=ranges[0],
            y_range=ranges[1],
            frame_width=size[0],
            frame_height=size[1],
            tools="pan,wheel_zoom,box_zoom,tap,reset",
            active_scroll="wheel_zoom",
            x_axis_label=f"x, {unit}",
            y_axis_label=f"y, {unit}",
            name=name,
        )
        self.figure.grid.visible = False
        self.image = empty_source("image", "x", "y", "dw", "dh")
        colours = palette(name)
        # bytes 0…255 are sent; the bar beside them has the real limits
        mapper, keys = LinearColorMapper(palette=colours, low=0, high=255), {key: key for key in self.image.data}
        self.figure.image(**keys, source=self.image, color_mapper=mapper, level="underlay")
        self.scale = LinearColorMapper(palette=colours, low=0, high=1)
        bar = ColorBar(color_mapper=self.scale, height=10, padding=2, title=None, name=f"{name}_bar")
        self.figure.add_layout(bar, "below")

    def show(self, image: Image, factor: float, note: str) -> None:
        """Show an image by one replacement of its data; the factor turns m into the unit of the axes."""
        box = zip(("x", "y", "dw", "dh"), image.box, strict=True)
        self.image.data = {"image": [image.pixels], **{key: [length * factor] for key, length in box}}
        low, high = image.limits
        title, _, si_unit = FIELDS[self.name]
        prefix, unit = scaled(max(abs(low), abs(high)), si_unit)
        self.scale.update(low=low * prefix, high=max(high * prefix, low * prefix + 1e-9))
        view = f"averaged view, {image.step[0]} × {image.step[1]}" if max(image.step) > 1 else "every point"
        self.figure.title.text = f"{title}, {unit}{note}  ({view})"


class Dial:
    """The sliding direction: a hand over a circle that follows the pointer."""

    def __init__(self) -> None:
        ends = (-1.45, 1.45)
        self.figure = figure(width=112, height=112, x_range=ends, y_range=ends, tools="", toolbar_location=None)
        self.figure.name = "dial"
        self.figure.axis.visible = self.figure.grid.visible = False
        self.figure.min_border = 0
        self.figure.circle(0, 0, radius=1.0, fill_color="#f2f2f2", line_color="#888888")
        self.figure.scatter([1, 0, -1, 0], [0, 1, 0, -1], size=4, color="#888888")
        names = {"text": ["x", "y"], "text_font_size": "11px", "text_align": "center", "text_baseline": "middle"}
        self.figure.text([1.28, 0.0], [0.0, 1.28], **names)
        head = NormalHead(size=13, fill_color=HEAT, line_color=HEAT)
        self.hand = Arrow(x_start=0, y_start=0, x_end=1, y_end=0, end=head, line_width=3, line_color=HEAT)
        self.figure.add_layout(self.hand)

    def turn(self, direction: float) -> None:
        """Point the hand along a direction, rad."""
        self.hand.update(x_end=cos(direction), y_end=sin(direction))


class LinePanels:
    """Heights, pressure and temperature on a line through the marked point; contact is shaded."""

    def __init__(self, unit: str) -> None:
        self.source = empty_source("distance", *FIELDS, "contact", "width")
        self.figures: list[Any] = []
        for name in FIELDS:
            last = name == "temperature"
            options = {"x_range": self.figures[0].x_range} if self.figures else {}
            options |= {"width": 690, "height": 150 if last else 112, "tools": "xpan,xwheel_zoom,reset"}
            plot = figure(name=f"profile_{name}", **options)
            plot.extra_y_ranges = {"share": Range1d(0, 1)}
            # bars: a stepped area of no points keeps BokehJS 3.9 busy for ever
            plot.vbar("distance", "width", "contact", 0, source=self.source, y_range_name="share", color="#dddddd")
            glyph = {"x": "distance", "y": name, "source": self.source, "color": COLOUR_OF[name]}
            if name == "pressure":
                plot.step(**glyph, mode="center")
            else:
                plot.line(**glyph)
            plot.add_layout(Span(location=0, dimension="height", line_color=MARK, line_width=1))
            plot.xaxis.visible = last
            self.figures.append(plot)
        self.figures[-1].xaxis.axis_label = f"distance from the marked point along sliding, {unit}"
        self.figures[0].add_tools(CrosshairTool(dimensions="height"))

    def show(self, distance: Field, values: dict[str, Field], width: float) -> list[str]:
        """Show fields over the distance, in the unit of the axis; return their values at distance 0 as texts."""
        texts, data = [], {"distance": distance}
        middle = int(np.abs(distance).argmin())
        for (name, (_, letter, si_unit)), plot in zip(FIELDS.items(), self.figures, strict=True):
            factor, unit = scaled(float(np.nanmax(np.abs(values[name]), initial=0.0)), si_unit)
            data[name] = values[name] * factor
            plot.yaxis.axis_label = f"{letter}, {unit}"
            at = data[name][middle]
            texts.append(f"{letter} = {'…' if np.isnan(at) else f'{at:.5g} {unit}'}")
        data |= {"contact": (values["pressure"] > 0.0).astype(float), "width": np.full(len(distance), width)}
        self.source.data = data
        return texts


class DistributionPanel:
    """The temperature over the contact, by area and by heat."""

    def __init__(self) -> None:
        tools = "xpan,xwheel_zoom,reset"
        self.figure = figure(width=560, height=374, tools=tools, x_axis_label="T, K", name="distribution")
        self.bins = empty_source("left", "right", "area", "middle", "heat")
        self.flash = Span(location=None, dimension="height", line_color=HEAT, line_dash="dashed", line_width=2)
        self.figure.add_layout(self.flash)
        grey = {"color": "#bbbbbb", "line_color": None, "legend_label": "of the contact area"}
        self.figure.quad("left", "right", "area", 0, source=self.bins, **grey)
        self.figure.line("middle", "heat", source=self.bins, color=HEAT, line_width=2, legend_label="of the heat")
        self.figure.yaxis.axis_label = "% per K"
        self.figure.y_range.start = 0

    def clear(self, title: str = "") -> None:
        """Show nothing but a title."""
        clear(self.bins)
        self.flash.location, self.figure.title.text = None, title

    def show(self, distribution: Distribution | None) -> None:
        """Show the densities, and ⟨Tσ⟩/⟨σ⟩ as a dashed line; None: no contact."""
        if distribution is None:
            self.clear("No contact")
            return
        flash, mean, highest, edges, area, heat = distribution
        middle = 0.5 * (edges[1:] + edges[:-1])
        self.bins.data = {"left": edges[:-1], "right": edges[1:], "area": area, "middle": middle, "heat": heat}
        self.flash.location = flash
        self.figure.title.text = (
            f"In the contact: ⟨Tσ⟩/⟨σ⟩ = {flash:.4g} K (dashed), mean {mean:.4g} K, highest {highest:.4g} K"
        )


class CurvePanel:
    """One curve: the theory as a line, and a band with points for every column; over speed both axes are log."""

    def __init__(self, name: str, columns: tuple[str, ...], speed: float):
        title, x, x_si, y, y_si = CURVES[name]
        self.x_factor, self.factor = shown(x_si)[1], shown(y_si)[1]
        self.over_speed = name != CORRELATION
        kind = "log" if self.over_speed else "linear"
        axes = {"x_axis_label": with_unit(x, x_si), "y_axis_label": with_unit(y, y_si)}
        axes |= {"x_axis_type": kind, "y_axis_type": kind}
        self.figure = figure(title=title, width=330, height=270, tools="pan,wheel_zoom,box_zoom,reset", **axes)
        self.sources = {"theory": empty_source("x", "y")}
        line = {"color": THEORY, "line_width": 1.5, "legend_label": "theory"}
        self.figure.line("x", "y", source=self.sources["theory"], **line)
        for column in columns:
            source = self.sources[column] = empty_source("x", "y", "low", "high")
            style = {"source": source, "color": COLOURS[column], "legend_label": column}
            self.figure.varea("x", "low", "high", alpha=0.3, **style)
            self.figure.line("x", "y", **style)
            if self.over_speed:
                self.figure.scatter("x", "y", size=5, **style)
        self.chosen_speed = Span(location=speed, dimension="height", line_color=MARK, line_width=1)
        if self.over_speed:
            self.figure.add_layout(self.chosen_speed)
            self.figure.legend.visible = False  # one legend is enough for the row

    def show_theory(self, x: Field, y: Field) -> None:
        """Show the curve of the theory; SI."""
        self.sources["theory"].data = {"x": x * self.x_factor, "y": y * self.factor}

    def show(self, column: str, curve: Curve) -> None:
        """Show the measured curve of a column with the band of its error; SI."""
        error = np.where(np.isfinite(curve.error), curve.error, 0.0)
        low, high = curve.mean - error, curve.mean + error
        if self.over_speed:  # a band that reaches below zero has no end on a log axis
            low = np.maximum(low, 1e-3 * curve.mean)
        data = {"x": curve.x * self.x_factor, "y": curve.mean * self.factor}
        self.sources[column].data = data | {"low": low * self.factor, "high": high * self.factor}
