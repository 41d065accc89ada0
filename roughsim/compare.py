"""Theory beside simulation: three columns and two ratios, never mixed.

theory (on C_sm, with the scene's γ) · smoothed (elastic contact of surfaces drawn from C_sm) · capped (contact of the
original surface, p ≤ σ_P). smoothed/theory tests W(q); capped/smoothed tests Eq. (27), where γ drops out. An elastic
scene has theory and elastic. Theory is summed over the simulation's own modes; the whole spectrum stands beside it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import isfinite, isnan, nan
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughsim import analytic
from roughsim.estimate import Estimate, quotient
from roughsim.means import OBSERVABLES
from roughsim.record.run import Run
from roughsim.spectrum import TruncatedSpectrum

Array = NDArray[np.float64]
NOTICED = 0.02  # difference of sum and integral of the theory that is told


@dataclass(frozen=True, slots=True)
class Cell:
    """A measured value: mean, its standard error, and finest level − mean."""

    mean: float
    standard_error: float
    bias: float


@dataclass(frozen=True, slots=True)
class Ratio:
    """A ratio of two columns with its paired standard error; z is its distance from 1 in standard errors."""

    value: float
    standard_error: float

    @property
    def z(self) -> float:
        """(value − 1)/standard_error; 0 where both agree to rounding, infinite where they differ without scatter."""
        if self.standard_error > 0.0 or isnan(self.value):
            return (self.value - 1.0) / self.standard_error if self.standard_error else nan
        return 0.0 if abs(self.value - 1.0) <= 1e-9 else (float("inf") if self.value > 1.0 else -float("inf"))


@dataclass(frozen=True, slots=True)
class Row:
    """One observable at one speed (None where there is none): theory, the measured columns, and their ratios.

    `note` is "identity" where force balance fixes the value, "at q_c" where it has no limit in the cut-off.
    """

    observable: str
    unit: str
    speed: float | None
    theory: float
    theory_full_spectrum: float
    columns: dict[str, Cell]
    ratios: dict[str, Ratio]
    note: str


@dataclass(frozen=True, slots=True)
class Comparison:
    """The table of a run. Temperatures are those of the heat share used; ratios do not depend on it."""

    run: Run
    realizations: int
    failed: int
    rows: tuple[Row, ...]

    def cell_note(self) -> str:
        """Say where the sum over the modes of the cell is no measure of the theory; empty where it is one.

        Contacts feel the size of their cell less than that sum does, see docs/errors.md.
        """
        off = [row.theory / row.theory_full_spectrum - 1.0 if row.theory_full_spectrum else nan for row in self.rows]
        told = [(abs(x), row) for x, row in zip(off, self.rows, strict=True) if isfinite(x) and not row.note]
        most, row = max(told, key=lambda pair: pair[0], default=(0.0, None))
        if row is None or most <= NOTICED:
            return ""
        speed = "" if row.speed is None else f" at {row.speed:g} m/s"
        return (
            f"The modes of this cell give another theory than the whole spectrum: {row.observable}{speed} "
            f"{row.theory:.4g} against {row.theory_full_spectrum:.4g} {row.unit}. Contacts feel the cell less: read "
            "the latter, theory_full_spectrum in --json, or take more waves per side."
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the table as JSON values; NaN and infinity become None."""
        return {
            "realizations": self.realizations,
            "failed": self.failed,
            "rows": [_row_dict(row) for row in self.rows],
        }

    def chart(self, path: str | Path) -> None:
        """Draw the comparison: C(q) and C_sm(q), g_σ(r), T_flash(v), D_flash(v), d_flash(v).

        Parameters
        ----------
        path : str or Path
            Of the picture; its ending says the format (.png, .pdf, .svg).

        Raises
        ------
        ValueError
            If the ending is none of these.
        """
        from roughsim.charts import comparison_chart

        comparison_chart(self, Path(path))


def compare(run: Run) -> Comparison:
    """Set a run beside the theory.

    Parameters
    ----------
    run : Run
        From `run` or `open_run`; at least two sound realizations.

    Returns
    -------
    Comparison
        `rows`, `to_dict()` and `chart(path)`.

    Raises
    ------
    ValueError
        If the run has fewer than two sound realizations: there is no error to compare with.
    """
    sound = len(run.sound(run.realizations))
    if sound < 2:
        raise ValueError(f"{run.folder} has {sound} sound realizations; a comparison needs at least 2, let it run on")
    return Comparison(run, run.realizations, run.failed, tuple(_rows(run)))


def _rows(run: Run) -> Iterator[Row]:
    first = run.numerics.columns[0]
    level = run.numerics.of_column(first)[-1]
    drawn = TruncatedSpectrum(analytic.smoothed_spectrum(run.scene), run.numerics.levels[level].q_max)
    summed = analytic.mode_sums(run.scene, drawn, run.numerics.grid(level))
    whole = analytic.predictions(run.scene)
    for observable, record in OBSERVABLES.items():
        measured = {name: run.estimate(observable, name) for name in run.numerics.columns}
        ratios = _ratios(run, observable, summed[observable])
        share = run.heat_partition if record.heated else np.ones(len(run.scene.speeds))
        note = _note(run, observable)
        for k, speed in enumerate(run.scene.speeds if record.per_speed else (None,)):
            yield Row(
                observable,
                record.unit,
                speed,
                float(summed[observable][k] * share[k]),
                float(whole[observable][k] * share[k]),
                {name: _cell(estimate, k) for name, estimate in measured.items()},
                {name: Ratio(float(values[k]), float(error[k])) for name, (values, error) in ratios.items()},
                note,
            )


def _cell(estimate: Estimate, k: int) -> Cell:
    return Cell(float(estimate.mean[k]), float(estimate.standard_error[k]), float(estimate.bias[k]))


def _ratios(run: Run, observable: str, theory: Array) -> dict[str, tuple[Array, Array]]:
    """Value and paired standard error of first/theory and, for capped scenes, capped/smoothed."""
    columns = run.numerics.columns
    result = {f"{columns[0]}_over_theory": quotient(run.values(observable, columns[0], extrapolated=False), theory)}
    if len(columns) > 1:
        first = run.values(observable, columns[0])
        result[f"{columns[1]}_over_{columns[0]}"] = quotient(run.values(observable, columns[1]), first)
    return result


def _note(run: Run, observable: str) -> str:
    if run.scene.elastic:
        return ""
    if OBSERVABLES[observable].by_force_balance and isfinite(analytic.yield_wavenumber(run.scene)):
        return "identity"
    return "" if OBSERVABLES[observable].limit else "at q_c"


def _row_dict(row: Row) -> dict[str, Any]:
    result: dict[str, Any] = {
        "observable": row.observable,
        "speed": row.speed,
        "theory": json_number(row.theory),
        "theory_full_spectrum": json_number(row.theory_full_spectrum),
    }
    for name, cell in row.columns.items():
        values = {"mean": cell.mean, "standard_error": cell.standard_error, "bias": cell.bias}
        result[name] = {key: json_number(value) for key, value in values.items()}
    for name, entry in row.ratios.items():
        values = {"value": entry.value, "standard_error": entry.standard_error, "z": entry.z}
        result[name] = {key: json_number(value) for key, value in values.items()}
    return result | {"note": row.note}


def json_number(value: float) -> float | None:
    """Return a number as JSON can hold it: NaN and infinity are None."""
    return value if isfinite(value) else None
