"""The members of a run in memory: a table for each level, with a row per realization, however many there are.

A summary beside the members has the same tables: it saves time and decides nothing. A row of it counts only while the
member's file has the same digest. A summary that is missing, damaged or of another run is ignored. Layout: a line of
JSON, for each level its table and wavenumbers as NumPy's .npy files, and the SHA-256 of all that.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator, MutableMapping
from contextlib import suppress
from io import BytesIO
from itertools import compress
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from roughsim.observables.catalogue import NUMBERS
from roughsim.store.disk import place_bytes, read_bytes
from roughsim.store.member_files import FIELD_UNITS, Member

Array = NDArray[np.float64]
Key = tuple[int, int]  # level and index
SUMMARY = "summary.bin"
HASH_BYTES = 32
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
    ("digest", "S64"),  # SHA-256 of the file, hexadecimal
    ("spectrum_start", "i8"),  # where the stress spectrum lies in the file, bytes
    ("spectrum_check", "u4"),  # CRC-32 of its bytes
]
PROVENANCE_NAMES = {name for name, *_ in PROVENANCE}


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
        self.put(key, member)

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

    def put(self, key: Key, member: Member, **file: Any) -> None:
        """Store a member, and what its file was when it was read: size, changed, digest and place of the spectrum."""
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
        table[row] = np.zeros((), table.dtype)
        values = {
            **{name: np.nan for name in table.dtype.names or () if table[name].dtype.kind == "f"},
            **seconds,
            **member.numbers,
            **{name: provenance[name] for name in ("residual", "iterations", "written") if name in provenance},
            **file,
            "kept": [name in member.kept for name in FIELD_UNITS],
            "versions": self.versions.index(versions),
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
            self.tables[level] = np.zeros(rows, [*old.dtype.descr, *new])
            for name in old.dtype.names or ():
                self.tables[level][name][: len(old)] = old[name]
        return self.tables[level]

    def unseen(self, level: int, index: int) -> np.void | None:
        """Return a row that comes from a summary and whose file was not seen yet, to be changed; else None."""
        row, table = index // self.every[level], self.tables[level]
        return cast(np.void, table[row]) if row < len(table) and table["state"][row] < 0 else None

    def load(self, path: Path, run: str) -> dict[str, Any]:
        """Let members, of which there are none yet, come from a summary, unseen, and return what `save` got as `stop`.

        Nothing happens, and `stop` is empty, without a summary that is whole, of this run and of these tables.
        """
        with suppress(OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError, MemoryError):
            content = read_bytes(path)
            file = BytesIO(content)
            header = json.loads(file.readline())
            whole = hashlib.sha256(memoryview(content)[:-HASH_BYTES]).digest() == content[-HASH_BYTES:]
            if not whole or header["run"] != run:
                return {}
            levels = [(old, np.load(file), np.load(file)) for old in self.tables]
            if any(new.dtype[name] != old.dtype[name] for old, new, _ in levels for name in old.dtype.names or ()):
                return {}
            failures = {(level, index): reason for level, index, reason in header["failures"]}
            versions, stop = list(header["versions"]), dict(header["stop"])
            for _, table, _ in levels:
                table["state"] *= -1
            self.tables = [table for _, table, _ in levels]
            self.wavenumber = {level: q for level, (_, _, q) in enumerate(levels) if q.size}
            self.versions, self.failures = versions, failures
            return stop
        return {}

    def save(self, path: Path, run: str, stop: dict[str, Any]) -> None:
        """Write a summary of all members that were read from files, whole or not at all; a folder may take no files."""
        in_file = [key for key in self.failures if key in self and self.row(key)["size"]]
        failures = [[*key, self.failures[key]] for key in in_file]
        header = {"run": run, "versions": self.versions, "failures": failures, "stop": stop}
        file = BytesIO()
        file.write(json.dumps(header).encode() + b"\n")
        for level, rows in enumerate(self.tables):
            seen = (rows["state"] > 0) & (rows["size"] > 0)
            table = rows[: np.max(np.flatnonzero(seen), initial=-1) + 1].copy()
            table["state"][~seen[: len(table)]] = 0
            np.save(file, table)
            np.save(file, self.wavenumber.get(level, np.empty(0)))
        content = file.getbuffer()
        with suppress(OSError):
            place_bytes(path, content, hashlib.sha256(content).digest())

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
