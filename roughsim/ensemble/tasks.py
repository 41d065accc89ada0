"""The members that are still to do, worked through in this process, in a pool of processes, or in any executor."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING

from roughsim.ensemble.members import store_member
from roughsim.errors import RecordError
from roughsim.numerics import Numerics
from roughsim.record import Member, Run, member_path, read_member

if TYPE_CHECKING:
    from roughsim.scene import Scene

RETRIES = 3  # how often a pool whose worker died is started anew without a new member in between


@contextmanager
def workforce(workers: int, executor: Executor | None) -> Iterator[Callable[[], Executor | None]]:
    """Yield what makes a pool, and end the last one made; a given executor is left to its owner.

    After an error or an interrupt the processes are ended at once: what they were at is not stored yet, so nothing is
    lost.
    """
    others = set(multiprocessing.active_children())
    made: list[Executor] = []

    def make() -> Executor | None:
        if executor is not None or workers == 1:
            return executor
        context = multiprocessing.get_context("spawn")  # fork after threaded transforms hangs
        made.append(
            ProcessPoolExecutor(workers, mp_context=context, initializer=_begin_worker, initargs=(os.getpid(),))
        )
        return made[-1]

    try:
        yield make
    except BaseException:
        for child in multiprocessing.active_children():
            if made and child not in others:
                child.terminate()
        raise
    finally:
        for pool in made:
            pool.shutdown(wait=True, cancel_futures=True)


def _begin_worker(parent: int) -> None:
    """Leave interrupts to the main process, and do not outlive it, however it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(0.5)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


@contextmanager
def stopped_by_signals() -> Iterator[Callable[[], None]]:
    """Let SIGTERM end a run as an interrupt does, and yield what raises an interrupt that was lost.

    Python drops an exception that comes up inside a finalizer, of an HDF5 object for instance: the run would go on.
    Only the main thread of a process can arrange signals; a handler of the program's own is left alone.
    """
    asked = threading.Event()

    def stop(number: int, frame: FrameType | None) -> None:
        asked.set()
        raise KeyboardInterrupt

    def check() -> None:
        if asked.is_set():
            raise KeyboardInterrupt

    before = {}
    if threading.current_thread() is threading.main_thread():
        before[signal.SIGTERM] = signal.signal(signal.SIGTERM, stop)
        if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            before[signal.SIGINT] = signal.signal(signal.SIGINT, stop)
    try:
        yield check
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def sweep(place: Path) -> None:
    """Remove what a killed writer left half done, and damaged files with a warning: they are done again."""
    for path in sorted((place / "realizations").glob("*")):
        if path.name.endswith(".tmp"):
            path.unlink()
            continue
        try:
            read_member(path)
        except RecordError as error:
            warnings.warn(f"{error}; doing it again", RuntimeWarning, stacklevel=3)
            path.unlink()


class Tasks:
    """The members still to do, in order, and the run that they make up."""

    def __init__(self, scene: Scene, numerics: Numerics, place: Path, result: Run, check: Callable[[], None]):
        self.scene, self.numerics, self.place, self.result, self.check = scene, numerics, place, result, check

    def _to_do(self) -> Iterator[tuple[int, int]]:
        """Yield (level, index) of what is not stored yet, index by index, the largest grid first."""
        levels = sorted(range(len(self.numerics.levels)), key=lambda i: -self.numerics.grid(i).points)
        for index in range(self.scene.ensemble.max_realizations):
            wanted = self.numerics.of_index(index)
            yield from ((level, index) for level in levels if level in wanted and not self._stored(level, index))

    def _stored(self, level: int, index: int) -> bool:
        return member_path(self.place, level, index).exists()

    def complete(
        self, make: Callable[[], Executor | None], workers: int, observer: Callable[[Run], None] | None
    ) -> None:
        """Work through the tasks until the targets are met or there are none left."""
        died, stored = 0, len(self.result.members)
        while True:
            pool = make()
            try:
                if pool is None:
                    self._alone(observer)
                else:
                    self._shared(pool, 2 * workers, observer)
            except BrokenExecutor as error:
                self.result.refresh()
                died = died + 1 if len(self.result.members) == stored else 1
                stored = len(self.result.members)
                if died > RETRIES:
                    raise RuntimeError(
                        f"workers died {died} times without storing a member, last: {error}; see memory and disk, and "
                        f"try fewer workers"
                    ) from error
                continue
            return

    def _alone(self, observer: Callable[[Run], None] | None) -> None:
        for level, index in self._to_do():
            if self.result.target_met:
                return
            self.result.take(store_member(self.scene, self.numerics, level, index, self.place))
            self._tell(observer)

    def _shared(self, pool: Executor, ahead: int, observer: Callable[[Run], None] | None) -> None:
        to_do = self._to_do()
        pending: set[Future[Member]] = set()
        try:
            while not self.result.target_met:
                while len(pending) < ahead and (task := next(to_do, None)) is not None:
                    pending.add(pool.submit(store_member, self.scene, self.numerics, *task, self.place))
                if not pending:
                    return
                done, pending = wait(pending, return_when=FIRST_COMPLETED)
                for future in done:
                    self.result.take(future.result())
                self._tell(observer)
        finally:
            for future in pending:
                future.cancel()

    def _tell(self, observer: Callable[[Run], None] | None) -> None:
        self.check()
        if observer is not None:
            observer(self.result)
