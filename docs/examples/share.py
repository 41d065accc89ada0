"""The package `theory` alone: T_flash and heat share of steel over speed; it needs numpy and scipy."""

import numpy as np
from numpy.typing import NDArray

from theory import flash, partition


class Spectrum:
    """C(q), m⁴, self-affine with H = 0.8."""

    breaks = (6.3e3, 2e5)

    def __call__(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return C at wavenumbers q, rad/m."""
        return np.asarray(1e-22 * (q / 6.3e3) ** -3.6)


def temperature(speed: float) -> float:
    """Return T_flash of the moving body, K, at a speed, m/s."""
    whole = flash.flash_temperature(
        speed,
        Spectrum(),
        effective_modulus=1.1e11,
        nominal_pressure=9e7,
        friction_coefficient=0.11,
        conductivity=30.0,
        diffusivity=7.6e-6,
    )
    share = partition.moving_share(
        speed=speed,
        spectrum=Spectrum(),
        effective_modulus=1.1e11,
        nominal_pressure=9e7,
        conductivity=30.0,
        diffusivity=7.6e-6,
    )
    return share * whole


if __name__ == "__main__":
    for each in (0.1, 1.0, 35.0):
        print(f"{each:g} m/s: {temperature(each):.1f} K")
