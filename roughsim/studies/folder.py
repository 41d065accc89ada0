"""The folder of a study: study.json, scene.toml, and the folder of each point, an ordinary run, in points/.

A folder may come from elsewhere, so nothing in it is trusted.
"""

import json
import sys
from contextlib import suppress
from dataclasses import asdict, dataclass
from math import prod
from pathlib import Path
from typing import Any

from roughsim.errors import RecordError
from roughsim.scene import Scene, SceneError, parse_scene
from roughsim.scene.files import errors_named, read_text, scene_content, toml_content
from roughsim.scene.schema import SECTIONS
from roughsim.store.disk import is_temporary, place_bytes, read_bytes
from roughsim.studies.vary import MOST_POINTS, NAME, Axis, Point, points_of

FORMAT = 1
DESCRIPTION = "study.json"
MOST_BYTES = 16 << 20  # of study.json
FILE_BYTES = 1 << 20  # of a study file
FILE_KEYS = ("scene", "target_error", "vary")


@dataclass(frozen=True, slots=True)
class Description:
    """What study.json holds: the scene that all points change, the axes, and the total error asked for."""

    scene: Scene
    axes: tuple[Axis, ...]
    target_error: float | None

    @property
    def points(self) -> tuple[Point, ...]:
        """The points of the grid."""
        return points_of(self.axes)


def study_file(path: Path) -> dict[str, Any]:
    """Return scene, vary and target_error of a study file; `scene` is a bundled name, or a path from its folder."""
    text = read_text(path, "study file", FILE_BYTES)
    with errors_named(str(path)):
        content = toml_content(text)
        for key in content:
            if key not in FILE_KEYS:
                raise SceneError(f"{key} is not a key of a study; the choice is {', '.join(FILE_KEYS)}")
        for key in ("scene", "vary"):
            if key not in content:
                raise SceneError(f'{key} is missing; a study has scene = "demo" and a table [vary]')
        if not isinstance(content["scene"], str):
            raise SceneError('scene must be the name of a bundled scene or the path of a file, as in scene = "demo"')
        if isinstance(content["vary"], dict):
            content["vary"] = with_dotted_keys(content["vary"])
    with suppress(OSError):  # a name that no file can have
        beside = path.parent / content["scene"]
        content["scene"] = beside if beside.is_file() else content["scene"]
    return content


def with_dotted_keys(vary: dict[str, Any]) -> dict[str, Any]:
    """Return the table [vary] with the keys of a section, as TOML reads them without quotes, as dotted keys."""
    result: dict[str, Any] = {}
    for name, value in vary.items():
        nested = name in SECTIONS and isinstance(value, dict)
        result |= {f"{name}.{key}": entry for key, entry in value.items()} if nested else {name: value}
    return result


def write(folder: Path, description: Description) -> None:
    """Write study.json and scene.toml, or those of more points; RecordError if the folder holds something else."""
    if folder.is_file():
        raise RecordError(f"{folder} is a file; name a folder for the study")
    if (folder / DESCRIPTION).exists():
        there, here = read(folder).scene.identity(), description.scene.identity()
        for key in dict.fromkeys((*there, *here)):
            if there.get(key) != here.get(key):
                raise RecordError(
                    f"{folder} holds a study of another scene: {key} is {there.get(key, 'absent')} there and "
                    f"{here.get(key, 'absent')} here; name another folder, or give the scene as it was"
                )
        if (before := read(folder).target_error) != description.target_error:
            raise RecordError(
                f"{folder} holds a study with target_error = {before}, here it is {description.target_error}: its "
                "levels were planned for that one; name another folder, or give the target as it was"
            )
    elif folder.exists() and not is_beginning(folder):
        raise RecordError(f"{folder} holds other files; name a new folder for the study")
    (folder / "points").mkdir(parents=True, exist_ok=True)
    content = {
        "format_version": FORMAT,
        "target_error": description.target_error,
        "axes": [asdict(axis) for axis in description.axes],
    }
    for name, text in (("scene.toml", description.scene.to_toml()), (DESCRIPTION, json.dumps(content, indent=1))):
        path = folder / name
        if not path.is_file() or path.read_bytes() != text.encode():
            place_bytes(path, text.encode())


def is_beginning(folder: Path) -> bool:
    """Return whether a folder is empty, or has what a process writes before study.json, which others may see."""
    names = {path.name for path in folder.iterdir() if not is_temporary(path.name)}
    points = folder / "points"
    return not names or (names <= {"points", "scene.toml"} and points.is_dir() and not any(points.iterdir()))


def read(folder: Path) -> Description:
    """Return what `write` wrote; RecordError if the folder is no study, or study.json is damaged."""
    path = folder / DESCRIPTION
    if not path.exists():
        raise RecordError(f"{folder} is no study: it has no {DESCRIPTION}; name the folder that `roughsim study` made")
    try:
        content = json.loads(read_bytes(path, MOST_BYTES).decode("utf-8"), parse_constant=refuse_constant)
        version = int(content["format_version"])
        if version > FORMAT:
            raise RecordError(f"{path} has format {version}, above {FORMAT}; update roughsim to read it")
        axes = tuple(
            Axis(tuple(map(str, axis["keys"])), tuple(tuple(map(frozen, row)) for row in axis["values"]))
            for axis in content["axes"]
        )
        count = prod(len(axis.values) for axis in axes)
        if not 1 <= count <= MOST_POINTS or any(len(row) != len(axis.keys) for axis in axes for row in axis.values):
            raise ValueError(f"{count} points, or rows of another length than their keys")
        target = content["target_error"]
        if target is not None and not 0.0 < float(target) < 1.0:
            raise ValueError(f"target_error = {target} must lie between 0 and 1")
        scene = parse_scene(read_bytes(folder / "scene.toml", MOST_BYTES).decode("utf-8"), source=str(folder))
        description = Description(scene, axes, None if target is None else float(target))
        for point in description.points:
            if not NAME.fullmatch(point.name):
                raise ValueError(f"the point {point.name!r} cannot be the name of a folder")
    except RecordError:
        raise
    except (ValueError, LookupError, TypeError, AttributeError, ArithmeticError, RecursionError) as error:
        raise RecordError(f"{path} is damaged ({error}); give the study again to have it anew") from error
    return description


def refuse_constant(word: str) -> None:
    """Refuse NaN and infinity, which no study writes."""
    raise ValueError(f"{word} is no value of a study")


def frozen(value: Any) -> Any:
    """Return a JSON value with its lists as tuples; ValueError for a number that no float holds."""
    if isinstance(value, (int, float)) and not abs(value) <= sys.float_info.max:
        raise ValueError("a number is beyond what a float holds")
    return tuple(map(frozen, value)) if isinstance(value, list) else value


def base_scene(scene: Scene | str | Path | dict[str, Any]) -> tuple[dict[str, Any], str, Path | None]:
    """Return what the file of a scene would hold, what errors call it, and the folder of the files that it names."""
    if isinstance(scene, Scene):
        return toml_content(scene.to_toml()), scene.title or "scene", Path()
    return scene_content(scene)
