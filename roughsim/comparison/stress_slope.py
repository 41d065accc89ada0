"""The slope of the stress spectrum |σ_q|² inside the self-affine band, measured and in the theory.

With C ∝ q^(−2−2H) full contact has |σ_q|² ∝ q^(−2H). Where contact is lost P ∝ 1/√G ∝ q^(H−1), so that the theory's
slope tends to −(1 + H) in a long band. Slopes are of least squares in ln q, all of the band with the same weight; what
a finite pixel changes of them is not in their error.
"""

from __future__ import annotations

from math import log
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughsim import prediction
from roughsim.estimate.errors import quantile, spread
from roughsim.surface.radial import modes_between

if TYPE_CHECKING:
    from roughsim.grid import Grid
    from roughsim.results.run import Run
    from roughsim.scene import Scene

Array = NDArray[np.float64]
_WIDTH, _LEAST = 0.12, 12  # of a bin in ln q; bins that make a band


class Slope(NamedTuple):
    """d ln|σ_q|²/d ln q of a column from `low` to `high`, rad/m; `error` is statistical, 95 %."""

    column: str
    low: float
    high: float
    measured: float
    error: float
    theory: float


def stress_slope(run: Run, column: str | None = None) -> Slope | None:
    """Return the slope of |σ_q|² between q_roll_off and the lower of q_c and q_y, at the finest level of a column.

    Parameters
    ----------
    run : Run
        With at least two sound realizations.
    column : str, optional
        As for `Run.estimate`.

    Returns
    -------
    Slope or None
        None where the band is too short to have a slope, as in steels that yield below q_roll_off.
    """
    name = run.column(column)
    level = run.numerics.of_column(name)[-1]
    low, high = _band(run.scene, run.numerics.levels[level].q_max)
    bins = int(log(high / low) / _WIDTH)
    if bins < _LEAST:
        return None
    edges = np.linspace(log(low), log(high), 1 + bins)
    sample, grid = run.samples(name)[-1], run.numerics.grid(level)
    count, place = _modes(grid, edges)
    there = count > 0.0
    x = place[there] - place[there].mean()
    area = count[there] * 4 * np.pi**2 / (grid.lengths[0] * grid.lengths[1])
    rows = _sums(np.log(sample.wavenumber), edges, sample.spectrum)[:, there] / area
    mean, weights = rows.mean(axis=0), x / (x @ x)
    error, freedom = spread((rows / mean @ weights)[:, None])
    predicted = np.log(prediction.stress_spectrum(run.scene, np.exp(place[there])))
    half = float(error[0] * quantile(freedom[0]))
    return Slope(name, low, high, float(weights @ np.log(mean)), half, float(weights @ predicted))


def _band(scene: Scene, q_c: float) -> tuple[float, float]:
    """Where the band begins and ends, rad/m: from the last kink of C(q) to q_c or to where contact has yielded."""
    return scene.spectrum.breaks[-2], q_c if scene.elastic else min(q_c, prediction.yield_wavenumber(scene))


def _modes(grid: Grid, edges: Array) -> tuple[Array, Array]:
    """How many modes of the plane lie in each bin of ln q, and their mean ln q; NaN where there are none."""
    modes = modes_between(grid)
    place = np.log(modes.wavenumber)
    count, sums = (
        np.histogram(place, edges, weights=weights)[0] for weights in (modes.multiplicity, modes.multiplicity * place)
    )
    return count, np.divide(sums, count, out=np.full(count.shape, np.nan), where=count > 0.0)


def _sums(place: Array, edges: Array, spectra: Array) -> Array:
    """Sums of spectra (n, m) over the entries in each bin, (n, bins)."""
    return np.stack([np.histogram(place, edges, weights=row)[0] for row in spectra])


__all__ = ["Slope", "stress_slope"]
