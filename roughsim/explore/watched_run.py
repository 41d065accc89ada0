"""A run folder that is watched: its state, problems, curves and error budgets as it grows, and the fields in memory."""

from __future__ import annotations

from functools import cached_property, lru_cache
from pathlib import Path
from threading import Lock
from typing import Any, NamedTuple

from roughsim.comparison.tables import budget_table
from roughsim.ensemble.status import state_line
from roughsim.errors import RecordError
from roughsim.explore import curves
from roughsim.explore.fields import load_fields
from roughsim.results.folder import open_run
from roughsim.results.gaps import gap
from roughsim.results.run import Run
from roughsim.show.terminal import table_text

REMEMBERED = 2  # members in memory: one of 4096 × 4096 points takes 130 MB


class Summary(NamedTuple):
    """A run at one moment: problems, error budget and curves by column, sound and kept realizations by level."""

    problems: list[str]
    budget: dict[str, str]
    measured: dict[str, dict[str, curves.Curve]]
    sound: dict[int, list[int]]
    kept: dict[int, list[int]]


class WatchedRun:
    """A run that may be empty or growing; damaged files are named and left out. RecordError if the folder is no run."""

    def __init__(self, folder: str | Path):
        self.run: Run = open_run(folder, damaged="skip")
        self.fields = lru_cache(REMEMBERED)(lambda level, index: load_fields(self.run, level, index))
        self._lock = Lock()
        nothing: dict[int, list[int]] = {level: [] for level in range(len(self.run.numerics.levels))}
        self._latest: tuple[Any, Summary] = None, Summary([], {}, {}, nothing, nothing)

    @cached_property
    def theory(self) -> dict[str, tuple[Any, Any]]:
        """The curves of the theory."""
        return curves.theory_curves(self.run)

    @property
    def deleted(self) -> bool:
        """Whether the folder is there no more."""
        return not (self.run.folder / "run.json").exists()

    def state(self) -> str:
        """Return in one line how many realizations there are, and whether more are being computed."""
        with self._lock:
            return "its folder is gone" if self.deleted else state_line(self.run)

    def summary(self) -> Summary:
        """Read the members that have come since; the same object comes back as long as nothing has changed."""
        with self._lock:
            if not self.deleted:
                self.run.refresh()
            members = "deleted" if self.deleted else (len(self.run.members), tuple(self.run.damaged))
            if self._latest[0] != members:
                try:
                    self._latest = members, self._summarized()
                except RecordError:  # a file was damaged after it had been read
                    self.run = open_run(self.run.folder, damaged="skip")
                    self._latest = members, self._summarized()
            return self._latest[1]

    def _summarized(self) -> Summary:
        run = self.run
        if self.deleted:  # nothing of it can be read any more
            line = f"{run.folder} was deleted or moved; what had been read of it is still shown"
            return self._latest[1]._replace(problems=[line])
        problems = [f"{text}. The other realizations are shown." for text in run.damaged.values()] + gap(run)
        if run.failed:
            problems.append(f"{run.failed} realizations did not converge and are left out of the means")
        sound, levels = run.sound(run.realizations), range(len(run.numerics.levels))
        none_yet = "No realization yet: there is no error to speak of."
        return Summary(
            problems,
            {c: table_text(budget_table(run, c)) if sound else none_yet for c in run.numerics.columns},
            {c: curves.measured_curves(run, c) for c in run.numerics.columns} if sound else {},
            {level: [i for i in sound if (level, i) in run.members] for level in levels},
            {level: run.kept(level) for level in levels},
        )
