"""Stress distribution, the weight of Wang and Müser, heat histories, and what the package remembers."""

from dataclasses import dataclass
from math import pi, sqrt

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import dawsn
from some_rows import some

from theory import background, flash, persson, plasticity
from theory.arguments import is_value

BODY = {"conductivity": 20.0, "diffusivity": 5e-6}


@pytest.mark.parametrize("s", [0.01, 0.3, 0.5, 0.9])
@pytest.mark.parametrize("g", some([1e-4, 0.03, 0.1999, 0.2001, 1.0, 3.0], 2))
def test_the_stress_distribution_fills_the_elastic_area_and_carries_the_load(s, g):
    given = (g * 4e18, s * 2e9, 2e9)

    def density(t):
        return float(plasticity.stress_distribution(t * 2e9, *given)) * 2e9

    tight = {
        "points": sorted({s, max(s - sqrt(g), 1e-3), min(s + sqrt(g), 0.999)}),
        "epsabs": 0,
        "epsrel": 1e-12,
        "limit": 400,
    }
    _, elastic, plastic = plasticity.area_fractions(*given)
    assert quad(density, 0, 1, **tight)[0] == pytest.approx(float(elastic), rel=1e-11, abs=1e-14)
    load = quad(lambda t: t * density(t), 0, 1, **tight)[0] + float(plastic)
    assert load == pytest.approx(s, rel=1e-11)


def test_far_from_the_hardness_the_stress_distribution_is_perssons():
    # two normal densities of variance 2G
    stress, pressure, half = np.linspace(0, 4e6, 9), 1e6, 6e11
    two = np.exp(-((stress - pressure) ** 2) / 4 / half) - np.exp(
        -((stress + pressure) ** 2) / 4 / half
    )
    got = plasticity.stress_distribution(stress, half, pressure, 1e12)
    np.testing.assert_allclose(got, two / sqrt(4 * pi * half), rtol=1e-12, atol=1e-25)
    assert got[0] == 0.0


def test_series_and_images_agree_where_they_meet():
    t = np.linspace(0, 1, 21)
    for s in (0.2, 0.8):
        below, above = (
            plasticity.stress_distribution(t, g, s, 1.0) for g in (0.2 - 1e-13, 0.2 + 1e-13)
        )
        np.testing.assert_allclose(below, above, rtol=1e-11, atol=1e-13)


def test_the_weight_of_wang_and_mueser_is_one_in_full_contact_and_five_ninths_of_the_area_in_light(
    case,
):
    share = np.array([0.0, 1e-6, 0.5, 1.0])
    got = persson.wang_mueser(share, np.ones(4))
    assert got == pytest.approx(
        [0.0, 5e-6 / 9, 0.5 * (5 / 9 - 0.5 / 9 + 0.0625 * 2 / 3), 1.0], rel=1e-11, abs=0
    )
    one = persson.stress_weight(
        2e4, case["spectrum"], **{**case["contact"], "gamma": persson.wang_mueser}
    )
    contact = {k: v for k, v in case["contact"].items() if k != "gamma"}
    area = persson.contact_probability(2e4, case["spectrum"], **contact)
    assert one == pytest.approx(
        float(area * (5 / 9 - 2 / 9 * area**2 + 2 / 3 * area**4)), rel=1e-13
    )


def test_the_composite_modulus_adds_the_compliances():
    assert persson.effective_modulus(2e11, 0.3) == pytest.approx(2e11 / 0.91, rel=1e-15)
    assert persson.effective_modulus([2e11, 2e11], 0.3) == pytest.approx(
        2e11 / 0.91 / 2, rel=1e-15
    )  # 109.89 GPa
    assert 1 / persson.effective_modulus([1e7, 5e10], [0.5, 0.2]) == pytest.approx(
        0.75 / 1e7 + 0.96 / 5e10, rel=1e-15
    )


def test_a_constant_history_is_the_closed_background():
    steady = background.temperature([0.0, 0.3, 2.0], heat_flux=1e6, **BODY)
    history = background.temperature([0.0, 0.3, 2.0], heat_flux=lambda t: 1e6, **BODY)
    np.testing.assert_allclose(history, steady, rtol=1e-13)


def test_a_rising_flux_heats_as_the_power_three_halves():
    # q̇ = at: T = (4a/3κ)√(D/π) t^(3/2)
    got = background.temperature(0.7, heat_flux=lambda t: 3e6 * t, **BODY)
    assert got == pytest.approx(4 * 3e6 / 3 / 20 * sqrt(5e-6 / pi) * 0.7**1.5, rel=1e-11)


def test_a_flux_that_stops_cools_as_the_difference_of_two_roots():
    got = background.temperature(
        0.7, heat_flux=lambda t: 1e6 * (t < 0.2), breaks=[0.2, 5.0], **BODY
    )
    assert got == pytest.approx(2e6 / 20 * sqrt(5e-6 / pi) * (sqrt(0.7) - sqrt(0.5)), rel=1e-11)


def test_a_decaying_flux_has_dawsons_integral():
    # ∫₀ᵗ e^(−t′)(t − t′)^(−1/2) dt′ = 2 F(√t)
    got = background.temperature(3.0, heat_flux=lambda t: 1e6 * np.exp(-t), **BODY)
    assert got == pytest.approx(1e6 / 20 * sqrt(5e-6 / pi) * 2 * dawsn(sqrt(3.0)), rel=1e-10)


@dataclass(frozen=True)
class _Frozen:
    psd: float
    breaks: tuple[float, ...] = (1e3, 1e4)

    def __call__(self, q):
        return np.full_like(q, self.psd)


class _Changing:
    """A spectrum known by its identity: it may change under the same hash."""

    def __init__(self, psd):
        self.psd, self.breaks = psd, (1e3, 1e4)

    def __call__(self, q):
        return np.full_like(q, self.psd)


def test_a_spectrum_that_changes_is_not_remembered(case):
    sliding = case["sliding"]
    changing = _Changing(1e-22)
    first = flash.flash_temperature(1.0, changing, **sliding)
    changing.psd = 2e-22
    second = flash.flash_temperature(1.0, changing, **sliding)
    assert first == flash.flash_temperature(1.0, _Frozen(1e-22), **sliding)
    assert second == flash.flash_temperature(1.0, _Frozen(2e-22), **sliding)
    assert first != second


@dataclass(frozen=True)
class _Twice:
    """A spectrum that compares by value, but its part does not."""

    parts: tuple

    @property
    def breaks(self):
        return self.parts[0].breaks

    def __call__(self, q):
        return 2.0 * self.parts[0](q)


def test_a_spectrum_with_a_part_that_changes_is_not_remembered(case):
    solid = {name: case["sliding"][name] for name in ("effective_modulus", "nominal_pressure")}
    changing = _Changing(1e-22)
    wrapped = _Twice((changing,))
    for psd in 1e-22, 2e-22:
        changing.psd, twice = psd, _Frozen(2.0 * psd)
        share = persson.contact_probability(5e3, wrapped, **solid)
        assert share == persson.contact_probability(5e3, twice, **solid)
        temperature = flash.flash_temperature(1.0, wrapped, **case["sliding"])
        assert temperature == flash.flash_temperature(1.0, twice, **case["sliding"])


def test_what_compares_by_value_in_all_its_parts_is_remembered():
    spectrum = _Frozen(1e-22)
    assert all(map(is_value, (None, 1.0, "text", spectrum, (spectrum, 1), _Twice((spectrum,)))))
    changing = _Changing(1e-22)
    others = (
        changing,
        _Twice((changing,)),
        (spectrum, changing),
        changing.__call__,
        [1.0],
        np.ones(2),
    )
    assert not any(map(is_value, others))


def test_a_weight_given_as_a_function_is_not_remembered(case):
    power = [1.0]
    given = {**case["sliding"], "gamma": lambda share, q: share ** power[0]}
    first = flash.flash_temperature(1.0, case["spectrum"], **given)
    power[0] = 2.0
    assert flash.flash_temperature(1.0, case["spectrum"], **given) < first


def test_a_remembered_number_does_not_let_a_wrong_type_pass(case):
    given = {**case["sliding"], "gamma": 1.0}
    flash.flash_temperature(1.0, case["spectrum"], **given)
    with pytest.raises(TypeError, match="gamma"):
        flash.flash_temperature(1.0, case["spectrum"], **{**given, "gamma": True})
