"""What a plan expects of its run from what the pilot saw: errors, strides and numbers of realizations."""

import importlib
import re
from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest
from scipy import stats

import roughsim as rs
from roughsim import prediction
from roughsim.planning import levels
from roughsim.planning.pilot import Pilot
from roughsim.planning.plan import half_width as expected_half_width
from roughsim.planning.plan import realizations_for, statistical_target, total_work
from roughsim.planning.reasons import forecast_reasons
from roughsim.scene.numerics import Forecast, Level, Numerics

WAVE = 2 * pi / 6350


def why(numerics, choice):
    return next(r.reason for r in numerics.reasons if r.choice == choice)


SEEN = Pilot(
    raw_scatter=0.05, scatter=0.03, hot_scatter=0.02, step=0.2, pixel=0.012, change_scatter=0.004, q_max=2e5, pace=2e-8
)


def planned(monkeypatch, scene, target=None, seen=SEEN):
    monkeypatch.setattr(levels, "pilot", lambda *_: seen)
    return rs.plan(replace(scene, ensemble=replace(scene.ensemble, until={})), target)


def half_width(n, scatter, *changes):
    """Student's, with Satterthwaite's degrees of freedom of all n rows and of the few fine ones of each correction.

    Two slopes are fitted to the rows: they cost two degrees of freedom, and add 2/(n − 5) to the variance.
    """
    few = [-(-n // every) for _, every in changes]
    parts = np.array(
        [
            scatter**2 / n * (n - 3) / (n - 5),
            *(change**2 / fine for (change, _), fine in zip(changes, few, strict=True)),
        ]
    )
    freedom = min(parts.sum() ** 2 / (parts**2 / [n - 3, *(max(fine - 1, 1) for fine in few)]).sum(), n - 3)
    return stats.t.ppf(0.975, freedom) * sqrt(1 + 2 / freedom) * sqrt(parts.sum())


def strides_of(numerics):
    """Of the first correction of the capped column, and of its highest level."""
    ladder = [numerics.levels[i] for i in numerics.of_column("capped")]
    step = next(level for level in ladder if level.q_max > ladder[0].q_max)
    return step.every, ladder[-1].every


def steps_of(numerics):
    """The first level of each cut-off of the capped column above the lowest."""
    levels = [numerics.levels[i] for i in numerics.of_column("capped")]
    first = {level.q_max: level for level in reversed(levels)}
    return [first[q_max] for q_max in sorted(first)[1:]]


def corrections(numerics, change):
    """Scatter and stride: as the pilot's over the cut-off; each step 0.45 of the one before; half the cell twice."""
    change *= 2e5 / numerics.levels[numerics.of_column("capped")[0]].q_max
    change *= 2.0 if numerics.levels[-1].cell == "half" else 1.0
    return [(0.45**k * change, level.every) for k, level in enumerate(steps_of(numerics))]


def test_the_plan_expects_a_rough_surface_to_fall_slowly(monkeypatch):
    monkeypatch.setattr(prediction, "yielded_fall", lambda *_: None)
    steel = rs.load_scene("steel-1.2GPa")
    numerics = planned(monkeypatch, replace(steel, surface=replace(steel.surface, hurst=0.3)), 0.02)
    top, p = numerics.levels[-1].q_max, 0.3 + 1.05 * 0.3
    # the last step of c q^(−p) is (2^p − 1) of what follows; half of that is in doubt
    remainder = 0.2 / (2**p - 1) * (2e5 / top) ** p
    assert numerics.forecast.bandwidth == pytest.approx(0.5 * remainder, rel=1e-9)


@pytest.mark.parametrize("power", [0.5, None])
def test_the_plan_expects_what_the_law_leaves_in_doubt(monkeypatch, power):
    def fall(_, cut_offs):  # at a slow and a fast speed; what follows 8 q_y is 1.2 % of the value, or all of it
        q = np.array([*cut_offs, 1e30])
        return None if power is None else np.stack([5.0 + 0.0 * q, 100.0 * (1 + 7.65 * q**-power)], axis=1)

    monkeypatch.setattr(prediction, "yielded_fall", fall)
    numerics = planned(monkeypatch, rs.load_scene("steel-1.2GPa"), 0.02)
    top = numerics.levels[-1].q_max
    if power is None:
        assert top == pytest.approx(16 * 5.07e4, rel=0.01)
        return
    assert top == pytest.approx(8 * 5.07e4, rel=0.01)
    follows = 1.0 - 1.0 / (1.0 + 7.65 * top**-0.5)  # of the value at 8 q_y
    assert numerics.forecast.bandwidth == pytest.approx(
        sqrt((0.15 * follows) ** 2 + (0.07 * follows) ** 2 + (0.15 * follows) ** 2), rel=1e-9
    )


def test_the_plan_expects_what_the_pilot_says(monkeypatch):
    monkeypatch.setattr(prediction, "yielded_fall", lambda *_: None)
    scene = rs.load_scene("steel-1.2GPa")
    numerics = planned(monkeypatch, scene, 0.02)
    forecast, ladder = numerics.forecast, [numerics.levels[i] for i in numerics.of_column("capped")]
    top, seldom = ladder[-1].q_max, ladder[-1].every
    assert forecast.pixel == pytest.approx(0.012 * 2e5 / top)
    q_y = ladder[-1].q_max / (16 if top > 6e5 else 8)
    assert q_y == pytest.approx(5.07e4, rel=0.01)
    assert forecast.bandwidth == pytest.approx((0.2 if top > 6e5 else 1.0) * 0.2 * 2e5 / top)
    assert {level.cell for level in ladder[1:]} == {"half"}
    # 0.4 % of what the corrections add, beside the size error of the run's cell; they start at a quarter of the top
    added = 0.2 * 2e5 / (top / 4)
    assert forecast.size == pytest.approx(np.hypot(0.002, 0.004 * added))
    assert forecast.cpu_seconds == pytest.approx(2e-8 * work(numerics.levels, forecast.realizations))
    systematic = np.linalg.norm([forecast.bandwidth, forecast.pixel, forecast.size])
    goal = sqrt(0.02**2 - systematic**2)
    n, changes = forecast.realizations, corrections(numerics, 0.4 * 0.004)
    assert n > 2 * seldom  # three fine ones at least
    assert half_width(n, 0.03, *changes) <= goal
    assert n == 2 * seldom + 1 or goal < half_width(n - 1, 0.03, *changes)
    assert forecast.statistical == pytest.approx(half_width(n, 0.02, *changes))
    assert f"flash_temperature={100 * goal:.3g}%" in next(
        r.reason for r in numerics.reasons if r.choice == "realizations"
    )


def work(levels, n):
    return sum(((a.shape[0] * a.shape[1]) ** 1.25 + 5e5) * -(-n // a.every) for a in levels)


def test_a_higher_ladder_is_taken_where_it_saves_more_realizations_than_it_costs(monkeypatch):
    asked = []

    def served(scene, lengths, target, *, lowest):
        asked.append(lowest)
        ends = {8.0: 0.009, 16.0: 0.002}  # what each leaves in doubt, of a target of 1 %
        shapes = {8.0: (64, 64), 16.0: (128, 128)}
        of = {top: [levels.Rung(Level("capped", shapes[top], top), "")] for top in ends}
        return [levels.Ladder(of[top], error, 0.0) for top, error in ends.items()][: 1 if lowest else None], SEEN

    monkeypatch.setattr(importlib.import_module("roughsim.planning.plan"), "ladders_of", served)
    scene = rs.load_scene("steel-1.2GPa")
    free = replace(scene, ensemble=replace(scene.ensemble, until={}))
    assert rs.plan(free, 0.01).levels[0].q_max == 16.0
    # a run that stops at a statistical error takes as many realizations on either
    stopping = replace(scene, ensemble=replace(scene.ensemble, until={"flash_temperature": 0.01}))
    assert rs.plan(stopping).levels[0].q_max == 8.0
    assert asked == [False, True]


def test_a_plan_says_how_far_its_realizations_may_be_off(monkeypatch):
    scene = rs.load_scene("steel-1.2GPa")
    numerics = planned(monkeypatch, scene, 0.012)
    forecast = numerics.forecast
    told = why(numerics, "realizations")
    low, high = (int(word) for word in re.search(r"; (\d+) to (\d+), as the scatter from 12 pilot", told).groups())
    assert low <= forecast.realizations < high
    goal = float(re.search(r"flash_temperature=([\d.]+)%", told).group(1)) / 100
    spread = sqrt(10 / stats.chi2.ppf(0.025, 10))  # how much larger the scatter of 12 values about a line may be
    assert spread == pytest.approx(1.75, abs=0.006)
    changes = corrections(numerics, spread * 0.4 * 0.004)
    # counts above 50 are found in steps of 2 %
    assert (
        half_width(high, spread * 0.03, *changes) < 1.001 * goal < half_width(int(0.97 * high), spread * 0.03, *changes)
    )


@pytest.mark.parametrize("change", [0.0005, 0.004, 0.05])
def test_the_strides_of_fine_levels_are_the_cheapest_powers_of_two(monkeypatch, change):
    scene = rs.load_scene("steel-1.2GPa")
    numerics = planned(monkeypatch, scene, 0.012, replace(SEEN, change_scatter=change))
    forecast, chosen = numerics.forecast, strides_of(numerics)
    systematic = np.linalg.norm([forecast.bandwidth, forecast.pixel, forecast.size])
    goal = sqrt(max(0.012**2 - systematic**2, 0.1 * 0.012**2))
    cost = {}
    for often, seldom in ((2**k, 2**j) for k in range(10) for j in range(k, 10)):
        # each step four times as rare as the one before, at most `seldom`, and the last
        scatters = [scatter for scatter, _ in corrections(numerics, 0.4 * change)]
        steps = [*(min(often * 4**k, seldom) for k in range(len(scatters) - 1)), seldom]
        changes = list(zip(scatters, steps, strict=True))
        n = max(12, 2 * seldom + 1, int((1.9 / goal) ** 2 * (0.03**2 + sum(x * x * k / 2 for x, k in changes))))
        while half_width(n, 0.03, *changes) > goal:
            n += max(1, n // 100)
        if seldom == 1 or 2 * seldom < min(n, scene.ensemble.max_realizations):
            # two smoothed levels, the first capped one, perhaps again; its partner and that of the first step
            repeated = [often] if numerics.levels[-1].cell == "half" else []
            strides = 1, seldom, 1, *repeated, seldom, steps[0], seldom, *steps[1:]
            cost[often, seldom] = work([replace(a, every=k) for a, k in zip(numerics.levels, strides, strict=True)], n)
    assert cost[chosen] <= 1.03 * min(cost.values())  # counts above 50 are found in steps of 2 %
    # a correction that scatters more than the coarsest level is solved each time
    assert (chosen[0] == 1) is (change > 0.004)
    assert chosen[1] >= chosen[0]


def test_a_run_too_short_for_three_fine_realizations_solves_every_level_each_time(monkeypatch):
    scene = rs.load_scene("steel-1.2GPa")
    monkeypatch.setattr(levels, "pilot", lambda *_: SEEN)
    numerics = rs.plan(replace(scene, ensemble=replace(scene.ensemble, until={}, max_realizations=2)), 0.012)
    assert {level.every for level in numerics.levels} == {1}


def test_what_is_not_extrapolated_has_the_error_of_its_pixel_alone(monkeypatch):
    scene = rs.load_scene("steel-1.2GPa")
    short = replace(scene, surface=replace(scene.surface, q_max=3e5))
    forecast = planned(monkeypatch, short, 0.02).forecast
    assert forecast.bandwidth == 0.0
    assert forecast.pixel == pytest.approx(0.6 * 0.012 * sqrt(2e5 / 3e5))


@pytest.mark.parametrize(("pixel", "per_wave", "left"), [(0.012, 4, 0.004), (0.06, 8, 0.005)])
def test_an_elastic_scene_is_left_with_a_third_of_its_pixels_change(monkeypatch, pixel, per_wave, left):
    scene = rs.load_scene("steel-1.2GPa")
    smooth = replace(scene.surface, q_max=3e5)
    soft = replace(scene, surface=smooth, body=replace(scene.body, penetration_hardness=None))
    numerics = planned(monkeypatch, soft, 0.02, replace(SEEN, pixel=pixel))
    coarse = numerics.levels[0]
    assert coarse.shape[0] * 2 * pi / (coarse.q_max * numerics.lengths[0]) == pytest.approx(per_wave, rel=0.35)
    assert numerics.forecast.pixel == pytest.approx(left)
    assert numerics.forecast.bandwidth == 0.0


def test_a_cut_scene_is_left_with_a_quarter_of_what_follows_scaled_by_the_pilots_step(monkeypatch):
    rubber = rs.load_scene("rubber")
    forecast = planned(monkeypatch, rubber, 0.02, replace(SEEN, step=0.09, q_max=1.6e4)).forecast

    def theory(q):  # T_flash at 10 m/s with the roughness up to q
        return prediction.over_speed(rubber, np.array([10.0]), rubber.spectrum.truncated(q_max=q))["flash_temperature"][
            0
        ]

    follows = (theory(1e9) - theory(6.4e4)) / (theory(1.6e4) - theory(0.8e4))
    assert forecast.bandwidth == pytest.approx(0.25 * 0.09 * follows, rel=1e-6)
    assert forecast.total > forecast.bandwidth


def test_a_rock_that_yields_at_waves_that_no_grid_holds_has_an_unknown_remainder(monkeypatch):
    numerics = planned(monkeypatch, rs.load_scene("granite"), 0.02)
    assert np.isnan(numerics.forecast.bandwidth)
    known = [numerics.forecast.statistical, numerics.forecast.pixel, numerics.forecast.size]
    assert numerics.forecast.total == pytest.approx(np.linalg.norm(known))
    assert "bandwidth unknown" in why(numerics, "error")
    assert "at q_c" in next(r.value for r in numerics.reasons if r.choice == "error")
    assert len({a.q_max for a in numerics.levels if a.column == "capped"}) == 3


def test_a_statistical_target_of_the_scene_is_taken_as_it_is():
    scene = rs.load_scene("demo")
    numerics = rs.plan(scene)
    goal = dict(scene.ensemble.until)["flash_temperature"]
    assert f"flash_temperature={100 * goal:.3g}%" in next(
        r.reason for r in numerics.reasons if r.choice == "realizations"
    )


def test_members_are_counted_by_their_stride():
    levels = (Level("elastic", (64, 64), 1e4), Level("elastic", (128, 128), 1e4, every=4))
    assert total_work(levels, 13) == pytest.approx(13 * 64**2.5 + 4 * 128**2.5 + 17 * 5e5)  # 13 of one, 4 of the other
    assert Numerics(levels, (1e-3, 1e-3)).members(13) == 17


def test_a_goal_that_is_met_at_once_still_takes_three_fine_realizations():
    assert [realizations_for(0.5, 0.01, [(0.001, every)]) for every in (1, 4, 64)] == [12, 12, 2 * 64 + 1]
    assert realizations_for(0.5, 0.01, [(0.001, 2), (0.001, 16)]) == 2 * 16 + 1


def test_few_fine_realizations_tell_with_few_degrees_of_freedom():
    # 17 coarse ones of which 3 are fine, almost all scatter in the latter: Student's t of little more than 2
    parts = np.array([0.01**2 / 17 * 14 / 12, 0.05**2 / 3])
    freedom = parts.sum() ** 2 / (parts[0] ** 2 / 14 + parts[1] ** 2 / 2)
    assert 2.0 < freedom < 2.1
    expected = stats.t.ppf(0.975, freedom) * sqrt(1 + 2 / freedom) * sqrt(parts.sum())
    assert expected_half_width(17, 0.01, [(0.05, 8)]) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("systematic", "left"),
    [(0.0, 5.0), (3.0, 4.0), (5.0 * 0.9**0.5, 5.0 * 0.1**0.5), (6.0, 2.0), (12.0, 4.0)],
)
def test_a_statistical_error_a_third_of_the_systematic_one_is_enough(systematic, left):
    assert statistical_target(5.0, systematic) == pytest.approx(left, rel=1e-12)


def test_a_target_below_the_systematic_errors_is_said_to_be_out_of_reach(monkeypatch):
    steel = rs.load_scene("steel-1.2GPa")
    steel = replace(steel, ensemble=replace(steel.ensemble, max_realizations=10**6))
    missed = planned(monkeypatch, steel, 0.001)
    forecast = missed.forecast
    systematic = np.linalg.norm([forecast.bandwidth, forecast.pixel, forecast.size])
    reason = why(missed, "error")
    assert reason.endswith("; the target of 0.1 % is out of reach: realizations lower the statistical part alone")
    assert f"flash_temperature={100 * systematic / 3:.3g}%" in why(missed, "realizations")
    assert forecast.statistical <= systematic / 3
    # with the least share for the scatter they meet a target that is so much larger
    for factor, said in ((0.999, True), (1.001, False)):
        assert ("out of reach" in why(planned(monkeypatch, steel, factor * systematic / 0.9**0.5), "error")) is said
    # a scene that names a statistical target names no total one
    stated = replace(steel, ensemble=replace(steel.ensemble, until={"flash_temperature": 0.0005}))
    assert "out of reach" not in why(rs.plan(stated), "error")


def test_the_total_of_a_plan_has_the_error_of_the_scan():
    forecast = Forecast(12, 0.02, 0.01, 0.02, 0.04, 1.0)  # 5 % in all
    for scan, total in ((None, "5 %"), (0.12, "13 %"), (np.nan, "5 % without the scan's own error")):
        assert forecast_reasons(forecast, scan, None)[0].value == total
