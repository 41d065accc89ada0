"""From coarse grids to the finest: each solve starts where the coarser one ended."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughsim._kernels import active_set as kernels
from roughsim._kernels.interpolation import refine
from roughsim.contact.solver.half_space import half_space
from roughsim.contact.solver.solve import Solver
from roughsim.contact.solver.state import NEGLIGIBLE, Problem, State
from roughsim.fourier.blocks import run, spans, total
from roughsim.grid import Grid

Array = NDArray[Any]
COARSEST = 64  # an axis is halved while it keeps at least this many points
COARSE_TOLERANCE = 1e-2  # tighter coarse solves do not help the next level
CONTINUATION = 0.15  # of κ(gap − d), by which the pressure is continued below zero before it is interpolated


def solve_cascade(levels: list[Problem], tolerance: float, max_iterations: int) -> tuple[State, float]:
    """Solve the levels, coarse to fine; return the finest and the work in its float64 transforms."""
    coarse_tolerance = max(COARSE_TOLERANCE, tolerance)
    work = 0.0
    state: State | None = None
    for problem in reversed(levels):
        solver = Solver(problem)
        coarse, state = state, solver.state
        if coarse is None:
            state.pressure[...] = problem.load
        else:
            _carry(coarse, state)
        final = problem is levels[0]
        precise = final and coarse is not None and coarse.assessment.blur > 0.3 * NEGLIGIBLE * tolerance
        state.refresh(np.float64 if precise else state.kind)
        solver.solve(tolerance if final else coarse_tolerance, max_iterations, final=final)
        work += state.transforms * problem.grid.points / levels[0].grid.points
    assert state is not None
    return state, work


def coarser(finest: Problem, spectrum: Array) -> list[Problem]:
    """The problem and its spectrally truncated versions, finest first; `spectrum` is the transposed half spectrum."""
    levels = [finest]
    while True:
        shape = levels[-1].grid.shape
        coarse = _halved(shape[0]), _halved(shape[1])
        if coarse == shape:
            return levels
        grid = Grid(coarse, finest.grid.lengths)
        operator = half_space(grid, np.float64)
        spectrum = _truncate(spectrum, shape, coarse)
        operator.complex_spectrum[...] = spectrum
        heights = np.empty(coarse)
        operator.inverse(heights)
        stiffness = min(finest.stiffness, 0.5 * grid.nyquist)
        levels.append(replace(finest, heights=heights, middle=0.0, unit=1.0, grid=grid, stiffness=stiffness))


def _halved(points: int) -> int:
    return (points + 1) // 2 if points >= 2 * COARSEST else points


def _truncate(spectrum: Array, fine: tuple[int, int], coarse: tuple[int, int]) -> Array:
    """Keep the modes that the coarse grid resolves; a Nyquist row or column that was not there before is dropped."""
    rows = np.rint(np.fft.fftfreq(coarse[0]) * coarse[0]).astype(int)
    result = spectrum[: coarse[1] // 2 + 1, rows]
    if coarse[0] % 2 == 0 and coarse[0] < fine[0]:
        result[:, coarse[0] // 2] = 0.0
    if coarse[1] % 2 == 0 and coarse[1] < fine[1]:
        result[-1] = 0.0
    return result


def _carry(coarse: State, fine: State) -> None:
    """Bring a continued pressure to a finer grid: cubic interpolation, clipped and shifted to the load."""
    problem = coarse.problem
    field = np.empty(problem.grid.shape, fine.kind)
    strength = CONTINUATION * problem.stiffness
    fields = coarse.pressure.ravel(), coarse.gap.ravel(), coarse.offset, strength, field.ravel()
    run(lambda a, b: kernels.continuation(a, b, *fields), coarse.blocks)
    cap = fine.problem.cap
    blocks = spans(*fine.problem.grid.shape)
    sums = total(run(lambda a, b: refine(a, b, field, cap, fine.pressure, fine.free), blocks))
    shift = fine.load_shift(sums, 1e-12)
    if shift is None:
        fine.pressure[...] = fine.problem.load
        return
    free, pressure = fine.free.ravel(), fine.pressure.ravel()
    run(lambda a, b: kernels.balance(a, b, free, shift, cap, pressure), fine.blocks)
