"""Gauss rules on panels that shrink geometrically towards a point, each with a coarser one to measure its error.

An integrand that is smooth in ln r, down to a scale that the speed sets, is resolved by such panels at every speed.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial.legendre import leggauss

from theory.arguments import Array
from theory.quadrature import POINTS, TOLERANCE, WEIGHTS, QuadratureError

_COARSE_POINTS, _COARSE_WEIGHTS = leggauss(POINTS.size - 3)
_NODES = np.concatenate([POINTS, _COARSE_POINTS])
_BOTH = np.zeros((_NODES.size, 2))
_BOTH[: POINTS.size, 0] = WEIGHTS
_BOTH[POINTS.size :, 1] = _COARSE_WEIGHTS


@dataclass(frozen=True, slots=True, eq=False)
class Rule:
    """Nodes and weights of an integral, and of a coarser one on the same panels.

    `nodes` has the shape (n,), `weights` (n, 2): each rule has the weight 0 at the nodes of the other.
    """

    nodes: Array
    weights: Array

    def joined(self, other: "Rule") -> "Rule":
        """Return the rule for the sum of the integrals over both domains."""
        return Rule(
            np.concatenate([self.nodes, other.nodes]),
            np.concatenate([self.weights, other.weights]),
        )

    def mapped(self, to: Callable[[Array], Array], slope: Callable[[Array], Array]) -> "Rule":
        """Return the rule in a new variable `to`(x), whose derivative is ± `slope`(x)."""
        return Rule(to(self.nodes), self.weights * slope(self.nodes)[:, None])

    def integral(self, integrand: Callable[[Array], Array]) -> Array:
        """Return the integral over the last axis of `integrand`(nodes).

        Raises
        ------
        QuadratureError
            If both rules differ by more than 1e-11 of the integral of the modulus.
        """
        values = integrand(self.nodes)
        result, coarse = np.moveaxis(values @ self.weights, -1, 0)
        error = np.abs(coarse - result)
        scale = np.abs(values) @ self.weights[:, 0]
        if not (error <= TOLERANCE * scale).all():
            raise QuadratureError(
                f"an integral over the source has the relative error {(error / scale).max():.1e}, above {TOLERANCE:.0e}"
            )
        return np.asarray(result)


def rule(edges: Array) -> Rule:
    """Return the rule on consecutive panels between `edges`."""
    middle, half = (edges[1:] + edges[:-1])[:, None] / 2, np.diff(edges)[:, None] / 2
    weights = half[..., None] * _BOTH
    return Rule((middle + half * _NODES).ravel(), weights.reshape(-1, 2))


def towards_zero(depth: float, top: float, ratio: float = 3.0) -> Array:
    """Return the edges 0, about `depth`, ..., `top`, each `ratio` times the last."""
    steps = max(int(np.ceil(np.log(top / depth) / np.log(ratio))), 1)
    return np.concatenate([[0.0], top * ratio ** np.arange(-steps, 1.0)])
