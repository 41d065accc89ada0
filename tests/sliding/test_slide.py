"""Two bodies that slide: exact mode sums of full contact, symmetries, limits, equal temperatures, and refusals."""

from dataclasses import replace
from math import hypot, pi, sqrt

import numpy as np
import pytest
from mode_sum_cases import CELL, LOAD, E, mode_sum, waves

from roughsim import Body, Grid, Solid, partition_heat, slide
from roughsim.sliding.path import ACROSS, oblique_path

STEEL, COPPER = Body(30.0, 7.6e-6), Body(300.0, 1e-4)


def full(first, second, distance, speed=5.0, moving=STEEL, resting=STEEL, **kwargs):
    """Slide in full contact, where the stress is known mode by mode."""
    grid = Grid(first.shape, (CELL, CELL))
    return grid, slide(
        first,
        grid,
        Solid(E),
        nominal_pressure=LOAD,
        friction_coefficient=0.3,
        speed=speed,
        moving=replace(moving, speed=speed),
        resting=resting,
        counter_heights=second,
        slid_distance=distance,
        **kwargs,
    )


@pytest.mark.parametrize(
    ("part", "moving"),
    [
        (0.3, COPPER),
        *(
            pytest.param(*case, marks=pytest.mark.slow)
            for case in ((0.0, STEEL), (0.0, COPPER), (0.3, STEEL), (1.0, STEEL), (1.0, COPPER))
        ),
    ],
)
def test_full_contact_is_the_mode_sum_of_each_wave_in_its_own_body(part, moving):
    # the longest wave takes L²/(4π²D) = 3.3 ms to warm the body that carries it: 4 cells take .8 ms at 5 m/s
    first, second = sqrt(1 - part) * waves(48, 1), sqrt(part) * waves(48, 2)
    grid, slid = full(first, second, 5 * CELL, speed=1.0, moving=moving)
    steady = slid.slid_distance > 4 * CELL
    expected = mode_sum(grid, first, second, slid.slid_distance[steady], 1.0, moving, STEEL)
    assert slid.flash_temperature[steady].mean() == pytest.approx(expected.mean(), rel=0.01)
    assert slid.resting_flash_temperature[steady].mean() == pytest.approx(expected.mean(), rel=0.01)


def test_the_error_of_the_step_falls_at_second_order():
    # a wave along x alone, so that no position is rounded: 1, 2 and 4 pixels a step of the same grid
    x = np.cos(2 * pi * 3 * np.arange(96) / 96)[:, None] * 1e-6
    distance = 48 * CELL / 96 * hypot(1, ACROSS)
    ends = [full(x, None, distance, steps=steps)[1].flash_temperature[-1] for steps in (48, 24, 12)]
    fine = np.cos(2 * pi * 3 * np.arange(384) / 384)[:, None] * 1e-6
    finest = full(fine, None, distance)[1].flash_temperature[-1]
    errors = np.array(ends) / finest - 1
    assert abs(errors[0]) < 3e-3
    assert errors[1:] / errors[:-1] == pytest.approx([4, 4], rel=0.25)


def test_exchanging_the_bodies_mirrors():
    first, second = waves(32, 1), waves(32, 2)
    one = full(first, second, CELL, moving=COPPER)[1]
    other = full(second, first, CELL, speed=-5.0, resting=COPPER)[1]
    assert other.moving_share == pytest.approx(1 - one.moving_share, rel=1e-6)
    assert other.resting_flash_temperature == pytest.approx(one.flash_temperature, rel=1e-6)
    assert other.resting_background == pytest.approx(one.background, rel=1e-6)
    assert other.contact_temperature == pytest.approx(one.contact_temperature, rel=1e-6)
    turned = full(first[::-1, ::-1], second[::-1, ::-1], CELL, speed=-5.0, moving=COPPER)[1]
    assert turned.flash_temperature == pytest.approx(one.flash_temperature, rel=1e-6)


def bumps(count, seed):
    """Rough enough for partial contact."""
    return waves(count, seed, rms=3e-6)


def partial(first, second, speed, distance=CELL / 2, moving=STEEL, resting=STEEL, **kwargs):
    grid = Grid(first.shape, (CELL, CELL))
    several = np.ndim(speed) > 0
    return slide(
        first,
        grid,
        kwargs.pop("solid", Solid(E)),
        nominal_pressure=1e6,
        friction_coefficient=0.3,
        speed=speed,
        moving=moving if several else replace(moving, speed=speed),
        resting=resting,
        counter_heights=second,
        slid_distance=distance,
        **kwargs,
    )


def test_the_temperatures_of_both_bodies_agree_and_all_heat_goes_into_them():
    slid = partial(bumps(64, 1), bumps(64, 2), 5.0, moving=COPPER)
    assert (slid.residual <= 1e-5).all()
    assert (slid.contact_fraction < 0.6).all()
    both = (
        slid.flash_temperature + slid.background,
        slid.resting_flash_temperature + slid.resting_background,
    )
    assert both[0] == pytest.approx(both[1], rel=1e-4)
    assert slid.contact_temperature == pytest.approx(both[0], rel=1e-12)
    # the backgrounds follow from the shares alone: heat flows one way in the mean
    step = slid.slid_distance[0] / 5.0
    effusivity = [body.conductivity / sqrt(body.diffusivity) for body in (COPPER, STEEL)]
    start = effusivity[0] / sum(effusivity)
    share = np.concatenate([[start], slid.moving_share])
    n = share.size - 1
    times = (np.arange(200 * n) + 0.5) / 200
    kernel = 2 * (np.sqrt(n - times + 0.5 / 200) - np.sqrt(n - times - 0.5 / 200))
    for part, rise, e in (
        (share, slid.background, effusivity[0]),
        (1 - share, slid.resting_background, effusivity[1]),
    ):
        flux = 0.3 * 5.0 * 1e6 * np.interp(times, np.arange(n + 1), part)
        assert rise[-1] == pytest.approx((kernel @ flux) * sqrt(step / pi) / e, rel=1e-5)


def test_equal_bodies_at_rest_against_one_another_share_by_conductivity():
    slow = partial(bumps(48, 1), None, 1e-4, resting=Body(10.0, 7.6e-6))
    assert slow.moving_share[-1] == pytest.approx(0.75, rel=1e-3)


def test_speeds_in_one_slide_are_the_same_as_alone():
    first, second = bumps(32, 1), bumps(32, 2)
    both = partial(first, second, [5.0, 0.5])
    for k, speed in enumerate((5.0, 0.5)):
        alone = partial(first, second, speed)
        assert (both.flash_temperature[k] == alone.flash_temperature).all()
        assert (both.moving_share[k] == alone.moving_share).all()


def test_over_a_flat_the_answer_is_that_of_the_frozen_contact():
    # one contact spot far from its images; the resting body is steady after many R²/D
    count, radius = 64, 8.0
    x = np.arange(count) - count / 2
    heights = -(x[:, None] ** 2 + x**2) / (2 * radius) * (CELL / count)
    heights = np.maximum(heights, heights.min() / 4)
    grid, speed = Grid((count, count), (CELL, CELL)), 0.5
    slid = slide(
        heights,
        grid,
        Solid(E),
        nominal_pressure=5e5,
        friction_coefficient=0.3,
        speed=speed,
        moving=replace(STEEL, speed=speed),
        resting=STEEL,
        slid_distance=CELL,
    )
    flux = 0.3 * speed * slid.contact.pressure
    frozen = partition_heat(
        flux,
        grid,
        moving=replace(STEEL, speed=speed),
        resting=STEEL,
        time=slid.slid_distance[-1] / speed,
    )
    assert slid.contact_fraction[-1] < 0.05
    assert slid.moving_share[-1] == pytest.approx(frozen.moving_share, abs=0.01)
    assert slid.contact_temperature[-1] == pytest.approx(frozen.flash_temperature, rel=0.02)


def test_the_stress_correlation_of_two_equal_faces_keeps_a_part_on_the_summits_of_each():
    still = partial(bumps(32, 1), None, 1.0)
    assert still.stress_correlation == pytest.approx(np.ones(still.slid_distance.size))
    rides = partial(0 * bumps(32, 1), bumps(32, 2), 1.0, distance=5 * CELL)
    assert abs(rides.stress_correlation[32:].mean()) < 0.05
    both = partial(bumps(32, 1), bumps(32, 2), 1.0, distance=5 * CELL)
    assert 0.05 < both.stress_correlation[32:].mean() < 0.3


def test_a_step_is_whole_pixels_and_laps_meet_new_rows():
    grid = Grid((64, 64), (CELL, CELL))
    path = oblique_path(grid, 3 * CELL)
    assert (np.diff(path.offsets[:, 0]) == 1).all()
    assert np.diff(path.distance) == pytest.approx(CELL / 64 * hypot(1, ACROSS))
    rows = path.offsets[[64, 128, 192 - 3], 1] % 64
    assert len({int(row) // 4 for row in rows}) == 3
    assert np.diff(oblique_path(grid, CELL, 16).offsets[:, 0]).tolist() == [4] * 16
    assert (
        oblique_path(grid, CELL, backwards=True).offsets == -oblique_path(grid, CELL).offsets
    ).all()


def test_in_a_tall_cell_the_path_is_no_steeper():
    path = oblique_path(Grid((20, 400), (CELL, 10 * CELL)), 2 * CELL)
    angle = path.offsets[-1] * [CELL / 20, CELL / 40]
    assert angle[1] / angle[0] == pytest.approx(ACROSS, abs=0.02)
    assert path.distance[-1] == pytest.approx(hypot(*angle), rel=0.01)


def test_the_stress_of_two_flats_has_no_correlation():
    flat = np.zeros((16, 16))
    assert np.isnan(partial(flat, flat, 1.0).stress_correlation).all()


def test_speeds_of_the_bodies_may_be_rounded():
    # 0.4 − 0.1 is not 0.3 to the last bit
    moving, resting = replace(STEEL, speed=0.4), replace(STEEL, speed=0.1)
    slid = partial(bumps(16, 1), bumps(16, 2), [0.3])
    both = slide(
        bumps(16, 1),
        Grid((16, 16), (CELL, CELL)),
        Solid(E),
        nominal_pressure=1e6,
        friction_coefficient=0.3,
        speed=0.3,
        moving=moving,
        resting=resting,
        counter_heights=bumps(16, 2),
        slid_distance=CELL / 2,
    )
    assert (both.flash_temperature == slid.flash_temperature[0]).all()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"speed": 0.0}, "speed = 0.0 m/s must be finite, not 0"),
        ({"speed": [1.0, -1.0]}, "of one sign"),
        (
            {"speed": [1.0, 2.0], "moving": replace(STEEL, speed=1.0)},
            "several speeds, but moving.speed",
        ),
        (
            {"moving": replace(STEEL, speed=2.0)},
            "moving.speed − resting.speed = 2 m/s, but speed = 1 m/s",
        ),
        ({"slid_distance": 1e-6}, "slid_distance = 1e-06 m is under a step of one pixel"),
        ({"slid_distance": -1.0}, "slid_distance = -1 m must be positive"),
        ({"steps": 100}, "steps = 100 over 0.001 m would be shorter than one pixel"),
        ({"steps": 0}, "steps = 0 must be a whole number"),
        (
            {"slid_distance": 1e5},
            "slid_distance = 100000 m is 1.58e.09 steps of 6.316e-05 m, of which 1000000 are",
        ),
        ({"friction_coefficient": -0.1}, "friction_coefficient = -0.1 must be positive"),
        ({"friction_coefficient": 0}, "friction_coefficient = 0 must be positive"),
        ({"counter_heights": np.zeros((8, 8))}, "counter_heights has shape"),
        ({"nominal_pressure": 2e9, "solid": Solid(E, 1e9)}, "exceeds penetration_hardness"),
        ({"grid": 3}, "^grid = 3 must be a Grid, as Grid("),
        ({"solid": E}, "^solid = 1.* must be a Solid, as Solid("),
        ({"moving": None}, "^moving = None must be a Body, as Body("),
        ({"resting": 1.0}, "^resting = 1.0 must be a Body, as Body("),
    ],
)
def test_bad_input_is_refused(change, message):
    arguments = {
        "heights": waves(16, 1),
        "grid": Grid((16, 16), (CELL, CELL)),
        "solid": Solid(E),
        "nominal_pressure": 1e6,
        "friction_coefficient": 0.3,
        "speed": 1.0,
        "moving": replace(STEEL, speed=1.0),
        "resting": STEEL,
        "slid_distance": CELL,
    } | change
    with pytest.raises((TypeError, ValueError), match=message.replace("(", r"\(")):
        slide(arguments.pop("heights"), arguments.pop("grid"), arguments.pop("solid"), **arguments)
