"""The fields of one member: the temperature at any speed, and its quick preview."""

from dataclasses import replace

import numpy as np
import pytest

import roughsim as rs
from roughsim import fourier
from roughsim.explore.content import load_fields, usual_seconds


def test_long_waves_of_the_previewed_temperature_are_those_of_the_whole(capped_run):
    # the temperature is linear in the heat, wave by wave
    member = load_fields(capped_run, 2, 0, preview=64)
    assert member.preview_grid != member.grid
    for speed, direction in ((0.1, 0.0), (35.0, 0.7), (100.0, -2.0)):
        whole = member.temperature(speed, direction).field
        preview = member.temperature(speed, direction, preview=True).field
        assert preview.shape == (64, 64)
        np.testing.assert_allclose(
            fourier.forward(preview)[1:32, :32],
            fourier.forward(whole)[1:32, :32],
            atol=2e-7 * np.abs(whole).max(),
        )


def test_the_temperature_of_the_page_is_that_of_the_run(capped_run):
    member = load_fields(capped_run, 2, 0)
    assert member.preview_grid == member.grid
    for speed, direction in ((0.1, 0.0), (35.0, 1.2)):
        index, field = next(capped_run.fields("temperature", speed=speed, direction=direction))
        assert index == 0
        np.testing.assert_array_equal(member.temperature(speed, direction).field, field)
        np.testing.assert_array_equal(
            member.temperature(speed, direction, preview=True).field, field
        )


def test_fields_that_were_not_kept_are_those_that_a_run_would_have_kept(capped_run, tmp_path):
    assert capped_run.kept(2) == [0]
    more = replace(capped_run.numerics, keep_fields=4)
    other = rs.run(capped_run.scene, tmp_path / "run", numerics=more, max_realizations=4)
    kept, again = load_fields(other, 2, 3), load_fields(capped_run, 2, 3)
    np.testing.assert_array_equal(again.heights, kept.heights)
    np.testing.assert_array_equal(again.pressure, kept.pressure)
    assert again.pressure.dtype == kept.pressure.dtype


def test_a_member_takes_the_time_that_others_took(capped_run):
    times = [
        sum(member.provenance["seconds"].values())
        for key, member in capped_run.members.items()
        if key[0] == 2
    ]
    assert usual_seconds(capped_run, 2) == pytest.approx(np.median(times))
