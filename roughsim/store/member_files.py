"""One file per realization: whole or absent, checked to the last byte, readable by every HDF5 tool."""

from __future__ import annotations

import errno
import hashlib
import io
import json
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughsim.errors import RecordError
from roughsim.observables.catalogue import NUMBERS
from roughsim.store.disk import DamagedError, damaged, hdf5_bytes, place_bytes, seal_of, sealed, unlocked
from roughsim.untrusted import ChildEndedError, call_in_child, check_hdf5

Array = NDArray[np.float64]
FORMAT = 2  # raised when older readers would misread
FIELD_UNITS = {"heights": "m", "pressure": "Pa"}


@dataclass(frozen=True, slots=True, eq=False)
class Member:
    """What is stored of one realization at one level.

    Attributes
    ----------
    level, index : int
        Its place in the run.
    failure : str
        Why there are no numbers; empty for a sound member.
    numbers : dict of str to ndarray
        Arrays over speed, or of one entry; temperatures with all heat in the moving body.
    wavenumber, spectrum : ndarray
        Radial stress spectrum: rad/m and Pa², summing to the pressure variance.
    fields : dict of str to ndarray
        "heights" (m) and "pressure" (Pa) in single precision, if kept.
    lengths : (float, float)
        Sides of the cell, m.
    speeds : tuple of float
        Sliding speeds of the arrays over speed, m/s.
    provenance : dict
        Versions, numerics, seed, residual, iterations, times.
    kept : tuple of str
        Names of the fields in its file, also where `fields` are not in memory.
    """

    level: int
    index: int
    failure: str = ""
    numbers: dict[str, Array] = field(default_factory=dict)
    wavenumber: Array = field(default_factory=lambda: np.empty(0))
    spectrum: Array = field(default_factory=lambda: np.empty(0))
    fields: dict[str, NDArray[np.float32]] = field(default_factory=dict)
    lengths: tuple[float, float] = (1.0, 1.0)
    speeds: tuple[float, ...] = ()
    provenance: dict[str, Any] = field(default_factory=dict)
    kept: tuple[str, ...] = ()


def member_path(folder: Path, level: int, index: int) -> Path:
    """Return the place of one realization's file."""
    return folder / "realizations" / f"L{level}-{index:06d}.h5"


def write_member(folder: Path, member: Member) -> None:
    """Write a realization's file, whole or not at all.

    Raises
    ------
    OSError
        If the disk refuses, naming the path; no half-written file stays.
    """
    path = member_path(folder, member.level, member.index)
    place_bytes(path, sealed(hdf5_bytes(lambda file: _fill(file, member)), path.name))


def read_member(path: Path, *, with_fields: bool = False) -> Member:
    """Read a realization's file and check every byte of its payload.

    Raises
    ------
    RecordError
        If the file is damaged, or written by a newer format; the message names the file.
    OSError
        If it cannot be read now, which is no damage.
    """
    return member_of(path, unlocked(path), with_fields=with_fields)


def member_of(path: Path, content: bytes, *, with_fields: bool = False) -> Member:
    """Return the member that the bytes of a file hold; RecordError as `read_member`."""
    member: Member = _inside(path, content, _take, with_fields)
    return member


def read_field(path: Path, name: str) -> NDArray[np.float32]:
    """Read one field of a realization's file and check its bytes; errors as `read_member`."""
    field: NDArray[np.float32] = _inside(path, unlocked(path), _one_field, name)
    return field


def check_member(path: Path) -> None:
    """See that every byte of a realization's file is as it was written, those of kept fields too.

    Raises
    ------
    RecordError
        If the file is damaged, naming it.
    OSError
        If it cannot be read now, which is no damage.
    """
    try:
        content = unlocked(path)
    except RecordError as error:  # somebody's folder or pipe
        raise OSError(errno.EINVAL, str(error)) from error
    try:
        if seal_of(path, content) is None:
            _apart(path, content, _take, True)
    except DamagedError:
        raise
    except RecordError:  # of another format: not ours to judge
        return


def _inside(path: Path, content: bytes, take: Callable[..., Any], *arguments: Any) -> Any:
    """Return ``take(file, path, *arguments)`` of an HDF5 file, once its bytes are judged."""
    where = _apart if seal_of(path, content) is None else _opened
    return where(path, content, take, *arguments)


def _apart(path: Path, content: bytes, take: Callable[..., Any], *arguments: Any) -> Any:
    """Open a file without a seal, as older versions wrote it, where the HDF5 library can do no harm."""
    seconds = 5.0 + len(content) / 1e7
    try:
        return call_in_child(_opened, path, content, take, *arguments, seconds=seconds)
    except ChildEndedError as error:
        raise damaged(path, error) from error


def _opened(path: Path, content: bytes, take: Callable[..., Any], *arguments: Any) -> Any:
    """Open a file in memory and take something out of it; whatever goes wrong means that the file is damaged."""
    import h5py

    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            check_format(path, int(file.attrs["format_version"]))
            check_hdf5(file, path)
            return take(file, path, *arguments)
    except RecordError:
        raise
    except (OSError, LookupError, ValueError, TypeError, RuntimeError) as error:
        raise damaged(path, error) from error


def _fill(file: Any, member: Member) -> None:
    """Put all arrays into the root group, as netCDF-4 has it; the groups of NeXus below link to them again."""
    file.attrs.update(NX_class="NXroot", default="entry", format="roughsim realization", format_version=FORMAT)
    entry = file.create_group("entry")
    entry.attrs.update(NX_class="NXentry", default="fields" if member.fields else "stress")
    file.attrs["header"] = header = json.dumps(_header(member), sort_keys=True)
    arrays: list[NDArray[Any]] = []
    if member.numbers:
        arrays = [*_fill_numbers(file, member), *_fill_stress(file, member)]
    if member.fields:
        _fill_fields(file, member)
    file.attrs["sha256"] = _digest(header, arrays)


def _digest(header: str, arrays: list[NDArray[Any]]) -> str:
    digest = hashlib.sha256(header.encode())
    for array in arrays:
        digest.update(np.ascontiguousarray(array).data)
    return digest.hexdigest()


def _header(member: Member) -> dict[str, Any]:
    """All that is not an array; guarded by the digest."""
    return {
        "level": member.level,
        "index": member.index,
        "failure": member.failure,
        "numbers": [[name, list(np.shape(values))] for name, values in member.numbers.items()],  # in their order
        "fields": [[name, list(values.shape)] for name, values in member.fields.items()],
        "lengths": list(member.lengths),
        "speeds": list(member.speeds),
        "provenance": member.provenance,
    }


def _fill_numbers(file: Any, member: Member) -> list[NDArray[Any]]:
    speed = _store_scale(file, "speed", np.array(member.speeds, dtype="<f8"), "m/s")
    arrays = []
    for name, values in member.numbers.items():
        wide = NUMBERS[name].per_speed
        data = np.asarray(values, dtype="<f8").reshape((len(member.speeds),) if wide else ())
        guard = {"chunks": data.shape, "fletcher32": True} if wide else {}  # no filter can guard a scalar
        dataset = file.create_dataset(name, data=data, **guard)
        dataset.attrs["units"] = NUMBERS[name].unit
        if wide:
            dataset.dims[0].attach_scale(speed)
        arrays.append(data)
    _link(file, "numbers", "flash_temperature", ["speed"], list(member.numbers))
    return arrays


def _fill_stress(file: Any, member: Member) -> list[NDArray[Any]]:
    arrays = [np.ascontiguousarray(values, dtype="<f8") for values in (member.wavenumber, member.spectrum)]
    scale = _store_scale(file, "wavenumber", arrays[0], "1/m")
    signal = file.create_dataset("stress_spectrum", data=arrays[1], chunks=arrays[1].shape, fletcher32=True)
    signal.attrs["units"] = "Pa^2"
    signal.dims[0].attach_scale(scale)
    _link(file, "stress", "stress_spectrum", ["wavenumber"], [])
    return arrays


def _fill_fields(file: Any, member: Member) -> None:
    shape = next(iter(member.fields.values())).shape
    for axis, points, length in zip("xy", shape, member.lengths, strict=True):
        _store_scale(file, axis, np.arange(points) * (length / points), "m")
    for name, values in member.fields.items():
        data = np.ascontiguousarray(values, dtype="<f4")
        chunks = tuple(min(n, 256) for n in data.shape)
        options = {"compression": "gzip", "compression_opts": 1, "shuffle": True, "fletcher32": True}
        dataset = file.create_dataset(name, data=data, chunks=chunks, **options)
        dataset.attrs.update(units=FIELD_UNITS[name], sha256=_digest(name, [data]), interpretation="image")
        for number, scale in enumerate("xy"):
            dataset.dims[number].attach_scale(file[scale])
    _link(file, "fields", "pressure", ["x", "y"], [name for name in member.fields if name != "pressure"])


def _store_scale(file: Any, name: str, data: Array, unit: str) -> Any:
    scale = file.create_dataset(name, data=data, chunks=data.shape, fletcher32=True)
    scale.attrs["units"] = unit
    scale.make_scale(name)
    return scale


def _link(file: Any, name: str, signal: str, axes: list[str], others: list[str]) -> None:
    """Make the group that viewers draw: hard links to a signal, its axes, and what stands beside it."""
    group = file["entry"].create_group(name)
    group.attrs.update(NX_class="NXdata", signal=signal, axes=axes)
    for array in dict.fromkeys((signal, *axes, *others)):
        if array in file:
            group[array] = file[array]


def _take(file: Any, path: Path, with_fields: bool) -> Member:
    text = str(file.attrs["header"])
    header = _checked_header(json.loads(text))
    level, index = header["level"], header["index"]
    if member_path(path.parent.parent, level, index).name != path.name:
        raise ValueError(f"it holds level {level}, index {index}, not what its name says")
    numbers: dict[str, Array] = {}
    wavenumber = spectrum = np.empty(0)
    arrays: list[Array] = []
    if header["numbers"]:
        numbers = {name: np.reshape(file[name][()], shape) for name, shape in header["numbers"]}
        wavenumber, spectrum = file["wavenumber"][()], file["stress_spectrum"][()]
        arrays = [*numbers.values(), wavenumber, spectrum]
    if _digest(text, arrays) != file.attrs["sha256"]:
        raise ValueError("its SHA-256 does not match")
    fields = {name: _field(file[name], name, shape) for name, shape in header["fields"] if with_fields}
    return Member(
        level,
        index,
        header["failure"],
        numbers,
        wavenumber,
        spectrum,
        fields,
        (header["lengths"][0], header["lengths"][1]),
        tuple(header["speeds"]),
        header["provenance"],
        tuple(name for name, _ in header["fields"]),
    )


def _one_field(file: Any, _: Path, name: str) -> NDArray[np.float32]:
    return _field(file[name], name)


def _field(dataset: Any, name: str, shape: list[int] | None = None) -> NDArray[np.float32]:
    data: NDArray[np.float32] = dataset[()]
    if _digest(name, [data]) != dataset.attrs["sha256"] or list(data.shape) != (shape or list(data.shape)):
        raise ValueError(f"the SHA-256 of its {name} does not match")
    return data


def _checked_header(header: dict[str, Any]) -> dict[str, Any]:
    """Return what `_header` made; ValueError if some of it is not what the writer writes."""
    wide = len(header["speeds"])
    sound = {
        "numbers": all(
            name in NUMBERS and shape == [wide if NUMBERS[name].per_speed else 1] for name, shape in header["numbers"]
        ),
        "fields": all(name in FIELD_UNITS and len(shape) == 2 for name, shape in header["fields"]),
        "failure": isinstance(header["failure"], str) and bool(header["failure"]) != bool(header["numbers"]),
        "provenance": isinstance(header["provenance"], dict),
    }
    for name, good in sound.items():
        if not good:
            raise ValueError(f"its header has {name} that no writer of this format makes")
    return header


def check_format(path: Path, version: int) -> None:
    """Refuse a version of the format that this reader does not know, RecordError."""
    if version > FORMAT:
        raise RecordError(f"{path} has format version {version}; this roughsim reads up to {FORMAT}: update it")
    if version < FORMAT:
        raise RecordError(f"{path} has format version {version}; this roughsim reads {FORMAT}: run the scene again")
