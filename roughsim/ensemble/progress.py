"""Progress of a run: a bar on a terminal, and a line for each round in a file, a pipe or a notebook."""

from contextlib import AbstractContextManager, suppress

from rich import progress as bars

from roughsim.ensemble.status import round_text, time_left
from roughsim.results.run import Run
from roughsim.show.terminal import PlainConsole
from roughsim.show.text import tell


class _Console(PlainConsole):
    def on_broken_pipe(self) -> None:
        """Drop the text; rich would end the process."""


class Progress(AbstractContextManager["Progress"]):
    """A line of text with a bar on a terminal; elsewhere the text alone, when a new stage begins.

    An output that is full or closed does not stop the run.
    """

    def __init__(self, text: str):
        console = _Console(stderr=True)
        description = bars.TextColumn("{task.description}", markup=False)
        self._bar = bars.Progress(description, bars.BarColumn(), console=console, disable=not console.is_terminal)
        self._task = self._bar.add_task(text, total=None)
        self._stage = 0

    def __enter__(self) -> "Progress":
        with suppress(OSError):
            self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        with suppress(OSError):
            self._bar.stop()

    def show(self, text: str, share: float, stage: int) -> None:
        """Show text, and the share of the work that is done; stages are numbered from 0."""
        with suppress(OSError):
            self._bar.update(self._task, description=text, total=1.0, completed=min(share, 1.0))
        if self._bar.disable and stage != self._stage:
            tell(text)
        self._stage = stage

    def update(self, run: Run) -> None:
        """Show the round of a run, the errors with their targets, and the time left."""
        share = len(run.members) / max(sum(run.needed), 1)
        self.show(f"{round_text(run)}, {time_left(run)}", share, run.rounds.number)
