"""Files of members: parts, each with the numbers of many members, and a file with the kept fields of one member.

Both are HDF5 files in the netCDF-4 format, written in one piece. Their attribute `header` has scene and numerics of the
run as JSON. In a file of fields the group `entry` links to them (NeXus). The HDF5 data is followed by the seal: a line
with the name of the file and the SHA-256 of all bytes before it.
"""

import hashlib
import io
import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from roughsim.errors import RecordError
from roughsim.observables.catalogue import AXIS, CURVES
from roughsim.observables.member import Member
from roughsim.sliding import snapshots
from roughsim.store.disk import DamagedError, place_bytes, read_bytes, seal

FORMAT = 8  # of members and of run.json
AGAIN = "repeat the command that made the folder"  # advice on a lost member
MEMBER_NAME = re.compile(
    r"L(\d+)-(\d{6,})"
)  # level and index; of a file of fields, of a claim, and in messages
_DIGEST = 65  # bytes at the end: SHA-256 of all before, as text, and the end of the line
REFUSED = (  # errors of h5py and of Python for content that no writer makes
    OSError,
    LookupError,
    ValueError,
    TypeError,
    AttributeError,
    RuntimeError,
    RecursionError,
)
Content = TypeVar("Content")


class Kind(NamedTuple):
    """Unit and axes of an array in a file; the axes of an axis are its own name."""

    unit: str
    axes: tuple[str, ...]
    description: str = ""  # in exported files


KEPT_FIELDS = {
    "heights": Kind("m", ("x", "y"), "composite heights"),
    "pressure": Kind("Pa", ("x", "y"), "contact pressure, positive in compression"),
}
MEMBER = "realization"  # axis of all arrays of a part but axes
_OF_BINS = (MEMBER, "below", "speed", "contact_area")  # axes
BINS = {  # of the contact area, in the order of `Bins`
    "bin_temperature": Kind("K", _OF_BINS, "mean temperature"),
    "bin_pressure": Kind("Pa", _OF_BINS, "mean pressure"),
    "bin_pressure_deviation": Kind("Pa", _OF_BINS, "standard deviation of the pressure"),
    "bin_pressure_skewness": Kind("1", _OF_BINS, "skewness of the pressure"),
}
FIELDS = KEPT_FIELDS | {name: Kind(*about) for name, about in snapshots.FIELDS.items()}
KINDS = {
    MEMBER: Kind("", (MEMBER,)),
    "about": Kind("", (MEMBER,)),
    "digest": Kind("", (MEMBER,)),
    "below": Kind("", ("below",)),
    "number": Kind("", ("number",)),
    "unit": Kind("", ("number",)),
    "speed": Kind("m/s", ("speed",)),
    "numbers": Kind("", (MEMBER, "below", "number", "speed")),
    "wavenumber": Kind("1/m", ("wavenumber",)),
    "stress_spectrum": Kind("Pa^2", (MEMBER, "below", "wavenumber")),
    "contact_area": Kind("1", ("contact_area",)),
    **BINS,
    **{
        name: Kind(curve.unit, (MEMBER, *["speed"] * curve.per_speed, AXIS))
        for name, curve in CURVES.items()
    },
    AXIS: Kind(CURVES[AXIS].unit, (AXIS,)),
    "x": Kind("m", ("x",)),
    "y": Kind("m", ("y",)),
    **FIELDS,
}


def member_name(level: int, index: int) -> str:
    """Return the name of a member, as "L0-000003"."""
    return f"L{level}-{index:06d}"


def fields_path(folder: Path, level: int, index: int) -> Path:
    """Return the place of the kept fields of a member in a run folder."""
    return folder.joinpath("fields", f"{member_name(level, index)}.h5")


def write_fields(folder: Path, run: Mapping[str, Any], member: Member) -> None:
    """Write the kept fields of a member, if it has some, whole or not at all; OSError as of `write_part`."""
    from roughsim.store.hdf5 import write_arrays

    if not member.fields:
        return
    shape = next(values.shape[-2:] for values in member.fields.values() if values.ndim > 1)
    arrays: dict[str, NDArray[Any]] = {}
    if any("speed" in KINDS[name].axes for name in member.fields):
        arrays["speed"] = np.array(member.speeds)
    for axis, points, length in zip("xy", shape, member.lengths, strict=True):
        arrays[axis] = np.arange(points) * (length / points)
    arrays |= {name: np.asarray(kept, np.float32) for name, kept in member.fields.items()}
    header = {"format_version": FORMAT, "level": member.level, "index": member.index}

    def fill(file: Any) -> None:
        file.attrs["header"] = json.dumps({**header, **run, "fields": list(member.fields)})
        write_arrays(file, labelled(arrays))
        _show(file, list(member.fields))

    path = fields_path(folder, member.level, member.index)
    path.parent.mkdir(exist_ok=True)
    write_sealed(path, fill)


def read_fields(
    path: Path, names: Iterable[str] | None = None
) -> tuple[dict[str, Any], dict[str, NDArray[np.float32]]]:
    """Read the header and some kept fields of a member, by default all, after a check of all bytes.

    Errors as of `read_part`; FileNotFoundError, with advice, if they are lost.
    """
    from roughsim.store.hdf5 import opened_array, read_array

    def read(file: Any) -> tuple[dict[str, Any], dict[str, NDArray[np.float32]]]:
        header = header_of(path, file)
        if member_name(header["level"], header["index"]) != path.stem:
            raise ValueError(
                f"it holds level {header['level']!r}, index {header['index']!r}, unlike its name"
            )
        there = [name for name in header["fields"] if name in FIELDS]
        fields = {}
        for name in there if names is None else names:
            if name not in there:
                raise ValueError(f"it has no {name}")
            fields[name] = read_array(opened_array(file, name, len(KINDS[name].axes)), np.float32)
        return header, fields

    try:
        return read_sealed(path, read)
    except FileNotFoundError as error:
        raise FileNotFoundError(error.errno, f"{path} is lost; {AGAIN} to have it") from None


def damaged(path: Path, fault: str) -> DamagedError:
    """Return the error that names a file with its fault, as "is damaged (…)", and gives advice."""
    return DamagedError(
        f"{path} {fault}; {AGAIN}: it moves the file into 'damaged' and computes its members again"
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


def write_sealed(path: Path, fill: Callable[[Any], None]) -> None:
    """Write the HDF5 file that `fill` fills, with its seal; it is made in memory, as HDF5 must meet no full disk."""
    import h5py

    # not the core driver: before HDF5 2.0 its images of v110 files have a stale checksum
    image = io.BytesIO()
    with h5py.File(image, "w", libver="v110") as file:
        fill(file)
    content = image.getvalue()
    place_bytes(path, content, seal(path.name, hashlib.sha256(content)))


def read_sealed(path: Path, reader: Callable[[Any], Content]) -> Content:
    """Return the content of an HDF5 file whose seal is sound; errors as of `read_part`."""
    import h5py

    content = read_bytes(path)
    digest = hashlib.sha256(memoryview(content)[:-_DIGEST]).hexdigest()
    if content[-_DIGEST:] != f"{digest}\n".encode():
        raise damaged(path, "is damaged (its SHA-256 does not match)")
    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            return reader(file)
    except RecordError:
        raise
    except MemoryError as error:  # on a larger machine it may be readable
        raise RecordError(f"{path}: {error}; nothing was read") from error
    except REFUSED as error:
        raise damaged(path, f"is damaged ({error})") from error


def labelled(
    arrays: Mapping[str, NDArray[Any]],
) -> Iterator[tuple[str, tuple[str, ...], NDArray[Any], dict[str, str]]]:
    """Yield arrays by their names with axes and units, as `write_arrays` takes them."""
    for name, values in arrays.items():
        kind = KINDS[name]
        yield name, kind.axes, values, {"units": kind.unit} if kind.unit else {}


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


def header_of(path: Path, file: Any) -> dict[str, Any]:
    """Return the header of an open file; RecordError for another format."""
    header: dict[str, Any] = json.loads(file.attrs["header"])
    check_format(path, int(header["format_version"]), header)
    return header
