"""A bar that shows how far a run is, on a terminal or in a notebook; in a file or pipe it is a line for each round."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from importlib import import_module
from typing import Any

from rich import progress as bars

from roughsim.ensemble.status import needed, round_text, seconds_left, time_left
from roughsim.results.run import Run
from roughsim.show.terminal import PlainConsole
from roughsim.show.text import is_notebook

EVERY = 0.1  # s between two updates, as often as a bar is drawn


class PatientConsole(PlainConsole):
    """A console that survives a closed pipe: rich itself would end the process, and with it the run."""

    def on_broken_pipe(self) -> None:
        """Drop the text."""

    def print_lines(self, *lines: str, style: str | None = None) -> None:
        """Print lines; if the terminal or pipe is closed they are dropped, and the run goes on."""
        with suppress(OSError):
            for line in lines:
                self.print(line, style=style, soft_wrap=True)


class Progress:
    """A bar on a terminal, or a line for each round in a file or pipe; a closed or full one does not stop the run."""

    def __init__(self, console: PatientConsole):
        self.console = console
        count, left = (bars.TextColumn(text, markup=False) for text in ("{task.description}", "{task.fields[left]}"))
        self.bar = bars.Progress(count, bars.BarColumn(), left, console=console, disable=not console.is_terminal)
        self.task = self.bar.add_task("planning", total=None, left="")
        self.round = 0  # that was shown last
        self.shown = 0.0  # when the bar was updated last, by `time.monotonic`

    def update(self, run: Run) -> None:
        """Show the state of the run, and the time left once that is known."""
        new_round = run.rounds.number != self.round
        if not new_round and time.monotonic() - self.shown < EVERY:
            return
        self.round, self.shown = run.rounds.number, time.monotonic()
        text, left = round_text(run), time_left(seconds_left(run))
        done = len(run.members) / max(sum(needed(run)), 1)
        with suppress(OSError):
            self.bar.update(self.task, description=text, total=1.0, completed=min(done, 1.0), left=left)
        if self.bar.disable and new_round:
            self.console.print_lines(f"{text}, {left}")


@contextmanager
def shown_in_notebook(
    observer: Callable[[Run], None] | None, make: Callable[[PatientConsole], Any] = Progress
) -> Iterator[Callable[[Run], None] | None]:
    """Show a bar below the cell of a notebook, and yield what updates it and calls `observer`; elsewhere that alone.

    `make` returns what has a `bar` of rich, and `update`, which is called with a run.
    """
    if not is_notebook():
        yield observer
        return
    console = PatientConsole()
    console.quiet = True  # the cell shows all
    shown = make(console)
    # rich would need another package to draw its bar anew; a cell can show a new one by itself
    cell: Any = import_module("IPython.display").display(table_of(shown.bar), display_id=True)

    def update(run: Run) -> None:
        shown.update(run)
        cell.update(table_of(shown.bar))
        if observer is not None:
            observer(run)

    yield update


def table_of(bar: bars.Progress) -> Any:
    """Return a bar as it is now, as something that a cell can show."""
    return bar.make_tasks_table(bar.tasks)
