"""Loops that bring a field to a finer grid by periodic cubic convolution (Keys 1981).

`across` and `along` name the coarse points around each fine point, and their weights: see `neighbours`.
"""

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughsim._kernels import REORDER, kernel

AT_ENDS = [0, 1, -4, -3, -2, -1]  # points of a line twice as fine whose neighbours are at both ends of the coarse one


@lru_cache(maxsize=32)
def neighbours(points: int, coarse: int) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """Return the four coarse points around each of so many fine ones, and their weights, (points, 4) both."""
    position = np.arange(points) * (coarse / points)
    cell = np.floor(position)
    f = position - cell
    weights = (
        f * (-0.5 + f * (1.0 - 0.5 * f)),
        1.0 + f * f * (1.5 * f - 2.5),
        f * (0.5 + f * (2.0 - 1.5 * f)),
        f * f * (0.5 * f - 0.5),
    )
    return (cell.astype(np.intp)[:, None] + np.arange(-1, 3)) % coarse, np.stack(weights, axis=1)


def tables(coarse: tuple[int, ...], fine: tuple[int, ...], dtype: Any) -> tuple[Any, Any]:
    """Return `across` the rows, in the precision of the field, and `along` them, for fields of these shapes.

    Along a line twice as fine it names only the points at both ends, which are listed with it.
    """
    across, along = (neighbours(*sizes) for sizes in zip(fine, coarse, strict=True))
    twice = fine[1] == 2 * coarse[1] and coarse[1] > 2
    points = np.arange(fine[1])[AT_ENDS if twice else slice(None)]
    return (across[0], across[1].astype(dtype)), (points, along[0][points], along[1][points])


@kernel(fastmath=REORDER)
def refine(
    start: int, stop: int, across: Any, along: Any, coarse: Any, cap: float, p: Any, free: Any, line: Any, fine: Any
) -> Any:
    """Write p = the interpolated field where it is positive, zero elsewhere, and mark these points.

    `line` and `fine` are buffers for a row of the coarse field and of the fine one. Return Σ min(p, cap) and the number
    of marked points below the cap.
    """
    total, count = 0.0, 0
    for i in range(start, stop):
        # one line across the coarse rows, then along that line: fewer products than from 16 points at once
        _row(i, across, along, coarse, line, fine)
        # what the continuation left below zero is without contact
        for j in range(fine.size):
            x = fine[j]
            inside = x > 0.0
            x = x if inside else x * 0.0
            p[i, j] = x
            free[i, j] = 1 if inside else 0
            total += min(x, cap)
            count += 1 if inside & (x < cap) else 0
    return total, count


@kernel()
def interpolate(start: int, stop: int, across: Any, along: Any, coarse: Any, fine: Any, line: Any) -> None:
    """Write the interpolated field; its grid may also be the coarser one. `line` is a buffer for a coarse row."""
    for i in range(start, stop):
        _row(i, across, along, coarse, line, fine[i])


@kernel(inline=True)
def _row(i: int, across: Any, along: Any, coarse: Any, line: Any, fine: Any) -> None:
    """Fill row i of the fine field; `line` is a buffer for one coarse row."""
    length, kind = line.size, line.dtype.type
    # across the coarse rows: one line of coarse points
    rows, weights = across
    k0, k1, k2, k3 = rows[i, 0], rows[i, 1], rows[i, 2], rows[i, 3]
    wa, wb, wc, wd = weights[i, 0], weights[i, 1], weights[i, 2], weights[i, 3]
    for j in range(length):
        line[j] = wa * coarse[k0, j] + wb * coarse[k1, j] + wc * coarse[k2, j] + wd * coarse[k3, j]
    # along the line. Twice as fine, as nearly always: every other point is a coarse one, and those between have the
    # same weights, but for six points whose neighbours are at the other end
    points, columns, shares = along
    if points.size < fine.size:
        outer, inner = kind(-0.0625), kind(0.5625)
        for j in range(1, length - 2):
            fine[2 * j] = line[j]
            fine[2 * j + 1] = outer * (line[j - 1] + line[j + 2]) + inner * (line[j] + line[j + 1])
    for k in range(points.size):
        fine[points[k]] = (
            shares[k, 0] * line[columns[k, 0]]
            + shares[k, 1] * line[columns[k, 1]]
            + shares[k, 2] * line[columns[k, 2]]
            + shares[k, 3] * line[columns[k, 3]]
        )
