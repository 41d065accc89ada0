"""The work of a run: computing members and storing their files, in whatever process."""

import socket
import time
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from roughsim import fourier
from roughsim.errors import ConvergenceError, RecordError
from roughsim.grid import Array
from roughsim.observables.catalogue import NUMBERS
from roughsim.pipeline import Problem, Solution, Solved, solve_problem, versions
from roughsim.store.member_files import Member, Moments, write_member

if TYPE_CHECKING:  # a worker that marches loads it with the problem; single contacts do without
    from roughsim.sliding.member import SlideProblem


class Surfaces(Protocol):
    """Surfaces that take the place of drawn ones; it can be pickled."""

    def heights(self, problem: Problem) -> Array:
        """Return the heights of the realization `problem.index`, m, on the grid of the problem."""

    def about(self, level: int, problem: Problem, solution: Solution) -> Mapping[str, Any]:
        """Return what else the member stores, as JSON values."""


@dataclass(frozen=True, slots=True, eq=False)
class Job:
    """What a worker needs to compute the members of one level: some kilobytes once pickled."""

    level: int
    problem: "Problem | SlideProblem"  # its index is replaced by that of the member
    below: Problem | None  # the level below on the same surfaces
    speeds: tuple[float, ...]  # m/s, as the scene has them: the problem has a tiny speed in place of zero
    keep_fields: int  # how many realizations keep their fields
    provenance: dict[str, Any]  # of the whole run: its scene and numerics
    folder: Path  # of the run
    surfaces: Surfaces | None = None  # None: they are drawn


def store_members(jobs: list[Job], index: int) -> str:
    """Compute one member of each run, write their files, and return the name of this host.

    Neighbours in the list share what they have in common: the surface, and the contact. A solve that does not converge
    is stored as a failure. RecordError if this process does not see a run folder; OSError, naming the path, if the disk
    refuses.
    """
    host, solved = socket.gethostname(), list[Solved]()
    for job in jobs:
        if not (job.folder / "run.json").exists():
            raise RecordError(
                f"a worker on {host} does not see {job.folder}: it was moved, or the file system is not shared; name a "
                f"run folder that all workers see"
            )
        solved = store_member(job, index, solved)
    return host


def store_member(job: Job, index: int, before: list[Solved]) -> list[Solved]:
    """Compute one member and write its file; return what was solved, or `before` where nothing was."""
    problem, solved = replace(job.problem, index=index), before
    fourier.set_threads(problem.threads)
    try:
        with warnings.catch_warnings():
            # the plan says how much of the spectrum the cell leaves out; the members need not repeat it
            warnings.filterwarnings("ignore", message="q_min = ", category=RuntimeWarning)
            if isinstance(problem, Problem):
                solved = solve(job, problem, before)
                member = contact_member(job, *solved)
            else:
                member = march_member(job, problem)
    except ConvergenceError as error:
        provenance = {"residual": error.residual, "iterations": error.iterations, "seconds": {}}
        member = Member(job.level, index, failure=str(error), provenance=provenance)
    provenance = {
        **member.provenance,
        **job.provenance,
        "seed": problem.seed,
        "stream": problem.stream,
        "threads": problem.threads,
        "versions": versions(),  # of this worker
        "written": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
    }
    write_member(job.folder, replace(member, lengths=problem.grid.lengths, provenance=provenance))
    return solved


def solve(job: Job, problem: Problem, before: list[Solved]) -> list[Solved]:
    """Solve a level, and on the same surface the level below it, if there is one.

    What they have in common with what was solved `before` is taken from there.
    """
    problems = [problem] if job.below is None else [problem, replace(job.below, index=problem.index)]
    solved = []
    for one, known in zip_longest(problems, before[: len(problems)]):
        heights = None if job.surfaces is None else job.surfaces.heights(one)
        solved.append((one, solve_problem(one, known, heights)))
    return solved


def contact_member(job: Job, main: Solved, below: Solved | None = None) -> Member:
    """Return the member of a contact, with the moments of the level below."""
    problem, solution = main
    kept = problem.index < job.keep_fields
    fields = {"heights": solution.heights, "pressure": solution.contact.pressure} if kept else {}
    seconds = dict(solution.seconds)
    provenance: dict[str, Any] = {
        "residual": solution.contact.residual,
        "iterations": solution.contact.iterations,
    }
    if below is not None:
        seconds = {stage: value + below[1].seconds[stage] for stage, value in seconds.items()}
        lower = below[1].contact
        provenance["below"] = {"residual": lower.residual, "iterations": lower.iterations}
    if job.surfaces is not None:
        provenance |= job.surfaces.about(job.level, problem, solution)
    return Member(
        job.level,
        problem.index,
        **moments_of(solution)._asdict(),
        below=None if below is None else moments_of(below[1]),
        fields={name: values.astype(np.float32) for name, values in fields.items()},
        speeds=job.speeds,
        provenance=provenance | {"seconds": seconds},
    )


def moments_of(solution: Solution) -> Moments:
    """Return what is stored of a contact."""
    numbers = {name: number.of_member(solution) for name, number in NUMBERS.items() if not number.of_march}
    spectrum = solution.observables.stress_spectrum
    return Moments(numbers, spectrum.wavenumber, spectrum.variance)


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
