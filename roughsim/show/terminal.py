"""Where tables and lines are printed: every text as it is, whatever brackets, colons or control characters it has."""

from __future__ import annotations

import sys
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from roughsim.show.text import plain_lines

_PIPED = 150  # columns: a pipe has no width, and no number is to be broken
_WIDEST = 500  # columns of a table whose numbers are whole


class PlainConsole(Console):
    """A console of rich on which no text is markup, an emoji or a command; styles are set by code alone."""

    def __init__(self, *, stderr: bool = False):
        stream = sys.stderr if stderr else sys.stdout  # None where it was closed before the start
        width = None if stream is not None and stream.isatty() else _PIPED
        super().__init__(stderr=stderr, markup=False, emoji=False, highlight=False, width=width)

    def print_whole(self, part: Any) -> None:
        """Print a line, or a table of which no number is cut: a terminal that is too narrow wraps its rows."""
        if isinstance(part, Table):
            wide = self.options.update(max_width=_WIDEST)
            for column in part.columns:
                if column.no_wrap:
                    cells = (column.header, *column.cells)
                    column.min_width = max(self.measure(cell, options=wide).maximum for cell in cells)
            self.width = max(self.width, self.measure(part, options=wide).minimum)
        self.print(part, soft_wrap=isinstance(part, str))

    def render_str(self, text: str, **rest: Any) -> Text:
        """Return a text to render; all that is not rich's own comes by here: lines, cells, titles and captions."""
        return super().render_str(plain_lines(text), **rest)
