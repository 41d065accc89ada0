"""Rows of a long computation in one small JSON file that is whole after each of them, so that it can be resumed."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

from roughsim.errors import RecordError
from roughsim.store.disk import place_bytes

Row = dict[str, float | str]
CONTENT = "rows of roughsim"


class Rows:
    """Named rows in tables. Without a path nothing is stored; with `resume` the rows of its file are kept.

    RecordError if the file to resume holds no rows.
    """

    def __init__(self, path: str | Path | None, *, resume: bool = False):
        self.path = None if path is None else Path(path)
        self._tables: dict[str, dict[str, Row]] = {}  # rows by table and name, in the order in which they came
        if resume and self.path is not None and self.path.exists():
            try:
                self._tables = dict(json.loads(self.path.read_text("utf-8"))[CONTENT])
            except (ValueError, LookupError, TypeError) as error:
                raise RecordError(f"{path} holds no rows to go on with ({error}); give another path") from error

    def __getitem__(self, table: str) -> dict[str, Row]:
        """The rows of a table by name."""
        return dict(self._tables.get(table, {}))

    def once(self, table: str, name: str, compute: Callable[[], Row]) -> Row:
        """Return the row of this name: the stored one, or what `compute` gives, stored before it is returned."""
        if name not in self[table]:
            self.extend(table, {name: compute()})
        return self._tables[table][name]

    def extend(self, table: str, rows: dict[str, Row]) -> None:
        """Store several rows at once."""
        self._tables.setdefault(table, {}).update(rows)
        if self.path is not None:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            place_bytes(self.path, json.dumps({CONTENT: self._tables}, indent=1).encode())
