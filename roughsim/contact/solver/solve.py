"""The contact solve: a cascade of grids, with preconditioned conjugate gradients on the free points of each.

A step is proposed on the free points. The load that the bounds add is then taken from the free points nearby, and the
rest from all of them by a shift. The step is clipped to the bounds and taken with its exact length. A bad step is
replaced by one of projected gradients; if bad steps keep coming, by exchanges of points (`exchange`).
"""

from dataclasses import dataclass

import numpy as np

from roughsim._kernels import active_set as kernels
from roughsim._kernels.interpolation import interpolate
from roughsim.contact.solver.exchange import exchange
from roughsim.contact.solver.problem import ScaledProblem, ScaledSolution
from roughsim.contact.solver.steps import (
    NEGLIGIBLE,
    NO_STEP,
    Check,
    Iterate,
    Length,
    rounding_floor,
    workspace_of,
)
from roughsim.fourier.blocks import run, spans
from roughsim.grid import Field

REACH = 0.5  # a point is free if 0 < p − REACH κ(gap − d) < cap
_COARSE_TOLERANCE = 0.03  # tighter coarse solves do not help the next level
PATIENCE = 30  # iterations without a new best residual after which a solve counts as stalled
# of the active set after short steps: then points leave or join a bound nearly one by one
_LEAST_REACH = 1e-3
_SHORT = 0.05  # length of a step below which it counts as bad
_BEARABLE = 3  # bad steps in a row before points are exchanged; doubled each time


def solve_cascade(
    levels: list[ScaledProblem], tolerance: float, max_iterations: int, start: Field | None = None
) -> ScaledSolution:
    """Solve the levels, finest first in the list; return the finest solution, with the work on all levels.

    `start`, the pressure of an earlier contact on any grid, is the first guess on the coarsest level.
    """
    finest = levels[0]
    work = 0.0
    enough = max(_COARSE_TOLERANCE, tolerance)
    for problem in reversed(levels[1:]):
        coarse = solve_level(problem, start, enough, max_iterations, final=False)
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
) -> ScaledSolution:
    """Iterate on one grid until the residual meets the tolerance, stalls, or the iterations run out; never raises.

    `start` is a pressure on any grid; the load everywhere if left out. With `final` the tolerance also holds for the
    worst point (its gap against the range of the displacement) and for rounding errors.
    """
    now = begun(problem, start)
    control = _Control()
    state = now.check(tolerance, control.reach)
    for iteration in range(max_iterations + 1):
        if final:
            state = _check_again(now, state, tolerance, control.reach)
        control.count(state.residual)
        met = state.residual <= tolerance and not (final and state.above)
        if met or iteration == max_iterations or _is_final_stall(now, control, state):
            break
        length = _conjugate_length(now, state, control)
        if length.best >= _SHORT:
            control.after_step(length)
            now.move(length)
        elif control.stalled or control.bad + 1 >= control.bearable:
            exchange(now)
            control.after_exchange()
        else:
            control.after_descent(descend(now, state))
        state = now.check(tolerance, control.reach)
    if final:
        # put the points that are not free exactly on their bounds, and the load on the others. The pressures that this
        # removes are part of the residual: the gap stays as it is
        now.work.do(kernels.put_on_bounds, (now.pressure, now.gap, now.work.free), now.law)
        now.balance(1e-14)
    return ScaledSolution(now.pressure, now.gap, state.residual, iteration, now.transforms)


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


def _is_final_stall(now: Iterate, control: _Control, state: Check) -> bool:
    """Whether the solve has stalled for good: exchanges have been tried enough, or only rounding is left."""
    if not control.stalled:
        return False
    floor = rounding_floor(now.problem, now.pressure)
    return control.bearable > 8 * _BEARABLE or state.residual <= 100.0 * floor


def _conjugate_length(now: Iterate, state: Check, control: _Control) -> Length:
    """Propose a step of conjugate gradients on the free points and return its best length, 0 without one."""
    if not state.free or control.stalled:
        return NO_STEP
    cross, own = now.precondition()
    beta = max(control.alpha * cross / control.curvature, 0.0) if own > 0.0 else 0.0
    return now.best_length(now.propose(state.residual, control.alpha, beta))


def _check_again(now: Iterate, state: Check, tolerance: float, reach: float) -> Check:
    """Check with a better gap if rounding errors matter, and with the range of the displacement as it is now."""
    if state.residual <= tolerance:
        span = now.displacement_span()
        shrank = span < 0.9 * now.span
        now.span = span
        if shrank:
            state = now.check(tolerance, reach)
    noisy = state.blur > NEGLIGIBLE * tolerance or 8 * now.noise > NEGLIGIBLE * tolerance * now.span
    if noisy and state.residual <= max(10.0 * state.blur, tolerance):
        now.compute_gap(np.float64)
        state = now.check(tolerance, reach)
    return state


def descend(now: Iterate, state: Check) -> Length:
    """Take a projected-gradient step, which always lowers the energy; return its length."""
    target = now.problem.target
    work = now.work
    excess = now.solve_offset(state.excess, state.inside)
    # a tiny load that no offset meets is exceeded: the share brings the step back to it
    share = target / (excess + target) if excess > 1e-9 * target else 1.0
    slope = sum(work.do(kernels.gradient_step, (now.pressure, now.gap, work.step), now.law, share))
    length = now.best_length(slope)
    if length.best > 0.0:
        now.move(length)
    return length


def begun(problem: ScaledProblem, start: Field | None) -> Iterate:
    """Return the first iterate: an earlier pressure, of any grid, at the load, or the mean pressure everywhere."""
    shape = problem.grid.shape
    work = workspace_of(problem)
    now = Iterate(problem, work, np.empty(shape), np.empty(shape))
    pressure = now.pressure
    if start is not None:
        columns = start.shape[1]
        position = np.arange(shape[1]) * (columns / shape[1])
        left = position.astype(np.intp)
        share = position - left
        run(interpolate, [(*rows, start, left, share, pressure) for rows in spans(*shape)])
        np.clip(pressure, 0.0, problem.cap, out=pressure)
        work.free[...] = (pressure > 0.0) & (pressure < problem.cap)
    if start is None or not now.balance(1e-12):  # no free point can take the load
        pressure.fill(problem.load)
    now.compute_gap(problem.step_type)
    now.guess_offset()
    return now
