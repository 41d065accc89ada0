"""The progress of a run on a terminal: realizations, errors beside their targets, and the time left."""

import os
import time
from contextlib import suppress
from pathlib import Path

from rich import progress as bars

from roughsim.ensemble.run import begin, run
from roughsim.ensemble.status import count_text, end_known, losses, reached, realizations_needed
from roughsim.planning.limits import judge
from roughsim.planning.realization import march_problem
from roughsim.results.run import Run
from roughsim.scene import Scene
from roughsim.show.terminal import PlainConsole
from roughsim.show.text import clock, warn


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
    """A bar on a terminal, or five lines in all in a file or pipe; one that is closed or full does not stop the run."""

    def __init__(self, console: PatientConsole):
        self.console = console
        count, left = (bars.TextColumn(text, markup=False) for text in ("{task.description}", "{task.fields[left]}"))
        self.bar = bars.Progress(count, bars.BarColumn(), left, console=console, disable=not console.is_terminal)
        self.task = self.bar.add_task("planning", total=None, left="")
        self.began = time.monotonic()
        self.first: int | None = None  # number of members before this process added any
        self.printed = -1  # realizations in the line that was printed last

    def update(self, run: Run) -> None:
        """Show the state of the run, and the time left once that is known."""
        count, members = run.realizations, len(run.members)
        if self.first is None:
            self.first = members - 1
        needed = realizations_needed(run)
        expected = run.numerics.members(needed)
        rate = (members - self.first) / max(time.monotonic() - self.began, 1e-9)
        left = f"{clock(max(expected - members, 0) / rate)} left" if end_known(run) else "time left not known yet"
        text = count_text(run) + reached(run)
        with suppress(OSError):
            self.bar.update(self.task, description=text, total=1.0, completed=min(members / expected, 1.0), left=left)
        # without a bar: five lines in all, and no count twice
        if self.bar.disable and count and count % max(needed // 5, 1) == 0 and count != self.printed:
            self.printed = count
            self.console.print_lines(f"{text}, {left}")


def run_shown(scene: Scene, folder: Path, workers: int | None, *, began: float | None = None) -> Run:
    """Plan and run a scene as `roughsim.run` does, showing the plan, the progress and the end; all cores for None.

    `began` is when the command was given, s by `time.monotonic`; now if left out. The last line tells the time since.
    """
    began = time.monotonic() if began is None else began
    console = PatientConsole(stderr=True)
    progress = Progress(console)
    try:
        with suppress(OSError):
            progress.bar.start()
        numerics = begin(scene, folder)
        plan = (reason.value for reason in numerics.reasons if reason.choice in ("smoothed", "capped", "elastic"))
        console.print_lines(*plan, style="dim")
        if numerics.march is not None:
            steps = march_problem(scene, numerics).steps
            told = f"sliding: {steps} contacts in turn for each member; one that is broken off begins again"
            console.print_lines(told, style="dim")
        for line in judge(scene, numerics).warnings:
            warn(line)
        count = (os.cpu_count() or 1) if workers is None else workers
        progress.began = time.monotonic()  # the time left follows from the members alone
        result = run(scene, folder, numerics=numerics, workers=count, observer=progress.update)
    finally:
        with suppress(OSError):
            progress.bar.stop()
    duration = clock(time.monotonic() - began)
    console.print_lines(f"{result.realizations} realizations in {result.folder}, {duration}{reached(result)}")
    console.print_lines(*losses(result))
    if result.until and not result.target_met:
        console.print_lines("target not reached: raise --max, or the target, and give the same command again")
    return result
