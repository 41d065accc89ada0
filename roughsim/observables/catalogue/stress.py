"""The variance of the pressure and the distances over which it is correlated. Eqs. (1), (2)"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from roughsim.observables.record import Number, Observable, Sample

Array = NDArray[np.float64]
RADII = {"correlation_radius_50": 0.5, "correlation_radius_10": 0.1, "correlation_radius_0": 0.0}


def _radius(sample: Sample, fraction: float) -> Array:
    """Influence values of the smallest r with g(r) = fraction·g(0) of the mean spectrum; NaN if there is none."""
    from scipy.special import j0, j1  # here: who only asks for names need not wait for it

    from roughsim.observables.moments import StressSpectrum

    q, mean = sample.wavenumber, sample.spectrum.mean(axis=0)
    r = StressSpectrum(q, mean, sample.reach).correlation_radius(fraction)
    if not np.isfinite(r):
        return np.full((len(sample.spectrum), 1), np.nan)
    slope = -float((mean * q) @ j1(q * r))
    excess = sample.spectrum @ (j0(q * r) - fraction)
    return (r - excess / slope)[:, None]


def _observable(name: str, fraction: float) -> Observable:
    return Observable(
        name,
        "m",
        values=lambda sample: _radius(sample, fraction),
        spectra=True,
        theory=lambda theory: theory.correlation_radius(fraction),
        distance=True,
        pixel_orders=(2.0, np.nan),  # 4, 8, 16, 32 pixels per wave: up by 2 %, then back
    )


NUMBERS = (Number("pressure_variance", "Pa^2", "<sigma^2> - sigma0^2", lambda one: one.observables.pressure_variance),)

OBSERVABLES = (
    Observable(
        "pressure_variance",
        "Pa^2",
        theory=lambda theory: theory.total(np.ones_like),
        pixel_orders=(2.0, 1.0),
        by_force_balance=True,
    ),
    *(_observable(name, fraction) for name, fraction in RADII.items()),
)
