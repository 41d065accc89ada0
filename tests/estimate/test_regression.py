"""Regression on the skewness: slopes of all other realizations, no bias, and what is left alone."""

import numpy as np
import pytest

from roughsim.estimate.errors import estimate
from roughsim.estimate.ladder import observe
from roughsim.estimate.regression import at_zero_skewness
from roughsim.observables.record import Sample

NAME = "flash_temperature"


def test_each_row_is_corrected_with_the_slope_of_all_others():
    rng = np.random.default_rng(1)
    skewness = rng.standard_normal(9)
    values = np.array([10.0, 200.0]) + np.outer(skewness, [3.0, -0.5]) + rng.standard_normal((9, 2))
    expected = np.empty_like(values)
    for i in range(9):
        others = np.arange(9) != i
        for k in range(2):
            slope = np.polyfit(skewness[others], values[others, k], 1)[0]
            expected[i, k] = values[i, k] - slope * skewness[i]
    np.testing.assert_allclose(at_zero_skewness(values, skewness), expected, rtol=1e-12)
    np.testing.assert_allclose(at_zero_skewness(values, skewness[:, None]), expected, rtol=1e-12)


def test_values_on_a_line_have_no_scatter_left_and_the_value_at_zero():
    skewness = np.linspace(-0.2, 0.5, 8)
    values = 7.0 + np.outer(skewness, [2.0, -4.0])
    np.testing.assert_allclose(at_zero_skewness(values, skewness), 7.0, rtol=1e-12)


def test_few_rows_and_rows_without_a_skewness_stay_to_the_bit():
    values = np.random.default_rng(2).standard_normal((12, 3))
    skewness = np.random.default_rng(3).standard_normal(12)
    np.testing.assert_array_equal(at_zero_skewness(values[:7], skewness[:7]), values[:7])
    assert not np.any(at_zero_skewness(values[:8], skewness[:8]) == values[:8])
    for unknown in (np.full(12, np.nan), np.zeros(12), np.full((12, 1), np.nan)):
        np.testing.assert_array_equal(at_zero_skewness(values, unknown), values)
    np.testing.assert_array_equal(at_zero_skewness(values, np.full(12, 0.3)), values)  # no slope can be told


def test_rows_of_an_older_run_count_as_they_are():
    values = np.random.default_rng(4).standard_normal((20, 1))
    skewness = np.random.default_rng(5).standard_normal(20)
    skewness[:10] = np.nan
    mixed = at_zero_skewness(values, skewness)
    np.testing.assert_array_equal(mixed[:10], values[:10])
    assert not np.any(mixed[10:] == values[10:])


def test_infinite_and_undefined_values_stay():
    values = np.ones((10, 3)) * [np.inf, np.nan, 1.0]
    changed = at_zero_skewness(values, np.linspace(-1, 1, 10))
    np.testing.assert_array_equal(changed, values)


@pytest.mark.statistical
def test_nothing_is_biased_where_a_common_slope_would_be():
    # Y = s² has the mean 1. The slope of all rows is correlated with their skewness: the mean at zero would be 1 − 2/n
    rng, n, own, common = np.random.default_rng(6), 10, [], []
    for _ in range(4000):
        s = rng.standard_normal(n)
        own.append(at_zero_skewness((s * s)[:, None], s).mean())
        common.append(np.polyfit(s, s * s, 1)[1])
    error = np.std(own) / np.sqrt(len(own))
    assert abs(np.mean(own) - 1.0) < 4 * error
    assert np.mean(common) < 1.0 - 6 * error


@pytest.mark.statistical
@pytest.mark.parametrize("n", [8, 12, 24])
@pytest.mark.slow
def test_intervals_hold_the_mean_as_often_as_they_say(n):
    # 80 % of the variance follows the skewness; the half-width is Student's, times √(1 + 2/f)
    rng, held, width = np.random.default_rng(7), 0, []
    for _ in range(3000):
        s = rng.standard_normal((n, 1))
        values = 5.0 + np.sqrt(0.8) * s + np.sqrt(0.2) * rng.standard_normal((n, 1))
        found = estimate(NAME, observe(NAME, [sample(values, s)], capped=True, end=1.0))
        held += abs(found.mean[0] - 5.0) <= found.half_width[0]
        width.append(found.standard_error[0] * np.sqrt(n))
    assert 0.94 < held / 3000 < 0.98
    assert np.sqrt(0.2) < np.mean(width) < np.sqrt(0.2) * (1 + 1.5 / n)


def sample(values, skewness, q_max=1.0, every=1):
    rows = np.arange(0, len(values), every)
    numbers = {NAME: values[rows], "skewness": skewness[rows]}
    return Sample(q_max, 64.0 * q_max, rows, numbers, np.ones(1), np.ones((len(rows), 1)), 1.0)


def test_the_coarsest_level_is_at_zero_skewness_and_the_corrections_are_as_they_are():
    rng = np.random.default_rng(8)
    s = rng.standard_normal((16, 1))
    base = 100.0 + 5.0 * s + 0.1 * rng.standard_normal((16, 1))
    change = -8.0 + 0.2 * rng.standard_normal((16, 1))
    found = observe(NAME, [sample(base, s), sample(base + change, s, 2.0, 4)], capped=False, end=2.0)
    coarse = np.array(
        [base[i] - np.polyfit(np.delete(s[:, 0], i), np.delete(base[:, 0], i), 1)[0] * s[i] for i in range(16)]
    )
    assert found.extrapolated.mean() == pytest.approx(coarse.mean() + change[::4].mean(), rel=1e-12)
    np.testing.assert_allclose(found.base - found.base.mean(), coarse - coarse.mean(), rtol=1e-9, atol=1e-9)
    whole = observe(NAME, [sample(base, s), sample(base + change, s, 2.0)], capped=False, end=2.0)
    top = (base + change)[:, 0]
    expected = [top[i] - np.polyfit(np.delete(s[:, 0], i), np.delete(top, i), 1)[0] * s[i, 0] for i in range(16)]
    np.testing.assert_allclose(whole.extrapolated[:, 0], expected, rtol=1e-12)


def test_levels_without_a_skewness_are_read_as_before():
    values = np.random.default_rng(9).standard_normal((12, 2)) + 50.0
    plain = Sample(1.0, 64.0, np.arange(12), {NAME: values}, np.ones(1), np.ones((12, 1)), 1.0)
    np.testing.assert_array_equal(observe(NAME, [plain], capped=True, end=1.0).extrapolated, values)
