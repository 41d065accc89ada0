"""Parts of a contact solve on one grid: its arrays, the gap, the active set, the step, and the load.

Everything is dimensionless here: E* = 1, S(q) = 2/q. The free points follow a primal–dual active set (Hintermüller, Ito
& Kunisch 2003), the offset d of the gap is the multiplier of the load (Polonsky & Keer 1999 for conjugate gradients
under load control), and the residual belongs to the fixed point p = clip(p − κ(gap − d), 0, cap).

Pressure and gap are float64; steps and their responses are float32 wherever its range allows: an increment need only
be accurate relative to itself. The rounding errors in the gap are estimated as they grow, and the gap is computed again
in float64 before they matter.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from roughsim._kernels import active_set as kernels
from roughsim.contact.solver.load import find_offset, find_shift
from roughsim.contact.solver.operators import (
    Extension,
    Operator,
    kept,
    kept_half_space,
    rms_compliance,
)
from roughsim.contact.solver.problem import ScaledProblem
from roughsim.fourier.blocks import extremes, run, spans, total
from roughsim.grid import Field, Grid

_DOUBLE = float(np.finfo(np.float64).eps)
NEGLIGIBLE = 0.1  # share of the tolerance that rounding may take
_ROUNDING = 64 * _DOUBLE  # the gap that rounding may leave, in units of the heights
_NEARBY = 0.01  # of the residual: from this share of the load on the place of the load of the bounds matters


class Workspace(NamedTuple):
    """Operators and arrays of the steps on one grid; a small one serves the next solve of its Python thread too.

    `free` is 1 on the free points, `inner` on the free points that stay between the bounds in a trial.
    """

    operator: Operator
    extension: Extension
    blocks: list[tuple[int, int]]  # ranges of points, for threads
    free: Field
    inner: Field
    field: Field
    trial: Field
    step: Field
    response: Field  # S·step
    slack: float  # relative rounding errors of a step
    cost: float  # of a product, in real float64 transforms
    compliance: float  # root mean square of 2/|q|

    def do(self, kernel: Any, arrays: tuple[Field, ...], *numbers: Any) -> list[Any]:
        """Run a kernel on all blocks of some arrays, flattened; return its results."""
        flat = [array.ravel() for array in arrays]

        def part(start: int, stop: int) -> Any:
            return kernel(*[array[start:stop] for array in flat], *numbers)

        return run(part, self.blocks)

    def sums(self, kernel: Any, arrays: tuple[Field, ...], *numbers: Any) -> Any:
        """Run a kernel on all blocks of some arrays; add up its results."""
        return total(self.do(kernel, arrays, *numbers))

    def displacement_size(self, pressure_square: float, displacement_square: float) -> float:
        """The size that rounding errors of S p are relative to: rms of S p, and of S times noise as large as p."""
        points = self.field.size
        spread = self.compliance * float(np.sqrt(pressure_square / points))
        return spread + float(np.sqrt(displacement_square / points))


def _make_workspace(grid: Grid, kind: Any) -> Workspace:
    """Return the operators and arrays for steps of a precision."""
    shape = grid.shape
    columns = grid.shape[1]
    return Workspace(
        operator=kept_half_space(grid, kind),
        extension=Extension(grid, kind),
        blocks=[(first * columns, last * columns) for first, last in spans(*shape)],
        free=np.zeros(shape, np.int8),
        inner=np.zeros(shape, np.int8),
        field=np.zeros(shape, kind),
        trial=np.zeros(shape, kind),
        step=np.zeros(shape, kind),
        response=np.zeros(shape, kind),
        slack=2.0 * float(np.finfo(kind).eps),
        cost=1.0 if kind == np.float32 else 2.0,
        compliance=rms_compliance(grid),
    )


def workspace_of(problem: ScaledProblem) -> Workspace:
    """Return the workspace for a problem, without a last step."""
    work = kept(_make_workspace, problem.grid, np.dtype(problem.step_type))
    work.step.fill(0.0)
    work.response.fill(0.0)
    return work


class Check(NamedTuple):
    """How good a pressure is, with x = clip(p − κ(gap − d), 0, cap)."""

    residual: float  # ‖p − x‖/‖p‖
    excess: float  # Σ x − target
    inside: int  # points with 0 < x < cap
    free: int  # free points
    above: int  # points whose gap alone misses the tolerance
    blur: float  # share of rounding errors in the residual


class Length(NamedTuple):
    """How far to go along a step."""

    best: float  # length of least energy, in steps
    curvature: float  # ⟨step, S·step⟩
    noise: float  # rounding errors in the response


NO_STEP = Length(0.0, 0.0, 0.0)


@dataclass(slots=True, eq=False)
class Iterate:
    """Iterate of a solve on one grid: pressure and gap, the offset, and the account of rounding errors."""

    problem: ScaledProblem
    work: Workspace
    pressure: Field  # shape of the grid
    gap: Field
    offset: float = 0.0
    noise: float = 0.0  # size of the rounding errors in the gap
    span: float = 0.0  # range of the displacement
    transforms: float = 0.0  # work so far, in real float64 transforms

    @property
    def law(self) -> tuple[float, float, float]:
        """Offset, stiffness and cap of clip(p − κ(gap − d), 0, cap)."""
        return self.offset, self.problem.stiffness, self.problem.cap

    def compute_gap(self, dtype: Any) -> None:
        """Compute the gap from the pressure, in a precision."""
        problem = self.problem
        work = self.work
        if dtype == work.field.dtype:
            work.field[...] = self.pressure
            work.operator.comply(work.field, work.field)
            self.gap[...] = work.field
        else:
            kept_half_space(problem.grid, dtype).comply(self.pressure, self.gap)
        self.transforms += 1.0 if dtype == np.float32 else 2.0
        low, high = extremes(self.gap)
        self.span = high - low
        arrays = problem.heights, self.pressure, self.gap
        squares = work.sums(kernels.subtract_heights, arrays, problem.middle, problem.unit)
        self.noise = 2.0 * float(np.finfo(dtype).eps) * work.displacement_size(*squares)

    def displacement_span(self) -> float:
        """Return the range of the displacement."""
        problem = self.problem
        arrays = problem.heights, self.gap
        parts = self.work.do(kernels.extent, arrays, problem.middle, problem.unit)
        lows, highs = zip(*parts, strict=True)
        return float(max(highs) - min(lows))

    def guess_offset(self) -> None:
        """Take the mean gap at the points under pressure as a first guess of the offset."""
        gaps, count = self.work.sums(kernels.contact_sum, (self.pressure, self.gap))
        self.offset = float(gaps / count)

    def check(self, tolerance: float, reach: float) -> Check:
        """Solve for the offset, mark the free points, write gap − d there to `field`, and return the residual."""
        problem = self.problem
        work = self.work
        kappa = problem.stiffness
        unit = 1.0 / problem.load
        limit = kappa * (0.9 * tolerance * self.span + _ROUNDING)
        arrays = self.pressure, self.gap, work.free, work.field
        for solved in (False, True):
            clipped, inside, square, norm, free, above = work.sums(
                kernels.classify, arrays, self.law, reach, unit, limit
            )
            blur = kappa * unit * self.noise * float(np.sqrt(max(free, 1) / norm))
            residual = float(np.sqrt(square / norm))
            excess = clipped - problem.target
            # the load free to vary: nothing if no point is between the bounds, little if nearly all points have yielded
            room = problem.room if inside else 0.0
            if solved or abs(excess) <= max(0.05 * residual * room, 1e-14 * problem.target):
                break
            self.solve_offset(excess, inside)
        return Check(residual, excess, int(inside), int(free), int(above), blur)

    def solve_offset(self, excess: float, inside: float) -> float:
        """Solve Σ clip(p − κ(gap − d), 0, cap) = target for d, from the excess at the present d; return the rest."""
        problem = self.problem
        kappa = self.problem.stiffness
        enough = min(problem.cap, problem.load * (1.0 + 1e-12))

        def sums(offset: float) -> Any:
            law = offset, kappa, problem.cap
            return self.work.sums(kernels.clipped_sum, (self.pressure, self.gap), law)

        def bracket() -> tuple[float, float]:
            # at the least offset no point carries pressure, at the greatest each carries enough
            least = self.gap - self.pressure / kappa
            greatest = self.gap + (enough - self.pressure) / kappa
            return float(least.min()), float(greatest.max())

        first = self.offset, excess, inside
        self.offset, excess, _ = find_offset(sums, bracket, kappa, problem.target, first)
        return excess

    def precondition(self) -> tuple[float, float]:
        """Turn the gap in `field` into a pressure, both on the free points.

        Return ⟨field, response⟩ and ⟨step, response⟩ there.
        """
        work = self.work
        work.extension.extend(work.free, work.field)
        work.operator.stiffen(work.field, work.field)
        self.transforms += work.cost
        return work.extension.transpose(work.free, work.field, work.step, work.response)

    def propose(self, residual: float, alpha: float, beta: float) -> float | None:
        """Write the next step, at an unchanged load: β step − α field on the free points, to the bound elsewhere.

        Return its slope ⟨step, gap − d⟩; None if no shift of the free points restores the load.
        """
        problem = self.problem
        work = self.work
        state = self.pressure, self.gap, work.free
        load = work.response  # the response of the last step is not needed any more
        arrays = *state, work.field, work.step, work.trial, load, work.inner
        clipped, count, added = work.sums(kernels.propose, arrays, (alpha, beta), self.law)
        # the load that bounds add or take is made up for by the free points nearby: a shift of all of them would move
        # it across the cell, and long waves answer strongly. If most of the load moves there is no nearby
        if count and _NEARBY * residual < added / problem.target < 0.5:
            clipped, count = work.extension.gather_load(
                work.inner, load, self.pressure, problem.cap, work.trial
            )
        slope = None

        def shifted(shift: float) -> tuple[float, float]:
            nonlocal slope
            arrays = *state, work.trial, work.step
            clipped, count, slope = work.sums(
                kernels.shifted_step, arrays, self.offset, shift, problem.cap
            )
            return clipped, count

        accuracy = max(min(1e-9, 1e-3 * residual) * problem.room / problem.target, 1e-15)
        met, _ = find_shift(shifted, problem.target, accuracy, clipped, count)
        if met and slope is None:  # no shift was needed, and none tried
            shifted(0.0)
        return slope if met else None

    def best_length(self, slope: float | None) -> Length:
        """Fill the response to the step, given its slope; return the length of least energy along the step.

        The length is 0 if the energy does not fall: then the response is 0 too, and the next step has a new direction.
        """
        if slope is None or not slope < 0.0:
            self.work.response.fill(0.0)
            return NO_STEP
        curvature, noise = self.respond()
        length = -slope / curvature if curvature > 0.0 else 1.0
        return Length(length, curvature, noise)

    def respond(self) -> tuple[float, float]:
        """Compute the response to the step; return ⟨step, S·step⟩, and the rounding errors in the response."""
        work = self.work
        work.operator.comply(work.step, work.response)
        self.transforms += work.cost
        curvature, *squares = work.sums(kernels.curvature, (work.step, work.response))
        return curvature, work.slack * work.displacement_size(*squares)

    def move(self, length: Length) -> None:
        """Take the step, and no more than all of it: beyond it could leave the bounds. Guess the new offset."""
        work = self.work
        share = min(length.best, 1.0)
        arrays = self.pressure, self.gap, work.step, work.response
        clipped, inside = work.sums(kernels.advance, arrays, share, work.slack, self.law)
        self.noise += share * length.noise
        if inside > 0:
            self.offset -= (clipped - self.problem.target) / (self.problem.stiffness * inside)

    def balance(self, accuracy: float) -> bool:
        """Shift the pressure of the free points, within the bounds, so that the load holds; return whether any does.

        If none does the pressure stays.
        """
        arrays = (self.pressure, self.work.free)
        cap = self.problem.cap

        def shifted(shift: float) -> Any:
            return self.work.sums(kernels.shifted_load, arrays, shift, cap)

        met, shift = find_shift(shifted, self.problem.target, accuracy, *shifted(0.0))
        if met:
            self.work.do(kernels.shift_free, arrays, shift, cap)
        return met


def rounding_floor(problem: ScaledProblem, pressure: Field) -> float:
    """The relative residual that rounding alone leaves: the gap cannot be known better than to ε·max|heights|."""
    spread = float(np.abs(problem.heights - problem.middle).max()) / problem.unit
    rms = float(np.sqrt(np.mean(pressure**2)))
    contact = float(np.sqrt(np.mean(pressure > 0.0)))
    return 4.0 * _DOUBLE * (1.0 + problem.stiffness * spread * contact / rms)
