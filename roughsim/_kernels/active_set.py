"""Loops of the contact solver: load, active set, directions, steps.

Arrays are flat and of one or two precisions: p and gap in that of the solution, the others in that of the steps. Each
loop covers the points start … stop − 1 and returns partial sums. It slices its arrays first, so that no index can be
negative: otherwise the compiler's choice of loop, and with it the last bits of a sum, depend on addresses. `cap` is
the highest pressure (may be infinite); `free` is 1 on the free points and 0 elsewhere; `law` holds the offset d, the
stiffness κ and the cap of clip(p − κ(gap − d), 0, cap).
"""

from typing import Any

import numpy as np

from roughsim._kernels import REORDER, kernel

ROUNDING = 2 * float(np.finfo(np.float64).eps)


@kernel(fastmath=REORDER)
def subtract_heights(start: int, stop: int, heights: Any, middle: float, unit: float, p: Any, gap: Any) -> Any:
    """Turn the displacement in `gap` into the gap u − (heights − middle)/unit; return Σ p² and Σ u²."""
    heights = heights[start:stop]
    p = p[start:stop]
    gap = gap[start:stop]
    pressure, square = 0.0, 0.0
    for i in range(stop - start):
        u = gap[i]
        pressure += p[i] * p[i]
        square += u * u
        gap[i] = u - (heights[i] - middle) / unit
    return pressure, square


@kernel(fastmath=REORDER)
def extent(start: int, stop: int, heights: Any, middle: float, unit: float, gap: Any) -> Any:
    """The least and the largest displacement gap + (heights − middle)/unit."""
    heights = heights[start:stop]
    gap = gap[start:stop]
    low, high = np.inf, -np.inf
    for i in range(stop - start):
        u = gap[i] + (heights[i] - middle) / unit
        low, high = min(low, u), max(high, u)
    return low, high


@kernel(fastmath=REORDER)
def contact_sum(start: int, stop: int, p: Any, gap: Any) -> Any:
    """Σ gap where p > 0, and the number of these points."""
    p = p[start:stop]
    gap = gap[start:stop]
    total, count = 0.0, 0
    for i in range(stop - start):
        if p[i] > 0.0:
            total += gap[i]
            count += 1
    return total, count


@kernel(fastmath=REORDER)
def clipped_sum(start: int, stop: int, p: Any, gap: Any, law: Any) -> Any:
    """Σ clip(p − κ(gap − d), 0, cap), and how many points lie strictly between the bounds."""
    p = p[start:stop]
    gap = gap[start:stop]
    offset, stiffness, cap = law
    total, inside = 0.0, 0
    for i in range(stop - start):
        x = p[i] - stiffness * (gap[i] - offset)
        y = min(max(x, 0.0), cap)
        total += y
        inside += 1 if x == y else 0
    return total, inside


@kernel(fastmath=REORDER)
def classify(
    start: int, stop: int, p: Any, gap: Any, law: Any, reach: float, unit: float, limit: float, free: Any, rest: Any
) -> Any:
    """Fill the active set, and gap − d on the free points (zero elsewhere).

    A point is free where 0 < p − reach κ (gap − d) < cap. With x = clip(p − κ(gap − d), 0, cap) and m = p − x, return
    Σ x, how many x lie between the bounds, Σ (m·unit)², Σ (p·unit)², the number of free points, and that of points
    with |m| > limit; `unit` keeps the squares of tiny pressures alive. A free point that near its bound may have a
    gap of 1/reach times its |m|: there the limit is `reach` times as large.
    """
    p = p[start:stop]
    gap = gap[start:stop]
    free = free[start:stop]
    rest = rest[start:stop]
    offset, stiffness, cap = law
    near_bound = reach * limit
    total, inside, square, norm, count, above = 0.0, 0, 0.0, 0.0, 0, 0
    for i in range(stop - start):
        # the residual: how far the pressure is from its own projection onto the bounds
        r = gap[i] - offset
        x = p[i] - stiffness * r
        y = min(max(x, 0.0), cap)
        total += y
        inside += 1 if x == y else 0
        m = p[i] - y
        above += 1 if abs(m) > (limit if x == y else near_bound) else 0
        m *= unit
        square += m * m
        norm += (p[i] * unit) * (p[i] * unit)
        # the active set, by a shorter step: a point near its bound stays free for longer
        near = p[i] - reach * stiffness * r
        is_free = (near > 0.0) & (near < cap)
        free[i] = 1 if is_free else 0
        rest[i] = r if is_free else 0.0
        count += 1 if is_free else 0
    return total, inside, square, norm, count, above


@kernel(fastmath=REORDER)
def propose(
    start: int, stop: int, free: Any, p: Any, gap: Any, z: Any, mix: Any, law: Any, change: Any, results: Any
) -> Any:
    """Turn the last step into a trial change: β step − α z on the free points, to the nearest bound elsewhere.

    `results` are filled with what the bounds add to the load of each point, and with the free points that stay between
    the bounds. Return Σ clip(p + change, 0, cap), the number of these points, and Σ |what the bounds add|.
    """
    free = free[start:stop]
    p = p[start:stop]
    gap = gap[start:stop]
    z = z[start:stop]
    change = change[start:stop]
    load = results[0][start:stop]
    inner = results[1][start:stop]
    alpha, beta = mix
    offset, _, cap = law
    total, count, added = 0.0, 0.0, 0.0
    for i in range(stop - start):
        # as a number: masks from bytes are slow to mix with those from pressures
        inside = float(free[i])
        # pressed beyond the flat it goes to the cap, else to zero; at exactly d it goes where it carries already
        r = gap[i] - offset
        bound = cap if (r < 0.0) | ((r == 0.0) & (p[i] > 0.0)) else 0.0
        # both are computed and one is taken: a branch here would keep the loop from vector units
        own, other = beta * change[i] - alpha * z[i], bound - p[i]
        change[i] = own if inside > 0.0 else other
        x = p[i] + change[i]
        y = min(max(x, 0.0), cap)
        stays = inside if x == y else 0.0
        more = y - x if inside > 0.0 else other
        load[i] = more
        inner[i] = np.int8(stays)
        total += y
        count += stays
        added += abs(more)
    return total, count, added


@kernel(fastmath=REORDER)
def shifted_step(
    start: int, stop: int, free: Any, p: Any, gap: Any, change: Any, offset: float, shift: float, cap: float, step: Any
) -> Any:
    """Write the step clip(p + change + shift on the free points, 0, cap) − p.

    Return Σ of the clipped, how many free points stay between the bounds, ⟨step, gap − d⟩ and Σ step².
    """
    free = free[start:stop]
    p = p[start:stop]
    gap = gap[start:stop]
    change = change[start:stop]
    step = step[start:stop]
    total, count, slope, square = 0.0, 0.0, 0.0, 0.0
    for i in range(stop - start):
        inside = float(free[i])
        x = p[i] + change[i] + shift * inside
        y = min(max(x, 0.0), cap)
        total += y
        count += inside if x == y else 0.0
        c = y - p[i]
        step[i] = c
        slope += c * (gap[i] - offset)
        square += c * c
    return total, count, slope, square


@kernel(fastmath=REORDER)
def shift_free(start: int, stop: int, free: Any, p: Any, shift: float, cap: float) -> None:
    """Add the shift to the pressure of the free points, and put all within the bounds."""
    free = free[start:stop]
    p = p[start:stop]
    for i in range(stop - start):
        p[i] = min(max(p[i] + (shift if free[i] else 0.0), 0.0), cap)


@kernel(fastmath=REORDER)
def gradient_step(start: int, stop: int, p: Any, gap: Any, law: Any, share: float, step: Any) -> Any:
    """Write step = share · clip(p − κ(gap − d)) − p and return ⟨step, gap − d⟩ and Σ step²."""
    p = p[start:stop]
    gap = gap[start:stop]
    step = step[start:stop]
    offset, stiffness, cap = law
    slope, square = 0.0, 0.0
    for i in range(stop - start):
        r = gap[i] - offset
        c = share * min(max(p[i] - stiffness * r, 0.0), cap) - p[i]
        step[i] = c
        slope += c * r
        square += c * c
    return slope, square


@kernel(fastmath=REORDER)
def curvature(start: int, stop: int, step: Any, response: Any) -> Any:
    """⟨step, S·step⟩, Σ step² and Σ (S·step)²."""
    step = step[start:stop]
    response = response[start:stop]
    own, size, square = 0.0, 0.0, 0.0
    for i in range(stop - start):
        own += step[i] * response[i]
        size += step[i] * step[i]
        square += response[i] * response[i]
    return own, size, square


@kernel(fastmath=REORDER)
def advance(
    start: int, stop: int, p: Any, gap: Any, step: Any, response: Any, length: float, slack: float, law: Any
) -> Any:
    """Add τ step to the pressure and τ S·step to the gap; return the sums of `clipped_sum` there.

    What the rounding of the step left of a bound (a share `slack` of the step) goes onto the bound: no more, since the
    gap knows nothing of it.
    """
    p = p[start:stop]
    gap = gap[start:stop]
    step = step[start:stop]
    response = response[start:stop]
    offset, stiffness, cap = law
    total, inside = 0.0, 0
    top = cap * (1.0 - ROUNDING)
    for i in range(stop - start):
        x = p[i] + length * step[i]
        # the step was rounded when it was stored: what should have met a bound misses it by that
        x = 0.0 if x <= slack * p[i] else x
        x = cap if x >= top - slack * length * step[i] else x
        p[i] = x
        gap[i] += length * response[i]
        # the load of the clipped pressure at the old offset, from which the new one is guessed
        x -= stiffness * (gap[i] - offset)
        y = min(max(x, 0.0), cap)
        total += y
        inside += 1 if x == y else 0
    return total, inside


@kernel()
def to_si(start: int, stop: int, p: Any, u: Any, heights: Any, units: Any, bounds: Any) -> Any:
    """Turn the pressure and the gap into Pa and a displacement in m; return how many points touch and have yielded.

    `units` are those of pressure and gap and the middle of the heights, `bounds` the cap and the hardness, Pa.
    """
    p = p[start:stop]
    u = u[start:stop]
    heights = heights[start:stop]
    pressure_unit, unit, middle = units
    cap, hardness = bounds
    touching, yielded = 0, 0
    for i in range(stop - start):
        # a yielded point has exactly the hardness, not the hardness to rounding
        x, full = p[i] * pressure_unit, p[i] >= cap
        touching += 1 if p[i] > 0.0 else 0
        yielded += 1 if full else 0
        p[i] = hardness if full else min(x, hardness)
        u[i] = u[i] * unit + heights[i] - middle
    return touching, yielded
