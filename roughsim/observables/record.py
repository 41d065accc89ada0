"""`Observable`: one record of a quantity, with its measurement, storage, average and theory.

The realizations of one level enter through their influence values (the delta method): one row per realization, whose
mean is the observable and whose scatter gives its error. Ratios of observables then keep the pairing of the rows.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from roughsim.grid import Array, Grid, Index
from roughsim.observables.distribution import Bins

Made = TypeVar("Made")

if TYPE_CHECKING:  # slow to import: reading names and units alone must not wait for them
    from roughsim.contact import Contact
    from roughsim.observables.distribution import Distribution
    from roughsim.observables.moments import Moments


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Measured:
    """One solved contact and its measured numbers, with all heat in the moving body."""

    grid: Grid
    heights: Array  # of both faces together, shape `grid.shape`, m
    contact: "Contact"
    observables: "Moments"  # at the speeds of the scene, averaged over directions
    peak_volume: float  # of the surface (`surface.peak_volume`); zero if it was not drawn
    distribution: "Distribution | None" = None  # of the temperature, if the scene asks for it
    seen_99: Array | None = None  # of the picture of a camera, K, (speeds,), if the scene has one
    # of that picture across sliding over faces with a lay, as stored, (speeds, distances)
    seen_correlations: Any = None


class TheoryOfScene(NamedTuple):
    """The theory of a scene, as observables use it; all the heat goes into the moving body."""

    # by name of the observable. Arrays (speeds,): T_flash, T′, ∇²T, D_flash, d_flash, and the heat share of the moving
    # body (NaN without a second one). Numbers: contact and plastic fraction of the area
    values: Mapping[str, ArrayLike]
    nominal_pressure: float  # σ₀, Pa
    correlation_radius: Callable[
        [float], float
    ]  # of a fraction: the smallest r, m, with g_σ(r) = fraction·g_σ(0)
    # of a function weight(q), smooth in ln q: its sum or integral over the variance of the pressure, Pa² × its unit
    total: Callable[[Callable[[Array], Array]], float]
    # of a camera's observable, by its name: over the speed; NaN without one
    seen: Callable[[str], ArrayLike] = lambda _: np.nan


@dataclass(frozen=True, slots=True, eq=False)
class Sample:
    """The numbers of one level, a row for each realization that was solved at it.

    `replace` makes a record without what was `kept`.
    """

    q_max: float  # the cut-off of the level, rad/m
    side: float  # points along a side of the cell
    rows: Index  # (n,), the place of each row among all realizations, ascending
    numbers: dict[str, Array]  # stored ones by name, (n, speeds) or (n, 1)
    wavenumber: Array  # of the stress spectra, (m,), rad/m
    spectrum: Array  # (n, m), Pa²
    reach: float  # the distance up to which the spectra hold, m
    part: bool = False  # whether its cell is a part of the run's, with surfaces of its own
    # of the contact area of each realization, (n, speeds, bins); None: not stored
    bins: Bins | None = None
    level: int = 0  # its number
    stream: int = 0  # of its surfaces: levels of one stream see the same ones
    # the level below on the same surfaces; None at the lowest level
    below: "Sample | None" = None
    # what was made of it, by name
    _kept: dict[str, Any] = field(default_factory=dict, init=False, repr=False)

    def kept(self, name: str, make: "Callable[[Sample], Made]") -> Made:
        """Return what `make` makes of the sample, by its name; made the first time."""
        if name not in self._kept:
            self._kept[name] = make(self)
        made: Made = self._kept[name]
        return made


def bins_of(sample: Sample) -> Bins:
    """Return the bins of a sample; ValueError if its members have none."""
    if sample.bins is None:
        raise ValueError(
            "the members of this run have not stored the distribution of the temperature; run it again"
        )
    return sample.bins


@dataclass(frozen=True, slots=True)
class Observable:
    """A quantity of a contact. Every run estimates it with its errors and sets it beside the theory."""

    name: str  # in files, tables and `until`
    unit: str  # SI
    stored: str = ""  # description in exported files of the number that each member stores; empty: none is stored
    # takes a member to the number to store, or one for each speed; None: the attribute of its moments of this name
    measure: Callable[[Measured], ArrayLike] | None = None
    # influence values, (realizations, speeds) or (realizations, 1); None: the stored number
    values: Callable[[Sample], Array] | None = None
    # takes the theory to its value; None: its entry of this name, or NaN
    theory: Callable[[TheoryOfScene], ArrayLike] | None = None
    # other observables are made of it; by itself neither estimated nor compared
    only_stored: bool = False
    of_slide: bool = False  # members of the column "sliding" store it, and no others
    asked: str = (
        ""  # only scenes that ask for this have it: "distribution" of the temperature, or "camera"
    )
    # a temperature of the contact: over the cut-off it follows the law of T_flash by steps; its error by the pixel, too
    as_flash: bool = False
    per_speed: bool = False  # one for each speed of the scene
    # the observable whose theory continues it over the cut-off; empty: its own
    follows: str = ""
    # proportional to the heat: reports multiply it by the share of the moving body
    heated: bool = False
    # `values` needs the stress spectra of the sample, which are read from disk
    spectra: bool = False
    at_rest: float | None = None  # the exact value at speed zero, for one measured at a tiny speed
    # whether it has a limit in q_c in capped contact, so that it may be extrapolated
    limit: bool = True
    # orders of convergence in the pixel at fixed q_c, of elastic and of capped contact; all here were measured from 2
    # to 16 pixels per shortest wave. NaN if it converges non-monotonically with the pixel: then the value of the finest
    # grid stays, with 1.5 times the last change as its error
    pixel_orders: tuple[float, float] = (2.0, 1.4)
    distance: bool = False  # a distance in the plane: extrapolated only if the shortest waves are shorter than it
    by_force_balance: bool = False  # force balance alone fixes it once all contact has yielded
    # error of its mean by the contact solves over their tolerance: at most this was measured in elastic and capped
    # contact of all bundled scenes, for tolerances up to 1e-2
    solver_share: float = 2.0

    def of_member(self, measured: Measured) -> Array:
        """Return the number to store of one member, (speeds,) or (1,)."""
        measure = self.measure or (lambda one: getattr(one.observables, self.name))
        return np.atleast_1d(np.asarray(measure(measured), dtype=float))

    def of_level(self, sample: Sample) -> Array:
        """Return the influence values at one level, (realizations, speeds) or (realizations, 1)."""
        if self.values is None:
            return sample.numbers[self.name]
        return sample.kept(self.name, self.values)

    def of_theory(self, theory: TheoryOfScene, speeds: int) -> Array:
        """Return the value of the theory at so many speeds, (speeds,) or (1,); NaN without one."""
        nothing = np.full(speeds if self.per_speed else 1, np.nan)
        if self.theory is None:
            return np.atleast_1d(theory.values.get(self.name, nothing))
        return np.array(np.broadcast_to(self.theory(theory), nothing.shape))


def ratio(above: Array, below: Array, power: float = 1.0) -> Array:
    """Return influence values of (⟨above⟩/⟨below⟩)^power with the pairing of the rows kept; arrays (n, any)."""
    top = above.mean(axis=0)
    bottom = below.mean(axis=0)
    with np.errstate(all="ignore"):  # undefined ratios become NaN
        value = (top / bottom) ** power
        change = value * (1.0 + power * ((above - top) / top - (below - bottom) / bottom))
    return np.where(np.isfinite(change), change, value)
