"""What a reaction feels on the page: shares that are hotter, activation temperatures and rates over speed."""

from typing import Any

import numpy as np
from bokeh import models
from bokeh.layouts import row
from bokeh.plotting import figure

from roughsim.charts.reaction import HOTTER, RATES, WARM, Lines, points_of
from roughsim.charts.style import CALIBRATED, COLOURS, scale_colours
from roughsim.explore.controls import WRAPPED
from roughsim.explore.layout import LEGEND, empty_source, ends_of_errors

# title, and labels and kinds of the axes
_PANELS = {
    HOTTER: (
        "Share of the contact that is hotter, highest speed",
        "T (K)",
        "% hotter than T",
        "linear",
        "log",
    ),
    WARM: (
        "Activation temperature; dashed: calibrated theory",
        "v (m/s)",
        "T_act (K)",
        "log",
        "linear",
    ),
    RATES: (
        "Rate per nominal area; dashed: calibrated theory",
        "v (m/s)",
        "rate (1/s)",
        "log",
        "log",
    ),
}


class ReactionView:
    """The pictures of what a reaction feels in a column of a run; `root` is their part of the page."""

    def __init__(self, column: str):
        self.column = column
        self.sources: dict[str, list[models.ColumnDataSource]] = {}
        self.figures: dict[str, Any] = {}
        self.root = row(name="reactions", visible=False, styles=WRAPPED)

    def show(self, lines: dict[str, Lines]) -> None:
        """Show the lines of each panel; nothing before there are any."""
        if lines and not self.figures:
            for panel, of_panel in lines.items():
                self.figures[panel] = self._figure(panel, [*of_panel])
            self.root.children = [*self.figures.values()]
        self.root.visible = bool(lines)
        for panel, of_panel in lines.items():
            for source, line in zip(self.sources[panel], of_panel.values(), strict=True):
                places, one, theory = points_of(line, self.column)
                ends = ends_of_errors(one.mean, one.total_error, log=panel == RATES)
                x, y = (one.mean, places) if panel == HOTTER else (places, one.mean)
                dashed = np.full(len(places), np.nan) if theory is None else theory
                source.data = {"x": x, "y": y, "theory": dashed, **ends}

    def _figure(self, panel: str, names: list[str]) -> Any:
        """Make a figure with a line, its errors and its theory for each name."""
        title, x, y, x_kind, y_kind = _PANELS[panel]
        options: dict[str, Any] = {
            "x_axis_label": x,
            "y_axis_label": y,
            "x_axis_type": x_kind,
            "y_axis_type": y_kind,
        }
        plot = figure(
            title=title, name=panel, width=400, height=300, tools="pan,wheel_zoom,reset", **options
        )
        colours, at = scale_colours(len(names)), ("x", "theory")
        ends = "x", "low", "x", "high"
        if panel == HOTTER:  # temperatures lie along x
            colours, at = [COLOURS[self.column], "#808080"], ("theory", "y")
            ends = "low", "y", "high", "y"
        self.sources[panel] = []
        for name, colour in zip(names, colours, strict=True):
            source = empty_source("x", "y", "low", "high", "theory")
            style = {"source": source, "color": colour}
            plot.segment(*ends, **style)
            plot.line("x", "y", line_width=1.5, legend_label=name, **style)
            plot.scatter("x", "y", size=5, **style)
            dashed = style | ({"color": CALIBRATED} if panel == HOTTER else {})
            plot.line(*at, line_dash="dashed", **dashed)
            self.sources[panel].append(source)
        plot.legend.update(**LEGEND, ncols=4, padding=2)
        plot.add_layout(plot.legend[0], "below")  # lines rise and fall into every corner
        return plot
