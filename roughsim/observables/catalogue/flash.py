"""Flash temperature, its gradient and Laplacian, and the two lengths made of them. Eqs. (3)–(9), (25), (26)"""

from __future__ import annotations

import numpy as np

from roughsim.observables.record import Number, Observable, power_of_ratio, ratio

NUMBERS = (
    Number(
        "flash_temperature",
        "K",
        "<T sigma>/<sigma>, steady sliding, averaged over directions",
        lambda one: one.observables.flash_temperature,
        per_speed=True,
        heated=True,
    ),
    Number(
        "flash_gradient",
        "K/m",
        "<dT/dx sigma>/<sigma>, along the sliding velocity",
        lambda one: one.observables.flash_gradient,
        per_speed=True,
        heated=True,
    ),
    Number(
        "flash_laplacian",
        "K/m^2",
        "<(d2T/dx2 + d2T/dy2) sigma>/<sigma>",
        lambda one: one.observables.flash_laplacian,
        per_speed=True,
        heated=True,
    ),
)

OBSERVABLES = (
    Observable(
        "flash_temperature",
        "K",
        per_speed=True,
        heated=True,
        theory=lambda theory: theory.over_speed["flash_temperature"],
        at_rest=0.0,
    ),
    Observable(
        "flash_gradient",
        "K/m",
        per_speed=True,
        heated=True,
        theory=lambda theory: theory.over_speed["flash_gradient"],
        at_rest=0.0,
        limit=False,
        pixel_orders=(2.0, 0.8),
    ),
    Observable(
        "flash_laplacian",
        "K/m^2",
        per_speed=True,
        heated=True,
        theory=lambda theory: theory.over_speed["flash_laplacian"],
        at_rest=0.0,
        limit=False,
        pixel_orders=(0.7, 0.7),
    ),
    Observable(
        "flash_width",
        "m",
        per_speed=True,
        values=lambda sample: power_of_ratio(
            sample.numbers["flash_temperature"], -sample.numbers["flash_laplacian"], 0.5
        ),
        theory=lambda theory: theory.over_speed["flash_width"],
        limit=False,
        pixel_orders=(0.7, 0.7),
    ),
    Observable(
        "slope_length",
        "m",
        per_speed=True,
        values=lambda sample: ratio(sample.numbers["flash_temperature"], -sample.numbers["flash_gradient"]),
        theory=lambda theory: theory.over_speed["slope_length"],
        at_rest=np.inf,
        limit=False,
    ),
)
