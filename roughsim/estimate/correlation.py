"""g_σ(r) of a column: of its lowest level, plus the changes by the levels above."""

import numpy as np
import scipy

from roughsim.estimate.errors import spread_of
from roughsim.estimate.mean import mean_of
from roughsim.estimate.regression import at_mean_peak_volume
from roughsim.estimate.telescoping import Pair
from roughsim.grid import Array
from roughsim.observables.record import Sample


def correlation_of(pairs: list[Pair], distance: Array) -> tuple[Array, Array, Array]:
    """Return g_σ(r) at the highest cut-off of a column, Pa², its standard error, and the degrees of freedom.

    `distance` is r, m, one-dimensional. Steps add. Levels in a part of the cell change it up to half the
    diagonal of their cell: the short waves that they add have lost their correlation there.
    """

    def of_level(sample: Sample) -> Array:
        values = sample.spectrum @ scipy.special.j0(np.multiply.outer(sample.wavenumber, distance))
        return np.where(distance <= sample.reach, values, 0.0) if sample.part else values

    lowest, *others = pairs
    of_peaks = at_mean_peak_volume(of_level(lowest.sample), lowest.sample.numbers)
    total = mean_of(lowest.stream, of_peaks)
    top = max(pair.sample.q_max for pair in pairs)
    for pair in others:
        if pair.below is not None and (not pair.is_refined or pair.sample.q_max == top):
            rows = of_level(pair.sample) - of_level(pair.below)
            total += mean_of(pair.stream, rows)
    return total.value, *spread_of(total)
