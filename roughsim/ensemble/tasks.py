"""Hand out the members of a run, round by round, until it has ended.

Several runs with the same levels and seed may be computed together, as the points of a study are. One call of a worker
then computes a member of each run that needs it, so that surfaces and contacts which they share are computed once.
"""

import re
import time
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Future, wait
from dataclasses import dataclass, field
from pathlib import Path

from roughsim.ensemble.executors import Workers
from roughsim.ensemble.status import expected_seconds
from roughsim.ensemble.workers import Job, Source, store_members
from roughsim.errors import RecordError
from roughsim.estimate.rounds import Counts
from roughsim.planning.realization import below_problem, level_problem, slide_problem
from roughsim.results.run import Run
from roughsim.scene import Scene
from roughsim.scene.numerics import Numerics
from roughsim.store.claims import Claims
from roughsim.store.member_files import MEMBER_NAME, member_name, member_path

RETRIES = 3  # times that a pool with a dead worker is replaced before a new member is stored
PAUSE = 0.5  # s between two looks at the members of other processes
LATE = 10.0  # s that a network file system may take to show a new file
_UNFINISHED = re.compile(rf"\.(?:({MEMBER_NAME.pattern})\.h5|run\.json|scene\.toml)\.[\w-]+\.tmp")


@dataclass(slots=True, eq=False)
class ActiveRun:
    """A run that this process computes."""

    scene: Scene
    numerics: Numerics
    folder: Path  # absolute: workers may have started in another directory
    run: Run
    source: Source | None = None  # None: random surfaces
    jobs: dict[int, Job] = field(default_factory=dict)  # by level

    def wanted(self, ahead: bool) -> Counts:
        """Return the members of each level in the current round, or, with `ahead`, about those to the end."""
        rounds = self.run.rounds
        return rounds.verdict.needed if ahead and rounds.verdict else rounds.wanted

    def job(self, level: int) -> Job:
        """Return the job of a level."""
        if level not in self.jobs:
            about = self.scene, self.numerics
            slides = level == self.numerics.slide
            self.jobs[level] = Job(
                level,
                slide_problem(*about) if slides else level_problem(*about, level),
                below_problem(*about, level),
                speeds=self.scene.speeds,
                keep_fields=self.numerics.keep_fields,
                provenance={"scene": self.scene.identity(), "numerics": self.numerics.to_dict()},
                folder=self.folder,
                source=self.source,
            )
        return self.jobs[level]


@dataclass(frozen=True, slots=True, eq=False)
class Assignment:
    """A member, and the runs that need it."""

    level: int
    index: int
    runs: list[ActiveRun]

    @property
    def name(self) -> str:
        """Name of the member."""
        return member_name(self.level, self.index)

    @property
    def jobs(self) -> list[Job]:
        """Job of each run."""
        return [active.job(self.level) for active in self.runs]

    @property
    def missing(self) -> list[Path]:
        """Files that this process does not see."""
        paths = [member_path(active.folder, self.level, self.index) for active in self.runs]
        return [path for path in paths if not path.exists()]


@dataclass(slots=True, eq=False)
class Tasks:
    """The members to compute, of one run or of several with the same levels and seed."""

    runs: list[ActiveRun]
    claims: Claims  # on a member of all of the runs
    observer: Callable[[Run], None] | None = None

    @property
    def unfinished(self) -> list[ActiveRun]:
        """Runs that need more members."""
        return [active for active in self.runs if not active.run.finished]

    def complete(self, workers: Workers) -> None:
        """Compute members until all runs have ended; RuntimeError if workers die repeatedly."""
        failures = 0
        stored = self._stored()
        while True:
            try:
                return self._work(workers)
            except (BrokenExecutor, CancelledError) as error:
                workers.replace_broken(error)
                self._refresh(self.runs)
                failures = 1 if self._stored() > stored else failures + 1
                stored = self._stored()
                if failures > RETRIES:
                    raise RuntimeError(
                        f"workers died {failures} times without storing a member; check memory and disk, and try "
                        "fewer workers"
                    ) from error

    def _stored(self) -> int:
        return sum(len(active.run.members) for active in self.runs)

    def _work(self, workers: Workers) -> None:
        """Keep an executor busy until all runs have ended."""
        pending: dict[Future[str], Assignment] = {}
        try:
            while self.unfinished:
                executor = workers.executor(sum(expected_seconds(active.run) for active in self.unfinished))
                while len(pending) < workers.in_flight:
                    assignment = self._next(idle=len(pending) < workers.count)
                    if assignment is None:
                        break
                    pending[executor.submit(store_members, assignment.jobs, assignment.index)] = assignment
                wait(pending, timeout=PAUSE, return_when=FIRST_COMPLETED)
                done = [future for future in pending if future.done()]  # `wait` may omit cancelled ones
                for future in done:
                    host = future.result()
                    self._count(pending.pop(future), host)
                if not done:
                    time.sleep(0.0 if pending else PAUSE)
                    self._refresh(self.runs)  # members of other processes
            if workers.own:
                wait([future for future in pending if not future.cancel()])  # members ahead that have begun
        finally:
            for future in pending:
                future.cancel()
            self.claims.release_all()

    def _next(self, *, idle: bool) -> Assignment | None:
        """Claim a member of the round, or, for an idle worker, of a later one; None if all are taken."""
        for ahead in (False, True) if idle else (False,):
            wanted = [(active, active.wanted(ahead)) for active in self.unfinished]
            for level, index in self._in_order(wanted, ahead):
                runs = [
                    active
                    for active, counts in wanted
                    if index < counts[level] and (level, index) not in active.run.members
                ]
                if not runs or not self.claims.take(member_name(level, index)):
                    continue
                assignment = Assignment(level, index, runs)
                if assignment.missing:
                    return assignment
                self._count(assignment, "another host")  # stored by another process meanwhile
        return None

    def _in_order(self, wanted: list[tuple[ActiveRun, Counts]], ahead: bool) -> Iterator[tuple[int, int]]:
        """Yield level and index of the members up to the wanted counts that some run lacks.

        In a round the largest grids come first, so that it ends evenly; ahead of it the level that grows most.
        """
        spans = {}
        sizes = {}
        for level, about in enumerate(self.runs[0].numerics.levels):
            first = min((active.run.members.available[level] for active, _ in wanted), default=0)
            last = max((counts[level] for _, counts in wanted), default=0)
            spans[level] = range(first, last)
            sizes[level] = len(spans[level]) if ahead else about.shape[0] * about.shape[1]
        for level in sorted(spans, key=sizes.__getitem__, reverse=True):
            for index in spans[level]:
                yield level, index

    def _count(self, assignment: Assignment, host: str) -> None:
        """Read the files of a computed member, and release its claim; a file system may show them late."""
        end = time.monotonic() + LATE
        missing = assignment.missing
        while missing:
            if time.monotonic() > end:
                raise RecordError(
                    f"a worker on {host} wrote {missing[0]}, but this process does not see it: the file system is not "
                    "shared; name a run folder that all workers see"
                )
            list(missing[0].parent.iterdir())  # lets a network file system update
            time.sleep(0.1)
            missing = assignment.missing
        self._refresh(assignment.runs, assignment)
        self.claims.release(assignment.name)

    def _refresh(self, runs: list[ActiveRun], assignment: Assignment | None = None) -> None:
        """Read new members, an assigned one also beyond a gap, and call the observer if there are any."""
        for active in runs:
            run = active.run
            before = len(run.members)
            if assignment is not None:
                run.members.take(assignment.level, assignment.index)
            run.refresh()
            if self.observer is not None and len(run.members) != before:
                self.observer(run)


def remove_unfinished(folder: Path, claims: Claims) -> None:
    """Remove the unfinished files of killed processes, except of claimed members."""
    for path in (*folder.iterdir(), *(folder / "realizations").iterdir()):
        unfinished = _UNFINISHED.fullmatch(path.name)
        if unfinished and not (unfinished[1] and claims.claimed(unfinished[1])):
            path.unlink(missing_ok=True)  # a process without a claim, if there is one, writes it again
