"""The work of a run: computing members and storing their files, in whatever process."""

import pickle
import socket
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from roughsim import fourier
from roughsim.ensemble.memory import keep_freed_memory
from roughsim.errors import ConvergenceError, RecordError, ResolutionError
from roughsim.machine import available_memory, workers_that_fit
from roughsim.observables.catalogue import NUMBERS
from roughsim.pipeline import Problem, Solution, Solved, solve_problem, versions
from roughsim.store.member_files import Member, write_member

if TYPE_CHECKING:  # who marches loads it with the problem; single contacts do without
    from roughsim.sliding.member import SlideProblem


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


def store_where_it_fits(members: list[tuple[list[Job], int]]) -> tuple[str, list[float]]:
    """Call `store_in_turn` in a process of an executor, which may be on another machine than the run was planned on.

    ResolutionError if this machine has too little memory for a member.
    """
    refuse_too_large(max(job.problem.memory for jobs, _ in members for job in jobs))
    return store_in_turn(members)


@lru_cache(maxsize=64)  # asked before the first member of a size: after it the memory of this process counts as used
def refuse_too_large(member: float) -> None:
    """Refuse members of so many bytes with a ResolutionError if this machine has too little memory."""
    try:
        workers_that_fit(1, member, "one member", available_memory())
    except ResolutionError as error:
        raise ResolutionError(f"a worker on {socket.gethostname()} cannot compute a member: {error}") from None


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
