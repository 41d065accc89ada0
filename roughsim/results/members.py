"""The members of a run: its files, each read once while it stays the same, as a table per level."""

import warnings
from collections import Counter
from collections.abc import Iterable, Mapping
from contextlib import suppress
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
from roughsim.scene import Scene
from roughsim.sliding.snapshots import snapshot_shape
from roughsim.store.disk import DamagedError, set_aside
from roughsim.store.member_files import (
    FIELDS,
    KEPT_FIELDS,
    damaged,
    fields_path,
    member_name,
    read_fields,
)
from roughsim.store.parts import Part, read_part
from roughsim.store.saving import Stamp, listed, replace_damaged, sound_part

_KNOWN = {
    "residual",
    "iterations",
    "seconds",
    "versions",
    "written",
}  # in the provenance of every member
_MOVES = 10  # of a file that other processes move whenever it is to be read, at most
Key = tuple[int, int]  # level and index
Damaged = Literal["refuse", "skip", "redo"]


class Members(dict[Key, Member]):
    """The members of a run folder by level and index, without their fields.

    The treatment of a damaged file: "refuse" raises the error; "skip" lets the lost members count as failed; "redo"
    moves the file aside with a warning, stores its sound members again, and the others are missing.
    """

    def __init__(self, folder: Path, description: RunDescription, scene: Scene, treatment: Damaged):
        super().__init__()
        self.folder, self.numerics, self.scene = folder, description.numerics, scene
        self.speeds = scene.speeds
        self.damaged: dict[str, str] = {}  # reasons by the names of files that cannot be used
        levels = len(self.numerics.levels)
        self.available = [0] * levels  # members of each level before the first missing one
        self.counts: Counts = (0,) * levels  # members of each level that count, for the methods
        self.spent = [(0, 0.0)] * levels  # number and computing time of all members, s
        self.lost: set[Key] = set()  # members that count as failed, as their file is damaged
        self.owner = ""  # name of this process, if it writes members: it does not read them
        self._treatment = treatment
        self._read: set[Stamp] = set()  # of files that have been read
        self._gone: Counter[tuple[Path, Stamp]] = (
            Counter()
        )  # times that a file was gone when it was opened
        self.of_run = {"scene": description.scene, "numerics": self.numerics.to_dict()}
        self._identity = _identity_of(self.of_run)
        self._modes: dict[
            int, list[tuple[int, ...]]
        ] = {}  # shapes of the stress spectra of each level

    def read(self) -> None:
        """Read the files that are new since the last call.

        RecordError if one is damaged or of another run, OSError if it cannot be read now, which is no damage.
        """
        while not all(
            self._take(path, stamp)
            for path, stamp in listed(self.folder).items()
            if stamp not in self._read
            and not (self.owner and path.name.startswith(f"{self.owner}-"))  # an own file
        ):
            pass  # another process has moved a file meanwhile, or a damaged one was moved aside
        if self.damaged:
            self._fill_gaps()

    def _take(self, path: Path, stamp: Stamp) -> bool:
        """Read a file; False if it is not there any more. Errors as `read`."""
        try:
            part = read_part(path, self.keys() - self.lost)
            self._check(path, part)
        except FileNotFoundError:
            self._gone[path, stamp] += 1
            if self._gone[path, stamp] > _MOVES:
                raise
            return False
        except RecordError as error:
            return self._damaged(path, stamp, error)
        for member in part.members:
            if self._treatment != "redo" or self._has_fields(member):
                self.add(member)
        self._read.add(stamp)
        return True

    def _damaged(self, path: Path, stamp: Stamp, error: RecordError) -> bool:
        """Treat a damaged file, or one of another run: True if it is not to be read again."""
        redo = self._treatment == "redo"
        if self._treatment == "refuse" or (redo and not isinstance(error, DamagedError)):
            raise error
        sound = sound_part(path) if isinstance(error, DamagedError) else Part({}, [])
        try:
            self._check(path, sound)
        except RecordError:
            sound = Part({}, [])
        if redo:
            with suppress(FileNotFoundError):  # another process has moved it
                _warn_moved(error, replace_damaged(path, self.folder, sound))
            return False
        self.damaged[path.name] = str(error)
        for member in sound.members:
            self.add(member)
        self._read.add(stamp)
        return True

    def _check(self, path: Path, part: Part) -> None:
        """Check that the members of a file belong to this run: RecordError."""
        if part.members and _identity_of(part.header) != self._identity:
            raise damaged(path, "is of another run: its scene, seed or numerics differ")
        for member in part.members:
            self._check_member(path, member)

    def _check_member(self, path: Path, member: Member) -> None:
        """Check that a member has the levels, speeds and points of this run: RecordError, naming its file."""
        fits = 0 <= member.level < len(self.numerics.levels) and member.index >= 0
        if not fits or not {*member.provenance} >= _KNOWN:
            raise damaged(path, "is of another run: its levels differ")
        if member.failure:
            return
        modes = [part.wavenumber.shape for part in member.moments]
        levels = 1 if self.numerics.below(member.level) is None else 2
        whole = self.numerics.levels[member.level].shape
        fits = all(
            shape[-2:] == (whole if name in KEPT_FIELDS else snapshot_shape(whole))
            for name, shape in member.kept.items()
            if len(shape) > 1
        )
        if member.speeds != self.speeds or len(modes) != levels or not fits:
            raise damaged(path, "is of another run: its speeds, levels or points differ")
        if modes != self._modes.setdefault(member.level, modes):
            raise RecordError(
                f"{path} or the members of its level read before are of another run: their wavenumbers differ; "
                f"move files of other runs out of the folder"
            )

    def _has_fields(self, member: Member) -> bool:
        """Whether the kept fields of a member are there and sound; damaged ones are moved aside with a warning."""
        if not member.kept:
            return True
        path = fields_path(self.folder, member.level, member.index)
        try:
            header, fields = read_fields(path)
            shapes = {name: values.shape for name, values in fields.items()}
            if _identity_of(header) != self._identity or shapes != member.kept:
                raise damaged(path, "is of another run: its scene, seed or numerics differ")
        except FileNotFoundError:
            return False
        except DamagedError as error:
            with suppress(FileNotFoundError):
                _warn_moved(error, set_aside(path, self.folder / "damaged"))
            return False
        return True

    def add(self, member: Member) -> None:
        """Take a new member of this run."""
        key = level, _ = member.level, member.index
        if key in self and key not in self.lost:
            return
        self[key] = member
        self.lost.discard(key)
        while (level, self.available[level]) in self:
            self.available[level] += 1
        count, spent = self.spent[level]
        self.spent[level] = count + 1, spent + sum(member.provenance["seconds"].values())

    def _fill_gaps(self) -> None:
        """Let members before others, which damaged files may have had, count as failed: the others count, too."""
        for level, last in dict(sorted(self)).items():
            for index in range(self.available[level], last):
                if (level, index) not in self:
                    failure = f"lost with {', '.join(self.damaged)}"
                    self.add(Member(level, index, failure, provenance={"seconds": {}}))
                    self.lost.add((level, index))

    def all_read(self) -> Part:
        """Return all members, after those of new files were read; errors as `read`."""
        self.read()
        return Part(self.of_run, [*self.values()])

    def check_computed(self, member: Member) -> None:
        """Refuse a member that a worker of another version computed otherwise: RecordError."""
        self._check_member(self.folder / member_name(member.level, member.index), member)

    def missing(self, wanted: Iterable[int]) -> list[str]:
        """Return the names of members missing from a round although later ones of their level are there."""
        last = dict(sorted(self))  # the highest index of each level
        keys = (
            (level, i)
            for level, count in enumerate(wanted)
            for i in range(min(count, last.get(level, 0)))
        )
        return [member_name(*key) for key in keys if key not in self]

    def failed(self, level: int) -> list[int]:
        """Return the indices of members of a level whose contact did not converge; damaged ones are left out."""
        read = ((i, self.get((level, i))) for i in range(self.counts[level]))
        failures = [i for i, member in read if member is not None and member.failure]
        return [i for i in failures if (level, i) not in self.lost]

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
        missing = np.full((rows.size, len(self.speeds)), np.nan)
        numbers = {
            name: missing if one.per_speed else missing[:, :1] for name, one in NUMBERS.items()
        }
        for name in {name for one in stored for name in one.numbers} & NUMBERS.keys():
            absent = numbers[name][0]
            numbers[name] = np.array([one.numbers.get(name, absent) for one in stored])
        return Sample(
            of_level.q_max,
            float(grid.shape[0]),
            rows,
            numbers,
            wavenumber,
            np.array([one.spectrum for one in stored]).reshape(rows.size, wavenumber.size),
            0.5 * float(np.hypot(*grid.stretched(self.scene.lay).lengths)),
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

    def seconds(self, level: int) -> Array:
        """Return the computing time of each member of a level, s, also of those that do not count."""
        members = [member for (of_level, _), member in self.items() if of_level == level]
        return np.array([sum(member.provenance["seconds"].values()) for member in members])


def _warn_moved(error: RecordError, kept: Path) -> None:
    words = f"{str(error).partition(';')[0]}; it was moved to {kept}"
    warnings.warn(f"{words} and is done again", RuntimeWarning, stacklevel=6)


def _identity_of(description: Mapping[str, Any]) -> list[Any]:
    """Return the common identity of a run and its members: scene with seed, and numerics without `keep_fields`."""
    numerics = description.get("numerics")
    if isinstance(numerics, dict):
        numerics = {key: value for key, value in numerics.items() if key != "keep_fields"}
    return [description.get("scene"), numerics]
