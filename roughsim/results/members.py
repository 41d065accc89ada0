"""The members of a run in memory: for each level a column per number and a row per realization, however many."""

from __future__ import annotations

import calendar
import time
from collections.abc import Iterator, MutableMapping, Sequence
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from roughsim.observables.catalogue import NUMBERS
from roughsim.store.member_files import FIELD_UNITS, Member

Array = NDArray[np.float64]
Key = tuple[int, int]  # level and index
_ABSENT, _SOUND, _FAILED = 0, 1, 2
_TIME = "%Y-%m-%dT%H:%M:%SZ"
_DIGEST = 32  # bytes
# columns that every level has, beside the numbers and the seconds of each stage
_FIXED: dict[str, tuple[str, tuple[int, ...]]] = {
    "state": ("i1", ()),
    "kept": ("i1", ()),  # a bit for each field
    "versions": ("i2", ()),  # place in `Members.versions`
    "residual": ("f8", ()),
    "iterations": ("i8", ()),
    "written": ("f8", ()),  # s since 1970
    "size": ("i8", ()),  # of the file, bytes; 0 where it was not read
    "changed": ("i8", ()),  # of the file, ns
    "digest": ("u1", (_DIGEST,)),
}


class Stamp(NamedTuple):
    """What a member's file was when it was read: size, bytes, last change, ns, and SHA-256."""

    size: int
    changed: int
    digest: bytes


class Columns:
    """The columns of one level: arrays whose row is the place of a realization among those that have the level."""

    def __init__(self, every: int, wide: int):
        self.every, self._wide, self._room = every, wide, 0
        self.data: dict[str, NDArray[Any]] = {name: np.zeros((0, *rest), kind) for name, (kind, rest) in _FIXED.items()}

    def row(self, index: int) -> int:
        """Return the row of a realization, with room for it."""
        row = index // self.every
        if row >= self._room:
            self._room = max(64, 2 * self._room, row + 1)
            self.data = {name: self._grown(values) for name, values in self.data.items()}
        return row

    def _grown(self, values: NDArray[Any]) -> NDArray[Any]:
        blank = np.nan if values.dtype.kind == "f" else 0
        grown = np.full((self._room, *values.shape[1:]), blank, values.dtype)
        grown[: len(values)] = values
        return grown

    def column(self, name: str) -> NDArray[Any]:
        """Return the column of a number or of the seconds of a stage, made if need be."""
        if name not in self.data:
            per_speed = name in NUMBERS and NUMBERS[name].per_speed
            self.data[name] = self._grown(np.empty((0, self._wide if per_speed else 1)))
        return self.data[name]

    def floats(self) -> list[str]:
        """Return the names of the columns that are no fixed ones."""
        return [name for name in self.data if name not in _FIXED]


class Members(MutableMapping[Key, Member]):
    """Members by (level, index), without their arrays; rows that a summary gave stand only once their file was seen.

    Parameters
    ----------
    every : sequence of int
        For each level, the step of the realizations that have it.
    lengths : (float, float)
        Sides of the cell, m.
    speeds : tuple of float
        Sliding speeds, m/s.
    """

    def __init__(self, every: Sequence[int], lengths: tuple[float, float], speeds: tuple[float, ...]):
        self.levels = [Columns(step, len(speeds)) for step in every]
        self.versions: list[dict[str, str]] = []
        self.failures: dict[Key, str] = {}
        self._lengths, self._speeds = lengths, speeds
        self._adopted: list[NDArray[np.int8]] = [np.zeros(0, np.int8) for _ in every]
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def __contains__(self, key: object) -> bool:
        level, index = cast(Key, key)
        columns = self.levels[level]
        row, rest = divmod(index, columns.every)
        state = columns.data["state"]
        return not rest and row < len(state) and bool(state[row])

    def __iter__(self) -> Iterator[Key]:
        for level, columns in enumerate(self.levels):
            for row in np.flatnonzero(columns.data["state"]).tolist():
                yield level, row * columns.every

    def __getitem__(self, key: Key) -> Member:
        if key not in self:
            raise KeyError(key)
        level, index = key
        columns = self.levels[level]
        row = index // columns.every
        data = {name: values[row] for name, values in columns.data.items()}
        numbers = {name: data[name].copy() for name in NUMBERS if name in data and not np.all(np.isnan(data[name]))}
        stages = [name for name in columns.floats() if name not in NUMBERS and not np.isnan(data[name][0])]
        provenance = {
            "residual": float(data["residual"]),
            "iterations": int(data["iterations"]),
            "versions": self.versions[data["versions"]],
            "seconds": {name: float(data[name][0]) for name in stages},
            "written": "" if np.isnan(data["written"]) else time.strftime(_TIME, time.gmtime(data["written"])),
        }
        kept = tuple(name for bit, name in enumerate(FIELD_UNITS) if data["kept"] >> bit & 1)
        failure = self.failures.get(key, "")
        return Member(
            level,
            index,
            failure,
            {} if failure else numbers,
            lengths=self._lengths,
            speeds=self._speeds,
            provenance=provenance,
            kept=kept,
        )

    def __setitem__(self, key: Key, member: Member) -> None:
        self.put(key, member)

    def __delitem__(self, key: Key) -> None:
        if key not in self:
            raise KeyError(key)
        level, index = key
        data = self.levels[level].data
        data["state"][index // self.levels[level].every] = _ABSENT
        data["size"][index // self.levels[level].every] = 0
        self.failures.pop(key, None)
        self._count -= 1

    def put(self, key: Key, member: Member, stamp: Stamp | None = None) -> None:
        """Store a member, and what its file was if it was read from it."""
        self._count += key not in self
        level, index = key
        columns = self.levels[level]
        row = columns.row(index)
        for name in columns.floats():
            columns.data[name][row] = np.nan
        for name, values in {**member.numbers, **member.provenance.get("seconds", {})}.items():
            columns.column(name)[row] = values
        self.failures.pop(key, None)
        if member.failure:
            self.failures[key] = member.failure
        fixed = {
            "state": _FAILED if member.failure else _SOUND,
            "kept": sum(1 << bit for bit, name in enumerate(FIELD_UNITS) if name in member.kept),
            "versions": self._place_of(member.provenance.get("versions", {})),
            "residual": member.provenance.get("residual", np.nan),
            "iterations": member.provenance.get("iterations", 0),
            "written": _seconds(member.provenance.get("written", "")),
            "size": 0 if stamp is None else stamp.size,
            "changed": 0 if stamp is None else stamp.changed,
            "digest": np.frombuffer(bytes(_DIGEST) if stamp is None else stamp.digest, np.uint8),
        }
        for name, value in fixed.items():
            columns.data[name][row] = value

    def _place_of(self, versions: dict[str, str]) -> int:
        if versions not in self.versions:
            self.versions.append(versions)
        return self.versions.index(versions)

    def adopt(self, level: int, indices: NDArray[np.int64], data: dict[str, NDArray[Any]]) -> None:
        """Take over rows of a summary; none of them stands until `confirm` says that its file was seen."""
        columns = self.levels[level]
        rows = indices // columns.every
        columns.row(int(indices.max(initial=0)))
        self._adopted[level] = np.zeros(len(columns.data["state"]), np.int8)
        for name, values in data.items():
            if name == "state":
                self._adopted[level][rows] = values
            else:
                (columns.data[name] if name in _FIXED else columns.column(name))[rows] = values

    def adopted(self, level: int, index: int) -> Stamp | None:
        """Return what the file of an adopted row was when the summary was made; None if there is no such row."""
        row = index // self.levels[level].every
        if row >= len(self._adopted[level]) or not self._adopted[level][row]:
            return None
        data = self.levels[level].data
        return Stamp(int(data["size"][row]), int(data["changed"][row]), data["digest"][row].tobytes())

    def confirm(self, level: int, index: int) -> None:
        """Let an adopted row stand: its file is what it was."""
        row = index // self.levels[level].every
        self.levels[level].data["state"][row] = self._adopted[level][row]
        self._count += 1

    def stamped(self, level: int) -> NDArray[np.int64]:
        """Return the indices of the members of a level that were read from their files, in order."""
        data = self.levels[level].data
        return np.flatnonzero((data["state"] > 0) & (data["size"] > 0)) * self.levels[level].every

    def latest(self, count: int) -> list[float]:
        """Return when the latest files were written, s since 1970, in order; of members read from files only."""
        times = [columns.data["changed"][columns.data["state"] > 0] for columns in self.levels]
        every = np.sort(np.concatenate(times))
        return [1e-9 * float(time) for time in every[every > 0][-count:]]

    def failed(self, level: int, count: int) -> NDArray[np.int64]:
        """Return the indices below `count` at which a level has no numbers."""
        columns = self.levels[level]
        return np.flatnonzero(columns.data["state"][: -(-count // columns.every)] == _FAILED) * columns.every

    def fixed(self, level: int, name: str, indices: NDArray[np.int64]) -> NDArray[Any]:
        """Return one of the columns that every level has, at some realizations."""
        return self._at(level, self.levels[level].data[name], indices)

    def numbers(self, level: int, name: str, indices: NDArray[np.int64]) -> Array:
        """Return a number at some realizations, (n, speeds) or (n, 1); NaN where it failed or is from before it."""
        return self._at(level, self.levels[level].column(name), indices)

    def _at(self, level: int, values: NDArray[Any], indices: NDArray[np.int64]) -> NDArray[Any]:
        rows = indices // self.levels[level].every
        if len(rows) and rows[-1] - rows[0] + 1 == len(rows):  # no gap: a view costs nothing
            view = values[rows[0] : rows[-1] + 1]
            view.flags.writeable = False
            return view
        return values[rows]


def _seconds(written: str) -> float:
    try:
        return float(calendar.timegm(time.strptime(written, _TIME)))
    except ValueError:
        return np.nan
