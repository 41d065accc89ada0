"""From coarse grids to the finest: each solve starts where the coarser one ended."""

from __future__ import annotations

import numpy as np

from roughsim._kernels import active_set as kernels
from roughsim._kernels.interpolation import refine
from roughsim.contact.solver.problem import ScaledProblem
from roughsim.contact.solver.solve import solve
from roughsim.contact.solver.state import NEGLIGIBLE, State
from roughsim.fourier.blocks import run, spans, total

COARSE_TOLERANCE = 1e-2  # tighter coarse solves do not help the next level
CONTINUATION = 0.15  # of κ(gap − d), by which the pressure is continued below zero before it is interpolated


def solve_cascade(levels: list[ScaledProblem], tolerance: float, max_iterations: int) -> tuple[State, float]:
    """Solve the levels, listed from the finest; return the finest and the work in its float64 transforms."""
    coarse_tolerance = max(COARSE_TOLERANCE, tolerance)
    finest, work = levels[0], 0.0
    coarse: State | None = None
    for problem in reversed(levels):
        state, final = State(problem), problem is finest
        if coarse is None:
            state.pressure[...] = problem.load
        else:
            carry(coarse, state)
        # single precision is enough for the first gap unless rounding already blurs the coarse solution
        precise = final and coarse is not None and coarse.assessment.blur > 0.3 * NEGLIGIBLE * tolerance
        state.refresh(np.float64 if precise else state.kind)
        solve(state, tolerance if final else coarse_tolerance, max_iterations, final=final)
        work += state.transforms * problem.grid.points / finest.grid.points
        coarse = state
    return state, work


def carry(coarse: State, fine: State) -> None:
    """Bring a pressure to a finer grid: continued below zero, interpolated, clipped, and shifted to the load."""
    field = np.empty(coarse.problem.grid.shape, fine.kind)
    strength, cap = CONTINUATION * coarse.problem.stiffness, fine.problem.cap
    fields = coarse.pressure.ravel(), coarse.gap.ravel(), coarse.offset, strength, field.ravel()
    run(lambda a, b: kernels.continuation(a, b, *fields), coarse.blocks)
    rows = spans(*fine.problem.grid.shape)
    sums = total(run(lambda a, b: refine(a, b, field, cap, fine.pressure, fine.free), rows))
    shift = fine.load_shift(sums, 1e-12)
    if shift is None:  # no free point can take the load
        fine.pressure[...] = fine.problem.load
        return
    free, pressure = fine.free.ravel(), fine.pressure.ravel()
    run(lambda a, b: kernels.balance(a, b, free, shift, cap, pressure), fine.blocks)
