"""Runs that share a folder: each member is computed once, whatever the others do."""

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import pytest
from claims_cases import TWO, silent
from stored_cases import member_path, members_of, read_member, split_members, write_member

import roughsim as rs
from roughsim.ensemble import run as ensemble_run
from roughsim.ensemble.executors import SerialExecutor
from roughsim.results.description import RunDescription, read_description
from roughsim.show.remarks import Remark
from roughsim.store.claims import Claims


def test_where_claims_cannot_be_made_the_run_goes_on_and_says_so_once(quick, tmp_path):
    folder = rs.run(quick, tmp_path / "run", max_realizations=1).folder
    (folder / "claims").write_text("a file of somebody")
    with pytest.warns(
        RuntimeWarning, match=r"claims cannot be made in .*claims \(.*\): the run goes on"
    ) as told:
        assert rs.run(quick, folder, max_realizations=4).realizations == 4
    assert [one.category for one in told].count(RuntimeWarning) == 1
    assert (folder / "claims").read_text() == "a file of somebody"


def test_members_that_a_process_left_are_computed_when_it_is_taken_for_gone(
    quick, tmp_path, soon, one_by_one
):
    run = rs.run(quick, tmp_path / "run", max_realizations=1)
    (tmp_path / "run" / "members" / ".elsewhere-1-ab-000.h5.elsewhere-1-ab.tmp").write_text("half")
    (run.folder / "members.h5").unlink()
    silent(run.folder)
    again = rs.run(quick, run.folder, max_realizations=4)
    assert again.realizations == 4
    names = ["fields", "members", "members.h5", "run.json", "scene.toml"]
    assert sorted(path.name for path in run.folder.iterdir()) == names
    assert list((run.folder / "members").iterdir()) == []
    assert len(members_of(run.folder)) == 4


class Recording(SerialExecutor):
    """Computes members in this process, records their indices, and calls `before` with those so far."""

    def __init__(self, before=lambda computed: None):
        self.computed, self.before = [], before

    def submit(self, function, jobs, wanted):
        self.computed += [index for index, _ in wanted]
        self.before(self.computed)
        return super().submit(function, jobs, wanted)


def copy_member(source, target, index):
    """Store a member as another process does."""
    write_member(target.folder, read_member(source.folder, 0, index))


def test_members_of_another_process_are_counted_and_not_computed_again(
    quick, tmp_path, soon, one_by_one
):
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


def test_a_run_stops_when_another_process_has_reached_its_target(quick, tmp_path, soon, one_by_one):
    goal = {"flash_temperature": 0.3}  # bandwidth: 0.27
    whole = rs.run(quick, tmp_path / "whole", max_realizations=60, until=goal)
    assert whole.finished  # its pixel error is unknown, the others meet the target
    run = rs.run(quick, tmp_path / "run", max_realizations=1)
    with Claims(run.folder) as other:
        for index in range(1, 60):
            other.take(f"L0-{index:06d}")
        split_members(whole.folder)
        for path in (whole.folder / "members").iterdir():
            (run.folder / "members" / path.name).write_bytes(path.read_bytes())
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


def test_of_two_starts_at_once_without_hard_links_both_take_the_last_plan(
    quick, tmp_path, monkeypatch
):
    def refuse(*_):
        raise OSError(95, "Operation not supported")

    planned, folder = rs.plan(quick), tmp_path / "run"
    other = RunDescription(quick.identity(), replace(planned, tolerance=2e-4), {})
    genuine, placed = os.replace, []

    def replaced(source, target):
        genuine(source, target)
        placed.append(target.name)
        if len(placed) == 1:  # the other process had looked before
            other.write(folder, quick)

    monkeypatch.setattr(os, "link", refuse)
    monkeypatch.setattr(os, "replace", replaced)
    assert ensemble_run.begin(quick, folder).tolerance == 2e-4
    assert placed[:2] == ["run.json", "run.json"]
    assert read_description(folder).numerics.tolerance == 2e-4


def test_each_of_two_processes_stops_where_it_was_told_and_run_json_tells_the_last(quick, tmp_path):
    longer = rs.run(quick, tmp_path / "run", max_realizations=3)

    def shorter(run):
        if run.realizations >= 4 and not started:
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


def test_a_part_that_is_damaged_while_the_run_goes_on_is_moved_aside_and_done_again(
    quick, tmp_path, soon, one_by_one
):
    whole = rs.run(quick, tmp_path / "whole", max_realizations=3)
    folder = rs.run(quick, tmp_path / "run", max_realizations=1).folder

    def spoil(run):
        if run.realizations == 2 and not (folder / "damaged").exists():
            member_path(folder, 0, 2).write_bytes(b"broken")

    with pytest.warns(
        RuntimeWarning,
        match=r"L0-000002.h5 is damaged .*; it was moved to .*damaged.* and is done again",
    ):
        run = rs.run(quick, folder, max_realizations=3, observer=spoil)
    assert run.realizations == 3
    assert [path.name for path in (folder / "damaged").iterdir()] == ["L0-000002.h5"]
    mine, theirs = members_of(folder), members_of(whole.folder)
    assert mine.keys() == theirs.keys()
    for key, member in theirs.items():
        assert all(
            (mine[key].numbers[name] == member.numbers[name]).all() for name in member.numbers
        )


def test_a_member_that_was_stored_between_two_looks_is_not_computed_again(
    quick, tmp_path, soon, one_by_one
):
    whole = rs.run(quick, tmp_path / "whole", max_realizations=3)
    run = rs.run(quick, tmp_path / "run", max_realizations=1)
    pool = Recording(
        lambda _: copy_member(whole, run, 2)
    )  # between the submissions of the first member and the next
    assert rs.run(quick, run.folder, max_realizations=3, executor=pool, workers=1).realizations == 3
    assert pool.computed == [1]


def test_unfinished_files_are_removed(quick, tmp_path, soon):
    folder = rs.run(quick, tmp_path / "run", max_realizations=1).folder
    begun = [
        folder / "members" / ".here-1-ab-000.h5.here-1-ab.tmp",
        folder / "fields" / ".L0-000000.h5.here-1-ab.tmp",
        folder / ".members.h5.here-1-ab.tmp",
    ]
    mine = folder / "members" / ".draft.tmp"
    for path in (*begun, mine):
        path.write_text("half")
    with Claims(folder):  # a process that may be at work on them
        rs.run(quick, folder, max_realizations=1)
    assert all(path.exists() for path in begun)
    rs.run(quick, folder, max_realizations=1)
    assert [path.exists() for path in (*begun, mine)] == [False, False, False, True]


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


def test_where_claims_cannot_be_made_no_member_is_handed_out_twice(quick, tmp_path, one_by_one):
    folder = rs.run(quick, tmp_path / "run", max_realizations=1).folder
    (folder / "claims").write_text("a file of somebody")
    handed = []

    class Threads(ThreadPoolExecutor):
        def submit(self, function, jobs, wanted):
            handed.extend(index for index, _ in wanted)
            return super().submit(function, jobs, wanted)

    with Threads(1) as pool, pytest.warns(RuntimeWarning, match="claims cannot be made"):
        assert rs.run(quick, folder, max_realizations=6, executor=pool, workers=3).realizations == 6
    assert handed == [1, 2, 3, 4, 5]


def test_a_member_that_another_process_has_left_comes_before_those_after_it(
    quick, tmp_path, one_by_one
):
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
