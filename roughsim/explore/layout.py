"""The layout of the page: controls, maps, lines, distribution, curves and texts. No computing."""

import re
from math import degrees, log10, remainder, tau
from typing import Any

import numpy as np
from bokeh import models
from bokeh.layouts import column, row
from bokeh.plotting import figure
from bokeh.themes import Theme

from roughsim.charts.maps import HARD, palette
from roughsim.charts.style import CALIBRATED, COLOURS, MARK, THEORY, scaled
from roughsim.charts.temperature import COLOUR_OF, densities
from roughsim.explore.content import (
    CORRELATION,
    USUAL,
    Field,
    Image,
    Line,
    MapLook,
    scene_text,
)
from roughsim.explore.controls import WRAPPED, Controls
from roughsim.explore.skin import SkinControls
from roughsim.explore.takeaway import Takeaway
from roughsim.grid import Grid
from roughsim.heat.statistics import ContactTemperature
from roughsim.results.run import Run
from roughsim.show.table import shown
from roughsim.table import Estimate

_SIDE = 254  # screen pixels along the longer side of a map: three stand beside each other in half a screen
_ALONG = "xpan,xwheel_zoom,reset,save"  # tools of a figure over one axis
_WIDE: Any = {"sizing_mode": "stretch_width"}  # takes the room that there is
_PAGE = "calc(100vw - 24px)"  # the width of the page within its margins
# of a line; may be scrolled
_REST = {"flex": "1 1 600px", "min-width": "0", "max-width": _PAGE, "overflow-x": "auto"}
_HEAT = COLOUR_OF["temperature"]
# title of the map, letter, SI unit
FIELDS = {
    "heights": ("Heights", "h", "m"),
    "pressure": ("Pressure", "σ", "Pa"),
    "temperature": ("Temperature", "T", "K"),
}
# title, formula and SI unit along y
_CURVES = {
    CORRELATION: (r"Stress correlation $$g_\sigma(r)$$", r"g_\sigma", "Pa^2"),
    "flash_temperature": ("Flash temperature", r"T_\mathrm{flash}", "K"),
    "flash_width": ("Hot-spot width", r"D_\mathrm{flash}", "m"),
    "slope_length": ("Slope length", r"d_\mathrm{flash}", "m"),
}
LEGEND = {"label_text_font_size": "12px", "border_line_color": None, "background_fill_alpha": 0.6}
_STYLE = {
    "Plot": {"outline_line_color": None},
    "Toolbar": {"logo": None, "autohide": True},
    "Title": {"text_font_size": "13px", "text_font_style": "normal"},
    "Axis": {
        "axis_label_text_font_style": "normal",
        "axis_label_text_font_size": "13px",
        "major_label_text_font_size": "12px",
        "axis_label_standoff": 2,
    },
    "BaseColorBar": {"major_label_text_font_size": "12px"},
    "Legend": LEGEND | {"padding": 4, "margin": 4, "spacing": 0},
}
THEME = Theme(json={"attrs": _STYLE})


def empty_source(*names: str) -> models.ColumnDataSource:
    """Return a source of data whose columns are empty."""
    return models.ColumnDataSource({name: [] for name in names})


def ends_of_errors(mean: Field, error: Field, *, log: bool) -> dict[str, Field]:
    """Return the ends of errors; an unknown error has none, nor one that reaches zero on a log axis."""
    error = np.where(np.isfinite(error), error, 0.0)
    least = 1e-3 * mean if log else -np.inf
    return {"low": np.maximum(mean - error, least), "high": mean + error}


def _formula(symbol: str, unit: str) -> str:
    """Return a symbol with the shown form of its SI unit, to be set as a formula; text beside one loses its "µ"."""
    letters = re.sub(r"[A-Za-z]+", r"\\mathrm{\g<0>}", shown(unit)[0])
    return f"$${symbol}\\ ({letters})$$".replace("µ", r"\mu ").replace("²", "^2")


def upright(location: float | None, colour: str, **style: Any) -> models.Span:
    """Return a line from the bottom to the top of a figure; a location None hides it."""
    return models.Span(location=location, dimension="height", line_color=colour, **style)


def plain_text(name: str, text: str = "", **styles: str) -> models.Div:
    """Return a widget for text that is shown as it is, neither as HTML nor as a formula."""
    return models.Div(text=text, render_as_text=True, disable_math=True, name=name, styles=styles)


def _small_text(name: str, text: str = "") -> models.PreText:
    """Return a widget for lines of small text of even width."""
    return models.PreText(text=text, disable_math=True, name=name, styles={"font-size": "11px"})


def frame(lengths: tuple[float, float], unit: str, longer: int) -> dict[str, Any]:
    """Return sides in screen pixels of a map of a cell, the longer one given, and labels of its axes."""
    width, height = (max(int(longer * length / max(lengths)), 90) for length in lengths)
    labels = {f"{axis}_axis_label": f"{axis} ({unit})" for axis in "xy"}
    # else a map that is broken into a line of its own is stretched over it
    still = {"flex": "0 1 auto"}
    return {"frame_width": width, "frame_height": height, "styles": still, **labels}


class MapPanel:
    """One field in colours. Maps of the same ranges are zoomed and moved together."""

    def __init__(self, quantity: str, name: str, **options: Any):
        self.title, _, self.unit = FIELDS[quantity]
        tools = {"tools": "pan,wheel_zoom,box_zoom,tap,reset,save", "active_scroll": "wheel_zoom"}
        # hidden until there is a field; tools stand in the line of the title, since beside a map they take its room
        options |= {"toolbar_location": "above", "visible": False}
        self.figure = figure(title=self.title, name=name, **tools, **options)
        self.figure.grid.visible = False
        self.image = empty_source("image", "x", "y", "dw", "dh")
        self.quantity = quantity
        colours = palette(quantity)
        self.mapper = models.LinearColorMapper(palette=colours, low=0, high=255, high_color=HARD)
        # bytes 0…255 are sent; the bar has the real limits
        columns = {key: key for key in self.image.data}
        self.figure.image(**columns, source=self.image, color_mapper=self.mapper, level="underlay")
        self.scale = models.LinearColorMapper(palette=colours, low=0, high=1)
        self.log_scale = models.LogColorMapper(palette=colours, low=1, high=10)
        self.bar, self.log_bar = (
            models.ColorBar(
                color_mapper=scale, height=10, padding=2, title=None, name=f"{name}_{bar}"
            )
            for scale, bar in ((self.scale, "bar"), (self.log_scale, "log_bar"))
        )
        self.log_bar.visible = False
        for bar in (self.bar, self.log_bar):
            self.figure.add_layout(bar, "below")
        self.prefix = 1.0  # from SI to the bar
        self.look = USUAL
        self.shown: Image | None = None

    def show(
        self, image: Image, factor: float, note: str, look: MapLook = USUAL, *, hard: bool = False
    ) -> None:
        """Show an image by one replacement of its data; the factor turns m into the unit of the axes."""
        # contact at the hardness has the highest value, and is grey
        self.mapper.high = 254 if hard else 255
        box = ([length * factor] for length in image.box)
        self.image.data = dict(zip(self.image.data, ([image.pixels], *box), strict=True))
        low, high = image.limits
        self.prefix, unit = scaled(max(abs(low), abs(high)), self.unit)
        ends = {"low": low * self.prefix, "high": max(high * self.prefix, low * self.prefix + 1e-9)}
        log = look.log and low > 0.0
        (self.log_scale if log else self.scale).update(**ends)
        self.bar.visible, self.log_bar.visible = not log, log
        if look.colours != self.look.colours:
            for mapper in (self.mapper, self.scale, self.log_scale):
                mapper.palette = palette(look.colours or self.quantity)
        self.look, self.shown = look, image
        view = f" (means of {image.step[0]} × {image.step[1]})" if max(image.step) > 1 else ""
        self.figure.title.text = f"{self.title} ({unit}){note}{view}"
        self.figure.visible = True


class _LinePanels:
    """Heights, pressure and temperature on a line through the marked point; contact is shaded."""

    def __init__(self, unit: str) -> None:
        self.source = empty_source("distance", *FIELDS, "contact", "width")
        self.figures: list[Any] = []
        self.titles: list[str] = []  # of the columns of its data, when there are any
        for name in FIELDS:
            last = name == "temperature"
            options = {"x_range": self.figures[0].x_range} if self.figures else {}
            options |= _WIDE | {"max_width": 690, "height": 150 if last else 112, "tools": _ALONG}
            plot = figure(name=f"profile_{name}", visible=False, **options)  # until there is a line
            plot.extra_y_ranges = {"share": models.Range1d(0, 1)}
            # bars, since a stepped area without points hangs BokehJS 3.9
            shade = {"source": self.source, "y_range_name": "share", "color": "#dddddd"}
            plot.vbar("distance", "width", "contact", 0, **shade)
            glyph = {"x": "distance", "y": name, "source": self.source, "color": COLOUR_OF[name]}
            if name == "pressure":
                plot.step(**glyph, mode="center")
            else:
                plot.line(**glyph)
            plot.add_layout(upright(0, MARK))
            plot.xaxis.visible = last
            self.figures.append(plot)
        self.figures[-1].xaxis.axis_label = f"distance from the marked point along sliding ({unit})"
        self.figures[0].add_tools(models.CrosshairTool(dimensions="height"))

    def show(self, distance: Field, values: dict[str, Field], width: float) -> list[str]:
        """Show fields over the distance, in the unit of the axis; return their values at distance 0 as texts."""
        texts, data = [], {"distance": distance}
        self.titles = [self.figures[-1].xaxis.axis_label]
        middle = int(np.abs(distance).argmin())
        for (name, (_, letter, si_unit)), plot in zip(FIELDS.items(), self.figures, strict=True):
            factor, unit = scaled(float(np.abs(values[name]).max()), si_unit)
            data[name] = values[name] * factor
            plot.visible = True
            plot.yaxis.axis_label = f"{letter} ({unit})"
            self.titles.append(f"{letter} ({unit})")
            texts.append(f"{letter} = {data[name][middle]:.5g} {unit}")
        contact = (values["pressure"] > 0.0).astype(float)
        self.source.data = data | {"contact": contact, "width": np.full(len(distance), width)}
        return texts


class _DistributionPanel:
    """The temperature over the contact, by area and by heat."""

    def __init__(self) -> None:
        options = _WIDE | {"max_width": 560, "height": 374, "tools": _ALONG}
        self.figure = figure(
            x_axis_label=_formula("T", "K"), name="distribution", visible=False, **options
        )
        self.bins = empty_source("left", "right", "area", "middle", "heat")
        self.flash = upright(None, _HEAT, line_dash="dashed", line_width=2)
        self.figure.add_layout(self.flash)
        grey = {"color": "#bbbbbb", "line_color": None, "legend_label": "of the contact area"}
        self.figure.quad("left", "right", "area", 0, source=self.bins, **grey)
        red = {"color": _HEAT, "line_width": 2, "legend_label": "of the heat"}
        self.figure.line("middle", "heat", source=self.bins, **red)
        self.figure.yaxis.axis_label = "% per K"
        self.figure.y_range.start = 0

    def show(self, contact: ContactTemperature) -> None:
        """Show the densities, and ⟨Tσ⟩/⟨σ⟩ as a dashed line."""
        edges, area, heat = densities(contact)
        left, right = edges[:-1], edges[1:]
        columns = left, right, area, 0.5 * (right + left), heat
        self.bins.data = dict(zip(self.bins.data, columns, strict=True))
        self.flash.location = contact.flash_temperature
        self.figure.title.text = (
            f"This field, at its q_c: ⟨Tσ⟩/⟨σ⟩ = {contact.flash_temperature:.4g} K (dashed),\n"
            f"mean of the contact {contact.mean_temperature:.4g} K, highest {contact.max_temperature:.4g} K"
        )
        self.figure.visible = True


class _CurvePanel:
    """One curve: the theory as a line, and a band with points for every column; all axes but that of g_σ are log."""

    def __init__(self, name: str, columns: tuple[str, ...], speed: float):
        title, y, y_si = _CURVES[name]
        self.over_speed = name != CORRELATION
        x, x_si, kind = ("v", "m/s", "log") if self.over_speed else ("r", "m", "linear")
        self.x_factor, self.factor = shown(x_si)[1], shown(y_si)[1]
        axes = {"x_axis_type": "log", "y_axis_type": kind}
        axes |= {"x_axis_label": _formula(x, x_si), "y_axis_label": _formula(y, y_si)}
        axes |= {"toolbar_location": "above", "tools": "pan,wheel_zoom,box_zoom,reset,save"}
        styles = {"flex": "1 1 230px", "max-width": "310px"}
        self.figure = figure(title=title, height=250, styles=styles, **axes, **_WIDE)
        self.sources = {"theory": empty_source("x", "y", "calibrated")}
        line = {"line_width": 1.5, "source": self.sources["theory"]}
        self.figure.line("x", "y", color=THEORY, legend_label="theory", **line)
        line |= {"line_dash": "dashed", "legend_label": "calibrated"}
        self.figure.line("x", "calibrated", color=CALIBRATED, **line)
        for measured in columns:
            source = self.sources[measured] = empty_source("x", "y", "low", "high")
            style = {"source": source, "color": COLOURS[measured], "legend_label": measured}
            self.figure.varea("x", "low", "high", alpha=0.3, **style)
            self.figure.line("x", "y", **style)
            if self.over_speed:
                self.figure.scatter("x", "y", size=5, **style)
        self.chosen_speed = upright(speed, MARK)
        if self.over_speed:
            self.figure.add_layout(self.chosen_speed)
        # one legend is enough for the row, below curves that rise
        self.figure.legend.visible = name == "flash_temperature"
        self.figure.legend.location = "bottom_right"

    def show_theory(self, x: Field, y: Field, calibrated: Field) -> None:
        """Show the curves of the theory; SI."""
        values = {"y": y * self.factor, "calibrated": calibrated * self.factor}
        self.sources["theory"].data = {"x": x * self.x_factor, **values}

    def show(self, name: str, curve: Estimate) -> None:
        """Show the measured curve of a column with the band of its error; SI."""
        (x,) = curve.coords.values()
        ends = ends_of_errors(curve.mean, curve.total_error, log=self.over_speed)
        data = {key: value * self.factor for key, value in {"y": curve.mean, **ends}.items()}
        self.sources[name].data = data | {"x": x * self.x_factor}


class Layout:
    """All controls, figures and texts of the page of a run; `speed`, m/s, is the first to be shown."""

    def __init__(self, run: Run, speed: float):
        self.factor, self.unit = scaled(max(run.sides), "m")
        columns = run.numerics.columns
        self.controls = Controls(run, speed)
        self.skin = SkinControls(run)
        titles = {name: title for name, (title, *_) in FIELDS.items()}
        self.takeaway = Takeaway(titles, self.controls.colours_of)

        # maps over one view, with the marked point and the line through it
        self.x_range, self.y_range = models.Range1d(), models.Range1d()
        self.show_cell(run.sides)
        view = frame(run.sides, self.unit, _SIDE)
        view |= {"x_range": self.x_range, "y_range": self.y_range}
        self.maps = {name: MapPanel(name, name, **view) for name in FIELDS}
        self.point, self.line_ends = empty_source("x", "y"), empty_source("x", "y")
        for panel in self.maps.values():
            mark = {"color": MARK, "line_width": 2}
            panel.figure.line("x", "y", source=self.line_ends, line_dash="dashed", **mark)
            mark |= {"marker": "circle_cross", "size": 13, "fill_alpha": 0}
            panel.figure.scatter("x", "y", source=self.point, **mark)

        # the other panels
        self.line = _LinePanels(self.unit)
        self.distribution = _DistributionPanel()
        self.curves = {name: _CurvePanel(name, columns, speed) for name in _CURVES}

        # texts
        self.state, self.values = plain_text("state"), plain_text("values")
        self.busy = plain_text("busy", color="#666666")
        wrapped = {"max-width": "1300px", "white-space": "pre-line"}
        self.problems = plain_text("problems", color="#b00020", **wrapped)
        self.budgets = {name: _small_text(f"budget_{name}") for name in columns}
        large = {"font-size": "16px", "font-weight": "bold"}
        heading = plain_text("heading", run.scene.title or str(run.folder), **large)
        scene = _small_text("scene", scene_text(run))
        scene.styles = scene.styles | {"overflow-x": "auto", "max-width": f"min(560px, {_PAGE})"}
        tabs = [
            models.TabPanel(child=text, title=f"error budget, {name}")
            for name, text in self.budgets.items()
        ]
        halves = [
            column(*figures, styles={"flex": "1 1 340px", "max-width": f"{widest}px"}, **_WIDE)
            for figures, widest in ((self.line.figures, 690), ([self.distribution.figure], 560))
        ]
        self.root = column(
            row(heading, self.state, self.busy, spacing=16, styles=WRAPPED),
            self.problems,
            self.controls.row,
            row(self.skin.row, self.takeaway.row, styles=WRAPPED),
            row(*(panel.figure for panel in self.maps.values()), styles=WRAPPED),
            self.values,
            row(*halves, styles=WRAPPED, **_WIDE),
            row(*(panel.figure for panel in self.curves.values()), styles=WRAPPED, **_WIDE),
            row(scene, models.Tabs(tabs=tabs, styles=_REST), spacing=30, styles=WRAPPED, **_WIDE),
            margin=(6, 10),
            **_WIDE,
        )

    def show_cell(self, lengths: tuple[float, float]) -> None:
        """Let the view be a cell of these sides, m; a part of it that is in view stays."""
        for axis, length in zip((self.x_range, self.y_range), lengths, strict=True):
            end = length * self.factor
            if axis.reset_end != end:
                bounds = -0.02 * end, 1.02 * end
                axis.update(bounds=bounds, start=0.0, end=end, reset_start=0.0, reset_end=end)

    def clear(self) -> None:
        """Empty and hide the maps, and the panels with values taken from them."""
        maps, other = self.maps.values(), (self.point, self.line_ends, self.line.source)
        for source in (*(panel.image for panel in maps), *other, self.distribution.bins):
            source.data = {name: [] for name in source.data}
        figures = [*(panel.figure for panel in maps), *self.line.figures, self.distribution.figure]
        for hidden in figures:
            hidden.visible = False
        self.distribution.flash.location = None
        self.distribution.figure.title.text = self.values.text = ""

    def add_below(self, part: Any) -> None:
        """Put a part that not all runs have above the curves, as the snapshots of a run whose faces slide."""
        children = list(self.root.children)
        self.root.children = [*children[:-2], part, *children[-2:]]

    def show_choice(self, speed: float, direction: float) -> None:
        """Set all controls and the marks on the curves to the chosen speed, m/s, and direction, rad."""
        controls = self.controls
        controls.speed.value = f"{speed:.4g}"
        controls.slider.value = min(max(log10(speed), controls.slider.start), controls.slider.end)
        controls.angle.value = round(degrees(remainder(direction, tau)))
        for panel in self.curves.values():
            panel.chosen_speed.location = speed

    def show_line(
        self, grid: Grid, point: tuple[int, int], line: Line, fields: dict[str, Field]
    ) -> None:
        """Show the marked point, the line through it on all maps, and fields along it."""
        x, y = (index * d * self.factor for index, d in zip(point, grid.spacing, strict=True))
        self.point.data = {"x": [x], "y": [y]}
        ends = zip("xy", (line.i, line.j), grid.spacing, strict=True)
        self.line_ends.data = {
            name: indices[[0, -1]] * d * self.factor for name, indices, d in ends
        }
        texts = self.line.show(line.distance * self.factor, fields, min(grid.spacing) * self.factor)
        position = f"x = {x:.5g} {self.unit}, y = {y:.5g} {self.unit}"
        self.values.text = f"Marked point ({position}), values of the full field: {', '.join(texts)}. Click a map to move it."
