"""The times that must not grow from release to release; `make bench` compares them with the last one.

A stage each, small enough for many rounds: CPU time of one thread.
"""

import numpy as np
import pytest

import roughsim as rs
from theory import flash

GRID = rs.Grid((512, 512), (1e-3, 1e-3))
SPECTRUM = rs.SelfAffineSpectrum.from_rms_height(1e-6, hurst=0.8, q_min=6.3e3, q_max=2e5)
LOAD = {"nominal_pressure": 9e7}
STEEL = {"friction_coefficient": 0.11, "conductivity": 30.0, "diffusivity": 7.6e-6}
SPEEDS = np.geomspace(0.01, 100.0, 20)


@pytest.fixture(scope="module")
def heights():
    return rs.synthesize(SPECTRUM, GRID, np.random.default_rng(1))


@pytest.fixture(scope="module")
def contact(heights):
    return rs.solve_contact(heights, GRID, rs.Solid(1.1e11, 1.2e9), **LOAD, tolerance=1e-4)


def test_synthesis(benchmark):
    benchmark(rs.synthesize, SPECTRUM, GRID, np.random.default_rng(1))


@pytest.mark.parametrize("hardness", [np.inf, 1.2e9], ids=["elastic", "capped"])
def test_contact(benchmark, heights, hardness):
    benchmark(rs.solve_contact, heights, GRID, rs.Solid(1.1e11, hardness), **LOAD, tolerance=1e-4)


def test_moments_at_twenty_speeds(benchmark, contact):
    benchmark(rs.measure, contact, GRID, rs.HeatSource(speeds=SPEEDS, **STEEL))


def test_temperature_field(benchmark, contact):
    heat = {"conductivity": 30.0, "diffusivity": 7.6e-6}
    benchmark(rs.sliding_temperature, 3.85 * contact.pressure, GRID, speed=35.0, **heat)


def test_theory_of_a_new_surface(benchmark):
    scales = iter(
        1.0 + 1e-6 * np.arange(10**6)
    )  # a spectrum that was seen before would cost nothing

    def evaluate():
        return flash.flash_temperature(
            SPEEDS,
            SPECTRUM.scaled(next(scales)),
            effective_modulus=1.1e11,
            **LOAD,
            **STEEL,
            gamma=0.294,
        )

    benchmark(evaluate)
