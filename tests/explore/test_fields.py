"""The fields of one member: the temperature at any speed, its quick preview, its distribution over the contact."""

import numpy as np
import pytest

import roughsim as rs
from roughsim import fourier
from roughsim.explore import fields
from roughsim.explore.fields import MemberFields, load_fields, long_waves


@pytest.mark.parametrize("shape", [(1, 1), (64, 48), (96, 31), (33, 64)])
def test_the_preview_has_the_waves_of_the_field(shape):
    grid = rs.Grid(shape, (3e-3, 2e-3))
    x, y = np.meshgrid(*(np.arange(n) * d for n, d in zip(shape, grid.spacing, strict=True)), indexing="ij")
    kx, ky = (0, 0) if shape == (1, 1) else (7, 5)

    def wave(x, y):
        return 2.0 + np.cos(2 * np.pi * (kx * x / 3e-3 + ky * y / 2e-3) + 0.4)

    target = rs.Grid((min(shape[0], 32), min(shape[1], 32)), grid.lengths)
    preview = long_waves(wave(x, y), target)
    places = np.meshgrid(*(np.arange(n) * d for n, d in zip(target.shape, target.spacing, strict=True)), indexing="ij")
    np.testing.assert_allclose(preview, wave(*places), atol=1e-12)


def test_a_preview_of_noise_has_all_waves_below_its_nyquist_wavenumber_and_none_at_it():
    field = np.random.default_rng(3).normal(size=(64, 48))
    whole = fourier.forward(field)
    coarse = fourier.forward(long_waves(field, rs.Grid((32, 32), (3e-3, 2e-3))))
    for rows in (slice(0, 16), slice(-15, None)):
        np.testing.assert_allclose(coarse[rows, :16], whole[rows, :16], atol=1e-12)
    np.testing.assert_allclose(coarse[16], 0.0, atol=1e-12)
    np.testing.assert_allclose(coarse[:, 16], 0.0, atol=1e-12)


def test_long_waves_of_the_previewed_temperature_are_those_of_the_whole(capped_run, monkeypatch):
    # the temperature is linear in the heat, wave by wave
    monkeypatch.setattr(fields, "PREVIEW", 64)
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


def distribution(temperature, pressure):
    """The distribution of a temperature over the contact of a member with a pressure."""
    field = np.asarray(pressure, dtype=float)
    grid = rs.Grid(field.shape, (1.0, 1.0))
    return MemberFields(None, grid, field, field, grid, field).distribution(np.asarray(temperature, dtype=float))


def test_the_distribution_has_the_mean_and_the_flash_temperature_of_the_contact():
    found = distribution([[1.0, 2.0], [4.0, 100.0]], [[1.0, 1.0], [2.0, 0.0]])
    assert found.flash_temperature == pytest.approx((1 + 2 + 8) / 4)
    assert found.mean_temperature == pytest.approx(7 / 3)
    assert found.max_temperature == 4.0  # 100 K is outside the contact
    width = 3.0 / 80
    np.testing.assert_allclose(found.edges, 1.0 + width * np.arange(81))
    places = [0, round(1.0 / width), 79]  # of 1 K, 2 K and 4 K
    for density, shares in ((found.area, [1 / 3, 1 / 3, 1 / 3]), (found.heat, [0.25, 0.25, 0.5])):
        bins = [density[max(place - 1, 0) : place + 1].sum() for place in places]  # 2 K lies on an edge, to rounding
        np.testing.assert_allclose(np.array(bins) * width, 100.0 * np.array(shares))


@pytest.mark.parametrize("values", [[[3.0]], [[300.0, 300.0]], [[1.0, 5.0, 2.0]]])
def test_a_distribution_adds_up_to_one_hundred_per_cent(values):
    found = distribution(values, np.ones_like(values))
    for density in (found.area, found.heat):
        assert (density * np.diff(found.edges)).sum() == pytest.approx(100.0)


def test_no_contact_has_no_distribution():
    assert distribution(np.ones((3, 3)), np.zeros((3, 3))) is None
