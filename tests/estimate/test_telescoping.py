"""The rungs of a column: products of ratios, differences where signs change, and what the pixel changes."""

import numpy as np
import pytest
from ladder_cases import NAME, ladder, lowest, step

from roughsim.estimate.mean import mean_of
from roughsim.estimate.telescoping import LevelMean, change_by_pixel, is_refined, telescoped

RNG = np.random.default_rng(1)


def rungs_of(pairs):
    return telescoped(lambda sample: sample.numbers[NAME], pairs)


def drawn(mean, n, speeds=2, scatter=0.1):
    return mean * (1.0 + scatter * RNG.standard_normal((n, speeds)))


@pytest.mark.parametrize("unit", [1.0, 1e-6, -1e3])
def test_a_rung_is_the_product_of_the_ratios_of_the_levels_up_to_it(unit):
    base = drawn(10.0 * unit, 7)
    first = drawn(9.0 * unit, 5), drawn(8.0 * unit, 5)
    second = drawn(6.0 * unit, 4), drawn(9.0 * unit, 4)
    pairs = [lowest(base), step(1, *first, (1.0, 2.0)), step(2, *second, (2.0, 4.0))]
    found = rungs_of(pairs)
    means = [base.mean(axis=0)]
    for fine, coarse in (first, second):
        means.append(means[-1] * fine.mean(axis=0) / coarse.mean(axis=0))
    assert [rung.q_max for rung in found] == [1.0, 2.0, 4.0]
    for rung, mean in zip(found, means, strict=True):
        np.testing.assert_allclose(rung.mean.value, mean, rtol=1e-12)
    assert sorted(found[-1].mean.influence) == [0, 1, 2]
    # relative variances of the lowest level and of both ratios
    ratios = [
        fine / fine.mean(axis=0) - coarse / coarse.mean(axis=0) for fine, coarse in (first, second)
    ]
    rows = [base / base.mean(axis=0), *ratios]
    relative = sum(row.var(axis=0, ddof=1) / len(row) for row in rows)
    np.testing.assert_allclose(
        sum(found[-1].mean.variance.values()), means[-1] ** 2 * relative, rtol=1e-12
    )


def test_levels_that_agree_with_the_level_below_add_no_scatter():
    same = drawn(9.0, 5)
    rung = rungs_of([lowest(drawn(10.0, 7)), step(1, 1.3 * same, same, (1.0, 2.0))])[-1]
    np.testing.assert_allclose(rung.mean.variance[1], 0.0, atol=1e-20)


@pytest.mark.parametrize("odd", [0, 1, 2])
def test_where_a_sign_changes_or_is_not_defined_steps_are_differences(odd):
    base, fine, coarse = drawn(10.0, 7), drawn(9.0, 5), drawn(8.0, 5)
    (base, fine, coarse)[odd][2, 0] *= -1.0  # at the first of two speeds
    found = rungs_of([lowest(base), step(1, fine, coarse, (1.0, 2.0))])[-1].mean
    b, f, c = (rows.mean(axis=0) for rows in (base, fine, coarse))
    np.testing.assert_allclose(found.value, [b[0] + f[0] - c[0], b[1] * f[1] / c[1]], rtol=1e-12)
    change = (fine - coarse)[:, 0]
    np.testing.assert_allclose(found.variance[0][0], base[:, 0].var(ddof=1) / 7, rtol=1e-12)
    np.testing.assert_allclose(found.variance[1][0], change.var(ddof=1) / 5, rtol=1e-12)


def test_values_that_are_zero_stay_zero():
    nothing = np.zeros((6, 1))
    found = rungs_of([lowest(nothing), step(1, nothing, nothing, (1.0, 2.0))])[-1].mean
    assert found.value[0] == 0.0
    assert sum(found.variance.values())[0] == 0.0


def test_infinite_values_stay_infinite_beside_others():
    def endless(mean, n):
        return np.column_stack((np.full(n, np.inf), drawn(mean, n, 1)))

    base, fine, coarse = endless(10.0, 7), endless(9.0, 5), endless(8.0, 5)
    found = rungs_of([lowest(base), step(1, fine, coarse, (1.0, 2.0))])[-1].mean
    expected = base[:, 1].mean() * fine[:, 1].mean() / coarse[:, 1].mean()
    assert found.value[1] == pytest.approx(expected, rel=1e-12)
    assert not np.isfinite(found.value[0])


def test_the_lowest_level_is_taken_at_the_mean_peak_volume_and_steps_as_they_are():
    volume = RNG.standard_normal(12)
    base = 10.0 + 3.0 * volume[:, None]  # without other scatter: 10 at the mean volume
    pairs = [
        lowest(base, peak_volume=volume[:, None]),
        step(1, base, base - 1.0, (1.0, 2.0), peak_volume=volume),
    ]
    found = rungs_of(pairs)
    assert found[0].mean.value[0] == pytest.approx(10.0, rel=1e-12)
    assert found[1].mean.value[0] == pytest.approx(
        10.0 * base.mean() / (base.mean() - 1.0), rel=1e-12
    )


def refined(level, fine, coarse, q_max, sides):
    return step(level, fine, coarse, (q_max, q_max), sides=sides)


def test_a_partner_corrects_the_rung_of_its_cut_off_and_is_none():
    fine, coarse = drawn(7.6, 5), drawn(8.0, 5)
    pairs = ladder([[10.0, 10.0], [8.0, 8.0]], (1.0, 2.0), scatter=0.1)
    low, high = rungs_of([pairs[0], refined(2, fine, coarse, 1.0, (64.0, 96.0)), pairs[1]])
    np.testing.assert_allclose(
        low.finer.value, fine.mean(axis=0) / coarse.mean(axis=0) - 1.0, rtol=1e-12
    )
    relative = fine / fine.mean(axis=0) - coarse / coarse.mean(axis=0)
    expected = (fine.mean(axis=0) / coarse.mean(axis=0)) ** 2 * relative.var(axis=0, ddof=1) / 5
    np.testing.assert_allclose(low.finer.variance[2], expected, rtol=1e-12)
    assert low.refined == pytest.approx(1.5)
    assert high.finer is None
    assert high.mean.value[0] == pytest.approx(8.0, rel=1e-12)


def test_a_partner_is_relative_to_its_rung_where_signs_change():
    fine, coarse = np.array([[2.0], [-1.0]]), np.array([[1.0], [-1.5]])
    (rung,) = rungs_of([lowest(np.full((6, 1), 4.0)), refined(1, fine, coarse, 1.0, (64.0, 128.0))])
    assert rung.finer.value[0] == pytest.approx((0.5 - -0.25) / 4.0, rel=1e-12)


def by_order(order, sides, change=0.08):
    """A rung of 10, and refined whose values are 10 (1 + change · (1 − h^order)) at pixels h = 64/side."""
    values = [1.0 + change * (1.0 - (sides[0] / side) ** order) for side in sides]
    pairs = [lowest(np.full((6, 1), 10.0))]
    for k in range(1, len(sides)):
        fine, coarse = (np.full((6, 1), 10.0 * value) for value in (values[k], values[k - 1]))
        pairs.append(refined(k, fine, coarse, 1.0, sides[k - 1 : k + 1]))
    return rungs_of(pairs)


@pytest.mark.parametrize("order", [0.7, 1.4, 2.0])
@pytest.mark.parametrize("fine", [96.0, 128.0])
def test_a_partner_of_known_order_gives_the_vanishing_pixel(order, fine):
    # a little change, as changes of a chain add
    change = change_by_pixel(by_order(order, (64.0, fine)), order, 0.5, 1.0)
    assert change.value[0] == pytest.approx(0.08, rel=1e-12)
    seen = 1.0 - (64.0 / fine) ** order
    assert change.errors["pixel"][0] == pytest.approx(
        0.08 * (1.0 - seen), rel=1e-12
    )  # all that was not seen is in doubt


@pytest.mark.parametrize("order", [0.7, 1.4])
def test_of_a_chain_of_partners_only_what_follows_the_last_is_in_doubt(order):
    # to first order in the changes
    change = change_by_pixel(by_order(order, (64.0, 128.0, 256.0), 1e-6), order, 0.5, 1.0)
    assert change.value[0] == pytest.approx(1e-6, rel=2e-6)
    assert change.errors["pixel"][0] == pytest.approx(1e-6 * 4.0**-order, rel=2e-6)


def test_what_turns_back_with_the_pixel_is_that_of_the_finest_grid_and_may_go_on_by_half_more_than_it_came():
    change = change_by_pixel(by_order(1.0, (64.0, 128.0)), np.nan, 0.5, 1.0)
    assert change.value[0] == pytest.approx(0.04, rel=1e-12)
    assert change.errors["pixel"][0] == pytest.approx(1.5 * 0.04, rel=1e-12)


@pytest.mark.parametrize("fall", [0.5, 1.0])
def test_a_change_that_was_seen_lower_falls_towards_the_end_and_all_of_it_is_in_doubt(fall):
    order = 1.4
    rungs = by_order(order, (64.0, 128.0))
    change = change_by_pixel(
        [*rungs, LevelMean(4.0, mean_of(9, np.full((6, 1), 8.0)))], order, fall, 16.0
    )
    assert change.value[0] == pytest.approx(0.08 / 16.0**fall, rel=1e-12)
    unseen = 0.08 * 2.0**-order / 16.0**fall
    assert change.errors["pixel"][0] == pytest.approx(
        np.hypot(unseen, 0.08 / 16.0**fall), rel=1e-12
    )


@pytest.mark.parametrize(("slow", "largest"), [(1.0, 0.6), (0.75, 0.6), (0.65, 0.7), (1.35, 0.7)])
def test_of_temperatures_the_largest_change_at_any_speed_is_in_doubt_at_each_higher_up(
    slow, largest
):
    coarse = np.full((6, 4), 10.0)
    coarse[:, 3] = 0.0  # nothing is known
    with np.errstate(invalid="ignore"):
        rungs, of_slow = (
            rungs_of([lowest(coarse), refined(1, coarse * change, coarse, 1.0, (64.0, 128.0))])
            for change in ([0.7, 1.0, 1.1, 1.0], [1.0, slow, 1.0, 1.0])
        )
        there = change_by_pixel(rungs, 1.0, 0.5, 1.0, of_slow)
        change = change_by_pixel(rungs, 1.0, 0.5, 16.0, of_slow)
    np.testing.assert_allclose(there.value, [-0.6, 0.0, 0.2, 0.0], rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(
        there.errors["pixel"], [0.3, 0.0, 0.1, 0.0], rtol=1e-12, atol=1e-12
    )  # where it was seen, each by itself
    np.testing.assert_allclose(change.value, there.value / 4.0, rtol=1e-12)
    np.testing.assert_allclose(
        change.errors["pixel"][:3],
        np.hypot(there.errors["pixel"] / 4.0, largest / 4.0 ** (1 / 3))[:3],
        rtol=1e-12,
    )
    assert change.errors["pixel"][3] == 0.0


def test_the_highest_partner_counts():
    low, high = (by_order(1.0, (64.0, 128.0), change)[0] for change in (0.2, 0.02))
    change = change_by_pixel([low, high._replace(q_max=2.0)], 1.0, 1.0, 2.0)
    assert change.value[0] == pytest.approx(0.02, rel=1e-12)


def test_the_scatter_of_a_partner_passes_into_what_it_leaves_and_falls_with_it():
    fine, coarse = drawn(7.6, 5), drawn(8.0, 5)
    rungs = rungs_of([lowest(np.full((6, 2), 10.0)), refined(1, fine, coarse, 1.0, (64.0, 128.0))])
    change = change_by_pixel(
        rungs, 1.0, 0.5, 4.0
    )  # twice what was seen, and half of that at the end
    np.testing.assert_allclose(
        change.value, fine.mean(axis=0) / coarse.mean(axis=0) - 1.0, rtol=1e-12
    )
    np.testing.assert_allclose(change.variance[1], rungs[0].finer.variance[1], rtol=1e-12)


def test_without_a_partner_the_error_is_unknown_and_nothing_is_changed():
    change = change_by_pixel(rungs_of(ladder([10.0, 8.0], (1.0, 2.0))), 1.4, 0.5, 2.0)
    np.testing.assert_array_equal(change.value, [0.0])
    assert change.influence == {}
    assert np.isnan(change.errors["pixel"]).all()


def test_what_is_zero_on_both_grids_is_not_changed_by_the_pixel():
    zero = np.outer(np.ones(6), [0.0, 5.0])
    rungs = rungs_of([lowest(zero), refined(1, 1.1 * zero, zero, 1.0, (64.0, 128.0))])
    change = change_by_pixel(rungs, 1.0, 0.5, 1.0)
    np.testing.assert_allclose(change.value, [0.0, 0.2], rtol=1e-12)
    np.testing.assert_allclose(change.errors["pixel"], [0.0, 0.1], rtol=1e-12)
    assert np.isfinite(change.influence[1]).all()


def test_a_level_with_the_cut_off_of_the_level_below_is_its_partner():
    rows = np.ones((6, 1))
    assert is_refined(step(1, rows, rows, (2.0, 2.0)))
    assert is_refined(step(1, rows, rows, (2.0, 2.0 * (1 + 1e-12))))  # the same to rounding
    assert not is_refined(step(1, rows, rows, (2.0, 2.001)))
    assert not is_refined(lowest(rows))
