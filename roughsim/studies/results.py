"""The results of a study: the runs of its points, and their values with errors as rows."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from roughsim.results.columns import estimated_columns, observables_of, results_of
from roughsim.results.description import folder_state
from roughsim.results.folder import open_run
from roughsim.results.run import Run
from roughsim.results.table import Results
from roughsim.show.remarks import of_several
from roughsim.studies.folder import Description, read, refuse_other_scene
from roughsim.studies.vary import Point, key_quantity, plain_value, short_names
from roughsim.table import Estimate, concat

SPEED = "speed"  # axis of the results
LATER = "levels of the study"  # choice of the reason of a point that came later and has the levels of the others
_LIMITS = (
    "bandwidth",
    "last step",
    "pixel",
    "size",
)  # parts of an error that more realizations do not lower


class StudyResults:
    """The points of a study with their runs and results; `Study` describes the attributes."""

    def __init__(self, folder: str | Path, description: Description | None = None):
        self.folder = Path(folder)
        description = description or read(self.folder)
        self.scene = description.scene
        self.axes = description.axes
        self.points = description.points
        self.target_error = description.target_error
        self._description = description
        self._runs: dict[str, Run | None] = {}
        self._tables: dict[str, dict[str, Estimate]] = {}  # of a point; the theories take .1 s each

    @property
    def keys(self) -> dict[str, str]:
        """The varied keys, and their names in tables."""
        return short_names([key for axis in self.axes for key in axis.keys])

    def full(self, name: str) -> str:
        """Return a varied key by its name in tables; another name unchanged."""
        return next((key for key, short in self.keys.items() if short == name), name)

    def values_of(self, name: str) -> dict[str, Any]:
        """Return the values of a varied key, by its name in tables, by their texts; none for another name."""
        key = self.full(name)
        values = (point.values[key] for point in self.points if key in point.values)
        return {str(value): value for value in values}

    @property
    def numeric_keys(self) -> list[str]:
        """The first key of each axis with numbers as values."""
        keys = []
        for axis in self.axes:
            if all(isinstance(row[0], (int, float)) for row in axis.values):
                keys.append(axis.keys[0])
        return keys

    def run(self, point: Point) -> Run | None:
        """Return the run of a point; None before it begins. RecordError if its folder holds another scene."""
        if point.name not in self._runs:
            path = self.folder / "points" / point.name
            run = open_run(path) if folder_state(path) == "run" else None
            if run is not None:
                refuse_other_scene(path, run.scene.identity(), point, self._description)
            self._runs[point.name] = run
        return self._runs[point.name]

    @property
    def runs(self) -> list[tuple[Point, Run]]:
        """The points that have begun, with their runs."""
        runs = ((point, self.run(point)) for point in self.points)
        return [(point, run) for point, run in runs if run is not None]

    @property
    def results(self) -> list[tuple[Point, Run]]:
        """The points with at least two sound realizations, with their runs."""
        return [(point, run) for point, run in self.runs if run.independent > 1]

    @property
    def finished(self) -> int:
        """The number of points that have ended: target met, out of reach, or with all realizations."""
        return sum(run.finished for _, run in self.results)

    @property
    def warnings(self) -> list[str]:
        """The warnings of the points that have begun."""
        return list(map(str, of_several({point.name: run.remarks for point, run in self.runs})))

    @property
    def later(self) -> list[str]:
        """Names of the points that came later and have the levels planned for others."""
        return [
            point.name
            for point, run in self.runs
            if any(reason.quantity == LATER for reason in run.reasons)
        ]

    def misfits(self) -> dict[str, tuple[str, float]]:
        """Return the points with unsuitable levels or cell, with the largest relative part of the error.

        The part is bandwidth, last step, pixel or size of T_flash at the worst speed, and exceeds the error asked for:
        `target_error`, or else the target of the point.
        """
        result: dict[str, tuple[str, float]] = {}
        for point, run in self.results:
            estimate = run.estimate("flash_temperature")
            hot = estimate.mean > 0.0
            parts = {
                name: float(np.nanmax(part[hot] / estimate.mean[hot], initial=0.0))
                for name, part in estimate.budget.items()
                if name in _LIMITS
            }
            worst = max(parts, key=parts.__getitem__)
            if parts[worst] > (self.target_error or run.until.get("flash_temperature", inf)):
                result[point.name] = worst, parts[worst]
        return result

    @property
    def _directions(self) -> tuple[float, ...]:
        """Directions of all points, radians, in which isotropic faces have the same results; none if it is varied."""
        each = (angle for _, run in self.results for angle in run.scene.directions)
        return () if "sliding.direction" in self.keys else tuple(dict.fromkeys(each))

    @property
    def column(self) -> str:
        """The simulated column of tables: capped, or elastic if no point has a hardness."""
        columns = [run.column(None) for _, run in self.results]
        return "capped" if "capped" in columns or not columns else columns[0]

    def results_at(self, point: Point, run: Run, observables: Sequence[str]) -> Results:
        """Return observables of a point in the theories of all of C(q) and the simulated columns.

        An isotropic face has the directions of the others. Where the direction is varied, it is no axis of the point.
        """
        known = self._tables.setdefault(point.name, {})
        missing = [name for name in observables if name not in known]
        if missing:
            found = results_of(run, missing, estimated_columns(run))
            own = run.scene.directions
            if "sliding.direction" in self.keys and len(own) == 1:
                found = found.sel(direction=own[0])
            known |= {
                name: one.by_direction(self._directions, alike=True) for name, one in found.items()
            }
        return Results({name: known[name] for name in observables if name in known})

    def table(
        self, observables: Sequence[str] | None = None, *, highest_speed: bool = False
    ) -> Results:
        """Return observables, by default those of all points, over the column, the varied keys, and the speed.

        With `highest_speed` each point has its highest speed alone, and there is no axis of the speed; so it is if each
        has a single speed of its own. An axis of several keys has the first as its coordinate, the others beside it.
        Entries in a column are in the order of `points`; those without a result are NaN.
        """
        speeds = {run.scene.speeds for _, run in self.results}
        highest_speed |= len(speeds) > 1 and all(len(each) == 1 for each in speeds)
        tables = {}
        for point, run in self.results:
            names = observables_of(run) if observables is None else observables
            found = dict(self.results_at(point, run, names))
            if highest_speed:
                found = {
                    name: one.sel(speed=max(one.coords["speed"])) for name, one in found.items()
                }
            tables[point.place] = found
        coords, about, along = self._labels()
        joined = {}
        for name in dict.fromkeys(name for table in tables.values() for name in table):
            pieces = {place: table[name] for place, table in tables.items() if name in table}
            if observables is not None or len(pieces) == len(tables):
                joined[name] = concat(pieces, coords)
        known = {name: one for name, one in joined.items() if not np.isnan(one.mean).all()}
        return Results(known, {}, about, along)

    def view(
        self, observable: str, free: Collection[str], fixed: Mapping[str, Any]
    ) -> Estimate | None:
        """Return an observable at the `fixed` values of keys and other axes, by their names; None without a value.

        It is NaN at all other points. Of an axis of its own that is neither fixed nor in `free`, each point has one
        label: the highest speed, or else the first label.
        """
        pieces, keys = {}, self.keys
        for point, run in self.results:
            values = {keys[key]: value for key, value in point.values.items()}
            if any(values.get(name, value) != value for name, value in fixed.items()):
                continue
            names = [observable] if observable in observables_of(run) else []
            for found in self.results_at(point, run, names).values():
                one, chosen = found.without_no_speed(), {}
                if np.isnan(one.mean).all():
                    continue
                for dim in {*one.dims} - {"column", *free}:
                    labels = one.known(dim)
                    at = max(labels) if dim == SPEED else labels[0]
                    chosen[dim] = labels[labels == fixed.get(dim, at)]
                if all(len(labels) for labels in chosen.values()):
                    pieces[point.place] = one.sel(**chosen)
        return concat(pieces, self._labels()[0]) if pieces else None

    def _labels(self) -> tuple[dict[str, Any], dict[str, Any], dict[str, Any]]:
        """Return the labels of the axes, their attributes, and the labels of keys beside the first ones."""
        coords, about, along = {}, {}, {}
        for axis in self.axes:
            first = self.keys[axis.keys[0]]
            for i, key in enumerate(axis.keys):
                name, values = (
                    self.keys[key],
                    np.array([plain_value(row[i]) for row in axis.values]),
                )
                number = key_quantity(key)
                known = number is not None and values.dtype.kind != "U"
                about[name] = {"key": key} | (
                    {"units": number.unit or "1"} if number and known else {}
                )
                if i == 0:
                    coords[name] = values
                else:
                    along[name] = (first, values)
        return coords, about, along

    def rows(self, observable: str | None = None) -> Iterator[dict[str, Any]]:
        """Yield the tidy table: a row for each point, observable (or a single one), column and speed, in SI.

        `speed` is None for an observable without speeds. `total_error` is the 95 % error, NaN for the theory; `unknown`
        lists its unknown parts, as "bandwidth, pixel". `note` is "at q_c" for a value that is not extrapolated in the
        cut-off, "identity" for a value fixed by force balance, or "". Temperatures include the heat share used. Rows of
        a reaction have its `energy`, eV, and rows of the heat above a temperature this `temperature`, absolute, K.
        """
        for point, run in self.results:
            names = [name for name in observables_of(run) if observable in (None, name)]
            head: dict[str, Any] = {"point": point.name}
            head |= {self.keys[key]: value for key, value in point.values.items()}
            for row in self.results_at(point, run, names).rows():
                yield head | row | {"realizations": run.realizations}
