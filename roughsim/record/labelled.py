"""All that a run holds as arrays with names, axes and units: what `Run.to_xarray` and the exported file are made of."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughsim.means import PER_SPEED
from roughsim.record.fields import kept
from roughsim.record.files import FIELD_UNITS, NUMBER_UNITS, member_path, read_field, read_member

if TYPE_CHECKING:
    from roughsim.record.run import Run

_HEATED = ("flash_temperature", "flash_gradient", "flash_laplacian", "resting_flash_temperature")
_WORDS = {
    "flash_temperature": "<T sigma>/<sigma>, steady sliding, averaged over directions",
    "flash_gradient": "<dT/dx sigma>/<sigma>, along the sliding velocity",
    "flash_laplacian": "<(d2T/dx2 + d2T/dy2) sigma>/<sigma>",
    "resting_flash_temperature": "<T sigma>/<sigma> of the same heat in a body that does not move under it",
    "contact_fraction": "A/A0",
    "plastic_fraction": "share of the cell at the penetration hardness",
    "contact_fraction_corrected": "A/A0 less what the pixels add along the edge of the contact",
    "plastic_fraction_corrected": "plastic_fraction with what the pixels take along its edge",
    "pressure_variance": "<sigma^2> - sigma0^2",
    "heights": "composite heights",
    "pressure": "contact pressure, positive in compression",
    "stress_spectrum": "shares of the pressure variance by wavenumber; single entries may be negative, sums are exact",
}


class KeptFields:
    """The stored field `name` of the kept members of a level, (realization, x, y), read one by one when asked for."""

    dtype = np.dtype(np.float32)

    def __init__(self, run: Run, level: int, indices: list[int], name: str):
        self.paths = [member_path(run.folder, level, index) for index in indices]
        self.name = name
        self.shape = (len(indices), *run.numerics.grid(level).shape)

    def __iter__(self) -> Iterator[NDArray[np.float32]]:
        return (read_field(path, self.name) for path in self.paths)

    def __getitem__(self, key: tuple[Any, ...]) -> NDArray[np.float32]:
        which, *inside = key
        if isinstance(which, (int, np.integer)):
            one: NDArray[np.float32] = read_field(self.paths[which], self.name)[tuple(inside)]
            return one
        chosen = [read_field(path, self.name)[tuple(inside)] for path in self.paths[which]]
        return np.stack(chosen) if chosen else np.empty((0, *self.shape[1:]), self.dtype)[(slice(None), *inside)]


@dataclass(frozen=True, slots=True, eq=False)
class Labelled:
    """An array with a name, its axes' names, and attributes."""

    name: str
    axes: tuple[str, ...]
    data: NDArray[Any] | KeptFields
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
    members = {key: member for key, member in run.members.items() if key[1] < count}
    for name in next(member for member in members.values() if not member.failure).numbers:
        wide = name in (*PER_SPEED, "resting_flash_temperature")
        values = np.full((levels, count, len(run.scene.speeds) if wide else 1), np.nan)
        for (level, index), member in members.items():
            if not member.failure:
                values[level, index] = member.numbers[name]
        if name in _HEATED:
            values *= run.heat_partition
        axes = ("level", "realization", "speed") if wide else ("level", "realization")
        comment = {"comment": "of the share heat_partition of the heat"} if name in _HEATED else {}
        attributes = {"units": NUMBER_UNITS[name], "description": _WORDS[name]} | comment
        yield Labelled(name, axes, values if wide else values[..., 0], attributes)
    yield from _solves(members, (levels, count))
    for level in range(levels):
        yield from _spectra(run, level, count)


def _solves(members: dict[tuple[int, int], Any], shape: tuple[int, int]) -> Iterator[Labelled]:
    converged, residual, iterations = np.zeros(shape, np.int8), np.zeros(shape), np.zeros(shape, np.int64)
    for place, member in members.items():
        converged[place] = not member.failure
        residual[place], iterations[place] = member.provenance["residual"], member.provenance["iterations"]
    axes = ("level", "realization")
    yield Labelled("converged", axes, converged, {"units": "1", "description": "1 where the contact converged, else 0"})
    yield Labelled("residual", axes, residual, {"units": "1", "description": "of the contact solve"})
    yield Labelled("iterations", axes, iterations, {"units": "1", "description": "of the contact solve"})


def _spectra(run: Run, level: int, count: int) -> Iterator[Labelled]:
    """The stress spectra of a level, read one by one."""
    wavenumber = spectra = np.empty(0)
    for index in range(count):
        if (level, index) not in run.members or run.members[level, index].failure:
            continue
        member = read_member(member_path(run.folder, level, index))
        if not spectra.size:
            wavenumber, spectra = member.wavenumber, np.full((count, member.wavenumber.size), np.nan)
        spectra[index] = member.spectrum
    axis = f"wavenumber_L{level}"
    yield Labelled(axis, (axis,), wavenumber, {"units": "1/m"})
    attributes = {"units": "Pa^2", "description": _WORDS["stress_spectrum"]} | _of_level(run, level)
    yield Labelled(f"stress_spectrum_L{level}", ("realization", axis), spectra, attributes)


def fields(run: Run, indices: list[int]) -> Iterator[Labelled]:
    """Yield the stored fields of the kept realizations, level by level, unread."""
    for level in range(len(run.numerics.levels) if indices else 0):
        for name, unit in FIELD_UNITS.items():
            axes = ("kept_realization", f"x_L{level}", f"y_L{level}")
            attributes = {"units": unit, "description": _WORDS[name]} | _of_level(run, level)
            yield Labelled(f"{name}_L{level}", axes, KeptFields(run, level, indices, name), attributes)


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
    from roughsim.record.lazy import lazily

    indices = kept_everywhere(run)
    axes = {a.name: (a.axes, a.data, a.attributes) for a in coordinates(run, indices)}
    variables: dict[str, Any] = {}
    for array in (*numbers(run), *fields(run, indices)):
        data = lazily(array.data) if isinstance(array.data, KeptFields) else array.data
        place = axes if array.axes == (array.name,) else variables
        place[array.name] = (array.axes, data, array.attributes)
    return xarray.Dataset(variables, axes, about(run))
