"""Workers compute members and return them, in any process."""

import time
import warnings
from dataclasses import dataclass, replace

from roughsim import fourier
from roughsim.ensemble.sources import Source
from roughsim.errors import ConvergenceError
from roughsim.observables.member import Member
from roughsim.pipeline import Solved, versions

Wanted = list[tuple[int, list[int]]]  # index of a realization, and numbers of the jobs that need it


@dataclass(frozen=True, slots=True, eq=False)
class Job:
    """Everything that a worker needs to compute the members of one level: some kilobytes once pickled."""

    source: Source
    speeds: tuple[float, ...]  # m/s, of the scene: a problem has a tiny speed in place of zero
    keep_fields: int  # number of realizations with stored fields


def computed_members(jobs: dict[int, Job], wanted: Wanted) -> list[tuple[int, Member]]:
    """Return members with the numbers of their jobs.

    Of one realization, neighbours in the list with an equal surface or contact share it.
    """
    members = []
    for index, numbers in wanted:
        solved: list[Solved] = []
        for number in numbers:
            member, solved = computed(jobs[number], index, solved)
            members.append((number, member))
    return members


def computed(job: Job, index: int, before: list[Solved]) -> tuple[Member, list[Solved]]:
    """Return a member of a job, as it is stored, and its contacts; a solve that does not converge is a failure."""
    source, problem, solved = job.source, job.source.problem, before
    fourier.set_threads(problem.threads)
    try:
        with warnings.catch_warnings():
            # the plan has stated how much of the spectrum the cell leaves out
            warnings.filterwarnings("ignore", message="q_min = ", category=RuntimeWarning)
            member, solved = source.solve(index, before, keep=index < job.keep_fields)
            member = replace(member, speeds=job.speeds)
    except ConvergenceError as error:
        provenance = {"residual": error.residual, "iterations": error.iterations, "seconds": {}}
        member = Member(source.level, index, failure=str(error), provenance=provenance)
    provenance = {
        **member.provenance,
        "seed": problem.seed,
        "stream": problem.stream,
        "threads": problem.threads,
        "versions": versions(),  # of this worker
        "written": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
    }
    return replace(member, lengths=problem.cell.lengths, provenance=provenance), solved
