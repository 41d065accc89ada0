"""The file of a member (one realization at one level): its format, written whole and checked to the last byte.

The file is HDF5 and netCDF-4 at once. All arrays lie in the root group with dimension scales and units; the group
`entry` links to them as NeXus wants it. The attribute `header` is JSON and holds what is no array. `sha256` guards the
header and the numbers, and each field has a digest of its own. After the end of the HDF5 file stands the seal: a line
with the name of the file and the SHA-256 of all bytes before it.
"""

import errno
import hashlib
import io
import json
import os
import re
import stat
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from roughsim.errors import RecordError
from roughsim.grid import Array
from roughsim.observables.catalogue import NUMBERS
from roughsim.store.disk import DamagedError, add_attributes, damaged, hdf5_bytes, place_bytes, read_bytes, read_numbers
from roughsim.untrusted import ChildEndedError, call_in_child, check_hdf5

FORMAT = 3  # to be raised when older readers would misread a file, or take it for damaged
OLDEST = 2  # the oldest version that is still read
KEPT_FIELDS = {  # unit, and description in exported files
    "heights": ("m", "composite heights"),
    "pressure": ("Pa", "contact pressure, positive in compression"),
}
STAGES = ("surface", "contact", "observables")  # of the pipeline: the seconds of each are stored
MEMBER_NAME = re.compile(r"L(\d+)-(\d{6,})")  # level and index; of the file, of its claim, and in messages
_SEAL = re.compile(rb"\nroughsim (L(\d+)-(\d{6,})\.h5) sha256 ([0-9a-f]{64})\n\Z")
_LONGEST_SEAL = 200  # bytes
_HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"


@dataclass(frozen=True, slots=True, eq=False)
class Member:
    """What is stored of one realization at one level."""

    level: int
    index: int  # of the realization
    failure: str = ""  # why there are no numbers; empty for a sound member
    # over speed, or of one entry; temperatures with all heat in the moving body
    numbers: dict[str, Array] = field(default_factory=dict)
    # the radial stress spectrum over the wavenumber, rad/m: shares of the pressure variance, Pa²
    wavenumber: Array = field(default_factory=lambda: np.empty(0))
    spectrum: Array = field(default_factory=lambda: np.empty(0))
    fields: dict[str, NDArray[np.float32]] = field(default_factory=dict)  # heights, m, and pressure, Pa, if kept
    lengths: tuple[float, float] = (1.0, 1.0)  # sides of the cell, m
    speeds: tuple[float, ...] = ()  # of the arrays over speed, m/s
    provenance: dict[str, Any] = field(default_factory=dict)  # scene, numerics, versions, residual, times
    kept: tuple[str, ...] = ()  # names of the fields in its file, also where `fields` are not in memory


def member_name(level: int, index: int) -> str:
    """Return the name of a member, as "L0-000003"."""
    return f"L{level}-{index:06d}"


def member_path(folder: Path, level: int, index: int) -> Path:
    """Return the place of a member's file in a run folder."""
    return folder / "realizations" / f"{member_name(level, index)}.h5"


def write_member(folder: Path, member: Member) -> None:
    """Write a member's file, whole or not at all; OSError, naming the path, if the disk refuses."""
    path = member_path(folder, member.level, member.index)
    content = hdf5_bytes(lambda file: _fill(file, member))
    # the seal lies behind the HDF5 file, where HDF5 does not look
    seal = f"\nroughsim {path.name} sha256 ".encode()
    digest = hashlib.sha256(content)
    digest.update(seal)
    place_bytes(path, content, seal + digest.hexdigest().encode() + b"\n")


def read_member(path: Path, *, with_fields: bool = False) -> Member:
    """Read a member's file and check every byte of what it returns.

    RecordError, naming the file, if it is damaged or of another format. OSError if it cannot be read now.
    """
    return member_of(path, read_bytes(path), tuple(KEPT_FIELDS) if with_fields else ())


def read_field(path: Path, name: str, shape: tuple[int, ...]) -> NDArray[np.float32]:
    """Read one kept field of a member's file and check its bytes and shape; errors as for `read_member`."""
    field = member_of(path, read_bytes(path), (name,)).fields.get(name)
    if field is None:
        raise damaged(path, f"it has no {name}")
    if field.shape != shape:
        raise RecordError(f"{path} holds {name} of shape {field.shape}, but this run has {shape}: it is not its own")
    return field


def read_spectrum(path: Path, start: int, count: int, check: int) -> Array:
    """Return the stress spectrum of a member's file, Pa², which lies at a place seen before and has this CRC-32.

    A file of other bytes there is read as a whole; errors as for `read_member`.
    """
    with suppress(OSError):
        spectrum: Array = np.fromfile(path, "<f8", count, offset=start)
        if crc32(spectrum.data) == check:
            return spectrum
    return read_member(path).spectrum


def member_of(path: Path, content: bytes, fields: Sequence[str] = ()) -> Member:
    """Return the member that the bytes of a file hold, with these of its fields; RecordError as for `read_member`."""
    if seal_of(path, content) is not None:
        return _opened(path, content, fields)
    # older versions wrote no seal: such a file is opened in another process, where a crash of HDF5 does no harm
    try:
        member: Member = call_in_child(_opened, path, content, fields, seconds=5.0 + len(content) / 1e7)
    except ChildEndedError as error:
        raise damaged(path, error) from error
    return member


def check_member(path: Path) -> None:
    """Check that every byte of a member's file is as it was written, kept fields included.

    DamagedError, naming the file, if it is not. OSError if it cannot be read now, which is no damage.
    """
    try:
        content = read_bytes(path)
    except RecordError as error:  # a folder or a pipe of that name
        raise OSError(errno.EINVAL, str(error)) from error
    try:
        if seal_of(path, content) is None:
            member_of(path, content, tuple(KEPT_FIELDS))
    except DamagedError:
        raise
    except RecordError:  # of another format: not known to be damaged
        return


def seal_of(path: Path, content: bytes) -> str | None:
    """Return the digest in the seal of a member's file if all bytes agree with it; None if it has no seal.

    DamagedError if they do not agree, if the file was written for another place, or if it is cut off.
    """
    seal = _SEAL.search(content, max(len(content) - _LONGEST_SEAL, 0))
    if seal is None:
        end = int.from_bytes(content[28:36], "little")  # of the superblock of version 3, which all members have
        if not content.startswith(_HDF5_SIGNATURE) or end != len(content):
            raise damaged(path, "its digest is missing, and its length is not the one that it states")
        return None
    name, level, index, digest = (part.decode() for part in seal.groups())
    if hashlib.sha256(memoryview(content)[: seal.start(4)]).hexdigest() != digest:
        raise damaged(path, "its SHA-256 does not match")
    if name != path.name:
        raise damaged(path, f"it holds level {int(level)}, index {int(index)}, not what its name says")
    return digest


def digest_of(path: Path, content: bytes) -> bytes:
    """Return the digest in the seal of a file, or, without a seal, that of its bytes; errors as for `seal_of`."""
    return (seal_of(path, content) or hashlib.sha256(content).hexdigest()).encode()


def is_unchanged(path: Path, status: os.stat_result, size: int, changed: int, digest: bytes) -> bool:
    """Whether a member's file still has a digest; with the same size and time, ns, its seal is believed unread."""
    if status.st_size != size or not stat.S_ISREG(status.st_mode):
        return False
    if status.st_mtime_ns == changed:
        with suppress(OSError), open(path, "rb") as file:
            file.seek(max(size - _LONGEST_SEAL, 0))
            seal = _SEAL.search(file.read())
            if seal and seal.group(1, 4) == (path.name.encode(), digest):
                return True
    return digest_of(path, read_bytes(path)) == digest


def check_format(path: Path, version: int) -> None:
    """Refuse a version of the format that this reader does not know, RecordError."""
    if version > FORMAT:
        raise RecordError(f"{path} has format version {version}; this roughsim reads up to {FORMAT}: update it")
    if version < OLDEST:
        raise RecordError(f"{path} has format version {version}; this one reads from {OLDEST} on: run the scene again")


def _fill(file: Any, member: Member) -> None:
    """Put the header and all arrays into the root group, as netCDF-4 wants it, and what viewers draw into `entry`."""
    add_attributes(file, {"NX_class": "NXroot", "default": "entry"})
    add_attributes(file, {"format": "roughsim realization", "format_version": FORMAT})
    entry = file.create_group("entry")
    add_attributes(entry, {"NX_class": "NXentry", "default": "fields" if member.fields else "stress"})
    header = json.dumps(
        {
            "level": member.level,
            "index": member.index,
            "failure": member.failure,
            "numbers": [[name, list(np.shape(values))] for name, values in member.numbers.items()],  # in their order
            "fields": [[name, list(values.shape)] for name, values in member.fields.items()],
            "lengths": list(member.lengths),
            "speeds": list(member.speeds),
            "provenance": member.provenance,
        },
        sort_keys=True,
    )
    add_attributes(file, {"header": header})
    guarded: list[NDArray[Any]] = []
    if member.numbers:
        speed = _add(file, "speed", np.array(member.speeds, dtype="<f8"), "m/s")
        speed.make_scale("speed")
        for name, values in member.numbers.items():
            axes = [speed] if NUMBERS[name].per_speed else []
            guarded.append(np.asarray(values, dtype="<f8").reshape([len(axis) for axis in axes]))
            _add(file, name, guarded[-1], NUMBERS[name].unit, axes)
        _link(file, "numbers", "flash_temperature", ["speed"], list(member.numbers))
        guarded += [np.ascontiguousarray(values, dtype="<f8") for values in (member.wavenumber, member.spectrum)]
        wavenumber = _add(file, "wavenumber", guarded[-2], "1/m")
        wavenumber.make_scale("wavenumber")
        _add(file, "stress_spectrum", guarded[-1], "Pa^2", [wavenumber])
        _link(file, "stress", "stress_spectrum", ["wavenumber"], [])
    if member.fields:
        _fill_fields(file, member)
    add_attributes(file, {"sha256": _digest(header, guarded)})


def _fill_fields(file: Any, member: Member) -> None:
    """Store the kept fields, each with its own digest: a reader of the numbers need not read them."""
    shape = next(iter(member.fields.values())).shape
    for axis, points, length in zip("xy", shape, member.lengths, strict=True):
        _add(file, axis, np.arange(points) * (length / points), "m").make_scale(axis)
    for name, values in member.fields.items():
        data = np.ascontiguousarray(values, dtype="<f4")
        # small chunks: viewers read a part of a large field at a time
        options: dict[str, Any] = {"chunks": tuple(min(points, 256) for points in shape)}
        if name == "pressure":  # mostly zeros; heights would shrink by a sixth in twenty times the time
            options |= {"compression": "gzip", "compression_opts": 1}
        attributes = {"sha256": _digest(name, [data]), "interpretation": "image"}
        _add(file, name, data, KEPT_FIELDS[name][0], [file["x"], file["y"]], attributes, **options)
    _link(file, "fields", "pressure", ["x", "y"], [name for name in member.fields if name != "pressure"])


def _add(
    file: Any,
    name: str,
    data: NDArray[Any],
    unit: str,
    axes: Sequence[Any] = (),
    attributes: dict[str, str] | None = None,
    **options: Any,
) -> Any:
    """Store an array over datasets that are its axes, and return its dataset."""
    if data.ndim:  # HDF5 guards chunks by a checksum; a scalar takes no filter
        options = {"chunks": data.shape, "fletcher32": True} | options
    dataset = file.create_dataset(name, data=data, **options)
    add_attributes(dataset, {"units": unit} | (attributes or {}))
    for number, axis in enumerate(axes):
        dataset.dims[number].attach_scale(axis)
    return dataset


def _link(file: Any, name: str, signal: str, axes: list[str], others: list[str]) -> None:
    """Make a group that viewers draw: hard links to a signal, its axes, and other arrays."""
    group = file["entry"].create_group(name)
    add_attributes(group, {"NX_class": "NXdata", "signal": signal, "axes": axes})
    stored = set(file)
    for array in dict.fromkeys((signal, *axes, *others)):
        if array in stored:
            group.id.links.create_hard(array.encode(), file.id, array.encode())


def _digest(text: str, arrays: Iterable[NDArray[Any]]) -> str:
    digest = hashlib.sha256(text.encode())
    for array in arrays:
        digest.update(np.ascontiguousarray(array).data)
    return digest.hexdigest()


def _opened(path: Path, content: bytes, fields: Sequence[str]) -> Member:
    """Return the member in the bytes of an HDF5 file; any error inside means that the file is damaged."""
    import h5py

    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            check_format(path, int(file.attrs["format_version"]))
            check_hdf5(file, path)
            return _taken(file, path, fields)
    except RecordError:
        raise
    except (OSError, LookupError, ValueError, TypeError, RuntimeError) as error:
        raise damaged(path, error) from error


def _taken(file: Any, path: Path, fields: Sequence[str]) -> Member:
    """Return the member that `_fill` stored; ValueError if a digest or the header is wrong."""
    text = str(file.attrs["header"])
    header = json.loads(text)
    _check_header(header)
    level, index = header["level"], header["index"]
    if member_path(path.parent.parent, level, index).name != path.name:
        raise ValueError(f"it holds level {level}, index {index}, not what its name says")
    numbers = {name: np.reshape(read_numbers(file, name), shape) for name, shape in header["numbers"]}
    wavenumber, spectrum = (
        read_numbers(file, name) if numbers else np.empty(0) for name in ("wavenumber", "stress_spectrum")
    )
    if _digest(text, [*numbers.values(), wavenumber, spectrum]) != file.attrs["sha256"]:
        raise ValueError("its SHA-256 does not match")
    kept: dict[str, list[int]] = dict(header["fields"])
    arrays: dict[str, NDArray[np.float32]] = {name: file[name][()] for name in kept if name in fields}
    for name, data in arrays.items():
        if _digest(name, [data]) != file[name].attrs["sha256"] or list(data.shape) != kept[name]:
            raise ValueError(f"the SHA-256 of its {name} does not match")
    return Member(
        level,
        index,
        header["failure"],
        numbers,
        wavenumber,
        spectrum,
        arrays,
        (header["lengths"][0], header["lengths"][1]),
        tuple(header["speeds"]),
        header["provenance"],
        tuple(kept),
    )


def _check_header(header: dict[str, Any]) -> None:
    """Refuse a header that no writer of this format makes, ValueError: who forges one can forge its digest too."""
    speeds = len(header["speeds"])
    sound = {
        "numbers": all(
            name in NUMBERS and shape == [speeds if NUMBERS[name].per_speed else 1] for name, shape in header["numbers"]
        ),
        "fields": all(name in KEPT_FIELDS and len(shape) == 2 for name, shape in header["fields"]),
        "failure": isinstance(header["failure"], str) and bool(header["failure"]) != bool(header["numbers"]),
        "provenance": isinstance(header["provenance"], dict),
    }
    for name, as_written in sound.items():
        if not as_written:
            raise ValueError(f"its header has {name} that no writer of this format makes")
