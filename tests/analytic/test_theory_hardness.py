"""The hardness at the temperature that it brings about."""

import pytest

from theory import hardness

TABLE = ([300.0, 800.0, 1300.0], [1.2e9, 0.8e9, 0.1e9])


def test_a_linear_rise_on_a_linear_table_is_closed():
    # T = cσ, H = 1.2e9 − 8e5 (T₀ + T − 300): σ = (1.2e9 − 8e5 (T₀ − 300))/(1 + 8e5 c)
    found, rise = hardness.self_consistent(lambda y: 2e-7 * y, *TABLE, background=350.0)
    exact = (1.2e9 - 8e5 * 50) / (1 + 8e5 * 2e-7)
    assert found == pytest.approx(exact, rel=1e-13)
    assert rise == pytest.approx(2e-7 * exact, rel=1e-12)


def test_hardness_and_temperature_belong_together_beyond_a_kink():
    found, rise = hardness.self_consistent(
        lambda y: 30.0 * (y / 1e6) ** 0.5, *TABLE, background=300.0
    )
    assert rise == pytest.approx(30.0 * (found / 1e6) ** 0.5, rel=1e-12)
    assert found == pytest.approx(0.8e9 - 1.4e6 * (300.0 + rise - 800.0), rel=1e-12)


def test_cold_contact_has_the_cold_hardness():
    assert hardness.self_consistent(lambda y: 0.0, *TABLE, background=300.0) == (1.2e9, 0.0)
