"""A study: ordinary runs for a grid of values, with shared surfaces, resumed and grown."""

import shutil
import threading
from dataclasses import replace

import h5py
import numpy as np
import pytest
from stored_cases import member_path, read_member, split_members
from study_cases import LOADS, VARY, description_of

import roughsim as rs
from roughsim import pipeline
from roughsim.store.claims import PLAN, Claims
from roughsim.studies import work
from roughsim.studies.folder import write


def test_every_point_is_an_ordinary_run_with_the_bits_of_its_scene_alone(done, small, tmp_path):
    assert (done.finished, len(done.points)) == (6, 6)
    for point in (done.points[0], done.points[-1]):
        run = rs.open_run(done.folder / "points" / point.name)
        scene = small.with_("sliding.nominal_pressure", point.values["sliding.nominal_pressure"])
        scene = scene.with_(
            "sliding.friction_coefficient", point.values["sliding.friction_coefficient"]
        )
        alone = rs.run(scene, tmp_path / point.name, numerics=run.numerics)
        assert alone.scene.identity() == run.scene.identity()
        assert np.array_equal(
            alone.estimate("flash_temperature").mean, run.estimate("flash_temperature").mean
        )


def test_surfaces_are_drawn_and_contacts_solved_once_for_all_points_that_share_them(
    small, tmp_path, calls
):
    drawn, solved = calls(pipeline, "synthesize"), calls(pipeline, "loaded")
    study = rs.study(small, vary=VARY, folder=tmp_path / "study")
    members = [len(run.members) for _, run in study.results]
    assert set(members) == {
        18
    }  # 12 of the lower level, and 6 of the higher one, which are solved at both
    assert len(drawn) == 24
    assert len(solved) == 24 * len(LOADS)  # points with another friction share them


@pytest.mark.slow
def test_a_study_over_skin_heat_depth_and_load_solves_the_contact_of_each_load_once(
    small, tmp_path, calls
):
    drawn, solved = calls(pipeline, "synthesize"), calls(pipeline, "loaded")
    vary = {
        "body.skin.thickness, body.heat_depth": [["0.1 um", "1 um"], ["10 um", "0 m"]],
        "body.skin.conductivity": ["3 W/(m K)"],
        "sliding.nominal_pressure": ["100 MPa", "300 MPa"],
    }  # the last one varies fastest
    study = rs.study(small, vary=vary, folder=tmp_path / "study")
    members = [len(run.members) for _, run in study.results]
    assert (len(members), set(members)) == (4, {18})
    assert (len(drawn), len(solved)) == (
        24,
        2 * 24,
    )  # as in the test above: 18 members, of which 6 have two levels


@pytest.mark.slow
def test_points_with_junction_growth_share_the_contacts_of_an_equal_friction(
    small, tmp_path, calls
):
    solved = calls(pipeline, "loaded")
    vary = {
        "body.conductivity": [20, 30],
        "sliding.friction_coefficient": [0.1, 0.3],
    }  # friction varies fastest
    rs.study(small.with_("sliding.junction_growth", 9), vary=vary, folder=tmp_path / "study")
    assert len(solved) == 2 * 24


def test_a_resumed_study_computes_only_what_is_missing_and_may_grow(small, done, tmp_path, calls):
    folder = tmp_path / "copy"
    shutil.copytree(done.folder, folder)
    (point,) = folder.glob("points/nominal_pressure=300000000,*0.2")
    content = read_member(point, 1, 3)
    member_path(split_members(point), 1, 3).unlink()
    solved = calls(pipeline, "loaded")
    rs.study(small, vary=VARY, folder=folder)
    assert len(solved) == 2  # at its own level and at the one below
    assert rs.open_study(folder).finished == 6
    assert (read_member(point, 1, 3).moments[0].spectrum == content.moments[0].spectrum).all()
    solved.clear()
    more = rs.study(small, vary=VARY | {"sliding.nominal_pressure": [*LOADS, 2e8]}, folder=folder)
    assert (more.finished, len(more.points)) == (8, 8)
    assert len(solved) == 24
    same = {run.numerics.levels for _, run in more.results}
    assert len(same) == 1


@pytest.mark.slow
def test_speeds_may_be_varied_one_by_one(small, tmp_path):
    study = rs.study(small, vary={"sliding.speed": [1.0, 35.0]}, folder=tmp_path / "speeds")
    value = study.to_dict()["rows"]
    assert {(row["sliding_speed"], row["speed"]) for row in value if row["speed"]} == {
        (1.0, 1.0),
        (35.0, 35.0),
    }
    assert (
        list(study.trends()) == []
    )  # the contacts are one, but the theory of trends needs the same speeds
    with h5py.File(study.save(tmp_path / "s.h5")) as file:
        assert "speed" not in file
        assert file["flash_temperature"].shape == (len(file["column"]), 2)


def test_a_process_waits_while_another_one_plans_the_points(small, tmp_path):
    folder, waited = tmp_path / "study", []
    write(folder, description_of(small))

    def end_planning():
        waited.append(sorted(path.name for path in (folder / "points").iterdir()))
        other.release(PLAN)

    with Claims(folder) as other:
        other.take(PLAN)
        threading.Timer(0.3, end_planning).start()
        with work.planning_alone(folder):
            assert waited == [[]]
            assert not other.take(PLAN)


@pytest.mark.slow
def test_processes_with_other_lists_of_points_share_their_claims(
    small, done, tmp_path, soon, one_by_one
):
    # they would compute the same members
    folder = tmp_path / "copy"
    shutil.copytree(done.folder, folder)
    point = folder / "points" / "nominal_pressure=100000000,friction_coefficient=0.1"
    for index in (3, 4):
        member_path(split_members(point), 0, index).unlink()
    seen = []

    def look(run):
        seen.append(sorted(i for level, i in run.members if level == 0 and i in (3, 4)))
        if seen[-1] == [4]:
            other.release("L0-000003")

    with Claims(folder) as other:
        other.take("L0-000003")
        rs.study(
            small,
            vary=VARY | {"sliding.nominal_pressure": [5e7, *LOADS]},
            folder=folder,
            observer=look,
        )
    assert [4] in seen
    # who leaves merges the points, also before the last process does: that one may leave others
    assert all(not any(members.iterdir()) for members in folder.glob("points/*/members"))


def test_a_study_returns_the_points_that_it_was_asked_for(quick, tmp_path):
    # meanwhile another process has begun more of them
    scene = replace(quick, ensemble=replace(quick.ensemble, until={}, max_realizations=2))
    loads = {"sliding.nominal_pressure": [1e8, 2e8]}
    more = description_of(scene, {"sliding.nominal_pressure": [1e8, 2e8, 3e8]})
    study = rs.study(scene, vary=loads, folder=tmp_path, observer=lambda _: write(tmp_path, more))
    assert (len(study.points), study.finished) == (2, 2)
    assert len(rs.open_study(tmp_path).points) == 3


def test_points_that_come_later_have_the_levels_of_the_others_and_the_table_says_so(
    small, tmp_path, monkeypatch
):
    scene = replace(small, numerics=replace(small.numerics, levels=None))
    planned = [
        rs.plan(small),
        rs.Numerics(levels=small.numerics.levels[:1], lengths=small.numerics.lengths),
    ]
    monkeypatch.setattr(work, "numerics_of", lambda *_: planned.pop(0))
    scene = replace(scene, ensemble=replace(scene.ensemble, until={}, max_realizations=2))
    first = rs.study(scene, vary={"sliding.nominal_pressure": [1e8]}, folder=tmp_path)
    assert first.later == []
    study = rs.study(scene, vary={"sliding.nominal_pressure": [1e8, 2e8]}, folder=tmp_path)
    assert len({run.numerics.levels for _, run in study.results}) == 1
    assert study.later == ["nominal_pressure=200000000"]
    words = " ".join(str(study).split())
    assert "1 points came later and have the levels planned for the others:" in words
    assert "nominal_pressure=200000000." in words
    again = rs.study(scene, vary={"sliding.nominal_pressure": [1e8, 2e8]}, folder=tmp_path)
    assert again.later == study.later
