"""Runs whose lowest level is corrected by the peak volume of its surfaces."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm
from small_scene import CAPPED
from stored_cases import read_member

import roughsim as rs
from roughsim.scene import parse_scene

COUNT = 13  # more than the regression needs
SHARE = 0.09  # of the area: nominal pressure over hardness


@pytest.fixture
def scene():
    small = parse_scene(CAPPED)
    levels = (rs.Level("capped", (64, 64), 5e4), rs.Level("capped", (96, 96), 1e5))
    return replace(
        small,
        ensemble=replace(small.ensemble, max_realizations=COUNT),
        numerics=replace(small.numerics, levels=levels, keep_fields=0),
    )


def volume_of(heights):
    """Of all waves, at the level of the contact area, less the mean of a normal surface, nearly that of surfaces."""
    level = norm.isf(SHARE)
    return np.maximum(heights / heights.std() - level, 0.0).mean() - (
        norm.pdf(level) - level * SHARE
    )


def at_mean(values, *controls):
    """Each value with the slopes of all others."""
    result = np.empty(len(values))
    for i in range(len(values)):
        others = np.arange(len(values)) != i
        design = np.column_stack((np.ones(len(values) - 1), *(x[others] for x in controls)))
        slopes = np.linalg.lstsq(design, values[others], rcond=None)[0][1:]
        result[i] = values[i] - sum(b * x[i] for b, x in zip(slopes, controls, strict=True))
    return result


def test_a_run_reports_the_mean_at_the_mean_peak_volume(scene, tmp_path):
    run = rs.run(scene, tmp_path / "run")
    solved = [rs.realize(scene, run.numerics, seed=3, level=0, index=i) for i in range(COUNT)]
    volumes = np.array([volume_of(one.heights) for one in solved])
    members = [read_member(run.folder, 0, i).numbers for i in range(COUNT)]
    stored = np.array([x["peak_volume"][0] for x in members])
    np.testing.assert_allclose(
        stored, volumes, atol=0.02 * volumes.std() + abs(stored.mean() - volumes.mean())
    )
    assert np.corrcoef(stored, volumes)[0, 1] > 0.999
    hot = np.array([one.observables.flash_temperature[2] for one in solved])
    fine = [read_member(run.folder, 1, i) for i in range(run.counts[1])]
    above = sum(one.numbers["flash_temperature"][2] for one in fine)
    below = sum(one.moments[1].numbers["flash_temperature"][2] for one in fine)
    found = run.values("flash_temperature", extrapolated=False)
    assert found.finest[2] == pytest.approx(at_mean(hot, stored).mean() * above / below, rel=1e-9)


def test_failed_members_take_no_part(scene, tmp_path, failing):
    failing(lambda problem: (problem.stream, problem.index) == (0, 2))
    run = rs.run(scene, tmp_path / "run")
    assert run.failed == 1
    rows = [i for i in range(COUNT) if i != 2]
    numbers = [run.members[0, i].numbers for i in rows]
    hot, volumes = (
        np.array([x[name][k] for x in numbers])
        for name, k in (("flash_temperature", 2), ("peak_volume", 0))
    )
    found = run.values("flash_temperature", extrapolated=False)
    apart = found.influence[0][:, 2] / found.value[2] * len(rows)
    expected = at_mean(hot, volumes)
    np.testing.assert_allclose(apart, expected / expected.mean() - 1.0, rtol=1e-9, atol=1e-12)
