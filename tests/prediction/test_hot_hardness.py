"""The hardness at the temperature of the contact, by the calibrated law inside its range and by the theory outside."""

from dataclasses import replace

import numpy as np
import pytest

import roughsim as rs
from roughsim.prediction.hot_hardness import hot_hardness
from theory import flash, plasticity

TABLE = [300.0, 600.0, 900.0], [1.5e9, 1.2e9, 0.8e9]  # K, Pa
# two steel faces of 0.9 µm that slide at 35 m/s: C(q) doubles, E* halves
SPECTRUM = rs.SelfAffineSpectrum.from_rms_height(
    9e-7, hurst=0.8, q_min=6350.0, q_roll_off=9.4e4, q_max=4.15e7, roll_off_exponent=1.5
).scaled(2.0)
MODULUS = 0.5 * 200e9 / (1 - 0.3**2)
HEAT = {"friction_coefficient": 0.11, "conductivity": 30.0, "diffusivity": 30.0 / (7900 * 500)}


def steel(pressure=9e7):
    scene = rs.load_scene("steel-1.2GPa")
    return replace(scene, sliding=replace(scene.sliding, speed=35.0, nominal_pressure=pressure))


def rise_by_the_law(hardness, pressure):
    arguments = {
        "effective_modulus": MODULUS,
        "nominal_pressure": pressure,
        "penetration_hardness": hardness,
    }
    stress = plasticity.stress_spectrum(SPECTRUM, **arguments)
    return 0.938 * flash.flash_temperature(
        35.0, stress_spectrum=stress, nominal_pressure=pressure, **HEAT
    )


def rise_by_the_theory(hardness, pressure):
    load = {"effective_modulus": MODULUS, "nominal_pressure": pressure}
    smooth = plasticity.smoothed_spectrum(SPECTRUM, **load, penetration_hardness=hardness)
    return 0.938 * flash.flash_temperature(35.0, smooth, **load, gamma=0.294, **HEAT)


@pytest.mark.parametrize(
    ("pressure", "law", "rise"),
    [(9e7, "calibrated", rise_by_the_law), (1e6, "theory", rise_by_the_theory)],
)
def test_the_hardness_is_that_of_the_temperature_which_the_named_law_gives(pressure, law, rise):
    found = hot_hardness(steel(pressure), *TABLE, background=300.0)
    assert found.law == law
    assert found.flash_temperature == pytest.approx(
        float(rise(found.penetration_hardness, pressure)), rel=1e-6
    )
    assert found.penetration_hardness == pytest.approx(
        np.interp(300.0 + found.flash_temperature, *TABLE), rel=1e-9
    )
    assert found.scene.penetration_hardness == found.penetration_hardness


def test_it_says_which_law_was_used_and_why_not_the_other():
    inside, outside = (
        hot_hardness(steel(pressure), *TABLE, background=300.0) for pressure in (9e7, 1e6)
    )
    assert str(inside).endswith("T_flash is by the calibrated law")
    assert inside.range == "inside"
    assert "by the theory, as nominal_pressure/penetration_hardness = 0.00" in str(outside)
    assert "lies outside 0.005" in outside.range


def test_several_speeds_and_a_table_that_ends_are_refused():
    with pytest.raises(
        ValueError, match="has 7 speeds, each with a hardness of its own; give a scene of one speed"
    ):
        hot_hardness(rs.load_scene("steel-1.2GPa"), *TABLE, background=300.0)
    with pytest.raises(ValueError, match="the contact becomes hotter than the table"):
        hot_hardness(steel(), [300.0, 350.0], [1.5e9, 1.4e9], background=300.0)
