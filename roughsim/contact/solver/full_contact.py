"""Full contact: the closed form where it keeps to the bounds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughsim.contact.solver.half_space import half_space
from roughsim.contact.solver.state import Problem

Array = NDArray[Any]


@dataclass(frozen=True, slots=True)
class FullContact:
    """The fields of full contact, in the units of the problem."""

    pressure: Array
    gap: Array
    residual: float = 0.0
    iterations: int = 0


def full_contact(problem: Problem, spectrum: Array) -> FullContact | None:
    """Return p = σ₀ + |q|h/2 where it keeps to the bounds, or p = cap where the load is the cap; None elsewhere.

    `spectrum` is the transposed half spectrum of the heights. One point that leaves the bounds is enough to say no,
    and the lowest point nearly always does: its pressure is one sum over the spectrum.
    """
    shape = problem.grid.shape
    if problem.load == problem.cap:
        return FullContact(np.full(shape, problem.load), (problem.middle - problem.heights) / problem.unit)
    if _pressure_at(np.unravel_index(np.argmin(problem.heights), shape), problem, spectrum) < -1e-3 * problem.load:
        return None
    operator = half_space(problem.grid, np.float64)
    operator.complex_spectrum[...] = spectrum * (0.5 * problem.grid.wavenumbers.T)
    fluctuation = np.empty(shape)
    operator.inverse(fluctuation)
    rounding = 1e-14 * (problem.load + float(np.abs(fluctuation).max()))
    pressure = problem.load + fluctuation
    if pressure.min() < -rounding or pressure.max() > problem.cap + rounding:
        return None
    return FullContact(np.clip(pressure, 0.0, problem.cap), np.full(shape, -spectrum[0, 0].real))


def _pressure_at(point: Any, problem: Problem, spectrum: Array) -> float:
    """The closed form at one point, where rounding cannot matter."""
    grid = problem.grid
    along = np.exp(2j * np.pi * point[0] / grid.shape[0] * np.arange(grid.shape[0]))
    across = np.exp(2j * np.pi * point[1] / grid.shape[1] * np.arange(grid.half_shape[1]))
    lines = np.einsum("ji,ji,i->j", spectrum, 0.5 * grid.wavenumbers.T, along)  # not BLAS: its threads spin on
    return float(problem.load + np.sum(grid.multiplicity[0] * (across * lines).real))
