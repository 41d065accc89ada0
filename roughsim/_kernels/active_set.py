"""Loops of the contact solver: load, active set, directions, steps.

Arrays are flat, of one length and of one or two precisions: pressure p and gap in the precision of the solution, the
others in the precision of the steps. Each loop returns sums over its points; the caller may divide the arrays and add
the sums. `cap` is the highest pressure (may be infinite); `free` is 1 on the free points and 0 elsewhere; `law` holds
the offset d, the stiffness κ and the cap of clip(p − κ(gap − d), 0, cap).
"""

import numpy as np

from roughsim._kernels import REORDER, kernel

_ROUNDING = 2 * float(np.finfo(np.float64).eps)


@kernel(fastmath=REORDER)
def subtract_heights(heights, p, gap, middle, unit):
    """Turn the displacement in `gap` into the gap u − (heights − middle)/unit; return Σ p² and Σ u²."""
    pressure = 0.0
    square = 0.0
    for i in range(p.size):
        u = gap[i]
        pressure += p[i] * p[i]
        square += u * u
        gap[i] = u - (heights[i] - middle) / unit
    return pressure, square


@kernel(fastmath=REORDER)
def extent(heights, gap, middle, unit):
    """The least and the largest displacement gap + (heights − middle)/unit."""
    low = np.inf
    high = -np.inf
    for i in range(gap.size):
        u = gap[i] + (heights[i] - middle) / unit
        low = min(low, u)
        high = max(high, u)
    return low, high


@kernel(fastmath=REORDER)
def contact_sum(p, gap):
    """Σ gap over the points with p > 0, and their number."""
    total = 0.0
    count = 0
    for i in range(p.size):
        if p[i] > 0.0:
            total += gap[i]
            count += 1
    return total, count


@kernel(fastmath=REORDER)
def clipped_sum(p, gap, law):
    """Σ clip(p − κ(gap − d), 0, cap), and how many points lie strictly between the bounds."""
    offset, stiffness, cap = law
    total = 0.0
    inside = 0
    for i in range(p.size):
        x = p[i] - stiffness * (gap[i] - offset)
        y = min(max(x, 0.0), cap)
        total += y
        inside += 1 if x == y else 0
    return total, inside


@kernel(fastmath=REORDER)
def classify(p, gap, free, rest, law, reach, unit, limit):
    """Fill the active set, and gap − d on the free points (zero elsewhere).

    A point is free if 0 < p − reach κ (gap − d) < cap. With x = clip(p − κ(gap − d), 0, cap) and m = p − x, return Σ x,
    how many x lie between the bounds, Σ (m·unit)², Σ (p·unit)², and the numbers of free points and of points with |m| >
    limit; `unit` keeps the squares of tiny pressures alive. A free point that near its bound may have a gap of 1/reach
    times its |m|: there the limit is `reach` times as large.
    """
    offset, stiffness, cap = law
    near_bound = reach * limit
    total = 0.0
    inside = 0
    square = 0.0
    norm = 0.0
    count = 0
    above = 0
    for i in range(p.size):
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
    p,
    gap,
    free,
    z,
    step,
    change,
    load,
    inner,
    mix,
    law,
):
    """Write the trial change: β step − α z on the free points, to the nearest bound elsewhere; `mix` holds α and β.

    `load` is filled with the load that the bounds add to each point, `inner` with 1 on the free points that stay
    between the bounds. Return Σ clip(p + change, 0, cap), the number of these points, and Σ |load|.
    """
    alpha, beta = mix
    offset, _, cap = law
    total = 0.0
    count = 0.0
    added = 0.0
    for i in range(p.size):
        # as a number: masks from bytes and masks from pressures mix slowly
        inside = float(free[i])
        # pressed beyond the flat it goes to the cap, else to zero; at exactly d it stays on its side
        r = gap[i] - offset
        bound = cap if (r < 0.0) | ((r == 0.0) & (p[i] > 0.0)) else 0.0
        # both are computed and one is taken: a branch here would keep the loop from vector units
        own = beta * step[i] - alpha * z[i]
        other = bound - p[i]
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
def shifted_step(p, gap, free, change, step, offset, shift, cap):
    """Write the step clip(p + change + shift on the free points, 0, cap) − p.

    Return Σ of the clipped, how many free points stay between the bounds, and ⟨step, gap − d⟩.
    """
    total = 0.0
    count = 0.0
    slope = 0.0
    for i in range(p.size):
        inside = float(free[i])
        x = p[i] + change[i] + shift * inside
        y = min(max(x, 0.0), cap)
        total += y
        count += inside if x == y else 0.0
        c = y - p[i]
        step[i] = c
        slope += c * (gap[i] - offset)
    return total, count, slope


@kernel(fastmath=REORDER)
def shifted_load(p, free, shift, cap):
    """Σ clip(p + shift on the free points, 0, cap), and how many free points stay between the bounds."""
    total = 0.0
    count = 0.0
    for i in range(p.size):
        inside = float(free[i])
        x = p[i] + shift * inside
        y = min(max(x, 0.0), cap)
        total += y
        count += inside if x == y else 0.0
    return total, count


@kernel(fastmath=REORDER)
def shift_free(p, free, shift, cap):
    """Add the shift to the pressure of the free points, and put all within the bounds."""
    for i in range(p.size):
        p[i] = min(max(p[i] + shift * float(free[i]), 0.0), cap)


@kernel(fastmath=REORDER)
def put_on_bounds(p, gap, free, law):
    """Set the pressure of the points that are not free to the bound next to p − κ(gap − d).

    The gap alone does not decide: on a surface that has yielded before, points at the cap just touch, gap = d.
    """
    offset, stiffness, cap = law
    for i in range(p.size):
        trial = p[i] - stiffness * (gap[i] - offset)
        bound = cap if trial > 0.5 * cap else 0.0
        p[i] = p[i] if free[i] else bound


@kernel(fastmath=REORDER)
def gradient_step(p, gap, step, law, share):
    """Write step = share · clip(p − κ(gap − d)) − p and return ⟨step, gap − d⟩."""
    offset, stiffness, cap = law
    slope = 0.0
    for i in range(p.size):
        r = gap[i] - offset
        c = share * min(max(p[i] - stiffness * r, 0.0), cap) - p[i]
        step[i] = c
        slope += c * r
    return slope


@kernel(fastmath=REORDER)
def curvature(step, response):
    """⟨step, S·step⟩, Σ step² and Σ (S·step)²."""
    own = 0.0
    size = 0.0
    square = 0.0
    for i in range(step.size):
        own += step[i] * response[i]
        size += step[i] * step[i]
        square += response[i] * response[i]
    return own, size, square


@kernel(fastmath=REORDER)
def advance(p, gap, step, response, length, slack, law):
    """Add τ step to the pressure and τ S·step to the gap; return the sums of `clipped_sum` there.

    Points within the rounding of the step (a share `slack` of it) go onto the bound, and no others, since the gap does
    not follow.
    """
    offset, stiffness, cap = law
    total = 0.0
    inside = 0
    top = cap * (1.0 - _ROUNDING)
    for i in range(p.size):
        x = p[i] + length * step[i]
        # the stored step is rounded, so a point that should meet a bound misses it by that much
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
def to_si(p, u, heights, units, bounds):
    """Turn the pressure and the gap into Pa and a displacement in m; return the numbers of touching and yielded points.

    `units` are the units of pressure and gap and the middle of the heights, `bounds` the cap and the hardness, Pa.
    """
    pressure_unit, unit, middle = units
    cap, hardness = bounds
    touching = 0
    yielded = 0
    for i in range(p.size):
        # a yielded point has exactly the hardness, not the hardness to rounding
        x = p[i] * pressure_unit
        full = p[i] >= cap
        touching += 1 if p[i] > 0.0 else 0
        yielded += 1 if full else 0
        p[i] = hardness if full else min(x, hardness)
        u[i] = u[i] * unit + heights[i] - middle
    return touching, yielded
