"""One level of the contact solve: preconditioned conjugate gradients on the free points of an active set.

Everything is dimensionless here: E* = 1, S(q) = 2/q. The free points are those of a primal–dual active set
(Hintermüller, Ito & Kunisch 2003), the offset d of the gap is the multiplier of the load (Polonsky & Keer 1999 for
conjugate gradients under load control), and the residual is that of the fixed point p = clip(p − κ(gap − d), 0, cap).

Pressure and gap are float64; steps and their responses are float32 wherever its range allows: an increment need only
be accurate relative to itself. What rounding has left in the gap is kept account of, and the gap is computed anew in
float64 before that matters.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughsim._kernels import active_set as kernels
from roughsim.contact.extension import Extension
from roughsim.contact.newton import exchange_points
from roughsim.contact.operator import half_space, rms_compliance
from roughsim.fourier.blocks import run, spans, total
from roughsim.grid import Grid

Array = NDArray[Any]
REACH = 0.5  # a point is free where 0 < p − REACH κ(gap − d) < cap
LEAST_REACH = 1e-3  # where steps are cut short: points are let go from a bound, and put on it, one by one
DOUBLE = float(np.finfo(np.float64).eps)
ROUNDING = 64 * DOUBLE  # what rounding may leave of the gap, in units of the heights
PATIENCE = 30  # iterations without a new best residual after which a solve counts as stalled
BEARABLE = 3  # bad steps in a row before points are exchanged on solved problems; doubled each time
NEGLIGIBLE = 0.1  # share of the tolerance that rounding may take


@dataclass(frozen=True, slots=True)
class Problem:
    """Minimise ½p·Sp − p·(heights − middle)/unit, 0 ≤ p ≤ cap, mean p = load: dimensionless but for the heights."""

    heights: Array
    middle: float
    unit: float
    grid: Grid
    load: float
    cap: float
    stiffness: float  # κ = q_s/2, q_s the highest wavenumber of the heights

    @property
    def step_type(self) -> Any:
        """Float32 where pressures keep well inside its range."""
        return np.float32 if 1e-15 < self.load < 1e15 else np.float64


class Iteration:
    """The fields, buffers and steps of one solve."""

    def __init__(self, problem: Problem):
        shape = problem.grid.shape
        kind = problem.step_type
        self.problem, self.kind = problem, kind
        self.blocks = [(a * shape[1], b * shape[1]) for a, b in spans(*shape)]
        self.operator, self.extension = half_space(problem.grid, kind), Extension(problem.grid, kind)
        self.free = np.zeros(shape, np.int8)
        self.step, self.response, self.field = (np.zeros(shape, kind) for _ in range(3))
        self.pressure, self.gap = np.empty(shape), np.empty(shape)
        self.alpha, self.curvature, self.reach, self.offset = 1.0, 0.0, REACH, 0.0
        self.target = problem.load * problem.grid.points
        self.slack = 2.0 * float(np.finfo(kind).eps)
        self.range, self.noise, self.transforms, self.iterations = 0.0, 0.0, 0.0, 0
        self.response_size, self.room = 0.0, self.target
        self.failures, self.bearable = 0, BEARABLE
        self._flat: tuple[Array, ...] = tuple(
            a.ravel() for a in (self.pressure, self.gap, self.free, self.field, self.step)
        )

    def sums(self, kernel: Any, *arguments: Any) -> Any:
        """Run a kernel over all blocks; add up what it returns."""
        return total(run(lambda a, b: kernel(a, b, *arguments), self.blocks))

    def refresh(self, dtype: Any) -> None:
        """Compute the gap anew from the pressure."""
        problem = self.problem
        operator = self.operator if dtype == self.kind else half_space(problem.grid, dtype)
        operator.comply(self.pressure, self.gap)
        self._count(2, dtype)
        self.range = float(np.ptp(self.gap))
        heights = problem.heights.ravel()
        sizes = self.sums(kernels.subtract_heights, heights, problem.middle, problem.unit, *self._flat[:2])
        self.noise = 2.0 * float(np.finfo(dtype).eps) * self._size(*sizes)

    def _size(self, pressure_square: float, displacement_square: float) -> float:
        """What rounding in S p is relative to: its result, and what S makes of evenly spread noise in its argument."""
        spread = rms_compliance(self.problem.grid) * float(np.sqrt(pressure_square / self.pressure.size))
        return spread + float(np.sqrt(displacement_square / self.pressure.size))

    def _range_shrank(self) -> bool:
        """Measure the range of the displacement anew; worst points are judged against it."""
        problem, old = self.problem, self.range
        scale = problem.heights.ravel(), problem.middle, problem.unit
        parts = run(lambda a, b: kernels.displacement_range(a, b, *scale, self._flat[1]), self.blocks)
        self.range = max(part[1] for part in parts) - min(part[0] for part in parts)
        return self.range < 0.9 * old

    def _count(self, transforms: int, dtype: Any) -> None:
        self.transforms += transforms * (0.5 if dtype == np.float32 else 1.0)

    def _law(self) -> tuple[float, float, float]:
        return self.offset, self.problem.stiffness, self.problem.cap

    def begin(self) -> None:
        """Guess the offset of a new start."""
        gaps, count, _ = self.sums(kernels.contact_sum, *self._flat[:2])
        self.offset = gaps / count

    def assess(self, tolerance: float) -> None:
        """Solve for the offset, mark the free points, and note the residual and how far rounding blurs it."""
        if not self._classify(tolerance):
            self._find_offset()
            self._classify(tolerance)

    def _classify(self, tolerance: float) -> bool:
        problem = self.problem
        p, gap, free, field, _ = self._flat
        kappa, unit = problem.stiffness, 1.0 / problem.load
        limit = kappa * (0.9 * tolerance * self.range + ROUNDING)
        clipped, self.inside, square, norm, self.free_count, self.above = self.sums(
            kernels.classify, p, gap, self._law(), self.reach, unit, limit, free, field
        )
        self.residual, self.norm = float(np.sqrt(square / norm)), float(np.sqrt(norm)) / unit
        self.excess = clipped - self.target
        touching = float(np.sqrt(max(self.free_count, 1) / norm))
        self.blur = kappa * unit * self.noise * touching
        # what is free to vary: nothing if no point is between the bounds, little if nearly all have yielded
        self.room = min(self.target, problem.cap * self.pressure.size - self.target)
        room = self.room if self.inside else 0.0
        return bool(abs(self.excess) <= max(0.05 * self.residual * room, 1e-14 * self.target))

    def _find_offset(self) -> None:
        """Solve Σ clip(p − κ(gap − d), 0, cap) = target for d."""
        (p, gap), block = self._flat[:2], self.blocks[0][1]
        goals = self.target, min(self.problem.cap, self.problem.load * (1.0 + 1e-12))
        found = kernels.find_offset(block, p, gap, self._law(), goals, self.excess, self.inside)
        self.offset, self.excess, self.inside = found

    def blurred(self, tolerance: float) -> bool:
        """Whether rounding in the gap now matters for the steps to come."""
        noise_matters = self.blur > NEGLIGIBLE * tolerance or 8 * self.noise > NEGLIGIBLE * tolerance * self.range
        return noise_matters and self.residual <= max(10.0 * self.blur, tolerance)

    def settle(self, tolerance: float) -> bool:
        """Put the points that are not free exactly on their bounds, as a step of full length.

        Return whether the gap had to follow: not if the bounds of what changes, residual and gap, are negligible.
        """
        self.step[...] = 0.0
        slope_square = self._shifted(self._propose(0.0, 0.0))
        if slope_square is None or slope_square[1] == 0.0:
            return False
        amplification = self.problem.stiffness * max(self.problem.grid.lengths) / np.pi  # κ S at the lowest wavenumber
        size = float(np.sqrt(slope_square[1]))
        change, displaced = (2.0 + amplification) * size / self.norm, rms_compliance(self.problem.grid) * size
        negligible = self.residual + change <= tolerance and displaced <= NEGLIGIBLE * tolerance * self.range
        if negligible:
            self.residual += change  # its bound
            self.response[...] = 0.0
        else:
            self.respond()
        self._apply(1.0)
        self.curvature, self.alpha = 0.0, 1.0  # the last step is gone
        self.response[...] = 0.0
        return not negligible

    def balance(self) -> None:
        """Bring the load of the settled pressure to the last digit."""
        p, _, free, _, step = self._flat
        self.step[...] = 0.0
        sums = self.sums(kernels.shifted_sum, free, p, step, 0.0, self.problem.cap)
        shift = self.load_shift(sums, 1e-15)
        if shift is not None:
            for a, b in self.blocks:
                kernels.balance(a, b, free, shift, self.problem.cap, p)

    def advance(self) -> None:
        """Take one step: preconditioned conjugate direction, load shift, exact length."""
        length = self._length(self._conjugate_step()) if self.free_count else 0.0
        if length < 0.05:
            self._recover()
            return
        self.failures = 0
        self.alpha = min(max(self.alpha * length, 0.2), 3.0)
        # a short step was cut by points sent to their bound too many at a time: more of them stay free
        self.reach = min(1.5 * self.reach, REACH) if length > 0.5 else max(0.2 * self.reach, LEAST_REACH)
        self._apply(length)

    def _conjugate_step(self) -> float:
        """Fill `step` and return its slope; zero if the load cannot be met by shifting the free points."""
        cross, own = self.precondition()
        beta = max(self.alpha * cross / self.curvature, 0.0) if own > 0.0 else 0.0
        slope_square = self._shifted(self._propose(self.alpha, beta))
        return 0.0 if slope_square is None else slope_square[0]

    def precondition(self) -> tuple[float, float]:
        """Turn the gap in `field` into a pressure, both on the free points.

        Return ⟨field, response⟩ and ⟨step, response⟩ there.
        """
        self.extension.extend(self.free, self.field)
        self.operator.stiffen(self.field, self.field)
        self._count(2, self.kind)
        return self.extension.transpose(self.free, self.field, self.step, self.response)

    def _propose(self, alpha: float, beta: float) -> tuple[float, int]:
        p, gap, free, field, step = self._flat
        sums: tuple[float, int] = self.sums(
            kernels.propose, free, p, gap, self.offset, field, (alpha, beta), self.problem.cap, step
        )
        return sums

    def _shifted(self, sums: tuple[float, int]) -> tuple[float, float] | None:
        """Turn the proposed change into a step that keeps the load; return its slope and square."""
        p, gap, free, _, step = self._flat
        accuracy = min(1e-9, 1e-3 * self.residual) * self.room / self.target
        shift = self.load_shift(sums, max(accuracy, 1e-15))
        if shift is None:
            return None
        result: tuple[float, float] = self.sums(
            kernels.free_step, free, p, gap, self.offset, shift, self.problem.cap, step
        )
        return result

    def load_shift(self, sums: tuple[float, int], accuracy: float) -> float | None:
        """Solve for the shift of the free points that restores the load; None if none does."""
        p, _, free, _, step = self._flat
        goal = self.problem.cap, self.target, accuracy
        found, shift = kernels.find_shift(self.blocks[0][1], free, p, step, *goal, *sums)
        return shift if found else None

    def _length(self, slope: float) -> float:
        """The length that minimises the energy along `step`, from its slope and its curvature."""
        if not slope < 0.0:
            return 0.0
        self.respond()
        return -slope / self.curvature if self.curvature > 0.0 else 1.0

    def respond(self) -> None:
        """Compute the response to the step, its curvature, and what its rounding is relative to."""
        self.operator.comply(self.step, self.response)
        self._count(2, self.kind)
        self.curvature, *squares = self.sums(kernels.curvature, self._flat[4], self.response.ravel())
        self.response_size = self._size(*squares)

    def _recover(self) -> None:
        """Projected gradients for a bad step; where they keep coming, exchange points between the sets."""
        self.failures += 1
        if self.failures < self.bearable:
            self._fall_back()
        else:
            self._exchange()

    def _exchange(self) -> None:
        exchange_points(self)
        self.failures, self.bearable = 0, 2 * self.bearable
        self.curvature, self.alpha, self.reach = 0.0, 1.0, REACH
        self.step[...] = 0.0
        self.begin()

    def _fall_back(self) -> None:
        """Take a projected-gradient step, which always lowers the energy, and trust the active set less."""
        self._find_offset()
        clipped = self.excess + self.target
        share = self.target / clipped if self.excess > 1e-9 * self.target else 1.0
        slope, _ = self.sums(kernels.gradient_step, *self._flat[:2], self._law(), share, self._flat[4])
        self.alpha, self.reach = 1.0, max(0.5 * self.reach, LEAST_REACH)
        length = self._length(slope)
        if length > 0.0:
            self._apply(length)

    def _apply(self, length: float) -> None:
        """Move by min(length, 1) steps: beyond 1 the step could leave the bounds."""
        problem = self.problem
        length = min(length, 1.0)
        p, gap, _, _, step = self._flat
        arguments = p, gap, step, self.response.ravel(), length, self.slack, self._law()
        clipped, inside = self.sums(kernels.advance, *arguments)
        self.noise += self.slack * length * self.response_size
        if inside > 0:
            self.offset -= (clipped - self.target) / (problem.stiffness * inside)

    def _hopeless(self) -> bool:
        """Whether exchanges have been tried enough, or rounding is all that is left."""
        return self.bearable > 8 * BEARABLE or self.residual <= 100.0 * rounding_floor(self)

    def solve(self, tolerance: float, max_iterations: int, *, final: bool) -> None:
        """Iterate until the residual meets the tolerance, stalls, or the iterations run out; never raises.

        With `final`, the tolerance must also hold for the worst point (its gap against the range of the displacement),
        rounding included, and for a pressure that is settled on its bounds.
        """
        best, since_best, settled = np.inf, 0, not final
        self.begin()
        self.assess(tolerance)
        for iteration in range(max_iterations + 1):
            self.iterations = iteration
            if final and not settled and self.residual <= tolerance:
                settled = True
                if self.settle(tolerance) or self._range_shrank():
                    self.assess(tolerance)
            if final and self.blurred(tolerance):
                self.refresh(np.float64)
                self.assess(tolerance)
            since_best = 0 if self.residual < 0.9 * best else since_best + 1
            best = self.residual if since_best == 0 else best
            met = self.residual <= tolerance and not (final and self.above)
            stalled = since_best > PATIENCE
            if met or iteration == max_iterations or (stalled and self._hopeless()):
                break
            if stalled:
                since_best = 0
                self._exchange()
            else:
                self.advance()
            self.assess(tolerance)
            settled = not final
        if final:
            self.balance()


def rounding_floor(state: Iteration) -> float:
    """The relative residual that rounding alone leaves: the gap cannot be known better than to ε·max|heights|."""
    problem = state.problem
    spread = float(np.abs(problem.heights - problem.middle).max()) / problem.unit
    rms = float(np.sqrt(np.mean(state.pressure**2)))
    contact = float(np.sqrt(np.mean(state.pressure > 0.0)))
    return 4.0 * DOUBLE * (1.0 + problem.stiffness * spread * contact / rms)
