"""What a worker does: compute one member and store its file. It needs the pipeline and the disk, no scene."""

from __future__ import annotations

import socket
import time
import warnings
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from roughsim import fourier
from roughsim.errors import ConvergenceError, RecordError
from roughsim.observables.catalogue import NUMBERS
from roughsim.pipeline import Problem, solve_problem, versions
from roughsim.store.member_files import Member, write_member


@dataclass(frozen=True, slots=True)
class Job:
    """The members of one level, as a worker gets them: some kilobytes once pickled."""

    level: int
    problem: Problem  # its index is replaced by that of the member
    speeds: tuple[float, ...]  # m/s, as the scene has them: the problem has a tiny speed in place of zero
    keep_fields: int  # how many realizations keep their fields
    provenance: dict[str, Any]  # of the whole run: its scene and numerics
    folder: Path  # of the run


def store_member(job: Job, index: int) -> str:
    """Compute one member, write its file, and return the name of this host.

    A solve that does not converge is stored as a failure. RecordError if this process does not see the run folder;
    OSError, naming the path, if the disk refuses.
    """
    host = socket.gethostname()
    if not (job.folder / "run.json").exists():
        raise RecordError(
            f"a worker on {host} does not see {job.folder}: it was moved, or the file system is not shared; name a run "
            f"folder that all workers see"
        )
    problem = replace(job.problem, index=index)
    fourier.set_threads(problem.threads)
    try:
        with warnings.catch_warnings():
            # the plan says what a cell leaves out of the spectrum; each member need not repeat it
            warnings.filterwarnings("ignore", message="q_min = ", category=RuntimeWarning)
            solution = solve_problem(problem)
    except ConvergenceError as error:
        provenance = {"residual": error.residual, "iterations": error.iterations, "seconds": {}}
        member = Member(job.level, index, failure=str(error))
    else:
        contact, spectrum = solution.contact, solution.observables.stress_spectrum
        provenance = {"residual": contact.residual, "iterations": contact.iterations, "seconds": solution.seconds}
        fields = {"heights": solution.heights, "pressure": contact.pressure} if index < job.keep_fields else {}
        member = Member(
            job.level,
            index,
            numbers={name: number.of_member(solution) for name, number in NUMBERS.items()},
            wavenumber=spectrum.wavenumber,
            spectrum=spectrum.variance,
            fields={name: values.astype(np.float32) for name, values in fields.items()},
            speeds=job.speeds,
        )
    provenance |= job.provenance | {
        "seed": problem.seed,
        "stream": problem.stream,
        "threads": problem.threads,
        "versions": versions(),  # of this worker
        "written": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
    }
    write_member(job.folder, replace(member, lengths=problem.grid.lengths, provenance=provenance))
    return host
