"""The progress of a study on a terminal: points finished, the point at work, and the end."""

import os
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

from rich import progress as bars

from roughsim.ensemble.bar import PatientConsole
from roughsim.results.run import Run
from roughsim.show.text import clock
from roughsim.studies.study import Study
from roughsim.studies.work import scenes_of, study


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
        from roughsim.ensemble.status import realizations_needed

        done = run.target_met or run.realizations >= run.max_realizations
        self.share[run.folder] = 1.0 if done else min(run.realizations / realizations_needed(run), 1.0)
        if done:
            self.finished.add(run.folder)
        count = len(self.finished)
        text = f"{count} of {self.points} points finished; {run.realizations} realizations in {run.folder.name}"
        with suppress(OSError):
            self.bar.update(self.task, description=text, completed=sum(self.share.values()))
        if self.bar.disable and count * 5 // self.points > self.printed:
            self.printed = count * 5 // self.points
            self.console.print_lines(f"{count} of {self.points} points finished")


def study_shown(content: dict[str, Any], folder: Path, workers: int | None, *, began: float | None = None) -> Study:
    """Compute a study as `roughsim.study` does, showing progress and end; all cores for None.

    `content` has its scene, vary and target_error. `began` is when the command was given, s by `time.monotonic`.
    """
    began = time.monotonic() if began is None else began
    console = PatientConsole(stderr=True)
    points = len(scenes_of(content["scene"], content["vary"])[1]) - 1
    progress = StudyProgress(console, points)
    try:
        with suppress(OSError):
            progress.bar.start()
        result = study(
            content["scene"],
            vary=content["vary"],
            folder=folder,
            target_error=content.get("target_error"),
            workers=(os.cpu_count() or 1) if workers is None else workers,
            observer=progress.update,
        )
    finally:
        with suppress(OSError):
            progress.bar.stop()
    console.print_lines(f"{result.finished} of {points} points finished in {folder}, {clock(time.monotonic() - began)}")
    return result
