"""Heat in time and depth: how a source starts, series of times, what lies below the surface."""

from math import inf, pi, sqrt

import mpmath as mp
import numpy as np
import pytest
from heat_cases import REFERENCE, STEEL, UNIT, close, points, steady

from roughsim import Grid, sliding_temperature
from roughsim.heat import uniform_temperature


def test_a_source_heats_as_the_square_root_of_time_at_first():
    # T/(2 q̇ √(Dt/π)/κ) = 1 − λ²Dt/3 + …: the error falls as t
    grid = Grid((8, 1), (1.0, 1.0))
    x, _ = points(grid)
    flux = np.cos(2 * pi * x)
    times = np.array([1e-5, 1e-6, 1e-7])
    fields = sliding_temperature(flux, grid, speed=0.0, time=times, **UNIT)
    errors = 1 - fields[:, 0, 0] / (2 * np.sqrt(times / pi))
    assert np.polyfit(np.log(times), np.log(errors), 1)[0] == pytest.approx(1.0, abs=1e-3)
    np.testing.assert_allclose(errors, (2 * pi) ** 2 * times / 3, rtol=1e-3)


def test_a_series_of_times_is_the_same_as_one_by_one():
    grid = Grid((12, 10), (1.0, 1.0))
    flux = np.random.default_rng(7).random(grid.shape)
    times = [0.0, 1e-4, 0.3, inf]
    with pytest.warns(RuntimeWarning, match="exceeds 1"):
        series = sliding_temperature(flux, grid, speed=9.0, time=times, **UNIT)
    assert series.shape == (4, 12, 10)
    assert (series[0] == 0.0).all()
    for time, field in zip(times[1:3], series[1:3], strict=True):
        np.testing.assert_array_equal(
            field, sliding_temperature(flux, grid, speed=9.0, time=time, **UNIT)
        )
    np.testing.assert_array_equal(series[3], steady(flux, grid, speed=9.0, **UNIT))


def test_sliding_distance_is_speed_times_time():
    grid = Grid((12, 10), (1.0, 1.0))
    flux = np.random.default_rng(8).random(grid.shape)
    slid = sliding_temperature(flux, grid, speed=-4.0, slid_distance=0.2, **UNIT)
    close(slid, sliding_temperature(flux, grid, speed=-4.0, time=0.05, **UNIT), 1e-14)
    for speed in (0.0, 4.0):
        assert (
            sliding_temperature(flux, grid, speed=speed, slid_distance=0.0, **UNIT) == 0.0
        ).all()
    assert (sliding_temperature(flux, grid, speed=4.0, time=0.0, depth=0.1, **UNIT) == 0.0).all()


def test_a_mode_forgets_its_start():
    # just beyond D q² t = 40 the steady response takes over, 4e-18 from the transient one
    grid = Grid((4, 1), (2 * pi, 1.0))
    flux = np.cos(points(grid)[0])
    for depth in (0.0, 0.5):
        field = sliding_temperature(flux, grid, speed=0.0, time=[39.9, 40.1], depth=depth, **UNIT)
        np.testing.assert_allclose(field[0], field[1], rtol=0, atol=1e-15)


def test_heat_enters_with_the_prescribed_flux():
    # −κ ∂T/∂z = q̇ at the surface, from rest as well as steady; one-sided difference of second order
    grid = Grid((9, 1), (1.0, 1.0))
    flux = np.cos(2 * pi * points(grid)[0])
    for time in (1e-4, 0.02, 10.0):
        layers = [
            sliding_temperature(flux, grid, speed=0.3, time=time, depth=d, **STEEL)
            for d in (0.0, 1e-6, 2e-6)
        ]
        slope = (-3 * layers[0] + 4 * layers[1] - layers[2]) / 2e-6
        close(-30.0 * slope, flux, 1e-4)


def test_a_transient_at_great_depth_does_not_overflow():
    grid = Grid((64, 64), (1.0, 1.0))
    flux = np.random.default_rng(9).random(grid.shape)
    for depth in (1.0, 100.0, 1e6):
        assert (
            np.abs(sliding_temperature(flux, grid, speed=100.0, depth=depth, **UNIT)).max() < 1e-3
        )


@pytest.mark.parametrize("depth", [0.0, 0.02, 0.2])
def test_the_uniform_term_is_diffusion_into_a_half_space(depth):
    mp.mp.dps = 30
    expected = mp.quad(
        lambda u: 2 / mp.sqrt(mp.pi) * mp.exp(-(mp.mpf(depth) ** 2) / (4 * u**2)),
        [0, 0.01, sqrt(0.003)],
    )
    actual = uniform_temperature(5.0, 0.006, conductivity=2.0, diffusivity=0.5, depth=depth)
    assert actual == pytest.approx(2.5 * float(expected), rel=1e-13)


def test_the_uniform_term_starts_at_zero_and_keeps_the_shape_of_time():
    for depth in (0.0, 1.0):
        assert uniform_temperature(5.0, 0.0, depth=depth, **UNIT) == 0.0
    rise = uniform_temperature(1.0, np.array([0.0, 1.0, 4.0]), **UNIT)
    np.testing.assert_allclose(rise, [0.0, 2 / sqrt(pi), 4 / sqrt(pi)], rtol=1e-15)


@pytest.mark.parametrize(
    "case", REFERENCE["hertz_from_rest"], ids=lambda case: f"Pe {case['peclet']}"
)
def test_a_hertz_contact_from_rest_meets_free_space(case):
    # in a cell that neither heat nor track has crossed, fields plus uniform term are those of free space; the pixel
    # error of the steep edge falls faster than its width
    errors = []
    for pixels in (4, 8, 16):
        grid = Grid((10 * pixels, 8 * pixels), (10.0, 8.0))
        x, y = points(grid)
        flux = np.sqrt(np.maximum(1 - (x - 5.03) ** 2 - (y - 4.01) ** 2, 0.0))
        when = {"speed": float(case["peclet"]), "time": case["fourier_number"]}
        field = sliding_temperature(flux, grid, **when, **UNIT)
        field = field + uniform_temperature(flux.mean(), when["time"], **UNIT)
        errors.append(abs(np.sum(field * flux) / flux.sum() / case["flash_temperature"] - 1))
    assert errors[2] < 2e-3
    assert errors[2] < errors[0] / 4
