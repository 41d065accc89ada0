"""Comparison of theory and simulation in three columns and two ratios.

theory (on C_sm, with the scene's γ) · smoothed (elastic contact of surfaces drawn from C_sm) · capped (contact of the
original surface, p ≤ σ_P). smoothed/theory tests W(q); capped/smoothed tests Eq. (27), without γ. An elastic scene has
theory and elastic. `theory` is over the whole spectrum; the ratio to the theory uses `theory_same_modes`, the sum over
the modes of the simulation.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import degrees, isfinite
from pathlib import Path
from typing import Any

import numpy as np

from roughsim.comparison.camera import meaning_of, pictured
from roughsim.comparison.slope import Slope, stress_slope
from roughsim.comparison.tables import (
    OF_SLIDING,
    asked_of_scene,
    asked_table,
    calibrated_note,
    sliding_note,
)
from roughsim.estimate.levels import FLASH
from roughsim.planning.limits import Plausibility
from roughsim.prediction.sliding import CONTINUED
from roughsim.results.columns import SAME_MODES, UP_TO_CUT_OFF, columns_of, finest, results_of
from roughsim.results.folder import left_out
from roughsim.results.row import NOTICED, Row, rows_of
from roughsim.results.run import Run
from roughsim.results.table import Results
from roughsim.results.theories import (
    CALIBRATED,
    CONTACT_TEMPERATURE,
    SLIDING_CALIBRATED,
    THEORY,
    ColumnOf,
    joined,
)
from roughsim.scene.numerics import SLIDING
from roughsim.show.frame import data_frame
from roughsim.show.markup import in_notebook
from roughsim.show.table import Number, Table, json_value, table_of, with_unit
from roughsim.show.text import marked
from roughsim.table import Estimate, marks_in_words

# what each ratio tests
TESTS = {
    "smoothed_over_theory": "tests the weight W(q) of the theory",
    "capped_over_smoothed": "tests the plastic smoothing, Eq. (27); γ drops out",
    "elastic_over_theory": "tests the weight W(q) of the theory",
    "capped_over_theory": "tests weight and smoothing together: no smoothed surfaces were computed",
}
_MOST_WARNINGS = 3  # of a first screen
_SAME_MODES = "The ratio to theory is over the modes of the cell, up to q_c."


@dataclass(frozen=True, repr=False)
class Comparison:
    """A run beside the theory. Temperatures have the heat share used; ratios do not depend on it.

    Printed, it is `summary()`. ValueError if the run has fewer than two sound realizations: there is no error to
    compare with.

    Attributes
    ----------
    run : Run
        The run.
    columns : mapping of str to callable
        The columns of the run, as functions of an observable.
    results : Results
        Every observable over (column, …, speed), with its error in parts.
    flash : Estimate
        T_flash alone, over (column, …, speed).
    rows : tuple of Row
        `results`, a row for each observable and speed.
    """

    run: Run

    def __post_init__(self) -> None:
        sound = self.run.independent
        if sound < 2:
            raise ValueError(
                f"{self.run.folder} has {sound} sound realizations; a comparison needs at least 2, let it run on"
            )

    @cached_property  # its functions keep what several observables need: T_flash takes .02 s, then .002
    def columns(self) -> Mapping[str, ColumnOf]:
        """The columns of the run, as functions of an observable."""
        return columns_of(self.run)

    @property
    def flash(self) -> Estimate:
        """T_flash alone, over (column, …, speed)."""
        return joined(self.columns, (FLASH,), self.run.scene.directions)[FLASH]

    @cached_property  # .2 s; a summary does without
    def results(self) -> Results:
        """Every observable over the columns, the speed, and the energy, temperature or direction of some."""
        return results_of(self.run, columns=self.columns)

    @cached_property  # its statements are .02 s, and several tables ask for them
    def judged(self) -> Plausibility:
        """Assumptions and warnings of the scene."""
        return self.run.judged

    @cached_property  # 7 ms, up to 184 times in a table of several runs
    def rows(self) -> tuple[Row, ...]:
        """A row for each observable and speed."""
        return tuple(rows_of(self.results))

    def to_xarray(self) -> Any:
        """Return `results` as an `xarray.Dataset`; ImportError without xarray.

        NAME has the values of an observable over (column, …, speed), NAME_part the parts of its 95 % error over
        (part, column, …, speed), NAME_note its marks.
        """
        return self.results.to_xarray()

    @property
    def slopes(self) -> tuple[Slope, ...]:
        """The slope of |σ_q|² of each column with a long enough band."""
        slopes = (stress_slope(self.run, column) for column in self.run.numerics.columns)
        return tuple(slope for slope in slopes if slope is not None)

    def __reduce__(self) -> tuple[Any, ...]:
        return Comparison, (self.run,)  # theories hold functions, which cannot be pickled

    def __repr__(self) -> str:
        return f"<Comparison of {self.run.folder}: {', '.join(self.run.numerics.columns)}>"

    def notes(self) -> tuple[str, ...]:
        """Return notes on missing members, and on waves that only the theory or only the simulation includes."""
        q_c, q_max = finest(self.run)[1], self.run.scene.spectrum.breaks[-1]
        notes = left_out(self.run)
        if cut := self.farthest(UP_TO_CUT_OFF, THEORY):
            notes.append(
                f"C(q) is cut at q_c = {q_c:.3g} rad/m, below q_max = {q_max:.3g} rad/m. Up to q_c the theory is {cut} "
                "Means are extrapolated to q_max, and the uncertainty of that is in their error; rows marked at q_c are not "
                "extrapolated. The ratio is formed up to q_c."
            )
        if short := self.farthest(SAME_MODES, UP_TO_CUT_OFF):
            notes.append(
                f"The cell holds too few long waves for the theory: summed over its modes it is {short} The error of "
                "the ratio includes this; take more waves per side."
            )
        return tuple(notes)

    def farthest(self, name: str, other: str) -> str:
        """Return in words T_flash where two theories differ most; empty for a difference below `NOTICED`.

        `name` and `other` are columns, as "calibrated".
        """
        values, references = (
            self.flash.sel(column=column).mean.ravel() for column in (name, other)
        )
        with np.errstate(all="ignore"):  # 0/0 at rest
            apart = np.where(references == 0.0, 0.0, np.abs(values / references - 1.0))
        k = int(np.argmax(np.nan_to_num(apart, nan=np.inf)))
        if not apart[k] > NOTICED:
            return ""
        speed = self.run.scene.speeds[k]
        return f"{values[k]:.4g} instead of {references[k]:.4g} K (flash_temperature at {speed:g} m/s)."

    def to_dict(self) -> dict[str, Any]:
        """Return the table as JSON values; NaN and infinity become None."""
        result: dict[str, Any] = {
            "realizations": self.run.realizations,
            "failed": self.run.failed,
            "missing": self.run.missing,
            "scene_warnings": self.judged.warnings,
            "rows": [row.to_dict() for row in self.rows],
            "stress_slopes": [slope._asdict() for slope in self.slopes],
        }
        if not self.run.drawn:
            result["directions"] = self.run.angles
        return {key: json_value(value) for key, value in result.items()}

    def table(self) -> Table:
        """Return the table of all observables, columns and ratios, as `compare --all` prints it."""
        rows = []
        for row in self.rows:
            cells = {"observable": with_unit(row.title, row.unit)} | row.heads | row.numbers
            if SLIDING in row.columns:
                cells[OF_SLIDING] = row.entries[SLIDING_CALIBRATED].number()
            ratios = {name: ratio.number() for name, ratio in row.ratios.items()}
            rows.append(cells | ratios | {"note": row.note})
        notes, title = [*meanings(self), *self.notes()], _title(self.run)
        return table_of(rows, title, notes, names=("observable",), texts=("note",))

    def summary(self) -> Table:
        """Return the table of T_flash that `compare` prints, or all of a pressed map and its directions."""
        run = self.run
        if not run.drawn:
            return self.table()
        rows = list(rows_of({FLASH: self.flash}))  # others take ten times as long
        cells = [row.heads | row.numbers for row in rows]
        fastest = max(rows, key=lambda row: row.speed or 0.0)
        ratios = [
            f"{name.replace('_over_', '/')} at {fastest.speed:g} m/s: {ratio.number()}, {TESTS[name]}."
            for name, ratio in fastest.ratios.items()
            if isfinite(ratio.mean)
        ]
        modes = (
            f" {_SAME_MODES}"
            if any(ratio.startswith(f"{run.numerics.columns[0]}/theory") for ratio in ratios)
            else ""
        )
        simulated = dict.fromkeys((run.numerics.columns[-1], run.simulated_columns[-1]))
        ratios += pictured(run.scene, self.columns, *simulated)
        notes = [
            *ratios,
            f"± total error, 95 %.{modes} Heat share in the body: {run.share_text()}.",
        ]
        notes += map(str, self.judged.of_run)
        columns = (one for row in rows for one in row.columns.values())
        notes += [*marks_in_words(columns, {row.note for row in rows}), *left_out(run)]
        warnings = self.judged.warnings
        notes += marked(warnings[:_MOST_WARNINGS])
        if more := len(warnings[_MOST_WARNINGS:]):
            notes.append(f"{more} more warnings by --all.")
        return table_of(cells, f"{_title(run)}; {with_unit(FLASH, 'K')}", notes)

    def asked(self) -> Table | None:
        """Return the table of what the scene asks for beside T_flash, as `compare` prints it; None if nothing.

        These are its targets, reactions and quantiles, by the calibrated law and by the contact that it is about.
        """
        scene = self.run.scene
        names = [name for name in asked_of_scene(scene, self.run.until) if name != FLASH]
        if not names or not self.run.drawn:
            return None
        shown = CALIBRATED, self.run.numerics.columns[-1], self.run.simulated_columns[-1]
        columns = {name: one for name, one in self.columns.items() if name in shown}
        found = joined(columns, names, scene.directions)
        return asked_table(scene, found) if found else None

    def first_screen(self) -> list[Table]:
        """Return the tables that `compare` prints without `--all`."""
        return [self.summary(), *filter(None, [self.asked()])]

    def __str__(self) -> str:
        return "\n\n".join(map(str, self.first_screen()))

    def _repr_html_(self) -> str:
        return in_notebook(*self.first_screen(), *marked(self.judged.warnings[_MOST_WARNINGS:]))

    def to_dataframe(self) -> Any:
        """Return the rows as a `pandas.DataFrame` in SI; its index is the observable.

        Its columns have the names of `to_dict`: speed, theory (over the whole spectrum), theory_same_modes (summed over
        the modes of the cell up to q_c), calibrated, each measured column and each ratio with its total error, 95 %,
        and the parts that this lacks (`NAME_unknown`), unit and note.

        Raises
        ------
        ImportError
            If pandas is not installed: ``pip install pandas``.
        """
        return data_frame([row.to_flat_dict() for row in self.rows], "observable")

    def chart(self, path: str | Path | None, *, csv: str | Path | None = None) -> None:
        """Draw C(q) and C_sm(q), g_σ(r), T_flash(v), D_flash(v) and d_flash(v) as .png, .pdf or .svg.

        `csv` is a file for the numbers drawn, .csv. ValueError for another ending of `path` or `csv`.
        """
        from roughsim.charts.curves import Entry, curves_chart
        from roughsim.charts.style import Look

        entry = Entry("run", self.run.scene, self.run, self.results)
        curves_chart(path, [entry], look=Look(csv=csv))


def _title(run: Run) -> str:
    """Return the title of the scene, if it has one, and the number of realizations in words."""
    count = run.extent + (f", {run.failed} failed and left out" if run.failed else "")
    return f"{run.scene.title}: {count}" if run.scene.title else count


def _meanings_of_directions(run: Run) -> Iterator[str]:
    """Yield notes on the cell of a map, and on its rows by the direction of sliding and over its Gaussian twin."""
    yield from (
        f"cell: {one.value}, {one.text}." for one in run.reasons if one.quantity == "surface"
    )
    if run.angles:
        angles = ", ".join(
            f"{FLASH}_{name} at {degrees(angle) % 360:.0f}°" for name, angle in run.angles.items()
        )
        yield (
            f"{FLASH}: the mean over all directions of sliding. {angles} from x towards y; along is the lay of the "
            "map. Each is the mean times its ratio at q_c, half the length of the map after the start from rest."
        )
    yield from (f"{line}." for line in run.needed_size())
    if run.over_twin is not None:
        ratios = ", ".join(
            f"{x:.2f} at {v:g} m/s" for x, v in zip(run.over_twin, run.scene.speeds, strict=True)
        )
        yield (
            f"map over Gaussian twin: {ratios}; T_flash of the map over T_flash of one map of the same |h(q)| with "
            "random phases. For Gaussian maps of four longest waves it scatters by 0.1, with grooves 5:1 by 0.2."
        )


def meanings(comparison: Comparison) -> Iterator[str]:
    """Yield notes: the slopes of the stress spectrum, and the meaning of columns and marks."""
    for slope in comparison.slopes:
        band = f"slope of |σ_q|² from {slope.low:.3g} to {slope.high:.3g} rad/m"
        measured = Number(slope.measured, error=slope.error)
        yield f"{band}: {slope.column} {measured} (statistical, 95 %), theory {slope.theory:.2f}"
    yield f"± total error, 95 %. theory: over the whole spectrum. {_SAME_MODES}"
    yield calibrated_note(comparison.run.scene)
    yield from map(str, comparison.judged.statements)
    yield from meaning_of(comparison.run.scene)
    yield from _meanings_of_directions(comparison.run)
    yield from marked(comparison.judged.warnings)
    if comparison.run.numerics.slide is not None:
        yield (
            "sliding: both faces move over one another, and the bodies share the heat point by point. T_flash above "
            "the background of the moving body, mean over the last half of the slid distance."
            + _continued_note(comparison.run)
        )
        yield sliding_note(comparison.run.scene)
    rows = comparison.rows
    columns = [row.columns for row in rows] + [row.ratios for row in rows]
    shown = (one for entries in columns for one in entries.values())
    yield from marks_in_words(shown, {row.note for row in rows})
    if CONTACT_TEMPERATURE in comparison.results:
        yield (
            f"{CONTACT_TEMPERATURE}: T₀ + T_flash of the moving body after the duration, steady without one, above its "
            "temperature when sliding began. T₀ is from the theory of heat, not simulated"
            + (
                ", but in the column sliding from the slide, of endless planes."
                if comparison.run.numerics.slide is not None
                else "."
            )
        )


def _continued_note(run: Run) -> str:
    """Return how far slides are followed, if it is not the whole slid distance."""
    followed = run.followed
    if followed is None:
        return ""
    whole = max(run.scene.sliding.distances)
    return (
        f" Slides are followed over {1e3 * followed:.3g} of {1e3 * whole:.3g} mm; the theory of {OF_SLIDING} "
        f"multiplies their values, with an error of {100 * CONTINUED:.2g} % more."
    )
