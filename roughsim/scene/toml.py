"""A scene as TOML text, exact to the last bit."""

from __future__ import annotations

import json
from dataclasses import fields
from typing import Any

from roughsim.scene.records import quantity


def scene_toml(scene: Any) -> str:
    """Return the scene file of a `Scene`: SI numbers, their units as comments, tables inline."""
    blocks = [key_line(scene, "title", scene.title)] if scene.title else []
    for name, record in values_of(scene):
        if name != "title":
            lines = [key_line(record, key, value) for key, value in values_of(record)]
            blocks.append("\n".join([f"[{name}]", *lines]))
    return "\n\n".join(blocks) + "\n"


def values_of(record: Any) -> list[tuple[str, Any]]:
    """Return the keys of a record that are not left out, with their values."""
    pairs = ((field.name, getattr(record, field.name)) for field in fields(record))
    return [(key, value) for key, value in pairs if value is not None]


def key_line(record: Any, key: str, value: Any) -> str:
    """Return the line or lines of a key."""
    if key == "until":
        return f"until = {inline_table(value)}"
    if key == "psd":
        rows = "".join(f"[{q!r}, {psd!r}],\n" for q, psd in value)
        return f"psd = [  # q in rad/m, C in m⁴\n{rows}]"
    if key == "conductivity" and isinstance(value, tuple):
        temperatures, values = (list(column) for column in zip(*value, strict=True))
        return f"conductivity = {{ temperature = {temperatures}, value = {values} }}  # K, W/(m K)"
    unit = getattr(quantity(type(record), key), "unit", "")
    return f"{key} = {literal(value)}" + (f"  # {unit}" if unit else "")


def literal(value: Any) -> str:
    """Return a value as TOML: records are tables, tuples are lists."""
    if hasattr(value, "__dataclass_fields__"):
        return inline_table(values_of(value))
    if isinstance(value, tuple):
        return f"[{', '.join(literal(entry) for entry in value)}]"
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)


def inline_table(pairs: Any) -> str:
    """Return pairs of key and value as a table on one line."""
    inside = ", ".join(f"{key} = {literal(value)}" for key, value in pairs)
    return f"{{ {inside} }}" if inside else "{}"
