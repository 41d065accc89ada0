"""Lists for two pages, made when the site is built: the keys of a scene, and the commands.

Units, limits and defaults of the keys come from the schema, meanings and examples from the form `roughsim new blank`;
the commands come from their own help.
"""

from __future__ import annotations

import inspect
import re
from dataclasses import MISSING, fields
from typing import Any, Literal, NamedTuple, get_args, get_origin, get_type_hints

import typer

from roughsim import cli
from roughsim.scene import BLANK, scene_text
from roughsim.scene.numerics import Level, Numerics
from roughsim.scene.schema import SECTIONS, Quantity, Record, as_written, quantity

_KEY = re.compile(r"^# (\w+) = (.+?)\s+# (.*)$")
_SECTION = re.compile(r"^(?:# )?\[(\w+)\](?:\s+# (.*))?$")
_MORE = re.compile(r"^\s{20,}# (.*)$")
_NO_LIMIT = 2.0**62  # TOML holds no larger whole numbers
_NEEDED, _IS_DEFAULT = " (needed)", "; this is the default"


class Entry(NamedTuple):
    """A key of the form: its section, an example as TOML, and its meaning."""

    section: str
    example: str
    meaning: str


def form() -> tuple[dict[str, str], dict[tuple[str, str], Entry]]:
    """Return the meaning of each section, and each key of the form by section and name."""
    section, sections, keys = "", {"": ""}, {}
    last: tuple[str, str] | None = None
    for line in scene_text(BLANK).splitlines():
        title, key, more = _SECTION.match(line), _KEY.match(line), _MORE.match(line)
        if title:
            section = title[1]
            sections[section] = title[2] or ""
        elif key:
            last = section, key[1]
            keys[last] = Entry(section, key[2], key[3])
        elif more and last:
            keys[last] = keys[last]._replace(meaning=f"{keys[last].meaning} {more[1]}")
    return sections, keys


def scene_keys() -> str:
    """Return a table of the keys of each section, as Markdown."""
    sections, keys = form()
    lines = []
    for section, meaning in sections.items():
        rows = [_row(name, entry) for (home, name), entry in keys.items() if home == section]
        title = f"[{section}]" if section else "Top of the file"
        sentence = f"{meaning[:1].upper()}{meaning[1:]}." if meaning else ""
        lines += [f"## {title}", "", sentence, "", *_table(rows)]
    return "\n".join(
        [*lines, "## Levels", "", "A level is a table with these keys.", "", *_table(_level_rows())]
    )


def _table(rows: list[tuple[str, ...]]) -> list[str]:
    """Return the lines of a Markdown table."""
    titles = ("key", "unit", "limits", "default", "meaning", "example")
    cells = [tuple(cell.replace("|", "\\|") for cell in row) for row in rows]
    return ["| " + " | ".join(row) + " |" for row in (titles, ("---",) * len(titles), *cells)] + [
        ""
    ]


def _row(name: str, entry: Entry) -> tuple[str, ...]:
    """Return the cells of a key of the form."""
    record = SECTIONS[entry.section]
    meaning = entry.meaning.replace(_NEEDED, "").replace(_IS_DEFAULT, "")
    number = quantity(record, name)
    return (
        f"`{name}`",
        _unit(number),
        _limits(record, name),
        _default(name, entry),
        meaning,
        f"`{entry.example}`",
    )


def _level_rows() -> list[tuple[str, ...]]:
    """Return the cells of the keys of a level, whose meanings are in the docstring of `Level`."""
    meanings = re.findall(r"(?m)^(\w+) : .*\n((?:    .*\n?)+)", inspect.getdoc(Level) or "")
    rows = []
    for name, text in meanings:
        number = quantity(Level, name)
        default = "needed" if _of_class(Level, name) is MISSING else "left out"
        written = number.example if number else as_written(_words(get_type_hints(Level)[name])[0])
        cells = (
            _unit(number),
            _limits(Level, name),
            default,
            " ".join(text.split()),
            f"`{name} = {written}`",
        )
        rows.append((f"`{name}`", *cells))
    return rows


def _unit(number: Quantity | None) -> str:
    """Return the SI unit of a number; a dash without one."""
    return number.unit if number and number.unit else "–"


def _limits(record: type[Record], name: str) -> str:
    """Return the limits of a number, or the words of a choice."""
    number = quantity(record, name)
    if number:
        bounds = {">": number.gt, "≥": number.ge, "<": number.lt, "≤": number.le}
        return (
            ", ".join(
                f"{sign} {bound:g}"
                for sign, bound in bounds.items()
                if bound is not None and abs(bound) < _NO_LIMIT
            )
            or "–"
        )
    return (
        ", ".join(f"`{as_written(word)}`" for word in _words(get_type_hints(record).get(name)))
        or "–"
    )


def _words(kind: Any) -> list[str]:
    """Return the words of a Literal, also within a union."""
    if get_origin(kind) is Literal:
        return list(get_args(kind))
    return [word for part in get_args(kind) for word in _words(part)]


def _default(name: str, entry: Entry) -> str:
    """Return the default of a key of the form in words."""
    if _NEEDED in f" {entry.meaning}":
        return "needed"
    if _IS_DEFAULT in entry.meaning:
        return f"`{entry.example}`"
    record = Numerics if entry.section == "numerics" else SECTIONS[entry.section]
    value = _of_class(record, name)
    if value not in (None, MISSING, ""):
        return f"`{as_written(value)}`"
    return "planned" if entry.section == "numerics" else "left out"


def _of_class(record: type[Record], name: str) -> Any:
    """Return the default of a field; MISSING without one."""
    return {field.name: field.default for field in fields(record)}.get(name, MISSING)  # type: ignore[arg-type]


def commands() -> str:
    """Return the help of each command, as Markdown."""
    group = typer.main.get_command(cli.app)
    above = typer.Context(group, info_name="roughsim", terminal_width=100, **group.context_settings)
    lines = []
    for name, command in group.commands.items():  # type: ignore[attr-defined]
        context = typer.Context(command, parent=above, info_name=name)
        lines += [f"## {name}", "", "```", command.get_help(context), "```", ""]
    return "\n".join(lines)
