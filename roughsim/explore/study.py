"""The page of a study: its figure, with controls that choose the observable, the axis and the curves."""

from functools import partial
from pathlib import Path
from typing import Any

from bokeh import models
from bokeh.document import Document
from bokeh.layouts import column, row

from roughsim.charts.style import data_url
from roughsim.estimate.asked import ABOUT, asked_names
from roughsim.explore.controls import WRAPPED
from roughsim.explore.layout import THEME, plain_text
from roughsim.explore.page import HEAD
from roughsim.explore.tasks import LatestTask
from roughsim.observables.catalogue import observables_of
from roughsim.show.text import plain
from roughsim.studies.figure import NONE, Choice, draw_study, usual_choice
from roughsim.studies.results import SPEED
from roughsim.studies.study import Study, open_study
from roughsim.studies.tables import value_text, words_of

_PERIOD = 5000  # ms between checks for new results
_WIDTH = "1000px"  # of the figure, at most
_HIGHEST = ""  # in the control of the speed


class StudyPage:
    """The page of a study in an empty document of Bokeh."""

    def __init__(self, folder: Path, document: Document):
        self.study = open_study(folder)
        self.study.table()  # its theories take a while: now, and no control is slow later
        self._tasks = LatestTask(document, self.show_problem)
        self.state = plain_text("state")
        self.problems = plain_text("problems", color="#b00020")
        self.figure = models.Div(
            name="figure", sizing_mode="stretch_width", styles={"max-width": _WIDTH}
        )
        self.selects = self._make_controls()
        controls = row(*self.selects.values(), name="controls", styles=WRAPPED)
        title = plain(self.study.scene.title or folder.name)
        head = plain_text("title", title, **{"font-size": "20px", "font-weight": "600"})
        root = column(
            head, self.state, controls, self.figure, self.problems, sizing_mode="stretch_width"
        )
        document.add_root(root)
        document.title = f"roughsim: {title}"
        document.template, document.theme = HEAD, THEME
        document.add_periodic_callback(self.read_news, _PERIOD)
        self.draw()

    def _make_controls(self) -> dict[str, Any]:
        """Return controls of the observable, the axis, the curves, the speed, and of each key ("key NAME")."""
        usual = usual_choice(self.study, "flash_temperature")
        asked = asked_names(self.study.scene)
        observables = [*observables_of(self.study.scene.asks), *asked]
        about = list(dict.fromkeys(ABOUT[name] for name in asked))
        numeric = [*(self.study.keys[key] for key in self.study.numeric_keys), SPEED, *about]
        families = [SPEED, *self.study.keys.values(), *about, NONE]
        speeds = {speed for _, run in self.study.results for speed in run.scene.speeds}
        speed_options = [(str(speed), f"{speed:g} m/s") for speed in sorted(speeds, reverse=True)]
        # title, value and options of each
        controls: dict[str, tuple[str, str, Any]] = {
            "observable": ("observable", usual.observable, observables),
            "x": ("along x", usual.x, numeric),
            "family": ("a curve for each", usual.family, families),
            SPEED: ("speed", _HIGHEST, [(_HIGHEST, "highest"), *speed_options]),
        }
        for key, name in self.study.keys.items():
            options = self._options(name)
            controls[f"key {name}"] = words_of(key)[0], options[0][0], options
        selects = {}
        for name, (title, value, options) in controls.items():
            select = models.Select(title=title, value=value, options=options, width=190)
            select.name = name.removeprefix("key ")
            select.on_change("value", lambda attr, old, new: self.draw())
            selects[name] = select
        return selects

    def _options(self, name: str) -> list[tuple[str, str]]:
        """Return the values of a key as options of a control."""
        key, values = self.study.full(name), self.study.values_of(name)
        return [(text, value_text(key, value)) for text, value in values.items()]

    def choice(self) -> Choice:
        """Return the choice of the controls."""
        selected = {name: str(select.value) for name, select in self.selects.items()}
        fixed = {
            name: self.study.values_of(name)[selected[f"key {name}"]]
            for name in self.study.keys.values()
        }
        if selected[SPEED] != _HIGHEST:
            fixed[SPEED] = float(selected[SPEED])
        return Choice(selected["observable"], selected["x"], selected["family"], fixed)

    def draw(self) -> None:
        """Draw the figure, and show the controls that change it."""
        choice = self.choice()
        for name in (SPEED, *(f"key {name}" for name in self.study.keys.values())):
            self.selects[name].visible = name.removeprefix("key ") not in (choice.x, choice.family)
        self.state.text = f"{self.study.finished} of {len(self.study.points)} points finished"
        self.problems.text = ""
        try:
            url = data_url(partial(draw_study, self.study, choice), ".svg")
        except ValueError as error:
            self.figure.text = ""
            self.show_problem(error)
            return
        self.figure.text = f'<img alt="figure of the study" style="width: 100%" src="{url}">'

    def read_news(self) -> None:
        """Read the study again in a thread, and draw it if it has new results."""

        def read() -> Study:
            study = self.study.reread()
            study.table()  # its theories take a while
            return study

        def show(study: Study) -> None:
            before, self.study = self.study, study
            if _counts(study) != _counts(before):
                for name in study.keys.values():
                    self.selects[f"key {name}"].options = self._options(name)
                self.draw()

        if self.study.finished < len(self.study.points):
            self._tasks.ask(read, show)

    def show_problem(self, error: Exception) -> None:
        """Show the message of an error."""
        self.problems.text = str(error)


def _counts(study: Study) -> list[Any]:
    """Return the number of realizations of each point with results."""
    return [(point.name, run.counts) for point, run in study.results]
