"""Partition of the heat between the bodies, and the background temperature."""

from math import erf, pi, sqrt

import pytest
from power_law import Flat
from scipy.integrate import quad

from theory import background, flash, partition, plasticity

RING = Flat(1e8, (1e4 * (1 - 1e-7), 1e4 * (1 + 1e-7)))
BODY = {"conductivity": 20.0, "diffusivity": 1e-5}
GIVEN = {"nominal_pressure": 2e6, "stress_spectrum": RING}


def test_equal_bodies_at_rest_share_equally(case):
    assert partition.moving_share(
        0.0, case["spectrum"], **case["contact"], **case["body"]
    ) == pytest.approx(0.5, rel=1e-14)


def test_bodies_at_rest_share_as_their_conductivities():
    share = partition.moving_share(
        0.0, **GIVEN, **BODY, resting_conductivity=60.0, resting_diffusivity=3e-6
    )
    assert share == pytest.approx(20 / 80, rel=1e-14)


def test_the_papers_rule_on_a_ring_of_waves_is_closed():
    # s = (π/2)/κ₂ / ((π/2)/κ₂ + A/κ₁)
    even = flash.angular_integrals(5.0 / 1e-5 / 1e4)[0]
    share = partition.moving_share([5.0, -5.0], **GIVEN, **BODY, resting_conductivity=50.0)
    exact = (pi / 2 / 50) / (pi / 2 / 50 + even / 20)
    assert share == pytest.approx([exact, exact], rel=1e-9)


def test_the_share_equalizes_the_flash_temperatures(case):
    # s T_mov = (1 − s) T_stat; T_stat/v is the limit of T/v at rest
    spectrum, sliding, speed = case["spectrum"], case["sliding"], 3.0
    share = partition.moving_share(speed, spectrum, **case["contact"], **case["body"])
    moving = flash.flash_temperature(speed, spectrum, **sliding)
    still = flash.flash_temperature(1e-12, spectrum, **sliding) * speed / 1e-12
    assert share * moving == pytest.approx((1 - share) * still, rel=1e-9)


def test_gamma_is_0_45_unless_said(case):
    contact = {**case["contact"], "gamma": 0.45}
    unsaid = {k: v for k, v in contact.items() if k != "gamma"}
    shares = [
        partition.moving_share(3.0, case["spectrum"], **given, **case["body"])
        for given in (contact, unsaid)
    ]
    assert shares[0] == shares[1]


def test_steel_gives_the_share_of_the_paper(steel):
    given = {k: steel["contact"][k] for k in ("effective_modulus", "nominal_pressure")}
    for hardness in (0.5e9, 1.2e9, 2e9):
        smooth = plasticity.smoothed_spectrum(
            steel["spectrum"], penetration_hardness=hardness, **given
        )
        share = partition.moving_share(35.0, smooth, **steel["contact"], **steel["body"])
        assert share == pytest.approx(steel[f"{hardness:g}"]["share"], rel=1e-10)
        assert share == pytest.approx(
            {0.5e9: 0.9475, 1.2e9: 0.9380, 2e9: 0.9304}[hardness], abs=5e-5
        )


def test_the_total_rule_on_a_ring_of_waves_is_closed():
    # g(0)/q brackets and backgrounds σ₀² 2√(Dt/π) of both bodies, each over its κ
    t, q, variance = 2e-4, 1e4, 2 * pi * 1e4 * 1e8 * 2e-3
    even = float(flash.angular_integrals(5.0 / 1e-5 / q)[0])
    hot = (2 / pi * even * variance / q + 4e12 * 2 * sqrt(1e-5 * t / pi)) / 20
    cold = (variance / q * erf(q * sqrt(3e-6 * t)) + 4e12 * 2 * sqrt(3e-6 * t / pi)) / 50
    share = partition.moving_share(
        5.0,
        **GIVEN,
        **BODY,
        resting_conductivity=50.0,
        resting_diffusivity=3e-6,
        rule="total",
        duration=t,
    )
    assert share == pytest.approx(cold / (cold + hot), rel=1e-8)


def test_the_total_rule_in_the_steel_scene(steel):
    given = {k: steel["contact"][k] for k in ("effective_modulus", "nominal_pressure")}
    smooth = plasticity.smoothed_spectrum(steel["spectrum"], penetration_hardness=1.2e9, **given)
    for t in (1e-4, 4.3e-4, 1e-3):
        share = partition.moving_share(
            35.0, smooth, **steel["contact"], **steel["body"], rule="total", duration=t
        )
        assert 0.76 < share < 0.785
        assert 210.5 < share * flash.flash_temperature(35.0, smooth, **steel["sliding"]) < 215.5


def test_after_a_long_time_the_total_rule_shares_as_the_effusivities():
    share = partition.moving_share(
        5.0,
        **GIVEN,
        **BODY,
        resting_conductivity=50.0,
        resting_diffusivity=3e-6,
        rule="total",
        duration=1e20,
    )
    first, second = 20 / sqrt(1e-5), 50 / sqrt(3e-6)
    assert share == pytest.approx(first / (first + second), rel=1e-8)


def test_the_background_is_the_diffusion_from_a_plane_source():
    # (1/κ)√(D/π) ∫ q̇ dt'/√(t − t'), with t − t' = u²
    exact = sqrt(1e-5 / pi) / 20 * 3e6 * quad(lambda u: 2.0, 0, sqrt(0.4))[0]
    assert background.temperature(0.4, heat_flux=3e6, **BODY) == pytest.approx(exact, rel=1e-12)


def test_the_background_of_the_steel_scene_is_700_kelvin():
    got = background.temperature(
        [0.0, 0.43e-3, 4 * 0.43e-3],
        heat_flux=0.938 * 0.11 * 9e7 * 35,
        conductivity=30.0,
        diffusivity=30 / 3.95e6,
    )
    assert got == pytest.approx([0.0, 698.6, 2 * 698.6], abs=0.1)


@pytest.mark.parametrize(("share", "distance"), [(0.938, 14e-3), (0.5, 50e-3)])
def test_the_measured_background_of_700_celsius_needs_the_stated_distance(share, distance):
    # steel from 20 °C at 35 m/s; docs/sliding.md and the steel scenes state these distances
    flux = share * 0.11 * 90e6 * 35.0
    reached = background.temperature(
        distance / 35.0, heat_flux=flux, conductivity=30.0, diffusivity=30 / (7900 * 500)
    )
    assert reached == pytest.approx(680.0, rel=0.01)
