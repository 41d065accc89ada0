"""HDF5 in memory: arrays with units, dimension scales and checksums, which netCDF-4 readers open too.

Modules import it inside functions, because h5py is slow to import.
"""

import io
from collections.abc import Callable, Iterable, Mapping
from math import prod
from typing import Any

import h5py
import numpy as np

from roughsim.machine import exceeds

_LARGEST_CHUNK = 256  # points along a side of a map: viewers read a part of a large one at a time


def hdf5_bytes(fill: Callable[[Any], None]) -> memoryview:
    """Return the bytes of an HDF5 file that `fill` fills, made in memory: HDF5 never meets a full disk."""
    image = io.BytesIO()  # not the core driver: before HDF5 2.0 its images of v110 files have a stale checksum
    with h5py.File(image, "w", libver="v110") as file:
        fill(file)
    return image.getbuffer()


def opened_hdf5(content: bytes) -> Any:
    """Return the HDF5 file in some bytes, open to be read; OSError if it is none."""
    return h5py.File(io.BytesIO(content), "r")


def write_arrays(
    group: Any, arrays: Iterable[tuple[str, tuple[str, ...], Any, Mapping[str, Any]]], compression: int = 1
) -> None:
    """Write arrays into a group, each after the arrays of its axes, which become its dimension scales.

    An array is its name, the names of its axes (its own name alone: it is an axis), its data, and its attributes. Data
    that are no array have a shape and a dtype, and yield their rows one by one. Numbers are guarded by a checksum. Maps
    (float32 of two or more axes) are packed by gzip, too, at a level of `compression`.
    """
    for name, axes, data, attributes in arrays:
        if data.dtype.kind == "U":
            dataset = group.create_dataset(name, data=data.tolist())
        elif data.dtype == np.float32 and len(data.shape) > 1:
            chunk = (*(1 for _ in data.shape[:-2]), *(min(points, _LARGEST_CHUNK) for points in data.shape[-2:]))
            packed = {"chunks": chunk, "shuffle": True, "compression": compression, "fletcher32": True}
            dataset = group.create_dataset(name, data.shape, data.dtype, **packed)
            for row, values in enumerate(data):
                dataset[row] = values
        else:
            checked = {"chunks": data.shape, "fletcher32": True} if data.size else {}
            dataset = group.create_dataset(name, data=data, **checked)
        dataset.attrs.update(attributes)
        if axes == (name,):
            dataset.make_scale(name)
            continue
        for number, axis in enumerate(axes):
            dataset.dims[number].attach_scale(group[axis])


def opened_array(file: h5py.File, name: str, axes: int) -> h5py.Dataset:
    """Return an unread array of floats of an open, untrusted file; other objects in the file are not opened.

    ValueError if it leads elsewhere or has not this number of axes, MemoryError if it is too large. `write_arrays`
    makes chunked arrays, which are neither external nor virtual ones.
    """
    if not isinstance(file.get(name, getlink=True), h5py.HardLink):
        raise ValueError(f"{name} is a link that leads elsewhere")
    found = file[name]
    if not isinstance(found, h5py.Dataset) or found.chunks is None or found.ndim != axes or found.dtype.kind != "f":
        raise ValueError(f"{name} is stored as no writer of this format does it")
    if exceeds(float(prod(found.shape)) * 8.0, 0.5):
        raise MemoryError(f"{name} declares the shape {found.shape}, above half of the available memory")
    return found
