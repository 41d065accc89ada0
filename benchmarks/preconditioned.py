"""A contact solver as an able user writes it in a day with the right paper: a peer of `benchmarks/contact.py`.

Elastic contact by conjugate gradients on the bounded pressure, preconditioned by |q| on the contact (Vollebregt, J.
Optim. Theory Appl. 162, 2014, 931), on nested grids that double from 64² points; FFTW plans that are measured, loops
that are compiled and fused. One thread, float64.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numba
import numpy as np
import pyfftw

COARSEST = 64


@numba.njit(cache=True, fastmath=True)
def residual(u: Any, heights: Any, p: Any, gap: Any, buffer: Any) -> None:
    """Fill the gap less its mean over the contact; in the buffer it is zero outside."""
    total, count = 0.0, 0
    for i in range(u.size):
        gap[i] = u[i] - heights[i]
        if p[i] > 0.0:
            total += gap[i]
            count += 1
    mean = total / count
    for i in range(u.size):
        gap[i] -= mean
        buffer[i] = gap[i] if p[i] > 0.0 else 0.0


@numba.njit(cache=True, fastmath=True)
def direction(p: Any, z: Any, gap: Any, old: Any, step: Any, last: float) -> Any:
    """Fill the next direction, of mean zero over the contact, by Polak and Ribière; return gap·z and gap·step."""
    total, count = 0.0, 0
    for i in range(p.size):
        if p[i] > 0.0:
            total += z[i]
            count += 1
    mean, now, before = total / count, 0.0, 0.0
    for i in range(p.size):
        if p[i] > 0.0:
            z[i] -= mean
            now += gap[i] * z[i]
            before += old[i] * z[i]
    beta = max((now - before) / last, 0.0) if last > 0.0 else 0.0
    total = 0.0
    for i in range(p.size):
        step[i] = z[i] + beta * step[i] if p[i] > 0.0 else 0.0
        total += step[i]
    mean, slope = total / count, 0.0
    for i in range(p.size):
        if p[i] > 0.0:
            step[i] -= mean
            slope += gap[i] * step[i]
            old[i] = gap[i]
        else:
            old[i] = 0.0
        z[i] = step[i]
    return now, slope


@numba.njit(cache=True, fastmath=True)
def curvature(step: Any, response: Any) -> float:
    """Return step·response."""
    total = 0.0
    for i in range(step.size):
        total += step[i] * response[i]
    return total


@numba.njit(cache=True, fastmath=True)
def advance(p: Any, gap: Any, step: Any, length: float, stiffness: float, load: float) -> Any:
    """Move, clip, let overlapping points join, and restore the load; return Σ |change| and whether any joined."""
    total, change, joined = 0.0, 0.0, False
    for i in range(p.size):
        x = p[i] - length * step[i]
        if p[i] == 0.0 and gap[i] < 0.0:
            x = -stiffness * gap[i]
            joined = True
        x = max(x, 0.0)
        change += abs(x - p[i])
        p[i] = x
        total += x
    factor = load * p.size / total
    for i in range(p.size):
        p[i] *= factor
    return change + abs(factor - 1.0) * total, joined


@lru_cache(maxsize=8)  # of the nested grids
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


def on_grid(h: np.ndarray, p: np.ndarray, load: float, tolerance: float, most: int) -> np.ndarray:
    """Return the pressure on one grid from a guess."""
    points = h.shape[0]
    field, spectrum, there, back, compliance = plans(points)
    stiffness = np.zeros_like(compliance)  # |q|/2 by the same scale; 0 of the mean
    np.divide(1.0 / points**4, compliance, out=stiffness, where=compliance > 0.0)
    buffer, heights, p = field.ravel(), h.ravel(), p.ravel().copy()
    gap, step, old = np.empty(p.size), np.zeros(p.size), np.zeros(p.size)
    at_pixel = 0.25 * np.pi * points  # stiffness of waves of four pixels
    last = 0.0

    def apply(factor: np.ndarray) -> None:
        there.execute()
        spectrum[...] *= factor
        back.execute()

    for _ in range(most):
        buffer[:] = p
        apply(compliance)
        residual(buffer, heights, p, gap, buffer)
        apply(stiffness)
        last, slope = direction(p, buffer, gap, old, step, last)
        apply(compliance)
        length = slope / curvature(step, buffer)
        change, joined = advance(p, gap, step, length, at_pixel, load)
        if joined:
            last = 0.0
        if change <= tolerance * load * p.size:
            return p.reshape(h.shape)
    raise RuntimeError(f"tolerance {tolerance:.0e} not met in {most} iterations")


def solve(heights: np.ndarray, load: float, tolerance: float, most: int = 2000) -> np.ndarray:
    """Return the pressure; `tolerance` is on Σ |change of p| / Σ p in one iteration. RuntimeError if it is not met."""
    if heights.shape[0] <= COARSEST:
        return on_grid(heights, np.full(heights.shape, load), load, tolerance, most)
    n = heights.shape[0] // 2
    coarse = heights.reshape(n, 2, n, 2).mean(axis=(1, 3))
    guess = solve(np.ascontiguousarray(coarse), load, max(tolerance, 1e-2), most)
    return on_grid(heights, np.kron(guess, np.ones((2, 2))), load, tolerance, most)
