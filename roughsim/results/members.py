"""The members of a run in memory, and their summary on disk: a table for each level, with a row per realization.

The summary has the same tables, and saves the time to read all files again. A row of it counts only while the member's
file has the same digest. A summary that is missing, damaged or of another run is ignored. Its layout: a line of JSON,
for each level its table and wavenumbers in NumPy's .npy format, and the SHA-256 of all that.
"""

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from io import BytesIO
from itertools import compress
from math import isnan
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from roughsim.grid import Array
from roughsim.observables.catalogue import NUMBERS
from roughsim.store.disk import place_bytes, read_bytes
from roughsim.store.member_files import STAGES, Member
from roughsim.store.member_hdf5 import STORED

Key = tuple[int, int]  # level and index
SUMMARY = "summary.bin"
HASH_BYTES = 32
SOUND, FAILED = 1, 2  # states of a row; 0 without a member
# fields of every table, beside the numbers (NUMBERS)
PROVENANCE: list[Any] = [
    ("state", "i1"),  # negative: the row comes from a summary, and its file was not seen yet
    ("kept", "?", (len(STORED),)),  # which fields are stored
    ("versions", "i2"),  # index into `Members.versions`
    ("residual", "f8"),
    ("iterations", "i8"),
    ("seconds", "f8", (len(STAGES),)),
    ("written", "U20"),  # as "2026-01-31T12:00:00Z"
    ("size", "i8"),  # of the file, bytes; 0 where it was not read
    ("changed", "i8"),  # of the file, ns
    ("digest", "S64"),  # SHA-256 of the file, hexadecimal
    ("spectrum_start", "i8"),  # where the stress spectrum lies in the file, bytes
    ("spectrum_check", "u4"),  # CRC-32 of its bytes
]


class Members(Mapping[Key, Member]):
    """Members by (level, index), without their stress spectra and fields: about 1 kB each.

    `every` has the stride of each level's realizations, `lengths` the sides of its cell, m, `speeds` are in m/s. Row r
    of a table is realization r·every. `march` is the level of marches, None without. `wavenumber` has that of the
    stress spectra of each level, rad/m. `failures` says why members failed, `versions` has those of packages.
    """

    def __init__(
        self,
        every: Iterable[int],
        lengths: list[tuple[float, float]],
        speeds: tuple[float, ...],
        march: int | None = None,
    ):
        self.every, self.march = list(every), march
        numbers = [(name, "f8", (len(speeds) if n.per_speed else 1,)) for name, n in NUMBERS.items()]
        self.tables: list[NDArray[Any]] = [np.zeros(0, PROVENANCE + numbers) for _ in self.every]
        self.wavenumber: dict[int, Array] = {}
        self.versions: list[dict[str, str]] = []
        self.failures: dict[Key, str] = {}
        self._count = 0
        self._lengths, self._speeds = lengths, speeds

    def __len__(self) -> int:
        return self._count

    def __contains__(self, key: object) -> bool:
        row = self.row(cast(Key, key))
        return row is not None and bool(row["state"] > 0)

    def __iter__(self) -> Iterator[Key]:
        for level, table in enumerate(self.tables):
            for row in np.flatnonzero(table["state"] > 0).tolist():
                yield level, row * self.every[level]

    def __getitem__(self, key: Key) -> Member:
        if key not in self:
            raise KeyError(key)
        row, failure = self.row(key), self.failures.get(key, "")
        seconds = zip(STAGES, row["seconds"].tolist(), strict=True)
        provenance = {
            "residual": float(row["residual"]),
            "iterations": int(row["iterations"]),
            "versions": self.versions[row["versions"]],
            "seconds": {stage: time for stage, time in seconds if not isnan(time)},
            "written": str(row["written"]),
        }
        return Member(
            *key,
            failure,
            {} if failure else {name: row[name].copy() for name in NUMBERS if not np.all(np.isnan(row[name]))},
            lengths=self._lengths[key[0]],
            speeds=self._speeds,
            provenance=provenance,
            kept=tuple(compress(STORED, row["kept"])),
        )

    def __delitem__(self, key: Key) -> None:
        row = self.row(key)
        self._count -= bool(row["state"] > 0)
        row["state"] = row["size"] = 0
        self.failures.pop(key, None)

    def row(self, key: Key) -> Any:
        """Return the row of a member, which may be changed; its state may be 0; None where the table has no row."""
        level, index = key
        row, rest = divmod(index, self.every[level])
        return self.tables[level][row] if not rest and row < len(self.tables[level]) else None

    def put(self, key: Key, member: Member, **file: Any) -> None:
        """Store a member, and size, time, digest and place of the spectrum of its file when it was read."""
        level, index = key
        provenance, versions = member.provenance, member.provenance.get("versions", {})
        if versions not in self.versions:
            self.versions.append(versions)
        self.failures.pop(key, None)
        if member.failure:
            self.failures[key] = member.failure
        elif member.wavenumber.size:
            self.wavenumber.setdefault(level, member.wavenumber)
        table, row = self.tables[level], index // self.every[level]
        if row >= len(table):  # twice as long, so that a run of n members copies its rows O(log n) times
            more = np.zeros(max(64, len(table), row + 1 - len(table)), table.dtype)
            table = self.tables[level] = np.concatenate([table, more])
        self._count += bool(table["state"][row] <= 0)
        table[row] = np.zeros((), table.dtype)
        values: dict[str, Any] = {
            **dict.fromkeys((*NUMBERS, "residual"), np.nan),
            **member.numbers,
            **{name: provenance[name] for name in ("residual", "iterations", "written") if name in provenance},
            **file,
            "seconds": [provenance.get("seconds", {}).get(stage, np.nan) for stage in STAGES],
            "kept": [name in member.kept for name in STORED],
            "versions": self.versions.index(versions),
            "state": FAILED if member.failure else SOUND,
        }
        for name, value in values.items():
            table[name][row] = value

    def see(self, key: Key, changed: int) -> None:
        """Count a member of a summary, whose file was seen and has this time, ns."""
        row = self.row(key)
        row["state"], row["changed"] = -row["state"], changed
        self._count += 1

    def load(self, path: Path, run: list[Any]) -> dict[str, Any]:
        """Fill the empty tables from a summary; their rows are marked unseen. Return the `stop` that `save` was given.

        Without a sound summary of this run, in the format of these tables, they stay empty, and so is the result.
        """
        with suppress(OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError, MemoryError):
            content = read_bytes(path)
            file = BytesIO(content)
            header = json.loads(file.readline())
            whole = hashlib.sha256(memoryview(content)[:-HASH_BYTES]).digest() == content[-HASH_BYTES:]
            if not whole or header["run"] != run:
                return {}
            levels = [(old, np.load(file), np.load(file)) for old in self.tables]
            if any(new.dtype != old.dtype for old, new, _ in levels):
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

    def save(self, path: Path, run: list[Any], stop: dict[str, Any]) -> None:
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
        indices = [index for of_level, index in self.failures if of_level == level and index < count]
        return np.array(sorted(index for index in indices if (level, index) in self), np.int64)

    def sound(self, count: int) -> list[int]:
        """Return the indices below `count` that failed at no level; a failed march does not count."""
        converged = np.ones(count, bool)
        converged[list(self._lost(count))] = False
        rows: list[int] = np.flatnonzero(converged).tolist()
        return rows

    def count_sound(self, count: int) -> int:
        """Return how many indices below `count` failed at no level."""
        return count - len(self._lost(count))

    def _lost(self, count: int) -> set[int]:
        """The indices below `count` that failed at some level; failures are few, so this does not go through all."""
        failures = ((level, index) for level, index in self.failures if level != self.march and index < count)
        return {index for level, index in failures if (level, index) in self}

    def kept(self, level: int, name: str, indices: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Return which realizations store a field, or the pressure, which gives all other fields."""
        field = STORED.index(name if name in STORED else "pressure")
        stored: NDArray[np.bool_] = self.column(level, "kept", indices)[:, field]
        return stored

    def column(self, level: int, name: str, indices: NDArray[np.int64]) -> NDArray[Any]:
        """Return a field of the table at some realizations; numbers (n, speeds) or (n, 1), NaN where there is none."""
        rows: NDArray[Any] = self.tables[level][name][indices // self.every[level]]
        return rows
