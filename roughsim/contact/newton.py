"""Where clipped steps get nowhere: the primal–dual active set with each of its linear problems solved.

In cells with very unlike sides, or under noise on every point, what clipping does to a step moves the load between
regions, and long waves answer so strongly that no clipped step lowers the energy. Here nothing is clipped while the
free points are fixed; then the points that left their bounds, or pull away from them, change sides (Hintermüller, Ito &
Kunisch 2003). Nearly S⁻¹ is an M-matrix, for which this converges without a line search.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughsim._kernels import active_set as kernels

if TYPE_CHECKING:
    from roughsim.contact.active_set import Iteration

Array = NDArray[Any]
PATIENCE = 30  # exchanges without fewer points moving than ever before, after which they lead nowhere
LEAST = 0.02  # share of the points on the wrong side that change it, when all at once lead in circles
STEPS = 300  # of conjugate gradients on one set
ENOUGH = (1e-4, 1e-8, 1e-13)  # a step that gains less than this share of the energy gained so far ends them


def exchange_points(state: Iteration) -> None:
    """Solve on the free points, ever more accurately, and exchange points until none changes sides."""
    p, bound = state.pressure, np.where(state.gap < state.offset, state.problem.cap, 0.0)
    p[...] = np.where(state.free.view(bool) | (p == state.problem.cap), p, bound)
    accuracy, fewest, share, idle = 0, p.size + 1, 1.0, 0
    while accuracy < len(ENOUGH) and idle < PATIENCE:
        _settle(state)
        _solve(state, ENOUGH[accuracy])
        wrong = _exchange(state, share)
        idle = 0 if wrong < fewest else idle + 1
        share = 1.0 if wrong < fewest else max(0.5 * share, LEAST)
        fewest = min(fewest, wrong)
        accuracy += 1 if wrong == 0 else 0
    np.clip(state.pressure, 0.0, state.problem.cap, out=state.pressure)
    _settle(state)


def _settle(state: Iteration) -> None:
    """Put all but the free points on their bounds, restore the load on these, and compute the gap."""
    p, free, cap = state.pressure, state.free, state.problem.cap
    state.step[...] = 0.0
    flat = free.ravel(), p.ravel()
    shift = state.load_shift(state.sums(kernels.shifted_sum, *flat, state.step.ravel(), 0.0, cap), 1e-14)
    if shift is not None:
        for a, b in state.blocks:
            kernels.balance(a, b, flat[0], shift, cap, flat[1])
    state.refresh(np.float64)


def _solve(state: Iteration, enough: float) -> None:
    """Conjugate gradients on the free points under their load, beyond the bounds if need be."""
    free = state.free.view(bool)
    count, gained = np.count_nonzero(free), 0.0
    state.step[...] = 0.0
    state.response[...] = 0.0
    for _ in range(STEPS if count > 1 else 0):
        offset = state.gap[free].mean()
        np.multiply(state.gap - offset, free, out=state.field, casting="unsafe")
        state.extension.extend(state.free, state.field)
        state.operator.stiffen(state.field, state.field)
        _, own = state.extension.transpose(state.free, state.field, state.step, state.response)
        state.field -= free * state.field[free].mean(dtype=float)
        beta = float(np.sum(state.field * state.response, dtype=float)) / own if own > 0.0 else 0.0
        state.step *= max(beta, 0.0)
        state.step -= state.field
        slope = float(np.sum(state.step * (state.gap - offset), dtype=float))
        state._respond()
        if not slope < 0.0 < state.curvature:
            break
        length = -slope / state.curvature
        state.pressure += length * state.step
        state.gap += length * state.response
        state.noise += state.slack * length * state.response_size
        gain = -0.5 * slope * length
        gained += gain
        if gain <= enough * gained:
            break


def _exchange(state: Iteration, share: float) -> int:
    """Points beyond a bound go onto it; points that pull away from theirs are set free: the worst, a share of them.

    Return how many were on the wrong side.
    """
    p, cap, free, kappa = state.pressure, state.problem.cap, state.free.view(bool), state.problem.stiffness
    pull = kappa * (state.gap - state.gap[free].mean())
    wrong = np.where(free, np.maximum(-p, p - cap), np.where(p <= 0.0, -pull, pull) - kappa * state.noise)
    places = np.flatnonzero(wrong > 0.0)
    number = places.size
    if share < 1.0 and number > 1:
        keep = max(int(share * number), 1)
        places = places[np.argpartition(wrong.ravel()[places], number - keep)[number - keep :]]
    free.ravel()[places] ^= True
    np.clip(p, 0.0, cap, out=p)
    return number
