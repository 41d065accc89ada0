"""The HDF5 data of a member's file: header, numbers and fields, and the places where they lie.

All arrays lie in the root group with dimension scales and units, as netCDF-4 wants it. The group `entry` links to them
as NeXus wants it. The attribute `header` is JSON and holds what is no array. `sha256` guards the header and numbers,
and each field has a digest of its own.

The files of members differ in header, digest and numbers alone, and HDF5 would take most of their time. So HDF5 makes
one file of each kind. The others are copies of it with their own bytes in these places. To a copy of a member that
keeps fields HDF5 adds these.
"""

import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughsim.grid import Array
from roughsim.observables.catalogue import AXIS, CURVES, NUMBERS
from roughsim.sliding import film
from roughsim.store.disk import add_attributes, hdf5_bytes

FORMAT = 4  # to be raised when older readers would misread a file, or take it for damaged
KEPT_FIELDS = {  # of single contacts: unit, and description in exported files
    "heights": ("m", "composite heights"),
    "pressure": ("Pa", "contact pressure, positive in compression"),
}
STORED = (*KEPT_FIELDS, *film.FIELDS)  # all arrays that a member may keep
UNITS = {"speed": "m/s", "wavenumber": "1/m", "stress_spectrum": "Pa^2"}  # of what is not in NUMBERS
HEADER_STEP = 512  # bytes: a header is filled up with spaces to a multiple, so that many files are of one kind
KINDS = 32  # so many stay in memory; a level has two or three
BEFORE_FIELDS = 1 << 20  # bytes in which header and digest usually lie, before the fields; else all are searched
CHECK_BYTES = 4  # of the Fletcher-32 behind an array

Fields = Mapping[str, NDArray[np.float32]]
Places = dict[str, tuple[int, int]]  # name of an array, "header" or "sha256" → its start in the file, and its bytes


def hdf5_of(header: dict[str, Any], arrays: dict[str, Array], fields: Fields) -> tuple[bytes | memoryview, Places]:
    """Return the HDF5 data of a member, and the places of header, digest and arrays in them.

    `header` is what goes into JSON; with fields it has the `lengths` of the cell, m. `arrays` are speed, the numbers,
    wavenumber, stress_spectrum and the curves of a march by name and in this order; none for a failed member.
    """
    text = json.dumps(header, sort_keys=True)
    text += " " * (-len(text) % HEADER_STEP)
    digest = digest_of_arrays(text, (values for name, values in arrays.items() if name != "speed"))
    blank, places = _blank(len(text), tuple((name, values.shape) for name, values in arrays.items()))
    content = bytearray(blank)
    for name, words in {"header": text, "sha256": digest}.items():
        start, count = places[name]
        content[start : start + count] = words.encode()
    for name, values in arrays.items():
        start, count = places[name]
        own = values.tobytes()
        content[start : start + count] = own
        if values.ndim:  # a scalar has no checksum
            content[start + count : start + count + CHECK_BYTES] = fletcher32(own).to_bytes(CHECK_BYTES, "little")
    if not fields:
        return memoryview(content), places
    add = _add_film if film.AXIS in fields else _add_fields
    whole = hdf5_bytes(lambda file: add(file, fields, header["lengths"]), content)
    return whole, places | _places_of(whole, text, digest)  # the arrays stay where they were


@lru_cache(maxsize=KINDS)
def _blank(length: int, shapes: tuple[tuple[str, tuple[int, ...]], ...]) -> tuple[memoryview, Places]:
    """Return the data of a kind of members, with a header of this length, and the places to be filled."""
    return _made("?" * length, "!" * 64, {name: np.zeros(shape) for name, shape in shapes})


def _made(text: str, digest: str, arrays: dict[str, Array]) -> tuple[memoryview, Places]:
    """Return the data as HDF5 writes them, and the places in them."""
    places: Places = {}

    def fill(file: Any) -> None:
        add_attributes(file, {"NX_class": "NXroot", "default": "entry"})
        add_attributes(file, {"format": "roughsim realization", "format_version": FORMAT})
        add_attributes(file.create_group("entry"), {"NX_class": "NXentry", "default": "stress"})
        add_attributes(file, {"header": text})
        if arrays:
            places.update(_fill_numbers(file, arrays))
        add_attributes(file, {"sha256": digest})

    content = hdf5_bytes(fill)
    return content, places | _places_of(content, text, digest)


def _places_of(content: memoryview, header: str, digest: str) -> Places:
    """Return where header and digest lie: text is stored as it is, and occurs once."""
    texts = {"header": header.encode(), "sha256": digest.encode()}
    for size in (BEFORE_FIELDS, len(content)):  # fields may take gigabytes: no copy of them if it can be helped
        part = bytes(content[:size])
        places = {name: (part.find(text), len(text)) for name, text in texts.items()}
        if all(start >= 0 for start, _ in places.values()):
            break
    return places


def _fill_numbers(file: Any, arrays: dict[str, Array]) -> Places:
    """Store the arrays over their axes, and what viewers draw of them; return their places."""
    datasets: dict[str, Any] = {}
    for name, values in arrays.items():
        if name in NUMBERS:
            unit, axes = NUMBERS[name].unit, [datasets["speed"]] if NUMBERS[name].per_speed else []
        elif name in CURVES:
            unit, axes = CURVES[name].unit, [datasets["speed"]] if CURVES[name].per_speed else []
            axes += [datasets[AXIS]] if name != AXIS else []
        else:
            unit, axes = UNITS[name], [datasets["wavenumber"]] if name == "stress_spectrum" else []
        datasets[name] = _add(file, name, values, unit, axes)
        if name in ("speed", "wavenumber", AXIS):
            datasets[name].make_scale(name)
    numbers = [name for name in arrays if name in NUMBERS]
    _link(file, "numbers", numbers[0], ["speed"], numbers)
    _link(file, "stress", "stress_spectrum", ["wavenumber"], [])
    if curves := [name for name in arrays if name in CURVES and name != AXIS]:
        _link(file, "slide", curves[0], ["speed", AXIS], curves)
    return {
        name: (
            dataset.id.get_chunk_info(0).byte_offset if dataset.shape else dataset.id.get_offset(),
            arrays[name].nbytes,
        )
        for name, dataset in datasets.items()
    }


def _add_fields(file: Any, fields: Fields, lengths: Sequence[float]) -> None:
    """Add the kept fields, each with its own digest: a reader of the numbers need not read them."""
    shape = next(iter(fields.values())).shape
    _fill_axes(file, shape, lengths)
    for name, values in fields.items():
        data = np.ascontiguousarray(values, dtype="<f4")
        # heights lie in one piece: compressed they would shrink by a sixth in twenty times the time
        options: dict[str, Any] = {"chunks": None, "fletcher32": False}
        if name == "pressure":  # mostly zeros; small chunks, as viewers read a part of a large field at a time
            chunks = tuple(min(points, 256) for points in shape)
            options = {"chunks": chunks, "compression": "gzip", "compression_opts": 1}
        attributes = {"sha256": digest_of_arrays(name, [data]), "interpretation": "image"}
        _add(file, name, data, KEPT_FIELDS[name][0], [file["x"], file["y"]], attributes, **options)
    _link(file, "fields", "pressure", ["x", "y"], [name for name in fields if name != "pressure"])


def _add_film(file: Any, fields: Fields, lengths: Sequence[float]) -> None:
    """Add the maps of a march, each array with its own digest, in chunks of one map."""
    _fill_axes(file, fields["film_pressure"].shape[-2:], lengths)
    for name, values in fields.items():
        data = np.ascontiguousarray(values, dtype="<f4")
        options: dict[str, Any] = {}
        if name != film.AXIS:
            chunks = (*(1 for _ in data.shape[:-2]), *data.shape[-2:])
            options = {"chunks": chunks, "compression": "gzip", "compression_opts": 1, "shuffle": True}
        axes = [file[axis] for axis in film.FIELDS[name].axes if axis != name]
        attributes = {"sha256": digest_of_arrays(name, [data])}
        dataset = _add(file, name, data, film.FIELDS[name].unit, axes, attributes, **options)
        if name == film.AXIS:
            dataset.make_scale(name)
    others = [name for name in fields if name != "film_pressure"]
    _link(file, "fields", "film_pressure", [film.AXIS, "x", "y"], ["speed", *others])


def _fill_axes(file: Any, shape: tuple[int, ...], lengths: Sequence[float]) -> None:
    """Store the coordinates of the points along x and y, of fields that viewers are to draw first."""
    file["entry"].attrs["default"] = "fields"
    for axis, points, length in zip("xy", shape, lengths, strict=True):
        _add(file, axis, np.arange(points) * (length / points), "m").make_scale(axis)


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
    if data.ndim:  # HDF5 guards chunks by a checksum; neither a scalar nor heights in one piece take any
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
    for array in dict.fromkeys((signal, *axes, *others)):
        if file.id.links.exists(array.encode()):
            group.id.links.create_hard(array.encode(), file.id, array.encode())


def digest_of_arrays(text: str, arrays: Iterable[NDArray[Any]]) -> str:
    """Return the SHA-256 of a text and arrays, hexadecimal."""
    digest = hashlib.sha256(text.encode())
    for array in arrays:
        digest.update(np.ascontiguousarray(array).data)
    return digest.hexdigest()


def fletcher32(content: bytes) -> int:
    """Return the checksum that HDF5 puts behind an array of an even number of bytes.

    Its words have 16 bits, the high byte first. Its sums are those of ones' complement: they count modulo 65535, and
    65535 stands in place of zero unless all words are zero.
    """
    words = np.frombuffer(content, ">u2").astype(np.uint64)
    sums = int(words.sum()), int(words @ np.arange(len(words), 0, -1, dtype=np.uint64))
    first, second = ((total - 1) % 0xFFFF + 1 if total else 0 for total in sums)
    return second << 16 | first
