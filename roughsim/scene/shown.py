"""A scene as a small table, for notebooks."""

from collections.abc import Mapping
from typing import Any

from roughsim.scene.schema import SECTIONS, unit_of
from roughsim.show.table import Column, Row, Table, significant


def scene_table(title: str, sections: Mapping[str, Any]) -> Table:
    """Return a row for each key of the sections with a value, in SI."""
    rows: list[Row] = []
    for name, section in sections.items():
        for key, value in section.items() if isinstance(section, dict) else ():
            if value is not None and (name, key) != ("numerics", "levels"):
                rows.append((f"{name}.{key}", *_value_and_unit(name, key, value)))
    return Table([Column("key"), Column("value", number=True), Column("unit")], rows, title)


def _value_and_unit(section: str, key: str, value: Any) -> tuple[str, str]:
    """Return the value of a key as text and its SI unit; of a table only its number of rows."""
    unit = unit_of(SECTIONS[section], key)
    if not isinstance(value, tuple):
        return _number_text(value), unit
    if not value or not isinstance(value[0], tuple):
        return ", ".join(map(_number_text, value)), unit
    if isinstance(value[0][0], str):  # pairs of a name and a number
        return ", ".join(f"{name} = {significant(float(x), 6)}" for name, x in value), ""
    return f"table of {len(value)} rows", ""


def _number_text(value: Any) -> str:
    """Return a number with up to six digits, and all else unchanged."""
    return significant(value, 6) if isinstance(value, float) else str(value)
