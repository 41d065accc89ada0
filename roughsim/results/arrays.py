"""Numbers and fields of a run as arrays with names, axes and units, for `Run.to_xarray` and the exported file."""

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from itertools import chain, islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughsim.errors import number
from roughsim.observables.catalogue import NUMBERS
from roughsim.results.means import Means
from roughsim.scene.numerics import Numerics
from roughsim.store.member_files import KEPT_FIELDS, member_path, read_field

Array = NDArray[Any]
DERIVED_UNITS = {"heat_flux": "W/m^2", "temperature": "K"}  # of fields that depend on the speed
OF_LEVELS = ("column", "q_max", "cell")  # names of coordinates of the levels
SHARED = {"realization", "speed", "kept_realization"}  # axes that all levels have in common
REALIZATION = ("realization",)
BELOW = "_below"
SPECTRUM = "shares of the pressure variance by wavenumber; single entries may be negative, sums are exact"


class Stored:
    """A field of many members as one array, (member, x, y): each is read, or computed, when it is asked for.

    `read` takes the index of a realization to its field, of the shape `shape`.
    """

    dtype = np.dtype("<f4")

    def __init__(self, indices: list[int], read: Callable[[int], Array], shape: tuple[int, int]):
        self.indices, self.read, self.shape = indices, read, (len(indices), *shape)

    def __iter__(self) -> Iterator[Array]:
        return map(self.read, self.indices)

    def __getitem__(self, key: tuple[Any, ...]) -> Array:
        which, *inside = key
        if isinstance(which, (int, np.integer)):
            return np.asarray(self.read(self.indices[which])[tuple(inside)])
        parts = [self.read(index)[tuple(inside)] for index in self.indices[which]]
        return np.stack(parts) if parts else np.empty((0, *self.shape[1:]), self.dtype)[(slice(None), *inside)]


def check_field(name: str, speed: float | None, direction: float = 0.0) -> None:
    """Refuse an unknown field, a missing or a useless speed, or a direction that is no number: ValueError."""
    number("direction", direction, "rad")
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
    data: Any  # an array, or `Stored`
    attributes: dict[str, Any]

    @property
    def is_axis(self) -> bool:
        """Whether it has the coordinates of the axis of its own name."""
        return self.axes == (self.name,)


def level_arrays(
    run: Means, level: int, kept: list[int], temperature: Callable[[int], Array] | None = None
) -> Iterator[Labelled]:
    """Yield what a level has: axes, numbers of the members that count, spectra, and fields of those in `kept`.

    `temperature` gives the map of one of these; without it there is none. What is of the level below, on the same
    surfaces, ends with `BELOW`.
    """
    rows = np.arange(run.counts[level])
    yield Labelled("realization", REALIZATION, rows, {"units": "1"})
    yield Labelled("speed", ("speed",), np.array(run.scene.speeds), {"units": "m/s"})
    below = run.numerics.below(level) is not None
    for of_below in (False, True) if below else (False,):
        yield from numbers(run, level, rows, of_below)
        yield from spectra(run, level, rows, of_below)
    yield from solves(run, level, rows)
    if kept and level in run.numerics.single:
        yield from fields(run, level, kept, temperature)


def numbers(run: Means, level: int, rows: NDArray[np.int64], below: bool) -> Iterator[Labelled]:
    """Yield the stored numbers of a level, (realization,) or (realization, speed), NaN where a member failed."""
    column, end = run.numerics.levels[level].column, BELOW * below
    share = run.share(column if column in run.numerics.columns else None)
    for name, record in NUMBERS.items():
        values = run.members.numbers(level, name, rows, below)
        if np.all(np.isnan(values)):
            continue
        attributes = {"units": record.unit, "description": record.stored + " (level below)" * below}
        if record.heated:
            values = values * share
            attributes["comment"] = "of the share of the heat that the run uses"
        axes = (*REALIZATION, "speed") if record.per_speed else REALIZATION
        yield Labelled(name + end, axes, values if record.per_speed else values[:, 0], attributes)


def spectra(run: Means, level: int, rows: NDArray[np.int64], below: bool) -> Iterator[Labelled]:
    """Yield wavenumbers and stress spectra of a level, NaN where a member failed."""
    wavenumber, values = run.members.spectra(level, rows, below)
    name, end = f"wavenumber{BELOW * below}", BELOW * below
    if wavenumber.size:
        yield Labelled(name, (name,), wavenumber, {"units": "1/m"})
        yield Labelled(
            f"stress_spectrum{end}", (*REALIZATION, name), values, {"units": "Pa^2", "description": SPECTRUM}
        )


def solves(run: Means, level: int, rows: NDArray[np.int64]) -> Iterator[Labelled]:
    """Yield whether the contact of each member converged, its residual, and its iterations."""
    members = [run.members[level, int(row)] for row in rows]
    converged = np.array([not member.failure for member in members], np.int8)
    yield Labelled("converged", REALIZATION, converged, {"units": "1", "description": "1 where the contact converged"})
    for name in ("residual", "iterations"):
        values = np.array([member.provenance.get(name, np.nan) for member in members], np.float64)
        yield Labelled(name, REALIZATION, values, {"units": "1", "description": "of the contact solve"})


def fields(run: Means, level: int, kept: list[int], temperature: Callable[[int], Array] | None) -> Iterator[Labelled]:
    """Yield the axes of a level's fields, and, unread, those that all the realizations in `kept` have stored."""
    grid, axes = run.numerics.grid(level), ("kept_realization", "x", "y")
    yield Labelled("kept_realization", axes[:1], np.array(kept), {"units": "1"})
    for axis, points, step in zip("xy", grid.shape, grid.spacing, strict=True):
        yield Labelled(axis, (axis,), np.arange(points) * step, {"units": "m"})

    for name, kind in KEPT_FIELDS.items():
        if run.members.kept(level, name, kept) == kept:
            stored = Stored(kept, partial(read_kept, run.folder, level, grid.shape, name), grid.shape)
            yield Labelled(name, axes, stored, {"units": kind.unit, "description": kind.description})
    if temperature is not None:
        fastest = max(run.scene.speeds)
        words = f"above the mean of the cell, at the highest speed, {fastest:g} m/s, with the share of the heat used"
        attributes = {"units": "K", "description": words, "speed": fastest}
        yield Labelled("temperature", axes, Stored(kept, temperature, grid.shape), attributes)


def read_kept(folder: Path, level: int, shape: tuple[int, int], name: str, index: int) -> Array:
    """Return a kept field of a member of a run."""
    return read_field(member_path(folder, level, index), name, shape)


def flat(run: Means, levels: list[list[Labelled]]) -> Iterator[Labelled]:
    """Yield the arrays of all levels as those of one dataset.

    Numbers are stacked over the level, NaN where it was not solved. All else carries the number of its level.
    """
    count, numerics = max(run.counts), run.numerics
    yield Labelled("level", ("level",), np.arange(len(levels)), {"units": "1"})
    yield Labelled("realization", REALIZATION, np.arange(count), {"units": "1"})
    yield Labelled("speed", ("speed",), np.array(run.scene.speeds), {"units": "m/s"})
    yield Labelled("column", ("level",), np.array([level.column for level in numerics.levels]), {})
    yield Labelled("q_max", ("level",), np.array([level.q_max for level in numerics.levels]), {"units": "1/m"})
    cells = np.array([level.cell or "whole" for level in numerics.levels])
    yield Labelled("cell", ("level",), cells, {"description": "half, quarter: of so much of the sides"})
    share = {"units": "1", "description": "share of the heat that the temperatures are of"}
    columns = (level.column if level.column in numerics.columns else None for level in numerics.levels)
    yield Labelled("heat_partition", ("level", "speed"), np.array([run.share(column) for column in columns]), share)
    kept = (array for array in chain(*levels) if array.name == "kept_realization")
    yield from islice(kept, 1)
    stacked: dict[str, Labelled] = {}
    for level, arrays in enumerate(levels):
        for array in arrays:
            if array.name in SHARED:
                continue
            data, axes = array.data, array.axes
            if axes[:1] == REALIZATION:  # as many as the level with most members has
                data = blank((count, *array.data.shape[1:]), array.data.dtype)
                data[: len(array.data)] = array.data
            if SHARED.issuperset(axes):
                if array.name not in stacked:
                    empty = blank((len(levels), *data.shape), data.dtype)
                    stacked[array.name] = Labelled(array.name, ("level", *axes), empty, array.attributes)
                stacked[array.name].data[level] = data
            else:
                own = tuple(axis if axis in SHARED else f"{axis}_L{level}" for axis in axes)
                attributes = array.attributes | ({} if array.is_axis else level_attributes(numerics, level))
                yield Labelled(f"{array.name}_L{level}", own, data, attributes)
    yield from stacked.values()


def blank(shape: tuple[int, ...], kind: np.dtype[Any]) -> Array:
    """Return an array without values: NaN, or 0 of whole numbers."""
    return np.full(shape, np.nan if kind.kind == "f" else 0, kind)


def level_attributes(numerics: Numerics, level: int) -> dict[str, Any]:
    """Return the column, number, cut-off and cell of a level as attributes."""
    of_level = numerics.levels[level]
    return {"column": of_level.column, "level": level, "q_max": of_level.q_max, "cell": of_level.cell or "whole"}


def attributes_of(run: Means) -> dict[str, Any]:
    """Return title, scene, numerics, seed and versions of a run, as files and datasets carry them."""
    return {
        "title": run.scene.title or run.folder.resolve().name,
        "source": f"roughsim {run.versions['roughsim']}",
        "scene": run.scene.to_toml(),
        "numerics": json.dumps(run.numerics.to_dict()),
        "seed": run.seed,
        "versions": json.dumps(run.versions),
    }


def to_dataset(arrays: list[Labelled], attributes: dict[str, Any]) -> Any:
    """Return arrays as an `xarray.Dataset` in which stored ones are read when they are used; ImportError without it."""
    try:
        xarray, unread = import_module("xarray"), import_module("roughsim.results.unread")
    except ImportError:
        raise ImportError("xarray is not installed; type: pip install 'roughsim[xarray]'") from None
    axes: dict[str, Any] = {}
    variables: dict[str, Any] = {}
    for array in arrays:
        data = unread.lazy(array.data) if isinstance(array.data, Stored) else array.data
        is_coordinate = array.is_axis or array.name in OF_LEVELS
        (axes if is_coordinate else variables)[array.name] = (array.axes, data, array.attributes)
    return xarray.Dataset(variables, axes, attributes)
