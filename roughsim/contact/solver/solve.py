"""The contact solve: a cascade of grids, with preconditioned conjugate gradients on the free points of each.

A step is proposed on the free points. The load that the bounds add is then taken from the free points nearby, and the
rest from all of them by a shift. The step is clipped to the bounds and taken with its exact length. A bad step is
replaced by one of projected gradients; if bad steps keep coming, by exchanges of points (`exchange`).
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from roughsim._kernels import active_set as kernels
from roughsim._kernels.interpolation import interpolate
from roughsim.contact.solver.exchange import exchange
from roughsim.contact.solver.problem import ScaledProblem
from roughsim.contact.solver.steps import (
    NEGLIGIBLE,
    Check,
    Iterate,
    Length,
    Workspace,
    balance,
    best_length,
    check,
    compute_gap,
    displacement_span,
    mean_gap,
    move,
    precondition,
    propose,
    rounding_floor,
    solve_offset,
    workspace_of,
)
from roughsim.fourier.blocks import run, spans
from roughsim.grid import Field

REACH = 0.5  # a point is free if 0 < p − REACH κ(gap − d) < cap
_COARSE_TOLERANCE = 0.03  # tighter coarse solves do not help the next level
PATIENCE = 30  # iterations without a new best residual after which a solve counts as stalled
_LEAST_REACH = (
    1e-3  # of the active set after short steps: then points leave or join a bound nearly one by one
)
_SHORT = 0.05  # length of a step below which it counts as bad
_BEARABLE = 3  # bad steps in a row before points are exchanged; doubled each time


class Solution(NamedTuple):
    """The solve of one grid."""

    pressure: Field  # shape of the grid
    gap: Field
    residual: float
    iterations: int
    transforms: float  # real float64 transforms of this grid


def solve_cascade(
    levels: list[ScaledProblem], tolerance: float, max_iterations: int, start: Field | None = None
) -> Solution:
    """Solve the levels, finest first in the list; return the finest solution, with the work on all levels.

    `start`, the pressure of an earlier contact on any grid, is the first guess on the coarsest level.
    """
    finest = levels[0]
    work = 0.0
    for problem in reversed(levels[1:]):
        coarse = solve_level(
            problem, start, max(_COARSE_TOLERANCE, tolerance), max_iterations, final=False
        )
        work += coarse.transforms * problem.grid.points / finest.grid.points
        start = coarse.pressure
    solution = solve_level(finest, start, tolerance, max_iterations, final=True)
    return solution._replace(transforms=work + solution.transforms)


def solve_level(
    problem: ScaledProblem,
    start: Field | None,
    tolerance: float,
    max_iterations: int,
    *,
    final: bool,
) -> Solution:
    """Iterate on one grid until the residual meets the tolerance, stalls, or the iterations run out; never raises.

    `start` is a pressure on any grid; the load everywhere if left out. With `final` the tolerance also holds for the
    worst point (its gap against the range of the displacement) and for rounding errors.
    """
    work = workspace_of(problem)
    now = Iterate(start_pressure(problem, work, start), np.empty(problem.grid.points))
    compute_gap(problem, work, now, problem.step_type)
    now.offset = mean_gap(work, now)
    control = _Control()
    state = check(problem, work, now, tolerance, control.reach)
    for iteration in range(max_iterations + 1):
        if final:
            state = _check_again(problem, work, now, state, tolerance, control.reach)
        control.count(state.residual)
        met = state.residual <= tolerance and not (final and state.above)
        if met or iteration == max_iterations or _is_final_stall(problem, now, control, state):
            break
        length = _conjugate_length(problem, work, now, state, control)
        if length.best >= _SHORT:
            control.after_step(length)
            move(problem, work, now, length)
        elif control.stalled or control.bad + 1 >= control.bearable:
            exchange(problem, work, now)
            control.after_exchange()
        else:
            control.after_descent(descend(problem, work, now, state))
        state = check(problem, work, now, tolerance, control.reach)
    if final:
        settle(problem, work, now)
    shape = problem.grid.shape
    fields = now.pressure.reshape(shape), now.gap.reshape(shape)
    return Solution(*fields, state.residual, iteration, now.transforms)


@dataclass(slots=True)
class _Control:
    """Values carried from step to step of a solve on one grid."""

    alpha: float = 1.0  # length of the last step, for the next conjugate direction
    curvature: float = 0.0  # ⟨step, S·step⟩ of the last step
    reach: float = REACH  # of the active set
    bad: int = 0  # bad steps in a row
    bearable: int = _BEARABLE  # bad steps in a row at which points are exchanged
    best: float = np.inf  # residual; a new one is lower by a tenth
    since_best: int = 0  # iterations since then

    @property
    def stalled(self) -> bool:
        """Whether the residual has not fallen for long."""
        return self.since_best > PATIENCE

    def count(self, residual: float) -> None:
        """Count an iteration, and keep its residual if it is clearly the best."""
        if residual < 0.9 * self.best:
            self.best = residual
            self.since_best = 0
        else:
            self.since_best += 1

    def after_step(self, length: Length) -> None:
        """Take over the length of a good step."""
        self.bad = 0
        self.alpha = min(max(self.alpha * length.best, 0.2), 1.0)
        self.curvature = length.curvature
        # a short step was cut by points sent to their bound too many at a time: more of them stay free
        if length.best > 0.5:
            self.reach = min(1.5 * self.reach, REACH)
        else:
            self.reach = max(0.2 * self.reach, _LEAST_REACH)

    def after_descent(self, length: Length) -> None:
        """Count a bad step, which one of projected gradients has replaced."""
        self.bad += 1
        self.alpha = 1.0
        self.curvature = length.curvature
        self.reach = max(0.5 * self.reach, _LEAST_REACH)

    def after_exchange(self) -> None:
        """Begin again, and bear twice as many bad steps before the next exchange."""
        if self.stalled:
            self.since_best = 0
        self.bad = 0
        self.bearable *= 2
        self.alpha = 1.0
        self.curvature = 0.0
        self.reach = REACH


def _is_final_stall(problem: ScaledProblem, now: Iterate, control: _Control, state: Check) -> bool:
    """Whether the solve has stalled for good: exchanges have been tried enough, or only rounding is left."""
    if not control.stalled:
        return False
    return control.bearable > 8 * _BEARABLE or state.residual <= 100.0 * rounding_floor(
        problem, now.pressure
    )


def _conjugate_length(
    problem: ScaledProblem, work: Workspace, now: Iterate, state: Check, control: _Control
) -> Length:
    """Propose a step of conjugate gradients on the free points and return its best length, 0 without one."""
    if not state.free or control.stalled:
        return Length(0.0, 0.0, 0.0)
    cross, own = precondition(problem, work, now)
    beta = max(control.alpha * cross / control.curvature, 0.0) if own > 0.0 else 0.0
    slope = propose(problem, work, now, state.residual, control.alpha, beta)
    return best_length(problem, work, now, slope)


def _check_again(
    problem: ScaledProblem,
    work: Workspace,
    now: Iterate,
    state: Check,
    tolerance: float,
    reach: float,
) -> Check:
    """Check with a better gap if rounding errors matter, and with the range of the displacement as it is now."""
    if state.residual <= tolerance:
        span = displacement_span(problem, work, now)
        shrank = span < 0.9 * now.span
        now.span = span
        if shrank:
            state = check(problem, work, now, tolerance, reach)
    noisy = state.blur > NEGLIGIBLE * tolerance or 8 * now.noise > NEGLIGIBLE * tolerance * now.span
    if noisy and state.residual <= max(10.0 * state.blur, tolerance):
        compute_gap(problem, work, now, np.float64)
        state = check(problem, work, now, tolerance, reach)
    return state


def descend(problem: ScaledProblem, work: Workspace, now: Iterate, state: Check) -> Length:
    """Take a projected-gradient step, which always lowers the energy; return its length."""
    target = problem.target
    excess = solve_offset(problem, work, now, state.excess, state.inside)
    # a tiny load that no offset meets is exceeded: the share brings the step back to it
    share = target / (excess + target) if excess > 1e-9 * target else 1.0
    law = now.offset, problem.stiffness, problem.cap
    slope = sum(work.do(kernels.gradient_step, (now.pressure, now.gap, work.step), law, share))
    length = best_length(problem, work, now, slope)
    if length.best > 0.0:
        move(problem, work, now, length)
    return length


def settle(problem: ScaledProblem, work: Workspace, now: Iterate) -> None:
    """Put the points that are not free exactly on their bounds, and the load on the others.

    The pressures that this removes are part of the residual: the gap stays as it is.
    """
    law = now.offset, problem.stiffness, problem.cap
    work.do(kernels.put_on_bounds, (now.pressure, now.gap, work.free), law)
    balance(problem, work, now.pressure, 1e-14)


def start_pressure(problem: ScaledProblem, work: Workspace, start: Field | None) -> Field:
    """Return a flat pressure at the load: from an earlier contact on any grid, or the mean pressure."""
    shape = problem.grid.shape
    pressure = np.empty(shape)
    if start is not None:
        columns = start.shape[1]
        position = np.arange(shape[1]) * (columns / shape[1])
        left = position.astype(np.intp)
        blocks = [
            (first, last, start, left, position - left, pressure) for first, last in spans(*shape)
        ]
        run(interpolate, blocks)
        np.clip(pressure, 0.0, problem.cap, out=pressure)
        work.free[...] = ((pressure > 0.0) & (pressure < problem.cap)).ravel()
    if start is None or not balance(
        problem, work, pressure.ravel(), 1e-12
    ):  # no free point can take the load
        pressure.fill(problem.load)
    return pressure.ravel()
