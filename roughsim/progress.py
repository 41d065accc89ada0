"""The progress of a run on a terminal: members done, how near the target is, and the time left."""

from __future__ import annotations

import time
from types import TracebackType
from typing import TYPE_CHECKING, Self

from rich import progress as bars
from rich.console import Console

from roughsim.status import clock, reached, realizations_needed

if TYPE_CHECKING:
    from roughsim.record import Run


class Progress:
    """A bar on a terminal, a line now and then elsewhere."""

    def __init__(self, console: Console):
        self.console = console
        columns = (bars.TextColumn("{task.description}"), bars.BarColumn(), bars.TextColumn("{task.fields[left]}"))
        self.bar = bars.Progress(*columns, console=console, disable=not console.is_terminal)
        self.task = self.bar.add_task("starting", total=1.0, left="")
        self.began = time.monotonic()
        self.first: int | None = None
        self.said = -1

    def __enter__(self) -> Self:
        self.bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.bar.stop()

    def update(self, run: Run) -> None:
        """Show where the run stands."""
        count = run.realizations
        members = len(run.members)
        if self.first is None:
            self.first = members - 1
        needed = realizations_needed(run)
        rate = (members - self.first) / max(time.monotonic() - self.began, 1e-9)
        expected = run.numerics.members(needed)
        left = max(expected - members, 0) / rate
        text = f"{count} of about {needed} realizations{reached(run)}"
        done = members / expected
        self.bar.update(self.task, description=text, completed=min(done, 1.0), left=f"{clock(left)} left")
        if self.bar.disable and count and count % max(needed // 5, 1) == 0 and count != self.said:
            self.said = count
            self.console.print(f"{text}, {clock(left)} left", highlight=False, soft_wrap=True)

    def summary(self, run: Run) -> list[str]:
        """Return what to say at the end."""
        seconds = time.monotonic() - self.began
        lines = [f"{run.realizations} realizations in {run.folder}, {clock(seconds)}{reached(run)}"]
        if run.failed:
            lines.append(f"{run.failed} did not converge and are left out of the means")
        if run.until and not run.target_met:
            lines.append("target not reached: raise --max, or the target, and give the same command again")
        return lines
