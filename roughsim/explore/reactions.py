"""What a reaction feels on the page: shares that are hotter, activation temperatures over energy, rates over speed."""

from math import inf
from typing import Any

import numpy as np
from bokeh import models
from bokeh.layouts import row
from bokeh.plotting import figure

from roughsim.charts.reaction_lines import ReactionLine
from roughsim.charts.sliding import speed_colours
from roughsim.charts.style import CALIBRATED, COLOURS
from roughsim.explore.layout import LEGEND, empty_source
from roughsim.explore.reacting import HOTTER, RATES, WARM, labels
from roughsim.results.run import Run

# title, and labels and kinds of the axes
_PANELS = {
    HOTTER: (
        "Share of the contact that is hotter, highest speed",
        "T, K",
        "% hotter than T",
        "linear",
        "log",
    ),
    WARM: (
        "Activation temperature; dashed: calibrated theory",
        "E, eV",
        "T_act, K",
        "linear",
        "linear",
    ),
    RATES: (
        "Rate per nominal area; dashed: calibrated theory",
        "v, m/s",
        "rate, 1/s",
        "log",
        "log",
    ),
}


class ReactionView:
    """The pictures of a run that asks for the distribution of the temperature; `root` is their part of the page."""

    def __init__(self, run: Run):
        self.sources: dict[str, list[models.ColumnDataSource]] = {}
        self.figures = {
            panel: self._figure(run, panel, names) for panel, names in labels(run).items()
        }
        self.root = row(
            *self.figures.values(), name="reactions", visible=False, styles={"flex-wrap": "wrap"}
        )

    def _figure(self, run: Run, panel: str, names: list[str]) -> Any:
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
        colours = (
            [COLOURS[run.column(None)], "#808080"] if panel == HOTTER else speed_colours(len(names))
        )
        self.sources[panel] = []
        for name, colour in zip(names, colours, strict=True):
            source = empty_source("x", "y", "low", "high", "theory")
            at = ("theory", "y") if panel == HOTTER else ("x", "theory")
            style = {"source": source, "color": colour}
            ends = ("low", "y", "high", "y") if panel == HOTTER else ("x", "low", "x", "high")
            plot.segment(*ends, **style)
            plot.line("x", "y", line_width=1.5, legend_label=name, **style)
            plot.scatter("x", "y", size=5, **style)
            dashed = {
                "source": source,
                "color": CALIBRATED if panel == HOTTER else colour,
                "line_dash": "dashed",
            }
            plot.line(*at, **dashed)
            self.sources[panel].append(source)
        plot.legend.update(**LEGEND, ncols=4, padding=2)
        plot.add_layout(plot.legend[0], "below")  # lines rise and fall into every corner
        return plot

    def show(self, lines: dict[str, list[ReactionLine]]) -> None:
        """Show the lines of each panel; nothing before there are any."""
        self.root.visible = bool(lines)
        for panel, of_panel in lines.items():
            for source, line in zip(self.sources[panel], of_panel, strict=True):
                error = np.where(np.isfinite(line.error), line.error, 0.0)
                # on a log axis an error that reaches zero has no end
                least = 1e-3 * line.mean if panel == RATES else -inf
                ends = {"low": np.maximum(line.mean - error, least), "high": line.mean + error}
                values, places = ("x", "y") if panel == HOTTER else ("y", "x")
                source.data = {values: line.mean, places: line.place, "theory": line.theory, **ends}
