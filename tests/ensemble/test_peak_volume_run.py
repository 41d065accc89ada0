"""Runs whose members store the peak volume of their surfaces, and runs from before members did."""

import importlib
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm
from small_scene import CAPPED

import roughsim as rs
from roughsim.observables.catalogue import NUMBERS
from roughsim.observables.record import Observable
from roughsim.scene import parse_scene
from roughsim.store import member_files, member_hdf5
from roughsim.store.member_files import member_path, read_member

COUNT = 13  # more than the regression needs; every fourth has the finer level
FINE = (0, 4, 8, 12)
SHARE = 0.09  # of the area: nominal pressure over hardness


@pytest.fixture
def scene():
    small = parse_scene(CAPPED)
    levels = (rs.Level("capped", (64, 64), 5e4), rs.Level("capped", (96, 96), 1e5, 4))
    return replace(
        small,
        ensemble=replace(small.ensemble, max_realizations=COUNT),
        numerics=replace(small.numerics, levels=levels, keep_fields=0),
    )


def volume_of(heights):
    """Of all waves, at the level of the contact area, less the mean of a normal surface, nearly that of surfaces."""
    level = norm.isf(SHARE)
    return np.maximum(heights / heights.std() - level, 0.0).mean() - (norm.pdf(level) - level * SHARE)


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
    members = [read_member(member_path(run.folder, 0, i)).numbers for i in range(COUNT)]
    stored, of_long = (np.array([x[name][0] for x in members]) for name in ("peak_volume", "long_peak_volume"))
    np.testing.assert_allclose(stored, volumes, atol=0.02 * volumes.std() + abs(stored.mean() - volumes.mean()))
    assert np.corrcoef(stored, volumes)[0, 1] > 0.999
    assert not of_long.any()  # the surfaces of the first level have no other waves than long ones
    hot = np.array([one.observables.flash_temperature[2] for one in solved])
    fine = [rs.realize(scene, run.numerics, seed=3, level=1, index=i).observables for i in FINE]
    ratio = np.mean([one.flash_temperature[2] for one in fine]) / hot[list(FINE)].mean()
    found = run.values("flash_temperature", extrapolated=False)
    assert found.extrapolated[:, 2].mean() == pytest.approx(at_mean(hot, stored).mean() * ratio, rel=1e-9)


def test_a_run_from_before_reads_as_it_did_and_goes_on(scene, tmp_path, monkeypatch):
    with monkeypatch.context() as before:  # what an older version stored
        before.delitem(NUMBERS, "peak_volume")
        before.delitem(NUMBERS, "long_peak_volume")
        skewness = Observable("skewness", "1", stored="of the surface", measure=lambda _: 0.25, only_stored=True)
        before.setitem(NUMBERS, "skewness", skewness)
        before.setattr(member_files, "NO_LONGER", ())
        for module in (member_files, member_hdf5, importlib.import_module("roughsim.ensemble.run")):
            before.setattr(module, "FORMAT", 2)
        rs.run(scene, tmp_path / "run")
    run = rs.open_run(tmp_path / "run")
    paths = [member_path(run.folder, 0, i) for i in range(COUNT)]
    assert b"skewness" in paths[0].read_bytes()
    members = [read_member(path).numbers for path in paths]
    assert set(read_member(paths[0], with_fields=True).numbers) == set(members[0]) == set(run.members[0, 0].numbers)
    assert not {"peak_volume", "long_peak_volume", "skewness"} & set(members[0])
    hot = np.array([numbers["flash_temperature"][2] for numbers in members])
    fine = [read_member(member_path(run.folder, 1, i)).numbers["flash_temperature"][2] for i in FINE]
    found = run.values("flash_temperature", extrapolated=False)
    ratio = np.mean(fine) / hot[list(FINE)].mean()
    assert found.extrapolated[:, 2].mean() == pytest.approx(hot.mean() * ratio, rel=1e-12)
    assert found.base[:, 2].std() == pytest.approx(hot.std() * ratio, rel=1e-9)
    # members that come now have one, and the others count as they are
    longer = rs.run(replace(scene, ensemble=replace(scene.ensemble, max_realizations=COUNT + 3)), tmp_path / "run")
    assert longer.realizations == COUNT + 3
    new = [longer.members[0, i].numbers for i in range(COUNT, COUNT + 3)]
    assert all(np.isfinite(numbers["peak_volume"]).all() for numbers in new)
    base = longer.values("flash_temperature", extrapolated=False).base[:COUNT, 2]
    np.testing.assert_allclose(base / found.base[:, 2], base[0] / found.base[0, 2], rtol=1e-9)


def test_the_finer_level_has_the_same_long_waves(scene, tmp_path):
    levels = (scene.numerics.levels[0], rs.Level("capped", (160, 160), 2e5, 4))
    run = rs.run(replace(scene, numerics=replace(scene.numerics, levels=levels)), tmp_path / "run")
    pairs = [[run.members[level, index].numbers for level in (0, 1)] for index in FINE]
    # all waves of the first level are long, and nearly all long waves of the second are in the first
    coarse = np.array([first["peak_volume"][0] for first, _ in pairs])
    fine = np.array([second["long_peak_volume"][0] for _, second in pairs])
    assert np.all(fine != 0.0)
    assert np.corrcoef(coarse, fine)[0, 1] > 0.9


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
    hot, volumes = (
        np.array([x[name][k] for x in numbers]) for name, k in (("flash_temperature", 2), ("peak_volume", 0))
    )
    base = run.values("flash_temperature", extrapolated=False).base[:, 2]
    expected = at_mean(hot, volumes)
    np.testing.assert_allclose(base / base.mean(), expected / expected.mean(), rtol=1e-9)
