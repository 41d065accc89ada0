"""The picture of one contact that slides in one direction over a face with a lay: its correlation across sliding.

A wave of the stress with the variance w has the mean square w|F|² of κT/q̇ in the picture, F with the lens. In a
periodic cell each wave stands for all those of its box in the plane of q, as long as the steps between waves, so |F|²
is its mean over that box. Without it a contact would meet its own track wherever waves lie on q·v = 0.
"""

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from roughsim.grid import Array, Complex, Grid
from roughsim.heat.periodic import MovingSource, response_of

_NEAR = 4.0  # half widths of a box along sliding: further from q·v = 0 |F|² is smooth, 4e-4
_NODES, _FEW = 16, 2  # over a part of a box near there, and over a side of the others
_ACROSS = 3  # nodes on the other side of a box near there
_LEAST = 1e-3  # of the width of a box across sliding: where it holds q = 0 or comes near
_MOST_TURNS = 60.0  # rad: more of a long exposure or slide are small beside the waves near q·v = 0
_KEPT = 2**20  # points up to which 32 sources are remembered, in 64 MB
_BLOCK = 1 << 12  # waves at once
Side = tuple[float, float]  # of a box along and across sliding, rad/m
_FINER = 16  # steps of q across sliding in one of the waves: cosines between them are linear to 5e-3 at half the cell


def variance_of(amplitude: Complex, grid: Grid) -> Array:
    """Return the variance of the stress of each wave of the half spectrum, Pa², by the transform of the pressure."""
    variance = (amplitude.real**2 + amplitude.imag**2) * grid.multiplicity
    variance[0, 0] = 0.0
    return variance


def correlation_across(
    variance: Array, grid: Grid, sources: Sequence[MovingSource], distance: Array
) -> Array:
    """Return Σ w ⟨|F|²⟩ cos(q·y) at distances y across sliding, m, of each source; (sources, distances), Pa² m²."""
    curves = []
    for source in sources:
        _, across = _turned(grid, source)
        step = min(grid.mode_spacing) / _FINER
        place = np.abs(across).ravel() / step
        below = place.astype(np.intp)
        power = (variance * mean_squares_of_waves(grid, source)).ravel()
        upper = power * (place - below)
        size = int(below.max()) + 2
        lower = np.bincount(below, power - upper, size)
        together = lower + np.bincount(below + 1, upper, size)
        q = step * np.arange(size)
        curves.append([float(np.sum(together * np.cos(q * y))) for y in distance.tolist()])
    return np.array(curves)


def _turned(grid: Grid, source: MovingSource) -> tuple[Array, Array]:
    """Return q along and across sliding of the half spectrum, rad/m."""
    qx, qy = grid.wavevectors
    rate = math.hypot(*source.drift)
    ux, uy = (part / rate for part in source.drift)
    return ux * qx + uy * qy, ux * qy - uy * qx


def mean_squares_of_waves(grid: Grid, source: MovingSource) -> NDArray[np.float32]:
    """Return ⟨|F|²⟩ over the box of each wave of the half spectrum, m²; 0 of q = 0.

    Waves at the Nyquist wavenumber count with one sign.
    """
    return (_remembered if grid.points <= _KEPT else _mean_squares)(grid, source)


def _mean_squares(grid: Grid, source: MovingSource) -> NDArray[np.float32]:
    rate = math.hypot(*source.drift)
    ux, uy = (part / rate for part in source.drift)
    dx, dy = grid.mode_spacing
    # along and across sliding
    first = ux * dx, -uy * dx
    second = uy * dy, ux * dy
    sides = sorted((first, second), key=lambda side: abs(side[0]))
    along, across = (part.ravel() for part in _turned(grid, source))
    width = sum(abs(ahead) for ahead, _ in sides)
    lengths = [source.spread * rate]  # of waves cos(q_sl) in |F|²
    if source.lens is not None:
        lengths += [source.lens.smear, source.lens.contact_length]
    turns = min(width * max(filter(math.isfinite, lengths), default=0.0), _MOST_TURNS)
    near = np.abs(along) < _NEAR * width / 2
    found = np.empty(along.size, np.float32)
    for waves, count, mean in (
        (np.flatnonzero(near), _NODES + int(2 * turns), _mean_near),
        (np.flatnonzero(~near), _FEW + int(turns / 2), _mean_far),
    ):
        for start in range(0, waves.size, _BLOCK):
            some = waves[start : start + _BLOCK]
            found[some] = mean(along[some], across[some], sides, source, count)
    found[0] = 0.0
    found.flags.writeable = False
    return found.reshape(grid.half_shape)


# .2 to 1 s for 512² points; the grids of a run come in turn
_remembered = lru_cache(maxsize=32)(_mean_squares)


def _mean_far(
    along: Array, across: Array, sides: Sequence[Side], source: MovingSource, count: int
) -> Array:
    """Return the mean over boxes far from q·v = 0, by `count` nodes on each side."""
    points, weights = legendre.leggauss(count)
    mean = np.zeros_like(along)
    for first, one in zip(points, weights, strict=True):
        for second, other in zip(points, weights, strict=True):
            s, c = (
                centre + (first * short + second * long) / 2
                for centre, short, long in zip((along, across), *sides, strict=True)
            )
            mean += one * other / 4 * _power(s, c, source)
    return mean


def _mean_near(
    along: Array, across: Array, sides: Sequence[Side], source: MovingSource, count: int
) -> Array:
    """Return the mean over boxes near q·v = 0.

    On the side that is longer along sliding q_s = few·sinh x; in x the peak 1/√(q_s² + few²) of |F|² is flat.
    """
    (short, aside), (long, tilted) = sides
    rate = math.hypot(*source.drift)
    points, weights = legendre.leggauss(count)
    young = 0.3 / (source.spread * rate)  # 0 of steady sliding
    mean = np.zeros_like(along)
    for first, one in zip(*legendre.leggauss(_ACROSS), strict=True):
        s = along + first * short / 2
        c = across + first * aside / 2
        tilt = tilted / long
        least = _LEAST * (abs(aside) + abs(tilted))
        few = np.maximum((c - tilt * s) ** 2, least**2) / rate
        few = np.maximum(few, young)
        low = s - abs(long) / 2
        high = s + abs(long) / 2
        peak = np.clip(0.0, low, high)
        for start, stop in ((low, peak), (peak, high)):
            first_x = np.arcsinh(start / few)
            last_x = np.arcsinh(stop / few)
            x = first_x[:, None] + (last_x - first_x)[:, None] * (1 + points) / 2
            at = few[:, None] * np.sinh(x)
            width = few[:, None] * np.cosh(x) * (last_x - first_x)[:, None] / 2
            power = _power(at, c[:, None] + tilt * (at - s[:, None]), source)
            mean += one / 2 * np.sum(weights * width * power, axis=1) / abs(long)
    return mean


def _power(along: Array, across: Array, source: MovingSource) -> Array:
    """Return |F|² of waves, m²."""
    response = response_of(along**2 + across**2, math.hypot(*source.drift) * along, source)
    return response.real**2 + response.imag**2
