"""The members of a run in memory: a table for each level, with a row per realization, however many there are."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, MutableMapping
from itertools import compress
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from roughsim.observables.catalogue import NUMBERS
from roughsim.store.member_files import FIELD_UNITS, Member

Array = NDArray[np.float64]
Key = tuple[int, int]  # level and index
SOUND, FAILED = 1, 2  # states of a row; 0 without a member
# fields of every table, beside the numbers (NUMBERS) and the seconds of each stage
PROVENANCE: list[Any] = [
    ("state", "i1"),  # negative: the row comes from a summary, and its file was not seen yet
    ("kept", "?", (len(FIELD_UNITS),)),  # which fields are stored
    ("versions", "i2"),  # index into `Members.versions`
    ("residual", "f8"),
    ("iterations", "i8"),
    ("written", "U20"),  # as "2026-01-31T12:00:00Z"
    ("size", "i8"),  # of the file, bytes; 0 where it was not read
    ("changed", "i8"),  # of the file, ns
    ("digest", "u1", (32,)),  # SHA-256 of the file
    ("spectrum_start", "i8"),  # where the stress spectrum lies in the file, bytes; -1 where it was not found
    ("spectrum_check", "u4"),  # CRC-32 of its bytes
]
PROVENANCE_NAMES = {name for name, *_ in PROVENANCE}


class Stamp(NamedTuple):
    """What a member's file was when it was read: size in bytes, time of the last change in ns, and SHA-256.

    And where its stress spectrum lies, in bytes, with the CRC-32 of it; −1 where it was not found.
    """

    size: int = 0
    changed: int = 0
    digest: bytes = bytes(32)
    spectrum_start: int = -1
    spectrum_check: int = 0


class Members(MutableMapping[Key, Member]):
    """Members by (level, index), without their stress spectra and fields: about 1 kB each.

    `every` has the stride of each level's realizations, `lengths` the sides of the cell, m, `speeds` are in m/s. Row r
    of a table is realization r·every. `wavenumber` has that of the stress spectra of each level, rad/m. `failures` says
    why members failed, `versions` has those of packages.
    """

    def __init__(self, every: Iterable[int], lengths: tuple[float, float], speeds: tuple[float, ...]):
        self.every = list(every)
        numbers = [(name, "f8", (len(speeds) if n.per_speed else 1,)) for name, n in NUMBERS.items()]
        self.tables: list[NDArray[Any]] = [np.zeros(0, PROVENANCE + numbers) for _ in self.every]
        self.wavenumber: dict[int, Array] = {}
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
        row, failure = self.row(key), self.failures.get(key, "")
        names = [name for name in row.dtype.names or () if name not in PROVENANCE_NAMES]
        measured = {name: row[name].copy() for name in names if not np.all(np.isnan(row[name]))}
        provenance = {
            "residual": float(row["residual"]),
            "iterations": int(row["iterations"]),
            "versions": self.versions[row["versions"]],
            "seconds": {name: float(value[0]) for name, value in measured.items() if name not in NUMBERS},
            "written": str(row["written"]),
        }
        return Member(
            *key,
            failure,
            {} if failure else {name: value for name, value in measured.items() if name in NUMBERS},
            lengths=self._lengths,
            speeds=self._speeds,
            provenance=provenance,
            kept=tuple(compress(FIELD_UNITS, row["kept"])),
        )

    def __setitem__(self, key: Key, member: Member) -> None:
        self.put(key, member, Stamp())

    def __delitem__(self, key: Key) -> None:
        row = self.row(key)
        row["state"] = row["size"] = 0
        self.failures.pop(key, None)

    def row(self, key: Key) -> np.void:
        """Return the row of a member, which may be changed; KeyError if there is none."""
        if key not in self:
            raise KeyError(key)
        level, index = key
        return cast(np.void, self.tables[level][index // self.every[level]])

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
        elif member.wavenumber.size:
            self.wavenumber.setdefault(level, member.wavenumber)
        row = index // self.every[level]
        table = self.table_for(level, row, seconds)
        table[row] = blank_rows(1, table.dtype)[0]
        values = {
            **seconds,
            **member.numbers,
            "kept": [name in member.kept for name in FIELD_UNITS],
            "versions": self.versions.index(versions),
            "residual": provenance.get("residual", np.nan),
            "iterations": provenance.get("iterations", 0),
            "written": provenance.get("written", ""),
            **stamp._asdict(),
            "digest": np.frombuffer(stamp.digest, np.uint8),
            "state": FAILED if member.failure else SOUND,
        }
        for name, value in values.items():
            table[name][row] = value

    def table_for(self, level: int, last_row: int, stages: Iterable[str]) -> NDArray[Any]:
        """Return the table of a level, made longer and wider where it lacks the row or the seconds of a stage."""
        old = self.tables[level]
        new = [(name, "f8", (1,)) for name in stages if name not in (old.dtype.names or ())]
        if last_row >= len(old) or new:
            # twice as long, so that a run of n members copies its rows O(log n) times
            rows = max(64, 2 * len(old), last_row + 1) if last_row >= len(old) else len(old)
            self.tables[level] = blank_rows(rows, np.dtype([*old.dtype.descr, *new]))
            for name in old.dtype.names or ():
                self.tables[level][name][: len(old)] = old[name]
        return self.tables[level]

    def adopt(self, level: int, table: NDArray[Any], wavenumber: Array) -> None:
        """Take over a level of a summary; ValueError, LookupError for another layout.

        Each row counts only after `confirm` has said that its file was seen.
        """
        own = self.tables[level].dtype
        if any(table.dtype[name] != own[name] for name in own.names or ()):
            raise ValueError("the summary has numbers of other shapes")
        if wavenumber.size:
            self.wavenumber[level] = wavenumber
        self.tables[level] = table
        table["state"] *= -1

    def adopted(self, level: int, index: int) -> Stamp | None:
        """Return what the file of an adopted row was when the summary was made; None if there is no such row."""
        row, table = index // self.every[level], self.tables[level]
        if row >= len(table) or table["state"][row] >= 0:
            return None
        stamp = {name: table[name][row] for name in Stamp._fields}
        return Stamp(**stamp | {"digest": stamp["digest"].tobytes()})

    def confirm(self, level: int, index: int, changed: int) -> None:
        """Let an adopted row count: its file is the one that the summary was made of, be it copied; `changed` in ns."""
        row = self.tables[level][index // self.every[level]]
        row["state"], row["changed"] = -row["state"], changed

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


def blank_rows(count: int, dtype: np.dtype[Any]) -> NDArray[Any]:
    """Return rows without a member: zeros, NaN for floats."""
    rows = np.zeros(count, dtype)
    for name in dtype.names or ():
        if rows[name].dtype.kind == "f":
            rows[name] = np.nan
    return rows
