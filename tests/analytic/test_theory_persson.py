from math import pi, sqrt

import numpy as np
import pytest
from power_law import Flat, PowerLaw
from scipy.integrate import quad
from scipy.special import erf, erfc

from theory import persson


def test_half_variance_of_a_power_law_is_closed(case):
    spectrum, modulus = case["spectrum"], case["contact"]["effective_modulus"]
    q = np.linspace(*spectrum.q[:2], 7)
    got = persson.half_variance(q, spectrum, effective_modulus=modulus)
    np.testing.assert_allclose(got[1:], pi / 4 * modulus**2 * spectrum.cube(q)[1:], rtol=1e-13)
    assert persson.half_variance(
        spectrum.q[2], spectrum, effective_modulus=modulus
    ) == pytest.approx(case["half_variance"], rel=1e-13)


def test_contact_is_full_at_q_min_and_proportional_to_a_light_load():
    spectrum, contact = PowerLaw(1e-18, (1e3, 1e4, 1e6), 0.8), {"effective_modulus": 1e9}
    half = float(persson.half_variance(1e6, spectrum, **contact))
    shares = persson.contact_probability(
        np.array([10.0, 1e3, 1e6]), spectrum, nominal_pressure=1.0, **contact
    )
    assert shares[:2].tolist() == [1.0, 1.0]
    assert shares[2] == pytest.approx(1 / sqrt(pi * half), rel=1e-10)  # corrections ∝ σ₀²/G


def test_contact_probability_is_the_error_function():
    spectrum = PowerLaw(1e-18, (1e3, 1e4, 1e6), 0.8)
    half = pi / 4 * 1e18 * spectrum.cube(5e3)
    share = persson.contact_probability(
        5e3, spectrum, effective_modulus=1e9, nominal_pressure=1.5 * sqrt(half)
    )
    assert share == pytest.approx(erf(0.75), rel=1e-13)


def test_the_weight_mixes_first_and_third_power_of_the_contact_probability():
    spectrum, contact = (
        PowerLaw(1e-18, (1e3, 1e4, 1e6), 0.8),
        {"effective_modulus": 1e9, "nominal_pressure": 1e6},
    )
    q = np.array([2e3, 1e5])
    p = persson.contact_probability(q, spectrum, **contact)
    np.testing.assert_allclose(
        persson.stress_weight(q, spectrum, gamma=1.0, **contact), p, rtol=1e-15
    )
    np.testing.assert_allclose(
        persson.stress_weight(q, spectrum, gamma=0.0, **contact), p**3, rtol=1e-15
    )
    np.testing.assert_allclose(
        persson.stress_weight(q, spectrum, **contact), 0.45 * p + 0.55 * p**3, rtol=1e-15
    )
    own = persson.stress_weight(q, spectrum, gamma=lambda share, at: share**2 * at, **contact)
    np.testing.assert_allclose(own, p**2 * q, rtol=1e-15)


def test_correlation_agrees_with_thirty_digits(case):
    r = np.array([0.0, *case["given"]["r"]])
    got = persson.pressure_correlation(r, case["spectrum"], **case["contact"])
    np.testing.assert_allclose(got, case["g"], rtol=0, atol=3e-13 * case["g"][0])
    np.testing.assert_allclose(got, case["g"], rtol=1e-10)


def test_correlation_is_right_after_a_million_oscillations(six_decades):
    got = persson.pressure_correlation(5e-3, six_decades["spectrum"], **six_decades["contact"])
    assert got == pytest.approx(six_decades["g(5 mm)"], rel=1e-9)
    assert got == pytest.approx(2.5867061e9, rel=2e-8)


def test_correlation_far_beyond_the_longest_wave_is_right_at_the_layer_too(far):
    # q_min r = 30, 300, 2000: what is left comes from the ends, where contact is lost within a thin layer
    got = persson.pressure_correlation(far["r"], far["spectrum"], **far["contact"])
    np.testing.assert_allclose(got, far["g"], rtol=1e-8)


@pytest.mark.parametrize("pressure", [1e9, 1e5, 1.0, 1e-3, 1e-6, 1e-60])
def test_the_stress_variance_obeys_its_sum_rule_however_thin_the_layer(pressure):
    # W = P: g(0) = ∫ 2P dG, and with x = σ₀/2√G this is 2G [erf x + 2x e^(−x²)/√π − 2x² erfc x]
    spectrum, modulus = PowerLaw(1e-13, (1e3, 1e3, 1e9), 0.8), 1e7
    half = float(persson.half_variance(1e9, spectrum, effective_modulus=modulus))
    x = pressure / 2 / sqrt(half)
    exact = 2 * half * (erf(x) + 2 * x * np.exp(-(x**2)) / sqrt(pi) - 2 * x**2 * erfc(x))
    got = persson.pressure_correlation(
        0.0, spectrum, effective_modulus=modulus, nominal_pressure=pressure, gamma=1.0
    )
    assert got == pytest.approx(exact, rel=1e-11)


def test_third_power_weight_is_right_for_a_layer_of_any_thinness():
    # ∫ P³ dG → σ₀²/4 ∫ erf(1/√t)³ dt for σ₀ → 0: the layer is all there is
    spectrum, modulus = PowerLaw(1e-13, (1e3, 1e3, 1e9), 0.8), 1e7
    tail = quad(lambda u: 2 * erf(u) ** 3 / u**3, 0, 1, epsrel=1e-12)[0]
    layer = tail + quad(lambda t: erf(1 / sqrt(t)) ** 3, 0, 1, epsrel=1e-12)[0]
    got = persson.pressure_correlation(
        0.0, spectrum, effective_modulus=modulus, nominal_pressure=1e-20, gamma=0.0
    )
    assert got == pytest.approx(2 * 1e-40 / 4 * layer, rel=1e-10)


def test_full_contact_has_the_variance_of_the_full_contact_stress():
    spectrum, contact = PowerLaw(1e-25, (1e3, 1e4, 1e6), 0.8), {"effective_modulus": 1e9}
    half = float(persson.half_variance(1e6, spectrum, **contact))
    got = persson.pressure_correlation(0.0, spectrum, nominal_pressure=1e3 * sqrt(half), **contact)
    assert got == pytest.approx(2 * half, rel=1e-12)


def test_a_ring_of_waves_correlates_as_a_bessel_function():
    # |σ_q|² constant over 1 ± 1e-7: g(r)/g(0) = J₀(qr) to 1e-14, first zero 2.404825557695773
    ring = Flat(3.0, (1e4 * (1 - 1e-7), 1e4 * (1 + 1e-7)))
    assert persson.pressure_correlation(0.0, stress_spectrum=ring) == pytest.approx(
        2 * pi * 1e4 * 3 * 2e-3, rel=1e-8
    )
    assert persson.correlation_radius(0, stress_spectrum=ring) == pytest.approx(
        2.404825557695773e-4, rel=1e-10
    )
    assert persson.correlation_radius(0.5, stress_spectrum=ring) == pytest.approx(
        1.5211e-4, rel=1e-4
    )


@pytest.mark.parametrize("missing", [1e-3, 1e-6])
def test_near_the_origin_the_correlation_is_a_parabola(missing):
    # |σ_q|² constant from 1 to 2: 1 − g(r)/g(0) = ⟨q²⟩ r²/4 − ⟨q⁴⟩ r⁴/64, ⟨q²⟩ = (15/4)/(3/2), ⟨q⁴⟩ = (63/6)/(3/2)
    radius = persson.correlation_radius(1 - missing, stress_spectrum=Flat(1.0, (1.0, 2.0)))
    assert 2.5 * radius**2 / 4 - 7 * radius**4 / 64 == pytest.approx(missing, rel=missing + 1e-9)


def test_the_correlation_without_mean_pressure_goes_negative(case):
    zero = persson.correlation_radius(0.0, case["spectrum"], **case["contact"])
    beyond = persson.pressure_correlation(
        zero * np.array([0.999, 1.001]), case["spectrum"], **case["contact"]
    )
    assert beyond[0] > 0 > beyond[1]


def test_the_radius_is_the_smallest_where_the_fraction_is_reached(case):
    spectrum, contact = case["spectrum"], case["contact"]
    for fraction in (0.5, 0.1):
        radius = persson.correlation_radius(fraction, spectrum, **contact)
        r = radius * np.linspace(0, 1, 200)
        g = persson.pressure_correlation(r, spectrum, **contact) / case["g"][0]
        assert (g[:-1] > fraction).all()
        assert g[-1] == pytest.approx(fraction, rel=1e-9)


def test_a_given_stress_spectrum_replaces_theory(case):
    spectrum, contact = case["spectrum"], case["contact"]

    class Stress:
        breaks = spectrum.breaks

        def __call__(self, q):
            weight = persson.stress_weight(q, spectrum, **contact)
            return contact["effective_modulus"] ** 2 / 4 * q**2 * spectrum(q) * weight

    got = persson.pressure_correlation(case["given"]["r"], stress_spectrum=Stress())
    np.testing.assert_allclose(got, case["g"][1:], rtol=1e-8)
