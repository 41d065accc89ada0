"""The theory at the ends of its range: eight decades, H = 0 and 1, tabulated spectra, speeds from 1e-9 to 1e9 m/s."""

from dataclasses import dataclass
from math import erf, exp, pi, sqrt

import numpy as np
import pytest
from power_law import PowerLaw

from theory import flash, persson

CONTACT = {"effective_modulus": 1e7, "nominal_pressure": 1e5}
BODY = {"friction_coefficient": 0.7, "conductivity": 0.2, "diffusivity": 1e-7}
SPEEDS = np.geomspace(1e-9, 1e9, 37)


@dataclass(frozen=True)
class Table:
    """Straight lines in ln C over ln q: every point is a break."""

    breaks: tuple[float, ...]
    values: tuple[float, ...]

    def __call__(self, q):
        return np.exp(np.interp(np.log(q), np.log(self.breaks), np.log(self.values)))


def eight_decades(hurst):
    return PowerLaw(1e-14, (1e2, 1e2, 1e10), hurst)


def variance_for_w_equal_p(spectrum, **contact):
    """∫ 2 erf(σ₀/2√G) dG from 0 to G in closed form: with x = σ₀/2√G, 2G[erf x + 2x e^(−x²)/√π − 2x² erfc x]."""
    half = float(persson.half_variance(1e12, spectrum, effective_modulus=contact["effective_modulus"]))
    x = contact["nominal_pressure"] / 2 / sqrt(half)
    return 2 * half * (erf(x) + 2 * x * exp(-x * x) / sqrt(pi) - 2 * x * x * (1 - erf(x)))


@pytest.mark.parametrize("hurst", [0.0, 0.5, 1.0])
def test_the_stress_variance_of_eight_decades_obeys_its_sum_rule(hurst):
    spectrum = eight_decades(hurst)
    got = float(persson.pressure_correlation(0.0, spectrum, gamma=1.0, **CONTACT))
    assert got == pytest.approx(variance_for_w_equal_p(spectrum, **CONTACT), rel=1e-10)


@pytest.mark.parametrize(("hurst", "power"), [(0.0, 2.0), (1.0, 0.0)])
def test_the_half_variance_of_the_extreme_hurst_exponents_is_closed(hurst, power):
    q = np.array([1e3, 1e6, 1e10])
    grown = np.log(q / 1e2) if power == 0.0 else ((q / 1e2) ** 2 - 1) / 2
    exact = pi / 4 * 1e14 * 1e-14 * 1e2**4 * grown
    np.testing.assert_allclose(persson.half_variance(q, eight_decades(hurst), effective_modulus=1e7), exact, rtol=1e-12)


def test_a_tabulated_spectrum_is_that_of_its_points():
    table = Table(tuple(np.geomspace(1e3, 1e8, 60).tolist()), tuple((1e-20 * np.geomspace(1.0, 1e-18, 60)).tolist()))
    smooth = PowerLaw(1e-20, (1e3, 1e3, 1e8), 0.8)
    for speed in (1e-3, 10.0):
        values = [flash.flash_temperature(speed, spectrum, **CONTACT, **BODY) for spectrum in (table, smooth)]
        assert values[0] == pytest.approx(values[1], rel=1e-10)
    assert float(persson.pressure_correlation(0.0, table, gamma=1.0, **CONTACT)) == pytest.approx(
        variance_for_w_equal_p(table, **CONTACT), rel=1e-10
    )


@pytest.mark.parametrize("hurst", [0.0, 0.8, 1.0])
def test_from_creep_to_flight_the_temperature_rises_between_the_root_and_the_speed(hurst):
    spectrum = eight_decades(hurst)
    rise = flash.flash_temperature(SPEEDS, spectrum, **CONTACT, **BODY)
    slope = np.diff(np.log(rise)) / np.diff(np.log(SPEEDS))
    assert (slope > 0.5 - 1e-12).all()
    assert (slope < 1.0 + 1e-12).all()
    assert (np.diff(slope) < 1e-9).all()
    assert flash.slope_length(1e-9, spectrum, **CONTACT, **BODY) == pytest.approx(4 * 1e-7 / 1e-9, rel=1e-3)


def test_the_slope_length_is_at_least_2_188_widths_when_fast():
    # Cauchy-Schwarz between ∫ s q^(−3/2), ∫ s q^(−1/2) and ∫ s q^(1/2); equality for one ring of waves
    for hurst in (0.0, 0.8, 1.0):
        given = (1e9, eight_decades(hurst))
        ratio = flash.slope_length(*given, **CONTACT, **BODY) / flash.flash_width(*given, **CONTACT, **BODY)
        assert ratio >= 2.1884396152264767 * (1 - 1e-6)
    ring = PowerLaw(1e-12, (1e4 * (1 - 1e-5), 1e4, 1e4 * (1 + 1e-5)), 0.8)
    ratio = flash.slope_length(1e9, ring, **CONTACT, **BODY) / flash.flash_width(1e9, ring, **CONTACT, **BODY)
    assert ratio == pytest.approx(2.1884396152264767, rel=1e-6)
