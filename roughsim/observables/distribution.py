"""Distribution of the temperature over one contact: quantiles by heat and by area, and bins of the contact area.

The bins hold more than the quantiles: any mean over the contact of a function of temperature and pressure, such as a
rate of reaction, follows from them. They are ordered from the coldest contact to the hottest. Eight of equal area
divide the colder half; in the hotter half, three divide each halving of the area that is hotter, down to 2^−14 of it.
"""

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
