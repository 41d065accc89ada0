"""Runs with members that are damaged, foreign, or not to be read now: each is named, and nothing is lost."""

import builtins
import os
import shutil
from dataclasses import replace

import h5py
import numpy as np
import pytest
from damage_cases import PASSING
from summary_cases import COUNT, bits

import roughsim as rs
from roughsim.store.member_files import check_member, member_path, read_member, write_member


@pytest.mark.parametrize("number", PASSING)
def test_members_that_cannot_be_read_now_are_an_error_and_stay_where_they_are(folder, whole, number, monkeypatch):
    before = {path.name: path.read_bytes() for path in (folder / "realizations").iterdir()}
    true = builtins.open

    def refuse(file, *given, **named):
        if str(file).endswith(".h5"):
            raise OSError(number, os.strerror(number), str(file))
        return true(file, *given, **named)

    monkeypatch.setattr(builtins, "open", refuse)
    for how in ("refuse", "skip"):
        with pytest.raises(OSError, match=r"L\d-000000.h5 cannot be read now") as told:
            rs.open_run(folder, damaged=how)
        assert not isinstance(told.value, rs.RecordError)
    with pytest.raises(OSError, match=r"L\d-000000.h5 cannot be read now"):
        rs.run(whole.scene, folder, max_realizations=COUNT + 1)  # goes on with nothing, redoes nothing
    monkeypatch.undo()
    assert {path.name: path.read_bytes() for path in (folder / "realizations").iterdir()} == before
    assert rs.open_run(folder).available(0) == COUNT


@pytest.mark.parametrize("name", ["heights", "pressure"])
def test_a_flipped_bit_in_a_kept_field_is_found_and_mended(folder, whole, name):
    path = member_path(folder, 0, 0)
    with h5py.File(path) as file:
        chunk = file[name].id.get_chunk_info(0)
    content = bytearray(path.read_bytes())
    content[chunk.byte_offset + chunk.size // 2] ^= 1
    path.write_bytes(content)
    with pytest.raises(rs.RecordError, match="L0-000000.h5 is damaged"):
        check_member(path)
    with pytest.raises(rs.RecordError, match="L0-000000.h5 is damaged"):
        rs.open_run(folder)
    with pytest.warns(RuntimeWarning, match=r"L0-000000.h5 is damaged .* moved to .*damaged/L0-000000.h5"):
        rs.run(whole.scene, folder, max_realizations=COUNT)
    assert (folder / "damaged" / "L0-000000.h5").read_bytes() == content
    true = read_member(member_path(whole.folder, 0, 0), with_fields=True)
    np.testing.assert_array_equal(read_member(path, with_fields=True).fields[name], true.fields[name])
    assert bits(rs.open_run(folder)) == bits(whole)


def test_a_damaged_member_that_is_skipped_counts_as_failed_until_it_is_whole_again(folder, whole):
    path = member_path(folder, 1, 4)
    sound = path.read_bytes()
    path.write_bytes(sound[:-100])
    run = rs.open_run(folder, damaged="skip")
    assert list(run.damaged) == [(1, 4)]
    assert (run.failed, run.available(1)) == (0, whole.available(1))  # its contact converged
    assert 4 not in run.pairs()[1].sample.rows
    path.write_bytes(sound)
    run.refresh()
    assert (run.damaged, bits(run)) == ({}, bits(whole))


@pytest.mark.parametrize("how", ["seed", "speeds", "no level below", "modes"])
def test_members_of_another_run_are_refused_by_name(folder, whole, tmp_path, how):
    path = member_path(folder, 1, 2)
    one = read_member(path)
    if how == "seed":
        scene = replace(whole.scene, ensemble=replace(whole.scene.ensemble, seed=8))
        other = rs.run(scene, tmp_path / "other", numerics=whole.numerics, max_realizations=3)
        shutil.copy(member_path(other.folder, 1, 2), path)
    else:
        changes = {
            "speeds": {"speeds": (0.0, 0.1, 36.0)},
            "no level below": {"below": None},
            "modes": {"wavenumber": one.wavenumber[1:], "spectrum": one.spectrum[1:]},
        }
        write_member(folder, replace(one, **changes[how]))
    with pytest.raises(rs.RecordError, match="L1-000002.h5 is of another run"):
        rs.open_run(folder)
