"""`study`: the scenes of a grid of values, each computed into an ordinary run folder.

Points with the same roughness have the same levels and the same random surfaces. One member of all of them is one unit
of work: its surface is drawn once, and points with the same contact, as with other speeds or another friction, share
it. Every member has the bits that its scene has when it is run alone with these numerics.
"""

import json
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import Executor
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from roughsim import prediction
from roughsim.ensemble.executors import Workers
from roughsim.ensemble.run import begin, complete
from roughsim.planning.limits import judge
from roughsim.planning.plan import numerics_of
from roughsim.planning.sliding import with_common_slide
from roughsim.results.description import folder_state, read_description
from roughsim.results.run import Run
from roughsim.scene import Scene, SceneError, SceneLike
from roughsim.scene.checks import check_ends
from roughsim.scene.ensemble import TARGET
from roughsim.scene.files import scene_of
from roughsim.scene.numerics import Numerics
from roughsim.scene.sections import ROUGHNESS_KEYS
from roughsim.show.remarks import Remark, of_several, warn_of
from roughsim.store.claims import PLAN, Claims
from roughsim.store.disk import make_folder
from roughsim.store.saving import listed
from roughsim.studies.folder import base_scene, describe, refuse_exchanged, refuse_other, write
from roughsim.studies.results import LATER
from roughsim.studies.study import Study
from roughsim.studies.vary import Axis, points_of, read_axes

_HARDEST = 1e30  # Pa, in place of the infinite hardness of elastic contact
PAUSE = 0.2  # s between two looks whether another process has planned
# keys of a scene that do not concern its contact; friction does through the pressure at which the contact yields
_OF_BODIES = ("conductivity", "density", "heat_capacity", "skin", "heat_depth", "temperature")
_OF_SLIDING = (
    "friction_coefficient",
    "junction_growth",
    "speed",
    "heat_partition",
    "duration",
    "contact_radius",
    "track_radius",
)
_HEAT_KEYS = (*_OF_BODIES, *_OF_SLIDING)


class PointRun(NamedTuple):
    """The run of a point: its scene with the target of the study, its numerics, and its folder."""

    scene: Scene
    numerics: Numerics
    folder: Path


def study(
    scene: SceneLike,
    *,
    vary: Mapping[Any, Any],
    folder: str | Path,
    target_error: float | str | None = None,
    workers: int | None = 1,
    executor: Executor | None = None,
    observer: Callable[[Run], None] | None = None,
    progress: bool = True,
) -> Study:
    """Compute a scene for all combinations of some values, or go on with the study in a folder.

    Parameters
    ----------
    scene : Scene, str, path or dict
        Scene to vary, or an argument of `load_scene`.
    vary : mapping
        Keys of the scene with their values, as {"sliding.nominal_pressure": ["1 MPa", "5 MPa"]}; the grid of all
        combinations is computed. {"logspace": ["1 MPa", "100 MPa", 9]} stands for a list, "a, b" for two keys that
        change together, with a list of pairs. More values may be given later: existing points stay.
    folder : str or Path
        Of the study; made if it does not exist. `folder`/points has a run folder for each point. The same call resumes
        it, and any number of processes may work on it.
    target_error : float or str, optional
        Relative total error of T_flash to reach at each point and speed, such as 0.02 or "2 %"; left out: the scene's
        `until`.
    workers, executor
        As of `roughsim.run`.
    observer : callable, optional
        Called with the run of a point after members of it have been stored, in place of `progress`.
    progress : bool
        As of `roughsim.run`.

    Returns
    -------
    Study
        The study as it stands at the end.

    Raises
    ------
    SceneError
        If a value does not fit its key, or the scene of a point is refused; before any work.
    RecordError
        If the folder holds something else, or a study of another scene or target, or the folder of a point holds
        another scene. A damaged or lost study.json is written again if the points fit.
    TypeError, ValueError, OSError, RuntimeError, KeyboardInterrupt
        As `roughsim.run`.
    """
    allowed = Workers(workers, executor)
    target = None if target_error is None else float(TARGET(target_error, "target_error"))
    axes, scenes = scenes_of(scene, vary)
    check_ends(scenes[""].ensemble, {"target_error": target_error})
    folder = Path(folder)
    description = describe(scenes, axes, target)
    refuse_other(folder, description)
    points = {name: each for name, each in scenes.items() if name}
    bar = None
    if progress and observer is None:
        from roughsim.ensemble.progress import StudyProgress  # rich is slow to import

        bar = StudyProgress(len(points))
        observer = bar.update
    with allowed, bar or nullcontext():
        with planning_alone(folder):
            refuse_other(folder, description)  # which another process may have begun meanwhile
            refuse_exchanged(folder, description)
            if target is not None:
                until = (("flash_temperature", target),)
                points = {
                    n: replace(one, ensemble=replace(one.ensemble, until=until))
                    for n, one in points.items()
                }
            plans = _plans_of(folder, points)
            write(folder, description)  # a plan that is refused leaves nothing behind
            groups = _begin_points(folder, points, plans)
        begun = {one.folder.name: one for group in groups for one in group}
        warn_of(
            of_several(
                {name: judge(one.scene, one.numerics).remarks for name, one in begun.items()}
            )
        )
        for group in groups:
            complete(group, allowed, observer, claimed_in=folder)
    return Study(folder, description)


@contextmanager
def planning_alone(folder: Path) -> Iterator[None]:
    """Wait until no other process plans this study: two plans may differ, and its points would be no pairs."""
    new = not folder.exists()
    make_folder(folder)
    try:
        with Claims(folder) as claims:
            while not claims.take(PLAN):
                time.sleep(PAUSE)
            yield
    finally:
        if new:
            with suppress(OSError):  # it holds a study; it is empty after a refusal
                folder.rmdir()


def scenes_of(
    scene: SceneLike, vary: Mapping[Any, Any]
) -> tuple[tuple[Axis, ...], dict[str, Scene]]:
    """Return the axes, and the scenes by the names of their points; "" is the base scene."""
    content, source, folder = base_scene(scene)
    axes = read_axes(vary)
    scenes = {"": scene if isinstance(scene, Scene) else scene_of(content, {}, source, folder)}
    for point in points_of(axes):
        varied = prediction.computed(
            scene_of(content, point.values, f"{source}, {point.name}", folder)
        )
        title = f"{scenes[''].title}: {point.name}" if scenes[""].title else point.name
        scenes[point.name] = replace(varied, title=title[:200])
    identities: dict[str, str] = {}
    for name, each in scenes.items():
        other = (
            identities.setdefault(json.dumps(each.identity(), sort_keys=True), name)
            if name
            else name
        )
        if other != name:
            raise SceneError(
                f"the points {other} and {name} are the same scene: no number of a member depends on their difference"
            )
    return axes, scenes


def families_of(scenes: dict[str, Scene]) -> dict[str, dict[str, Scene]]:
    """Return the scenes by family and name; scenes of a family can have the same levels and surfaces."""
    families: dict[str, dict[str, Scene]] = {}
    for name, scene in scenes.items():
        families.setdefault(family(scene), {})[name] = scene
    return families


def _begun_of(folder: Path, names: Iterable[str]) -> list[str]:
    """Return the names of the points with a run."""
    return [name for name in names if folder_state(folder / "points" / name) == "run"]


def _plans_of(folder: Path, scenes: dict[str, Scene]) -> dict[str, Numerics]:
    """Plan each family without a begun point, for its median load; write nothing.

    Fields are kept only if the scene sets their number: maps are recomputed for display.
    """
    plans = {}
    for key, members in families_of(scenes).items():
        if there := _begun_of(folder, members):
            _refuse_later_slides(
                folder, there[0], {name: members[name] for name in members.keys() - there}
            )
            continue
        loads = {
            name: scene.sliding.nominal_pressure / min(scene.penetration_hardness, _HARDEST)
            for name, scene in members.items()
        }
        middle = members[sorted(loads, key=loads.__getitem__)[len(loads) // 2]]
        planned = with_common_slide(middle, numerics_of(middle), members.values())
        plans[key] = replace(planned, keep_fields=middle.numerics.keep_fields or 0)
    return plans


def _refuse_later_slides(folder: Path, begun: str, later: dict[str, Scene]) -> None:
    """Refuse points whose slides the theory cannot continue from the distance that was planned for others."""
    numerics = read_description(folder / "points" / begun).numerics
    if numerics.slide is None:
        return
    for name, scene in sorted(later.items()):
        try:
            prediction.check_continuation(
                scene, numerics.levels[numerics.slide].followed, numerics.lengths[0]
            )
        except ValueError as error:
            raise SceneError(
                f"{name}: {error}; or name another folder, as {folder} was planned without it"
            ) from None


def _begin_points(
    folder: Path, scenes: dict[str, Scene], plans: dict[str, Numerics]
) -> list[list[PointRun]]:
    """Begin the run of each point, or check an existing one; return groups with the same levels.

    `plans` as of `_plans_of`. A point added later has the numerics of its family.
    """
    groups: dict[str, list[PointRun]] = {}
    for key, members in families_of(scenes).items():
        paths = {name: folder / "points" / name for name in members}
        there = _begun_of(folder, members)
        numerics = plans.get(key)
        if numerics is None:
            numerics = begin(members[there[0]], paths[there[0]])
            at_work = any(listed(paths[name]) for name in there)
            if (
                at_work and not members[there[0]].numerics.levels
            ):  # else an interrupted start, or levels of the scene
                why = "the point came later, to others with the same roughness"
                reason = Remark("choice", LATER, why, "as planned before")
                others = (reason for reason in numerics.reasons if reason.quantity != LATER)
                numerics = replace(numerics, reasons=(reason, *others))
        for name, scene in members.items():
            own = begin(scene, paths[name], None if name in there else numerics)
            same_levels = json.dumps(own.to_dict() | {"keep_fields": None}, sort_keys=True)
            groups.setdefault(key + same_levels, []).append(PointRun(scene, own, paths[name]))
    return [
        sorted(group, key=lambda one: (_contact_keys(one.scene), one.folder.name))
        for group in groups.values()
    ]


def family(scene: Scene) -> str:
    """Return the common keys of scenes with the same levels and surfaces, as text."""
    keys = {
        f"{face}.{key}" for face in ("surface", "counterface") for key in (*ROUGHNESS_KEYS, "like")
    }
    keys |= {"ensemble.seed", "sliding.history"}
    identity = {
        key: value
        for key, value in scene.identity().items()
        if key in keys or key.startswith("numerics.")
    }
    return json.dumps([identity, scene.elastic], sort_keys=True)


def _contact_keys(scene: Scene) -> str:
    """Return the keys that determine the contact of a scene, as text that sorts like surfaces side by side."""
    identity = {
        key: value
        for key, value in scene.identity().items()
        if key.rpartition(".")[2] not in _HEAT_KEYS
    }
    load = identity.pop("sliding.nominal_pressure")
    return f"{json.dumps(identity, sort_keys=True)} {load:.17e} {scene.penetration_hardness:.17e}"
