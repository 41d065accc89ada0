"""What an observable is: a record that says how it is stored, averaged, and set beside the theory.

The realizations of one level enter through their influence values (the delta method): one row per realization, whose
mean is the observable and whose scatter gives its error. Ratios of observables then keep the pairing of the rows.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    from roughsim.prediction import Theory
    from roughsim.realization import Realization

Array = NDArray[np.float64]


class Sample(NamedTuple):
    """The numbers of one level, a row per realization that has it.

    `numbers` has arrays (n, speeds) or (n, 1); `wavenumber` (m,), rad/m, and `spectrum` (n, m), Pa², are the radial
    stress spectra, which hold up to the distance `reach`, m. `side` is the number of points along a side, `rows` (n,)
    the place of each row among all realizations.
    """

    q_max: float
    side: float
    rows: NDArray[np.intp]
    numbers: dict[str, Array]
    wavenumber: Array
    spectrum: Array
    reach: float

    def at(self, rows: NDArray[np.intp]) -> Sample:
        """Return the sample of some of its realizations."""
        chosen = np.isin(self.rows, rows)
        numbers = {name: values[chosen] for name, values in self.numbers.items()}
        return self._replace(rows=self.rows[chosen], numbers=numbers, spectrum=self.spectrum[chosen])

    def first(self, count: int) -> Sample:
        """Return the sample of those among the first `count` realizations."""
        rows = int(np.searchsorted(self.rows, count))
        numbers = {name: values[:rows] for name, values in self.numbers.items()}
        return self._replace(rows=self.rows[:rows], numbers=numbers, spectrum=self.spectrum[:rows])


@dataclass(frozen=True, slots=True)
class Number:
    """What the file of each realization stores.

    Parameters
    ----------
    name, unit, words : str
        Name in files, SI unit, and what exported files say that it is.
    measure : callable
        Of a `Realization`: one number, or one for each speed of the scene. Temperatures with all heat in the body.
    per_speed : bool
        Whether there is one for each speed.
    heated : bool
        Whether it is proportional to the heat, so that reports multiply it by the share of the moving body.
    """

    name: str
    unit: str
    words: str
    measure: Callable[[Realization], ArrayLike]
    per_speed: bool = False
    heated: bool = False


@dataclass(frozen=True, slots=True)
class Observable:
    """A quantity that every run is asked for: estimated with its errors and set beside the theory.

    Parameters
    ----------
    name, unit : str
        Name in tables, files and `until`, and its SI unit.
    per_speed, heated : bool
        As for `Number`.
    values : callable, optional
        Of a `Sample`: influence values (n, speeds) or (n, 1). Left out: the stored `Number` of the same name.
    spectra : bool
        Whether `values` needs the stress spectra of the sample, which are read from disk.
    theory : callable, optional
        Of a `Theory`, which integrates or sums over the modes of a cell. Left out: the theory says nothing, NaN.
    at_rest : float, optional
        The exact value at speed zero, where it is measured at a tiny speed.
    limit : bool
        Whether capped contact has a limit in q_c, so that its value may be extrapolated.
    pixel_orders : (float, float)
        Order of convergence in the pixel at fixed q_c of elastic and of capped contact; all of the package's own were
        measured from 2 to 16 pixels per shortest wave. NaN for what turns back: it stays that of the finest grid, and
        once and a half the change to it counts as error.
    distance : bool
        Whether it is a distance in the field: cut-offs tell what follows only where their shortest wave is shorter.
    by_force_balance : bool
        Whether force balance alone fixes it where all contact has yielded.
    """

    name: str
    unit: str
    per_speed: bool = False
    heated: bool = False
    values: Callable[[Sample], Array] | None = None
    spectra: bool = False
    theory: Callable[[Theory], ArrayLike] | None = None
    at_rest: float | None = None
    limit: bool = True
    pixel_orders: tuple[float, float] = (2.0, 1.4)
    distance: bool = False
    by_force_balance: bool = False


def power_of_ratio(above: Array, below: Array | float, power: float) -> Array:
    """Return influence values of (⟨above⟩/⟨below⟩)^power with the pairing of the rows kept; arrays (n, any)."""
    below = np.broadcast_to(below, above.shape)
    top, bottom = above.mean(axis=0), below.mean(axis=0)
    with np.errstate(all="ignore"):  # what is undefined here is NaN in the end
        value = (top / bottom) ** power
        change: Array = value * (1.0 + power * ((above - top) / top - (below - bottom) / bottom))
    return np.where(np.isfinite(change), change, value)


def ratio(above: Array, below: Array) -> Array:
    """Return influence values of ⟨above⟩/⟨below⟩ with the pairing of the rows kept."""
    return power_of_ratio(above, below, 1.0)


__all__ = ["Number", "Observable", "Sample", "power_of_ratio", "ratio"]
