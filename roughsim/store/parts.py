"""Parts: files with the numbers of many members.

A part has a group for each level, as `L2`, in which all arrays have `realization` as their first axis. `numbers` has
all numbers over `below`, `number` and `speed`; numbers that do not depend on the speed are stored at the first one.
`stress_spectrum` has the axes `below` and `wavenumber`. The axis `below` is 0 for the level, and 1 for the level below
it on the same surface. Missing values are NaN. If the scene asks for the distribution of the temperature, `bin_…` have
the bins of the contact area as their last axis. `about` has all other data of a member as JSON, and `digest` the
SHA-256 of all its values.
"""

import hashlib
import json
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughsim.observables.catalogue import AXIS, CURVES, NUMBERS
from roughsim.observables.distribution import BIN_AREAS, Bins
from roughsim.observables.member import Member, StoredMoments
from roughsim.store.member_files import (
    BINS,
    FIELDS,
    FORMAT,
    KINDS,
    MEMBER,
    REFUSED,
    header_of,
    labelled,
    read_sealed,
    write_sealed,
)

_COMMON = ("versions", "seed", "stream", "threads")  # of the provenance: in most parts the same
_VALUES = ("numbers", "wavenumber", "stress_spectrum")
Arrays = dict[str, NDArray[Any]]


class Part(NamedTuple):
    """The members in a file, without fields, and what is common to them."""

    header: dict[str, Any]  # with scene and numerics of the run
    members: list[Member]


def of_run(header: Mapping[str, Any]) -> dict[str, Any]:
    """Return scene and numerics of the run from the header of a file."""
    return {key: header.get(key) for key in ("scene", "numerics")}


def write_part(path: Path, run: Mapping[str, Any], members: Iterable[Member]) -> None:
    """Write members into a file, whole or not at all, without their fields.

    `run` has the scene and the numerics of their run. OSError, naming the path, if the disk refuses.
    """
    from roughsim.store.hdf5 import write_arrays  # loads h5py

    levels: dict[int, list[Member]] = {}
    for member in sorted(members, key=lambda one: (one.level, one.index)):
        levels.setdefault(member.level, []).append(member)

    def fill(file: Any) -> None:
        about = []
        for level, of_level in levels.items():
            common, arrays = _stacked(of_level)
            about.append(common)
            write_arrays(file.create_group(f"L{level}"), labelled(arrays))
        file.attrs["header"] = json.dumps({"format_version": FORMAT, **run, "levels": about})

    write_sealed(path, fill)


def read_part(path: Path, known: Collection[tuple[int, int]] = ()) -> Part:
    """Read a file of members, without those that are `known` by level and index, after a check of all its bytes.

    RecordError, naming the file, if it is damaged or of another format. OSError if it cannot be read now.
    """

    def read(file: Any) -> Part:
        header = header_of(path, file)
        levels = [_Level(file, common) for common in header["levels"]]
        return Part(header, [one for level in levels for one in level.members(known)])

    return read_sealed(path, read)


def read_sound(path: Path) -> Part:
    """Read the members of a damaged file whose own digests match.

    HDF5 may crash or never end on damaged bytes: to be called in a process of its own.
    """
    import h5py

    part = Part({}, [])
    try:
        with h5py.File(path, "r", locking=False) as file:
            part.header.update(header_of(path, file))
            for common in part.header["levels"]:
                level = _Level(file, common)
                part.members.extend(level.members((), level.sound()))
    except REFUSED:
        pass  # what was read before is sound
    return part


def _stacked(members: Sequence[Member]) -> tuple[dict[str, Any], Arrays]:
    """Return what is common to members of a level, and their arrays by name, each after its axes."""
    first = next((one for one in members if one.moments), members[0])
    shared = {
        key: first.provenance[key]
        for key in _COMMON
        if key in first.provenance
        and all(one.provenance.get(key) == first.provenance[key] for one in members)
    }
    about = [
        {
            "failure": one.failure,
            "kept": one.kept,
            "provenance": {k: v for k, v in one.provenance.items() if k not in shared},
        }
        for one in members
    ]
    names = list(dict.fromkeys(name for one in members for name in one.numbers))
    common = {
        "level": first.level,
        "lengths": first.lengths,
        "speeds": first.speeds,
        "provenance": shared,
        "numbers": names,
        "curves": list(first.curves),
        "bins": bool(first.moments) and first.moments[0].bins is not None,
    }
    arrays: Arrays = {
        MEMBER: np.array([one.index for one in members]),
        "about": np.array([json.dumps(one).encode() for one in about]),
    }
    if names:
        arrays |= _moment_arrays(members, first, names)
    for name, values in first.curves.items():
        nothing = np.full(values.shape, np.nan)
        rows = [one.curves.get(name, nothing) for one in members]
        arrays[name] = values if name == AXIS else np.array(rows)
    arrays["digest"] = np.array(_digests(common, arrays))
    return common, arrays


def _moment_arrays(members: Sequence[Member], first: Member, names: list[str]) -> Arrays:
    """Return numbers, spectra and bins of members of a level; NaN for failed ones."""
    wavenumber, of_below = first.moments[0].wavenumber, first.moments[-1].wavenumber
    if not np.array_equal(
        of_below, wavenumber[: len(of_below)]
    ):  # a small grid has entries of its own
        wavenumber = np.union1d(wavenumber, of_below)
    places = [np.searchsorted(wavenumber, each.wavenumber) for each in first.moments]
    size = len(members), len(first.moments)
    numbers = np.full((*size, len(names), len(first.speeds)), np.nan)
    spectra = np.full((*size, len(wavenumber)), np.nan)
    for row, member in enumerate(members):
        for k, each in enumerate(member.moments):
            for i, name in enumerate(names):
                values = each.numbers.get(name, ())
                numbers[row, k, i, : len(values)] = values
            spectra[row, k, places[k]] = each.spectrum
    units = [NUMBERS[name].unit if name in NUMBERS else "" for name in names]
    arrays: Arrays = {
        "below": np.arange(float(size[1])),
        "number": np.array(names, np.bytes_),
        "unit": np.array(units, np.bytes_),
        "speed": np.array(first.speeds, np.float64),
        "numbers": numbers,
        "wavenumber": wavenumber,
        "stress_spectrum": spectra,
    }
    if first.moments[0].bins is not None:
        arrays["contact_area"] = BIN_AREAS
        bins = np.full((len(BINS), *size, len(first.speeds), BIN_AREAS.size), np.nan)
        for row, member in enumerate(members):
            for k, each in enumerate(member.moments):
                if each.bins is not None:
                    bins[:, row, k] = each.bins
        arrays |= dict(zip(BINS, bins, strict=True))
    return arrays


def _digests(common: Mapping[str, Any], arrays: Arrays) -> list[bytes]:
    """Return the SHA-256 of all values of each member of a level, and of what is common to them."""
    shared = hashlib.sha256(json.dumps(common, sort_keys=True).encode())
    if "wavenumber" in arrays:
        shared.update(arrays["wavenumber"].tobytes())
    own = [name for name in sorted(arrays) if KINDS[name].axes[0] == MEMBER and name != "digest"]
    digests = []
    for row in range(len(arrays[MEMBER])):
        digest = shared.copy()
        for name in own:
            digest.update(arrays[name][row].tobytes())
        digests.append(digest.hexdigest().encode())
    return digests


class _Level:
    """The members of one level in an open file; ValueError or another of `REFUSED` if no writer made the file.

    A forger of a header can forge its seal, too.
    """

    def __init__(self, file: Any, common: Mapping[str, Any]):
        from roughsim.store.hdf5 import opened_array, opened_group, read_array, read_text

        self.common, self.level = common, int(common["level"])
        self.names, self.speeds = list(common["numbers"]), [float(v) for v in common["speeds"]]
        self.curves = [name for name in common["curves"] if name in CURVES]
        self._group = opened_group(file, f"L{self.level}")
        bins = list(BINS) if common["bins"] else []
        values = [*(_VALUES if self.names else ()), *bins, *self.curves]
        kinds: dict[str, Any] = {MEMBER: np.int64, **dict.fromkeys(values, np.float64)}
        self.arrays: Arrays = {
            name: read_array(opened_array(self._group, name, len(KINDS[name].axes)), kind)
            for name, kind in kinds.items()
        }
        self.arrays["about"] = read_text(opened_array(self._group, "about", 1))
        sizes = {
            "number": len(self.names),
            "speed": len(self.speeds),
            "contact_area": BIN_AREAS.size,
        }
        for name, array in self.arrays.items():
            for axis, size in zip(KINDS[name].axes, array.shape, strict=True):
                if sizes.setdefault(axis, size) != size:
                    raise ValueError(f"{name} has another size than its header or its axes")

    def sound(self) -> set[int]:
        """Return the rows whose own digests match."""
        from roughsim.store.hdf5 import opened_array, read_text

        stored = read_text(opened_array(self._group, "digest", 1)).tolist()
        own = _digests(self.common, self.arrays)
        return {row for row, digest in enumerate(own) if digest == stored[row]}

    def members(
        self, known: Collection[tuple[int, int]], rows: Collection[int] | None = None
    ) -> Iterator[Member]:
        """Yield the members that are not known, of all rows or of some."""
        length_x, length_y = (float(length) for length in self.common["lengths"])
        for row, index in enumerate(self.arrays[MEMBER].tolist()):
            if (self.level, index) in known or (rows is not None and row not in rows):
                continue
            about = json.loads(self.arrays["about"][row])
            failure, provenance = about["failure"], about["provenance"]
            # a member has either a failure or numbers
            if not isinstance(failure, str) or not (failure or self.names):
                raise ValueError("its header is none that a writer of this format makes")
            curves = {
                name: self.arrays[name] if name == AXIS else self.arrays[name][row]
                for name in self.curves
            }
            kept = {
                name: tuple(map(int, shape))
                for name, shape in about["kept"].items()
                if name in FIELDS
            }
            yield Member(
                self.level,
                index,
                failure,
                () if failure else tuple(self._moments(row)),
                {} if failure else curves,
                lengths=(length_x, length_y),
                speeds=() if failure else tuple(self.speeds),
                provenance={**provenance, **self.common["provenance"]},
                kept=kept,
            )

    def _moments(self, row: int) -> Iterator[StoredMoments]:
        """Yield the moments of a member at its level, and at the level below it."""
        numbers, wavenumber, spectra = (self.arrays[name] for name in _VALUES)
        for k, (rows, spectrum) in enumerate(zip(numbers[row], spectra[row], strict=True)):
            # numbers of a package that is not installed here are kept as they are
            own = {
                name: values if name not in NUMBERS or NUMBERS[name].per_speed else values[:1]
                for name, values in zip(self.names, rows, strict=True)
            }
            there = ~np.isnan(spectrum)
            bins = None
            if self.common["bins"]:
                bins = Bins(*(self.arrays[name][row, k] for name in BINS))
            yield StoredMoments(own, wavenumber[there], spectrum[there], bins)
