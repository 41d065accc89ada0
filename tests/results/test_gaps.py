"""What a run lacks is named: members missing in the middle, and damaged ones, in every output."""

import os

import pytest
from stored_cases import member_path

import roughsim as rs
from roughsim.cli import main
from roughsim.explore.content import WatchedRun
from roughsim.results import folder as folder_module
from roughsim.store.claims import Claims


@pytest.mark.slow
def test_a_missing_member_in_the_middle_is_named_and_what_follows_is_said(folder):
    for name in ("L0-000003.h5", "L0-000005.h5", "L1-000002.h5"):
        (folder / "members" / name).unlink()
    (folder / "members" / "mine").mkdir()  # what is somebody's own is left alone
    (folder / "members" / "L0-000099.h5.bak").write_text("mine")
    run = rs.open_run(folder)
    assert (run.realizations, run.missing) == (3, ["L0-000003", "L0-000005", "L1-000002"])
    said = "lost: L0-000003, L0-000005, L1-000002; only the 3 realizations before count; repeat the command"
    assert any(line.startswith(said) for line in str(rs.status(run)).splitlines())
    assert rs.status(run).to_dict()["missing"] == rs.status(run).to_dict()["lost"] == run.missing
    assert any(note.startswith(said) for note in rs.compare(run).notes())
    assert rs.compare(run).to_dict()["missing"] == run.missing
    assert any(note.startswith(said) for note in rs.compare(run).table().notes)


def test_members_beyond_a_lowered_maximum_are_not_lost(folder):
    for name in ("L0-000003.h5", "L0-000005.h5"):
        (folder / "members" / name).unlink()
    run = rs.run(rs.open_run(folder).scene, folder, max_realizations=2)
    assert (run.realizations, run.missing, rs.status(run).to_dict()["lost"]) == (2, [], [])
    assert not any("lost" in line for line in str(rs.status(run)).splitlines())


@pytest.mark.parametrize("study", [False, True])
def test_what_a_run_lacks_while_a_process_computes_it_is_not_lost(folder, tmp_path, soon, study):
    (folder / "members" / "L0-000003.h5").unlink()
    if study:  # its processes sign in the folder of the study
        (tmp_path / "study/points").mkdir(parents=True)
        folder = folder.rename(tmp_path / "study/points/a=1")
    run = rs.open_run(folder)
    with Claims(tmp_path / "study" if study else folder):
        (line,) = (line for line in str(rs.status(run)).splitlines() if "L0-000003" in line)
        assert line.startswith(f"not there yet: L0-000003; process {os.getpid()} on ")
        assert line.endswith(" computes the run now; only the 3 realizations before count so far")
        assert (rs.status(run).to_dict()["missing"], rs.status(run).to_dict()["lost"]) == (
            ["L0-000003"],
            [],
        )
        assert f"being computed by process {os.getpid()} on " in str(rs.status(run)).splitlines()[1]
    assert rs.status(run).to_dict()["lost"] == ["L0-000003"]


def test_what_is_stored_while_the_last_process_ends_is_not_lost(folder, monkeypatch):
    path = folder / "members" / "L0-000003.h5"
    content, whole = path.read_bytes(), rs.open_run(folder)
    path.unlink()
    run = rs.open_run(folder)
    monkeypatch.setattr(folder_module, "writer", lambda folder: path.write_bytes(content) and None)
    assert folder_module.gap(run) == []
    path.unlink()
    run = rs.open_run(folder)
    monkeypatch.setattr(
        "roughsim.outputs.status.writer", lambda folder: path.write_bytes(content) and None
    )
    lines = str(rs.status(run)).splitlines()
    assert not any("L0-000003" in line for line in lines)
    assert f"{whole.realizations} " in lines[1]
    path.unlink()
    assert rs.status(rs.open_run(folder)).to_dict()["missing"] == []


@pytest.mark.slow
def test_files_and_pages_of_a_run_with_a_gap_are_not_shorter_without_a_word(
    folder, tmp_path, capsys
):
    (folder / "members" / "L0-000003.h5").unlink()
    for words in (
        ["export", str(folder), "-o", str(tmp_path / "a.h5")],
        ["plot", str(folder), "spectrum"],
    ):
        with pytest.raises(SystemExit) as ended:
            main(words)
        assert ended.value.code == 0
        assert "lost: L0-000003; only the 3 real" in capsys.readouterr().err
    assert any("lost: L0-000003" in line for line in WatchedRun(folder).summary().problems)


def test_a_whole_run_and_one_that_met_its_target_miss_nothing(folder):
    run = rs.open_run(folder)
    assert run.missing == []
    (folder / "members" / "L0-000007.h5").unlink()
    assert rs.open_run(folder).missing == ["L0-000007"]
    (
        folder / "members" / "L0-000008.h5"
    ).unlink()  # the last of its level: as if it had not been computed yet
    assert rs.open_run(folder).missing == []


def test_damaged_members_are_named_and_not_said_to_have_not_converged(folder):
    path = member_path(folder, 0, 2)
    path.write_bytes(path.read_bytes()[:1000])
    run = rs.open_run(folder, damaged="skip")
    lines = str(rs.status(run)).splitlines()
    assert any(
        line.startswith("damaged and left out of the means: L0-000002.h5; repeat the command")
        for line in lines
    )
    assert not any("did not converge" in line for line in lines)
    assert (rs.status(run).to_dict()["damaged"], rs.status(run).to_dict()["failed"]) == (
        ["L0-000002.h5"],
        0,
    )
