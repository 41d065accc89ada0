"""Runs whose members store a skewness, and runs from before members did."""

import importlib
from dataclasses import replace

import numpy as np
import pytest
from small_scene import CAPPED

import roughsim as rs
from roughsim.observables.catalogue import NUMBERS
from roughsim.scene import parse_scene
from roughsim.store import member_files, member_hdf5
from roughsim.store.member_files import member_path, read_member

COUNT = 9  # one more than the regression needs


@pytest.fixture
def scene():
    small = parse_scene(CAPPED)
    levels = (rs.Level("capped", (64, 64), 5e4), rs.Level("capped", (96, 96), 1e5, 4))
    return replace(
        small,
        ensemble=replace(small.ensemble, max_realizations=COUNT),
        numerics=replace(small.numerics, levels=levels, keep_fields=0),
    )


def skewness_of(heights):
    """Of all waves up to 32 per side: the surfaces of the first level have no others."""
    return (heights**3).mean() / (heights**2).mean() ** 1.5


def at_zero(values, skewness):
    """Each value with the slope of all others."""
    others = [np.arange(len(values)) != i for i in range(len(values))]
    slopes = np.array([np.polyfit(skewness[rest], values[rest], 1)[0] for rest in others])
    return values - slopes * skewness


def test_a_run_reports_the_mean_at_zero_skewness(scene, tmp_path):
    run = rs.run(scene, tmp_path / "run")
    solved = [rs.realize(scene, run.numerics, seed=3, level=0, index=i) for i in range(COUNT)]
    skewness = np.array([skewness_of(one.heights) for one in solved])
    stored = [read_member(member_path(run.folder, 0, i)).numbers["skewness"] for i in range(COUNT)]
    np.testing.assert_allclose(np.concatenate(stored), skewness, rtol=1e-9)
    hot = np.array([one.observables.flash_temperature[2] for one in solved])
    fine = [rs.realize(scene, run.numerics, seed=3, level=1, index=i).observables for i in (0, 4, 8)]
    steps = [one.flash_temperature[2] - hot[i] for one, i in zip(fine, (0, 4, 8), strict=True)]
    found = run.values("flash_temperature", extrapolated=False)
    assert found.extrapolated[:, 2].mean() == pytest.approx(at_zero(hot, skewness).mean() + np.mean(steps), rel=1e-9)


def test_a_run_from_before_reads_as_it_did_and_goes_on(scene, tmp_path, monkeypatch):
    with monkeypatch.context() as before:  # what an older version stored
        before.delitem(NUMBERS, "skewness")
        for module in (member_files, member_hdf5, importlib.import_module("roughsim.ensemble.run")):
            before.setattr(module, "FORMAT", 2)
        rs.run(scene, tmp_path / "run")
    run = rs.open_run(tmp_path / "run")
    members = [read_member(member_path(run.folder, 0, i)).numbers for i in range(COUNT)]
    assert all("skewness" not in numbers for numbers in members)
    hot = np.array([numbers["flash_temperature"][2] for numbers in members])
    fine = [read_member(member_path(run.folder, 1, i)).numbers["flash_temperature"][2] for i in (0, 4, 8)]
    found = run.values("flash_temperature", extrapolated=False)
    expected = hot.mean() + np.mean([value - hot[i] for value, i in zip(fine, (0, 4, 8), strict=True)])
    assert found.extrapolated[:, 2].mean() == pytest.approx(expected, rel=1e-12)
    assert found.base[:, 2].std() == pytest.approx(hot.std(), rel=1e-9)
    # members that come now have one, and the others count as they are
    longer = rs.run(replace(scene, ensemble=replace(scene.ensemble, max_realizations=COUNT + 3)), tmp_path / "run")
    assert longer.realizations == COUNT + 3
    new = [longer.members[0, i].numbers for i in range(COUNT, COUNT + 3)]
    assert all(np.isfinite(numbers["skewness"]).all() for numbers in new)
    np.testing.assert_allclose(
        longer.values("flash_temperature", extrapolated=False).base[:COUNT, 2] - found.base[:, 2],
        longer.values("flash_temperature", extrapolated=False).base[0, 2] - found.base[0, 2],
        rtol=1e-9,
    )


def test_the_levels_of_a_realization_have_almost_the_same_skewness(scene, tmp_path):
    run = rs.run(scene, tmp_path / "run")
    for index in (0, 4, 8):
        coarse, fine = (float(run.members[level, index].numbers["skewness"][0]) for level in (0, 1))
        assert fine == pytest.approx(coarse, abs=0.02)  # the finer level has more modes beside the same long waves
        assert abs(coarse) > 0.001


def test_failed_members_take_no_part(scene, tmp_path, monkeypatch):
    from roughsim.ensemble import workers

    solve = workers.solve_problem

    def fails(problem, before):
        if problem.index == 2:
            raise rs.ConvergenceError("residual = 1 exceeds 1e-4", residual=1.0, iterations=10)
        return solve(problem, before)

    monkeypatch.setattr(workers, "solve_problem", fails)
    run = rs.run(scene, tmp_path / "run")
    assert run.failed == 1
    rows = [i for i in range(COUNT) if i != 2]
    numbers = [run.members[0, i].numbers for i in rows]
    hot, skewness = (np.array([x[name][k] for x in numbers]) for name, k in (("flash_temperature", 2), ("skewness", 0)))
    base = run.values("flash_temperature", extrapolated=False).base[:, 2]
    expected = at_zero(hot, skewness)
    np.testing.assert_allclose(base - base.mean(), expected - expected.mean(), rtol=1e-6, atol=1e-9)
