"""Rows of a long computation in one small HDF5 file, which is whole after each of them and can be gone on with."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from roughsim.errors import RecordError
from roughsim.store.disk import place_hdf5

Row = dict[str, float | str]
_MARK = "rows of roughsim"


class Rows:
    """Named rows in tables: a group per table, a dataset per column, written beside its place and moved into it.

    Parameters
    ----------
    path : str or Path or None
        The file; its folder is made if need be. None: nothing is stored.
    resume : bool, optional
        Whether to keep what is there; else the file is written anew.

    Raises
    ------
    RecordError
        If the file to go on with is none of these.
    """

    def __init__(self, path: str | Path | None, *, resume: bool = False):
        self.path = None if path is None else Path(path)
        self._tables: dict[str, dict[str, Row]] = {}
        if resume and self.path is not None and self.path.exists():
            self._read(self.path)

    def once(self, table: str, name: str, compute: Callable[[], Row]) -> Row:
        """Return the row of this name: the stored one, or what `compute` gives, stored before it is returned."""
        rows = self._tables.setdefault(table, {})
        if name not in rows:
            rows[name] = compute()
            self._write()
        return rows[name]

    def extend(self, table: str, rows: dict[str, Row]) -> None:
        """Store several rows at once."""
        self._tables.setdefault(table, {}).update(rows)
        self._write()

    def __getitem__(self, table: str) -> dict[str, Row]:
        """The rows of a table by name, in the order in which they came."""
        return dict(self._tables.get(table, {}))

    def _write(self) -> None:
        if self.path is None:
            return
        self.path.parent.mkdir(parents=True, exist_ok=True)
        place_hdf5(self.path, self._fill, track_order=True)

    def _fill(self, file: Any) -> None:
        import h5py
        import numpy as np

        file.attrs["content"] = _MARK
        for table, rows in self._tables.items():
            group = file.create_group(table, track_order=True)
            group.create_dataset("name", data=list(rows), dtype=h5py.string_dtype())
            for column in dict.fromkeys(key for row in rows.values() for key in row):
                words = any(isinstance(row.get(column), str) for row in rows.values())
                values = [row.get(column, "" if words else np.nan) for row in rows.values()]
                group.create_dataset(column, data=values, dtype=h5py.string_dtype() if words else "f8")

    def _read(self, path: Path) -> None:
        import h5py

        try:
            with h5py.File(path, "r", locking=False) as file:
                if file.attrs.get("content") != _MARK:
                    raise RecordError(f"{path} holds no rows to go on with; give another path")
                for table, group in file.items():
                    columns = {key: _values(data) for key, data in group.items()}
                    names = columns.pop("name")
                    rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
                    self._tables[table] = dict(zip(map(str, names), rows, strict=True))
        except OSError as error:
            raise RecordError(f"{path} cannot be read as HDF5: {error}") from error


def _values(data: object) -> list[float | str]:
    import h5py

    assert isinstance(data, h5py.Dataset)
    texts = h5py.check_string_dtype(data.dtype) is not None
    return list(data.asstr()[()]) if texts else [float(value) for value in data[()]]


__all__ = ["Row", "Rows"]
