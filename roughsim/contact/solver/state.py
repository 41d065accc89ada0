"""The state of one contact solve on one grid: its fields, their residual, and the rounding errors in them.

Everything is dimensionless here: E* = 1, S(q) = 2/q. The free points are those of a primal–dual active set
(Hintermüller, Ito & Kunisch 2003), the offset d of the gap is the multiplier of the load (Polonsky & Keer 1999 for
conjugate gradients under load control), and the residual is that of the fixed point p = clip(p − κ(gap − d), 0, cap).

Pressure and gap are float64; steps and their responses are float32 wherever its range allows: an increment need only
be accurate relative to itself. The rounding errors in the gap are estimated as they grow, and the gap is computed anew
in float64 before they matter.
"""

from typing import Any, NamedTuple

import numpy as np

from roughsim._kernels import active_set as kernels
from roughsim.contact.solver.load import find_offset, find_shift
from roughsim.contact.solver.operators import Extension, kept, kept_half_space, rms_compliance
from roughsim.contact.solver.problem import ScaledProblem
from roughsim.fourier.blocks import extremes, run, spans, total
from roughsim.grid import Field, Grid

REACH = 0.5  # a point is free where 0 < p − REACH κ(gap − d) < cap
DOUBLE = float(np.finfo(np.float64).eps)
ROUNDING = 64 * DOUBLE  # what rounding may leave of the gap, in units of the heights
NEGLIGIBLE = 0.1  # share of the tolerance that rounding may take
NEARBY = 0.01  # of the residual: from this share of the load on it matters where the load of the bounds goes
BEARABLE = 3  # bad steps in a row before points are exchanged on solved problems; doubled each time


class Assessment(NamedTuple):
    """How good a pressure is. With x = clip(p − κ(gap − d), 0, cap):

    residual ‖p − x‖/‖p‖, norm ‖p‖, excess Σx − target, inside the number of points with 0 < x < cap, free the number
    of free points, above that of points whose gap alone misses the tolerance, blur what rounding in the gap may make of
    the residual.
    """

    residual: float
    norm: float
    excess: float
    inside: int
    free: int
    above: int
    blur: float


class Buffers:
    """What a solve works in, but for its pressure and gap: operators, and fields of the steps' precision."""

    def __init__(self, grid: Grid, kind: Any):
        self.operator, self.extension = kept_half_space(grid, kind), Extension(grid, kind)
        self.blocks = [(a * grid.shape[1], b * grid.shape[1]) for a, b in spans(*grid.shape)]
        # the free points, and those of them that stay between the bounds in the step that is proposed
        self.free, self.inner = np.empty(grid.shape, np.int8), np.empty(grid.shape, np.int8)
        self.step, self.response, self.field = (np.empty(grid.shape, kind) for _ in range(3))


class State:
    """The fields of one solve, and the estimate of its rounding errors.

    On a small grid the next solve of a Python thread takes over all fields but pressure and gap: one state at a time.
    """

    def __init__(self, problem: ScaledProblem):
        grid, kind = problem.grid, problem.step_type
        self.problem, self.kind = problem, kind
        buffers: Buffers = kept(Buffers, grid, np.dtype(kind))
        self.blocks, self.operator, self.extension = buffers.blocks, buffers.operator, buffers.extension
        self.free, self.inner, self.field = buffers.free, buffers.inner, buffers.field
        self.step, self.response = buffers.step, buffers.response
        self.pressure, self.gap = np.empty(grid.shape), np.empty(grid.shape)

        def clear(start: int, stop: int) -> None:
            for each in (self.free, self.step, self.response):
                each[start:stop] = 0

        run(clear, spans(*grid.shape))
        # the same arrays in one dimension, as kernels take them
        self.flat: tuple[Field, ...] = tuple(
            a.ravel() for a in (self.pressure, self.gap, self.free, self.field, self.step)
        )
        self.offset = 0.0
        self.assessment: Assessment
        # what the next step takes from the last: its length, its curvature, and how far the free points reach
        self.alpha, self.curvature, self.reach = 1.0, 0.0, REACH
        # bad steps in a row, and how many are borne before points are exchanged
        self.failures, self.bearable = 0, BEARABLE
        # rounding errors: `noise` is their size in the gap, judged against `range`, that of the displacement. Each full
        # step adds the share `slack` of `response_size`, the size of the last response
        self.noise, self.range, self.response_size = 0.0, 0.0, 0.0
        self.slack = 2.0 * float(np.finfo(kind).eps)
        self.transforms, self.iterations = 0.0, 0

    @property
    def residual(self) -> float:
        """The relative residual when it was last assessed."""
        return self.assessment.residual

    @property
    def law(self) -> tuple[float, float, float]:
        """What p − clip(p − κ(gap − d), 0, cap) takes: d, κ, cap."""
        return self.offset, self.problem.stiffness, self.problem.cap

    @property
    def room(self) -> float:
        """Σ p that is free to vary: little if nearly all points have yielded."""
        target = self.problem.target
        return min(target, self.problem.cap * self.pressure.size - target)

    def sums(self, kernel: Any, *arguments: Any) -> Any:
        """Run a kernel over all blocks; add up what it returns."""
        if len(self.blocks) == 1:  # on a small grid a call costs as much as its work
            return kernel(*self.blocks[0], *arguments)
        return total(run(lambda a, b: kernel(a, b, *arguments), self.blocks))

    def refresh(self, dtype: Any) -> None:
        """Compute the gap anew from the pressure."""
        problem = self.problem
        if dtype == self.kind:
            # in a buffer of the steps' precision: kernels that convert would have to be compiled for this alone
            p, gap, _, field, _ = self.flat
            run(lambda a, b: np.copyto(field[a:b], p[a:b], casting="same_kind"), self.blocks)
            self.operator.comply(self.field, self.field)
            run(lambda a, b: np.copyto(gap[a:b], field[a:b]), self.blocks)
            low, high = extremes(self.field)
        else:
            kept_half_space(problem.grid, dtype).comply(self.pressure, self.gap)
            low, high = extremes(self.gap)
        self.transforms += 1.0 if dtype == np.float32 else 2.0
        self.range = high - low
        heights = problem.heights.ravel()
        sizes = self.sums(kernels.subtract_heights, heights, problem.middle, problem.unit, *self.flat[:2])
        self.noise = 2.0 * float(np.finfo(dtype).eps) * self._size(*sizes)

    def _size(self, pressure_square: float, displacement_square: float) -> float:
        """The size that rounding errors of S p are relative to: rms of S p, and of S times noise as large as p."""
        spread = rms_compliance(self.problem.grid) * float(np.sqrt(pressure_square / self.pressure.size))
        return spread + float(np.sqrt(displacement_square / self.pressure.size))

    def range_shrank(self) -> bool:
        """Measure the range of the displacement anew; return whether it has shrunk by more than a tenth."""
        problem, gap, old = self.problem, self.flat[1], self.range
        arguments = problem.heights.ravel(), problem.middle, problem.unit, gap
        lows, highs = zip(*run(lambda a, b: kernels.extent(a, b, *arguments), self.blocks), strict=True)
        self.range = max(highs) - min(lows)
        return self.range < 0.9 * old

    def begin(self) -> None:
        """Guess the offset of a new start."""
        gaps, count = self.sums(kernels.contact_sum, *self.flat[:2])
        self.offset = gaps / count

    def assess(self, tolerance: float) -> None:
        """Solve for the offset, mark the free points, and note the residual and how far rounding blurs it."""
        problem = self.problem
        p, gap, free, field, _ = self.flat
        kappa, unit = problem.stiffness, 1.0 / problem.load
        limit = kappa * (0.9 * tolerance * self.range + ROUNDING)
        for solved in (False, True):
            clipped, inside, square, norm, count, above = self.sums(
                kernels.classify, p, gap, self.law, self.reach, unit, limit, free, field
            )
            blur = kappa * unit * self.noise * float(np.sqrt(max(count, 1) / norm))
            residual, excess = float(np.sqrt(square / norm)), clipped - problem.target
            self.assessment = Assessment(residual, float(np.sqrt(norm)) / unit, excess, inside, count, above, blur)
            room = self.room if inside else 0.0  # nothing is free to vary if no point is between the bounds
            if solved or abs(excess) <= max(0.05 * residual * room, 1e-14 * problem.target):
                return
            self.find_offset()

    def find_offset(self) -> None:
        """Solve Σ clip(p − κ(gap − d), 0, cap) = target for d."""
        last = self.assessment
        first = self.offset, last.excess, last.inside
        self.offset, excess, inside = self.offset_of(self.problem.stiffness, first)
        self.assessment = last._replace(excess=excess, inside=int(inside))

    def offset_of(self, stiffness: float, first: tuple[float, float, float]) -> tuple[float, float, float]:
        """Solve that equation for any stiffness κ; `first` and the result hold d, the excess, and points within."""
        (p, gap), problem = self.flat[:2], self.problem
        enough = min(problem.cap, problem.load * (1.0 + 1e-12))

        def bounds(start: int, stop: int) -> tuple[float, float]:
            pressure, own = p[start:stop], gap[start:stop]
            return float((own - pressure / stiffness).min()), float((own + (enough - pressure) / stiffness).max())

        def bracket() -> tuple[float, float]:
            # at `least` no point carries pressure, at `most` each carries `enough`: the solution lies between
            least, most = zip(*run(bounds, self.blocks), strict=True)
            return min(least), max(most)

        sums = lambda d: self.sums(kernels.clipped_sum, p, gap, (d, stiffness, problem.cap))  # noqa: E731
        return find_offset(sums, bracket, stiffness, problem.target, first)

    def blurred(self, tolerance: float) -> bool:
        """Whether rounding in the gap now matters for the steps to come."""
        blur, residual = self.assessment.blur, self.residual
        noise_matters = blur > NEGLIGIBLE * tolerance or 8 * self.noise > NEGLIGIBLE * tolerance * self.range
        return noise_matters and residual <= max(10.0 * blur, tolerance)

    def precondition(self) -> tuple[float, float]:
        """Turn the gap in `field` into a pressure, both on the free points.

        Return ⟨field, response⟩ and ⟨step, response⟩ there.
        """
        self.extension.extend(self.free, self.field)
        self.operator.stiffen(self.field, self.field)
        self.transforms += 1.0 if self.kind == np.float32 else 2.0
        return self.extension.transpose(self.free, self.field, self.step, self.response)

    def respond(self) -> None:
        """Compute the response to the step, its curvature, and its size for the estimate of rounding errors."""
        self.operator.comply(self.step, self.response)
        self.transforms += 1.0 if self.kind == np.float32 else 2.0
        self.curvature, *squares = self.sums(kernels.curvature, self.flat[4], self.response.ravel())
        self.response_size = self._size(*squares)

    def propose(self, alpha: float, beta: float) -> tuple[float, float] | None:
        """Fill `step`: β step − α field on the free points, the way to the bound elsewhere, at an unchanged load.

        Return its slope and square; None if no shift of the free points restores the load.
        """
        p, gap, free, field, step = self.flat
        load = self.response  # of the last step, which is done with
        arguments = free, p, gap, field, (alpha, beta), self.law, step, (load.ravel(), self.inner.ravel())
        *sums, added = self.sums(kernels.propose, *arguments)
        # the load that bounds add or take is made up for by the free points nearby: a shift of all of them would move
        # it across the cell, where long waves answer strongly. Where most of the load moves there is no nearby
        if sums[1] and NEARBY * self.residual < added / self.problem.target < 0.5:
            sums = self.extension.gather_load(self.inner, load, self.pressure, self.problem.cap, self.step)
        accuracy = min(1e-9, 1e-3 * self.residual) * self.room / self.problem.target
        products: list[float] = []

        def after(shift: float) -> tuple[float, float]:
            nonlocal products
            total, count, *products = self.shifted(shift)
            return total, count

        met, shift = find_shift(after, self.problem.target, max(accuracy, 1e-15), *sums)
        if not met:
            return None
        slope, square = products or self.shifted(shift)[2:]  # no shift was needed, and none tried
        # the step is in the other of the two fields
        self.step, self.response, self.flat = load, self.step, (*self.flat[:4], load.ravel())
        return slope, square

    def shifted(self, shift: float) -> tuple[float, float, float, float]:
        """Write `step` with the free points shifted, and clipped, into `response`.

        Return the load after it, the number of free points between the bounds, its slope and its square.
        """
        p, gap, free, _, step = self.flat
        arguments = free, p, gap, step, self.offset, shift, self.problem.cap, self.response.ravel()
        result: tuple[float, float, float, float] = self.sums(kernels.shifted_step, *arguments)
        return result

    def best_length(self, slope: float) -> float:
        """Return the length of least energy along `step`, given its slope; 0 where the energy does not fall."""
        if not slope < 0.0:
            self.response[...] = 0.0  # the next step starts anew
            return 0.0
        self.respond()
        return -slope / self.curvature if self.curvature > 0.0 else 1.0

    def balance(self, accuracy: float, sums: tuple[float, float] | None = None) -> bool:
        """Shift the free points so that the load holds to this accuracy; return whether any shift does.

        `sums` are the load and the number of free points between the bounds, where they are at hand.
        """
        p, _, free, *_ = self.flat
        self.step[...] = 0.0
        sums = sums or self.shifted(0.0)[:2]
        met, shift = find_shift(lambda shift: self.shifted(shift)[:2], self.problem.target, accuracy, *sums)
        if met:
            run(lambda a, b: kernels.shift_free(a, b, free, p, shift, self.problem.cap), self.blocks)
        return met

    def move(self, length: float) -> None:
        """Move by min(length, 1) steps: beyond 1 the step could leave the bounds."""
        length = min(length, 1.0)
        p, gap, _, _, step = self.flat
        arguments = p, gap, step, self.response.ravel(), length, self.slack, self.law
        clipped, inside = self.sums(kernels.advance, *arguments)
        self.noise += self.slack * length * self.response_size
        if inside > 0:
            self.offset -= (clipped - self.problem.target) / (self.problem.stiffness * inside)


def rounding_floor(state: State) -> float:
    """The relative residual that rounding alone leaves: the gap cannot be known better than to ε·max|heights|."""
    problem = state.problem
    spread = float(np.abs(problem.heights - problem.middle).max()) / problem.unit
    rms = float(np.sqrt(np.mean(state.pressure**2)))
    contact = float(np.sqrt(np.mean(state.pressure > 0.0)))
    return 4.0 * DOUBLE * (1.0 + problem.stiffness * spread * contact / rms)
