"""Plans: the rules and their reasons, what a scene overrides, and what is refused."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest

import roughsim as rs
from roughsim import plan as _function  # the public name is the function, whatever was imported
from roughsim.planning.levels import fast_size
from roughsim.scene import parse_scene
from roughsim.scene.numerics import Level, Numerics

WAVE = 2 * pi / 6350
# q_y, 1/m, where 99 % of the contact has yielded
YIELD = {"steel-0.5GPa": 2.5e4, "steel-1.2GPa": 5.1e4, "steel-2.0GPa": 7.6e4}
TOP = {"steel-0.5GPa": 32, "steel-1.2GPa": 16, "steel-2.0GPa": 16}  # over q_y, for 1 %


@pytest.mark.parametrize("name", YIELD)
@pytest.mark.slow
def test_steel_is_planned_from_where_it_yields(name):
    numerics = rs.plan(rs.load_scene(name))
    coarse, fine = (numerics.levels[i] for i in numerics.of_column("smoothed"))
    assert numerics.lengths == pytest.approx((4 * WAVE, 4 * WAVE))
    assert fine.q_max == coarse.q_max == pytest.approx(1.5 * YIELD[name], rel=0.02)
    assert (pixels(coarse, numerics), pixels(fine, numerics)) == (4, 8)
    ladder = [numerics.levels[i] for i in numerics.of_column("capped")]
    # half the cell begins with the first rung again; the lower two rungs have partners; the lowest stands at 4 q_y
    rungs = {16: [4, 4, 4, 8, 8, 16], 32: [4, 4, 4, 8, 8, 16, 32]}[TOP[name]]
    assert [level.cell for level in ladder] == [None, *["half"] * (len(rungs) - 1)]
    assert [pixels(level, numerics) for level in ladder] == [4, 4, 8, 4, 8, 4, 4][: len(rungs)]
    assert [level.q_max / YIELD[name] for level in ladder] == pytest.approx(rungs, rel=0.02)
    # the first correction is solved for more realizations than what the rarest levels add or show
    first, start, *partners, top = (ladder[i].every for i in (0, 1, 2, 4, -1))
    assert (first, ladder[3].every) == (1, start)
    assert {*partners, top} == {top}
    assert top > start
    told = {r.choice for r in numerics.reasons}
    assert {"cell", "smoothed", "capped", "pilot", "realizations", "error", "workers", "tolerance", "memory"} <= told


def pixels(level, numerics):
    """Pixels per shortest wave, to the nearest whole number below 4/3 of the wanted."""
    per_wave = level.shape[0] * 2 * pi / (level.q_max * numerics.lengths[0] / (2 if level.cell == "half" else 1))
    return next(n for n in (4, 8, 16) if 0.98 * n <= per_wave < 1.34 * n)


def test_a_loose_target_takes_coarser_grids():
    scene = rs.load_scene("steel-1.2GPa")
    assert rs.plan(scene, 0.2).levels[-1].q_max == pytest.approx(rs.plan(scene, 0.01).levels[-1].q_max / 2)


def test_a_plan_is_the_same_every_time_and_tells_what_to_expect():
    scene = rs.load_scene("steel-1.2GPa")
    first, second = rs.plan(scene, 0.02), rs.plan(scene, 0.02)
    assert first == second
    forecast = first.forecast
    parts = (forecast.statistical, forecast.bandwidth, forecast.pixel, forecast.size)
    assert forecast.total == pytest.approx(np.linalg.norm(parts))
    assert forecast.total <= 0.02
    assert forecast.realizations >= 12
    assert forecast.cpu_seconds > 0.0
    assert forecast.wall_seconds(4) == pytest.approx(3.0 + forecast.cpu_seconds / 4, rel=1e-12)
    assert any(
        r.choice == "realizations" and "--until flash_temperature=" in r.reason for r in first.reasons
    )  # a target in all says at which statistical error to stop


def test_a_plan_says_when_the_realizations_end_before_the_target():
    scene = rs.load_scene("demo")

    def told(most, target):
        ensemble = replace(scene.ensemble, max_realizations=most, until={"flash_temperature": target})
        reasons = rs.plan(replace(scene, ensemble=ensemble)).reasons
        return next(reason for reason in reasons if reason.choice == "realizations")

    assert "max_realizations" not in told(1000, 0.05).reason
    short = told(20, 5e-4)
    assert short.value == "about 20"
    wanted = float(short.reason.rpartition("max_realizations ends the run before, as that takes about ")[2])
    assert wanted > 500  # a scatter of half a percent and more falls as 1/√n


@pytest.mark.slow  # a pilot of 512² points
def test_an_elastic_scene_is_resolved_or_cut_with_a_word():
    scene = rs.load_scene("steel-1.2GPa")
    elastic = replace(scene, body=replace(scene.body, penetration_hardness=None))
    numerics = rs.plan(elastic)
    assert {level.column for level in numerics.levels} == {"elastic"}
    top = 2048 * pi / (2 * 4 * WAVE)  # 4 pixels per wave on 2048²
    assert [level.q_max / top for level in numerics.levels] == pytest.approx([0.25, 0.25, 0.5, 1.0])
    assert [level.shape[0] for level in numerics.levels] == [512, 1024, 1024, 2048]
    assert [level.every == 1 for level in numerics.levels] == [True, False, False, False]
    assert "C(q) cut at q_c" in [r.reason for r in numerics.reasons if r.choice == "elastic"][-1]
    short = replace(elastic, surface=replace(elastic.surface, q_max=2e5))
    assert {level.q_max for level in rs.plan(short).levels} == {2e5}


def test_a_plateau_is_given_eight_roll_off_waves():
    scene = rs.load_scene("steel-1.2GPa")
    flat = replace(scene, surface=replace(scene.surface, roll_off_exponent=0.0, q_min=5e4))
    assert rs.plan(flat).lengths[0] == pytest.approx(8 * 2 * pi / 9.4e4)


def test_what_the_scene_fixes_is_taken_as_it_is(capped_scene):
    numerics = rs.plan(capped_scene)
    assert [level.shape for level in numerics.levels] == [(64, 64), (64, 64), (128, 128)]
    assert numerics.lengths == (2e-3, 2e-3)
    assert {r.reason for r in numerics.reasons if r.choice in ("levels", "cell", "tolerance")} == {"given in the scene"}


def test_numerics_survive_their_json():
    numerics = rs.plan(rs.load_scene("demo"))
    slid = replace(numerics, slid_distance=float("inf"))
    for one in (numerics, slid):
        assert Numerics.from_dict(one.to_dict()) == one
    assert "solver" not in numerics.to_dict()  # as in runs from before there was a choice
    with pytest.raises(ValueError, match='solver = "other" is not known; the choice is active_set'):
        replace(numerics, solver="other")


def test_levels_of_a_column_are_ordered_and_the_finest_names_the_stream():
    levels = (Level("capped", (128, 128), 1e5), Level("smoothed", (64, 64), 5e4), Level("capped", (64, 64), 5e4))
    numerics = Numerics(levels, (2e-3, 2e-3))
    assert numerics.of_column("capped") == (2, 0)
    assert numerics.columns == ("smoothed", "capped")
    assert {numerics.stream(level) for level in range(3)} == {0}


@pytest.mark.parametrize("points", np.geomspace(1, 5000, 60))
def test_fast_sizes_are_just_large_enough(points):
    size = fast_size(points)
    odd = size
    while odd % 2 == 0:
        odd //= 2
    assert odd in (1, 3, 5)
    assert size >= min(0.98 * points, size)
    assert size <= max(8, 1.34 * points)


def test_fine_levels_are_solved_for_few():
    levels = (Level("capped", (64, 64), 5e4), Level("capped", (128, 128), 1e5, every=4))
    numerics = Numerics(levels, (2e-3, 2e-3))
    assert [numerics.of_index(i) for i in (0, 1, 4)] == [(0, 1), (0,), (0, 1)]
    assert numerics.members(13) == 13 + 4
    # the coarsest is for all; a multiple of the rung below; partners may be rarer than rungs, but nested with all
    finer = Level("capped", (256, 256), 2e5, every=6)
    refined = Level("capped", (256, 256), 1e5, every=6)
    for bad in ((Level("capped", (64, 64), 5e4, every=2),), (*levels, finer), (*levels, refined)):
        with pytest.raises(ValueError, match="every = . does not fit"):
            Numerics(bad, (2e-3, 2e-3))


def test_a_partner_may_be_solved_for_fewer_realizations_than_the_rung_above():
    rungs = [Level("capped", (n, n), 800.0 * n, every) for n, every in ((64, 1), (128, 2), (256, 4))]
    partner = Level("capped", (128, 128), rungs[0].q_max, every=8)
    assert Numerics((*rungs, partner), (2e-3, 2e-3)).members(9) == 9 + 5 + 3 + 2
    with pytest.raises(
        ValueError, match="levels.2..every = 3 does not fit.*multiple of that of the rung below it, here of 2"
    ):
        Numerics((*rungs[:2], replace(rungs[2], every=3)), (2e-3, 2e-3))


REFUSED = {
    "tolerance": {"tolerance": 2.0},
    "precision": {"precision": "half"},
    "threads": {"threads": 0},
    "keep_fields": {"keep_fields": -1},
    r"levels = \(\) must be a list of at least one level": {"levels": ()},
    "lengths": {"lengths": (1.0, -1.0)},
}


@pytest.mark.parametrize("match", REFUSED)
def test_bad_numerics_are_refused_by_name(match):
    values = {"levels": (Level("elastic", (64, 64), 1.0),), "lengths": (1.0, 1.0)} | REFUSED[match]
    with pytest.raises(ValueError, match=match):
        Numerics(**values)


def test_a_cut_off_beyond_nyquist_is_refused():
    with pytest.raises(rs.ResolutionError, match=r"q_max = .* rad/m exceeds the Nyquist wavenumber"):
        Numerics((Level("elastic", (64, 64), 1e4),), (1.0, 1.0))


def test_unfit_columns_targets_and_memory_are_refused(capped_scene):
    with pytest.raises(ValueError, match='column = "plastic" is not known; did you mean "elastic"'):
        Level("plastic", (8, 8), 1.0)
    with pytest.raises(ValueError, match="target_error"):
        rs.plan(capped_scene, 0.0)
    soft = replace(capped_scene.numerics, levels=({"column": "elastic", "shape": [64, 64], "q_max": 1e4},))
    with pytest.raises(ValueError, match='column = "elastic" does not fit a scene with a hardness'):
        rs.plan(replace(capped_scene, numerics=soft))
    huge = replace(capped_scene.numerics, levels=({"column": "capped", "shape": [10**6, 10**6], "q_max": 1e5},))
    with pytest.raises(rs.ResolutionError, match="memory"):
        rs.plan(replace(capped_scene, numerics=huge))


def test_the_public_name_is_the_function():
    assert callable(_function)
    assert _function is rs.plan
    assert parse_scene


def test_a_plan_of_one_realization_says_that_its_scatter_is_unknown():
    scene = rs.load_scene("demo")
    once = replace(scene, ensemble=replace(scene.ensemble, max_realizations=1))
    reasons = {reason.choice: reason for reason in rs.plan(once).reasons}
    assert reasons["error"].value == "unknown"
    assert "statistical unknown" in reasons["error"].reason


def test_a_younger_key_of_the_numerics_is_stored_where_it_has_a_value_of_its_own(monkeypatch):
    monkeypatch.setattr("roughsim.scene.numerics.YOUNGER", ("solver", "precision"))
    old = Numerics((Level("elastic", (32, 32), 1e4),), (1e-3, 1e-3))
    assert not {"solver", "precision"} & set(old.to_dict())
    assert Numerics.from_dict(old.to_dict()) == old
    new = replace(old, precision="single")
    assert new.to_dict()["precision"] == "single"
    assert Numerics.from_dict(new.to_dict()) == new
