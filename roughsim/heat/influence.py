"""The temperature that one heated pixel makes at all others, on the free half-space.

Heat released at a point of the surface a time τ ago has spread over √(Dτ) and lags v τ behind. Summed over a pixel it
is a product of one factor along x and one along y, and with u = √(Dτ) the temperature of a pixel with unit flux is

    κT = (2/√π) ∫₀^√(Dt) f(u) E(x, a) E(y, b) du,    f = e^(−z²/4u²),
    E(x, a) = ½ erf((x + p u² + a/2)/2u) − ½ erf((x + p u² − a/2)/2u),   p = v/D along that axis

(Carslaw & Jaeger, 10.2 and 10.7). It is taken at the centres of the pixels, at points shifted from there, or as the
mean over each pixel: then E is [J(x + a) − 2J(x) + J(x − a)]/2a with J(x) the integral of erf((x + p u²)/2u). All
offsets share the nodes in u, so each panel of nodes is one matrix product, over those offsets alone that the heat has
reached by then and not yet left.
"""

import math
from bisect import bisect_left
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy

from roughsim.grid import Array

_REACH = 10.0  # in units of u: erfc(10/2) = 2e-12 of the heat has gone further
_STEP = 5.0  # a panel at the passage of heat over the edge of a pixel, in units of the width 1/p of that passage
_FAR = 300.0  # in units of the box: beyond it the heat has spread so far that a closed form is exact to 1e-9
_GROWTH = 4.0  # of u over a panel: 16 nodes then err by less than 1e-9 of the influence of a pixel on itself
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)


@dataclass(frozen=True, slots=True)
class PixelAxis:
    """One axis of the grid: `count` pixels of side `size`, drift = v/D along it; lengths in any one unit.

    The temperature is taken `shift` pixels from the centres, |shift| ≤ ½, or `averaged` over each pixel.
    """

    count: int
    size: float
    drift: float
    shift: float = 0.0
    averaged: bool = False

    @property
    def mirrored(self) -> bool:
        """Whether the influence is even along this axis."""
        return self.drift == 0.0 and self.shift == 0.0

    @property
    def extent(self) -> float:
        """Distance over which heat matters to the grid."""
        return (self.count + 0.5) * self.size

    @property
    def start(self) -> float:
        """A u before which heat has neither left its pixel nor spread to its edge from the point.

        On an edge, or for the mean, it spreads over the edge at once: there it must not yet have drifted as far.
        """
        inside = 0.0 if self.averaged else (0.5 - abs(self.shift)) * self.size
        p = abs(self.drift)
        if inside > 0.0:
            return min(inside / 26, math.sqrt(inside / (2 * p)) if p else math.inf)
        return min(self.size / 52, 1 / p if p else math.inf)

    @property
    def end(self) -> float:
        """The u after which the heat lies behind the whole grid."""
        p = abs(self.drift)
        root = math.sqrt(_REACH**2 + 4 * p * (self.extent + self.size))
        return (_REACH + root) / (2 * p) if p > 0.0 else math.inf

    @property
    def peclet(self) -> float:
        """Péclet number of a pixel."""
        return abs(self.drift) * self.size

    def reached(self, low: float, high: float) -> tuple[int, int]:
        """First and last offset, in pixels, that heat of the age low < u < high can be over."""
        shifts = (-self.drift * low**2, -self.drift * high**2)
        reach = self.size + _REACH * high
        end = float(self.count - 1)
        first = max((min(shifts) - reach) / self.size, -end)
        last = min((max(shifts) + reach) / self.size, end)
        return math.ceil(first), math.floor(last)

    def share(self, offsets: Array, u: Array) -> Array:
        """E(x, a): share of a pixel's heat over the point, or over the pixel, at each offset; shape (offsets, u)."""
        if self.averaged:
            sides = np.concatenate((offsets[:1] - 1, offsets, offsets[-1:] + 1))
        else:
            sides = np.append(offsets - 0.5, offsets[-1] + 0.5) + self.shift
        edges = sides[:, None] * self.size
        scaled = (edges + self.drift * u**2) / (2 * u)
        risen = scipy.special.erf(scaled)
        if self.averaged:
            tail = np.exp(-(scaled**2)) / math.sqrt(math.pi)
            integral = scaled * risen + tail
            return np.diff(integral, 2, axis=0) * (u / self.size)
        return (risen[1:] - risen[:-1]) / 2


class Fading(NamedTuple):
    """A factor f of the heat by its age, and where it changes."""

    factor: Callable[[Array], Array]  # of u
    first: float  # u up to which the factor is constant, or analytic
    last: float  # u from which on it is smooth in 1/u
    nothing: float = 0.0  # u up to which it is 0


def buried(depth: float) -> Fading:
    """Return the factor e^(−z²/4u²) at a depth z."""
    nothing = depth / 13  # e^(−13²/4) = 4e-19
    return Fading(lambda u: np.exp(-((depth / (2 * u)) ** 2)), math.inf, depth, nothing)


def one_sided_influence(x: PixelAxis, y: PixelAxis, *, fading: Fading, end: float) -> Array:
    """Return κT at all offsets for unit flux on the pixel at 0, in the unit of length of the axes.

    `end` is √(Dt), t the time since the start from rest; inf is the steady state. Shape (2 n_x − 1, 2 n_y − 1), offsets
    from −(n − 1) to n − 1 pixels; without the negative offsets of an axis y along which it is even.
    """
    before_x = 0 if x.mirrored else x.count - 1  # negative offsets along x
    before_y = 0 if y.mirrored else y.count - 1
    rows = (-before_x, x.count - 1)
    columns = (-before_y, y.count - 1)
    result = np.zeros((x.count + before_x, y.count + before_y))
    for row, column, along, across in _shares(x, y, fading, end, rows, columns):
        part = result[row + before_x :, column + before_y :]
        part[: len(along), : len(across)] += along @ across.T
    # the oldest heat is the same at all offsets but for a factor along each axis
    oldest = _oldest_heat(x, y, fading, end)
    if oldest:
        result += oldest * _slants(x, before_x)[:, None] * _slants(y, before_y)
    return np.concatenate((result[:0:-1], result)) if x.mirrored else result


def temperature_at(
    pixel: tuple[int, int], flux: Array, x: PixelAxis, y: PixelAxis, *, fading: Fading, end: float
) -> float:
    """Return κT at the point of one pixel that the shifts of the axes name, for a flux on all pixels."""
    i, j = pixel
    rows = (i + 1 - x.count, i)
    columns = (j + 1 - y.count, j)
    total = 0.0
    for row, column, along, across in _shares(x, y, fading, end, rows, columns):
        reaching = flux[: i - row + 1, : j - column + 1]
        part = reaching[-len(along) :, -len(across) :]
        total += float((along[::-1] * (part @ across[::-1])).sum())
    oldest = _oldest_heat(x, y, fading, end)
    if oldest:
        along = _slants(x, x.count - 1)[i : i + x.count][::-1]
        across = _slants(y, y.count - 1)[j : j + y.count][::-1]
        total += oldest * float(along @ flux @ across)
    return total


def _shares(
    x: PixelAxis,
    y: PixelAxis,
    fading: Fading,
    end: float,
    rows: tuple[int, int],
    columns: tuple[int, int],
) -> Iterator[tuple[int, int, Array, Array]]:
    """Yield for each panel the first offsets in `rows` and `columns` that heat reaches, and the shares from there on.

    Shares along x, with the weights of the nodes, and along y, each of shape (offsets, nodes).
    """
    for nodes, weights, reach in _rules(x, y, fading, end):
        first_row, last_row = x.reached(*reach)
        first_row = max(first_row, rows[0])
        last_row = min(last_row, rows[1])
        first_column, last_column = y.reached(*reach)
        first_column = max(first_column, columns[0])
        last_column = min(last_column, columns[1])
        if first_row <= last_row and first_column <= last_column:
            along = x.share(np.arange(first_row, last_row + 1.0), nodes) * weights
            across = y.share(np.arange(first_column, last_column + 1.0), nodes)
            yield first_row, first_column, along, across


def _rules(
    x: PixelAxis, y: PixelAxis, fading: Fading, end: float
) -> Iterator[tuple[Array, Array, tuple[float, float]]]:
    """Yield nodes in u, weights, and the interval of u that they integrate over."""

    def faded(weights: Array, nodes: Array) -> Array:
        return weights * (2 / math.sqrt(math.pi) * fading.factor(nodes))

    for low, high in _panels(x, y, fading, end):
        nodes = (low + high) / 2 + (high - low) / 2 * _NODES
        yield nodes, faded((high - low) / 2 * _WEIGHTS, nodes), (low, high)
    start = max(x.extent, y.extent, fading.last)
    if x.drift == y.drift == 0.0 and end > start:
        # at rest the integrand is smooth in 1/u to the end, and the heat is over the whole box already
        low = 1 / end
        high = 1 / start
        nodes = 1 / ((low + high) / 2 + (high - low) / 2 * _NODES)
        yield nodes, faded((high - low) / 2 * _WEIGHTS * nodes**2, nodes), (start, start)


def _panels(
    x: PixelAxis, y: PixelAxis, fading: Fading, end: float
) -> Iterator[tuple[float, float]]:
    """Panels in u: each grows by a factor at most, and none is wider than the passage of an edge of a pixel in it."""
    spread = max(x.extent, y.extent, fading.last)  # the heat is over the box by then
    at_rest = x.drift == y.drift == 0.0
    last = min(end, x.end, y.end, spread * (1.0 if at_rest else _FAR))
    low = min(fading.nothing or min(x.start, y.start, fading.first), last)
    if low > fading.nothing:
        yield 0.0, low
    passages = [_passages(axis) for axis in (x, y) if axis.drift]
    while low < last:
        high = min([_GROWTH * low, last, *(panel_end(low) for panel_end in passages)])
        yield low, high
        low = high


def _oldest_heat(x: PixelAxis, y: PixelAxis, fading: Fading, end: float) -> float:
    """κT by heat older than `_FAR` boxes, without its factor e^(−p·x/2): ab/4π · (2/√π) ∫ e^(−p²u²/4)/u² du."""
    start = _FAR * max(x.extent, y.extent, fading.last)
    p = math.hypot(x.drift, y.drift)
    if p == 0.0 or min(end, x.end, y.end) <= start:
        return 0.0

    def older(u: float) -> float:
        if math.isinf(u):
            return 0.0
        x = p * u / 2
        return math.exp(-(x**2)) / u - p * math.sqrt(math.pi) / 2 * math.erfc(x)

    faded = float(fading.factor(np.array([start]))[0])
    strength = faded * x.size * y.size / (2 * math.pi**1.5)
    return float(strength * (older(start) - older(end)))


def _slants(axis: PixelAxis, before: int) -> Array:
    """e^(−p·x/2) at the offsets −before … n − 1."""
    places = np.arange(-before, axis.count) + axis.shift
    return np.exp(-axis.drift * axis.size / 2 * places)


def _passages(axis: PixelAxis) -> Callable[[float], float]:
    """Return the end of a panel, as a function of its start, so that none is wider than the passage of an edge in it.

    Edges of pixels at −ka pass over a heated line at u = √(ka/p), within a few 1/p.
    """
    # distances behind the source, in pixels, at which edges of pixels lie
    first = (
        0.0 if axis.averaged else (0.5 - math.copysign(axis.shift, axis.shift * axis.drift)) % 1.0
    )
    width = 1 / abs(axis.drift)
    margin = _REACH * 0.6 * width
    times = np.sqrt(np.arange(first, axis.count + 1.0) * axis.size * width).tolist()

    def panel_end(low: float) -> float:
        k = bisect_left(times, low - margin * (1 - 1e-9))
        if k == len(times):
            return math.inf
        opening = times[k] - margin
        return low + _STEP * width if opening <= low * (1 + 1e-12) else float(opening)

    return panel_end
