"""`Reader`: reads the files of a run folder as they appear, each once, in order, up to the first that is missing."""

import hashlib
import os
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from roughsim.errors import RecordError
from roughsim.extensions import extensions
from roughsim.grid import Array
from roughsim.observables.catalogue import AXIS, NUMBERS
from roughsim.observables.record import Sample
from roughsim.results.members import SUMMARY, Key, Members
from roughsim.scene.numerics import Numerics
from roughsim.store.disk import not_readable, read_bytes
from roughsim.store.member_files import (
    MEMBER_NAME,
    Member,
    is_unchanged,
    member_name,
    member_of,
    member_path,
    read_member,
    read_spectrum,
)

# the summary is written again after so many new members or looks at the targets, and not before this share of all
LEAST_NEW, SHARE_NEW = 64, 0.1
LEAST_AT_END = 16  # and at the end of a run after so many: fewer are read in no time
MOST_KEPT = 256 << 20  # bytes of stress spectra that stay in memory: those of more members are read when asked for


class Reader:
    """The members of a run folder: how many realizations are there without a gap, and which files are damaged, and why.

    `numerics` gives the levels of each realization, `identity` (from `identity_of`) the scene and numerics that every
    file must have. With `skip_damaged` a damaged file counts as a failed member; otherwise it is an error.
    """

    def __init__(
        self, folder: Path, numerics: Numerics, speeds: tuple[float, ...], identity: list[Any], skip_damaged: bool
    ):
        self.folder, self.numerics, self.identity = folder, numerics, identity
        self.damaged: dict[Key, str] = {}
        self.available = 0
        self._skip_damaged, self._speeds = skip_damaged, speeds
        lengths = [numerics.grid(level).lengths for level in range(len(numerics.levels))]
        self.members = Members([level.every for level in numerics.levels], lengths, speeds, numerics.march)
        # the last look at the targets that no number of realizations met
        self._insufficient = self.members.load(folder / SUMMARY, identity)
        # how many realizations were found too few by this process, and for which targets; None before the first look
        self._tried: tuple[int, dict[str, float]] | None = None
        self._news = 0  # members and looks at the targets that the summary on disk lacks
        # stress spectra of each level by the row of the table, and whether a row was read
        self._spectra: dict[int, tuple[Array, NDArray[np.bool_]]] = {}

    def refresh(self, most: int) -> None:
        """Read the members that have appeared since, of at most `most` realizations; damaged ones again."""
        while self.damaged:
            (level, index), _ = self.damaged.popitem()
            del self.members[level, index]
            self._tried = None
            self.available = min(self.available, index)
        while self.available < most and all(
            self.take(level, self.available) for level in self.numerics.of_index(self.available)
        ):
            self.available += 1
        self.save_now_and_then()

    def take(self, level: int, index: int) -> bool:
        """Read one member unless it was read before; False if its file is missing."""
        if (level, index) in self.members:
            return True
        path = member_path(self.folder, level, index)
        try:
            status = os.stat(path)
            row = self.members.row((level, index))
            unseen = row is not None and row["state"] < 0
            if unseen and is_unchanged(path, status, *row[["size", "changed", "digest"]].item()):
                self.members.see((level, index), status.st_mtime_ns)  # a copy has another time
                return True
            content = read_bytes(path)
            member = member_of(path, content)
            complete = {"residual", "iterations", "versions"} <= set(member.provenance)
            # a header may say one thing, and the arrays another
            modes = self.members.wavenumber.get(level, member.wavenumber).shape
            fits = member.speeds == self._speeds and member.spectrum.shape == member.wavenumber.shape == modes
            if not complete or identity_of(member.provenance) != self.identity or not (fits or member.failure):
                raise RecordError(
                    f"{path} is of another run: its scene, seed or numerics differ; move it out of the folder"
                )
            spectrum = member.spectrum.astype("<f8").tobytes()
            self.members.put(
                (level, index),
                member,
                size=len(content),
                changed=status.st_mtime_ns,
                digest=member.digest.encode(),
                spectrum_start=content.find(spectrum),
                spectrum_check=crc32(spectrum),
            )
            if member.spectrum.size:  # so that the file need not be opened again
                place = index // self.members.every[level]
                spectra, known = self._room(level, place + 1)
                if place < len(known):
                    spectra[place], known[place] = member.spectrum, True
            self._news += 1
        except FileNotFoundError:
            return False
        except RecordError as error:
            if not self._skip_damaged:
                raise
            self.damaged[level, index] = str(error)
            self.members.put((level, index), Member(level, index, failure=str(error)))
        return True

    def sample(self, level: int, indices: NDArray[np.int64], *, with_spectra: bool) -> Sample:
        """Return numbers and, if asked for, stress spectra of a level, over the realizations that were solved at it."""
        of_level, reach = self.numerics.levels[level], 0.5 * float(np.hypot(*self.numerics.grid(level).lengths))
        rows = np.flatnonzero(indices % self.members.every[level] == 0)
        numbers = {name: self.members.column(level, name, indices[rows]) for name in NUMBERS}
        nothing = np.empty(0), np.empty((len(rows), 0))
        wavenumber, spectra = self.spectra(level, indices[rows]) if with_spectra else nothing
        side, part = float(of_level.shape[0]), of_level.parts > 1
        return Sample(of_level.q_max, side, rows, numbers, wavenumber, spectra, reach, part)

    def spectra(self, level: int, indices: NDArray[np.int64]) -> tuple[Array, Array]:
        """Return the wavenumbers of a level, rad/m, and the stress spectra of sound members, Pa².

        Those that are not in memory are read from the files of the members. RecordError or OSError if such a file was
        damaged or moved after its numbers had been read.
        """
        wavenumber, rows = self.members.wavenumber[level], indices // self.members.every[level]
        spectra, known = self._room(level, int(rows.max(initial=-1)) + 1)
        inside = rows < len(known)
        whole = np.array_equal(rows[inside], np.arange(len(rows)))
        result = spectra[: len(rows)] if whole else np.empty((len(rows), len(wavenumber)))  # whole: nothing is copied
        starts, checks = (self.members.column(level, f"spectrum_{name}", indices) for name in ("start", "check"))
        for place, (row, index) in enumerate(zip(rows.tolist(), indices.tolist(), strict=True)):
            if inside[place] and known[row]:
                if not whole:
                    result[place] = spectra[row]
                continue
            path = member_path(self.folder, level, index)
            result[place] = read_spectrum(path, starts[place], len(wavenumber), checks[place])
            if inside[place]:
                spectra[row], known[row] = result[place], True
        return wavenumber, result

    def marches(self, count: int) -> tuple[int, list[int]]:
        """Return the level of marches, and which of the first `count` realizations have a sound one.

        ValueError if there is none.
        """
        level = self.numerics.march
        if level is None:
            raise ValueError(f'{self.folder} has no column "sliding": its scene has history = "frozen"')
        indices = {*self.numerics.levels[level].indices(count)}
        if sound := sorted(indices - {*self.members.failed(level, count).tolist()}):
            return level, sound
        raise ValueError(f"{self.folder} has no sound member that slides yet; let it run first")

    def marched(self, count: int) -> dict[str, Array]:
        """Return the numbers of the marches among the first `count` realizations, (members, speeds); as `marches`."""
        level, indices = self.marches(count)
        rows = np.array(indices, np.int64)
        return {name: self.members.column(level, name, rows) for name, n in NUMBERS.items() if n.of_march}

    def curves(self, count: int) -> dict[str, Array]:
        """Return what marches stored over the slid distance, `slid_distance` once, all else a row each; as `marches`.

        RecordError or OSError if a file was damaged or moved after its numbers had been read.
        """
        level, indices = self.marches(count)
        rows = [read_member(member_path(self.folder, level, index)).curves for index in indices]
        names = [name for name in rows[0] if all(name in row for row in rows)]  # older members lack some
        return {name: np.stack([row[name] for row in rows]) for name in names} | {AXIS: rows[0][AXIS]}

    def _room(self, level: int, count: int) -> tuple[Array, NDArray[np.bool_]]:
        """Return the spectra of a level that stay in memory, and which of them were read; up to `count` if they fit."""
        length = len(self.members.wavenumber[level])
        most = MOST_KEPT // (8 * length * len(self.members.every))
        spectra, known = self._spectra.get(level, (np.empty((0, length)), np.zeros(0, bool)))
        if len(known) < min(count, most):  # twice as long, so that n spectra are copied O(log n) times
            size = min(max(count, 2 * len(known)), most)
            longer = np.empty((size, length)), np.zeros(size, bool)
            for new, old in zip(longer, (spectra, known), strict=True):
                new[: len(old)] = old
            spectra, known = self._spectra[level] = longer
        return spectra, known

    def save_now_and_then(self) -> None:
        """Write the summary again if enough is new."""
        self._save(max(LEAST_NEW, SHARE_NEW * len(self.members)))

    def save(self) -> None:
        """Write the summary at the end of a run."""
        self._save(LEAST_AT_END)

    def _save(self, least: float) -> None:
        if self._news >= least:
            if self._tried is not None and self._tried[0]:
                self._insufficient = self.look(*self._tried)
            self.members.save(self.folder / SUMMARY, self.identity, self._insufficient)
            self._news = 0

    def insufficient(self, until: dict[str, float]) -> int:
        """Return how many sound realizations an earlier look found too few for the targets; 0 if unknown."""
        if self._tried is None:  # the summary is believed if members, targets and code are the same
            count = int(self._insufficient.get("count", 0))
            known = 0 < count <= self.members.count_sound(self.available)
            self._tried = (count, dict(until)) if known and self._insufficient == self.look(count, until) else (0, {})
        count, targets = self._tried
        return count if targets == until else 0

    def remember_insufficient(self, count: int, until: dict[str, float]) -> None:
        """Remember that the first `count` sound realizations do not meet the targets, nor fewer."""
        self._tried = count, dict(until)
        self._news += 1

    def look(self, count: int, until: dict[str, float]) -> dict[str, Any]:
        """Return members, targets and code of a look at the targets: its result holds while these are the same."""
        digest, indices = hashlib.sha256(), np.array(self.members.sound(self.available)[:count], np.int64)
        for level in self.numerics.single:
            of_level = indices[indices % self.members.every[level] == 0]
            digest.update(of_level.tobytes() + self.members.column(level, "digest", of_level).tobytes())
        return {"count": count, "until": dict(until), "code": code_digest(), "members": digest.hexdigest()}

    def state(self, count: int) -> dict[str, str]:
        """Return digests of all members of the first `count` realizations, and of the code: what follows from both."""
        digest = hashlib.sha256()
        for level, of_level in enumerate(self.numerics.levels):
            indices = np.array(of_level.indices(count), np.int64)
            for name in ("state", "digest"):
                digest.update(self.members.column(level, name, indices).tobytes())
        return {"members": digest.hexdigest(), "code": code_digest()}

    def missing(self, most: int) -> list[str]:
        """Return the names of members missing from the first `most` realizations although later members are there."""
        try:
            names = os.listdir(self.folder / "realizations")
        except OSError as error:
            raise not_readable(self.folder / "realizations", error) from error
        stems = [MEMBER_NAME.fullmatch(name.removesuffix(".h5")) for name in names if name.endswith(".h5")]
        stored = {match[0]: int(match[2]) for match in stems if match}
        gap = range(self.available, min(most, max(stored.values(), default=-1) + 1))
        expected = (member_name(level, index) for index in gap for level in self.numerics.of_index(index))
        return [name for name in expected if name not in stored]


def identity_of(description: dict[str, Any]) -> list[Any]:
    """Return what a run and its files have in common: the scene with its seed, and the numerics but `keep_fields`."""
    numerics = description.get("numerics")
    if isinstance(numerics, dict):
        numerics = {key: value for key, value in numerics.items() if key != "keep_fields"}
    return [description.get("scene"), numerics]


@cache
def code_digest() -> str:
    """Return a digest of the package's code: after a change of code nothing that it remembered counts."""
    digest = hashlib.sha256()
    for package in ("roughsim", "theory"):
        for path in sorted((Path(__file__).parents[2] / package).rglob("*.py")):
            digest.update(path.read_bytes())
    for entry in extensions("observables").values():  # those of other packages
        if (spec := find_spec(entry.module)) is not None and spec.origin is not None:
            digest.update(Path(spec.origin).read_bytes())
    return digest.hexdigest()
