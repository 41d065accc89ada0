"""A contact solver as an able user would write it in a day: a peer of `benchmarks/contact.py`.

Conjugate gradients of Polonsky & Keer (Wear 231, 1999, 206), elastic, with FFTW plans that are measured and loops that
are compiled and fused. One thread, float64.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numba
import numpy as np
import pyfftw


@numba.njit(cache=True, fastmath=True)
def contact_mean(p: Any, field: Any) -> float:
    """Mean of a field over the contact."""
    total, count = 0.0, 0
    for i in range(p.size):
        if p[i] > 0.0:
            total += field[i]
            count += 1
    return total / count


@numba.njit(cache=True, fastmath=True)
def gap_of(u: Any, heights: Any, p: Any, gap: Any) -> float:
    """Fill the gap, its mean over the contact taken off; return Σ gap² over the contact."""
    total, count = 0.0, 0
    for i in range(u.size):
        gap[i] = u[i] - heights[i]
        if p[i] > 0.0:
            total += gap[i]
            count += 1
    mean, square = total / count, 0.0
    for i in range(u.size):
        gap[i] -= mean
        if p[i] > 0.0:
            square += gap[i] * gap[i]
    return square


@numba.njit(cache=True, fastmath=True)
def direction(p: Any, gap: Any, beta: float, step: Any, buffer: Any) -> None:
    """Fill the next direction, also into the buffer of the transform."""
    for i in range(p.size):
        step[i] = gap[i] + beta * step[i] if p[i] > 0.0 else 0.0
        buffer[i] = step[i]


@numba.njit(cache=True, fastmath=True)
def length_of(p: Any, gap: Any, step: Any, response: Any) -> float:
    """Length of the step."""
    mean, above, below = contact_mean(p, response), 0.0, 0.0
    for i in range(p.size):
        if p[i] > 0.0:
            above += gap[i] * step[i]
            below += (response[i] - mean) * step[i]
    return above / below


@numba.njit(cache=True, fastmath=True)
def advance(p: Any, gap: Any, step: Any, length: float, buffer: Any) -> Any:
    """Move, clip, and let overlapping points join the contact; the old pressure stays in the buffer.

    Return the sum of the pressures and how many points joined.
    """
    total, joined = 0.0, 0
    for i in range(p.size):
        buffer[i] = p[i]
        x = max(p[i] - length * step[i], 0.0)
        if x == 0.0 and gap[i] < 0.0:
            x = -length * gap[i]
            joined += 1
        p[i] = x
        total += x
    return total, joined


@numba.njit(cache=True, fastmath=True)
def rescale(p: Any, factor: float, buffer: Any) -> float:
    """Restore the load, leave the pressure in the buffer, and return Σ |change|."""
    change = 0.0
    for i in range(p.size):
        x = factor * p[i]
        change += abs(x - buffer[i])
        p[i], buffer[i] = x, x
    return change


@lru_cache(maxsize=8)  # also of the nested grids of `preconditioned`
def plans(points: int) -> tuple[Any, ...]:
    """Buffers, measured plans of both directions, and the compliance 2/|q| of the unit cell, E* = 1."""
    field = pyfftw.empty_aligned((points, points), "float64")
    spectrum = pyfftw.empty_aligned((points, points // 2 + 1), "complex128")
    there = pyfftw.FFTW(field, spectrum, axes=(0, 1), flags=("FFTW_MEASURE", "FFTW_DESTROY_INPUT"))
    back = pyfftw.FFTW(
        spectrum,
        field,
        axes=(0, 1),
        direction="FFTW_BACKWARD",
        flags=("FFTW_MEASURE", "FFTW_DESTROY_INPUT"),
    )
    q = (
        2
        * np.pi
        * np.hypot(np.fft.fftfreq(points, 1 / points)[:, None], np.arange(points // 2 + 1))
    )
    q[0, 0] = np.inf
    return field, spectrum, there, back, 2.0 / q / points**2


def solve(heights: np.ndarray, load: float, tolerance: float, most: int = 20000) -> np.ndarray:
    """Return the pressure; `tolerance` is on Σ |change of p| / Σ p in one iteration. RuntimeError if it is not met."""
    field, spectrum, there, back, compliance = plans(heights.shape[0])
    buffer, h = field.ravel(), heights.ravel()
    p, gap, step = np.full(h.size, load), np.empty(h.size), np.zeros(h.size)
    field[...] = load
    last, conjugate = 1.0, 0.0
    for _ in range(most):
        there.execute()
        spectrum *= compliance
        back.execute()
        square = gap_of(buffer, h, p, gap)
        direction(p, gap, conjugate * square / last, step, buffer)
        there.execute()
        spectrum *= compliance
        back.execute()
        total, joined = advance(p, gap, step, length_of(p, gap, step, buffer), buffer)
        last, conjugate = square, 0.0 if joined else 1.0
        if rescale(p, load * p.size / total, buffer) <= tolerance * load * p.size:
            return p.reshape(heights.shape)
    raise RuntimeError(f"tolerance {tolerance:.0e} not met in {most} iterations")
