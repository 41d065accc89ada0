"""Loops of the push–pull pyramid: the extension of a field from the free points to the plane, and its transpose.

Weights are 1 on the free points. A parent cell has the weight min(1, Σ/3) and the weighted mean of its (up to) four
children; on the way back u = w v + (1 − w)·(bilinear interpolation of the parents), periodic.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from roughsim._kernels import REORDER, kernel


@kernel(fastmath=REORDER)
def push(weight: Any, value: Any, parent_weight: Any, parent_value: Any, parent_inverse: Any) -> None:
    """Fill the parents: weight, weighted mean, and 1/Σ weights."""
    rows, columns = weight.shape
    for i in range(parent_weight.shape[0]):
        for j in range(parent_weight.shape[1]):
            total, mean = 0.0, 0.0
            for a in range(2 * i, min(2 * i + 2, rows)):
                for b in range(2 * j, min(2 * j + 2, columns)):
                    total += weight[a, b]
                    mean += weight[a, b] * value[a, b]
            inverse = 1.0 / total if total > 0.0 else 0.0
            parent_weight[i, j] = min(1.0, total / 3.0)
            parent_value[i, j] = mean * inverse
            parent_inverse[i, j] = inverse


@kernel(fastmath=REORDER)
def pull(weight: Any, value: Any, parent: Any, result: Any) -> None:
    """Write w v + (1 − w)·bilinear(parent)."""
    rows, columns = weight.shape
    parents = parent.shape[1]
    blended = np.empty(parents + 2, parent.dtype)
    for i in range(rows):
        near, side = i // 2, (i // 2 + (1 if i % 2 else -1)) % parent.shape[0]
        for j in range(parents):
            blended[j + 1] = 0.75 * parent[near, j] + 0.25 * parent[side, j]
        blended[0], blended[parents + 1] = blended[parents], blended[1]
        for j in range(columns):
            k = j // 2 + 1
            w = weight[i, j]
            bilinear = 0.75 * blended[k] + 0.25 * blended[k + (1 if j % 2 else -1)]
            result[i, j] = w * value[i, j] + (1.0 - w) * bilinear


@kernel(fastmath=REORDER)
def pull_transposed(weight: Any, source: Any, parent: Any) -> None:
    """Write the transpose of the bilinear part: parent = bilinearᵀ (1 − w) source."""
    rows, columns = weight.shape
    parents = parent.shape[1]
    parent[:] = 0.0
    gathered = np.empty(parents + 2, parent.dtype)
    for i in range(rows):
        near, side = i // 2, (i // 2 + (1 if i % 2 else -1)) % parent.shape[0]
        gathered[:] = 0.0
        for j in range(columns):
            k = j // 2 + 1
            x = (1.0 - weight[i, j]) * source[i, j]
            gathered[k] += 0.75 * x
            gathered[k + (1 if j % 2 else -1)] += 0.25 * x
        gathered[parents] += gathered[0]
        gathered[1] += gathered[parents + 1]
        for j in range(parents):
            parent[near, j] += 0.75 * gathered[j + 1]
            parent[side, j] += 0.25 * gathered[j + 1]


@kernel(fastmath=REORDER)
def push_transposed(weight: Any, source: Any, parent: Any, parent_inverse: Any, result: Any) -> None:
    """Write w (source + parent / Σ weights): what reaches the values of this level."""
    rows, columns = weight.shape
    for i in range(rows):
        for j in range(columns):
            result[i, j] = weight[i, j] * (source[i, j] + parent_inverse[i // 2, j // 2] * parent[i // 2, j // 2])
