"""Scenes with other values of some keys: as if the file had said so."""

import tomllib
from contextlib import chdir

import pytest
from soft_scene import RUBBER

import roughsim as rs
from roughsim.scene import scene_text
from roughsim.scene.changes import read_changes, with_changes


def test_a_changed_scene_is_that_of_the_changed_file():
    text = scene_text("steel-1.2GPa").replace(
        'nominal_pressure = "90 MPa"', 'nominal_pressure = "5 MPa"'
    )
    expected = rs.load_scene(tomllib.loads(text))
    assert expected.sliding.nominal_pressure == 5e6
    assert rs.load_scene("steel-1.2GPa").with_("sliding.nominal_pressure", "5 MPa") == expected
    assert rs.load_scene("steel-1.2GPa", {"sliding.nominal_pressure": 5e6}) == expected


@pytest.mark.parametrize("name", ["steel-1.2GPa", RUBBER, "granite", "demo"])
def test_a_change_keeps_everything_else_to_the_last_bit(name):
    scene = rs.load_scene(name)
    assert scene.with_("title", "other").with_("title", scene.title) == scene
    assert scene.with_("ensemble.seed", 5).spectrum == scene.spectrum


def test_none_takes_a_key_or_a_section_away():
    scene = rs.load_scene("steel-1.2GPa")
    assert scene.with_("body.penetration_hardness", None).elastic
    assert scene.with_("counterface", None).counterface is None
    rougher = rs.load_scene("steel-1.2GPa", {"surface.rms_height": None, "surface.rms_slope": 0.3})
    assert rougher.surface.rms_slope == 0.3
    assert rougher.surface.rms_height is None


def test_what_was_handed_in_stays_as_it_was():
    content = {"sliding": {"speed": 1.0}}
    assert with_changes(content, {"sliding.speed": 2.0, "body.density": 7.0}) == {
        "sliding": {"speed": 2.0},
        "body": {"density": 7.0},
    }
    assert content == {"sliding": {"speed": 1.0}}
    assert with_changes(content, {"sliding.speed": None}) == {}


def test_words_of_the_command_line_are_toml_or_text():
    words = [
        "sliding.speed = [1, 2]",
        "sliding.nominal_pressure=5 MPa",
        "body.density=7800",
        "counterface=",
    ]
    assert read_changes(words) == {
        "sliding.speed": [1, 2],
        "sliding.nominal_pressure": "5 MPa",
        "body.density": 7800,
        "counterface": None,
    }


def test_a_table_of_another_file_may_be_set(tmp_path):
    (tmp_path / "psd.csv").write_text("1e4, 1e-24\n1e5, 1e-27\n")
    roughness = dict.fromkeys(rs.load_scene("demo").surface.known_keys())
    changes = {f"surface.{key}": None for key in roughness} | {
        "surface.psd_file": "psd.csv",
        "surface.psd_convention": "persson",
    }
    with chdir(tmp_path):
        scene = rs.load_scene("demo", changes)
    assert scene.surface.psd == ((1e4, 1e-24), (1e5, 1e-27))
