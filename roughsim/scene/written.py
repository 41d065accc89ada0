"""Keys and values as a scene file writes them."""

import json
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


def key_line(section: str, key: str, value: Any) -> str:
    """Return the line of a key, or the lines of a table, with its unit as a comment."""
    if key in _TABLES:
        rows = "".join(f"{literal(row)},\n" for row in value)
        return f"{key} = [  # {_TABLES[key]}\n{rows}]"
    unit = unit_of(SECTIONS[section], key)
    if key == "until":
        value = dict(value)
    if key in ("conductivity", "friction_coefficient") and isinstance(value, tuple):
        temperatures, values = zip(*value, strict=True)
        value = {"temperature": temperatures, "value": values}
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
