"""HDF5 in memory: arrays with units, dimension scales and checksums, which netCDF-4 readers open too.

Who uses it imports it where it is needed, because h5py is slow to import. The lower interface of h5py, which it calls,
takes a third of the time of the one above.
"""

import io
from collections.abc import Callable, Sequence
from functools import lru_cache
from math import prod
from typing import Any

import h5py
import numpy as np
from h5py import h5a, h5d, h5ds, h5p, h5s, h5t
from numpy.typing import NDArray

from roughsim.machine import exceeds

LARGEST_CHUNK = 256  # points along a side of a map: viewers read a part of a large one at a time
_ONE, _TEXT = h5s.create(h5s.SCALAR), h5t.py_create(h5py.string_dtype(), logical=True)


def hdf5_bytes(fill: Callable[[Any], None]) -> memoryview:
    """Return the bytes of an HDF5 file that `fill` fills, made in memory: HDF5 never meets a full disk."""
    image = io.BytesIO()  # not the core driver: before HDF5 2.0 its images of v110 files have a stale checksum
    with h5py.File(image, "w", libver="v110") as file:
        fill(file)
    return image.getbuffer()


def opened_hdf5(content: bytes) -> Any:
    """Return the HDF5 file in some bytes, open to be read; OSError if it is none."""
    return h5py.File(io.BytesIO(content), "r")


def describe(place: Any, name: str, text: str) -> None:
    """Give a new group or dataset a text as attribute."""
    h5a.create(place, name.encode(), _TEXT, _ONE).write(np.array(text, object))


def add_array(place: Any, name: str, values: NDArray[Any], unit: str, axes: Sequence[Any]) -> Any:
    """Store an array over the datasets of its axes, none of an axis itself, and return its dataset; "": no unit."""
    kind, space, layout = _stored_as(values.shape, values.dtype)
    dataset = h5d.create(place, name.encode(), kind, space, layout)
    dataset.write(h5s.ALL, h5s.ALL, np.ascontiguousarray(values), kind)
    if unit:
        describe(dataset, "units", unit)
    if not axes:
        h5ds.set_scale(dataset, name.encode())
    for number, scale in enumerate(axes):
        h5ds.attach_scale(dataset, scale, number)
    return dataset


@lru_cache(maxsize=64)  # a fifth of the time of a member, as those of one level have the same shapes
def _stored_as(shape: tuple[int, ...], kind: np.dtype[Any]) -> tuple[Any, Any, Any]:
    """Return how HDF5 is to store an array: type, shape, and chunks guarded by a checksum."""
    layout = h5p.create(h5p.DATASET_CREATE)
    if kind == np.float32:  # maps, packed one by one
        layout.set_chunk((1,) * (len(shape) - 2) + tuple(min(points, LARGEST_CHUNK) for points in shape[-2:]))
        layout.set_shuffle()
        layout.set_deflate(1)
    else:
        layout.set_chunk(shape)
    layout.set_fletcher32()
    return h5t.py_create(kind), h5s.create_simple(shape), layout


def opened_array(file: Any, name: str, axes: int) -> Any:
    """Return an array of an open file, unread; nothing in the file is trusted, and nothing else in it is opened.

    ValueError if it leads elsewhere or has not this number of axes, MemoryError if it is too large. `add_array` makes
    chunked arrays, which are neither external nor virtual ones.
    """
    if not isinstance(file.get(name, getlink=True), h5py.HardLink):
        raise ValueError(f"{name} is a link that leads elsewhere")
    dataset = file[name]
    if dataset.chunks is None or dataset.ndim != axes:
        raise ValueError(f"{name} is stored as no writer of this format does it")
    if exceeds(float(prod(dataset.shape)) * 8.0, 0.5):
        raise MemoryError(f"{name} declares the shape {dataset.shape}, above half of the available memory")
    return dataset
