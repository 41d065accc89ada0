"""From coarse grids to the finest: each solve starts where the coarser one ended."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughsim import fourier
from roughsim._kernels import active_set as kernels
from roughsim.contact.active_set import Problem, Solution, solve_level
from roughsim.grid import Grid

Array = NDArray[np.float64]
COARSEST = 64  # an axis is halved while it keeps at least this many points
COARSE_TOLERANCE = 1e-2  # tighter coarse solves do not help the next level


def solve_cascade(problem: Problem, tolerance: float, max_iterations: int) -> tuple[Solution, float]:
    """Solve on spectrally truncated surfaces from coarse to fine; return the solution and the work in finest FFTs."""
    coarse_tolerance = max(COARSE_TOLERANCE, tolerance)
    work, previous, solution = 0.0, None, None
    for level in reversed(_levels(problem)):
        if solution is None or previous is None:
            start = np.full(level.heights.shape, level.load)
        else:
            start = _carry(solution.continuation(previous.stiffness), level)
        goal = tolerance if level is problem else coarse_tolerance
        solution = solve_level(level, start, goal, max_iterations, final=level is problem)
        work += solution.transforms * level.heights.size / problem.heights.size
        previous = level
    assert solution is not None
    return solution, work


def full_contact(problem: Problem) -> Solution | None:
    """The closed form p = σ₀ + E*|q|h/2 where it keeps to the bounds: full contact; None elsewhere."""
    if problem.load == problem.cap:
        fluctuation = np.zeros(problem.heights.shape)
    else:
        spectrum = fourier.forward(problem.heights) * (0.5 * problem.grid.wavenumbers)
        fluctuation = fourier.inverse(spectrum, problem.heights.shape)
    rounding = 1e-14 * (problem.load + float(np.abs(fluctuation).max()))
    pressure = problem.load + fluctuation
    if pressure.min() < -rounding or pressure.max() > problem.cap + rounding:
        return None
    pressure = np.clip(pressure, 0.0, problem.cap)
    if problem.load == problem.cap:
        gap, offset = -problem.heights, float(-problem.heights.max())
    else:
        offset = float(-problem.heights.mean())
        gap = np.full(problem.heights.shape, offset)
    return Solution(pressure, gap, offset, 0.0, 0, 2)


def _levels(problem: Problem) -> list[Problem]:
    """The problem and its coarser versions, finest first."""
    levels = [problem]
    spectrum: NDArray[Any] | None = None
    while True:
        shape = levels[-1].heights.shape
        coarse = _halved(shape[0]), _halved(shape[1])
        if coarse == shape:
            return levels
        if spectrum is None:
            spectrum = fourier.forward(problem.heights)
        grid = Grid(coarse, problem.grid.lengths)
        heights = fourier.inverse(_truncate(spectrum, problem.grid.shape, grid.shape), grid.shape)
        stiffness = min(problem.stiffness, 0.5 * grid.nyquist)
        levels.append(replace(problem, heights=heights, grid=grid, stiffness=stiffness))


def _halved(points: int) -> int:
    return (points + 1) // 2 if points >= 2 * COARSEST else points


def _truncate(
    spectrum: NDArray[np.complex128], fine: tuple[int, int], coarse: tuple[int, int]
) -> NDArray[np.complex128]:
    """Keep the modes that the coarse grid resolves; a Nyquist row or column that was not there before is dropped."""
    rows = np.rint(np.fft.fftfreq(coarse[0]) * coarse[0]).astype(int)
    result = spectrum[rows, : coarse[1] // 2 + 1].copy()
    if coarse[0] % 2 == 0 and coarse[0] < fine[0]:
        result[coarse[0] // 2] = 0.0
    if coarse[1] % 2 == 0 and coarse[1] < fine[1]:
        result[:, -1] = 0.0
    return result


def _carry(field: Array, level: Problem) -> Array:
    """Bring a continued pressure to a finer grid: cubic interpolation, clipped and shifted to the load."""
    raw = _interpolate(_interpolate(field, level.heights.shape[0], 0), level.heights.shape[1], 1)
    free = (raw > 0.0).astype(np.int8)
    trial = np.maximum(raw, 0.0)
    shift, met = kernels.load_shift(free.ravel(), trial.ravel(), level.cap, level.load * trial.size)
    if not met:
        return np.full(raw.shape, level.load)
    start: Array = np.clip(trial + shift * free, 0.0, level.cap)
    return start


def _interpolate(field: Array, points: int, axis: int) -> Array:
    """Periodic cubic convolution along one axis (Keys 1981)."""
    size = field.shape[axis]
    if size == points:
        return field
    place = np.arange(points) * (size / points)
    cell = np.floor(place).astype(int)
    f = (place - cell).reshape((-1, 1) if axis == 0 else (1, -1))
    weights = (
        f * (-0.5 + f * (1.0 - 0.5 * f)),
        1.0 + f * f * (1.5 * f - 2.5),
        f * (0.5 + f * (2.0 - 1.5 * f)),
        f * f * (0.5 * f - 0.5),
    )
    result = np.zeros((points, field.shape[1]) if axis == 0 else (field.shape[0], points))
    for k, weight in enumerate(weights):
        result += weight * np.take(field, (cell + k - 1) % size, axis=axis)
    return result
