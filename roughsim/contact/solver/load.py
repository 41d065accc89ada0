"""The offset or shift at which a contact carries its load: Newton's method on a sum that rises, with bisection.

The sum over all points of a clipped pressure rises with the offset, or the shift, by the number of points that lie
between the bounds times a factor. The caller gives the sum, so that it may be shared out among threads.
"""

from collections.abc import Callable
from math import inf, isfinite, nan

_Sums = Callable[
    [float], tuple[float, float]
]  # from offset or shift to Σ clipped pressure, and the number of points
# that lie between the bounds


def find_offset(
    sums: _Sums,
    bracket: Callable[[], tuple[float, float]],
    stiffness: float,
    target: float,
    first: tuple[float, ...],
) -> tuple[float, float, float]:
    """Solve Σ clip(p − κ(gap − d), 0, cap) = target for d. Return d, the excess over the target, and the number there.

    `first` holds these three of a first guess. `bracket` returns an offset at which no point carries pressure, and one
    at which the load is at least the target; it is called only if Newton's method leaves these bounds.
    """
    offset, excess, inside = first
    low = -inf
    high = inf
    bracketed = False
    last = False
    for _ in range(200):
        # the sum rises with d: the sign of the excess is the side of the solution on which d lies
        if excess > 0.0:
            high = min(high, offset)
        else:
            low = max(low, offset)
        # Newton: only points between the bounds answer to d, each by κ
        proposal = offset - excess / (stiffness * inside) if inside > 0 else nan
        if not low < proposal < high:
            if not bracketed:
                least, most = bracket()
                low = max(low, least)
                high = min(high, max(least, most))
                bracketed = True
            proposal = 0.5 * (low + high)
        if proposal == offset or not low < high:
            if not (excess < -1e-9 * target and high < inf):
                break
            proposal, last = high, True  # no number meets a tiny load: rather exceed it
        offset = proposal
        clipped, inside = sums(offset)
        excess = clipped - target
        if last or abs(excess) <= 1e-14 * target:
            break
    return offset, excess, inside


def find_shift(
    sums: _Sums, target: float, accuracy: float, clipped: float, count: float
) -> tuple[bool, float]:
    """Solve Σ clip(p + change + shift on the free points, 0, cap) = target; the sum and the number at 0 are known.

    Return whether a shift meets the target, to `accuracy` or as well as rounding allows, and the shift.
    """
    shift = 0.0
    low = -inf
    high = inf
    excess = clipped - target
    # without a bracket no bisection can help
    for _ in range(100):
        if abs(excess) <= accuracy * target:
            return True, shift
        if excess > 0.0:
            high = shift
        else:
            low = shift
        proposal = shift - excess / count if count > 0 else nan
        if not low < proposal < high:
            if not (isfinite(low) and isfinite(high)):
                return False, shift
            proposal = 0.5 * (low + high)
            if proposal in (low, high):
                break
        shift = proposal
        clipped, count = sums(shift)
        excess = clipped - target
    return abs(excess) <= 1e-9 * target, shift
