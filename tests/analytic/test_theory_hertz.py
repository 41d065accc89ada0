"""Moving Hertz, disc and square sources: exact values, limits with their rates, symmetry."""

import json
from math import asinh, pi, sqrt
from pathlib import Path

import mpmath as mp
import numpy as np
import pytest
from scipy import integrate

from theory import hertz
from theory.hertz import graded
from theory.quadrature import QuadratureError

REFERENCE = json.loads((Path(__file__).parents[1] / "reference" / "hertz.json").read_text())
FUNCTIONS = {
    "hertz": {
        "T_flash": hertz.flash_temperature,
        "slope": hertz.flash_gradient,
        "laplacian": hertz.flash_laplacian,
        "T_av": hertz.mean_temperature,
        "T_max": hertz.max_temperature,
        "x_max": hertz.hottest_point,
    },
    "disc": {
        "T_av": hertz.disc_mean_temperature,
        "T_max": hertz.disc_max_temperature,
        "x_max": hertz.disc_hottest_point,
    },
    "square": {
        "T_av": hertz.square_mean_temperature,
        "T_max": hertz.square_max_temperature,
        "x_max": hertz.square_hottest_point,
    },
}
MOMENTS = [hertz.flash_temperature, hertz.flash_laplacian, hertz.mean_temperature]
MEANS = [*MOMENTS, hertz.disc_mean_temperature, hertz.square_mean_temperature]
MAXIMA = [hertz.max_temperature, hertz.disc_max_temperature, hertz.square_max_temperature]


@pytest.mark.parametrize("peclet", [0.1, 1.0, 10.0, 1000.0])
@pytest.mark.parametrize("source", ["hertz", "disc", "square"])
def test_moving_sources_agree_with_routes_of_their_own(source, peclet):
    for name, exact in REFERENCE["peclet"][f"{peclet:g}"][source].items():
        if name == "x_max":  # the maximum is flat: its place is known to the root of its accuracy
            assert FUNCTIONS[source][name](peclet) == pytest.approx(exact, abs=1e-6)
        else:
            assert FUNCTIONS[source][name](peclet) == pytest.approx(exact, rel=1e-11, abs=0), name


def test_the_resting_hertz_source_is_closed():
    # Eqs. (13) to (18): T = (π/4)(1 − r²/2), ∇²T = −π/2 within the contact
    assert hertz.flash_temperature(0.0) == pytest.approx(pi / 5, rel=1e-14)
    assert hertz.max_temperature(0.0) == pytest.approx(pi / 4, rel=1e-13)
    assert hertz.mean_temperature(0.0) == pytest.approx(3 * pi / 16, rel=1e-14)
    assert hertz.flash_laplacian(0.0) == pytest.approx(-pi / 2, rel=1e-13)
    assert hertz.flash_gradient(0.0) == 0.0
    assert hertz.flash_width(0.0) == pytest.approx(sqrt(0.4), rel=1e-13)
    assert hertz.slope_length(0.0) == np.inf
    assert hertz.hottest_point(0.0) == 0.0


def test_the_resting_uniform_sources_are_closed():
    # disc: 1 and 8/3π; square: (4/π) asinh 1, and its mean less (4/3π)(√2 − 1)
    assert hertz.disc_max_temperature(0.0) == pytest.approx(1.0, rel=1e-13)
    assert hertz.disc_mean_temperature(0.0) == pytest.approx(8 / 3 / pi, rel=1e-14)
    top = 4 / pi * asinh(1)
    assert hertz.square_max_temperature(0.0) == pytest.approx(top, rel=1e-13)
    mean = 4 / pi * (asinh(1) - (sqrt(2) - 1) / 3)
    assert hertz.square_mean_temperature(0.0) == pytest.approx(mean, rel=1e-13)
    assert (
        hertz.SQUARE_STATIC.max_temperature,
        hertz.SQUARE_STATIC.mean_temperature,
    ) == pytest.approx((top, mean), rel=1e-15)
    assert (hertz.DISC_STATIC.max_temperature, hertz.DISC_STATIC.mean_temperature) == (
        1.0,
        8 / 3 / pi,
    )


def test_the_constants_at_rest_are_the_papers():
    rest = hertz.STATIC
    assert rest.flash_temperature / rest.max_temperature == pytest.approx(0.8, rel=1e-15)
    printed = [
        rest.per_power(t)
        for t in (rest.flash_temperature, rest.max_temperature, rest.mean_temperature)
    ]
    assert printed == pytest.approx([0.3, 0.375, 0.28125], rel=1e-15)
    assert -rest.flash_laplacian / rest.flash_temperature == pytest.approx(2.5, rel=1e-15)
    assert (rest.flash_width, rest.slope_length, rest.flash_gradient) == (sqrt(0.4), np.inf, 0.0)


def test_the_fast_constants_are_the_integrals_of_the_appendix():
    exact, fast = REFERENCE["fast"], hertz.FAST
    assert fast.flash_temperature == pytest.approx(exact["T_flash"], rel=1e-14)
    assert fast.max_temperature == pytest.approx(exact["T_max"], rel=1e-14)
    assert fast.mean_temperature == pytest.approx(exact["T_av"], rel=1e-14)
    assert fast.flash_gradient == pytest.approx(exact["slope"], rel=1e-11)
    assert fast.hottest_point == pytest.approx(exact["x_max"], rel=1e-12)
    assert hertz.DISC_FAST.mean_temperature == pytest.approx(exact["disc_T_av"], rel=1e-14)
    assert fast.slope_length == pytest.approx(
        -fast.flash_temperature / fast.flash_gradient, rel=1e-14
    )
    assert -fast.flash_laplacian / fast.flash_temperature == pytest.approx(81 / 16, rel=1e-15)
    assert fast.flash_width == pytest.approx(4 / 9, rel=1e-15)


def test_the_fast_constants_in_the_papers_units():
    fast = hertz.FAST
    printed = [
        fast.per_power(t)
        for t in (fast.flash_temperature, fast.max_temperature, fast.mean_temperature)
    ]
    assert printed == pytest.approx([0.3551657979, 0.5894875468, 0.3230079563], abs=5e-11)
    assert fast.flash_temperature * sqrt(pi) == pytest.approx(1.3184531039, abs=5e-11)
    assert fast.slope_length / fast.flash_width == pytest.approx(3.0638154613, abs=5e-11)


@pytest.mark.parametrize(
    ("function", "limit", "rate"),
    [
        (hertz.flash_temperature, hertz.FAST.flash_temperature, -1.0),
        (hertz.flash_gradient, hertz.FAST.flash_gradient, -1.0),
        (hertz.flash_laplacian, hertz.FAST.flash_laplacian, -0.5),
        (hertz.mean_temperature, hertz.FAST.mean_temperature, -1.0),
        (hertz.square_mean_temperature, hertz.SQUARE_FAST.mean_temperature, -0.5),
    ],
)
def test_the_fast_limit_is_approached_at_its_rate(function, limit, rate):
    # heat that leaves sideways within the contact: R(Pe)^(−1/2) wide; the rim has no flux, so T_flash errs only as 1/Pe
    peclet = np.array([1e5, 1e6, 1e7])
    error = 1 - function(peclet) * np.sqrt(peclet) / limit
    assert (error > 0.0).all()
    assert np.polyfit(np.log(peclet), np.log(error), 1)[0] == pytest.approx(rate, abs=0.1)
    far = np.array([1e20, 1e25, 0.999e30, 1e30, 1e100, 1e300])
    np.testing.assert_allclose(function(far) * np.sqrt(far), limit, rtol=1e-9)
    np.testing.assert_allclose(function(far[3:]) * np.sqrt(far[3:]), limit, rtol=1e-13)


def test_the_curvature_errs_as_three_point_nine_over_root_peclet():
    ratio = -hertz.flash_laplacian(1e8) / hertz.flash_temperature(1e8)
    assert (81 / 16 - ratio) * 1e4 == pytest.approx(3.9, abs=0.2)


@pytest.mark.parametrize("source", ["hertz", "disc", "square"])
def test_the_fast_limit_of_a_maximum_is_approached_as_one_over_peclet(source):
    limits = {"hertz": hertz.FAST, "disc": hertz.DISC_FAST, "square": hertz.SQUARE_FAST}
    peclet = np.array([1e2, 1e3, 1e4]) if source != "square" else np.array([1e3, 1e4, 1e5])
    limit, top = limits[source], FUNCTIONS[source]["T_max"]
    error = np.abs(1 - top(peclet) * np.sqrt(peclet) / limit.max_temperature)
    assert np.polyfit(np.log(peclet), np.log(error), 1)[0] == pytest.approx(-1, abs=0.15)
    for far in (0.99e12, 1e12, 1e200):
        assert top(far) * sqrt(far) == pytest.approx(limit.max_temperature, rel=1e-11)
    assert FUNCTIONS[source]["x_max"](-1e13) == -limit.hottest_point


def test_slow_sliding_tilts_the_temperature_in_proportion():
    # d_flash → 4D/v, any source; the hottest point moves by T′/T″ at the centre
    for peclet in (1e-12, 1e-6, 1e-3):
        assert hertz.slope_length(peclet) * peclet == pytest.approx(4, rel=3 * peclet + 1e-12)
    assert hertz.flash_temperature(1e-6) == pytest.approx(
        pi / 5 * (1 - 1e-6 / (2 * pi / 5) / 3), rel=1e-12
    )


@pytest.mark.parametrize("function", [*MEANS, *MAXIMA, hertz.flash_width, hertz.slope_length])
def test_temperatures_do_not_depend_on_the_direction(function):
    assert function(-3.7) == function(3.7)
    assert function([[3.7, -0.2]]).shape == (1, 2)
    assert isinstance(function(3.7), float)


@pytest.mark.parametrize(
    "function",
    [
        hertz.flash_gradient,
        hertz.hottest_point,
        hertz.disc_hottest_point,
        hertz.square_hottest_point,
    ],
)
def test_the_heat_trails_the_source(function):
    assert function(5.0) < 0.0
    assert function(-5.0) == -function(5.0)


def test_many_speeds_are_the_same_as_one_at_a_time():
    peclet = np.geomspace(1e-3, 1e5, 150).reshape(3, 50)
    for function in (*MEANS, hertz.flash_gradient):
        values = function(peclet)
        assert values.shape == peclet.shape
        for index in ((0, 0), (1, 17), (2, 49)):
            assert values[index] == pytest.approx(function(float(peclet[index])), rel=1e-14)
    assert hertz.flash_temperature([]).shape == (0,)


def test_the_flash_temperature_lies_between_the_mean_and_the_maximum():
    for peclet in (0.0, 0.3, 4.0, 300.0, 1e7):
        mean, flash, top = (
            f(peclet)
            for f in (hertz.mean_temperature, hertz.flash_temperature, hertz.max_temperature)
        )
        assert mean < flash < top


def test_the_laplacian_is_that_of_the_resting_map():
    # five-point Laplacian of the map, weighted with the flux, at rest: exact within the paraboloid
    step, r = 1e-3, 0.4
    east, west, north, centre = (
        hertz.static_temperature(x, y)
        for x, y in ((r + step, 0.0), (r - step, 0.0), (r, step), (r, 0.0))
    )
    assert (east + west + 2 * north - 4 * centre) / step**2 == pytest.approx(-pi / 2, rel=1e-7)


@pytest.mark.parametrize("r", [0.0, 0.3, 0.999999, 1.0, 1.000001, 1.7, 5.99, 6.01, 40.0])
def test_the_resting_map_is_the_potential_of_the_source(r):
    # T = ∫ q̇ dρ ρ ∮ dφ/2π|..| with the closed ring potential (4/2π)K(m)/(r + ρ), m = 4rρ/(r + ρ)²
    def ring(rho):
        m = 4 * r * rho / (r + rho) ** 2
        return mp.sqrt(1 - rho * rho) * rho * 2 / mp.pi * (mp.ellipk(m) if m < 1 else 0) / (r + rho)

    exact = float(mp.re(mp.quad(ring, sorted({0.0, min(r, 1.0), 1.0}))))
    assert hertz.static_temperature(r, 0.0) == pytest.approx(exact, rel=1e-8)
    assert hertz.static_temperature(-0.6 * r, 0.8 * r) == pytest.approx(
        hertz.static_temperature(r, 0.0), rel=1e-12
    )


def test_far_away_the_resting_source_is_a_point():
    # Q̇/2πr with Q̇ = 2π/3
    assert hertz.static_temperature(1e6, 0.0) == pytest.approx(1 / 3e6, rel=1e-12)


def test_the_fast_map_is_the_integral_of_the_appendix():
    for place, exact in REFERENCE["fast"]["line"]:
        assert hertz.fast_temperature(-place, 0.0) == pytest.approx(exact, rel=1e-12)
        half = sqrt(1 - 0.6**2)  # f(x, y) = s^(3/2) F(x/s)
        assert hertz.fast_temperature(-place * half, 0.6) == pytest.approx(
            exact * half**1.5, rel=1e-12
        )


def test_the_fast_map_is_cold_ahead_and_beside_and_hottest_behind_the_centre():
    x = np.linspace(-3, 3, 601)
    line = hertz.fast_temperature(x, 0.0)
    assert (line[x >= 1.0] == 0.0).all()
    assert line.max() == pytest.approx(hertz.FAST.max_temperature, rel=1e-5)
    assert x[line.argmax()] == pytest.approx(hertz.FAST.hottest_point, abs=0.01)
    assert (hertz.fast_temperature(x, 1.0) == 0.0).all()
    assert (hertz.fast_temperature(x, -1.5) == 0.0).all()
    np.testing.assert_array_equal(hertz.fast_temperature(x, 0.3), hertz.fast_temperature(x, -0.3))
    assert hertz.fast_temperature(x[:, None], np.zeros(4)).shape == (601, 4)


def test_far_behind_a_fast_source_the_track_cools_as_the_root():
    # ∫√(1−u²) du = π/2 deposited at once: T → (π/2)(1/√x)/√π
    assert hertz.fast_temperature(-1e8, 0.0) == pytest.approx(sqrt(pi) / 2 / 1e4, rel=1e-12)


def test_the_map_averages_to_the_moments():
    # Gauss in both directions over the contact, x = s sin, y = sin: T_flash, T_av of the fast limit
    nodes, weights = np.polynomial.legendre.leggauss(200)
    angle, weights = nodes * pi / 2, weights * pi / 2
    y, x = np.sin(angle)[:, None], np.sin(angle) * np.cos(angle)[:, None]
    area = weights[:, None] * weights * np.cos(angle)[:, None] ** 2 * np.cos(angle)
    field, flux = hertz.fast_temperature(x, y), np.sqrt(1 - x**2 - y**2)
    assert (field * area).sum() / pi == pytest.approx(hertz.FAST.mean_temperature, rel=1e-6)
    assert (field * flux * area).sum() / (2 * pi / 3) == pytest.approx(
        hertz.FAST.flash_temperature, rel=1e-6
    )


@pytest.mark.parametrize("r", [0.0, 0.3, 1.0, 1.9])
def test_the_pair_correlation_is_the_overlap_of_two_pressures(r):
    def product(x, y):  # a quarter of the lens in which both contacts press
        return sqrt(max(1 - (x - r / 2) ** 2 - y**2, 0)) * sqrt(max(1 - (x + r / 2) ** 2 - y**2, 0))

    quarter, _ = integrate.dblquad(
        product, 0, sqrt(1 - r**2 / 4), 0, lambda y: sqrt(max(1 - y**2, 0)) - r / 2, epsabs=1e-9
    )
    assert hertz.pressure_correlation(r) == pytest.approx(4 * quarter / (pi / 2), abs=1e-7)


def test_the_pair_correlation_is_zero_beyond_the_diameter():
    np.testing.assert_array_equal(hertz.pressure_correlation([2.0, 2.1, 1e3]), 0.0)
    # the parabolas of both lines touch: (2 − r)^(5/2)
    near = hertz.pressure_correlation([2 - 1e-2, 2 - 4e-2])
    assert near[1] / near[0] == pytest.approx(32, rel=0.02)


def test_an_integrand_that_the_panels_do_not_resolve_is_refused():
    rule = graded.rule(np.linspace(0, 1, 3))
    assert rule.integral(np.exp) == pytest.approx(np.e - 1, rel=1e-14)
    with pytest.raises(QuadratureError, match="relative error"):
        rule.integral(lambda x: np.sin(500 * x) ** 2)


@pytest.mark.parametrize("function", [*MEANS, *MAXIMA, hertz.flash_gradient, hertz.hottest_point])
@pytest.mark.parametrize(
    ("value", "error"),
    [(np.nan, ValueError), (np.inf, ValueError), ("1", TypeError), (1j, TypeError)],
)
def test_impossible_peclet_numbers_are_refused(function, value, error):
    with pytest.raises(error, match="peclet"):
        function(value)
