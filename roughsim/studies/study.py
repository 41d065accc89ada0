"""`Study`: the folder of a study as it stands, its runs, and its results as one tidy table and as arrays."""

from collections.abc import Iterator
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from roughsim.observables.catalogue import OBSERVABLES
from roughsim.results.answers import NOTE, TAIL, UNKNOWN, answers
from roughsim.results.arrays import Labelled
from roughsim.results.folder import folder_state, open_run
from roughsim.results.run import Run
from roughsim.show.frame import data_frame
from roughsim.show.markup import in_notebook
from roughsim.show.table import json_value
from roughsim.show.terminal import table_text
from roughsim.studies.folder import Description, read, refuse_other_scene
from roughsim.studies.tables import dataset, draw_study, save_study, study_table
from roughsim.studies.trends import trends_of
from roughsim.studies.vary import Point, short_names

LATER = "levels of the study"  # choice of the reason of a point that came later and has the levels of the others
LIMITS = ("bandwidth", "last step", "pixel", "size")  # parts of an error that more realizations leave as they are


class Study:
    """The folder of a study; made by `roughsim.study` and `roughsim.open_study`.

    Attributes
    ----------
    folder : Path
        Where it is.
    scene : Scene
        What is varied.
    axes : tuple of Axis
        The varied keys, with their values in SI.
    points : tuple of Point
        Their grid, the last axis varying fastest: `name` is that of a folder in points/, `values` are those of the
        keys.
    target_error : float or None
        Relative total error of T_flash that was asked for; None: the targets of the scene.
    """

    def __init__(self, folder: str | Path, description: Description | None = None):
        self.folder = Path(folder)
        description = description or read(self.folder)
        self.scene, self.axes, self.points = description.scene, description.axes, description.points
        self.target_error = description.target_error
        self._description = description
        self._runs: dict[str, Run | None] = {}
        self._tables: dict[str, dict[str, Labelled]] = {}

    @property
    def keys(self) -> dict[str, str]:
        """The varied keys, and their names in tables."""
        return short_names([key for axis in self.axes for key in axis.keys])

    def run(self, point: Point) -> Run | None:
        """Return the run of a point; None if it was not begun. RecordError if its folder holds another scene."""
        if point.name not in self._runs:
            path = self.folder / "points" / point.name
            run = open_run(path) if folder_state(path) == "run" else None
            if run is not None:
                refuse_other_scene(path, run.scene.identity(), point, self._description)
            self._runs[point.name] = run
        return self._runs[point.name]

    @property
    def results(self) -> list[tuple[Point, Run]]:
        """The points that have at least two sound realizations, with their runs."""
        runs = ((point, self.run(point)) for point in self.points)
        return [(point, run) for point, run in runs if run is not None and run.independent > 1]

    @property
    def finished(self) -> int:
        """How many points have ended: with their targets met, out of reach, or with all realizations."""
        return sum(run.finished for _, run in self.results)

    def reread(self) -> "Study":
        """Return the study as it stands now; the points that have finished are not read again."""
        again = Study(self.folder)
        for _, run in self.results:
            if run.finished:
                again._runs[run.folder.name] = run
        again._tables = {name: table for name, table in self._tables.items() if name in again._runs}
        return again

    @property
    def later(self) -> list[str]:
        """Names of the points that came later, and have the levels that were planned for others."""
        runs = ((point.name, self.run(point)) for point in self.points)
        return [name for name, run in runs if run is not None and any(reason[0] == LATER for reason in run.reasons)]

    def misfits(self) -> dict[str, tuple[str, float]]:
        """Return the points whose levels or cell do not suit them: the largest part of the error of each, relative.

        That is one of `LIMITS` of T_flash at the worst speed, where it exceeds what was asked for: `target_error`, or
        else the target of the point.
        """
        result: dict[str, tuple[str, float]] = {}
        for point, run in self.results:
            estimate = run.estimate("flash_temperature")
            hot = estimate.mean > 0.0
            limit = self.target_error or run.until.get("flash_temperature", inf)
            parts = {
                part: float(np.nanmax(estimate.budget[part][hot] / estimate.mean[hot], initial=0.0))
                for part in LIMITS
                if part in estimate.budget
            }
            worst = max(parts, key=parts.__getitem__)
            if parts[worst] > limit:
                result[point.name] = worst, parts[worst]
        return result

    @property
    def shape(self) -> tuple[int, ...]:
        """How many values each axis has."""
        return tuple(len(axis.values) for axis in self.axes)

    @property
    def column(self) -> str:
        """The simulated column that tables show: capped, or elastic where no point has a hardness."""
        columns = [run.column(None) for _, run in self.results]
        return "capped" if "capped" in columns or not columns else columns[0]

    def common_speeds(self) -> list[float] | None:
        """Return the speeds that all points have; None where each has one of its own. ValueError for other lists."""
        lists = list(dict.fromkeys(run.scene.speeds for _, run in self.results))
        if len(lists) == 1:
            return list(lists[0])
        if all(len(speeds) == 1 for speeds in lists):
            return None
        raise ValueError("the points have lists of different speeds, which make no array; use the tidy table")

    def rows(self, observable: str | None = None) -> Iterator[dict[str, Any]]:
        """Yield the tidy table: a row for each point, observable (or one alone), column and speed, in SI.

        `speed` is None where an observable has none. `total_error` is that of 95 %, NaN where there is none, as of the
        theory; `unknown` names the parts that it lacks, as "bandwidth, pixel", and is "" where it is whole. `note` is
        "at q_c" where the value is not extrapolated in the cut-off, "identity" where force balance fixes it, or "".
        Temperatures are those of the heat share used.
        """
        for point, run in self.results:
            values = {"point": point.name} | {self.keys[key]: value for key, value in point.values.items()}
            names = [name for name in OBSERVABLES if observable in (None, name)]
            tables = self._answers(point, run, names)
            columns = tables["column"].data.tolist()
            for name in names:
                record = OBSERVABLES[name]
                parts = [tables[name + tail].data for tail in ("", TAIL, UNKNOWN, NOTE)]
                for i, column in enumerate(columns):
                    entries = (np.atleast_1d(part[i]) for part in parts)
                    for k, (mean, error, unknown, note) in enumerate(zip(*entries, strict=True)):
                        if np.isnan(mean):
                            continue
                        yield values | {
                            "observable": name,
                            "unit": record.unit,
                            "column": column,
                            "speed": run.scene.speeds[k] if record.per_speed else None,
                            "value": float(mean),
                            "total_error": float(error),
                            "unknown": str(unknown),
                            "note": str(note),
                            "realizations": run.realizations,
                        }

    def _answers(self, point: Point, run: Run, observables: list[str]) -> dict[str, Labelled]:
        """The answers of a point by their names, with these observables; computed once."""
        table = self._tables.setdefault(point.name, {})
        missing = [name for name in observables if name not in table]
        if missing or not table:
            table |= {array.name: array for array in answers(run, missing)}
        return table

    def to_dict(self) -> dict[str, Any]:
        """Return the study as JSON values: its keys, how far it is, the tidy table, and the trends of T_flash."""
        return {
            "folder": str(self.folder),
            "target_error": self.target_error,
            "points": len(self.points),
            "finished": self.finished,
            "keys": {name: {"key": key} for key, name in self.keys.items()},
            "rows": [json_value(row) for row in self.rows()],
            "trends": [json_value(trend) for trend in self.trends()],
        }

    def to_dataframe(self) -> Any:
        """Return the tidy table as a `pandas.DataFrame`; ImportError without pandas."""
        return data_frame(list(self.rows()))

    def trends(self, observable: str = "flash_temperature", column: str | None = None) -> Iterator[dict[str, Any]]:
        """Go through the changes of an observable between neighbours along each varied number, all else the same.

        Parameters
        ----------
        observable : str, optional
            One of the observables of `roughsim.observables.catalogue.OBSERVABLES`.
        column : str, optional
            As of `Run.estimate`.

        Returns
        -------
        iterator of dict
            The point and the one `before` it along `key`, the `speed`, the `ratio` of the two with its errors, and the
            `exponent` n of observable ∝ keyⁿ between them. Both points see the same surfaces, so that `standard_error`
            is that of pairs: far less than the scatter of each. `total_error` adds all other parts of both (95 %) but
            those in `unknown`. The exponent is NaN between values of different kind: where one of the two is not
            extrapolated, or lacks a part of its error, and the other does not.
            Neighbours with other levels or another seed make no pairs, and are left out.
        """
        return trends_of(self, observable, column)

    @property
    def numeric_keys(self) -> list[str]:
        """The keys all of whose values are numbers, the first of each axis."""
        firsts = [(axis.keys[0], [row[0] for row in axis.values]) for axis in self.axes]
        return [key for key, values in firsts if all(isinstance(value, (int, float)) for value in values)]

    def __str__(self) -> str:
        return table_text(study_table(self))

    def _repr_html_(self) -> str:
        return in_notebook(study_table(self))

    def to_xarray(self) -> Any:
        """Return every observable with its error over the varied keys, the column and the speed, as a Dataset.

        ImportError without xarray; ValueError if no point has a result, or the points have lists of other speeds.
        """
        return dataset(self)

    def save(self, path: str | Path) -> Path:
        """Write the results into one file.

        Parameters
        ----------
        path : str or Path
            .csv, .json and .parquet (with pandas and pyarrow) hold the tidy table; .h5 and .nc are netCDF-4 for xarray,
            with every observable over the varied keys, the column and the speed. Returned.

        ValueError for another ending, or if the points do not make arrays.
        """
        return save_study(self, path)

    def chart(self, path: str | Path, observable: str = "flash_temperature") -> None:
        """Draw an observable over the first varied number, and as a map over the first two.

        Other keys have their first values, which the title names.

        Parameters
        ----------
        path : str or Path
            Of the picture: .png, .pdf or .svg.
        observable : str, optional
            One of the observables of `roughsim.observables.catalogue.OBSERVABLES`.

        ValueError for another ending or observable, or if no varied key is a number.
        """
        draw_study(self, Path(path), observable)


def open_study(folder: str | Path) -> Study:
    """Open the folder of a study for reading, also while processes compute it.

    RecordError if it is none, or its study.json is damaged; a reader of results raises it, too, where the folder of a
    point holds another scene.
    """
    return Study(folder)
