"""Text files of numbers: separators, decimal commas, and columns or rows that are no heights."""

import re
from itertools import product
from typing import NamedTuple

import numpy as np

from roughsim.grid import Array
from roughsim.surface.topography.contents import EVEN, UNITS, Contents, NoHeightsError, even_step

_NO_UNITS = ("", "1", "-", "px", "pixel", "pixels", "raw")  # in a heading
# in place of a number
_UNDEFINED = {"", "bad", "na", "n/a", "null", "none", "-", "--", "---", "***"}
_DECIMAL_COMMA = re.compile(
    r"[-+]?\d*,\d+(?:[eE][-+]?\d+)?|[-+]?\d+(?:[eE][-+]?\d+)?|[-+]?nan|[-+]?inf", re.IGNORECASE
)
_CONTROL = re.compile(r"[\x00-\x08\x0e-\x19\x1b-\x1f]")
_SAMPLE = 20  # lines that show how numbers are divided
_BESIDE = 3  # lines beside the first that show how straight lines of heights are
_ROUGH = 10  # lines beside the first that show how far lines are apart
_ROUNDING = 1e-6  # of the largest height: nearer to a straight line a line is straight
_STRAIGHT = 0.01  # of their distance from a straight line: below it a line is no line of heights
_JUMP = 10.0  # steps between lines of heights: above it a line does not belong to them


class NumberLayout(NamedTuple):
    """How the numbers of a line are divided."""

    divider: str | None  # None: blanks
    comma: bool  # whether it is the decimal sign

    def split(self, line: str) -> list[str]:
        """Return the fields of a line."""
        return [field.strip() for field in line.replace('"', "").strip().split(self.divider)]

    def fields(self, line: str) -> list[str]:
        """Return the fields of a line, with decimal points."""
        fields = self.split(line)
        return [field.replace(",", ".") for field in fields] if self.comma else fields

    def fits(self, line: str) -> bool:
        """Whether a line holds numbers alone, divided so."""
        if self.divider is not None and self.divider not in line:
            return False
        values = [field for field in self.split(line) if field.lower() not in _UNDEFINED]
        number = _DECIMAL_COMMA.fullmatch if self.comma else _is_number
        return bool(values) and all(map(number, values))


_LAYOUTS = [
    *(NumberLayout(*one) for one in product((";", "\t", None), (False, True))),
    NumberLayout(",", False),
]


class NumberTable(NamedTuple):
    """The numbers of a text, and the lines before them."""

    numbers: Array  # undefined ones NaN
    header: list[str]
    layout: NumberLayout


def decoded(content: bytes) -> str | None:
    """Return the text of a file, None if it is no text."""
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        text = content.decode("utf-16", errors="replace")
    else:
        try:
            text = content.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = content.decode("latin-1")
    return None if _CONTROL.search(text) else text


def table_of(text: str) -> NumberTable:
    """Return the numbers of a text; NoHeightsError that names the first line with anything else."""
    lines = [(k, line) for k, line in enumerate(text.splitlines(), start=1) if line.strip()]
    plain = [(k, line.split("#")[0]) for k, line in lines]
    of_numbers = (i for i, (_, line) in enumerate(plain) if any(one.fits(line) for one in _LAYOUTS))
    first = next(of_numbers, None)
    if first is None:
        raise NoHeightsError("holds no numbers; is it the right file?")
    data = [(k, line) for k, line in plain[first:] if line.strip()]
    layout = _layout_of([line for _, line in data[:_SAMPLE]])
    numbers = _numbers_of(data, layout)
    ends_in_divider = data[0][1].rstrip().endswith(layout.divider or "\n")
    if numbers.shape[1] > 1 and ends_in_divider and np.isnan(numbers[:, -1]).all():
        numbers = numbers[:, :-1]
    numbers[np.isinf(numbers)] = np.nan
    return NumberTable(numbers, [line for _, line in lines[:first]], layout)


def _numbers_of(data: list[tuple[int, str]], layout: NumberLayout) -> Array:
    """Return the numbers of lines, each with its line number; NoHeightsError unless all have the same count."""
    rows: list[Array] = []
    for k, line in data:
        fields = layout.fields(line)
        try:
            row = np.array([_number(field) for field in fields])
        except ValueError:
            wrong = next(field for field in fields if not _is_number(field))
            raise NoHeightsError(f"must hold numbers alone: line {k} has {wrong[:40]!r}") from None
        rows.append(row)
        if row.size != rows[0].size:
            raise NoHeightsError(
                f"must hold as many numbers in each line: line {data[0][0]} has {rows[0].size}, line {k} has {row.size}"
            )
    return np.array(rows)


def refuse_damaged(lines: list[str]) -> None:
    """Raise a NoHeightsError that names a line of numbers which are not all numbers: readers of headers skip it."""
    for line, divider in product(lines, (";", "\t", None, ",")):
        fields = [field.strip() for field in line.split("#")[0].split(divider)]
        wrong = [field for field in fields if not _is_number(field.replace(",", "."))]
        if wrong and len(fields) > 3 and 2 * len(wrong) < len(fields):
            raise NoHeightsError(f"has {wrong[0][:40]!r} in a line of numbers; it is damaged")


def _layout_of(lines: list[str]) -> NumberLayout:
    """Return the layout of the numbers of these lines; NoHeightsError if it is ambiguous."""
    fitting = [one for one in _LAYOUTS if all(one.fits(line) for line in lines)]
    if not fitting:  # a line further down is no line of numbers: it is named when it is read
        return next(one for one in _LAYOUTS if one.fits(lines[0]))
    ambiguous = {NumberLayout(None, True), NumberLayout(",", False)} <= {*fitting}
    if ambiguous and not any(" " in line.strip() for line in lines):
        raise NoHeightsError(
            f"has lines like {lines[0].strip()[:40]!r}: one number with a decimal comma, or two; divide numbers by "
            "semicolons or blanks"
        )
    return fitting[0]


def heights_of(table: NumberTable) -> Contents:
    """Return the heights of a table of numbers: a map, a line scan, or a list of coordinates and heights.

    Line k of a map has the heights at the k-th point along x. One column or one line of heights is a line scan, two
    columns one with its positions, and three columns are a list of x, y and height on a grid. Units are read from the
    heading of these columns.
    """
    numbers = table.numbers
    columns = numbers.shape[1]
    left_out, units = _heading_of(table)
    if 1 in numbers.shape:
        unit = units[-1] if columns == 1 else None
        return Contents(numbers.ravel(), unit=unit, left_out=left_out)
    if columns == 2:
        step = even_step(numbers[:, 0], "positions in its first column")
        heights = numbers[:, 1] if step > 0.0 else numbers[::-1, 1]
        return Contents(heights, (abs(step) * len(numbers),), units[1], units[0], left_out=left_out)
    if columns == 3:
        return _listed(numbers, units, left_out)
    return without_coordinates(numbers, left_out)


def _heading_of(table: NumberTable) -> tuple[tuple[str, ...], list[float | None]]:
    """Return the lines left out, and the unit of each column in m, None without one; NoHeightsError for other lines.

    A heading has a name for each column, with its unit as in "x/um", "x [um]", "x (um)", "x_um", or below its name.
    """
    columns = table.numbers.shape[1]
    names = [line for line in table.header if not line.lstrip().startswith("#")]
    bare = [line.lstrip(" #") for line in table.header]
    rows = [row for row in map(table.layout.fields, bare) if len(row) == columns]
    below = [[UNITS.get(field.strip(" /[]()").lower()) for field in row] for row in rows]
    found = next((units for units in below if None not in units), None)
    own = _fields_of_heading(names[0], table.layout) if names else []
    if names and (len(names) > 1 + (found is not None) or len(own) != columns):
        raise NoHeightsError(
            f"must hold numbers alone, but line 1 is {names[0].strip()[:40]!r}; remove such lines"
        )
    for name in own if columns <= 3 and found is None else ():
        known = _unit_in(name) is not None or name.rpartition("/")[2].lower() in _NO_UNITS
        if "/" in name and not known:
            raise NoHeightsError(
                f"has a unit that is not known in its heading, {name[:40]!r}; write m, mm, um or nm"
            )
    headings = [_fields_of_heading(line, table.layout) for line in bare]
    beside = [[_unit_in(field) for field in row] for row in headings if len(row) == columns]
    nothing: list[float | None] = [None] * columns
    units = found or next((units for units in beside if any(units)), nothing)
    return ("its first line, names of columns",) * bool(names), units


def _fields_of_heading(line: str, layout: NumberLayout) -> list[str]:
    """Return the names of columns; units in brackets, which blanks may set off, follow them as in "x/um"."""
    joined = re.sub(r"\s*[\[(]\s*([^\s\]),;]*)[^\])]*[\])]", r"/\1", line)
    return layout.fields(joined)


def _unit_in(name: str) -> float | None:
    """Return the unit at the end of the name of a column, m, None without one."""
    match = re.search(r"[/_\s]([^\W\d_]+)$", name.strip())
    return UNITS.get(match[1].lower()) if match else None


def _listed(numbers: Array, units: list[float | None], left_out: tuple[str, ...]) -> Contents:
    """Return the map of a list of x, y and height; points of the grid that are not in the list are undefined."""
    places = []
    sizes = []
    for name, values in zip("xy", numbers.T[:2], strict=True):
        if not np.isfinite(values).all():
            raise NoHeightsError(f"has three columns, x, y and height, but an undefined {name}")
        ordered = np.sort(values)
        several = np.diff(ordered) > 1e-6 * (ordered[-1] - ordered[0])
        if not several.any():
            raise NoHeightsError(
                f"has three columns, x, y and height, but one {name} alone; a map has many"
            )
        distinct = ordered[np.append(True, several)]
        step = even_step(distinct, f"x, y and height in three columns, and {name}")
        places.append(np.rint((values - ordered[0]) / step).astype(np.intp))
        sizes.append(step * distinct.size)
    shape = int(places[0].max()) + 1, int(places[1].max()) + 1
    if shape[0] * shape[1] > 4 * len(numbers):
        raise NoHeightsError(
            f"lists {len(numbers)} points of a grid of {shape}; put its heights on a grid first"
        )
    heights = np.full(shape, np.nan)
    if np.unique(places[0] * shape[1] + places[1]).size < len(numbers):
        raise NoHeightsError("lists a point twice; put its heights on a grid first")
    heights[places[0], places[1]] = numbers[:, 2]
    x, y, unit = units
    if (x is None) != (y is None):
        raise NoHeightsError("has a unit of x or of y in its heading, but not of both; write both")
    if x is not None and y is not None:
        sizes[1] *= y / x
    return Contents(heights, (sizes[0], sizes[1]), unit, x, left_out=left_out)


def without_coordinates(numbers: Array, left_out: tuple[str, ...] = ()) -> Contents:
    """Return a map without a first line and a first column of evenly rising or falling numbers, which are no heights.

    Such are the index and the header of `pandas.DataFrame.to_csv`, and coordinates.
    """
    line = _counts(numbers[0, 1:], numbers[1:, 1:])
    column = _counts(numbers[1:, 0], numbers[1:, 1:].T)
    found = ["line"] * line + ["column"] * column
    found = [f"its first {name}, which counts in even steps" for name in found]
    return Contents(numbers[int(line) :, int(column) :], left_out=(*left_out, *found))


def _counts(line: Array, others: Array) -> bool:
    """Whether a line goes in even steps, as coordinates do, and the lines of heights beside it do not.

    Either it is a straight line to rounding while the others are rough. Or it rises or falls at each step, nearly
    evenly, and is far from the line beside it. A tilted map has neither: its lines are as straight as the first.
    """
    if line.size < 3 or len(others) < 2 or not np.isfinite(line).all():
        return False
    step = float(line[-1] - line[0]) / (line.size - 1)
    bend = float(np.abs(line - line[0] - step * np.arange(line.size)).max())
    if step == 0.0 or bend > 0.6 * abs(step):
        return False
    beside = others[:_BESIDE]
    rough = min(_distance_from_straight(row) for row in beside)
    jumps = np.abs(np.diff(others[:_ROUGH], axis=0))
    apart = np.abs(line - others[0])
    jumps = jumps[np.isfinite(jumps)]
    apart = apart[np.isfinite(apart)]
    if not (jumps.size and apart.size):
        return False
    straight = bend < _STRAIGHT * rough and bend <= EVEN * abs(step)
    if straight and rough > _ROUNDING * np.nanmax(np.abs(beside)):
        return True
    return bool((np.diff(line) / step > 0.0).all() and apart.mean() > _JUMP * jumps.mean() > 0.0)


def _distance_from_straight(row: Array) -> float:
    """Return how far a line of heights is from a straight one, at most; 0 of fewer than three points."""
    present = np.flatnonzero(np.isfinite(row))
    if present.size < 3:
        return 0.0
    line = np.polyval(np.polyfit(present, row[present], 1), present)
    return float(np.abs(row[present] - line).max())


def _number(field: str) -> float:
    """Return the number of a field, NaN if undefined; ValueError for anything else, and for Python's 1_000."""
    if "_" in field:
        raise ValueError
    return np.nan if field.lower() in _UNDEFINED else float(field)


def _is_number(field: str) -> bool:
    try:
        _number(field)
    except ValueError:
        return False
    return True
