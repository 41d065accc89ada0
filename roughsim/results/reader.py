"""The members of a run folder as they come: read once each, in order, up to the first that is not there."""

from __future__ import annotations

import hashlib
import json
import os
import re
import stat
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughsim.errors import RecordError
from roughsim.observables.catalogue import NUMBERS
from roughsim.results.members import Members, Stamp
from roughsim.results.summary import Block, Summary, code_digest, read_summary, write_summary
from roughsim.store.disk import not_readable, read_bytes
from roughsim.store.member_files import FIELD_UNITS, Member, member_of, member_path, read_member, read_seal, seal_of

if TYPE_CHECKING:
    from roughsim.scene.numerics import Numerics

Array = NDArray[np.float64]
_NAME = re.compile(r"(L\d+-(\d{6,}))\.h5")
_SMALL = 1 << 16  # bytes: such a file is checked whole also where its summary is at hand
_LEAST_NEW, _SHARE_NEW = 64, 0.1  # members, and share of all, that came since: then the summary is written anew


class Reader:
    """What a run folder holds.

    Parameters
    ----------
    folder : Path
        Where it is.
    numerics : Numerics
        Its levels say which members there are.
    speeds : tuple of float
        Sliding speeds, m/s.
    identity : tuple
        What the run and each of its files have in common, from `identity_of`.
    skip_damaged : bool
        Whether a damaged file stands as a failed member.

    Attributes
    ----------
    members : Members
        What was read.
    available : int
        How many realizations there are without a gap.
    damaged : dict of (int, int) to str
        Files that could not be used, and why.
    stop : dict
        What is known of where the run may stop; stored with the summary.
    """

    def __init__(
        self, folder: Path, numerics: Numerics, speeds: tuple[float, ...], identity: tuple[Any, Any], skip_damaged: bool
    ):
        self.folder, self.numerics = folder, numerics
        self.members = self._nobody(speeds)
        self.damaged: dict[tuple[int, int], str] = {}
        self.available = 0
        self._identity, self._skip_damaged = identity, skip_damaged
        layout = {name: number.per_speed for name, number in NUMBERS.items()}, list(FIELD_UNITS)
        self._run = hashlib.sha256(json.dumps((identity, layout), sort_keys=True).encode()).hexdigest()
        self._fresh: dict[tuple[int, int], Array] = {}  # stress spectra that no summary has yet
        self._wavenumber: dict[int, Array] = {}
        self._latest: dict[int, tuple[NDArray[np.int64], Array]] = {}  # spectra asked for last, by level
        summary = read_summary(folder, self._run)
        self.stop: dict[str, Any] = {} if summary is None else summary.stop
        try:
            for level, block in enumerate([] if summary is None else summary.blocks):
                self.members.adopt(level, block.indices, block.columns)
        except (ValueError, LookupError, TypeError):  # whole, but not as it is written here: as none
            self.members, self.stop, summary = self._nobody(speeds), {}, None
        if summary is not None:
            self.members.versions, self.members.failures = summary.versions, summary.failures

    def _nobody(self, speeds: tuple[float, ...]) -> Members:
        return Members([level.every for level in self.numerics.levels], self.numerics.lengths, speeds)

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
        if self._worth_saving(len(self._fresh)):
            self.save()

    def _worth_saving(self, news: int) -> bool:
        return news >= max(_LEAST_NEW, _SHARE_NEW * len(self.members))

    def remember(self, count: int, rows: list[int], until: dict[str, float]) -> None:
        """Keep with the summary, now and then, that the first `count` of the rows do not meet the targets."""
        if self._worth_saving(count - self.stop.get("count", 0)):
            self.stop = self._stop_of(count, rows, until)
            self.save()

    def remembered(self, rows: list[int], until: dict[str, float]) -> int:
        """Return how many of the rows are known not to meet the targets: the same members, targets and code; else 0."""
        count = self.stop.get("count", 0)
        if not 0 < count <= len(rows) or self.stop != self._stop_of(count, rows, until):
            self.stop = {}
            return 0
        return int(count)

    def _stop_of(self, count: int, rows: list[int], until: dict[str, float]) -> dict[str, Any]:
        digest, indices = hashlib.sha256(), np.array(rows[:count], np.int64)
        for level, columns in enumerate(self.members.levels):
            wanted = indices[indices % columns.every == 0]
            digest.update(wanted.tobytes() + self.members.fixed(level, "digest", wanted).tobytes())
        return {"count": count, "until": until, "code": code_digest(), "members": digest.hexdigest()}

    def take(self, level: int, index: int) -> bool:
        """Read one member if need be; False if it is not there yet."""
        if (level, index) in self.members:
            return True
        path = member_path(self.folder, level, index)
        try:
            found = os.stat(path)
            known = self.members.adopted(level, index)
            if known is not None and self._unchanged(path, found, known):
                self.members.confirm(level, index)
            else:
                self._read(path, level, index, found)
        except FileNotFoundError:
            return False
        except RecordError as error:
            if not self._skip_damaged:
                raise
            self.damaged[level, index] = str(error)
            self.members[level, index] = Member(level, index, failure=str(error))
        return True

    def _unchanged(self, path: Path, found: os.stat_result, known: Stamp) -> bool:
        """Whether a file is the one that the summary has read, by its digest."""
        if found.st_size != known.size or not stat.S_ISREG(found.st_mode):
            return False
        if found.st_size > _SMALL and found.st_mtime_ns == known.changed:
            return read_seal(path) == known.digest
        return _digest(path, read_bytes(path)) == known.digest

    def _read(self, path: Path, level: int, index: int, found: os.stat_result) -> None:
        content = read_bytes(path)
        member = member_of(path, content)
        told = {"residual", "iterations", "versions"} <= set(member.provenance)
        if not told or identity_of(member.provenance) != self._identity:
            raise RecordError(
                f"{path} is of another run: its scene, seed or numerics differ; move it out of the folder"
            )
        stamp = Stamp(len(content), found.st_mtime_ns, _digest(path, content))
        self.members.put((level, index), member, stamp)
        self._fresh[level, index] = member.spectrum
        if not member.failure:
            self._wavenumber.setdefault(level, member.wavenumber)

    def spectra(self, level: int, indices: NDArray[np.int64]) -> tuple[Array, Array]:
        """Return the wavenumbers of a level, rad/m, and its stress spectra at sound realizations, Pa², (n, m).

        Raises
        ------
        RecordError
            If a file has been damaged since it was read.
        """
        self._check_unchanged(level, indices)
        latest = self._latest.get(level)
        if latest is None or not np.array_equal(latest[0], indices):
            self._latest[level] = indices, self._gathered(level, indices)
        return self._wavenumber[level], self._latest[level][1]

    def _check_unchanged(self, level: int, indices: NDArray[np.int64]) -> None:
        """See that files which have changed since they were read are sound: another process may have redone them."""
        sizes, times = (self.members.fixed(level, name, indices) for name in ("size", "changed"))
        for index, size, changed in zip(indices.tolist(), sizes.tolist(), times.tolist(), strict=True):
            path = member_path(self.folder, level, index)
            with suppress(FileNotFoundError):  # moved since it was read; it was sound then
                found = os.stat(path)
                if (found.st_size, found.st_mtime_ns) != (size, changed):
                    seal_of(path, read_bytes(path))

    def _gathered(self, level: int, indices: NDArray[np.int64]) -> Array:
        """Spectra from the summary where its rows are of the same files, from memory, and else from the files."""
        result, known = np.empty((len(indices), 0)), np.zeros(len(indices), bool)
        summary = None
        if any((level, index) not in self._fresh for index in indices.tolist()):
            summary = read_summary(self.folder, self._run)
        if summary is not None and len(summary.blocks[level].indices):
            block = summary.blocks[level]
            rows = np.minimum(np.searchsorted(block.indices, indices), len(block.indices) - 1)
            same = block.columns["digest"][rows] == self.members.fixed(level, "digest", indices)
            known = (block.indices[rows] == indices) & same.all(axis=1)
            result = block.spectra[rows]
            self._wavenumber.setdefault(level, block.wavenumber.copy())
        for k in np.flatnonzero(~known).tolist():
            spectrum = self._fresh.get((level, int(indices[k])))
            if spectrum is None:
                member = read_member(member_path(self.folder, level, int(indices[k])))
                spectrum = member.spectrum
                self._wavenumber.setdefault(level, member.wavenumber)
            if not known.any() and result.shape[1] != len(spectrum):
                result = np.empty((len(indices), len(spectrum)))
            result[k] = spectrum
            known[k] = True
        return result

    def save(self) -> None:
        """Write the summary of all that was read, and forget the spectra that it holds."""
        blocks = [self._block(level) for level in range(len(self.numerics.levels))]
        failures = {key: text for key, text in self.members.failures.items() if key not in self.damaged}
        write_summary(self.folder, self._run, Summary(blocks, self.members.versions, failures, self.stop))
        self._fresh.clear()

    def _block(self, level: int) -> Block:
        indices = self.members.stamped(level)
        failed = np.isin(indices, self.members.failed(level, self.available + 1))
        spectra = self._gathered(level, indices[~failed]) if not failed.all() else np.empty((0, 0))
        rows = spectra if not failed.any() else np.full((len(indices), spectra.shape[1]), np.nan)
        if failed.any():
            rows[~failed] = spectra
        columns = {name: self.members.fixed(level, name, indices) for name in self.members.levels[level].data}
        return Block(indices, columns, self._wavenumber.get(level, np.empty(0)), rows)

    def missing(self) -> list[str]:
        """Return the names of the members that are not there although those of later realizations are."""
        try:
            names = os.listdir(self.folder / "realizations")
        except OSError as error:
            raise not_readable(self.folder / "realizations", error) from error
        there = {found[1]: int(found[2]) for found in map(_NAME.fullmatch, names) if found}
        gap = range(self.available, max(there.values(), default=-1) + 1)
        wanted = (member_path(self.folder, level, i).stem for i in gap for level in self.numerics.of_index(i))
        return [name for name in wanted if name not in there]


def identity_of(description: dict[str, Any]) -> tuple[Any, Any]:
    """Return what a run and each of its files must have in common: scene with seed, and numerics but what is kept."""
    numerics = description.get("numerics")
    if isinstance(numerics, dict):
        numerics = {key: value for key, value in numerics.items() if key != "keep_fields"}
    return description.get("scene"), numerics


def _digest(path: Path, content: bytes) -> bytes:
    """The digest that a file bears, or, without a seal, that of its bytes."""
    sealed = seal_of(path, content)
    return hashlib.sha256(content).digest() if sealed is None else bytes.fromhex(sealed)
