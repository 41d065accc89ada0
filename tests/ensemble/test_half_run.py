"""Levels in half the cell: their cells, streams, numbers and files, resuming, and what pictures are made of."""

import json
from dataclasses import replace

import numpy as np
import pytest

import roughsim as rs
from roughsim import prediction
from roughsim.results.members import Members
from roughsim.scene import parse_scene
from roughsim.scene.numerics import Numerics
from roughsim.store.member_files import member_path, read_member

LENGTHS = (2e-3, 2e-3)
WHOLE = rs.Level("capped", (64, 64), 5e4)
START = rs.Level("capped", (32, 32), 5e4, every=2, cell="half")
FINE = rs.Level("capped", (64, 64), 1e5, every=2, cell="half")
LEVELS = (FINE, WHOLE, START)  # in any order


@pytest.fixture(scope="module")
def half_run(capped_scene, tmp_path_factory):
    numerics = Numerics(LEVELS, LENGTHS)
    return rs.run(capped_scene, tmp_path_factory.mktemp("half") / "run", numerics=numerics, workers=1)


def test_levels_in_half_the_cell_come_after_those_of_the_runs_cell():
    numerics = Numerics((*LEVELS, rs.Level("capped", (128, 128), 1e5, every=2, cell="half")), LENGTHS)
    assert numerics.of_column("capped") == (1, 2, 0, 3)
    assert numerics.picture("capped") == 1
    assert [numerics.grid(level).lengths for level in range(3)] == [(1e-3, 1e-3), LENGTHS, (1e-3, 1e-3)]
    # a stream for each cell, named by its finest level
    assert [numerics.stream(level) for level in range(4)] == [3, 1, 3, 3]
    assert [numerics.of_index(index) for index in (0, 1)] == [(0, 1, 2, 3), (1,)]


def test_only_levels_in_half_the_cell_have_the_key():
    numerics = Numerics(LEVELS, LENGTHS)
    levels = numerics.to_dict()["levels"]
    assert [level.get("cell") for level in levels] == ["half", None, "half"]
    assert "cell" not in levels[1]  # as in older runs
    assert Numerics.from_dict(json.loads(json.dumps(numerics.to_dict()))) == numerics


@pytest.mark.parametrize(
    ("levels", "match"),
    [
        ((START, FINE), 'levels of column capped all have cell = "half"'),
        ((WHOLE, replace(START, shape=(64, 64)), FINE), "has 64 × 64 points .* here 32 × 32 points"),
        (
            (WHOLE, replace(FINE, shape=(32, 32), q_max=4e4)),
            r"to q_max = 40000 rad/m; it must repeat .* to q_max = 50000 rad/m",
        ),
        # where the highest cut-off of the run's cell has two grids, the coarser one is repeated
        ((WHOLE, replace(WHOLE, shape=(128, 128)), replace(START, shape=(64, 64))), "here 32 × 32 points"),
        ((WHOLE, replace(START, every=1), replace(FINE, every=3), replace(FINE, every=4)), "every = 4 does not fit"),
        ((WHOLE, START, replace(FINE, every=1)), r"levels\[2\].every = 1 does not fit.* here of 2"),
    ],
)
def test_half_cells_that_do_not_begin_where_the_runs_cell_ends_are_refused(levels, match):
    with pytest.raises(ValueError, match=match):
        Numerics(levels, LENGTHS)


def test_a_cell_of_another_size_is_refused():
    with pytest.raises(ValueError, match=r'levels.cell = "third" is not known; the choice is half, quarter'):
        rs.Level("capped", 64, 5e4, cell="third")
    assert rs.Level("capped", 64, 5e4).cell is None


def test_a_quarter_of_the_cell_has_its_grid_its_own_surfaces_and_no_half_beside_it():
    levels = tuple(replace(level, shape=(16 << i, 16 << i), cell="quarter") for i, level in enumerate((START, FINE)))
    numerics = Numerics((WHOLE, *levels), LENGTHS)
    assert numerics.grid(1).lengths == (LENGTHS[0] / 4, LENGTHS[1] / 4)
    assert [numerics.stream(i) for i in range(3)] == [0, 2, 2]
    assert [numerics.parts("capped"), levels[0].parts, WHOLE.parts] == [4, 4, 1]
    assert levels[0].where == " in a quarter of the cell"
    with pytest.raises(ValueError, match='column capped have cell = "half" and "quarter"; choose one of the two'):
        Numerics((WHOLE, START, levels[1]), LENGTHS)
    odd = replace(WHOLE, shape=(66, 68))  # no quarter has its pixel along x
    with pytest.raises(
        ValueError, match=r'cell = "quarter" needs .* divide by 4; the highest capped one .* has 66 × 68'
    ):
        Numerics((odd, replace(levels[0], shape=(16, 17)), levels[1]), LENGTHS)
    with pytest.raises(ValueError, match=r'cell = "quarter" has 32 × 32 points .* here 16 × 16 points'):
        Numerics((WHOLE, replace(levels[0], shape=(32, 32)), levels[1]), LENGTHS)


def test_a_quarter_for_one_column_and_half_for_another_have_surfaces_of_their_own():
    quarter = tuple(replace(level, shape=(16 << i, 16 << i), cell="quarter") for i, level in enumerate((START, FINE)))
    smoothed = tuple(replace(level, column="smoothed", q_max=level.q_max / 2) for level in (WHOLE, START, FINE))
    numerics = Numerics((WHOLE, *quarter, *smoothed), LENGTHS)
    assert [numerics.stream(i) for i in range(6)] == [0, 2, 2, 0, 5, 5]
    assert [numerics.parts(column) for column in numerics.columns] == [2, 4]
    assert [numerics.picture(column) for column in numerics.columns] == [3, 0]
    assert [numerics.grid(i).lengths[0] for i in range(6)] == [2e-3, 5e-4, 5e-4, 2e-3, 1e-3, 1e-3]


def test_a_scene_may_state_them_and_writes_them_back(capped_scene):
    levels = tuple({"column": a.column, "shape": a.shape, "q_max": a.q_max, "every": a.every} for a in LEVELS)
    levels = tuple(a | ({"cell": "half"} if i != 1 else {}) for i, a in enumerate(levels))
    scene = replace(capped_scene, numerics=replace(capped_scene.numerics, levels=levels))
    assert parse_scene(scene.to_toml()) == scene
    assert scene.to_toml().count('cell = "half"') == 2
    assert ["cell" in level for level in scene.identity()["numerics.levels"]] == [True, False, True]
    assert rs.plan(scene).levels == LEVELS


def test_the_surfaces_of_half_the_cell_are_its_own_and_the_same_on_all_its_grids(capped_scene):
    numerics = Numerics(LEVELS, LENGTHS)
    heights = [rs.realize(capped_scene, numerics, seed=3, level=level, index=4).heights for level in range(3)]
    # the finest level of each cell names the stream
    for level, stream in ((0, 0), (2, 0), (1, 1)):
        generator = np.random.default_rng(np.random.SeedSequence(3, spawn_key=(stream, 4)))
        spectrum = capped_scene.spectrum.truncated(q_max=LEVELS[level].q_max)
        side = 1e-3 if stream == 0 else 2e-3
        grid = rs.Grid(LEVELS[level].shape, (side, side))
        np.testing.assert_array_equal(heights[level], rs.synthesize(spectrum, grid, generator))
    low = (slice(0, 4), slice(0, 4))
    fine, start = (np.fft.fft2(heights[level])[low] / heights[level].size for level in (0, 2))
    np.testing.assert_allclose(fine[1:], start[1:], rtol=1e-9)


def test_members_are_numbered_by_realization_and_state_their_cell(half_run):
    assert half_run.realizations == 6
    assert set(half_run.members) == {(1, i) for i in range(6)} | {(level, i) for level in (0, 2) for i in (0, 2, 4)}
    for level, side in ((0, 1e-3), (1, 2e-3), (2, 1e-3)):
        assert read_member(member_path(half_run.folder, level, 0)).lengths == (side, side)
        assert half_run.members[level, 0].lengths == (side, side)


def test_the_mean_is_that_of_the_runs_cell_times_the_ratio_in_half_of_it(half_run):
    def numbers(level, index):
        return read_member(member_path(half_run.folder, level, index)).numbers["contact_fraction"][0]

    fine, start = (sum(numbers(level, index) for index in (0, 2, 4)) for level in (0, 2))
    expected = np.mean([numbers(1, index) for index in range(6)]) * fine / start
    values = half_run.values("contact_fraction", extrapolated=False)
    assert values.finest.mean() == pytest.approx(expected, rel=1e-12)
    # 8 waves of the roll-off per side have 0.4 %; the run's cell has 6.4, half of it 3.2
    whole = 0.004 * (8 / (2e-3 * 2e4 / (2 * np.pi))) ** 2
    told = half_run.estimate("contact_fraction")
    share = half_run.values("contact_fraction").from_part[0]
    # of what half of it adds: as much, or 0.016 over its number of spots, (q_y L/2)² σ₀/σ_P over 4π²
    scene = half_run.scene
    spots = (1e-3 * prediction.yield_wavenumber(scene) / (2 * np.pi)) ** 2
    spots *= scene.sliding.nominal_pressure / scene.penetration_hardness
    added = max(whole, 0.016 / spots)
    assert told.budget["size"][0] == pytest.approx(told.mean[0] * np.hypot(whole, added * share), rel=1e-9)
    assert share > 0.01


def test_a_resumed_run_has_the_same_bits(half_run, capped_scene, tmp_path):
    numerics = Numerics(LEVELS, LENGTHS)
    few = rs.run(capped_scene, tmp_path / "run", numerics=numerics, max_realizations=3, workers=1)
    assert set(few.members) == {(1, 0), (1, 1), (1, 2), (0, 0), (2, 0), (0, 2), (2, 2)}
    member_path(few.folder, 0, 2).unlink()
    again = rs.run(capped_scene, tmp_path / "run", numerics=numerics, max_realizations=6, workers=1)
    assert set(again.members) == set(half_run.members)
    for key in half_run.members:
        one, other = (read_member(member_path(run.folder, *key)).numbers for run in (half_run, again))
        for name in one:
            np.testing.assert_array_equal(one[name], other[name])


def test_a_damaged_member_in_half_the_cell_is_computed_again(half_run, capped_scene, tmp_path):
    numerics = Numerics(LEVELS, LENGTHS)
    run = rs.run(capped_scene, tmp_path / "run", numerics=numerics, max_realizations=3, workers=1)
    path = member_path(run.folder, 0, 2)
    content = path.read_bytes()
    path.write_bytes(content[:-200] + bytes(200))
    with pytest.warns(RuntimeWarning, match="L0-000002"):
        run = rs.run(capped_scene, tmp_path / "run", numerics=numerics, max_realizations=3, workers=1)
    assert path.read_bytes()[:8] == content[:8]
    again, first = (read_member(member_path(one.folder, 0, 2)).numbers for one in (run, half_run))
    np.testing.assert_array_equal(again["flash_temperature"], first["flash_temperature"])


def test_pictures_are_of_the_runs_cell(half_run):
    (index, pressure), *_ = half_run.fields("pressure")
    stored = read_member(member_path(half_run.folder, 1, 0), with_fields=True).fields["pressure"]
    assert index == 0
    np.testing.assert_array_equal(pressure, stored)
    np.testing.assert_array_equal(half_run.field(0, 0, "pressure").shape, (64, 64))  # those of others by their level


def test_the_correlation_has_the_changes_of_half_the_cell(half_run):
    def variances(level, members):
        read = [read_member(member_path(half_run.folder, level, i)) for i in members]
        return np.array([member.numbers["pressure_variance"][0] for member in read])

    g, error = half_run.correlation(np.array([0.0, 1.4e-3]))  # as far as half the diagonal of the run's cell
    change = variances(0, (0, 2, 4)) - variances(2, (0, 2, 4))
    assert g[0] == pytest.approx(variances(1, range(6)).mean() + change.mean(), rel=1e-9)
    expected = variances(1, range(6)).var(ddof=1) / 6 + change.var(ddof=1) / 3
    assert error[0] == pytest.approx(expected**0.5, rel=1e-9)


@pytest.mark.slow
def test_a_comparison_has_the_modes_of_the_runs_cell_up_to_the_highest_cut_off(capped_scene, tmp_path):
    # 128 points in the run's cell hold q_max, 64 would not
    fine = replace(FINE, q_max=1.5e5)
    theories = []
    for name, levels in (("half", (WHOLE, START, fine)), ("whole", (WHOLE, rs.Level("capped", (128, 128), 1.5e5)))):
        numerics = Numerics(levels, LENGTHS)
        run = rs.run(capped_scene, tmp_path / name, numerics=numerics, max_realizations=3, workers=1)
        theories.append([row.theory_same_modes for row in rs.compare(run).rows])
    np.testing.assert_array_equal(*theories)


def test_a_summary_knows_the_cell_of_each_level(half_run):
    members = Members([2, 1, 2], [(1e-3, 1e-3), LENGTHS, (1e-3, 1e-3)], half_run.scene.speeds)
    members.put((0, 2), half_run.members[0, 2])
    assert members[0, 2].lengths == (1e-3, 1e-3)
