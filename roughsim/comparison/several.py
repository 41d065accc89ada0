"""`Comparisons`: several runs with the theory, side by side in one table and one figure."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Any

from roughsim.comparison.compare import Comparison, numbers_of
from roughsim.estimate.levels import FLASH
from roughsim.results.folder import left_out
from roughsim.results.row import Row
from roughsim.results.theories import THEORIES
from roughsim.show.frame import data_frame
from roughsim.show.markup import in_notebook
from roughsim.show.remarks import of_several
from roughsim.show.table import Column, Table, with_unit
from roughsim.show.text import marked
from roughsim.table import marks_in_words


@dataclass(frozen=True, slots=True, repr=False)
class Comparisons:
    """The comparisons of several runs.

    Attributes
    ----------
    labels : sequence of str
        A name for each run.
    comparisons : sequence of Comparison
        The comparison of each run.
    """

    labels: Sequence[str]
    comparisons: Sequence[Comparison]

    def __repr__(self) -> str:
        return f"<Comparisons of {', '.join(self.labels)}>"

    def __iter__(self) -> Any:
        return iter(self.comparisons)

    @property
    def _labelled(self) -> list[tuple[str, Comparison]]:
        """Each comparison with its label."""
        return list(zip(self.labels, self.comparisons, strict=True))

    def to_dict(self) -> dict[str, Any]:
        """Return the comparison of each run as JSON values, with its label and folder."""
        runs = [
            {"run": label, "folder": str(one.run.folder)} | one.to_dict()
            for label, one in self._labelled
        ]
        return {"runs": runs}

    def to_dataframe(self) -> Any:
        """Return the rows of all runs as a `pandas.DataFrame`, as `Comparison.to_dataframe`, with a column `run`.

        ImportError without pandas.
        """
        rows = [
            {"run": label} | row.to_flat_dict() for label, one in self._labelled for row in one.rows
        ]
        return data_frame(rows, "observable")

    def table(self, observables: Sequence[str] | None = (FLASH,)) -> Table:
        """Return observables of all runs, a row for each speed and run; None: all observables."""
        all_rows = [row for one in self.comparisons for row in one.rows]
        shown = [row for row in all_rows if observables is None or row.observable in observables]
        chosen = list(dict.fromkeys(row.title for row in shown))
        columns = list(
            dict.fromkeys(name for one in self.comparisons for name in one.rows[0].columns)
        )
        titles = [Column("observable", name=True)] if len(chosen) > 1 else []
        heads = {"speed, m/s", *(title for row in shown for title in row.heads)}
        turned = sorted(heads, reverse=True)  # direction after speed
        titles += [Column(title, name=True) for title in (*turned, "run")]
        titles += [Column(title, number=True) for title in (*THEORIES, *columns)]
        rows = []
        for name in chosen:
            for label, row in self._rows_of(name):
                head = [with_unit(name, row.unit)] if len(chosen) > 1 else []
                places = (row.heads.get(each, "") for each in turned)
                rows.append([*head, *places, label, *numbers_of(row, columns)])
        title = with_unit(chosen[0], *{row.unit for row in shown}) if len(chosen) == 1 else ""
        return Table(titles, rows, title, self._notes(shown), sum(c.name for c in titles))

    def _rows_of(self, title: str) -> list[tuple[str, Row]]:
        """Return the rows of an observable with the labels of their runs, by speed, then by direction."""
        rows = [(label, row) for label, one in self._labelled for row in one.rows]
        own = [(label, row) for label, row in rows if row.title == title]
        return sorted(
            own, key=lambda each: (each[1].speed or 0.0, each[1].about.get("direction", -inf))
        )

    def _notes(self, rows: Sequence[Row]) -> list[str]:
        """Return the sentences below the table of some rows."""
        unknown = dict.fromkeys(part for row in rows for part in row.unknown)
        notes = [
            "± total error, 95 %; each with the heat share of its run.",
            *marks_in_words(list(unknown), set()),
        ]
        for label, one in self._labelled:
            notes += [f"{label}: {line}" for line in left_out(one.run)]
        remarks = {label: one.run.remarks for label, one in self._labelled}
        return notes + marked(of_several(remarks))

    def __str__(self) -> str:
        return str(self.table())

    def _repr_html_(self) -> str:
        return in_notebook(self.table())

    def chart(self, path: str | Path | None, *, csv: str | Path | None = None) -> None:
        """Draw C(q) and C_sm(q), g_σ(r), T_flash(v), D_flash(v) and d_flash(v) of all runs in one figure.

        `path` ends in .png, .pdf or .svg, `csv`, a file for the numbers drawn, in .csv. ValueError if not.
        """
        from roughsim.charts.curves import Entry, curves_chart  # matplotlib is slow to import
        from roughsim.charts.style import Look

        entries = [
            Entry(label, one.run.scene, one.run, one.results) for label, one in self._labelled
        ]
        curves_chart(path, entries, look=Look(csv=csv))
