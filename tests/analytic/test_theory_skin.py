"""A skin on the bodies and heat released in depth, in the theory: one ring of waves, image series and limits."""

from math import pi, sqrt

import numpy as np
import pytest
import scipy
from power_law import Flat

from roughsim.heat.skin import Layering, direction_means
from theory import background, flash, partition
from theory.skin import direction_mean, even_part, layers_of, odd_part, square_part

Q = 1e5
RING = Flat(1e8, (Q * (1 - 1e-7), Q * (1 + 1e-7)))
VARIANCE = 2 * pi * Q * 1e8 * 2e-7 * Q  # 2π ∫ q |σ_q|² dq
BODY = {"conductivity": 46.0, "diffusivity": 1.2e-5}
GIVEN = {"nominal_pressure": 2e6, "stress_spectrum": RING}
SLIDING = {**GIVEN, **BODY, "friction_coefficient": 0.2}
OXIDE = (3e-6, 3.0, 9e-7)
COSINES = np.cos((np.arange(4000) + 0.5) * pi / 4000)
SPEED = 5.0


def roots(cosine=COSINES, skin=OXIDE):
    return [np.sqrt(Q**2 - 1j * Q * cosine * SPEED / d) for d in (BODY["diffusivity"], skin[2])]


def responses(skin=OXIDE):
    """T/q̇ of the ring by heat at the surface, in all directions of sliding: two layers in series."""
    below, within = roots(skin=skin)
    outer, inner, lag = BODY["conductivity"] * below, skin[1] * within, np.tanh(within * skin[0])
    return (inner + outer * lag) / (inner * (outer + inner * lag))


def test_a_ring_of_waves_has_all_moments_of_its_response():
    heat = 0.2 * SPEED * VARIANCE / 2e6
    even = responses().real.mean()
    odd = (1j * Q * COSINES * responses()).real.mean()
    square = (np.abs(responses()) ** 2).mean()
    assert flash.flash_temperature(SPEED, skin=OXIDE, **SLIDING) == pytest.approx(
        heat * even, rel=1e-9
    )
    assert flash.flash_gradient(SPEED, skin=OXIDE, **SLIDING) == pytest.approx(heat * odd, rel=1e-9)
    assert flash.flash_gradient(-SPEED, skin=OXIDE, **SLIDING) == pytest.approx(
        -heat * odd, rel=1e-9
    )
    assert flash.flash_laplacian(SPEED, skin=OXIDE, **SLIDING) == pytest.approx(
        -heat * Q**2 * even, rel=1e-9
    )
    assert flash.flash_width(SPEED, skin=OXIDE, **SLIDING) == pytest.approx(1 / Q, rel=1e-9)
    assert flash.slope_length(SPEED, skin=OXIDE, **SLIDING) == pytest.approx(-even / odd, rel=1e-9)
    rms = 0.2 * SPEED * sqrt(VARIANCE * square)
    assert flash.rms_temperature(SPEED, skin=OXIDE, **SLIDING) == pytest.approx(rms, rel=1e-9)
    at = np.array([0.0, 3e-5])
    correlation = flash.temperature_correlation(at, SPEED, skin=OXIDE, **SLIDING)
    np.testing.assert_allclose(correlation, rms**2 * scipy.special.j0(Q * at), rtol=1e-8)


@pytest.mark.parametrize("depth", [1e-6, 2e-5])
def test_heat_in_depth_on_a_ring_is_the_mean_over_its_release(depth):
    # without a skin ∫ e^(−z/h)/h e^(−λz) dz = 1/(1 + λh); with one, T at z by heat at the surface, by reciprocity
    below, within = roots()
    bare = (1 / (BODY["conductivity"] * below * (1 + below * depth))).real.mean()
    heat = 0.2 * SPEED * VARIANCE / 2e6
    assert flash.flash_temperature(SPEED, heat_depth=depth, **SLIDING) == pytest.approx(
        heat * bare, rel=1e-9
    )
    nodes, weights = np.polynomial.legendre.leggauss(40)
    z = OXIDE[0] / 2 * (1 + nodes)[:, None]
    here = responses() * np.cosh(within * z) - np.sinh(within * z) / (OXIDE[1] * within)
    share = OXIDE[0] / 2 * weights[:, None] * np.exp(-z / depth) / depth
    edge = responses() * np.cosh(within * OXIDE[0]) - np.sinh(within * OXIDE[0]) / (
        OXIDE[1] * within
    )
    total = (share * here).sum(axis=0) + edge * np.exp(-OXIDE[0] / depth) / (1 + below * depth)
    got = flash.flash_temperature(SPEED, skin=OXIDE, heat_depth=depth, **SLIDING)
    assert got == pytest.approx(heat * total.real.mean(), rel=1e-9)


@pytest.mark.parametrize("heat_depth", [0.0, 2e-6])
def test_a_skin_of_the_same_material_changes_no_moment(case, heat_depth):
    skin = (1e-6, case["body"]["conductivity"], case["body"]["diffusivity"])
    speeds = [-3.0, 0.0, 1e-3, 40.0]
    for name in ("flash_temperature", "flash_gradient", "flash_laplacian", "rms_temperature"):
        with_skin, without = (
            getattr(flash, name)(
                speeds, case["spectrum"], skin=layer, heat_depth=heat_depth, **case["sliding"]
            )
            for layer in (skin, None)
        )
        np.testing.assert_allclose(with_skin, without, rtol=1e-9)


def test_nothing_on_the_body_is_the_closed_mean(case):
    almost = flash.flash_temperature(
        [0.5, 40.0], case["spectrum"], heat_depth=1e-30, **case["sliding"]
    )
    np.testing.assert_allclose(
        almost, flash.flash_temperature([0.5, 40.0], case["spectrum"], **case["sliding"]), rtol=1e-9
    )


@pytest.mark.parametrize(
    "numbers",
    [(3e-7, 0.1, 5.0, 0.0), (3e-7, 0.1, 5.0, 1e-7), (2e-6, 9.0, 0.2, 3e-6), (0.0, 1.0, 1.0, 1e-6)],
)
def test_theory_and_simulation_have_the_same_means_by_their_own_quadratures(numbers):
    thickness, conduction, ratio, depth = numbers
    q = np.geomspace(1e3, 1e8, 12)
    layers = layers_of(
        (thickness, 30 * conduction, 7.6e-6 / ratio) if thickness else None, depth, 30.0, 7.6e-6
    )
    for speed in (0.0, 0.1, 35.0, 1e4):
        even, odd = direction_means(q, speed / 7.6e-6, Layering(*numbers))
        np.testing.assert_allclose(
            direction_mean(q, speed / 7.6e-6, layers, even_part), even, rtol=1e-9
        )
        np.testing.assert_allclose(
            direction_mean(q, speed / 7.6e-6, layers, odd_part), odd, rtol=2e-9, atol=1e-15
        )
    still = direction_mean(q, 0.0, layers, square_part)
    np.testing.assert_allclose(
        still, direction_means(q, 0.0, Layering(*numbers))[0] ** 2, rtol=1e-9
    )


def at_rest(skin, conductivity):
    inner, lag = skin[1] / conductivity, np.tanh(Q * skin[0])
    return (inner + lag) / (inner * (1 + inner * lag))


def test_bodies_at_rest_share_as_their_responses():
    # s = T₂/(T₁ + T₂) with T = F/κq at rest
    share = partition.moving_share(
        0.0, **GIVEN, **BODY, resting_conductivity=20.0, resting_skin=OXIDE
    )
    cold, hot = at_rest(OXIDE, 20.0) / 20.0, 1 / 46.0
    assert share == pytest.approx(cold / (cold + hot), rel=1e-9)
    share = partition.moving_share(
        0.0, **GIVEN, **BODY, resting_conductivity=20.0, skin=OXIDE, resting_heat_depth=1e-5
    )
    cold, hot = 1 / 20.0 / 2, at_rest(OXIDE, 46.0) / 46.0  # 1 + qh = 2
    assert share == pytest.approx(cold / (cold + hot), rel=1e-9)


def test_equal_bodies_with_equal_skins_share_equally_at_rest():
    layers = {"skin": OXIDE, "resting_skin": OXIDE, "heat_depth": 1e-6, "resting_heat_depth": 1e-6}
    assert partition.moving_share(0.0, **GIVEN, **BODY, **layers) == pytest.approx(0.5, rel=1e-14)
    total = partition.moving_share(0.0, **GIVEN, **BODY, **layers, rule="total", duration=1e-2)
    assert total == pytest.approx(0.5, rel=1e-14)


def test_the_total_share_makes_both_temperatures_equal():
    duration, layers = 1e-2, {"skin": OXIDE, "heat_depth": 1e-6}
    share = partition.moving_share(
        SPEED, **GIVEN, **BODY, **layers, rule="total", duration=duration
    )
    flux = 0.2 * SPEED * 2e6
    hot, cold = (
        background.temperature(duration, heat_flux=flux, **BODY, **own) for own in (layers, {})
    )
    hot += flash.flash_temperature(SPEED, **SLIDING, **layers)
    grown = scipy.special.erf(Q * sqrt(BODY["diffusivity"] * duration))
    cold += 0.2 * SPEED * VARIANCE / 2e6 / (46.0 * Q) * grown
    assert share * hot == pytest.approx((1 - share) * cold, rel=1e-8)


@pytest.mark.parametrize(("duration", "thickness"), [(1e-2, 3e-6), (2e-5, 3e-8)])
def test_the_total_share_of_unlike_bodies_has_the_background_under_the_skin_of_each(
    duration, thickness
):
    resting = {"conductivity": 20.0, "diffusivity": 6e-6}
    named = {"resting_conductivity": 20.0, "resting_diffusivity": 6e-6}
    worked, oxide = (thickness / 3, 23.0, 6e-6), (thickness, 3.0, 9e-7)
    layers = {"skin": worked, "resting_skin": oxide}
    share = partition.moving_share(
        SPEED, **GIVEN, **BODY, **named, **layers, rule="total", duration=duration
    )
    flux = 0.2 * SPEED * 2e6
    hot = background.temperature(duration, heat_flux=flux, **BODY, skin=worked)
    hot += flash.flash_temperature(SPEED, **SLIDING, skin=worked)
    cold = background.temperature(duration, heat_flux=flux, **resting, skin=oxide)
    # from rest: the bare body's transient, and the steady change by the skin
    grown = scipy.special.erf(Q * sqrt(6e-6 * duration)) + at_rest(oxide, 20.0) - 1
    cold += 0.2 * SPEED * VARIANCE / 2e6 / (20.0 * Q) * grown
    assert share * hot == pytest.approx((1 - share) * cold, rel=1e-8)


def image_series(skin, time):
    """κT₀/q̇ = (2√(D_s t)/k)(ierfc(0) + 2 Σ rⁿ ierfc(nd/√(D_s t))), r = (e_s − e)/(e_s + e), over κ."""
    thickness, kappa, diffusivity = skin
    ratio = kappa / sqrt(diffusivity) / (46.0 / sqrt(1.2e-5))
    r, n = (ratio - 1) / (ratio + 1), np.arange(1, 4000)
    reach = sqrt(diffusivity * time)
    x = n * thickness / reach
    ierfc = np.exp(-(x**2)) * (1 / sqrt(pi) - x * scipy.special.erfcx(x))
    return 2 * reach / kappa * (1 / sqrt(pi) + 2 * (r**n * ierfc).sum())


def test_the_background_under_a_skin_is_the_late_image_series():
    errors = []
    for time in (1e-2, 1.6e-1):
        got = background.temperature(time, heat_flux=1.0, **BODY, skin=OXIDE)
        errors.append(abs(got / image_series(OXIDE, time) - 1))
    assert errors[0] < 5e-4
    assert errors[1] / errors[0] == pytest.approx(1 / 16, rel=0.1)


@pytest.mark.parametrize(
    ("skin", "depth"),
    [
        ((3e-6, 4.6, 4.8e-5), 3e-6),  # d
        ((3e-6, 4.6, 3e-6), 6e-6),  # d√(D/D_s)
        ((3e-6, 460.0, 1.2e-5), 3e-5),  # dκ_sD/κD_s: what the skin stores
        ((3e-6, 460.0, 6e-6), 6e-5),
    ],
)
def test_a_background_is_refused_until_heat_has_spread_five_times_as_far_as_the_layers(skin, depth):
    limit = 25 * depth**2 / 1.2e-5
    with pytest.raises(ValueError, match=f"less than 5 times the {depth:.3g} m of the skin"):
        background.temperature(0.99 * limit, heat_flux=1.0, **BODY, skin=skin)
    got = background.temperature(1.01 * limit, heat_flux=1.0, **BODY, skin=skin)
    assert got == pytest.approx(image_series(skin, 1.01 * limit), rel=0.03)


def test_the_background_of_heat_in_depth_is_late_in_closed_form():
    # T₀ = (q̇/κ)[2√(Dt/π) − h(1 − e^τ erfc √τ)], τ = Dt/h²
    depth, time = 1e-6, 1e-3
    root = sqrt(1.2e-5 * time) / depth
    exact = (2 * root / sqrt(pi) - 1 + scipy.special.erfcx(root)) * depth / 46.0
    got = background.temperature([time], heat_flux=1.0, **BODY, heat_depth=depth)[0]
    assert got + depth / 46.0 * scipy.special.erfcx(root) == pytest.approx(exact, rel=1e-12)
    assert got == pytest.approx(exact, rel=1e-4)


def test_a_skin_and_heat_in_it_raise_the_background_by_the_mean_resistance():
    # heat at z has the resistance of the skin above it less
    depth = 4e-6
    only = background.temperature(1e-2, heat_flux=1.0, **BODY, skin=OXIDE)
    both = background.temperature(1e-2, heat_flux=1.0, **BODY, skin=OXIDE, heat_depth=depth)
    inside, beyond = scipy.integrate.quad(lambda u: np.exp(-u) * u, 0, 0.75)[0], np.exp(-0.75)
    resistance = depth / 3.0 * inside + beyond * (OXIDE[0] / 3.0 + depth / 46.0)
    assert only - both == pytest.approx(resistance, rel=1e-12)
