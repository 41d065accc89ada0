"""Where tables and lines are printed: every text as it is, whatever brackets, colons or control characters it has."""

from __future__ import annotations

import sys
from typing import Any

from rich.console import Console
from rich.text import Text

from roughsim.text import plain_lines

_PIPED = 150  # columns: a pipe has no width, and no number is to be broken


class PlainConsole(Console):
    """A console of rich on which no text is markup, an emoji or a command; styles are set by code alone."""

    def __init__(self, *, stderr: bool = False):
        stream = sys.stderr if stderr else sys.stdout  # None where it was closed before the start
        width = None if stream is not None and stream.isatty() else _PIPED
        super().__init__(stderr=stderr, markup=False, emoji=False, highlight=False, width=width)

    def render_str(self, text: str, **rest: Any) -> Text:
        """Return a text to render; all that is not rich's own comes by here: lines, cells, titles and captions."""
        return super().render_str(plain_lines(text), **rest)
