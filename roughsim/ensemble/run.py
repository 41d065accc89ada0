"""`run`: compute an ensemble into a folder.

A member is one realization of one level, named by (level, index). Its random stream is SeedSequence(seed,
spawn_key=(stream, index)), so it has the same bits in any process, at any time. The number of members of each level
follows from the members alone. So any number of processes may work on one run.
"""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import AbstractContextManager, nullcontext, suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughsim import prediction
from roughsim.ensemble.executors import Workers
from roughsim.ensemble.map_beside import press_beside
from roughsim.ensemble.sources import Source
from roughsim.ensemble.tasks import Tasks, source_of
from roughsim.errors import RecordError
from roughsim.pipeline import versions
from roughsim.planning.limits import judge
from roughsim.planning.plan import largest_member, numerics_of
from roughsim.planning.realization import scene_of
from roughsim.results.description import RunDescription, content_of, folder_state, read_description
from roughsim.results.folder import unread_run
from roughsim.results.run import Run
from roughsim.scene import Scene, SceneLike
from roughsim.scene.checks import check_ends, check_levels
from roughsim.scene.ensemble import TARGET
from roughsim.scene.files import with_map
from roughsim.scene.numerics import Numerics
from roughsim.show.remarks import warn_of
from roughsim.store.claims import Claims
from roughsim.store.saving import merge, remove_unfinished

if TYPE_CHECKING:
    from roughsim.ensemble.progress import Progress


def run(  # noqa: PLR0913  (each is an option)
    scene: SceneLike,
    folder: str | Path,
    *,
    changes: Mapping[str, Any] | None = None,
    numerics: Numerics | None = None,
    seed: int | None = None,
    target_error: float | str | None = None,
    until: Mapping[str, float | str] | None = None,
    max_realizations: int | None = None,
    realizations: int | None = None,
    workers: int | None = 1,
    executor: Executor | None = None,
    observer: Callable[[Run], None] | None = None,
    progress: bool = True,
) -> Run:
    """Compute an ensemble into a folder, or resume it.

    A `SceneWarning` names each number beyond the model, and each assumption that is easily missed, before any work.

    Parameters
    ----------
    scene : Scene, str, path or dict
        Scene to compute, or an argument of `load_scene`.
    folder : str or Path
        Run folder; made if it does not exist. The same scene, numerics and seed resume it. Several processes may work
        on one run, also on different machines: each takes members that no other computes.
    changes : mapping, optional
        Other values of some keys of the scene, as for `load_scene`.
    numerics : Numerics, optional
        Default: stored in the folder, else from `plan`.
    seed : int, optional
        Default: the seed of the scene.
    target_error : float or str, optional
        Relative total error of T_flash, 95 %, at which to stop, at the worst speed, such as 0.02 or "2 %": short for
        ``until={"flash_temperature": target_error}``.
    until : mapping of str to float or str, optional
        Relative total error, 95 %, of each named observable at which to stop, at the worst speed; default: from the
        scene. It is checked after rounds of members. A run that cannot reach it ends, too, and states the reason.
    max_realizations : int, optional
        Largest number of members of each level; default: from the scene. Each of several processes stops by its own
        `until` and `max_realizations`; run.json has the values of the process that started last.
    realizations : int, optional
        Members of each lowest level, in place of `until` and `max_realizations`; default: from the scene. Higher levels
        have as many members as go best with them. A larger number later continues the run.
    workers : int, optional
        Processes, with this one where members are short. None: as many as it has cores, once more than 3 s are
        left. The number is reduced, with a warning, to use at most 80 % of the available memory. A script with several
        workers needs ``if __name__ == "__main__":``; a notebook does not.
    executor : concurrent.futures.Executor, optional
        Used in place of own processes; twice `workers` members are submitted at a time. Their memory is not checked.
    observer : callable, optional
        Called with the run after new members, in place of `progress`.
    progress : bool
        Show the progress on the standard error: a bar on a terminal, else a line for each round, and after 2 s, 4 s …
        60 s without one. A run without a second round that takes less than 2 s writes nothing.

    Returns
    -------
    Run
        The run at the end.

    Raises
    ------
    RecordError
        If the folder holds another scene, naming the first key that differs.
    OSError
        If the disk refuses, or a file of members cannot be read now; stored members stay.
    RuntimeError
        If workers or the scheduler of an executor die again and again, or the script of the call lacks
        ``if __name__ == "__main__":``.
    KeyboardInterrupt
        After Ctrl-C, SIGTERM, SIGHUP or SIGXCPU, within a second; stored members stay.
    ResolutionError
        If a member of the first round takes more than 80 % of the available memory, before any work; if one of a later
        round does, when the round begins: stored members stay.
    TypeError, ValueError
        Naming the argument, before any work.
    """
    allowed = Workers(workers, executor)
    if target_error is not None:
        if until is not None:
            raise ValueError(
                f"target_error = {target_error} and until = {until} are both given; give one of them"
            )
        until = {"flash_temperature": TARGET(target_error, "target_error")}
    ends = {"until": until, "max_realizations": max_realizations}
    given: dict[str, Any] = {"seed": seed, "realizations": realizations, **ends}
    ensemble = {f"ensemble.{key}": value for key, value in given.items() if value is not None}
    scene, measured = with_map(scene, {**(changes or {}), **ensemble})
    check_ends(scene.ensemble, ends)
    folder = Path(folder)
    with allowed, shown(progress and observer is None, "planning") as bar:
        if numerics is not None:  # before a folder is made
            check_levels(scene, numerics.levels)
            if folder_state(folder) == "free":
                allowed.fit(*largest_member(scene, numerics), numerics.threads)
        numerics = begin(scene, folder, numerics)
        warn_of(judge(scene, numerics).remarks)
        began = None if bar is None else bar.update
        begun = [(scene, numerics, folder)]
        (result,) = complete(begun, allowed, observer or began, began=began)
        press_beside(result, measured)
        return result


def shown(wanted: bool, text: str) -> "AbstractContextManager[Progress | None]":
    """Return the progress to show, with its first text, or nothing."""
    if not wanted:
        return nullcontext()
    from roughsim.ensemble.progress import Progress  # rich is slow to import

    return Progress(text)


def complete(
    begun: Sequence[tuple[Scene, Numerics, Path]],
    workers: Workers,
    observer: Callable[[Run], None] | None = None,
    *,
    claimed_in: Path | None = None,
    source: Callable[[Run, int], Source] = source_of,
    began: Callable[[Run], None] | None = None,
) -> list[Run]:
    """Compute the missing members of runs with the same levels and seed; errors as `run`.

    `claimed_in` is the folder of the claims, by default the first run. `source` returns the source of a level. `began`
    is called with each run before its members are computed.
    """
    runs = []
    with Claims(claimed_in or begun[0][2].absolute()) as claims:
        for scene, numerics, folder in begun:
            run = unread_run(folder, "redo", scene_of(scene, numerics))
            run.until = scene.ensemble.ends  # scene.toml may have the targets of another process
            run.max_realizations = scene.ensemble.most
            run.refresh()
            if began is not None:
                began(run)
            runs.append(run)
        Tasks(runs, claims, observer, source).complete(workers)
    for run in runs:
        if claims.was_last:
            remove_unfinished(run.folder)
        if claims.was_last or claimed_in:  # the last process of a study may have left other runs
            with suppress(OSError):  # on a full disk the parts stay
                merge(run.folder, claims.name, run.members.all_read)
    return runs


def begin(
    scene: Scene,
    folder: Path,
    numerics: Numerics | None = None,
    *,
    press: Mapping[str, str] | None = None,
) -> Numerics:
    """Begin a run in a folder, or check the scene of an existing run; return the numerics of the run.

    `press` is of a pressed map, as in `RunDescription`. RecordError, before anything is planned, if the folder holds
    other files, another kind of run or another scene, naming the first key that differs.
    """
    prediction.background(scene)  # refuses a duration that is too short for a skin
    state = folder_state(folder)
    if state == "foreign":
        raise RecordError(f"{folder} {content_of(folder)}; name a new folder for the run")
    if state == "free":
        planned = numerics_of(scene) if numerics is None else numerics
        computed = scene_of(scene, planned)
        description = RunDescription(computed.identity(), planned, versions(), press or {})
        with suppress(FileExistsError):  # another process was faster: its numerics count
            description.write(folder, computed, first=True)
    stored = read_description(folder)
    if numerics is None:
        keep = scene.numerics.keep_fields
        numerics = stored.numerics if keep is None else replace(stored.numerics, keep_fields=keep)
    computed = scene_of(scene, numerics)
    # versions and reasons may differ between processes: the first ones stay
    with_reasons = replace(numerics, reasons=stored.numerics.reasons)
    description = RunDescription(computed.identity(), with_reasons, stored.versions, press or {})
    description.refuse_other(folder, stored)
    description.write(folder, computed)
    return numerics
