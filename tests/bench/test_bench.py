"""Error over cost: the front, the law of the realizations, the rows in their file, and the command."""

import json
from dataclasses import replace
from math import inf, nan

import numpy as np
import pytest

import roughsim as rs
from roughsim import cli
from roughsim.bench import STAGES, Point, bench, bench_chart, bench_dict, front, panels
from roughsim.bench.chain import KNOWN
from roughsim.errors import RecordError
from roughsim.store.rows import Rows


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


# the stages


def test_surfaces_of_fixed_amplitudes_have_their_rms_height_and_gaussian_ones_scatter():
    scene, numerics = small()
    points = bench(scene, numerics=numerics, stages=["surface"], realizations=4)
    fixed, gaussian = ([p.error for p in points if p.method.startswith(kind)] for kind in ("fixed", "gaussian"))
    assert max(fixed) < 1e-6
    assert min(gaussian) > 1e-3
    assert [p.setting.split(",")[0] for p in points if p.chosen] == ["4.04 longest waves"]


def test_tighter_tolerances_cost_more_and_err_less():
    scene, numerics = small()
    points = bench(scene, numerics=numerics, stages=["contact"], realizations=4)
    errors = [p.error for p in points if p.observable == "pressure" and p.method == "double precision"]
    for tolerance, error in zip(10.0 ** -np.arange(1.0, 9.0), errors, strict=True):
        assert error < 3 * tolerance
    (planned,) = [p for p in points if p.chosen and p.observable == "pressure"]
    assert planned.setting.startswith("tolerance 1e-04")
    pixels = [p.error for p in points if p.observable == "T_flash, any pixel"]
    assert pixels[0] == max(pixels)


def test_heat_and_theory_meet_the_exact_values_of_others():
    scene, numerics = small()
    points = bench(scene, numerics=numerics, stages=["heat", "theory"], realizations=4)
    kernels = {p.method: p.error for p in points if p.setting.startswith("64 pixels")}
    assert kernels["periodic, from rest"] < 1e-3
    assert kernels["free half-space"] < 1e-3
    assert kernels["periodic, steady"] > 1.0  # hot tracks
    ours, gauss = ([p.error for p in points if p.method == m] for m in ("package theory", "Gauss points"))
    assert ours[0] < 1e-9
    assert gauss[-1] < 1e-12 < gauss[0]


def test_the_mean_over_directions_scatters_less_than_one_direction():
    scene, numerics = small()
    points = bench(scene, numerics=numerics, stages=["moments"], realizations=4)
    error = {p.method: p.error for p in points}
    assert error["mean over directions"] < error["field from rest"] < error["1 direction, steady"]
    assert error["1 direction, steady"] == pytest.approx(error["steady field"], rel=0.05)


# the chain


def test_the_error_of_the_chain_falls_with_the_root_of_the_realizations_to_bias_and_doubt():
    scene, numerics = small()
    points = bench(scene, numerics=numerics, stages=["chain"], realizations=6)
    doubt = {p.observable: p.error for p in points if p.method == KNOWN}
    for title, group in panels(points).items():
        for method in {p.method for p in group}:
            line = {int(p.setting.split()[0]): p.error for p in group if p.method == method}
            assert list(line.values()) == sorted(line.values(), reverse=True)
            floor = line[64] ** 2 - (line[16] ** 2 - line[64] ** 2) / 3  # error² = floor + s²/n
            assert line[256] == pytest.approx(np.sqrt(floor + (line[64] ** 2 - floor) / 4), rel=1e-9)
            least = doubt[title.removeprefix("chain: ")]
            assert floor >= least**2 * (1 - 1e-9)
            if "all of them" in method:  # against itself there is no bias
                assert floor == pytest.approx(least**2, rel=1e-6, abs=1e-15)


def test_few_fine_members_cost_what_their_number_says():
    scene, numerics = small(every=2)
    group = panels(bench(scene, numerics=numerics, stages=["chain"], realizations=4))["chain: contact area"]
    cost = {(p.method, int(p.setting.split()[0])): p.seconds for p in group}
    coarse, fine = (cost[f"one grid, 1× q_c, {n}²", 8] for n in (64, 128))
    assert cost["the plan's levels, all of them", 8] == pytest.approx(coarse + fine)
    assert cost["the plan's levels, fine ones 1 in 2", 8] == pytest.approx(coarse + fine / 2)


# the file


def test_rows_come_back_as_they_were_and_are_not_computed_again(tmp_path):
    rows = Rows(tmp_path / "deep" / "data.json")
    first = rows.once("maps", "σ/E* = 1", lambda: {"error": 1e-3, "why": ""})
    rows.once("maps", "failed", lambda: {"error": nan, "why": "stalled", "more": inf})
    again = Rows(tmp_path / "deep" / "data.json", resume=True)
    assert again.once("maps", "σ/E* = 1", lambda: pytest.fail("computed again")) == first == {"error": 1e-3, "why": ""}
    assert list(again["maps"]) == ["σ/E* = 1", "failed"]
    assert again["maps"]["failed"]["why"] == "stalled"
    assert np.isnan(again["maps"]["failed"]["error"])
    assert again["maps"]["failed"]["more"] == inf
    assert [path.name for path in (tmp_path / "deep").iterdir()] == ["data.json"]  # nothing half-written beside it
    assert not Rows(tmp_path / "deep" / "data.json")["maps"]  # written anew without resume


def test_a_row_that_fails_leaves_the_others_whole(tmp_path):
    rows = Rows(tmp_path / "data.json")
    rows.once("maps", "one", lambda: {"error": 1.0})
    with pytest.raises(ZeroDivisionError):
        rows.once("maps", "two", lambda: {"error": 1 / 0})
    assert list(Rows(tmp_path / "data.json", resume=True)["maps"]) == ["one"]


def test_files_that_hold_no_rows_are_refused(tmp_path):
    for content in ('{"x": 1.0}', '{"rows of roughsim": 1.0}', "[]", "no JSON", "\x89HDF"):
        (tmp_path / "other").write_text(content, "latin-1")
        with pytest.raises(RecordError, match="holds no rows"):
            Rows(tmp_path / "other", resume=True)


def test_a_stage_in_the_file_is_not_measured_again(tmp_path, monkeypatch):
    scene, numerics = small()
    first = bench(scene, numerics=numerics, stages=["surface"], realizations=4, rows=Rows(tmp_path / "data.json"))
    monkeypatch.setitem(STAGES, "surface", lambda *_: pytest.fail("measured again"))
    rows = Rows(tmp_path / "data.json", resume=True)
    assert bench(scene, numerics=numerics, stages=["surface"], realizations=4, rows=rows) == first


# the outside


def test_the_chart_is_a_picture(tmp_path):
    bench_chart([point(0.5 / k, k, method) for k in (1.0, 2.0) for method in "ab"], tmp_path / "chart.png")
    assert (tmp_path / "chart.png").read_bytes().startswith(b"\x89PNG")


def test_the_command_prints_the_front_and_the_choice_of_the_plan(capsys):
    with pytest.raises(SystemExit) as ended:
        cli.main(["bench", "demo", "--stage", "surface", "--realizations", "4"])
    out = capsys.readouterr().out
    assert ended.value.code == 0
    assert "surface: rms height" in out
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
