"""A scene as TOML text, exact to the last bit."""

from __future__ import annotations

import json
from dataclasses import fields
from typing import TYPE_CHECKING, Any

from roughsim.scene.quantities import unit_of

if TYPE_CHECKING:
    from roughsim.scene.model import Scene


def scene_toml(scene: Scene) -> str:
    """Return the scene file of `scene`: SI numbers, their units as comments, tables inline."""
    blocks = [_line("title", scene.title)] if scene.title else []
    for name in (field.name for field in fields(scene)):
        record = getattr(scene, name)
        if name != "title" and record is not None:
            blocks.append("\n".join([f"[{name}]", *_lines(record)]))
    return "\n\n".join(blocks) + "\n"


def _lines(record: Any) -> list[str]:
    entries = ((field.name, getattr(record, field.name)) for field in fields(record))
    return [_line(key, value) for key, value in entries if value is not None]


def _line(key: str, value: Any) -> str:
    if key == "until":
        return f"until = {_table(value)}"
    if key == "psd":
        rows = "".join(f"[{q!r}, {psd!r}],\n" for q, psd in value)
        return f"psd = [  # q in rad/m, C in m⁴\n{rows}]"
    if key == "conductivity" and isinstance(value, tuple):
        temperatures, values = (list(column) for column in zip(*value, strict=True))
        return f"conductivity = {{ temperature = {temperatures}, value = {values} }}  # K, W/(m K)"
    unit = unit_of(key)
    return f"{key} = {_value(value)}" + (f"  # {unit}" if unit else "")


def _value(value: Any) -> str:
    if hasattr(value, "__dataclass_fields__"):
        entries = ((field.name, getattr(value, field.name)) for field in fields(value))
        return _table((key, entry) for key, entry in entries if entry is not None)
    if isinstance(value, tuple):
        return f"[{', '.join(_value(entry) for entry in value)}]"
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)


def _table(pairs: Any) -> str:
    inside = ", ".join(f"{key} = {_value(value)}" for key, value in pairs)
    return f"{{ {inside} }}" if inside else "{}"
