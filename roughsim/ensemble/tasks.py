"""Hand out the members of a run, round by round, until it has ended.

A task is a batch of realizations of a level, which takes some 50 ms by the model of `work`. A claim is on those of one
task or more: its borders follow from run.json alone. It is held until the members that it has at that time are saved.

Several runs with the same levels and seed may be computed together, as the points of a study are. One call of a worker
then computes a member of each run that needs it, so that surfaces and contacts which they share are computed once.
"""

import time
from collections.abc import Callable, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    wait,
)
from dataclasses import dataclass, field
from math import inf
from typing import Any

from roughsim.ensemble.executors import SUITABLE, SerialExecutor, Workers
from roughsim.ensemble.sources import DrawnSurfaces, Slides, Source
from roughsim.ensemble.status import expected_seconds
from roughsim.ensemble.workers import Job, Wanted, computed_members
from roughsim.errors import ResolutionError
from roughsim.estimate.rounds import WORK_SECONDS, work
from roughsim.observables.member import Member
from roughsim.planning.plan import largest_member
from roughsim.planning.realization import (
    below_problem,
    level_problem,
    slide_problem,
)
from roughsim.results.run import Run
from roughsim.store.claims import Claims
from roughsim.store.member_files import member_name
from roughsim.store.saving import MOST, Saver

RETRIES = 3  # times that a pool with a dead worker is replaced before a new member is stored
PAUSE = 0.5  # s between two looks at the members of other processes
INTERVAL = 1.0  # s between two times that members are saved, at least; and s of computing of a claim, at most
SHARE = 0.02  # of the time, at most, that writing last parts again takes
BATCH = 0.05  # s of computing that a task takes, by the model of `work`
Found = list[tuple[int, Member]]  # number of the run in the assignment, and its member


@dataclass(frozen=True, slots=True, eq=False)
class Assignment:
    """Members of a batch."""

    level: int
    wanted: Wanted  # by the numbers of the runs


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
    )


@dataclass(slots=True, eq=False)
class Tasks:
    """The members to compute, of one run or of several with the same levels and seed."""

    runs: list[Run]
    claims: Claims  # on a member of all of the runs
    observer: Callable[[Run], None] | None = None
    source: Callable[[Run, int], Source] = source_of  # of a level
    _fitted: frozenset[int] = frozenset()  # levels for which the workers have the memory
    _jobs: dict[tuple[int, int], Job] = field(
        default_factory=dict
    )  # by run and level: 1 ms each, a tenth of a member
    _savers: list[Saver] = field(default_factory=list)  # of the runs
    _seconds: list[float] = field(init=False)  # modelled, of a member of each level
    _pending: dict[Future[Found], Assignment] = field(default_factory=dict)  # that workers compute
    _held: set[str] = field(default_factory=set)  # claims
    _handed: dict[tuple[int, int], str] = field(default_factory=dict)  # members in work → claims
    _saved: float = field(default_factory=time.monotonic)  # time of the last save
    _pause: float = INTERVAL  # s until the next one

    def __post_init__(self) -> None:
        for run in self.runs:
            run.members.owner = self.claims.name  # members that this process does not read
            saver = Saver(run.folder.absolute(), self.claims.name, run.members.of_run)
            self._savers.append(saver)
        numerics = self.runs[0].numerics
        self._seconds = [
            WORK_SECONDS * work(numerics, level) for level in range(len(numerics.levels))
        ]
        if numerics.slide is not None:
            self._seconds[numerics.slide] = inf  # of many steps

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
                self._refresh()
                stored = sum(len(run.members) for run in self.runs) > before
                failures = 1 if stored else failures + 1
                if failures > RETRIES:
                    raise RuntimeError(
                        f"workers died {failures} times without storing a member; check memory and disk, and try "
                        "fewer workers"
                    ) from error

    def _work(self, workers: Workers) -> None:
        """Keep an executor busy until all runs have ended."""
        pending = self._pending
        try:
            while self.unfinished:
                if (
                    workers.interrupted
                ):  # Python has dropped the exception, as in the callback of a weak reference
                    raise KeyboardInterrupt
                self._hand_out(workers)
                wait(pending, timeout=PAUSE, return_when=FIRST_COMPLETED)
                done = [
                    future for future in pending if future.done()
                ]  # `wait` may omit cancelled ones
                for future in done:
                    found = future.result()
                    self._take(pending.pop(future), found)
                self._save_if_due()
                if not done and not pending:  # other processes compute what is left
                    self._save()
                    time.sleep(PAUSE)
                if not done:
                    self._refresh()
            if workers.given is None:  # members ahead that have begun
                for future in [future for future in pending if not future.cancel()]:
                    found = future.result()
                    self._take(pending.pop(future), found)
        finally:
            for future in pending:
                future.cancel()
            pending.clear()
            self._handed.clear()
            try:
                self._save()
            finally:
                self._held.clear()
                self.claims.release_all()

    def _hand_out(self, workers: Workers) -> None:
        """Submit as many batches as the workers take; then compute one here, if this process helps them."""
        if not self._fit(workers):
            return
        executor = workers.executor(lambda: sum(expected_seconds(run) for run in self.unfinished))
        while len(self._pending) < workers.in_flight:
            if not self._submit(executor, idle=len(self._pending) < workers.others):
                break
        if workers.helps:
            self._submit(SerialExecutor(), idle=True)

    def _submit(self, executor: Executor, *, idle: bool) -> bool:
        """Submit a batch, if there is one."""
        assignment = self._next(idle=idle)
        if assignment is None:
            return False
        self._save_if_due(self._seconds[assignment.level] * len(assignment.wanted))
        future = _submitted(executor, self._jobs_of(assignment), assignment.wanted)
        self._pending[future] = assignment
        return True

    def _fit(self, workers: Workers) -> bool:
        """Fit the workers into memory with the levels of the round; False if busy ones must end first.

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
                member,
                part,
                max(run.numerics.threads for run in self.unfinished),
                seconds=max(self._seconds[level] for level in levels),
                busy=bool(self._pending),
            )
        except ResolutionError as error:
            raise ResolutionError(
                f"{error}; stored members stay, and the same call continues from them"
            ) from None
        self._fitted = levels if fits else self._fitted
        return fits

    def _next(self, *, idle: bool) -> Assignment | None:
        """Take a batch of the round, or, for an idle worker, of a later one; None if all are taken."""
        for ahead in (False, True) if idle else (False,):
            for claim, level, wanted in self._lacking(ahead):
                left = wanted
                if claim not in self._held:
                    if not self.claims.take(claim):
                        continue
                    self._held.add(claim)
                    self._refresh()  # another process may have saved it meanwhile
                    left = [
                        (index, [number for number in numbers if self._lacks(number, level, index)])
                        for index, numbers in wanted
                    ]
                most = max(int(BATCH / self._seconds[level]), 1)
                if batch := [each for each in left if each[1]][:most]:
                    self._handed |= {(level, index): claim for index, _ in batch}
                    return Assignment(level, batch)
        return None

    def _lacks(self, number: int, level: int, index: int) -> bool:
        run = self.runs[number]
        return not run.finished and (level, index) not in run.members

    def _lacking(self, ahead: bool) -> Iterator[tuple[str, int, Wanted]]:
        """Yield claims with the level and the members of the round that some runs lack, and no worker computes.

        The levels are those that the workers fit. The largest grids come first, so that the round ends evenly. With
        `ahead`, the members to the end of the runs, the level that grows most first.
        """
        runs = [
            (number, run, run.needed if ahead else run.rounds.wanted)
            for number, run in enumerate(self.runs)
            if not run.finished
        ]
        spans = {}
        sizes = {}
        for level, about in enumerate(self.runs[0].numerics.levels):
            first = min((run.members.available[level] for _, run, _ in runs), default=0)
            last = max((counts[level] for *_, counts in runs), default=0)
            spans[level] = range(first, last)
            sizes[level] = len(spans[level]) if ahead else about.shape[0] * about.shape[1]
        for level in sorted(self._fitted & spans.keys(), key=sizes.__getitem__, reverse=True):
            index, last = spans[level].start, spans[level].stop
            while index < last:
                claim = claim_on(index, self._seconds[level])
                numbers = [
                    (
                        each,
                        [
                            number
                            for number, run, counts in runs
                            if each < counts[level] and (level, each) not in run.members
                        ],
                    )
                    for each in claim
                    if (level, each) not in self._handed
                ]
                if wanted := [each for each in numbers if each[1]]:
                    yield member_name(level, claim.start), level, wanted
                index = claim.stop

    def _jobs_of(self, assignment: Assignment) -> dict[int, Job]:
        """Return the jobs of the runs that need members of an assignment, by the numbers of the runs."""
        level = assignment.level
        numbers = {number for _, of_index in assignment.wanted for number in of_index}
        for number in numbers:
            if (number, level) not in self._jobs:
                self._jobs[number, level] = job_of(self.runs[number], level, self.source)
        return {number: self._jobs[number, level] for number in numbers}

    def _take(self, assignment: Assignment, found: Found) -> None:
        """Take computed members; OSError if the disk refuses their fields."""
        for number, member in found:
            run = self.runs[number]
            if (member.level, member.index) not in run.members:
                run.members.check_computed(member)
                run.members.add(self._savers[number].add(member))
        for index, _ in assignment.wanted:
            del self._handed[assignment.level, index]
        for number in sorted({number for number, _ in found}):
            self.runs[number].recount()
            if self.observer is not None:
                self.observer(self.runs[number])

    def _save_if_due(self, ahead: float = 0.0) -> None:
        """Save new members if it is time, or will be after some seconds."""
        if time.monotonic() + ahead >= self._saved + self._pause:
            self._save()

    def _save(self) -> None:
        """Save new members, and release their claims; OSError if the disk refuses: what was saved before stays."""
        began = time.monotonic()
        written = [saver.save() for saver in self._savers]
        for claim in self._held - set(self._handed.values()):
            self.claims.release(claim)
            self._held.remove(claim)
        if not any(written):
            return
        self._saved = time.monotonic()
        # what fewer saves spare is the last part of each run, written again: other parts are written once
        again = (self._saved - began) * sum(map(bool, written)) / sum(written)
        self._pause = max(INTERVAL, again / SHARE)

    def _refresh(self) -> None:
        """Read the members of other processes, and call the observer if there are any."""
        for run in self.runs:
            before = len(run.members)
            run.members.read()
            if len(run.members) != before:
                run.recount()
                if self.observer is not None:
                    self.observer(run)


def claim_on(index: int, seconds: float) -> range:
    """Return the members of a level that are claimed together with one, where a member takes so many seconds.

    One claim for each task would be a file for 50 ms of computing, hundreds until they are saved. So a claim grows with
    the number of members before it, of which it is at most an eighth: processes that share a round still end it
    together. It takes no longer than the interval in which members are saved, and others wait for a save anyway. Its
    size is a power of two, so that no two claims overlap.
    """
    least, most = (max(int(limit / seconds), 1) for limit in (BATCH, INTERVAL))
    size = min(max(index // 8, least), max(least, most), MOST)
    size = 1 << (size.bit_length() - 1)
    start = index // size * size
    return range(start, start + size)


def _submitted(executor: Executor, jobs: dict[int, Job], wanted: Wanted) -> Future[Found]:
    """Hand a batch to an executor; BrokenExecutor if it takes none, whatever its own class of error.

    TypeError if the executor returns no future of concurrent.futures, as a client of dask.
    """
    try:
        future: Any = executor.submit(computed_members, jobs, wanted)
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
