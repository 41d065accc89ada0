"""`Results`: every observable over named axes, with its error in parts. All outputs are views of it."""

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np

from roughsim.table import AXES, Estimate, Labels

_TAILS = {
    "_part": "parts of the 95 % error; NaN: unknown, 0: absent",
    "_total_error": "total error of the mean, 95 %: root of the squares of its known parts",
    "_standard_error": "statistical standard error of the mean",
    "_bias": "value at the finest level minus the mean",
    "_note": "identity: fixed by force balance; at q_c: not extrapolated in the cut-off",
}


class Labelled(NamedTuple):
    """An array with a name, its axes' names, and attributes."""

    name: str
    axes: tuple[str, ...]
    data: Any  # an array, or one that is read when it is used
    attributes: Mapping[str, Any]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Results(Mapping[str, Estimate]):
    """The estimates of observables by name, over named axes; immutable.

    Attributes
    ----------
    estimates : mapping of str to Estimate
        By the names of the observables.
    attrs : mapping
        Scene, numerics, seed and versions, as texts or numbers.
    about : mapping of str to mapping
        Attributes of axes, such as their units, in place of those of `AXES`.
    along : mapping of str to (str, ndarray)
        Further labels along an axis, with its name: keys that vary together, or angles of directions.
    """

    estimates: Mapping[str, Estimate]
    attrs: Mapping[str, Any] = field(default_factory=dict)
    about: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    along: Mapping[str, tuple[str, Labels]] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Estimate:
        return self.estimates[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.estimates)

    def __len__(self) -> int:
        return len(self.estimates)

    def sel(self, **labels: Any) -> "Results":
        """Return the entries at labels of axes, as `Estimate.sel` of each observable."""
        chosen = {name: estimate.sel(**labels) for name, estimate in self.items()}
        return replace(self, estimates=chosen)

    def rows(self) -> Iterator[dict[str, Any]]:
        """Yield the tidy table: the rows of each observable after one another, in SI."""
        for estimate in self.values():
            yield from estimate.rows()

    def arrays(self) -> Iterator[Labelled]:
        """Yield the axes, then the arrays of each observable: name, names of its axes, data and attributes.

        NAME_part has the parts of the 95 % error of NAME over the axis "part" and the axes of NAME, NAME_total_error
        their root of squares, NAME_standard_error the statistical error of the mean, and NAME_bias the value at the
        finest level minus the mean. NAME_note marks entries that are not extrapolated or fixed by force balance.
        """
        flat = {name: one.without_no_speed() for name, one in self.items()}
        parts = list(dict.fromkeys(part for one in flat.values() for part in one.budget))
        axes = {"part": np.array(parts)}
        for one in flat.values():
            axes |= one.coords
        for name, labels in axes.items():
            of_axis = {"units": AXES[name]} if AXES.get(name) else {}
            attributes = self.about.get(name, of_axis)
            yield Labelled(name, (name,), labels, attributes)
        for name, (axis, labels) in self.along.items():
            yield Labelled(name, (axis,), labels, self.about.get(name, {}))
        for name, one in flat.items():
            unit = {"units": one.unit}
            nothing = np.where(one.stated, 0.0, np.nan)
            beside = {
                "_part": [one.budget.get(part, nothing) for part in parts],
                "_total_error": one.total_error,
                "_standard_error": one.standard_error,
                "_bias": one.bias,
            }
            tails = " ".join(name + tail for tail in (*beside, "_note"))
            yield Labelled(name, one.dims, one.mean, unit | {"ancillary_variables": tails})
            for tail, values in beside.items():
                dims = ("part", *one.dims) if tail == "_part" else one.dims
                about = unit | {"description": _TAILS[tail]}
                yield Labelled(name + tail, dims, np.array(values), about)
            notes, about = one.note.astype(str), {"description": _TAILS["_note"]}
            yield Labelled(name + "_note", one.dims, notes, about)

    def to_xarray(self) -> Any:
        """Return all `arrays` as an `xarray.Dataset`; ImportError without xarray."""
        return to_dataset(self.arrays(), self.along, self.attrs)


def to_dataset(
    arrays: Iterable[Labelled], beside: Collection[str], attrs: Mapping[str, Any]
) -> Any:
    """Return arrays as an `xarray.Dataset`; ImportError without xarray.

    Its coordinates are the axes, which have their own name as their only axis, and the arrays named in `beside`.
    """
    try:
        xarray = import_module("xarray")
    except ImportError:
        message = "xarray is not installed; type: pip install 'roughsim[xarray]'"
        raise ImportError(message) from None
    coordinates: dict[str, Any] = {}
    variables: dict[str, Any] = {}
    for name, *array in arrays:
        kind = coordinates if array[0] == (name,) or name in beside else variables
        kind[name] = tuple(array)
    return xarray.Dataset(variables, coordinates, dict(attrs))
