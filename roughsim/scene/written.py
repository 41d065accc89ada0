"""Keys and values as a scene file writes them, and as a small table for notebooks."""

from collections.abc import Mapping
from typing import Any

from roughsim.scene.schema import SECTIONS, literal, shortened, unit_of
from roughsim.show.table import Table, significant, table_of

_TEXTURE = (
    "lay, its angle, of one octave: lay, angle, q from, to; skewness, kurtosis, share beyond 8 rms, slope of tops, "
    "evidence of the lay"
)
# key of a table → the comment on its rows
_TABLES = {
    "psd": 'q in rad/m (by "frequency" f in 1/m), C in m⁴',
    "psd_error": "relative to C",
    "psd_texture": _TEXTURE,
    "psd_directions": "q in rad/m, M at even angles from x to -x",
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
    title, blocks = content["title"], []
    for name, section in content.items():
        if isinstance(section, dict):
            lines = (_key_line(name, key, value) for key, value in section.items())
            blocks.append("\n".join([f"[{name}]", *lines]))
    return f"title = {literal(title)}\n\n" * bool(title) + "\n\n".join(blocks) + "\n"


def scene_table(content: Mapping[str, Any]) -> Table:
    """Return a row for each key of the sections with a value, in SI; of a table C(q) the number of its rows."""
    rows = []
    for name, section in content.items():
        for key, value in section.items() if isinstance(section, dict) else ():
            text = significant(value, 6) if isinstance(value, float) else shortened(literal(value))
            if key in _TABLES:
                text = f"table of {len(value)} rows"
            unit = _unit(name, key, value)
            rows.append({"key": f"{name}.{key}", "value": text, "unit": unit})
    return table_of(rows, content["title"], texts=("key", "unit"))


def _key_line(section: str, key: str, value: Any) -> str:
    """Return the line of a key, or the lines of a table, with its unit as a comment."""
    if key in _TABLES:
        rows = "".join(f"{literal(row)},\n" for row in value)
        return f"{key} = [  # {_TABLES[key]}\n{rows}]"
    unit = _unit(section, key, value)
    return f"{key} = {literal(value)}" + f"  # {unit}" * bool(unit)


def _unit(section: str, key: str, value: Any) -> str:
    """Return the SI unit of a key, or the units of the columns of a table over temperature."""
    unit = unit_of(SECTIONS[section], key)
    over_temperature = isinstance(value, dict) and key in ("conductivity", "friction_coefficient")
    return f"K, {unit or 1}" if over_temperature else unit
