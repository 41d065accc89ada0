"""Regression on peak volumes: slopes of all other realizations, no bias, and what is left alone."""

import numpy as np
import pytest
from scipy import stats

from roughsim.estimate.errors import estimate, looks, quotient, relative_half_width, spread
from roughsim.estimate.ladder import observe
from roughsim.estimate.regression import LEAST_FITTED, at_mean_peak_volume, scatter_at_mean_peak_volume
from roughsim.observables.record import Sample

NAME = "flash_temperature"


def numbers(*controls):
    """Numbers of members with the first, or both, of the controls."""
    return dict(zip(("peak_volume", "long_peak_volume"), controls, strict=False))


@pytest.mark.parametrize("count", [1, 2])
def test_each_row_is_corrected_with_the_slopes_of_all_others(count):
    rng = np.random.default_rng(1)
    controls = rng.standard_normal((count, 13)) * [[1e-3], [20.0]][:count]
    values = np.array([10.0, 200.0]) + (controls.T @ [[3e3, -0.5], [0.2, 0.1]][:count]) + rng.standard_normal((13, 2))
    expected = np.empty_like(values)
    for i in range(13):
        others = np.arange(13) != i
        design = np.column_stack((np.ones(12), controls[:, others].T))
        slopes = np.linalg.lstsq(design, values[others], rcond=None)[0][1:]
        expected[i] = values[i] - controls[:, i] @ slopes
    np.testing.assert_allclose(at_mean_peak_volume(values, numbers(*controls)), expected, rtol=1e-9)
    columns = numbers(*controls[:, :, None])
    np.testing.assert_allclose(at_mean_peak_volume(values, columns), expected, rtol=1e-9)


def test_values_on_a_plane_have_no_scatter_left_and_the_value_at_zero():
    first, second = np.linspace(-0.2, 0.5, 12), np.linspace(-1.0, 1.0, 12) ** 2
    values = 7.0 + np.outer(first, [2.0, -4.0]) + np.outer(second, [0.3, 5.0])
    np.testing.assert_allclose(at_mean_peak_volume(values, numbers(first, second)), 7.0, rtol=1e-12)
    np.testing.assert_allclose(scatter_at_mean_peak_volume(values, numbers(first, second)), 0.0, atol=1e-12)


def test_few_rows_and_rows_without_a_peak_volume_stay_to_the_bit():
    values = np.random.default_rng(2).standard_normal((12, 3))
    volumes = np.random.default_rng(3).standard_normal(12)
    few = LEAST_FITTED - 1
    np.testing.assert_array_equal(at_mean_peak_volume(values[:few], numbers(volumes[:few])), values[:few])
    assert not np.any(at_mean_peak_volume(values[: few + 1], numbers(volumes[: few + 1])) == values[: few + 1])
    np.testing.assert_array_equal(at_mean_peak_volume(values, {}), values)
    for unknown in (np.full(12, np.nan), np.zeros(12), np.full((12, 1), np.nan)):
        np.testing.assert_array_equal(at_mean_peak_volume(values, numbers(unknown)), values)
    # no slope can be told, and none from one row alone
    np.testing.assert_array_equal(at_mean_peak_volume(values, numbers(np.full(12, 0.3))), values)
    np.testing.assert_allclose(at_mean_peak_volume(values, numbers(np.eye(12)[3])), values, rtol=1e-12)


def test_a_control_that_the_other_makes_up_changes_nothing():
    rng = np.random.default_rng(12)
    values, volumes = rng.standard_normal((14, 2)), rng.standard_normal(14)
    alone = at_mean_peak_volume(values, numbers(volumes))
    np.testing.assert_allclose(at_mean_peak_volume(values, numbers(volumes, -3.0 * volumes)), alone, rtol=1e-9)


def test_rows_of_an_older_run_count_as_they_are():
    values = np.random.default_rng(4).standard_normal((20, 1))
    volumes = np.random.default_rng(5).standard_normal(20)
    volumes[:10] = np.nan
    mixed = at_mean_peak_volume(values, numbers(volumes))
    np.testing.assert_array_equal(mixed[:10], values[:10])
    assert not np.any(mixed[10:] == values[10:])


def test_infinite_and_undefined_values_stay():
    values = np.ones((10, 3)) * [np.inf, np.nan, 1.0]
    changed = at_mean_peak_volume(values, numbers(np.linspace(-1, 1, 10)))
    np.testing.assert_array_equal(changed, values)


@pytest.mark.statistical
def test_the_scatter_that_is_left_is_that_of_many_rows():
    # of 12 rows it is right in the mean; their own scatter with the slopes of others would be a third larger
    rng, squares = np.random.default_rng(13), []
    for _ in range(3000):
        controls = rng.standard_normal((2, 12))
        values = (controls[0] - controls[1] + 0.5 * rng.standard_normal(12))[:, None]
        squares.append(float(scatter_at_mean_peak_volume(values, numbers(*controls))[0]) ** 2)
    assert abs(np.mean(squares) - 0.25) < 4 * np.std(squares) / np.sqrt(3000)


@pytest.mark.statistical
def test_nothing_is_biased_where_a_common_slope_would_be():
    # Y = s² has the mean 1. The slope of all rows is correlated with their s: the mean at zero would be 1 − 2/n
    rng, n, own, common = np.random.default_rng(6), 12, [], []
    for _ in range(4000):
        s = rng.standard_normal(n)
        own.append(at_mean_peak_volume((s * s)[:, None], numbers(s)).mean())
        common.append(np.polyfit(s, s * s, 1)[1])
    error = np.std(own) / np.sqrt(len(own))
    assert abs(np.mean(own) - 1.0) < 4 * error
    assert np.mean(common) < 1.0 - 6 * error


def member_level(values, controls, q_max=1.0, every=1):
    """A level with both controls of its realizations, (2, n)."""
    rows = np.arange(0, len(values), every)
    stored = {NAME: values[rows], **numbers(*controls[:, rows])}
    return Sample(q_max, 64.0 * q_max, rows, stored, np.ones(1), np.ones((len(rows), 1)), 1.0)


def by_others(values, controls):
    """Each row, of one speed, with the slopes of all others: least squares written out."""
    n = len(values)
    result = np.empty(n)
    for i in range(n):
        others = np.arange(n) != i
        design = np.column_stack((np.ones(n - 1), controls[:, others].T))
        result[i] = values[i, 0] - np.linalg.lstsq(design, values[others, 0], rcond=None)[0][1:] @ controls[:, i]
    return result


def students(rows, lost):
    """Half-width of a mean of rows with n − 1 − lost degrees of freedom, wider for runs that stop themselves."""
    freedom = len(rows) - 1 - lost
    return stats.t.ppf(0.975, freedom) * np.sqrt(1 + 2 / freedom) * stats.sem(rows)


def test_each_fitted_slope_costs_an_interval_a_degree_of_freedom():
    rng = np.random.default_rng(20)
    controls = rng.standard_normal((2, 14))
    values = 8.0 + (controls.sum(axis=0) + rng.standard_normal(14))[:, None]
    first, twice, known = controls[:1], np.stack([controls[0], -2.0 * controls[0]]), np.zeros((2, 14))
    for x, used, lost in ((controls, controls, 2), (first, first, 1), (twice, first, 1), (known, known[:0], 0)):
        seen = observe(NAME, [member_level(values, x)], capped=True, end=1.0)
        expected = students(by_others(values, used), lost)
        assert estimate(NAME, seen).half_width[0] == pytest.approx(expected, rel=1e-9)
        assert relative_half_width(seen) == pytest.approx(expected / by_others(values, used).mean(), rel=1e-9)
    few = observe(NAME, [member_level(values[:9], controls[:, :9])], capped=True, end=1.0)
    assert estimate(NAME, few).half_width[0] == pytest.approx(students(values[:9, 0], 0), rel=1e-9)


def test_a_ratio_loses_the_slopes_of_its_columns():
    # the influence of row i on ⟨a⟩/⟨b⟩ is (a_i − (⟨a⟩/⟨b⟩) b_i)/⟨b⟩: the two columns have the same surfaces
    rng = np.random.default_rng(21)
    controls = rng.standard_normal((2, 15))
    columns = [8.0 + (controls.T @ slopes + 0.3 * rng.standard_normal(15))[:, None] for slopes in ([1, 1], [2, -1])]
    above, below = (by_others(values, controls) for values in columns)
    of_columns = [observe(NAME, [member_level(values, controls)], capped=True, end=1.0) for values in columns]
    expected = students((above - above.mean() / below.mean() * below) / below.mean(), 2)
    plain = observe(NAME, [member_level(columns[1], np.zeros((2, 15)))], capped=True, end=1.0)
    assert quotient(*of_columns).budget["statistical"][0] == pytest.approx(expected, rel=1e-9)
    exact = quotient(of_columns[0], np.array([4.0])).budget["statistical"][0]
    assert exact == pytest.approx(students(above, 2) / 4.0, rel=1e-9)
    rows, many = columns[1][:, 0], columns[1].mean()  # one column alone has slopes
    expected = students((above - above.mean() / many * rows) / many, 2)
    assert quotient(of_columns[0], plain).budget["statistical"][0] == pytest.approx(expected, rel=1e-9)
    expected = students((rows - many / above.mean() * above) / above.mean(), 2)
    assert quotient(plain, of_columns[0]).budget["statistical"][0] == pytest.approx(expected, rel=1e-9)


def test_corrections_keep_their_degrees_of_freedom():
    # corrections of every second row that do not scatter with the coarsest level: Satterthwaite of n − 3 and n/2 − 1
    rng = np.random.default_rng(22)
    controls = rng.standard_normal((2, 16))
    base = 50.0 + (controls.sum(axis=0) + rng.standard_normal(16))[:, None]
    coarse = by_others(base, controls)
    design = np.column_stack((np.ones(8), coarse[::2]))
    noise = rng.standard_normal(8)
    noise -= design @ np.linalg.lstsq(design, noise, rcond=None)[0]
    fine = base.copy()
    fine[::2, 0] += 3.0 * noise - 1.0
    levels = [member_level(base, controls), member_level(fine, controls, 2.0, 2)]
    found = estimate(NAME, observe(NAME, levels, capped=False, end=2.0))
    shared, added = coarse.var(ddof=1) / 16, 9.0 * noise.var(ddof=1) / 8
    # the slope of the corrections over the coarsest level is known from 8 rows, and the mean of 16 moves with it
    doubt = shared**2 / 13 + (added**2 + 2.0 * (coarse.var(ddof=1) / 16) * added * 8 / 16) / 7
    assert found.standard_error[0] == pytest.approx(np.sqrt(shared + added), rel=1e-9)
    assert found.effective_n[0] - 1.0 == pytest.approx((shared + added) ** 2 / doubt, rel=1e-9)


def test_corrections_add_no_degrees_of_freedom_to_those_of_the_coarsest_level():
    # two independent parts of 13 and 7 degrees, with variances in that ratio, would be worth 20 of them
    base, added = np.zeros((16, 1)), np.zeros((16, 1))
    base[:, 0] = np.sqrt(13.0) * stats.zscore(np.arange(16.0), ddof=1)
    added[::2, 0] = np.sqrt(16.0**2 / 8.0 * 7.0 / 16.0) * stats.zscore(np.arange(8.0) ** 2, ddof=1)
    error, freedom = spread(base + added, base, np.tile([1, 0], 8), independent=True, slopes=2)
    assert error[0] == pytest.approx(np.sqrt(20.0 / 16.0), rel=1e-12)
    assert freedom[0] == pytest.approx(13.0, rel=1e-12)


@pytest.mark.statistical
@pytest.mark.slow
@pytest.mark.parametrize("worth", [12, 18, 30])
def test_runs_that_stop_themselves_hold_the_mean_in_95_percent(worth):
    # three quarters of the variance follow two controls; the rest alone, of one unit, meets the goal with `worth` rows
    rng, held, ratios = np.random.default_rng(23), [], []
    goal = 1.96 / np.sqrt(worth) / 1000.0
    for _ in range(1500):
        x = rng.standard_normal((2, 4 * worth + 20))
        noise = rng.standard_normal((2, x.shape[1]))
        above, below = 1000.0 + (np.sqrt(1.5) * x.sum(axis=0) + noise)[:, :, None]

        def seen(values, n, x=x):
            return observe(NAME, [member_level(values[:n], x[:, :n])], capped=True, end=1.0)

        n = next(n for n in looks(12, x.shape[1]) if relative_half_width(seen(above, n)) <= goal)
        found, between = estimate(NAME, seen(above, n)), quotient(seen(above, n), seen(below, n))
        held.append(abs(found.mean[0] - 1000.0) <= found.half_width[0])
        ratios.append(abs(between.mean[0] - 1.0) <= between.budget["statistical"][0])
    for share in (np.mean(held), np.mean(ratios)):
        assert 0.94 - 2 * 0.0056 < share < 0.96 + 2 * 0.0056 + 0.1 / worth  # standard errors; wider intervals of few


@pytest.mark.statistical
@pytest.mark.parametrize("n", [10, 12, 24])
@pytest.mark.slow
def test_intervals_hold_the_mean_as_often_as_they_say(n):
    # 80 % of the variance follows the peak volume; the half-width is Student's, times √(1 + 2/f)
    rng, held, width = np.random.default_rng(7), 0, []
    for _ in range(3000):
        s = rng.standard_normal((n, 1))
        values = 5.0 + np.sqrt(0.8) * s + np.sqrt(0.2) * rng.standard_normal((n, 1))
        found = estimate(NAME, observe(NAME, [sample(values, s)], capped=True, end=1.0))
        held += abs(found.mean[0] - 5.0) <= found.half_width[0]
        width.append(found.standard_error[0] * np.sqrt(n))
    assert 0.94 < held / 3000 < 0.98
    assert np.sqrt(0.2) < np.mean(width) < np.sqrt(0.2) * (1 + 1.5 / n)


def sample(values, volumes, q_max=1.0, every=1):
    rows = np.arange(0, len(values), every)
    stored = {NAME: values[rows], "peak_volume": volumes[rows]}
    return Sample(q_max, 64.0 * q_max, rows, stored, np.ones(1), np.ones((len(rows), 1)), 1.0)


def test_the_coarsest_level_is_at_the_mean_peak_volume_and_the_corrections_are_as_they_are():
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


def test_levels_without_a_peak_volume_are_read_as_they_are():
    values = np.random.default_rng(9).standard_normal((12, 2)) + 50.0
    plain = Sample(1.0, 64.0, np.arange(12), {NAME: values}, np.ones(1), np.ones((12, 1)), 1.0)
    np.testing.assert_array_equal(observe(NAME, [plain], capped=True, end=1.0).extrapolated, values)
