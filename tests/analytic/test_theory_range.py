"""The theory at the ends of its range: eight decades, H = 0 and 1, tabulated spectra, speeds from 1e-9 to 1e9 m/s."""

from dataclasses import dataclass
from functools import cache
from math import erf, exp, pi, sqrt

import mpmath
import numpy as np
import pytest
from power_law import PowerLaw

from theory import flash, persson, plasticity

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
    half = float(
        persson.half_variance(1e12, spectrum, effective_modulus=contact["effective_modulus"])
    )
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
    np.testing.assert_allclose(
        persson.half_variance(q, eight_decades(hurst), effective_modulus=1e7), exact, rtol=1e-12
    )


def test_a_tabulated_spectrum_is_that_of_its_points():
    table = Table(
        tuple(np.geomspace(1e3, 1e8, 60).tolist()),
        tuple((1e-20 * np.geomspace(1.0, 1e-18, 60)).tolist()),
    )
    smooth = PowerLaw(1e-20, (1e3, 1e3, 1e8), 0.8)
    for speed in (1e-3, 10.0):
        values = [
            flash.flash_temperature(speed, spectrum, **CONTACT, **BODY)
            for spectrum in (table, smooth)
        ]
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
    assert flash.slope_length(1e-9, spectrum, **CONTACT, **BODY) == pytest.approx(
        4 * 1e-7 / 1e-9, rel=1e-3
    )


def test_the_slope_length_is_at_least_2_188_widths_when_fast():
    # Cauchy-Schwarz between ∫ s q^(−3/2), ∫ s q^(−1/2) and ∫ s q^(1/2); equality for one ring of waves
    for hurst in (0.0, 0.8, 1.0):
        given = (1e9, eight_decades(hurst))
        ratio = flash.slope_length(*given, **CONTACT, **BODY) / flash.flash_width(
            *given, **CONTACT, **BODY
        )
        assert ratio >= 2.1884396152264767 * (1 - 1e-6)
    ring = PowerLaw(1e-12, (1e4 * (1 - 1e-5), 1e4, 1e4 * (1 + 1e-5)), 0.8)
    ratio = flash.slope_length(1e9, ring, **CONTACT, **BODY) / flash.flash_width(
        1e9, ring, **CONTACT, **BODY
    )
    assert ratio == pytest.approx(2.1884396152264767, rel=1e-6)


def smoothing_with_thirty_digits(s, g):
    """1 − (A_pl/s)⁶ by images or modes, s = σ₀/σ_P, g = G/σ_P²."""
    if g < 0.3:
        width = 2 * mpmath.sqrt(g)
        plastic = (
            sum(
                mpmath.erfc((2 * k + 1 - s) / width) - mpmath.erfc((2 * k + 1 + s) / width)
                for k in range(8)
            )
            / s
        )
    else:
        modes = (
            (-1) ** (n + 1)
            * mpmath.sin(n * mpmath.pi * s)
            / n
            * mpmath.exp(-((n * mpmath.pi) ** 2) * g)
            for n in range(1, 14)
        )
        plastic = 1 - 2 / (mpmath.pi * s) * sum(modes)
    return 1 - plastic**6


@cache
def integral_of_smoothing(s):
    """Over all g, to thirty digits."""
    with mpmath.workdps(30):
        places = [0, 0.01, 0.03, 0.1, 0.3, 1, 3, 10]
        return float(mpmath.quad(lambda g: smoothing_with_thirty_digits(mpmath.mpf(s), g), places))


@pytest.mark.parametrize(
    ("hurst", "modulus", "width"),
    [
        pytest.param(0.05, 1e2, 1e-4, marks=pytest.mark.slow),
        (1.0, 1e8, 1e-15),
        *(
            pytest.param(*case, marks=pytest.mark.slow)
            for case in [
                *((1.0, 1e2, 1e-4), (0.05, 1e8, 1e-15)),
                *((h, *pair) for h in (0.05, 1.0) for pair in [(1e4, 1e-8), (1e6, 1e-12)]),
            ]
        ),
    ],
)
def test_a_surface_that_yields_at_once_is_a_ring_of_waves_with_the_stress_of_any_that_yields(
    hurst, modulus, width
):
    # G of the smoothed surface is σ_P² ∫ smoothing dg whatever C(q), once all yields, and so is ∫ 2 P dG; it lies
    # within (σ_P/E*)² above q_min, down to the last bit of q, where D_flash = 1/q_min
    hardness, load, lowest = 2.0, 0.06, 3.0
    contact = {"effective_modulus": modulus * hardness, "nominal_pressure": load}
    smoothed = plasticity.smoothed_spectrum(
        PowerLaw(1 / lowest**4, (lowest, lowest, 300.0), hurst),
        penetration_hardness=hardness,
        **contact,
    )
    half = hardness**2 * integral_of_smoothing(load / hardness)
    x = load / 2 / sqrt(half)
    exact = 2 * half * (erf(x) + 2 * x * exp(-x * x) / sqrt(pi) - 2 * x * x * (1 - erf(x)))
    assert float(
        persson.pressure_correlation(0.0, smoothed, gamma=1.0, **contact)
    ) == pytest.approx(exact, rel=1e-11)
    assert flash.flash_width(1e-3, smoothed, **contact, **BODY) == pytest.approx(
        1 / lowest, rel=width
    )


def test_a_surface_that_yields_before_the_next_number_is_refused():
    with pytest.raises(
        ValueError, match=r"penetration_hardness = 1 Pa: the surface has yielded .* 1e-16 .*; raise"
    ):
        plasticity.smoothed_spectrum(
            eight_decades(0.8),
            effective_modulus=1e12,
            nominal_pressure=0.1,
            penetration_hardness=1.0,
        )
