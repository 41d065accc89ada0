"""Sections on the distribution of the temperature: units, and what they refuse."""

import pytest
from steel_text import changed

from roughsim.scene import parse_scene

WARM = changed("friction_coefficient =", "background_temperature = 300\nfriction_coefficient =")
REACTION = """[reaction]
activation_energy = ["1 eV", "1.602176634e-19 J"]
activation_volume = "10 angstrom^3"
prefactor = "1e13 1/s"
contact_length = "1 cm"
[theory]"""


def test_a_reaction_is_read_in_si():
    reaction = parse_scene(changed("[theory]", REACTION, WARM)).reaction
    assert reaction.activation_energy == (1.602176634e-19, 1.602176634e-19)
    assert reaction.activation_volume == pytest.approx(1e-29, rel=1e-12)
    assert (reaction.prefactor, reaction.contact_length) == (1e13, 0.01)
    one = parse_scene(
        changed("[theory]", '[reaction]\nactivation_energy = "0 eV"\nprefactor = 1\n[theory]', WARM)
    )
    assert (one.reaction.activation_energy, one.reaction.activation_volume) == ((0.0,), 0.0)


def test_a_scene_without_the_sections_asks_for_nothing():
    scene = parse_scene(changed("[theory]", "[theory]"))
    assert scene.reaction is scene.observables is None
    assert not scene.distribution
    asked = parse_scene(
        changed("[theory]", "[observables]\ntemperature_distribution = false\n[theory]")
    )
    assert not asked.distribution


def test_the_heat_above_a_temperature_asks_for_the_distribution():
    assert parse_scene(
        changed("[theory]", '[observables]\nheat_above = "900 K"\n[theory]', WARM)
    ).distribution


def test_a_quantile_is_a_target_only_of_a_scene_that_asks():
    text = changed(
        'until = { flash_temperature = "1 %" }', "until = { temperature_quantile_99 = 0.1 }"
    )
    asks = changed("[theory]", "[observables]\ntemperature_distribution = true\n[theory]", text)
    assert parse_scene(asks).ensemble.until == (("temperature_quantile_99", 0.1),)
