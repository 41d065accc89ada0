"""HTML from text that is not trusted: everything is escaped but elements made by this module."""

import re
from dataclasses import replace
from html import escape
from itertools import groupby

from roughsim.show.table import Cell, Number, Table
from roughsim.show.text import plain_lines


class Html(str):
    """Text that is HTML already."""

    __slots__ = ()


def text(value: object) -> Html:
    """Return a value as HTML: escaped, without control characters, unless it is HTML already."""
    if isinstance(value, Html):
        return value
    return Html(escape(plain_lines(value)))


def tag(name: str, *inside: object, **attributes: str) -> Html:
    """Return an element; content and attributes are escaped. ``css`` stands for the attribute class."""
    words = "".join(
        f' {"class" if key == "css" else key}="{text(value)}"' for key, value in attributes.items()
    )
    return Html(f"<{name}{words}>{''.join(text(part) for part in inside)}</{name}>")


def joined(*parts: object) -> Html:
    """Return parts one after another, a line each."""
    return Html("\n".join(text(part) for part in parts))


def bullets(*lines: object, css: str = "plain") -> Html:
    """Return a list of lines."""
    return tag("ul", *(tag("li", line) for line in lines), css=css)


def digits(number: Number) -> Html:
    """Return the digits of a number with its error, in its shown unit; powers of ten are written out."""
    # a minus sign is no hyphen, and 3.04e+07 is 3.04 × 10⁷
    return Html(re.sub(r"e\+?(−?)0*(\d+)", r" × 10<sup>\1\2</sup>", str(number).replace("-", "−")))


def in_notebook(*parts: str | Table) -> Html:
    """Return lines and tables as HTML for a notebook, whose own theme gives the style: no script, no colours.

    Notes of a table are folded.
    """
    content: list[Html] = []
    for part in parts:
        if isinstance(part, str):
            content.append(tag("p", part))
            continue
        content += [tag("p", tag("strong", part.title))] if part.title else []
        content.append(html_table(replace(part, notes=()), aligned=True))
        if part.notes:
            content.append(
                tag("details", tag("summary", "notes"), *(tag("p", note) for note in part.notes))
            )
    return tag("div", joined(*content))


def html_table(table: Table, *, aligned: bool = False) -> Html:
    """Return a table with its notes; repeated names become lines of their own above their rows.

    Cells have classes, for a page with a style sheet; with `aligned` they have a style attribute for their alignment.
    """
    columns, rows = list(table.columns), [list(row) for row in table.rows]
    names = [str(row[0]) for row in rows]
    grouped = columns[0].name and len(set(names)) < len(names)
    sides: dict[bool, dict[str, str]] = {False: {"css": ""}, True: {"css": "number"}}
    if aligned:
        sides = {
            False: {"style": "text-align: left"},
            True: {"style": "text-align: right; white-space: nowrap"},
        }
    kinds = [sides[column.number] for column in columns][grouped:]

    # a narrow screen has the title beside each cell
    beside = [{} if aligned else {"data-title": c.title} for c in columns][grouped:]

    def line(row: list[Cell]) -> Html:
        cells = (digits(cell) if isinstance(cell, Number) else cell for cell in row[grouped:])
        every = zip(cells, kinds, beside, strict=True)
        return tag("tr", *(tag("td", cell, **kind, **title) for cell, kind, title in every))

    bodies = []
    for name, group in groupby(rows, key=lambda row: str(row[0]) if grouped else ""):
        heading = tag(
            "th",
            name,
            colspan=str(len(kinds)),
            scope="rowgroup",
            **(sides[False] if aligned else {}),
        )
        title = tag("tr", heading, css="group") if grouped else ""
        bodies.append(tag("tbody", title, joined(*map(line, group))))
    titles = (tag("th", c.title, **kind) for c, kind in zip(columns[grouped:], kinds, strict=True))
    head = tag("thead", tag("tr", *titles)) if any(column.title for column in columns) else ""
    notes = (tag("p", note, css="note") for note in table.notes)
    return joined(tag("div", tag("table", head, *bodies), css="wide"), *notes)
