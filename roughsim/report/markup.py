"""HTML from text that is not trusted: everything is escaped unless it was built here."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from math import isfinite

from roughsim.show.units import written


class Html(str):
    """Text that is HTML already."""

    __slots__ = ()


def text(value: object) -> Html:
    """Return a value as HTML: escaped, without control characters, unless it is HTML already."""
    if isinstance(value, Html):
        return value
    shown = "".join(
        c if c.isprintable() or c in "\n\t\N{NO-BREAK SPACE}" else "\N{REPLACEMENT CHARACTER}" for c in str(value)
    )
    return Html(escape(shown, quote=True))


def tag(name: str, *inside: object, **attributes: str) -> Html:
    """Return an element; content and attributes are escaped. ``css`` stands for the attribute class."""
    given = "".join(f' {"class" if key == "css" else key}="{text(value)}"' for key, value in attributes.items())
    return Html(f"<{name}{given}>{''.join(text(part) for part in inside)}</{name}>")


def joined(*parts: object) -> Html:
    """Return parts one after another, a line each."""
    return Html("\n".join(text(part) for part in parts))


def table(titles: list[str], rows: list[list[object]], *, numbers: set[int]) -> Html:
    """Return a table; the columns in `numbers` stand right."""
    kinds = ["number" if k in numbers else "" for k in range(len(titles))]
    return _table(titles, tag("tbody", joined(*(_line(row, kinds) for row in rows))), kinds)


def grouped_table(titles: list[str], groups: dict[str, list[list[object]]]) -> Html:
    """Return a table of numbers whose rows stand in groups, each under its name; the last column is a remark."""
    kinds = ["number"] * (len(titles) - 1) + [""]
    bodies = []
    for name, rows in groups.items():
        head = tag("tr", tag("th", name, colspan=str(len(titles)), scope="rowgroup"), css="group")
        bodies.append(tag("tbody", head, joined(*(_line(row, kinds) for row in rows))))
    return _table(titles, joined(*bodies), kinds)


def _table(titles: list[str], bodies: Html, kinds: list[str]) -> Html:
    head = tag("tr", *(tag("th", title, css=kind) for title, kind in zip(titles, kinds, strict=True)))
    return tag("div", tag("table", tag("thead", head), bodies), css="wide")


def _line(row: list[object], kinds: list[str]) -> Html:
    return tag("tr", *(tag("td", cell, css=kind) for cell, kind in zip(row, kinds, strict=True)))


def number(value: float | None, digits: int = 4) -> Html:
    """Return a number with its significant digits, powers of ten written out; a dash where there is none."""
    if value is None or not isfinite(value):
        return Html("–")
    shown = f"{value:.{digits - 1}e}"
    mantissa, _, exponent = shown.partition("e")
    power = int(exponent)
    if value == 0.0:
        return Html("0")
    if -4 <= power < 5:
        return Html(_minus(f"{float(shown):.{max(digits - 1 - power, 0)}f}"))
    return Html(_minus(mantissa) + _power(power))


def plus_minus(mean: float, error: float, unknown: Sequence[str] = ()) -> Html:
    """Return mean ± error as `roughsim.show.units.plus_minus` does, powers of ten written out."""
    value, wrong, power = written(mean, error, unknown)
    if not wrong:
        return number(mean)
    small, _, exponent = wrong.partition("e")
    both = f"{_minus(value)} ± {small}" + (_power(int(exponent)) if exponent else "")
    return Html(f"({both}){_power(power)}" if power else both)


def _power(exponent: int) -> str:
    return f" × 10<sup>{_minus(str(exponent))}</sup>"


def _minus(shown: str) -> str:
    return shown.replace("-", "−")
