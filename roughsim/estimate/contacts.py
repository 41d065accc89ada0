"""`Contacts`: the contacts of a column, simulated or drawn, for means over the distribution of their temperature."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from roughsim.estimate.errors import SOURCES
from roughsim.estimate.levels import FLASH
from roughsim.estimate.mean import Mean
from roughsim.estimate.sliding import stretched
from roughsim.grid import Array
from roughsim.observables.distribution import BIN_AREAS
from roughsim.observables.record import Sample, bins_of

# of `form_uncertainty`: at 1, its fall, least and most. Set on 29 contacts that were drawn by chance, tested on 13
# others (experiments/reactions.py)
_AT_ONE = 0.17
_PER_E_FOLD = 0.02
_UNCERTAINTIES = (0.06, 0.24)
# how much warmer all is, over the uncertainty, of quantiles by heat, by area, and in bins: contact that the law lacks
# is cold. It has no heat, which shows once the form is better known
SHIFTS = (1.4, 1.4, 1.4)
# uncertainty of fields corrected at rest, at any speed, and their shifts: set in view of 68 drawn contacts, these
# 42 and 26 more. It is wide: 28 others have 99 % of the quantiles and all rates within
WALKED = 0.16, (0.0, 2.0, 0.5)
SETTLED: Array = np.ones((3, 1))  # a law by which nothing follows the highest cut-off


class Contacts(NamedTuple):
    """The contacts of a column, whose temperatures are scaled to its T_flash."""

    # of its levels, lowest first; or of slides alone, continued to the end of C(q), which have themselves as they were
    # followed as the level below
    samples: Sequence[Sample]
    flash: Mean  # reported T_flash, K
    area: Mean  # A/A₀
    background: Array  # T₀, absolute, K
    speeds: tuple[float, ...]  # m/s
    law: Array | None = (
        SETTLED  # T_flash at the upper cut-offs and at the end of C(q); None: unknown
    )
    end: float = 0.0  # of C(q), rad/m
    fall: float | None = None  # as `PIXEL_FALL`; None where no pixel changes the levels
    stretch: Array | None = (
        None  # of slides: growth of temperatures about T_flash up to the end of C(q)
    )
    form: Array | float | None = None  # relative uncertainty of drawn contacts by their form
    shifts: tuple[float, float, float] = SHIFTS
    sources: Mapping[str, str] = SOURCES  # the parts of an error, in words

    @property
    def all_samples(self) -> list[Sample]:
        """The samples of the levels and of those below."""
        both = (each for sample in self.samples for each in (sample.below, sample))
        return [each for each in both if each is not None]

    def by_form(self, value: Callable[[Sample], Array]) -> Array:
        """Return the error of a value by the form of drawn contacts, whose changes add as squares.

        Solved contacts are evener, the slower the more. The changes are those of `_displaced`.
        """
        top = self.samples[-1]
        uncertainty = np.asarray(self.form)
        if self.stretch is None or top.below is None:
            displaced = [*_displaced(top, uncertainty, self.shifts)]
        else:
            below = _displaced(top.below, uncertainty, self.shifts)
            displaced = [stretched(one, self.stretch) for one in below]
        plain = value(top)
        return np.sqrt(sum(np.square(value(other) - plain) for other in displaced))


def form_uncertainty(peclet_number: ArrayLike) -> Array:
    """Return how uncertain T/T_flash is by the form of the fields at v h_rms/(D h′), dimensionless."""
    with np.errstate(divide="ignore"):
        return np.clip(_AT_ONE - _PER_E_FOLD * np.log(peclet_number), *_UNCERTAINTIES)


def factor_of(sample: Sample, flash: Mean) -> Array:
    """Return the continued T_flash over the mean of a level, (speeds,)."""
    return flash.value / sample.numbers[FLASH].mean(axis=0)


def _displaced(
    sample: Sample, uncertainty: Array, shifts: tuple[float, float, float] = SHIFTS
) -> Iterator[Sample]:
    """Yield samples as far from a given one as its form is uncertain, 95 %, with the same T_flash.

    At the distance x from T_flash, over T_flash, the hotter, or the colder points, are nearer to it by
    `uncertainty`·x^(3/2); or all are hotter by `shifts` times the `uncertainty`.
    """
    flash = sample.numbers[FLASH].mean(axis=0)
    bins = bins_of(sample)
    hot = {name: values for name, values in sample.numbers.items() if "quantile" in name}
    apart = np.broadcast_to(uncertainty, flash.shape)
    over = bins.temperature / flash[:, None]
    heat = BIN_AREAS * bins.pressure
    for side in (1.0, -1.0):
        evened = _evened(over, apart[:, None], side)
        # they have another mean, but T_flash is given
        change = (heat * evened).sum(axis=(0, 2)) / (heat * over).sum(axis=(0, 2))
        unit = flash / change
        numbers = {
            name: unit * _evened(values / flash, apart, side) for name, values in hot.items()
        }
        yield replace(
            sample,
            numbers=sample.numbers | numbers,
            bins=bins._replace(temperature=unit[:, None] * evened),
        )
    by_heat, by_area, in_bins = (1.0 + shift * apart for shift in shifts)
    warm = {name: values * (by_area if "area" in name else by_heat) for name, values in hot.items()}
    yield replace(
        sample,
        numbers=sample.numbers | warm,
        bins=bins._replace(temperature=in_bins[:, None] * bins.temperature),
    )


def _evened(ratio: Array, uncertainty: Array, side: float) -> Array:
    """Return T/T_flash with the hotter points, `side` 1, or the colder ones, −1, nearer to 1."""
    excess = ratio - 1.0
    with np.errstate(divide="ignore"):  # further out all come to the same: the order stays
        apart = np.minimum(np.abs(excess), 4.0 / 9.0 / uncertainty**2)
    nearer = 1.0 + np.sign(excess) * (apart - uncertainty * apart**1.5)
    return np.where(side * excess > 0.0, nearer, ratio)
