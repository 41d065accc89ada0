"""Loops of the push–pull pyramid where only one axis is halved: cells much longer along one axis than the other.

As `extension` has them for both axes, but for the share of a parent that makes it whole: it is `WHOLE` of two
children rather than three of four. Which axis is halved follows from the shapes.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from roughsim._kernels import REORDER, kernel

WHOLE = 1.5  # children on which a parent has the full weight


@kernel(fastmath=REORDER)
def push(weight: Any, value: Any, parent_weight: Any, parent_value: Any, parent_inverse: Any) -> None:
    """Fill the parents: weight min(1, Σ/`WHOLE`), weighted mean, 1/Σ weights."""
    rows, columns = weight.shape
    high, wide = rows > parent_weight.shape[0], columns > parent_weight.shape[1]
    one, zero, share = value.dtype.type(1.0), value.dtype.type(0.0), value.dtype.type(1.0 / WHOLE)
    totals, sums = np.empty(columns + 1, value.dtype), np.empty(columns + 1, value.dtype)
    totals[columns], sums[columns] = zero, zero  # the partner of an odd last column
    for i in range(parent_weight.shape[0]):
        first, second = (2 * i, 2 * i + 1) if high else (i, rows)
        for j in range(columns):
            totals[j] = weight[first, j]
            sums[j] = weight[first, j] * value[first, j]
        if second < rows:
            for j in range(columns):
                totals[j] += weight[second, j]
                sums[j] += weight[second, j] * value[second, j]
        for j in range(parent_weight.shape[1]):
            total, mean = (
                (totals[2 * j] + totals[2 * j + 1], sums[2 * j] + sums[2 * j + 1]) if wide else (totals[j], sums[j])
            )
            inverse = one / total if total > zero else zero
            parent_inverse[i, j] = inverse
            parent_value[i, j] = mean * inverse
            parent_weight[i, j] = min(one, total * share)


@kernel(fastmath=REORDER)
def pull(weight: Any, parent: Any, value: Any) -> None:
    """Write w v + (1 − w)·(linear interpolation of the parents)."""
    rows, columns = value.shape
    high, wide = rows > parent.shape[0], columns > parent.shape[1]
    parents = parent.shape[1]
    one, big, small = parent.dtype.type(1.0), parent.dtype.type(0.75), parent.dtype.type(0.25)
    line = np.empty(parents + 2, parent.dtype)
    for i in range(rows):
        near, side = _parents(i, parent.shape[0], high)
        for j in range(parents):
            line[j + 1] = big * parent[near, j] + small * parent[side, j]
        line[0], line[parents + 1] = line[parents], line[1]
        for j in range(columns):
            at = j // 2 + 1
            mean = big * line[at] + small * line[at + 2 * (j % 2) - 1] if wide else line[j + 1]
            value[i, j] = weight[i, j] * value[i, j] + (one - weight[i, j]) * mean


@kernel(fastmath=REORDER)
def gather(weight: Any, source: Any, parent: Any) -> None:
    """Fill the parents with the transpose of the linear part of `pull`."""
    rows, columns = source.shape
    high, wide = rows > parent.shape[0], columns > parent.shape[1]
    one, big, small = source.dtype.type(1.0), source.dtype.type(0.75), source.dtype.type(0.25)
    parent[:, :] = 0.0
    line = np.empty(columns, source.dtype)
    for i in range(rows):
        near, side = _parents(i, parent.shape[0], high)
        for j in range(columns):
            line[j] = (one - weight[i, j]) * source[i, j]
        if wide:
            for j in range(columns):
                other = _parents(j, parent.shape[1], True)
                parent[i, other[0]] += big * line[j]
                parent[i, other[1]] += small * line[j]
        else:
            for j in range(columns):
                parent[near, j] += big * line[j]
                parent[side, j] += small * line[j]


@kernel(fastmath=REORDER)
def scatter(weight: Any, parent: Any, inverse: Any, source: Any) -> None:
    """Write w (source + what the parent has for its children): the transpose of `push`."""
    rows, columns = source.shape
    high, wide = rows > parent.shape[0], columns > parent.shape[1]
    for i in range(rows):
        k = i // 2 if high else i
        for j in range(columns):
            m = j // 2 if wide else j
            source[i, j] = weight[i, j] * (source[i, j] + inverse[k, m] * parent[k, m])


@kernel()
def _parents(child: int, parents: int, halved: bool) -> Any:
    """The parent of a child and the parent beside it, periodic; the child itself, twice, if the axis is not halved."""
    if not halved:
        return child, child
    near = child // 2
    return near, (near + 2 * (child % 2) - 1) % parents
