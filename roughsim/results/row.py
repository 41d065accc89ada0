"""`Row`: one observable at one speed in all columns, a view of `Results`."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from math import copysign, inf, isnan
from typing import Any

from roughsim.estimate.levels import FLASH
from roughsim.results.columns import is_ratio, is_theory
from roughsim.show.table import Cell
from roughsim.table import AT_CUT_OFF, IDENTITY, Estimate, heads_of

NOTICED = 0.02  # relative difference of two theories that a note names


@dataclass(frozen=True, slots=True)
class Row:
    """One observable at one speed (None without a speed) and direction: theories, simulated columns, and ratios.

    `theory` is integrated over all of C(q), `theory_at_cut_off` up to q_c. `theory_same_modes` is summed over the modes
    of the cell up to q_c; ratios to the theory use it. `calibrated` uses the calibrated stress spectrum; NaN outside
    the range compared with contacts. `sliding_calibrated` is the calibrated theory of two sliding bodies, for the
    column sliding. `note` is "identity" for a value fixed by force balance, "at q_c" for a value without a limit in the
    cut-off, or if the run shows none.
    """

    observable: str
    unit: str
    speed: float | None
    about: Mapping[
        str, float
    ]  # energy of activation, eV, absolute temperature, K, or direction of sliding, rad, of rows that have one
    theories: Mapping[str, float]  # by column
    columns: Mapping[str, Estimate]  # simulated ones, each of one entry
    ratios: Mapping[str, Estimate]
    note: str

    @property
    def theory(self) -> float:
        """The theory over the whole spectrum."""
        return self.theories["theory"]

    @property
    def calibrated(self) -> float:
        """The theory by the calibrated stress spectrum; NaN outside its range."""
        return self.theories["calibrated"]

    @property
    def title(self) -> str:
        """The observable, with the energy, eV, or the temperature, K, of a row that has one."""
        units = {"energy": ", {:.3g} eV", "temperature": " {:g} K"}
        words = (units[key].format(x) for key, x in self.about.items() if key in units)
        return self.observable + "".join(words)

    @property
    def heads(self) -> dict[str, Cell]:
        """Direction and speed in words by the titles of their columns, as `table.heads_of`."""
        return heads_of({**self.about, "speed": self.speed})

    @property
    def cut(self) -> bool:
        """Whether the theory up to q_c differs from the theory over the whole spectrum by more than `NOTICED`."""
        return abs(self.theories["theory_at_cut_off"] - self.theory) > NOTICED * abs(self.theory)

    @property
    def unknown(self) -> list[str]:
        """Unknown parts of the errors of the simulated columns."""
        return list(dict.fromkeys(part for one in self.columns.values() for part in one.unknown))

    def to_dict(self) -> dict[str, Any]:
        """Return the row with an entry for each column and ratio."""
        result = {"observable": self.observable, "speed": self.speed} | self._theories()
        for name, one in self.columns.items():
            result[name] = {
                "mean": float(one.mean),
                "standard_error": float(one.standard_error),
                "bias": float(one.bias),
                "total_error": float(one.total_error),
                "unknown": one.unknown,
            }
        for name, one in self.ratios.items():
            result[name] = {
                "value": float(one.mean),
                "standard_error": float(one.standard_error),
                "z": deviation(one),
                "total_error": float(one.total_error),
                "unknown": one.unknown,
            }
        return result | {"note": self.note}

    def to_flat_dict(self) -> dict[str, Any]:
        """Return the row with one value for each key.

        NAME_total_error is the error of NAME, 95 %; NAME_unknown are the parts that it lacks, "" for none.
        """
        head = {"observable": self.observable, "unit": self.unit, "speed": self.speed}
        result = head | self._theories()
        for name, one in {**self.columns, **self.ratios}.items():
            result[name] = float(one.mean)
            result[f"{name}_total_error"] = float(one.total_error)
            result[f"{name}_unknown"] = ", ".join(one.unknown)
        return result | {"note": self.note}

    def _theories(self) -> dict[str, Any]:
        """Return the theories but the one up to q_c, and the energy or temperature."""
        shown = {name: x for name, x in self.theories.items() if name != "theory_at_cut_off"}
        return {**shown, **self.about}


def rows_of(results: Mapping[str, Estimate]) -> Iterator[Row]:
    """Yield the rows of results: each observable at each energy, temperature or direction, and speed."""
    for name, estimate in results.items():
        others = [dim for dim in estimate.dims if dim != "column"]
        columns = estimate.coords["column"].tolist()
        for labels in product(*(estimate.coords[dim].tolist() for dim in others)):
            at = dict(zip(others, labels, strict=True))
            here = estimate.sel(**at)
            entries = {column: here.sel(column=column) for column in columns}
            simulated = {c: e for c, e in entries.items() if not (is_theory(c) or is_ratio(c))}
            speed = at.pop("speed")
            named = at.pop("direction") if isinstance(at.get("direction"), str) else None
            marks = {str(one.note) for one in simulated.values()}
            yield Row(
                name if named is None else f"{FLASH}_{named}",
                estimate.unit,
                None if isnan(speed) else speed,
                at,
                {column: float(e.mean) for column, e in entries.items() if is_theory(column)},
                simulated,
                {column: e for column, e in entries.items() if is_ratio(column)},
                next((mark for mark in (IDENTITY, AT_CUT_OFF) if mark in marks), ""),
            )


def deviation(ratio: Estimate) -> float:
    """Return (ratio − 1)/standard error; 0 for agreement to rounding, infinite for a difference without scatter."""
    value, error = float(ratio.mean), float(ratio.standard_error)
    if error > 0.0:
        return (value - 1.0) / error
    if isnan(value):
        return value
    return 0.0 if abs(value - 1.0) <= 1e-9 else copysign(inf, value - 1.0)
