"""The law of contact that yields: exact cases, limits with their rates, and symmetries."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import j0, ndtr, ndtri, owens_t
from yielding_cases import HARDNESS, HEATING, MODULUS, InUnits, Rough, SelfAffine, law

from theory import flash, persson, plasticity
from theory.interface import diffuse, interface_law
from theory.scattering import BIN, scatter
from theory.walls import area_fractions
from theory.yielding import EDGE, YieldingSpectrum


def missing_from_full_yield(share, **spectrum):
    stress = law(SelfAffine(**spectrum), pressure=share * HARDNESS)
    return 1 - float(persson.pressure_correlation(0.0, stress_spectrum=stress)) / (
        share * (1 - share) * HARDNESS**2
    )


@pytest.mark.parametrize("share", [0.02, 0.1, 0.5])
def test_where_all_has_yielded_the_stress_varies_as_force_balance_wants(share):
    # a pressure that is 0 or sigma_P has the variance sigma_0 sigma_P - sigma_0^2
    assert missing_from_full_yield(share, hurst=0.5, q_max=4e9) == pytest.approx(0.0, abs=1e-11)


@pytest.mark.parametrize("share", [0.02, 0.1, 0.5])
def test_what_has_not_yielded_fades_with_the_variance_of_full_contact(share):
    # as exp(-D/7 sigma_P^2), D going with the level of C(q); what the law lacks without its edges falls slowly too
    q = np.geomspace(5e4, 2e6, 20001)
    full = (
        (MODULUS / 2) ** 2
        * 2
        * np.pi
        * np.trapezoid(q**3 * SelfAffine(level=1.0, q_max=2e6)(q), q)
        / HARDNESS**2
    )
    variances = np.array([15.0, 30.0, 60.0])
    missing = [missing_from_full_yield(share, level=x / full, q_max=2e6) for x in variances]
    rates = -np.diff(np.log(missing)) / np.diff(variances)
    assert (rates > 1 / 7).all()
    assert (rates < 1.35 / 7).all()


def test_stress_behind_a_soft_half_space_is_that_of_the_bearing_set():
    # sigma = sigma_P on the highest points of a Gaussian surface: g = sigma_P^2 (Phi_2(t; rho) - A^2); at no speed
    # <T sigma> ~ int g dr; the edges of a set that is sharp are seen up to a few percent
    share, spectrum = 0.1, SelfAffine(hurst=0.5, q_max=4e6)
    stress = law(spectrum, modulus=1e5 * MODULUS, pressure=share * HARDNESS)
    q = np.geomspace(*spectrum.breaks[::2], 3001)
    power = 2 * np.pi * q**2 * spectrum(q)
    r = np.unique(np.concatenate([np.linspace(0, 3e-6, 400), np.linspace(3e-6, 6e-4, 3000)]))
    correlation = np.array([np.trapezoid(power * j0(q * x), np.log(q)) for x in r])
    rho = np.clip(correlation / correlation[0], -1.0, 1.0)
    joint = share - 2 * owens_t(-ndtri(share), np.sqrt((1 - rho) / (1 + rho)))
    exact = np.trapezoid(joint - share**2, r) * HARDNESS**2
    q = np.geomspace(stress.breaks[0], stress.breaks[-1], 20001)
    assert np.trapezoid(2 * np.pi * q * stress(q), np.log(q)) == pytest.approx(exact, rel=0.06)


class Ending(SelfAffine):
    """The same C(q), zero beyond q_max."""

    def __call__(self, q):
        return np.where(q > self.q_max, 0.0, super().__call__(q))


def test_flash_temperature_falls_smoothly_with_q_max_where_nothing_lies_beyond():
    # exp(ln q_max) exceeds q_max by rounding at about half of these ends: there C was taken as zero
    ends = 1e6 * 2 ** (np.arange(9) / 8)
    assert {bool(np.exp(np.log(q)) > q) for q in ends} == {False, True}
    laws = [law(Ending(level=3e-25, q_max=q), pressure=0.02 * HARDNESS) for q in ends]
    heat = {"nominal_pressure": 0.02 * HARDNESS, **HEATING}
    steps = np.diff(
        np.log(
            [float(flash.flash_temperature(1e8, stress_spectrum=stress, **heat)) for stress in laws]
        )
    )
    assert np.abs(np.diff(steps)).max() < 5e-4  # of steps of -4e-3; 1.6e-3 with that


def test_the_mean_pressure_is_kept_and_probabilities_sum_to_one():
    diffusion = diffuse(SelfAffine(), MODULUS, 0.1 * HARDNESS, HARDNESS)
    assert diffusion.probability @ diffusion.pressure == pytest.approx(0.1 * HARDNESS, rel=1e-11)
    assert diffusion.probability.sum(axis=1) == pytest.approx(1.0, abs=1e-12)


def test_full_contact_has_the_stress_of_full_contact():
    errors = []
    for level in (1e-29, 1e-30):
        spectrum = SelfAffine(level=level, q_max=1e6)
        stress = law(spectrum, hardness=1e11, pressure=0.5e11)
        q = np.geomspace(5.01e4, 9.9e5, 40)
        errors.append(np.abs(stress(q) / ((MODULUS * q / 2) ** 2 * spectrum(q)) - 1).max())
    assert errors[-1] < 3e-5


def test_at_the_load_of_full_yield_the_stress_is_uniform():
    variances = [
        float(
            persson.pressure_correlation(0.0, stress_spectrum=law(pressure=(1 - rest) * HARDNESS))
        )
        for rest in (1e-2, 1e-3, 1e-4)
    ]
    assert (np.array(variances) < HARDNESS**2 * np.array([1e-2, 1e-3, 1e-4])).all()
    assert variances[0] / variances[1] == pytest.approx(10.0, rel=0.02)
    assert variances[1] / variances[2] == pytest.approx(10.0, rel=0.02)


def test_stiff_roughness_obeys_the_bearing_law():
    # far above the compliance of the half-space sigma = sigma_P Phi(-d/h): E = 1 at every pressure
    z = np.arange(-6.0, 6.01, 0.15)
    variance = np.geomspace(1e-12, 1e-16, 60)
    assert interface_law(z, variance, np.full(60, 1e-13))[0] == pytest.approx(1.0, abs=2e-5)


def test_the_law_of_one_wavenumber_is_a_bed_of_springs():
    # one w = 2/E*q throughout: sigma_v = sigma_eta_eta/2, so that springs of E*q/2 under Gaussian heights are exact
    z = np.arange(-5.0, 5.01, 0.05)
    variance = np.geomspace(1.0, 3e-3, 400)
    sigma = np.linspace(9.0, -9.0, 4001)

    def touched(t):
        return np.exp(-(t**2) / 2) / np.sqrt(2 * np.pi) - t * ndtr(-t)

    share = (
        touched(-sigma) - touched(-sigma + 1.0)
    ) / 1.0  # of sigma_P, two walls one unit apart, h = 1
    inside = ndtr(sigma) - ndtr(sigma - 1.0)
    at = np.interp(ndtr(z), share[::-1], inside[::-1])
    compliance = 1 / at - 1
    expected = compliance * np.exp(-(z**2) / 2) / np.sqrt(2 * np.pi)
    middle = np.abs(z) < 3.5
    assert interface_law(z, variance, np.ones(400))[0][middle] == pytest.approx(
        expected[middle], rel=5e-3
    )


@pytest.mark.parametrize(("length", "stress"), [(1e6, 1.0), (1.0, 1e-9)])
def test_units_do_not_matter(length, stress):
    units = {
        "modulus": MODULUS * stress,
        "pressure": 0.1 * HARDNESS * stress,
        "hardness": HARDNESS * stress,
    }
    q = np.geomspace(1e3, 1e8, 50)
    scaled = law(InUnits(SelfAffine(), length), **units)(q / length)
    assert scaled / (stress * length) ** 2 == pytest.approx(law()(q), rel=1e-7)


def test_more_load_is_more_contact_and_more_of_it_yields():
    contact, plastic = np.array(
        [
            (stress.contact_fraction, stress.plastic_fraction)
            for stress in (
                law(SelfAffine(q_max=1e6), pressure=s * HARDNESS)
                for s in (0.01, 0.03, 0.1, 0.3, 0.6)
            )
        ]
    ).T
    assert (np.diff(contact) > 0).all()
    assert (np.diff(plastic) > 0).all()
    assert (plastic < contact).all()


def test_where_no_pressure_reaches_the_hardness_contact_is_elastic():
    given = {"effective_modulus": MODULUS, "nominal_pressure": 4e8}
    spectrum = SelfAffine(level=1e-27, q_max=2e6)
    elastic = persson.calibrated_spectrum(spectrum, **given)
    assert plasticity.stress_spectrum(spectrum, **given, penetration_hardness=1e12) == elastic


def test_the_law_goes_over_into_elastic_contact_within_its_error_band():
    speed = np.array([1e-8, 1e5, 1e8])
    spectrum = SelfAffine(level=1e-27, q_max=2e6)
    given = {"effective_modulus": MODULUS, "nominal_pressure": 4e8}
    elastic = persson.calibrated_spectrum(spectrum, **given)
    hard = law(spectrum, pressure=4e8, hardness=1e11)
    heat = {"nominal_pressure": 4e8, **HEATING}
    ratio = flash.flash_temperature(speed, stress_spectrum=hard, **heat) / flash.flash_temperature(
        speed, stress_spectrum=elastic, **heat
    )
    assert ratio == pytest.approx(1.0, abs=0.07)


def times_a_step(stress, x, q_max):
    # q^3 |sigma_q|^2 at q = x q_max: constant for edges that are steps
    return np.array(x) ** 3 * stress(np.array(x) * q_max)


def inverse_width_of_rims(spectrum, modulus):
    # (E* h'/sigma_P)^2, over q_max
    q = np.geomspace(5e4, 2e5, 20001)
    return (modulus / HARDNESS) ** 2 * 2 * np.pi * np.trapezoid(q**3 * spectrum(q), q)


def test_part_of_the_sidebands_above_q_max_lies_in_the_tail_of_edges():
    spectrum = SelfAffine(q_max=2e5)
    stress, rim = law(spectrum), inverse_width_of_rims(spectrum, MODULUS)
    inside, outside = stress(np.array([2e5 * (1 - 1e-9), 2e5 * (1 + 1e-9)]))
    full = (MODULUS * 1e5) ** 2 * spectrum(np.array(2e5))
    tail = times_a_step(stress, [200.0], 2e5)[0] * (1 + 200 / rim) / (1 + 1.7**8) / (1 + 1 / rim)
    assert tail < 0.1 * outside
    assert 0.0 < (outside - tail) / (1 - EDGE) < inside < (outside - tail) / (1 - EDGE) + full
    assert float(stress(4e4)) < float(stress(6e4))
    assert float(stress(60.0)) == pytest.approx(
        float(stress(1.5e4)), rel=1e-12
    )  # shot noise: constant


@pytest.mark.parametrize("modulus", [0.5 * MODULUS, 2 * MODULUS, 10 * MODULUS, 1e3 * MODULUS])
def test_edges_are_steps_but_for_rims_in_which_elastic_pressure_rises(modulus):
    # a step makes |sigma_q|^2 ~ q^-3, a pressure that rises as the root of the distance q^-4
    spectrum = SelfAffine(q_max=2e5)
    rim = inverse_width_of_rims(spectrum, modulus)
    near, far = times_a_step(law(spectrum, modulus=modulus), [50.0, 500.0], 2e5)
    assert near / far == pytest.approx((1 + 500 / rim) / (1 + 50 / rim), rel=1e-3)


def test_the_tail_of_edges_begins_where_sums_of_two_waves_end():
    # in a contact that has all yielded the tail is that of steps: half of it has set in at 1.7 q_max
    spectrum = SelfAffine(q_max=2e5)
    stress = law(spectrum, modulus=1e3 * MODULUS)
    place, value, _ = scatter(
        diffuse(spectrum, 1e3 * MODULUS, 0.1 * HARDNESS, HARDNESS), 1e3 * MODULUS
    ).sidebands
    x = np.array([1.7, 100.0])
    beside = (
        (1 - EDGE)
        * np.interp(np.log(x * 2e5), place, np.exp(value), right=0.0)
        * stress._balance.scale
    )
    near, far = x**3 * (stress(x * 2e5) - beside)
    assert near / far == pytest.approx(0.5, rel=0.05)


def test_roughness_without_end_has_a_limit():
    # what is still elastic falls as q_max^(H - 1), and the steps leave 1 % open
    q = np.geomspace(1e2, 1e7, 30)
    limit, *further = (law(SelfAffine(hurst=0.5, q_max=q_max))(q) for q_max in (4e9, 4e11, 4e13))
    for spectrum in further:
        assert 2 * np.trapezoid(np.abs(spectrum - limit) * q**2, np.log(q)) < 0.03 * np.trapezoid(
            (spectrum + limit) * q**2, np.log(q)
        )


def test_edges_take_their_share_from_the_sidebands_and_nothing_is_lost():
    # far from yielding nothing is added, so that the variance is what the waves make at their own place and beside it
    given = (SelfAffine(level=1e-27, q_max=2e6), MODULUS, 3e7, 1e14)
    made_of = scatter(diffuse(*given), MODULUS)
    q = np.geomspace(*given[0].breaks[::2], 20001)
    coherent = np.exp(np.interp(np.log(q), made_of.coherent.place, made_of.coherent.value))
    whole = np.trapezoid(
        2 * np.pi * q**2 * (MODULUS * q / 2) ** 2 * given[0](q) * coherent, np.log(q)
    )
    other = np.exp(made_of.sidebands.place)
    area = 2 * np.pi * other**2 * BIN
    beside_them = np.exp(made_of.sidebands.value) @ np.append(np.pi * other[0] ** 2, area[1:])
    assert beside_them > 0.1 * whole
    variance = float(persson.pressure_correlation(0.0, stress_spectrum=YieldingSpectrum(*given)))
    assert variance == pytest.approx(whole + beside_them, rel=0.005)


def test_the_variance_never_exceeds_what_force_balance_leaves():
    # E* = 1, q_r = 1: what the waves make is 0.4 % more
    spectrum = InUnits(SelfAffine(level=1e20, hurst=0.9675, q_min=1e5 / 1.697, q_max=1e10), 1e5)
    stress = YieldingSpectrum(spectrum, 1.0, 0.05527 * 1.622659, 1.622659)
    variance = float(persson.pressure_correlation(0.0, stress_spectrum=stress))
    assert variance == pytest.approx(0.05527 * (1 - 0.05527) * 1.622659**2, rel=1e-9)
    assert stress._balance.scale < 1.0


def test_the_tail_leaves_what_force_balance_leaves():
    # the roughness stiff: all has yielded, and the tail has what the waves lack
    stress = law(SelfAffine(q_max=2e5), modulus=1e15, pressure=0.5 * HARDNESS)
    variance = float(persson.pressure_correlation(0.0, stress_spectrum=stress))
    assert variance == pytest.approx(0.25 * HARDNESS**2, rel=1e-9)


@pytest.mark.parametrize(("share", "q_max"), [(0.1, 3e5), (0.6, 2e6)])
def test_the_areas_are_those_of_a_pressure_between_absorbing_walls_with_the_variance_of_the_spectrum(
    share, q_max
):
    stress = law(SelfAffine(q_max=q_max), pressure=share * HARDNESS)
    variance = float(persson.pressure_correlation(0.0, stress_spectrum=stress)) / HARDNESS**2
    pressure = np.linspace(0.0, 1.0, 4001)

    def excess(g):
        elastic = plasticity.stress_distribution(pressure, g, share, 1.0)
        plastic = float(area_fractions(g, share, 1.0)[2])
        return float(np.trapezoid(elastic * pressure**2, pressure)) + plastic - share**2 - variance

    _, elastic, plastic = area_fractions(brentq(excess, 1e-4, 3.0), share, 1.0)
    assert stress.plastic_fraction == pytest.approx(float(plastic), rel=2e-3)
    assert stress.between_walls() == pytest.approx((float(elastic), float(plastic)), rel=2e-3)


@pytest.mark.parametrize(
    ("spectrum", "pressure", "hardness", "area"),
    [
        (Rough(2.164e-21, 0.6132, 1.822, 4.0), 79.23e6, np.inf, 0.0937),
        (Rough(1.106e-21, 0.9642, 1.336, 4.0), 304.2e6, np.inf, 0.6577),
        (Rough(2.112e-22, 0.3434, 2.35, 4.0), 183.7e6, 934e6, 0.4067),  # 10 % yields
        (Rough(6.682e-21, 0.6481, 1.075, 4.0), 301.1e6, 1051e6, 0.4087),  # 43 %
    ],
)
def test_the_contact_area_is_that_of_solved_contacts(spectrum, pressure, hardness, area):
    # 12 faces each with 12 and 24 pixels per shortest wave, without the strip along edges; they scatter by up to 1 %
    stress = law(spectrum, pressure=pressure, hardness=hardness)
    assert stress.contact_fraction == pytest.approx(area, rel=0.02)
