"""What a temperature field says: distributions, hot spots, profiles, and the conductivity of a hot contact."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from roughsim import Grid, half_space_temperature
from roughsim.heat import (
    contact_temperature,
    depth_profile,
    effective_conductivity,
    hot_spots,
    profiles,
    share_above,
)

GRID = Grid((6, 5), (12.0, 5.0))  # pixels of 2 m²


def spotted(*pixels):
    field = np.zeros(GRID.shape)
    for pixel in pixels:
        field[pixel] = 10.0
    return field


def test_the_heat_weights_the_flash_temperature_and_the_area_the_mean():
    temperature = np.array([[5.0, 1.0, 100.0], [3.0, 7.0, -2.0]])
    flux = np.array([[1.0, 2.0, 0.0], [0.0, 1.0, 0.0]])
    contact = contact_temperature(temperature, flux)
    assert contact.flash_temperature == pytest.approx((5 + 2 + 7) / 4)
    assert contact.mean_temperature == pytest.approx(13 / 3)
    assert contact.max_temperature == 7.0  # not the 100 K beside the contact
    np.testing.assert_array_equal(contact.temperatures, [1.0, 5.0, 7.0])
    np.testing.assert_allclose(contact.cooler, [0.5, 0.75, 1.0])


def test_the_share_above_counts_area_and_adds_the_background():
    temperature, flux = np.array([[5.0, 1.0, 100.0, 7.0]]), np.array([[1.0, 9.0, 0.0, 1.0]])
    assert share_above(temperature, flux, 4.0) == pytest.approx(2 / 3)
    assert share_above(temperature, flux, 306.0, background_temperature=300.0) == pytest.approx(
        1 / 3
    )
    assert share_above(temperature, flux, 7.0) == 0.0  # at the threshold nothing has melted yet


def test_hot_spots_join_over_the_sides_of_a_periodic_cell():
    field = spotted((0, 0), (5, 0), (0, 4), (2, 2), (3, 2), (4, 3))
    joined = hot_spots(field, GRID, 5.0)
    np.testing.assert_allclose(joined.areas, [6.0, 4.0, 2.0])
    assert (joined.count, joined.unresolved) == (3, 3)
    free = hot_spots(field, GRID, 5.0, periodic=False)
    np.testing.assert_allclose(free.areas, [4.0, 2.0, 2.0, 2.0, 2.0])


def test_hot_spots_are_none_one_or_all():
    assert hot_spots(spotted(), GRID, 5.0).count == 0
    whole = hot_spots(spotted() + 9.0, GRID, 5.0)
    assert (whole.count, whole.areas[0], whole.unresolved) == (1, 60.0, 0)


def test_profiles_pass_through_the_hottest_point():
    field = np.arange(30.0).reshape(6, 5)
    field[2, 3] = 99.0
    along, across = profiles(field, GRID)
    np.testing.assert_array_equal(along, field[:, 3])
    np.testing.assert_array_equal(across, field[2])
    np.testing.assert_array_equal(profiles(field, GRID, (1, 0))[0], field[:, 0])


UNIT = {"conductivity": 1.0, "diffusivity": 1.0}


@pytest.fixture(scope="module")
def resting_hertz():
    """(flux, grid, T) of the flux √(1 − r²) at rest on an odd number of pixels: κT = π(2 − r²)/8 inside."""
    grid = Grid((67, 67), (67 / 32, 67 / 32))
    x = (np.arange(67) - 33) / 32
    flux = np.sqrt(np.maximum(1 - x[:, None] ** 2 - x**2, 0.0))
    return flux, grid, half_space_temperature(flux, grid, speed=0.0, **UNIT)


def test_a_resting_hertz_contact_has_its_distribution_of_temperature(resting_hertz):
    # hotter than π(2 − r²)/8 is the disc of radius r: r² of the area, 1 − (1 − r²)^(3/2) of the heat
    flux, grid, field = resting_hertz
    contact = contact_temperature(field, flux)
    assert contact.max_temperature == pytest.approx(math.pi / 4, rel=1e-3)
    # means of π(2 − r²)/8: r² is 1/2 over the area and 2/5 over the heat
    assert contact.mean_temperature == pytest.approx(math.pi / 8 * 1.5, rel=2e-3)
    assert contact.flash_temperature == pytest.approx(math.pi / 8 * 1.6, rel=1e-3)
    assert contact.temperatures.size == (flux > 0).sum()
    for square in (0.2, 0.5, 0.8):
        level = math.pi / 8 * (2 - square)
        cooler = np.interp(level, contact.temperatures, contact.cooler)
        assert cooler == pytest.approx((1 - square) ** 1.5, abs=3e-3)
        assert share_above(field, flux, 300 + level, background_temperature=300.0) == pytest.approx(
            square, abs=6e-3
        )
        spots = hot_spots(field, grid, level, periodic=False)
        assert (spots.count, spots.unresolved) == (1, 0)
        assert spots.areas[0] == pytest.approx(math.pi * square, rel=1e-2)


def test_profiles_of_a_hertz_contact_are_even_at_rest_and_trail_when_it_slides(resting_hertz):
    flux, grid, field = resting_hertz
    x = (np.arange(67) - 33) / 32
    inside = np.abs(x) < 0.95
    for profile in profiles(field, grid):
        np.testing.assert_allclose(profile[inside], math.pi / 8 * (2 - x[inside] ** 2), rtol=2e-3)
    along, across = profiles(half_space_temperature(flux, grid, speed=30.0, **UNIT), grid)
    np.testing.assert_allclose(across, across[::-1], rtol=1e-10)
    assert x[along.argmax()] < -0.3  # the wake is at smaller x
    assert along[x < 0].sum() > 2 * along[x > 0].sum()


def test_below_the_middle_of_a_resting_hertz_contact_the_temperature_is_an_integral(resting_hertz):
    flux, grid, _ = resting_hertz
    depths = [0.0, 0.1, 0.5, 2.0]
    below = depth_profile(
        lambda z: half_space_temperature(flux, grid, speed=0.0, depth=z, **UNIT), depths
    )
    exact = [
        quad(lambda r, z=z: np.sqrt(1 - r * r) * r / np.hypot(r, z), 0, 1, points=[0.1])[0]
        for z in depths
    ]
    np.testing.assert_allclose(below, exact, rtol=1.5e-3)


def test_the_depth_profile_stays_under_the_point_that_is_hottest_at_the_surface(resting_hertz):
    flux, grid, _ = resting_hertz

    def at(depth):
        return half_space_temperature(flux, grid, speed=30.0, depth=depth, **UNIT)

    there = np.unravel_index(at(0.0).argmax(), grid.shape)
    deep = at(0.3)
    assert depth_profile(at, 0.3)[0] == deep[there]
    assert deep.max() > 1.05 * deep[there]  # further back it is hotter down there


def test_spots_of_fewer_than_four_pixels_are_unresolved():
    field = spotted((0, 0), (1, 0), (2, 0), (2, 1), (0, 3), (1, 3), (2, 3), (4, 4))
    spots = hot_spots(field, GRID, 9.99, periodic=False)
    np.testing.assert_allclose(spots.areas, [8.0, 6.0, 2.0])
    assert spots.unresolved == 2
    assert hot_spots(field, GRID, 10.0).count == 0  # at the threshold is not above it


def test_below_a_resting_square_the_temperature_falls_as_a_point_source():
    grid, flux = Grid((5, 5), (1.0, 1.0)), np.zeros((5, 5))
    flux[1:4, 1:4] = 1.0
    body = {"speed": 0.0, "conductivity": 1.0, "diffusivity": 1.0}
    depths = np.array([0.0, 50.0, 100.0])
    below = depth_profile(lambda z: half_space_temperature(flux, grid, depth=z, **body), depths)
    assert below[0] == half_space_temperature(flux, grid, **body).max()
    np.testing.assert_allclose(below[1:], 0.36 / (2 * math.pi * depths[1:]), rtol=1e-4)


def test_a_hot_contact_conducts_as_at_three_quarters_of_its_flash_temperature():
    # κ(T) = 80 − T/10, T_flash = 6000/κ and T₀ = 300: κ = 50 − 450/κ, of which 25 + √175 is the stable root
    value = effective_conductivity(
        lambda t: 80 - t / 10, lambda k: 6000 / k, background_temperature=300.0
    )
    assert value == pytest.approx(25 + math.sqrt(625 - 450), rel=1e-8)
    assert effective_conductivity(lambda t: 30.0, lambda k: 1e9 / k) == 30.0
