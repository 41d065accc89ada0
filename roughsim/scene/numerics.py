"""How well a scene is computed: levels, cell, tolerance; what `plan` chooses and a run records."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import ceil, isnan, sqrt
from typing import Any, Literal, NamedTuple, get_args

from roughsim.contact import methods
from roughsim.errors import ResolutionError, number, positive
from roughsim.grid import Grid

Column = Literal["smoothed", "capped", "elastic"]


class Reason(NamedTuple):
    """One choice of the plan: what was chosen, and why."""

    choice: str
    value: str
    reason: str


START_SECONDS = 3.0  # until processes have loaded what they need


class Forecast(NamedTuple):
    """What a plan expects of the highest T_flash in the column that the run is judged by: relative errors; the cost.

    `statistical` is the 95 % half-width at `realizations`; `bandwidth` is NaN where no level tells it. `cpu_seconds`
    is of one thread on the machine of the plan.
    """

    realizations: int
    statistical: float
    bandwidth: float
    pixel: float
    size: float
    cpu_seconds: float

    @property
    def total(self) -> float:
        """Root of the sum of squares of what is known."""
        parts = (self.statistical, self.bandwidth, self.pixel, self.size)
        return sqrt(sum(part**2 for part in parts if not isnan(part)))

    def wall_seconds(self, workers: int) -> float:
        """Return the time that the run takes with so many processes, one core each, s."""
        return START_SECONDS + self.cpu_seconds / workers


@dataclass(frozen=True, slots=True)
class Level:
    """One contact problem of each realization.

    Parameters
    ----------
    column : {"smoothed", "capped", "elastic"}
        Elastic contact on C_sm, capped contact on C, or elastic contact on C.
    shape : (int, int)
        Points along x and y.
    q_max : float
        Where the spectrum is cut, rad/m, at most the Nyquist wavenumber.
    every : int
        It is solved for the indices that are multiples of this: a fine level, whose difference from the next coarser
        one scatters little, needs few. 1 for the coarsest of a column, and a multiple from each to the next finer.
    """

    column: Column
    shape: tuple[int, int]
    q_max: float
    every: int = 1

    def __post_init__(self) -> None:
        if self.column not in get_args(Column):
            raise ValueError(f"column = {self.column!r} must be one of {', '.join(get_args(Column))}")
        object.__setattr__(self, "shape", Grid(self.shape, (1.0, 1.0)).shape)
        positive("q_max", self.q_max, "rad/m")
        _check_count("every", self.every, 1)


@dataclass(frozen=True, slots=True)
class Numerics:
    """How well a scene is computed. Levels with the same `column` are paired and extrapolated in q_max.

    Parameters
    ----------
    levels : tuple of Level
        Contact problems of each realization; the position is the level number.
    lengths : (float, float)
        Sides of the periodic cell, m.
    tolerance : float
        Relative pressure error aimed at in the contact solve.
    precision : {"double", "single"}
        Of the pressure fields.
    solver : str
        Of the contact: a name of `roughsim.contact.methods`.
    slid_distance : float or None
        Distance slid from rest in temperature fields, m; None is half the cell. Moments are steady.
    threads : int
        Threads of each realization.
    keep_fields : int
        Number of realizations, from the first, whose fields are stored.
    reasons : tuple of Reason
        Why the plan chose so; not part of what the numerics are.
    forecast : Forecast or None
        What the plan expects; None where the levels were given.
    """

    levels: tuple[Level, ...]
    lengths: tuple[float, float]
    tolerance: float = 1e-4
    precision: Literal["double", "single"] = "double"
    slid_distance: float | None = None
    threads: int = 1
    keep_fields: int = 1
    reasons: tuple[Reason, ...] = field(default=(), compare=False, repr=False)
    forecast: Forecast | None = field(default=None, compare=False, repr=False)
    solver: str = methods.DEFAULT

    def __post_init__(self) -> None:
        object.__setattr__(self, "levels", tuple(self.levels))
        if not self.levels:
            raise ValueError("levels is empty; at least one level is needed")
        for i, level in enumerate(self.levels):
            grid = Grid(level.shape, self.lengths)
            if level.q_max > grid.nyquist * (1 + 1e-12):
                raise ResolutionError(
                    f"levels[{i}].q_max = {level.q_max:.4g} rad/m exceeds the Nyquist wavenumber {grid.nyquist:.4g} "
                    f"rad/m of the grid {level.shape}; refine the grid or lower q_max"
                )
        object.__setattr__(self, "lengths", grid.lengths)
        if not 0.0 < number("tolerance", self.tolerance) < 1.0:
            raise ValueError(f"tolerance = {self.tolerance:.6g} must lie between 0 and 1")
        if self.precision not in ("double", "single"):
            raise ValueError(f'precision = {self.precision!r} must be "double" or "single"')
        if self.solver not in methods.NAMES:
            raise ValueError(f"solver = {self.solver!r} must be one of {', '.join(methods.NAMES)}")
        _check_count("threads", self.threads, 1)
        _check_count("keep_fields", self.keep_fields, 0)
        self._check_nesting()

    def _check_nesting(self) -> None:
        for column in self.columns:
            before = 1
            for i in self.of_column(column):
                every = self.levels[i].every
                if every % before or (i == self.of_column(column)[0] and every != 1):
                    raise ValueError(
                        f"levels[{i}].every = {every} does not fit: the coarsest {column} level needs every = 1, "
                        f"each finer one a multiple of the one before, here of {before}"
                    )
                before = every

    def grid(self, level: int) -> Grid:
        """Return the grid of a level."""
        return Grid(self.levels[level].shape, self.lengths)

    def of_column(self, column: str) -> tuple[int, ...]:
        """Return the levels of a column in order of q_max, then of the number of points."""
        numbers = [i for i, level in enumerate(self.levels) if level.column == column]
        return tuple(sorted(numbers, key=lambda i: (self.levels[i].q_max, self.grid(i).points)))

    def of_index(self, index: int) -> tuple[int, ...]:
        """Return the numbers of the levels that are solved for the realization `index`."""
        return tuple(i for i, level in enumerate(self.levels) if index % level.every == 0)

    def members(self, count: int) -> int:
        """Return how many members the first `count` realizations have."""
        return sum(-(-count // level.every) for level in self.levels)

    @property
    def columns(self) -> tuple[str, ...]:
        """The columns that are computed, in the order smoothed, capped, elastic."""
        return tuple(column for column in get_args(Column) if self.of_column(column))

    @property
    def stream(self) -> int:
        """The level whose random stream all levels share: the finest. Paired levels see the same modes."""
        return max(range(len(self.levels)), key=lambda i: (self.levels[i].q_max, self.levels[i].shape))

    def to_dict(self) -> dict[str, Any]:
        """Return what these numerics are as JSON values, without the reasons and what does not change a number."""
        levels = [{"column": a.column, "shape": list(a.shape), "q_max": a.q_max, "every": a.every} for a in self.levels]
        return {
            "levels": levels,
            "lengths": list(self.lengths),
            "tolerance": self.tolerance,
            "precision": self.precision,
            "slid_distance": None if self.slid_distance is None else repr(float(self.slid_distance)),
            "threads": self.threads,
            "keep_fields": self.keep_fields,
        } | ({} if self.solver == methods.DEFAULT else {"solver": self.solver})  # absent in older runs

    @classmethod
    def from_dict(cls, values: dict[str, Any]) -> Numerics:
        """Return the numerics that `to_dict` described as `values`."""
        levels = tuple(Level(a["column"], tuple(a["shape"]), a["q_max"], a.get("every", 1)) for a in values["levels"])
        distance = values["slid_distance"]
        return cls(
            levels,
            tuple(values["lengths"]),
            values["tolerance"],
            values["precision"],
            None if distance is None else float(distance),
            values["threads"],
            values["keep_fields"],
            solver=values.get("solver", methods.DEFAULT),
        )


def fast_size(points: float) -> int:
    """Return the next size of the form 2^a·{4, 5, 6} ≥ `points` less 2 %: fast to transform, easy to halve."""
    wanted = max(8, ceil(0.98 * points))
    power = 1
    while 8 * power < wanted:
        power *= 2
    return min(k * power for k in (4, 5, 6, 8) if k * power >= wanted)


def _check_count(name: str, value: Any, least: int) -> None:
    if isinstance(value, bool) or int(value) != value or value < least:
        raise ValueError(f"{name} = {value!r} must be a whole number ≥ {least}")


__all__ = ["Column", "Forecast", "Level", "Numerics", "Reason", "fast_size"]
