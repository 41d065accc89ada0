"""Runs with members that are damaged, foreign, or not to be read now: each is named, and nothing is lost."""

import json
import os
import shutil
from dataclasses import replace

import h5py
import numpy as np
import pytest
from damage_cases import PASSING, forged
from some_rows import some
from stored_cases import (
    member_path,
    members_of,
    read_file,
    read_member,
    split_members,
    write_member,
)
from summary_cases import COUNT, bits

import roughsim as rs
from roughsim.ensemble import workers
from roughsim.results.arrays import attributes_of
from roughsim.store.member_files import fields_path


@pytest.mark.parametrize("number", some(PASSING))
def test_members_that_cannot_be_read_now_are_an_error_and_stay_where_they_are(
    folder, whole, number, unreadable
):
    before = {path.name: path.read_bytes() for path in (folder / "members").iterdir()}
    with unreadable("*.h5", number):
        for how in ("refuse", "skip"):
            with pytest.raises(OSError, match=r"L\d-00000\d.h5 cannot be read now") as told:
                rs.open_run(folder, damaged=how)
            assert not isinstance(told.value, rs.RecordError)
        with pytest.raises(OSError, match=r"L\d-00000\d.h5 cannot be read now"):
            rs.run(
                whole.scene, folder, max_realizations=COUNT + 1
            )  # goes on with nothing, redoes nothing
    assert {path.name: path.read_bytes() for path in (folder / "members").iterdir()} == before
    assert rs.open_run(folder).members.available[0] == COUNT


@pytest.mark.parametrize("name", some(["heights", "pressure"]))
def test_a_flipped_bit_in_a_kept_field_is_found_and_mended(folder, whole, name):
    path = fields_path(folder, 0, 0)
    with h5py.File(path) as file:
        chunk = file[name].id.get_chunk_info(0)
    content = bytearray(path.read_bytes())
    content[chunk.byte_offset + chunk.size // 2] ^= 1
    path.write_bytes(content)
    with pytest.raises(rs.RecordError, match="L0-000000.h5 is damaged"):
        rs.open_run(folder).field(0, 0, name)
    with pytest.warns(
        RuntimeWarning, match=r"L0-000000.h5 is damaged .* moved to .*damaged/L0-000000.h5"
    ):
        rs.run(whole.scene, folder, max_realizations=COUNT)
    assert (folder / "damaged" / "L0-000000.h5").read_bytes() == content
    true = read_member(whole.folder, 0, 0)
    np.testing.assert_array_equal(rs.open_run(folder).field(0, 0, name), true.fields[name])
    assert bits(rs.open_run(folder)) == bits(whole)


def test_a_damaged_member_that_is_skipped_counts_as_failed_until_the_run_is_opened_again(
    folder, whole
):
    path = member_path(folder, 1, 4)
    sound = path.read_bytes()
    path.write_bytes(sound[:1000])
    run = rs.open_run(folder, damaged="skip")
    assert list(run.damaged) == ["L1-000004.h5"]
    assert (run.failed, run.members.available[1]) == (
        0,
        whole.members.available[1],
    )  # its contact converged
    assert 4 not in run.samples()[1].rows
    path.write_bytes(sound)
    run.refresh()
    assert list(run.damaged) == ["L1-000004.h5"]
    run = rs.open_run(folder, damaged="skip")
    assert (run.damaged, bits(run)) == ({}, bits(whole))


def test_a_run_whose_first_member_is_damaged_has_the_versions_of_the_next(folder, whole):
    path = member_path(folder, 0, 0)
    path.write_bytes(path.read_bytes()[:1000])
    run = rs.open_run(folder, damaged="skip")
    of_next = read_member(whole.folder, 0, 1).provenance["versions"]
    assert json.loads(attributes_of(run.members)["versions"]) == of_next


def foreign(whole, elsewhere, how):
    """Place a file with a sound seal that is not of the run at L1-000002."""
    path = member_path(elsewhere, 1, 2)
    one = read_file(path)
    if how in ("seed", "tolerance"):
        scene, numerics = whole.scene, whole.numerics
        if how == "seed":
            scene = replace(scene, ensemble=replace(scene.ensemble, seed=8))
        else:
            numerics = replace(numerics, tolerance=1e-5)
        other = rs.run(scene, elsewhere.with_name("other"), numerics=numerics, max_realizations=3)
        shutil.copy(member_path(split_members(other.folder), 1, 2), path)
    elif how == "link":
        with forged(path) as file:
            del file["L1/numbers"]
            file["L1/numbers"] = h5py.SoftLink("/L1/stress_spectrum")
    else:
        changes = {
            "speeds": {"speeds": (0.0, 0.1, 36.0)},
            "no level below": {"moments": one.moments[:1]},
            "modes": {
                "moments": tuple(
                    part._replace(wavenumber=part.wavenumber[1:], spectrum=part.spectrum[1:])
                    for part in one.moments
                )
            },
            "fields": {"fields": {"pressure": np.zeros((16, 16), np.float32)}},
        }
        write_member(elsewhere, replace(one, **changes[how]))
    return path


@pytest.mark.parametrize(
    "how", some(["seed", "tolerance", "speeds", "no level below", "fields", "link"])
)
def test_what_readers_refuse_the_run_moves_aside_and_does_again(folder, whole, how):
    path = foreign(whole, folder, how)
    wrong = path.read_bytes()
    with pytest.raises(
        rs.RecordError, match=r"L1-000002.h5 is (of another run|damaged) .*|L1-000002.h5 is of"
    ) as told:
        rs.open_run(folder)
    assert str(told.value).endswith(
        "folder: it moves the file into 'damaged' and computes its members again"
    )
    assert list(rs.open_run(folder, damaged="skip").damaged) == ["L1-000002.h5"]
    with pytest.warns(
        RuntimeWarning, match=r"L1-000002.h5 is .*; it was moved to .*damaged/L1-000002.h5"
    ):
        again = rs.run(whole.scene, folder, max_realizations=COUNT)
    assert (folder / "damaged" / "L1-000002.h5").read_bytes() == wrong
    assert (again.damaged, bits(again)) == ({}, bits(whole))


def test_members_of_one_level_with_other_wavenumbers_are_named_and_all_of_them_stay(folder, whole):
    # which of them is the wrong one, the files do not show
    path = foreign(whole, folder, "modes")
    wrong = path.read_bytes()
    for look in (rs.open_run, lambda place: rs.run(whole.scene, place, max_realizations=COUNT)):
        with pytest.raises(
            rs.RecordError, match="L1-000002.h5 or the members .* move files of other runs"
        ):
            look(folder)
    assert path.read_bytes() == wrong
    assert not (folder / "damaged").exists()


def test_a_member_that_is_wrong_again_once_it_was_computed_ends_the_run(folder, whole, monkeypatch):
    # as by workers of another version
    foreign(whole, folder, "speeds")
    genuine = workers.computed

    def computed(*rest):
        member, solved = genuine(*rest)
        return replace(member, speeds=(1.0, 2.0, 3.0)), solved

    monkeypatch.setattr(workers, "computed", computed)
    with (
        pytest.warns(RuntimeWarning, match="moved to"),
        pytest.raises(rs.RecordError, match="L1-000002 is of another run: its speeds"),
    ):
        rs.run(whole.scene, folder, max_realizations=COUNT)
    assert len(list((folder / "damaged").iterdir())) == 1
    assert (1, 2) not in members_of(folder)


@pytest.mark.parametrize("kind", ["folder", "pipe"])
def test_a_folder_or_a_pipe_in_the_place_of_a_member_is_one_sentence(folder, whole, kind):
    path = member_path(folder, 0, 1)
    path.unlink()
    path.mkdir() if kind == "folder" else os.mkfifo(path)
    for look in (rs.open_run, lambda place: rs.run(whole.scene, place, max_realizations=COUNT)):
        with pytest.raises(
            rs.RecordError,
            match=r"^/.*L0-000001.h5 is a folder, a pipe or a device; a file is needed",
        ):
            look(folder)
    assert list(rs.open_run(folder, damaged="skip").damaged) == ["L0-000001.h5"]
