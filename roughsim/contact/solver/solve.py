"""The contact solve: a cascade of grids, with preconditioned conjugate gradients on the free points of each.

A step is proposed on the free points. What the bounds then add to the load is taken from the free points nearby, and
what is left from all of them by a shift. The step is clipped to the bounds and taken with its exact length. A bad step
is replaced by one of projected gradients.

In cells with very unlike sides, or under noise on every point, what clipping does to a step moves the load between
regions, and long waves answer so strongly that no clipped step lowers the energy. Where bad steps keep coming, the
primal–dual active set is followed with each of its linear problems solved. Nothing is clipped while the free points are
fixed; then the points that left their bounds, or pull away from them, change sides (Hintermüller, Ito & Kunisch 2003).
Where all at once lead in circles, ever fewer change, the worst of them (block pivoting: Júdice & Pires 1994).
"""

from typing import NamedTuple

import numpy as np

from roughsim._kernels import active_set as kernels
from roughsim._kernels.interpolation import interpolate, refine, tables
from roughsim.contact.solver.operators import rms_compliance
from roughsim.contact.solver.problem import ScaledProblem
from roughsim.contact.solver.state import BEARABLE, NEGLIGIBLE, REACH, State, rounding_floor
from roughsim.fourier.blocks import run, spans, total
from roughsim.grid import Field

COARSE_TOLERANCE = 0.03  # tighter coarse solves do not help the next level
CONTINUATION = 0.15  # of κ(gap − d), by which the pressure is continued below zero before it is interpolated
LONGEST = 0.95  # multiple of the preconditioned gap in a step after a first one: where points are still sent to their
# bounds the best length of the whole step is that of their part, up to 4, and free points would overshoot with it
LEAST_REACH = 1e-3  # of the active set after short steps: then points leave or join a bound nearly one by one
PATIENCE = 30  # iterations without a new best residual after which a solve counts as stalled; exchanges likewise
LEAST_SHARE = 0.02  # of the points on the wrong side, that change sides at least
STEPS = 300  # of conjugate gradients on one set of free points
ENOUGH = (1e-4, 1e-8, 1e-13)  # a step that gains less than this share of the energy gained so far ends them


class Coarse(NamedTuple):
    """What the solve on one grid hands on to that on the next: nothing else is kept of it."""

    pressure: Field  # continued smoothly below zero, so that an interpolation keeps the edges of the contact
    blur: float  # of its residual, by rounding
    transforms: float


def solve_cascade(
    levels: list[ScaledProblem], tolerance: float, max_iterations: int, start: tuple[Field, Field] | None = None
) -> tuple[State, float]:
    """Solve the levels, finest first in the list; return the finest state and all work in its float64 transforms.

    `start`, pressure and displacement of an earlier contact on any grid, is where the coarsest level begins.
    """
    finest, work = levels[0], 0.0
    coarse: Coarse | None = None
    for problem in reversed(levels[1:]):
        coarse = handed_on(
            solve_level(problem, coarse, start, max(COARSE_TOLERANCE, tolerance), max_iterations, final=False)
        )
        work += coarse.transforms * problem.grid.points / finest.grid.points
    state = solve_level(finest, coarse, start, tolerance, max_iterations, final=True)
    return state, work + state.transforms


def solve_level(
    problem: ScaledProblem,
    coarse: Coarse | None,
    start: tuple[Field, Field] | None,
    tolerance: float,
    max_iterations: int,
    *,
    final: bool,
) -> State:
    """Solve on one grid, from a coarser one, from an earlier contact, or from the mean pressure."""
    state = State(problem)
    if coarse is not None:
        start_from(coarse.pressure, state)
    elif start is not None:
        resume(*start, state)
    else:
        state.pressure[...] = problem.load
    # single precision is enough for the first gap unless rounding already blurs the coarse solution
    precise = final and coarse is not None and coarse.blur > 0.3 * NEGLIGIBLE * tolerance
    state.refresh(np.float64 if precise else state.kind)
    solve(state, tolerance, max_iterations, final=final)
    return state


def handed_on(state: State) -> Coarse:
    """Return what the next grid begins from; the gap of the state is used up."""
    slope, field = CONTINUATION * state.problem.stiffness, state.field

    def extend(start: int, stop: int) -> None:
        gap = state.gap[start:stop]
        gap -= state.offset
        gap *= slope
        np.subtract(state.pressure[start:stop], gap, out=field[start:stop], casting="same_kind")

    run(extend, spans(*field.shape))
    return Coarse(field, state.assessment.blur, state.transforms)


def start_from(coarse: Field, fine: State) -> None:
    """Set the pressure of a finer grid to that of a coarser one, at the load."""
    p, cap, places = fine.pressure, fine.problem.cap, tables(coarse.shape, fine.pressure.shape, coarse.dtype)

    def write(start: int, stop: int) -> tuple[float, int]:
        buffers = (np.empty(size, coarse.dtype) for size in (coarse.shape[1], p.shape[1]))
        sums: tuple[float, int] = refine(start, stop, *places, coarse, cap, p, fine.free, *buffers)
        return sums

    sums = total(run(write, spans(*p.shape)))
    if not fine.balance(1e-12, sums):  # no free point can take the load
        fine.pressure[...] = fine.problem.load


def resume(pressure: Field, displacement: Field, state: State) -> None:
    """Set the pressure to that of an earlier contact, at the load, and moved towards the optimum for these heights."""
    problem, p, gap = state.problem, *state.flat[:2]
    for earlier, field in ((pressure, state.pressure), (displacement, state.gap)):
        if earlier.shape == field.shape:
            field[...] = earlier
        else:
            places = tables(earlier.shape, field.shape, earlier.dtype)
            # each block has its own buffer for a row
            blocks = [(*rows, *places, earlier, field, np.empty(earlier.shape[1])) for rows in spans(*field.shape)]
            run(interpolate, blocks)
    state.sums(kernels.subtract_heights, problem.heights.ravel(), problem.middle, problem.unit, p, gap)
    # clip(p − κ′(gap − d), 0, cap), d for the load: where the heights have risen, contact begins, and elsewhere it ends
    stiffness = CONTINUATION * problem.stiffness
    state.begin()
    clipped, inside = state.sums(kernels.clipped_sum, p, gap, (state.offset, stiffness, problem.cap))
    offset, *_ = state.offset_of(stiffness, (state.offset, clipped - problem.target, inside))
    np.clip(state.pressure - stiffness * (state.gap - offset), 0.0, problem.cap, out=state.pressure)
    state.free[...] = (state.pressure > 0.0) & (state.pressure < problem.cap)
    if not state.balance(1e-12):  # no free point can take the load
        state.pressure[...] = problem.load


def solve(state: State, tolerance: float, max_iterations: int, *, final: bool) -> None:
    """Iterate until the residual meets the tolerance, stalls, or the iterations run out; never raises.

    With `final`, the tolerance must also hold for the worst point (its gap against the range of the displacement),
    rounding included, and for a pressure that is settled on its bounds.
    """
    best, since_best, settled = np.inf, 0, not final
    state.begin()
    state.assess(tolerance)
    for iteration in range(max_iterations + 1):
        state.iterations = iteration
        if final:
            if not settled and state.residual <= tolerance:
                settled = True
                if settle(state, tolerance) or state.range_shrank():
                    state.assess(tolerance)
            # the noise of single-precision steps is in the gap: compute it anew before that matters
            if state.blurred(tolerance):
                state.refresh(np.float64)
                state.assess(tolerance)
        since_best = 0 if state.residual < 0.9 * best else since_best + 1
        best = state.residual if since_best == 0 else best
        met = state.residual <= tolerance and not (final and state.assessment.above)
        stalled = since_best > PATIENCE
        if met or iteration == max_iterations:
            break
        # a stall is final once exchanges have been tried enough, or where rounding is all that is left
        if stalled and (state.bearable > 8 * BEARABLE or state.residual <= 100.0 * rounding_floor(state)):
            break
        if stalled:
            since_best = 0
            exchange(state)
        else:
            advance(state)
        state.assess(tolerance)
        settled = not final
    if final:
        state.balance(1e-14)  # the load of the settled pressure, to rounding: less cannot be met on every grid


def settle(state: State, tolerance: float) -> bool:
    """Put the points that are not free exactly on their bounds, as a step of full length.

    Return whether the gap had to follow: not if the bounds of what changes, residual and gap, are negligible.
    """
    problem = state.problem
    state.step[...] = 0.0
    slope_square = state.propose(0.0, 0.0)
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
        state.assessment = state.assessment._replace(residual=residual)  # an upper bound is enough
        state.response[...] = 0.0
    else:
        state.respond()
    state.move(1.0)
    state.curvature, state.alpha = 0.0, 1.0  # the last step is gone
    state.response[...] = 0.0
    return not negligible


def advance(state: State) -> None:
    """Take one step: preconditioned conjugate direction, load shift, exact length."""
    length = 0.0
    if state.assessment.free:
        cross, own = state.precondition()
        beta = max(state.alpha * cross / state.curvature, 0.0) if own > 0.0 else 0.0
        slope_square = state.propose(state.alpha, beta)
        length = 0.0 if slope_square is None else state.best_length(slope_square[0])
    if length < 0.05:  # a bad step: projected gradients, and where bad steps keep coming, exchanges
        state.failures += 1
        (descend if state.failures < state.bearable else exchange)(state)
        return
    state.failures = 0
    state.alpha = min(max(state.alpha * length, 0.2), LONGEST)
    # a short step was cut by points sent to their bound too many at a time: more of them stay free
    state.reach = min(1.5 * state.reach, REACH) if length > 0.5 else max(0.2 * state.reach, LEAST_REACH)
    state.move(length)


def descend(state: State) -> None:
    """Take a projected-gradient step, which always lowers the energy, and trust the active set less."""
    target = state.problem.target
    state.find_offset()
    # a tiny load that no offset meets is exceeded: the share brings the step back to it
    excess = state.assessment.excess
    share = target / (excess + target) if excess > 1e-9 * target else 1.0
    slope, _ = state.sums(kernels.gradient_step, *state.flat[:2], state.law, share, state.flat[4])
    state.alpha, state.reach = 1.0, max(0.5 * state.reach, LEAST_REACH)
    length = state.best_length(slope)
    if length > 0.0:
        state.move(length)


def exchange(state: State) -> None:
    """Solve on the free points, ever more accurately, exchange points until none changes sides, and begin anew."""
    p, cap, free, target = state.pressure, state.problem.cap, state.free.view(bool), state.problem.target
    p[...] = np.where(free | (p == cap), p, np.where(state.gap < state.offset, cap, 0.0))
    accuracy, fewest, share, idle = 0, p.size + 1, 1.0, 0
    while accuracy < len(ENOUGH) and idle < PATIENCE:
        # restore the load on the free points, beyond the bounds if need be, and compute the gap anew
        if not free.any():
            free[...] = True
        p[free] += (target - p.sum()) / np.count_nonzero(free)
        state.refresh(np.float64)
        solve_on_free_points(state, ENOUGH[accuracy])
        wrong = change_sides(state, share)
        idle = 0 if wrong < fewest else idle + 1
        share = min(2.0 * share, 1.0) if wrong < fewest else max(0.5 * share, LEAST_SHARE)
        fewest = min(fewest, wrong)
        accuracy += 1 if wrong == 0 else 0
    # put the pressure within its bounds and under its load
    np.clip(p, 0.0, cap, out=p)
    if not state.balance(1e-14):
        p[...] = state.problem.load
    state.refresh(np.float64)
    state.failures, state.bearable = 0, 2 * state.bearable
    state.curvature, state.alpha, state.reach = 0.0, 1.0, REACH
    state.step[...] = 0.0
    state.begin()


def solve_on_free_points(state: State, enough: float) -> None:
    """Conjugate gradients on the free points at fixed load, beyond the bounds if need be."""
    free, gained = state.free.view(bool), 0.0
    state.step[...] = 0.0
    state.response[...] = 0.0
    for _ in range(STEPS if np.count_nonzero(free) > 1 else 0):
        # turn the last step into the next: preconditioned, without load, and conjugate to the last
        offset = state.gap[free].mean()
        np.multiply(state.gap - offset, free, out=state.field, casting="unsafe")
        state.precondition()
        own = float(np.sum(state.step * state.response, dtype=float))
        state.field -= free * state.field[free].mean(dtype=float)
        beta = float(np.sum(state.field * state.response, dtype=float)) / own if own > 0.0 else 0.0
        state.step *= max(beta, 0.0)
        state.step -= state.field
        slope = float(np.sum(state.step * (state.gap - offset), dtype=float))
        state.respond()
        if not slope < 0.0 < state.curvature:
            break
        # its length is exact: nothing is clipped here
        length = -slope / state.curvature
        state.pressure += length * state.step
        state.gap += length * state.response
        state.noise += state.slack * length * state.response_size
        gained -= 0.5 * slope * length
        if -0.5 * slope * length <= enough * gained:
            break


def change_sides(state: State, share: float) -> int:
    """Points beyond a bound go onto it; points that pull away from theirs are set free: the worst, a share of them.

    Return how many were on the wrong side.
    """
    p, cap, free, kappa = state.pressure, state.problem.cap, state.free.view(bool), state.problem.stiffness
    # by how much each point is on the wrong side, a gap as the pressure that it stands for
    pull = kappa * (state.gap - state.gap[free].mean())
    wrong = np.where(free, np.maximum(-p, p - cap), np.where(p <= 0.0, -pull, pull) - kappa * state.noise).ravel()
    places = np.flatnonzero(wrong > 0.0)
    number, keep = places.size, max(int(share * places.size), 1)
    if keep < number:
        places = places[np.argpartition(wrong[places], number - keep)[number - keep :]]
    free.ravel()[places] ^= True
    np.clip(p, 0.0, cap, out=p)
    return number
