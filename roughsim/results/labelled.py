"""All that a run holds as arrays with names, axes and units: what `Run.to_xarray` and the exported file are made of."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughsim.errors import RecordError
from roughsim.observables.catalogue import NUMBERS
from roughsim.results.fields import kept
from roughsim.store.member_files import FIELD_UNITS, member_path, read_field, read_member

if TYPE_CHECKING:
    from roughsim.observables.record import Observable
    from roughsim.results.run import Run

Array = NDArray[Any]
_WORDS = {
    "heights": "composite heights",
    "pressure": "contact pressure, positive in compression",
    "stress_spectrum": "shares of the pressure variance by wavenumber; single entries may be negative, sums are exact",
}


class Stored:
    """Arrays of many files as one, (file, ...): each is read when it is asked for; NaN where there is no file."""

    def __init__(self, paths: list[Path | None], shape: tuple[int, ...], read: Callable[[Path], Array], kind: str):
        self.paths, self.read = paths, read
        self.shape, self.dtype = (len(paths), *shape), np.dtype(kind)

    def __iter__(self) -> Iterator[Array]:
        return (self._one(path) for path in self.paths)

    def __getitem__(self, key: tuple[Any, ...]) -> Array:
        which, *inside = key
        if isinstance(which, (int, np.integer)):
            one: Array = self._one(self.paths[which])[tuple(inside)]
            return one
        chosen = [self._one(path)[tuple(inside)] for path in self.paths[which]]
        return np.stack(chosen) if chosen else np.empty((0, *self.shape[1:]), self.dtype)[(slice(None), *inside)]

    def _one(self, path: Path | None) -> Array:
        if path is None:
            return np.full(self.shape[1:], np.nan, self.dtype)
        values = self.read(path)
        if values.shape != self.shape[1:]:
            raise RecordError(f"{path} holds an array of shape {values.shape}, but this run has {self.shape[1:]}")
        return values


@dataclass(frozen=True, slots=True, eq=False)
class Labelled:
    """An array with a name, its axes' names, and attributes."""

    name: str
    axes: tuple[str, ...]
    data: NDArray[Any] | Stored
    attributes: dict[str, Any]


def coordinates(run: Run, indices: list[int]) -> Iterator[Labelled]:
    """Yield the axes, and what belongs to each level, speed or realization; `indices` are those with fields."""
    levels = run.numerics.levels
    yield Labelled("level", ("level",), np.arange(len(levels)), {"units": "1"})
    yield Labelled("realization", ("realization",), np.arange(run.realizations), {"units": "1"})
    yield Labelled("speed", ("speed",), np.array(run.scene.speeds), {"units": "m/s"})
    yield Labelled("column", ("level",), np.array([level.column for level in levels]), {})
    yield Labelled("q_max", ("level",), np.array([level.q_max for level in levels]), {"units": "1/m"})
    if indices:
        yield Labelled("kept_realization", ("kept_realization",), np.array(indices), {"units": "1"})
    for number in range(len(levels)):
        grid = run.numerics.grid(number)
        for axis, points, step in zip("xy", grid.shape, grid.spacing, strict=True):
            if indices:
                name = f"{axis}_L{number}"
                yield Labelled(name, (name,), np.arange(points) * step, {"units": "m"})


def numbers(run: Run) -> Iterator[Labelled]:
    """Yield what was measured: (level, realization) or (level, realization, speed), NaN where a member failed."""
    count, levels = run.realizations, len(run.numerics.levels)
    rows = run.sound(count)
    if not rows:
        raise ValueError(f"{run.folder} has no sound realization yet; let it run first")
    share = {"units": "1", "description": "share of the heat that the temperatures are of"}
    yield Labelled("heat_partition", ("speed",), run.heat_partition, share)
    for name, number in NUMBERS.items():
        values = _number(run, name)
        if not np.all(np.isnan(values)):
            yield _of_number(run, number, values)
    yield from _solves(run)
    for level in range(levels):
        yield from _spectra(run, level, count)


def _number(run: Run, name: str) -> Array:
    """A number at (level, realization, speed); NaN where it was not measured."""
    count, levels = run.realizations, run.numerics.levels
    values = np.full((len(levels), count, len(run.scene.speeds) if NUMBERS[name].per_speed else 1), np.nan)
    for level, wanted in enumerate(levels):
        indices = np.arange(0, count, wanted.every)
        values[level, indices] = run.members.numbers(level, name, indices)
    return values


def _of_number(run: Run, number: Observable, values: Array) -> Labelled:
    attributes = {"units": number.unit, "description": number.stored}
    if number.heated:
        values *= run.heat_partition
        attributes["comment"] = "of the share heat_partition of the heat"
    axes = ("level", "realization", "speed")
    if number.per_speed:
        return Labelled(number.name, axes, values, attributes)
    return Labelled(number.name, axes[:2], values[..., 0], attributes)


def _solves(run: Run) -> Iterator[Labelled]:
    shape = len(run.numerics.levels), run.realizations
    converged, residual, iterations = np.zeros(shape, np.int8), np.zeros(shape), np.zeros(shape, np.int64)
    for level, wanted in enumerate(run.numerics.levels):
        indices = np.arange(0, run.realizations, wanted.every)
        converged[level, indices] = ~np.isin(indices, run.members.failed(level, run.realizations))
        residual[level, indices] = run.members.fixed(level, "residual", indices)
        iterations[level, indices] = run.members.fixed(level, "iterations", indices)
    axes = ("level", "realization")
    yield Labelled("converged", axes, converged, {"units": "1", "description": "1 where the contact converged, else 0"})
    yield Labelled("residual", axes, residual, {"units": "1", "description": "of the contact solve"})
    yield Labelled("iterations", axes, iterations, {"units": "1", "description": "of the contact solve"})


def _spectra(run: Run, level: int, count: int) -> Iterator[Labelled]:
    """The stress spectra of a level, unread but for the first, which has the wavenumbers of all."""
    every, failed = run.numerics.levels[level].every, set(run.members.failed(level, count).tolist())
    there = [index % every == 0 and index not in failed for index in range(count)]
    paths = [member_path(run.folder, level, index) if there[index] else None for index in range(count)]
    first = next((path for path in paths if path), None)
    if first is None:
        return
    wavenumber = read_member(first).wavenumber
    axis = f"wavenumber_L{level}"
    yield Labelled(axis, (axis,), wavenumber, {"units": "1/m"})
    attributes = {"units": "Pa^2", "description": _WORDS["stress_spectrum"]} | _of_level(run, level)
    spectra = Stored(paths, wavenumber.shape, lambda path: read_member(path).spectrum, "<f8")
    yield Labelled(f"stress_spectrum_L{level}", ("realization", axis), spectra, attributes)


def fields(run: Run, indices: list[int]) -> Iterator[Labelled]:
    """Yield the stored fields of the kept realizations, level by level, unread."""
    for level in range(len(run.numerics.levels) if indices else 0):
        paths: list[Path | None] = [member_path(run.folder, level, index) for index in indices]
        shape = run.numerics.grid(level).shape
        for name, unit in FIELD_UNITS.items():
            axes = ("kept_realization", f"x_L{level}", f"y_L{level}")
            attributes = {"units": unit, "description": _WORDS[name]} | _of_level(run, level)
            stack = Stored(paths, shape, partial(_field_of, name), "<f4")
            yield Labelled(f"{name}_L{level}", axes, stack, attributes)


def _field_of(name: str, path: Path) -> Array:
    return read_field(path, name)


def _of_level(run: Run, level: int) -> dict[str, Any]:
    wanted = run.numerics.levels[level]
    return {"column": wanted.column, "level": level, "q_max": wanted.q_max}


def kept_everywhere(run: Run) -> list[int]:
    """Return the realizations whose fields are stored at every level."""
    return sorted(set.intersection(*(set(kept(run, level)) for level in range(len(run.numerics.levels)))))


def about(run: Run) -> dict[str, Any]:
    """Return what the whole is: title, scene, numerics, seed and versions, as text and numbers."""
    versions = next(iter(run.members.values())).provenance["versions"]
    return {
        "title": run.scene.title or run.folder.resolve().name,
        "source": f"roughsim {versions['roughsim']}",
        "scene": run.scene.to_toml(),
        "numerics": json.dumps(run.numerics.to_dict()),
        "seed": run.seed,
        "versions": json.dumps(versions),
    }


def to_xarray(run: Run) -> Any:
    """Return what `Run.to_xarray` says."""
    try:
        xarray = import_module("xarray")
    except ImportError:
        raise ImportError("xarray is not installed; type: pip install 'roughsim[xarray]'") from None
    from roughsim.results.lazy import lazily

    indices = kept_everywhere(run)
    axes = {a.name: (a.axes, a.data, a.attributes) for a in coordinates(run, indices)}
    variables: dict[str, Any] = {}
    for array in (*numbers(run), *fields(run, indices)):
        data = lazily(array.data) if isinstance(array.data, Stored) else array.data
        place = axes if array.axes == (array.name,) else variables
        place[array.name] = (array.axes, data, array.attributes)
    return xarray.Dataset(variables, axes, about(run))
