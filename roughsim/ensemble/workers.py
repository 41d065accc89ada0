"""The processes of a run: computing members and storing their files, pools of workers, and signals that end a run."""

import multiprocessing
import os
import pickle
import signal
import socket
import sys
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, replace
from functools import lru_cache
from multiprocessing.context import SpawnContext, SpawnProcess
from pathlib import Path
from types import FrameType, TracebackType
from typing import TYPE_CHECKING, Any

import numpy as np

from roughsim import fourier
from roughsim.ensemble.memory import MUCH, give_memory_back, keep_freed_memory
from roughsim.errors import ConvergenceError, RecordError
from roughsim.observables.catalogue import NUMBERS
from roughsim.pipeline import Problem, Solution, Solved, solve_problem, versions
from roughsim.store.member_files import Member, write_member

if TYPE_CHECKING:  # who marches loads it with the problem; single contacts do without
    from roughsim.sliding.member import SlideProblem

WORKER = "roughsim worker"  # name of the processes that are started here
UNGUARDED = 113  # exit code of a worker that met the call of `run` while it imported the script of its parent


@dataclass(frozen=True, slots=True, eq=False)
class Job:
    """What a worker needs to compute the members of one level: some kilobytes once pickled.

    It is pickled once and read once by each process, however many members are handed out with it.
    """

    level: int
    problem: "Problem | SlideProblem"  # its index is replaced by that of the member
    speeds: tuple[float, ...]  # m/s, as the scene has them: the problem has a tiny speed in place of zero
    keep_fields: int  # how many realizations keep their fields
    provenance: dict[str, Any]  # of the whole run: its scene and numerics
    folder: Path  # of the run

    def __reduce__(self) -> tuple[Callable[[bytes], "Job"], tuple[bytes]]:
        return unpacked, (packed(self),)


@lru_cache(maxsize=1024)
def packed(job: Job) -> bytes:
    """Return the fields of a job as bytes."""
    return pickle.dumps([getattr(job, name) for name in job.__slots__], pickle.HIGHEST_PROTOCOL)


@lru_cache(maxsize=1024)
def unpacked(content: bytes) -> Job:
    """Return the job that `packed` took apart."""
    return Job(*pickle.loads(content))


def store_in_turn(members: list[tuple[list[Job], int]]) -> tuple[str, list[float]]:
    """Call `store_members` with each of these arguments; return the name of this host, and the time of each call, s."""
    seconds = []
    for jobs, index in members:
        began = time.perf_counter()
        host = store_members(jobs, index)
        seconds.append(time.perf_counter() - began)
    return host, seconds


def store_members(jobs: list[Job], index: int) -> str:
    """Compute one member of each run, write their files, and return the name of this host.

    Neighbours in the list share what they have in common: the surface, and the contact. A solve that does not converge
    is stored as a failure. RecordError if this process does not see a run folder; OSError, naming the path, if the disk
    refuses.
    """
    keep_freed_memory()
    host, solved = socket.gethostname(), None
    for job in jobs:
        if not (job.folder / "run.json").exists():
            raise RecordError(
                f"a worker on {host} does not see {job.folder}: it was moved, or the file system is not shared; name a "
                f"run folder that all workers see"
            )
        solved = store_member(job, index, solved)
    return host


def store_member(job: Job, index: int, before: Solved | None) -> Solved | None:
    """Compute one member and write its file; return its problem with what was computed, None where nothing was.

    What its problem has in common with the one `before` is taken from there.
    """
    problem, solved = replace(job.problem, index=index), before
    fourier.set_threads(problem.threads)
    try:
        with warnings.catch_warnings():
            # the plan says how much of the spectrum the cell leaves out; the members need not repeat it
            warnings.filterwarnings("ignore", message="q_min = ", category=RuntimeWarning)
            if isinstance(problem, Problem):
                solved = problem, solve_problem(problem, before)
                member = single_member(job, *solved)
            else:
                member = march_member(job, problem)
    except ConvergenceError as error:
        provenance = {"residual": error.residual, "iterations": error.iterations, "seconds": {}}
        member = Member(job.level, index, failure=str(error), provenance=provenance)
    write(job, problem, member)
    return solved


def write(job: Job, problem: "Problem | SlideProblem", member: Member) -> None:
    """Write the file of a member with how it came about."""
    provenance = (
        member.provenance
        | job.provenance
        | {
            "seed": problem.seed,
            "stream": problem.stream,
            "threads": problem.threads,
            "versions": versions(),  # of this worker
            "written": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
        }
    )
    write_member(job.folder, replace(member, lengths=problem.grid.lengths, provenance=provenance))


def single_member(job: Job, problem: Problem, solution: Solution) -> Member:
    """Return the member of a single contact."""
    contact, spectrum = solution.contact, solution.observables.stress_spectrum
    kept = problem.index < job.keep_fields
    fields = {"heights": solution.heights, "pressure": contact.pressure} if kept else {}
    return Member(
        job.level,
        problem.index,
        numbers={name: number.of_member(solution) for name, number in NUMBERS.items() if not number.of_march},
        wavenumber=spectrum.wavenumber,
        spectrum=spectrum.variance,
        fields={name: values.astype(np.float32) for name, values in fields.items()},
        speeds=job.speeds,
        provenance={"residual": contact.residual, "iterations": contact.iterations, "seconds": solution.seconds},
    )


def march_member(job: Job, problem: "SlideProblem") -> Member:
    """Compute the member of a march of one body over the other."""
    from roughsim.sliding.member import solve_slide

    solution = solve_slide(problem, film=problem.index < job.keep_fields)
    return Member(
        job.level,
        problem.index,
        numbers=solution.numbers,
        wavenumber=solution.wavenumber,
        spectrum=solution.spectrum,
        curves=solution.curves,
        fields=solution.film.fields() if solution.film else {},
        speeds=job.speeds,
        provenance={"residual": solution.residual, "iterations": solution.steps, "seconds": solution.seconds},
    )


class ThisProcess(Executor):
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

    At the end all processes made here have ended, and the system has the memory back that this one does not need. After
    an error or an interrupt they are killed at once: a member that is not stored yet is computed again. An executor of
    the caller is left to the caller.
    """

    def __init__(self, workers: int, executor: Executor | None):
        self.executor = executor
        self.stuck = False  # whether some worker will not come back: do not wait for it at the end
        self.broken = False  # whether a process of the pool has died, so that it takes no more members
        self.workers = workers
        self.context = RememberingContext()
        self._made: list[Executor] = []

    @property
    def in_flight(self) -> int:
        """How many calls are handed out at a time: one more for each worker, so that none waits for the next."""
        return 1 if self.executor is None and self.workers == 1 else 2 * self.workers

    def start(self) -> None:
        """Start the processes of the first pool, so that they load their libraries while this process is busy."""
        if self.executor is None and self.workers > 1:
            for _ in range(self.workers):
                self.pool().submit(load_solver)  # a pool starts a process for each task that waits

    def pool(self) -> Executor:
        """Return the executor that takes members: a new pool at first, and where the last one is `broken`."""
        if self.executor is not None:
            return self.executor
        if self.workers == 1:
            keep_freed_memory(MUCH)
            return ThisProcess()
        if self._made and not self.broken:
            return self._made[-1]
        self.broken = False
        pool = ProcessPoolExecutor(self.workers, self.context, initializer=begin_worker, initargs=(os.getpid(),))
        self._made.append(pool)
        return pool

    @property
    def unguarded(self) -> bool:
        """Whether a worker ended because the script that it imports calls `run` without a guard."""
        return any(child.exitcode == UNGUARDED for child in self.context.born)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is not None or self.stuck:
            for child in self.context.born:
                child.kill()
        for pool in self._made:
            pool.shutdown(wait=True, cancel_futures=True)
        if self.executor is None and self.workers == 1:
            give_memory_back()


def load_solver() -> None:
    """Load the contact solver, and numba with it: a third of a second."""
    import roughsim.contact.active_set  # noqa: F401


def refuse_script_without_file() -> None:
    """Refuse processes for a script from the standard input, ValueError: each of them would look for its file."""
    script = sys.modules["__main__"]
    path = getattr(script, "__file__", None)
    if getattr(script, "__spec__", None) is None and path is not None and not os.path.exists(path):
        raise ValueError(
            f"workers = 2 or more processes import the script again, but {path} is no file; save the script in a file, "
            f"or compute with workers=1"
        )


def leave_if_imported() -> None:
    """End this process if it is a worker that imports the script of its parent and has come to the call of `run`.

    The parent then says what the script lacks; an exception here would print a traceback for each worker.
    """
    if multiprocessing.current_process().name == WORKER:
        os._exit(UNGUARDED)


def begin_worker(parent: int) -> None:
    """Leave interrupts to the main process, and do not outlive it, however it ends; keep memory as long as it lasts."""
    keep_freed_memory(MUCH)
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(0.5)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


@contextmanager
def stopped_by_signals() -> Iterator[Callable[[], None]]:
    """Let SIGTERM end a run as Ctrl-C does, and yield a function that raises an interrupt which Python has dropped.

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
