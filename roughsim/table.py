"""`Estimate`: one observable over named axes, with its error in parts.

The words are those of xarray: `dims`, `coords`, `sel`, `concat`. The axis "column" comes first and "speed" last;
between them stand "energy", "temperature" or "direction", and the varied keys of a study. An observable that does not
depend on the speed has the one speed NaN, which files leave out.
"""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import degrees, isnan
from operator import itemgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughsim.grid import Array
from roughsim.show.markup import in_notebook
from roughsim.show.table import Cell, Number, Table, shown, table_of, with_unit

# SI units of the axes that are no varied keys of a study, but of energies, which are in eV
AXES = {"column": "", "direction": "", "energy": "eV", "temperature": "K", "speed": "m/s"}
_PLACES = {"column": 0, "speed": 2}  # of axes in an array; 1 of all others
_NO_SPEED = np.array([np.nan])
IDENTITY, AT_CUT_OFF = "identity", "at q_c"  # marks of values, see `Estimate.note`
_ARRAYS = "mean", "standard_error", "bias", "effective_n"
Labels = NDArray[Any]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Estimate:
    """One observable over named axes, with its error in parts; all arrays have the shape of `dims`.

    Attributes
    ----------
    observable : str
        Its name.
    unit : str
        SI unit.
    mean : ndarray
        Extrapolated in q_c and the pixel if a limit exists and the levels show it.
    standard_error : ndarray
        Of the mean, statistical.
    budget : mapping of str to ndarray
        The parts of the 95 % error by source; NaN: unknown, 0: absent. If all are unknown, no error is stated, as of
        the theory.
    bias : ndarray
        Value at the finest level minus `mean`; zero without extrapolation.
    n : int
        Number of realizations.
    effective_n : ndarray
        Independent realizations that would give the same interval: degrees of freedom and one.
    note : ndarray of str
        "identity": fixed by force balance; "at q_c": without a limit in the cut-off, or none that the run shows.
    dims : tuple of str
        Names of the axes.
    coords : mapping of str to ndarray
        Labels along each axis.
    notes : tuple of str
        Sentences on extrapolation and missing levels, for `explain`.
    sources : mapping of str to str
        Meaning of each part of `budget`.
    """

    observable: str
    unit: str
    mean: Array
    standard_error: Array
    budget: Mapping[str, Array]
    bias: Array
    n: int
    effective_n: Array
    note: Labels
    dims: tuple[str, ...] = ("speed",)
    coords: Mapping[str, Labels] = field(default_factory=lambda: {"speed": _NO_SPEED})
    notes: tuple[str, ...] = ()
    sources: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        observable: str,
        unit: str,
        mean: Array,
        coords: Mapping[str, Labels],
        budget: Mapping[str, Array] | None = None,
    ) -> "Estimate":
        """Return the values `mean` of an observable without realizations, such as of a theory.

        `unit` is SI, `coords` has the labels along each axis by its name, and `budget` the parts of the error; without
        it no error is stated.
        """
        mean = np.asarray(mean, float)
        nothing, unmarked = np.full(mean.shape, np.nan), np.full(mean.shape, "", object)
        return cls(
            observable, unit, mean, nothing, budget or {}, nothing, 0, nothing, unmarked,
            tuple(coords), coords,
        )  # fmt: skip

    @property
    def stated(self) -> NDArray[np.bool_]:
        """Whether a part of the error is known."""
        unknown = np.full(self.mean.shape, True)
        for part in self.budget.values():
            unknown &= np.isnan(part)
        return ~unknown

    @property
    def total_error(self) -> Array:
        """Root of the sum of squares of the known parts of `budget`; NaN without any, or for an undefined mean."""
        parts = self.budget.values()
        total = np.sqrt(sum((np.where(np.isnan(p), 0.0, p) ** 2 for p in parts), np.array(0.0)))
        return np.where(np.isnan(self.mean) | ~self.stated, np.nan, total)[()]

    @property
    def half_width(self) -> Array:
        """Half-width of the 95 % interval of the scatter (Student t with `effective_n` − 1 degrees of freedom)."""
        return self.budget["statistical"]

    def unknown_at(self, *place: int) -> tuple[str, ...]:
        """Return the unknown parts of `budget` at the entry of indices `place`.

        There is none if no error is stated, or the mean is undefined or zero.
        """
        if not self._with_error[place]:
            return ()
        return tuple(name for name, part in self.budget.items() if np.isnan(part[place]))

    @property
    def unknown(self) -> tuple[str, ...]:
        """The unknown parts of `budget` at any entry, by `unknown_at`; `total_error` excludes them."""
        expected = self._with_error
        missing = {name: np.isnan(part) & expected for name, part in self.budget.items()}
        return tuple(name for name, places in missing.items() if places.any())

    @property
    def _with_error(self) -> NDArray[np.bool_]:
        """Whether an entry should have all parts of its error."""
        expected: NDArray[np.bool_] = np.isfinite(self.mean) & (self.mean != 0.0) & self.stated
        return expected

    def known(self, dim: str) -> Labels:
        """Return the labels of the axis `dim` at which any entry has a value."""
        others = tuple(k for k, name in enumerate(self.dims) if name != dim)
        found: Labels = self.coords[dim][~np.isnan(self.mean).all(others)]
        return found

    def sel(self, **labels: Any) -> "Estimate":
        """Return the entries at the `labels` of axes by name: a single one drops its axis, several keep their order.

        KeyError for a label that is not there. Axes that the estimate lacks are ignored.
        """
        result = self
        for dim, wanted in labels.items():
            if dim not in result.dims:
                continue
            several = isinstance(wanted, (list, tuple, np.ndarray))
            places = _places(result.coords[dim], wanted if several else [wanted])
            axis = result.dims.index(dim)
            taken = places if several else places[0]
            coords = {**result.coords, dim: result.coords[dim][places]}
            if not several:
                del coords[dim]
            at = (slice(None),) * axis + (taken,)
            result = result._mapped(itemgetter(at), coords)
        return result

    def without_no_speed(self) -> "Estimate":
        """Return an estimate that does not depend on the speed without this axis, and others unchanged."""
        alike = "speed" in self.dims and bool(np.isnan(self.coords["speed"]).all())
        return self.sel(speed=np.nan) if alike else self

    def by_direction(self, directions: Sequence[float], *, alike: bool = False) -> "Estimate":
        """Return the estimate with the axis speed, which has all speeds in each direction, as two axes.

        `directions` are in radians. With `alike` the speeds are there once, and their values are of all directions.
        What does not depend on the speed is unchanged; so is all without directions.
        """
        speed, many = self.coords.get("speed", _NO_SPEED), len(directions)
        if not many or "direction" in self.dims or np.isnan(speed).any():
            return self
        coords = {dim: labels for dim, labels in self.coords.items() if dim != "speed"}
        coords["direction"] = np.array(directions)
        coords["speed"] = speed if alike else speed[: speed.size // many]
        shape = [len(labels) for labels in coords.values()]
        copies = many if alike else 1
        return self._mapped(lambda values: np.tile(values, copies).reshape(shape), coords)

    def times(self, factor: Array | float) -> "Estimate":
        """Return the estimate of a product with an exact factor, such as a share of the heat."""
        budget = {name: part * np.abs(factor) for name, part in self.budget.items()}
        return replace(
            self,
            mean=self.mean * factor,
            standard_error=self.standard_error * np.abs(factor),
            budget=budget,
            bias=self.bias * factor,
        )

    def _mapped(self, function: Callable[[Any], Any], coords: Mapping[str, Labels]) -> "Estimate":
        """Return the estimate with all its arrays mapped to other axes."""
        arrays: dict[str, Any] = {}
        for name in (*_ARRAYS, "note"):
            arrays[name] = function(getattr(self, name))
        budget = {name: function(part) for name, part in self.budget.items()}
        return replace(self, **arrays, budget=budget, dims=tuple(coords), coords=coords)

    def labels(self, place: Sequence[int]) -> dict[str, Any]:
        """Return the labels of an entry by axis; None in place of NaN."""
        at = zip(self.dims, place, strict=True)
        return {dim: _plain(self.coords[dim][k].item()) for dim, k in at}

    def rows(self) -> Iterator[dict[str, Any]]:
        """Yield each defined entry with its labels, its value and total error in SI, and its marks."""
        total = self.total_error
        for place in np.ndindex(self.mean.shape):
            if np.isnan(self.mean[place]):
                continue
            yield {
                "observable": self.observable,
                "unit": self.unit,
                **self.labels(place),
                "value": float(self.mean[place]),
                "total_error": float(total[place]),
                "unknown": ", ".join(self.unknown_at(*place)),
                "note": str(np.asarray(self.note)[place]),
            }

    def number(self, *place: int) -> Number:
        """Return the entry of indices `place` as it is shown, with its total error, if one is stated."""
        error = float(self.total_error[place]) if self.stated[place] else 0.0
        return Number(float(self.mean[place]), self.unit, error, self.unknown_at(*place))

    def row(self, place: tuple[int, ...], parts: Iterable[str]) -> dict[str, Cell]:
        """Return the entry of indices `place` as a row of a table, by titles: its `heads`, its number, and its error.

        The error is in the named `parts`, of which one that `budget` lacks is zero; the value at the finest level minus
        the mean stands beside them.
        """
        nothing = np.zeros_like(self.mean)
        errors = {name: self.budget.get(name, nothing) for name in parts}
        errors["finest − mean"] = self.bias
        row = self.heads(place) | {"mean ± total error": self.number(*place)}
        return row | {
            name: Number(float(each[place]), self.unit, digits=2) for name, each in errors.items()
        }

    def heads(self, place: tuple[int, ...]) -> dict[str, Cell]:
        """Return direction and speed of the entry of indices `place` as `heads_of`."""
        return heads_of(self.labels(place))

    def table(self) -> Table:
        """Return the mean with its total error and the parts of the error, a row per speed."""
        rows = [self.row(place, self.budget) for place in np.ndindex(self.mean.shape)]
        title = f"{with_unit(self.observable, self.unit)}: {self.n} realizations"
        sources = (f"{name}: {self.sources[name]}" for name in self.budget)
        return table_of(rows, title, (*self.notes, *sources))

    def __repr__(self) -> str:
        means = ", ".join(str(self.number(*place)) for place in np.ndindex(self.mean.shape))
        speeds = [f"{speed:g}" for speed in self.coords.get("speed", ()) if not np.isnan(speed)]
        at = f" at {', '.join(speeds)} m/s" if speeds else ""
        return f"<Estimate of {with_unit(self.observable, self.unit)}: {means}{at}; n = {self.n}>"

    def _repr_html_(self) -> str:
        return in_notebook(self.table())

    def explain(self) -> str:
        """Explain the source of each part of the error."""
        lines, (unit, factor) = [], shown(self.unit)
        for place in np.ndindex(self.mean.shape):
            known = {
                name: part[place] * factor
                for name, part in self.budget.items()
                if np.isfinite(part[place])
            }
            parts = ", ".join(f"{name} {part:.2g}" for name, part in known.items())
            lines.append(
                f"{self.number(*place)} {unit}".rstrip()
                + f": {parts}; n = {self.n} realizations of the lowest "
                f"level; interval with {self.effective_n[place] - 1:.3g} degrees of freedom; value at the finest level "
                f"{self.bias[place] * factor:+.2g}"
            )
        known_parts = (name for name in self.budget if name not in self.unknown)
        sources = [f"{name}: {self.sources[name]}" for name in known_parts]
        why = dict.fromkeys(self.unknown, "no level of the run shows it")
        if "statistical" in why:
            why["statistical"] = "too few realizations show it"
        if "bandwidth" in why and "last step" in self.budget:
            why["bandwidth"] = (
                "the waves above the highest q_c may change more than the last step to it did"
            )
        missing = (
            f"{name}: unknown: {reason}; not in these figures" for name, reason in why.items()
        )
        return "\n".join([f"{self.observable}:", *lines, *self.notes, *sources, *missing])


def heads_of(labels: Mapping[str, Any]) -> dict[str, Cell]:
    """Return the direction, radians, and the speed among some labels, in words by the titles of their columns.

    None where nothing depends on them; directions of a pressed map have names, and stand elsewhere.
    """
    direction, speed = labels.get("direction"), labels.get("speed")
    heads: dict[str, Cell] = {}
    if isinstance(direction, float):
        heads["direction, °"] = f"{degrees(direction):.4g}"
    if speed is not None:
        heads["speed, m/s"] = f"{speed:g}"
    return heads


def unknown_parts(estimates: Iterable[Estimate]) -> list[str]:
    """Return the unknown parts of the errors of some estimates."""
    return list(dict.fromkeys(part for one in estimates for part in one.unknown))


def marks_in_words(shown: Iterable[Estimate], notes: Collection[str] = ()) -> Iterator[str]:
    """Yield a sentence for each mark that a table of estimates has; `notes` as `Estimate.note`."""
    if unknown := unknown_parts(shown):
        yield f"≥: a part of the error is unknown, as the run does not show it ({', '.join(unknown)})."
    if IDENTITY in notes:
        yield "identity: fixed by force balance; its ratios test nothing."
    if AT_CUT_OFF in notes:
        yield "at q_c: no limit in the cut-off, or none that the run shows; its ratios test nothing."


def concat(pieces: Mapping[Any, Estimate], coords: Mapping[str, Labels]) -> Estimate:
    """Join estimates of one observable along new axes; the key of a piece is the tuple of its places on them.

    Labels of the other axes are united in the order of their appearance. Entries that no piece has are NaN. A part of
    the error that a piece lacks is 0, or NaN if the piece states no error.
    """
    first = next(iter(pieces.values()))
    united = dict(coords)
    for dim in first.dims:
        found = {repr(x): x for one in pieces.values() for x in one.coords[dim].tolist()}
        united[dim] = np.array([*found.values()])
    dims = sorted(united, key=lambda dim: _PLACES.get(dim, 1))
    order = [[*united].index(dim) for dim in dims]
    inside = {
        place: np.ix_(*(_places(united[dim], one.coords[dim]) for dim in first.dims))
        for place, one in pieces.items()
    }

    def joined(values: Callable[[Estimate], Any], missing: Any) -> Any:
        shape = [len(labels) for labels in united.values()]
        whole = np.full(shape, missing, np.asarray(missing).dtype if missing != "" else object)
        for place, one in pieces.items():
            whole[place][inside[place]] = values(one)
        return whole.transpose(order)

    names: list[str] = []  # of the parts, in the order that each piece has: the total rounds alike
    for one in pieces.values():
        place = 0
        for name in one.budget:
            if name not in names:
                names.insert(place, name)
            place = names.index(name) + 1
    arrays = {name: joined(lambda one: getattr(one, name), np.nan) for name in _ARRAYS}  # noqa: B023
    budget = {
        name: joined(lambda one: one.budget.get(name, 0.0 if one.budget else np.nan), np.nan)  # noqa: B023
        for name in names
    }
    return replace(
        first,
        **arrays,
        budget=budget,
        note=joined(lambda one: one.note, ""),
        n=max(one.n for one in pieces.values()),
        dims=tuple(dims),
        coords={dim: united[dim] for dim in dims},
        sources={name: text for one in pieces.values() for name, text in one.sources.items()},
    )


def _places(labels: Labels, wanted: Iterable[Any]) -> NDArray[np.intp]:
    """Return the places of some labels of an axis; NaN is a label. KeyError if one is not there."""
    places = {_plain(x): k for k, x in enumerate(labels.tolist())}
    return np.array([places[_plain(x)] for x in wanted], np.intp)


def _plain(label: Any) -> Any:
    """Return a label, and None in place of NaN."""
    return None if isinstance(label, float) and isnan(label) else label
