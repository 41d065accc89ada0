from itertools import pairwise
from math import pi, sqrt

import mpmath as mp
import numpy as np
import pytest
from power_law import Flat, PowerLaw
from scipy.special import ellipk, i0e, j0

from theory import flash, persson

ALL = [
    flash.flash_temperature,
    flash.flash_gradient,
    flash.flash_laplacian,
    flash.flash_width,
    flash.slope_length,
]


def test_angular_integrals_agree_with_their_definition(reference):
    a, even, odd = np.array(reference["angular"]).T
    got = flash.angular_integrals(a)
    np.testing.assert_allclose(got[0], even, rtol=1e-14)
    np.testing.assert_allclose(got[1], odd, rtol=1e-14)


@pytest.mark.parametrize("a", [0.0, 1e-300, 1e-12, 1e-5, 0.02, 0.3, 7.0, 1e3, 1e8, 1e150, 1e300])
def test_angular_integrals_keep_all_digits_at_any_ratio(a):
    with mp.workdps(
        700
    ):  # the closed form of A cancels in B at small a, and 1 + a² needs 600 digits
        x = mp.mpf(a)
        h = mp.sqrt(1 + x * x)
        m = (h - 1) / (2 * h)
        even = mp.ellipk(m) / mp.sqrt(h)
        odd = (
            (even - mp.sqrt(h) * (2 * mp.ellipe(m) - mp.ellipk(m))) / x
            if a > 1e-200
            else -mp.pi * x / 8
        )
    got = flash.angular_integrals(a)
    assert got[0] == pytest.approx(float(even), rel=1e-14, abs=0)
    assert got[1] == pytest.approx(float(odd), rel=1e-14, abs=0)


def test_angular_integrals_are_even_and_odd():
    a = np.geomspace(1e-3, 1e3, 9)
    plus, minus = flash.angular_integrals(a), flash.angular_integrals(-a)
    assert (plus[0] == minus[0]).all()
    assert (plus[1] == -minus[1]).all()


def test_moments_agree_with_thirty_digits(case):
    speeds = case["given"]["speeds"]
    got = [f(speeds, case["spectrum"], **case["sliding"]) for f in ALL]
    exact = np.array(case["T, gradient, Laplacian"]).T
    for values, expected in zip(got, exact, strict=False):
        np.testing.assert_allclose(values, expected, rtol=1e-11)
    np.testing.assert_allclose(got[3], np.sqrt(-exact[0] / exact[2]), rtol=1e-11)
    np.testing.assert_allclose(got[4], -exact[0] / exact[1], rtol=1e-11)


def test_six_decades_without_roll_off(six_decades):
    got = flash.flash_temperature(1.0, six_decades["spectrum"], **six_decades["sliding"])
    assert got == pytest.approx(six_decades["T(1 m/s)"], rel=1e-10)
    assert got == pytest.approx(125.0520012, rel=1e-9)


def test_a_layer_far_thinner_than_a_panel_counts_in_proportion_to_its_thickness(six_decades):
    # T(σ₀) = T(0) + c σ₀ + O(σ₀²); at 1 mPa the linear term is 2e-10 of T
    sliding = six_decades["sliding"]
    pressures = [1e-30, 1e-3, 1e-2, 1e-1]
    rest, *others = (
        flash.flash_temperature(1.0, six_decades["spectrum"], **{**sliding, "nominal_pressure": p})
        for p in pressures
    )
    excess = np.array(others) / rest - 1
    assert excess[0] > 1e-10
    assert excess / excess[0] == pytest.approx([1, 10, 100], rel=2e-3)


def test_gamma_is_0_45_unless_said(case):
    sliding = {**case["sliding"], "gamma": 0.45}
    unsaid = {k: v for k, v in sliding.items() if k != "gamma"}
    for f in ALL:
        assert f(2.0, case["spectrum"], **unsaid) == f(2.0, case["spectrum"], **sliding)


def test_one_ring_of_waves_is_closed():
    # |σ_q|² on 1 ± 1e-7: T = (μv/κσ₀)(2/π) A g(0)/q, T' with B, ∇²T = −q² T
    q, v, a = 1e4, 3.0, 3.0 / 1e-5 / 1e4
    ring = Flat(1e8, (q * (1 - 1e-7), q * (1 + 1e-7)))
    given = {
        "nominal_pressure": 2e6,
        "friction_coefficient": 0.3,
        "conductivity": 20.0,
        "diffusivity": 1e-5,
    }
    variance = 2 * pi * q * 1e8 * 2e-7 * q
    even = float(mp.quad(lambda x: ((1 - 1j * a * mp.cos(x)) ** -0.5).real, [0, 1, mp.pi / 2]))
    odd = float(
        mp.quad(
            lambda x: (1j * mp.cos(x) * (1 - 1j * a * mp.cos(x)) ** -0.5).real, [0, 1, mp.pi / 2]
        )
    )
    factor = 0.3 * v / 20.0 / 2e6 * 2 / pi * variance
    exact = [factor * even / q, factor * odd, -factor * even * q, 1 / q, -even / odd / q]
    for f, expected in zip(ALL, exact, strict=True):
        assert f(v, stress_spectrum=ring, **given) == pytest.approx(expected, rel=1e-9)


def test_at_rest_there_is_no_heat_and_the_lengths_have_limits(case):
    spectrum, sliding = case["spectrum"], case["sliding"]
    for f in ALL[:3]:
        assert f(0.0, spectrum, **sliding) == 0.0
    assert flash.slope_length(0.0, spectrum, **sliding) == np.inf
    slow = flash.flash_width(1e-9, spectrum, **sliding)
    assert flash.flash_width(0.0, spectrum, **sliding) == pytest.approx(slow, rel=1e-9)


def test_the_slope_length_tends_to_four_diffusivities_over_speed(case):
    # the ratio of the next terms is −15a²/32 + 3a²/16 = −9a²/32, averaged: second order in speed
    diffusivity, q_min = case["body"]["diffusivity"], case["spectrum"].q[0]
    speeds = diffusivity * q_min * np.array([1e-2, 5e-3])
    excess = (
        flash.slope_length(speeds, case["spectrum"], **case["sliding"]) * speeds / 4 / diffusivity
        - 1
    )
    assert 0 < excess[1] < 9 / 32 * 2.6e-5
    assert excess[0] / excess[1] == pytest.approx(4, rel=1e-3)


def test_fast_sliding_falls_as_the_square_root(case):
    # T ∝ √v; K(1/2) = Γ(1/4)²/4√π; corrections of relative order Dq/v
    spectrum, sliding = case["spectrum"], case["sliding"]
    fast = 1e9 * case["body"]["diffusivity"] * spectrum.q[2] * np.array([1.0, 4.0])
    temperature = flash.flash_temperature(fast, spectrum, **sliding)
    assert temperature[1] / temperature[0] == pytest.approx(2, rel=1e-8)
    ratio = flash.slope_length(fast, spectrum, **sliding) / flash.flash_width(
        fast, spectrum, **sliding
    )
    assert (ratio > 1.8540746773 / 0.8472130848).all()  # Cauchy-Schwarz; equality for a ring


def test_reversed_sliding_is_the_mirror_image(case):
    spectrum, sliding = case["spectrum"], case["sliding"]
    plus, minus = ([f(sign * 2.0, spectrum, **sliding) for f in ALL] for sign in (1, -1))
    assert plus[1] < 0 < plus[0]
    assert minus == [plus[0], -plus[1], *plus[2:]]


def test_the_shape_of_the_speeds_is_kept(case):
    speeds = np.geomspace(1e-3, 1e3, 150)
    for f in ALL:
        flat = f(speeds, case["spectrum"], **case["sliding"])
        assert (
            f(speeds.reshape(3, 50), case["spectrum"], **case["sliding"]).tolist()
            == flat.reshape(3, 50).tolist()
        )
        assert isinstance(f(1.0, case["spectrum"], **case["sliding"]), float)
        assert f([], case["spectrum"], **case["sliding"]).shape == (0,)


class Bump:
    """A smooth band about 7000 rad/m: its correlation falls as a Gaussian, below 1e-16 at r = 0.012 m."""

    breaks = (2e3, 2e4)

    def __call__(self, q):
        return np.exp(-((np.log(q / 7e3) / 0.15) ** 2))


def test_temperature_is_the_correlation_weighted_by_the_field_of_a_moving_point():
    # T_flash = (μv/κσ₀) ∫ g_σ(r) e^(−z) I₀(z) dr, z = vr/2D: real space against wavenumbers
    given = {
        "nominal_pressure": 2e6,
        "friction_coefficient": 0.3,
        "conductivity": 20.0,
        "diffusivity": 1e-5,
    }
    x, w = np.polynomial.legendre.leggauss(24)
    edges = np.array(
        [0, 1e-5, 1e-4, 1e-3, 3e-3, 6e-3, 9e-3, 12e-3]
    )  # the kernel is 3e-6 m wide at the highest speed
    half = np.diff(edges)[:, None] / 2
    r = (edges[:-1, None] + half * (1 + x)).ravel()
    correlation = (half * w).ravel() * persson.pressure_correlation(r, stress_spectrum=Bump())
    for speed in 1e-5 * 7e3 * np.array([0.1, 3.0, 100.0]):
        expected = 0.3 * speed / 20.0 / 2e6 * (correlation @ i0e(speed * r / 2e-5))
        assert flash.flash_temperature(speed, stress_spectrum=Bump(), **given) == pytest.approx(
            expected, rel=1e-9
        )


def test_full_contact_does_not_depend_on_the_weight():
    # σ₀ ≫ √G: W = 1 for every γ, and T = (μv/κσ₀)E*² ∫ q² C A dq
    spectrum = PowerLaw(1e-25, (1e3, 1e4, 1e6), 0.8)
    half = float(persson.half_variance(1e6, spectrum, effective_modulus=1e9))
    given = {"effective_modulus": 1e9, "nominal_pressure": 1e3 * sqrt(half), "diffusivity": 1e-5}
    given |= {"friction_coefficient": 0.3, "conductivity": 20.0}
    temperatures = [
        flash.flash_temperature(1.0, spectrum, gamma=g, **given) for g in (0.0, 0.45, 1.0)
    ]
    assert temperatures == pytest.approx([temperatures[0]] * 3, rel=1e-14)
    resting = flash.flash_temperature(1e-9, spectrum, **given)
    # ∫ q² C dq of the two powers
    kink = 1e-25 * (1e12 - 1e9) / 3 + 1e-25 * 1e12 * (1e2**-0.6 - 1) / -0.6
    assert resting == pytest.approx(
        0.3 * 1e-9 / 20.0 / given["nominal_pressure"] * 1e18 * kink * pi / 2, rel=1e-10
    )


def test_uniform_stress_has_no_flash_temperature():
    given = {
        "nominal_pressure": 1.0,
        "friction_coefficient": 1.0,
        "conductivity": 1.0,
        "diffusivity": 1.0,
    }
    uniform = Flat(0.0, (1.0, 2.0))
    assert flash.flash_temperature(1.0, stress_spectrum=uniform, **given) == 0.0


def test_the_mean_square_of_the_temperature_over_directions_is_an_elliptic_integral():
    a = np.array([0.0, 1e-9, 0.02, 0.7, 1.0, 30.0, 1e5, 1e12, 1e200])
    got = flash.square_integral(a)
    assert got[0] == pi / 2
    with mp.workdps(700):
        for value, ratio in zip(got, a, strict=True):
            assert value == pytest.approx(float(mp.ellipk(-(mp.mpf(ratio) ** 2))), rel=1e-14, abs=0)
    np.testing.assert_array_equal(flash.square_integral(-a), got)
    # |1/√(1 − ia cos φ)|² summed over directions: the sum over a period converges fast
    angle = 2 * pi * np.arange(4000) / 4000
    for value, ratio in zip(got[:6], a[:6], strict=True):
        direct = np.mean(np.abs(1 / np.sqrt(1 - 1j * ratio * np.cos(angle))) ** 2)
        assert 2 / pi * value == pytest.approx(direct, rel=1e-12)


def test_the_rms_temperature_of_one_ring_of_waves_is_a_sum_over_directions():
    q, v, diffusivity = 1e4, 3.0, 1e-5
    ring = Flat(1e8, (q * (1 - 1e-7), q * (1 + 1e-7)))
    given = {
        "nominal_pressure": 2e6,
        "friction_coefficient": 0.3,
        "conductivity": 20.0,
        "diffusivity": diffusivity,
    }
    variance = 2 * pi * q * 1e8 * 2e-7 * q
    angle = 2 * pi * np.arange(4000) / 4000
    response = 1 / np.abs(q**2 - 1j * q * np.cos(angle) * v / diffusivity)
    exact = np.sqrt((0.3 * v / 20.0) ** 2 * variance * np.mean(response))
    for sign in (1, -1):
        assert flash.rms_temperature(sign * v, stress_spectrum=ring, **given) == pytest.approx(
            exact, rel=1e-9
        )
    r = np.array([0.0, 1e-4, 3e-4])
    got = flash.temperature_correlation(r, -v, stress_spectrum=ring, **given)
    np.testing.assert_allclose(got, exact**2 * j0(q * r), rtol=1e-8)


def test_the_rms_temperature_is_an_integral_over_panels_that_grow_from_each_break(case):
    """2π ∫ q |σ_q|² (μv/κq)² (2/π) K(−a²) dq; contact may be lost within a thin layer at the first break."""
    body, sliding = case["body"], case["sliding"]
    spectrum = case["spectrum"]
    load = {name: sliding[name] for name in ("effective_modulus", "nominal_pressure", "gamma")}
    for speed in (1e-3, 1.0, 50.0):
        total = 0.0
        x, w = np.polynomial.legendre.leggauss(40)
        for low, high in pairwise(spectrum.q):
            edges = low + (high - low) * np.append(0.0, np.geomspace(1e-13, 1.0, 120))
            for start, stop in pairwise(edges):
                q = 0.5 * (stop + start) + 0.5 * (stop - start) * x
                weight = persson.stress_weight(q, spectrum, **load)
                stress = (load["effective_modulus"] * q / 2) ** 2 * spectrum(q) * weight
                total += (
                    0.5
                    * (stop - start)
                    * np.sum(w * stress / q * ellipk(-((speed / body["diffusivity"] / q) ** 2)))
                )
        exact = sliding["friction_coefficient"] * speed / body["conductivity"] * np.sqrt(4 * total)
        assert flash.rms_temperature(speed, spectrum, **sliding) == pytest.approx(exact, rel=1e-8)


def test_the_correlation_of_the_temperature_begins_with_its_mean_square(case):
    spectrum, sliding = case["spectrum"], case["sliding"]
    longest = 2 * pi / spectrum.q[0]
    for speed in (1e-3, 2.0):
        square = flash.rms_temperature(speed, spectrum, **sliding) ** 2
        values = flash.temperature_correlation(
            [0.0, 1e-9 * longest, 0.5 * longest], speed, spectrum, **sliding
        )
        assert values[:2] == pytest.approx(square, rel=1e-9)
        assert abs(values[2]) < square
    assert flash.rms_temperature([0.0, 1.0], spectrum, **sliding)[0] == 0.0
