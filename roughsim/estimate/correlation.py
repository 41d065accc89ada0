"""g_σ(r) of a column: that of its coarsest level in the run's cell, changed as finer levels change it."""

import numpy as np

from roughsim.estimate.errors import spread
from roughsim.estimate.ladder import climb, group_of, ties_of
from roughsim.grid import Array
from roughsim.observables.record import Sample
from roughsim.observables.special import j0


def correlation_of(samples: list[Sample], distance: Array) -> tuple[Array, Array, Array]:
    """Return g_σ(r) at the highest cut-off of a column, Pa², its standard error, and that one's degrees of freedom.

    `samples` are those of the column, coarsest first; `distance` is r, m, one-dimensional. Levels in a part of the cell
    tell changes as far as half its diagonal: up to there the short waves that they add have lost their correlation.
    """

    def of_level(sample: Sample) -> Array:
        values = sample.spectrum @ j0(np.multiply.outer(sample.wavenumber, distance))
        return np.where(distance <= sample.reach, values, 0.0) if sample.part else values

    ladder = climb(of_level, samples, np.zeros(distance.shape, dtype=np.bool_))
    coarsest, top = ladder[0].rows, ladder[-1]
    finest = top.rows if top.partner is None else top.partner
    mean = finest.mean(axis=0)
    base = mean + (coarsest - coarsest.mean(axis=0))
    independent, slopes = ties_of(samples)
    return mean, *spread(finest, base, group_of(samples), independent=independent, slopes=slopes)
