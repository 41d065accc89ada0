"""Theory beside simulation: three columns and two ratios, never mixed.

theory (on C_sm, with the scene's γ) · smoothed (elastic contact of surfaces drawn from C_sm) · capped (contact of the
original surface, p ≤ σ_P). smoothed/theory tests W(q); capped/smoothed tests Eq. (27), where γ drops out. An elastic
scene has theory and elastic. People read the theory over the whole spectrum, everywhere the same number; the ratio to
the theory is formed over the modes that the simulation itself has.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import hypot, isfinite, isnan, nan
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughsim import prediction
from roughsim.comparison.stress_slope import Slope, stress_slope
from roughsim.estimate.cell_size import size_error
from roughsim.estimate.errors import Estimate, Quotient, quotient
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.results.gaps import left_out
from roughsim.results.run import Run
from roughsim.show.units import json_number
from roughsim.surface.spectrum import TruncatedSpectrum

Array = NDArray[np.float64]
NOTICED = 0.02  # difference of sum and integral of the theory that is told


@dataclass(frozen=True, slots=True)
class Cell:
    """A measured value: mean, standard error, finest level − mean; total error (95 %) and what it does not know of."""

    mean: float
    standard_error: float
    bias: float
    total_error: float = nan
    unknown: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Ratio:
    """A ratio of two columns with its paired standard error and its total error (95 %).

    z is its distance from 1 in standard errors.
    """

    value: float
    standard_error: float
    total_error: float = nan
    unknown: tuple[str, ...] = ()

    @property
    def z(self) -> float:
        """(value − 1)/standard_error; 0 where both agree to rounding, infinite where they differ without scatter."""
        if self.standard_error > 0.0 or isnan(self.value):
            return (self.value - 1.0) / self.standard_error if self.standard_error else nan
        return 0.0 if abs(self.value - 1.0) <= 1e-9 else (float("inf") if self.value > 1.0 else -float("inf"))


@dataclass(frozen=True, slots=True)
class Row:
    """One observable at one speed (None where there is none): theory, the measured columns, and their ratios.

    `theory` is summed over the modes of the cell up to q_c, `theory_at_cut_off` integrated up to q_c, and
    `theory_full_spectrum` integrated over all. `note` is "identity" where force balance fixes the value, "at q_c" where
    it has no limit in the cut-off, or none that the run can tell.
    """

    observable: str
    unit: str
    speed: float | None
    theory: float
    theory_at_cut_off: float
    theory_full_spectrum: float
    columns: dict[str, Cell]
    ratios: dict[str, Ratio]
    note: str

    @property
    def cut(self) -> bool:
        """Whether the theory up to q_c is noticeably another than that over the whole spectrum."""
        whole = self.theory_full_spectrum
        return abs(self.theory_at_cut_off - whole) > NOTICED * abs(whole)


@dataclass(frozen=True, slots=True)
class Comparison:
    """The table of a run. Temperatures are those of the heat share used; ratios do not depend on it.

    `slopes` are those of |σ_q|² in the band of each column that has one.
    """

    run: Run
    realizations: int
    failed: int
    rows: tuple[Row, ...]
    slopes: tuple[Slope, ...] = ()

    @property
    def unknown(self) -> tuple[str, ...]:
        """The parts of the errors that no level of the run tells, of some column or ratio."""
        parts: dict[str, None] = {}
        for row in self.rows:
            entries: list[Cell | Ratio] = [*row.columns.values(), *row.ratios.values()]
            for entry in entries:
                parts |= dict.fromkeys(entry.unknown)
        return tuple(parts)

    def notes(self) -> tuple[str, ...]:
        """Say what is missing, and why measured values and the theory beside them differ in what they include."""
        run = self.run
        first = run.numerics.columns[0]
        q_c, q_max = run.numerics.levels[run.numerics.of_column(first)[-1]].q_max, run.scene.spectrum.breaks[-1]
        told = left_out(run)
        if cut := self._apart("theory_at_cut_off", "theory_full_spectrum"):
            told.append(
                f"C(q) is cut at q_c = {q_c:.3g} rad/m, below q_max = {q_max:.3g} rad/m. Up to q_c the theory is {cut} "
                "Means are continued to q_max, what that leaves open is in their error; rows marked at q_c are not. "
                "The ratio is formed up to q_c."
            )
        if short := self._apart("theory", "theory_at_cut_off"):
            told.append(
                f"The cell holds too few long waves for the theory: summed over its modes it is {short} The ratio has "
                "this in its error; take more waves per side."
            )
        return tuple(told)

    def _apart(self, name: str, other: str) -> str:
        """The T_flash at which two theories are farthest apart, in words; empty where that is too little to tell."""
        rows = [row for row in self.rows if row.observable == "flash_temperature" and getattr(row, other)]
        off = [abs(getattr(row, name) / getattr(row, other) - 1.0) for row in rows]
        most = max(range(len(rows)), key=off.__getitem__, default=None)
        if most is None or not off[most] > NOTICED:
            return ""
        values = (getattr(rows[most], key) for key in (name, other))
        return "{:.4g} instead of {:.4g} K".format(*values) + f" (flash_temperature at {rows[most].speed:g} m/s)."

    def to_dict(self) -> dict[str, Any]:
        """Return the table as JSON values; NaN and infinity become None."""
        return {
            "realizations": self.realizations,
            "failed": self.failed,
            "missing": self.run.missing,
            "rows": [_row_dict(row) for row in self.rows],
            "stress_slopes": [_plain(slope._asdict()) for slope in self.slopes],
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
    slopes = (stress_slope(run, column) for column in run.numerics.columns)
    return Comparison(run, run.realizations, run.failed, tuple(_rows(run)), tuple(s for s in slopes if s is not None))


def _rows(run: Run) -> Iterator[Row]:
    first = run.numerics.columns[0]
    level = run.numerics.of_column(first)[-1]
    q_c = run.numerics.levels[level].q_max
    drawn = TruncatedSpectrum(prediction.smoothed_spectrum(run.scene), q_c)
    summed = prediction.mode_sums(run.scene, drawn, run.numerics.grid(level))
    cut, whole = prediction.predictions(run.scene, q_c), prediction.predictions(run.scene)
    for observable, record in OBSERVABLES.items():
        measured = {name: run.estimate(observable, name) for name in run.numerics.columns}
        ratios = _ratios(run, observable, summed[observable], cut[observable])
        share = run.heat_partition if record.heated else np.ones(len(run.scene.speeds))
        note = _note(run, observable)
        open_ended = np.any([np.isnan(estimate.budget["bandwidth"]) for estimate in measured.values()], axis=0)
        for k, speed in enumerate(run.scene.speeds if record.per_speed else (None,)):
            yield Row(
                observable,
                record.unit,
                speed,
                float(summed[observable][k] * share[k]),
                float(cut[observable][k] * share[k]),
                float(whole[observable][k] * share[k]),
                {name: _cell(estimate, k) for name, estimate in measured.items()},
                {name: _ratio(found, k) for name, found in ratios.items()},
                note or ("at q_c" if open_ended[k] else ""),
            )


def _cell(found: Estimate, k: int) -> Cell:
    mean, error, bias, total = (float(x[k]) for x in (found.mean, found.standard_error, found.bias, found.total_error))
    return Cell(mean, error, bias, total, found.unknown_at(k))


def _ratio(found: Quotient, k: int) -> Ratio:
    value, error, total = (float(x[k]) for x in (found.value, found.standard_error, found.total_error))
    return Ratio(value, error, total, found.unknown_at(k))


def _ratios(run: Run, observable: str, summed: Array, integral: Array) -> dict[str, Quotient]:
    """First/theory and, for capped scenes, capped/smoothed.

    What the sum over the modes has over the integral is an error by the cell: contacts feel it less than the sum does.
    """
    columns = run.numerics.columns
    known: Any = {"tolerance": run.numerics.tolerance, "scanned": run.scene.scanned}
    sizes = [size_error(run.scene, run.numerics.lengths, observable, column) for column in columns]
    first = run.values(observable, columns[0], extrapolated=False)
    with np.errstate(all="ignore"):  # 0/0 at rest
        apart = np.nan_to_num(summed / integral - 1.0, nan=0.0, posinf=0.0, neginf=0.0)
    result = {f"{columns[0]}_over_theory": quotient(first, summed, size=np.hypot(sizes[0], apart), **known)}
    if len(columns) > 1:
        pair = (run.values(observable, column) for column in (columns[1], columns[0]))
        result[f"{columns[1]}_over_{columns[0]}"] = quotient(*pair, size=hypot(*sizes), **known)
    return result


def _note(run: Run, observable: str) -> str:
    if run.scene.elastic:
        return ""
    if OBSERVABLES[observable].by_force_balance and isfinite(prediction.yield_wavenumber(run.scene)):
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
        result[name] = _entry(values | {"total_error": cell.total_error}, cell.unknown)
    for name, entry in row.ratios.items():
        values = {"value": entry.value, "standard_error": entry.standard_error, "z": entry.z}
        result[name] = _entry(values | {"total_error": entry.total_error}, entry.unknown)
    return result | {"note": row.note}


def _entry(values: dict[str, float], unknown: tuple[str, ...]) -> dict[str, Any]:
    return _plain(values) | {"unknown": list(unknown)}


def _plain(values: dict[str, Any]) -> dict[str, Any]:
    return {key: json_number(value) if isinstance(value, float) else value for key, value in values.items()}
