"""Mirrors, turns, units and the sense of sliding in the periodic heat solver."""

from math import inf, pi

import numpy as np
import pytest
from heat_cases import STEEL, UNIT, close, points, steady

from roughsim import Grid, sliding_temperature


def mirrored(field):
    return np.roll(field[::-1], 1, axis=0)


@pytest.mark.parametrize("shape", [(16, 16), (15, 18)])
@pytest.mark.parametrize("direction", [0.0, pi])
def test_the_mirror_image_of_the_source_slides_the_other_way(shape, direction):
    grid = Grid(shape, (1.0, 1.3))
    flux = np.random.default_rng(2).random(shape)
    forth = sliding_temperature(flux, grid, speed=20.0, direction=direction, **UNIT)
    back = sliding_temperature(mirrored(flux), grid, speed=-20.0, direction=direction, **UNIT)
    close(back, mirrored(forth), 1e-13)


@pytest.mark.parametrize("speed", [20.0, 1e12])
def test_turning_everything_by_a_right_angle_turns_the_field(speed):
    flux = np.random.default_rng(3).random((14, 9))
    along = steady(flux, Grid((14, 9), (1.0, 1.3)), speed=speed, **UNIT)
    across = steady(flux.T, Grid((9, 14), (1.3, 1.0)), speed=speed, direction=pi / 2, **UNIT)
    close(across.T, along, 1e-13)
    backwards = steady(flux.T, Grid((9, 14), (1.3, 1.0)), speed=-speed, direction=-pi / 2, **UNIT)
    close(backwards.T, along, 1e-13)


@pytest.mark.parametrize("direction", [0.0, 0.4, pi / 2, 2.5])
def test_a_negative_speed_is_the_opposite_direction(direction):
    grid = Grid((80, 70), (1.0, 1.3))
    flux = np.random.default_rng(4).random(grid.shape)
    forth = sliding_temperature(flux, grid, speed=-30.0, direction=direction, **UNIT)
    close(
        forth, sliding_temperature(flux, grid, speed=30.0, direction=direction + pi, **UNIT), 1e-13
    )


@pytest.mark.parametrize("direction", [0.0, pi / 2, 2.0])
def test_each_row_of_a_large_grid_has_its_own_response(direction):
    # more rows than one block: against a plain transform of the whole plane, Nyquist waves filtered out
    grid = Grid((150, 141), (1.0, 1.3))
    flux = np.random.default_rng(5).random(grid.shape)
    qx, qy = (2 * pi * np.fft.fftfreq(n, d) for n, d in zip(grid.shape, grid.spacing, strict=True))
    qx, qy = np.meshgrid(qx, qy, indexing="ij")
    source = np.fft.fft2(flux)
    source[75] = 0.0
    decay = np.sqrt(qx**2 + qy**2 - 1j * 40.0 * (qx * np.cos(direction) + qy * np.sin(direction)))
    decay[0, 0] = inf
    expected = np.fft.ifft2(source / decay).real
    actual = steady(np.fft.ifft2(source).real, grid, speed=40.0, direction=direction, **UNIT)
    close(actual, expected, 1e-13)


def test_steel_in_si_units_is_the_unit_problem_scaled():
    flux = np.random.default_rng(6).random((24, 24))
    unit = sliding_temperature(flux, Grid((24, 24), (1.0, 1.0)), speed=35.0 * 1e-6 / 7.6e-6, **UNIT)
    steel = sliding_temperature(2e9 * flux, Grid((24, 24), (1e-6, 1e-6)), speed=35.0, **STEEL)
    close(steel, unit * 2e9 * 1e-6 / 30.0, 1e-13)


@pytest.mark.parametrize("speed", [50.0, 500.0])
def test_the_hot_spot_trails_the_source(speed):
    grid = Grid((128, 64), (1.0, 0.5))
    x, y = points(grid)
    flux = np.exp(-((x - 0.5) ** 2 + (y - 0.25) ** 2) / 0.05**2)
    field = sliding_temperature(flux, grid, speed=speed, **UNIT)
    hottest = x[np.unravel_index(field.argmax(), field.shape)]
    assert hottest < 0.5
    assert np.sum(np.gradient(field, axis=0) * flux) < 0.0
