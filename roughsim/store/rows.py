"""Rows of a long computation in one small HDF5 file that is whole after each of them, so that it can be resumed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from roughsim.errors import RecordError
from roughsim.store.disk import place_hdf5

Row = dict[str, float | str]
Tables = dict[str, dict[str, Row]]  # rows by table and name, in the order in which they came
CONTENT = "rows of roughsim"


class Rows:
    """Named rows in tables. Without a path nothing is stored; with `resume` the rows of its file are kept.

    RecordError if the file to resume holds no rows.
    """

    def __init__(self, path: str | Path | None, *, resume: bool = False):
        self.path = None if path is None else Path(path)
        self._tables = read_tables(self.path) if resume and self.path is not None and self.path.exists() else {}

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
            place_hdf5(self.path, self._fill, track_order=True)

    def _fill(self, file: Any) -> None:
        """Write a group per table and a dataset per column; what a row lacks is empty or NaN."""
        file.attrs["content"] = CONTENT
        for table, rows in self._tables.items():
            group = file.create_group(table, track_order=True)
            group.create_dataset("name", data=list(rows), dtype=h5py.string_dtype())
            for column in dict.fromkeys(key for row in rows.values() for key in row):
                is_text = any(isinstance(row.get(column), str) for row in rows.values())
                values = [row.get(column, "" if is_text else np.nan) for row in rows.values()]
                group.create_dataset(column, data=values, dtype=h5py.string_dtype() if is_text else "f8")


def read_tables(path: Path) -> Tables:
    """Return the rows of a file; RecordError if it holds others or is no HDF5."""
    tables: Tables = {}
    try:
        with h5py.File(path, "r", locking=False) as file:
            if file.attrs.get("content") != CONTENT:
                raise RecordError(f"{path} holds no rows to go on with; give another path")
            for table, group in file.items():
                columns = {
                    key: data.asstr()[()] if h5py.check_string_dtype(data.dtype) else data[()].tolist()
                    for key, data in group.items()
                }
                names = map(str, columns.pop("name"))
                rows = (dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True))
                tables[table] = dict(zip(names, rows, strict=True))
    except OSError as error:
        raise RecordError(f"{path} cannot be read as HDF5: {error}") from error
    return tables
