"""The calibrated stress spectrum: its formula by another route, full contact, what lies beyond the ends, its range."""

import pickle
from dataclasses import dataclass
from itertools import pairwise
from math import erf, exp, log, pi, sqrt

import numpy as np
import pytest
from power_law import PowerLaw
from scipy.integrate import quad

from theory import flash, persson
from theory.calibrated import CONSTANTS

MODULUS = 1.1e11
HEAT = {"friction_coefficient": 0.11, "conductivity": 30.0, "diffusivity": 7.6e-6}
SPECTRUM = PowerLaw(2e-27, (6e3, 2e4, 4e5), 0.7)


def moment(order, stop, start=6e3):
    inner = [SPECTRUM.q[1]] if start < SPECTRUM.q[1] < stop else []
    value, _ = quad(
        lambda q: q**order * float(SPECTRUM(np.array(q))), start, stop, points=inner, epsabs=0, epsrel=1e-12, limit=200
    )
    return value


SLOPE = sqrt(2 * pi * moment(3, 4e5))


def at_load(load, spectrum=SPECTRUM):
    return persson.calibrated_spectrum(spectrum, effective_modulus=MODULUS, nominal_pressure=load * MODULUS * SLOPE)


@pytest.mark.parametrize("load", [0.012, 0.1, 0.5])
@pytest.mark.parametrize("q", [6.3e3, 1.9e4, 5e4, 3.9e5])
def test_in_the_band_the_weight_is_the_stated_formula(load, q):
    c = CONSTANTS
    pressure, rate = load * MODULUS * SLOPE, pi / 4 * MODULUS**2
    variance, later = rate * moment(3, q), rate * q * moment(2, 4e5, q)
    share = erf(pressure / 2 / sqrt(variance))
    softer = erf(pressure / 2 / sqrt(variance + c.later * later))
    m1, m4 = moment(4, q) / q / moment(3, q), moment(7, q) / q**4 / moment(3, q)
    b0, b1, b4 = c.power
    weight = share**c.present * softer ** (b0 + b1 * log(m1) + b4 * log(m4))
    expected = (MODULUS * q / 2) ** 2 * float(SPECTRUM(np.array(q))) * weight
    assert float(at_load(load)(q)) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("load", [0.012, 0.3])
def test_beyond_the_ends_are_the_stated_tail_and_floor(load):
    c = CONSTANTS
    pressure, rate = load * MODULUS * SLOPE, pi / 4 * MODULUS**2
    low, high = SPECTRUM.q[0], SPECTRUM.q[2]
    full = [(MODULUS * q / 2) ** 2 * float(SPECTRUM(np.array(q))) for q in (low, high)]
    opening = erf(pressure / 2 / sqrt(c.later * rate * low * moment(2, high)))
    spectrum = at_load(load)
    floor = exp(c.floor) * opening ** c.power[0] * (1 - opening) * full[0]
    np.testing.assert_allclose(spectrum(np.array([low / 900, low / 2])), floor, rtol=1e-9)
    share = erf(pressure / 2 / sqrt(rate * moment(3, high)))
    m1, m4 = log(moment(4, high) / high / moment(3, high)), log(moment(7, high) / high**4 / moment(3, high))
    t0, t1, t2, t3, t4 = c.edge
    edge = exp(t0 + t1 * log(share) + t3 * m1 + t4 * m4) * (1 - share) ** t2 * full[1]
    near = exp(c.near[0] + c.near[1] * m4)
    for x in (1.5, 10.0, 1e4):
        assert float(spectrum(x * high)) == pytest.approx(edge * x**-4 * (1 + near * x**-2), rel=1e-9)


def test_in_full_contact_nothing_is_left_to_calibrate():
    # 1 − erf is 0 to rounding: W = 1 exactly, and no stress beyond the ends of C(q)
    spectrum = at_load(8.0)
    q = np.geomspace(*SPECTRUM.q[::2], 40)
    np.testing.assert_array_equal(spectrum.weight(q), 1.0)
    np.testing.assert_array_equal(spectrum(q), (MODULUS * q / 2) ** 2 * SPECTRUM(q))
    np.testing.assert_array_equal(spectrum(np.array([1e3, 5.9e3, 4.1e5, 1e9])), 0.0)
    load = {"nominal_pressure": 8.0 * MODULUS * SLOPE}
    exact = flash.flash_temperature(35.0, SPECTRUM, effective_modulus=MODULUS, gamma=1.0, **load, **HEAT)
    assert flash.flash_temperature(35.0, stress_spectrum=spectrum, **load, **HEAT) == pytest.approx(exact, rel=1e-10)


def test_full_contact_is_approached_monotonically():
    q = np.array([6.1e3, 3e4, 4e5])
    departures = [np.abs(np.log(at_load(load).weight(q))) for load in (0.3, 0.6, 1.2, 2.4)]
    assert (np.diff(departures, axis=0) < 0).all()


@pytest.mark.parametrize("load", [0.012, 0.2])
def test_flash_temperature_and_correlation_are_its_integrals(load):
    spectrum = at_load(load)
    ends = spectrum.breaks

    def integral(f):
        pieces = pairwise(ends)
        return sum(
            quad(
                lambda t: exp(t) * f(exp(t)) * float(spectrum(exp(t))),
                log(a) + 1e-12,
                log(b) - 1e-12,
                epsrel=1e-10,
                limit=400,
            )[0]
            for a, b in pieces
        )

    variance = float(persson.pressure_correlation(0.0, stress_spectrum=spectrum))
    assert variance == pytest.approx(2 * pi * integral(lambda q: q), rel=1e-7)
    speed, pressure = 0.4, spectrum.nominal_pressure
    even = integral(lambda q: float(flash.angular_integrals(speed / HEAT["diffusivity"] / q)[0]))
    expected = 4 * HEAT["friction_coefficient"] * speed / HEAT["conductivity"] / pressure * even
    got = flash.flash_temperature(speed, stress_spectrum=spectrum, nominal_pressure=pressure, **HEAT)
    assert got == pytest.approx(expected, rel=1e-7)


def test_every_quantity_takes_it():
    spectrum = at_load(0.05)
    given = {"stress_spectrum": spectrum, "nominal_pressure": spectrum.nominal_pressure, **HEAT}
    assert flash.flash_gradient(1.0, **given) < 0 < flash.flash_temperature(1.0, **given)
    assert flash.flash_laplacian(1.0, **given) < 0
    assert flash.slope_length(1e4, **given) > 2.18844 * flash.flash_width(1e4, **given)
    assert flash.slope_length(1e-6, **given) == pytest.approx(4 * HEAT["diffusivity"] / 1e-6, rel=1e-4)
    assert persson.correlation_radius(0.5, stress_spectrum=spectrum) > 0


def test_units_cancel():
    # pressures in units of E*, lengths in any unit: |σ_q|² scales as E*² m²
    base, q = at_load(0.05), np.geomspace(1e2, 1e8, 31)
    longer = PowerLaw(2e-27 * 1e4**4, tuple(x / 1e4 for x in SPECTRUM.q), 0.7)
    other = persson.calibrated_spectrum(longer, effective_modulus=1.0, nominal_pressure=0.05 * SLOPE)
    np.testing.assert_allclose(other(q / 1e4), base(q) / MODULUS**2 * 1e8, rtol=1e-9)


def test_breaks_hold_all_of_it():
    spectrum = at_load(0.05)
    np.testing.assert_allclose(spectrum.breaks, [6.0, 6e3, 2e4, 4e5, 4e13])
    np.testing.assert_array_equal(spectrum(np.array([5.0, 1e14])), 0.0)


def test_it_is_a_value():
    spectrum = at_load(0.05)
    assert spectrum == at_load(0.05)
    assert hash(spectrum) == hash(at_load(0.05))
    q = np.geomspace(1e3, 1e6, 7)
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(spectrum))(q), spectrum(q))


def test_a_lighter_load_than_calibrated_is_refused():
    assert at_load(0.0101).breaks
    with pytest.raises(ValueError, match=r"nominal_pressure = .* Pa is 0\.0099 E\*h′, below the 0\.01 .*raise it to"):
        at_load(0.0099)


@pytest.mark.parametrize(
    ("spectrum", "words"),
    [
        (PowerLaw(2e-27, (6e3, 2e4, 4e5), -0.3), "memory m₁"),
        (PowerLaw(2e-27, (6e3, 2.4e4, 4.2e4), 0.7), "bandwidth"),
        (PowerLaw(2e-27, (6e3, 7e3, 3.5e4), 0.7), r"width q_max/q_min = 5\.83"),
        (PowerLaw(2e-27, (6e3, 2e4, 4e8), 0.7), "bandwidth"),
    ],
)
def test_a_spectrum_unlike_the_calibrated_ones_is_refused(spectrum, words):
    with pytest.raises(ValueError, match=words):
        persson.calibrated_spectrum(spectrum, effective_modulus=1.0, nominal_pressure=1e9)


@dataclass(frozen=True)
class Gap:
    """A power law in which waves over a factor 2 of q are left out but for a share."""

    fill: float
    breaks: tuple[float, ...] = (6e3, 2e4, 6e4, 1.2e5, 4e5)

    def __call__(self, q):
        whole = PowerLaw(2e-27, (6e3, 2e4, 4e5), 0.7)(q)
        return whole * np.where((q > 6e4) & (q < 1.2e5), self.fill, 1.0)


def test_a_spectrum_with_a_gap_is_refused():
    # of elastic contacts with a gap of an octave T_flash is 5 to 16 % off
    solid = {"effective_modulus": MODULUS, "nominal_pressure": 1e9}
    assert persson.calibrated_spectrum(Gap(1.0), **solid).breaks
    for fill in (0.0, 1e-3, 0.1):
        with pytest.raises(ValueError, match=r"octaves of gaps = 0\.9.*, outside 0 … 0\.5"):
            persson.calibrated_spectrum(Gap(fill), **solid)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"effective_modulus": -1.0}, "effective_modulus = -1 Pa must be positive"),
        ({"nominal_pressure": float("nan")}, "nominal_pressure holds values that are NaN"),
        ({"spectrum": 3.0}, "spectrum = 3.0 must be a callable"),
    ],
)
def test_wrong_arguments_are_named(given, message):
    arguments = {"spectrum": SPECTRUM, "effective_modulus": MODULUS, "nominal_pressure": 1e9} | given
    spectrum = arguments.pop("spectrum")
    with pytest.raises((TypeError, ValueError), match=message):
        persson.calibrated_spectrum(spectrum, **arguments)
