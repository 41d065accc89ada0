"""`Row`: one line of a comparison, with its measured cells and ratios."""

from dataclasses import dataclass
from math import copysign, inf, isnan, nan
from typing import Any, NamedTuple

from roughsim.scene.numerics import SLIDING

NOTICED = 0.02  # relative difference of two theories that a note names


class Cell(NamedTuple):
    """A measured value: mean, standard error, finest level − mean, total error (95 %) and the parts it lacks."""

    mean: float
    standard_error: float
    bias: float
    total_error: float = nan
    unknown: tuple[str, ...] = ()


NOTHING = Cell(nan, nan, nan)


class Ratio(NamedTuple):
    """A ratio of two columns with its paired standard error and its total error (95 %)."""

    value: float
    standard_error: float
    total_error: float = nan
    unknown: tuple[str, ...] = ()

    @property
    def z(self) -> float:
        """(value − 1)/standard_error; 0 for agreement to rounding, infinite for a difference without scatter."""
        if self.standard_error > 0.0:
            return (self.value - 1.0) / self.standard_error
        if isnan(self.value):
            return nan
        return 0.0 if abs(self.value - 1.0) <= 1e-9 else copysign(inf, self.value - 1.0)


@dataclass(frozen=True, slots=True)
class Row:
    """One observable at one speed (None without a speed): theory, the measured columns, and their ratios.

    `theory` is integrated over all of C(q), `theory_at_cut_off` up to q_c. `theory_same_modes` is summed over the modes
    of the cell up to q_c; ratios to the theory use it. `calibrated` uses the calibrated stress spectrum; NaN outside
    the range compared with contacts. `sliding_calibrated` is the calibrated theory of two sliding bodies, for the
    column sliding. `note` is "identity" for a value fixed by force balance, "at q_c" for a value without a limit in the
    cut-off, or if the run shows none.
    """

    observable: str
    unit: str
    speed: float | None
    theory: float
    theory_same_modes: float
    theory_at_cut_off: float
    calibrated: float
    columns: dict[str, Cell]
    ratios: dict[str, Ratio]
    note: str
    sliding_calibrated: float = nan
    energy: float | None = None  # of activation, eV, of rows of a reaction
    temperature: float | None = None  # absolute, K, of rows of the share of the heat above it

    @property
    def about(self) -> dict[str, float]:
        """Energy or temperature of a row that has one."""
        both = {"energy": self.energy, "temperature": self.temperature}
        return {name: value for name, value in both.items() if value is not None}

    @property
    def title(self) -> str:
        """The observable, with the energy, eV, or the temperature, K, of a row that has one."""
        if self.energy is not None:
            return f"{self.observable}, {self.energy:.3g} eV"
        return (
            self.observable
            if self.temperature is None
            else f"{self.observable} {self.temperature:g} K"
        )

    @property
    def cut(self) -> bool:
        """Whether the theory up to q_c differs from the theory over the whole spectrum by more than `NOTICED`."""
        return abs(self.theory_at_cut_off - self.theory) > NOTICED * abs(self.theory)

    def to_dict(self) -> dict[str, Any]:
        """Return the row with an entry for each column and ratio."""
        names = ("observable", "speed", "theory", "theory_same_modes", "calibrated")
        result: dict[str, Any] = {name: getattr(self, name) for name in names} | self.about
        result |= {name: cell._asdict() for name, cell in self.columns.items()}
        if SLIDING in self.columns:
            result["sliding_calibrated"] = self.sliding_calibrated
        for name, ratio in self.ratios.items():
            head = {"value": ratio.value, "standard_error": ratio.standard_error, "z": ratio.z}
            result[name] = head | {"total_error": ratio.total_error, "unknown": ratio.unknown}
        return result | {"note": self.note}

    def to_flat_dict(self) -> dict[str, Any]:
        """Return the row with one value for each key.

        NAME_total_error is the error of NAME, 95 %; NAME_unknown are the parts that it lacks, "" for none.
        """
        names = ("observable", "unit", "speed", "theory", "theory_same_modes", "calibrated")
        result: dict[str, Any] = {name: getattr(self, name) for name in names} | self.about
        values = {
            name: (cell.mean, cell.total_error, cell.unknown) for name, cell in self.columns.items()
        }
        values |= {
            name: (ratio.value, ratio.total_error, ratio.unknown)
            for name, ratio in self.ratios.items()
        }
        if SLIDING in self.columns:
            result["sliding_calibrated"] = self.sliding_calibrated
        for name, (value, error, unknown) in values.items():
            result |= {
                name: value,
                f"{name}_total_error": error,
                f"{name}_unknown": ", ".join(unknown),
            }
        return result | {"note": self.note}
