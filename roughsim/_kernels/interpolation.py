"""Loops that bring a field to a finer grid by periodic cubic convolution (Keys 1981)."""

from typing import Any

import numpy as np

from roughsim._kernels import REORDER, kernel


@kernel(fastmath=REORDER, allocates=True)
def refine(start: int, stop: int, coarse: Any, cap: float, p: Any, free: Any) -> Any:
    """Write p = the interpolated field where it is positive, zero elsewhere, and mark these points.

    Return Σ min(p, cap) and the number of marked points below the cap.
    """
    rows, columns = p.shape
    line = np.empty(coarse.shape[1], coarse.dtype)
    fine = np.empty(columns, coarse.dtype)
    total, count = 0.0, 0
    for i in range(start, stop):
        # one line across the coarse rows, then along that line: fewer products than from 16 points at once
        _row(coarse, i, rows, line, fine)
        # what the continuation left below zero is without contact
        for j in range(columns):
            x = fine[j]
            inside = x > 0.0
            x = x if inside else x * 0.0
            p[i, j] = x
            free[i, j] = 1 if inside else 0
            total += min(x, cap)
            count += 1 if inside & (x < cap) else 0
    return total, count


@kernel(allocates=True)
def interpolate(start: int, stop: int, coarse: Any, fine: Any) -> None:
    """Write the interpolated field; its grid may also be the coarser one."""
    line = np.empty(coarse.shape[1], coarse.dtype)
    for i in range(start, stop):
        _row(coarse, i, fine.shape[0], line, fine[i])


@kernel()
def _weights(points: int, coarse: int, i: int) -> Any:
    """The coarse point before fine point i, and the weights of the four around it."""
    position = i * (coarse / points)
    cell = int(np.floor(position))
    f = position - cell
    return (
        cell,
        f * (-0.5 + f * (1.0 - 0.5 * f)),
        1.0 + f * f * (1.5 * f - 2.5),
        f * (0.5 + f * (2.0 - 1.5 * f)),
        f * f * (0.5 * f - 0.5),
    )


@kernel(inline=True)
def _row(coarse: Any, i: int, rows: int, line: Any, fine: Any) -> None:
    """Fill row i of the fine field, of so many rows; `line` is a buffer for one coarse row."""
    (size, length), points, kind = coarse.shape, fine.size, coarse.dtype.type
    # across the coarse rows: one line of coarse points
    cell, a, b, c, d = _weights(rows, size, i)
    wa, wb, wc, wd = kind(a), kind(b), kind(c), kind(d)
    k0, k1, k2, k3 = (cell - 1) % size, cell % size, (cell + 1) % size, (cell + 2) % size
    for j in range(length):
        line[j] = wa * coarse[k0, j] + wb * coarse[k1, j] + wc * coarse[k2, j] + wd * coarse[k3, j]
    # along the line. Twice as fine, as nearly always: every other point is a coarse one, and those between have the
    # same weights, but for six points whose neighbours are at the other end
    twice, outer, inner = points == 2 * length and length > 2, kind(-0.0625), kind(0.5625)
    if twice:
        for j in range(1, length - 2):
            fine[2 * j] = line[j]
            fine[2 * j + 1] = outer * (line[j - 1] + line[j + 2]) + inner * (line[j] + line[j + 1])
    count = 6 if twice else points
    for k in range(count):
        j = k if k < 2 else points - count + k
        cell, a, b, c, d = _weights(points, length, j)
        fine[j] = (
            a * line[(cell - 1) % length]
            + b * line[cell % length]
            + c * line[(cell + 1) % length]
            + d * line[(cell + 2) % length]
        )
