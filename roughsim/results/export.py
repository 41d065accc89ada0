"""One portable file of a run: the numbers of all members and the kept fields, for every HDF5 and netCDF-4 reader.

All arrays lie in the root group with dimension scales and units, as netCDF-4 has it; the group ``entry`` links to them
again as NeXus has it, so that viewers find what to show first.
"""

from __future__ import annotations

import os
from io import FileIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughsim.results.labelled import Labelled, Stored, about, coordinates, fields, kept_everywhere, numbers

if TYPE_CHECKING:
    from roughsim.results.run import Run

ENDINGS = (".h5", ".hdf5", ".nc")
MANTISSA = 23  # explicit bits of a float32


def export_run(run: Run, path: str | Path, bits: int | None = None) -> Path:
    """Write the numbers of all members that count, and the kept fields, into one file, whole or not at all.

    It holds the variables of `Run.to_xarray`; ``xarray.open_dataset(path, engine="h5netcdf")`` gives the same data.

    Parameters
    ----------
    run : Run
        From `run` or `open_run`.
    path : str or Path
        Of the file: .h5, .hdf5 or .nc; written anew if it is there.
    bits : int, optional
        Explicit mantissa bits that fields keep, 1 to 23: each value is rounded by at most 2^−(bits+1) of itself, and
        the file shrinks. Left out: all 23.

    Returns
    -------
    Path
        Where the file is.

    Raises
    ------
    ValueError
        If the ending is none of these, `bits` is out of range, or the run has no sound realization yet.
    RecordError
        If a file of the run is damaged.
    OSError
        If the disk refuses, naming the path; no half-written file stays.
    """
    import h5py

    place = Path(path)
    if place.suffix.lower() not in ENDINGS:
        raise ValueError(f"path = {str(place)!r} must end in {', '.join(ENDINGS)}")
    if bits is not None and (isinstance(bits, bool) or int(bits) != bits or not 1 <= bits <= MANTISSA):
        raise ValueError(f"bits = {bits!r} must be a whole number from 1 to {MANTISSA}")
    place.parent.mkdir(parents=True, exist_ok=True)
    temporary = place.with_name(f".{place.name}.{os.getpid()}.tmp")
    try:
        with _Deferring(temporary) as handle:
            with h5py.File(handle, "w", libver="v110", track_order=True) as file:
                _fill(file, run, bits)
            handle.settle()
        os.replace(temporary, place)
    except BaseException as error:
        temporary.unlink(missing_ok=True)
        if isinstance(error, OSError):
            raise OSError(error.errno, f"cannot write {place}: {error.strerror or error}") from error
        raise
    return place


class _Deferring(FileIO):
    """A new file that keeps the first failure to write until `settle`: HDF5 itself crashes on a full disk."""

    def __init__(self, path: Path):
        super().__init__(path, "w+")
        self.failure: OSError | None = None

    def write(self, data: Any) -> int:
        """Write all of `data`, or nothing once a write has failed."""
        rest = memoryview(data).cast("B")
        whole = len(rest)
        try:
            while len(rest) and self.failure is None:
                rest = rest[super().write(rest) or 0 :]
        except OSError as error:
            self.failure = error
        return whole

    def truncate(self, size: int | None = None) -> int:
        """Set the length; a failure is kept."""
        try:
            return super().truncate(size)
        except OSError as error:
            self.failure = self.failure or error
            return size or 0

    def settle(self) -> None:
        """Force the file to disk; raise what failed before."""
        if self.failure is not None:
            raise self.failure
        os.fsync(self.fileno())


def _fill(file: Any, run: Run, bits: int | None) -> None:
    indices = kept_everywhere(run)
    arrays = [*coordinates(run, indices), *numbers(run), *fields(run, indices)]
    file.attrs.update(about(run) | {"NX_class": "NXroot", "default": "entry"})
    axes = [array for array in arrays if array.axes == (array.name,)]
    for array in axes:  # first: the others refer to them
        _store(file, array, None)
        file[array.name].make_scale(array.name)
    for array in arrays:
        if array.axes == (array.name,):
            continue
        dataset = _store(file, array, bits)
        for number, axis in enumerate(array.axes):
            dataset.dims[number].attach_scale(file[axis])
        if "level" in array.axes and array.name not in ("column", "q_max"):
            dataset.attrs["coordinates"] = "column q_max"
    shown = [array for array in arrays if array.name.startswith(("flash_temperature", "pressure_L", "heights_L"))]
    _fill_entry(file, shown, f"pressure_L{run.numerics.of_column(run.column(None))[-1]}" if indices else "")


def _store(file: Any, array: Labelled, bits: int | None) -> Any:
    if isinstance(array.data, Stored):
        dataset = _store_one_by_one(file, array.name, array.data, bits)
    elif array.data.dtype.kind == "U":
        dataset = file.create_dataset(array.name, data=array.data.tolist())
    else:
        options = {"compression": "gzip", "shuffle": True, "fletcher32": True} if array.data.size else {}
        dataset = file.create_dataset(array.name, data=array.data, **options)
    dataset.attrs.update(array.attributes)
    return dataset


def _store_one_by_one(file: Any, name: str, stack: Stored, bits: int | None) -> Any:
    """Write array after array, one in memory at a time; fields are rounded, numbers are not."""
    is_field = stack.dtype == np.float32
    chunks = (1, *(min(n, 256) for n in stack.shape[1:])) if is_field else (1, *stack.shape[1:])
    options = {"chunks": chunks, "compression": "gzip", "compression_opts": 4, "shuffle": True, "fletcher32": True}
    dataset = file.create_dataset(name, stack.shape, stack.dtype, **options)
    for row, values in enumerate(stack):
        dataset[row] = rounded(values, bits) if is_field and bits is not None else values
    if is_field:
        dataset.attrs["interpretation"] = "image"
        if bits is not None:  # netCDF's own word for such rounding
            dataset.attrs["_QuantizeBitRoundNumberOfSignificantBits"] = np.int32(bits)
    return dataset


def rounded(values: NDArray[np.float32], bits: int) -> NDArray[np.float32]:
    """Return `values` with `bits` explicit mantissa bits, rounded to nearest, ties to even: the rest is zeros.

    The relative error is at most 2^−(bits+1), for numbers of normal size.
    """
    drop = np.uint32(MANTISSA - bits)
    if drop == 0:
        return values
    pattern = np.ascontiguousarray(values, dtype=np.float32).view(np.uint32)
    half = (np.uint32(1) << (drop - np.uint32(1))) - np.uint32(1)
    odd = (pattern >> drop) & np.uint32(1)
    mask = ~((np.uint32(1) << drop) - np.uint32(1))
    return ((pattern + half + odd) & mask).view(np.float32)


def _fill_entry(file: Any, shown: list[Labelled], first: str) -> None:
    """Link to what viewers can draw: one NXdata group each, the finest pressure first."""
    entry = file.create_group("entry")
    entry.attrs.update(NX_class="NXentry", default=first or "flash_temperature")
    for array in shown:
        group = entry.create_group(array.name)
        group.attrs.update(NX_class="NXdata", signal=array.name, axes=list(array.axes))
        for name in (array.name, *array.axes):
            group[name] = file[name]
