"""What an observable is: one record that says how it is measured, stored, averaged, and set beside the theory.

The realizations of one level enter through their influence values (the delta method): one row per realization, whose
mean is the observable and whose scatter gives its error. Ratios of observables then keep the pairing of the rows.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    from roughsim.grid import Grid
    from roughsim.observables.moments import Moments, SolvedContact

Array = NDArray[np.float64]


class Measured(Protocol):
    """What a number is measured of: one solved contact and its moments."""

    @property
    def grid(self) -> Grid:
        """The cell."""

    @property
    def contact(self) -> SolvedContact:
        """Pressure and areas."""

    @property
    def observables(self) -> Moments:
        """The moments, with all heat in the moving body."""


@dataclass(frozen=True, slots=True, eq=False)
class Theory:
    """What an observable may ask of the theory of a scene; all the heat goes into the moving body."""

    over_speed: dict[str, Array]  # T_flash, T′, ∇²T, D_flash and d_flash by name, (speeds,)
    heat_partition: Array  # the share of the moving body, (speeds,); NaN without a second one
    area_fractions: dict[str, float]  # `contact_fraction` and `plastic_fraction`
    correlation_radius: Callable[[float], float]  # of a fraction: the smallest r, m, with g_σ(r) = fraction·g_σ(0)
    # of weight(q), smooth in ln q: its sum or integral over the variance of the pressure, Pa² times its unit
    total: Callable[[Callable[[Array], Array]], float]


class Sample(NamedTuple):
    """The numbers of one level, a row per realization that has it.

    `numbers` has arrays (n, speeds) or (n, 1); `wavenumber` (m,), rad/m, and `spectrum` (n, m), Pa², are the radial
    stress spectra, which hold up to the distance `reach`, m. `side` is the number of points along a side, `rows` (n,)
    the place of each row among all realizations, ascending.
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
        return self.at(np.arange(count))


@dataclass(frozen=True, slots=True)
class Observable:
    """A quantity of a contact. Every run estimates it with its errors and sets it beside the theory.

    Parameters
    ----------
    name, unit : str
        Name in files, tables and `until`, and its SI unit.
    stored : str
        What exported files say of the number that the file of each member stores; empty: nothing is stored.
    measure : callable, optional
        Of a `Measured`: the stored number, or one for each speed. Left out: the attribute of its moments of this name.
    values : callable, optional
        Of a `Sample`: influence values (n, speeds) or (n, 1). Left out: the stored number.
    theory : callable, optional
        Of a `Theory`, which integrates or sums over the modes of a cell. Left out: the theory says nothing, NaN.
    only_stored : bool
        Whether it is stored for the sake of others and neither estimated nor compared.
    per_speed : bool
        Whether there is one for each speed of the scene.
    heated : bool
        Whether it is proportional to the heat, so that reports multiply it by the share of the moving body.
    spectra : bool
        Whether `values` needs the stress spectra of the sample, which are read from disk.
    at_rest : float, optional
        The exact value at speed zero, where it is measured at a tiny speed.
    limit : bool
        Whether capped contact has a limit in q_c, so that its value may be extrapolated.
    pixel_orders : (float, float)
        Order of convergence in the pixel at fixed q_c of elastic and of capped contact; all of the package's own were
        measured from 2 to 16 pixels per shortest wave. NaN for what turns back: it stays that of the finest grid, and
        once and a half the change to it counts as error.
    distance : bool
        Whether it is a distance in the field: it is extrapolated only where the shortest waves are shorter than it.
    by_force_balance : bool
        Whether force balance alone fixes it where all contact has yielded.
    """

    name: str
    unit: str
    stored: str = ""
    measure: Callable[[Measured], ArrayLike] | None = None
    values: Callable[[Sample], Array] | None = None
    theory: Callable[[Theory], ArrayLike] | None = None
    only_stored: bool = False
    per_speed: bool = False
    heated: bool = False
    spectra: bool = False
    at_rest: float | None = None
    limit: bool = True
    pixel_orders: tuple[float, float] = (2.0, 1.4)
    distance: bool = False
    by_force_balance: bool = False

    def of_member(self, measured: Measured) -> Array:
        """Return the number to store of one member, (speeds,) or (1,)."""
        value = getattr(measured.observables, self.name) if self.measure is None else self.measure(measured)
        return np.atleast_1d(np.asarray(value, dtype=np.float64))

    def of_level(self, sample: Sample) -> Array:
        """Return the influence values at one level, (realizations, speeds) or (realizations, 1)."""
        return sample.numbers[self.name] if self.values is None else self.values(sample)

    def of_theory(self, theory: Theory, speeds: int) -> Array:
        """Return what a view of the theory says at so many speeds, (speeds,) or (1,); NaN where it says nothing."""
        if self.theory is None:
            return np.full(speeds if self.per_speed else 1, np.nan)
        return np.atleast_1d(self.theory(theory))


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
