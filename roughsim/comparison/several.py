"""`Comparisons`: several runs with the theory, side by side in one table and one figure."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Any

from roughsim.comparison.compare import Comparison
from roughsim.estimate.levels import FLASH
from roughsim.results.folder import left_out
from roughsim.results.row import Row
from roughsim.show.frame import data_frame
from roughsim.show.markup import in_notebook
from roughsim.show.remarks import of_several
from roughsim.show.table import Table, table_of, with_unit
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
        shown = [
            (label, row)
            for label, one in self._labelled
            for row in one.rows
            if observables is None or row.observable in observables
        ]
        chosen = list(dict.fromkeys(row.title for _, row in shown))
        titles = {"speed, m/s", *(title for _, row in shown for title in row.heads)}
        turned = sorted(titles, reverse=True)  # direction after speed

        def order(each: tuple[str, Row]) -> tuple[float, ...]:
            row = each[1]
            return chosen.index(row.title), row.speed or 0.0, row.about.get("direction", -inf)

        rows = []
        for label, row in sorted(shown, key=order):
            cells = {"observable": with_unit(row.title, row.unit)} if len(chosen) > 1 else {}
            heads = {title: row.heads.get(title, "") for title in turned}
            rows.append(cells | heads | {"run": label} | row.numbers)
        title = with_unit(chosen[0], shown[0][1].unit) if len(chosen) == 1 else ""
        notes = self._notes([row for _, row in shown])
        return table_of(rows, title, notes, names=("observable", *turned, "run"))

    def _notes(self, rows: Sequence[Row]) -> list[str]:
        """Return the sentences below the table of some rows."""
        simulated = (one for row in rows for one in row.columns.values())
        notes = [
            "± total error, 95 %; each with the heat share of its run.",
            *marks_in_words(simulated),
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
