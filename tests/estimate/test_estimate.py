"""Estimates: means, errors, extrapolation and stopping, against closed forms and a plain jackknife."""

from dataclasses import replace

import numpy as np
import pytest
from ladder_cases import values_of
from scipy import special, stats

from roughsim.estimate import errors as est
from roughsim.estimate.continuation import fitted_exponent
from roughsim.estimate.errors import relative_half_width
from roughsim.estimate.ladder import NO_LIMIT, Values, observe
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.observables.record import Sample, ratio

RADII = {"correlation_radius_50": 0.5, "correlation_radius_10": 0.1, "correlation_radius_0": 0.0}


def sample(q_max=1.0, n=20, seed=0, speeds=2, shift=0.0):
    rng = np.random.default_rng(seed)
    numbers = {
        "flash_temperature": 10.0 + rng.standard_normal((n, speeds)) + shift,
        "flash_gradient": -3.0 + 0.2 * rng.standard_normal((n, speeds)),
        "flash_laplacian": -5.0 + 0.3 * rng.standard_normal((n, speeds)),
        "resting_flash_temperature": 20.0 + rng.standard_normal((n, speeds)),
        "contact_fraction": 0.1 + 0.01 * rng.standard_normal((n, 1)),
        "plastic_fraction": np.zeros((n, 1)),
        "pressure_variance": 2.0 + 0.1 * rng.standard_normal((n, 1)),
    }
    q = np.linspace(1.0, 20.0, 60)
    spectrum = q**-2 * rng.uniform(0.8, 1.2, (n, 60))
    return Sample(q_max, 16.0 * q_max, np.arange(n), numbers, q, spectrum, 20.0)


def jackknife(statistic, n):
    """Standard error of a statistic of rows by leaving one out."""
    left_out = np.array([statistic(np.delete(np.arange(n), i)) for i in range(n)])
    return np.sqrt((n - 1) * np.mean((left_out - left_out.mean(axis=0)) ** 2, axis=0))


def test_a_mean_has_students_interval_and_two_degrees_of_freedom_for_having_stopped():
    data = sample()
    found = est.estimate("flash_temperature", observe("flash_temperature", [data], capped=False))
    rows = data.numbers["flash_temperature"]
    interval = stats.t.interval(0.95, 19, rows.mean(axis=0), stats.sem(rows, axis=0) * np.sqrt(21 / 19))
    np.testing.assert_allclose(found.mean - found.half_width, interval[0], rtol=1e-12)
    np.testing.assert_allclose(found.mean + found.half_width, interval[1], rtol=1e-12)
    np.testing.assert_array_equal(found.bias, 0.0)
    np.testing.assert_allclose(found.total_error, found.half_width)
    assert found.n == 20


def test_two_realizations_have_an_error_of_one_degree_of_freedom_and_one_has_none():
    values = np.array([[1.0, 5.0], [3.0, 5.5]])
    error, freedom = est.spread(values)
    np.testing.assert_allclose(error, [1.0, 0.25])
    np.testing.assert_allclose(freedom, 1.0)
    assert np.isinf(est.spread(values[:1])[0]).all()


def test_a_ladder_that_reaches_the_end_of_the_spectrum_is_not_extrapolated():
    ladder = [sample(q_max, shift=-1.0 / q_max) for q_max in (1.0, 2.0, 4.0)]
    found = observe("flash_temperature", ladder, capped=True, end=4.0)
    assert np.isnan(found.exponent).all()
    np.testing.assert_array_equal(found.bandwidth, 0.0)
    assert np.isfinite(observe("flash_temperature", ladder, capped=True, end=5.0).exponent).all()


def test_observables_converge_and_end_at_rest_as_measured():
    orders = {
        "flash_temperature": (2.0, 1.4),
        "flash_gradient": (2.0, 0.8),
        "flash_laplacian": (0.7, 0.7),
        "flash_width": (0.7, 0.7),
        "contact_fraction": (1.0, 1.0),
        "plastic_fraction": (2.0, 1.0),
        "pressure_variance": (2.0, 1.0),
    }
    assert {name: OBSERVABLES[name].pixel_orders for name in orders} == orders
    rest = {"flash_temperature": 0.0, "flash_gradient": 0.0, "flash_laplacian": 0.0, "slope_length": np.inf}
    assert {name: OBSERVABLES[name].at_rest for name in rest} == rest


DERIVED = {
    "flash_width": lambda m: np.sqrt(-m["flash_temperature"] / m["flash_laplacian"]),
    "slope_length": lambda m: -m["flash_temperature"] / m["flash_gradient"],
    "heat_partition": lambda m: (
        m["resting_flash_temperature"] / (m["resting_flash_temperature"] + m["flash_temperature"])
    ),
}


@pytest.mark.parametrize("name", DERIVED)
def test_ratios_of_means_have_the_error_of_a_jackknife(name):
    data = sample(n=60)
    found = est.estimate(name, observe(name, [data], capped=False))

    def statistic(rows):
        return DERIVED[name]({key: values[rows].mean(axis=0) for key, values in data.numbers.items()})

    np.testing.assert_allclose(found.mean, statistic(np.arange(60)), rtol=1e-12)
    np.testing.assert_allclose(found.standard_error, jackknife(statistic, 60), rtol=0.03)


@pytest.mark.parametrize(("name", "fraction"), RADII.items())
def test_correlation_radii_have_the_error_of_a_jackknife(name, fraction):
    data = sample(n=40)
    found = est.estimate(name, observe(name, [data], capped=False))

    def statistic(rows):
        mean = data.spectrum[rows].mean(axis=0)
        r = np.linspace(0.0, 5.0, 5001)
        curve = mean @ special.j0(np.multiply.outer(data.wavenumber, r)) / mean.sum() - fraction
        k = int(np.argmax(curve <= 0.0))
        return r[k - 1] + 1e-3 * curve[k - 1] / (curve[k - 1] - curve[k])

    assert found.mean[0] == pytest.approx(statistic(np.arange(40)), rel=1e-5)  # of the secant
    assert found.standard_error[0] == pytest.approx(jackknife(statistic, 40), rel=0.05)


def test_two_cut_offs_extrapolate_one_over_q_exactly():
    coarse, fine = sample(q_max=2.0, shift=6.0 / 2.0), sample(q_max=6.0, shift=6.0 / 6.0)
    found = est.estimate("flash_temperature", observe("flash_temperature", [coarse, fine], capped=True))
    limit = sample().numbers["flash_temperature"].mean(axis=0)
    np.testing.assert_allclose(found.mean, limit, rtol=1e-12)
    np.testing.assert_allclose(found.bias, 1.0, rtol=1e-10)  # finest level − limit
    np.testing.assert_allclose(found.total_error, np.hypot(found.half_width, 0.5), rtol=1e-10)


def test_three_cut_offs_fit_the_exponent():
    cutoffs, exponent = (1.0, 2.0, 5.0), 0.8
    samples = [sample(q_max=q, shift=4.0 * q**-exponent) for q in cutoffs]
    values = observe("flash_temperature", samples, capped=True)
    assert values.exponent == pytest.approx(exponent, rel=1e-9)
    limit = sample().numbers["flash_temperature"].mean(axis=0)
    np.testing.assert_allclose(values.extrapolated.mean(axis=0), limit, rtol=1e-9)


def test_values_that_do_not_settle_fall_back_to_first_order():
    flat = [np.full((3, 1), value) for value in (1.0, 2.0, 1.5)]
    assert fitted_exponent([1.0, 2.0, 4.0], flat) == 1.0


@pytest.mark.parametrize("name", NO_LIMIT)
def test_what_has_no_limit_is_not_extrapolated(name):
    coarse, fine = sample(q_max=2.0, seed=1), sample(q_max=4.0, seed=2)
    capped = observe(name, [coarse, fine], capped=True)
    np.testing.assert_array_equal(capped.extrapolated, capped.finest)
    elastic = observe(name, [coarse, fine], capped=False)
    assert not np.array_equal(elastic.extrapolated, elastic.finest)


def test_a_ratio_keeps_the_pairing():
    rng = np.random.default_rng(3)
    below = 5.0 + rng.standard_normal((50, 1))
    values = ratio(3.0 * below, below)
    np.testing.assert_allclose(values, 3.0, rtol=1e-12)  # the common scatter cancels
    above = 7.0 + rng.standard_normal((50, 1))
    error = est.spread(ratio(above, below))[0]
    expected = jackknife(lambda rows: above[rows].mean(axis=0) / below[rows].mean(axis=0), 50)
    np.testing.assert_allclose(error, expected, rtol=0.05)


@pytest.mark.parametrize("name", [*DERIVED, *RADII])
def test_each_row_is_its_realizations_own_influence(name):
    # pairing rests on it: rows must follow the pseudo-values n θ − (n − 1) θ₋ᵢ of a jackknife, sign included
    data, n = sample(n=40), 40

    def statistic(rows):
        numbers = {key: values[rows] for key, values in data.numbers.items()}
        part = replace(data, numbers=numbers, spectrum=data.spectrum[rows])
        return observe(name, [part], capped=False).extrapolated.mean(axis=0)

    rows = observe(name, [data], capped=False).extrapolated[:, 0]
    pseudo = [n * statistic(np.arange(n))[0] - (n - 1) * statistic(np.delete(np.arange(n), i))[0] for i in range(n)]
    assert np.corrcoef(rows, pseudo)[0, 1] > 0.99


def test_agreement_to_all_digits_is_no_scatter():
    rows = 1.0 + 1e-15 * np.arange(12.0)[:, None]
    assert est.spread(rows)[0][0] == 0.0
    assert est.spread(rows[:1])[0][0] == np.inf


def test_an_estimate_explains_itself():
    values = observe("flash_temperature", [sample()], capped=False)
    found = est.estimate("flash_temperature", values, size=0.01, solver=2e-4)
    text = found.explain()
    assert "flash_temperature" in text
    assert "n = 20" in text
    assert "size: at most what a larger cell changes, as measured" in text
    assert "pixel: unknown: no level of the run shows it; not in these figures" in text
    assert found.unknown == ("bandwidth", "pixel")
    np.testing.assert_allclose(found.budget["size"], 0.01 * found.mean)
    np.testing.assert_allclose(found.budget["solver"], 2e-4 * found.mean)
    parts = [found.budget[name] ** 2 for name in ("statistical", "size", "solver")]
    np.testing.assert_allclose(found.total_error, np.sqrt(sum(parts)))


def test_a_part_is_unknown_where_no_level_tells_but_not_where_the_mean_itself_is_infinite():
    rows = np.column_stack([np.full(12, np.inf), 1.0 + 0.1 * np.random.default_rng(1).standard_normal(12)])
    group, zero, nothing = np.zeros(12, dtype=np.intp), np.zeros(2), np.array([np.nan, np.nan])
    found = est.estimate("slope_length", Values(rows, rows, rows, group, nothing, nothing, zero), size=0.01)
    assert found.unknown == ("bandwidth",)  # the statistical part is NaN too, at rest: there the length is infinite
    np.testing.assert_allclose(found.total_error[1], np.hypot(found.half_width[1], 0.01 * found.mean[1]), rtol=1e-12)


def test_the_relative_half_width_of_a_run_that_may_stop_is_of_its_worst_speed():
    rng = np.random.default_rng(4)
    rows = 10.0 + rng.standard_normal((400, 2)) * [0.5, 1.0]
    first = next(n for n in range(12, 401) if relative_half_width(values_of(rows[:n])) <= 0.02)

    def half_width(count):
        part = rows[:count]
        quantile = stats.t.ppf(0.975, count - 1) * np.sqrt((count + 1) / (count - 1))
        return (quantile * stats.sem(part, axis=0) / part.mean(axis=0)).max()

    assert half_width(first) <= 0.02 < half_width(first - 1)
    assert relative_half_width(values_of(rows)) > 1e-6
    assert relative_half_width(values_of(np.ones((12, 1)))) == 0.0


def test_a_long_run_looks_at_its_targets_at_every_second_fourth_eighth_realization():
    assert est.looks(0, 14) == [12, 13, 14]
    assert est.looks(250, 262) == [250, 251, 252, 253, 254, 255, 256, 258, 260, 262]
    assert est.looks(509, 520) == [510, 512, 516, 520]
    assert est.looks(100_000, 102_000) == [100_352, 100_864, 101_376, 101_888]  # 512 apart
    assert est.looks(20, 19) == []
    at = np.array(est.looks(0, 50_000))
    assert ((at[1:] - at[:-1]) / at[:-1])[at[:-1] >= 256].max() <= 1 / 128
