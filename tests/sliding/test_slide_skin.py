"""Two sliding bodies with skins, or heated in depth: mode sums of full contact, symmetries, and limits."""

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest
from mode_sum_cases import CELL, LOAD, E, mode_sum, response, waves

from roughsim import Body, Grid, Skin, Solid, slide

BARE = Body(30.0, 7.6e-6)
OXIDE = Body(30.0, 7.6e-6, skin=Skin(1e-5, 3.0, 0.9e-6))
SILVER = Body(30.0, 7.6e-6, skin=Skin(2e-5, 300.0, 1e-4))
DEEP = Body(30.0, 7.6e-6, heat_depth=2e-5)
BOTH = Body(30.0, 7.6e-6, skin=Skin(1e-5, 3.0, 0.9e-6), heat_depth=1.5e-5)
NUMBERS = (
    "flash_temperature",
    "resting_flash_temperature",
    "moving_share",
    "background",
    "contact_temperature",
)


def slid(first, second, moving, resting, speed=1.0, distance=CELL / 2, load=1e6, **kwargs):
    grid = Grid(first.shape, (CELL, CELL))
    numbers = {
        "nominal_pressure": load,
        "friction_coefficient": 0.3,
        "speed": speed,
        "slid_distance": distance,
    }
    moving = replace(moving, speed=speed)
    return slide(
        first,
        grid,
        Solid(E),
        moving=moving,
        resting=resting,
        counter_heights=second,
        **numbers,
        **kwargs,
    )


@pytest.mark.parametrize(
    ("moving", "resting"),
    [
        pytest.param(OXIDE, OXIDE, id="oxides", marks=pytest.mark.slow),
        pytest.param(BARE, SILVER, id="silver", marks=pytest.mark.slow),
        pytest.param(DEEP, BARE, id="deep", marks=pytest.mark.slow),
        pytest.param(BOTH, DEEP, id="both"),
    ],
)
def test_full_contact_is_the_mode_sum_of_each_wave_in_its_own_body(moving, resting):
    first, second = sqrt(0.7) * waves(64, 1), sqrt(0.3) * waves(64, 2)
    got = slid(first, second, moving, resting, distance=5 * CELL, load=LOAD)
    steady = got.slid_distance > 4 * CELL
    grid = Grid(first.shape, (CELL, CELL))
    expected = mode_sum(grid, first, second, got.slid_distance[steady], 1.0, moving, resting).mean()
    bare = mode_sum(grid, first, second, got.slid_distance[steady], 1.0, BARE, BARE).mean()
    assert abs(expected / bare - 1) > 0.04
    assert got.flash_temperature[steady].mean() == pytest.approx(expected, rel=0.01)
    assert got.resting_flash_temperature[steady].mean() == pytest.approx(expected, rel=0.01)


def rough(count, seed):
    """Rough enough for partial contact."""
    return waves(count, seed, rms=3e-6)


def test_a_skin_of_the_same_material_is_no_skin():
    same = replace(BARE, skin=Skin(1e-5, BARE.conductivity, BARE.diffusivity))
    bare, layered = (slid(rough(32, 1), rough(32, 2), body, body) for body in (BARE, same))
    for name in NUMBERS:
        assert getattr(layered, name) == pytest.approx(getattr(bare, name), rel=1e-4), name
    assert layered.frozen_flash_temperature == pytest.approx(
        bare.frozen_flash_temperature, rel=1e-9
    )


@pytest.mark.parametrize(
    "thin", [replace(OXIDE, skin=(1e-10, 3.0, 0.9e-6)), replace(SILVER, skin=(1e-11, 300.0, 1e-4))]
)
def test_a_skin_without_thickness_is_no_skin(thin):
    bare, layered = (slid(rough(32, 1), rough(32, 2), body, BARE) for body in (BARE, thin))
    for name in NUMBERS:
        assert getattr(layered, name) == pytest.approx(getattr(bare, name), rel=3e-4), name


def test_twins_with_equal_skins_share_alike():
    face = rough(32, 1)
    got = slid(face, face[::-1, ::-1], BOTH, BOTH, distance=4 * CELL)
    # which body a spot belongs to is chance at one position; over the way both are alike
    assert got.moving_share[16:].mean() == pytest.approx(0.5, abs=0.01)
    assert got.background[-1] == pytest.approx(got.resting_background[-1], rel=0.02)
    assert (got.residual <= 1e-5).all()
    total = got.resting_flash_temperature + got.resting_background
    assert got.contact_temperature == pytest.approx(total, rel=1e-4)


def test_exchanging_the_bodies_mirrors():
    first, second = waves(32, 1), waves(32, 2)
    one = slid(first, second, BOTH, SILVER, speed=5.0, load=LOAD)
    other = slid(second, first, SILVER, BOTH, speed=-5.0, load=LOAD)
    assert other.moving_share == pytest.approx(1 - one.moving_share, rel=5e-5)
    assert other.resting_flash_temperature == pytest.approx(one.flash_temperature, rel=5e-5)
    assert other.resting_background == pytest.approx(one.background, rel=5e-5)
    assert other.contact_temperature == pytest.approx(one.contact_temperature, rel=5e-5)


def test_all_heat_enters_the_body_whose_skin_conducts():
    insulated = replace(BARE, skin=Skin(1e-4, 1e-6, 0.9e-6))
    assert slid(rough(32, 1), rough(32, 2), BARE, insulated).moving_share[-1] > 0.9999
    assert slid(rough(32, 1), rough(32, 2), insulated, BARE).moving_share[-1] < 0.0001


def test_the_frozen_temperature_has_the_skin_of_the_moving_body():
    # full contact of one wave along the way: the steady response of the moving body alone
    x = np.cos(2 * pi * np.arange(32) / 32)[:, None] * 1e-6 * np.ones(32)
    got = slid(x, None, OXIDE, BARE, load=LOAD)
    q = 2 * pi / CELL
    angles = np.cos((np.arange(2000) + 0.5) * pi / 2000)
    mean = response(
        OXIDE, np.full(2000, q * q), q * angles
    ).real.mean()  # over the directions of sliding
    assert got.frozen_flash_temperature[-1] == pytest.approx(
        0.3 * (E * q * 1e-6 / 2) ** 2 / 2 / LOAD * mean, rel=1e-6
    )
