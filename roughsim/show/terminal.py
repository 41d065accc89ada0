"""Printing tables and lines to a terminal; brackets, colons and control characters in a text have no effect."""

import sys
from collections.abc import Sequence
from dataclasses import replace
from io import StringIO
from textwrap import fill, wrap
from typing import IO, Any

import rich.table
from rich.cells import cell_len
from rich.console import Console
from rich.text import Text

from roughsim.show.table import Table
from roughsim.show.text import marked, plain_lines, say, tell

PIPED = 150  # columns: a pipe has no width, and no number is to be broken
_NARROW, _LINES = 80, 24  # of a first screen, below a line on slow work
_MOST_REMARKS = 3  # of a first screen
_WIDEST = 500  # columns of a table whose numbers are whole
_LEAST_TEXT = (
    12  # columns that a text may be narrowed to; longer words, such as paths, are then broken
)


class PlainConsole(Console):
    """A console of rich that takes no text as markup, emoji or command; only code sets styles."""

    def __init__(self, *, stderr: bool = False, file: IO[str] | None = None, piped: int = PIPED):
        stream = file or (
            sys.stderr if stderr else sys.stdout
        )  # None if it was closed before the start
        width = None if stream is not None and stream.isatty() else piped
        super().__init__(
            stderr=stderr, file=file, markup=False, emoji=False, highlight=False, width=width
        )

    def render_str(self, text: str, **rest: Any) -> Text:
        """Return a text to render, made harmless: rich calls this for every line, cell and title."""
        return super().render_str(plain_lines(text), **rest)

    def print_parts(self, *parts: str | Table) -> None:
        """Print lines and tables, an empty line between tables."""
        for before, part in zip((None, *parts), parts, strict=False):
            if isinstance(part, str):
                self.print(part, soft_wrap=True)
                continue
            if isinstance(before, Table):
                self.print()
            self.print_table(part)

    def print_table(self, table: Table) -> None:
        """Print a table of which no number is cut: in a terminal that is too narrow, text is wrapped, then rows are."""
        grid = rich.table.Table(
            box=None, pad_edge=False, show_header=any(c.title for c in table.columns)
        )
        cells = [table.cells(k) for k in range(len(table.columns))]
        for column, texts in zip(table.columns, cells, strict=True):
            if (
                column.number or column.name
            ):  # cells stay whole, the title takes two lines above them
                widest = max(
                    (len(column.title) + 1) // 2, 0, *map(cell_len, (*column.title.split(), *texts))
                )
                title = "\n".join(wrap(column.title, max(widest, 1)))
                justify: Any = "right" if column.number else "left"
                grid.add_column(title, justify=justify, no_wrap=True, min_width=widest)
            else:
                longest = max(map(cell_len, " ".join((column.title, *texts)).split()), default=0)
                grid.add_column(column.title, overflow="fold", min_width=min(longest, _LEAST_TEXT))
        for row in zip(*cells, strict=True):
            grid.add_row(*row)
        if table.title:
            self.print(table.title, style="italic")
        least = self.measure(grid, options=self.options.update(max_width=_WIDEST)).minimum
        width, self.width = self.width, max(self.width, least)
        self.print(grid)
        self.width = width
        for note in table.notes:
            self.print(note, style="dim")


def print_first_screen(
    short: Table, whole: Sequence[Table], warnings: Sequence[str], screens: int = 1
) -> None:
    """Print a short table, the most serious warnings, and what --all adds: 25 lines of 80 columns for all `screens`.

    The table has its most important rows first; the last ones are left out where there is no room. `whole` are the
    tables of --all.
    """
    told = [
        fill(f"roughsim: {line}", _NARROW, subsequent_indent="  ", break_on_hyphens=False)
        for line in marked(warnings[:_MOST_REMARKS])
    ]
    room = _LINES // screens - 1 - sum(text.count("\n") + 1 for text in told)
    rows = list(short.rows)
    while len(rows) > 1 and table_text(replace(short, rows=rows), _NARROW).count("\n") >= room:
        del rows[-1]
    PlainConsole(piped=_NARROW).print_table(replace(short, rows=rows))
    for text in told:
        tell(text)
    more = f"{sum(len(table.rows) for table in whole)} rows"
    if len(warnings) > len(told):
        more += f", and {len(warnings) - len(told)} more warnings"
    say(f"--all prints {more}, with reasons.")


def table_text(table: Table, width: int = PIPED) -> str:
    """Return a table as plain text, of at most `width` columns if its numbers allow it."""
    file = StringIO()
    PlainConsole(file=file, piped=width).print_table(table)
    return "\n".join(line.rstrip() for line in file.getvalue().splitlines())
