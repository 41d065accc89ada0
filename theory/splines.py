"""The spline of degree 5 nearest to weighted points, and its values by de Boor's algorithm.

scipy.interpolate has it too, but imports scipy.optimize, and so takes as long as a sixth of the start of a command.
"""

from typing import NamedTuple

import numpy as np

from theory.arguments import Array

DEGREE = 5


class Spline(NamedTuple):
    """A function of x, constant beyond its ends."""

    knots: Array  # ascending, each end DEGREE + 1 times
    coefficients: Array  # (..., n): several splines on the same knots

    def __call__(self, x: Array) -> Array:
        """Return the values at the places `x`, of the shape (..., *x.shape)."""
        t = self.knots
        at = np.clip(x.ravel(), t[0], t[-1])
        last = np.clip(np.searchsorted(t, at, side="right") - 1, DEGREE, t.size - DEGREE - 2)
        place = last + np.arange(-DEGREE, 1)[:, None]
        values: Array = self.coefficients[..., place]
        for degree in range(1, DEGREE + 1):
            place = place[1:]
            start = t[place]
            share = (at - start) / (t[place + DEGREE + 1 - degree] - start)
            values = (1 - share) * values[..., :-1, :] + share * values[..., 1:, :]
        return values.reshape(*self.coefficients.shape[:-1], *x.shape)


def nearest_spline(x: Array, y: Array, weight: Array, inner: Array) -> Spline:
    """Return the spline with knots at `inner` and both ends of x, whose (`weight` × difference to y)² sum to the least.

    All have the shape (n,), x ascending; between any two knots must lie points.
    """
    ends = np.full(DEGREE + 1, x[0]), np.full(DEGREE + 1, x[-1])
    knots = np.concatenate([ends[0], inner, ends[1]])
    each = Spline(knots, np.eye(knots.size - DEGREE - 1))(x)
    return Spline(knots, np.asarray(np.linalg.lstsq((weight * each).T, weight * y)[0]))
