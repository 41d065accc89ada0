"""The varied keys of a study: axes with their values, and the points of their grid.

An axis is written as ``"sliding.nominal_pressure" = ["1 MPa", "5 MPa"]``, or with the ends and the number of values as
``{ logspace = ["1 MPa", "100 MPa", 9] }`` or ``{ linspace = ... }``. Keys that change together share an axis:
``"body.penetration_hardness, sliding.friction_coefficient" = [["1 GPa", 0.1], ["2 GPa", 0.2]]``. The numbers of a key
all have a unit or none has.
"""

import hashlib
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import prod
from numbers import Integral, Real
from typing import Any

import numpy as np

from roughsim.observables.catalogue import OBSERVABLES
from roughsim.scene.schema import (
    SECTIONS,
    Quantity,
    SceneError,
    as_written,
    literal,
    quantity,
    shortened,
)
from roughsim.table import AXES

MOST_POINTS = 10_000
_LONGEST = 60  # letters of a value in the name of a point
_DIGITS = (
    9  # significant, of a number in the name of a point: values that differ by less are the same
)
NAME = re.compile(
    r"[\w=.,+-]{1,200}", re.ASCII
)  # of a point: none of *?[]/, so that it is a folder that a pattern can name
_SPACES: dict[str, Any] = {"logspace": np.geomspace, "linspace": np.linspace}
_EXAMPLE = '"sliding.nominal_pressure" = ["1 MPa", "5 MPa"]'
_SPACED = '{ logspace = ["1 MPa", "100 MPa", 9] }'
_IN_TEXT = re.compile(r"\s*[-+.0-9]")  # how a number with a unit begins


@dataclass(frozen=True, slots=True)
class Axis:
    """Keys that change together, and a row of their values for each place along the axis, in SI."""

    keys: tuple[str, ...]
    values: tuple[tuple[Any, ...], ...]


@dataclass(frozen=True, slots=True)
class Point:
    """One scene of a study: the values of the varied keys, in SI, the name of its folder, and its place in the grid."""

    name: str
    values: dict[str, Any]
    place: tuple[int, ...]


def read_axes(vary: Any) -> tuple[Axis, ...]:
    """Return the axes of a mapping from keys to values; SceneError names an unusable key or value."""
    if not isinstance(vary, Mapping) or not vary:
        raise SceneError(
            f"vary = {as_written(vary)} must name at least one key and its values, for example {_EXAMPLE}"
        )
    axes = tuple(_read_axis(keys, values) for keys, values in vary.items())
    keys = [key for axis in axes for key in axis.keys]
    for key in keys:
        if keys.count(key) > 1:
            raise SceneError(f"vary: {key} is there twice; keep one of the two")
    count = prod(len(axis.values) for axis in axes)
    if count > MOST_POINTS:
        raise SceneError(
            f"vary gives {count} points, above the limit of {MOST_POINTS}; take fewer values"
        )
    return axes


def _read_axis(names: Any, values: Any) -> Axis:
    """Return one axis."""
    keys = _keys_of(names)
    where = f"vary.{as_written(', '.join(keys))}"
    if isinstance(values, Mapping):
        values = _spaced(keys, values, where)
    if not _is_list(values) or not len(values):
        raise SceneError(
            f"{where} = {as_written(values)} must be a list of values, for example {_EXAMPLE}"
        )
    rows = [_row_of(value, len(keys), f"{where}[{i}]") for i, value in enumerate(values)]
    for k, key in enumerate(keys):
        _refuse_mixture(key, [row[k] for row in rows], where)
    converted: dict[str, tuple[Any, ...]] = {}  # by label
    for i, row in enumerate(rows):
        in_si = tuple(
            _in_si(key, entry, f"{where}[{i}]") for key, entry in zip(keys, row, strict=True)
        )
        label = ",".join(map(_label, in_si))
        if label in converted:
            raise SceneError(f"{where}[{i}] = {label} is there twice; remove one of the two")
        converted[label] = in_si
    return Axis(keys, tuple(converted.values()))


def _keys_of(names: Any) -> tuple[str, ...]:
    """Return the keys of an axis, given as "a, b" or as a list."""
    words = names.split(",") if isinstance(names, str) else names
    if (
        not isinstance(words, Sequence)
        or not words
        or any(not isinstance(word, str) for word in words)
    ):
        raise SceneError(
            f"vary: {as_written(names)} must be the name of a key, or several, for example {_EXAMPLE}"
        )
    return tuple(word.strip() for word in words)


def _is_list(value: Any) -> bool:
    return isinstance(value, (Sequence, np.ndarray)) and not isinstance(value, str)


def _row_of(value: Any, count: int, where: str) -> list[Any]:
    """Return the values of several keys, or of a single one."""
    if count == 1:
        return [value]
    if not _is_list(value) or len(value) != count:
        raise SceneError(
            f"{where} = {as_written(value)} must be a list of {count} values, one for each key"
        )
    return list(value)


def _refuse_mixture(key: str, values: Sequence[Any], where: str) -> None:
    """Refuse numbers of a key with and without units: a count is not a third load."""
    number = key_quantity(key)
    if number is None:
        return
    entries = list(_leaves(values))
    with_unit = [entry for entry in entries if isinstance(entry, str) and _IN_TEXT.match(entry)]
    plain = [entry for entry in entries if not isinstance(entry, bool) and isinstance(entry, Real)]
    if not with_unit or not plain:
        return
    is_range = len(entries) == 3 and entries[:2] == with_unit and _is_count(entries[2])
    example = f"{{ logspace = {literal(entries)} }}" if is_range else _SPACED
    unit = f" ({number.unit})" if number.unit else ""
    raise SceneError(
        f"{where} mixes {as_written(with_unit[0])} with the plain number {as_written(plain[0])}{unit}; write all with "
        f"a unit, or none. First, last and count are written {example}"
    )


def _is_count(value: Any) -> bool:
    """Whether a value is a number of points of a range."""
    if isinstance(value, bool) or not isinstance(value, Integral):
        return False
    return 2 <= int(value) <= MOST_POINTS


def _leaves(values: Any) -> Iterator[Any]:
    """Yield the entries of nested lists."""
    for value in values:
        if isinstance(value, (list, tuple, np.ndarray)):
            yield from _leaves(value)
        else:
            yield value


def _spaced(keys: tuple[str, ...], values: Mapping[str, Any], where: str) -> list[float]:
    """Return the values of "logspace" or "linspace", given by first, last and count."""
    kind = next(iter(values), "")
    ends: Any = values.get(kind)
    if len(values) != 1 or kind not in _SPACES or not _is_list(ends) or len(ends) != 3:
        written = shortened(literal(dict(values)))
        raise SceneError(
            f"{where} = {written} must be a list, or first, last and count as in {_SPACED}"
        )
    if len(keys) != 1:
        raise SceneError(f"{where}: {kind} is for one key; write several keys as a list of lists")
    where = f"{where}.{kind}"
    _refuse_mixture(keys[0], ends[:2], where)
    first, last = (_end(keys[0], end, kind, where) for end in ends[:2])
    count = ends[2]
    if not _is_count(count):
        raise SceneError(
            f"{where}: count = {as_written(count)} must be a whole number from 2 to {MOST_POINTS}"
        )
    spread = [
        float(f"{value:.{_DIGITS}g}")
        for value in _SPACES[kind](float(first), float(last), int(count))
    ]
    if isinstance(first, int):
        return [int(value) if value.is_integer() else value for value in spread]
    return spread


def _end(key: str, value: Any, kind: str, where: str) -> float:
    """Return an end of a range in SI."""
    end = _in_si(key, value, where)
    limit = " > 0" if kind == "logspace" else ""
    if isinstance(end, bool) or not isinstance(end, (int, float)) or (limit and end <= 0.0):
        raise SceneError(f"{where} = {as_written(end)} must be a number{limit}")
    return end


def key_quantity(key: str) -> Quantity | None:
    """Return the `Quantity` of a key of the scene; None for an unknown key, or one without numbers."""
    section, _, name = key.rpartition(".")
    return quantity(SECTIONS[section], name) if section in SECTIONS and name else None


def plain_value(value: Any) -> Any:
    """Return a number or a word unchanged, and a list or a table as in a scene file."""
    if isinstance(value, str) or (isinstance(value, (int, float)) and not isinstance(value, bool)):
        return value
    return literal(value)


def _in_si(key: str, value: Any, where: str) -> Any:
    """Return a value in SI if its key is a number; any other value as it is, to be checked in its scene."""
    number = key_quantity(key)
    if hasattr(value, "tolist"):  # a number or an array of NumPy
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return tuple(_in_si(key, entry, where) for entry in value)
    if number is None or isinstance(value, bool) or not isinstance(value, (str, int, float)):
        return value
    try:
        return number(value) if number.whole else float(number(value))
    except ValueError as error:
        if isinstance(value, str) and not _IN_TEXT.match(value):
            return value  # a word, as of sliding.heat_partition
        raise SceneError(f"{where}{error}") from None


def _label(value: Any) -> str:
    """Return a value as a short part of a folder name; a long one is cut, with a digest."""
    if isinstance(value, tuple):
        value = "-".join(map(_label, value))
    text = f"{value:.{_DIGITS}g}" if isinstance(value, float) else str(value)
    word = re.sub(r"[^\w.+-]+", "-", text, flags=re.ASCII).strip("-") or "none"
    return (
        word
        if len(word) <= _LONGEST
        else f"{word[: _LONGEST - 9]}-{hashlib.sha256(text.encode()).hexdigest()[:8]}"
    )


def short_names(keys: Sequence[str]) -> dict[str, str]:
    """Return each key without its section if that is unique: "nominal_pressure", but "sliding_speed"."""
    last = [key.rpartition(".")[2] for key in keys]
    taken = {*AXES, "observable", "heat_above", *OBSERVABLES}  # names in the tables
    return {
        key: name if last.count(name) == 1 and name not in taken else key.replace(".", "_")
        for key, name in zip(keys, last, strict=True)
    }


def points_of(axes: Sequence[Axis]) -> tuple[Point, ...]:
    """Return the points of the grid; the last axis varies fastest."""
    names, points = short_names([key for axis in axes for key in axis.keys]), []
    for place in np.ndindex(*(len(axis.values) for axis in axes)):
        values: dict[str, Any] = {}
        for axis, k in zip(axes, place, strict=True):
            values |= zip(axis.keys, axis.values[k], strict=True)
        name = ",".join(f"{names[key]}={_label(value)}" for key, value in values.items())
        points.append(Point(name[:200], values, place))
    seen: set[str] = set()
    for point in points:
        if point.name in seen:
            raise SceneError(
                f"vary: two points would have the name {point.name}; write their values shorter"
            )
        seen.add(point.name)
    return tuple(points)
