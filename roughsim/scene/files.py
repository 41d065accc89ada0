"""Reading scene files: bundled ones by name, others by path, and the tables C(q) that they name."""

from __future__ import annotations

import os
import re
import tomllib
from difflib import get_close_matches
from importlib import resources
from pathlib import Path
from typing import Any

from roughsim.scene.messages import SceneError, as_written
from roughsim.scene.model import Scene
from roughsim.scene.rules import MAX_ROWS, ROUGHNESS_KEYS
from roughsim.show.text import plain

MAX_BYTES = 64 * 1024
BLANK = "blank"  # a form to fill in: every key, commented out; no scene by itself


def bundled_scenes() -> tuple[str, ...]:
    """Return the names of the scenes that come with roughsim, sorted."""
    entries = resources.files("roughsim.scenes").iterdir()
    names = {entry.name.removesuffix(".toml") for entry in entries if entry.name.endswith(".toml")}
    return tuple(sorted(names - {BLANK}))


def scene_text(name: str) -> str:
    """Return the text of a bundled scene, comments included, or of the form to fill in, "blank".

    Raises
    ------
    SceneError
        If there is no bundled scene of that name.
    """
    if name not in (*bundled_scenes(), BLANK):
        near = get_close_matches(str(name).lower(), {n.lower(): n for n in bundled_scenes()}, n=1)
        hint = next((f'did you mean "{n}"? ' for n in bundled_scenes() if [n.lower()] == near), "")
        names = ", ".join(bundled_scenes())
        raise SceneError(
            f"scene {plain(as_written(str(name)))} is not bundled; {hint}bundled are {names}; or give a .toml file"
        )
    return (resources.files("roughsim.scenes") / f"{name}.toml").read_text(encoding="utf-8")


def load_scene(name_or_path: str | os.PathLike[str]) -> Scene:
    """Return a scene from the name of a bundled one or from a file.

    Parameters
    ----------
    name_or_path : str or path
        A name such as "steel-1.2GPa", or the path of a .toml file of at most 64 KiB. Files that it names are looked
        for beside it.

    Raises
    ------
    SceneError
        One line that names the file, the key, its value, the limit and what to do.
    FileNotFoundError
        If a path leads nowhere.
    """
    if not isinstance(name_or_path, (str, os.PathLike)):
        raise TypeError(f"name_or_path = {name_or_path!r} must be the name of a bundled scene or a path")
    name = os.fspath(name_or_path)
    if isinstance(name_or_path, str) and not _is_path(name):
        return parse_scene(scene_text(name), source=name)
    path = Path(name)
    return parse_scene(_text(path, "scene file", MAX_BYTES), source=name, folder=path.parent)


def parse_scene(text: str, *, source: str = "scene", folder: Path | None = None) -> Scene:
    """Return the scene written in `text`.

    Parameters
    ----------
    text : str
        TOML.
    source : str, optional
        What to call the text in an error message.
    folder : Path, optional
        Where the files it names lie; without it, none may be named.

    Raises
    ------
    SceneError
        One line that names `source`, the key, its value, the limit and what to do.
    """
    try:
        content = tomllib.loads(text)
    except RecursionError:
        raise SceneError(_line(source, "nested too deeply for a scene; sections and lists are enough")) from None
    except ValueError as error:
        raise SceneError(_line(source, f"not valid TOML: {_toml_error(text, str(error))}")) from None
    try:
        return Scene(**_with_tables(content, folder))
    except SceneError as error:
        raise SceneError(_line(source, str(error))) from None


def _line(source: str, message: str) -> str:
    return plain(f"{source}: {message}")


def _is_path(name: str) -> bool:
    looks_so = name.endswith(".toml") or os.sep in name or "/" in name
    return looks_so or (name not in bundled_scenes() and _exists(name))


def _exists(name: str) -> bool:
    try:
        return Path(name).exists()
    except (OSError, ValueError):
        return False


def _text(path: Path, what: str, limit: int) -> str:
    """The text of a regular file of at most `limit` bytes."""
    name = plain(str(path))
    try:
        if not path.exists():
            raise FileNotFoundError(f"{what} {name} does not exist; check the path{_bundled_hint(path)}")
        if not path.is_file():
            raise SceneError(f"{what} {name} is a folder or a device; give the path of a file")
        with path.open("rb") as file:
            data = file.read(limit + 1)
    except FileNotFoundError:
        raise
    except (OSError, ValueError) as error:
        if isinstance(error, SceneError):
            raise
        reason = getattr(error, "strerror", None) or str(error)
        raise SceneError(f"{what} {name} cannot be read ({reason}); check the path and its permissions") from None
    if len(data) > limit:
        raise SceneError(f"{what} {name} is larger than the limit of {limit // 1024} KiB; is it the right file?")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise SceneError(f"{what} {name} is not UTF-8 text (byte {error.start}); is it the right file?") from None


def _bundled_hint(path: Path) -> str:
    near = get_close_matches(path.name.removesuffix(".toml"), bundled_scenes(), n=1)
    return f', or use the bundled scene "{near[0]}"' if near else ""


def _toml_error(text: str, message: str) -> str:
    """Tomllib's message with the line it complains about, and a hint where a unit stands without quotes."""
    long = re.search(r"([^\s=\[,{]*)[ \t]*=[^=\n]*[0-9_]{4300}", text)
    if "integer string conversion" in message and long is not None:
        return f"{as_written(long[1])} holds a number of thousands of digits; write it like 1e9"
    match = re.search(r"at line (\d+)", message)
    lines = text.splitlines()
    if match is None or int(match[1]) > len(lines):
        return message
    line = lines[int(match[1]) - 1].strip()
    unquoted = re.search(r"[=\[,]\s*[-+.0-9eE_]+\s*(?:[A-Za-zµμ%]|1\s*/)[^\"']*$", line.split("#")[0])
    hint = '; a value with a unit needs quotes, as in speed = "35 m/s"' if unquoted else ""
    return f"{message}: {as_written(line)}{hint}"


def _with_tables(content: dict[str, Any], folder: Path | None) -> dict[str, Any]:
    """The content with each `psd_file` and `topography` replaced by the table C(q) it holds: files count by content."""
    result = dict(content)
    for name in ("surface", "counterface"):
        section = content.get(name)
        if isinstance(section, dict) and "topography" in section:
            result[name] = _measured(section, name, folder)
        elif isinstance(section, dict) and "psd_file" in section:
            rest = {key: value for key, value in section.items() if key != "psd_file"}
            if "psd" in rest:
                raise SceneError(f"{name}.psd_file and {name}.psd are both given; keep exactly one")
            result[name] = {**rest, "psd": _table(section["psd_file"], f"{name}.psd_file", folder)}
    return result


def _measured(section: dict[str, Any], name: str, folder: Path | None) -> dict[str, Any]:
    """The section with the C(q) of a measured map in place of its `topography`."""
    from roughsim.surface.topography import read_topography

    rest = {key: value for key, value in section.items() if key != "topography"}
    other = next((key for key in rest if key in (*ROUGHNESS_KEYS, "psd_file")), None)
    if other is not None:
        raise SceneError(
            f"{name}.{other} does not go with {name}.topography, whose map fixes C(q); remove one of the two"
        )
    path = _beside(section["topography"], f"{name}.topography", '"scan.x3p"', folder)
    try:
        spectrum = read_topography(path).spectrum
    except (OSError, ValueError, ImportError) as error:
        raise SceneError(f"{name}.topography = {as_written(section['topography'])}: {error}") from None
    rows = [[float(q), float(psd)] for q, psd in zip(spectrum.q, spectrum.psd, strict=True)]
    return {**rest, "psd": rows, "psd_convention": "persson", "psd_source": "scan"}


def _beside(value: Any, key: str, example: str, folder: Path | None) -> Path:
    """The path of a file that a scene names, which lies beside the scene."""
    if not isinstance(value, str) or not value:
        raise SceneError(f"{key} = {as_written(value)} must be the path of a file, for example {example}")
    if folder is None:
        raise SceneError(
            f"{key} = {as_written(value)} needs a scene file to lie beside; write the table as psd = [[q, C], ...]"
        )
    return folder / value


def _table(value: Any, key: str, folder: Path | None) -> list[list[float]]:
    """The rows of a text file of two columns, q in rad/m and C in m⁴."""
    path = _beside(value, key, '"psd.csv"', folder)
    try:
        text = _text(path, "the table", 1024 * 1024)
    except (SceneError, FileNotFoundError) as error:
        raise SceneError(f"{key} = {as_written(value)}: {error}") from None
    lines = [(n, line.split("#")[0].strip()) for n, line in enumerate(text.splitlines(), start=1)]
    lines = [(n, line) for n, line in lines if line]
    if lines and not re.match(r"[-+.0-9]", lines[0][1]):
        lines = lines[1:]  # the names of the columns
    if len(lines) > MAX_ROWS:
        raise SceneError(
            f"{key} = {as_written(value)} has {len(lines)} rows, above the limit of {MAX_ROWS}; average C over bins of "
            "log q"
        )
    return [_row(line, f"{key} = {as_written(value)}, line {n}") for n, line in lines]


def _row(line: str, where: str) -> list[float]:
    try:
        q, psd = (float(entry) for entry in re.split(r"\s*[,;\s]\s*", line))
    except ValueError:
        raise SceneError(f"{where}: {as_written(line)} must be two numbers, q in rad/m and C in m⁴") from None
    return [q, psd]
