"""The slope of the stress spectrum |σ_q|² inside the self-affine band, measured and in the theory.

With C ∝ q^(−2−2H) full contact has |σ_q|² ∝ q^(−2H). Where contact is lost P ∝ 1/√G ∝ q^(H−1), so that the theory's
slope tends to −(1 + H) in a long band. Slopes are of least squares in ln q, all of the band with the same weight; what
a finite pixel changes of them is not in their error.
"""

from __future__ import annotations

from math import log
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from roughsim import prediction
from roughsim.estimate.errors import quantile, spread
from roughsim.surface.radial import modes_between

if TYPE_CHECKING:
    from roughsim.results.run import Run

WIDTH = 0.12  # of a bin in ln q
LEAST_BINS = 12  # that make a band


class Slope(NamedTuple):
    """d ln|σ_q|²/d ln q of a column from `low` to `high`, rad/m; `error` is statistical, 95 %."""

    column: str
    low: float
    high: float
    measured: float
    error: float
    theory: float


def stress_slope(run: Run, column: str | None = None) -> Slope | None:
    """Return the slope of |σ_q|² at the finest level of a column; the run needs two sound realizations.

    The band goes from the last kink of C(q) to q_c, or to where contact has yielded. None where it is too short to have
    a slope, as in steels that yield below q_roll_off.
    """
    name, scene = run.column(column), run.scene
    level = run.numerics.of_column(name)[-1]
    low, high = scene.spectrum.breaks[-2], run.numerics.levels[level].q_max
    if not scene.elastic:
        high = min(high, prediction.yield_wavenumber(scene))
    bins = int(log(high / low) / WIDTH)
    if bins < LEAST_BINS:
        return None
    # how many modes of the plane lie in each bin of ln q, and their mean ln q
    edges = np.linspace(log(low), log(high), 1 + bins)
    sample, grid = run.samples(name)[-1], run.numerics.grid(level)
    modes = modes_between(grid)
    log_q, many = np.log(modes.wavenumber), modes.multiplicity
    count, sums = (np.histogram(log_q, edges, weights=weights)[0] for weights in (many, many * log_q))
    filled = count > 0.0
    center = sums[filled] / count[filled]
    # least squares of ln|σ_q|² over ln q: the slope is a weighted sum; to first order so is its scatter
    x = center - center.mean()
    weights = x / (x @ x)
    area = count[filled] * 4 * np.pi**2 / (grid.lengths[0] * grid.lengths[1])
    spectra = [np.histogram(np.log(sample.wavenumber), edges, weights=row)[0] for row in sample.spectrum]
    rows = np.stack(spectra)[:, filled] / area
    mean = rows.mean(axis=0)
    error, freedom = spread((rows / mean @ weights)[:, None])
    predicted = np.log(prediction.stress_spectrum(scene, np.exp(center)))
    half_width = float(error[0] * quantile(freedom[0]))
    return Slope(name, low, high, float(weights @ np.log(mean)), half_width, float(weights @ predicted))
