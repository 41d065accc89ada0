"""The ladders of a plan: where columns begin and end, on which grids, in which cell, and which levels have refined."""

from dataclasses import replace
from math import inf, pi
from types import SimpleNamespace

import numpy as np
import pytest
from soft_scene import RUBBER
from some_rows import some

import roughsim as rs
from roughsim import prediction
from roughsim.planning import levels as stage
from roughsim.planning.levels import fast_size, levels_of
from roughsim.planning.sliding import slide_level
from roughsim.scene.numerics import Numerics

WAVE = 2 * pi / 6350
CELL = (4 * WAVE, 4 * WAVE)


@pytest.fixture(autouse=True)
def cell(monkeypatch):
    """Capped contact is corrected in half the cell, or in another part that a test sets, whatever was measured."""
    part = SimpleNamespace(parts=2, smoothed=1)

    def parts_of(scene, lengths, target=inf, column="capped"):
        return part.smoothed if column == "smoothed" else part.parts

    monkeypatch.setattr(stage, "parts_of", parts_of)
    return part


def planned(scene, lengths=CELL):
    return Numerics(tuple(rung.level for rung in levels_of(scene, lengths, 0.01)), lengths)


def steel_to(q_max, q_yield=None, monkeypatch=None):
    """Steel whose C(q) ends at q_max, rad/m; with a yield wavenumber of one's own, rad/m."""
    if q_yield is not None:
        monkeypatch.setattr(prediction, "yield_wavenumber", lambda _: q_yield)
    steel = rs.load_scene("steel-1.2GPa")
    return replace(steel, surface=replace(steel.surface, q_max=q_max))


def cut_offs(numerics, column, over=1.0):
    return [numerics.levels[i].q_max / over for i in numerics.coarse_levels(column)]


def pixels(numerics, i):
    grid = numerics.grid(i)
    return 2 * pi / (numerics.levels[i].q_max * grid.spacing[0])


# where 99 % of the contact has yielded, 1/m
@pytest.mark.parametrize(
    ("name", "q_yield"), [("steel-0.5GPa", 2.5e4), ("steel-1.2GPa", 5.1e4), ("steel-2.0GPa", 7.6e4)]
)
def test_steel_is_followed_from_512_points_to_the_largest_grid_in_half_the_cell(name, q_yield):
    numerics = planned(rs.load_scene(name))
    points = [
        cut * CELL[0] * 3 / (2 * pi) for cut in cut_offs(numerics, "capped")
    ]  # of the whole cell
    assert points == pytest.approx([512, 1024, 2048, 4096, 8192])
    lowest, *higher = numerics.of_column("capped")
    assert numerics.levels[lowest].cell is None
    assert {numerics.levels[i].cell for i in higher} == {"half"}
    assert cut_offs(numerics, "smoothed", q_yield)[-1] == pytest.approx(1.5, rel=0.02)
    assert {numerics.levels[i].cell for i in numerics.of_column("smoothed")} == {None}
    # the largest grid has no room for a partner
    assert [numerics.refined(i) is not None for i in numerics.coarse_levels("capped")] == [
        k < 4 for k in range(5)
    ]
    assert all(numerics.refined(i) is not None for i in numerics.coarse_levels("smoothed"))


@pytest.mark.parametrize("name", ["demo", "steel-2.0GPa", "granite", RUBBER])
def test_levels_have_3_pixels_per_shortest_wave_and_partners_6_or_12_on_fast_grids(name):
    scene = rs.load_scene(name)
    numerics = rs.plan(scene)
    for i in numerics.single:
        below = numerics.below(i)
        of_refined = numerics.is_refined(i) and below is not None and numerics.is_refined(below)
        wanted = 12 if of_refined else 6 if numerics.is_refined(i) else 3
        assert 0.98 * wanted <= pixels(numerics, i) < 1.34 * wanted
        odd = numerics.levels[i].shape[0]
        while odd % 2 == 0:
            odd //= 2
        assert odd in (1, 3, 5)


def test_smoothed_levels_come_first_and_each_column_from_the_lowest():
    numerics = planned(rs.load_scene("steel-2.0GPa"))
    order = [i for column in ("smoothed", "capped") for i in numerics.of_column(column)]
    assert order == list(numerics.single)


@pytest.mark.parametrize("end", [5.0, 6.5, 9.0, 13.0, 20.0, 31.0])
def test_where_a_grid_holds_all_of_C_the_cut_offs_double_exactly_to_its_end(monkeypatch, end):
    q_yield = 5e4
    numerics = planned(steel_to(end * q_yield, q_yield, monkeypatch))
    rungs = cut_offs(numerics, "capped", q_yield)
    assert np.diff(np.log2(rungs)).tolist() == pytest.approx([1.0] * (len(rungs) - 1), abs=1e-12)
    assert rungs[-1] == pytest.approx(end, rel=1e-12)
    lowest = numerics.levels[numerics.coarse_levels("capped")[0]].shape[0]
    assert 384 / 2**0.5 <= lowest <= 640  # √2 · 384, on the next fast grid
    assert (
        numerics.refined(numerics.coarse_levels("capped")[-1]) is not None
    )  # the end of C(q) has one


@pytest.mark.parametrize("name", ["demo", "steel-1.2GPa", "granite"])
def test_the_lowest_grid_follows_the_target(name):
    targets = 0.003, 0.01, 0.05, 0.9
    elastic = {"body.penetration_hardness": None} if name == "granite" else {}
    plans = [rs.plan(rs.load_scene(name, elastic), target) for target in targets]
    sides = [plan.levels[plan.of_column(plan.columns[-1])[0]].shape[0] for plan in plans]
    for target, side in zip(targets, sides, strict=True):
        middle = max(384 * min(0.01 / target, 1) ** (1 / 3), 128)
        assert middle / 2**0.5 * 0.98 <= side <= middle * 2**0.5 * 4 / 3
    assert sides[1:] == sorted(sides[1:], reverse=True)


@pytest.mark.parametrize("hardness", some([None, 5e8, 2e9], 2))
@pytest.mark.parametrize("target", some([0.03, 0.9, 0.1, 0.01]))
@pytest.mark.parametrize("waves", [(64, 64), (128, 32), (2, 300)])
def test_the_lowest_level_has_waves_in_a_cell_of_very_many(waves, target, hardness):
    changes = {
        "body.penetration_hardness": hardness,
        "numerics.lengths": [n * WAVE for n in waves],
        "ensemble.until.flash_temperature": target,
    }
    numerics = rs.plan(rs.load_scene("demo", changes))
    assert min(level.q_max for level in numerics.levels) >= 2 * 6350


@pytest.mark.parametrize("band", [1.05, 1.2, 1.5, 2.0])
def test_each_refined_level_of_a_narrow_spectrum_has_more_points(band, monkeypatch, cell):
    cell.parts = 4
    narrow = {"q_max": band * 6350, "q_roll_off": None, "roll_off_exponent": None}
    demo = rs.load_scene("demo", {f"surface.{key}": value for key, value in narrow.items()})
    numerics = planned(demo)
    for column in numerics.columns:
        points = [numerics.levels[i].resolved for i in numerics.of_column(column)]
        assert points == sorted({*points})


def test_contact_that_yields_far_up_begins_on_a_cheap_grid(monkeypatch):
    # 4 q_y would have 4096 points per side: too many for a lowest level
    q_yield = 1024 * 2 * pi / (3 * CELL[0])
    numerics = planned(steel_to(1e9, q_yield, monkeypatch))
    lowest = numerics.levels[numerics.of_column("capped")[0]]
    assert lowest.shape == (512, 512)
    assert lowest.q_max == pytest.approx(0.5 * q_yield)
    assert cut_offs(numerics, "smoothed", q_yield) == pytest.approx([1.5 / 2**k for k in (2, 1, 0)])


@pytest.mark.parametrize("q_yield", [inf, 1e7])
def test_where_no_grid_reaches_q_y_both_columns_climb_the_same_cut_offs_in_the_whole_cell(
    monkeypatch, q_yield
):
    numerics = planned(steel_to(4e7, q_yield, monkeypatch))
    top = 2048 * 2 * pi / (3 * CELL[0])
    assert cut_offs(numerics, "smoothed", top) == pytest.approx([1 / 4, 1 / 2, 1.0])
    assert cut_offs(numerics, "capped", top) == pytest.approx([1 / 4, 1 / 2, 1.0])
    assert {level.cell for level in numerics.levels} == {None}


def test_elastic_contact_begins_coarse_and_ends_with_C_or_the_largest_grid(steel):
    elastic = replace(steel, body=replace(steel.body, penetration_hardness=None))
    numerics = planned(elastic)
    parts = numerics.parts("elastic")
    sides = [
        numerics.grid(i).shape[0] * numerics.levels[i].parts
        for i in numerics.coarse_levels("elastic")
    ]
    assert sides == [512 << k for k in range(len(sides))]
    assert numerics.levels[-1].shape == (4096, 4096)
    assert sides[-1] == 4096 * parts
    short = planned(replace(elastic, surface=replace(elastic.surface, q_max=3e5)))
    rungs = cut_offs(short, "elastic")
    assert rungs == pytest.approx([3e5 / 2**k for k in reversed(range(len(rungs)))])
    assert 384 / 2**0.5 <= short.levels[0].shape[0] <= 640
    assert short.refined(short.coarse_levels("elastic")[-1]) is not None


def test_a_short_spectrum_is_one_cut_off_and_its_partners(steel):
    surface = replace(steel.surface, q_roll_off=2e4, q_max=5e4)
    numerics = planned(
        replace(steel, body=replace(steel.body, penetration_hardness=None), surface=surface)
    )
    assert cut_offs(numerics, "elastic") == [5e4]
    assert len(numerics.levels) == 3


def test_each_cut_off_has_a_partner_if_there_is_room_and_the_end_of_C_two(monkeypatch):
    # 3 pixels per wave of 4e6 rad/m are 3780 points in half the cell, 6 are too many; of 2e6 rad/m they fit
    for end, with_partner in {
        4e6: [1, 1, 1, 1, 0],
        2e6: [1, 1, 1, 1],
        1e6: [1, 1, 2],
        4.15e7: [1, 1, 1, 1, 0],
    }.items():
        numerics = planned(steel_to(end, 5e4, monkeypatch))
        cuts = cut_offs(numerics, "capped")
        of_column = [numerics.levels[i].q_max for i in numerics.of_column("capped")]
        assert [of_column.count(cut) - 1 for cut in cuts] == with_partner


@pytest.mark.parametrize("parts", [1, 2, 4])
def test_grids_divide_by_the_parts_and_are_not_larger_than_the_limit(monkeypatch, cell, parts):
    cell.parts = parts
    numerics = planned(
        steel_to(4e9, 5.3e4, monkeypatch), (CELL[0], 0.7 * CELL[0])
    )  # numerics refuse what does not fit
    lowest, *higher = (numerics.levels[i] for i in numerics.of_column("capped"))
    assert lowest.parts == 1
    assert {level.parts for level in higher} == {parts}
    most = max(max(level.shape) for level in higher)
    assert 2048 < most <= 4096


@pytest.mark.parametrize("parts", [2, 4])
def test_corrections_of_smoothed_contact_lie_in_a_part_of_the_cell_that_has_256_points(cell, parts):
    cell.smoothed = parts
    numerics = planned(rs.load_scene("steel-2.0GPa"))
    lowest, *refined = (numerics.levels[i] for i in numerics.of_column("smoothed"))
    points = [lowest.shape[0] * times for times in (2, 4)]  # along a side of the whole cell
    assert lowest.cell is None
    fitting = [[n for n in (1, 2, parts) if n == 1 or side >= 256 * n] for side in points]
    assert [level.parts for level in refined] == [max(each) for each in fitting]


def test_a_part_of_the_cell_holds_finer_grids_than_all_of_it(monkeypatch, cell):
    tops = []
    for cell.parts in (1, 2, 4):
        tops.append(cut_offs(planned(steel_to(4e9, 5.1e4, monkeypatch)), "capped", 5.1e4)[-1])
    assert tops == pytest.approx([128 / 3, 256 / 3, 512 / 3], rel=0.01)


def test_reasons_name_q_y_the_end_of_C_and_the_limit_of_grids(monkeypatch):
    rungs = levels_of(rs.load_scene("steel-1.2GPa"), CELL, 0.01)
    assert "1.5 q_y" in rungs[0].reason
    assert "half the pixel" in rungs[1].reason
    assert "the largest grid of a plan, C(q) goes on to 4.15e+07 rad/m" in rungs[-1].reason
    (*_, top, partner, _) = levels_of(steel_to(4e5, 5e4, monkeypatch), CELL, 0.01)
    assert top.reason.endswith("all of C(q)")
    assert partner.level.q_max == top.level.q_max == 4e5


@pytest.mark.parametrize("points", np.geomspace(1, 5000, 60))
def test_fast_sizes_are_just_large_enough(points):
    size = fast_size(points)
    odd = size
    while odd % 2 == 0:
        odd //= 2
    assert odd in (1, 3, 5)
    assert size >= min(0.98 * points, size)
    assert size <= max(8, 1.34 * points)


def test_a_slide_has_256_points_but_4_q_y_where_contact_yields():
    rubber = rs.load_scene(RUBBER)
    level = slide_level(rubber, planned(rubber, rs.plan(rubber).lengths))
    assert (level.column, level.shape, level.first) == ("sliding", (256, 256), 8)
    assert level.q_max == pytest.approx(256 * 2 * pi / (4 * rs.plan(rubber).lengths[0]))
    steel = rs.load_scene("steel-1.2GPa")
    level = slide_level(steel, planned(steel))
    assert level.q_max == 4 * prediction.yield_wavenumber(steel)
    assert 4 * 0.98 <= 2 * pi / (level.q_max * CELL[0] / level.shape[0]) < 4 * 1.34
    high = replace(
        steel, body=replace(steel.body, penetration_hardness=4e9)
    )  # 4 q_y are beyond the lowest level
    lowest = planned(high).levels[planned(high).of_column("capped")[0]]
    level = slide_level(high, planned(high))
    assert level.shape == (512, 512)  # a slide costs the cube of its points per side
    assert level.q_max == pytest.approx(512 * 2 * pi / (4 * CELL[0]))
    assert level.q_max < lowest.q_max < 4 * prediction.yield_wavenumber(high)
    short = replace(planned(high), levels=(replace(lowest, shape=(128, 128), q_max=4e4),))
    assert slide_level(high, short).q_max == 4e4  # that of the lowest level


@pytest.mark.parametrize("sides", [(CELL[0], CELL[0] / 2), (CELL[0] / 2, CELL[0])])
def test_a_slide_has_square_pixels_in_an_oblong_cell(sides):
    rubber = rs.load_scene(RUBBER)
    assert sorted(slide_level(rubber, planned(rubber, sides)).shape) == [128, 256]


@pytest.mark.parametrize(
    ("name", "gigabytes"),
    [("steel-2.0GPa", 0.05), ("steel-2.0GPa", 2.0), ("granite", 0.2), (RUBBER, 0.2)],
)
def test_a_plan_has_the_levels_that_fit_into_memory_of_those_on_a_large_machine(
    name, gigabytes, memory
):
    scene = rs.load_scene(name)
    memory(inf)
    whole = rs.plan(scene).levels
    memory(1e9 * gigabytes)
    numerics = rs.plan(scene)
    fitting = [
        level for level in whole if 120 * level.shape[0] * level.shape[1] <= 0.8e9 * gigabytes
    ]
    assert len(fitting) < len(whole)
    assert list(numerics.levels) == fitting
    last = [reason for reason in numerics.reasons if reason.quantity == numerics.columns[-1]][-1]
    assert (
        f"more than 80 % of the {gigabytes:g} GB that are available (limit of the test)"
        in last.text
    )
    assert "levels above are left out: the next would take " in last.text
