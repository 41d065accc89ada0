"""The physics of two bodies in a scene: modulus, spectrum, hardness."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from steel_text import approx, changed, with_counterface

from roughsim.scene import parse_scene


def test_equal_bodies_halve_the_modulus_and_double_the_spectrum(steel):
    alone = replace(steel, counterface=None)
    assert alone.effective_modulus == approx(2e11 / 0.91, rel=1e-15)
    assert steel.effective_modulus == approx(1e11 / 0.91, rel=1e-15)
    for q in (6350.0, 2e4, 9.4e4, 1e6, 4.15e7):
        assert steel.spectrum(q) == approx(2 * alone.spectrum(q), rel=1e-14)
    assert alone.spectrum.rms_height == approx(9e-7, rel=1e-12)
    assert steel.spectrum.rms_height == approx(9e-7 * math.sqrt(2), rel=1e-12)


def test_steel_has_the_known_modulus_and_diffusivity(steel):
    assert steel.effective_modulus == approx(1.0989e11, rel=1e-5)
    assert steel.conduction().diffusivity == approx(7.5949e-6, rel=1e-5)
    assert steel.conduction().counter_conductivity == 30.0
    assert steel.conduction().counter_diffusivity == approx(30.0 / (7900.0 * 500.0), rel=1e-15)


def test_an_incompressible_body_is_stiffer_by_a_quarter(steel):
    scene = replace(steel, counterface=None, body=replace(steel.body, poisson_ratio=0.5))
    assert scene.effective_modulus == approx(2e11 / 0.75, rel=1e-15)


def test_different_faces_add_their_spectra_and_compliances():
    scene = parse_scene(
        with_counterface(
            'rms_slope = 0.1\nhurst = 0.5\nq_min = 2e4\nq_max = 1e6\nyoungs_modulus = "70 GPa"\npoisson_ratio = 0.2\n'
            'penetration_hardness = "0.8 GPa"\nconductivity = 150\ndensity = 2700\nheat_capacity = 900'
        )
    )
    assert scene.effective_modulus == approx(1 / (0.91 / 2e11 + 0.96 / 7e10), rel=1e-14)
    assert scene.penetration_hardness == 8e8
    assert scene.conduction().counter_conductivity == 150.0
    assert scene.conduction().counter_diffusivity == approx(150 / (2700 * 900), rel=1e-15)
    alone = replace(scene, counterface=None).spectrum
    # C = a q^(-3) with rms slope 0.1: 2π ∫ q³ C dq = 2π a (q_max - q_min)
    level = 0.1**2 / (2 * math.pi * (1e6 - 2e4))
    for q in (
        1e4,
        3e4,
        5e5,
        2e6,
    ):  # outside, inside, inside and outside the band of the second face
        second = level * q**-3 if 2e4 <= q <= 1e6 else 0.0
        assert scene.spectrum(q) == approx(alone(q) + second, rel=1e-12)


def test_the_softer_body_yields_first_whichever_it_is():
    harder = with_counterface('penetration_hardness = "3 GPa"')
    assert parse_scene(harder).penetration_hardness == 1.2e9
    only_counterface = changed('penetration_hardness = "1.2 GPa"', "", harder)
    assert parse_scene(only_counterface).penetration_hardness == 3e9
    assert not parse_scene(only_counterface).elastic


def test_a_scene_without_hardness_is_elastic():
    scene = parse_scene(changed('penetration_hardness = "1.2 GPa"', ""))
    assert scene.elastic
    assert scene.penetration_hardness == math.inf


def test_a_counterface_without_keys_of_a_kind_is_rigid_smooth_or_insulating(steel):
    alone = replace(steel, counterface=None)
    smooth = parse_scene(with_counterface('youngs_modulus = "200 GPa"\npoisson_ratio = 0.3'))
    rough = parse_scene(
        with_counterface('rms_height = "0.9 um"\nhurst = 0.8\nq_min = 6350\nq_max = 1e6')
    )
    assert smooth.spectrum == alone.spectrum
    assert smooth.effective_modulus == steel.effective_modulus
    assert rough.effective_modulus == alone.effective_modulus
    for scene in (alone, smooth, rough):
        assert scene.conduction().counter_conductivity is None
        assert scene.conduction().counter_diffusivity is None


def test_the_spectrum_has_the_exponents_of_the_scene_on_both_sides_of_the_roll_off(steel):
    assert steel.spectrum(6350.0) / steel.spectrum(9.4e4) == approx(
        (9.4e4 / 6350.0) ** 1.5, rel=1e-12
    )
    assert steel.spectrum(9.4e4) / steel.spectrum(9.4e5) == approx(10**3.6, rel=1e-12)
    assert steel.spectrum.breaks == (6350.0, 9.4e4, 4.15e7)


@pytest.mark.parametrize("end", ["6350 1/m", "4.15e7 1/m"])
def test_the_roll_off_may_lie_at_either_end(end):
    assert parse_scene(changed("9.4e4 1/m", end)).spectrum.breaks == (6350.0, 4.15e7)


def test_left_out_roll_off_begins_at_q_min():
    text = changed('q_roll_off = "9.4e4 1/m"', "", changed("roll_off_exponent = 1.5", ""))
    scene = parse_scene(text)
    assert scene.spectrum(6350.0) / scene.spectrum(63500.0) == approx(10**3.6, rel=1e-12)


def test_load_equal_to_the_hardness_is_allowed():
    assert parse_scene(changed('"90 MPa"', '"1.2 GPa"')).sliding.nominal_pressure == 1.2e9
