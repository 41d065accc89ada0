"""Executors that compute the members of a run: this process, a pool of worker processes, or one of the caller."""

import signal
import threading
import warnings
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from math import inf
from multiprocessing import active_children, get_context
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from types import FrameType
from typing import Any, Self

from roughsim.contact.active_set import note_compilation
from roughsim.ensemble.workers import computed_members
from roughsim.machine import (
    PROCESS,
    SHARE,
    available_memory,
    in_words,
    usable_cores,
    workers_that_fit,
)
from roughsim.show.text import note, notes_are_shown, show_notes

# s of computing above which processes are started, if their number is not given: each takes 1.6 s of CPU time to
# start, so two of them, of which one is this process, end earlier than one from 1.6 s on
_WORTH_PROCESSES = 3.0
# s of a member above which this process computes none beside others: members that these return wait for it to be saved
_LONGEST = 2.0
# processes above which this one computes none beside others: it takes members that they return, .3 ms each
_FEW = 8
_STARTING = threading.Lock()  # runs in several threads: each knows its own processes
SUITABLE = "give a concurrent.futures.Executor; that of a client of dask is client.get_executor(pure=False)"


class SerialExecutor(Executor):
    """An executor that computes each call in this process, before `submit` returns."""

    def submit(
        self, function: Callable[..., Any], /, *arguments: Any, **options: Any
    ) -> Future[Any]:
        """Compute ``function(*arguments, **options)`` and return a future that is done."""
        future: Future[Any] = Future()
        try:
            future.set_result(function(*arguments, **options))
        except Exception as error:  # KeyboardInterrupt is not caught
            future.set_exception(error)
        return future


class Workers:
    """The executor of a run, and the number of members that it computes at the same time.

    Where members are short, this process computes while the others start, and is one of the workers if they are few;
    elsewhere it hands members out and saves them. Without a given number of workers (`count` None) it computes alone as
    long as processes would take longer to start than to compute. A context manager: own processes end with it. After an
    error or an interrupt they are ended at once, since a member that is not stored can be computed again. An executor
    of the caller is never shut down.
    Inside it SIGTERM, SIGHUP of a closed terminal and SIGXCPU of a limit of CPU time are a KeyboardInterrupt as Ctrl-C
    (SIGINT) is. Handlers that a program has set itself, or that `nohup` has, are kept.
    """

    def __init__(self, count: int | None, executor: Executor | None = None):
        if count is not None and (isinstance(count, bool) or int(count) != count or count < 1):
            raise ValueError(f"workers = {count!r} must be a whole number ≥ 1")
        if executor is not None and not callable(getattr(executor, "submit", None)):
            raise TypeError(f"executor = {executor!r:.200} has no method submit; {SUITABLE}")
        self.count = int(usable_cores().amount) if count is None else int(count)
        self.given = executor  # of the caller
        self.interrupted = False
        self._died = False  # a worker, as if memory ran out
        self._asked = count
        self._memory = available_memory()  # before there are workers, which take some of it
        self._member = 0.0  # bytes of a member
        self._short = True  # members of `_LONGEST` at most
        self._pool: ProcessPoolExecutor | None = None
        self._starting: list[Future[Any]] = []  # first calls of workers, until all have started
        self._processes: set[BaseProcess] = set()  # of the pool
        self._lifeline: Connection | None = None  # when it closes, the workers end
        self._handlers: dict[int, Any] = {}  # of signals before

    @property
    def helps(self) -> bool:
        """Whether this process computes members beside the executor: the few others have started."""
        return self._has_started and self._pool_size < self.count

    @property
    def _pool_size(self) -> int:
        return self.count - (self._computes and self.count <= _FEW)

    @property
    def _computes(self) -> bool:
        """Whether this process may compute: a member that is killed would end the run."""
        return self._short and not self._died

    @property
    def _has_started(self) -> bool:
        return self._pool is not None and not self._starting

    @property
    def others(self) -> int:
        """Number of members that `executor` computes at the same time."""
        if self.given is not None:
            return self.count
        return self._pool_size if self._has_started else 1

    @property
    def in_flight(self) -> int:
        """Number of tasks that `executor` has at a time: one more than each worker computes, so that none waits."""
        return 1 if self.given is None and not self._has_started else 2 * self.others

    def fit(
        self, member: float, source: str, threads: int, *, seconds: float = 0.0, busy: bool = False
    ) -> bool:
        """Choose the number of workers that fit into memory, each with a member of this size in bytes.

        A number that was asked for is lowered with a RuntimeWarning. ResolutionError if one member does not fit;
        `source` is the part of the member that takes its memory, `seconds` the modelled time of the longest member.
        Executors of the caller are left as they are. False, and nothing is done, if the workers are to be others but
        some are still `busy`.
        """
        if self.given is not None:
            return True
        wanted = self._asked or max(int(usable_cores().amount) // threads, 1)
        count = workers_that_fit(wanted, member, source, self._memory)
        short = seconds <= _LONGEST
        changed = (count, short) != (self.count, self._short)
        if busy and changed:
            return False
        if count < wanted:
            words = (
                f"workers = {wanted} would need {wanted} × {(member + PROCESS) / 1e9:.3g} GB, more than "
                f"{100 * SHARE:.0f} % of the {in_words(self._memory)}; the run has {count}"
            )
            if self._asked is None:
                note(words)
            else:
                warnings.warn(words, RuntimeWarning, stacklevel=2)
        if changed:
            self._close()
        self.count, self._short = count, short
        self._member = member
        return True

    def executor(self, seconds_left: Callable[[], float] = lambda: inf) -> Executor:
        """Return the executor for the computing that is left, s in one process.

        It is this process until the pool has started; from then on the pool, until it breaks. RuntimeError if workers
        fail while they start; BrokenExecutor if one is killed.
        """
        if self.given is not None:
            return self.given
        alone = self.count == 1 and not self._died
        if self._pool is None and (
            alone or (self._asked is None and seconds_left() < _WORTH_PROCESSES)
        ):
            return SerialExecutor()
        pool = self._pool or self._start()
        if self._computes and not all(call.done() for call in self._starting):
            return SerialExecutor()
        try:
            for call in self._starting:
                call.result()
        except BrokenExecutor as error:
            self._close()
            if all((process.exitcode or 0) <= 0 for process in self._processes):
                raise  # killed
            raise RuntimeError(
                f"no worker could start ({error}): each worker imports the script, which must be a file with "
                '`if __name__ == "__main__":` above the call; or compute with workers=1'
            ) from None
        self._starting = []
        return pool

    def _start(self) -> ProcessPoolExecutor:
        """Start a pool of processes; a script without a guard calls `run` again in each, which fails here."""
        note_compilation()  # here, as one line: all workers compile the same kernels
        context = get_context("spawn")  # a fork after threaded transforms hangs
        receiver, self._lifeline = context.Pipe(duplex=False)
        size = self._pool_size
        with _STARTING:
            before = {*active_children()}
            self._pool = ProcessPoolExecutor(
                size, context, _begin_worker, (receiver, notes_are_shown())
            )
            # a call without members imports what they need
            self._starting = [self._pool.submit(computed_members, {}, []) for _ in range(size)]
            self._processes = {*active_children()} - before
        return self._pool

    def replace_broken(self, error: Exception) -> None:
        """Prepare a new pool with one worker fewer after a worker has died; RuntimeError for one of the caller."""
        reason = str(error) or type(error).__name__
        if self.given is not None:
            raise RuntimeError(
                f"the executor has lost a member ({reason}): its scheduler or its workers have ended; all finished "
                "members are stored, and the same call continues from there; if its workers are processes, the script "
                'needs `if __name__ == "__main__":` above the call'
            ) from error
        self._close()
        before, self._died = self.count, True
        self._asked = self.count = max(before - 1, 1)
        warnings.warn(
            f"a worker has died ({reason}), as if memory ran out: {before} workers need about {before} × "
            f"{(self._member + PROCESS) / 1e9:.3g} GB, and {in_words(self._memory)} at the start of the run; ask for "
            f"more memory, or for fewer workers; the run continues with {self.count}",
            RuntimeWarning,
            stacklevel=2,
        )

    def __enter__(self) -> Self:
        for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGXCPU"):
            number = getattr(signal, name, None)
            main = (
                threading.current_thread() is threading.main_thread()
            )  # others can set no handlers
            if (
                main
                and number
                and signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler)
            ):
                self._handlers[number] = signal.signal(number, self._interrupt)
        return self

    def _interrupt(self, number: int, frame: FrameType | None) -> None:
        self.interrupted = True
        signal.default_int_handler(number, frame)

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        try:
            if kind is not None and self._lifeline is not None:
                self._lifeline.close()
            self._close()
        finally:
            for number, handler in self._handlers.items():
                signal.signal(number, handler)

    def _close(self) -> None:
        """End the pool after the calls in progress; workers that still start have none, and end at once."""
        if self._pool is not None and self._lifeline is not None:
            if not all(call.done() for call in self._starting):
                for process in self._processes:
                    process.terminate()
            self._pool.shutdown(wait=True, cancel_futures=True)
            self._lifeline.close()
            self._pool, self._starting = None, []


def _begin_worker(lifeline: Connection, notes: bool) -> None:
    """Leave interrupts to the parent process, and end when it closes the connection, or ends in any way.

    Workers show notes if the parent does.
    """
    if notes:
        show_notes()
    for name in ("SIGINT", "SIGHUP"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)

    def watch() -> None:
        lifeline.poll(None)
        signal.raise_signal(signal.SIGTERM)

    threading.Thread(target=watch, daemon=True).start()
