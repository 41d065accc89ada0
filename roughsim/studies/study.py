"""`Study`: the folder of a study, its runs, and its results as a tidy table, as arrays, and as files."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from roughsim.results.export import ENDINGS
from roughsim.results.table import Results
from roughsim.show.frame import TABLES, data_frame, table_bytes
from roughsim.show.markup import in_notebook
from roughsim.show.table import json_value
from roughsim.store.disk import place_bytes
from roughsim.store.member_files import write_sealed
from roughsim.studies.figure import draw_study, usual_choice
from roughsim.studies.results import StudyResults
from roughsim.studies.tables import study_table
from roughsim.studies.trends import trends_of
from roughsim.studies.vary import plain_value


class Study(StudyResults):
    """The folder of a study; made by `roughsim.study` and `roughsim.open_study`.

    Attributes
    ----------
    folder : Path
        Path of the folder.
    scene : Scene
        The base scene of all points.
    axes : tuple of Axis
        The varied keys, with their values in SI.
    points : tuple of Point
        Grid of the axes, the last axis varying fastest: `name` of the folder in points/, and `values` of the keys.
    target_error : float or None
        Target for the relative total error of T_flash; None: the targets of the scene.
    """

    def reread(self) -> "Study":
        """Return the present state of the study; finished points are not read again."""
        again = Study(self.folder)
        for point, run in self.results:
            if run.finished:
                again._runs[point.name] = run
                if point.name in self._tables:
                    again._tables[point.name] = self._tables[point.name]
        return again

    def to_dict(self) -> dict[str, Any]:
        """Return the study as JSON values: keys, number of finished points, the tidy table, and trends of T_flash."""
        return {
            "folder": str(self.folder),
            "target_error": self.target_error,
            "points": len(self.points),
            "finished": self.finished,
            "keys": {name: {"key": key} for key, name in self.keys.items()},
            "rows": json_value([*self.rows()]),
            "scene_warnings": self.warnings,
            "trends": json_value([*self.trends()]),
        }

    def to_dataframe(self) -> Any:
        """Return the tidy table as a `pandas.DataFrame`; ImportError without pandas."""
        return data_frame(list(self.rows()))

    def to_xarray(self) -> Any:
        """Return every observable with its error over the varied keys, the column and the speed, as a Dataset.

        ImportError without xarray; ValueError if no point has a result, or the points have lists of other speeds.
        """
        return self._described().to_xarray()

    def _described(self) -> Results:
        """Return `table` with title, scene, and a description of its arrays; ValueError without results."""
        table = self.table()
        if not table:
            raise ValueError(f"{self.folder} has no point with results yet; let it run first")
        columns = "theory, calibrated (the theory with a fitted stress spectrum), and the simulated columns"
        readme = (
            f"A study by roughsim: {self.scene.title}. Units are SI. Each observable is an array over the varied keys, "
            f"the column it comes from ({columns}), and the speed if it depends on it. NAME_part are the parts of its 95 % "
            "error, and NAME_note marks values that are not extrapolated (at q_c) or fixed by force balance (identity). "
            "NaN: not computed yet, or not defined."
        )
        title, scene = self.scene.title or self.folder.name, self.scene.to_toml()
        return replace(table, attrs={"title": title, "README": readme, "scene": scene})

    def trends(
        self, observable: str = "flash_temperature", column: str | None = None
    ) -> Iterator[dict[str, Any]]:
        """Yield the changes of an observable between neighbours along each varied number, all else the same.

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
            `exponent` n of observable ∝ keyⁿ between them. Both points have the same surfaces: `standard_error` is that
            of pairs, far less than the scatter of each. `total_error` adds all other parts of both (95 %) but
            those in `unknown`. The exponent is NaN between values of different kind: one extrapolated and the other
            not, or with other unknown parts of their errors. Neighbours with other levels or another seed make no
            pairs, and are left out.
        """
        return trends_of(self, observable, column)

    def __repr__(self) -> str:
        return f"<Study {self.folder}: {self.finished} of {len(self.points)} points finished; {', '.join(self.keys)}>"

    def __str__(self) -> str:
        return str(study_table(self))

    def _repr_html_(self) -> str:
        return in_notebook(study_table(self))

    def save(self, path: str | Path) -> Path:
        """Write the results into one file.

        ValueError for another ending, or if the points do not make arrays.

        Parameters
        ----------
        path : str or Path
            .csv, .json and .parquet (with pandas and pyarrow) hold the tidy table; .h5 and .nc are netCDF-4 for xarray,
            with every observable over the varied keys, the column and the speed. Returned.
        """
        path = Path(path)
        ending = path.suffix.lower()
        if ending not in (*TABLES, *ENDINGS):
            raise ValueError(f"path = {str(path)!r} must end in {', '.join((*TABLES, *ENDINGS))}")
        path.parent.mkdir(parents=True, exist_ok=True)
        if ending in TABLES:
            rows = list(self.rows())
            for name in self.keys.values():
                # one type of value in each column; lists and tables as in a scene file
                if not all(isinstance(row[name], (int, float)) for row in rows):
                    rows = [row | {name: str(plain_value(row[name]))} for row in rows]
            place_bytes(path, table_bytes(ending, rows, self.to_dict, ["point"]))
            return path
        results = self._described()

        def fill(file: Any) -> None:
            from roughsim.store.hdf5 import write_arrays  # loads h5py

            file.attrs.update(results.attrs)
            write_arrays(file, results.arrays())

        write_sealed(path, fill)
        return path

    def chart(self, path: str | Path, observable: str = "flash_temperature") -> None:
        """Draw an observable over the first varied number, and as a map over the first two.

        Without a varied number it is drawn over the speed. Other keys have their first values, named in the title.

        ValueError for another ending or observable, or without results.

        Parameters
        ----------
        path : str or Path
            Of the picture: .png, .pdf or .svg.
        observable : str, optional
            One of the observables of `roughsim.observables.catalogue.OBSERVABLES`.
        """
        draw_study(self, usual_choice(self, observable), Path(path))


def open_study(folder: str | Path) -> Study:
    """Open the folder of a study for reading, also while processes compute it.

    Parameters
    ----------
    folder : str or Path
        Folder of the study.

    Returns
    -------
    Study
        The study as it is now.

    Raises
    ------
    RecordError
        If it is no study, or its study.json is damaged; while reading results, if a point holds another scene.
    """
    return Study(folder)
