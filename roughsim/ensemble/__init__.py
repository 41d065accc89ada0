"""Ensembles: many realizations of one scene, in this process or several, into a folder.

A member is named by (level, index) and has one random stream, SeedSequence(seed, spawn_key=(stream, index)); all levels
of a run share the stream of the finest, so they see the same modes. Who computes a member, and when, changes no bit.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughsim import analytic
from roughsim.ensemble.tasks import Tasks, stopped_by_signals, sweep, workforce
from roughsim.errors import RecordError
from roughsim.means import OBSERVABLES
from roughsim.numerics import Numerics, Reason
from roughsim.plan import plan
from roughsim.realization import Realization, level_spectrum, realize, versions
from roughsim.record import Run, describe, open_run, read_description, writing
from roughsim.record.files import FORMAT

if TYPE_CHECKING:
    from roughsim.scene import Scene


def run(
    scene: Scene,
    folder: str | Path,
    *,
    numerics: Numerics | None = None,
    seed: int | None = None,
    until: dict[str, float] | None = None,
    max_realizations: int | None = None,
    workers: int = 1,
    executor: Executor | None = None,
    observer: Callable[[Run], None] | None = None,
) -> Run:
    """Compute an ensemble into a folder, or go on with the one that is there.

    Parameters
    ----------
    scene : Scene
        What is computed.
    folder : str or Path
        The run folder; made if it does not exist. The same scene, numerics and seed resume it.
    numerics : Numerics, optional
        Left out: those that the run in the folder began with, else from `plan`.
    seed : int, optional
        The scene's if left out.
    until : dict of str to float, optional
        Relative 95 % half-width of each named observable at which to stop, at the worst speed; the scene's if left out.
    max_realizations : int, optional
        Where to stop in any case; the scene's if left out.
    workers : int, optional
        Processes; 1 computes in this one. A script that asks for more needs ``if __name__ == "__main__":``.
    executor : concurrent.futures.Executor, optional
        Used in place of own processes; twice `workers` members are kept in flight.
    observer : callable, optional
        Called with the run after each member has been stored.

    Returns
    -------
    Run
        The run as it stands at the end.

    Raises
    ------
    RecordError
        If the folder holds another scene, naming the first key that differs, or another process writes to it.
    OSError
        If the disk refuses; what was stored stays.
    KeyboardInterrupt
        After Ctrl-C or SIGTERM, within a second; what was stored stays.
    TypeError, ValueError
        Naming the argument, before any work.
    """
    if isinstance(workers, bool) or int(workers) != workers or workers < 1:
        raise ValueError(f"workers = {workers!r} must be a whole number ≥ 1")
    goals = _checked_goals(dict(scene.ensemble.until) if until is None else until)
    scene = replace(
        scene,
        ensemble=replace(
            scene.ensemble,
            seed=scene.ensemble.seed if seed is None else seed,
            max_realizations=scene.ensemble.max_realizations if max_realizations is None else max_realizations,
            until=tuple(goals.items()),
        ),
    )
    place = Path(folder)
    numerics = settled(scene, place) if numerics is None else numerics
    _prepare(place, scene, numerics)
    with stopped_by_signals() as check, writing(place):
        describe(place, _description(scene, numerics), scene)
        sweep(place)
        result = open_run(place)
        tasks = Tasks(scene, numerics, place, result, check)
        with workforce(workers, executor) as pool:
            tasks.complete(pool, workers, observer)
    return result


def settled(scene: Scene, place: Path) -> Numerics:
    """Return the numerics that a run in a folder goes on with, or a plan where there is none.

    A plan depends on when the run is to stop; going on for longer must not make it another run.
    """
    if not (place / "run.json").exists():
        return plan(scene)
    there = read_description(place)
    try:
        numerics = Numerics.from_dict(there["numerics"])
        reasons = tuple(Reason(*words) for words in there["reasons"])
    except (KeyError, TypeError, ValueError) as error:
        raise RecordError(f"{place} cannot be opened: {error}") from error
    kept = scene.numerics.keep_fields
    return replace(numerics, keep_fields=numerics.keep_fields if kept is None else kept, reasons=reasons)


def _checked_goals(until: dict[str, float]) -> dict[str, float]:
    for name, goal in until.items():
        if name not in OBSERVABLES:
            raise ValueError(f"until = {name!r} is no observable; choose among {', '.join(OBSERVABLES)}")
        if not 0.0 < goal < 1.0:
            raise ValueError(f"until: {name} = {goal!r} must lie between 0 and 1; write 0.01 for 1 %")
    return until


def _prepare(place: Path, scene: Scene, numerics: Numerics) -> None:
    """Make the folder, or see that it holds this very scene."""
    if place.exists() and not place.is_dir():
        raise RecordError(f"{place} is a file; name a folder for the run")
    if not (place / "run.json").exists():
        if place.exists() and any(place.iterdir()):
            raise RecordError(f"{place} holds other files; name a new folder for the run")
        place.mkdir(parents=True, exist_ok=True)
        return
    there, wanted = read_description(place), _description(scene, numerics)
    for part in ("scene", "numerics"):
        for key in dict.fromkeys((*there[part], *wanted[part])):
            old, new = there[part].get(key), wanted[part].get(key)
            if old != new and key != "keep_fields":
                raise RecordError(
                    f"{place} holds another scene: {key} is {old} there and {new} here; name another folder, or give "
                    f"the scene as it was"
                )


def _description(scene: Scene, numerics: Numerics) -> dict[str, Any]:
    """What run.json says: all that the run is, as JSON values."""
    return {
        "format_version": FORMAT,
        "scene": scene.identity(),
        "numerics": numerics.to_dict(),
        "seed": scene.ensemble.seed,
        "until": dict(scene.ensemble.until),
        "max_realizations": scene.ensemble.max_realizations,
        "heat_partition": analytic.heat_partition(scene).tolist(),
        "reasons": [list(reason) for reason in numerics.reasons],
        "versions": versions(),
    }


__all__ = ["Realization", "level_spectrum", "realize", "run", "settled"]
