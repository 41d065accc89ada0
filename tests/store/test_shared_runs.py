"""Runs that share a folder: each member is computed once, whatever the others do."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import pytest
from claims_cases import TWO, silent

import roughsim as rs
from roughsim.ensemble import run as ensemble_run
from roughsim.ensemble.executors import SerialExecutor
from roughsim.results.description import read_description
from roughsim.show.remarks import Remark
from roughsim.store.claims import Claims
from roughsim.store.member_files import member_path, read_member


def test_where_claims_cannot_be_made_the_run_goes_on_and_says_so_once(quick, tmp_path):
    folder = rs.run(quick, tmp_path / "run", max_realizations=1).folder
    (folder / "claims").write_text("a file of somebody")
    with pytest.warns(
        RuntimeWarning, match=r"claims cannot be made in .*claims \(.*\): the run goes on"
    ) as told:
        assert rs.run(quick, folder, max_realizations=4).realizations == 4
    assert [one.category for one in told].count(RuntimeWarning) == 1
    assert (folder / "claims").read_text() == "a file of somebody"


def test_members_that_a_process_left_are_computed_when_it_is_taken_for_gone(quick, tmp_path, soon):
    run = rs.run(quick, tmp_path / "run", max_realizations=1)
    (tmp_path / "run" / "realizations" / ".L0-000000.h5.elsewhere-1-ab.tmp").write_text("half")
    member_path(run.folder, 0, 0).unlink()
    silent(run.folder)
    again = rs.run(quick, run.folder, max_realizations=4)
    assert again.realizations == 4
    names = ["realizations", "run.json", "scene.toml"]
    assert sorted(path.name for path in run.folder.iterdir()) == names
    assert len(list((run.folder / "realizations").iterdir())) == 4


class Recording(SerialExecutor):
    """Computes members in this process, records their indices, and calls `before` with those so far."""

    def __init__(self, before=lambda computed: None):
        self.computed, self.before = [], before

    def submit(self, function, jobs, index):
        self.computed.append(index)
        self.before(self.computed)
        return super().submit(function, jobs, index)


def copy_member(source, target, index):
    """Store a member as another process does."""
    member_path(target.folder, 0, index).write_bytes(
        member_path(source.folder, 0, index).read_bytes()
    )


def test_members_of_another_process_are_counted_and_not_computed_again(quick, tmp_path, soon):
    whole = rs.run(quick, tmp_path / "whole", max_realizations=4)
    run = rs.run(quick, tmp_path / "run", max_realizations=1)

    def others(_):  # meanwhile the other one has been at work
        for index in (1, 3):
            copy_member(whole, run, index)

    pool = Recording(others)
    with Claims(run.folder) as other:
        other.take(TWO)
        result = rs.run(quick, run.folder, max_realizations=4, executor=pool, workers=1)
    assert pool.computed == [2]
    assert result.realizations == 4


def test_a_run_stops_when_another_process_has_reached_its_target(quick, tmp_path, soon):
    goal = {"flash_temperature": 0.3}  # bandwidth: 0.27
    whole = rs.run(quick, tmp_path / "whole", max_realizations=60, until=goal)
    assert whole.finished  # its pixel error is unknown, the others meet the target
    run = rs.run(quick, tmp_path / "run", max_realizations=1)
    with Claims(run.folder) as other:
        for index in range(1, 60):
            other.take(f"L0-{index:06d}")
        for path in (whole.folder / "realizations").iterdir():
            (run.folder / "realizations" / path.name).write_bytes(path.read_bytes())
        result = rs.run(quick, run.folder, max_realizations=60, until=goal)
    assert (result.finished, result.realizations) == (True, whole.realizations)


def test_of_two_starts_at_once_the_first_plan_counts(quick, tmp_path, monkeypatch):
    # plans are made of timings: two of them may differ
    scene, planned = quick, rs.plan(quick)
    other = replace(planned, tolerance=2e-4)
    folder = tmp_path / "run"

    def late(scene):
        if folder.exists():
            return other
        folder.mkdir()
        assert ensemble_run.begin(scene, folder) == other
        return planned

    monkeypatch.setattr(ensemble_run, "numerics_of", late)
    assert ensemble_run.begin(scene, folder).tolerance == 2e-4
    assert rs.open_run(folder).numerics.tolerance == 2e-4
    with pytest.raises(rs.RecordError, match="tolerance is 0.0002 there"):
        ensemble_run.begin(scene, folder, planned)


def test_each_of_two_processes_stops_where_it_was_told_and_run_json_tells_the_last(quick, tmp_path):
    longer = rs.run(quick, tmp_path / "run", max_realizations=3)

    def shorter(run):
        if run.realizations == 4 and not started:
            started.append(rs.run(quick, run.folder, max_realizations=2).realizations)

    started = []
    assert rs.run(quick, longer.folder, max_realizations=6, observer=shorter).realizations == 6
    assert started == [2]
    assert rs.open_run(longer.folder).max_realizations == 2
    assert rs.run(quick, longer.folder, max_realizations=6).realizations == 6


def test_the_versions_are_those_of_the_process_that_began(quick, tmp_path):
    folder = rs.run(quick, tmp_path / "run", max_realizations=1).folder
    description = read_description(folder)
    older = replace(description, versions=description.versions | {"numpy": "1.26.0"})
    older.write(folder, quick)
    rs.run(quick, folder, max_realizations=2)
    assert read_description(folder).versions == older.versions


def test_the_reasons_are_those_of_the_process_that_began(quick, tmp_path):
    run = rs.run(quick, tmp_path / "run", max_realizations=1)
    others = replace(
        run.numerics,
        reasons=(*run.reasons, Remark("choice", "cut-off", "of another version", "1 rad/m")),
    )
    ensemble_run.begin(quick, run.folder, others)
    assert read_description(run.folder).numerics.reasons == run.reasons


def test_a_member_that_is_damaged_while_the_run_goes_on_is_moved_aside_and_done_again(
    quick, tmp_path, soon
):
    whole = rs.run(quick, tmp_path / "whole", max_realizations=3)
    folder = rs.run(quick, tmp_path / "run", max_realizations=1).folder

    def spoil(run):
        path = member_path(folder, 0, 2)
        if run.realizations == 2 and not (folder / "damaged").exists():
            path.write_bytes(path.read_bytes()[:999] if path.exists() else b"broken")

    with pytest.warns(
        RuntimeWarning,
        match=r"L0-000002.h5 is damaged .*; it was moved to .*damaged.* and is done again",
    ):
        run = rs.run(quick, folder, max_realizations=3, observer=spoil)
    assert run.realizations == 3
    assert [path.name for path in (folder / "damaged").iterdir()] == ["L0-000002.h5"]
    for index in range(3):
        mine, theirs = (
            read_member(member_path(place, 0, index)).numbers for place in (folder, whole.folder)
        )
        assert all((mine[name] == theirs[name]).all() for name in theirs)


def test_a_member_that_was_stored_between_two_looks_is_not_computed_again(quick, tmp_path, soon):
    whole = rs.run(quick, tmp_path / "whole", max_realizations=3)
    run = rs.run(quick, tmp_path / "run", max_realizations=1)
    pool = Recording(
        lambda _: copy_member(whole, run, 2)
    )  # between the submissions of the first member and the next
    assert rs.run(quick, run.folder, max_realizations=3, executor=pool, workers=1).realizations == 3
    assert pool.computed == [1]


def test_what_a_living_process_is_writing_is_not_swept_away(quick, tmp_path, soon):
    folder = rs.run(quick, tmp_path / "run", max_realizations=1).folder
    begun = [folder / "realizations" / f".{name}.h5.here-1-ab.tmp" for name in (TWO, "L0-000005")]
    for path in begun:
        path.write_text("half")
    with Claims(folder) as other:
        other.take(TWO)
        rs.run(quick, folder, max_realizations=1)
        assert [path.exists() for path in begun] == [True, False]
    rs.run(quick, folder, max_realizations=1)
    assert not begun[0].exists()


def test_a_process_keeps_its_own_end_when_another_writes_run_json_at_its_start(
    quick, tmp_path, monkeypatch
):
    rs.run(quick, tmp_path / "run", max_realizations=1)
    genuine = ensemble_run.unread_run

    def late(place, *others):
        other = replace(quick.ensemble, max_realizations=2, until={"flash_temperature": 0.9})
        ensemble_run.begin(replace(quick, ensemble=other), place)
        return genuine(place, *others)

    monkeypatch.setattr(ensemble_run, "unread_run", late)
    run = rs.run(quick, tmp_path / "run", max_realizations=4)
    assert (run.realizations, run.until, run.max_realizations) == (4, {}, 4)


def test_where_claims_cannot_be_made_no_member_is_handed_out_twice(quick, tmp_path):
    folder = rs.run(quick, tmp_path / "run", max_realizations=1).folder
    (folder / "claims").write_text("a file of somebody")
    handed = []

    class Threads(ThreadPoolExecutor):
        def submit(self, function, jobs, index):
            handed.append(index)
            return super().submit(function, jobs, index)

    with Threads(1) as pool, pytest.warns(RuntimeWarning, match="claims cannot be made"):
        assert rs.run(quick, folder, max_realizations=6, executor=pool, workers=3).realizations == 6
    assert handed == [1, 2, 3, 4, 5]


def test_a_member_that_another_process_has_left_comes_before_those_after_it(quick, tmp_path):
    run = rs.run(quick, tmp_path / "run", max_realizations=1)

    def left(computed):
        if len(computed) == 3:
            other.release(TWO)

    pool = Recording(left)
    with Claims(run.folder) as other:
        other.take(TWO)
        assert (
            rs.run(quick, run.folder, max_realizations=9, executor=pool, workers=1).realizations
            == 9
        )
    assert pool.computed == [2, 3, 4, 1, 5, 6, 7, 8]
