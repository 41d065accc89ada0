"""Gauss rules on panels that shrink geometrically towards a point, each with a coarser one to measure its error.

An integrand that is smooth in ln r, down to a scale that the speed sets, is resolved by such panels at every speed.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial.legendre import leggauss

from theory.arguments import Array
from theory.quadrature import POINTS, TOLERANCE, WEIGHTS, QuadratureError

_COARSE = leggauss(POINTS.size - 3)


@dataclass(frozen=True, slots=True, eq=False)
class Rule:
    """Nodes and weights of an integral, with a coarser set on the same panels."""

    nodes: Array
    weights: Array
    coarse_nodes: Array
    coarse_weights: Array

    def joined(self, other: "Rule") -> "Rule":
        """Return the rule for the sum of the integrals over both domains."""
        return Rule(
            np.concatenate([self.nodes, other.nodes]),
            np.concatenate([self.weights, other.weights]),
            np.concatenate([self.coarse_nodes, other.coarse_nodes]),
            np.concatenate([self.coarse_weights, other.coarse_weights]),
        )

    def mapped(self, to: Callable[[Array], Array], slope: Callable[[Array], Array]) -> "Rule":
        """Return the rule in a new variable `to`(x), whose derivative is ± `slope`(x)."""
        return Rule(
            to(self.nodes),
            self.weights * slope(self.nodes),
            to(self.coarse_nodes),
            self.coarse_weights * slope(self.coarse_nodes),
        )

    def integral(self, integrand: Callable[[Array], Array]) -> Array:
        """Return the integral over the last axis of `integrand`(nodes).

        Raises
        ------
        QuadratureError
            If both rules differ by more than 1e-11 of the integral of the modulus.
        """
        values = integrand(self.nodes)
        result = values @ self.weights
        error = np.abs(integrand(self.coarse_nodes) @ self.coarse_weights - result)
        scale = np.abs(values) @ self.weights
        if not (error <= TOLERANCE * scale).all():
            raise QuadratureError(
                f"an integral over the source has the relative error {(error / scale).max():.1e}, above {TOLERANCE:.0e}"
            )
        return np.asarray(result)


def rule(edges: Array) -> Rule:
    """Return the rule on consecutive panels between `edges`."""
    middle, half = (edges[1:] + edges[:-1])[:, None] / 2, np.diff(edges)[:, None] / 2
    points, weights = _COARSE
    return Rule(
        (middle + half * POINTS).ravel(),
        (half * WEIGHTS).ravel(),
        (middle + half * points).ravel(),
        (half * weights).ravel(),
    )


def towards_zero(depth: float, top: float, ratio: float = 3.0) -> Array:
    """Return the edges 0, about `depth`, ..., `top`, each `ratio` times the last."""
    steps = max(int(np.ceil(np.log(top / depth) / np.log(ratio))), 1)
    return np.concatenate([[0.0], top * ratio ** np.arange(-steps, 1.0)])
