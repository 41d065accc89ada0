"""A length over which the pressure varies: the mean of 1/q, weighted by the pressure variance."""

import numpy as np
from numpy.typing import NDArray

from roughsim.observables.record import Measured, Observable, Sample, ratio


def moment(measured: Measured) -> float:
    """Return Σ |σ(q)|²/q of one contact, Pa² m."""
    spectrum = measured.observables.stress_spectrum
    return float(spectrum.variance @ (1.0 / spectrum.wavenumber))


def length(sample: Sample) -> NDArray[np.float64]:
    """Return influence values of ⟨Σ |σ(q)|²/q⟩/⟨Σ |σ(q)|²⟩, m."""
    return ratio(sample.numbers["pressure_variance_over_q"], sample.numbers["pressure_variance"])


OBSERVABLES = (
    Observable(
        "pressure_variance_over_q",
        "Pa^2 m",
        stored="sum of |sigma(q)|^2/q",
        measure=moment,
        only_stored=True,
    ),
    Observable(
        "stress_length",
        "m",
        values=length,
        theory=lambda theory: theory.total(lambda q: 1.0 / q) / theory.total(lambda q: q**0),
    ),
)
