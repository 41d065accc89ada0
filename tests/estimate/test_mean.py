"""`Mean`: sums, products and ratios of means have the scatter that moving one realization shows."""

import numpy as np
import pytest

from roughsim.estimate.mean import Mean, mean_of

RNG = np.random.default_rng(3)
# rows of four means: the first two see the same surfaces, of which the second has fewer; the others have their own
ROWS = tuple(
    level + RNG.standard_normal((n, 2)) for level, n in ((20.0, 9), (-7.0, 5), (4.0, 6), (11.0, 4))
)
STREAMS = 2, 2, 5, 0
FORMULAS = {
    "a sum": lambda a, b, c, d: a + b + c,
    "a difference": lambda a, b, c, d: a - b - c,
    "a multiple": lambda a, b, c, d: a * -3.0 + b * 0.5,
    "a product": lambda a, b, c, d: a * b * c,
    "a square": lambda a, b, c, d: a * a,
    "a ratio": lambda a, b, c, d: a / b,
    "the fewer over the more": lambda a, b, c, d: b / a,
    "a chain": lambda a, b, c, d: a * (c / d) + b / d,
    "exact numbers": lambda a, b, c, d: (a + 3.0) * (b - 2.0),
}


def by_moving_one(formula, stream, i, step=1e-4):
    """What realization i adds to a result: that with a little more of its deviation, and with less, by the step."""

    def result(more):
        means = [rows.mean(axis=0) for rows in ROWS]
        for k, rows in enumerate(ROWS):
            if STREAMS[k] == stream and i < len(rows):
                means[k] = means[k] + more * (rows[i] - means[k]) / len(rows)
        return formula(*means)

    return (result(step) - result(-step)) / (2.0 * step)


@pytest.mark.parametrize("name", FORMULAS)
def test_a_result_scatters_as_moving_one_realization_shows(name):
    formula = FORMULAS[name]
    found = formula(*(mean_of(stream, rows) for stream, rows in zip(STREAMS, ROWS, strict=True)))
    np.testing.assert_allclose(
        found.value, formula(*(rows.mean(axis=0) for rows in ROWS)), rtol=1e-12
    )
    for stream, rows in found.influence.items():
        expected = [by_moving_one(formula, stream, i) for i in range(len(rows))]
        np.testing.assert_allclose(rows, expected, rtol=1e-6, atol=1e-6)


def test_a_result_has_the_streams_of_its_means():
    a, b, c, d = (mean_of(stream, rows) for stream, rows in zip(STREAMS, ROWS, strict=True))
    assert {stream: len(rows) for stream, rows in ((a + b) * (c / d)).influence.items()} == {
        2: 9,
        5: 6,
        0: 4,
    }
    assert {stream: len(rows) for stream, rows in (b + a).influence.items()} == {2: 9}


def test_what_surfaces_have_in_common_cancels_in_a_ratio_and_in_a_difference():
    rows = ROWS[0]
    upper, lower = mean_of(1, 3.0 * rows), mean_of(1, rows)
    ratio, difference = upper / lower, upper - lower * 3.0
    np.testing.assert_allclose(ratio.value, 3.0, rtol=1e-12)
    np.testing.assert_allclose(ratio.influence[1], 0.0, atol=1e-14)
    np.testing.assert_allclose(difference.influence[1], 0.0, atol=1e-14)
    apart = mean_of(2, 3.0 * rows) / lower  # of surfaces of their own nothing does
    np.testing.assert_allclose(
        sum(apart.variance.values()),
        2 * 9 * rows.var(axis=0, ddof=1) / 9 / rows.mean(axis=0) ** 2,
        rtol=1e-12,
    )


def test_the_variance_of_a_mean_is_that_of_its_rows_over_their_number():
    rows = ROWS[0]
    np.testing.assert_allclose(
        mean_of(4, rows).variance[4], rows.var(axis=0, ddof=1) / 9, rtol=1e-12
    )
    both = (mean_of(4, rows) + mean_of(1, ROWS[2]) * 2.0).variance
    np.testing.assert_allclose(both[1], 4.0 * ROWS[2].var(axis=0, ddof=1) / 6, rtol=1e-12)
    np.testing.assert_allclose(both[4], rows.var(axis=0, ddof=1) / 9, rtol=1e-12)


def test_one_realization_shows_no_scatter_and_two_do():
    one, two = mean_of(0, ROWS[0][:1]), mean_of(0, ROWS[0][:2])
    np.testing.assert_array_equal(one.value, ROWS[0][0])
    assert one.variance[0].tolist() == [np.inf, np.inf]
    np.testing.assert_allclose(two.variance[0], (ROWS[0][0] - ROWS[0][1]) ** 2 / 4, rtol=1e-12)


def test_means_are_chosen_by_speed_with_their_scatter():
    a, c = mean_of(2, ROWS[0]), mean_of(5, ROWS[2])
    found = a.where(np.array([True, False]), c)
    np.testing.assert_array_equal(found.value, [a.value[0], c.value[1]])
    expected = ROWS[0][:, 0].var(ddof=1) / 9, ROWS[2][:, 1].var(ddof=1) / 6
    np.testing.assert_allclose(sum(found.variance.values()), expected, rtol=1e-12)


def test_what_is_not_chosen_may_be_undefined():
    a = mean_of(2, ROWS[0])
    undefined = Mean(*np.full((2, 2), np.nan), {5: np.full((6, 2), np.nan)})
    for whole in (
        a.where(np.array([True, True]), undefined),
        undefined.where(np.array([False, False]), a),
    ):
        np.testing.assert_array_equal(whole.value, a.value)
        np.testing.assert_array_equal(whole.influence[2], a.influence[2])
        np.testing.assert_array_equal(whole.influence[5], 0.0)


def test_a_mean_of_infinite_values_is_infinite_and_does_not_warn():
    found = mean_of(0, np.array([[np.inf, 1.0], [np.inf, 3.0]]))
    np.testing.assert_array_equal(found.value, [np.inf, 2.0])
    assert found.variance[0][1] == 1.0


def test_a_mean_that_holds_for_all_speeds_goes_with_one_that_does_not():
    share, kelvins = mean_of(0, ROWS[0][:, :1]), mean_of(0, ROWS[0])
    both, turned = share * kelvins, kelvins * share
    np.testing.assert_allclose(both.value, ROWS[0].mean(axis=0) * ROWS[0][:, 0].mean(), rtol=1e-12)
    np.testing.assert_allclose(both.influence[0], turned.influence[0], rtol=1e-12)
    for both in (share + kelvins, kelvins + share):
        assert both.influence[0].shape == (9, 2)
        np.testing.assert_allclose(
            both.influence[0], share.influence[0] + kelvins.influence[0], rtol=1e-12
        )
    fewer = mean_of(0, ROWS[0][:3]) * share  # and where one has fewer surfaces
    assert fewer.influence[0].shape == (9, 2)
    np.testing.assert_allclose(
        fewer.influence[0][5], ROWS[0][:3].mean(axis=0) * share.influence[0][5], rtol=1e-12
    )
