"""T_flash of one contact in one direction of sliding, by the field of temperature itself."""

from dataclasses import asdict

import numpy as np

from roughsim.grid import Array, Grid
from roughsim.heat.periodic import sliding_temperature
from roughsim.observables.moments import HeatSource


def flash_temperature_along(
    pressure: Array,
    grid: Grid,
    sliding: HeatSource,
    direction: float,
    slid_distance: float | None = None,
) -> Array:
    """Return ⟨Tσ⟩/⟨σ⟩ in one direction of sliding, K, at each speed, without q = 0.

    The temperature follows `sliding_temperature` from rest: the steady moments of one direction have every spot in its
    own hot track, for ever, and above v L/(2πD) = 1 they are too high. With the sides four and more longest waves, the
    mean over directions is within 2 % of `measure`.

    Parameters
    ----------
    pressure : ndarray
        Shape `grid.shape`, Pa, periodic.
    grid : Grid
        Its cell.
    sliding : HeatSource
        Speeds, friction, and the body; its own direction is not read.
    direction : float
        Radians from axis 0 towards axis 1.
    slid_distance : float, optional
        Distance slid since the start from rest, m. Default: half the chord of the cell along `direction`.
    """
    frictions = np.broadcast_to(sliding.friction_coefficient, len(sliding.speeds)).tolist()
    mean = float(pressure.mean())
    found = []
    for body, friction in zip(sliding.bodies, frictions, strict=True):
        temperature = sliding_temperature(
            sliding.heat_partition * friction * abs(body.speed) * pressure,
            grid,
            direction=direction,
            slid_distance=slid_distance,
            **asdict(body),
        )
        found.append(float(np.mean(temperature * pressure)) / mean)
    return np.array(found)
