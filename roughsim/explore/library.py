"""What all open pages of a run share: the run as it grows, its curves, and the members last looked at."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cached_property
from pathlib import Path
from threading import Lock
from typing import Any, NamedTuple

from roughsim.errors import RecordError
from roughsim.explore import curves, words
from roughsim.explore.specimen import Specimen, load
from roughsim.results.folder import open_run
from roughsim.results.run import Run

_REMEMBERED = 2  # members in memory: one of 4096 × 4096 points takes 130 MB


class Summary(NamedTuple):
    """A run at one moment: problems, error budget and curves by column, sound and kept members by level."""

    problems: list[str]
    budget: dict[str, str]
    measured: dict[str, dict[str, curves.Curve]]
    sound: dict[int, list[int]]
    kept: dict[int, list[int]]


class Library:
    """A run folder, opened for any number of pages; damaged files are named and left out.

    Parameters
    ----------
    folder : str or Path
        Of a run, also an empty or a growing one.

    Raises
    ------
    RecordError
        If it is no run.
    """

    def __init__(self, folder: str | Path):
        self.run: Run = open_run(folder, damaged="skip")
        self._lock = Lock()
        self._known: tuple[Any, Summary] | None = None
        self._specimens: dict[tuple[int, int], Specimen] = {}

    @cached_property
    def theory(self) -> dict[str, tuple[Any, Any]]:
        """The curves of the theory."""
        return curves.theory_curves(self.run)

    def state(self) -> str:
        """Return where the run stands, in one line."""
        with self._lock:
            return words.state_of(self.run)

    def summary(self) -> Summary:
        """Read the members that have come since; the same object comes back as long as there are none."""
        with self._lock:
            self.run.refresh()
            key = len(self.run.members), tuple(self.run.damaged)
            if self._known is None or self._known[0] != key:
                self._known = key, self._summarize()
            return self._known[1]

    def _summarize(self) -> Summary:
        try:
            return self._summary_of(self.run)
        except RecordError:  # a file was damaged after it had been read
            self.run = open_run(self.run.folder, damaged="skip")
            return self._summary_of(self.run)

    def _summary_of(self, run: Run) -> Summary:
        sound = run.sound(run.realizations)
        levels = range(len(run.numerics.levels))
        there = {level: [i for i in sound if (level, i) in run.members] for level in levels}
        stored = {level: run.kept(level) for level in levels}
        budget = {column: words.budget_of(run, column) for column in run.numerics.columns}
        return Summary(words.problems_of(run), budget, curves.measured_curves(run), there, stored)

    def specimen(self, level: int, index: int) -> Specimen:
        """Return a member with its fields; errors as `load`."""
        place = level, index
        with self._lock:
            found = self._specimens.pop(place, None)
        found = load(self.run, level, index) if found is None else found
        with self._lock:
            self._specimens[place] = found  # the latest stands last
            while len(self._specimens) > _REMEMBERED:
                self._specimens.pop(next(iter(self._specimens)))
        return found

    def forget(self) -> None:
        """Let go of the members in memory; the next look reads them again."""
        with self._lock:
            self._specimens.clear()


class Latest:
    """A thread that does the latest of the tasks asked of it; what was not begun before the next came is dropped.

    Parameters
    ----------
    deliver : callable
        Takes a function without arguments and calls it in the thread of the page.
    failed : callable
        Called there with the error of a task that failed.
    """

    def __init__(self, deliver: Callable[[Callable[[], None]], None], failed: Callable[[Exception], None]):
        self._deliver, self._failed = deliver, failed
        self._pool = ThreadPoolExecutor(1)
        self._ticket = object()

    def ask(self, work: Callable[[], Any], show: Callable[[Any], None]) -> None:
        """Do `work` in the thread, then `show` its result in the thread of the page."""
        self._ticket = ticket = object()

        def job() -> None:
            if self._ticket is not ticket:
                return
            try:
                result = work()
            except Exception as error:  # whatever it is, the page says it
                failure = error
                self._deliver(lambda: self._failed(failure))
            else:
                self._deliver(lambda: show(result))

        self._pool.submit(job)

    def close(self) -> None:
        """End the thread; what it is doing is finished, what waits is dropped."""
        self._pool.shutdown(wait=False, cancel_futures=True)
