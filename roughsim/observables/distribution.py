"""Distribution of the temperature over one contact: quantiles by heat and by area, and bins of the contact area.

The bins hold more than the quantiles: any mean over the contact of a function of temperature and pressure, such as a
rate of reaction, follows from them. They are ordered from the coldest contact to the hottest. Eight of equal area
divide the colder half; in the hotter half, three divide each halving of the area that is hotter, down to 2^−14 of it.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from roughsim.grid import Array

LEVELS = {
    "05": 0.05,
    "25": 0.25,
    "50": 0.5,
    "75": 0.75,
    "90": 0.9,
    "99": 0.99,
    "999": 0.999,
}  # of quantiles, by name
_HALVINGS = 13  # of the hotter half of the area
_PER_HALVING = 3
_HOTTER = np.concatenate(  # fraction of the contact area that is hotter than each edge of a bin, from the coldest one on
    [
        np.linspace(1.0, 0.5, 9),
        0.5 ** (1.0 + np.arange(1, _PER_HALVING * _HALVINGS + 1) / _PER_HALVING),
        [0.0],
    ]
)
BIN_AREAS: Array = -np.diff(_HOTTER)  # fraction of the contact area in each bin
_BISECTIONS = 25  # of the span of all temperatures
_ROUNDING = 1e-5  # of the mean pressure: a smaller deviation within a bin is rounding


class Bins(NamedTuple):
    """Temperature and pressure in bins of the contact area; arrays (..., bins), the areas are `BIN_AREAS`."""

    temperature: Array  # mean, K
    pressure: Array  # mean, Pa
    pressure_deviation: Array  # standard deviation, Pa
    pressure_skewness: Array  # third moment about the mean over the cube of the deviation


class Distribution(NamedTuple):
    """Distribution of the temperature over one contact, at each speed."""

    by_heat: Array  # quantiles at `LEVELS`, weighted by the heat, K, (speeds, levels)
    by_area: Array  # the same weighted by the area
    bins: Bins  # (speeds, bins)


def weighted_quantiles(values: Array, weights: Array, levels: Array) -> Array:
    """Return the quantiles of ascending values at some levels between 0 and 1.

    A value stands at the middle of its own weight; between values the quantile is linear.
    """
    total = np.cumsum(weights)
    return np.interp(levels * total[-1], total - 0.5 * weights, values)


def area_quantiles(values: Array, levels: Array) -> Array:
    """Return `weighted_quantiles` of values with equal weights."""
    place = np.clip(levels * values.size - 0.5, 0.0, values.size - 1.0)
    below = place.astype(np.intp)
    above = np.minimum(below + 1, values.size - 1)
    return values[below] + (place - below) * (values[above] - values[below])


def binned(temperature: Array, pressure: Array) -> Bins:
    """Return the bins of the pixels of a contact: temperatures ascending, K, with their pressures > 0, Pa; (n,) each.

    A pixel belongs to each bin in proportion to its area there, so that means over all bins are means over all pixels.
    """
    unit = float(pressure.mean())
    relative = pressure / unit
    squares = relative * relative
    rows = np.stack([temperature, relative, squares, squares * relative])
    means = _sums(rows) / (temperature.size * BIN_AREAS)
    mean_temperature, mean, square, cube = means
    deviation = np.sqrt(np.maximum(square - mean**2, 0.0))
    deviation = np.where(deviation > _ROUNDING * mean, deviation, 0.0)
    third = cube - 3.0 * mean * square + 2.0 * mean**3
    skewness = np.divide(third, deviation**3, out=np.zeros_like(third), where=deviation > 0.0)
    return Bins(mean_temperature, unit * mean, unit * deviation, skewness)


def _sums(rows: Array) -> Array:
    """Return the sums of rows of pixels, (n, pixels), over the bins, (n, bins), with the parts of pixels at edges."""
    pixels = rows.shape[1]
    rows = rows[:, ::-1]  # from the hottest pixel on, as the hottest bins are the smallest
    edges = _HOTTER[::-1] * pixels
    at_edge = np.minimum(edges.astype(np.intp), pixels - 1)
    part = rows[:, at_edge] * (edges - at_edge)  # of the pixel at each edge
    # from the pixel at an edge up to that at the next one
    whole = np.add.reduceat(rows, at_edge[:-1], axis=1)
    whole[:, -1] -= rows[:, -1]
    whole[:, at_edge[:-1] == at_edge[1:]] = 0.0  # both edges in one pixel
    return (whole + np.diff(part, axis=1))[:, ::-1]


def two_pressures(bins: Bins) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Return the pressures, Pa, and shares of two points that have mean, deviation and skewness of each bin.

    They are the nodes and weights of the Gauss rule of two points: m + d (γ/2 ± √(1 + γ²/4)).
    """
    half = 0.5 * bins.pressure_skewness
    root = np.sqrt(1.0 + half**2)
    upper = 0.5 * (1.0 - half / root)
    low, high = (
        bins.pressure + bins.pressure_deviation * (half + sign * root) for sign in (-1.0, 1.0)
    )
    return (low, 1.0 - upper), (high, upper)


def areas_of(bins: Bins) -> Array:
    """Return the areas of the bins of all contacts, (n, speeds, bins), over the mean area of a contact.

    Each contact bears the same load: its area is in proportion to 1 over its mean pressure.
    """
    whole = 1.0 / (bins.pressure @ BIN_AREAS)
    return BIN_AREAS * (whole / whole.mean(axis=0))[..., None]


class Shares(NamedTuple):
    """Distribution functions of the temperature of contacts by heat or area, linear between the middles of bins."""

    temperature: Array  # of bins, ascending, K, the first and the last twice, (n, speeds, bins + 2)
    below: Array  # share of a contact below the middle of each bin, from 0 to 1
    of_contact: Array  # heat or area of each contact over the mean of all, (n, speeds)

    def colder(self, temperature: Array) -> Array:
        """Return the share of each contact, (n, speeds, any), that is colder than temperatures, K.

        They are (speeds, any) or (n, speeds, any). NaN of contacts of unknown temperatures.
        """
        place = (self.temperature[..., None, :] <= temperature[..., None]).sum(axis=-1)
        ends = np.maximum(place - 1, 0), np.minimum(place, self.temperature.shape[-1] - 1)
        start, end = (np.take_along_axis(self.temperature, k, axis=-1) for k in ends)
        below, above = (np.take_along_axis(self.below, k, axis=-1) for k in ends)
        # bins of one temperature ascend but for rounding
        part = np.divide(temperature - start, end - start, out=0.0 * start, where=end > start)
        return below + (above - below) * np.clip(part, 0.0, 1.0)


def shares_of(bins: Bins, weight: str) -> Shares:
    """Return the distribution functions of contacts, weighted by "heat" or "area"."""
    weights = areas_of(bins) * (bins.pressure if weight == "heat" else 1.0)
    total = np.cumsum(weights, axis=-1)
    below = (total - 0.5 * weights) / total[..., -1:]
    ends = (0, 0), (0, 0), (1, 1)
    of_contact = weights.sum(axis=-1)
    return Shares(
        np.pad(bins.temperature, ends, "edge"),
        np.pad(below, ends, constant_values=(0.0, 1.0)),
        of_contact / of_contact.mean(axis=0),
    )


class Pooled(NamedTuple):
    """Quantiles over all contacts together."""

    rows: Array  # influence values, (n, speeds, levels), K
    known: Array  # whether the contacts show its scatter, (speeds, levels)


def pooled_quantiles(shares: Shares, of_contacts: Array, levels: Array) -> Pooled:
    """Return quantiles over all contacts together.

    A contact of few hot spots has too few for its own highest quantiles, `of_contacts`, (n, speeds, levels), K: their
    mean is biased. The share below the quantile q of all contacts scatters by its standard error e, and q by this
    scatter times its slope between the levels ± 2 e (R.S. Woodruff, J. Am. Stat. Assoc. 47, 635, 1952), unknown if
    these leave 0 to 1. The width of the bins errs alike in the quantiles of each contact, which are known without it.
    """
    coldest, hottest = (shares.temperature[..., k, None] for k in (0, -1))
    of_contact = shares.of_contact[..., None]

    def together(at: Array) -> tuple[Array, Array]:
        ends = coldest.min(axis=0), hottest.max(axis=0)
        return crossing(lambda t: (of_contact * shares.colder(t)).mean(axis=0), at, *ends)

    # one pixel may hold much of a small contact: where the share jumps, the side on which it scatters more
    pooled = np.where(levels > 0.5, *together(levels))
    apart = of_contact * (levels - shares.colder(pooled))
    apart -= apart.mean(axis=0)
    error = np.sqrt((apart**2).sum(axis=0) / (len(apart) * max(len(apart) - 1, 1)))
    low, high = levels - 2.0 * error, levels + 2.0 * error
    rise = together(high)[1] - together(low)[1]
    slope = np.divide(rise, high - low, out=np.zeros_like(rise), where=high > low)
    by_bins = of_contacts - crossing(shares.colder, levels, coldest, hottest)[1]
    return Pooled(pooled + slope * apart + by_bins.mean(axis=0), (low >= 0.0) & (high <= 1.0))


def crossing(
    share: Callable[[Array], Array], level: Array | float, low: Array, high: Array
) -> tuple[Array, Array]:
    """Return temperatures just below and above the place between two others where a share rises past a level."""
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        below = share(middle) < level
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return low, high
