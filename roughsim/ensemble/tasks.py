"""Hand out the members of a run, round by round, until it has ended.

Several runs with the same levels and seed may be computed together, as the points of a study are. One call of a worker
then computes a member of each run that needs it, so that surfaces and contacts which they share are computed once.
"""

import re
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    wait,
)
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from roughsim.ensemble.executors import SUITABLE, Workers
from roughsim.ensemble.sources import DrawnSurfaces, Slides, Source
from roughsim.ensemble.status import expected_seconds
from roughsim.ensemble.workers import Job, store_members
from roughsim.errors import RecordError, ResolutionError
from roughsim.planning.realization import (
    below_problem,
    largest_member,
    level_problem,
    slide_problem,
)
from roughsim.results.run import Run
from roughsim.store.claims import Claims
from roughsim.store.member_files import MEMBER_NAME, member_name, member_path

RETRIES = 3  # times that a pool with a dead worker is replaced before a new member is stored
PAUSE = 0.5  # s between two looks at the members of other processes
LATE = 10.0  # s that a network file system may take to show a new file
_UNFINISHED = re.compile(rf"\.(?:({MEMBER_NAME.pattern})\.h5|run\.json|scene\.toml)\.[\w-]+\.tmp")


@dataclass(frozen=True, slots=True, eq=False)
class Assignment:
    """A member, and the runs that need it."""

    level: int
    index: int
    runs: list[Run]

    def missing(self) -> list[Path]:
        """Return the files of the member that this process does not see."""
        paths = [member_path(run.folder, self.level, self.index) for run in self.runs]
        return [path for path in paths if not path.exists()]


def source_of(run: Run, level: int) -> Source:
    """Return the source of a level of a run of drawn surfaces."""
    scene, numerics = run.scene, run.numerics
    if level == numerics.slide:
        return Slides(level, slide_problem(scene, numerics))
    below = below_problem(scene, numerics, level)
    return DrawnSurfaces(level, level_problem(scene, numerics, level), below)


def job_of(run: Run, level: int, source: Callable[[Run, int], Source] = source_of) -> Job:
    """Return the job of a level of a run."""
    return Job(
        source(run, level),
        run.scene.speeds,
        run.numerics.keep_fields,
        {"scene": run.scene.identity(), "numerics": run.numerics.to_dict()},
        run.folder.absolute(),  # workers may have started in another directory
    )


@dataclass(slots=True, eq=False)
class Tasks:
    """The members to compute, of one run or of several with the same levels and seed."""

    runs: list[Run]
    claims: Claims  # on a member of all of the runs
    observer: Callable[[Run], None] | None = None
    source: Callable[[Run, int], Source] = source_of  # of a level
    _fitted: frozenset[int] = frozenset()  # levels for which the workers have the memory
    _jobs: dict[tuple[Path, int], Job] = field(
        default_factory=dict
    )  # by run and level: 1 ms each, a tenth of a member

    @property
    def unfinished(self) -> list[Run]:
        """Runs that need more members."""
        return [run for run in self.runs if not run.finished]

    def complete(self, workers: Workers) -> None:
        """Compute members until all runs have ended; RuntimeError if workers die repeatedly."""
        failures = 0
        while self.unfinished:
            before = sum(len(run.members) for run in self.runs)
            try:
                self._work(workers)
            except (BrokenExecutor, CancelledError) as error:
                workers.replace_broken(error)
                self._refresh(self.runs)
                stored = sum(len(run.members) for run in self.runs) > before
                failures = 1 if stored else failures + 1
                if failures > RETRIES:
                    raise RuntimeError(
                        f"workers died {failures} times without storing a member; check memory and disk, and try "
                        "fewer workers"
                    ) from error

    def _work(self, workers: Workers) -> None:
        """Keep an executor busy until all runs have ended."""
        pending: dict[Future[str], Assignment] = {}
        try:
            while self.unfinished:
                if (
                    workers.interrupted
                ):  # Python has dropped the exception, as in the callback of a weak reference
                    raise KeyboardInterrupt
                fits = self._fit(workers, busy=bool(pending))
                executor = workers.executor(
                    lambda: sum(expected_seconds(run) for run in self.unfinished)
                )
                while fits and len(pending) < workers.in_flight:
                    assignment = self._next(idle=len(pending) < workers.count)
                    if assignment is None:
                        break
                    jobs = [self._job(run, assignment.level) for run in assignment.runs]
                    pending[_submit(executor, jobs, assignment.index)] = assignment
                wait(pending, timeout=PAUSE, return_when=FIRST_COMPLETED)
                done = [
                    future for future in pending if future.done()
                ]  # `wait` may omit cancelled ones
                for future in done:
                    host = future.result()
                    self._count(pending.pop(future), host)
                if not done:
                    time.sleep(0.0 if pending else PAUSE)
                    self._refresh(self.runs)  # members of other processes
            if workers.given is None:
                wait(
                    [future for future in pending if not future.cancel()]
                )  # members ahead that have begun
        finally:
            for future in pending:
                future.cancel()
            self.claims.release_all()

    def _fit(self, workers: Workers, *, busy: bool) -> bool:
        """Fit the workers into memory with the levels of the round; False if `busy` ones must end first.

        Levels of later rounds are not asked for: a run may end before. ResolutionError if a level does not fit.
        """
        lacking = {
            level
            for run in self.unfinished
            for level, count in enumerate(run.rounds.wanted)
            if run.members.available[level] < count
        }
        if lacking <= self._fitted:
            return True
        levels = self._fitted | lacking
        member, part = max(
            largest_member(run.scene, run.numerics, levels) for run in self.unfinished
        )
        try:
            fits = workers.fit(
                member, part, max(run.numerics.threads for run in self.unfinished), busy=busy
            )
        except ResolutionError as error:
            raise ResolutionError(
                f"{error}; stored members stay, and the same call continues from them"
            ) from None
        self._fitted = levels if fits else self._fitted
        return fits

    def _next(self, *, idle: bool) -> Assignment | None:
        """Claim a member of the round, or, for an idle worker, of a later one; None if all are taken."""
        for ahead in (False, True) if idle else (False,):
            for assignment in self._lacking(ahead):
                if not self.claims.take(member_name(assignment.level, assignment.index)):
                    continue
                if assignment.missing():
                    return assignment
                self._count(assignment, "another host")  # stored by another process meanwhile
        return None

    def _lacking(self, ahead: bool) -> Iterator[Assignment]:
        """Yield the members of the round that some runs lack.

        The levels are those that the workers fit. The largest grids come first, so that the round ends evenly. With
        `ahead`, the members to the end of the runs, the level that grows most first.
        """
        wanted = [(run, run.needed if ahead else run.rounds.wanted) for run in self.unfinished]
        spans = {}
        sizes = {}
        for level, about in enumerate(self.runs[0].numerics.levels):
            first = min((run.members.available[level] for run, _ in wanted), default=0)
            last = max((counts[level] for _, counts in wanted), default=0)
            spans[level] = range(first, last)
            sizes[level] = len(spans[level]) if ahead else about.shape[0] * about.shape[1]
        for level in sorted(self._fitted & spans.keys(), key=sizes.__getitem__, reverse=True):
            for index in spans[level]:
                runs = [
                    run
                    for run, counts in wanted
                    if index < counts[level] and (level, index) not in run.members
                ]
                if runs:
                    yield Assignment(level, index, runs)

    def _job(self, run: Run, level: int) -> Job:
        """Return the job of a level of a run."""
        key = run.folder, level
        if key not in self._jobs:
            self._jobs[key] = job_of(run, level, self.source)
        return self._jobs[key]

    def _count(self, assignment: Assignment, host: str) -> None:
        """Read the files of a computed member, and release its claim; a file system may show them late."""
        end = time.monotonic() + LATE
        while missing := assignment.missing():
            if time.monotonic() > end:
                raise RecordError(
                    f"a worker on {host} wrote {missing[0]}, but this process does not see it: the file system is not "
                    "shared; name a run folder that all workers see"
                )
            list(missing[0].parent.iterdir())  # lets a network file system update
            time.sleep(0.1)
        self._refresh(assignment.runs, assignment)
        self.claims.release(member_name(assignment.level, assignment.index))

    def _refresh(self, runs: Sequence[Run], assignment: Assignment | None = None) -> None:
        """Read new members, or the assigned one, also beyond a gap, and call the observer if there are any."""
        for run in runs:
            before = len(run.members)
            if assignment is None:
                run.refresh()
            else:
                run.add(assignment.level, assignment.index)
            if self.observer is not None and len(run.members) != before:
                self.observer(run)


def _submit(executor: Executor, jobs: list[Job], index: int) -> Future[str]:
    """Hand a member to an executor; BrokenExecutor if it takes none, whatever its own class of error.

    TypeError if the executor returns no future of concurrent.futures, as a client of dask.
    """
    try:
        future: Any = executor.submit(store_members, jobs, index)
    except BrokenExecutor:
        raise
    except Exception as error:
        raise BrokenExecutor(f"{type(error).__name__}: {error}") from error
    if not isinstance(future, Future):
        kind = f"{type(future).__module__}.{type(future).__qualname__}"
        raise TypeError(
            f"executor.submit returned a {kind}, not a concurrent.futures.Future; {SUITABLE}"
        )
    return future


def remove_unfinished(folder: Path, claims: Claims) -> None:
    """Remove the unfinished files of killed processes, except of claimed members."""
    for path in (*folder.iterdir(), *(folder / "realizations").iterdir()):
        unfinished = _UNFINISHED.fullmatch(path.name)
        if unfinished and not (unfinished[1] and claims.claimed(unfinished[1])):
            path.unlink(
                missing_ok=True
            )  # a process without a claim, if there is one, writes it again
