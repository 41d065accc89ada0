"""Error over cost: the front, the tolerance, the law of the realizations, and the command."""

import json
from dataclasses import replace
from math import nan

import numpy as np
import pytest

import roughsim as rs
from roughsim import bench as measurements
from roughsim import cli
from roughsim.bench import bench, bench_dict
from roughsim.charts.error_over_cost import Point, error_over_cost_chart, front, panels
from roughsim.machine import Limit


def point(error, seconds, method="a"):
    return Point("stage", "what", method, "", error, seconds, pairs=seconds)


def small(every=2):
    """A demo with few points: the plan's kind of levels at 1/64 of its cost."""
    levels = rs.Level("capped", (64, 64), 4e4), rs.Level("capped", (128, 128), 4e4, every)
    return rs.load_scene("demo"), rs.Numerics(levels, (4e-3, 4e-3))


# the front


def test_the_front_is_what_no_other_point_beats_in_both():
    draw = np.random.default_rng(0)
    points = [point(error, cost) for error, cost in draw.random((60, 2))]
    best = front(points)
    for one in points:
        beaten = any(p.error <= one.error and p.seconds <= one.seconds and p is not one for p in points)
        assert (one in best) == (not beaten)
    assert [p.seconds for p in best] == sorted(p.seconds for p in best)


def test_a_failure_is_never_on_the_front_and_is_shown_as_no_number():
    points = [point(nan, 0.1), point(0.5, 1.0)]
    assert front(points) == [points[1]]
    told = bench_dict(points)["points"]
    assert told[0]["error"] is None
    assert not told[0]["front"]
    json.dumps(told, allow_nan=False)


# the costs


def test_a_cost_is_the_least_of_three_calls_after_a_first_one_or_that_of_a_long_one(monkeypatch):
    def measured(*durations):
        clock = iter(np.ravel([(10.0 * k, 10.0 * k + seconds) for k, seconds in enumerate(durations)]))
        monkeypatch.setattr(measurements.time, "process_time", lambda: next(clock))
        return measurements.cpu_seconds(lambda: None)

    assert measured(0.125, 0.25, 0.375, 0.3125) == 0.25  # the first fills caches and does not count
    assert measured(0.5, 0.625) == 0.625  # a second in all is enough
    assert measured(2.0) == 2.0


def test_each_cost_is_that_of_one_call(monkeypatch):
    calls = []
    clock = iter([0.0, 0.25, 1.0, 1.25, 2.0, 2.25, 3.0, 3.25])
    monkeypatch.setattr(measurements.time, "process_time", lambda: next(clock))
    assert measurements.cpu_seconds(lambda: calls.append("call")) == 0.25
    assert len(calls) == 4  # a first one and three that count


# the stages


@pytest.mark.slow
def test_tighter_tolerances_cost_more_and_err_less():
    scene, numerics = small()
    points = bench(scene, numerics=numerics, stages=["contact"], realizations=4)
    rates = [p.seconds / p.pairs for p in points]
    assert rates == pytest.approx([rates[0]] * len(rates), rel=1e-12)
    assert 1e-4 < rates[0] < 1.0  # a pair of 512² takes milliseconds
    errors = [p.error for p in points if p.observable == "pressure" and p.method == "double precision"]
    tolerances = [1e-1, 1e-2, 3e-3, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8]
    for tolerance, error in zip(tolerances, errors, strict=True):
        assert error < 3 * tolerance
    (planned,) = [p for p in points if p.chosen and p.observable == "pressure"]
    assert planned.setting.startswith("tolerance 3e-03")
    pixels = [p.error for p in points if p.observable == "T_flash, any pixel"]
    assert pixels[0] == max(pixels)


# the chain


def test_the_error_of_the_chain_falls_with_the_root_of_the_realizations_to_bias_and_doubt():
    scene, numerics = small()
    points = bench(scene, numerics=numerics, stages=["chain"], realizations=6)
    for group in panels(points).values():
        for method in {p.method for p in group}:
            line = {int(p.setting.split()[0]): p.error for p in group if p.method == method}
            assert list(line.values()) == sorted(line.values(), reverse=True)
            floor = line[64] ** 2 - (line[16] ** 2 - line[64] ** 2) / 3  # error² = floor + s²/n
            assert line[256] == pytest.approx(np.sqrt(floor + (line[64] ** 2 - floor) / 4), rel=1e-9)
            least = group[0].doubt
            assert floor >= least**2 * (1 - 1e-9)
            if "all of them" in method:  # against itself there is no bias
                assert floor == pytest.approx(least**2, rel=1e-6, abs=1e-15)


def test_the_splits_begin_with_the_coarsest_level_and_end_with_the_choice_of_the_plan():
    sides = ((64, 1e4), (128, 1e4), (128, 2e4), (256, 2e4), (256, 4e4))
    levels = [rs.Level("capped", (side, side), q_c, 1 if k == 0 else 8) for k, (side, q_c) in enumerate(sides)]
    splits = measurements.splits_of(levels)
    assert [split.levels for split in splits[:5]] == [(0,), (1,), (2,), (3,), (4,)]  # each grid alone
    assert [split.levels for split in splits[5:7]] == [(0, 2), (0, 2, 4)]  # the coarsest grid of each cut-off
    assert [split.levels for split in splits[7:]] == [(0, 1, 2, 3, 4)] * 4
    assert [split.strides for split in splits[7:]] == [(1, k, k, k, k) for k in (1, 2, 4, 8)]
    assert [split.planned for split in splits] == [False] * 10 + [True]


def test_a_plan_with_two_strides_is_one_of_the_splits():
    strides = (1, 8, 2, 8)
    sides = ((64, 1e4), (128, 1e4), (128, 2e4), (256, 4e4))
    levels = [rs.Level("capped", (n, n), q_c, every) for (n, q_c), every in zip(sides, strides, strict=True)]
    chosen = [split for split in measurements.splits_of(levels) if split.planned]
    assert [split.strides for split in chosen] == [strides]
    assert chosen[0].method == "the plan's levels, fine ones 1 in 2 or 8"


def test_levels_in_half_the_cell_are_never_alone_and_have_surfaces_of_their_own(monkeypatch):
    levels = [rs.Level("capped", (64, 64), 2e4)]
    levels += [rs.Level("capped", (n, n), q_c, 2, "half") for n, q_c in ((32, 2e4), (64, 4e4))]
    splits = measurements.splits_of(levels)
    assert [split.levels for split in splits] == [(0,)] + [(0, 1, 2)] * 3
    seen = []
    solve_level = measurements.solve_level

    def noted(problem, level, realizations):
        sample, seconds = solve_level(problem, level, realizations)
        seen.append((problem.stream, problem.grid.lengths[0], sample.part))
        return sample, seconds

    monkeypatch.setattr(measurements, "solve_level", noted)
    scene, numerics = small(every=2)
    side = numerics.lengths[0]
    bench(scene, numerics=replace(numerics, levels=tuple(levels)), stages=["chain"], realizations=4)
    (first, *whole), *halves = seen
    assert whole == [side, False]
    assert [half[1:] for half in halves] == [(side / 2, True)] * 2
    assert first not in {stream for stream, _, _ in halves}
    assert len({stream for stream, _, _ in halves}) == 1


def test_where_only_the_fine_members_scatter_their_number_alone_counts(monkeypatch):
    # T = T₀ + (T − T₀) with n values of T₀ and n/k of T − T₀. If T₀ is the same in all, n/k is all that counts
    solve_level = measurements.solve_level

    def without_scatter_of_the_first(problem, level, realizations):
        sample, seconds = solve_level(problem, level, realizations)
        if level.shape == (64, 64):
            numbers = {name: np.zeros_like(rows) + rows[0] for name, rows in sample.numbers.items()}
            sample = replace(sample, numbers=numbers, spectrum=np.zeros_like(sample.spectrum) + sample.spectrum[0])
        return sample, seconds

    monkeypatch.setattr(measurements, "solve_level", without_scatter_of_the_first)
    scene, numerics = small(every=2)
    points = panels(bench(scene, numerics=numerics, stages=["chain"], realizations=4))
    for title in ("chain: T_flash, fastest", "chain: contact area"):
        error = {
            (p.method.removeprefix("the plan's levels, "), int(p.setting.split()[0])): p.error for p in points[title]
        }
        assert error["fine ones 1 in 2", 64] == pytest.approx(error["all of them", 32], rel=1e-9)
        assert error["fine ones 1 in 4", 64] == pytest.approx(error["all of them", 16], rel=1e-9)
        every, fine = (error[m, 16] ** 2 - error[m, 64] ** 2 for m in ("all of them", "one grid, 1× q_c, 128²"))
        assert 1.0 < every / fine < 10.0  # extrapolated over the pixel: (1 + a)² times the scatter of the fine level


def test_errors_and_doubts_of_the_chain_are_relative():
    scene, numerics = small()
    hotter = replace(scene, sliding=replace(scene.sliding, friction_coefficient=8 * scene.sliding.friction_coefficient))
    once, more = (bench(s, numerics=numerics, stages=["chain"], realizations=4) for s in (scene, hotter))
    for a, b in zip(once, more, strict=True):  # eight times the temperatures
        assert (b.error, b.doubt) == pytest.approx((a.error, a.doubt), rel=1e-9, abs=0)
    assert max(point.doubt for point in once) > 0


def test_few_fine_members_cost_what_their_number_says():
    scene, numerics = small(every=2)
    group = panels(bench(scene, numerics=numerics, stages=["chain"], realizations=4))["chain: contact area"]
    cost = {(p.method, int(p.setting.split()[0])): p.seconds for p in group}
    coarse, fine = (cost[f"one grid, 1× q_c, {n}²", 8] for n in (64, 128))
    assert cost["the plan's levels, all of them", 8] == pytest.approx(coarse + fine)
    assert cost["the plan's levels, fine ones 1 in 2", 8] == pytest.approx(coarse + fine / 2)


# the outside


def test_the_chart_is_a_picture(tmp_path):
    error_over_cost_chart([point(0.5 / k, k, method) for k in (1.0, 2.0) for method in "ab"], tmp_path / "chart.png")
    assert (tmp_path / "chart.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_the_command_prints_the_front_and_the_choice_of_the_plan(capsys):
    with pytest.raises(SystemExit) as ended:
        cli.main(["bench", "demo", "--stage", "contact", "--realizations", "4"])
    out = capsys.readouterr().out
    assert ended.value.code == 0
    assert "contact: T_flash, any pixel" in out
    assert "plan" in out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [({"stages": ["weather"]}, "stage = 'weather' is unknown"), ({"realizations": 3}, "realizations = 3 must be")],
)
def test_what_cannot_be_measured_is_refused(arguments, message):
    scene, numerics = small()
    with pytest.raises(ValueError, match=message):
        bench(scene, numerics=numerics, **arguments)


def test_a_scene_at_rest_has_no_flash_temperature_to_measure():
    scene, numerics = small()
    still = replace(scene, sliding=replace(scene.sliding, speed=(0.0,)))
    with pytest.raises(ValueError, match="speed = 0 m/s is the highest"):
        bench(still, numerics=numerics)


def test_grids_that_the_memory_does_not_hold_are_refused_before_any_work(monkeypatch):
    scene, numerics = small()
    monkeypatch.setattr(measurements, "available_memory", lambda: Limit(9.8e6, "here"))  # 256² × 120 B / 0.8 = 9.83e6
    monkeypatch.setattr(measurements, "solve_contact", None)
    with pytest.raises(rs.ResolutionError, match=r"memory = 0.00786 GB \(a grid 4 times as fine as planned\) exceeds"):
        bench(scene, numerics=numerics)
