"""Scenes and numerics as small tables, for notebooks."""

from collections.abc import Iterator, Mapping
from typing import Any

from roughsim.scene.schema import SECTIONS, quantity
from roughsim.show.table import Column, Table, significant


def scene_table(title: str, sections: Mapping[str, Any]) -> Table:
    """Return the keys of the sections of a scene that have a value, a row each, in SI."""
    rows = [
        (f"{name}.{key}", *value_and_unit(name, key, value))
        for name, section in sections.items()
        if isinstance(section, dict)
        for key, value in section.items()
        if value is not None and not (name == "numerics" and key == "levels")
    ]
    return Table([Column("key"), Column("value", number=True), Column("unit")], rows, title)


def value_and_unit(section: str, key: str, value: Any) -> tuple[str, str]:
    """Return the value of a key as people read it, and its SI unit; of a table only how many rows it has."""
    unit = getattr(quantity(SECTIONS[section], key), "unit", "")
    if isinstance(value, tuple) and value and isinstance(value[0], tuple):
        names = [f"{name} = {significant(float(x), 6)}" for name, x in value] if isinstance(value[0][0], str) else []
        return ", ".join(names) or f"table of {len(value)} rows", ""
    if isinstance(value, tuple):
        return ", ".join(map(number_text, value)), unit
    return number_text(value), unit


def number_text(value: Any) -> str:
    """Return a number with up to six digits; all else as it is."""
    return significant(value, 6) if isinstance(value, float) else str(value)


def numerics_table(numerics: Any) -> Table:
    """Return the levels of numerics, a row each; below what all have in common."""
    titles = (("level", True), ("column", False), ("points", True), ("q_c, rad/m", True), ("corrects", False))
    rows = [
        (str(i), level.column, *level_texts(level), corrected(numerics, i)) for i, level in enumerate(numerics.levels)
    ]
    return Table([Column(title, number=right) for title, right in titles], rows, "", tuple(common_notes(numerics)))


def level_texts(level: Any) -> Iterator[str]:
    """Yield the points and the cut-off of a level."""
    yield f"{level.shape[0]} × {level.shape[1]}" + level.where
    yield significant(level.q_max, 4)


def corrected(numerics: Any, level: int) -> str:
    """Return what a level corrects; nothing of the lowest of a column."""
    below, first = numerics.below(level), numerics.levels[level].first
    if below is None:
        return "" if first is None else f"frozen contact, {first} realizations"
    return f"the pixel of level {below}" if numerics.is_partner(level) else f"level {below}"


def common_notes(numerics: Any) -> Iterator[str]:
    """Yield lines on the cell, the solves and the fields that are kept."""
    sides = " × ".join(significant(1e3 * side, 4) for side in numerics.lengths)
    yield f"Cell {sides} mm; tolerance {numerics.tolerance:g} of the contact, {numerics.precision} precision."
    yield f"Fields of the first {numerics.keep_fields} of each level are kept; {numerics.threads} threads each."
    yield from (f"{choice} {value}: {reason}." for choice, value, reason in numerics.reasons)
