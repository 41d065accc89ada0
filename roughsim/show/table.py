"""Tables, and the numbers in them: made once, rendered by the terminal, as plain text and as HTML.

Every ± is a total error that holds with 95 %. Value and error both end at the second digit of the error.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import floor, isfinite, log10
from textwrap import wrap
from typing import Any
from unicodedata import east_asian_width

from roughsim.show.text import columns_of_terminal, plain, wrapped

# SI unit → unit that people read, and the factor between them; a unit that is not here is shown as it is
SHOWN = {
    "K/m": ("K/mm", 1e-3),
    "K/m^2": ("K/µm²", 1e-12),
    "W/m^2": ("W/m²", 1.0),
    "m": ("µm", 1e6),
    "1": ("", 1.0),
    "Pa^2": ("GPa²", 1e-18),
}
_MOST_DIGITS = 6  # of a value that are worth printing
_LEAST_TEXT = (
    30  # columns that a text may be narrowed to; longer words, such as paths, are then broken
)
_GAP = 2  # columns between two of a table


def shown(unit: str) -> tuple[str, float]:
    """Return the unit that tables and figures show in place of an SI unit, and the factor between them."""
    return SHOWN.get(unit, (unit, 1.0))


def with_unit(name: str, unit: str) -> str:
    """Return a name with the shown form of its SI unit: "slope_length, µm"."""
    return f"{name}, {text}" if (text := shown(unit)[0]) else name


@dataclass(frozen=True, slots=True)
class Number:
    """A number of a table, in SI; printed in the unit of `shown`, which is in the title of its column or row."""

    value: float  # NaN and inf are written "–"
    unit: str = "1"  # SI
    error: float = 0.0  # total, 95 %; 0 for numbers without an error, such as theory
    unknown: Sequence[
        str
    ] = ()  # unknown parts of the error: the rest is a lower bound, "208.33 ± ≥0.38"
    digits: int = 4  # significant, of a number without an error

    def written(self) -> tuple[str, str, int]:
        """Return value and error in the shown unit, both to the second digit of the error, and their power of ten.

        The error is empty without one.
        """
        factor = shown(self.unit)[1]
        value, error = self.value * factor, self.error * factor
        if not isfinite(value):
            return "–", "", 0
        if error == 0.0 or not isfinite(error):
            known = error == 0.0 and not (self.unknown and value)
            return significant(value, self.digits), "" if known else "unknown", 0
        at_least = "≥" if self.unknown else ""
        if abs(value) > 10**_MOST_DIGITS * error:
            return f"{value:.{_MOST_DIGITS}g}", f"{at_least}{error:.1e}", 0
        # very large and very small numbers share one power of ten with their error: (1.6328 ± 0.0081)e-4
        large = floor(log10(max(abs(value), error)))
        power = large if not -3 <= large < 5 else 0
        value, error = value / 10.0**power, error / 10.0**power
        places = 1 - int(
            f"{error:.1e}".partition("e")[2]
        )  # of the error's second digit, once it is rounded
        value, error = round(value, places), round(error, places)
        shown_places = max(places, 0)
        return f"{value:.{shown_places}f}", f"{at_least}{error:.{shown_places}f}", power

    def __str__(self) -> str:
        value, error, power = self.written()
        both = f"{value} ± {error}" if error else value
        return f"({both})e{power}" if power else both


Cell = str | Number
Row = Sequence[Cell]


@dataclass(frozen=True, slots=True)
class Column:
    """A column of a table: its title, with the unit of its numbers, and the alignment of its cells."""

    title: str
    number: bool = False  # cells are aligned right and never broken
    name: bool = (
        False  # cells name groups of rows: never broken, and a name is shown only in its first row
    )


@dataclass(frozen=True, slots=True)
class Table:
    """A table for people: a cell for each column in every row."""

    columns: Sequence[Column]  # without any title there is no line of titles
    rows: Sequence[Row]
    title: str = ""  # stands above
    notes: Sequence[str] = ()  # stand below, a sentence or two each, on marks and missing values
    heads: int = 1  # columns on the left that a narrow terminal repeats before others

    def __str__(self) -> str:
        return table_text(self)

    def cells(self, k: int) -> list[str]:
        """Return the text of column k, a line per row; in a column of names a name is written once for its group."""
        texts = [[str(cell) for cell in row[: k + 1]] for row in self.rows]
        # a new name on the left begins a new group
        repeats = [
            self.columns[k].name and n > 0 and texts[n - 1] == row for n, row in enumerate(texts)
        ]
        return ["" if repeat else row[k] for row, repeat in zip(texts, repeats, strict=True)]


def table_text(table: Table, width: int | None = None) -> str:
    """Return a table as plain text, of at most `width` columns, by default the terminal's, if its numbers allow it.

    No number and no word is cut: text is wrapped, then columns continue in a block below, after the heads of the rows.
    """
    width = width or columns_of_terminal()
    cells = [[plain(text) for text in table.cells(k)] for k in range(len(table.columns))]
    least = [_least_width(c, texts) for c, texts in zip(table.columns, cells, strict=True)]
    lines = wrapped(table.title, width) if table.title else []
    for n, places in enumerate(_blocks(least, table.heads, width)):
        lines += [""] * (n > 0)
        lines += _block_lines([(table.columns[k], cells[k], least[k]) for k in places], width)
    for note in table.notes:
        lines += wrapped(note, width)
    return "\n".join(lines)


def _columns_of(text: str) -> int:
    """Return the columns of a terminal that a text takes."""
    return len(text) + sum(east_asian_width(c) in "WF" for c in text)


def _least_width(column: Column, texts: Sequence[str]) -> int:
    """Return the width to which a column may be narrowed: of its cells, or of the longest word of a text."""
    if column.number or column.name:  # cells stay whole, and the title takes two lines
        whole = (*column.title.split(), *texts)
        return max((len(column.title) + 1) // 2, 1, *map(_columns_of, whole))
    words = " ".join((column.title, *texts)).split()
    return min(max(map(_columns_of, words), default=0), _LEAST_TEXT)


def _blocks(least: Sequence[int], heads: int, width: int) -> list[list[int]]:
    """Return the places of the columns of each block, which begins with the heads; as wide as `width`, if it can be."""
    first = list(range(min(heads, len(least))))
    blocks = [[*first]]
    for k in range(len(first), len(least)):
        taken = sum(least[i] + _GAP for i in blocks[-1]) + least[k]
        if taken > width and len(blocks[-1]) > len(first):
            blocks.append([*first])
        blocks[-1].append(k)
    return blocks


def _block_lines(columns: Sequence[tuple[Column, list[str], int]], width: int) -> list[str]:
    """Return the lines of columns side by side, each with its cells and its least width."""
    widths = [least for _, _, least in columns]
    longest = [max(map(_columns_of, (column.title, *texts))) for column, texts, _ in columns]
    wide = [k for k, (column, _, _) in enumerate(columns) if not (column.number or column.name)]
    room = width - _GAP * (len(columns) - 1) - sum(widths) + sum(widths[k] for k in wide)
    for n, k in enumerate(sorted(wide, key=longest.__getitem__)):  # a short text leaves room
        widths[k] = max(widths[k], min(longest[k], room // (len(wide) - n)))
        room -= widths[k]
    lines = []
    titles = [column.title for column, _, _ in columns]
    for i, row in enumerate([titles, *zip(*(texts for _, texts, _ in columns), strict=True)]):
        parts = [
            wrap(text, max(size, 1), break_on_hyphens=False)
            for text, size in zip(row, widths, strict=True)
        ]
        height = max(map(len, parts))
        for part in parts:
            missing = [""] * (height - len(part))
            part[:] = [*missing, *part] if i == 0 else [*part, *missing]  # titles stand below
        for line in zip(*parts, strict=True):
            cells = []
            for text, size, (column, _, _) in zip(line, widths, columns, strict=True):
                blank = " " * (size - _columns_of(text))
                cells.append(blank + text if column.number else text + blank)
            lines.append((" " * _GAP).join(cells).rstrip())
    return lines


def table_of(
    rows: Sequence[Mapping[str, Cell]],
    title: str = "",
    notes: Sequence[str] = (),
    *,
    names: Sequence[str] = (),
    texts: Sequence[str] = (),
) -> Table:
    """Return a table of rows by the titles of their columns; a cell that a row lacks is empty.

    Columns are aligned as numbers, but for those of `names` and of `texts`. The heads are those before the first
    `Number`.
    """
    titles = [*dict.fromkeys(name for row in rows for name in row)]
    columns = [Column(name, name not in (*names, *texts), name in names) for name in titles]
    cells = [[row.get(name, "") for name in titles] for row in rows]
    numbers = (k for row in cells for k, cell in enumerate(row) if isinstance(cell, Number))
    return Table(columns, cells, title, notes, min(numbers, default=1))


def significant(value: float, digits: int) -> str:
    """Return a number with some significant digits, up to 99999 without an exponent: "120" in place of 1.2e+02."""
    text = f"{value + 0.0:.{digits}g}"  # + 0.0: no zero is negative
    return f"{float(text):.0f}" if "e+" in text and abs(value) < 1e5 else text


def json_value(value: Any) -> Any:
    """Return numbers, arrays, lists and dicts as JSON values: NaN and infinity become None."""
    if hasattr(value, "tolist"):  # an array or a number of NumPy
        value = value.tolist()
    if isinstance(value, dict):
        return {key: json_value(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [json_value(entry) for entry in value]
    return None if isinstance(value, float) and not isfinite(value) else value
