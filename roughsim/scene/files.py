"""Reading scene files: bundled ones by name, others by path, and the tables C(q) that they name."""

import os
import re
import tomllib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from roughsim.scene.changes import with_changes
from roughsim.scene.model import Scene
from roughsim.scene.scans import ScanOptions, measured_psd, psd_of_profile
from roughsim.scene.schema import SceneError, as_written, is_list
from roughsim.scene.sections import ROUGHNESS_KEYS
from roughsim.scene.spellings import nearest, with_decimal_point
from roughsim.show.remarks import warn_of
from roughsim.show.text import plain

if TYPE_CHECKING:
    from roughsim.surface.topography.reading import Profile, Topography

_MAX_BYTES = 64 * 1024
_FEW_ROWS = 6  # of a table C(q) that a text for people shows
_MAX_TABLE_BYTES = 1024 * 1024
SceneSource = (
    str | os.PathLike[str] | Mapping[str, Any]
)  # bundled name, path, or content of a scene
SceneLike = Scene | SceneSource
Scans = dict[str, "list[tuple[Path, Topography | Profile]]"]
BLANK = "blank"  # the form to fill in: every key, commented out; it is no scene by itself


def bundled_scenes() -> tuple[str, ...]:
    """Return the names of the scenes that come with roughsim, sorted."""
    entries = resources.files("roughsim.scenes").iterdir()
    names = {entry.name.removesuffix(".toml") for entry in entries if entry.name.endswith(".toml")}
    return tuple(sorted(names - {BLANK}))


def scene_text(name: str) -> str:
    """Return the text of a bundled scene or of the form "blank", comments included; SceneError for another name."""
    if name not in (*bundled_scenes(), BLANK):
        near, names = nearest(str(name), bundled_scenes()), ", ".join(bundled_scenes())
        hint = f'did you mean "{near}"? ' if near else ""
        raise SceneError(
            f"scene {plain(as_written(str(name)))} is not bundled; {hint}bundled are {names}; a path ends in .toml"
        )
    return (resources.files("roughsim.scenes") / f"{name}.toml").read_text(encoding="utf-8")


def new(name: str | None = None, path: str | os.PathLike[str] | None = None) -> str:
    """Return the text of a bundled scene to start from.

    Parameters
    ----------
    name : str, optional
        Of a bundled scene, or "blank", a form with every key. Default: the names of all, a line each, are returned.
    path : path, optional
        Of a new file to write the text to, too.

    Returns
    -------
    str
        The text of a scene file.

    Raises
    ------
    SceneError
        If there is no such scene.
    FileExistsError
        If the file exists.
    """
    if name is None:
        return "\n".join((*bundled_scenes(), BLANK))
    text = scene_text(name)
    if path is not None:
        with open(path, "x", encoding="utf-8") as file:
            file.write(text)
    return text


def load_scene(name_or_path: SceneSource, changes: Mapping[str, Any] | None = None) -> Scene:
    """Return a scene from the name of a bundled one, from a file, or from the content of a file.

    A `SceneWarning` names each number that is probably a slip.

    Parameters
    ----------
    name_or_path : str, path or mapping
        A name such as "steel-1.2GPa", or the path of a .toml file of at most 64 KiB. Paths inside the file are
        relative to its folder. Or the sections themselves, as {"surface": {...}, "body": {...}, "sliding": {...}};
        paths are then relative to the current directory.
    changes : mapping, optional
        Values of keys that replace those in the file: {"sliding.nominal_pressure": "5 MPa"}. None removes a key.

    Raises
    ------
    SceneError
        One line with the file, the key, its value, the limit and advice.
    FileNotFoundError
        If a file does not exist.
    """
    scene = _loaded(name_or_path, changes)
    warn_of(scene.remarks)
    return scene


def _loaded(name_or_path: SceneSource, changes: Mapping[str, Any] | None) -> Scene:
    """Return a scene as `load_scene`, without its warnings."""
    content, source, folder = scene_content(name_or_path)
    return scene_of(content, changes or {}, source, folder)


def as_scene(scene: SceneLike, changes: Mapping[str, Any] | None = None) -> Scene:
    """Return a scene as it is, or load it by name, path or content, with changes; errors as of `load_scene`."""
    if not isinstance(scene, Scene):
        return _loaded(scene, changes)
    return _loaded(scene.content(), changes) if changes else scene


def with_map(
    scene: SceneLike, changes: Mapping[str, Any] | None = None
) -> "tuple[Scene, Topography | None]":
    """Return a scene as `as_scene`, and its map, if files name one, of its only rough face; errors as `load_scene`."""
    if isinstance(scene, Scene):
        return as_scene(scene, changes), None
    content, source, folder = scene_content(scene)
    scans: Scans = {}
    loaded = scene_of(content, changes or {}, source, folder, scans)
    found = [scan for several in scans.values() for _, scan in several]
    alone = len(found) == len(loaded.faces) == 1 and found[0].heights.ndim == 2
    return loaded, cast("Topography", found[0]) if alone else None


def scene_content(name_or_path: SceneSource) -> tuple[dict[str, Any], str, Path | None]:
    """Return the content of a scene file, its name in errors, and the folder of its relative paths."""
    if isinstance(name_or_path, Mapping):
        return dict(name_or_path), "scene", Path()
    if not isinstance(name_or_path, (str, os.PathLike)):
        raise TypeError(
            f"name_or_path = {name_or_path!r} must be the name of a bundled scene, a path or a mapping"
        )
    name = os.fspath(name_or_path)
    looks_like_a_path = (
        not isinstance(name_or_path, str) or name.endswith(".toml") or os.sep in name or "/" in name
    )
    if looks_like_a_path or (name not in bundled_scenes() and os.path.exists(name)):
        path = Path(name)
        text, folder = read_text(path, "scene file", _MAX_BYTES), path.parent
    else:
        text, folder = scene_text(name), Path()
    with errors_named(name):
        return toml_content(text), name, folder


def parse_scene(text: str, *, source: str = "scene", folder: Path | None = None) -> Scene:
    """Return the scene written in `text`; a SceneError begins with `source`.

    Files that the scene names lie in `folder`; without it, none may be named.
    """
    with errors_named(source):
        content = toml_content(text)
    return scene_of(content, {}, source, folder)


def scene_of(
    content: Mapping[str, Any],
    changes: Mapping[str, Any],
    source: str,
    folder: Path | None,
    scans: Scans | None = None,
) -> Scene:
    """Return the scene of a content with changes; a SceneError begins with `source`.

    The scans that were read are added to `scans`, by the section of their face.
    """
    with errors_named(source):
        return Scene(**_with_tables(with_changes(content, changes), folder, scans))


def load_map(
    name_or_path: SceneSource, changes: Mapping[str, Any] | None = None
) -> "tuple[Scene, list[Topography]]":
    """Return a scene and its maps: of [surface], and of [counterface] if that names one too.

    SceneError if [surface] names no map, or a face several.
    """
    content, source, folder = scene_content(name_or_path)
    scans: Scans = {}
    scene = scene_of(content, changes or {}, source, folder, scans)
    maps = []
    for name in ("surface", *(["counterface"] if scans.get("counterface") else [])):
        found = scans.get(name, [])
        if len(found) != 1:
            count = f"names {len(found)} maps" if found else "names no map"
            raise SceneError(
                f'{source}: [{name}] {count}; to press one, write topography = "scan.x3p"'
            )
        path, scan = found[0]
        if scan.heights.ndim != 2:
            raise SceneError(
                f"{source}: {path} is a line scan, of which there is C(q), but no map to press; use run"
            )
        maps.append(cast("Topography", scan))
        if scene.sections_of_faces[name].psd_directions:  # the map itself has them
            scene = scene.with_(f"{name}.psd_directions", None)
    return scene, maps


@contextmanager
def errors_named(source: str) -> Iterator[None]:
    """Let a SceneError begin with the name of its source."""
    try:
        yield
    except SceneError as error:
        raise SceneError(plain(f"{source}: {error}")) from None


def toml_content(text: str) -> dict[str, Any]:
    """Return the content of a text in TOML; SceneError with the wrong line."""
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise SceneError("nested too deeply for a scene; sections and lists are enough") from None
    except ValueError as error:
        message = str(error)
    long = re.search(r"([^\s=\[,{]*)[ \t]*=[^=\n]*[0-9_]{4300}", text)
    if "integer string conversion" in message and long is not None:
        message = f"{as_written(long[1])} holds a number of thousands of digits; write it like 1e9"
    lines, match = text.splitlines(), re.search(r"at line (\d+)", message)
    if match is not None and int(match[1]) <= len(lines):
        line = lines[int(match[1]) - 1].strip()
        message += f": {as_written(line)}"
        # a number, then a letter, and no quotes: a unit
        if re.search(r"[=\[,]\s*[-+.0-9eE_]+\s*(?:[A-Za-zµμ%]|1\s*/)[^\"']*$", line.split("#")[0]):
            message += '; a value with a unit needs quotes, as in speed = "35 m/s"'
        message += with_decimal_point(line.split("#")[0].partition("=")[2])
    raise SceneError(f"not valid TOML: {message}")


def read_text(path: Path, what: str, limit: int) -> str:
    """Return the text of a regular file of at most `limit` bytes; SceneError or FileNotFoundError otherwise."""
    name = plain(str(path))
    try:
        if not path.exists():
            near = nearest(path.name.removesuffix(".toml"), bundled_scenes())
            hint = f', or use the bundled scene "{near}"' if near else ""
            raise FileNotFoundError(f"{what} {name} does not exist; check the path{hint}")
        if not path.is_file():
            hint = (
                f"; {name}/scene.toml is the scene of this run"
                if (path / "scene.toml").is_file()
                else ""
            )
            raise SceneError(
                f"{what} {name} is a folder or a device; give the path of a file{hint}"
            )
        with path.open("rb") as file:
            data = file.read(limit + 1)
    except (FileNotFoundError, SceneError):
        raise
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise SceneError(
            f"{what} {name} cannot be read ({reason}); check the path and its permissions"
        ) from None
    if len(data) > limit:
        raise SceneError(
            f"{what} {name} is larger than the limit of {limit // 1024} KiB; is it the right file?"
        )
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise SceneError(
            f"{what} {name} is not UTF-8 text (byte {error.start}); is it the right file?"
        ) from None


def _stored_psd(paths: list[Path], *_: Any) -> dict[str, Any]:
    """Read a text file of two columns, q in rad/m and C in m⁴; return the key of a section that gives it as a table."""
    (path,) = paths
    text = read_text(path, "the table", _MAX_TABLE_BYTES)
    rows: list[list[float]] = []
    for number, line in enumerate(text.splitlines(), start=1):
        entries = re.split(r"[,;\s]+", line.split("#")[0].strip())
        named = not rows and not re.match(r"[-+.0-9]", entries[0])  # names of the columns
        if named or entries == [""]:
            continue
        try:
            q, psd = map(float, entries)
        except ValueError:
            fault = f"{as_written(line)} must be two numbers, q in rad/m and C in m⁴"
            raise SceneError(f"line {number}: {fault}") from None
        rows.append([q, psd])
    return {"psd": rows}


# key → the reader of its files, their content, an example, and the keys that it excludes
_FILES: dict[str, tuple[Callable[..., dict[str, Any]], str, str, tuple[str, ...]]] = {
    "topography": (measured_psd, "map", "scan.x3p", (*ROUGHNESS_KEYS, "psd_file")),
    "psd_file": (_stored_psd, "table", "psd.csv", ("psd", "psd_error")),
}


def _with_tables(
    content: dict[str, Any], folder: Path | None, scans: Scans | None = None
) -> dict[str, Any]:
    """Return the content with each `psd_file` and `topography` replaced by the table C(q) that the files hold."""
    result = dict(content)
    for name in ("surface", "counterface"):
        section = result.get(name)
        if not isinstance(section, dict):
            continue
        for key in _FILES:
            if key in section:
                found = None if scans is None else scans.setdefault(name, [])
                section = _with_table(name, key, section, folder, found)
        if extra := [key for key in ScanOptions.known_keys() if key in section]:
            raise SceneError(f"{name}.{extra[0]} goes with topography only; remove it")
        if section.get("psd_convention") == "profile" and "psd" in section:
            section = psd_of_profile(name, section)
        result[name] = section
    return result


def _with_table(
    name: str,
    key: str,
    section: dict[str, Any],
    folder: Path | None,
    found: "list[tuple[Path, Topography | Profile]] | None",
) -> dict[str, Any]:
    """Return a section with the key of its files replaced by the table C(q) that they hold."""
    read, what, example, others = _FILES[key]
    excluded = next((other for other in section if other in others), None)
    if excluded is not None:
        raise SceneError(
            f"{name}.{excluded} does not go with {name}.{key}, whose {what} fixes C(q); remove one"
        )
    paths = section[key] if key == "topography" and is_list(section[key]) else [section[key]]
    setting = f"{name}.{key} = {as_written(section[key])}"
    if not paths or not all(isinstance(path, str) and path for path in paths):
        raise SceneError(f'{setting} must be the path of a file, for example "{example}"')
    if len(set(paths)) < len(paths):
        raise SceneError(f"{setting} names a file twice; a scan counts once")
    if folder is None:
        raise SceneError(
            f"{setting} needs a scene file to lie beside; write the table as psd = [[q, C], ...]"
        )
    try:
        table = read([folder / path for path in paths], section, found)
    except (OSError, ValueError, ImportError) as error:
        raise SceneError(f"{setting}: {error}") from None
    used = {key, *ScanOptions.known_keys()} if key == "topography" else {key}
    return {other: value for other, value in section.items() if other not in used} | table


def with_short_tables(text: str) -> str:
    """Return the text of a scene file for people to read: long tables C(q) have their first and last rows only."""

    def shortened(match: re.Match[str]) -> str:
        rows, half = match[1].splitlines(keepends=True), _FEW_ROWS // 2
        if len(rows) <= _FEW_ROWS:
            return match[1]
        return "".join(
            [
                *rows[:half],
                f"# … {len(rows) - 2 * half} rows more in scene.toml of the run …\n",
                *rows[-half:],
            ]
        )

    return re.sub(r"((?:^\[[^\[\]\n]*\],\n)+)", shortened, text, flags=re.MULTILINE)
