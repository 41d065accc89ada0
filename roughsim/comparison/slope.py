"""Slope of the stress spectrum of a run, beside the slope of the theory."""

from math import log
from typing import NamedTuple

import numpy as np

from roughsim import prediction
from roughsim.estimate.errors import quantile, spread
from roughsim.grid import modes_between
from roughsim.results.run import Run

_BIN_WIDTH = 0.12  # of the stress spectrum, in ln q
_LEAST_BINS = 12  # for a slope


class Slope(NamedTuple):
    """d ln|σ_q|²/d ln q of a column from `low` to `high`, rad/m; `error` is statistical, 95 %."""

    column: str
    low: float
    high: float
    measured: float
    error: float
    theory: float


def stress_slope(run: Run, column: str | None = None) -> Slope | None:
    """Return the slope of |σ_q|² at the finest level of a column; that level needs two sound members.

    With C ∝ q^(−2−2H) full contact has |σ_q|² ∝ q^(−2H). Loss of contact gives P ∝ 1/√G ∝ q^(H−1), so that the slope of
    the theory tends to −(1 + H) in a long band. The error does not include the effect of a finite pixel.

    The band extends from the last kink of C(q) to q_c, or to the yield wavenumber. None if the band is too short for a
    slope, as in steels that yield below q_roll_off.
    """
    name, scene = run.column(column), run.scene
    sample = run.samples(name)[-1]
    low, high = scene.spectrum.breaks[-2], sample.q_max
    if not scene.elastic:
        high = min(high, prediction.yield_wavenumber(scene))
    bins = int(log(high / low) / _BIN_WIDTH)
    if bins < _LEAST_BINS:
        return None
    # number of modes of the plane in each bin of ln q, and their mean ln q
    band = log(low), log(high)
    grid = run.grid(sample.level)
    modes = modes_between(grid)
    log_q, many = np.log(modes.wavenumber), modes.multiplicity
    count, sums = (
        np.histogram(log_q, bins, band, weights=weights)[0] for weights in (many, many * log_q)
    )
    filled = count > 0.0
    center = sums[filled] / count[filled]
    # least squares of ln|σ_q|² over ln q: the slope is a weighted sum; to first order so is its scatter
    x = center - center.mean()
    weights = x / (x @ x)
    area = count[filled] * 4 * np.pi**2 / (grid.lengths[0] * grid.lengths[1])
    entries = np.log(sample.wavenumber)
    spectra = [np.histogram(entries, bins, band, weights=row)[0] for row in sample.spectrum]
    rows = np.stack(spectra)[:, filled] / area
    mean = rows.mean(axis=0)
    error, freedom = spread((rows / mean @ weights)[:, None])
    predicted = np.log(prediction.stress_spectrum(scene, np.exp(center)))
    half_width = float(error[0] * quantile(freedom[0]))
    return Slope(
        name, low, high, float(weights @ np.log(mean)), half_width, float(weights @ predicted)
    )
