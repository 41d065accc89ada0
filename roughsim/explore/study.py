"""The page of a study: an observable over a varied number, a curve for each value of another, beside the theory."""

from pathlib import Path
from typing import Any

import numpy as np
from bokeh import models
from bokeh.document import Document
from bokeh.layouts import column, row
from bokeh.palettes import viridis
from bokeh.plotting import figure

from roughsim.explore.layout import THEME, plain_text
from roughsim.explore.page import HEAD, LatestTask
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.results.marks import is_whole
from roughsim.scene.numerics import SLIDING
from roughsim.show.table import shown, with_unit
from roughsim.show.text import plain
from roughsim.studies.study import Study, open_study
from roughsim.studies.tables import value_text, words_of

PERIOD = 5000  # ms between looks for new results
MOST_CURVES = 12  # of one figure: more cannot be told apart
WIDTH, HEIGHT = 860, 520  # of the figure, at most
SPEED, NONE = "speed", "none"  # names in the controls that are no varied key
THEORIES = {"theory": "solid", "calibrated": "dashed"}


class StudyPage:
    """The page of a study in an empty document of Bokeh."""

    def __init__(self, folder: Path, document: Document):
        self.folder = folder
        self.study = open_study(folder)
        self.rows = list(self.study.rows())
        self.names = {name: key for key, name in self.study.keys.items()}  # name in the table → key
        self.tasks = LatestTask(document, self.say)
        title = plain(self.study.scene.title or folder.name)
        self.state = plain_text("state")
        self.problems = plain_text("problems", color="#b00020")
        self.plot = row(name="plot", sizing_mode="stretch_width")
        self._make_controls()
        self.controls = row(*self.selects.values(), name="controls", styles={"flex-wrap": "wrap"})
        head = plain_text("title", title, **{"font-size": "20px", "font-weight": "600"})
        document.add_root(
            column(head, self.state, self.controls, self.plot, self.problems, sizing_mode="stretch_width")
        )
        document.title = f"roughsim: {title}"
        document.template, document.theme = HEAD, THEME
        document.add_periodic_callback(self.look_for_news, PERIOD)
        self.draw()

    def _make_controls(self) -> None:
        """Make a choice of the observable, of what lies along x, of what a curve is for, and one for each key."""
        numeric = [*(self.study.keys[key] for key in self.study.numeric_keys), SPEED]
        families = [SPEED, *self.names, NONE]
        second = next((name for name in self.names if name != numeric[0]), SPEED)
        self.selects: dict[str, models.Select] = {
            "observable": models.Select(title="observable", value="flash_temperature", options=list(OBSERVABLES)),
            "x": models.Select(title="along x", value=numeric[0], options=numeric),
            "family": models.Select(title="a curve for each", value=second, options=families),
        }
        speeds = sorted({r["speed"] for r in self.rows if r["speed"] is not None}, reverse=True)
        options = [(str(speed), f"{speed:g} m/s") for speed in speeds]
        self.selects[SPEED] = models.Select(title="speed", value=options[0][0] if options else "", options=options)
        for name, key in self.names.items():
            choices = self.choices(key)
            self.selects[f"key {name}"] = models.Select(title=words_of(key)[0], value=choices[0][0], options=choices)
        for name, select in self.selects.items():
            select.update(name=name.removeprefix("key "), width=190)
            select.on_change("value", lambda attr, old, new: self.draw())

    def choices(self, key: str) -> list[tuple[str, str]]:
        """Return the values of a key, as they are compared and as they are shown."""
        return list(
            {str(value): value_text(key, value) for value in (p.values[key] for p in self.study.points)}.items()
        )

    def choice(self, name: str) -> str:
        """Return the value of a control."""
        return str(self.selects[name].value)

    def chosen_rows(self) -> list[dict[str, Any]]:
        """Return the rows of the observable, at the chosen values of all keys that are neither along x nor a family."""
        free = {self.choice("x"), self.choice("family")}
        rows = [r for r in self.rows if r["observable"] == self.choice("observable")]
        for name in self.names:
            if name not in free:
                rows = [r for r in rows if str(r[name]) == self.choice(f"key {name}")]
        with_speed = {(r["point"], r["speed"]) for r in rows if r["speed"] is not None}
        if SPEED not in free and len(with_speed) > len(dict(with_speed)):  # else each point has one speed of its own
            rows = [r for r in rows if r["speed"] is None or str(r["speed"]) == self.choice(SPEED)]
        if self.choice("x") == SPEED:
            rows = [r for r in rows if r["speed"] is not None]
        return rows

    def words(self, name: str) -> tuple[str, float]:
        """Return what an axis is called, and the factor from SI to its unit."""
        return words_of(self.names.get(name, "sliding.speed"))

    def draw(self) -> None:
        """Draw the figure anew, and show only the controls that matter."""
        free = {self.choice("x"), self.choice("family")}
        for name in (SPEED, *(f"key {name}" for name in self.names)):
            self.selects[name].visible = name.removeprefix("key ") not in free
        self.problems.text = ""
        count, total = self.study.finished, len(self.study.points)
        self.state.text = (
            f"{count} of {total} points finished. Points: simulated, ± total error (95 %). Thin lines: theory; dashed: "
            "by the calibrated stress spectrum."
        )
        if any(r["column"] == SLIDING for r in self.rows):
            self.state.text += " Diamonds: of faces that slide over one another."
        if not all(is_whole(r["unknown"], r["note"]) for r in self.rows):
            self.state.text += " Hollow: at q_c, or a part of the error is unknown."
        rows = self.chosen_rows()
        if not rows:
            self.say(ValueError("there is no result to draw with these values yet"))
            return
        self.plot.children = [self.figure_of(rows)]

    def figure_of(self, rows: list[dict[str, Any]]) -> Any:
        """Return the figure of some rows."""
        x, family, observable = self.choice("x"), self.choice("family"), self.choice("observable")
        words, factor = self.words(x)
        unit, simulation = OBSERVABLES[observable].unit, self.study.column  # which asks every point
        in_unit = shown(unit)[1]
        places = [r[x] for r in rows]
        simulated = [r["value"] for r in rows if r["column"] == simulation]
        log_x = min(places) > 0.0 and max(places) > 5.0 * min(places)
        log_y = bool(simulated) and min(simulated) > 0.0
        made = figure(
            x_axis_type="log" if log_x else "linear",
            y_axis_type="log" if log_y else "linear",
            x_axis_label=words,
            y_axis_label=with_unit(observable.replace("_", " "), unit),
            sizing_mode="stretch_width",
            max_width=WIDTH,
            height=HEIGHT,
            tools="pan,wheel_zoom,box_zoom,reset,save",
        )
        values = list({str(r.get(family)): r.get(family) for r in rows}.values())
        if len(values) > MOST_CURVES:
            values = [values[k] for k in np.linspace(0, len(values) - 1, MOST_CURVES).round().astype(int)]
        for value, colour in zip(values, viridis(max(len(values), 2) + 1), strict=False):
            same = [r for r in rows if family == NONE or r.get(family) == value]
            label = self.label_of(family, value)
            for source, dash in THEORIES.items():
                at, mean, *_ = curve(same, x, source)
                made.line(at * factor, mean * in_unit, color=colour, line_dash=dash, line_width=1, alpha=0.8)
            at, mean, error, marks = curve(same, x, simulation)
            whole = np.array([is_whole(*each) for each in marks], bool)
            data = {"x": at * factor, "y": mean * in_unit, "joined": np.where(whole, mean * in_unit, np.nan)}
            data |= {"low": (mean - error) * in_unit, "high": (mean + error) * in_unit, "error": error * in_unit}
            data |= {"at_least": ["≥" if unknown else "" for unknown, _ in marks], "note": [note for _, note in marks]}
            source = models.ColumnDataSource(data | {"face": faces(marks, colour)})
            style = {"color": colour, "legend_label": label}
            dots = made.scatter("x", "y", source=source, size=7, fill_color="face", line_width=1.5, **style)
            made.line("x", "joined", source=source, line_width=2, alpha=0.5, **style)
            at, mean, _, marks = curve(same, x, SLIDING)
            if len(at):
                slid = {"x": at * factor, "y": mean * in_unit, "face": faces(marks, colour)}
                diamond = {"color": colour, "fill_color": "face", "size": 12}
                made.scatter("x", "y", source=models.ColumnDataSource(slid), marker="diamond", **diamond)
            whisker = {"base": "x", "lower": "low", "upper": "high", "line_color": colour, "source": source}
            made.add_layout(models.Whisker(**whisker, upper_head=None, lower_head=None))
            tips = [(words, "@x{0.[0000]a}"), (observable, "@y{0.[0000]a} ± @at_least@error{0.[0000]a} @note")]
            made.add_tools(models.HoverTool(renderers=[dots], tooltips=tips))
        for axis, logarithmic in ((made.xaxis, log_x), (made.yaxis, log_y)):
            if logarithmic:
                axis.ticker = models.LogTicker(mantissas=[1, 2, 5])
        made.legend.title = "" if family == NONE else self.words(family)[0]
        made.add_layout(made.legend[0], "right" if len(values) > 1 else "center")
        made.legend.click_policy = "hide"
        return made

    def label_of(self, family: str, value: Any) -> str:
        """Return what a curve is called."""
        if value is None or family == NONE:
            return self.study.column
        if family == SPEED:
            return f"{value:g} m/s"
        words = words_of(self.names[family])[0].rpartition(", ")
        return f"{value_text(self.names[family], value)} {words[2] if words[1] else ''}".strip()

    def look_for_news(self) -> None:
        """Read the study again in a thread, and draw it if it has more."""

        def read() -> tuple[Study, list[dict[str, Any]]]:
            study = self.study.reread()
            return study, list(study.rows())

        def show(news: tuple[Study, list[dict[str, Any]]]) -> None:
            changed = [r["value"] for r in news[1]] != [r["value"] for r in self.rows]
            self.study, self.rows = news
            if changed:
                for name, key in self.names.items():  # values may have been added
                    self.selects[f"key {name}"].options = self.choices(key)
                self.draw()

        if self.study.finished < len(self.study.points):
            self.tasks.ask(read, show)

    def say(self, error: Exception) -> None:
        """Show what went wrong."""
        self.problems.text = str(error)


def faces(marks: list[tuple[str, str]], colour: str) -> list[str]:
    """Return the colours of the inside of points: white where a value is not whole."""
    return [colour if is_whole(*each) else "white" for each in marks]


def curve(rows: list[dict[str, Any]], x: str, column: str) -> tuple[Any, Any, Any, list[tuple[str, str]]]:
    """Return the places, values and errors of a column, by place, and the marks of each: unknown parts, and note."""
    of_column = sorted((r for r in rows if r["column"] == column), key=lambda r: r[x])
    at, value, error = (np.array([r[name] for r in of_column], float) for name in (x, "value", "total_error"))
    return at, value, np.nan_to_num(error), [(r["unknown"], r["note"]) for r in of_column]
