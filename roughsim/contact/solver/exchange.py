"""Exchange of points between the free set and the bounds, for problems on which clipped steps fail.

In cells with very unlike sides, or under noise on every point, the clipping of a step moves the load between regions,
and long waves answer so strongly that no clipped step lowers the energy. Then the primal–dual active set is followed
with each of its linear problems solved. Nothing is clipped while the free points are fixed; then the points that left
their bounds, or pull away from them, change sides (Hintermüller, Ito & Kunisch 2003). If all at once lead in circles,
ever fewer change, the worst of them (block pivoting: Júdice & Pires 1994).
"""

import numpy as np

from roughsim.contact.solver.steps import Iterate

_PATIENCE = 30  # exchanges without fewer points on the wrong side
_LEAST_SHARE = 0.02  # of the points on the wrong side, that change sides at least
_STEPS = 300  # of conjugate gradients on one set of free points
# a step that gains less than this share of the energy gained so far ends them
_ENOUGH = (1e-4, 1e-8, 1e-13)


def exchange(now: Iterate) -> None:
    """Solve on the free points, ever more accurately, and exchange points until none is on the wrong side."""
    p = now.pressure
    work = now.work
    cap = now.problem.cap
    free = work.free.view(np.bool_)
    bound = np.where(now.gap < now.offset, cap, 0.0)
    p[...] = np.where(free | (p == cap), p, bound)
    accuracy = 0
    idle = 0
    fewest = p.size + 1
    share = 1.0
    while accuracy < len(_ENOUGH) and idle < _PATIENCE:
        # restore the load on the free points, beyond the bounds if need be, and compute the gap again
        if not free.any():
            free[...] = True
        p[free] += (now.problem.target - p.sum()) / np.count_nonzero(free)
        now.compute_gap(np.float64)
        _solve_on_free_points(now, _ENOUGH[accuracy])
        wrong = _change_sides(now, share)
        if wrong < fewest:
            idle = 0
            share = min(2.0 * share, 1.0)
            fewest = wrong
        else:
            idle += 1
            share = max(0.5 * share, _LEAST_SHARE)
        if wrong == 0:
            accuracy += 1
    # put the pressure within its bounds and under its load
    np.clip(p, 0.0, cap, out=p)
    if not now.balance(1e-14):
        p[...] = now.problem.load
    now.compute_gap(np.float64)
    now.guess_offset()
    work.step.fill(0.0)


def _solve_on_free_points(now: Iterate, enough: float) -> None:
    """Conjugate gradients on the free points at fixed load, beyond the bounds if need be."""
    work = now.work
    free = work.free.view(np.bool_)
    gained = 0.0
    work.step.fill(0.0)
    work.response.fill(0.0)
    for _ in range(_STEPS if np.count_nonzero(free) > 1 else 0):
        # turn the last step into the next: preconditioned, without load, and conjugate to the last
        offset = now.gap[free].mean()
        np.multiply(now.gap - offset, free, out=work.field, casting="unsafe")
        now.precondition()
        own = float(np.sum(work.step * work.response, dtype=float))
        mean = work.field[free].mean(dtype=float)
        np.subtract(work.field, free * mean, out=work.field, casting="unsafe")
        cross = float(np.sum(work.field * work.response, dtype=float))
        beta = max(cross / own, 0.0) if own > 0.0 else 0.0
        np.multiply(work.step, beta, out=work.step, casting="unsafe")
        np.subtract(work.step, work.field, out=work.step)
        slope = float(np.sum(work.step * (now.gap - offset), dtype=float))
        curvature, noise = now.respond()
        if not slope < 0.0 < curvature:
            break
        # its length is exact: nothing is clipped here
        length = -slope / curvature
        now.pressure += length * work.step
        now.gap += length * work.response
        now.noise += length * noise
        gain = -0.5 * slope * length
        gained += gain
        if gain <= enough * gained:
            break


def _change_sides(now: Iterate, share: float) -> int:
    """Points beyond a bound go onto it; points that pull away from theirs are set free: the worst, a share of them.

    Return the number of points on the wrong side.
    """
    p = now.pressure
    cap = now.problem.cap
    stiffness = now.problem.stiffness
    free = now.work.free.view(np.bool_)
    # by how much each point is on the wrong side, a gap as the pressure that it stands for
    pull = stiffness * (now.gap - now.gap[free].mean())
    beyond = np.maximum(-p, p - cap)
    away = np.where(p <= 0.0, -pull, pull) - stiffness * now.noise
    wrong = np.where(free, beyond, away).ravel()
    places = np.flatnonzero(wrong > 0.0)
    number = places.size
    keep = max(int(share * number), 1)
    if keep < number:
        places = places[np.argpartition(wrong[places], number - keep)[number - keep :]]
    free.ravel()[places] ^= True
    np.clip(p, 0.0, cap, out=p)
    return number
