"""The members that are still to do, worked through in this process, in a pool of processes, or in any executor."""

from __future__ import annotations

import socket
import time
import warnings
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future, wait
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from roughsim.ensemble.members import store_for, store_member
from roughsim.ensemble.start import sweep
from roughsim.ensemble.workers import Workforce
from roughsim.errors import RecordError
from roughsim.results.run import Run
from roughsim.scene.numerics import Numerics
from roughsim.store.claims import Claims
from roughsim.store.disk import DamagedError
from roughsim.store.member_files import member_path

if TYPE_CHECKING:
    from roughsim.scene import Scene

Task = tuple[int, int]  # level and index
RETRIES = 3  # how often a pool whose worker died is started anew without a new member in between
PAUSE = 0.5  # s between two looks at what other processes have done
SEEN = 10.0  # s that a network file system may take to show what a worker has written
LEAST_WAIT, LONGEST_WAITS = 600.0, 10.0  # s, and multiple of the longest time of a member, after which it is done again


@dataclass(slots=True)
class _Sent:
    """A member that was handed to a worker: when, and whether for the second time."""

    task: Task
    since: float
    again: bool = False


class Tasks:
    """The members still to do, in order, and the run that they make up, also by the work of other processes."""

    def __init__(
        self,
        scene: Scene,
        numerics: Numerics,
        place: Path,
        result: Run,
        claims: Claims,
        check: Callable[[], None],
        observer: Callable[[Run], None] | None = None,
    ):
        self.scene, self.numerics, self.place, self.result = scene, numerics, place, result
        self.claims, self.check, self.observer = claims, check, observer
        self.most = scene.ensemble.max_realizations
        self.longest = 0.0  # s from handing a member out until it came back
        self._levels = sorted(range(len(numerics.levels)), key=lambda i: -numerics.grid(i).points)

    def complete(self, force: Workforce) -> None:
        """Work through the tasks until the targets are met or all members are there, whoever computes them."""
        died, stored = 0, len(self.result.members)
        while True:
            pool = force.pool()
            try:
                if pool is None:
                    self._alone()
                else:
                    self._shared(pool, force)
                return
            except BrokenExecutor as error:
                if force.unguarded:
                    raise RuntimeError(_GUARD) from None
                if force.executor is not None:  # it is broken for good, and not ours to start anew
                    reason = str(error) or type(error).__name__
                    raise RuntimeError(
                        f"workers of the executor died ({reason}): {_GONE}; if they are processes of a script, it "
                        f'needs `if __name__ == "__main__":`'
                    ) from error
                self._refresh()
                died = died + 1 if len(self.result.members) == stored else 1
                stored = len(self.result.members)
                if died > RETRIES:
                    raise RuntimeError(
                        f"workers died {died} times without storing a member, last: {error or type(error).__name__}; "
                        f"see memory and disk, and try fewer workers"
                    ) from error

    def _next(self) -> Task | None:
        """Claim the first member, index by index and the largest grid first, that is not there and nobody computes."""
        for index in range(self.result.realizations, self.most):
            wanted = self.numerics.of_index(index)
            for task in ((level, index) for level in self._levels if level in wanted):
                if not self._stored(task) and self.claims.take(_claim(task)):
                    if not self._stored(task):
                        return task
                    self.claims.release(_claim(task))  # stored since we looked
        return None

    def _stored(self, task: Task) -> bool:
        return member_path(self.place, *task).exists()

    def _finished(self) -> bool:
        return self.result.target_met or self.result.realizations >= self.most

    def _alone(self) -> None:
        while not self._finished():
            task = self._next()
            if task is None:
                self._pause()
            else:
                store_member(self.scene, self.numerics, *task, self.place)
                self._count(task, socket.gethostname())

    def _shared(self, pool: Executor, force: Workforce) -> None:
        pending: dict[Future[str], _Sent] = {}
        try:
            while not self._finished():
                while len(pending) < 2 * force.workers and (task := self._next()) is not None:
                    self._hand_out(pool, pending, _Sent(task, time.monotonic()))
                wait(pending, timeout=PAUSE, return_when=FIRST_COMPLETED)
                done = [future for future in pending if future.done()]  # also those that others have cancelled
                for future in done:
                    sent = pending.pop(future)
                    host = _result(future)
                    self.longest = max(self.longest, time.monotonic() - sent.since)
                    self._count(sent.task, host)
                if not done:
                    self._pause(0.0 if pending else PAUSE)
                    self._redo_overdue(pool, pending, force)
            if force.executor is None:
                running = [future for future in pending if not future.cancel()]
                force.stuck |= bool(wait(running, timeout=self._limit).not_done)
        finally:
            for future in pending:
                future.cancel()
            self.claims.release_all()

    def _hand_out(self, pool: Executor, pending: dict[Future[str], _Sent], sent: _Sent) -> None:
        try:
            future = pool.submit(store_for, self.scene, self.numerics, *sent.task, self.place)
        except BrokenExecutor:
            raise
        except Exception as error:  # each library of executors has its own
            reason = str(error) or type(error).__name__
            raise RuntimeError(f"the executor takes no more members ({reason}): {_GONE}") from error
        pending[future] = sent

    def _redo_overdue(self, pool: Executor, pending: dict[Future[str], _Sent], force: Workforce) -> None:
        """Hand out again what has not come back for long; what then still does not come back is computed here."""
        limit = self._limit
        for future, sent in list(pending.items()):
            waited = time.monotonic() - sent.since
            if waited <= limit:
                continue
            del pending[future]
            force.stuck |= not future.cancel()
            name = f"{_claim(sent.task)} has not come back from a worker for {waited:.0f} s"
            if sent.again:
                warnings.warn(f"{name} again; it is computed in this process", RuntimeWarning, stacklevel=2)
                store_member(self.scene, self.numerics, *sent.task, self.place)
                self._count(sent.task, socket.gethostname())
            else:
                warnings.warn(
                    f"{name} (limit {limit:.0f} s: {LONGEST_WAITS:g} times the longest so far, at least "
                    f"{LEAST_WAIT:g} s); it is handed out again; see whether the workers are alive",
                    RuntimeWarning,
                    stacklevel=2,
                )
                self._hand_out(pool, pending, _Sent(sent.task, time.monotonic(), again=True))

    @property
    def _limit(self) -> float:
        """How long a member is waited for, s."""
        return max(LEAST_WAIT, LONGEST_WAITS * self.longest)

    def _count(self, task: Task, host: str) -> None:
        """Count a member once this process has read its file, and give up its claim."""
        end = time.monotonic() + SEEN
        while not self._stored(task):
            if time.monotonic() > end:
                raise RecordError(
                    f"a worker on {host} wrote {member_path(self.place, *task)}, but this process does not see it: the "
                    f"file system is not shared; name a run folder that all workers see"
                )
            list(member_path(self.place, *task).parent.iterdir())  # network file systems look again
            time.sleep(0.1)
        self._refresh(task)
        self.claims.release(_claim(task))
        self._tell()

    def _pause(self, seconds: float = PAUSE) -> None:
        """Wait, and count what other processes have stored."""
        before = len(self.result.members)
        time.sleep(seconds)
        self._refresh()
        if len(self.result.members) != before:
            self._tell()
        self.check()

    def _refresh(self, *tasks: Task) -> None:
        """Read what has come, these members also beyond a gap; what a disk has damaged since is done again."""
        try:
            for task in tasks:
                self.result.take(*task)
            self.result.refresh()
        except (DamagedError, FileNotFoundError):
            sweep(self.place, self.claims)
            self.result.refresh()

    def _tell(self) -> None:
        self.check()
        if self.observer is not None:
            self.observer(self.result)


_GUARD = (
    'the script lacks `if __name__ == "__main__":`: each worker imports the script and would start the run again; '
    "put the call of run below that line, or compute with workers=1"
)

_GONE = (
    "its scheduler or its workers are gone; what was computed is stored; start them anew, and the same call goes on "
    "from there"
)


def _claim(task: Task) -> str:
    return f"L{task[0]}-{task[1]:06d}"


def _result(future: Future[str]) -> str:
    """The host that a worker sends back; an executor that drops what it was given says nothing by itself."""
    try:
        return future.result()
    except CancelledError:
        raise RuntimeError(f"the executor dropped a member that it had been given: {_GONE}") from None
