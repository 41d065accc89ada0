"""`Numerics`: how accurately a scene is computed (levels, cell, tolerance). `plan` chooses it, a run records it."""

from dataclasses import field, fields
from math import isinf, isnan, sqrt
from typing import Annotated, Any, Final, Literal, NamedTuple, Self, get_args

from pydantic import BeforeValidator, PlainSerializer, SkipValidation, model_validator
from pydantic.dataclasses import dataclass
from pydantic_core import to_jsonable_python

from roughsim.errors import ResolutionError
from roughsim.extensions import extensions
from roughsim.grid import Grid
from roughsim.scene.schema import QMax, Quantity, Record, as_written, one_or_list, optional_keys, whole
from roughsim.scene.shown import numerics_table
from roughsim.show.markup import in_notebook

Column = Literal["smoothed", "capped", "elastic", "sliding"]
SLIDING: Final = "sliding"  # the column of the march of two bodies; all others are of single contacts
Points = Annotated[int, whole("1024", 1, 2**31)]
Length = Annotated[float, Quantity("m", '"4 mm"', above=0)]
Distance = Annotated[
    float,
    Quantity("m", '"2 mm"', above=0, may_be_infinite=True),
    PlainSerializer(lambda distance: "inf" if isinf(distance) else distance),  # JSON has no inf
]
DEFAULT_SOLVER = "active_set"
YOUNGER = ("solver",)  # keys that older runs do not have: not stored where they have their default
START_SECONDS = 3.0  # until processes have loaded what they need


class Reason(NamedTuple):
    """One choice of the plan: what was chosen, and why."""

    choice: str
    value: str
    reason: str


class Forecast(NamedTuple):
    """The relative errors of the highest T_flash that a plan expects, and the cost of the run.

    T_flash is that of the capped column, or of the elastic one without a hardness. `statistical` is the 95 % half-width
    after `realizations`; `bandwidth` is NaN where no level shows it. `cpu_seconds` is the time of one thread on the
    machine of the plan.
    """

    realizations: int
    statistical: float
    bandwidth: float
    pixel: float
    size: float
    cpu_seconds: float

    @property
    def total(self) -> float:
        """Root of the sum of squares of the known errors."""
        parts = (self.statistical, self.bandwidth, self.pixel, self.size)
        return sqrt(sum(part**2 for part in parts if not isnan(part)))

    def wall_seconds(self, workers: int) -> float:
        """Return the time that the run takes with `workers` processes, one core each, s."""
        return START_SECONDS + self.cpu_seconds / workers


@dataclass(frozen=True)
class Level(Record, section="numerics.levels"):
    """One contact problem of each realization.

    Parameters
    ----------
    column : {"smoothed", "capped", "elastic", "sliding"}
        Elastic contact on C_sm, capped contact on C, or elastic contact on C. Or the march of one body over the other
        ("sliding"), at most one level, and the last.
    shape : (int, int)
        Points along x and y.
    q_max : float
        Where the spectrum is cut, rad/m, at most the Nyquist wavenumber.
    every : int
        The level is solved for realizations 0, `every`, 2 `every`, … A fine level needs few, since its difference from
        the next coarser one scatters little. 1 for the coarsest level of a column; for each other one a multiple of the
        value of the rung below it, and of all smaller values in the column.
    cell : {"half", "quarter"} or None
        "half": the cell has half the sides of the run's, and surfaces of its own; "quarter": a quarter of the sides.
        Such levels only correct: each adds its mean difference from the one before. The first of a column repeats the
        pixel and q_max of the column's highest level in the run's cell, and the others lie in the same cell. None: the
        run's cell.
    first : int or None
        Of the march: only realizations 0 … `first` − 1 have it. None: all have it.
    """

    column: Column
    shape: Annotated[tuple[Points, Points], one_or_list(2)]
    q_max: QMax
    every: Annotated[int, whole("1", 1, 1_000_000)] = 1
    cell: Literal["half", "quarter"] | None = None
    first: Annotated[int, whole("8", 1, 1_000_000)] | None = None

    @property
    def parts(self) -> int:
        """How many sides of its cell make one of the run's."""
        return {None: 1, "half": 2, "quarter": 4}[self.cell]

    @property
    def where(self) -> str:
        """In which part of the run's cell it lies, in words to append; empty for all of it."""
        return {None: "", "half": " in half the cell", "quarter": " in a quarter of the cell"}[self.cell]

    def indices(self, count: int) -> range:
        """Return which of the first `count` realizations are solved at this level."""
        return range(0, count if self.first is None else min(count, self.first), self.every)


def read_levels(value: Any) -> Any:
    """Refuse a value that is no list of levels, or an empty list."""
    if not isinstance(value, (list, tuple)) or not value:
        example = '[{ column = "capped", shape = 1024, q_max = "4e5 1/m" }]'
        raise ValueError(f" = {as_written(value)} must be a list of at least one level, for example {example}")
    return value


@dataclass(frozen=True)
class Numerics(Record, section="numerics"):
    """How accurately a scene is computed. Levels with the same `column` are paired and extrapolated in q_max.

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
        Of the contact: a name of `roughsim.extensions`.
    slid_distance : float or None
        Distance slid from rest in temperature fields, m; None is half the cell. Moments are steady.
    threads : int
        Threads of each realization.
    keep_fields : int
        Number of realizations, from the first, whose fields are stored.
    reasons : tuple of Reason
        Why the plan chose so; numerics with other reasons are equal.
    forecast : Forecast or None
        The errors and the cost that the plan expects; None where the levels were given.
    """

    levels: Annotated[tuple[Level, ...], BeforeValidator(read_levels)]
    lengths: Annotated[tuple[Length, Length], one_or_list(2)]
    tolerance: Annotated[float, Quantity("", "3e-3", above=0, below=1)] = 3e-3
    precision: Literal["double", "single"] = "double"
    slid_distance: Distance | None = None
    threads: Annotated[int, whole("1", 1, 4096)] = 1
    keep_fields: Annotated[int, whole("1", 0)] = 1
    reasons: SkipValidation[tuple[Reason, ...]] = field(default=(), compare=False, repr=False)
    forecast: SkipValidation[Forecast | None] = field(default=None, compare=False, repr=False)
    solver: Literal[tuple(sorted(extensions("solvers")))] = DEFAULT_SOLVER  # type: ignore[valid-type]

    @model_validator(mode="after")
    def _fits(self) -> Self:
        for i, level in enumerate(self.levels):
            nyquist = self.grid(i).nyquist
            if level.q_max > nyquist * (1 + 1e-12):
                raise ResolutionError(
                    f"numerics.levels[{i}].q_max = {level.q_max:.4g} rad/m exceeds the Nyquist wavenumber "
                    f"{nyquist:.4g} rad/m of the grid {level.shape}; refine the grid or lower q_max"
                )
        self._check_march()
        for column in self.columns:
            self._check_parts(column)
            self._check_strides(column)
        return self

    def _check_strides(self, column: str) -> None:
        """Refuse strides that leave a level without the rung that it corrects, or realizations that are not nested."""
        rung, strides = None, set[int]()  # the first level of a cut-off in a cell, and what levels have so far
        for i in self.of_column(column):
            level = self.levels[i]
            every, least = level.every, rung.every if rung else 1
            nested = all(every % other == 0 or other % every == 0 for other in strides)
            if every % least or not nested or (rung is None and every != 1):
                raise ValueError(
                    f"levels[{i}].every = {every} does not fit: the coarsest {column} level needs every = 1, each "
                    f"other one a multiple of that of the rung below it, here of {least}, and a multiple or a divisor "
                    "of those of the levels before"
                )
            strides.add(every)
            if rung is None or (level.cell, level.q_max) != (rung.cell, rung.q_max):
                rung = level

    def _check_march(self) -> None:
        """Refuse more than one march, one that is not the last level, and its keys on other levels."""
        for i, level in enumerate(self.levels):
            if level.column != SLIDING and level.first is not None:
                raise ValueError(f'levels[{i}].first = {level.first} is for column = "{SLIDING}" only; remove it')
            if level.column == SLIDING and (level.every, level.cell) != (1, None):
                key = "cell" if level.every == 1 else "every"
                raise ValueError(f'levels[{i}].{key} does not go with column = "{SLIDING}"; remove it')
            if level.column == SLIDING and (i == 0 or i < len(self.levels) - 1):
                raise ValueError(
                    f'levels[{i}].column = "{SLIDING}" must be that of the last level, after those of single contacts; '
                    "keep one and move it to the end"
                )

    def _check_parts(self, column: str) -> None:
        """Refuse levels in a part of the cell that do not begin where those in the run's cell end, or in two parts."""
        levels = [self.levels[i] for i in self.of_column(column)]
        whole = [level for level in levels if level.cell is None]
        start = next((level for level in levels if level.cell), None)
        if start is None:
            return
        if not whole:
            raise ValueError(
                f'levels of column {column} all have cell = "{start.cell}", which only correct; add one in the '
                "run's cell"
            )
        other = next((level for level in levels if level.cell not in (None, start.cell)), None)
        if other is not None:
            raise ValueError(
                f'levels of column {column} have cell = "{start.cell}" and "{other.cell}"; choose one of the two'
            )
        end = next(level for level in whole if level.q_max == whole[-1].q_max)
        if start.q_max != end.q_max or tuple(start.parts * n for n in start.shape) != end.shape:
            if any(n % start.parts for n in end.shape):
                raise ValueError(
                    f'levels: cell = "{start.cell}" needs a grid of the run\'s cell whose points divide by '
                    f"{start.parts}; the highest {column} one to q_max = {end.q_max:.6g} rad/m has {end.shape[0]} × "
                    f"{end.shape[1]}"
                )
            x, y = (n // start.parts for n in end.shape)
            part = f"{x} × {y} points to q_max = {end.q_max:.6g} rad/m"
            raise ValueError(
                f'levels: the first {column} one with cell = "{start.cell}" has {start.shape[0]} × {start.shape[1]} '
                f"points to q_max = {start.q_max:.6g} rad/m; it must repeat the highest one in the run's cell, here "
                f"{part}: corrections are ratios to it"
            )

    def grid(self, level: int) -> Grid:
        """Return the grid of a level."""
        parts = self.levels[level].parts
        return Grid(self.levels[level].shape, (self.lengths[0] / parts, self.lengths[1] / parts))

    def of_column(self, column: str) -> tuple[int, ...]:
        """Return the levels of a column: first in the run's cell, each by q_max, then by the number of points."""
        numbers = [i for i, level in enumerate(self.levels) if level.column == column]
        place = [(level.parts, level.q_max, level.shape[0] * level.shape[1]) for level in self.levels]
        return tuple(sorted(numbers, key=place.__getitem__))

    def picture(self, column: str) -> int:
        """Return the finest level of a column in the run's cell: its fields are the pictures of the scene."""
        return [i for i in self.of_column(column) if self.levels[i].cell is None][-1]

    def parts(self, column: str) -> int:
        """Return how many sides of the cell of a column's last level make one of the run's."""
        return max(self.levels[i].parts for i in self.of_column(column))

    def of_index(self, index: int) -> tuple[int, ...]:
        """Return the numbers of the levels that are solved for the realization `index`."""
        return tuple(i for i, level in enumerate(self.levels) if index in level.indices(index + 1))

    def members(self, count: int) -> int:
        """Return how many members the first `count` realizations have."""
        return sum(len(level.indices(count)) for level in self.levels)

    @property
    def march(self) -> int | None:
        """The level of the march of one body over the other; None where history = "frozen"."""
        return len(self.levels) - 1 if self.levels[-1].column == SLIDING else None

    @property
    def single(self) -> range:
        """The levels of single contacts: all but the march."""
        return range(len(self.levels) if self.march is None else self.march)

    @property
    def columns(self) -> tuple[str, ...]:
        """The columns of single contacts that are computed, in the order smoothed, capped, elastic."""
        return tuple(column for column in get_args(Column) if column != SLIDING and self.of_column(column))

    def stream(self, level: int) -> int:
        """Return the level that names the random stream of a level: the finest in the same cell.

        So levels of one cell see the same modes, and those of the other cell have surfaces of their own; so has the
        march, whose two faces are drawn one by one.
        """
        if level == self.march:
            return level
        alike = [i for i in self.single if self.levels[i].cell == self.levels[level].cell]
        return max(alike, key=lambda i: (self.levels[i].q_max, self.levels[i].shape))

    def _repr_html_(self) -> str:
        return in_notebook(numerics_table(self))

    def to_dict(self) -> dict[str, Any]:
        """Return these numerics as JSON values, without reasons and forecast."""
        values: dict[str, Any] = to_jsonable_python(self, exclude={"reasons", "forecast"})
        for level in values["levels"]:
            for key in ("cell", "first"):
                if level[key] is None:
                    del level[key]  # older runs do not have the key
        if self.slid_distance is not None:
            values["slid_distance"] = str(values["slid_distance"])  # as in all runs so far
        defaults = {key.name: key.default for key in fields(self)}
        return {key: value for key, value in values.items() if key not in YOUNGER or value != defaults[key]}

    @classmethod
    def from_dict(cls, values: dict[str, Any]) -> Self:
        """Return the numerics that `to_dict` described as `values`."""
        if values["slid_distance"] is not None:
            values = values | {"slid_distance": float(values["slid_distance"])}
        keys = [key.name for key in fields(cls) if key.compare and (key.name in values or key.name not in YOUNGER)]
        return cls(**{key: values[key] for key in keys})


# why `plan` leaves each of these keys at its default
DEFAULT_REASONS = {
    "tolerance": "relative error of the pressure: T_flash then errs by less than 0.1 %",
    "precision": "double costs little beside the solve's own transforms",
    "solver": "the package's own, elastic and capped",
    "slid_distance": "half the cell: a longer slide would meet its own periodic hot track (fields only)",
    "threads": "one per realization: realizations run side by side",
    "keep_fields": "enough to look at; every further one costs disk space",
}


@dataclass(frozen=True, kw_only=True)
class NumericsSection(optional_keys(Numerics), section="numerics"):  # type: ignore[misc, call-arg]
    """The numerics that the scene fixes: the keys of `Numerics`; None leaves the choice to the plan."""
