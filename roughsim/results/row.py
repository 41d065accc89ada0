"""`Row`: one observable at one speed in all columns, a view of `Results`."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import product
from math import copysign, inf, isnan
from typing import Any

from roughsim.estimate.levels import FLASH
from roughsim.results.columns import UP_TO_CUT_OFF, is_ratio, is_simulated, is_theory
from roughsim.results.theories import CALIBRATED, THEORIES, THEORY
from roughsim.show.table import Cell, Number
from roughsim.table import AT_CUT_OFF, IDENTITY, Estimate, heads_of

NOTICED = 0.02  # relative difference of two theories that a note names


@dataclass(frozen=True, slots=True)
class Row:
    """One observable at one speed (None without a speed) and direction, by theories, simulations, and their ratios.

    `theory` is integrated over all of C(q), `theory_at_cut_off` up to q_c. `theory_same_modes` is summed over the modes
    of the cell up to q_c; ratios to the theory use it. `calibrated` uses the calibrated stress spectrum; NaN outside
    the range compared with contacts. `sliding_calibrated` is the calibrated theory of two sliding bodies, for the
    column sliding.
    """

    observable: str
    unit: str
    speed: float | None
    # energy of activation, eV, absolute temperature, K, or direction of sliding, rad, of rows that have one
    about: Mapping[str, float]
    entries: Mapping[str, Estimate]  # by column, each of one entry

    @property
    def theories(self) -> dict[str, float]:
        """The values of the theories by column."""
        return {name: float(one.mean) for name, one in self.entries.items() if is_theory(name)}

    @property
    def columns(self) -> dict[str, Estimate]:
        """The simulated columns."""
        return {name: one for name, one in self.entries.items() if is_simulated(name)}

    @property
    def ratios(self) -> dict[str, Estimate]:
        """The ratios of two columns, without a unit."""
        ratios = {name: one for name, one in self.entries.items() if is_ratio(name)}
        return {name: replace(one, unit="1") for name, one in ratios.items()}

    @property
    def theory(self) -> float:
        """The theory over the whole spectrum."""
        return self.theories[THEORY]

    @property
    def calibrated(self) -> float:
        """The theory by the calibrated stress spectrum; NaN outside its range."""
        return self.theories[CALIBRATED]

    @property
    def note(self) -> str:
        """The mark: "identity", fixed by force balance; "at q_c", without a limit that the run shows; or ""."""
        marks = {str(one.note) for one in self.columns.values()}
        return next((mark for mark in (IDENTITY, AT_CUT_OFF) if mark in marks), "")

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
    def numbers(self) -> dict[str, Cell]:
        """The values by theories over all of C(q) and in the simulated columns, for a table."""
        theories, unit = self.theories, self.unit
        numbers: dict[str, Cell] = {name: Number(theories[name], unit) for name in THEORIES}
        for name, one in self.columns.items():
            # a simulated value without a known error, as of a single map, says so
            numbers[name] = Number(float(one.mean), unit, float(one.total_error), one.unknown)
        return numbers

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
        shown = {name: x for name, x in self.theories.items() if name != UP_TO_CUT_OFF}
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
            speed = at.pop("speed")
            of_map = isinstance(at.get("direction"), str)
            title = f"{FLASH}_{at.pop('direction')}" if of_map else name
            yield Row(title, estimate.unit, None if isnan(speed) else speed, at, entries)


def deviation(ratio: Estimate) -> float:
    """Return (ratio − 1)/standard error; 0 for agreement to rounding, infinite for a difference without scatter."""
    value, error = float(ratio.mean), float(ratio.standard_error)
    if error > 0.0:
        return (value - 1.0) / error
    if isnan(value):
        return value
    return 0.0 if abs(value - 1.0) <= 1e-9 else copysign(inf, value - 1.0)
