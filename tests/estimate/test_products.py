"""Products of values of one column, and their multiples."""

from dataclasses import replace

import numpy as np
from ladder_cases import END, NAME, SPEEDS, at_level, sample

from roughsim.estimate.levels import values_of


def drawn_values(scene, seed, mean, scatter=0.1, stream=0, n=8):
    rng = np.random.default_rng(seed)
    rows = mean * (1.0 + scatter * rng.standard_normal((n, SPEEDS)))
    pair = at_level(sample(rows, END), 0, stream)
    values = values_of(scene, "elastic", NAME, [pair])
    return replace(
        values, errors={name: np.full(SPEEDS, share * mean) for name, share in ERRORS.items()}
    ), rows


ERRORS = {"bandwidth": 0.02, "pixel": 0.03, "last step": 0.005}


def test_a_product_keeps_surfaces_together_and_adds_errors_of_the_same_causes(steel):
    (kelvins, of_kelvins), (share, of_share) = (
        drawn_values(steel, seed, mean) for seed, mean in ((1, 200.0), (2, 0.4))
    )
    found = kelvins * share
    a, b = of_kelvins.mean(axis=0), of_share.mean(axis=0)
    np.testing.assert_allclose(found.value, a * b, rtol=1e-12)
    np.testing.assert_allclose(found.finest, a * b, rtol=1e-12)
    paired = of_kelvins * b + a * of_share
    np.testing.assert_allclose(found.variance[0], paired.var(axis=0, ddof=1) / 8, rtol=1e-9)
    for name, relative in ERRORS.items():
        expected = relative * (a * 0.4 + b * 200.0)
        np.testing.assert_allclose(found.errors[name], expected, rtol=1e-12)
    for negative in (
        kelvins * replace(share, value=-b),
        replace(kelvins, value=-a) * share,
    ):
        np.testing.assert_allclose(negative.value, -found.value, rtol=1e-12)
        np.testing.assert_allclose(negative.errors["pixel"], found.errors["pixel"], rtol=1e-12)
    nothing = {"bandwidth": np.full(SPEEDS, np.nan)}
    unknown = replace(kelvins, errors={**kelvins.errors, **nothing}) * share
    assert np.isnan(unknown.errors["bandwidth"]).all()


def test_a_product_that_is_exactly_zero_has_no_error(steel):
    kelvins, _ = drawn_values(steel, 1, 200.0)
    share, _ = drawn_values(steel, 2, 0.4)
    moving = np.arange(SPEEDS) > 0
    nothing = np.full(SPEEDS, np.nan)
    errors = kelvins.errors | {"bandwidth": nothing, "pixel": np.where(moving, np.inf, np.nan)}
    at_rest = replace(kelvins * (moving * 1.0), errors=errors)
    found = at_rest * share
    assert (found.value[0], found.errors["bandwidth"][0], found.errors["pixel"][0]) == (
        0.0,
        0.0,
        0.0,
    )
    assert np.isnan(found.errors["bandwidth"][1:]).all()


def test_values_times_an_exact_number_are_scaled_with_all_that_they_have(steel):
    values, rows = drawn_values(steel, 3, 200.0)
    factor = np.linspace(0.1, 0.7, SPEEDS)
    found = values * factor
    for name in ("value", "finest"):
        np.testing.assert_allclose(getattr(found, name), getattr(values, name) * factor, rtol=1e-12)
    for name, part in values.errors.items():
        np.testing.assert_allclose(found.errors[name], part * factor, rtol=1e-12)
    np.testing.assert_allclose(
        found.variance[0], (rows * factor).var(axis=0, ddof=1) / 8, rtol=1e-9
    )
