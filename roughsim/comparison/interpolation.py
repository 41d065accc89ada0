"""Interpolation between the nodes of a table: linear, by cubic splines, and monotone.

SciPy has all of it, in packages that take longer to load than a comparison takes. Nodes increase, two or more of them;
values (nodes, ...) have one along their first axis.
"""

import numpy as np

from roughsim.grid import Array


def linear(nodes: Array, values: Array, x: float) -> Array:
    """Return the value at x on the line between the nodes around it."""
    k = cell_of(nodes, x)
    share = (x - nodes[k]) / (nodes[k + 1] - nodes[k])
    return np.asarray((1 - share) * values[k] + share * values[k + 1])


def spline(nodes: Array, values: Array, x: float) -> Array:
    """Return the value at x of the cubic spline that has no knots at the nodes next to its ends.

    Through two or three nodes goes a line or a parabola.
    """
    reached, knots = nodes - nodes[0], (nodes - nodes[0])[2:-2]
    powers = np.arange(min(nodes.size, 4))

    def basis(u: Array) -> Array:
        return np.concatenate((u[:, None] ** powers, np.maximum(u[:, None] - knots, 0.0) ** 3), axis=1)

    weights = np.linalg.solve(basis(reached).T, basis(np.array([x - nodes[0]]))[0])
    return np.asarray(np.tensordot(weights, values, 1))


def monotone(nodes: Array, values: Array, x: float) -> float:
    """Return the value at x of the cubics that rise and fall only where `values` do (Fritsch & Butland 1984)."""
    steps = np.diff(nodes)
    slopes = np.diff(values) / steps
    tangents = np.full(nodes.size, slopes[0])
    if nodes.size > 2:
        near, far = 2 * steps[1:] + steps[:-1], steps[1:] + 2 * steps[:-1]
        alike = slopes[1:] * slopes[:-1] > 0.0
        left, right = (np.where(alike, side, 1.0) for side in (slopes[:-1], slopes[1:]))
        tangents[1:-1] = np.where(alike, (near + far) / (near / left + far / right), 0.0)
        tangents[0] = tangent_at_end(steps[:2], slopes[:2])
        tangents[-1] = tangent_at_end(steps[:-3:-1], slopes[:-3:-1])
    k = cell_of(nodes, x)
    t, step = (x - nodes[k]) / steps[k], steps[k]
    # Hermite's cubics
    line = values[k] * (1 + 2 * t) * (1 - t) ** 2 + values[k + 1] * t**2 * (3 - 2 * t)
    return float(line + step * t * (1 - t) * (tangents[k] * (1 - t) - tangents[k + 1] * t))


def tangent_at_end(steps: Array, slopes: Array) -> float:
    """Return the tangent at the first node from the two cells next to it, such that the cubic stays monotone."""
    (step, next_step), (slope, next_slope) = steps, slopes
    tangent = float(((2 * step + next_step) * slope - step * next_slope) / (step + next_step))
    if tangent * slope <= 0.0:
        return 0.0
    return float(3 * slope) if slope * next_slope <= 0.0 and abs(tangent) > 3 * abs(slope) else tangent


def cell_of(nodes: Array, x: float) -> int:
    """Return the number of the cell between two nodes that holds x; the nearest one beyond the ends."""
    return int(np.clip(np.searchsorted(nodes, x, side="right") - 1, 0, nodes.size - 2))
