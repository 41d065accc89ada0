"""Loops of the contact solver: load equation, active set, directions, steps.

Arrays are flat views; `cap` is the highest pressure (may be infinite); `free` is 1 on the free points and 0 elsewhere.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from roughsim._kernels import REORDER, kernel


@kernel(fastmath=REORDER)
def clipped_sum(p: Any, gap: Any, stiffness: float, offset: float, cap: float) -> Any:
    """Σ clip(p − κ(gap − d), 0, cap), and how many points lie strictly between the bounds."""
    total, free = 0.0, 0
    for i in range(p.size):
        x = p[i] - stiffness * (gap[i] - offset)
        y = min(max(x, 0.0), cap)
        total += y
        free += 1 if x == y else 0
    return total, free


@kernel()
def _bracket(p: Any, gap: Any, stiffness: float, cap: float, target: float) -> Any:
    """Offsets at which the clipped sum is surely zero and surely at least the target."""
    low, high = np.inf, -np.inf
    goal = min(cap, target / p.size * (1.0 + 1e-12))
    for i in range(p.size):
        low = min(low, gap[i] - p[i] / stiffness)
        high = max(high, gap[i] + (goal - p[i]) / stiffness)
    return low, max(high, low)


@kernel()
def load_offset(p: Any, gap: Any, stiffness: float, offset: float, cap: float, target: float) -> float:
    """Solve Σ clip(p − κ(gap − d), 0, cap) = target for d by Newton's method, safeguarded by bisection."""
    low, high = -np.inf, np.inf
    bracketed = False
    for _ in range(200):
        total, free = clipped_sum(p, gap, stiffness, offset, cap)
        excess = total - target
        if abs(excess) <= 1e-14 * target:
            break
        if excess > 0.0:
            high = min(high, offset)
        else:
            low = max(low, offset)
        proposal = offset - excess / (stiffness * free) if free > 0 else np.nan
        if not low < proposal < high:
            if not bracketed:
                a, b = _bracket(p, gap, stiffness, cap, target)
                low, high, bracketed = max(low, a), min(high, b), True
            proposal = 0.5 * (low + high)
        if proposal == offset or not low < high:
            break
        offset = proposal
    return offset


@kernel(fastmath=REORDER)
def classify(p: Any, gap: Any, offset: float, stiffness: float, reach: float, cap: float, free: Any, r: Any) -> Any:
    """Fill the active set, and r = gap − d on the free points (zero elsewhere); return their number.

    A point is free where 0 < p − reach κ r < cap.
    """
    count = 0
    for i in range(p.size):
        rest = gap[i] - offset
        x = p[i] - reach * stiffness * rest
        inside = (x > 0.0) & (x < cap)
        free[i] = 1 if inside else 0
        r[i] = rest if inside else 0.0
        count += 1 if inside else 0
    return count


@kernel(fastmath=REORDER)
def mismatch(p: Any, gap: Any, offset: float, stiffness: float, cap: float, unit: float) -> Any:
    """√(Σ m²/Σ p²) and max |m|, m = p − clip(p − κ(gap − d)); `unit` keeps the squares of tiny pressures alive."""
    square, norm, worst = 0.0, 0.0, 0.0
    for i in range(p.size):
        x = p[i] - stiffness * (gap[i] - offset)
        m = (p[i] - min(max(x, 0.0), cap)) * unit
        square += m * m
        norm += (p[i] * unit) ** 2
        worst = max(worst, abs(m))
    return np.sqrt(square / norm), worst / unit


@kernel()
def settle(free: Any, trial: Any, shift: float, cap: float, p: Any) -> None:
    """Write p = clip(trial + shift): exact bounds on the points that are not free."""
    for i in range(p.size):
        p[i] = min(max(trial[i] + (shift if free[i] else 0.0), 0.0), cap)


@kernel(fastmath=REORDER)
def conjugacy(free: Any, z: Any, step: Any, response: Any) -> Any:
    """⟨z, S·step⟩ and ⟨step, S·step⟩ over the free points."""
    cross, own = 0.0, 0.0
    for i in range(free.size):
        if free[i]:
            cross += z[i] * response[i]
            own += step[i] * response[i]
    return cross, own


@kernel()
def propose(
    free: Any, p: Any, gap: Any, offset: float, z: Any, alpha: float, beta: float, cap: float, trial: Any
) -> None:
    """Turn the last step into a trial: p − α z + β step on the free points, the nearest bound elsewhere."""
    for i in range(free.size):
        if free[i]:
            trial[i] = p[i] - alpha * z[i] + beta * trial[i]
        else:
            rest = gap[i] - offset
            trial[i] = cap if rest < 0.0 or (rest == 0.0 and p[i] > 0.0) else 0.0


@kernel(fastmath=REORDER)
def shifted_sum(free: Any, trial: Any, shift: float, cap: float) -> Any:
    """Σ of the trial with its free points shifted and clipped, and how many of them stay between the bounds."""
    total, count = 0.0, 0
    for i in range(free.size):
        x = trial[i] + (shift if free[i] else 0.0)
        y = min(max(x, 0.0), cap)
        total += y
        count += 1 if (x == y) & (free[i] == 1) else 0
    return total, count


@kernel()
def load_shift(free: Any, trial: Any, cap: float, target: float) -> Any:
    """Solve for the shift of the free points that restores the load; False if none does."""
    shift, low, high, excess = 0.0, -np.inf, np.inf, np.inf
    for _ in range(100):
        total, count = shifted_sum(free, trial, shift, cap)
        excess = total - target
        if abs(excess) <= 1e-14 * target:
            return shift, True
        if excess > 0.0:
            high = shift
        else:
            low = shift
        proposal = shift - excess / count if count > 0 else np.nan
        if not low < proposal < high:
            if not (np.isfinite(low) and np.isfinite(high)):
                return shift, False
            proposal = 0.5 * (low + high)
            if proposal in (low, high):
                break
        shift = proposal
    return shift, abs(excess) <= 1e-9 * target


@kernel(fastmath=REORDER)
def free_step(free: Any, trial: Any, shift: float, cap: float, p: Any, gap: Any, offset: float) -> float:
    """Turn the trial into the step clip(trial + shift) − p and return its slope ⟨step, gap − d⟩."""
    slope = 0.0
    for i in range(free.size):
        x = trial[i] + (shift if free[i] else 0.0)
        change = min(max(x, 0.0), cap) - p[i]
        trial[i] = change
        slope += change * (gap[i] - offset)
    return slope


@kernel(fastmath=REORDER)
def gradient_step(p: Any, gap: Any, offset: float, stiffness: float, cap: float, step: Any) -> float:
    """Write step = clip(p − κ(gap − d)) − p and return its slope ⟨step, gap − d⟩, never positive."""
    slope = 0.0
    for i in range(p.size):
        rest = gap[i] - offset
        change = min(max(p[i] - stiffness * rest, 0.0), cap) - p[i]
        step[i] = change
        slope += change * rest
    return slope


@kernel(fastmath=REORDER)
def curvature(spectrum: Any, wavenumber: Any, multiplicity: Any) -> float:
    """Σ_q S |step_q|², S = 2/q, over the full plane."""
    total = 0.0
    rows, columns = spectrum.shape
    for i in range(rows):
        for j in range(columns):
            q = wavenumber[i, j]
            if q > 0.0:
                c = spectrum[i, j]
                total += multiplicity[0, j] * 2.0 / q * (c.real * c.real + c.imag * c.imag)
    return total


@kernel()
def comply(spectrum: Any, wavenumber: Any, factor: float) -> None:
    """Multiply by factor · 2/q; q = 0 becomes zero: from pressure to displacement."""
    rows, columns = spectrum.shape
    for i in range(rows):
        for j in range(columns):
            q = wavenumber[i, j]
            spectrum[i, j] *= 2.0 * factor / q if q > 0.0 else 0.0


@kernel()
def stiffen(spectrum: Any, wavenumber: Any, factor: float) -> None:
    """Multiply by factor · q/2: from displacement to pressure."""
    rows, columns = spectrum.shape
    for i in range(rows):
        for j in range(columns):
            spectrum[i, j] *= 0.5 * factor * wavenumber[i, j]


@kernel()
def advance(p: Any, gap: Any, step: Any, response: Any, length: float) -> None:
    """Add τ step to the pressure and τ S·step to the gap."""
    for i in range(p.size):
        p[i] += length * step[i]
        gap[i] += length * response[i]
