"""The members of a run in memory, by level and index; without any run."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from damage_cases import member

from roughsim.observables.member import Member
from roughsim.results.description import RunDescription
from roughsim.results.members import Members
from roughsim.scene.numerics import Level, Numerics

SPEEDS = (0.0, 0.5, 3.0)
LEVELS = (
    Level("smoothed", (32, 32), 2e4),
    Level("capped", (32, 32), 2e4),
    Level("capped", (32, 32), 4e4, cell="half"),
    Level("capped", (64, 64), 4e4, cell="half"),
)


@pytest.fixture
def members():
    """Five members of each level; index 1 failed in smoothed contact, index 2 at the second capped level."""
    scene = SimpleNamespace(speeds=SPEEDS, lay=1.0)
    description = RunDescription({}, Numerics(LEVELS, (2.0e-3, 1.5e-3)), {})
    table = Members(Path("run"), description, scene, "refuse")
    table.counts = (5,) * 4
    for level in range(4):
        for index in range(5):
            one = replace(
                member(10 * level + index),
                kept={"pressure": (32, 32)},
                provenance={"seconds": {"contact": 1.0 + level}},
            )
            one = replace(one, moments=one.moments if level > 1 else one.moments[:1])
            lost = Member(level, index, failure="stalled", provenance={"seconds": {}})
            table[level, index] = lost if (level, index) in ((0, 1), (2, 2)) else one
    return table


def test_members_that_failed_are_named_by_their_level(members):
    assert [members.failed(level) for level in range(4)] == [[1], [], [2], []]
    members.lost.add((2, 2))  # its contact converged
    assert members.failed(2) == []
    members.counts = (1,) * 4
    assert members.failed(0) == []


def test_a_surface_on_which_another_column_failed_does_not_count(members):
    # smoothed and capped contact of the lowest levels see the same surfaces, and stay paired; others have their own
    assert [members.sound(level) for level in range(4)] == [
        [0, 2, 3, 4],
        [0, 2, 3, 4],
        [0, 1, 3, 4],
        [0, 1, 2, 3, 4],
    ]
    members.counts = (2,) * 4
    assert members.sound(1) == [0]
    members.counts = (7,) * 4
    assert members.sound(1) == [0, 2, 3, 4]  # those that are there


def test_numbers_are_those_of_the_members_in_the_order_asked_for_and_nan_without_one(members):
    rows = members.sample(2, indices=[3, 2, 9]).numbers["flash_temperature"]
    np.testing.assert_array_equal(rows[0], member(23).numbers["flash_temperature"])
    assert np.isnan(rows[1:]).all()
    below = members.sample(2, below=True, indices=[3]).numbers["contact_fraction"]
    np.testing.assert_array_equal(below, [member(23).moments[1].numbers["contact_fraction"]])
    assert members.sample(2, indices=[3]).numbers["plastic_fraction"].shape == (
        1,
        1,
    )  # which these have not stored
    assert members.sample(2, indices=[]).numbers["flash_temperature"].shape == (0, 3)


def test_spectra_have_the_wavenumbers_of_their_level(members):
    for below, one in zip((False, True), member(24).moments, strict=True):
        sample = members.sample(2, below, [2, 4])
        np.testing.assert_array_equal(sample.wavenumber, one.wavenumber)
        np.testing.assert_array_equal(sample.spectrum[1], one.spectrum)
        assert np.isnan(sample.spectrum[0]).all()


def test_a_sample_has_the_cut_off_and_the_pixel_of_its_level_in_its_own_cell(members):
    sample, below = members.sample(2), members.sample(2, below=True)
    assert sample.rows.tolist() == below.rows.tolist() == members.sound(2)
    assert (sample.q_max, below.q_max) == (4e4, 2e4)
    assert (sample.side, below.side) == (
        32.0,
        16.0,
    )  # half the cell has half the points of the level below
    assert sample.reach == below.reach == pytest.approx(0.5 * np.hypot(1.0e-3, 0.75e-3))
    assert sample.part
    np.testing.assert_array_equal(
        sample.numbers["flash_temperature"][1], member(21).numbers["flash_temperature"]
    )
    np.testing.assert_array_equal(below.spectrum[1], member(21).moments[1].spectrum)
    partner = members.sample(3, below=True)
    assert (partner.q_max, partner.side) == (4e4, 32.0)
    whole = members.sample(1)
    assert (whole.side, whole.part) == (32.0, False)


def test_a_kept_pressure_gives_all_fields_but_the_heights(members):
    assert members.kept(1, "heights") == []
    for name in ("pressure", "temperature", "heat_flux"):
        assert members.kept(1, name) == [0, 2, 3, 4]


def test_the_time_of_a_level_is_that_of_its_members(members):
    assert sorted(members.seconds(2)) == [0.0, 3.0, 3.0, 3.0, 3.0]
