"""HDF5 in memory: arrays with units and dimension scales, which netCDF-4 readers open too.

Members are read by the low-level interface of h5py, in two thirds of the time of its high-level interface.

Modules import it inside functions, because h5py is slow to import.
"""

from collections.abc import Iterable, Mapping
from math import prod
from typing import Any

import numpy as np
from h5py import h5d, h5l, h5s, h5t
from numpy.typing import NDArray

from roughsim.machine import exceeds

_LARGEST_CHUNK = 256  # points along a side of a map: viewers read a part of a large one at a time
_FILTERS: dict[str, dict[str, Any]] = {
    "heights": {},  # gzip takes ten times as long as writing them, and leaves 84 %
    # mostly zeros: gzip leaves 7 % of them, and of shuffled ones 12 %, in twice the time
    "pressure": {"compression": 1},
    "film_pressure": {"compression": 1},
}


def write_arrays(
    group: Any,
    arrays: Iterable[tuple[str, tuple[str, ...], Any, Mapping[str, Any]]],
    compression: int = 1,
) -> None:
    """Write arrays into a group, each after the arrays of its axes, which become its dimension scales.

    An array is its name, the names of its axes (its own name alone: it is an axis), its data, and its attributes. Data
    that are no array have a shape and a dtype, and yield their rows one by one. Maps (float32 of two or more axes) but
    heights are packed by gzip at a level of `compression`. No array has a checksum (fletcher32), which readers by
    reference do not know: each file ends in the SHA-256 of all its bytes.
    """
    scales: dict[str, Any] = {}  # a look-up in the group takes as long as an attachment
    for name, axes, data, attributes in arrays:
        if data.dtype.kind == "U":
            dataset = group.create_dataset(name, data=data.tolist())
        elif data.dtype == np.float32 and len(data.shape) > 1:
            chunk = (
                *(1 for _ in data.shape[:-2]),
                *(min(points, _LARGEST_CHUNK) for points in data.shape[-2:]),
            )
            filters = _FILTERS.get(name, {"shuffle": True, "compression": compression})
            dataset = group.create_dataset(name, data.shape, data.dtype, chunks=chunk, **filters)
            if isinstance(data, np.ndarray):
                dataset[...] = data
            else:
                for row, values in enumerate(data):
                    dataset[row] = values
        else:
            dataset = group.create_dataset(
                name, data=data, chunks=data.shape if data.size else None
            )
        dataset.attrs.update(attributes)
        if axes == (name,):
            dataset.make_scale(name)
            scales[name] = dataset
            continue
        for number, axis in enumerate(axes):
            dataset.dims[number].attach_scale(scales[axis] if axis in scales else group[axis])


def opened_array(file: Any, name: str, axes: int) -> Any:
    """Return an unread array of an open, untrusted file; other objects in the file are not opened.

    ValueError if it leads elsewhere or has not this number of axes, MemoryError if it is too large. `write_arrays`
    makes chunked arrays, which are neither external nor virtual ones.
    """
    if file.id.links.get_info(name.encode()).type != h5l.TYPE_HARD:
        raise ValueError(f"{name} is a link that leads elsewhere")
    dataset = h5d.open(file.id, name.encode())
    shape = dataset.shape
    if dataset.get_create_plist().get_layout() != h5d.CHUNKED or len(shape) != axes:
        raise ValueError(f"{name} is stored as no writer of this format does it")
    if exceeds(float(prod(shape)) * float(dataset.get_type().get_size()), 0.5):
        raise MemoryError(f"{name} declares the shape {shape}, above half of the available memory")
    return dataset


def opened_group(file: Any, name: str) -> Any:
    """Return a group of an open, untrusted file; ValueError if it leads elsewhere."""
    if file.id.links.get_info(name.encode()).type != h5l.TYPE_HARD:
        raise ValueError(f"{name} is a link that leads elsewhere")
    return file[name]


def read_text(dataset: Any) -> NDArray[Any]:
    """Read texts of `opened_array`, as bytes; TypeError or OSError if it holds something else."""
    if dataset.dtype.kind != "S":
        raise TypeError("an array of texts holds something else")
    values = np.empty(dataset.shape, dataset.dtype)
    dataset.read(h5s.ALL, h5s.ALL, values)
    return values


def read_array(dataset: Any, kind: type[np.number[Any]]) -> NDArray[Any]:
    """Read an array of `opened_array`; TypeError or OSError if it holds no plain numbers."""
    values = np.empty(dataset.shape, kind)
    dataset.read(h5s.ALL, h5s.ALL, values, h5t.py_create(np.dtype(kind)))
    return values
