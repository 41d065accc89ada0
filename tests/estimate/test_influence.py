"""Observables that are no plain means: influence values of each realization, against a jackknife."""

import numpy as np
import pytest
from scipy import special

from roughsim.estimate.errors import spread
from roughsim.observables.catalogue import OBSERVABLES, observables_of
from roughsim.observables.record import Sample, ratio

RADII = {"correlation_radius_50": 0.5, "correlation_radius_10": 0.1, "correlation_radius_0": 0.0}
OF_MEANS = {
    "flash_width": lambda m: np.sqrt(-m["flash_temperature"] / m["flash_laplacian"]),
    "slope_length": lambda m: -m["flash_temperature"] / m["flash_gradient"],
}


def sample(n, speeds=2):
    rng = np.random.default_rng(0)
    numbers = {
        "flash_temperature": 10.0 + rng.standard_normal((n, speeds)),
        "flash_gradient": -3.0 + 0.2 * rng.standard_normal((n, speeds)),
        "flash_laplacian": -5.0 + 0.3 * rng.standard_normal((n, speeds)),
    }
    q = np.linspace(1.0, 20.0, 60)
    return Sample(1.0, 16.0, np.arange(n), numbers, q, q**-2 * rng.uniform(0.8, 1.2, (n, 60)), 20.0)


def statistic(name, data):
    """Takes the numbers of rows to the observable of their mean, (speeds,) or (1,), without influence values."""
    if name in OF_MEANS:
        return lambda rows: OF_MEANS[name](
            {key: values[rows].mean(axis=0) for key, values in data.numbers.items()}
        )

    def radius(rows):
        mean = data.spectrum[rows].mean(axis=0)
        r = np.linspace(0.0, 5.0, 2001)
        curve = mean @ BESSEL - RADII[name] * mean.sum()
        k = int(np.argmax(curve <= 0.0))
        return np.array([r[k - 1] + r[1] * curve[k - 1] / (curve[k - 1] - curve[k])])

    return radius


BESSEL = special.j0(np.multiply.outer(np.linspace(1.0, 20.0, 60), np.linspace(0.0, 5.0, 2001)))


def left_out(statistic, n):
    return np.array([statistic(np.delete(np.arange(n), i)) for i in range(n)])


@pytest.mark.parametrize("name", [*OF_MEANS, *RADII])
def test_influence_values_have_the_mean_and_the_error_of_a_jackknife(name):
    # pairing rests on the rows: they must follow the pseudo-values n θ − (n − 1) θ₋ᵢ, sign included
    n = 40
    data = sample(n)
    of_rows = statistic(name, data)
    rows = OBSERVABLES[name].of_level(data)
    whole, without = of_rows(np.arange(n)), left_out(of_rows, n)
    np.testing.assert_allclose(rows.mean(axis=0), whole, rtol=1e-5)  # of the secant
    error = np.sqrt((n - 1) * np.mean((without - without.mean(axis=0)) ** 2, axis=0))
    np.testing.assert_allclose(spread(rows)[0], error, rtol=0.05)
    pseudo = n * whole - (n - 1) * without
    for k in range(rows.shape[1]):
        assert np.corrcoef(rows[:, k], pseudo[:, k])[0, 1] > 0.99


@pytest.mark.parametrize("power", [1.0, 0.5, -2.0])
def test_a_ratio_of_means_keeps_the_pairing(power):
    rng = np.random.default_rng(3)
    below, above = 5.0 + rng.standard_normal((50, 1)), 7.0 + rng.standard_normal((50, 1))
    np.testing.assert_allclose(
        ratio(3.0 * below, below, power), 3.0**power, rtol=1e-12
    )  # the common scatter cancels
    found = ratio(above, below, power)

    def of_means(rows):
        return (above[rows].mean(axis=0) / below[rows].mean(axis=0)) ** power

    without = left_out(of_means, 50)
    error = np.sqrt(49 * np.mean((without - without.mean(axis=0)) ** 2, axis=0))
    np.testing.assert_allclose(spread(found)[0], error, rtol=0.05)
    np.testing.assert_allclose(found.mean(axis=0), of_means(np.arange(50)), rtol=1e-12)


def test_what_is_exact_at_rest():
    rest = {
        "flash_temperature": 0.0,
        "flash_gradient": 0.0,
        "flash_laplacian": 0.0,
        "slope_length": np.inf,
    }
    always = observables_of()
    assert {
        name: record.at_rest for name, record in always.items() if record.at_rest is not None
    } == rest
    asked = {*OBSERVABLES} - {*always}
    assert len(asked) == 14 + 3
    assert {name for name in asked if OBSERVABLES[name].at_rest != 0.0} == {"seen_width"}


def test_in_capped_contact_only_gradients_have_no_limit():
    without = {name for name, record in OBSERVABLES.items() if not record.limit}
    assert without == {"flash_gradient", "flash_laplacian", "flash_width", "slope_length"}
