"""From the levels of a column to one value: where it is continued, by what, and what is left as its error."""

from dataclasses import replace

import numpy as np
import pytest
from ladder_cases import (
    END,
    GRADIENT,
    NAME,
    SPEEDS,
    at_level,
    at_speeds,
    ladder,
    power_law,
    step,
    with_partner,
)
from scipy.special import j0

import roughsim as rs
from roughsim.estimate.levels import notes_of, values_of
from roughsim.observables.record import Sample
from roughsim.scene.numerics import Level, Numerics


@pytest.fixture
def resting(steel):
    """The steel, at rest and in motion."""
    return replace(steel, sliding=replace(steel.sliding, speed=(0.0, 1.0)))


# to the end of C(q)


@pytest.mark.parametrize("column", ["elastic", "capped"])
def test_levels_to_the_end_of_the_spectrum_leave_no_bandwidth_error(steel, column):
    cut_offs = END / 4, END / 2, END
    values = values_of(steel, column, NAME, ladder(at_speeds(9.0, 8.0, 7.5), cut_offs))
    np.testing.assert_allclose(values.value, 7.5, rtol=1e-12)
    np.testing.assert_allclose(values.finest, 7.5, rtol=1e-12)
    np.testing.assert_array_equal(values.errors["bandwidth"], 0.0)
    np.testing.assert_array_equal(values.errors["last step"], 0.0)
    assert np.isnan(values.errors["pixel"]).all()  # no partner shows it
    assert values.way == ""
    almost = values_of(
        steel, column, NAME, ladder(at_speeds(7.5), [END * (1 - 1e-12)])
    )  # the end to rounding
    np.testing.assert_array_equal(almost.errors["bandwidth"], 0.0)


def test_levels_add_their_variances_by_stream(steel):
    pairs = ladder(at_speeds(9.0, 8.0), (END / 2, END), n=8, scatter=0.1)
    pairs[0] = replace(pairs[0], stream=3)
    rng = np.random.default_rng(5)
    fine, coarse = (2.0 + 0.1 * rng.standard_normal((6, SPEEDS)) for _ in range(2))
    pairs.append(step(2, fine, coarse, (END, END), name=NAME))
    values = values_of(steel, "elastic", NAME, pairs)
    assert {stream: len(rows) for stream, rows in values.influence.items()} == {3: 8, 1: 8, 2: 6}
    base = pairs[0].numbers[NAME]
    variance = base.var(axis=0, ddof=1) / 8 / base.mean(axis=0) ** 2
    np.testing.assert_allclose(values.variance[3] / values.value**2, variance, rtol=1e-9)
    # 4/3 of the ratio of refined, at order 2: T (1 + 4/3 (r − 1))
    ratio = fine.mean(axis=0) / coarse.mean(axis=0)
    relative = fine / fine.mean(axis=0) - coarse / coarse.mean(axis=0)
    expected = (8.0 * 4 / 3 * ratio) ** 2 * relative.var(axis=0, ddof=1) / 6
    np.testing.assert_allclose(values.variance[2], expected, rtol=1e-9)


# beyond the highest cut-off


def test_contact_that_follows_the_theory_goes_on_with_its_shape(steel, foretold):
    foretold.theory = np.outer([1.0, 2.0, 3.5], np.ones(SPEEDS))
    for column in ("elastic", "capped"):
        values = values_of(steel, column, NAME, ladder(at_speeds(8.0, 9.0), (1e5, 2e5)))
        np.testing.assert_allclose(values.value, 10.5, rtol=1e-12)
        np.testing.assert_allclose(values.errors["bandwidth"], np.abs(1.5 - 9.0 * 0.75), rtol=1e-12)
        np.testing.assert_array_equal(values.errors["last step"], 0.0)
        assert values.way == "with the shape of the theory"
    assert foretold.calls == [
        (what, column, (1e5, 2e5), *name)
        for column in ("elastic", "capped")
        for what, *name in (("law",), ("theory", NAME))
    ]


@pytest.mark.parametrize(("column", "doubt"), [("elastic", 0.5), ("capped", 1.0)])
def test_capped_contact_that_follows_the_theory_may_yield_so_that_all_of_the_rest_is_in_doubt(
    steel, foretold, column, doubt
):
    foretold.theory = np.outer([8.0, 9.0, 9.5, 9.6], np.ones(SPEEDS))
    values = values_of(steel, column, NAME, ladder(at_speeds(8.0, 9.0, 9.5), (1e5, 2e5, 4e5)))
    np.testing.assert_allclose(values.value, 9.6, rtol=1e-12)
    np.testing.assert_allclose(values.errors["bandwidth"], doubt * 0.1, rtol=1e-9)


def test_t_flash_of_yielded_contact_goes_on_by_the_law_of_the_upper_two_cut_offs(steel, foretold):
    foretold.law = np.outer([4.0, 3.6, 3.0], np.ones(SPEEDS))
    values = values_of(steel, "capped", NAME, ladder(at_speeds(12.0, 10.0, 9.0), (1e5, 2e5, 4e5)))
    np.testing.assert_allclose(values.value, 9.0 * 3.0 / 3.6, rtol=1e-12)
    np.testing.assert_allclose(values.errors["bandwidth"], 0.1 * 1.5, rtol=1e-12)
    assert foretold.calls == [("law", "capped", (1e5, 2e5, 4e5))]


def test_elastic_contact_by_the_law_is_known_no_better_than_its_steps(steel, foretold):
    elastic = replace(steel, body=replace(steel.body, penetration_hardness=None), counterface=None)
    foretold.law = np.outer([3.9, 4.0, 4.0], np.ones(SPEEDS))
    values = values_of(elastic, "elastic", NAME, ladder(at_speeds(9.75, 10.0), (2e5, 4e5)))
    np.testing.assert_allclose(values.value, 10.0, rtol=1e-12)
    np.testing.assert_allclose(values.errors["bandwidth"], 0.04, rtol=1e-9)


def test_where_no_law_holds_t_flash_goes_on_as_a_power(steel, asked):
    q = 1.0, 2.0, 4.0  # in units of 1e5/m
    pairs = ladder(at_speeds(*(power_law(x, 0.9) for x in q)), [1e5 * x for x in q])
    values = values_of(steel, "capped", NAME, pairs)
    np.testing.assert_allclose(values.value, power_law(END / 1e5, 0.9), rtol=1e-9)
    assert [call[0] for call in asked] == ["law", "theory", "usual"]
    assert asked[-1] == ("usual", 4e5)
    two = values_of(
        steel, "capped", NAME, ladder(at_speeds(*(power_law(x, 0.8) for x in q[1:])), [2e5, 4e5])
    )
    np.testing.assert_allclose(two.value, power_law(END / 1e5, 0.8), rtol=1e-9)


# T_flash of 4 to 400 boundary-element contacts each, from one cut-off to twice as much, from 1.99e5 to 3.19e6/m
SOFT = {
    "surface": {
        "rms_height": 3.39e-6,
        "hurst": 0.67,
        "q_min": 2730.0,
        "q_roll_off": 9360.0,
        "q_max": 3.19e6,
    },
    "body": {
        "youngs_modulus": 1.34e8,
        "poisson_ratio": 0.5,
        "conductivity": 5.48,
        "density": 1200.0,
        "heat_capacity": 1600.0,
    },
    "sliding": {
        "nominal_pressure": 2.83e6,
        "friction_coefficient": 0.5,
        "speed": [0.0134, 0.267, 5.34],
    },
}
GAINS = np.array(
    [[1.085, 3.708, 10.017], [0.488, 1.733, 7.425], [0.235, 0.82, 5.28], [0.115, 0.388, 3.325]]
)


@pytest.mark.parametrize("steps", [1, 2])
def test_elastic_contact_goes_on_to_what_finer_grids_found(steps):
    # steps of the theory exceed these ever more: by its shape 1.3 to 1.6 times as much followed at the lower speeds
    scene = rs.load_scene(SOFT)
    found = np.cumprod(1.0 + GAINS / 100.0, axis=0)
    rungs = [np.ones(3), *found][: steps + 1]
    cut_offs = 3.19e6 / 2.0 ** np.arange(4, 3 - steps, -1)
    values = values_of(
        scene, "elastic", NAME, ladder([np.tile(one, (6, 1)) for one in rungs], cut_offs)
    )
    rest = found[-1] - rungs[-1]
    assert np.all(np.abs(values.value - found[-1]) < values.errors["bandwidth"])
    of_rest = np.sqrt(values.errors["bandwidth"] ** 2 - (0.004 * rungs[-1]) ** 2)
    assert np.all(of_rest < 0.2 * rest)


# lengths


def radius_level(radius, cut_off):
    """A single wave, whose J0(q r) is .5 at this radius."""
    q = np.array([1.5211440576687654 / radius])
    assert j0(q[0] * radius) == pytest.approx(0.5)
    return Sample(cut_off, 64.0, np.arange(6), {}, q, np.ones((6, 1)), 10.0 * radius)


@pytest.mark.parametrize(("waves", "goes_on"), [(1.9, False), (2.1, True)])
def test_a_length_within_two_waves_of_the_cut_off_does_not_go_on(steel, asked, waves, goes_on):
    # steel, r(g = .5): 10.7, 8.8, 7.8, 7.55 µm, where the first three promised 6.7 ± .2
    top = 2e-6 * np.pi * waves
    cut_offs = 5e5, 1e6
    low, high = (radius_level(r, q) for r, q in zip((top + 1e-6, top), cut_offs, strict=True))
    values = values_of(
        steel, "capped", "correlation_radius_50", [at_level(low, 0, 0), at_level(high, 1, 1, low)]
    )
    if goes_on:
        assert values.value[0] < top - 0.5e-6
    else:
        assert values.value[0] == pytest.approx(top, rel=1e-9)
        assert values.errors["bandwidth"][0] == pytest.approx(1e-6, rel=1e-6)  # the last step


def test_a_length_at_one_cut_off_is_unknown_beyond(steel, asked):
    values = values_of(
        steel, "capped", "correlation_radius_50", [at_level(radius_level(1e-6, 1e6), 0, 0)]
    )
    assert np.isnan(values.errors["bandwidth"][0])
    assert values.value[0] == pytest.approx(1e-6, rel=1e-9)


def test_in_capped_contact_what_has_no_limit_stays_the_value_of_the_finest_level(steel, asked):
    pairs = with_partner(ladder(at_speeds(-3.0, -5.0), (1e5, 2e5), name=GRADIENT), 0.1, 2e5)
    values = values_of(steel, "capped", GRADIENT, pairs)
    assert asked == []
    np.testing.assert_allclose(values.value, -5.5, rtol=1e-12)
    np.testing.assert_allclose(values.finest, -5.5, rtol=1e-12)
    assert np.isnan(values.errors["bandwidth"]).all()
    np.testing.assert_array_equal(values.errors["last step"], 0.0)
    # both what the pixel has changed and what it leaves, at order .8
    left = 0.1 / (2.0**0.8 - 1.0)
    np.testing.assert_allclose(values.errors["pixel"], 5.5 * np.hypot(left, 0.1 + left), rtol=1e-12)
    elastic = values_of(
        steel,
        "elastic",
        GRADIENT,
        with_partner(ladder(at_speeds(-3.0, -5.0), (END / 2, END), name=GRADIENT), 0.1, END),
    )
    np.testing.assert_allclose(elastic.value, -5.0 * (1.0 + 0.1 * 4 / 3), rtol=1e-12)
    np.testing.assert_allclose(elastic.errors["pixel"], 5.0 * 0.1 / 3, rtol=1e-12)


# what is unknown


@pytest.mark.parametrize("column", ["elastic", "capped"])
def test_where_nothing_continues_the_last_step_is_part_of_the_error(steel, foretold, column):
    foretold.theory = np.full((4, SPEEDS), np.nan)
    pairs = with_partner(
        ladder(at_speeds(14.77, 25.92, 40.21), (1e5, 2e5, 4e5), scatter=0.01), 0.0, 4e5
    )
    values = values_of(steel, column, NAME, pairs)
    np.testing.assert_allclose(values.value, 40.21, rtol=1e-12)
    np.testing.assert_allclose(values.errors["last step"], 40.21 - 25.92, rtol=1e-12)
    assert np.isnan(values.errors["bandwidth"]).all()
    assert values.way == ""
    falling = values_of(
        steel, column, NAME, ladder(at_speeds(40.21, 25.92, 14.77), (1e5, 2e5, 4e5))
    )
    np.testing.assert_allclose(falling.errors["last step"], 25.92 - 14.77, rtol=1e-12)


def test_one_cut_off_shows_no_last_step(steel, asked):
    values = values_of(steel, "capped", NAME, ladder(at_speeds(9.0), (1e5,)))
    np.testing.assert_array_equal(values.errors["last step"], 0.0)
    assert np.isnan(values.errors["bandwidth"]).all()


def test_not_extrapolated_values_are_those_of_the_highest_cut_off_with_a_vanishing_pixel(
    steel, asked
):
    pairs = with_partner(ladder(at_speeds(9.0, 8.0), (1e5, 2e5)), -0.06, 1e5)
    values = values_of(steel, "capped", NAME, pairs, extrapolated=False)
    assert asked == []
    change, left = 0.06 * 2.0**1.75 / (2.0**1.75 - 1.0), 0.06 / (2.0**1.75 - 1.0)
    np.testing.assert_allclose(
        values.value, 8.0 * (1.0 - change / 2.0**0.75), rtol=1e-12
    )  # from 1e5 to 2e5
    moved, left = change / 2.0**0.25, left / 2.0**0.75  # of the largest change
    np.testing.assert_allclose(values.errors["pixel"], 8.0 * np.hypot(moved, left), rtol=1e-12)
    np.testing.assert_array_equal(values.errors["bandwidth"], 0.0)


def test_not_continued_values_are_extrapolated_in_the_pixel_alone(steel, asked):
    pairs = with_partner(ladder(at_speeds(9.0, 8.0), (END / 8, END / 4)), -0.06, END / 4)
    values = values_of(steel, "capped", NAME, pairs, continued=False)
    assert asked == []
    change = 0.06 * 2.0**1.75 / (2.0**1.75 - 1.0)
    np.testing.assert_allclose(values.value, 8.0 * (1.0 - change), rtol=1e-12)
    assert np.isnan(values.errors["bandwidth"]).all()
    np.testing.assert_allclose(values.errors["last step"], 1.0, rtol=1e-12)


# at rest


def test_at_rest_nothing_heats_and_that_is_exact(resting, asked):
    pairs = ladder([[1e-9, 9.0], [2e-9, 8.0]], (1e5, 2e5), scatter=0.1)
    values = values_of(resting, "capped", NAME, with_partner(pairs, 0.1, 2e5, speeds=2))
    for part in (values.value, values.finest, *values.errors.values()):
        assert part[0] == 0.0
    assert all(np.all(rows[:, 0] == 0.0) for rows in values.influence.values())
    assert np.all(values.variance[0][1] > 0.0)
    assert values.value[1] != 0.0
    assert values.errors["pixel"][1] > 0.0
    assert values.errors["bandwidth"][1] > 0.0


def test_at_rest_the_slope_length_is_infinite(resting, asked):
    def level(q, side=64.0):
        numbers = {NAME: np.full((6, 2), 8.0), GRADIENT: np.full((6, 2), [0.0, -2.0])}
        return Sample(q, side, np.arange(6), numbers, np.ones(1), np.ones((6, 1)), 1.0)

    pairs = [at_level(level(1e5), 0, 0), at_level(level(2e5), 1, 1, level(1e5))]
    pairs.append(at_level(level(1e5, 128.0), 2, 2, level(1e5)))
    values = values_of(resting, "capped", "slope_length", pairs)
    assert values.value[0] == np.inf
    assert values.value[1] == pytest.approx(4.0)


def test_in_motion_nothing_is_set(steel, asked):
    values = values_of(steel, "capped", NAME, ladder(at_speeds(9.0), (END,)))
    assert np.all(values.value == 9.0)


# in words


def test_notes_say_what_values_are_made_of(steel, resting, asked):
    levels = [Level("capped", (64, 64), 1e5), Level("capped", (64, 64), 2e5, cell="half")]
    numerics = Numerics((*levels, Level("smoothed", (64, 64), 1e5)), (2e-3, 2e-3), tolerance=2e-3)

    def notes(values, name=NAME):
        return notes_of(steel, numerics, "capped", name, values)

    pairs = ladder(at_speeds(9.0, 8.0), (1e5, 2e5))
    found = notes(values_of(steel, "capped", NAME, pairs))
    assert found[0] == (
        "capped contact, levels with members: 64 × 64 to 1e+05 rad/m, 64 × 64 to 2e+05 rad/m in half the cell; "
        "solver tolerance 0.002"
    )
    assert found[1] == "continued beyond the highest cut-off as q_c^(−p) with p = 0.80"
    assert found[2] == "speeds 0.001, 0.01, 0.1, 1, 10, 35, 100 m/s"
    at_rest = ladder(at_speeds(9.0, 8.0, speeds=2), (1e5, 2e5))
    for scene, column in ((steel, pairs), (resting, at_rest)):
        cut = notes(values_of(scene, "capped", NAME, column, continued=False))
        assert cut[1] == (
            "the bandwidth error is unknown: value of the highest q_c, and the change by the last step to it is "
            "part of the error"
        )
    one = notes(values_of(steel, "capped", NAME, pairs[:1]))
    assert one[1] == "the bandwidth error is unknown: value of the highest q_c"
    gradients = ladder(at_speeds(-9.0, -8.0), (1e5, 2e5), name=GRADIENT)
    endless = notes(values_of(steel, "capped", GRADIENT, gradients), GRADIENT)
    assert (
        endless[1]
        == "does not converge with the grid: the value of the finest level, not extrapolated"
    )
    variance = ladder([2.0, 3.0], (1e5, 2e5), name="pressure_variance")
    assert (
        len(notes(values_of(steel, "capped", "pressure_variance", variance), "pressure_variance"))
        == 2
    )  # no speeds
