"""Error over cost: the front, the tolerance, the law of the realizations, and the command."""

import json
from dataclasses import replace
from math import nan

import numpy as np
import pytest

import roughsim as rs
from roughsim import cli
from roughsim import error_over_cost as measurements
from roughsim.charts.error_over_cost import CostPoint, error_over_cost_chart, front, panels
from roughsim.error_over_cost import bench, bench_dict


def point(error, seconds, method="a"):
    return CostPoint("stage", "what", method, "", error, seconds, pairs=seconds)


def small():
    """A demo with few points: two cut-offs, the second in half the cell, and a partner of the first."""
    levels = (
        rs.Level("capped", (64, 64), 2e4),
        rs.Level("capped", (128, 128), 2e4),
        rs.Level("capped", (64, 64), 4e4, "half"),
    )
    return rs.load_scene("demo"), rs.Numerics(levels, (4e-3, 4e-3))


# the front


def test_the_front_is_what_no_other_point_beats_in_both():
    draw = np.random.default_rng(0)
    points = [point(error, cost) for error, cost in draw.random((60, 2))]
    best = front(points)
    for one in points:
        beaten = any(
            p.error <= one.error and p.seconds <= one.seconds and p is not one for p in points
        )
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


@pytest.fixture
def clock(monkeypatch):
    """Sets the readings of the clock of the processor, s."""
    return lambda readings: monkeypatch.setattr(
        measurements.time, "process_time", iter(readings).__next__
    )


def test_a_cost_is_the_least_of_three_calls_after_a_first_one_or_that_of_a_long_one(clock):
    def measured(*durations):
        clock(np.ravel([(10.0 * k, 10.0 * k + seconds) for k, seconds in enumerate(durations)]))
        return measurements.cpu_seconds(lambda: None)

    assert measured(0.125, 0.25, 0.375, 0.3125) == 0.25  # the first fills caches and does not count
    assert measured(0.5, 0.625) == 0.625  # a second in all is enough
    assert measured(2.0) == 2.0


def test_each_cost_is_that_of_one_call(clock):
    calls = []
    clock([0.0, 0.25, 1.0, 1.25, 2.0, 2.25, 3.0, 3.25])
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
    errors = [
        p.error for p in points if p.observable == "pressure" and p.method == "double precision"
    ]
    tolerances = [1e-1, 1e-2, 3e-3, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8]
    for tolerance, error in zip(tolerances, errors, strict=True):
        assert error < 3 * tolerance
    (planned,) = [p for p in points if p.chosen and p.observable == "pressure"]
    assert planned.setting.startswith("tolerance 3e-03")
    pixels = [p.error for p in points if p.observable == "T_flash, any pixel"]
    assert pixels[0] == max(pixels)


# the chain


@pytest.fixture(scope="module")
def chain():
    scene, numerics = small()
    return panels(bench(scene, numerics=numerics, stages=["chain"], realizations=6))


def lines(group):
    """The points of each method: the members of each level, the error, and the cost."""
    result = {}
    for p in group:
        counts = np.array([int(word) for word in p.setting.removesuffix(" members").split(" + ")])
        result.setdefault(p.method, []).append((counts, p.error, p.seconds))
    return result


def test_the_ways_are_each_grid_of_the_cell_alone_the_cut_offs_and_all_levels(chain):
    for group in chain.values():
        assert list(lines(group)) == [
            "one grid, 1× q_c, 64²",
            "one grid, 1× q_c, 128²",
            "2 cut-offs",
            "all levels",
        ]
        (chosen,) = {p.method for p in group if p.chosen}
        assert chosen == "all levels"


def test_the_error_of_the_chain_is_bias_doubt_and_a_scatter_that_falls_with_the_members_of_each_level(
    chain,
):
    for group in chain.values():
        doubt = group[0].uncertainty
        for method, points in lines(group).items():
            counts, errors, _ = (np.array(each) for each in zip(*points, strict=True))
            assert np.all(np.diff(errors) <= 0.0)
            if len(points) <= 1 + counts.shape[1]:
                continue
            # error² = floor + Σ variance of a level/its members
            known = np.column_stack([np.ones(len(points)), 1.0 / counts])
            floor, *variances = np.linalg.lstsq(known, errors**2, rcond=None)[0]
            np.testing.assert_allclose(known @ [floor, *variances], errors**2, rtol=1e-9)
            assert floor >= doubt**2 * (1 - 1e-6)
            if method == "all levels":  # against itself there is no bias
                assert floor == pytest.approx(doubt**2, rel=1e-6)


def test_a_member_of_a_step_costs_both_of_its_solves(clock):
    clock(np.arange(1e6))  # each solve takes one second
    scene, numerics = small()
    group = panels(bench(scene, numerics=numerics, stages=["chain"], realizations=4))[
        "chain: contact area"
    ]
    for method, solves in (
        ("one grid, 1× q_c, 128²", [1]),
        ("2 cut-offs", [1, 2]),
        ("all levels", [1, 2, 2]),
    ):
        for counts, _, seconds in lines(group)[method]:
            assert seconds == pytest.approx(counts @ solves)


def test_members_are_shared_out_at_the_least_cost():
    # N_l = √(V_l/C_l) Σ √(V C)/goal²: with V = 4, 1 and C = 1, 4 it is 2·4 and ½·4 over goal²
    assert measurements.shared_out([4.0, 1.0], [1.0, 4.0], 0.1) == (800, 200)
    assert measurements.shared_out([4.0, 1.0], [1.0, 4.0], 10.0) == (
        12,
        6,
    )  # what a run begins with


def test_levels_far_above_the_lowest_are_not_solved():
    scene, _ = small()
    levels = tuple(rs.Level("capped", (n, n), 640.0 * n) for n in (32, 64, 128, 256))
    ways = measurements.ways_of(scene, rs.Numerics(levels, (4e-3, 4e-3)), 4)
    assert [len(way.samples) for way in ways] == [
        1,
        1,
        1,
        2,
        3,
    ]  # up to four times the lowest cut-off


def test_errors_and_doubts_of_the_chain_are_relative():
    scene, numerics = small()
    hotter = replace(
        scene,
        sliding=replace(scene.sliding, friction_coefficient=8 * scene.sliding.friction_coefficient),
    )
    once, more = (
        bench(s, numerics=numerics, stages=["chain"], realizations=4) for s in (scene, hotter)
    )
    known = {(p.observable, p.method, p.setting): p for p in once}
    same = [(known[key], p) for p in more if (key := (p.observable, p.method, p.setting)) in known]
    assert len(same) > 12  # by the measured times, a few members more or less are shared out
    for a, b in same:  # eight times the temperatures
        assert (b.error, b.uncertainty) == pytest.approx((a.error, a.uncertainty), rel=1e-9, abs=0)
    assert max(point.uncertainty for point in once) > 0


# the outside


@pytest.mark.slow
def test_the_chart_is_a_picture(tmp_path):
    error_over_cost_chart(
        [point(0.5 / k, k, method) for k in (1.0, 2.0) for method in "ab"], tmp_path / "chart.png"
    )
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
    [
        ({"stages": ["weather"]}, "stage = 'weather' is unknown"),
        ({"realizations": 3}, "realizations = 3 must be"),
    ],
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


def test_grids_that_the_memory_does_not_hold_are_refused_before_any_work(memory):
    scene, numerics = small()
    memory(9.8e6)  # 256² × 120 B / 0.8 = 9.83e6
    with pytest.raises(
        rs.ResolutionError,
        match=r"memory = 0.00786 GB \(a grid 4 times as fine as planned\) exceeds",
    ):
        bench(scene, numerics=numerics)
