"""Where clipped steps get nowhere: the primal–dual active set with each of its linear problems solved.

In cells with very unlike sides, or under noise on every point, what clipping does to a step moves the load between
regions, and long waves answer so strongly that no clipped step lowers the energy. Here nothing is clipped while the
free points are fixed; then the points that left their bounds, or pull away from them, change sides (Hintermüller, Ito &
Kunisch 2003). Where all at once lead in circles, ever fewer change, the worst of them (block pivoting: Júdice & Pires
1994).
"""

from __future__ import annotations

import numpy as np

from roughsim.contact.solver.state import State

PATIENCE = 30  # exchanges without fewer points on the wrong side than ever before, after which they lead nowhere
LEAST = 0.02  # share of these points that change sides, at least
STEPS = 300  # of conjugate gradients on one set
ENOUGH = (1e-4, 1e-8, 1e-13)  # a step that gains less than this share of the energy gained so far ends them


def exchange_points(state: State) -> None:
    """Solve on the free points, ever more accurately, and exchange points until none changes sides."""
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
        share = min(2.0 * share, 1.0) if wrong < fewest else max(0.5 * share, LEAST)
        fewest = min(fewest, wrong)
        accuracy += 1 if wrong == 0 else 0
    # put the pressure within its bounds and under its load
    np.clip(p, 0.0, cap, out=p)
    if not state.balance(1e-14):
        p[...] = state.problem.load
    state.refresh(np.float64)


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
