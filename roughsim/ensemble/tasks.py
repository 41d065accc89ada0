"""`Tasks`: hands out the members that are still to be computed until the targets are met; damaged ones again.

Several runs with the same levels and seed may be worked on together, as the points of a study are: what is handed out
is one member of all of them, so that surfaces and contacts which they share are computed once.
"""

import re
import time
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future, wait
from dataclasses import dataclass, field
from functools import partial
from itertools import islice
from math import inf
from pathlib import Path

from roughsim.ensemble.workers import Job, store_in_turn, store_members, store_where_it_fits
from roughsim.ensemble.workforce import Workforce
from roughsim.errors import RecordError
from roughsim.planning.march import seconds_of_march
from roughsim.planning.realization import level_problem, march_problem
from roughsim.results.run import Run
from roughsim.scene import Scene
from roughsim.scene.numerics import Numerics
from roughsim.store.claims import RENEWAL, Claims
from roughsim.store.disk import DamagedError, is_temporary, set_aside
from roughsim.store.member_files import MEMBER_NAME, check_member, member_name, member_path

Task = tuple[int, int]  # level and index
RETRIES = 3  # times that a pool with a dead worker is started again without a new member in between
CALL = 0.25  # s that a call of a worker takes at most, unless it has one member: a call costs dask some milliseconds
UNDER_WAY = 0.25  # of the members done that calls of several members hold at most: a target may be met before them
PAUSE = 0.5  # s between two looks at what other processes have done
LONG_PAUSE = 2.0  # s between them at most, where members take longer than that: each that comes back is a look too
LATE = 10.0  # s that a network file system may take to show what a worker has written
LEAST_WAIT, LONGEST_WAITS = 600.0, 10.0  # s, and multiple of the longest time of a member, after which it is done again
_MEMBER = re.compile(rf"{MEMBER_NAME.pattern}\.h5|\.{MEMBER_NAME.pattern}\.h5\..+\.tmp")
_BEGUN = re.compile(r"\.(run\.json|scene\.toml|summary\.bin|estimates\.json)\..+\.tmp")
_NO_GUARD = (
    'the script lacks `if __name__ == "__main__":`: each worker imports the script and would start the run again; '
    "put the call of run below that line, or compute with workers=1"
)
_GONE = (
    "its scheduler or its workers have ended; all finished members are stored; start the workers again, and the same "
    "call goes on from there"
)


@dataclass(slots=True, eq=False)
class AtWork:
    """A run that this process works on."""

    scene: Scene
    numerics: Numerics
    folder: Path  # absolute
    run: Run
    jobs: dict[int, Job] = field(default_factory=dict)  # by level

    @property
    def finished(self) -> bool:
        """Whether the targets are met, or all members are there."""
        return self.run.target_met or self.run.realizations >= self.run.max_realizations

    def is_stored(self, task: Task) -> bool:
        """Whether this process sees the file of a member."""
        return member_path(self.folder, *task).exists()

    def job(self, level: int) -> Job:
        """Return the job of a level for a worker: numbers and JSON values only, no scene."""
        if level not in self.jobs:
            problem = march_problem if level == self.numerics.march else partial(level_problem, level=level)
            self.jobs[level] = Job(
                level,
                problem(self.scene, self.numerics),
                speeds=self.scene.speeds,
                keep_fields=self.numerics.keep_fields,
                provenance={"scene": self.scene.identity(), "numerics": self.numerics.to_dict()},
                folder=self.folder,
            )
        return self.jobs[level]


@dataclass(frozen=True, slots=True, eq=False)
class Given:
    """A member that was handed out, of the runs that need it, and when, by `time.monotonic`."""

    task: Task
    runs: list[AtWork]
    since: float

    @property
    def slides(self) -> bool:
        """Whether it is a march."""
        return self.task[0] == self.runs[0].numerics.march

    @property
    def arguments(self) -> tuple[list[Job], int]:
        """Those of `store_members`."""
        level, index = self.task
        return [at_work.job(level) for at_work in self.runs], index

    def seconds_of_march(self) -> float:
        """Return about how long the march takes, s; a few of its steps are timed."""
        return sum(seconds_of_march(march_problem(run.scene, run.numerics)) for run in self.runs)


Pending = dict[Future[tuple[str, list[float]]], list[Given]]  # calls of `store_in_turn`, and their members


@dataclass(slots=True, eq=False)
class Tasks:
    """The members of one run, or of several with the same levels and seed, that are still to do, in order."""

    runs: list[AtWork]
    claims: Claims  # on a member of all of the runs
    check: Callable[[], None]  # raises an interrupt that Python has dropped
    observer: Callable[[Run], None] | None = None
    longest: float = 0.0  # s from handing a member out until it came back, or that a march is known to take
    seconds: dict[int, float] = field(default_factory=dict)  # that the latest member of each level took
    counted: int = 0  # members that came back
    order: Iterator[Task] = field(default_factory=lambda: iter(()))  # members that were not looked at yet
    look_again: float = 0.0  # from the first on, since other processes may have ended: when, by `time.monotonic`

    @property
    def unfinished(self) -> list[AtWork]:
        """The runs that still need members."""
        return [at_work for at_work in self.runs if not at_work.finished]

    @property
    def stored(self) -> int:
        """How many members all runs have."""
        return sum(len(at_work.run.members) for at_work in self.runs)

    def complete(self, force: Workforce) -> None:
        """Work through the tasks until the targets are met or all members are there, whoever computes them.

        RuntimeError if workers, or the scheduler of an executor, die again and again.
        """
        died, stored = 0, self.stored
        while True:
            pool = force.pool()
            try:
                self._work(pool, force)
                return
            except BrokenExecutor as error:
                force.broken = True
                reason = str(error) or type(error).__name__
                if force.unguarded:
                    raise RuntimeError(_NO_GUARD) from None
                if force.executor is not None:  # it is broken for good, and not ours to start anew
                    raise RuntimeError(
                        f"workers of the executor died ({reason}): {_GONE}; if they are processes of a script, it "
                        f'needs `if __name__ == "__main__":`'
                    ) from error
                self._refresh()
                died = died + 1 if self.stored == stored else 1
                stored = self.stored
                killed = force.lose_killed()
                if died > RETRIES:
                    raise RuntimeError(
                        f"workers died {died} times without storing a member, last: {killed or reason}; see memory and "
                        f"disk, and try fewer workers"
                    ) from error
                if killed:
                    warnings.warn(f"{killed}; the run goes on with {force.workers}", RuntimeWarning, stacklevel=2)

    def _work(self, pool: Executor, force: Workforce) -> None:
        """Keep a pool busy until the run is finished; BrokenExecutor if its workers die."""
        pending: Pending = {}
        self.look_again = 0.0
        try:
            while self.unfinished:
                while len(pending) < force.in_flight and (call := self._next_call(force)):
                    pending[self._hand_out(pool, call, force)] = call
                self.check()
                wait(pending, timeout=min(max(PAUSE, self.longest), LONG_PAUSE), return_when=FIRST_COMPLETED)
                done = [future for future in pending if future.done()]  # also those that others have cancelled
                for future in done:
                    call = pending.pop(future)
                    try:
                        host, seconds = future.result()
                    except CancelledError:  # which says nothing by itself
                        raise RuntimeError(f"the executor dropped a member that it had been given: {_GONE}") from None
                    self.longest = max(self.longest, time.monotonic() - call[0].since)
                    self.seconds |= {given.task[0]: took for given, took in zip(call, seconds, strict=True)}
                    for given in call:
                        self._count(given, host)
                if not done:  # other processes may have stored members meanwhile
                    time.sleep(0.0 if pending else PAUSE)
                    self._refresh()
                    self._do_overdue(pending, force)
            if force.executor is None:
                # own workers finish what they have begun, if they come back at all
                running = [future for future in pending if not future.cancel()]
                force.stuck |= bool(wait(running, timeout=self.limit).not_done)
        finally:
            for future in pending:
                future.cancel()
            self.claims.release_all()

    def _next_call(self, force: Workforce) -> list[Given]:
        """Claim the members of the next call: several where those of all levels are short, few beside those done.

        Where a call is broken off, only the member in work is lost: each is written when it is computed.
        """
        size = 1
        if force.in_flight > 1:  # a call of this process costs nothing
            longest = max(self.seconds.get(level, inf) for level in range(len(self.runs[0].numerics.levels)))
            size = max(1, min(int(CALL / longest), int(UNDER_WAY * self.counted / force.in_flight)))
        return list(islice(iter(self._next, None), size))

    def _next(self) -> Given | None:
        """Claim the first member that is not stored and not being computed; None if there is none now."""
        if time.monotonic() > self.look_again:
            self.order, self.look_again = self._in_order(), time.monotonic() + RENEWAL
        unfinished = self.unfinished
        for task in self.order:
            missing = [at_work for at_work in unfinished if task not in at_work.run.members]
            if missing and self.claims.take(member_name(*task)):
                if runs := [at_work for at_work in missing if not at_work.is_stored(task)]:
                    return Given(task, runs, time.monotonic())
                self.claims.release(member_name(*task))
                self._refresh(Given(task, missing, 0.0))  # another process has stored it
        self.look_again = 0.0
        return None

    def _in_order(self) -> Iterator[Task]:
        """Go through the members that do not count yet: by index, then the largest grid first."""
        numerics, most = self.runs[0].numerics, max(at_work.run.max_realizations for at_work in self.runs)
        levels = sorted(enumerate(numerics.levels), key=lambda level: -level[1].shape[0] * level[1].shape[1])
        indices = [(number, level.indices(most)) for number, level in levels]
        first = min((at_work.run.realizations for at_work in self.unfinished), default=most)
        for index in range(first, most):
            yield from ((number, index) for number, of_level in indices if index in of_level)

    def _hand_out(self, pool: Executor, call: list[Given], force: Workforce) -> Future[tuple[str, list[float]]]:
        function = store_in_turn if force.executor is None else store_where_it_fits
        try:
            return pool.submit(function, [given.arguments for given in call])
        except BrokenExecutor:
            raise
        except Exception as error:  # each library of executors has its own
            reason = str(error) or type(error).__name__
            raise RuntimeError(f"the executor takes no more members ({reason}): {_GONE}") from error

    def _do_overdue(self, pending: Pending, force: Workforce) -> None:
        """Compute in this process the members that a worker has not returned for too long."""
        if any(time.monotonic() - call[0].since > self.limit for call in pending.values()):
            # a march takes minutes or hours, and so does a member that waits behind one
            times = (given.seconds_of_march() for call in pending.values() for given in call if given.slides)
            self.longest = max(self.longest, *times, 0.0)
        for future, call in list(pending.items()):
            if (waited := time.monotonic() - call[0].since) <= self.limit:
                continue
            del pending[future]
            force.stuck |= not future.cancel()
            for given in call:
                if any(not at_work.is_stored(given.task) for at_work in given.runs):
                    warnings.warn(
                        f"{member_name(*given.task)} has not come back from a worker for {waited:.0f} s (limit "
                        f"{self.limit:.0f} s: {LONGEST_WAITS:g} times the longest member, at least {LEAST_WAIT:g} s); "
                        "it is computed in this process; see whether the workers are alive",
                        RuntimeWarning,
                        stacklevel=2,
                    )
                    store_members(*given.arguments)
                self._count(given, "this host")

    @property
    def limit(self) -> float:
        """The longest time to wait for a member, s."""
        return max(LEAST_WAIT, LONGEST_WAITS * self.longest)

    def _count(self, given: Given, host: str) -> None:
        """Count a member once this process has read its files, and give up its claim."""
        end = time.monotonic() + LATE
        while unseen := [at_work for at_work in given.runs if not at_work.is_stored(given.task)]:
            path = member_path(unseen[0].folder, *given.task)
            if time.monotonic() > end:
                raise RecordError(
                    f"a worker on {host} wrote {path}, but this process does not see it: the file system is not "
                    f"shared; name a run folder that all workers see"
                )
            list(path.parent.iterdir())  # makes a network file system look again
            time.sleep(0.1)
        self._refresh(given)
        self.claims.release(member_name(*given.task))
        self.counted += 1

    def _refresh(self, given: Given | None = None) -> None:
        """Read the members that have appeared, the one `given` also beyond a gap, and call the observer if any have.

        A member that was damaged on disk meanwhile is moved aside, to be computed again.
        """
        for at_work in self.runs if given is None else given.runs:
            run, before = at_work.run, len(at_work.run.members)
            try:
                if given is not None:
                    run.take(*given.task)
                run.refresh()
            except (DamagedError, FileNotFoundError):
                sweep(at_work.folder, self.claims)
                self.look_again = 0.0
                run.refresh()
            self.check()
            if self.observer is not None and len(run.members) != before:
                self.observer(run)


def sweep(folder: Path, claims: Claims) -> None:
    """Move damaged members aside, with a warning each, and remove what killed writers left half done.

    OSError if a member cannot be read now: that is no damage, and nothing is done about it.
    """
    clear(folder, claims)
    for path in member_files(folder):
        if is_temporary(path.name):
            continue
        try:
            check_member(path)
        except FileNotFoundError:
            continue  # another process has moved it
        except RecordError as error:
            try:
                kept = set_aside(path)
            except FileNotFoundError:
                continue
            reason = str(error).partition(";")[0]
            warnings.warn(f"{reason}; it was moved to {kept} and is done again", RuntimeWarning, stacklevel=3)


def clear(folder: Path, claims: Claims) -> None:
    """Remove what killed writers left half done: of members that nobody computes now, and beside them."""
    for path in member_files(folder):
        if is_temporary(path.name) and not claims.claimed(path.name[1:].partition(".")[0]):
            path.unlink(missing_ok=True)  # a writer without a claim, if there is one, writes it again
    for path in folder.iterdir():
        if _BEGUN.fullmatch(path.name) and is_temporary(path.name):
            path.unlink(missing_ok=True)  # so does a process that is at work


def member_files(folder: Path) -> list[Path]:
    """Return the files of members in a run folder, whole or half written; other files are left alone."""
    return sorted(path for path in (folder / "realizations").iterdir() if _MEMBER.fullmatch(path.name))
