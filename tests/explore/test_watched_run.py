"""A run folder that is watched: empty, growing, damaged, deleted; its state and its budget."""

import os
import shutil

import numpy as np
import pytest
from stored_cases import split_members

import roughsim as rs
from roughsim.explore.content import WatchedRun, load_fields
from roughsim.show.table import Number
from roughsim.store.claims import Claims


@pytest.fixture
def copied(capped_run, tmp_path):
    """A run folder of one's own, to be damaged."""
    return split_members(shutil.copytree(capped_run.folder, tmp_path / "copy"))


def test_the_budget_names_every_observable_with_the_numbers_of_the_estimate(capped_run):
    text = WatchedRun(capped_run.folder).summary().budget["capped"]
    for name in (
        "flash_temperature, K",
        "slope_length, µm",
        "correlation_radius_0, µm",
        "statistical",
        "n = 6",
    ):
        assert name in text
    flash = capped_run.estimate("flash_temperature", "capped")
    row = next(line for line in text.splitlines() if line.split()[:1] == ["35"])
    assert str(Number(flash.mean[2], "K", flash.total_error[2], flash.unknown_at(2))) in row


def test_the_state_counts_and_says_that_the_run_is_finished(capped_run):
    state = WatchedRun(capped_run.folder).state()
    assert state.startswith("6 realizations")
    assert state.endswith("finished: all realizations are there")


@pytest.fixture
def empty(copied):
    """The folder of a run of which nothing is there yet, and its members beside it."""
    aside = copied.with_name("aside")
    (copied / "members").rename(aside)
    (copied / "members").mkdir()
    return copied, aside


def arrive(folder, aside, index):
    for path in sorted(aside.glob(f"L?-{index:06d}.h5")):
        shutil.copy(path, folder / "members")


@pytest.fixture
def watched(empty):
    """A page on a run of which three realizations are there, with its folder and the other members beside it."""
    folder, aside = empty
    for index in (0, 1, 2):
        arrive(folder, aside, index)
    run = WatchedRun(folder)
    assert run.summary().problems == []
    return folder, aside, run


def test_an_empty_run_shows_its_scene_and_theory(empty):
    run = WatchedRun(empty[0])
    summary = run.summary()
    assert summary.measured == {}
    assert summary.kept == {0: [], 1: [], 2: []}
    assert run.state().startswith("0 realizations")
    assert "not being computed now" in run.state()
    assert summary.budget["capped"].startswith("No realization yet")
    assert run.theory(None)["flash_temperature"][1].min() > 0.0
    assert summary is run.summary()


@pytest.mark.slow
def test_a_run_of_which_one_column_has_members_yet_shows_that_column(empty):
    folder, aside = empty
    for path in aside.glob("L1-*.h5"):
        shutil.copy(path, folder / "members")
    summary = WatchedRun(folder).summary()
    assert list(summary.measured) == ["capped"]
    assert summary.budget["smoothed"].startswith("No realization yet")
    assert (summary.sound[0], summary.sound[1]) == ([], [0, 1, 2, 3, 4, 5])


def test_a_growing_run_is_followed(empty, soon):
    folder, aside = empty
    run = WatchedRun(folder)
    before = run.summary()
    arrive(folder, aside, 0)
    one = run.summary()
    assert one is not before
    assert one.kept[2] == [0]
    assert np.isinf(
        one.measured["capped"]["flash_temperature"].total_error
    ).all()  # one realization has no scatter
    with Claims(folder):
        assert f"being computed by process {os.getpid()}" in run.state()
    arrive(folder, aside, 1)
    assert run.summary().sound[2] == [0, 1]
    assert np.isfinite(run.summary().measured["capped"]["flash_temperature"].total_error).all()
    assert sorted(path.name for path in folder.iterdir()) == [
        "fields",
        "members",
        "run.json",
        "scene.toml",
    ]


@pytest.mark.slow
def test_a_damaged_file_is_named_and_the_others_are_shown(copied):
    path = copied / "members" / "L2-000003.h5"
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(rs.RecordError, match="L2-000003"):
        rs.open_run(copied)
    run = WatchedRun(copied)
    summary = run.summary()
    assert summary.sound[2] == [0, 1, 2, 4, 5]
    (line,) = summary.problems
    assert "L2-000003.h5 is damaged" in line
    assert "other realizations are shown" in line
    path.write_bytes(whole)  # mended: counted again
    assert run.summary().sound[2] == [0, 1, 2, 3, 4, 5]
    assert run.summary().problems == []


@pytest.mark.slow
def test_a_file_that_is_damaged_when_the_page_comes_to_it_is_named(watched):
    folder, aside, run = watched
    arrive(folder, aside, 3)
    (folder / "members" / "L2-000003.h5").write_bytes(b"no HDF5")
    assert "L2-000003.h5 is damaged" in run.summary().problems[0]
    assert run.summary().sound[2] == [0, 1, 2]
    arrive(folder, aside, 4)
    path = folder / "members" / "L2-000004.h5"
    path.write_bytes(path.read_bytes()[::-1])  # of the same size
    assert any("L2-000004.h5 is damaged" in problem for problem in run.summary().problems)
    assert run.summary().sound[2] == [0, 1, 2]


@pytest.mark.slow
def test_what_was_read_stays_when_its_file_is_damaged_and_the_next_page_names_it(watched):
    folder, aside, run = watched
    (folder / "members" / "L2-000001.h5").write_bytes(b"no HDF5")
    arrive(folder, aside, 3)
    assert run.summary().sound[2] == [0, 1, 2, 3]
    again = WatchedRun(folder)
    assert "L2-000001.h5 is damaged" in again.summary().problems[0]
    assert again.summary().sound[2] == [0, 2, 3]


@pytest.mark.slow
def test_a_deleted_folder_is_said_in_a_line_and_what_was_read_stays(copied):
    run = WatchedRun(copied)
    before = run.summary()
    moved = copied.rename(copied.with_name("moved"))
    gone = run.summary()
    assert gone.problems == [f"{copied} was deleted or moved; the last results remain on the page"]
    assert gone.measured is before.measured
    assert run.summary() is gone
    assert run.state() == "its folder is gone"
    moved.rename(copied)
    assert run.summary().problems == []
    assert "finished" in run.state()


def test_a_folder_deleted_before_the_first_look_is_said_too(copied):
    run = WatchedRun(copied)
    shutil.rmtree(copied)
    assert "was deleted" in run.summary().problems[0]
    assert run.summary().kept[0] == []


def test_damaged_fields_are_named(copied):
    path = copied / "fields" / "L2-000000.h5"
    content = bytearray(path.read_bytes())
    content[-5000] ^= 0xFF
    path.write_bytes(bytes(content))
    with pytest.raises(rs.RecordError, match=r"L2-000000.h5 is damaged"):
        load_fields(WatchedRun(copied).run, 2, 0)
