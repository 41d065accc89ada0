"""The members of a run folder as they come: each file is read once, in order, up to the first that is missing."""

from __future__ import annotations

import hashlib
import json
import os
import stat
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughsim.errors import RecordError
from roughsim.observables.catalogue import NUMBERS
from roughsim.observables.record import Sample
from roughsim.results.members import SOUND, Key, Members, Stamp
from roughsim.results.summary import Block, Summary, code_digest, read_summary, write_summary
from roughsim.scene.numerics import Numerics
from roughsim.store.disk import not_readable, read_bytes
from roughsim.store.member_files import (
    FIELD_UNITS,
    MEMBER_NAME,
    Member,
    member_name,
    member_of,
    member_path,
    read_member,
    read_seal,
    seal_of,
)

Array = NDArray[np.float64]
SMALL = 1 << 16  # bytes: such a file is checked as a whole, also where its size and time are those of the summary
# the summary is written anew after so many new members, and after this share of all
LEAST_NEW, SHARE_NEW = 64, 0.1


class Reader:
    """The members of a run folder: which there are without a gap (`available`), and which files are `damaged`, and why.

    `numerics` says which members there are, `identity` (from `identity_of`) what their files have in common. With
    `skip_damaged` a damaged file counts as a failed member; else it is an error.
    """

    def __init__(
        self, folder: Path, numerics: Numerics, speeds: tuple[float, ...], identity: tuple[Any, Any], skip_damaged: bool
    ):
        self.folder, self.numerics = folder, numerics
        self.damaged: dict[Key, str] = {}
        self.available = 0
        self._identity, self._skip_damaged = identity, skip_damaged
        layout = {name: number.per_speed for name, number in NUMBERS.items()}, list(FIELD_UNITS)
        self.summary_key = hashlib.sha256(json.dumps((identity, layout), sort_keys=True).encode()).hexdigest()
        self._new_spectra: dict[Key, Array] = {}  # of members that no summary has yet
        self._wavenumber: dict[int, Array] = {}  # by level
        self._last_spectra: dict[int, tuple[NDArray[np.int64], Array]] = {}  # those asked for last, by level

        def table() -> Members:
            return Members([level.every for level in numerics.levels], numerics.lengths, speeds)

        self.members, self._insufficient = table(), dict[str, Any]()
        summary, adopted = read_summary(folder, self.summary_key), table()
        if summary is not None:
            with suppress(ValueError, LookupError, TypeError):  # whole, but of another layout: ignored
                for level, block in enumerate(summary.blocks):
                    adopted.adopt(level, block.indices, block.columns)
                adopted.versions, adopted.failures = summary.versions, summary.failures
                self.members, self._insufficient = adopted, summary.stop

    def refresh(self, most: int) -> None:
        """Read the members that have come since, of at most so many realizations; damaged ones again."""
        while self.damaged:
            (level, index), _ = self.damaged.popitem()
            del self.members[level, index]
            self.available = min(self.available, index)
        while self.available < most and all(
            self.take(level, self.available) for level in self.numerics.of_index(self.available)
        ):
            self.available += 1
        if self.worth_saving(len(self._new_spectra)):
            self.save()

    def take(self, level: int, index: int) -> bool:
        """Read one member unless it was read before; False if its file is missing."""
        if (level, index) in self.members:
            return True
        path = member_path(self.folder, level, index)
        try:
            status = os.stat(path)
            stamp = self.members.adopted(level, index)
            if stamp is not None and unchanged(path, status, stamp):
                self.members.confirm(level, index)
                return True
            content = read_bytes(path)
            member = member_of(path, content)
            complete = {"residual", "iterations", "versions"} <= set(member.provenance)
            if not complete or identity_of(member.provenance) != self._identity:
                raise RecordError(
                    f"{path} is of another run: its scene, seed or numerics differ; move it out of the folder"
                )
            self.members.put((level, index), member, Stamp(len(content), status.st_mtime_ns, digest_of(path, content)))
            self._new_spectra[level, index] = member.spectrum
            if not member.failure:
                self._wavenumber.setdefault(level, member.wavenumber)
        except FileNotFoundError:
            return False
        except RecordError as error:
            if not self._skip_damaged:
                raise
            self.damaged[level, index] = str(error)
            self.members[level, index] = Member(level, index, failure=str(error))
        return True

    def sample(self, level: int, indices: NDArray[np.int64], *, with_spectra: bool) -> Sample:
        """Return the numbers of a level over those of the realizations that have it; spectra as `spectra`, or empty."""
        q_max, side = self.numerics.levels[level].q_max, float(self.numerics.levels[level].shape[0])
        rows = np.flatnonzero(indices % self.members.every[level] == 0)
        numbers = {name: self.members.column(level, name, indices[rows]) for name in NUMBERS}
        nothing = np.empty(0), np.empty((len(rows), 0))
        wavenumber, spectra = self.spectra(level, indices[rows]) if with_spectra else nothing
        return Sample(q_max, side, rows, numbers, wavenumber, spectra, 0.5 * float(np.hypot(*self.numerics.lengths)))

    def spectra(self, level: int, indices: NDArray[np.int64]) -> tuple[Array, Array]:
        """Return the wavenumbers of a level, rad/m, and its stress spectra at sound realizations, Pa², (n, m).

        RecordError if a file has been damaged since it was read.
        """
        # a file that has changed since it was read, as another process may have computed it again, must be sound
        sizes, times = (self.members.column(level, name, indices).tolist() for name in ("size", "changed"))
        for index, size, changed in zip(indices.tolist(), sizes, times, strict=True):
            path = member_path(self.folder, level, index)
            with suppress(FileNotFoundError):  # moved since it was read; it was sound then
                status = os.stat(path)
                if (status.st_size, status.st_mtime_ns) != (size, changed):
                    seal_of(path, read_bytes(path))
        last = self._last_spectra.get(level)
        if last is None or not np.array_equal(last[0], indices):
            self._last_spectra[level] = indices, self.stored_spectra(level, indices)
        return self._wavenumber[level], self._last_spectra[level][1]

    def stored_spectra(self, level: int, indices: NDArray[np.int64]) -> Array:
        """Return spectra of the summary where its rows are of the same files, else from memory or from the files."""
        rows: dict[int, Array] = {}
        if any((level, index) not in self._new_spectra for index in indices.tolist()):
            summary = read_summary(self.folder, self.summary_key)
            if summary is not None:
                block = summary.blocks[level]
                both, at, _ = np.intersect1d(block.indices, indices, assume_unique=True, return_indices=True)
                same = np.all(block.columns["digest"][at] == self.members.column(level, "digest", both), axis=1)
                rows = dict(zip(both[same].tolist(), block.spectra[at[same]], strict=True))
                if rows:
                    self._wavenumber.setdefault(level, block.wavenumber.copy())
        for index in indices.tolist():
            if index not in rows and (level, index) in self._new_spectra:
                rows[index] = self._new_spectra[level, index]
            elif index not in rows:
                member = read_member(member_path(self.folder, level, index))
                rows[index] = member.spectrum
                self._wavenumber.setdefault(level, member.wavenumber)
        return np.array([rows[index] for index in indices.tolist()]) if rows else np.empty((0, 0))

    def save(self) -> None:
        """Write the summary of all that was read, and forget the spectra that it holds."""
        blocks = []
        for level, table in enumerate(self.members.tables):
            rows = np.flatnonzero((table["state"] > 0) & (table["size"] > 0))
            indices, sound = rows * self.members.every[level], table["state"][rows] == SOUND
            of_sound = self.stored_spectra(level, indices[sound])
            spectra = np.full((len(rows), of_sound.shape[1]), np.nan)
            spectra[sound] = of_sound
            columns = {name: table[name][rows] for name in table.dtype.names or ()}
            blocks.append(Block(indices, columns, self._wavenumber.get(level, np.empty(0)), spectra))
        failures = {key: reason for key, reason in self.members.failures.items() if key not in self.damaged}
        summary = Summary(blocks, self.members.versions, failures, self._insufficient)
        write_summary(self.folder, self.summary_key, summary)
        self._new_spectra.clear()

    def worth_saving(self, news: int) -> bool:
        """Whether so much is new that the summary is written anew."""
        return news >= max(LEAST_NEW, SHARE_NEW * len(self.members))

    def remember_insufficient(self, count: int, rows: list[int], until: dict[str, float]) -> None:
        """Keep with the summary, now and then, that the first `count` of the rows do not meet the targets."""
        if self.worth_saving(count - self._insufficient.get("count", 0)):
            self._insufficient = self.insufficient_record(count, rows, until)
            self.save()

    def known_insufficient(self, rows: list[int], until: dict[str, float]) -> int:
        """Return how many of the rows do not meet the targets by an earlier look at the same members; 0 if unknown."""
        count = int(self._insufficient.get("count", 0))
        if not 0 < count <= len(rows) or self._insufficient != self.insufficient_record(count, rows, until):
            self._insufficient = {}
            return 0
        return count

    def insufficient_record(self, count: int, rows: list[int], until: dict[str, float]) -> dict[str, Any]:
        """Return what must be the same for an earlier look to hold: members, targets and code."""
        digest, indices = hashlib.sha256(), np.array(rows[:count], np.int64)
        for level, every in enumerate(self.members.every):
            of_level = indices[indices % every == 0]
            digest.update(of_level.tobytes() + self.members.column(level, "digest", of_level).tobytes())
        return {"count": count, "until": until, "code": code_digest(), "members": digest.hexdigest()}

    def missing(self) -> list[str]:
        """Return the names of the members that are missing although those of later realizations are there."""
        try:
            names = os.listdir(self.folder / "realizations")
        except OSError as error:
            raise not_readable(self.folder / "realizations", error) from error
        stems = (MEMBER_NAME.fullmatch(name.removesuffix(".h5")) for name in names if name.endswith(".h5"))
        stored = {match[0]: int(match[2]) for match in stems if match}
        gap = range(self.available, max(stored.values(), default=-1) + 1)
        expected = (member_name(level, index) for index in gap for level in self.numerics.of_index(index))
        return [name for name in expected if name not in stored]


def unchanged(path: Path, status: os.stat_result, stamp: Stamp) -> bool:
    """Whether a file is the one that the summary was made of, by its digest."""
    if status.st_size != stamp.size or not stat.S_ISREG(status.st_mode):
        return False
    if status.st_size > SMALL and status.st_mtime_ns == stamp.changed:
        return read_seal(path) == stamp.digest
    return digest_of(path, read_bytes(path)) == stamp.digest


def digest_of(path: Path, content: bytes) -> bytes:
    """Return the digest in the seal of a file, or, without a seal, that of its bytes."""
    sealed = seal_of(path, content)
    return hashlib.sha256(content).digest() if sealed is None else bytes.fromhex(sealed)


def identity_of(description: dict[str, Any]) -> tuple[Any, Any]:
    """Return what a run and each of its files must have in common: scene with seed, and numerics but what is kept."""
    numerics = description.get("numerics")
    if isinstance(numerics, dict):
        numerics = {key: value for key, value in numerics.items() if key != "keep_fields"}
    return description.get("scene"), numerics
