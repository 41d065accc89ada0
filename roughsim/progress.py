"""The progress of a run on a terminal: members done, how near the target is, and the time left."""

from __future__ import annotations

import time
from types import TracebackType
from typing import TYPE_CHECKING, Self

from rich import progress as bars
from rich.console import Console

from roughsim.estimate import relative_half_width

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
        needed = self._needed(run)
        rate = (members - self.first) / max(time.monotonic() - self.began, 1e-9)
        left = max(needed * len(run.numerics.levels) - members, 0) / rate
        text = f"{count} of about {needed} realizations{_reached(run)}"
        self.bar.update(self.task, description=text, completed=min(count / needed, 1.0), left=f"{_clock(left)} left")
        if self.bar.disable and count and count % max(needed // 5, 1) == 0 and count != self.said:
            self.said = count
            self.console.print(f"{text}, {_clock(left)} left", highlight=False, soft_wrap=True)

    @staticmethod
    def _needed(run: Run) -> int:
        """How many realizations the target will take: the half-width falls as 1/√n."""
        rows = run.sound(run.realizations)
        if len(rows) < 4 or not run.until:
            return max(12, len(rows)) if run.until else run.max_realizations
        worst = max(relative_half_width(run.values(name).extrapolated) / goal for name, goal in run.until.items())
        return int(min(max(12, round(len(rows) * worst**2), run.realizations), run.max_realizations))

    def summary(self, run: Run) -> list[str]:
        """Return what to say at the end."""
        seconds = time.monotonic() - self.began
        lines = [f"{run.realizations} realizations in {run.folder}, {_clock(seconds)}{_reached(run)}"]
        if run.failed:
            lines.append(f"{run.failed} did not converge and are left out of the means")
        if run.until and not run.target_met:
            lines.append("target not reached: raise --max, or the target, and give the same command again")
        return lines


def _reached(run: Run) -> str:
    if not run.until or len(run.sound(run.realizations)) < 4:
        return ""
    parts = (
        f"{name} ± {100 * relative_half_width(run.values(name).extrapolated):.2g} % (target {100 * goal:g} %)"
        for name, goal in run.until.items()
    )
    return ": " + ", ".join(parts)


def _clock(seconds: float) -> str:
    whole = round(seconds)
    return f"{whole // 60} min {whole % 60:02d} s" if whole >= 60 else f"{whole} s"
