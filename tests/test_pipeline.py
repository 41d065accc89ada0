"""One member from numbers alone: what a worker of an ensemble computes."""

import pickle
from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import roughsim as rs
from roughsim import pipeline
from roughsim.pipeline import solve_problem
from roughsim.planning.realization import level_problem, scene_of


@pytest.fixture(scope="module")
def capped_numerics(capped_scene):
    return rs.plan(capped_scene)


@pytest.mark.parametrize("level", [0, 1])
def test_a_problem_that_was_sent_to_a_worker_gives_the_bits_of_realize(
    capped_scene, capped_numerics, level
):
    problem = replace(level_problem(capped_scene, capped_numerics, level), seed=5, index=3)
    sent = pickle.loads(pickle.dumps(problem))
    assert sent == problem
    solution = solve_problem(sent)
    member = rs.realize(capped_scene, capped_numerics, seed=5, level=level, index=3)
    assert member.grid == solution.grid
    np.testing.assert_array_equal(solution.heights, member.heights)
    np.testing.assert_array_equal(solution.contact.pressure, member.contact.pressure)
    np.testing.assert_array_equal(
        solution.observables.flash_temperature, member.observables.flash_temperature
    )
    assert tuple(solution.seconds) == ("surface", "contact", "observables")


def test_each_stage_gets_what_the_problem_says(capped_scene, capped_numerics, monkeypatch):
    problem = replace(
        level_problem(capped_scene, capped_numerics, 0),
        seed=5,
        index=3,
        tolerance=1e-3,
        precision="single",
        threads=3,
    )
    used = []

    def loaded(kind, name):
        used.append((kind, name))
        return rs.solve_contact

    pools = SimpleNamespace(limit=lambda limits: used.append(limits) or nullcontext())
    monkeypatch.setattr(pipeline, "loaded", loaded)
    monkeypatch.setattr(pipeline, "linear_algebra", lambda: pools)
    solution = solve_problem(replace(problem, solver="another"))
    assert used == [3, ("solvers", "another")]
    # the same by hand, with the stream that the docstring of the problem promises
    stream = np.random.default_rng(np.random.SeedSequence(5, spawn_key=(problem.stream, 3)))
    heights = rs.synthesize(problem.spectrum, problem.grid, stream)
    asked = {"nominal_pressure": problem.nominal_pressure, "tolerance": 1e-3, "precision": "single"}
    contact = rs.solve_contact(heights, problem.grid, problem.solid, **asked)
    np.testing.assert_array_equal(solution.heights, heights)
    np.testing.assert_array_equal(solution.contact.pressure, contact.pressure)
    assert (solution.contact.residual, solution.contact.pressure.dtype) == (
        contact.residual,
        np.float32,
    )
    assert all(0.0 < seconds < 60.0 for seconds in solution.seconds.values())


@pytest.mark.parametrize("name", ["active_set", "another"])
def test_only_our_own_solver_begins_from_another_contact(
    capped_scene, capped_numerics, monkeypatch, name
):
    problem = level_problem(capped_scene, capped_numerics, 0)
    start = solve_problem(problem).contact
    given = {}

    def solver(heights, grid, solid, **arguments):
        given.update(arguments)
        return rs.solve_contact(heights, grid, solid, **arguments)

    monkeypatch.setattr(pipeline, "loaded", lambda kind, name: solver)
    solve_problem(replace(problem, solver=name), start=start)
    assert {*given} - {"nominal_pressure", "tolerance", "precision"} == (
        {"start"} if name == "active_set" else set()
    )
    assert given.get("start", start) is start


def test_the_lowest_levels_share_one_random_stream_and_others_have_their_own(
    capped_scene, capped_numerics
):
    problems = [
        level_problem(capped_scene, capped_numerics, level)
        for level in range(len(capped_numerics.levels))
    ]
    assert [problem.stream for problem in problems] == [0, 0, 2]
    assert {problem.seed for problem in problems} == {capped_scene.ensemble.seed}


def test_peak_volumes_are_those_of_the_lowest_levels(capped_scene, capped_numerics):
    problems = [level_problem(capped_scene, capped_numerics, level) for level in range(3)]
    assert [problem.with_peaks for problem in problems] == [True, True, False]
    assert all(solve_problem(one).peak_volume != 0.0 for one in problems[:2])
    assert solve_problem(problems[2]).peak_volume == 0.0
    heights = solve_problem(problems[0]).heights
    assert (
        solve_problem(problems[0], heights=heights).peak_volume == 0.0
    )  # of surfaces that are not drawn


def test_only_capped_contact_has_a_hardness(capped_scene, capped_numerics):
    for level, asked in enumerate(capped_numerics.levels):
        hardness = level_problem(capped_scene, capped_numerics, level).solid.penetration_hardness
        assert hardness == (
            capped_scene.penetration_hardness if asked.column == "capped" else np.inf
        )


@pytest.mark.parametrize("wrong", [{"seed": -1}, {"level": 99}, {"index": 1.0}, {"seed": True}])
def test_a_member_that_does_not_exist_is_refused(capped_scene, capped_numerics, wrong):
    (name,) = wrong
    with pytest.raises(ValueError, match=f"{name} = .* must be a whole number from 0 to below"):
        rs.realize(capped_scene, capped_numerics, **{"seed": 1} | wrong)


def test_levels_of_a_column_that_the_scene_lacks_are_refused_before_any_work(
    full_scene, capped_numerics, tmp_path
):
    message = r"^numerics.levels\[0\].column = \"smoothed\" needs a body.penetration_hardness"
    with pytest.raises(ValueError, match=message):
        rs.realize(full_scene, capped_numerics, seed=1)
    with pytest.raises(ValueError, match=message):
        rs.run(full_scene, tmp_path / "run", numerics=capped_numerics)
    assert not (tmp_path / "run").exists()


def test_a_slide_needs_a_history(capped_scene, capped_numerics, tmp_path):
    slide = replace(capped_numerics.levels[0], column="sliding")
    slid = replace(capped_numerics, levels=(*capped_numerics.levels, slide))
    with pytest.raises(ValueError, match=r'column = "sliding" needs sliding.history = "sliding"'):
        rs.run(capped_scene, tmp_path / "run", numerics=slid)
    assert not (tmp_path / "run").exists()


def test_a_hardness_that_is_never_reached_stays_where_a_column_needs_it(
    capped_scene, capped_numerics
):
    free = replace(capped_scene.numerics, levels=None)
    hard = replace(
        capped_scene, body=replace(capped_scene.body, penetration_hardness=1e12), numerics=free
    )
    for column, elastic in {"smoothed": False, "capped": False, "elastic": True}.items():
        numerics = replace(
            capped_numerics, levels=(replace(capped_numerics.levels[0], column=column),)
        )
        assert scene_of(hard, numerics).elastic is elastic


def test_what_two_problems_have_in_common_is_taken_over_with_the_same_bits(
    capped_scene, capped_numerics, calls
):
    problem = level_problem(capped_scene, capped_numerics, 0)
    drawn = calls(pipeline, "synthesize")
    others = {
        "surface and contact": replace(
            problem, sliding=replace(problem.sliding, friction_coefficient=0.3)
        ),
        "surface": replace(problem, nominal_pressure=1.5 * problem.nominal_pressure),
        "nothing": replace(problem, index=problem.index + 1),
    }
    before = problem, solve_problem(problem)
    for shared, other in others.items():
        drawn.clear()
        solution = solve_problem(other, before)
        assert len(drawn) == (shared == "nothing")
        assert (solution.contact is before[1].contact) == (shared == "surface and contact")
        alone = solve_problem(other)
        assert np.array_equal(solution.contact.pressure, alone.contact.pressure)
        assert np.array_equal(
            solution.observables.flash_temperature, alone.observables.flash_temperature
        )
        assert not np.array_equal(
            alone.observables.flash_temperature, before[1].observables.flash_temperature
        )
