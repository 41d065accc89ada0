"""Going on: what cannot be read now is no damage, what is damaged is moved aside, and what is somebody's own stays."""

import errno
import os
import shutil
from dataclasses import replace

import numpy as np
import pytest
from some_rows import some
from stored_cases import member_path, read_member, split_members

import roughsim as rs
from roughsim.ensemble import run as ensemble_run
from roughsim.ensemble import sources
from roughsim.store.member_files import fields_path


@pytest.fixture(scope="module")
def finished(capped_scene, tmp_path_factory):
    """The run of `quick` with three realizations; tests work on copies."""
    levels = ({"column": "capped", "shape": [32, 32], "q_max": 4e4},)
    scene = replace(
        capped_scene, numerics=replace(capped_scene.numerics, levels=levels, keep_fields=1)
    )
    return rs.run(scene, tmp_path_factory.mktemp("finished") / "run", max_realizations=3)


@pytest.fixture
def folder(finished, tmp_path):
    return split_members(shutil.copytree(finished.folder, tmp_path / "run"))


def contents(folder):
    return {
        path.name: path.read_bytes() for path in (folder / "members").iterdir() if path.is_file()
    }


@pytest.mark.parametrize(
    "number",
    some([errno.ENOLCK, errno.ESTALE, errno.EIO, errno.EACCES, errno.EMFILE, errno.EAGAIN]),
)
def test_a_member_that_cannot_be_read_now_stops_the_run_with_a_sentence_and_nothing_is_done_to_it(
    quick, folder, unreadable, number, calls
):
    before = contents(folder)
    said = r"L0-000001.h5 cannot be read now \(.*\); nothing was changed"
    with unreadable("*L0-000001.h5", number), pytest.raises(OSError, match=said) as told:
        rs.run(quick, folder, max_realizations=4)
    assert told.value.errno == number
    assert contents(folder) == before
    solved = calls(sources, "solve_problem")
    assert rs.run(quick, folder, max_realizations=4).realizations == 4
    assert len(solved) == 1  # not one was computed again
    assert not (folder / "damaged").exists()


@pytest.mark.parametrize("where", some([40, -300, "field"], 2))
def test_a_damaged_member_is_moved_aside_whole_and_done_again(quick, folder, where):
    # index 0 has kept its fields: a flipped bit in them counts too
    numbers = read_member(folder, 0, 0).numbers
    path = fields_path(folder, 0, 0) if where == "field" else member_path(folder, 0, 0)
    broken = bytearray(path.read_bytes())
    broken[len(broken) // 2 if where == "field" else where] ^= 4
    path.write_bytes(broken)
    for round in (0, 1):
        with pytest.warns(
            RuntimeWarning, match=r"L0-000000.h5 is damaged .*; it was moved to .*damaged.L0-000000"
        ):
            rs.run(quick, folder, max_realizations=3)
        assert len(list((folder / "damaged").iterdir())) == round + 1
        for name, values in read_member(folder, 0, 0).numbers.items():
            np.testing.assert_array_equal(values, numbers[name])
        path.write_bytes(broken)
    assert {aside.read_bytes() for aside in (folder / "damaged").iterdir()} == {bytes(broken)}


def test_folders_and_files_of_others_are_left_alone(quick, folder):
    place = folder / "members"
    (place / "mine").mkdir()
    (place / "mine" / "L0-000000.h5").write_text("broken")
    others = (
        "notes.txt",
        "L0-000001.h5.bak",
        "old L0-000002.h5",
        ".draft.tmp",
        ".L0-000001.h5",
        "L0-1.h5",
    )
    for name in others:
        (place / name).write_text(name)
    assert rs.run(quick, folder, max_realizations=4).realizations == 4
    assert all((place / name).read_text() == name for name in others)
    assert (place / "mine" / "L0-000000.h5").read_text() == "broken"


def test_a_member_that_was_lost_from_the_middle_is_done_again(quick, folder):
    numbers = read_member(folder, 0, 1).numbers
    member_path(folder, 0, 1).unlink()
    assert rs.run(quick, folder, max_realizations=3).realizations == 3
    for name, values in read_member(folder, 0, 1).numbers.items():
        np.testing.assert_array_equal(values, numbers[name])


def test_a_start_that_was_interrupted_is_taken_up_at_any_moment_of_it(quick, tmp_path, monkeypatch):
    for count in range(4):  # bytes placed before the interrupt
        folder = tmp_path / f"run{count}"
        left, genuine = [count], os.fsync

        def interrupted(handle, left=left, genuine=genuine):
            if left[0] == 0:
                raise KeyboardInterrupt
            left[0] -= 1
            genuine(handle)

        with monkeypatch.context() as killed:
            killed.setattr(os, "fsync", interrupted)
            with pytest.raises(KeyboardInterrupt):
                rs.run(quick, folder, max_realizations=2)
        assert rs.run(quick, folder, max_realizations=2).realizations == 2


@pytest.mark.parametrize("case", ["foreign", "file", "other scene", "target"])
def test_what_cannot_be_is_refused_before_planning(quick, tmp_path, calls, case):
    place, scene, until = tmp_path / "run", quick, None
    if case == "foreign":
        place.mkdir()
        (place / "letter.txt").write_text("dear")
    elif case == "file":
        place.write_text("dear")
    elif case == "other scene":
        rs.run(quick, place, max_realizations=1)
        scene = replace(quick, sliding=replace(quick.sliding, friction_coefficient=0.2))
    else:
        until = {"flash_temperature": 2.0}
    planned = calls(ensemble_run, "numerics_of")
    words = {
        "foreign": "holds other files",
        "file": "is a file",
        "other scene": "friction",
        "target": "must be less than 1",
    }
    with pytest.raises(ValueError, match=words[case]):
        rs.run(scene, place, until=until)
    assert planned == []
