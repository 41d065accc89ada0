"""The folder of a study: study.json, and the folder of each point, an ordinary run, in points/.

scene.toml is the scene that all points change, for people; study.json holds it, too. A folder may come from elsewhere,
so nothing in it is trusted.
"""

import json
import sys
import warnings
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass
from math import prod
from pathlib import Path
from typing import Any

import roughsim as rs
from roughsim.errors import RecordError
from roughsim.results.description import content_of, folder_state, read_description
from roughsim.scene import Scene, SceneError, SceneLike, parse_scene
from roughsim.scene.files import errors_named, read_text, scene_content, toml_content
from roughsim.scene.schema import SECTIONS
from roughsim.show.table import json_value
from roughsim.store.disk import (
    DamagedError,
    checksum,
    is_temporary,
    place_bytes,
    read_bytes,
    set_aside,
)
from roughsim.store.member_files import check_format
from roughsim.studies.vary import MOST_POINTS, NAME, Axis, Point, points_of

FORMAT = 2  # of study.json
_DESCRIPTION = "study.json"
_MOST_BYTES = 16 << 20  # of study.json
_FILE_BYTES = 1 << 20  # of a study file
_FILE_KEYS = ("scene", "target_error", "vary")


@dataclass(frozen=True, slots=True)
class Description:
    """The content of study.json: the base scene, the axes, and the target for the total error.

    `identities` are checksums of the identities of the scenes of the points, by their names.
    """

    scene: Scene
    axes: tuple[Axis, ...]
    target_error: float | None
    identities: Mapping[str, str]

    @property
    def points(self) -> tuple[Point, ...]:
        """The points of the grid."""
        return points_of(self.axes)


def study_file(path: Path) -> dict[str, Any]:
    """Return scene, vary and target_error of a study file; `scene` is a bundled name, or a path from its folder."""
    text = read_text(path, "study file", _FILE_BYTES)
    with errors_named(str(path)):
        content = toml_content(text)
        for key in content:
            if key not in _FILE_KEYS:
                raise SceneError(
                    f"{key} is not a key of a study; the choice is {', '.join(_FILE_KEYS)}"
                )
        for key in ("scene", "vary"):
            if key not in content:
                raise SceneError(f'{key} is missing; a study has scene = "demo" and a table [vary]')
        if not isinstance(content["scene"], str):
            raise SceneError(
                'scene must be the name of a bundled scene or the path of a file, as in scene = "demo"'
            )
        if isinstance(content["vary"], dict):
            content["vary"] = _with_dotted_keys(content["vary"])
    with suppress(OSError):  # a name that no file can have
        beside = path.parent / content["scene"]
        content["scene"] = beside if beside.is_file() else content["scene"]
    return content


def _with_dotted_keys(vary: dict[str, Any]) -> dict[str, Any]:
    """Return the table [vary] with the keys of a section, as TOML reads them without quotes, as dotted keys."""
    result: dict[str, Any] = {}
    for name, value in vary.items():
        nested = name in SECTIONS and isinstance(value, dict)
        result |= (
            {f"{name}.{key}": entry for key, entry in value.items()} if nested else {name: value}
        )
    return result


def describe(
    scenes: Mapping[str, Scene], axes: tuple[Axis, ...], target_error: float | None
) -> Description:
    """Return the description of a study from the scenes of its points by their names; "" is the base scene."""
    identities = {name: checksum(scene.identity()) for name, scene in scenes.items() if name}
    return Description(scenes[""], axes, target_error, identities)


def write(folder: Path, description: Description) -> None:
    """Write study.json and scene.toml, also with more points; RecordError as `refuse_other`.

    Of several processes that begin at once the first one places study.json, and the others must fit it. A
    damaged study.json is moved into the folder "damaged".
    """
    refuse_other(folder, description)
    (folder / "points").mkdir(parents=True, exist_ok=True)
    path, scene = folder / _DESCRIPTION, description.scene.to_toml()
    content: dict[str, Any] = {
        "format_version": FORMAT,
        "versions": {"roughsim": rs.__version__},
        "target_error": description.target_error,
        "axes": [asdict(axis) for axis in description.axes],
        "scene": scene,
        "identities": dict(description.identities),
    }
    text = json.dumps(content | {"checksum": checksum(content)}, indent=1).encode()
    if _is_damaged(folder):
        _move_aside(path)
    if not path.exists():
        with suppress(FileExistsError):
            place_bytes(path, text, first=True)
    refuse_other(folder, description)  # another process may have been the first
    if path.read_bytes() != text:
        place_bytes(path, text)
    _write_scene(folder / "scene.toml", description.scene)


def _write_scene(path: Path, scene: Scene) -> None:
    """Write scene.toml, which is for people; one of another scene, or a damaged one, is moved aside."""
    text = scene.to_toml().encode()
    if path.is_file():
        there = path.read_bytes()
        if there == text:
            return
        try:
            same = (
                parse_scene(there.decode("utf-8"), source=str(path)).identity() == scene.identity()
            )
        except ValueError:
            same = False
        if not same:
            _move_aside(path)
    place_bytes(path, text)


def _move_aside(path: Path) -> None:
    """Move a damaged file of a study into its folder "damaged", with a warning."""
    kept = set_aside(path, path.parent / "damaged")
    words = f"{path} was damaged: it was moved to {kept}, and is written again from the given study"
    warnings.warn(words, RuntimeWarning, stacklevel=2)


def refuse_other(folder: Path, description: Description) -> None:
    """Refuse a folder with other content than this study, with these points or others: RecordError.

    If study.json is damaged or lost, all points in the folder must belong to this study.
    """
    if folder.is_file():
        raise RecordError(f"{folder} {content_of(folder)}; name a new folder for the study")
    if not (folder / _DESCRIPTION).exists() or _is_damaged(folder):
        _refuse_other_points(folder, description)
        return
    before = read(folder)
    there, here = before.scene.identity(), description.scene.identity()
    for key in there | here:
        if there.get(key) != here.get(key):
            raise RecordError(
                f"{folder} holds a study of another scene: {key} is {there.get(key, 'absent')} there and "
                f"{here.get(key, 'absent')} here; name another folder, or give the scene as it was"
            )
    if before.target_error != description.target_error:
        raise RecordError(
            f"{folder} holds a study with target_error = {before.target_error}, here it is "
            f"{description.target_error}: its levels were planned for that one; name another folder, or give the "
            "target as it was"
        )


def _refuse_other_points(folder: Path, description: Description) -> None:
    """Refuse a folder without a sound study.json, unless it has no points, or only points of this study."""
    if refuse_exchanged(folder, description) or not folder.exists():
        return
    names = {path.name for path in folder.iterdir() if not is_temporary(path.name)}
    begun = {"claims", "damaged", "points", "scene.toml"} if "points" in names else {"claims"}
    points = folder / "points"
    computed = points.is_dir() and any(points.iterdir())
    if not computed and (_DESCRIPTION in names or not names - begun):
        return
    if (folder / _DESCRIPTION).exists() and not _is_damaged(
        folder
    ):  # another process has begun it meanwhile
        refuse_other(folder, description)
    elif computed:
        raise RecordError(
            f"{points} holds other files than points of this study, and {_DESCRIPTION} is damaged or lost; give the "
            "study as it was, or name another folder"
        )
    else:
        raise RecordError(f"{folder} {content_of(folder)}; name a new folder for the study")


def refuse_exchanged(folder: Path, description: Description) -> int:
    """Refuse a study with the folder of another scene at a point; return the number of begun points."""
    places = [(point, folder / "points" / point.name) for point in description.points]
    begun = [(point, place) for point, place in places if folder_state(place) == "run"]
    for point, place in begun:
        refuse_other_scene(place, read_description(place).scene, point, description)
    return len(begun)


def refuse_other_scene(
    place: Path, identity: Mapping[str, Any], point: Point, description: Description
) -> None:
    """Refuse the folder of a point with the run of another scene, as after an exchange of folders: RecordError.

    `identity` is the identity of the scene in the folder.
    """
    if checksum(identity) == description.identities[point.name]:
        return
    varied = json_value(point.values)
    key = next((key for key, value in varied.items() if identity.get(key, value) != value), None)
    differs = (
        "another key of its scene differs"
        if key is None
        else f"{key} is {identity[key]} there, not {varied[key]}"
    )
    raise RecordError(
        f"{place} does not hold the scene of its point: {differs}; give each folder in points/ its own name again, or "
        "move this one away and give the study again, which computes the point again"
    )


def is_study(folder: Path) -> bool:
    """Return whether a folder belongs to a study, also without its study.json."""
    return (folder / _DESCRIPTION).is_file() or (
        (folder / "points").is_dir() and not (folder / "run.json").exists()
    )


def _is_damaged(folder: Path) -> bool:
    """Return whether a folder has a damaged study.json; RecordError or OSError if it cannot be judged."""
    try:
        if (folder / _DESCRIPTION).exists():
            read(folder)
    except DamagedError:
        return True
    return False


def read(folder: Path) -> Description:
    """Return the description of a study; DamagedError if study.json is damaged, RecordError in another folder."""
    path = folder / _DESCRIPTION
    again = (
        f"give the study again, which writes it if the points fit: roughsim study STUDY -o {folder}"
    )
    if not path.exists():
        if is_study(folder):
            raise RecordError(f"{folder} has points, but its {_DESCRIPTION} is lost; {again}")
        raise RecordError(
            f"{folder} is no study: it has no {_DESCRIPTION}; name the folder that `roughsim study` made"
        )
    try:
        content = json.loads(
            read_bytes(path, _MOST_BYTES).decode("utf-8"), parse_constant=_refuse_constant
        )
        check_format(path, int(content["format_version"]), content, FORMAT)
        if content.pop("checksum") != checksum(content):
            raise ValueError("its checksum does not match")
        return _description_of(content, str(path))
    except RecordError:
        raise
    except (
        ValueError,
        LookupError,
        TypeError,
        AttributeError,
        ArithmeticError,
        RecursionError,
    ) as error:
        raise DamagedError(f"{path} is damaged ({error}); {again}") from error


def _description_of(content: dict[str, Any], source: str) -> Description:
    """Return the description from study.json; ValueError, LookupError or another error of Python if damaged."""
    axes = _axes_of(content["axes"])
    target = content["target_error"]
    if target is not None and not 0.0 < float(target) < 1.0:
        raise ValueError(f"target_error = {target} must lie between 0 and 1")
    points = points_of(axes)
    for point in points:
        if not NAME.fullmatch(point.name):
            raise ValueError(f"the point {point.name!r} cannot be the name of a folder")
    identities = {point.name: str(content["identities"][point.name]) for point in points}
    scene = parse_scene(content["scene"], source=source)
    return Description(scene, axes, None if target is None else float(target), identities)


def _axes_of(content: list[dict[str, Any]]) -> tuple[Axis, ...]:
    """Return the axes from study.json; ValueError if they fit no study."""
    axes = tuple(
        Axis(
            tuple(map(str, axis["keys"])), tuple(tuple(map(_frozen, row)) for row in axis["values"])
        )
        for axis in content
    )
    count = prod(len(axis.values) for axis in axes)
    if not 1 <= count <= MOST_POINTS or any(
        len(row) != len(axis.keys) for axis in axes for row in axis.values
    ):
        raise ValueError(f"{count} points, or rows of another length than their keys")
    return axes


def _refuse_constant(word: str) -> None:
    """Refuse NaN and infinity: no study writes them."""
    raise ValueError(f"{word} is no value of a study")


def _frozen(value: Any) -> Any:
    """Return a JSON value with its lists as tuples; ValueError for a number that no float holds."""
    if isinstance(value, (int, float)) and not abs(value) <= sys.float_info.max:
        raise ValueError("a number is beyond the range of floats")
    return tuple(map(_frozen, value)) if isinstance(value, list) else value


def base_scene(scene: SceneLike) -> tuple[dict[str, Any], str, Path | None]:
    """Return the content of a scene file, its name in errors, and the folder of the files that it names."""
    if isinstance(scene, Scene):
        return scene.content(), scene.title or "scene", Path()
    return scene_content(scene)
