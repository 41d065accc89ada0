"""Workers compute members and store their files, in any process."""

import socket
import time
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from roughsim import fourier
from roughsim.errors import ConvergenceError, RecordError
from roughsim.grid import Array
from roughsim.observables.catalogue import stored_numbers
from roughsim.pipeline import Problem, Solution, Solved, solve_problem, versions
from roughsim.store.member_files import Member, Moments, write_member

if TYPE_CHECKING:  # a worker that slides loads it with the problem; single contacts do without
    from roughsim.sliding.member import SlideProblem


class Source(Protocol):
    """Surfaces in place of random ones; it can be pickled."""

    def heights(self, problem: Problem) -> Array:
        """Return the heights of the realization `problem.index`, m, on the grid of the problem."""

    def about(self, level: int, problem: Problem, solution: Solution) -> Mapping[str, Any]:
        """Return additional values that the member stores, as JSON values."""


@dataclass(frozen=True, slots=True, eq=False)
class Job:
    """Everything that a worker needs to compute the members of one level: some kilobytes once pickled."""

    level: int
    problem: "Problem | SlideProblem"  # of realization 0; each member replaces its index
    below: Problem | None  # the level below, on the same surfaces
    speeds: tuple[float, ...]  # m/s, of the scene: the problem has a tiny speed in place of zero
    keep_fields: int  # number of realizations with stored fields
    provenance: dict[str, Any]  # scene and numerics of the run
    folder: Path  # of the run
    source: Source | None = None  # None: random surfaces


def store_members(jobs: list[Job], index: int) -> str:
    """Compute one member of each run, write their files, and return the name of this host.

    Neighbours in the list with an equal surface or contact share it. A solve that does not converge is stored as a
    failure. RecordError if a run folder does not exist for this process; OSError with the path if the disk refuses.
    """
    host = socket.gethostname()
    solved: list[Solved] = []
    for job in jobs:
        if not (job.folder / "run.json").exists():
            raise RecordError(
                f"a worker on {host} does not see {job.folder}: it was moved, or the file system is not shared; name a "
                f"run folder that all workers see"
            )
        problem = replace(job.problem, index=index)
        fourier.set_threads(problem.threads)
        try:
            with warnings.catch_warnings():
                # the plan has stated how much of the spectrum the cell leaves out
                warnings.filterwarnings("ignore", message="q_min = ", category=RuntimeWarning)
                if isinstance(problem, Problem):
                    member, solved = _contact_member(job, problem, solved)
                else:
                    member = _slide_member(job, problem)
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
        write_member(
            job.folder, replace(member, lengths=problem.grid.lengths, provenance=provenance)
        )
    return host


def _contact_member(
    job: Job, problem: Problem, before: list[Solved]
) -> tuple[Member, list[Solved]]:
    """Solve a level, after the level below it on the same surface; return the member and the contacts.

    Equal contacts solved `before` are reused.
    """
    problems = (
        [problem] if job.below is None else [replace(job.below, index=problem.index), problem]
    )
    solved: list[Solved] = []
    moments = []
    accuracy = []
    for k, one in enumerate(problems):
        heights = None if job.source is None else job.source.heights(one)
        start = solved[-1][1].contact if solved else None
        solution = solve_problem(one, before[k] if before else None, heights, start)
        solved.append((one, solution))
        spectrum, distribution = solution.observables.stress_spectrum, solution.distribution
        bins = None if distribution is None else distribution.bins
        moments.append(
            Moments(stored_numbers(solution), spectrum.wavenumber, spectrum.variance, bins)
        )
        accuracy.append(
            {"residual": solution.contact.residual, "iterations": solution.contact.iterations}
        )
    main = solved[-1][1]
    provenance: dict[str, Any] = {**accuracy[-1]}
    if job.below is not None:
        provenance["below"] = accuracy[0]
    if job.source is not None:
        provenance |= job.source.about(job.level, problem, main)
    provenance["seconds"] = {
        stage: sum(one.seconds[stage] for _, one in solved) for stage in main.seconds
    }
    kept = (
        {"heights": main.heights, "pressure": main.contact.pressure}
        if problem.index < job.keep_fields
        else {}
    )
    member = Member(
        job.level,
        problem.index,
        moments=tuple(reversed(moments)),
        fields={name: values.astype(np.float32) for name, values in kept.items()},
        speeds=job.speeds,
        provenance=provenance,
    )
    return member, solved


def _slide_member(job: Job, problem: "SlideProblem") -> Member:
    """Compute the member of a slide of one body over the other."""
    from roughsim.sliding.member import solve_slide

    solution = solve_slide(problem, film=problem.index < job.keep_fields)
    return Member(
        job.level,
        problem.index,
        moments=(Moments(solution.numbers, solution.wavenumber, solution.spectrum, solution.bins),),
        curves=solution.curves,
        fields=solution.film.fields() if solution.film else {},
        speeds=job.speeds,
        provenance={
            "residual": solution.residual,
            "iterations": solution.steps,
            "seconds": solution.seconds,
        },
    )
