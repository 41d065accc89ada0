"""The ladder of capped contact: where it ends, and what the law for contact that yields leaves in doubt."""

from dataclasses import replace
from math import hypot, inf, pi

import numpy as np
import pytest

import roughsim as rs
from roughsim import prediction
from roughsim.planning import levels as stage
from roughsim.planning.pilot import Pilot

Q_YIELD = 5e4
SEEN = Pilot(
    raw_scatter=0.03, scatter=0.03, hot_scatter=0.02, step=0.2, pixel=0.02, change_scatter=0.004, q_max=2e5, pace=2e-8
)


def ladder(monkeypatch, *, end=800.0, limit=64.0, law=inf, target=0.01, seen=SEEN, parts=1):
    """The lowest ladder that serves steel which yields at Q_YIELD; the end of C(q) and the limit of grids over it."""
    return ladders(monkeypatch, end=end, limit=limit, law=law, target=target, seen=seen, parts=parts)[0]


def ladders(monkeypatch, *, end=800.0, limit=64.0, law=inf, target=0.01, seen=SEEN, parts=1, lowest=False):
    """All that serve."""
    monkeypatch.setattr(stage, "yield_scale", lambda _: (Q_YIELD, "q_y"))
    monkeypatch.setattr(stage, "law_error", law if callable(law) else lambda *_: law)
    monkeypatch.setattr(stage, "parts_of", lambda *_: parts)
    steel = rs.load_scene("steel-1.2GPa")
    scene = replace(steel, surface=replace(steel.surface, q_max=end * Q_YIELD))
    side = 4096 * 2 * pi / (4 * limit * Q_YIELD)  # four pixels per wave at the limit
    return stage.capped_ladders(scene, (side, side), target, seen, lowest=lowest)


def capped(found):
    """Cut-offs of capped contact over q_y."""
    return [rung.level.q_max / Q_YIELD for rung in found.rungs if rung.level.column == "capped"]


@pytest.mark.parametrize(("end", "whole"), [(7.0, True), (9.9, True), (10.1, False)])
def test_what_ends_little_above_a_top_is_solved_whole(monkeypatch, end, whole):
    found = ladder(monkeypatch, end=end, law=1e-4, target=0.2)
    assert capped(found) == pytest.approx([end, end] if whole else [2.0, 2.0, 4.0, 4.0, 8.0])
    assert (found.bandwidth == 0.0) is whole


@pytest.mark.parametrize(("limit", "end", "top"), [(9.0, 9.5, 8.0), (7.0, 8.0, 7.0), (12.0, 800.0, 12.0)])
def test_no_grid_is_larger_than_the_limit(monkeypatch, limit, end, top):
    found = ladder(monkeypatch, limit=limit, end=end, target=0.2 if limit < 10.0 else 1e-4)
    assert capped(found)[-1] == pytest.approx(top)
    assert len(capped(found)) == 5
    assert (f"the limit of {stage.CAPPED_SIDE} points" in found.rungs[-1].reason) is (limit == top)


def test_a_part_of_the_cell_holds_finer_grids_than_all_of_it(monkeypatch):
    # up to 6144 points per side in a half or a quarter, 4096 in the run's cell
    for parts, limit in ((2, 27.0), (4, 54.0)):
        tops = ladders(monkeypatch, limit=9.0, target=1e-4, parts=parts)
        assert capped(tops[-1])[-1] == pytest.approx(limit)
        assert tops[-1].only_part
        assert "the limit of 6144 points" in tops[-1].rungs[-1].reason
        assert tops[-1].rungs[-1].level.shape[0] // parts == 6144
        finest = tops[-1].levels(1, 4, in_part=True)[-1]
        assert (finest.shape, finest.cell) == ((6144, 6144), "half" if parts == 2 else "quarter")
    low = ladders(monkeypatch, limit=9.0, law=1e-4, target=0.2, parts=2)
    assert [found.only_part for found in low] == [False, True, True]


@pytest.mark.parametrize(
    ("limit", "rungs"),
    [
        (32.0, [4, 8, 16, 32]),
        (32.0 * 0.985, [3.94, 7.88, 15.76, 31.52]),  # little less
        (32.0 * 0.975, [7.8, 15.6, 31.2]),
        (60.0, [7.5, 15, 30, 60]),
        (800.0, [4, 8, 16, 32, 64, 128]),
    ],
)
def test_high_ladders_begin_between_4_and_8_q_y(monkeypatch, limit, rungs):
    found = ladder(monkeypatch, limit=limit, target=1e-5, end=1e4)
    assert sorted({round(depth, 6) for depth in capped(found)}) == pytest.approx(rungs)
    scatters = [rung.scatter for rung in found.rungs if rung.level.column == "capped" and rung.scatter]
    assert scatters == pytest.approx([0.45**k for k in range(len(rungs) - 1)])
    # the lowest two also at half the pixel
    sides = [rung.level.shape[0] for rung in found.rungs if rung.level.column == "capped"]
    assert len(sides) == len(rungs) + 2


def test_all_that_follows_a_ladder_below_8_q_y_is_in_doubt(monkeypatch):
    found = ladder(monkeypatch, limit=7.0, target=1e-4)
    assert found.bandwidth == pytest.approx(0.2 * 4.0 / 7.0)  # the step of the pilot, up to 4 q_y, by the power 1


def test_higher_ladders_serve_too(monkeypatch):
    tops = [capped(found)[-1] for found in ladders(monkeypatch, law=1e-3, target=0.1)]
    assert tops == pytest.approx([8.0, 16.0, 32.0, 64.0])
    assert [capped(found)[-1] for found in ladders(monkeypatch, law=1e-3, target=1e-4)] == pytest.approx([64.0])


def test_of_the_lowest_ladder_that_serves_nothing_higher_is_computed(monkeypatch):
    computed, whole = [], stage.capped_ladder
    monkeypatch.setattr(stage, "capped_ladder", lambda *given: (computed.append(given[-2]), whole(*given))[1])
    for target, factors in ((0.1, [8]), (0.006, [8, 16]), (1e-4, [8, 16, 32, 64])):  # of the last none serves
        (found,) = ladders(monkeypatch, law=1e-3, target=target, lowest=True)
        assert computed == factors
        assert found == ladders(monkeypatch, law=1e-3, target=target)[0]
        computed.clear()


@pytest.mark.parametrize(("part", "top"), [(0.84, 8.0), (0.86, 16.0)])
def test_bandwidth_and_pixel_take_no_more_than_0_85_of_the_target(monkeypatch, part, top):
    equal = part / 2**0.5 * 0.01  # of both, at 8 q_y
    seen = replace(SEEN, pixel=equal * 8 * Q_YIELD / SEEN.q_max)
    found = ladder(monkeypatch, law=equal, seen=seen)
    assert capped(found)[-1] == pytest.approx(top)
    assert (found.bandwidth, found.pixel) == pytest.approx((equal, equal * 8.0 / top), rel=1e-12)


def test_the_law_is_expected_but_outside_its_range_and_of_a_guess_the_power(monkeypatch):
    # at 8 q_y all of the remainder by the power 1, 0.2 × 2e5/4e5, is in doubt
    for law, expected in ((0.05, 0.05), (0.3, 0.3), (inf, 0.1)):
        assert ladder(monkeypatch, law=law, target=0.5).bandwidth == pytest.approx(expected)
    guess = replace(SEEN, measured=False)
    assert ladder(monkeypatch, law=0.05, target=0.5, seen=guess).bandwidth == pytest.approx(0.1)


def test_measured_over_law_still_changes_more_up_to_8_q_y(monkeypatch):
    asked = []
    found = ladders(monkeypatch, law=lambda _, top, change: asked.append((top / Q_YIELD, change)) or 1e-3, target=0.1)
    assert asked == [(8.0, 0.15), (16.0, 0.1), (32.0, 0.1), (64.0, 0.1)]
    assert len(found) == 4


def test_what_the_law_leaves_in_doubt_is_that_of_the_highest_temperature(monkeypatch):
    asked, said = [], [np.array([[9.0, 110.0], [8.0, 80.0], [7.0, 78.0]]), np.zeros((3, 2)), None]
    monkeypatch.setattr(
        prediction, "yielded_fall", lambda _, cut_offs: (asked.append(cut_offs), said[len(asked) - 1])[1]
    )
    scene = rs.load_scene("steel-1.2GPa")
    found = [stage.law_error(scene, 4e5, 0.1) for _ in said]
    assert found == [pytest.approx(hypot(0.15 * 2.0 / 80.0, 0.07 * 2.0 / 80.0, 0.1 * 2.0 / 80.0), rel=1e-12), inf, inf]
    assert asked[0] == (2e5, 4e5)
