"""One schema for each key: sections share it, and numerics are checked, stored and read by it."""

from __future__ import annotations

import pickle
import re
import tomllib
from dataclasses import FrozenInstanceError, fields, replace

import pytest
from steel_text import STEEL

import roughsim as rs
from roughsim.scene import parse_scene
from roughsim.scene.numerics import NumericsSection
from roughsim.scene.schema import SECTIONS, did_you_mean, quantity
from roughsim.scene.sections import BodySection, CounterfaceSection, SurfaceSection
from roughsim.scene.spellings import nearest

LEVEL = rs.Level("capped", (64, 32), 5e4)


def test_a_counterface_has_the_keys_of_a_surface_and_of_a_body_with_their_units_and_limits():
    ours = {field.name for record in (SurfaceSection, BodySection) for field in fields(record)}
    assert {field.name for field in fields(CounterfaceSection)} == ours | {"like"}
    for record in (SurfaceSection, BodySection):
        for field in fields(record):
            assert quantity(CounterfaceSection, field.name) == quantity(record, field.name), (
                field.name
            )


def test_the_section_numerics_has_the_keys_of_the_numerics_and_its_levels_are_theirs():
    keys = [field.name for field in fields(rs.Numerics) if field.name != "reasons"]
    assert [field.name for field in fields(NumericsSection)] == keys
    lines = (
        'levels = [{ column = "capped", shape = [64, 32], q_max = "5e4 1/m" }]\nlengths = "2 mm"'
    )
    assert parse_scene(STEEL + lines).numerics.levels == (LEVEL,)


def test_numerics_read_units_and_are_frozen_hashable_and_whole_after_json_and_pickle():
    numerics = rs.Numerics([LEVEL], "2 mm", slid_distance="1 um", threads=2)
    assert (numerics.lengths, numerics.slid_distance) == ((2e-3, 2e-3), 1e-6)
    again = rs.Numerics.from_dict(numerics.to_dict())
    assert again == numerics == pickle.loads(pickle.dumps(numerics))
    assert hash(again) == hash(numerics)
    with pytest.raises(FrozenInstanceError):
        numerics.threads = 3


def test_what_is_stored_of_numerics_stays_what_it_was():
    numerics = rs.Numerics(
        (LEVEL, replace(LEVEL, q_max=1e4)), (2e-3, 1e-3), slid_distance=float("inf")
    )
    level = {"column": "capped", "shape": [64, 32], "q_max": 5e4}
    stored = {"levels": [level, level | {"q_max": 1e4}], "lengths": [2e-3, 1e-3], "tolerance": 3e-3}
    stored |= {
        "precision": "double",
        "slid_distance": "inf",
        "threads": 1,
        "keep_fields": 1,
        "solver": "active_set",
    }
    assert numerics.to_dict() == stored
    assert replace(numerics, slid_distance=1e-3).to_dict()["slid_distance"] == 1e-3
    assert rs.Numerics.from_dict(stored | {"levels": [level], "of_a_later_version": 3}).levels == (
        LEVEL,
    )
    with pytest.raises(KeyError, match="tolerance"):
        rs.Numerics.from_dict({key: value for key, value in stored.items() if key != "tolerance"})


POSITIVE = ([1e-9], [0, -1])
NOT_NEGATIVE = ([0, 1e-9], [-1])
WHOLE = [1.5, 1.0, "1", True]
# key → SI unit, numbers that are accepted, numbers and texts that are not
LIMITS = {
    "surface.psd_filled": ("", [0, 0.999], [-0.001, 1]),
    "surface.rms_height": ("m", *POSITIVE),
    "surface.rms_slope": ("", *POSITIVE),
    "surface.hurst": ("", [0, 1], [-0.001, 1.001]),
    "surface.q_min": ("rad/m", *POSITIVE),
    "surface.q_roll_off": ("rad/m", *POSITIVE),
    "surface.q_max": ("rad/m", *POSITIVE),
    "surface.roll_off_exponent": ("", [0, 4], [-0.001, 4.001]),
    "body.youngs_modulus": ("Pa", *POSITIVE),
    "body.poisson_ratio": ("", [-0.999, 0.5], [-1, 0.501]),
    "body.penetration_hardness": ("Pa", *POSITIVE),
    "body.conductivity": ("W/(m K)", *POSITIVE),
    "body.density": ("kg/m^3", *POSITIVE),
    "body.heat_capacity": ("J/(kg K)", *POSITIVE),
    "body.melting_temperature": ("K", *POSITIVE),
    "body.temperature": ("K", *POSITIVE),
    "body.heat_depth": ("m", [0, 1e-9], [-1e-9]),
    "body.skin.thickness": ("m", *POSITIVE),
    "body.skin.conductivity": ("W/(m K)", *POSITIVE),
    "body.skin.density": ("kg/m^3", *POSITIVE),
    "body.skin.heat_capacity": ("J/(kg K)", *POSITIVE),
    "sliding.nominal_pressure": ("Pa", *POSITIVE),
    "sliding.friction_coefficient": ("", *POSITIVE),
    "sliding.junction_growth": ("", [0, 9, 100], [-1e-9, 101]),
    "sliding.speed": ("m/s", [0, 1e5], [-1e-9]),
    "sliding.heat_partition": ("", [1e-9, 1], [0, 1.001]),
    "sliding.direction": ("rad", [-6.28, 0, 6.28], [-6.3, 30]),
    "surface.lay": ("", *POSITIVE),
    "surface.lay_direction": ("rad", [-6.28, 0, 6.28], [-6.3, 30]),
    "sliding.duration": ("s", *POSITIVE),
    "sliding.slid_distance": ("m", *POSITIVE),
    "sliding.background_temperature": ("K", *POSITIVE),
    "sliding.contact_radius": ("m", *POSITIVE),
    "sliding.track_radius": ("m", *POSITIVE),
    "observables.heat_above": ("K", *POSITIVE),
    "reaction.activation_energy": ("J", [0, 1e-19, 1e-17], [-1e-19, 1.1e-17]),
    "reaction.activation_volume": ("m^3", [-1e-26, 0, 1e-29], [-1.1e-26, 1.1e-26, 1e-41]),
    "reaction.prefactor": ("1/s", *POSITIVE),
    "reaction.contact_length": ("m", *POSITIVE),
    "camera.resolution": ("m", *NOT_NEGATIVE),
    "camera.exposure": ("s", *NOT_NEGATIVE),
    "camera.behind": ("m", *NOT_NEGATIVE),
    "theory.gamma": ("", [0, 1], [-0.001, 1.001]),
    "ensemble.seed": ("", [0, 2**63 - 1], [-1, 2**63, *WHOLE]),
    "ensemble.max_realizations": ("", [1, 10**6], [0, 10**6 + 1, *WHOLE]),
    "ensemble.realizations": ("", [1, 10**6], [0, 10**6 + 1, *WHOLE]),
    "numerics.lengths": ("m", *POSITIVE),
    "numerics.tolerance": ("", [1e-9, 0.999], [0, 1]),
    "numerics.slid_distance": ("m", [1e-9, float("inf")], [0, -float("inf")]),
    "numerics.threads": ("", [1, 4096], [0, 4097, *WHOLE]),
    "numerics.keep_fields": ("", [0, 2**63 - 1], [-1, *WHOLE]),
    "numerics.levels.shape": ("", [1, 2**31], [0, 2**31 + 1, *WHOLE]),
    "numerics.levels.q_max": ("rad/m", *POSITIVE),
    "numerics.levels.first": ("", [1, 10**6], [0, 10**6 + 1, *WHOLE]),
    "numerics.levels.followed": ("m", *POSITIVE),
    "numerics.levels.lengths": ("m", *POSITIVE),
}


@pytest.mark.parametrize("key", LIMITS)
def test_each_number_has_its_si_unit_and_its_limits(key):
    section, _, name = key.rpartition(".")
    reads, (unit, accepted, refused) = quantity(SECTIONS[section], name), LIMITS[key]
    assert reads.unit == unit
    assert [reads(value) for value in accepted] == accepted
    for value in refused:
        with pytest.raises(ValueError, match=rf"must be .*{re.escape(unit)}"):
            reads(value)
    assert reads(tomllib.loads(f"x = {reads.example}")["x"]) > 0


def test_the_limits_of_every_number_of_a_scene_are_tried():
    assert {*LIMITS} == {
        f"{section}.{key}"
        for section, record in SECTIONS.items()
        for key in record.known_keys()
        # a counterface has those of surface and body
        if not section.startswith("counterface") and quantity(record, key) is not None
    }


def test_a_misspelt_word_stands_for_the_nearest_name_if_three_fifths_are_alike():
    assert (
        did_you_mean("HurXX", ["hurst", "q_max"]) == 'did you mean "hurst"?'
    )  # 2·3 letters of 5 + 5
    assert (
        did_you_mean("hurxxx", ["hurst", "q_max"]) == "the choice is hurst, q_max"
    )  # 2·3 of 6 + 5
    assert nearest("steel-1", ["steel-22", "Steel-1.2"]) == "Steel-1.2"
