"""The share of the heat that the moving body takes up."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from roughsim.observables.record import Number, Observable, Sample

Array = NDArray[np.float64]


def _share(sample: Sample) -> Array:
    """Influence values of ⟨T_stat⟩/(⟨T_stat⟩ + ⟨T_mov⟩) of a level that `prediction.balanced` has prepared."""
    resting, moving = sample.numbers["resting_flash_temperature"], sample.numbers["flash_temperature"]
    still, slid = resting.mean(axis=0), moving.mean(axis=0)
    whole = still + slid
    change: Array = still / whole + (slid * (resting - still) - still * (moving - slid)) / whole**2
    return change


NUMBERS = (
    Number(
        "resting_flash_temperature",
        "K",
        "<T sigma>/<sigma> of the same heat in a body that does not move under it",
        lambda one: one.observables.resting_flash_temperature,
        per_speed=True,
        heated=True,
    ),
)

OBSERVABLES = (
    Observable(
        "heat_partition",
        "1",
        per_speed=True,
        values=_share,
        spectra=True,  # the balance of the two bodies after a time of sliding
        theory=lambda theory: theory.heat_partition,
    ),
)
