"""`Reader`: reads the files of a run folder as they appear, each once, and level by level up to the first gap."""

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from roughsim.errors import RecordError
from roughsim.grid import Array
from roughsim.observables.catalogue import AXIS, NUMBERS
from roughsim.results.members import Key, Members
from roughsim.scene.numerics import Numerics
from roughsim.store.disk import not_readable
from roughsim.store.member_files import MEMBER_NAME, Member, member_name, member_path, read_member

KNOWN = ("residual", "iterations", "seconds", "versions", "written")  # of the provenance of a member


class Reader:
    """The members of a run folder, and which files are damaged, and why.

    `identity` (from `identity_of`) are the scene and numerics that every file must have. With `skip_damaged` a damaged
    file counts as a failed member; otherwise it is an error.
    """

    def __init__(
        self, folder: Path, numerics: Numerics, speeds: tuple[float, ...], identity: list[Any], skip_damaged: bool
    ):
        self.folder, self.numerics, self.identity = folder, numerics, identity
        self.members = Members(numerics, speeds)
        self.damaged: dict[Key, str] = {}
        self.files: dict[Key, tuple[str, int, int]] = {}  # name, size and time, ns, of what was read
        self.available = [0] * len(numerics.levels)  # members of each level without a gap
        self._skip_damaged = skip_damaged
        self._modes: dict[int, list[tuple[int, ...]]] = {}  # of the stress spectra of each level

    def refresh(self, most: int) -> bool:
        """Read the members that have appeared since, of each level at most `most`, and damaged ones again.

        Return whether damaged ones were read again. Errors as `take`.
        """
        again = [*self.damaged]
        self.damaged.clear()
        for level, index in again:
            del self.members[level, index]
            self.available[level] = min(self.available[level], index)
        for level in range(len(self.available)):
            while self.available[level] < most and self.take(level, self.available[level]):
                self.available[level] += 1
        return bool(again)

    def take(self, level: int, index: int) -> bool:
        """Read one member unless it was read before; False if its file is missing.

        RecordError if it is damaged or of another run, OSError if it cannot be read now, which is no damage.
        """
        if (level, index) in self.members:
            return True
        path = member_path(self.folder, level, index)
        try:
            status = os.stat(path)
            member = read_member(path)
            if not self._fits(member):
                raise RecordError(
                    f"{path} is of another run: its scene, seed or numerics differ; move it out of the folder"
                )
            self.files[level, index] = path.name, status.st_size, status.st_mtime_ns
        except FileNotFoundError:
            return False
        except RecordError as error:
            if not self._skip_damaged:
                raise
            self.damaged[level, index] = str(error)
            member = Member(level, index, failure=str(error), provenance={"seconds": {}})
        known = {name: member.provenance[name] for name in KNOWN if name in member.provenance}
        self.members[level, index] = replace(member, curves={}, provenance=known)
        return True

    def _fits(self, member: Member) -> bool:
        """Whether a member is of this run: a header may say one thing, and the arrays another."""
        if not set(KNOWN) <= set(member.provenance) or identity_of(member.provenance) != self.identity:
            return False
        if member.failure:
            return True
        modes = [part.wavenumber.shape for part in member.moments]
        levels = 1 if self.numerics.below(member.level) is None else 2
        fits = member.speeds == self.members.speeds and len(modes) == levels
        return fits and modes == self._modes.setdefault(member.level, modes)

    def marches(self, counts: Sequence[int]) -> tuple[int, list[int]]:
        """Return the level of marches, and which of those that count are sound; ValueError if there is none."""
        level = self.numerics.march
        if level is None:
            raise ValueError(f'{self.folder} has no column "sliding": its scene has history = "frozen"')
        if sound := self.members.sound(level, counts[level]):
            return level, sound
        raise ValueError(f"{self.folder} has no sound member that slides yet; let it run first")

    def marched(self, counts: Sequence[int]) -> dict[str, Array]:
        """Return the numbers of the marches that count, (members, speeds); errors as `marches`."""
        level, indices = self.marches(counts)
        return {name: self.members.numbers(level, name, indices) for name, n in NUMBERS.items() if n.of_march}

    def curves(self, counts: Sequence[int]) -> dict[str, Array]:
        """Return what marches stored over the slid distance, `slid_distance` once, all else a row each; as `marches`.

        RecordError or OSError if a file was damaged or moved after its numbers had been read.
        """
        level, indices = self.marches(counts)
        rows = [read_member(member_path(self.folder, level, index)).curves for index in indices]
        return {name: np.stack([row[name] for row in rows]) for name in rows[0]} | {AXIS: rows[0][AXIS]}

    def missing(self, wanted: Sequence[int]) -> list[str]:
        """Return the names of members missing from a round although later ones of their level are there."""
        try:
            names = os.listdir(self.folder / "realizations")
        except OSError as error:
            raise not_readable(self.folder / "realizations", error) from error
        found = [MEMBER_NAME.fullmatch(name.removesuffix(".h5")) for name in names if name.endswith(".h5")]
        stored = {(int(match[1]), int(match[2])) for match in found if match}
        last = dict(sorted(stored))  # the highest index of each level
        keys = ((level, i) for level, count in enumerate(wanted) for i in range(min(count, last.get(level, 0))))
        return [member_name(*key) for key in keys if key not in stored]


def identity_of(description: dict[str, Any]) -> list[Any]:
    """Return what a run and its files have in common: the scene with its seed, and the numerics but `keep_fields`."""
    numerics = description.get("numerics")
    if isinstance(numerics, dict):
        numerics = {key: value for key, value in numerics.items() if key != "keep_fields"}
    return [description.get("scene"), numerics]
