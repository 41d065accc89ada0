"""Export of a run to one file for HDF5 and netCDF-4 readers, and of surfaces to other contact programs.

The group ``results`` has the `Results`: every observable in every column with its error. The group ``members`` has
the arrays of `Run.to_xarray`: numbers and kept fields. All arrays have dimension scales and units (netCDF-4). The group
``entry`` links to the default plots of viewers (NeXus).
"""

import hashlib
import os
from dataclasses import replace
from io import FileIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughsim.results.arrays import SHARE, Stored, attributes_of
from roughsim.results.columns import columns_of, heat_shares, is_ratio, meaning, results_of
from roughsim.results.run import Run
from roughsim.results.table import Labelled
from roughsim.store.disk import place_bytes, seal
from roughsim.surface.topography import writing
from roughsim.table import Estimate

ENDINGS = (".h5", ".hdf5", ".nc")
_MANTISSA = 23  # explicit bits of a float32
_GZIP = 4  # level at which fields are packed


def export_run(run: Run, path: str | Path, bits: int | None = None) -> Path:
    """Write the results of a run, the numbers of all members that count, and the kept fields into one file.

    It is whole or not there, and its last line has the SHA-256 of all before. Its attribute README describes it.
    ``xarray.open_dataset(path, group="results")`` has the results, and with ``group="members"`` the members.

    `path`, which is returned, ends in .h5, .hdf5 or .nc; a file there is replaced. `bits` are the explicit mantissa
    bits that fields keep, 1 to 23, left out: all. A value is rounded by at most 2^−(bits+1) of itself.

    ValueError for another ending, `bits` out of range, or a run without a sound realization. RecordError if a file of
    the run is damaged. OSError, naming the path, if the disk refuses; no half-written file stays.
    """
    import h5py

    path = Path(path)
    if path.suffix.lower() not in ENDINGS:
        raise ValueError(f"path = {str(path)!r} must end in {', '.join(ENDINGS)}")
    if bits is not None and (
        isinstance(bits, bool) or int(bits) != bits or not 1 <= bits <= _MANTISSA
    ):
        raise ValueError(f"bits = {bits!r} must be a whole number from 1 to {_MANTISSA}")
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        with _DeferringFile(temporary) as handle:
            with h5py.File(handle, "w", libver="v110", track_order=True) as file:
                _write_run(file, run, bits)
            if handle.failure is not None:
                raise handle.failure
            handle.seek(0)
            handle.write(
                seal(path.name, hashlib.file_digest(handle, "sha256"))
            )  # the position is the end
            if handle.failure is not None:
                raise handle.failure
            os.fsync(handle.fileno())
        os.replace(temporary, path)
    except BaseException as error:
        temporary.unlink(missing_ok=True)
        if isinstance(error, OSError):
            raise OSError(error.errno, f"cannot write {path}: {error.strerror or error}") from error
        raise
    return path


def export_surface(run: Run, path: str | Path, realization: int = 0) -> Path:
    """Write the composite heights of one kept realization for SurfaceTopography, ContactMechanics or tamaas.

    `path`, which is returned, ends in .nc (with sizes and unit) or .npy (the bare array, m); a file there is replaced.
    The heights are of the finest level of the main column in the run's cell.

    ValueError for another ending, or a realization whose fields were not kept. RecordError if its file is damaged.
    OSError, naming the path, if the disk refuses.
    """
    path = Path(path)
    if path.suffix.lower() not in writing.ENDINGS:
        raise ValueError(
            f"path = {str(path)!r} of a surface must end in {' or '.join(writing.ENDINGS)}"
        )
    level = run.numerics.picture(run.column(None))
    if realization not in run.kept(level):
        raise run.not_kept(level, realization)
    heights = run.field(level, realization, "heights")
    content = writing.encoded(heights, run.grid(level), path.suffix.lower())
    path.parent.mkdir(parents=True, exist_ok=True)
    place_bytes(path, content)
    return path


class _DeferringFile(FileIO):
    """A new file that keeps the first failure to write, and raises none: HDF5 itself crashes on a full disk."""

    def __init__(self, path: Path):
        super().__init__(path, "w+")
        self.failure: OSError | None = None

    def write(self, data: Any) -> int:
        """Write all of `data`, or nothing after a failed write."""
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


def _write_run(file: Any, run: Run, bits: int | None) -> None:
    """Fill an HDF5 file with a run: results, members, and the default plots of viewers."""
    from roughsim.store.hdf5 import write_arrays  # loads h5py

    results = results_of(run)
    members = [_rounded(array, bits) for array in run.arrays()]
    file.attrs.update(
        attributes_of(run.members)
        | {"README": readme(run), "NX_class": "NXroot", "default": "entry"}
    )
    file.attrs.update(realizations=run.realizations, failed=run.failed)
    shares = Labelled("heat_share_used", ("column", "speed"), heat_shares(run), SHARE)
    write_arrays(file.create_group("results"), (*results.arrays(), shares))
    group = file.create_group("members")
    write_arrays(group, members, _GZIP)
    entry = file.create_group("entry")
    entry.attrs.update(NX_class="NXentry", default="flash_temperature")
    _draw_flash(file, entry, results["flash_temperature"], run.column(None))
    for array in members:
        if isinstance(array.data, Stored):
            shown = entry.create_group(array.name)
            shown.attrs.update(NX_class="NXdata", signal=array.name, axes=list(array.axes))
            for name in (array.name, *array.axes):
                shown[name] = group[name]


def _draw_flash(file: Any, entry: Any, flash: Estimate, column: str) -> None:
    """Set the default plot of viewers: T_flash of a column over the speed, with its error, and the other columns."""
    from roughsim.store.hdf5 import write_arrays

    names = [name for name in flash.coords["column"].tolist() if not is_ratio(name)]
    curves = {name: flash.sel(column=name).mean for name in names}
    curves[f"{column}_errors"] = flash.sel(column=column).total_error
    beside = [name for name in names if name != column]
    group = entry.create_group("flash_temperature")
    group.attrs.update(NX_class="NXdata", signal=column, auxiliary_signals=beside, axes=["speed"])
    group["speed"] = file["results/speed"]
    write_arrays(
        group,
        [Labelled(name, ("speed",), values, {"units": "K"}) for name, values in curves.items()],
    )


def readme(run: Run) -> str:
    """Return the README text of an exported file."""
    columns, main = list(columns_of(run)), run.column(None)
    failed = f", {run.failed} of them failed and left out" if run.failed else ""
    levels = [
        f"- level {i}: {level.column} contact, {level.shape[0]} x {level.shape[1]} points{level.where}, "
        f"q_c = {level.q_max:.4g} rad/m."
        for i, level in enumerate(run.numerics.levels)
    ]
    parts = [
        f"{run.scene.title or run.folder.resolve().name}: {run.realizations} realizations{failed}. Units are SI. "
        "Temperatures are above the background, with the share heat_share_used of the heat of both bodies.",
        "The group results holds the results. Each observable is an array over the columns, and over the speed if it "
        "depends on it. NAME_part are the parts of its 95 % error (NaN: unknown), NAME_total_error their root of "
        "squares, and NAME_note marks values that are not extrapolated (at q_c) or fixed by force balance (identity). "
        "The columns are",
        *(f"- {column}: {meaning(column)}" for column in columns),
        "The means are extrapolated to all of C(q) if the levels allow it. The raw numbers, one for each level and "
        "realization, are in the group members. Its levels are",
        *levels,
        "Arrays of one level, as pressure_L2, end with its number: spectra, and fields (heights, pressure, and "
        "temperature at the highest speed) of the realizations that kept them. The group entry links to the data for "
        "viewers (NeXus).",
        f'For example in Python, T_flash of column "{main}" over the speed: '
        f'h5py.File(NAME)["results/flash_temperature"][{columns.index(main)}] or '
        f'xarray.open_dataset(NAME, group="results").flash_temperature.sel(column="{main}").',
    ]
    return "\n".join(parts)


def _rounded(array: Labelled, bits: int | None) -> Labelled:
    """Return a kept field rounded to `bits` explicit mantissa bits, and other arrays unchanged."""
    if not isinstance(array.data, Stored):
        return array
    attributes = {**array.attributes, "interpretation": "image"}
    if bits is None:
        return array._replace(attributes=attributes)
    attributes["_QuantizeBitRoundNumberOfSignificantBits"] = np.int32(
        bits
    )  # netCDF's own word for such rounding
    data = replace(array.data, read=lambda index: rounded(array.data.read(index), bits))
    return array._replace(data=data, attributes=attributes)


def rounded(values: NDArray[np.float32], bits: int) -> NDArray[np.float32]:
    """Return `values` with `bits` explicit mantissa bits, rounded to nearest, ties to even: the rest is zeros.

    The relative error is at most 2^−(bits+1), for numbers of normal size.
    """
    drop = _MANTISSA - bits
    if drop == 0:
        return values
    pattern = np.ascontiguousarray(values, dtype=np.float32).view(np.uint32)
    half, odd = (1 << (drop - 1)) - 1, (pattern >> drop) & 1
    return ((pattern + half + odd) >> drop << drop).view(np.float32)
