"""Workers compute members and store their files, in any process."""

import socket
import time
import warnings
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from roughsim import fourier
from roughsim.ensemble.sources import Source
from roughsim.errors import ConvergenceError, RecordError
from roughsim.observables.member import Member
from roughsim.pipeline import Solved, versions
from roughsim.store.member_files import write_member


@dataclass(frozen=True, slots=True, eq=False)
class Job:
    """Everything that a worker needs to compute the members of one level: some kilobytes once pickled."""

    source: Source
    speeds: tuple[float, ...]  # m/s, of the scene: a problem has a tiny speed in place of zero
    keep_fields: int  # number of realizations with stored fields
    provenance: dict[str, Any]  # scene and numerics of the run
    folder: Path  # of the run


def store_members(jobs: list[Job], index: int) -> str:
    """Compute one member of each run, write their files, and return the name of this host.

    Neighbours in the list with an equal surface or contact share it. RecordError if a run folder does not exist for
    this process; OSError with the path if the disk refuses.
    """
    host = socket.gethostname()
    solved: list[Solved] = []
    for job in jobs:
        if not (job.folder / "run.json").exists():
            raise RecordError(
                f"a worker on {host} does not see {job.folder}: it was moved, or the file system is not shared; name a "
                f"run folder that all workers see"
            )
        member, solved = computed(job, index, solved)
        write_member(job.folder, member)
    return host


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
        **job.provenance,
        "seed": problem.seed,
        "stream": problem.stream,
        "threads": problem.threads,
        "versions": versions(),  # of this worker
        "written": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
    }
    return replace(member, lengths=problem.grid.lengths, provenance=provenance), solved
