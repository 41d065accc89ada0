"""The fields of one member: the temperature at any speed, and its quick preview."""

import numpy as np
import pytest

from roughsim import fourier
from roughsim.explore import content
from roughsim.explore.content import load_fields


def test_long_waves_of_the_previewed_temperature_are_those_of_the_whole(capped_run, monkeypatch):
    # the temperature is linear in the heat, wave by wave
    monkeypatch.setattr(content, "PREVIEW", 64)
    member = load_fields(capped_run, 2, 0)
    assert member.preview_grid != member.grid
    for speed, direction in ((0.1, 0.0), (35.0, 0.7), (100.0, -2.0)):
        whole = member.temperature(speed, direction).field
        preview = member.temperature(speed, direction, preview=True).field
        assert preview.shape == (64, 64)
        np.testing.assert_allclose(
            fourier.forward(preview)[1:32, :32], fourier.forward(whole)[1:32, :32], atol=2e-7 * np.abs(whole).max()
        )


def test_the_temperature_of_the_page_is_that_of_the_run(capped_run):
    member = load_fields(capped_run, 2, 0)
    assert member.preview_grid == member.grid
    for speed, direction in ((0.1, 0.0), (35.0, 1.2)):
        index, field = next(capped_run.fields("temperature", speed=speed, direction=direction))
        assert index == 0
        np.testing.assert_array_equal(member.temperature(speed, direction).field, field)
        np.testing.assert_array_equal(member.temperature(speed, direction, preview=True).field, field)


def test_a_field_that_was_not_kept_says_how_to_come_by_it(capped_run):
    with pytest.raises(ValueError, match=r"fields of realization 3 at level 2; .*--keep-fields 4.*index=3"):
        load_fields(capped_run, 2, 3)
