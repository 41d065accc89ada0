"""Regression on peak volumes: slopes of all other realizations, no bias, and what is left alone."""

import numpy as np
import pytest
from ladder_cases import NAME, lowest
from scipy import stats

from roughsim.estimate.errors import spread
from roughsim.estimate.regression import LEAST_FITTED, at_mean_peak_volume
from roughsim.estimate.telescoping import telescoped


def corrected(values, volumes):
    return at_mean_peak_volume(values, {"peak_volume": volumes})


def by_others(values, x):
    """Each row less what its peak volume adds by the slope of all others: least squares written out."""
    result = np.empty_like(values)
    for i in range(len(x)):
        others = np.arange(len(x)) != i
        for k in range(values.shape[1]):
            slope = np.polyfit(x[others], values[others, k], 1)[0]
            result[i, k] = values[i, k] - slope * x[i]
    return result


@pytest.mark.parametrize("scale", [1e-3, 20.0])
def test_each_row_is_corrected_with_the_slope_of_all_others(scale):
    rng = np.random.default_rng(1)
    x = scale * (0.3 + rng.standard_normal(13))
    values = np.array([10.0, 200.0]) + np.outer(x, [3e3, -0.5]) + rng.standard_normal((13, 2))
    np.testing.assert_allclose(corrected(values, x), by_others(values, x), rtol=1e-9)
    np.testing.assert_allclose(corrected(values, x[:, None]), by_others(values, x), rtol=1e-9)


def test_values_on_a_line_have_no_scatter_left_and_the_value_at_zero():
    x = np.linspace(-0.2, 0.5, 12)
    np.testing.assert_allclose(corrected(7.0 + np.outer(x, [2.0, -4.0]), x), 7.0, rtol=1e-12)


def test_few_rows_and_rows_without_a_peak_volume_stay_as_they_are():
    values = np.random.default_rng(2).standard_normal((12, 3))
    x = np.random.default_rng(3).standard_normal(12)
    few = LEAST_FITTED - 1
    np.testing.assert_array_equal(corrected(values[:few], x[:few]), values[:few])
    assert not np.any(corrected(values[: few + 1], x[: few + 1]) == values[: few + 1])
    np.testing.assert_array_equal(at_mean_peak_volume(values, {}), values)
    for unknown in (np.full(12, np.nan), np.zeros(12), np.full((12, 1), 0.3), x[:11]):
        np.testing.assert_array_equal(corrected(values, unknown), values)


def test_volumes_that_differ_by_rounding_alone_show_no_slope():
    values = np.random.default_rng(2).standard_normal((12, 1))
    for mean in (0.3, -0.3):
        np.testing.assert_array_equal(
            corrected(values, mean * (1.0 + 1e-14 * np.arange(12))), values
        )


def test_a_row_without_a_volume_counts_as_one_of_the_mean_volume():
    values = np.random.default_rng(4).standard_normal((14, 1))
    x = np.random.default_rng(5).standard_normal(14)
    x[3] = np.nan
    np.testing.assert_allclose(corrected(values, x), by_others(values, np.nan_to_num(x)), rtol=1e-9)
    assert corrected(values, x)[3] == values[3]


def test_infinite_and_undefined_values_stay():
    values = np.ones((10, 3)) * [np.inf, np.nan, 1.0]
    np.testing.assert_array_equal(corrected(values, np.linspace(-1, 1, 10)), values)


@pytest.mark.statistical
def test_nothing_is_biased_where_a_common_slope_would_be():
    # Y = x² has the mean 1. The slope of all rows is correlated with their x: the mean at zero would be 1 − 2/n
    rng, n, own, common = np.random.default_rng(6), 12, [], []
    for _ in range(1500):
        x = rng.standard_normal(n)
        own.append(corrected((x * x)[:, None], x).mean())
        apart = x - x.mean()
        common.append((x * x).mean() - x.mean() * (apart @ (x * x)) / (apart @ apart))
    error = np.std(own) / np.sqrt(len(own))
    assert abs(np.mean(own) - 1.0) < 4 * error
    assert np.mean(common) < 1.0 - 6 * error


@pytest.mark.statistical
@pytest.mark.parametrize("n", [12, 24])
def test_intervals_of_corrected_rows_hold_the_mean(n):
    # 80 % of the variance follows the peak volume. A row corrected with the slope of others scatters more than the
    # mean: so the plain interval is wide enough
    rng, trials, held, width = np.random.default_rng(7), 1000, 0, []
    quantile = stats.t.ppf(0.975, n - 1)
    for _ in range(trials):
        x = rng.standard_normal(n)
        rows = corrected(
            5.0 + np.sqrt(0.8) * x[:, None] + np.sqrt(0.2) * rng.standard_normal((n, 1)), x
        )
        error, _ = spread(rows)
        held += abs(rows.mean() - 5.0) <= quantile * error[0]
        width.append(error[0] * np.sqrt(n))
    assert 0.94 - 2.0 * 0.0069 < held / trials < 0.98
    assert np.sqrt(0.2) < np.mean(width) < np.sqrt(0.2) * (1.0 + 2.0 / n)


def test_the_lowest_level_of_a_column_is_taken_at_the_mean_peak_volume():
    rng = np.random.default_rng(8)
    x = rng.standard_normal(16)
    base = 100.0 + 5.0 * x[:, None] + 0.1 * rng.standard_normal((16, 1))
    (rung,) = telescoped(
        lambda sample: sample.numbers[NAME], [lowest(base, peak_volume=x[:, None])]
    )
    rows = by_others(base, x)
    np.testing.assert_allclose(rung.mean.value, rows.mean(axis=0), rtol=1e-12)
    np.testing.assert_allclose(rung.mean.variance[0], rows.var(axis=0, ddof=1) / 16, rtol=1e-9)
