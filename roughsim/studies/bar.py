"""A bar over the points of a study, on a terminal or in a notebook; in a file or pipe it is a few lines."""

from contextlib import suppress
from pathlib import Path

from rich import progress as bars

from roughsim.ensemble.bar import PatientConsole
from roughsim.results.run import Run


class StudyProgress:
    """A bar over the points on a terminal, or five lines in all in a file or pipe."""

    def __init__(self, console: PatientConsole, points: int):
        self.console, self.points = console, points
        text = bars.TextColumn("{task.description}", markup=False)
        self.bar = bars.Progress(text, bars.BarColumn(), console=console, disable=not console.is_terminal)
        self.task = self.bar.add_task(f"planning {points} points", total=float(points))
        self.finished: set[Path] = set()
        self.share: dict[Path, float] = {}  # of each point that is not finished
        self.printed = 0  # fifths of the points

    def update(self, run: Run) -> None:
        """Show the state after a member of a point."""
        from roughsim.ensemble.status import needed

        self.share[run.folder] = 1.0 if run.finished else min(len(run.members) / max(sum(needed(run)), 1), 1.0)
        if run.finished:
            self.finished.add(run.folder)
        count = len(self.finished)
        text = f"{count} of {self.points} points finished; {run.realizations} realizations in {run.folder.name}"
        with suppress(OSError):
            self.bar.update(self.task, description=text, completed=sum(self.share.values()))
        if self.bar.disable and count * 5 // self.points > self.printed:
            self.printed = count * 5 // self.points
            self.console.print_lines(f"{count} of {self.points} points finished")
