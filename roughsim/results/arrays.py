"""Numbers and fields of a run as arrays with names, axes and units, for `Run.to_xarray` and the exported file."""

from collections.abc import Iterator
from dataclasses import dataclass
from importlib import import_module
from itertools import compress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughsim.errors import number
from roughsim.observables.catalogue import NUMBERS
from roughsim.results.members import SOUND, Members
from roughsim.results.reader import Reader
from roughsim.scene.numerics import Numerics
from roughsim.store.member_files import member_path, read_field
from roughsim.store.member_hdf5 import KEPT_FIELDS

Array = NDArray[Any]
DERIVED_UNITS = {"heat_flux": "W/m^2", "temperature": "K"}  # of fields that depend on the speed
OF_LEVELS = ("column", "q_max", "cell")  # names of coordinates of the levels
SPECTRUM = "shares of the pressure variance by wavenumber; single entries may be negative, sums are exact"


class Stored:
    """A kept field of many files as one array, (file, x, y): each is read when it is asked for."""

    dtype = np.dtype("<f4")

    def __init__(self, paths: list[Path], name: str, shape: tuple[int, int]):
        self.paths, self.name, self.shape = paths, name, (len(paths), *shape)

    def __iter__(self) -> Iterator[Array]:
        return map(self.load, self.paths)

    def __getitem__(self, key: tuple[Any, ...]) -> Array:
        which, *inside = key
        if isinstance(which, (int, np.integer)):
            return np.asarray(self.load(self.paths[which])[tuple(inside)])
        parts = [self.load(path)[tuple(inside)] for path in self.paths[which]]
        return np.stack(parts) if parts else np.empty((0, *self.shape[1:]), self.dtype)[(slice(None), *inside)]

    def load(self, path: Path) -> Array:
        """Return the field of one file; errors as `read_field`."""
        return read_field(path, self.name, self.shape[1:])


def check_field(name: str, speed: float | None) -> None:
    """Refuse an unknown field, a missing or a useless speed, ValueError."""
    if name not in (*KEPT_FIELDS, *DERIVED_UNITS):
        raise ValueError(f"name = {name!r} is no field; choose one of {', '.join((*KEPT_FIELDS, *DERIVED_UNITS))}")
    if name in DERIVED_UNITS:
        if speed is None:
            raise ValueError(f"speed is missing: {name} depends on it; give speed= in m/s")
        number("speed", speed, "m/s")
    elif speed is not None:
        raise ValueError(f"speed = {speed!r} m/s: {name} does not depend on it; leave it out")


@dataclass(frozen=True, slots=True, eq=False)
class Labelled:
    """An array with a name, its axes' names, and attributes."""

    name: str
    axes: tuple[str, ...]
    data: Array | Stored
    attributes: dict[str, Any]

    @property
    def is_axis(self) -> bool:
        """Whether it has the coordinates of the axis of its own name."""
        return self.axes == (self.name,)


def coordinates(numerics: Numerics, speeds: tuple[float, ...], count: int, kept: list[int]) -> Iterator[Labelled]:
    """Yield the axes, and the column, cut-off and cell of each level; `kept` are the realizations with fields."""
    levels = numerics.levels
    yield Labelled("level", ("level",), np.arange(len(levels)), {"units": "1"})
    yield Labelled("realization", ("realization",), np.arange(count), {"units": "1"})
    yield Labelled("speed", ("speed",), np.array(speeds), {"units": "m/s"})
    yield Labelled("column", ("level",), np.array([level.column for level in levels]), {})
    yield Labelled("q_max", ("level",), np.array([level.q_max for level in levels]), {"units": "1/m"})
    cells = np.array([level.cell or "whole" for level in levels])
    yield Labelled("cell", ("level",), cells, {"description": "half: of half the sides, on surfaces of its own"})
    if not kept:
        return
    yield Labelled("kept_realization", ("kept_realization",), np.array(kept), {"units": "1"})
    for level in numerics.single:
        grid = numerics.grid(level)
        for axis, points, step in zip("xy", grid.shape, grid.spacing, strict=True):
            name = f"{axis}_L{level}"
            yield Labelled(name, (name,), np.arange(points) * step, {"units": "m"})


def numbers(members: Members, numerics: Numerics, count: int, heat_partition: Array) -> Iterator[Labelled]:
    """Yield the stored numbers: (level, realization) or (level, realization, speed), NaN where a member failed."""
    levels, axes = numerics.levels, ("level", "realization", "speed")
    rows = [np.array(level.indices(count)) for level in levels]

    def gathered(name: str, blank: Array) -> Array:
        for level, indices in enumerate(rows):
            blank[level, indices] = members.column(level, name, indices).reshape(len(indices), *blank.shape[2:])
        return blank

    share = {"units": "1", "description": "share of the heat that the temperatures are of"}
    yield Labelled("heat_partition", ("speed",), heat_partition, share)
    shape = len(levels), count
    for name, record in NUMBERS.items():
        values = gathered(name, np.full((*shape, len(heat_partition)) if record.per_speed else shape, np.nan))
        if np.all(np.isnan(values)):
            continue
        attributes = {"units": record.unit, "description": record.stored}
        if record.heated:
            values *= heat_partition
            attributes["comment"] = "of the share heat_partition of the heat"
        yield Labelled(name, axes[: values.ndim], values, attributes)
    converged = (gathered("state", np.zeros(shape, np.int8)) == SOUND).astype(np.int8)
    description = {"units": "1", "description": "1 where the contact converged, else 0"}
    yield Labelled("converged", axes[:2], converged, description)
    description = {"units": "1", "description": "of the contact solve"}
    yield Labelled("residual", axes[:2], gathered("residual", np.zeros(shape)), description)
    yield Labelled("iterations", axes[:2], gathered("iterations", np.zeros(shape, np.int64)), description)


def spectra(reader: Reader, count: int) -> Iterator[Labelled]:
    """Yield wavenumbers and stress spectra of each level, NaN where it was not solved or failed."""
    numerics = reader.numerics
    for level, of_level in enumerate(numerics.levels):
        sound = np.setdiff1d(of_level.indices(count), reader.members.failed(level, count))
        if not sound.size:
            continue
        axis, (wavenumber, rows) = f"wavenumber_L{level}", reader.spectra(level, sound)
        yield Labelled(axis, (axis,), wavenumber, {"units": "1/m"})
        values = np.full((count, len(wavenumber)), np.nan)
        values[sound] = rows
        attributes = level_attributes(numerics, level, "Pa^2", SPECTRUM)
        yield Labelled(f"stress_spectrum_L{level}", ("realization", axis), values, attributes)


def fields(folder: Path, members: Members, numerics: Numerics, kept: list[int]) -> Iterator[Labelled]:
    """Yield the fields that all the kept realizations have stored, level by level, unread."""
    for level in numerics.single if kept else ():
        paths = [member_path(folder, level, index) for index in kept]
        stored_by_all = [bool(of_field.all()) for of_field in members.column(level, "kept", np.array(kept)).T]
        for name, (unit, description) in compress(KEPT_FIELDS.items(), stored_by_all):
            axes = ("kept_realization", f"x_L{level}", f"y_L{level}")
            stored = Stored(paths, name, numerics.grid(level).shape)
            yield Labelled(f"{name}_L{level}", axes, stored, level_attributes(numerics, level, unit, description))


def level_attributes(numerics: Numerics, level: int, unit: str, description: str) -> dict[str, Any]:
    """Return the attributes of an array of one level: unit, description, column, number and cut-off of the level."""
    column, q_max = numerics.levels[level].column, numerics.levels[level].q_max
    return {"units": unit, "description": description, "column": column, "level": level, "q_max": q_max}


def to_dataset(arrays: list[Labelled], attributes: dict[str, Any]) -> Any:
    """Return arrays as an `xarray.Dataset` in which stored ones are read when they are used; ImportError without it."""
    try:
        xarray, indexing = import_module("xarray"), import_module("xarray.core.indexing")
    except ImportError:
        raise ImportError("xarray is not installed; type: pip install 'roughsim[xarray]'") from None
    base: Any = import_module("xarray.backends").BackendArray

    class Unread(base):  # type: ignore[misc]
        """The bridge that xarray asks of a storage backend."""

        def __init__(self, stored: Stored):
            self.stored, self.shape, self.dtype = stored, stored.shape, stored.dtype

        def __getitem__(self, key: Any) -> Any:
            basic = indexing.IndexingSupport.BASIC
            return indexing.explicit_indexing_adapter(key, self.shape, basic, self.stored.__getitem__)

    axes: dict[str, Any] = {}
    variables: dict[str, Any] = {}
    for array in arrays:
        data = indexing.LazilyIndexedArray(Unread(array.data)) if isinstance(array.data, Stored) else array.data
        is_coordinate = array.is_axis or array.name in OF_LEVELS
        (axes if is_coordinate else variables)[array.name] = (array.axes, data, array.attributes)
    return xarray.Dataset(variables, axes, attributes)
