"""`Study`: the folder of a study, its runs, and its results as a tidy table and as arrays."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughsim.show.frame import data_frame
from roughsim.show.markup import in_notebook
from roughsim.studies.figure import draw_study, usual_choice
from roughsim.studies.files import save_study, study_dict, study_results
from roughsim.studies.results import StudyResults
from roughsim.studies.tables import study_table
from roughsim.studies.trends import trends_of

if TYPE_CHECKING:  # matplotlib is slow to import
    from roughsim.charts.style import Look


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
        return study_dict(self)

    def to_dataframe(self) -> Any:
        """Return the tidy table as a `pandas.DataFrame`; ImportError without pandas."""
        return data_frame(list(self.rows()))

    def to_xarray(self) -> Any:
        """Return every observable with its error over the varied keys, the column and the speed, as a Dataset.

        ImportError without xarray; ValueError if no point has a result, or the points have lists of other speeds.
        """
        return study_results(self).to_xarray()

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

        Parameters
        ----------
        path : str or Path
            .csv, .json and .parquet (with pandas and pyarrow) hold the tidy table; .h5 and .nc are netCDF-4 for xarray,
            with every observable over the varied keys, the column and the speed. Returned.

        ValueError for another ending, or if the points do not make arrays.
        """
        return save_study(self, Path(path))

    def chart(self, path: str | Path, observable: str = "flash_temperature") -> None:
        """Draw an observable over the first varied number, and as a map over the first two.

        Without a varied number it is drawn over the speed. Other keys have their first values, named in the title.

        Parameters
        ----------
        path : str or Path
            Of the picture: .png, .pdf or .svg.
        observable : str, optional
            One of the observables of `roughsim.observables.catalogue.OBSERVABLES`.

        ValueError for another ending or observable, or without results.
        """
        self.draw(Path(path), observable)

    def draw(
        self, path: Path, observable: str, *, over: str | None = None, look: "Look | None" = None
    ) -> None:
        """Draw as `chart`, over the speed or a varied number by name; `roughsim.plot` calls it.

        `look` has the size and the colours of the figure, by default those of `chart`.
        ValueError if `over` is no axis of the study.
        """
        draw_study(self, usual_choice(self, observable, over), path, look)


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
