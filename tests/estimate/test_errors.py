"""Errors of means and of ratios: Student's interval, degrees of freedom that add, and the parts of a budget."""

from dataclasses import replace

import numpy as np
import pytest
from ladder_cases import NAME
from scipy import stats

from roughsim.estimate import errors as est
from roughsim.estimate.mean import exact, mean_of
from roughsim.table import Estimate

SHARES = {"bandwidth": 0.02, "pixel": 0.03}


def values_of(
    mean, *, bandwidth=0.0, pixel=0.0, last_step=0.0, finest=None, size=0.0, solver=0.0, **scan
):
    """Values with these other errors at all speeds; `size`, `solver` and `scan` are relative."""
    parts = {"bandwidth": bandwidth, "pixel": pixel, "last step": last_step}
    filled = {name: np.zeros_like(mean.value) + part for name, part in parts.items()}
    finest = mean.value if finest is None else finest
    mean = replace(mean, finest=finest, errors=filled)
    return mean.with_errors(size=size, solver=solver, **scan)


def rows_of(seed, n, mean=10.0, scatter=1.0, speeds=2):
    return mean + scatter * np.random.default_rng(seed).standard_normal((n, speeds))


def students(error, freedom):
    """Half-width of the 95 % interval of a run that stops itself."""
    return stats.t.ppf(0.975, freedom) * np.sqrt(1.0 + 2.0 / freedom) * error


# scatter


def test_independent_streams_have_the_error_and_the_freedom_of_welch():
    first, second = rows_of(1, 9), rows_of(2, 5, scatter=2.0)
    mean = mean_of(0, first) - mean_of(4, second)
    error, freedom = est.spread_of(mean)
    welch = stats.ttest_ind(first, second, equal_var=False)
    np.testing.assert_allclose(mean.value / error, welch.statistic, rtol=1e-12)
    np.testing.assert_allclose(freedom, welch.df, rtol=1e-12)
    np.testing.assert_allclose(est.spread_of(values_of(mean))[1], welch.df, rtol=1e-12)


def test_three_streams_have_satterthwaites_degrees_of_freedom():
    rows = [rows_of(k, n, scatter=s) for k, (n, s) in enumerate(((12, 1.0), (6, 0.5), (4, 2.0)))]
    mean = mean_of(0, rows[0]) + mean_of(1, rows[1]) + mean_of(2, rows[2]) * 0.3
    error, freedom = est.spread_of(mean)
    parts = [
        w**2 * x.var(axis=0, ddof=1) / len(x) for w, x in zip((1.0, 1.0, 0.3), rows, strict=True)
    ]
    worth = sum(parts) ** 2 / sum(
        part**2 / (len(x) - 1) for part, x in zip(parts, rows, strict=True)
    )
    np.testing.assert_allclose(error, np.sqrt(sum(parts)), rtol=1e-12)
    np.testing.assert_allclose(freedom, worth, rtol=1e-12)


def test_a_stream_that_does_not_scatter_takes_no_freedom():
    mean = mean_of(0, rows_of(1, 9)) + mean_of(1, np.full((2, 2), 3.0))
    np.testing.assert_allclose(est.spread_of(mean)[1], 8.0, rtol=1e-12)
    still = mean_of(0, np.full((9, 2), 3.0))
    error, freedom = est.spread_of(still)
    np.testing.assert_array_equal(error, 0.0)
    np.testing.assert_array_equal(freedom, 8.0)


@pytest.mark.parametrize("unit", [1.0, -1e6, 1e-9])
@pytest.mark.parametrize(("step", "agrees"), [(1e-14, True), (1e-10, False)])
def test_agreement_to_all_digits_is_no_scatter_and_more_is(unit, step, agrees):
    rows = unit * (1.0 + step * np.arange(12.0)[:, None])
    assert (est.spread_of(mean_of(0, rows))[0][0] == 0.0) == agrees


def test_one_realization_of_any_stream_leaves_the_error_infinite():
    mean = mean_of(0, rows_of(1, 9)) + mean_of(1, rows_of(2, 1))
    error, freedom = est.spread_of(mean)
    assert np.isinf(error).all()
    np.testing.assert_array_equal(freedom, 0.0)
    assert np.isinf(est.half_width(error, freedom)).all()


def test_plain_rows_have_the_error_of_their_mean():
    rows = rows_of(3, 7)
    error, freedom = est.spread(rows)
    np.testing.assert_allclose(error, stats.sem(rows, axis=0), rtol=1e-12)
    np.testing.assert_array_equal(freedom, 6.0)
    error, freedom = est.spread(np.array([[1.0], [3.0]]))
    assert (error[0], freedom[0]) == (1.0, 1.0)
    error, freedom = est.spread(rows[:1])
    assert np.isinf(error).all()
    np.testing.assert_array_equal(freedom, 0.0)


@pytest.mark.parametrize("freedom", [1.0, 2.5, 11.0, 400.0])
def test_the_quantile_is_students_and_wider_for_runs_that_stop_themselves(freedom):
    assert est.quantile(freedom) == pytest.approx(students(1.0, freedom), rel=1e-9)
    assert est.half_width(np.array([0.3]), np.array([freedom]))[0] == pytest.approx(
        students(0.3, freedom), rel=1e-9
    )


def test_less_than_one_degree_of_freedom_counts_as_one():
    assert est.quantile(0.4) == est.quantile(1.0)


# estimates


def test_an_estimate_has_all_parts_of_its_error():
    rows = rows_of(1, 20)
    mean = mean_of(0, rows)
    scan = np.array([0.05, np.nan])
    beyond = {"size": np.array([0.01, 0.02]), "solver": 2e-4, "scan": scan}
    values = values_of(mean, bandwidth=0.3, pixel=0.4, finest=mean.value + 0.7, **beyond)
    found = est.estimate(NAME, values, ("one note",))
    error = stats.sem(rows, axis=0)
    parts = {
        "statistical": students(error, 19.0),
        "bandwidth": np.full(2, 0.3),
        "pixel": np.full(2, 0.4),
        "size": mean.value * [0.01, 0.02],
        "solver": 2e-4 * mean.value,
        "scan": mean.value * scan,
    }
    assert list(found.budget) == list(parts)
    for name, part in parts.items():
        np.testing.assert_allclose(found.budget[name], part, rtol=1e-9)
    total = np.sqrt(sum(np.nan_to_num(part) ** 2 for part in parts.values()))
    np.testing.assert_allclose(found.total_error, total, rtol=1e-9)
    np.testing.assert_allclose(found.standard_error, error, rtol=1e-12)
    np.testing.assert_allclose(found.half_width, parts["statistical"], rtol=1e-9)
    np.testing.assert_allclose(found.bias, 0.7, rtol=1e-12)
    np.testing.assert_allclose(found.effective_n, 20.0, rtol=1e-12)
    assert (found.n, found.unit, found.notes) == (20, "K", ("one note",))
    assert found.unknown == ("scan",)
    assert [found.unknown_at(k) for k in range(2)] == [(), ("scan",)]


def test_errors_are_not_negative_where_the_mean_is():
    beyond = {"size": 0.01, "solver": 1e-3, "scan": np.full(2, 0.1)}
    values = values_of(
        mean_of(0, -rows_of(1, 20)), bandwidth=0.1, pixel=0.1, last_step=0.1, **beyond
    )
    found = est.estimate("flash_gradient", values)
    ratio = est.quotient(values, values_of(mean_of(0, rows_of(1, 20)), scan=0.0))
    for budget in (found.budget, ratio.budget):
        assert all(np.all(part > 0.0) for name, part in budget.items() if name != "statistical")
    assert np.all(found.half_width > 0.0)


def test_the_number_of_realizations_is_that_of_the_lowest_level():
    mean = mean_of(3, rows_of(1, 20)) + mean_of(0, rows_of(2, 6))
    assert est.estimate(NAME, values_of(mean)).n == 20


def test_the_last_step_counts_where_there_is_one():
    mean = mean_of(0, rows_of(1, 20))
    found = est.estimate(NAME, values_of(mean, bandwidth=np.nan, last_step=np.array([0.0, 2.0])))
    np.testing.assert_allclose(found.budget["last step"], [0.0, 2.0])
    np.testing.assert_allclose(found.total_error[1], np.hypot(found.half_width[1], 2.0), rtol=1e-12)
    assert found.unknown == ("bandwidth",)
    assert "≥" in str(found.number(1))
    assert "last step" not in est.estimate(NAME, values_of(mean)).budget
    assert (
        "the waves above the highest q_c may change more than the last step to it did"
        in found.explain()
    )


def test_at_rest_no_spectrum_changes_what_does_not_heat():
    rows = rows_of(1, 20) * [0.0, 1.0]
    found = est.estimate(NAME, values_of(mean_of(0, rows), scan=np.full(2, np.nan)))
    assert found.budget["scan"][0] == 0.0
    assert np.isnan(found.budget["scan"][1])
    assert found.unknown_at(0) == ()


def test_an_area_of_which_nothing_is_there_has_no_unknown_error():
    found = est.estimate("plastic_fraction", values_of(mean_of(0, np.zeros((12, 1))), pixel=np.nan))
    assert (found.unknown, found.unknown_at(0)) == ((), ())
    assert "unknown" not in found.explain()


def test_a_part_is_unknown_where_no_level_shows_it_but_not_where_the_mean_itself_is_infinite():
    rows = np.column_stack([np.full(12, np.inf), rows_of(1, 12)[:, 0]])
    values = values_of(mean_of(0, rows), bandwidth=np.nan, size=0.01)
    found = est.estimate("slope_length", values)
    assert found.unknown == ("bandwidth",)
    np.testing.assert_allclose(
        found.total_error[1], np.hypot(found.half_width[1], 0.01 * found.mean[1]), rtol=1e-12
    )


def test_an_estimate_explains_itself():
    found = est.estimate(
        NAME, values_of(mean_of(0, rows_of(1, 20)), pixel=np.nan, size=0.01), ("one note",)
    )
    text = found.explain()
    assert text.startswith(f"{NAME}:\n")
    assert "n = 20 realizations of the lowest level; interval with 19 degrees of freedom" in text
    assert "size: change by a larger cell" in text
    assert "pixel: unknown: no level of the run shows it; not in these figures" in text
    assert "one note" in text
    cut = est.estimate(NAME, values_of(mean_of(0, rows_of(1, 20)), bandwidth=np.nan)).explain()
    assert "bandwidth: unknown: no level of the run shows it; not in these figures" in cut
    few = replace(
        found, budget={**found.budget, "statistical": np.full_like(found.mean, np.nan)}
    ).explain()
    assert "statistical: unknown: too few realizations show it; not in these figures" in few


def test_errors_are_told_in_the_unit_of_the_mean():
    # 10 ± 0.3 µm, and 2 µm less at the finest level
    rows = 1e-6 * np.full((6, 1), 10.0)
    values = values_of(mean_of(0, rows), pixel=3e-7, finest=np.array([8e-6]))
    line = est.estimate("correlation_radius_50", values).explain().splitlines()[1]
    assert line.startswith("10.00 ± 0.30 µm: statistical 0, bandwidth 0, pixel 0.3, ")
    assert line.endswith("value at the finest level -2")


def test_the_table_of_an_estimate_has_a_column_for_each_part_and_a_row_for_each_speed():
    values = values_of(mean_of(0, rows_of(1, 20)), bandwidth=0.3, pixel=0.4)
    found = est.estimate(NAME, replace(values, finest=values.value - 0.9))
    table = found.table()
    assert [column.title for column in table.columns] == [
        "mean ± total error",
        *found.budget,
        "finest − mean",
    ]
    for k, row in enumerate(table.rows):
        assert row[0].value == found.mean[k]
        assert row[0].error == found.total_error[k]
        assert [cell.value for cell in row[1:]] == pytest.approx(
            [*(part[k] for part in found.budget.values()), -0.9]
        )
    named = replace(found, coords={"speed": np.array([0.5, 2.0])})
    assert [row[0] for row in named.table().rows] == ["0.5", "2"]
    row = found.row((0,), ("scan", "pixel"))
    assert [row[title].value for title in ("scan", "pixel", "finest − mean")] == pytest.approx(
        [0.0, 0.4, -0.9]
    )


def test_what_is_exactly_zero_or_undefined_has_no_unknown_error():
    means = np.array([0.0, 2.0, np.nan])
    budget = {"statistical": np.array([0.0, 0.3, 0.0]), "scan": np.full(3, np.nan)}
    found = Estimate.of(NAME, "K", means, {"speed": np.arange(3.0)}, budget)
    assert [found.unknown_at(k) for k in range(3)] == [(), ("scan",), ()]
    np.testing.assert_array_equal(found.total_error, [0.0, 0.3, np.nan])


# ratios


def test_a_ratio_has_the_errors_of_both_columns_but_for_the_scatter_that_they_share():
    mean = mean_of(0, rows_of(8, 40, 4.0, 0.4))
    below = values_of(
        mean, bandwidth=0.02 * mean.value, pixel=0.03 * mean.value, size=0.001, solver=2e-4
    )
    above = values_of(mean * 0.5, bandwidth=0.01 * mean.value, size=0.002, solver=2e-4)
    found = est.quotient(above, below, size=0.003)
    expected = {
        "statistical": 0.0,
        "bandwidth": 0.5 * np.hypot(0.02, 0.02),
        "pixel": 0.5 * 0.03,
        "size": 0.5 * np.sqrt(0.001**2 + 0.002**2 + 0.003**2),
        "solver": 0.5 * 2e-4 * np.sqrt(2.0),
    }
    assert list(found.budget) == list(expected)
    np.testing.assert_allclose(found.mean, 0.5, rtol=1e-12)
    for name, part in expected.items():
        np.testing.assert_allclose(found.budget[name], part, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(found.total_error, np.linalg.norm([*expected.values()]), rtol=1e-9)


def test_a_ratio_pairs_surfaces_and_adds_the_scatter_of_levels_that_are_not_shared():
    common, fine = rows_of(1, 12, 8.0), rows_of(2, 6, 1.0, 0.2)
    above_rows = 1.5 * common + rows_of(3, 12, 0.0, 0.1)
    above = values_of(mean_of(0, above_rows) + mean_of(3, fine))
    found = est.quotient(above, values_of(mean_of(0, common)))
    b = common.mean(axis=0)
    ratio = (above_rows.mean(axis=0) + fine.mean(axis=0)) / b
    parts = [
        (above_rows - ratio * common).var(axis=0, ddof=1) / 12 / b**2,
        fine.var(axis=0, ddof=1) / 6 / b**2,
    ]
    np.testing.assert_allclose(found.mean, ratio, rtol=1e-12)
    np.testing.assert_allclose(found.standard_error, np.sqrt(sum(parts)), rtol=1e-9)
    freedom = sum(parts) ** 2 / (parts[0] ** 2 / 11 + parts[1] ** 2 / 5)
    np.testing.assert_allclose(
        found.budget["statistical"], students(np.sqrt(sum(parts)), freedom), rtol=1e-9
    )


def test_a_ratio_to_exact_values_of_the_same_modes_has_no_bandwidth_error():
    rows = rows_of(8, 40, 4.0, 0.4)
    above = values_of(mean_of(0, rows), bandwidth=np.nan, pixel=0.08, last_step=1.0, solver=1e-3)
    found = est.quotient(above, np.array([2.0, 8.0]), size=np.array([0.01, 0.0]))
    np.testing.assert_allclose(found.mean, rows.mean(axis=0) / [2.0, 8.0], rtol=1e-12)
    np.testing.assert_allclose(
        found.standard_error, stats.sem(rows, axis=0) / [2.0, 8.0], rtol=1e-9
    )
    np.testing.assert_array_equal(found.budget["bandwidth"], 0.0)
    assert "last step" not in found.budget
    assert found.unknown_at(0) == ()
    np.testing.assert_allclose(found.budget["pixel"], [0.04, 0.01], rtol=1e-12)
    np.testing.assert_allclose(found.budget["size"], found.mean * [0.01, 0.0], rtol=1e-12)
    np.testing.assert_allclose(found.budget["solver"], found.mean * 1e-3, rtol=1e-12)
    one = est.quotient(above, np.array([2.0]))  # one value for all speeds
    np.testing.assert_allclose(one.mean, rows.mean(axis=0) / 2.0, rtol=1e-12)


def test_a_ratio_has_the_last_steps_of_both_columns():
    above = values_of(mean_of(0, np.full((6, 1), 40.0)), bandwidth=np.nan, last_step=14.0)
    below = values_of(mean_of(0, np.full((6, 1), 20.0)), bandwidth=np.nan, last_step=1.0)
    found = est.quotient(above, below)
    assert found.budget["last step"][0] == pytest.approx(2.0 * np.hypot(14.0 / 40.0, 1.0 / 20.0))
    still = replace(below, errors={**below.errors, "last step": np.zeros(1)})
    assert est.quotient(above, still).budget["last step"][0] == pytest.approx(14.0 / 20.0)
    at_one_speed = values_of(mean_of(0, np.full((6, 2), 40.0)), last_step=np.array([0.0, 14.0]))
    found = est.quotient(at_one_speed, values_of(mean_of(0, np.full((6, 2), 20.0))))
    np.testing.assert_allclose(found.budget["last step"], [0.0, 14.0 / 20.0])


def test_what_one_column_does_not_know_the_ratio_does_not_know():
    above = values_of(mean_of(0, rows_of(1, 9)), bandwidth=np.nan, pixel=0.1)
    below = values_of(mean_of(0, rows_of(2, 9)), bandwidth=0.2, pixel=0.1)
    for pair in ((above, below), (below, above)):
        assert est.quotient(*pair).unknown_at(0) == ("bandwidth",)
    assert est.quotient(below, np.ones(2), scanned=True).unknown_at(0) == ("scan",)
    assert "scan" not in est.quotient(below, below).budget


def test_no_realization_of_plastic_area_has_no_ratio():
    none = values_of(mean_of(0, np.zeros((12, 1))))
    assert np.isnan(est.quotient(none, np.array([0.0])).mean[0])
    assert np.isnan(est.quotient(none, np.array([0.4])).mean[0])
    at_rest = values_of(mean_of(0, rows_of(1, 9) * [0.0, 1.0]))
    found = est.quotient(at_rest, at_rest)  # at rest alone there is none
    assert np.isnan(found.mean[0])
    assert found.mean[1] == pytest.approx(1.0)


@pytest.mark.statistical
def test_intervals_of_three_streams_hold_the_mean_as_often_as_they_say():
    rng, trials = np.random.default_rng(3), 20_000
    mean = exact(np.zeros(trials))
    for stream, (n, scatter) in enumerate(((12, 1.0), (6, 0.7), (6, 0.4))):
        mean += mean_of(stream, scatter * rng.standard_normal((n, trials)))
    error, freedom = est.spread_of(mean)
    held = np.mean(np.abs(mean.value) <= stats.t.ppf(0.975, freedom) * error)
    assert abs(held - 0.95) < 0.01 + 3.0 * np.sqrt(
        0.05 * 0.95 / trials
    )  # Satterthwaite's freedom is not exact


def test_a_product_has_all_parts_of_both_factors():
    # 10 ± (.3 and .2) times 4 ± (.1 and .5): to first order 4·.3 + 10·.1 and so on
    first, second = (mean_of(0, np.full((4, 1), mean)) for mean in (10.0, 4.0))
    first = replace(first, errors={"bandwidth": 0.3, "tail": 0.2})
    second = replace(second, errors={"bandwidth": 0.1, "scan": 0.5})
    for both in (first * second, second * first):
        assert both.value == pytest.approx(40.0)
        found = {name: float(part[0]) for name, part in both.errors.items()}
        assert found == pytest.approx({"bandwidth": 2.2, "tail": 0.8, "scan": 5.0})
