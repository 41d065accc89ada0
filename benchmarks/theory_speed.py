"""Times of the theory package: python benchmarks/theory_speed.py

Goals: one T_flash at one speed in at most 1 ms warm; T, T' and the Laplacian at 200 speeds over eight decades in at
most 20 ms, on one core, and so T_flash there by the law for contact that yields. "New surface" is what it costs when
nothing is remembered of the stress spectrum.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

import roughsim as rs
from theory import flash, hertz, partition, plasticity

LOAD = {"effective_modulus": 2e11 / 0.91 / 2, "nominal_pressure": 9e7}
STEEL = {
    **LOAD,
    "friction_coefficient": 0.11,
    "conductivity": 30.0,
    "diffusivity": 30 / 3.95e6,
    "gamma": 0.294,
}


def best(function: Callable[[], Any], repeats: int = 20) -> float:
    """Return the shortest of several times, s."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return min(times)


def surface(height: float = 9e-7) -> rs.SelfAffineSpectrum:
    return rs.SelfAffineSpectrum.from_rms_height(
        height, hurst=0.8, q_min=6350.0, q_roll_off=9.4e4, q_max=4.15e7, roll_off_exponent=1.5
    ).scaled(2.0)


def main() -> None:
    elastic = surface()
    smooth = plasticity.smoothed_spectrum(elastic, penetration_hardness=1.2e9, **LOAD)
    decades = rs.SelfAffineSpectrum.from_rms_height(
        2e-4, hurst=0.8, q_min=1e2, q_roll_off=1e2, q_max=1e10
    )
    speeds = np.geomspace(1e-4, 1e4, 200)
    heights = iter(np.linspace(8e-7, 9e-7, 1000))
    body = {"conductivity": 30.0, "diffusivity": 30 / 3.95e6, "gamma": 0.294}

    def curve(spectrum: Any) -> None:
        for quantity in (flash.flash_temperature, flash.flash_gradient, flash.flash_laplacian):
            quantity(speeds, spectrum, **STEEL)

    def yielding(spectrum: Any) -> None:
        stress = plasticity.stress_spectrum(spectrum, penetration_hardness=1.2e9, **LOAD)
        flash.flash_temperature(speeds, stress_spectrum=stress, **heat)

    heat = {
        name: value for name, value in STEEL.items() if name not in ("effective_modulus", "gamma")
    }
    law = plasticity.stress_spectrum(elastic, penetration_hardness=1.2e9, **LOAD)

    rows: dict[str, Callable[[], Any]] = {
        "T_flash, one speed, warm": lambda: flash.flash_temperature(35.0, elastic, **STEEL),
        "T_flash, one speed, smoothed, warm": lambda: flash.flash_temperature(
            35.0, smooth, **STEEL
        ),
        "T_flash, one speed, eight decades, warm": lambda: flash.flash_temperature(
            35.0, decades, **STEEL
        ),
        "T_flash, one speed, new surface": lambda: flash.flash_temperature(
            35.0, surface(next(heights)), **STEEL
        ),
        "T, T', Laplacian at 200 speeds": lambda: curve(elastic),
        "T, T', Laplacian at 200 speeds, smoothed": lambda: curve(smooth),
        "heat share, one speed": lambda: partition.moving_share(35.0, smooth, **LOAD, **body),
        "smoothed spectrum": lambda: plasticity.smoothed_spectrum(
            elastic, penetration_hardness=1.2e9, **LOAD
        ),
        "law for yielding contact, 200 speeds, warm": lambda: flash.flash_temperature(
            speeds, stress_spectrum=law, **heat
        ),
        "the same, new surface": lambda: yielding(surface(next(heights))),
        "Hertz T_flash at 200 speeds": lambda: hertz.flash_temperature(speeds),
        "Hertz T_max at one speed": lambda: hertz.max_temperature(10.0),
    }
    for name, function in rows.items():
        function()
        print(f"{name:42}{best(function) * 1e3:9.3f} ms")


if __name__ == "__main__":
    main()
