"""The fit behind theory.calibrated: its form once more, over all points at once, and least squares on half the map.

The constants are those that theory.calibrated.CONSTANTS holds, in the same order. Points of the map with an even sum of
grid indices are fitted, up to q_1/q_r = 32; the others only judge.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from scipy.optimize import least_squares
from scipy.special import erf

from theory import calibrated
from validity_map import elastic, estimates
from validity_map.members import COLUMNS, FUNCTIONALS, kernel_matrix

SCORED = [
    *(("flash_temperature", k) for k in (0, 3, 6)),
    ("pressure_variance", 0),
    *(("flash_width", k) for k in (0, 3, 6)),
    *(("slope_length", k) for k in (3, 6)),
]
LIGHTEST = 0.005  # loads below the calibrated range still count, but less
LESS = 0.6
START = (1.9, 0.6, 0.85, -0.8, 0.6, -2.7, -2.1, 0.8, 1.6, 5.5, -2.7, -1.0, -0.9)
WIDEST = 32.0
FLOOR = 0.012  # added to the standard errors: no quantity is fitted beyond what the form can do
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(48)
_T = 0.5 * (_NODES + 1)
_USED = [
    COLUMNS[name].start + k for name in ("flash_temperature", "flash_gradient", "flash_laplacian") for k in (0, 3, 6)
]
_USED.append(COLUMNS["pressure_variance"].start)


class Sample:
    """C(q) of one point at quadrature nodes, its moments, and the kernels of the scored quantities."""

    def __init__(self, point: elastic.Point):
        self.load = point.load
        low, high = 1.0 / point.plateau, point.bandwidth
        q, width = _band_nodes(low, high)
        pieces = [(low, 1.0, point.low_exponent), (1.0, high, 2 + 2 * point.hurst)]
        below = {n: _moment(pieces, n, q) for n in (2, 3, 4, 7)}
        whole = {n: float(_moment(pieces, n, np.array([high]))[0]) for n in below}
        norm = 1 / (2 * np.pi * whole[3])  # rms slope 1
        level = norm * np.where(q < 1.0, q**-point.low_exponent, q ** (-2 - 2 * point.hurst))
        rate = np.pi / 4 * norm
        self.variance, self.whole = rate * below[3], rate * whole[3]
        self.later = rate * q * (whole[2] - below[2])
        self.first_later = rate * low * whole[2]
        self.memory, self.sharp = below[4] / (q * below[3]), below[7] / (q**4 * below[3])
        self.end_memory, self.end_sharp = whole[4] / (high * whole[3]), whole[7] / (high**4 * whole[3])
        self.band = np.pi / 2 * q**3 * level * width
        self.kernel = _kernel(q)
        tail = high / _T**4
        start, stop = (norm * x**-e for x, e in ((low, point.low_exponent), (high, 2 + 2 * point.hurst)))
        self.tail_ratio = high / tail
        self.tail = np.pi / 2 * high**3 * stop * 0.5 * _WEIGHTS * 4 * high * _T**-5
        self.tail_kernel = _kernel(tail)
        floor = low * _T**2
        self.floor = np.pi / 2 * low**2 * start * floor * 0.5 * _WEIGHTS * 2 * low * _T
        self.floor_kernel = _kernel(floor)


def _band_nodes(low: float, high: float) -> tuple[Any, Any]:
    cuts = [low, *([1.0] if low < 1.0 else [])]
    cuts += list(np.geomspace(1.0, high, int(np.ceil(np.log(high) / 1.4)) + 1)[1:])
    nodes, widths = [], []
    for k, (a, b) in enumerate(pairwise(cuts)):
        power = 2 if k == 0 else 1  # P falls as a square root just above q_min
        q = a * (b / a) ** (_T**power)
        nodes.append(q)
        widths.append(0.5 * _WEIGHTS * power * _T ** (power - 1) * np.log(b / a) * q)
    return np.concatenate(nodes), np.concatenate(widths)


def _moment(pieces: list[tuple[float, float, float]], order: int, q: Any) -> Any:
    """Return the integral of q^order C from q_min to q, C = 1 at q = 1."""
    total = np.zeros_like(q)
    for low, high, exponent in pieces:
        power = order + 1 - exponent
        top = np.clip(q, low, high)
        total += np.log(top / low) if abs(power) < 1e-12 else (top**power - low**power) / power
    return total


def _kernel(q: Any) -> Any:
    return kernel_matrix(q)[:, _USED]


def predicted(sample: Sample, constants: Any) -> Any:
    """Return ln Q of the scored quantities by the calibrated form."""
    c, a, b0, b1, b4, f, t0, t1, t2, t3, t4, u0, u4 = constants
    share = erf(sample.load / (2 * np.sqrt(sample.variance)))
    later = erf(sample.load / (2 * np.sqrt(sample.variance + c * sample.later)))
    weight = share**a * later ** (b0 + b1 * np.log(sample.memory) + b4 * np.log(sample.sharp))
    end = erf(sample.load / (2 * np.sqrt(sample.whole)))
    m, s, p = np.log(sample.end_memory), np.log(sample.end_sharp), np.log(end)
    edge = np.exp(t0 + t1 * p + t3 * m + t4 * s) * (1 - end) ** t2
    near = np.exp(u0 + u4 * s)
    tail = edge * sample.tail_ratio**3 * (1 + near * sample.tail_ratio**2)
    opening = erf(sample.load / (2 * np.sqrt(c * sample.first_later)))
    floor = np.exp(f) * opening**b0 * (1 - opening)
    sums = (sample.band * weight) @ sample.kernel + (sample.tail * tail) @ sample.tail_kernel
    sums += floor * sample.floor @ sample.floor_kernel
    full = np.ones(FUNCTIONALS)
    full[_USED] = sums
    return np.array([estimates.linear(full, quantity)[0] for quantity in SCORED])


def is_fitted(point: elastic.Point, loads: Any, hursts: Any, bandwidths: Any) -> bool:
    """Return whether a point of the grid belongs to the part that is fitted."""
    places = (
        list(axis).index(x) for axis, x in ((loads, point.load), (hursts, point.hurst), (bandwidths, point.bandwidth))
    )
    return point.bandwidth <= WIDEST and sum(places) % 2 == 0


def fit(chosen: list[tuple[elastic.Point, Any]], start: Any = START) -> tuple[Any, Any]:
    """Return the constants that fit the chosen points, and the misses ln(form/measured) there."""
    samples = [Sample(point) for point, _ in chosen]
    measured = [estimates.estimate(raw) for _, raw in chosen]
    target = np.array([[values[q][0] for q in SCORED] for values in measured])
    error = np.array([[values[q][1] / 2 for q in SCORED] for values in measured])

    def misses(constants: Any) -> Any:
        return np.array([predicted(sample, constants) for sample in samples]) - target

    weight = np.array([[1.0 if point.load >= calibrated.LIGHTEST else LESS] for point, _ in chosen])
    found = least_squares(
        lambda constants: (weight * misses(constants) / np.hypot(error, FLOOR)).ravel(),
        start,
        x_scale=np.abs(start) + 0.2,
    )
    return found.x, misses(found.x)
