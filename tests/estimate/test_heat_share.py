"""The share of the heat from the temperatures of both bodies, each continued by itself."""

from dataclasses import replace

import numpy as np
import pytest
from ladder_cases import END, NAME, SPEEDS, at_level

from roughsim import prediction
from roughsim.estimate.levels import values_of
from roughsim.observables.record import Sample


def bodies(moving, resting, q_max, *, speeds=SPEEDS):
    """A level with the temperatures of both bodies, each with all the heat; rows or a mean."""
    numbers = {NAME: moving, "resting_flash_temperature": resting}
    rows = {name: np.broadcast_to(values, (6, speeds)) for name, values in numbers.items()}
    return Sample(q_max, 64.0, np.arange(6), rows, np.ones(1), np.ones((6, 1)), 1.0)


@pytest.fixture
def two_bodies(steel):
    """The steel on a body of half its conductivity, with the share by the means of both temperatures."""
    counter = replace(
        steel.counterface, like=None, conductivity=15.0, density=7900.0, heat_capacity=500.0
    )
    return replace(
        steel, counterface=counter, sliding=replace(steel.sliding, heat_partition="mean")
    )


def test_the_share_of_the_heat_makes_both_bodies_equally_warm(two_bodies):
    rng = np.random.default_rng(2)
    moving, at_rest = 20.0 + rng.standard_normal((2, 6, SPEEDS))
    values = values_of(
        two_bodies, "elastic", "heat_partition", [at_level(bodies(moving, at_rest, END), 0, 0)]
    )
    a, b = 2.0 * at_rest.mean(axis=0), moving.mean(axis=0)  # of half the conductivity: twice as hot
    np.testing.assert_allclose(values.value, a / (a + b), rtol=1e-12)  # s T = (1 − s) T'
    np.testing.assert_allclose(values.finest, a / (a + b), rtol=1e-12)
    rows = (b * 2.0 * at_rest - a * moving) / (a + b) ** 2
    np.testing.assert_allclose(values.influence[0], (rows - rows.mean(axis=0)) / 6, rtol=1e-9)
    np.testing.assert_array_equal(values.errors["bandwidth"], 0.0)


def test_the_temperature_of_each_body_goes_on_by_itself(two_bodies, asked):
    q = 2.0, 4.0, END / 1e5
    moving, at_rest = ([base + 3.0 * x**-0.8 for x in q] for base in (7.0, 12.0))
    low, high = (bodies(t, r, 1e5 * x) for t, r, x in zip(moving, at_rest, q[:2], strict=False))
    pairs = [at_level(low, 0, 0), at_level(high, 1, 1, low)]
    values = values_of(two_bodies, "capped", "heat_partition", pairs)
    np.testing.assert_allclose(
        values.value, 2.0 * at_rest[2] / (2.0 * at_rest[2] + moving[2]), rtol=1e-9
    )
    np.testing.assert_allclose(
        values.finest, 2.0 * at_rest[1] / (2.0 * at_rest[1] + moving[1]), rtol=1e-9
    )
    relative = [
        (body[2] - body[1]) / body[2] for body in (moving, at_rest)
    ]  # two rungs: all of the rest is in doubt
    np.testing.assert_allclose(
        values.errors["bandwidth"],
        values.value * (1.0 - values.value) * np.hypot(*relative),
        rtol=1e-9,
    )
    cut = values_of(two_bodies, "capped", "heat_partition", pairs, continued=False)
    np.testing.assert_allclose(cut.value, cut.finest, rtol=1e-12)
    steps = np.hypot((moving[0] - moving[1]) / moving[1], (at_rest[0] - at_rest[1]) / at_rest[1])
    np.testing.assert_allclose(
        cut.errors["last step"], cut.value * (1.0 - cut.value) * steps, rtol=1e-9
    )


def test_what_the_pixel_changes_of_the_resting_body_is_in_doubt_in_both_at_a_higher_cut_off(
    two_bodies,
):
    coarse, upper = bodies(20.0, 10.0, END / 4), bodies(20.0, 10.0, END)
    finer = replace(bodies(20.0, 9.7, END / 4), side=128.0)
    pairs = [at_level(coarse, 0, 0), at_level(upper, 1, 1, coarse), at_level(finer, 2, 2, coarse)]
    values = values_of(two_bodies, "elastic", "heat_partition", pairs)
    change, left = -0.03 * 4.0 / 3.0, 0.03 / 3.0  # of order 2
    resting = 1.0 + change * 4.0**-0.3
    assert values.value[0] == pytest.approx(resting / (resting + 1.0), rel=1e-12)
    moved = change * 4.0**-0.1
    relative = np.hypot(moved, np.hypot(moved, left * 4.0**-0.3) / resting)
    assert values.errors["pixel"][0] == pytest.approx(
        values.value[0] * (1.0 - values.value[0]) * relative, rel=1e-12
    )


def test_mean_temperatures_of_the_surfaces_come_on_top(two_bodies, foretold):
    foretold.backgrounds = np.full(SPEEDS, 5.0), np.full(SPEEDS, 1.0)
    values = values_of(
        two_bodies, "elastic", "heat_partition", [at_level(bodies(20.0, 6.0, END), 0, 0)]
    )
    np.testing.assert_allclose(values.value, 13.0 / (13.0 + 25.0), rtol=1e-12)
    np.testing.assert_allclose(values.finest, 13.0 / (13.0 + 25.0), rtol=1e-12)


def test_the_resting_body_follows_the_theory_of_slow_sliding(two_bodies):
    q = 1e4, 2e4
    low, high = (bodies(t, 0.9 * t, cut_off) for t, cut_off in zip((1.0, 1.5), q, strict=True))
    values = values_of(
        two_bodies, "elastic", "heat_partition", [at_level(low, 0, 0), at_level(high, 1, 1, low)]
    )
    slow = replace(
        two_bodies,
        sliding=replace(two_bodies.sliding, speed=tuple(1e-10 * (k + 1) for k in range(SPEEDS))),
    )

    def to_the_end(scene, first, last):
        theory = prediction.continuation(scene, "elastic", q, NAME)
        return last + (last - first) * (theory[2] - theory[1]) / (theory[1] - theory[0])

    moving, resting = to_the_end(two_bodies, 1.0, 1.5), 2.0 * to_the_end(slow, 0.9, 1.35)
    np.testing.assert_allclose(values.value, resting / (resting + moving), rtol=1e-6)


def test_at_rest_the_share_is_that_of_slow_sliding(two_bodies):
    # both bodies go on with the shape of the theory, although it is zero at rest
    scene = replace(two_bodies, sliding=replace(two_bodies.sliding, speed=(0.0, 1e-9)))
    slow = np.array([1e-150, 1e-9])  # as members at rest are measured
    low, high = (
        bodies(t * slow, 0.9 * t * slow, q, speeds=2) for t, q in ((1.0, 2e5), (1.05, 4e5))
    )
    values = values_of(
        scene, "elastic", "heat_partition", [at_level(low, 0, 0), at_level(high, 1, 1, low)]
    )
    assert values.value[0] == pytest.approx(values.value[1], rel=1e-3)
    assert values.errors["bandwidth"][0] == pytest.approx(values.errors["bandwidth"][1], rel=1e-2)
    assert values.value[1] == pytest.approx(1.8 / 2.8, rel=1e-3)
