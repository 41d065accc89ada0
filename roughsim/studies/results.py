"""The results of a study: the runs of its points, and their values with errors as rows."""

from collections.abc import Iterator
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from roughsim.observables.catalogue import UNITS
from roughsim.results.answers import NOTE, TAIL, UNKNOWN, answers
from roughsim.results.arrays import Labelled
from roughsim.results.description import folder_state
from roughsim.results.folder import open_run
from roughsim.results.reactions import ABOUT, asked_names
from roughsim.results.run import Run
from roughsim.show.remarks import of_several
from roughsim.studies.folder import Description, read, refuse_other_scene
from roughsim.studies.vary import Point, short_names

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
        self._answers: dict[
            str, dict[str, Labelled]
        ] = {}  # of a point; the two theories take .1 s each

    @property
    def keys(self) -> dict[str, str]:
        """The varied keys, and their names in tables."""
        return short_names([key for axis in self.axes for key in axis.keys])

    @property
    def numeric_keys(self) -> list[str]:
        """The first key of each axis with numbers as values."""
        keys = []
        for axis in self.axes:
            if all(isinstance(row[0], (int, float)) for row in axis.values):
                keys.append(axis.keys[0])
        return keys

    @property
    def shape(self) -> tuple[int, ...]:
        """The number of values of each axis."""
        return tuple(len(axis.values) for axis in self.axes)

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
            parts = {}
            for part in _LIMITS:
                if part in estimate.budget:
                    parts[part] = float(
                        np.nanmax(estimate.budget[part][hot] / estimate.mean[hot], initial=0.0)
                    )
            worst = max(parts, key=parts.__getitem__)
            if parts[worst] > (self.target_error or run.until.get("flash_temperature", inf)):
                result[point.name] = worst, parts[worst]
        return result

    @property
    def column(self) -> str:
        """The simulated column of tables: capped, or elastic if no point has a hardness."""
        columns = [run.column(None) for _, run in self.results]
        return "capped" if "capped" in columns or not columns else columns[0]

    def common_speeds(self) -> list[float] | None:
        """Return the common speeds of all points; None if each has its own single speed. ValueError for other lists."""
        lists = {run.scene.speeds for _, run in self.results}
        if len(lists) == 1:
            return list(lists.pop())
        if all(len(speeds) == 1 for speeds in lists):
            return None
        raise ValueError(
            "the points have lists of different speeds, which make no array; use the tidy table"
        )

    def answers(self, point: Point, run: Run, observables: list[str]) -> dict[str, Labelled]:
        """Return observables of a point as arrays over column and speed, by their names; reactions as of a run."""
        table = self._answers.setdefault(point.name, {})
        missing = [name for name in observables if name not in table]
        if missing:
            table |= {array.name: array for array in answers(run, missing)}
        return table

    def rows(self, observable: str | None = None) -> Iterator[dict[str, Any]]:
        """Yield the tidy table: a row for each point, observable (or a single one), column and speed, in SI.

        `speed` is None for an observable without speeds. `total_error` is the 95 % error, NaN for the theory; `unknown`
        lists its unknown parts, as "bandwidth, pixel". `note` is "at q_c" for a value that is not extrapolated in the
        cut-off, "identity" for a value fixed by force balance, or "". Temperatures include the heat share used. Rows of
        a reaction have its `energy`, eV, and rows of the heat above a temperature this `temperature`, absolute, K.
        """
        for point, run in self.results:
            known = (*run.observables, *asked_names(run.scene))
            names = [name for name in known if observable in (None, name)]
            head: dict[str, Any] = {"point": point.name}
            head |= {self.keys[key]: value for key, value in point.values.items()}
            table = self.answers(point, run, names)
            for name in names:
                for row in rows_of_run(run, table, name):
                    yield head | row


def rows_of_run(run: Run, table: dict[str, Labelled], name: str) -> Iterator[dict[str, Any]]:
    """Yield a row for each value of an observable of a run, or of a reaction or the heat above a temperature."""
    axes, columns = table[name].axes, table["column"].data.tolist()
    speeds = run.scene.speeds if "speed" in axes else (None,)
    numbers = table[axes[1]].data.tolist() if name in ABOUT else [None]
    shape = len(columns), len(numbers), len(speeds)
    value, error, unknown, note = (
        table[name + tail].data.reshape(shape) for tail in ("", TAIL, UNKNOWN, NOTE)
    )
    for i, j, k in np.ndindex(shape):
        if np.isnan(value[i, j, k]):
            continue
        yield {
            "observable": name,
            "unit": UNITS[name],
            "column": columns[i],
            "speed": speeds[k],
            **({ABOUT[name]: numbers[j]} if name in ABOUT else {}),
            "value": float(value[i, j, k]),
            "total_error": float(error[i, j, k]),
            "unknown": str(unknown[i, j, k]),
            "note": str(note[i, j, k]),
            "realizations": run.realizations,
        }
