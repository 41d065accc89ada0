"""`Numerics`: levels, cell and tolerance of a computation. `plan` chooses it, a run records it."""

from dataclasses import field, fields
from functools import cached_property
from math import isinf, pi
from typing import Annotated, Any, Final, Literal, Self, get_args

from pydantic import BeforeValidator, PlainSerializer, SkipValidation, model_validator
from pydantic_core import to_jsonable_python

from roughsim.errors import ResolutionError
from roughsim.extensions import extensions
from roughsim.grid import Grid
from roughsim.scene.schema import (
    QMax,
    Quantity,
    Record,
    as_written,
    one_or_list,
    optional_keys,
    record,
    whole,
)
from roughsim.show.markup import in_notebook
from roughsim.show.remarks import Remark
from roughsim.show.table import Table, significant, table_of

Column = Literal["smoothed", "capped", "elastic", "sliding", "quadrants"]
SLIDING: Final = (
    "sliding"  # the column of the slide of two bodies; all others are of single contacts
)
QUADRANTS: Final = "quadrants"  # the column of the quadrants of a pressed map
_Points = Annotated[int, whole("1024", 1, 2**31)]
_Length = Annotated[float, Quantity("m", '"4 mm"', gt=0)]
_Distance = Annotated[
    float,
    Quantity("m", '"2 mm"', gt=0, may_be_infinite=True),
    PlainSerializer(lambda distance: "inf" if isinf(distance) else distance),  # JSON has no inf
]
DEFAULT_SOLVER = "active_set"
_CELLS = {
    None: (1, ""),
    "half": (2, " in half the cell"),
    "quarter": (4, " in a quarter of the cell"),
}
SAME = 1e-9  # relative: wavenumbers that differ by less are the same


@record("numerics.levels", kw_only=False)
class Level(Record):
    """A contact problem with its own random surfaces.

    Parameters
    ----------
    column : {"smoothed", "capped", "elastic", "sliding", "quadrants"}
        Elastic contact on C_sm, capped contact on C, or elastic contact on C. Or the slide of one body over the other
        ("sliding"), at most one level, and the last. Or the contact of the quadrants of a pressed map.
    shape : (int, int)
        Points along x and y.
    q_max : float
        Cut-off of the spectrum, rad/m, at most the Nyquist wavenumber.
    cell : {"half", "quarter"} or None
        Sides of its cell as a part of the sides of the run's cell; None: all. The lowest level of a column has the
        run's cell. Higher levels are corrections, and may have smaller cells.
    first : int or None
        Number of realizations, for the slide and for pressed maps only. None: all.
    followed : float or None
        Simulated distance, m, for the slide only; the theory continues it. None: all of the slid distance.
    lengths : (float, float) or None
        Sides of its cell, m, for the quadrants of a pressed map only.
    """

    column: Column
    shape: Annotated[tuple[_Points, _Points], one_or_list(2)]
    q_max: QMax
    cell: Literal["half", "quarter"] | None = None
    first: Annotated[int, whole("8", 1, 1_000_000)] | None = None
    followed: Annotated[float, Quantity("m", '"4 mm"', gt=0)] | None = None
    lengths: Annotated[tuple[_Length, _Length], one_or_list(2)] | None = None

    @property
    def parts(self) -> int:
        """Ratio of the sides of the run's cell and of its own cell."""
        return _CELLS[self.cell][0]

    @property
    def where(self) -> str:
        """The size of its cell, as text to append; empty for the run's cell."""
        return _CELLS[self.cell][1]

    @property
    def resolved(self) -> tuple[float, int]:
        """Its place in a column: q_max, rad/m, then the points that the whole cell has with its pixel."""
        return self.q_max, self.parts**2 * self.shape[0] * self.shape[1]


def _read_levels(value: Any) -> Any:
    """Refuse a value that is no list of levels, or an empty list."""
    if not isinstance(value, (list, tuple)) or not value:
        example = '[{ column = "capped", shape = 1024, q_max = "4e5 1/m" }]'
        raise ValueError(
            f" = {as_written(value)} must be a list of at least one level, for example {example}"
        )
    return value


@record("numerics", kw_only=False)
class Numerics(Record):
    """Numerical parameters of a computation.

    A column of levels is a levels of cut-offs: its lowest level has the mean, and each higher one corrects the level
    below it. A member of a higher level is one surface, solved at that level and at the level below.

    Parameters
    ----------
    levels : tuple of Level
        Contact problems; the position is the level number.
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
        Number of realizations of each level, from the first, whose fields are stored.
    reasons : tuple of Remark
        Why the plan chose so; numerics with other reasons are equal.
    """

    levels: Annotated[tuple[Level, ...], BeforeValidator(_read_levels)]
    lengths: Annotated[tuple[_Length, _Length], one_or_list(2)]
    tolerance: Annotated[float, Quantity("", "3e-3", gt=0, lt=1)] = 3e-3
    precision: Literal["double", "single"] = "double"
    slid_distance: _Distance | None = None
    threads: Annotated[int, whole("1", 1, 4096)] = 1
    keep_fields: Annotated[int, whole("1", 0)] = 1
    reasons: SkipValidation[tuple[Remark, ...]] = field(default=(), compare=False, repr=False)
    solver: Literal[tuple(sorted(extensions("solvers")))] = DEFAULT_SOLVER  # type: ignore[valid-type]

    @model_validator(mode="after")
    def _fits(self) -> Self:
        self._check_slide()
        for i in range(len(self.levels)):
            self._check_waves(i, i, self.grid(i))
        for column in self.columns:
            self._check_column(column)
            for i in self.of_column(column)[1:]:
                self._check_waves(i, self.below(i) or 0, self.grid_below(i))
        return self

    def _check_waves(self, level: int, of: int, grid: Grid) -> None:
        """Refuse the cut-off of the level `of` that the grid of it, in the cell of `level`, does not hold."""
        q_max, place = self.levels[of].q_max, f", in the cell of levels[{level}]" * (of != level)
        cut_off = f"numerics.levels[{of}].q_max = {q_max:.4g} rad/m"
        if q_max > grid.nyquist * (1 + 1e-12):
            raise ResolutionError(
                f"{cut_off} exceeds the Nyquist wavenumber {grid.nyquist:.4g} rad/m of the grid {grid.shape}{place}; "
                "refine the grid or lower q_max"
            )
        longest = max(
            (side for n, side in zip(grid.shape, grid.lengths, strict=True) if n > 1), default=0.0
        )
        if (
            q_max * longest <= pi
        ):  # a mode of the cell has the waves to half a step below its wavenumber
            raise ResolutionError(
                f"{cut_off} leaves no wave in a cell of {grid.lengths[0]:.4g} × {grid.lengths[1]:.4g} m with "
                f"{grid.shape} points{place}; raise q_max or numerics.lengths"
            )

    def _check_slide(self) -> None:
        """Refuse more than one slide, one that is not the last level, and its keys on other levels."""
        if self.of_column(QUADRANTS):  # `press` has made them
            return
        for i, level in enumerate(self.levels):
            for key in ("first", "followed"):
                if level.column != SLIDING and getattr(level, key) is not None:
                    value = f"levels[{i}].{key} = {getattr(level, key):g}"
                    raise ValueError(f'{value} is for column = "{SLIDING}" only; remove it')
            if level.column == SLIDING and level.cell is not None:
                raise ValueError(
                    f'levels[{i}].cell does not go with column = "{SLIDING}"; remove it'
                )
            if level.column == SLIDING and (i == 0 or i < len(self.levels) - 1):
                raise ValueError(
                    f'levels[{i}].column = "{SLIDING}" must be the last level, after all single contacts; keep one and '
                    "move it to the end"
                )

    def _check_column(self, column: str) -> None:
        """Refuse a lowest level in a part of the cell, a level given twice, and pixels that do not fit the parts."""
        for i in self.of_column(column):
            level, j = self.levels[i], self.below(i)
            if j is None:
                if level.cell is None:
                    continue
                raise ValueError(
                    f'levels[{i}].cell = "{level.cell}", but no {column} level lies below it, and a level in a part of '
                    "the cell only corrects; remove its cell, or add a lower level in the run's cell"
                )
            below = self.levels[j]
            if level.resolved == below.resolved:
                raise ValueError(
                    f"levels[{max(i, j)}] has the q_max and the pixel of levels[{min(i, j)}], so that neither corrects "
                    "the other; remove one, or change its q_max or shape"
                )
            if any(n * below.parts % level.parts for n in below.shape):
                x, y = below.shape
                raise ValueError(
                    f"levels[{i}] lies{level.where} and corrects levels[{j}], whose {x} × {y} points{below.where} do "
                    f"not divide by {level.parts // below.parts}; change the shape of levels[{j}], or the cell"
                )

    def grid(self, level: int) -> Grid:
        """Return the grid of a level, in its own cell."""
        about = self.levels[level]
        x, y = (side / about.parts for side in about.lengths or self.lengths)
        return Grid(about.shape, (x, y))

    def grid_below(self, level: int) -> Grid:
        """Return the grid of the level below in the cell of `level`, with its own pixel; ValueError without one."""
        j = self.below(level)
        if j is None:
            raise ValueError(f"level {level} has none below it")
        below, parts = self.levels[j], self.levels[level].parts
        x, y = (n * below.parts // parts for n in below.shape)
        return Grid((x, y), self.grid(level).lengths)

    def below(self, level: int) -> int | None:
        """Return the level that a level corrects; None for the lowest of a column, and for the slide.

        It is the next coarser one to the same q_max, or else the coarsest one to the next lower q_max.
        """
        if level == self.slide:
            return None
        column = self.of_column(self.levels[level].column)
        lower = column[: column.index(level)]
        if not lower:
            return None
        q_max = self.levels[lower[-1]].q_max
        if q_max == self.levels[level].q_max:
            return lower[-1]
        return next(i for i in lower if self.levels[i].q_max == q_max)

    def is_refined(self, level: int) -> bool:
        """Return whether a level has the q_max of the level below it: it corrects the pixel."""
        below = self.below(level)
        return below is not None and self.levels[below].q_max == self.levels[level].q_max

    def refined(self, level: int) -> int | None:
        """Return the level that corrects the pixel of a level, or None."""
        of_pixel = (i for i in self.single if self.is_refined(i) and self.below(i) == level)
        return next(of_pixel, None)

    def of_column(self, column: str) -> tuple[int, ...]:
        """Return the levels of a column by q_max, then by the pixel, the coarser first."""
        return self._sorted.get(column, ())

    @cached_property  # 3,000 times in a run of fifty members
    def _sorted(self) -> dict[str, tuple[int, ...]]:
        order = sorted(range(len(self.levels)), key=lambda i: self.levels[i].resolved)
        columns = {level.column for level in self.levels}
        return {name: tuple(i for i in order if self.levels[i].column == name) for name in columns}

    def coarse_levels(self, column: str) -> tuple[int, ...]:
        """Return the levels of a column that are no refined: one for each q_max."""
        return tuple(i for i in self.of_column(column) if not self.is_refined(i))

    def picture(self, column: str) -> int:
        """Return the finest level of a column in the run's cell: its fields are the pictures of the scene."""
        return [i for i in self.of_column(column) if self.levels[i].cell is None][-1]

    def parts(self, column: str) -> int:
        """Return the side of the run's cell over the side of the smallest cell of a column."""
        return max(self.levels[i].parts for i in self.of_column(column))

    @property
    def slide(self) -> int | None:
        """The level of the slide of one body over the other; None for history = "frozen"."""
        return len(self.levels) - 1 if self.levels[-1].column == SLIDING else None

    @property
    def single(self) -> range:
        """The levels of single contacts: all but the slide."""
        return range(len(self.levels) if self.slide is None else self.slide)

    @property
    def columns(self) -> tuple[str, ...]:
        """The columns of single contacts that are computed, in the order smoothed, capped, elastic."""
        return tuple(column for column in get_args(Column)[:3] if self.of_column(column))

    def stream(self, level: int) -> int:
        """Return the number of the random stream of a level: its own, as each level has its own surfaces.

        The lowest levels of all columns share one, so that each smoothed contact is paired with a capped one. All
        levels of a column with a number of realizations of its own have the same surfaces.
        """
        if self.levels[level].first is not None:
            return self.of_column(self.levels[level].column)[0]
        lowest = [self.of_column(column)[0] for column in self.columns]
        return min(lowest) if level in lowest else level

    def table(self) -> Table:
        """Return a row for each level, with notes on the cell, the solves and the kept fields."""
        rows = [
            {
                "level": str(i),
                "column": level.column,
                "points": f"{level.shape[0]} × {level.shape[1]}{level.where}",
                "q_c, rad/m": significant(level.q_max, 4),
                "corrects": self._correction(i),
            }
            for i, level in enumerate(self.levels)
        ]
        sides = " × ".join(significant(1e3 * side, 4) for side in self.lengths)
        notes = [
            f"Cell {sides} mm; tolerance {self.tolerance:g} of the contact, {self.precision} precision.",
            f"Fields of the first {self.keep_fields} of each level are kept; {self.threads} threads each.",
            *(f"{one.quantity} {one.value}: {one.text}." for one in self.reasons),
        ]
        return table_of(rows, "", notes, texts=("column", "corrects"))

    def _correction(self, level: int) -> str:
        """Return the correction by a level in words; "" for the lowest of a column."""
        below = self.below(level)
        if below is not None:
            return f"the pixel of level {below}" if self.is_refined(level) else f"level {below}"
        first = self.levels[level].first
        return "" if first is None else f"frozen contact, {first} realizations"

    def __str__(self) -> str:
        return str(self.table())

    def _repr_html_(self) -> str:
        return in_notebook(self.table())

    def to_dict(self) -> dict[str, Any]:
        """Return these numerics as JSON values, without reasons."""
        values: dict[str, Any] = to_jsonable_python(self, exclude={"reasons"})
        for level in values["levels"]:
            for key in ("cell", "first", "followed", "lengths"):
                if level[key] is None:
                    del level[key]
        return values

    @classmethod
    def from_dict(cls, values: dict[str, Any]) -> Self:
        """Return the numerics that `to_dict` described as `values`; a key too many or too few is refused."""
        if values["slid_distance"] is not None:
            values = values | {"slid_distance": float(values["slid_distance"])}  # JSON has no inf
        return cls(**{key.name: values[key.name] for key in fields(cls) if key.compare})


# why `plan` leaves each of these keys at its default
DEFAULT_REASONS = {
    "tolerance": "relative error of the pressure: T_flash then errs by less than 0.1 %",
    "precision": "double costs little beside the solve's own transforms",
    "solver": "the package's own, elastic and capped",
    "slid_distance": "half the cell: a longer slide would meet its own periodic hot track (fields only)",
    "threads": "one per realization: realizations run side by side",
    "keep_fields": "enough to look at; every further one costs disk space",
}


@record("numerics")
class NumericsSection(optional_keys(Numerics)):  # type: ignore[misc]
    """The numerics that the scene fixes: the keys of `Numerics`; None leaves the choice to the plan."""
