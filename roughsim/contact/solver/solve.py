"""The solve on one grid: preconditioned conjugate gradients on the free points, with what to do where they fail.

A step is proposed on the free points, shifted so that the load is kept, clipped to the bounds, and taken with its exact
length. A bad step is replaced by one of projected gradients; where bad steps keep coming, points change sides on solved
linear problems (`pivoting`).
"""

from __future__ import annotations

import numpy as np

from roughsim._kernels import active_set as kernels
from roughsim.contact.solver.half_space import rms_compliance
from roughsim.contact.solver.pivoting import exchange_points
from roughsim.contact.solver.state import NEGLIGIBLE, REACH, Problem, State, rounding_floor

LEAST_REACH = 1e-3  # where steps are cut short: points are let go from a bound, and put on it, one by one
PATIENCE = 30  # iterations without a new best residual after which a solve counts as stalled
BEARABLE = 3  # bad steps in a row before points are exchanged on solved problems; doubled each time


class Solver:
    """Iterates on one grid; what it has reached stands in `state`."""

    def __init__(self, problem: Problem):
        self.state = State(problem)
        self.failures, self.bearable = 0, BEARABLE

    def solve(self, tolerance: float, max_iterations: int, *, final: bool) -> None:
        """Iterate until the residual meets the tolerance, stalls, or the iterations run out; never raises.

        With `final`, the tolerance must also hold for the worst point (its gap against the range of the displacement),
        rounding included, and for a pressure that is settled on its bounds.
        """
        state = self.state
        best, since_best, settled = np.inf, 0, not final
        state.begin()
        state.assess(tolerance)
        for iteration in range(max_iterations + 1):
            state.iterations = iteration
            if final:
                settled = self._polish(tolerance, settled)
            since_best = 0 if state.residual < 0.9 * best else since_best + 1
            best = state.residual if since_best == 0 else best
            met = state.residual <= tolerance and not (final and state.assessment.above)
            stalled = since_best > PATIENCE
            if met or iteration == max_iterations or (stalled and self._hopeless()):
                break
            if stalled:
                since_best = 0
                self._exchange()
            else:
                self.advance()
            state.assess(tolerance)
            settled = not final
        if final:
            state.balance(1e-15)  # the load of the settled pressure, to the last digit

    def _polish(self, tolerance: float, settled: bool) -> bool:
        """Where the residual meets the tolerance, settle on the bounds; where rounding matters, compute the gap anew.

        Return whether the pressure is settled.
        """
        state = self.state
        if not settled and state.residual <= tolerance:
            settled = True
            if self._settle(tolerance) or state.range_shrank():
                state.assess(tolerance)
        if state.blurred(tolerance):
            state.refresh(np.float64)
            state.assess(tolerance)
        return settled

    def _settle(self, tolerance: float) -> bool:
        """Put the points that are not free exactly on their bounds, as a step of full length.

        Return whether the gap had to follow: not if the bounds of what changes, residual and gap, are negligible.
        """
        state, problem = self.state, self.state.problem
        state.step[...] = 0.0
        slope_square = self._shifted(self._propose(0.0, 0.0))
        if slope_square is None or slope_square[1] == 0.0:
            return False
        # a step of this size changes the residual by at most so much, κ S being largest at the lowest wavenumber, and
        # the gap by what S makes of it on average
        amplification = problem.stiffness * max(problem.grid.lengths) / np.pi
        size = float(np.sqrt(slope_square[1]))
        residual = state.residual + (2.0 + amplification) * size / state.assessment.norm
        displaced = rms_compliance(problem.grid) * size
        negligible = residual <= tolerance and displaced <= NEGLIGIBLE * tolerance * state.range
        if negligible:
            state.assessment = state.assessment._replace(residual=residual)  # its bound
            state.response[...] = 0.0
        else:
            state.respond()
        state.move(1.0)
        state.curvature, state.alpha = 0.0, 1.0  # the last step is gone
        state.response[...] = 0.0
        return not negligible

    def advance(self) -> None:
        """Take one step: preconditioned conjugate direction, load shift, exact length."""
        state = self.state
        length = self._length(self._conjugate_step()) if state.assessment.free else 0.0
        if length < 0.05:
            self._recover()
            return
        self.failures = 0
        state.alpha = min(max(state.alpha * length, 0.2), 3.0)
        # a short step was cut by points sent to their bound too many at a time: more of them stay free
        state.reach = min(1.5 * state.reach, REACH) if length > 0.5 else max(0.2 * state.reach, LEAST_REACH)
        state.move(length)

    def _conjugate_step(self) -> float:
        """Fill `step` and return its slope; zero if the load cannot be met by shifting the free points."""
        state = self.state
        cross, own = state.precondition()
        beta = max(state.alpha * cross / state.curvature, 0.0) if own > 0.0 else 0.0
        slope_square = self._shifted(self._propose(state.alpha, beta))
        return 0.0 if slope_square is None else slope_square[0]

    def _propose(self, alpha: float, beta: float) -> tuple[float, int]:
        """Write β step − α field on the free points into `step`, the way to the bound elsewhere; return its sums."""
        state = self.state
        p, gap, free, field, step = state.flat
        sums: tuple[float, int] = state.sums(
            kernels.propose, free, p, gap, state.offset, field, (alpha, beta), state.problem.cap, step
        )
        return sums

    def _shifted(self, sums: tuple[float, int]) -> tuple[float, float] | None:
        """Turn the proposed change into a step that keeps the load; return its slope and square."""
        state = self.state
        p, gap, free, _, step = state.flat
        accuracy = min(1e-9, 1e-3 * state.residual) * state.room / state.problem.target
        shift = state.load_shift(sums, max(accuracy, 1e-15))
        if shift is None:
            return None
        result: tuple[float, float] = state.sums(
            kernels.free_step, free, p, gap, state.offset, shift, state.problem.cap, step
        )
        return result

    def _length(self, slope: float) -> float:
        """The length that minimises the energy along `step`, from its slope and its curvature."""
        state = self.state
        if not slope < 0.0:
            return 0.0
        state.respond()
        return -slope / state.curvature if state.curvature > 0.0 else 1.0

    def _recover(self) -> None:
        """Projected gradients for a bad step; where they keep coming, exchange points between the sets."""
        self.failures += 1
        if self.failures < self.bearable:
            self._fall_back()
        else:
            self._exchange()

    def _exchange(self) -> None:
        state = self.state
        exchange_points(state)
        self.failures, self.bearable = 0, 2 * self.bearable
        state.curvature, state.alpha, state.reach = 0.0, 1.0, REACH
        state.step[...] = 0.0
        state.begin()

    def _fall_back(self) -> None:
        """Take a projected-gradient step, which always lowers the energy, and trust the active set less."""
        state, target = self.state, self.state.problem.target
        state.find_offset()
        excess = state.assessment.excess
        share = target / (excess + target) if excess > 1e-9 * target else 1.0
        slope, _ = state.sums(kernels.gradient_step, *state.flat[:2], state.law, share, state.flat[4])
        state.alpha, state.reach = 1.0, max(0.5 * state.reach, LEAST_REACH)
        length = self._length(slope)
        if length > 0.0:
            state.move(length)

    def _hopeless(self) -> bool:
        """Whether exchanges have been tried enough, or rounding is all that is left."""
        return self.bearable > 8 * BEARABLE or self.state.residual <= 100.0 * rounding_floor(self.state)
