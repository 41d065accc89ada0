"""`Tasks`: hands out the members of the round in progress until the run has ended; damaged ones again.

Several runs with the same levels and seed may be worked on together, as the points of a study are: what is handed out
is one member of those that want it, so that surfaces and contacts which they share are computed once.
"""

import re
import time
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future, wait
from dataclasses import dataclass, field
from pathlib import Path

from roughsim.ensemble.workers import Job, Surfaces, store_members
from roughsim.ensemble.workforce import Workforce
from roughsim.errors import RecordError
from roughsim.estimate.rounds import Counts
from roughsim.planning.march import seconds_of_march
from roughsim.planning.realization import below_problem, level_problem, march_problem
from roughsim.results.run import Run
from roughsim.scene import Scene
from roughsim.scene.numerics import Numerics
from roughsim.store.claims import Claims
from roughsim.store.member_files import MEMBER_NAME, member_name, member_path

RETRIES = 3  # times that a pool with a dead worker is started again without a new member in between
PAUSE = 0.5  # s between two looks at what other processes have done
LATE = 10.0  # s that a network file system may take to show what a worker has written
LEAST_WAIT, LONGEST_WAITS = 600.0, 10.0  # s, and multiple of the longest time of a member, after which it is done again
_BEGUN = re.compile(rf"\.(?:({MEMBER_NAME.pattern})\.h5|run\.json|scene\.toml)\.[\w-]+\.tmp")
_NO_GUARD = (
    'the script lacks `if __name__ == "__main__":`: each worker imports the script and would start the run again; '
    "put the call of run below that line, or compute with workers=1"
)
_GONE = (
    "its scheduler or its workers have ended; all finished members are stored; start the workers again, and the same "
    "call goes on from there"
)


@dataclass(slots=True, eq=False)
class ActiveRun:
    """A run that this process works on."""

    scene: Scene
    numerics: Numerics
    folder: Path  # absolute
    run: Run
    surfaces: Surfaces | None = None  # None: they are drawn
    jobs: dict[int, Job] = field(default_factory=dict)  # by level

    def counts(self, ahead: bool) -> Counts:
        """Return how many members of each level the round in progress takes, or, `ahead`, about those to the end."""
        rounds = self.run.rounds
        return rounds.verdict.needed if ahead and rounds.verdict else rounds.wanted

    def job(self, level: int) -> Job:
        """Return the job of a level for a worker: numbers and JSON values only, no scene."""
        if level not in self.jobs:
            about = self.scene, self.numerics
            self.jobs[level] = Job(
                level,
                march_problem(*about) if level == self.numerics.march else level_problem(*about, level),
                below_problem(*about, level),
                speeds=self.scene.speeds,
                keep_fields=self.numerics.keep_fields,
                provenance={"scene": self.scene.identity(), "numerics": self.numerics.to_dict()},
                folder=self.folder,
                surfaces=self.surfaces,
            )
        return self.jobs[level]


@dataclass(frozen=True, slots=True, eq=False)
class Assignment:
    """A member that was handed out, the runs that want it, and when, by `time.monotonic`."""

    level: int
    index: int
    runs: list[ActiveRun]
    since: float

    @property
    def name(self) -> str:
        """That of the member."""
        return member_name(self.level, self.index)

    @property
    def jobs(self) -> list[Job]:
        """What a worker needs, for each run."""
        return [active.job(self.level) for active in self.runs]

    @property
    def unseen(self) -> list[Path]:
        """Its files that this process does not see."""
        paths = [member_path(active.folder, self.level, self.index) for active in self.runs]
        return [path for path in paths if not path.exists()]


@dataclass(slots=True, eq=False)
class Tasks:
    """The members of one run, or of several with the same levels and seed, that are still to do."""

    runs: list[ActiveRun]
    claims: Claims  # on a member of all of the runs
    check: Callable[[], None]  # raises an interrupt that Python has dropped
    observer: Callable[[Run], None] | None = None
    longest: float = 0.0  # s from handing a member out until it came back, or that a march is expected to take

    @property
    def unfinished(self) -> list[ActiveRun]:
        """The runs that still need members."""
        return [active for active in self.runs if not active.run.finished]

    @property
    def limit(self) -> float:
        """The longest time to wait for a member, s."""
        return max(LEAST_WAIT, LONGEST_WAITS * self.longest)

    def complete(self, force: Workforce) -> None:
        """Work through the rounds until all runs have ended, whoever computes their members.

        RuntimeError if workers, or the scheduler of an executor, die again and again.
        """
        died, stored = 0, -1
        while True:
            try:
                return self._work(force.pool(), force)
            except BrokenExecutor as error:
                reason = str(error) or type(error).__name__
                if force.unguarded:
                    raise RuntimeError(_NO_GUARD) from None
                if force.executor is not None:  # it is broken for good, and not ours to start anew
                    raise RuntimeError(
                        f"workers of the executor died ({reason}): {_GONE}; if they are processes of a script, it "
                        f'needs `if __name__ == "__main__":`'
                    ) from error
                self._refresh(self.runs)
                before, stored = stored, sum(len(active.run.members) for active in self.runs)
                died = died + 1 if stored == before else 1
                killed = force.lose_pool()
                if died > RETRIES:
                    raise RuntimeError(
                        f"workers died {died} times without storing a member, last: {killed or reason}; see memory and "
                        f"disk, and try fewer workers"
                    ) from error
                if killed:
                    warnings.warn(f"{killed}; the run goes on with {force.workers}", RuntimeWarning, stacklevel=2)

    def _work(self, pool: Executor, force: Workforce) -> None:
        """Keep a pool busy until all runs have ended; BrokenExecutor if its workers die."""
        pending: dict[Future[str], Assignment] = {}
        try:
            while self.unfinished:
                while len(pending) < force.in_flight and (one := self._next(idle=len(pending) < force.workers)):
                    pending[self._hand_out(pool, one)] = one
                self.check()
                wait(pending, timeout=PAUSE, return_when=FIRST_COMPLETED)
                done = [future for future in pending if future.done()]  # also those that others have cancelled
                for future in done:
                    assignment = pending.pop(future)
                    try:
                        host = future.result()
                    except CancelledError:  # which says nothing by itself
                        raise RuntimeError(f"the executor dropped a member that it had been given: {_GONE}") from None
                    self.longest = max(self.longest, time.monotonic() - assignment.since)
                    self._count(assignment, host)
                if not done:  # other processes may have stored members meanwhile
                    time.sleep(0.0 if pending else PAUSE)
                    self._refresh(self.runs)
                    for future in [late for late, one in pending.items() if time.monotonic() - one.since > self.limit]:
                        force.stuck |= not future.cancel()
                        self._do_here(pending.pop(future))
            if force.executor is None:
                # own workers finish what they have begun, if they come back at all
                running = [future for future in pending if not future.cancel()]
                force.stuck |= bool(wait(running, timeout=self.limit).not_done)
        finally:
            for future in pending:
                future.cancel()
            self.claims.release_all()

    def _next(self, *, idle: bool) -> Assignment | None:
        """Claim a member of the round, or, for an idle worker, of a later one; None if there is none now."""
        for ahead in (False, True) if idle else (False,):
            wanting = [(active, active.counts(ahead)) for active in self.unfinished]
            for level, index in self._in_order(wanting, ahead):
                runs = [
                    one for one, counts in wanting if index < counts[level] and (level, index) not in one.run.members
                ]
                if not runs or not self.claims.take(member_name(level, index)):
                    continue
                assignment = Assignment(level, index, runs, time.monotonic())
                if assignment.unseen:
                    return assignment
                self._count(assignment, "another host")  # another process has stored it
        return None

    def _in_order(self, wanting: list[tuple[ActiveRun, Counts]], ahead: bool) -> Iterator[tuple[int, int]]:
        """Go through level and index of the members of runs up to some counts, beyond those that all have.

        In a round the largest grids come first, so that it ends evenly; `ahead` of it the level that grows most.
        """
        spans, sizes = [], []
        for number, level in enumerate(self.runs[0].numerics.levels):
            first = min((active.run.available(number) for active, _ in wanting), default=0)
            spans.append(range(first, max((counts[number] for _, counts in wanting), default=0)))
            sizes.append(len(spans[-1]) if ahead else level.shape[0] * level.shape[1])
        for number in sorted(range(len(spans)), key=lambda number: -sizes[number]):
            yield from ((number, index) for index in spans[number])

    def _hand_out(self, pool: Executor, one: Assignment) -> Future[str]:
        if one.level == self.runs[0].numerics.march:
            marches = (march_problem(active.scene, active.numerics) for active in one.runs)
            self.longest = max(self.longest, sum(map(seconds_of_march, marches)))
        try:
            return pool.submit(store_members, one.jobs, one.index)
        except BrokenExecutor:
            raise
        except Exception as error:  # each library of executors has its own
            reason = str(error) or type(error).__name__
            raise RuntimeError(f"the executor takes no more members ({reason}): {_GONE}") from error

    def _do_here(self, one: Assignment) -> None:
        """Compute in this process a member that a worker has not returned for too long."""
        if one.unseen:
            warnings.warn(
                f"{one.name} has not come back from a worker for {time.monotonic() - one.since:.0f} s (limit "
                f"{self.limit:.0f} s: {LONGEST_WAITS:g} times the longest member, at least {LEAST_WAIT:g} s); it is "
                "computed in this process; see whether the workers are alive",
                RuntimeWarning,
                stacklevel=2,
            )
            store_members(one.jobs, one.index)
        self._count(one, "this host")

    def _count(self, one: Assignment, host: str) -> None:
        """Read the files of a member that was computed, and give up its claim; a file system may show them late."""
        end = time.monotonic() + LATE
        while unseen := one.unseen:
            if time.monotonic() > end:
                raise RecordError(
                    f"a worker on {host} wrote {unseen[0]}, but this process does not see it: the file system is not "
                    f"shared; name a run folder that all workers see"
                )
            list(unseen[0].parent.iterdir())  # makes a network file system look again
            time.sleep(0.1)
        self._refresh(one.runs, one)
        self.claims.release(one.name)

    def _refresh(self, runs: list[ActiveRun], one: Assignment | None = None) -> None:
        """Read the members that have appeared, `one` also beyond a gap, and call the observer if any have."""
        for active in runs:
            run, before = active.run, len(active.run.members)
            if one is not None:
                run.take(one.level, one.index)
            run.refresh()
            self.check()
            if self.observer is not None and len(run.members) != before:
                self.observer(run)


def clear(folder: Path, claims: Claims) -> None:
    """Remove what killed writers left half done: of members that no process computes now, and beside them."""
    for path in (*folder.iterdir(), *(folder / "realizations").iterdir()):
        begun = _BEGUN.fullmatch(path.name)
        if begun and not (begun[1] and claims.claimed(begun[1])):
            path.unlink(missing_ok=True)  # a writer without a claim, if there is one, writes it again
