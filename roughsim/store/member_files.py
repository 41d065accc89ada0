"""The file of a member (one realization at one level): its format, written whole and checked to the last byte.

The file is HDF5 and netCDF-4 at once (`roughsim.store.member_hdf5`). After the end of the HDF5 data it has two lines.
The first says where the header and the numbers lie, so that reading them needs no HDF5. The second is the seal: the
name of the file and the SHA-256 of all bytes before it.
"""

import errno
import hashlib
import io
import json
import os
import re
import stat
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from roughsim.errors import RecordError
from roughsim.grid import Array
from roughsim.observables.catalogue import CURVES, NO_LONGER, NUMBERS
from roughsim.sliding.film import FIELDS as FILM
from roughsim.store.disk import DamagedError, place_bytes, read_bytes, read_numbers
from roughsim.store.kinds import again
from roughsim.store.member_hdf5 import FORMAT, KEPT_FIELDS, STORED, digest_of_arrays, hdf5_of
from roughsim.untrusted import ChildEndedError, call_in_child, check_hdf5

OLDEST = 2  # the oldest version that is still read
STAGES = ("surface", "contact", "observables")  # of the pipeline: the seconds of each are stored
MEMBER_NAME = re.compile(r"L(\d+)-(\d{6,})")  # level and index; of the file, of its claim, and in messages
_SEAL = re.compile(rb"\nroughsim (L(\d+)-(\d{6,})\.h5) sha256 ([0-9a-f]{64})\n\Z")
_LONGEST_SEAL = 200  # bytes
_PLACES = b"\nroughsim places "  # begins the line with the places
_LONGEST_PLACES = 4096  # bytes
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
    curves: dict[str, Array] = field(default_factory=dict)  # over the slid distance, of the column "sliding" only
    # heights, m, and pressure, Pa, or the film of a march, if kept
    fields: dict[str, NDArray[np.float32]] = field(default_factory=dict)
    lengths: tuple[float, float] = (1.0, 1.0)  # sides of the cell, m
    speeds: tuple[float, ...] = ()  # of the arrays over speed, m/s
    provenance: dict[str, Any] = field(default_factory=dict)  # scene, numerics, versions, residual, times
    kept: tuple[str, ...] = ()  # names of the fields in its file, also where `fields` are not in memory
    digest: str = ""  # SHA-256 of its file, hexadecimal, if it was read from one


def member_name(level: int, index: int) -> str:
    """Return the name of a member, as "L0-000003"."""
    return f"L{level}-{index:06d}"


def member_path(folder: Path, level: int, index: int) -> Path:
    """Return the place of a member's file in a run folder."""
    return folder.joinpath("realizations", f"{member_name(level, index)}.h5")


def write_member(folder: Path, member: Member) -> None:
    """Write a member's file, whole or not at all; OSError, naming the path, if the disk refuses."""
    path = member_path(folder, member.level, member.index)
    header = {
        "level": member.level,
        "index": member.index,
        "failure": member.failure,
        "numbers": [[name, list(np.shape(values))] for name, values in member.numbers.items()],  # in their order
        "fields": [[name, list(values.shape)] for name, values in member.fields.items()],
        **({"curves": [[name, list(values.shape)] for name, values in member.curves.items()]} if member.curves else {}),
        "lengths": list(member.lengths),
        "speeds": list(member.speeds),
        "provenance": member.provenance,
    }
    arrays: dict[str, Any] = {}
    if member.numbers:
        scalars = {name: values[0] for name, values in member.numbers.items() if not NUMBERS[name].per_speed}
        arrays = {"speed": member.speeds} | member.numbers | scalars
        arrays |= {"wavenumber": member.wavenumber, "stress_spectrum": member.spectrum} | member.curves
    content, places = hdf5_of(
        header, {name: np.asarray(values, "<f8", order="C") for name, values in arrays.items()}, member.fields
    )
    # these lines lie behind the HDF5 data, where HDF5 does not look
    lines = _PLACES + json.dumps({"format_version": FORMAT} | places).encode()
    lines += f"\nroughsim {path.name} sha256 ".encode()
    digest = hashlib.sha256(content)
    digest.update(lines)
    place_bytes(path, content, lines + digest.hexdigest().encode() + b"\n")


def read_member(path: Path, *, with_fields: bool = False) -> Member:
    """Read a member's file and check every byte of what it returns.

    RecordError, naming the file, if it is damaged or of another format. OSError if it cannot be read now.
    """
    return member_of(path, read_bytes(path), STORED if with_fields else ())


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
    if (digest := seal_of(path, content)) is not None:
        member: Member = _opened(path, content, fields) if fields else _read_in_place(path, content)
        return replace(member, digest=digest)
    # older versions wrote no seal: such a file is opened in another process, where a crash of HDF5 does no harm
    try:
        member = call_in_child(_opened, path, content, fields, seconds=5.0 + len(content) / 1e7)
    except ChildEndedError as error:
        raise damaged(path, error) from error
    return replace(member, digest=hashlib.sha256(content).hexdigest())


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
            member_of(path, content, STORED)
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
    content = read_bytes(path)
    return (seal_of(path, content) or hashlib.sha256(content).hexdigest()).encode() == digest


def damaged(path: Path, reason: object) -> DamagedError:
    """Return the error that names a damaged file and says what to do."""
    advice = f"{again(path.parent.parent)}: it is moved into the folder 'damaged' and redone"
    return DamagedError(f"{path} is damaged ({reason}); {advice}")


def check_format(path: Path, version: int) -> None:
    """Refuse a version of the format that this reader does not know, RecordError."""
    if version > FORMAT:
        raise RecordError(f"{path} has format version {version}; this roughsim reads up to {FORMAT}: update it")
    if version < OLDEST:
        raise RecordError(f"{path} has format version {version}; this one reads from {OLDEST} on: run the scene again")


def _read_in_place(path: Path, content: bytes) -> Member:
    """Return the member of a file whose seal is sound, from the places that it states; without them by HDF5."""
    start = content.rfind(_PLACES, max(len(content) - _LONGEST_PLACES, 0))
    if start < 0:
        return _opened(path, content, ())
    try:
        places = json.loads(content[start + len(_PLACES) : content.index(b"\n", start + 1)])
        check_format(path, int(places["format_version"]))

        def read(name: str) -> Array:
            first, size = places[name]
            return np.frombuffer(content, "<f8", size // 8, first).copy()  # a view would keep the whole file in memory

        first, size = places["header"]
        return _without_former(_member(_header_of(path, content[first : first + size].decode()), read, {}))
    except RecordError:
        raise
    except (LookupError, ValueError, TypeError, OverflowError, RecursionError) as error:
        raise damaged(path, error) from error


def _opened(path: Path, content: bytes, fields: Sequence[str]) -> Member:
    """Return the member in the bytes of an HDF5 file; any error inside means that the file is damaged."""
    import h5py

    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            check_format(path, int(file.attrs["format_version"]))
            check_hdf5(file, path)
            text = str(file.attrs["header"])
            header = _header_of(path, text)
            shapes = {name: shape for name, shape in header["fields"] if name in fields}
            member = _member(header, partial(read_numbers, file), {name: file[name][()] for name in shapes})
            guarded = [*member.numbers.values(), member.wavenumber, member.spectrum, *member.curves.values()]
            if digest_of_arrays(text, guarded) != file.attrs["sha256"]:
                raise ValueError("its SHA-256 does not match")
            for name, data in member.fields.items():
                if digest_of_arrays(name, [data]) != file[name].attrs["sha256"] or list(data.shape) != shapes[name]:
                    raise ValueError(f"the SHA-256 of its {name} does not match")
            return _without_former(member)
    except RecordError:
        raise
    except (OSError, LookupError, ValueError, TypeError, RuntimeError) as error:
        raise damaged(path, error) from error


def _member(header: dict[str, Any], read: Callable[[str], Array], fields: dict[str, NDArray[np.float32]]) -> Member:
    """Return the member of a header, with arrays that `read` gives by name."""
    numbers = {name: read(name).reshape(shape) for name, shape in header["numbers"]}
    return Member(
        header["level"],
        header["index"],
        header["failure"],
        numbers,
        read("wavenumber") if numbers else np.empty(0),
        read("stress_spectrum") if numbers else np.empty(0),
        {name: np.reshape(read(name), shape) for name, shape in header.get("curves", ())},
        fields,
        (header["lengths"][0], header["lengths"][1]),
        tuple(header["speeds"]),
        header["provenance"],
        tuple(name for name, _ in header["fields"]),
    )


def _without_former(member: Member) -> Member:
    """Return a member without the numbers that are no longer stored."""
    return replace(member, numbers={name: x for name, x in member.numbers.items() if name not in NO_LONGER})


def _header_of(path: Path, text: str) -> dict[str, Any]:
    """Return the header of a file from its JSON; ValueError if it is of another member, or no writer makes it."""
    header: dict[str, Any] = json.loads(text)
    _check_header(header)
    level, index = header["level"], header["index"]
    if f"{member_name(level, index)}.h5" != path.name:
        raise ValueError(f"it holds level {level}, index {index}, not what its name says")
    return header


def _check_header(header: dict[str, Any]) -> None:
    """Refuse a header that no writer of this format makes, ValueError: who forges one can forge its digest too."""
    speeds = len(header["speeds"])
    sound = {
        "numbers": all(
            shape == [1]
            if name in NO_LONGER
            else name in NUMBERS and shape == [speeds if NUMBERS[name].per_speed else 1]
            for name, shape in header["numbers"]
        ),
        "curves": all(
            name in CURVES and len(shape) == 1 + CURVES[name].per_speed and shape[0] in (speeds, shape[-1])
            for name, shape in header.get("curves", ())
        ),
        "fields": all(
            name in STORED and len(shape) == (2 if name in KEPT_FIELDS else len(FILM[name].axes))
            for name, shape in header["fields"]
        ),
        "failure": isinstance(header["failure"], str) and bool(header["failure"]) != bool(header["numbers"]),
        "provenance": isinstance(header["provenance"], dict),
    }
    for name, as_written in sound.items():
        if not as_written:
            raise ValueError(f"its header has {name} that no writer of this format makes")
