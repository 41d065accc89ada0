"""One level of the contact solve: preconditioned conjugate gradients on the free points of an active set.

Everything is dimensionless here: E* = 1, S(q) = 2/q. The free points are those of a primal–dual active set
(Hintermüller, Ito & Kunisch 2003), the offset d of the gap is the multiplier of the load (Polonsky & Keer 1999 for
conjugate gradients under load control), and the residual is that of the fixed point p = clip(p − κ(gap − d), 0, cap).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughsim._kernels import active_set as kernels
from roughsim.contact.extension import Extension
from roughsim.fourier import Transform
from roughsim.grid import Grid

Array = NDArray[np.float64]
REACH = 0.5  # a point is free where 0 < p − REACH κ(gap − d) < cap
ROUNDING = 64 * float(np.finfo(np.float64).eps)  # what rounding may leave of the gap, in units of the heights
PATIENCE = 40  # iterations without a new best residual after which a solve counts as stalled


@dataclass(frozen=True, slots=True)
class Problem:
    """Minimise ½p·Sp − p·heights, 0 ≤ p ≤ cap, mean p = load: dimensionless."""

    heights: Array
    grid: Grid
    load: float
    cap: float
    stiffness: float  # κ = q_s/2, q_s the highest wavenumber of the heights


@dataclass(slots=True)
class Solution:
    """Where an iteration stands: pressure, S p − heights, its offset d, and how good they are."""

    pressure: Array
    gap: Array
    offset: float
    residual: float
    iterations: int
    transforms: int

    def continuation(self, stiffness: float) -> Array:
        """A field whose positive part is the pressure and which goes on smoothly into the gap."""
        return self.pressure - 0.15 * stiffness * (self.gap - self.offset)


class _Iteration:
    """The buffers and steps of one solve."""

    def __init__(self, problem: Problem, start: Array):
        shape = problem.heights.shape
        self.problem = problem
        self.transform = Transform((shape[0], shape[1]), normalized=False)
        self.extension = Extension((shape[0], shape[1]))
        self.free = np.zeros(shape, np.int8)
        self.step, self.response = np.zeros(shape), np.zeros(shape)
        self.alpha, self.curvature, self.reach = 1.0, 0.0, REACH
        self.target = problem.load * start.size
        self.transforms = 0
        self.pressure = start
        self.gap = np.empty(shape)
        self.refresh()
        self.offset = float(self.gap[start > 0.0].mean())

    def refresh(self) -> None:
        """Compute the gap anew from the pressure, free of accumulated rounding."""
        self.transform.field[...] = self.pressure
        self.transform.forward()
        self._comply()
        self.range = float(np.ptp(self.transform.field))
        np.subtract(self.transform.field, self.problem.heights, out=self.gap)
        self.transforms += 2

    def _comply(self) -> None:
        kernels.comply(self.transform.spectrum, self.problem.grid.wavenumbers, 1.0 / self.pressure.size)
        self.transform.inverse()

    def assess(self) -> float:
        """Solve for the offset, mark the free points, and return the relative residual."""
        problem, flat = self.problem, (self.pressure.ravel(), self.gap.ravel())
        self.offset = kernels.load_offset(*flat, problem.stiffness, self.offset, problem.cap, self.target)
        residual, worst = kernels.mismatch(*flat, self.offset, problem.stiffness, problem.cap, 1.0 / problem.load)
        self.violation = float(worst) / problem.stiffness
        self.free_count = kernels.classify(
            *flat, self.offset, problem.stiffness, self.reach, problem.cap, self.free.ravel(), self._spare.ravel()
        )
        return float(residual)

    @property
    def _spare(self) -> Array:
        """The transform's own field: between two transforms it holds the residual gap, then the direction."""
        return self.transform.field

    def settle(self) -> None:
        """Put the points that are not free exactly on their bounds, keep the load, and compute the gap anew."""
        flat = self.free.ravel(), self.pressure.ravel(), self.gap.ravel()
        trial = self.step.ravel()
        kernels.propose(*flat, self.offset, self._spare.ravel(), 0.0, 0.0, self.problem.cap, trial)
        shift, met = kernels.load_shift(flat[0], trial, self.problem.cap, self.target)
        if met:
            kernels.settle(flat[0], trial, shift, self.problem.cap, flat[1])
        self.curvature, self.alpha = 0.0, 1.0  # the last step is gone
        self.response[...] = 0.0
        self.refresh()

    def advance(self) -> None:
        """Take one step: preconditioned conjugate direction, load shift, exact length."""
        slope = self._conjugate_step() if self.free_count else 0.0
        length = self._length(slope)
        if length < 0.05:
            self._fall_back()
            return
        self.alpha = float(np.clip(self.alpha * length, 0.2, 3.0))
        self.reach = min(1.5 * self.reach, REACH)
        self._apply(length)

    def _conjugate_step(self) -> float:
        """Fill `step` and return its slope; zero if the load cannot be met by shifting the free points."""
        problem, free, field = self.problem, self.free, self.transform.field
        self.extension.extend(free, field)
        self.transform.forward()
        kernels.stiffen(self.transform.spectrum, problem.grid.wavenumbers, 1.0 / field.size)
        self.transform.inverse()
        self.transforms += 2
        self.extension.transpose(free, field)
        flat = free.ravel(), self.pressure.ravel(), self.gap.ravel(), self.step.ravel(), field.ravel()
        cross, own = kernels.conjugacy(flat[0], flat[4], flat[3], self.response.ravel())
        beta = max(self.alpha * cross / self.curvature, 0.0) if own > 0.0 else 0.0
        kernels.propose(*flat[:3], self.offset, flat[4], self.alpha, beta, problem.cap, flat[3])
        shift, met = kernels.load_shift(flat[0], flat[3], problem.cap, self.target)
        if not met:
            return 0.0
        return float(kernels.free_step(flat[0], flat[3], shift, problem.cap, flat[1], flat[2], self.offset))

    def _length(self, slope: float) -> float:
        """The length that minimises the energy along `step`, from its slope and its curvature (Parseval)."""
        if not slope < 0.0:
            return 0.0
        self.transform.field[...] = self.step
        self.transform.forward()
        self.transforms += 1
        self.curvature = self._curvature()
        return -slope / self.curvature if self.curvature > 0.0 else 1.0

    def _curvature(self) -> float:
        grid = self.problem.grid
        total = kernels.curvature(self.transform.spectrum, grid.wavenumbers, grid.multiplicity)
        return float(total) / self.pressure.size

    def _fall_back(self) -> None:
        """Take a projected-gradient step, which always lowers the energy, and trust the active set less."""
        problem = self.problem
        flat = self.pressure.ravel(), self.gap.ravel()
        slope = kernels.gradient_step(*flat, self.offset, problem.stiffness, problem.cap, self.step.ravel())
        self.alpha, self.reach = 1.0, max(0.5 * self.reach, REACH / 64)
        length = self._length(float(slope))
        if length > 0.0:
            self._apply(length)

    def _apply(self, length: float) -> None:
        """Move by min(length, 1) steps: beyond 1 the step could leave the bounds."""
        self._comply()
        self.transforms += 1
        self.response[...] = self.transform.field
        flat = self.pressure.ravel(), self.gap.ravel(), self.step.ravel(), self.response.ravel()
        kernels.advance(*flat, min(length, 1.0))

    def solution(self, residual: float, iterations: int) -> Solution:
        """Hand over the fields."""
        return Solution(self.pressure, self.gap, self.offset, residual, iterations, self.transforms)


def rounding_floor(problem: Problem, pressure: Array) -> float:
    """The relative residual that rounding alone leaves: the gap cannot be known better than to ε·max|heights|."""
    spread = float(np.abs(problem.heights).max())
    rms = float(np.sqrt(np.mean(pressure**2)))
    contact = float(np.sqrt(np.mean(pressure > 0.0)))
    return 4.0 * float(np.finfo(np.float64).eps) * (1.0 + problem.stiffness * spread * contact / rms)


def solve_level(problem: Problem, start: Array, tolerance: float, max_iterations: int, *, final: bool) -> Solution:
    """Iterate until the residual meets the tolerance, stalls, or the iterations run out; never raises.

    With `final`, the tolerance must also hold for the worst point (its gap against the range of the displacement), and
    for a gap that is computed anew from the pressure.
    """
    state = _Iteration(problem, start)
    residual, best, since_best, fresh = state.assess(), np.inf, 0, True
    for iteration in range(max_iterations + 1):
        if final and residual <= tolerance and not fresh:
            state.settle()
            residual, fresh = state.assess(), True
        since_best = 0 if residual < 0.9 * best else since_best + 1
        best = min(best, residual)
        met = residual <= tolerance and not (final and state.violation > tolerance * state.range + ROUNDING)
        if met or since_best > PATIENCE or iteration == max_iterations:
            break
        state.advance()
        residual, fresh = state.assess(), False
    return state.solution(residual, iteration)
