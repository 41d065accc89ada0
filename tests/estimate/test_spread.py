"""The error of rows of which only some have the finer levels, and of quotients of such columns."""

import numpy as np
import pytest
from ladder_cases import values_of
from scipy import stats

from roughsim.estimate import errors as est
from roughsim.estimate.errors import relative_half_width
from roughsim.estimate.ladder import observe
from roughsim.observables.record import Sample, ratio

RADII = {"correlation_radius_50": 0.5, "correlation_radius_10": 0.1, "correlation_radius_0": 0.0}


def by_hand(base, added, few):
    """Variance of b̄ + c̄ with c known for the first `few` of n rows, and its worth: the formulas written out once."""
    n, s = len(base), base.std(ddof=1)
    along, beside = np.polyfit(base[:few], added, 1)[0], added.var(ddof=1)
    r = along * base[:few].std(ddof=1) / np.sqrt(beside)
    slope, left = r * np.sqrt(beside) / s, (1 - r**2) * beside  # c = slope·b + rest
    shared, rest = s**2 * (1 / n + slope**2 / few + 2 * slope / n), left / few
    doubt = shared**2 / (n - 1) + (rest**2 + 2 * s**2 * left * (1 / n + slope / few) ** 2) / (few - 1)
    return shared + rest, (shared + rest) ** 2 / doubt


@pytest.mark.parametrize("slope", [-0.8, 0.0, 0.5])
def test_the_coarsest_level_scatters_alike_in_all_rows_and_fine_ones_add_to_few(slope):
    rng = np.random.default_rng(7)
    base = 3.0 * rng.standard_normal(30)
    added = slope * base[:6] + rng.standard_normal(6)
    rows = base + added.mean()
    rows[:6] += 30 / 6 * (added - added.mean())
    group = np.repeat([4, 0], [6, 24])
    error, freedom = est.spread(rows[:, None], (base + added.mean())[:, None], group)
    variance, worth = by_hand(base, added, 6)
    assert error[0] == pytest.approx(np.sqrt(variance), rel=1e-12)
    assert freedom[0] == pytest.approx(min(worth, 29.0), rel=1e-12)
    one = np.repeat([4, 0], [1, 29])
    assert est.spread(rows[:, None], base[:, None], one)[0][0] == np.inf  # one row tells nothing of its scatter


def test_where_all_rows_have_all_levels_the_coarsest_is_no_matter():
    rng = np.random.default_rng(8)
    rows, base = rng.standard_normal((2, 15, 2))
    for group in (None, np.full(15, 2)):
        error, freedom = est.spread(rows, base, group)
        np.testing.assert_allclose(error, stats.sem(rows, axis=0), rtol=1e-12)
        np.testing.assert_allclose(freedom, 14.0, rtol=1e-12)


def test_two_strides_add_up():
    # what three groups add to a common level that does not scatter: variances of their own means, weighted
    rng = np.random.default_rng(9)
    group = np.repeat([0, 1, 2], [12, 6, 6])
    added = rng.standard_normal((24, 1)) * np.array([0.0, 1.0, 3.0])[group][:, None]
    error, freedom = est.spread(5.0 + added, np.full((24, 1), 5.0), group)
    parts = [6 * added[group == k].var(ddof=1) / 24**2 for k in (1, 2)]
    assert error[0] == pytest.approx(np.sqrt(sum(parts)), rel=1e-12)
    assert freedom[0] == pytest.approx(sum(parts) ** 2 / (parts[0] ** 2 / 5 + parts[1] ** 2 / 5), rel=1e-12)


def strided(rng, n, every, scatter):
    """Values of a column whose finer level is known for every n-th row; the rows of both levels beside them."""
    coarse = 10.0 + rng.standard_normal((n, 1))
    fine = coarse - 1.0 + scatter * rng.standard_normal((n, 1))
    at = np.arange(0, n, every)
    none = np.ones((n, 1))
    samples = [
        Sample(q, 64.0, rows, {"flash_temperature": values[rows]}, np.ones(1), none[rows], 1.0)
        for q, rows, values in ((1.0, np.arange(n), coarse), (2.0, at, fine))
    ]
    return observe("flash_temperature", samples, capped=True, end=2.0), coarse, fine[at], at


def test_a_quotient_keeps_what_two_strided_columns_have_in_common():
    rng = np.random.default_rng(5)
    above, coarse, fine, at = strided(rng, 48, 4, 0.1)
    own = observe(
        "flash_temperature",
        [
            Sample(q, 64.0, rows, {"flash_temperature": 2.0 * values}, np.ones(1), np.ones((len(rows), 1)), 1.0)
            for q, rows, values in ((1.0, np.arange(48), coarse), (2.0, at, fine))
        ],
        capped=True,
        end=2.0,
    )
    found = est.quotient(above, own)
    value, error = found.mean, found.standard_error
    assert value[0] == pytest.approx(0.5, rel=1e-12)
    assert error[0] == pytest.approx(0.0, abs=1e-12)
    found = est.quotient(above, np.array([4.0]))
    value, error = found.mean, found.standard_error
    assert value[0] == pytest.approx(above.extrapolated.mean() / 4.0, rel=1e-12)
    assert error[0] == pytest.approx(est.spread(above.extrapolated, above.base, above.group)[0][0] / 4.0, rel=1e-12)


@pytest.mark.statistical
def test_the_error_of_a_quotient_is_its_scatter_over_many_runs():
    rng = np.random.default_rng(6)
    told = []
    for _ in range(600):
        above, coarse, _, _ = strided(rng, 24, 4, 0.6)
        below = values_of(coarse + 0.5 * rng.standard_normal((24, 1)))
        found = est.quotient(above, below)
        told.append([found.mean[0], found.standard_error[0]])
    values, errors = np.array(told).T
    # 1/√1200 = 3 % is the relative error of the left side
    assert values.std() == pytest.approx(np.sqrt((errors**2).mean()), rel=0.1)


def test_a_run_does_not_stop_while_two_fine_realizations_may_agree_by_chance():
    rng = np.random.default_rng(12)
    for n, enough in ((16, False), (17, True)):  # the third of every eighth comes with the 17th
        values, *_ = strided(rng, n, 8, 1e-6)
        assert np.isfinite(relative_half_width(values)) is np.bool_(enough)


def test_a_quotient_tells_rows_apart_by_the_levels_of_both_columns():
    rng = np.random.default_rng(15)
    above, *_ = strided(rng, 24, 2, 3.0)
    below, *_ = strided(rng, 24, 3, 0.01)  # in some rows the one has its fine level, in others the other
    error = est.quotient(above, below).standard_error
    pattern = np.arange(24) % 2 * 2 + (np.arange(24) % 3 > 0)  # 3: neither has it
    group = np.array([3, 1, 2, 0])[pattern]
    rows, base = ratio(above.extrapolated, below.extrapolated), ratio(above.base, below.base)
    assert error[0] == pytest.approx(est.spread(rows, base, group)[0][0], rel=1e-12)


def test_no_realization_of_plastic_area_has_no_quotient():
    none = values_of(np.zeros((12, 1)))
    assert np.isnan(est.quotient(none, np.array([0.0])).mean[0])
