"""The members of a run: their files, each read once, up to the first gap of each level, as a table per level."""

import os
import warnings
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from roughsim.errors import RecordError
from roughsim.estimate.rounds import Counts
from roughsim.grid import Array
from roughsim.observables.catalogue import NUMBERS
from roughsim.observables.distribution import BIN_AREAS, Bins
from roughsim.observables.member import Member, StoredMoments
from roughsim.observables.record import Sample
from roughsim.results.description import RunDescription
from roughsim.sliding.snapshots import snapshot_shape
from roughsim.store.disk import DamagedError, not_readable, set_aside
from roughsim.store.member_files import (
    FIELDS,
    KEPT_FIELDS,
    MEMBER_NAME,
    damaged,
    member_name,
    member_path,
    read_member,
)

_KNOWN = {
    "residual",
    "iterations",
    "seconds",
    "versions",
    "written",
}  # in the provenance of every member
_OF_RUN = {"scene", "numerics"}  # in the provenance of every member, too, and the same in all
Key = tuple[int, int]  # level and index
Damaged = Literal["refuse", "skip", "redo"]


class Members(dict[Key, Member]):
    """The members of a run folder by level and index, without their fields.

    The treatment of a file that cannot be used: "refuse" raises the error, "skip" counts the member as failed, "redo"
    moves the file aside with a warning, and the member is missing.
    """

    def __init__(
        self,
        folder: Path,
        description: RunDescription,
        speeds: tuple[float, ...],
        treatment: Damaged,
    ):
        super().__init__()
        self.folder, self.numerics, self.speeds = folder, description.numerics, speeds
        self.damaged: dict[Key, str] = {}  # reasons of files that cannot be used
        self.available = [0] * len(
            self.numerics.levels
        )  # members of each level before the first missing one
        self.counts: Counts = tuple(
            self.available
        )  # members of each level that count, for the methods
        self._treatment = treatment
        self._identity = _identity_of(
            {"scene": description.scene, "numerics": self.numerics.to_dict()}
        )
        self._modes: dict[
            int, list[tuple[int, ...]]
        ] = {}  # shapes of the stress spectra of each level

    def read(self, wanted: Iterable[int]) -> None:
        """Read new members, up to the first gap of each level and to the wanted number; errors as `take`."""
        for level, count in enumerate(wanted):
            while self.available[level] < count and self.take(level, self.available[level]):
                self.available[level] += 1

    def take(self, level: int, index: int) -> bool:
        """Read one member unless it was read before; False if its file is missing.

        RecordError if it is damaged or of another run, OSError if it cannot be read now, which is no damage.
        """
        key = level, index
        if key in self:
            return True
        path = member_path(self.folder, level, index)
        try:
            member = self._checked(path)
        except FileNotFoundError:
            return False
        except RecordError as error:
            redo, in_vain = (
                self._treatment == "redo",
                key in self.damaged,
            )  # as by workers of another version
            if self._treatment == "refuse" or (
                redo and (in_vain or not isinstance(error, DamagedError))
            ):
                raise
            self.damaged[key] = str(error)
            if redo:
                with suppress(FileNotFoundError):  # another process has moved it
                    kept = set_aside(path, self.folder / "damaged")
                    moved = (
                        f"{str(error).partition(';')[0]}; it was moved to {kept} and is done again"
                    )
                    warnings.warn(moved, RuntimeWarning, stacklevel=5)
                return False
            self[key] = Member(level, index, failure=str(error), provenance={"seconds": {}})
            return True
        self.damaged.pop(key, None)
        own = {name: value for name, value in member.provenance.items() if name not in _OF_RUN}
        self[key] = replace(member, curves={}, fields={}, provenance=own)
        return True

    def _checked(self, path: Path) -> Member:
        """Read a file and check that it belongs to this run; errors as `take`."""
        member = read_member(path, FIELDS if self._treatment == "redo" else ())
        provenance, grid = member.provenance, self.numerics.grid(member.level)
        if not {*provenance} >= _KNOWN or _identity_of(provenance) != self._identity:
            raise damaged(path, "is of another run: its scene, seed or numerics differ")
        if member.failure:
            return member
        modes = [part.wavenumber.shape for part in member.moments]
        levels = 1 if self.numerics.below(member.level) is None else 2
        points = {
            name: grid.shape if name in KEPT_FIELDS else snapshot_shape(grid.shape)
            for name in member.kept
        }
        fits = all(
            len(shape) < 2 or shape[-2:] == points[name] for name, shape in member.kept.items()
        )
        if member.speeds != self.speeds or len(modes) != levels or not fits:
            raise damaged(path, "is of another run: its speeds, levels or points differ")
        if modes != self._modes.setdefault(member.level, modes):
            raise RecordError(
                f"{path} or the members of its level read before are of another run: their wavenumbers differ; "
                f"move files of other runs out of the folder"
            )
        return member

    def missing(self, wanted: Iterable[int]) -> list[str]:
        """Return the names of members missing from a round although later ones of their level are there."""
        try:
            names = os.listdir(self.folder / "realizations")
        except OSError as error:
            raise not_readable(self.folder / "realizations", error) from error
        found = [
            MEMBER_NAME.fullmatch(name.removesuffix(".h5"))
            for name in names
            if name.endswith(".h5")
        ]
        stored = {(int(match[1]), int(match[2])) for match in found if match}
        last = dict(sorted(stored))  # the highest index of each level
        keys = (
            (level, i)
            for level, count in enumerate(wanted)
            for i in range(min(count, last.get(level, 0)))
        )
        return [member_name(*key) for key in keys if key not in stored]

    def failed(self, level: int) -> list[int]:
        """Return the indices of members of a level whose contact did not converge; damaged ones are left out."""
        read = ((i, self.get((level, i))) for i in range(self.counts[level]))
        failures = [i for i, member in read if member is not None and member.failure]
        return [i for i in failures if (level, i) not in self.damaged]

    def sound(self, level: int) -> list[int]:
        """Return the indices at which a level has numbers, and no counted member of the same surface failed."""
        stream = self.numerics.stream
        failed = [key for key, member in self.items() if member.failure]
        lost = {
            i for other, i in failed if i < self.counts[other] and stream(other) == stream(level)
        }
        return [i for i in range(self.counts[level]) if i not in lost and (level, i) in self]

    def kept(self, level: int, name: str) -> list[int]:
        """Return the indices of sound members that store a field, or the pressure, which gives all other fields."""
        stored = name if name in FIELDS else "pressure"
        return [i for i in self.sound(level) if stored in self[level, i].kept]

    def sample(
        self, level: int, below: bool = False, indices: Iterable[int] | None = None
    ) -> Sample:
        """Return the numbers of members of a level, or of the level below on the same surfaces; NaN if not stored.

        Default `indices`: the sound members.
        """
        numerics, grid = self.numerics, self.numerics.grid(level)
        of_level = numerics.levels[level]
        if below:
            of_level, grid = numerics.levels[numerics.below(level) or 0], numerics.grid_below(level)
        rows = np.array(self.sound(level) if indices is None else [*indices], np.intp)
        moments = [self[level, i].moments if (level, i) in self else [] for i in rows.tolist()]
        found = [each[below] if len(each) > below else None for each in moments]
        wavenumber = next((one.wavenumber for one in found if one), np.empty(0))
        nothing = StoredMoments({}, wavenumber, np.full(wavenumber.size, np.nan))
        stored = [one or nothing for one in found]
        numbers = {}
        for name, record in NUMBERS.items():
            missing = np.full(len(self.speeds) if record.per_speed else 1, np.nan)
            numbers[name] = np.array([one.numbers.get(name, missing) for one in stored]).reshape(
                -1, missing.size
            )
        return Sample(
            of_level.q_max,
            float(grid.shape[0]),
            rows,
            numbers,
            wavenumber,
            np.array([one.spectrum for one in stored]).reshape(rows.size, wavenumber.size),
            0.5 * float(np.hypot(*grid.lengths)),
            numerics.levels[level].parts > 1,
            self._bins([one.bins for one in stored]),
            level,
            numerics.stream(level),
        )

    def _bins(self, found: list[Bins | None]) -> Bins | None:
        """Return the bins of members together, (n, speeds, bins), NaN where they are missing; None if all are."""
        if not any(found):
            return None
        nothing = np.full((len(self.speeds), BIN_AREAS.size), np.nan)
        rows = [bins or Bins(nothing, nothing, nothing, nothing) for bins in found]
        return Bins(*map(np.array, zip(*rows, strict=True)))

    def samples(self, column: str) -> list[Sample]:
        """Return a column's levels, lowest first, with those below; levels without sound members are left out."""
        samples: dict[int | None, Sample] = {}
        for level in self.numerics.of_column(column):
            below = self.numerics.below(level)
            if self.sound(level) and (below is None or below in samples):
                lower = None if below is None else self.sample(level, below=True)
                samples[level] = replace(self.sample(level), below=lower)
        return list(samples.values())

    def slides(self) -> Sample:
        """Return the sample of the slides, with their T_flash as that of contacts; ValueError without a sound one."""
        level = self.numerics.slide
        if level is None:
            raise ValueError(
                f'{self.folder} has no column "sliding": its scene has history = "frozen"'
            )
        sample = self.sample(level)
        if not sample.rows.size:
            raise ValueError(f"{self.folder} has no sound member that slides yet; let it run first")
        numbers = sample.numbers | {
            "flash_temperature": sample.numbers["sliding_flash_temperature"]
        }
        return replace(sample, numbers=numbers)

    def seconds(self, level: int) -> Array:
        """Return the computing time of each member of a level, s, also of those that do not count."""
        members = [member for (of_level, _), member in self.items() if of_level == level]
        return np.array([sum(member.provenance["seconds"].values()) for member in members])


def _identity_of(description: Mapping[str, Any]) -> list[Any]:
    """Return the common identity of a run and its members: scene with seed, and numerics without `keep_fields`."""
    numerics = description.get("numerics")
    if isinstance(numerics, dict):
        numerics = {key: value for key, value in numerics.items() if key != "keep_fields"}
    return [description.get("scene"), numerics]
