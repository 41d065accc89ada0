"""One record of a table. It is made once; the terminal, plain text and HTML render the same titles, cells and notes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from roughsim.show.units import Number

Cell = str | Number
Row = Sequence[Cell]


@dataclass(frozen=True, slots=True)
class Column:
    """The title of a column, with its unit where all its numbers have one, and how its cells stand."""

    title: str
    number: bool = False  # cells stand right and are never broken
    name: bool = False  # cells name groups of rows: never broken, and empty where they repeat the one above


@dataclass(frozen=True, slots=True)
class Table:
    """A table for people: a cell for each column in every row."""

    columns: Sequence[Column]  # without any title there is no line of titles
    rows: Sequence[Row]
    title: str = ""  # stands above
    notes: Sequence[str] = ()  # stand below, a sentence or two each: what marks mean, what is missing

    def cells(self, k: int) -> list[str]:
        """Return the text of column k, a line per row; in a column of names a name is written once for its group."""
        texts = [[str(cell) for cell in row[: k + 1]] for row in self.rows]
        # a group begins anew where a name to the left of it does
        repeats = [self.columns[k].name and n > 0 and texts[n - 1] == row for n, row in enumerate(texts)]
        return ["" if repeat else row[k] for row, repeat in zip(texts, repeats, strict=True)]
