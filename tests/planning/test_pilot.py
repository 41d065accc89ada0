"""Pilots: what a few cheap solves tell, from realizations whose T_flash is known."""

from dataclasses import replace
from math import pi
from types import SimpleNamespace

import numpy as np
import pytest

import roughsim as rs
from roughsim.errors import ConvergenceError
from roughsim.planning import pilot as stage
from roughsim.planning import realization
from roughsim.planning.pilot import HALF_SCATTER, Solved

WAVE = 2 * pi / 6350


def why(numerics, choice):
    return next(r.reason for r in numerics.reasons if r.choice == choice)


def temperatures(index, level):
    """T_flash at two speeds, the second the hotter: 110, 105 at twice the cut-off, 108.5 at half the pixel.

    Level 3 stands for that of twice the cut-off in the run's cell, where realizations scatter half as much.
    """
    if level == 3:
        return 0.5 * (temperatures(index, 1) + np.array([10.5, 105.0]))
    scatter = np.random.default_rng(index).standard_normal(2) * [0.02, 0.01]
    slow, fast = np.random.default_rng(100 + index).standard_normal(2) * [0.0, 0.3]
    coarse = np.array([11.0, 110.0]) * (1 + scatter)
    change = {0: 0.0, 1: -5.0 + fast, 2: -1.5 + 0.1 * fast}[level]
    return coarse + np.array([slow + 0.1 * change, change])


def solution(flash_temperature, peak_volumes=(0.0, 0.0)):
    """A solved member."""
    observables = SimpleNamespace(flash_temperature=flash_temperature)
    return SimpleNamespace(observables=observables, peak_volumes=peak_volumes)


def test_a_pilot_tells_scatter_step_and_pixel(monkeypatch):
    seen = []

    def realize(scene, numerics, *, seed, level, index):
        seen.append((numerics.levels[level], numerics.lengths, seed))
        in_whole = numerics.lengths == (4 * WAVE, 4 * WAVE)
        return solution(temperatures(index, 3 if in_whole else level))

    monkeypatch.setattr(realization, "realize", realize)
    scene = replace(rs.load_scene("steel-1.2GPa"), title="pilot of known realizations")
    found = stage.pilot(scene, "capped", (4 * WAVE, 4 * WAVE), 1e9)
    highest = np.array([temperatures(i, 3) for i in range(12)])
    first, above, finer = (np.array([temperatures(i, level)[1] for i in range(12)]) for level in (0, 1, 2))
    limit = (2 * above - first).mean()  # with an error of first order in 1/q_c
    each = [np.array([temperatures(i, level) for i in range(12)]) for level in (0, 1, 2)]
    limits = (2 * each[1] - each[0]).mean(axis=0)
    relative = highest.std(axis=0, ddof=1) / limits
    assert found.scatter == pytest.approx(relative.max(), rel=1e-12)
    assert found.hot_scatter == pytest.approx(relative[1], rel=1e-12)
    assert found.scatter > found.hot_scatter
    changes = [(rows - each[0]).std(axis=0, ddof=1) / limits for rows in each[1:]]
    # what changes was seen in half the cell, and scatters so much less in the run's
    assert found.widest_change_scatter == pytest.approx(np.max(changes) / HALF_SCATTER, rel=1e-12)
    assert found.step == pytest.approx(-(above - first).mean() / limit, rel=1e-12)
    assert found.pixel == pytest.approx(-(finer - first).mean() / limit, rel=1e-12)
    assert found.change_scatter == pytest.approx((above - first).std(ddof=1) / limit / HALF_SCATTER, rel=1e-12)
    # 512 points resolve the highest cut-off with 4 pixels per wave; half of it on half the points, and with 8
    cut = 512 / 4 / (4 * WAVE) * 2 * pi
    assert found.q_max == pytest.approx(cut)
    grids = {(a.shape[0], round(a.q_max / cut, 6), round(lengths[0] / WAVE, 6)) for a, lengths, _ in seen}
    assert grids == {(128, 0.5, 2), (256, 1, 2), (256, 0.5, 2), (512, 1, 4)}
    seeds = {seed for _, _, seed in seen}
    assert len(seeds) == 1
    assert scene.ensemble.seed not in seeds
    low = stage.pilot(scene, "capped", (4 * WAVE, 4 * WAVE), cut / 2)
    assert low.q_max == pytest.approx(cut / 2)


def test_a_pilot_stays_in_the_runs_cell_where_half_of_it_has_other_changes(monkeypatch):
    seen = set()

    def realize(scene, numerics, *, level, index, **_):
        seen.add((numerics.levels[level].shape[0], numerics.lengths[0]))
        return solution(temperatures(index, level))

    monkeypatch.setattr(realization, "realize", realize)
    scene = replace(rs.load_scene("steel-1.2GPa"), title="pilot of a short cell")
    found = stage.pilot(scene, "capped", (3.9 * WAVE, 3.9 * WAVE), 1e9)
    assert seen == {(256, 3.9 * WAVE), (512, 3.9 * WAVE)}
    fine = np.array([temperatures(i, 1) for i in range(12)])
    changes = fine[:, 1] - [temperatures(i, 0)[1] for i in range(12)]
    limit = fine[:, 1].mean() + changes.mean()
    assert found.hot_scatter == pytest.approx(fine[:, 1].std(ddof=1) / limit, rel=1e-12)
    assert found.change_scatter == pytest.approx(changes.std(ddof=1) / limit, rel=1e-12)


def test_a_pilot_takes_the_changes_from_half_of_a_cell_that_has_a_quarter_too(monkeypatch):
    seen = set()

    def realize(scene, numerics, *, level, index, **_):
        seen.add((numerics.levels[level].shape[0], numerics.lengths[0]))
        return solution(temperatures(index, 3 if numerics.lengths[0] > 5 * WAVE else level))

    monkeypatch.setattr(realization, "realize", realize)
    scene = replace(rs.load_scene("steel-1.2GPa"), title="pilot of a long cell")
    found = stage.pilot(scene, "capped", (8 * WAVE, 8 * WAVE), 1e9)
    assert seen == {(128, 4 * WAVE), (256, 4 * WAVE), (512, 8 * WAVE)}
    first, above = (np.array([temperatures(i, level)[1] for i in range(12)]) for level in (0, 1))
    limit = (2 * above - first).mean()
    assert found.change_scatter == pytest.approx((above - first).std(ddof=1) / limit / 2.0, rel=1e-12)


def test_a_pilot_whose_temperature_more_than_halves_still_tells_its_scatter(monkeypatch):
    def realize(scene, numerics, *, level, index, **_):
        return solution((1.0 + 0.05 * np.random.default_rng(index).standard_normal(1)) * [100.0, 40.0, 95.0][level])

    monkeypatch.setattr(realization, "realize", realize)
    scene = replace(rs.load_scene("steel-1.2GPa"), title="pilot that falls fast")
    found = stage.pilot(scene, "capped", (3.9 * WAVE, 3.9 * WAVE), 1e9)
    rows = np.array([1.0 + 0.05 * np.random.default_rng(i).standard_normal() for i in range(12)])
    # the limit of first order is below zero: half the temperature of the highest cut-off stands for it
    assert found.hot_scatter == pytest.approx(2.0 * rows.std(ddof=1) / rows.mean(), rel=1e-9)


def test_the_scatter_of_a_pilot_is_what_the_peak_volumes_leave(monkeypatch):
    rng = np.random.default_rng(3)
    volumes, rest = rng.standard_normal((12, 2)) * [0.01, 0.02], rng.standard_normal(12)
    told = 4.0 * volumes[:, 0] - 1.0 * volumes[:, 1] + 0.001 * rest  # T_flash is a plane of them, and a rest

    def realize(scene, numerics, *, level, index, **_):
        change = 1 if numerics.lengths[0] == 4 * WAVE else level
        return solution(np.array([10.0 * (1 + told[index]) + change]), volumes[index])

    monkeypatch.setattr(realization, "realize", realize)
    scene = replace(rs.load_scene("steel-1.2GPa"), title="pilot of surfaces with peaks")
    found = stage.pilot(scene, "capped", (4 * WAVE, 4 * WAVE), 1e9)
    rows = 10.0 * (1 + told) + 1
    design = np.column_stack((np.ones(12), volumes))
    left = rows - design @ np.linalg.lstsq(design, rows, rcond=None)[0]
    # the limit of first order is one step above the rows; three numbers were fitted
    assert found.raw_scatter == pytest.approx(rows.std(ddof=1) / (rows.mean() + 1), rel=1e-9)
    assert found.scatter == pytest.approx(np.sqrt((left**2).sum() / 9) / (rows.mean() + 1), rel=1e-6)
    assert found.hot_scatter == found.scatter


def test_the_coarsest_grid_of_a_pilot_has_eight_points_per_side_however_low_the_cut_off(monkeypatch):
    shapes = []

    def realize(scene, numerics, *, level, index, **_):
        shapes.append(numerics.levels[level].shape)
        return solution(temperatures(index, level))

    monkeypatch.setattr(realization, "realize", realize)
    scene = replace(rs.load_scene("steel-1.2GPa"), title="pilot of one wave")
    stage.pilot(scene, "capped", (4 * WAVE, 8 * WAVE), 2 * pi / (8 * WAVE))
    assert list(dict.fromkeys(shapes)) == [(8, 8), (16, 16), (32, 32)]
    shapes.clear()
    stage.pilot(scene, "capped", (4 * WAVE, 8 * WAVE), 12 * 2 * pi / (8 * WAVE))  # 48 points along the longer side
    assert list(dict.fromkeys(shapes)) == [(8, 12), (16, 24), (32, 48)]


def test_the_pace_is_that_of_large_grids():
    nothing = np.zeros((12, 1)), np.zeros(12)
    coarse, fine = (Solved(*nothing, side**2, 0.004 + 1e-8 * side**2.5) for side in (128, 256))  # 4 ms for anything
    assert stage.pace(coarse, fine) == pytest.approx(1e-8, rel=1e-9)
    disturbed = coarse._replace(seconds=fine.seconds)
    assert stage.pace(disturbed, fine) == pytest.approx(0.5 * fine.seconds / 256**2.5)


def test_a_pilot_that_does_not_converge_is_a_guess(monkeypatch):
    def realize(*_, **__):
        raise ConvergenceError("residual = 1 exceeds 1e-4", residual=1.0, iterations=10)

    monkeypatch.setattr(realization, "realize", realize)
    scene = replace(rs.load_scene("steel-1.2GPa"), title="pilot that fails")
    found = stage.pilot(scene, "capped", (4 * WAVE, 4 * WAVE), 1e5)
    assert (found.measured, found.q_max) == (False, 1e5)
    numerics = rs.plan(scene, 0.02)
    assert "a guess" in why(numerics, "pilot")
    parts = (numerics.forecast.statistical, numerics.forecast.bandwidth, numerics.forecast.pixel)
    assert all(0.0 < part < 0.02 for part in parts)
