"""The file of a member (one realization of one level): written in one piece, with a checksum.

It is an HDF5 file in the netCDF-4 format. `numbers` has all numbers over `below`, `number` and `speed`; numbers that do
not depend on the speed are stored at the first one. `stress_spectrum` has the axes `below` and `wavenumber`. The axis
`below` is 0 for the level of the file, and 1 for the level below it on the same surface. Missing values are NaN. If the
scene asks for the distribution of the temperature, `bin_…` have the bins of the contact area as their last axis. The
attribute `header` holds all other data as JSON. If fields are kept, the group `entry` links to them (NeXus). The HDF5
data is followed by the seal: a line with the name of the file and the SHA-256 of all bytes before it.
"""

import hashlib
import io
import json
import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughsim.errors import RecordError
from roughsim.grid import Array
from roughsim.observables.catalogue import AXIS, CURVES, NUMBERS
from roughsim.observables.distribution import BIN_AREAS, Bins
from roughsim.observables.member import Member, StoredMoments
from roughsim.sliding import snapshots
from roughsim.store.disk import DamagedError, place_bytes, read_bytes, seal

FORMAT = 6  # of members and of run.json
AGAIN = "repeat the command that made the folder"  # advice on a lost member
MEMBER_NAME = re.compile(
    r"L(\d+)-(\d{6,})"
)  # level and index; of the file, of its claim, and in messages
_DIGEST = 65  # bytes at the end: SHA-256 of all before, as text, and the end of the line


class Kind(NamedTuple):
    """Unit and axes of an array in a file; the axes of an axis are its own name."""

    unit: str
    axes: tuple[str, ...]
    description: str = ""  # in exported files


KEPT_FIELDS = {
    "heights": Kind("m", ("x", "y"), "composite heights"),
    "pressure": Kind("Pa", ("x", "y"), "contact pressure, positive in compression"),
}
_OF_BINS = ("below", "speed", "contact_area")  # axes
BINS = {  # of the contact area, in the order of `Bins`
    "bin_temperature": Kind("K", _OF_BINS, "mean temperature"),
    "bin_pressure": Kind("Pa", _OF_BINS, "mean pressure"),
    "bin_pressure_deviation": Kind("Pa", _OF_BINS, "standard deviation of the pressure"),
    "bin_pressure_skewness": Kind("1", _OF_BINS, "skewness of the pressure"),
}
FIELDS = KEPT_FIELDS | {name: Kind(*about) for name, about in snapshots.FIELDS.items()}
KINDS = {
    "below": Kind("", ("below",)),
    "number": Kind("", ("number",)),
    "unit": Kind("", ("number",)),
    "speed": Kind("m/s", ("speed",)),
    "numbers": Kind("", ("below", "number", "speed")),
    "wavenumber": Kind("1/m", ("wavenumber",)),
    "stress_spectrum": Kind("Pa^2", ("below", "wavenumber")),
    "contact_area": Kind("1", ("contact_area",)),
    **BINS,
    **{
        name: Kind(curve.unit, (*["speed"] * curve.per_speed, AXIS))
        for name, curve in CURVES.items()
    },
    "x": Kind("m", ("x",)),
    "y": Kind("m", ("y",)),
    **FIELDS,
}


def member_name(level: int, index: int) -> str:
    """Return the name of a member, as "L0-000003"."""
    return f"L{level}-{index:06d}"


def member_path(folder: Path, level: int, index: int) -> Path:
    """Return the place of a member's file in a run folder."""
    return folder.joinpath("realizations", f"{member_name(level, index)}.h5")


def write_member(folder: Path, member: Member) -> None:
    """Write a member's file, whole or not at all; OSError, naming the path, if the disk refuses."""
    from roughsim.store.hdf5 import hdf5_bytes  # loads h5py

    path = member_path(folder, member.level, member.index)
    content = hdf5_bytes(lambda file: _fill(file, member))
    place_bytes(path, content, seal(path.name, hashlib.sha256(content)))


def read_member(path: Path, fields: Iterable[str] = ()) -> Member:
    """Read a member's file, with some of its kept fields, after a check of all its bytes.

    RecordError, naming the file, if it is damaged or of another format. OSError if it cannot be read now.
    """
    import h5py

    content = read_bytes(path)
    digest = hashlib.sha256(memoryview(content)[:-_DIGEST]).hexdigest()
    if content[-_DIGEST:] != f"{digest}\n".encode():
        raise damaged(path, "is damaged (its SHA-256 does not match)")
    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            return _member_of(path, file, fields)
    except RecordError:
        raise
    except MemoryError as error:  # on a larger machine it may be readable
        raise RecordError(f"{path}: {error}; nothing was read") from error
    except (
        OSError,
        LookupError,
        ValueError,
        TypeError,
        AttributeError,
        RuntimeError,
        RecursionError,
    ) as error:
        raise damaged(path, f"is damaged ({error})") from error


def read_field(path: Path, name: str) -> NDArray[np.float32]:
    """Read one kept field of a member's file after a check of all bytes; errors as for `read_member`."""
    values = read_member(path, (name,)).fields.get(name)
    if values is None:
        raise damaged(path, f"is damaged (it has no {name})")
    return values


def damaged(path: Path, fault: str) -> DamagedError:
    """Return the error that names a file with its fault, as "is damaged (…)", and gives advice."""
    return DamagedError(
        f"{path} {fault}; {AGAIN}: it moves the file into 'damaged' and computes the member again"
    )


def check_format(path: Path, version: int, provenance: Any, known: int = FORMAT) -> None:
    """Refuse another version of the format than `known`: RecordError.

    `provenance` may have the versions of packages.
    """
    if version > known:
        raise RecordError(
            f"{path} has format version {version}; this roughsim reads {known}: update it"
        )
    if version < known:
        versions = provenance.get("versions") if isinstance(provenance, dict) else None
        number = versions.get("roughsim", "") if isinstance(versions, dict) else ""
        writer = (
            f"the roughsim that wrote it ({number})" if number else "the roughsim that wrote it"
        )
        reads = f"has the older format {version}, and this roughsim reads {known}"
        raise RecordError(f"{path} {reads}; read or export it with {writer}")


def _fill(file: Any, member: Member) -> None:
    """Store a member in a new HDF5 file."""
    from roughsim.store.hdf5 import write_arrays

    header = {
        name: getattr(member, name)
        for name in ("level", "index", "failure", "lengths", "speeds", "provenance")
    }
    header |= {name: list(getattr(member, name)) for name in ("numbers", "curves", "fields")}
    if member.moments and member.moments[0].bins is not None:
        header["bins"] = list(BINS)
    file.attrs["header"] = json.dumps({"format_version": FORMAT, **header})
    labelled = []
    for name, values in _arrays_of(member):
        kind = KINDS[name]
        labelled.append((name, kind.axes, values, {"units": kind.unit} if kind.unit else {}))
    write_arrays(file, labelled)
    if member.fields:
        _show(file, list(member.fields))


def _arrays_of(member: Member) -> Iterator[tuple[str, NDArray[Any]]]:
    """Yield the arrays of a member with their names, each after its axes."""
    if moments := member.moments:
        wavenumber, of_below = moments[0].wavenumber, moments[-1].wavenumber
        if not np.array_equal(
            of_below, wavenumber[: len(of_below)]
        ):  # a small grid has entries of its own
            wavenumber = np.union1d(wavenumber, of_below)
        numbers = np.full((len(moments), len(member.numbers), len(member.speeds)), np.nan)
        spectra = np.full((len(moments), len(wavenumber)), np.nan)
        for rows, spectrum, each in zip(numbers, spectra, moments, strict=True):
            for row, name in zip(rows, member.numbers, strict=True):
                row[: len(each.numbers[name])] = each.numbers[name]
            spectrum[np.searchsorted(wavenumber, each.wavenumber)] = each.spectrum
        yield "below", np.arange(float(len(moments)))
        yield "number", np.array(list(member.numbers), np.bytes_)
        yield "unit", np.array([NUMBERS[name].unit for name in member.numbers], np.bytes_)
        yield "speed", np.array(member.speeds, np.float64)
        yield "numbers", numbers
        yield "wavenumber", wavenumber
        yield "stress_spectrum", spectra
        of_levels = [each.bins for each in moments if each.bins is not None]
        if of_levels:
            yield "contact_area", BIN_AREAS
            for name, values in zip(BINS, zip(*of_levels, strict=True), strict=True):
                yield name, np.array(values)
    yield from member.curves.items()
    shape = next((values.shape[-2:] for values in member.fields.values() if values.ndim > 1), ())
    for axis, points, length in zip("xy", shape, member.lengths, strict=False):
        yield axis, np.arange(points) * (length / points)
    for name, kept in member.fields.items():
        yield name, np.asarray(kept, np.float32)


def _show(file: Any, names: list[str]) -> None:
    """Let viewers draw the kept fields, as NeXus wants it: hard links to a signal, its axes, and the other fields."""
    signal = "film_pressure" if snapshots.AXIS in names else "pressure"
    file.attrs.update(NX_class="NXroot", default="entry")
    entry = file.create_group("entry")
    entry.attrs.update(NX_class="NXentry", default="fields")
    shown = entry.create_group("fields")
    axes = KINDS[signal].axes
    shown.attrs.update(NX_class="NXdata", signal=signal, axes=list(axes))
    for name in dict.fromkeys((signal, *axes, *names)):
        shown[name] = file[name]


def _member_of(path: Path, file: Any, fields: Iterable[str]) -> Member:
    """Return the member in an open file; RecordError for another format, other errors if no writer made the file.

    A forger of a header can forge its seal, too.
    """
    from roughsim.store.hdf5 import opened_array, read_array

    def opened(name: str) -> Any:
        return opened_array(file, name, len(KINDS[name].axes))

    header = json.loads(file.attrs["header"])
    # headers up to format 4 have no version: it stood beside them
    check_format(path, int(header.get("format_version", 4)), header.get("provenance"))
    level, index = (int(number) for number in path.stem[1:].split("-"))
    if [header["level"], header["index"]] != [level, index]:
        raise ValueError(
            f"it holds level {header['level']!r}, index {header['index']!r}, unlike its name"
        )
    failure, provenance = header["failure"], header["provenance"]
    # a member has either a failure or numbers
    if (
        not isinstance(provenance, dict)
        or not isinstance(failure, str)
        or bool(failure) == bool(header["numbers"])
    ):
        raise ValueError("its header is none that a writer of this format makes")
    speeds = tuple(float(speed) for speed in header["speeds"])
    length_x, length_y = (float(length) for length in header["lengths"])
    moments: tuple[StoredMoments, ...] = ()
    if not failure:
        arrays = [
            read_array(opened(name), np.float64)
            for name in ("numbers", "wavenumber", "stress_spectrum")
        ]
        bins = [read_array(opened(name), np.float64) for name in BINS if "bins" in header]
        moments = tuple(_moments(header["numbers"], len(speeds), arrays, bins))
    kept = {name: opened(name) for name in header["fields"] if name in FIELDS}
    return Member(
        level,
        index,
        failure,
        moments,
        {name: read_array(opened(name), np.float64) for name in header["curves"] if name in CURVES},
        {name: read_array(kept[name], np.float32) for name in kept if name in fields},
        (length_x, length_y),
        speeds,
        provenance,
        {name: dataset.shape for name, dataset in kept.items()},
    )


def _moments(
    names: list[str], speeds: int, arrays: Sequence[Array], bins: Sequence[Array]
) -> Iterator[StoredMoments]:
    """Yield the moments of the level of a file, and of the level below it; ValueError if the sizes do not fit.

    `arrays` are the numbers, the wavenumbers and the spectra.
    """
    numbers, wavenumber, spectra = arrays
    if numbers.shape[1:] != (len(names), speeds) or spectra.shape != (
        len(numbers),
        len(wavenumber),
    ):
        raise ValueError("its arrays and its header have different sizes")
    if any(values.shape != (len(numbers), speeds, BIN_AREAS.size) for values in bins):
        raise ValueError("its bins and its header have different sizes")
    for k, (rows, spectrum) in enumerate(zip(numbers, spectra, strict=True)):
        # numbers of a package that is not installed here are left out
        known = {name: row for name, row in zip(names, rows, strict=True) if name in NUMBERS}
        own = {name: row if NUMBERS[name].per_speed else row[:1] for name, row in known.items()}
        there = ~np.isnan(spectrum)
        of_bins = Bins(*(values[k] for values in bins)) if bins else None
        yield StoredMoments(own, wavenumber[there], spectrum[there], of_bins)
