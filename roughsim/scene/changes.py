"""Changes of keys of a scene, checked as in its file."""

import tomllib
from collections.abc import Mapping
from copy import deepcopy
from typing import Any

from roughsim.scene.schema import SECTIONS, SceneError, as_written, did_you_mean


def with_changes(content: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return the content of a scene file with other values of some keys, such as "sliding.speed".

    None takes a key, or a whole section, away. SceneError for a name that is no section; all else is checked when the
    scene is made.
    """
    result = deepcopy(dict(content))
    for key, value in changes.items():
        *tables, name = _parts_of(key)
        inside: Any = result
        for depth, table in enumerate(tables):
            inside = inside.setdefault(table, {})
            if not isinstance(inside, dict):
                where, kind = ".".join(tables[: depth + 1]), "table" if depth else "section"
                raise SceneError(
                    f'{as_written(key)} is not a key of a scene: "{where}" is no {kind}'
                )
        if value is None:
            inside.pop(name, None)
        else:
            inside[name] = value
        if tables and not result[tables[0]]:
            del result[tables[0]]  # without any key
    return result


def _parts_of(key: Any) -> list[str]:
    """Return section, key and key within its table, as many as there are; SceneError without a section of a scene."""
    if not isinstance(key, str):
        raise SceneError(
            f'{key!r} must be the name of a key, for example "sliding.nominal_pressure"'
        )
    parts = key.split(".", maxsplit=2)
    names = SECTIONS[""].known_keys()
    if parts[0] not in names:
        homes = [home for home in names if home in SECTIONS and key in SECTIONS[home].known_keys()]
        hint = f'did you mean "{homes[0]}.{key}"?' if homes else did_you_mean(parts[0], names)
        raise SceneError(f"{as_written(key)} is not a key of a scene; {hint}")
    return parts


def read_changes(words: list[str]) -> dict[str, Any]:
    """Return changes written as "sliding.nominal_pressure=5 MPa"; SceneError for another form.

    A value is read as TOML if it is valid TOML (35.0, ["1 m/s", "10 m/s"]), else as a text; without a value the key is
    removed.
    """
    changes: dict[str, Any] = {}
    for word in words:
        key, equals, text = word.partition("=")
        key, text = key.strip(), text.strip()
        if not (equals and key):
            raise SceneError(
                f"--set {as_written(word)} must be a key and a value, as in sliding.nominal_pressure=5MPa"
            )
        if key in changes:
            raise SceneError(f"--set {key} is given twice; keep one of the two")
        try:
            changes[key] = tomllib.loads(f"value = {text}")["value"] if text else None
        except (tomllib.TOMLDecodeError, KeyError):
            changes[key] = text
    return changes
