"""The file of one member: computed and stored."""

from __future__ import annotations

import socket
import time
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from roughsim import fourier
from roughsim.errors import ConvergenceError, RecordError
from roughsim.observables.catalogue import NUMBERS
from roughsim.pipeline import versions
from roughsim.realization import Realization, realize
from roughsim.scene.numerics import Numerics
from roughsim.store.member_files import Member, write_member

if TYPE_CHECKING:
    from roughsim.scene import Scene


def store_member(scene: Scene, numerics: Numerics, level: int, index: int, place: Path) -> None:
    """Compute one member and write its file.

    A solve that does not converge is stored as a failure.
    """
    fourier.set_threads(numerics.threads)
    seed = scene.ensemble.seed
    try:
        with warnings.catch_warnings():
            # the plan says what a cell leaves out of the spectrum; each member need not repeat it
            warnings.filterwarnings("ignore", message="q_min = ", category=RuntimeWarning)
            member = _member(scene, numerics, realize(scene, numerics, seed=seed, level=level, index=index))
    except ConvergenceError as error:
        provenance = _provenance(scene, numerics, error.residual, error.iterations, {})
        member = Member(level, index, failure=str(error), lengths=numerics.lengths, provenance=provenance)
    write_member(place, member)


def store_for(scene: Scene, numerics: Numerics, level: int, index: int, place: Path) -> str:
    """Do as `store_member` in a worker, and return the name of its host.

    Raises
    ------
    RecordError
        If the worker does not see the run folder.
    """
    host = socket.gethostname()
    if not (place / "run.json").exists():
        raise RecordError(
            f"a worker on {host} does not see {place}: the file system is not shared; name a run folder that all "
            f"workers see"
        )
    store_member(scene, numerics, level, index, place)
    return host


def _member(scene: Scene, numerics: Numerics, one: Realization) -> Member:
    seen, contact = one.observables, one.contact
    numbers = {name: record.of_member(one) for name, record in NUMBERS.items()}
    kept = one.index < numerics.keep_fields
    fields = {"heights": one.heights, "pressure": contact.pressure} if kept else {}
    return Member(
        one.level,
        one.index,
        numbers=numbers,
        wavenumber=seen.stress_spectrum.wavenumber,
        spectrum=seen.stress_spectrum.variance,
        fields={name: values.astype(np.float32) for name, values in fields.items()},
        lengths=numerics.lengths,
        speeds=scene.speeds,
        provenance=_provenance(scene, numerics, contact.residual, contact.iterations, one.seconds),
    )


def _provenance(
    scene: Scene, numerics: Numerics, residual: float, iterations: int, seconds: dict[str, float]
) -> dict[str, Any]:
    return {
        "scene": scene.identity(),
        "numerics": numerics.to_dict(),
        "seed": scene.ensemble.seed,
        "stream": numerics.stream,
        "versions": versions(),
        "threads": numerics.threads,
        "residual": residual,
        "iterations": iterations,
        "seconds": seconds,
        "written": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
    }
