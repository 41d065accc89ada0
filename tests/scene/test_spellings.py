"""Units and numbers as people write them: refused with the spelling that is read, or understood."""

import pytest
from steel_text import changed, refusal

from roughsim.scene import parse_scene


@pytest.mark.parametrize(
    ("key", "written", "meant"),
    [
        ("nominal_pressure", "90 N/mm2", "90 N/mm^2"),
        ("speed", "35 ms-1", "35 m/s"),
        ("rms_height", "0.9 mu", "0.9 um"),
        ("rms_height", "0.9 MICROMETER", "0.9 micrometer"),
        ("nominal_pressure", "0.09 Gpa", "0.09 GPa"),
        ("nominal_pressure", "90 mpa s", "90 MPa"),
        ("density", "7.9 g/cm3", "7.9 g/cm^3"),
        ("density", "7900 kg/m3", "7900 kg/m^3"),
        ("conductivity", "30 W/m K", "30 W/(m K)"),
        ("conductivity", "30 W/m*K", "30 W/(m*K)"),
        ("conductivity", "30 W/mK", "30 W/(m K)"),
        ("heat_capacity", "500 J/kg K", "500 J/(kg K)"),
        ("heat_capacity", "0.5 kJ/kgK", "0.5 kJ/(kg K)"),
    ],
)
def test_a_refused_unit_names_the_spelling(key, written, meant):
    message = refusal(changed(f"{key} =", f'{key} = "{written}"  #'))
    assert message.endswith(f'; did you mean "{meant}"?')
    parse_scene(changed(f"{key} =", f'{key} = "{meant}"  #'))


def test_an_energy_per_mole_becomes_one_of_a_molecule():
    reaction = '[reaction]\nactivation_energy = "100 kJ/mol"\nprefactor = "1e13 1/s"\n[sliding]'
    message = refusal(changed("[sliding]", reaction))
    assert 'this is per mole: of one molecule it is "1.0364 eV"' in message  # 1 eV is 96.485 kJ/mol


@pytest.mark.parametrize("written", ["20 C", "20 deg C", "20 ° C"])
def test_celsius_is_named(written):
    message = refusal(changed("[sliding]", f'[sliding]\nbackground_temperature = "{written}"'))
    assert message.endswith('; did you mean "20 degC"?')


def test_a_number_with_blanks_is_not_cut_short():
    message = refusal(changed("youngs_modulus =", 'youngs_modulus = "200 000 MPa" #'))
    assert message.endswith("; write the number without blanks")


def test_decimal_commas_are_named():
    assert refusal(changed("poisson_ratio =", 'poisson_ratio = "0,35" #')).endswith(
        "; the decimal sign is a point: 0.35"
    )
    assert "the decimal sign is a point: 1.2 GPa" in refusal(
        changed("penetration_hardness =", 'penetration_hardness = "1,2 GPa" #')
    )
    assert "the decimal sign is a point: 0.35" in refusal(
        changed("poisson_ratio =", "poisson_ratio = 0,35 #")
    )


def test_a_background_temperature_may_stand_alone():
    scene = parse_scene(changed("[sliding]", '[sliding]\nbackground_temperature = "473 K"'))
    assert scene.sliding.background_temperature == 473.0
    assert (
        scene.identity() == parse_scene(changed("[sliding]", "[sliding]")).identity()
    )  # rises do not depend on it
