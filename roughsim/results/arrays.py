"""Numbers and fields of a run as named arrays with axes and units, for `Run.to_xarray` and the exported file."""

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughsim.observables.catalogue import NUMBERS
from roughsim.observables.record import Sample
from roughsim.results.members import Members
from roughsim.results.table import Labelled
from roughsim.scene import Scene
from roughsim.store.member_files import KEPT_FIELDS

Array = NDArray[Any]
OF_LEVELS = ("column", "q_max", "cell")  # names of coordinates of the levels
_SPECTRUM = (
    "shares of the pressure variance by wavenumber; single entries may be negative, sums are exact"
)
SHARE = {"units": "1", "description": "share of the heat used for the temperatures"}


@dataclass(frozen=True)
class Stored:
    """A field of many members as one lazy array, (member, x, y)."""

    indices: list[int]  # of the members
    read: Callable[[int], Array]  # returns the field of a member by its index
    points: tuple[int, int]
    dtype = np.dtype("<f4")

    @property
    def shape(self) -> tuple[int, int, int]:
        """Members and points."""
        return len(self.indices), *self.points

    def __iter__(self) -> Iterator[Array]:
        return map(self.read, self.indices)

    def __getitem__(self, key: tuple[Any, ...]) -> Array:
        which, *inside = key
        if isinstance(which, (int, np.integer)):
            return np.asarray(self.read(self.indices[which])[tuple(inside)])
        parts = [self.read(index)[tuple(inside)] for index in self.indices[which]]
        return (
            np.stack(parts)
            if parts
            else np.empty((0, *self.shape[1:]), self.dtype)[(slice(None), *inside)]
        )


def arrays_of(
    members: Members, shares: list[Array], read: Callable[..., Array]
) -> Iterator[Labelled]:
    """Yield all numbers of the counted members over the level, and the spectra and fields of each level.

    `shares` of the heat, (speeds,), are by level; `read` is `Run.field`. Arrays of the level below, on the same
    surfaces, have "_below" in their name; arrays that depend on the grid of a level have the number of the level, as
    "pressure_L2".
    """
    levels, scene = members.numerics.levels, members.scene
    cells = np.array([level.cell or "whole" for level in levels])
    yield Labelled("level", ("level",), np.arange(len(levels)), {"units": "1"})
    yield Labelled("realization", ("realization",), np.arange(max(members.counts)), {"units": "1"})
    if scene.directions:
        about = {"units": "rad", "description": "of sliding, from x towards y"}
        yield Labelled("direction", ("direction",), np.array(scene.directions), about)
    yield Labelled("speed", ("speed",), np.array(scene.sliding.speed), {"units": "m/s"})
    yield Labelled("column", ("level",), np.array([level.column for level in levels]), {})
    yield Labelled(
        "q_max", ("level",), np.array([level.q_max for level in levels]), {"units": "1/m"}
    )
    yield Labelled(
        "cell", ("level",), cells, {"description": "half, quarter: of so much of the sides"}
    )
    yield _over_speed(scene, "heat_partition", ("level",), np.array(shares), SHARE)
    yield from _solves(members)
    for below in (False, True):
        of_levels = {
            level: members.sample(level, below, range(count))
            for level, count in enumerate(members.counts)
            if not below or members.numerics.below(level) is not None
        }
        yield from _numbers(members, of_levels, shares, below)
        for level, sample in of_levels.items():
            yield from _spectra(members, sample, f"{'_below' * below}_L{level}")
    for level in members.numerics.single:
        if kept := members.kept(level, "pressure"):
            yield from _fields(members, level, kept, partial(read, level))


def _solves(members: Members) -> Iterator[Labelled]:
    """Yield whether the contact of each member converged, its residual, and its iterations."""
    axes, shape = ("level", "realization"), (len(members.counts), max(members.counts))
    converged = np.zeros(shape, np.int8)
    of_solve = {name: np.full(shape, np.nan) for name in ("residual", "iterations")}
    for level, count in enumerate(members.counts):
        for index in range(count):
            member = members[level, index]
            converged[level, index] = not member.failure
            for name, values in of_solve.items():
                values[level, index] = member.provenance.get(name, np.nan)
    about = {"units": "1", "description": "1 for a converged contact"}
    yield Labelled("converged", axes, converged, about)
    for name, values in of_solve.items():
        yield Labelled(name, axes, values, {"units": "1", "description": "of the contact solve"})


def _over_speed(
    scene: Scene, name: str, axes: tuple[str, ...], data: Array, attributes: dict[str, str]
) -> Labelled:
    """Return an array whose last axis has the `speeds` of a scene, with axes of their directions and speeds."""
    if not scene.directions:
        return Labelled(name, (*axes, "speed"), data, attributes)
    split = data.reshape(*data.shape[:-1], len(scene.directions), -1)
    return Labelled(name, (*axes, "direction", "speed"), split, attributes)


def _numbers(
    members: Members, of_levels: dict[int, Sample], shares: list[Array], below: bool
) -> Iterator[Labelled]:
    """Yield the stored numbers, NaN without a sound member; temperatures with their share of the heat."""
    for name, record in NUMBERS.items():
        values = np.full(
            (len(shares), max(members.counts), len(members.speeds) if record.per_speed else 1),
            np.nan,
        )
        for level, sample in of_levels.items():
            rows = sample.numbers[name]
            values[level, : len(rows)] = rows * shares[level] if record.heated else rows
        if np.all(np.isnan(values)):
            continue
        attributes = {"units": record.unit, "description": record.stored + " (level below)" * below}
        if record.heated:
            attributes["comment"] = "with the share of the heat used by the run"
        axes, name_below = ("level", "realization"), name + "_below" * below
        if record.per_speed:
            yield _over_speed(members.scene, name_below, axes, values, attributes)
        else:
            yield Labelled(name_below, axes, values[..., 0], attributes)


def _spectra(members: Members, sample: Sample, end: str) -> Iterator[Labelled]:
    """Yield the wavenumbers and stress spectra of a level, NaN for failed members; `end` is of their names."""
    axis = f"wavenumber{end}"
    if sample.wavenumber.size:
        padded = np.full((max(members.counts), sample.wavenumber.size), np.nan)
        padded[: len(sample.spectrum)] = sample.spectrum
        attributes = {"units": "Pa^2", "description": _SPECTRUM}
        yield Labelled(axis, (axis,), sample.wavenumber, {"units": "1/m"})
        yield Labelled(f"stress_spectrum{end}", ("realization", axis), padded, attributes)


def _fields(
    members: Members, level: int, kept: list[int], read: Callable[..., Array]
) -> Iterator[Labelled]:
    """Yield the axes of a level's fields, and the lazy fields stored by all realizations in `kept`."""
    numerics, end = members.numerics, f"_L{level}"
    grid, axes = (
        numerics.grid(level).stretched(members.scene.lay),
        (f"kept_realization{end}", f"x{end}", f"y{end}"),
    )
    yield Labelled(axes[0], axes[:1], np.array(kept), {"units": "1"})
    for axis, points, step in zip(axes[1:], grid.shape, grid.spacing, strict=True):
        yield Labelled(axis, (axis,), np.arange(points) * step, {"units": "m"})
    for name, kind in KEPT_FIELDS.items():
        if members.kept(level, name) == kept:
            stored = Stored(kept, partial(read, name=name), grid.shape)
            yield Labelled(
                name + end, axes, stored, {"units": kind.unit, "description": kind.description}
            )
    fastest = max(members.speeds)
    if fastest > 0.0 and level in map(numerics.picture, numerics.columns):
        words = f"above the mean of the cell, at the highest speed, {fastest:g} m/s, with the share of the heat used"
        stored = Stored(kept, partial(read, name="temperature", speed=fastest), grid.shape)
        yield Labelled(
            f"temperature{end}",
            axes,
            stored,
            {"units": "K", "description": words, "speed": fastest},
        )


def attributes_of(members: Members) -> dict[str, Any]:
    """Return title, scene, numerics, seed and versions of a run, as files and datasets carry them."""
    # of the packages that computed the first member; one that is damaged and skipped has none
    scene = members.scene
    versions = next(
        found for member in members.values() if (found := member.provenance.get("versions"))
    )
    return {
        "title": scene.title or members.folder.resolve().name,
        "source": f"roughsim {versions['roughsim']}",
        "scene": scene.to_toml(),
        "numerics": json.dumps(members.numerics.to_dict()),
        "seed": scene.ensemble.seed,
        "versions": json.dumps(versions),
    }


def lazily_read(array: Labelled) -> Labelled:
    """Return an array for `to_dataset`, which reads a stored field when it is used."""
    if not isinstance(array.data, Stored):
        return array
    return array._replace(data=import_module("roughsim.results.unread").lazy(array.data))
