"""The calibrated law of elastic contact: full contact, the tail of its edges, the measured contacts, its range."""

import pickle
from dataclasses import dataclass
from math import inf, pi, sqrt

import numpy as np
import pytest
from law_cases import CONTACTS
from power_law import PowerLaw
from some_rows import some

import roughsim as rs
from theory import flash, persson, plasticity
from theory.yielding import ELASTIC_BANDS

MODULUS = 1.1e11
SPECTRUM = PowerLaw(2e-27, (6e3, 2e4, 4e5), 0.7)
HEAT = {"friction_coefficient": 0.11, "conductivity": 30.0, "diffusivity": 7.6e-6}
PECLET = np.array([1e-3, 1.0, 1e3])


def slope(spectrum):
    q = np.geomspace(spectrum.breaks[0], spectrum.breaks[-1] * (1 - 1e-12), 200001)
    return sqrt(2 * pi * float(np.trapezoid(q**4 * spectrum(q), np.log(q))))


def at_load(load, spectrum=SPECTRUM):
    pressure = load * MODULUS * slope(spectrum)
    return persson.calibrated_spectrum(
        spectrum, effective_modulus=MODULUS, nominal_pressure=pressure
    )


@pytest.mark.parametrize("contact", some(CONTACTS["elastic"][::3], 6))
def test_measured_contacts_lie_within_the_error_bands(contact):
    spectrum = rs.SelfAffineSpectrum.from_rms_slope(
        1.0,
        hurst=contact["hurst"],
        q_min=1.0 / contact["plateau"],
        q_roll_off=1.0,
        q_max=contact["bandwidth"],
        roll_off_exponent=contact["low_exponent"],
    )
    load = contact["load"]
    law = persson.calibrated_spectrum(spectrum, effective_modulus=1.0, nominal_pressure=load)
    heat = {
        "friction_coefficient": load,
        "conductivity": 1.0,
        "diffusivity": 1.0,
        "nominal_pressure": load,
    }
    found = {
        name: np.abs(getattr(flash, name)(PECLET, stress_spectrum=law, **heat))
        for name in ("flash_temperature", "flash_gradient", "flash_width", "slope_length")
    }
    found["pressure_variance"] = persson.pressure_correlation(0.0, stress_spectrum=law)
    found["contact_fraction"] = law.contact_fraction
    assert set(found) == set(ELASTIC_BANDS)
    for name, value in found.items():
        np.testing.assert_allclose(value, contact[name]["value"], rtol=ELASTIC_BANDS[name])


def test_full_contact_has_the_stress_of_full_contact():
    q = np.geomspace(6.1e3, 3.9e5, 40)
    np.testing.assert_allclose(at_load(8.0)(q), (MODULUS * q / 2) ** 2 * SPECTRUM(q), rtol=2e-3)
    assert at_load(8.0).contact_fraction == pytest.approx(1.0, abs=1e-6)
    assert at_load(8.0).plastic_fraction == 0.0


def test_full_contact_is_approached_monotonically():
    whole = pi / 2 * MODULUS**2 * (slope(SPECTRUM) ** 2 / (2 * pi))  # g_σ(0) of full contact
    shares = [
        float(persson.pressure_correlation(0.0, stress_spectrum=at_load(p))) / whole
        for p in (0.1, 0.3, 0.6, 1.2)
    ]
    assert (np.diff(shares) > 0).all()
    assert shares[-1] == pytest.approx(1.0, abs=0.02)


def test_edges_make_a_tail_of_the_fourth_power():
    # elastic pressure falls to 0 at an edge as the root of the distance: |σ_q|² ~ q⁻⁴
    near, far = at_load(0.05)(np.array([20.0, 200.0]) * 4e5)
    assert near / far == pytest.approx(1e4, rel=1e-3)


def test_the_area_exceeds_that_of_full_contact_stress():
    law = at_load(0.05)
    whole = {"effective_modulus": MODULUS, "nominal_pressure": law.nominal_pressure}
    assert (
        1.05
        < law.contact_fraction / float(persson.contact_probability(4e5, SPECTRUM, **whole))
        < 1.6
    )


def test_a_hardness_out_of_reach_changes_nothing():
    solid = {"effective_modulus": MODULUS, "nominal_pressure": 0.05 * MODULUS * slope(SPECTRUM)}
    assert plasticity.stress_spectrum(SPECTRUM, **solid, penetration_hardness=1e13) == at_load(0.05)
    assert at_load(0.05).penetration_hardness == inf


def test_units_cancel():
    # pressures in units of E*, lengths in any unit: |σ_q|² scales as E*² m²
    base, q = at_load(0.05), np.geomspace(1e2, 1e8, 31)
    longer = PowerLaw(2e-27 * 1e4**4, tuple(x / 1e4 for x in SPECTRUM.q), 0.7)
    pressure = base.nominal_pressure / MODULUS
    other = persson.calibrated_spectrum(longer, effective_modulus=1.0, nominal_pressure=pressure)
    np.testing.assert_allclose(other(q / 1e4), base(q) / MODULUS**2 * 1e8, rtol=1e-8)


def test_it_is_a_value():
    spectrum = at_load(0.05)
    assert spectrum == at_load(0.05)
    assert hash(spectrum) == hash(at_load(0.05))
    q = np.geomspace(1e3, 1e6, 7)
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(spectrum))(q), spectrum(q))


@pytest.mark.parametrize(
    ("spectrum", "load", "name"),
    [
        (SPECTRUM, 0.0019, r"nominal_pressure/\(E\*h′\) = 0.0019"),
        (
            PowerLaw(2e-27, (6e3, 2e4, 4e5), 0.2),
            0.05,
            r"Hurst exponent by the slope of .* rad/m = 0.2",
        ),
        (PowerLaw(2e-27, (6e3, 7e3, 2.1e4), 0.7), 0.05, "q_max/q_min = 3.5"),
        (PowerLaw(2e-27, (6e3, 2e4, 1.4e6), 0.7), 0.05, "q_max/q_roll_off = 70"),
        (PowerLaw(2e-27, (1e3, 2e4, 4e5), 0.7, 2.0), 0.05, "q_roll_off/q_min = 20"),
    ],
)
def test_a_contact_unlike_those_that_were_compared_is_refused_by_name(spectrum, load, name):
    with pytest.raises(ValueError, match=f"^{name} lies outside"):
        at_load(load, spectrum)


def test_the_lightest_load_is_taken():
    assert at_load(0.0021).breaks


@dataclass(frozen=True)
class Gap:
    """A power law in which waves over a factor 2 of q are left out but for a share."""

    fill: float
    breaks: tuple[float, ...] = (6e3, 2e4, 6e4, 1.2e5, 4e5)

    def __call__(self, q):
        whole = PowerLaw(2e-27, (6e3, 2e4, 4e5), 0.7)(q)
        return whole * np.where((q > 6e4) & (q < 1.2e5), self.fill, 1.0)


def test_a_spectrum_with_a_gap_is_refused():
    solid = {"effective_modulus": MODULUS, "nominal_pressure": 1e9}
    assert persson.calibrated_spectrum(Gap(1.0), **solid).breaks
    for fill in (1e-3, 1e-2):
        with pytest.raises(
            ValueError, match=r"octaves of gaps in C\(q\) = .* lies outside 0 … 0\.5"
        ):
            persson.calibrated_spectrum(Gap(fill), **solid)
