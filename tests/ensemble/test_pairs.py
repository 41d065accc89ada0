"""Members of higher levels: one surface, solved at the level and at the level below, in one file."""

from dataclasses import replace

import numpy as np
import pytest
from stored_cases import member_path, read_member, split_members

import roughsim as rs
from roughsim import pipeline
from roughsim.ensemble import workers
from roughsim.ensemble.tasks import job_of
from roughsim.planning.realization import below_problem, level_problem
from roughsim.scene.numerics import Numerics

LENGTHS = (2e-3, 2e-3)
# in any order: a step in half the cell, the lowest level, and its partner
LEVELS = (
    rs.Level("capped", (64, 64), 1e5, "half"),
    rs.Level("capped", (64, 64), 5e4),
    rs.Level("capped", (96, 96), 5e4),
)
STEP, LOWEST, PARTNER = range(3)
COUNT = 6


@pytest.fixture(scope="module")
def numerics():
    return Numerics(LEVELS, LENGTHS)


@pytest.fixture(scope="module")
def run(capped_scene, numerics, tmp_path_factory):
    return rs.run(capped_scene, tmp_path_factory.mktemp("pairs") / "run", numerics=numerics)


def stored(run, level, index):
    return read_member(run.folder, level, index)


@pytest.mark.parametrize(
    ("level", "shape", "side", "q_max"),
    [(STEP, (32, 32), 1e-3, 5e4), (PARTNER, (64, 64), 2e-3, 5e4)],
)
def test_the_level_below_is_solved_on_the_same_surface_without_the_waves_beyond_its_cut_off(
    capped_scene, run, level, shape, side, q_max
):
    stream = np.random.default_rng(np.random.SeedSequence(3, spawn_key=(level, 4)))
    grid = rs.Grid(shape, (side, side))
    heights = rs.synthesize(capped_scene.spectrum.truncated(q_max=q_max), grid, stream)
    solid = rs.Solid(capped_scene.effective_modulus, capped_scene.penetration_hardness)
    contact = rs.solve_contact(heights, grid, solid, nominal_pressure=9e7, tolerance=3e-3)
    member = stored(run, level, 4)
    assert member.moments[1].numbers["contact_fraction"][0] == contact.contact_fraction
    fine = rs.realize(capped_scene, run.numerics, seed=3, level=level, index=4)
    np.testing.assert_array_equal(
        member.numbers["flash_temperature"], fine.observables.flash_temperature
    )
    # all waves of the coarse surface are in the fine one
    low = (slice(0, 4), slice(0, 4))
    modes = [np.fft.fft2(one)[low] / one.size for one in (heights, fine.heights)]
    np.testing.assert_allclose(modes[1][1:], modes[0][1:], rtol=1e-9, atol=1e-18)


@pytest.mark.parametrize("level", [STEP, PARTNER])
def test_a_level_begins_from_the_contact_below_it_and_meets_its_tolerance(
    capped_scene, numerics, run, level
):
    problem = replace(level_problem(capped_scene, numerics, level), seed=3, index=4)
    below = replace(below_problem(capped_scene, numerics, level), seed=3, index=4)
    solution = pipeline.solve_problem(problem, start=pipeline.solve_problem(below).contact)
    alone = pipeline.solve_problem(problem)
    assert not np.array_equal(solution.contact.pressure, alone.contact.pressure)
    exact = pipeline.solve_problem(replace(problem, tolerance=1e-8)).contact.pressure
    for one in (solution, alone):
        assert np.linalg.norm(one.contact.pressure - exact) < 3e-3 * np.linalg.norm(exact)
    member = stored(run, level, 4)
    np.testing.assert_array_equal(
        member.numbers["flash_temperature"], solution.observables.flash_temperature
    )
    assert member.provenance["iterations"] == solution.contact.iterations


def test_only_the_lowest_level_has_peak_volumes_and_nothing_below(run):
    lowest, step = stored(run, LOWEST, 0), stored(run, STEP, 0)
    assert len(lowest.moments) == 1
    assert lowest.numbers["peak_volume"][0] != 0.0
    assert step.numbers["peak_volume"][0] == step.moments[1].numbers["peak_volume"][0] == 0.0


def test_the_mean_is_that_of_the_lowest_level_times_ratios_of_each_step(run):
    def total(level, below=False):
        members = (stored(run, level, i) for i in range(COUNT))
        return sum(one.moments[below].numbers["contact_fraction"][0] for one in members)

    assert run.counts == (COUNT,) * 3
    at_cut_off = total(LOWEST) / COUNT * total(STEP) / total(STEP, below=True)
    found = run.values("contact_fraction", extrapolated=False)
    assert found.influence[LOWEST].shape == (COUNT, 1)
    by_hand = run.values("contact_fraction").value / at_cut_off - 1.0
    partner = (
        total(PARTNER) / total(PARTNER, below=True) - 1.0
    )  # finer points take away contact, here too
    assert np.sign(by_hand) == np.sign(partner)


def test_a_failed_solve_of_either_level_is_the_failure_of_the_member(
    capped_scene, numerics, tmp_path, failing
):
    failing(lambda problem: problem.grid.shape == (32, 32) and problem.index == 1)
    run = rs.run(capped_scene, tmp_path / "run", numerics=numerics, max_realizations=3)
    member = stored(run, STEP, 1)
    assert "stalled" in member.failure
    assert not member.moments
    assert run.failed == 1
    assert [len(sample.rows) for sample in run.samples()] == [3, 3, 2]


def test_runs_that_are_computed_together_share_surfaces_and_contacts_of_both_levels(
    capped_scene, numerics, tmp_path, calls
):
    # with another friction the contact is the same; with another load the surface
    scenes = [
        capped_scene,
        capped_scene.with_("sliding.friction_coefficient", 0.3),
        capped_scene.with_("sliding.nominal_pressure", 4e7),
    ]
    runs = [
        rs.run(one, tmp_path / str(k), numerics=numerics, max_realizations=1)
        for k, one in enumerate(scenes)
    ]
    jobs = [job_of(run, STEP) for run in runs]
    before = [stored(run, STEP, 0) for run in runs]
    drawn, solved = calls(pipeline, "synthesize"), calls(pipeline, "loaded")
    found = workers.computed_members(dict(enumerate(jobs)), [(0, [0, 1, 2])])
    assert (len(drawn), len(solved)) == (2, 4)  # two levels; two levels and two loads
    for (_, again), one in zip(found, before, strict=True):
        for mine, theirs in zip(again.moments, one.moments, strict=True):
            for name, values in theirs.numbers.items():
                np.testing.assert_array_equal(mine.numbers[name], values)
            np.testing.assert_array_equal(mine.spectrum, theirs.spectrum)


@pytest.mark.slow
def test_a_run_that_was_broken_off_and_damaged_ends_with_the_same_bits(
    capped_scene, numerics, run, tmp_path
):
    rs.run(capped_scene, tmp_path / "run", numerics=numerics, max_realizations=3)
    split_members(tmp_path / "run")
    member_path(tmp_path / "run", STEP, 2).unlink()
    path = member_path(tmp_path / "run", PARTNER, 1)
    path.write_bytes(path.read_bytes()[:-200] + bytes(200))
    with pytest.warns(RuntimeWarning, match="L2-000001"):
        again = rs.run(capped_scene, tmp_path / "run", numerics=numerics)
    assert set(again.members) == set(run.members)
    for key in run.members:
        mine, theirs = stored(again, *key), stored(run, *key)
        for one, other in zip(mine.moments, theirs.moments, strict=True):
            for name, values in other.numbers.items():
                np.testing.assert_array_equal(one.numbers[name], values)


def test_pictures_are_of_the_runs_cell(run):
    (index, pressure), *_ = run.fields("pressure")
    kept = read_member(run.folder, PARTNER, 0).fields["pressure"]
    assert index == 0
    np.testing.assert_array_equal(pressure, kept)
    assert run.field(STEP, 0, "pressure").shape == (64, 64)  # those of others by their level


def test_the_problem_below_differs_in_cut_off_and_grid_alone(capped_scene, numerics):
    problem, below = (
        level_problem(capped_scene, numerics, STEP),
        below_problem(capped_scene, numerics, STEP),
    )
    assert replace(below, spectrum=problem.spectrum, grid=problem.grid) == problem
    assert below_problem(capped_scene, numerics, LOWEST) is None
    assert (problem.stream, below.stream, level_problem(capped_scene, numerics, LOWEST).stream) == (
        STEP,
        STEP,
        LOWEST,
    )
