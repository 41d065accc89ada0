"""Progress of a run: a bar on a terminal, and lines with the time in a file, a pipe or a notebook."""

import time
from contextlib import AbstractContextManager, suppress
from datetime import timedelta
from pathlib import Path
from threading import Event, Thread
from typing import Any

from rich import progress as bars
from rich.console import Console
from rich.text import Text

from roughsim.ensemble.status import seconds_left
from roughsim.results.run import Run
from roughsim.show.text import clock, plain_lines, tell

SILENCE = 2.0  # s until a first line without a terminal; each further silence is twice as long, up to _LONGEST
LINES = 5  # of a study, printed at most without a terminal
_LONGEST = 60.0  # s: a run of a day writes 1,440 lines


class _Console(Console):
    """A console of rich that takes no text as markup, emoji or command."""

    def render_str(self, text: str, **rest: Any) -> Text:
        """Return a text to render, made harmless: rich calls this for every line."""
        return super().render_str(plain_lines(text), **rest)

    def on_broken_pipe(self) -> None:
        """Drop the text; rich would end the process."""


class Progress(AbstractContextManager["Progress"]):
    """A line of text with a bar on a terminal; elsewhere lines: when a new stage begins, and after a silence.

    An output that is full or closed does not stop the run.
    """

    def __init__(self, text: str):
        console = _Console(stderr=True, markup=False, emoji=False, highlight=False)
        columns = (
            bars.TextColumn("{task.description}", markup=False),
            bars.BarColumn(bar_width=None),
        )
        self._bar = bars.Progress(
            *columns, console=console, expand=True, disable=not console.is_terminal
        )
        self._task = self._bar.add_task(text, total=None)
        self._text, self._stage = text, 0
        self._began = self._told = time.monotonic()
        self._silence = SILENCE
        self._ended = Event()
        self._teller = Thread(target=self._tell_after_silence, daemon=True)

    def __enter__(self) -> "Progress":
        with suppress(OSError):
            self._bar.start()
        if self._bar.disable:
            self._teller.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        if (
            not self._bar.disable
        ):  # older versions of rich end one that is disabled with an empty line
            with suppress(OSError):
                self._bar.stop()

    def show(self, text: str, share: float, stage: int) -> None:
        """Show text, and the share of the work that is done; stages are numbered from 0."""
        self._text = text
        with suppress(OSError):
            self._bar.update(self._task, description=text, total=1.0, completed=min(share, 1.0))
        if self._bar.disable and stage != self._stage:
            self._tell()
        self._stage = stage

    def update(self, run: Run) -> None:
        """Show the round of a run, its largest error over its target, and the time left."""
        share = len(run.members) / max(sum(run.needed), 1)
        self.show(progress_text(run), share, run.rounds.number)

    def _tell(self) -> None:
        """Write the text as a line, after the time since the start, unless it has no count yet."""
        self._told = time.monotonic()
        if any(map(str.isdigit, self._text)):
            tell(f"{timedelta(seconds=round(self._told - self._began))} {self._text}")

    def _tell_after_silence(self) -> None:
        """Write a line after each silence, until the work has ended."""
        while not self._ended.wait(max(self._told + self._silence - time.monotonic(), 0.0)):
            if time.monotonic() >= self._told + self._silence:
                self._tell()
                self._silence = min(2.0 * self._silence, _LONGEST)


class StudyProgress(Progress):
    """Progress over the points of a study: the finished ones, and the current one."""

    def __init__(self, points: int):
        super().__init__(f"planning {points} points")
        self._points = points
        self._shares: dict[Path, float] = {}  # finished share of the work of each point

    def update(self, run: Run) -> None:
        """Show the number of finished points, and the current one."""
        share = min(len(run.members) / max(sum(run.needed), 1), 0.99)
        self._shares[run.folder] = 1.0 if run.finished else share
        finished = sum(share == 1.0 for share in self._shares.values())
        text = f"{finished} of {self._points} points finished; {run.realizations} realizations in {run.folder.name}"
        self.show(text, sum(self._shares.values()) / self._points, finished * LINES // self._points)


def progress_text(run: Run) -> str:
    """Return the round of a run, its largest error over its target, and the time left, in less than 75 columns."""
    wanted = run.rounds.wanted
    there = sum(min(run.members.available[level], count) for level, count in enumerate(wanted))
    text = f"round {run.rounds.number + 1}: {there}/{sum(wanted)} members"
    if errors := run.total_errors:
        worst = max(errors, key=lambda name: errors[name] / run.until[name])
        least = "≥" * bool(run.unknown_parts(worst))
        text += f", error {least}{100 * errors[worst]:.2g} % (target {100 * run.until[worst]:g} %)"
    seconds = seconds_left(run)
    return text if seconds is None else f"{text}, {clock(seconds)} left"
