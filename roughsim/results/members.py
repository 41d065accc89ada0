"""The members of a run in memory: a table for each level, with a row per realization, however many there are."""

from __future__ import annotations

import calendar
import time
from collections.abc import Iterable, Iterator, MutableMapping
from contextlib import suppress
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from roughsim.observables.catalogue import NUMBERS
from roughsim.store.member_files import FIELD_UNITS, Member

Key = tuple[int, int]  # level and index
ABSENT, SOUND, FAILED = 0, 1, 2  # negative: the row comes from a summary, and its file was not seen yet
TIME_FORMAT = "%Y-%m-%dT%H:%M:%SZ"
# fields of every table, beside the numbers (NUMBERS) and the seconds of each stage
PROVENANCE: list[Any] = [
    ("state", "i1"),
    ("kept", "i1"),  # a bit for each field of FIELD_UNITS
    ("versions", "i2"),  # index into `Members.versions`
    ("residual", "f8"),
    ("iterations", "i8"),
    ("written", "f8"),  # s since 1970
    ("size", "i8"),  # of the file, bytes; 0 where it was not read
    ("changed", "i8"),  # of the file, ns
    ("digest", "u1", (32,)),  # SHA-256 of the file
]


class Stamp(NamedTuple):
    """What a member's file was when it was read: size in bytes, time of the last change in ns, and SHA-256."""

    size: int = 0
    changed: int = 0
    digest: bytes = bytes(32)


class Members(MutableMapping[Key, Member]):
    """Members by (level, index), without their spectra and fields.

    `every` has the stride of each level's realizations, `lengths` the sides of the cell, m, `speeds` are in m/s. Row r
    of a table is realization r·every. `failures` says why members failed, `versions` has those of packages.
    """

    def __init__(self, every: Iterable[int], lengths: tuple[float, float], speeds: tuple[float, ...]):
        self.every = list(every)
        numbers = [(name, "f8", (len(speeds) if n.per_speed else 1,)) for name, n in NUMBERS.items()]
        self.tables: list[NDArray[Any]] = [np.zeros(0, PROVENANCE + numbers) for _ in self.every]
        self.versions: list[dict[str, str]] = []
        self.failures: dict[Key, str] = {}
        self._lengths, self._speeds = lengths, speeds

    def __len__(self) -> int:
        return sum(int(np.count_nonzero(table["state"] > 0)) for table in self.tables)

    def __contains__(self, key: object) -> bool:
        level, index = cast(Key, key)
        row, rest = divmod(index, self.every[level])
        state = self.tables[level]["state"]
        return not rest and row < len(state) and bool(state[row] > 0)

    def __iter__(self) -> Iterator[Key]:
        for level, table in enumerate(self.tables):
            for row in np.flatnonzero(table["state"] > 0).tolist():
                yield level, row * self.every[level]

    def __getitem__(self, key: Key) -> Member:
        if key not in self:
            raise KeyError(key)
        level, index = key
        row = self.tables[level][index // self.every[level]]
        measured = {name: row[name].copy() for name in floats(row.dtype) if not np.all(np.isnan(row[name]))}
        provenance = {
            "residual": float(row["residual"]),
            "iterations": int(row["iterations"]),
            "versions": self.versions[row["versions"]],
            "seconds": {name: float(value[0]) for name, value in measured.items() if name not in NUMBERS},
            "written": "" if np.isnan(row["written"]) else time.strftime(TIME_FORMAT, time.gmtime(row["written"])),
        }
        failure = self.failures.get(key, "")
        return Member(
            level,
            index,
            failure,
            {} if failure else {name: value for name, value in measured.items() if name in NUMBERS},
            lengths=self._lengths,
            speeds=self._speeds,
            provenance=provenance,
            kept=tuple(name for bit, name in enumerate(FIELD_UNITS) if row["kept"] >> bit & 1),
        )

    def __setitem__(self, key: Key, member: Member) -> None:
        self.put(key, member, Stamp())

    def __delitem__(self, key: Key) -> None:
        if key not in self:
            raise KeyError(key)
        row = self.tables[key[0]][key[1] // self.every[key[0]]]
        row["state"] = row["size"] = 0
        self.failures.pop(key, None)

    def put(self, key: Key, member: Member, stamp: Stamp) -> None:
        """Store a member, and what its file was when it was read from it."""
        level, index = key
        provenance, seconds = member.provenance, member.provenance.get("seconds", {})
        versions = provenance.get("versions", {})
        if versions not in self.versions:
            self.versions.append(versions)
        self.failures.pop(key, None)
        if member.failure:
            self.failures[key] = member.failure
        written = np.nan
        with suppress(ValueError):
            written = calendar.timegm(time.strptime(provenance.get("written", ""), TIME_FORMAT))
        values = {
            "state": FAILED if member.failure else SOUND,
            "kept": sum(1 << bit for bit, name in enumerate(FIELD_UNITS) if name in member.kept),
            "versions": self.versions.index(versions),
            "residual": provenance.get("residual", np.nan),
            "iterations": provenance.get("iterations", 0),
            "written": written,
            "size": stamp.size,
            "changed": stamp.changed,
            "digest": np.frombuffer(stamp.digest, np.uint8),
        }
        row = index // self.every[level]
        table = self.table_for(level, row, seconds)
        table[row] = blank_rows(1, table.dtype)[0]
        for name, value in {**seconds, **member.numbers, **values}.items():
            table[name][row] = value

    def table_for(self, level: int, last_row: int, fields: Iterable[str]) -> NDArray[Any]:
        """Return the table of a level, made longer and wider if need be; unknown fields are seconds of stages."""
        table = self.tables[level]
        if last_row >= len(table):  # twice as long, so that a run of n members copies its rows O(log n) times
            table = np.concatenate([table, blank_rows(max(64, len(table), last_row + 1 - len(table)), table.dtype)])
        if new := [name for name in fields if name not in (table.dtype.names or ())]:
            wider = blank_rows(len(table), np.dtype([*table.dtype.descr, *((name, "f8", (1,)) for name in new)]))
            for name in table.dtype.names or ():
                wider[name] = table[name]
            table = wider
        self.tables[level] = table
        return table

    def adopt(self, level: int, indices: NDArray[np.int64], columns: dict[str, NDArray[Any]]) -> None:
        """Take over rows of a summary; each counts only after `confirm` has said that its file was seen."""
        rows = indices // self.every[level]
        table = self.table_for(level, int(rows.max(initial=0)), columns)
        for name, values in columns.items():
            table[name][rows] = values
        table["state"][rows] *= -1

    def adopted(self, level: int, index: int) -> Stamp | None:
        """Return what the file of an adopted row was when the summary was made; None if there is no such row."""
        row, table = index // self.every[level], self.tables[level]
        if row >= len(table) or table["state"][row] >= 0:
            return None
        size, changed, digest = (table[name][row] for name in Stamp._fields)
        return Stamp(int(size), int(changed), digest.tobytes())

    def confirm(self, level: int, index: int) -> None:
        """Let an adopted row count: its file is the one that the summary was made of."""
        self.tables[level]["state"][index // self.every[level]] *= -1

    def latest(self, count: int) -> list[float]:
        """Return when the latest files were written, s since 1970, in order; of members read from files only."""
        times = np.sort(np.concatenate([table["changed"][table["state"] > 0] for table in self.tables]))
        return [1e-9 * float(time) for time in times[times > 0][-count:]]

    def failed(self, level: int, count: int) -> NDArray[np.int64]:
        """Return the indices below `count` at which a level has no numbers."""
        every = self.every[level]
        return np.flatnonzero(self.tables[level]["state"][: -(-count // every)] == FAILED) * every

    def column(self, level: int, name: str, indices: NDArray[np.int64]) -> NDArray[Any]:
        """Return a field of the table at some realizations; numbers (n, speeds) or (n, 1), NaN where there is none."""
        rows: NDArray[Any] = self.tables[level][name][indices // self.every[level]]
        return rows


def floats(dtype: np.dtype[Any]) -> list[str]:
    """Return the fields of a table that are numbers of the member or seconds of its stages."""
    return [name for name in dtype.names or () if name not in {field[0] for field in PROVENANCE}]


def blank_rows(count: int, dtype: np.dtype[Any]) -> NDArray[Any]:
    """Return rows without a member: zeros, NaN for floats."""
    rows = np.zeros(count, dtype)
    for name in dtype.names or ():
        if rows[name].dtype.kind == "f":
            rows[name] = np.nan
    return rows
