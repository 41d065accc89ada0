"""Damaged, not to be read now, or sound: told apart by the bytes alone, and nothing is ever deleted."""

import errno
import os
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from damage_cases import PASSING, forged, member, sealed, with_header, without_seal
from stored_cases import OF_RUN, member_path, write_member

import roughsim as rs
from roughsim.store import disk
from roughsim.store.disk import is_temporary, set_aside
from roughsim.store.member_files import fields_path, read_fields
from roughsim.store.parts import read_part, write_part
from roughsim.store.saving import sound_part


@pytest.fixture
def path(tmp_path):
    """The part of a member."""
    (tmp_path / "members").mkdir()
    write_member(tmp_path, member())
    return member_path(tmp_path, 1, 42)


@pytest.mark.parametrize("kind", ["flipped bit", "64 zeroed bytes"])
def test_no_damaged_byte_goes_unseen_wherever_it_lies(path, kind):
    sound = path.read_bytes()
    places = [
        *np.linspace(0, len(sound) - 1, 80, dtype=int),
        *range(len(sound) - 100, len(sound), 3),
    ]
    for place in places:
        broken = bytearray(sound)
        if kind == "flipped bit":
            broken[place] ^= 1 << (place % 8)
        else:
            broken[place : place + 64] = bytes(len(broken[place : place + 64]))
        if broken == sound:
            continue  # zeros were there before
        path.write_bytes(broken)
        with pytest.raises(
            rs.RecordError, match=r"L1-000042.h5 is damaged \(.*moves the file into 'damaged'"
        ):
            read_part(path)


def test_a_cut_off_file_is_damaged_at_every_length(path):
    sound = path.read_bytes()
    whole = len(without_seal(sound))
    for length in (0, 7, 47, 48, 1000, whole - 1, *range(whole, len(sound))):
        path.write_bytes(sound[:length])
        with pytest.raises(rs.RecordError, match="is damaged"):
            read_part(path)
    path.write_bytes(sound + b"\0")
    with pytest.raises(rs.RecordError, match="is damaged"):
        read_part(path)


def test_the_file_or_the_digest_of_another_member_is_refused(path, tmp_path):
    write_member(tmp_path, member(43))
    mine, theirs = path.read_bytes(), member_path(tmp_path, 1, 43).read_bytes()
    path.write_bytes(without_seal(mine) + theirs[len(without_seal(theirs)) :])
    with pytest.raises(rs.RecordError, match="its SHA-256 does not match"):
        read_part(path)
    kept, other = (fields_path(tmp_path, 1, index) for index in (42, 43))
    kept.write_bytes(other.read_bytes())
    with pytest.raises(rs.RecordError, match="it holds level 1, index 43, unlike its name"):
        read_fields(kept)
    sealed(kept, without_seal(other.read_bytes()))
    with pytest.raises(rs.RecordError, match="it holds level 1, index 43, unlike its name"):
        read_fields(kept)


@pytest.mark.parametrize("index", [42, 43, 44])
def test_members_of_a_damaged_part_are_kept_but_those_that_are_damaged(path, index):
    members = [member(number, fields=False) for number in (42, 43, 44)]
    write_part(path, OF_RUN, members)
    spectrum = next(one for one in members if one.index == index).moments[0].spectrum
    content = path.read_bytes()
    place = content.index(spectrum.tobytes())
    path.write_bytes(content[:place] + bytes([content[place] ^ 1]) + content[place + 1 :])
    with pytest.raises(rs.RecordError, match="its SHA-256 does not match"):
        read_part(path)
    sound = sound_part(path)
    assert [one.index for one in sound.members] == [i for i in (42, 43, 44) if i != index]
    for one in sound.members:
        np.testing.assert_array_equal(
            one.moments[0].spectrum, members[one.index - 42].moments[0].spectrum
        )


@pytest.mark.parametrize("length", [0, 100, 1000])
def test_of_a_part_that_hdf5_cannot_open_nothing_is_kept(path, length):
    path.write_bytes(path.read_bytes()[:length])
    assert sound_part(path).members == []


@pytest.mark.parametrize("number", PASSING)
def test_what_cannot_be_read_now_is_an_error_that_says_why_and_no_damage(path, number, unreadable):
    said = rf"L1-000042.h5 cannot be read now \({os.strerror(number)}\); nothing"
    with unreadable("*.h5", number), pytest.raises(OSError, match=said) as told:
        read_part(path)
    assert told.value.errno == number
    assert not isinstance(told.value, rs.RecordError)


@pytest.mark.skipif(sys.platform != "linux", reason="a file of Linux that opens and cannot be read")
def test_an_error_in_the_middle_of_a_file_is_no_damage(path):
    path.unlink()
    path.symlink_to("/proc/self/mem")  # its first page is never mapped
    with pytest.raises(OSError, match=r"cannot be read now \(Input/output error\)"):
        read_part(path)


def test_a_file_that_another_machine_replaces_while_it_is_read_is_read_again(path, monkeypatch):
    genuine, stale = os.fstat, []

    def fstat(handle):
        if not stale:
            stale.append(handle)
            raise OSError(errno.ESTALE, os.strerror(errno.ESTALE))
        return genuine(handle)

    monkeypatch.setattr(os, "fstat", fstat)
    assert disk.read_bytes(path)[-65:] == path.read_bytes()[-65:]
    assert stale


def test_a_missing_file_and_a_folder_in_its_place_are_no_damage(path):
    path.unlink()
    with pytest.raises(FileNotFoundError, match="L1-000042.h5 cannot be read now"):
        read_part(path)
    path.mkdir()
    with pytest.raises(rs.RecordError, match="is a folder, a pipe or a device") as told:
        read_part(path)
    assert not isinstance(told.value, disk.DamagedError)


def test_a_file_of_another_format_is_no_damage(path):
    for version in (4, 99):
        with_header(path, format_version=version)
        with pytest.raises(rs.RecordError, match=f"format.* {version}") as told:
            read_part(path)
        assert not isinstance(told.value, disk.DamagedError)


@pytest.mark.parametrize("header", [["{}"] * 7, h5py.Empty("S9")])
def test_a_header_that_is_not_one_text_is_refused_before_it_is_read(path, header):
    with forged(path) as file:  # HDF5 would write seven texts to the place of one
        del file.attrs["header"]
        file.attrs["header"] = header
    with pytest.raises(disk.DamagedError, match="is damaged"):
        read_part(path)


def test_damaged_files_are_kept_under_free_names(path, tmp_path):
    sound = path.read_bytes()
    for number, name in enumerate(("L1-000042.h5", "L1-000042-1.h5", "L1-000042-2.h5")):
        path.write_bytes(sound + bytes([number]))
        assert set_aside(path, tmp_path / "damaged") == tmp_path / "damaged" / name
        assert not path.exists()
    kept = {p.name: p.read_bytes()[-1] for p in (tmp_path / "damaged").iterdir()}
    assert kept == {"L1-000042.h5": 0, "L1-000042-1.h5": 1, "L1-000042-2.h5": 2}
    with pytest.raises(FileNotFoundError):
        set_aside(path, tmp_path / "damaged")
    assert (
        len(list((tmp_path / "damaged").iterdir())) == 3
    )  # no empty file stands for one that was gone


def test_a_temporary_file_that_another_process_sweeps_away_is_written_again(
    path, tmp_path, monkeypatch
):
    true, swept = os.replace, []

    def replace(source, target):
        if len(swept) < 2:
            swept.append(Path(source).name)
            Path(source).unlink()
        true(source, target)

    monkeypatch.setattr(os, "replace", replace)
    disk.place_bytes(path, b"whole")
    assert path.read_bytes() == b"whole"
    assert len(set(swept)) == 2
    assert all(is_temporary(name) for name in swept)
    assert not is_temporary(path.name)
    assert not is_temporary(".profile")
    assert [p.name for p in path.parent.iterdir()] == [path.name]


def test_a_disk_that_takes_nothing_and_removes_nothing_is_named_with_the_file_that_was_to_be_written(
    path, unreadable
):
    # mounted for reading only, or remounted so after an error
    said = rf"cannot write .*{path.name}: Read-only file system"
    with unreadable("*.tmp", errno.EROFS), pytest.raises(OSError, match=said):
        disk.place_bytes(path, b"whole")
