"""The processes of a run: this one, a pool of as many workers as fit, or an executor of the caller."""

import multiprocessing
import os
import signal
import sys
import threading
import time
import warnings
from collections.abc import Callable
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import AbstractContextManager
from multiprocessing.context import SpawnContext, SpawnProcess
from types import TracebackType
from typing import Any

from roughsim.machine import PROCESS, SHARE, available_memory, in_words, usable_cores, workers_that_fit
from roughsim.show.text import note

WORKER = "roughsim worker"  # name of the processes that are started here
UNGUARDED = 113  # exit code of a worker that met the call of `run` while it imported the script of its parent


class SerialExecutor(Executor):
    """An executor that computes each member where it is handed out, before it returns."""

    def submit(self, function: Callable[..., Any], /, *arguments: Any, **options: Any) -> Future[Any]:
        """Compute ``function(*arguments, **options)`` and return a future that is done."""
        future: Future[Any] = Future()
        try:
            future.set_result(function(*arguments, **options))
        except Exception as error:  # an interrupt goes through
            future.set_exception(error)
        return future


class RememberingContext(SpawnContext):
    """Starts processes by spawning, since a fork after threaded transforms hangs, and keeps a list of them."""

    def __init__(self) -> None:
        self.born: list[SpawnProcess] = []

    def Process(self, *args: Any, **kwargs: Any) -> SpawnProcess:  # type: ignore[override]
        """Return a process that is not started yet."""
        self.born.append(SpawnProcess(*args, **kwargs))
        self.born[-1].name = WORKER
        return self.born[-1]


class Workforce(AbstractContextManager["Workforce"]):
    """What computes the members of a run: this process, a pool of worker processes, or an executor of the caller.

    At the end all processes made here have ended. After an error or an interrupt they are killed at once: a member that
    is not stored yet is computed again. An executor of the caller is left to the caller.
    """

    def __init__(self, workers: int | None, executor: Executor | None):
        self.executor = executor
        self.asked = workers  # None: as many as there are cores
        self.workers = int(usable_cores().amount) if workers is None else workers
        self.stuck = False  # whether some worker will not come back: do not wait for it at the end
        self.memory = available_memory()  # before there are workers, which take some of it
        self.member = 0.0  # bytes that a member takes
        self.context = RememberingContext()
        self._pool: Executor | None = None  # of own processes
        self._killed = 0  # workers known to have been killed

    @property
    def alone(self) -> bool:
        """Whether this process computes the members."""
        return self.executor is None and self.workers == 1 and not self.context.born

    @property
    def in_flight(self) -> int:
        """How many members are handed out at a time: one more for each worker, so that none waits for the next."""
        return 1 if self.alone else 2 * self.workers

    @property
    def unguarded(self) -> bool:
        """Whether a worker ended because the script that it imports calls `run` without a guard."""
        return any(child.exitcode == UNGUARDED for child in self.context.born)

    def fit(self, member: float, why: str, threads: int) -> None:
        """Let no more workers compute members of so many bytes than cores and memory allow, and say so.

        A number of workers that was asked for is lowered by memory alone, with a RuntimeWarning. ResolutionError if
        there is no room for one member; `why` says what takes its memory.
        """
        if self.executor is not None:  # which may be on other machines
            return
        wanted = self.asked or max(int(usable_cores().amount) // threads, 1)
        workers = workers_that_fit(wanted, member, why, self.memory)
        if workers < wanted:
            words = (
                f"workers = {wanted} would need {wanted} × {(member + PROCESS) / 1e9:.3g} GB, more than "
                f"{100 * SHARE:.0f} % of the {in_words(self.memory)}; the run has {workers}"
            )
            if self.asked is None:
                note(words)
            else:
                warnings.warn(words, RuntimeWarning, stacklevel=2)
        if workers != self.workers:
            self._close()
        self.workers, self.member = workers, member

    def pool(self) -> Executor:
        """Return the executor that takes members: the same until it is lost."""
        if self.executor is not None:
            return self.executor
        if self.alone:
            return SerialExecutor()
        if self._pool is None:
            self._pool = ProcessPoolExecutor(
                self.workers, self.context, initializer=begin_worker, initargs=(os.getpid(),)
            )
        return self._pool

    def lose_pool(self) -> str:
        """Drop a broken pool, with one worker fewer where the system has killed one; return that in words, else ""."""
        self._close()
        killed = sum(child.exitcode == -signal.SIGKILL for child in self.context.born)
        if killed == self._killed:
            return ""
        self._killed, before = killed, self.workers
        self.asked = self.workers = max(before - 1, 1)
        return (
            f"the system has killed a worker (SIGKILL), as it does where memory runs out: {before} workers need about "
            f"{before} × {(self.member + PROCESS) / 1e9:.3g} GB, and {in_words(self.memory)} at the start of the run; "
            "ask for more memory, or for fewer workers"
        )

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is not None or self.stuck:
            for child in self.context.born:
                child.kill()
        self._close()

    def _close(self) -> None:
        """End the processes of the pool, once they have done what they have begun."""
        if self._pool is not None:
            self._pool.shutdown(wait=True, cancel_futures=True)
            self._pool = None


def check_workers(workers: int | None, executor: Executor | None) -> None:
    """Refuse a number of workers that cannot be, or processes that would look for a script without a file.

    A worker that imports the script of its parent and has come to the call of `run` ends here: the parent then says
    what the script lacks, while an exception would print a traceback for each worker.
    """
    if multiprocessing.current_process().name == WORKER:
        os._exit(UNGUARDED)
    if workers is not None and (isinstance(workers, bool) or int(workers) != workers or workers < 1):
        raise ValueError(f"workers = {workers!r} must be a whole number ≥ 1")
    script = sys.modules["__main__"]
    path = getattr(script, "__file__", None)
    lacks_file = getattr(script, "__spec__", None) is None and path is not None and not os.path.exists(path)
    if workers != 1 and executor is None and lacks_file:
        raise ValueError(
            f"workers = 2 or more processes import the script again, but {path} is no file; save the script in a file, "
            f"or compute with workers=1"
        )


def begin_worker(parent: int) -> None:
    """Leave interrupts to the main process, and do not outlive it, however it ends."""
    for name in ("SIGINT", "SIGHUP"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(0.5)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
