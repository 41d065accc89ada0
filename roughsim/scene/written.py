"""Keys and values as a scene file writes them."""

import json
from collections.abc import Mapping
from typing import Any

from roughsim.scene.schema import SECTIONS, unit_of

_TEXTURE = (
    "ratio of slopes, its angle, of one octave: ratio, angle, q from, to; skewness, kurtosis, share beyond 8 rms, "
    "slope of tops"
)
# key of a table → the comment on its rows
_TABLES = {
    "psd": 'q in rad/m (by "frequency" f in 1/m), C in m⁴',
    "psd_error": "relative to C",
    "psd_texture": _TEXTURE,
}


def as_content(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return a record, as a dict, as the content of a scene file: tables by key, and no key without a value."""
    content = {key: value for key, value in values.items() if value is not None}
    for key, value in content.items():
        if isinstance(value, dict):
            content[key] = as_content(value)
        elif key == "until":
            content[key] = dict(value)
        elif key in ("conductivity", "friction_coefficient") and isinstance(value, tuple):
            kelvin, numbers = zip(*value, strict=True)
            content[key] = {"temperature": kelvin, "value": numbers}
    return content


def toml_of(content: Mapping[str, Any]) -> str:
    """Return the text of a scene file with a content."""
    texts = [
        f"{key} = {literal(value)}\n\n"
        for key, value in content.items()
        if isinstance(value, str) and value
    ]
    blocks = [
        "\n".join([f"[{name}]", *(key_line(name, key, value) for key, value in section.items())])
        for name, section in content.items()
        if isinstance(section, dict)
    ]
    return "".join(texts) + "\n\n".join(blocks) + "\n"


def key_line(section: str, key: str, value: Any) -> str:
    """Return the line of a key, or the lines of a table, with its unit as a comment."""
    if key in _TABLES:
        rows = "".join(f"{literal(row)},\n" for row in value)
        return f"{key} = [  # {_TABLES[key]}\n{rows}]"
    unit = unit_of(SECTIONS[section], key)
    if key in ("conductivity", "friction_coefficient") and isinstance(value, dict):
        unit = f"K, {unit or 1}"
    return f"{key} = {literal(value)}" + (f"  # {unit}" if unit else "")


def literal(value: Any) -> str:
    """Return a value as TOML; a mapping is a table on one line."""
    if isinstance(value, dict):
        entries = [f"{key} = {literal(entry)}" for key, entry in value.items() if entry is not None]
        return f"{{ {', '.join(entries)} }}"
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(literal, value))}]"
    return json.dumps(value, ensure_ascii=False) if isinstance(value, (str, bool)) else repr(value)
