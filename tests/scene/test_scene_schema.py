"""One schema for each key: sections share it, and numerics are checked, stored and read by it."""

from __future__ import annotations

import pickle
from dataclasses import FrozenInstanceError, fields, replace

import pytest
from steel_text import STEEL

import roughsim as rs
from roughsim.scene import SceneError, parse_scene
from roughsim.scene.numerics import NumericsSection
from roughsim.scene.schema import quantity
from roughsim.scene.sections import BodySection, CounterfaceSection, SurfaceSection

LEVEL = rs.Level("capped", (64, 32), 5e4)


def test_a_counterface_has_the_keys_of_a_surface_and_of_a_body_with_their_units_and_limits():
    ours = {field.name for record in (SurfaceSection, BodySection) for field in fields(record)}
    assert {field.name for field in fields(CounterfaceSection)} == ours | {"like"}
    for record in (SurfaceSection, BodySection):
        for field in fields(record):
            assert quantity(CounterfaceSection, field.name) == quantity(record, field.name), field.name


def test_the_section_numerics_has_the_keys_of_the_numerics_and_its_levels_are_theirs():
    keys = [field.name for field in fields(rs.Numerics) if field.name not in ("reasons", "forecast")]
    assert [field.name for field in fields(NumericsSection)] == keys
    lines = 'levels = [{ column = "capped", shape = [64, 32], q_max = "5e4 1/m" }]\nlengths = "2 mm"'
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
    numerics = rs.Numerics((LEVEL, replace(LEVEL, q_max=1e4)), (2e-3, 1e-3), slid_distance=float("inf"))
    level = {"column": "capped", "shape": [64, 32], "q_max": 5e4, "every": 1}
    stored = {"levels": [level, level | {"q_max": 1e4}], "lengths": [2e-3, 1e-3], "tolerance": 1e-4}
    stored |= {"precision": "double", "slid_distance": "inf", "threads": 1, "keep_fields": 1}
    assert numerics.to_dict() == stored
    assert replace(numerics, slid_distance=1e-3).to_dict()["slid_distance"] == "0.001"
    del level["every"]  # as in the first runs
    assert rs.Numerics.from_dict(stored | {"levels": [level], "of_a_later_version": 3}).levels == (LEVEL,)
    with pytest.raises(KeyError, match="tolerance"):
        rs.Numerics.from_dict({key: value for key, value in stored.items() if key != "tolerance"})


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (
            lambda: rs.Level("plastic", 8, 1.0),
            'numerics.levels.column = "plastic" is not known; did you mean',
        ),
        (lambda: rs.Level("elastic", (8, 8, 8), 1.0), "numerics.levels.shape = (8, 8, 8) must be one number or two"),
        (lambda: rs.Level("elastic", 8, -1), "numerics.levels.q_max = -1 rad/m must be above 0 rad/m"),
        (lambda: rs.Level("elastic", 8.0, 1), "numerics.levels.shape = 8.0 must be a whole number"),
        (lambda: rs.Level("elastic"), "numerics.levels.shape is missing"),
        (
            lambda: rs.Numerics((LEVEL,), 1, tolerence=3),
            "numerics.tolerence = 3 is not a key of a scene; did you mean",
        ),
        (lambda: rs.Numerics((LEVEL,), (1, "1 s")), 'numerics.lengths[1] = "1 s" has the dimension [time]; a length'),
    ],
)
def test_wrong_levels_and_numerics_are_refused_as_in_a_scene(make, words):
    with pytest.raises(SceneError) as refused:
        make()
    assert words in str(refused.value)
