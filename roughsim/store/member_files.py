"""The file of a member (one realization of one level): written whole, and checked to the last byte.

It is HDF5 and netCDF-4 at once. Arrays lie in the root group with dimension scales and units. The axis `below` of the
numbers is 0 for the level of the file, and 1 for the level below it on the same surface. The attribute `header` is JSON
and holds what is no array. Where fields are kept, the group `entry` links to them as NeXus wants it. After the end of
the HDF5 data comes the seal: a line with the name of the file and the SHA-256 of all bytes before it.
"""

import errno
import hashlib
import io
import json
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from functools import lru_cache, partial
from math import prod
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughsim.errors import RecordError
from roughsim.grid import Array
from roughsim.machine import exceeds
from roughsim.observables.catalogue import AXIS, CURVES, NUMBERS
from roughsim.sliding import film
from roughsim.store.disk import DamagedError, hdf5_bytes, place_bytes, read_bytes
from roughsim.store.kinds import again

FORMAT = 5  # of members and of run.json
STAGES = ("surface", "contact", "observables")  # of the pipeline: the seconds of each are stored
MEMBER_NAME = re.compile(r"L(\d+)-(\d{6,})")  # level and index; of the file, of its claim, and in messages
ENDS = "", "_below"  # of the names of spectra: of the level, and of the level below it
_SEAL = re.compile(rb"\nroughsim (L(\d+)-(\d{6,})\.h5) sha256 ([0-9a-f]{64})\n\Z")
_LONGEST_SEAL = 200  # bytes
LARGEST_CHUNK = 256  # points along a side of a field: viewers read a part of a large one at a time


class Kind(NamedTuple):
    """What an array of a file is: its unit and the names of its axes; an axis has its own name there."""

    unit: str
    axes: tuple[str, ...]
    description: str = ""  # in exported files


KEPT_FIELDS = {
    "heights": Kind("m", ("x", "y"), "composite heights"),
    "pressure": Kind("Pa", ("x", "y"), "contact pressure, positive in compression"),
}
FIELDS = KEPT_FIELDS | {name: Kind(*about) for name, about in film.FIELDS.items()}
SPEED, BELOW = ("speed",), ("below",)
SPECTRUM = "wavenumber", "stress_spectrum"
KINDS = {
    "speed": Kind("m/s", SPEED),
    "below": Kind("1", BELOW),
    **{name: Kind(number.unit, BELOW + SPEED * number.per_speed) for name, number in NUMBERS.items()},
    **{f"wavenumber{end}": Kind("1/m", (f"wavenumber{end}",)) for end in ENDS},
    **{f"stress_spectrum{end}": Kind("Pa^2", (f"wavenumber{end}",)) for end in ENDS},
    **{name: Kind(curve.unit, (*SPEED * curve.per_speed, AXIS)) for name, curve in CURVES.items()},
    "x": Kind("m", ("x",)),
    "y": Kind("m", ("y",)),
    **FIELDS,
}


class Moments(NamedTuple):
    """What was measured of one contact: numbers, (speeds,) or (1,), and the stress spectrum, Pa², over q, rad/m."""

    numbers: dict[str, Array]
    wavenumber: Array
    spectrum: Array


@dataclass(frozen=True, slots=True, eq=False)
class Member:
    """What is stored of one realization of one level."""

    level: int
    index: int  # of the realization
    failure: str = ""  # why there are no numbers; empty for a sound member
    # over speed, or of one entry; temperatures with all heat in the moving body
    numbers: dict[str, Array] = field(default_factory=dict)
    # the radial stress spectrum over the wavenumber, rad/m: shares of the pressure variance, Pa²
    wavenumber: Array = field(default_factory=lambda: np.empty(0))
    spectrum: Array = field(default_factory=lambda: np.empty(0))
    below: Moments | None = None  # the same of the level below, on the same surface
    curves: dict[str, Array] = field(default_factory=dict)  # over the slid distance, of the column "sliding" only
    # heights, m, and pressure, Pa, or the film of a march, if kept
    fields: dict[str, NDArray[np.float32]] = field(default_factory=dict)
    lengths: tuple[float, float] = (1.0, 1.0)  # sides of the cell, m
    speeds: tuple[float, ...] = ()  # of the arrays over speed, m/s
    provenance: dict[str, Any] = field(default_factory=dict)  # scene, numerics, versions, residual, times
    kept: tuple[str, ...] = ()  # names of the fields in its file, also where `fields` are not in memory


def member_name(level: int, index: int) -> str:
    """Return the name of a member, as "L0-000003"."""
    return f"L{level}-{index:06d}"


def member_path(folder: Path, level: int, index: int) -> Path:
    """Return the place of a member's file in a run folder."""
    return folder.joinpath("realizations", f"{member_name(level, index)}.h5")


def write_member(folder: Path, member: Member) -> None:
    """Write a member's file, whole or not at all; OSError, naming the path, if the disk refuses."""
    path = member_path(folder, member.level, member.index)
    content = hdf5_bytes(lambda file: _fill(file, member))
    seal = f"\nroughsim {path.name} sha256 ".encode()
    digest = hashlib.sha256(content)
    digest.update(seal)
    place_bytes(path, content, seal + digest.hexdigest().encode() + b"\n")


def read_member(path: Path, with_fields: bool = False) -> Member:
    """Read a member's file after a check of all its bytes.

    RecordError, naming the file, if it is damaged or of another format. OSError if it cannot be read now.
    """
    return _opened(path, tuple(FIELDS) if with_fields else ())


def read_field(path: Path, name: str, shape: tuple[int, ...]) -> NDArray[np.float32]:
    """Read one kept field of a member's file after a check of all bytes and its shape; errors as for `read_member`."""
    values = _opened(path, (name,)).fields.get(name)
    if values is None:
        raise damaged(path, f"it has no {name}")
    if values.shape != shape:
        raise RecordError(f"{path} holds {name} of shape {values.shape}, but this run has {shape}: it is not its own")
    return values


def check_member(path: Path) -> None:
    """Check that every byte of a member's file is as it was written, kept fields included.

    DamagedError, naming the file, if it is not. OSError if it cannot be read now, which is no damage.
    """
    try:
        _check_seal(path, read_bytes(path))
    except DamagedError:
        raise
    except RecordError as error:  # a folder or a pipe of that name
        raise OSError(errno.EINVAL, str(error)) from error


def damaged(path: Path, reason: object) -> DamagedError:
    """Return the error that names a damaged file and says what to do."""
    advice = f"{again(path.parent.parent)}: it is moved into the folder 'damaged' and redone"
    return DamagedError(f"{path} is damaged ({reason}); {advice}")


def check_format(path: Path, version: int, provenance: Any) -> None:
    """Refuse another version of the format, RecordError; `provenance` may have the versions of packages."""
    if version > FORMAT:
        raise RecordError(f"{path} has format version {version}; this roughsim reads {FORMAT}: update it")
    if version < FORMAT:
        versions = provenance.get("versions") if isinstance(provenance, dict) else None
        number = versions.get("roughsim", "") if isinstance(versions, dict) else ""
        writer = f"the roughsim that wrote it ({number})" if number else "the roughsim that wrote it"
        raise RecordError(f"{path} has the older format {version}; read or export it with {writer}")


def _check_seal(path: Path, content: bytes) -> None:
    """Refuse bytes that are not those that the seal was made of, or that were written for another place."""
    seal = _SEAL.search(content, max(len(content) - _LONGEST_SEAL, 0))
    if seal is None:
        raise damaged(path, "its last line with the SHA-256 is missing")
    name, level, index, digest = (part.decode() for part in seal.groups())
    if hashlib.sha256(memoryview(content)[: seal.start(4)]).hexdigest() != digest:
        raise damaged(path, "its SHA-256 does not match")
    if name != path.name:
        raise damaged(path, f"it holds level {int(level)}, index {int(index)}, not what its name says")


def _fill(file: Any, member: Member) -> None:
    """Store a member in a new HDF5 file."""
    header = {name: getattr(member, name) for name in ("level", "index", "failure", "lengths", "speeds", "provenance")}
    header |= {name: list(getattr(member, name)) for name in ("numbers", "curves", "fields")}
    file.attrs["format_version"] = FORMAT
    _set_text(file.id, "format", "roughsim realization")
    _set_text(file.id, "header", json.dumps(header))
    scales: dict[str, Any] = {}
    for name, values in _arrays_of(member):
        _add(file.id, name, values, KINDS[name], scales)
    if member.fields:
        _show(file, list(member.fields))


def _arrays_of(member: Member) -> Iterator[tuple[str, NDArray[Any]]]:
    """Yield the arrays of a member with their names, each after its axes."""
    own = Moments(member.numbers, member.wavenumber, member.spectrum)
    moments = [own] if member.below is None else [own, member.below]
    if member.numbers:
        yield "speed", np.array(member.speeds, np.float64)
        yield "below", np.arange(float(len(moments)))
        for name in member.numbers:
            values = np.array([each.numbers[name] for each in moments], np.float64)
            yield name, values if NUMBERS[name].per_speed else values[:, 0]
        for end, each in zip(ENDS, moments, strict=False):
            yield f"wavenumber{end}", each.wavenumber
            yield f"stress_spectrum{end}", each.spectrum
    yield from member.curves.items()
    shape = next((values.shape[-2:] for values in member.fields.values() if values.ndim > 1), ())
    for axis, points, length in zip("xy", shape, member.lengths, strict=False):
        yield axis, np.arange(points) * (length / points)
    for name, kept in member.fields.items():
        yield name, np.asarray(kept, np.float32)


def _add(place: Any, name: str, values: NDArray[Any], kind: Kind, scales: dict[str, Any]) -> None:
    """Store an array over `scales`, the datasets of axes by name; an axis is added to them.

    These calls take a third of the time of the interface above them: a member has some twenty arrays.
    """
    from h5py import h5d, h5ds, h5s, h5t

    number = h5t.IEEE_F32LE if name in FIELDS else h5t.IEEE_F64LE
    dataset = h5d.create(place, name.encode(), number, *_layout(values.shape, name in FIELDS))
    dataset.write(h5s.ALL, h5s.ALL, np.ascontiguousarray(values))
    _set_text(dataset, "units", kind.unit)
    if kind.axes == (name,):
        h5ds.set_scale(dataset, name.encode())
        scales[name] = dataset
        return
    for axis, scale in enumerate(kind.axes):
        h5ds.attach_scale(dataset, scales[scale], axis)


@lru_cache(maxsize=64)  # a fifth of the time of a member, as those of one level have the same shapes
def _layout(shape: tuple[int, ...], packed: bool) -> tuple[Any, Any]:
    """Return how HDF5 is to store an array: its shape, and chunks guarded by a checksum."""
    from h5py import h5p, h5s

    chunk = shape
    if len(shape) > 1:  # one part of one map
        chunk = (1,) * (len(shape) - 2) + tuple(min(points, LARGEST_CHUNK) for points in shape[-2:])
    how = h5p.create(h5p.DATASET_CREATE)
    how.set_chunk(chunk)
    if packed:
        how.set_shuffle()
        how.set_deflate(1)
    how.set_fletcher32()
    return h5s.create_simple(shape), how


def _set_text(place: Any, name: str, text: str) -> None:
    """Give a new group or dataset a text; the interface above this call looks for an older one first."""
    from h5py import h5a

    h5a.create(place, name.encode(), *_text()).write(np.array(text, object))


@lru_cache(maxsize=1)
def _text() -> tuple[Any, Any]:
    """Return the type of texts, and the shape of one."""
    from h5py import h5s, h5t, string_dtype

    return h5t.py_create(string_dtype(), logical=True), h5s.create(h5s.SCALAR)


def _show(file: Any, names: list[str]) -> None:
    """Let viewers draw the kept fields, as NeXus wants it: hard links to a signal, its axes, and the other fields."""
    signal = "film_pressure" if film.AXIS in names else "pressure"
    file.attrs.update(NX_class="NXroot", default="entry")
    entry = file.create_group("entry")
    entry.attrs.update(NX_class="NXentry", default="fields")
    shown = entry.create_group("fields")
    axes = KINDS[signal].axes
    shown.attrs.update(NX_class="NXdata", signal=signal, axes=list(axes))
    for name in dict.fromkeys((signal, *axes, *names)):
        shown[name] = file[name]


def _opened(path: Path, fields: Iterable[str]) -> Member:
    """Return the member in a file whose seal is sound, with these of its fields; errors as for `read_member`."""
    import h5py

    content = read_bytes(path)
    _check_seal(path, content)
    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            header = json.loads(file.attrs["header"])
            check_format(path, int(file.attrs["format_version"]), header["provenance"])
            return _member_of(path, header, partial(_read, path, file.id), fields)
    except RecordError:
        raise
    except (OSError, LookupError, ValueError, TypeError, AttributeError, RuntimeError, RecursionError) as error:
        raise damaged(path, error) from error


def _member_of(path: Path, header: dict[str, Any], read: Callable[..., NDArray[Any]], fields: Iterable[str]) -> Member:
    """Return the member of a header and of the arrays in a file; ValueError or LookupError if no writer made these.

    Who forges a header can forge its seal too.
    """
    level, index, failure, provenance = (header[name] for name in ("level", "index", "failure", "provenance"))
    if f"{member_name(level, index)}.h5" != path.name:
        raise ValueError(f"it holds level {level}, index {index}, not what its name says")
    # those of a package that is not installed here are left out
    numbers = {name: read(name) for name in header["numbers"] if name in NUMBERS}
    moments = []
    for k in range(len(read("below")) if numbers else 0):
        of_level = {name: np.atleast_1d(values[k]) for name, values in numbers.items()}
        moments.append(Moments(of_level, *(read(name + ENDS[k]) for name in SPECTRUM)))
    if not isinstance(provenance, dict) or not isinstance(failure, str) or bool(failure) == bool(moments):
        raise ValueError("its header is none that a writer of this format makes")
    speeds = tuple(float(speed) for speed in header["speeds"])
    if any(values.shape[1:] not in ((), (len(speeds),)) for values in numbers.values()):
        raise ValueError("its numbers are over other speeds than its header has")
    length_x, length_y = header["lengths"]
    return Member(
        level,
        index,
        failure,
        *(moments[0] if moments else Moments({}, np.empty(0), np.empty(0))),
        moments[1] if len(moments) > 1 else None,
        {name: read(name) for name in header["curves"] if name in CURVES},
        {name: read(name, np.float32) for name in header["fields"] if name in fields},
        (float(length_x), float(length_y)),
        speeds,
        provenance,
        tuple(name for name in header["fields"] if name in FIELDS),
    )


def _read(path: Path, place: Any, name: str, kind: Any = np.float64) -> NDArray[Any]:
    """Return an array of a file. RecordError if it leads elsewhere or is too large, else errors as `_member_of`.

    Only what is read is opened. What writers of this format make is chunked: that is no external and no virtual array.
    """
    from h5py import h5d, h5l, h5s

    if place.links.get_info(name.encode()).type != h5l.TYPE_HARD:
        raise RecordError(f"{path}: {name} is a link that leads elsewhere; nothing was read")
    dataset = h5d.open(place, name.encode())
    shape = dataset.shape
    if dataset.get_create_plist().get_layout() != h5d.CHUNKED or len(shape) != len(KINDS[name].axes):
        raise RecordError(f"{path}: {name} is stored as no writer of this format does it; nothing was read")
    if exceeds(float(prod(shape)) * np.dtype(kind).itemsize, 0.5):
        raise RecordError(f"{path}: {name} declares the shape {shape}, above half of the available memory")
    values = np.empty(shape, kind)
    dataset.read(h5s.ALL, h5s.ALL, values)
    return values
