"""The table of members, its file, and whether a member's file is still the one that was read; without any run."""

import os
from dataclasses import replace

import numpy as np
import pytest
from damage_cases import member

import roughsim as rs
from roughsim.results.members import Members
from roughsim.store import member_files
from roughsim.store.member_files import (
    Member,
    is_unchanged,
    member_path,
    read_field,
    read_member,
    read_spectrum,
    write_member,
)

SPEEDS = (0.0, 0.5, 3.0)
OF_FILE = {"size": 9, "digest": b"d", "spectrum_start": 7, "spectrum_check": 8}


@pytest.fixture
def path(tmp_path):
    (tmp_path / "realizations").mkdir()
    write_member(tmp_path, member(fields=False))
    return member_path(tmp_path, 1, 42)


def table():
    return Members([1, 2], [(2.0, 1.5), (1.0, 0.75)], SPEEDS)


def filled():
    """Realizations 0 to 4, of which 1 failed at the first level and 2 at the second."""
    members = table()
    for index in range(5):
        one = replace(member(index, fields=False), provenance={"versions": {"numpy": str(index)}}, kept=("pressure",))
        lost = Member(0, index, failure="stalled", provenance={"versions": {}})
        members.put((0, index), lost if index == 1 else one, changed=10**9 * (10 - index), **OF_FILE)
        if index % 2 == 0:
            members.put((1, index), lost if index == 2 else one, changed=10**9 * (20 + index), **OF_FILE)
    return members


def test_a_member_counts_once_however_often_it_is_put_and_not_after_it_was_taken_out():
    members = filled()
    assert len(members) == len(list(members)) == 8
    members.put((0, 3), member(3, fields=False), changed=1, **OF_FILE)
    assert len(members) == 8
    del members[0, 3]
    assert len(members) == len(list(members)) == 7
    assert (0, 3) not in members
    members.put((0, 3), member(3, fields=False), changed=1, **OF_FILE)
    assert len(members) == 8
    assert (1, 3) not in members  # no row of that level
    with pytest.raises(KeyError):
        members[0, 5]


def test_what_failed_below_an_index_is_known_by_level_and_by_realization():
    members = filled()
    assert members.failed(0, 5).tolist() == [1]
    assert members.failed(0, 1).tolist() == []
    assert members.failed(0, 2).tolist() == [1]
    assert members.failed(1, 5).tolist() == [2]
    assert members.sound(5) == [0, 3, 4]
    assert [members.count_sound(count) for count in range(6)] == [0, 1, 1, 1, 2, 3]
    members.put((0, 1), member(1, fields=False), changed=1, **OF_FILE)  # done again, and sound
    assert members.failures == {(1, 2): "stalled"}
    assert members.sound(5) == [0, 1, 3, 4]


def test_a_row_gives_back_its_member_with_its_own_versions_and_cell():
    members = filled()
    for level, lengths in ((0, (2.0, 1.5)), (1, (1.0, 0.75))):
        back, one = members[level, 4], member(4, fields=False)
        np.testing.assert_array_equal(back.numbers["flash_temperature"], one.numbers["flash_temperature"])
        assert (back.level, back.index, back.lengths, back.speeds) == (level, 4, lengths, SPEEDS)
        assert back.provenance["versions"] == {"numpy": "4"}
        assert back.kept == ("pressure",)
    assert members[0, 1].failure == "stalled"
    assert members[0, 1].numbers == {}
    indices = np.array([0, 4])
    assert members.kept(0, "heights", indices).tolist() == [False, False]
    for name in ("pressure", "temperature", "heat_flux"):
        assert members.kept(0, name, indices).tolist() == [True, True]


def test_the_latest_files_are_those_with_the_latest_times():
    assert filled().latest(2) == [22.0, 24.0]
    assert filled().latest(99)[0] == 6.0


def test_a_summary_gives_rows_that_count_only_once_their_files_were_seen(tmp_path):
    members, path = filled(), tmp_path / "summary.bin"
    for index in (3, 5):
        members.put((0, index), member(index, fields=False))  # of no file
    members.save(path, ["this run"], {"count": 3})
    again = table()
    assert again.load(path, ["this run"]) == {"count": 3}
    assert (len(again), again.sound(0), list(again)) == (0, [], [])
    assert again.row((0, 3))["state"] == 0
    assert again.row((0, 5)) is None
    for number, key in enumerate(sorted(set(members) - {(0, 3), (0, 5)}), 1):
        again.see(key, 77)
        assert len(again) == number
        assert again.row(key)["changed"] == 77
    assert again.sound(3) == members.sound(3) == [0]
    assert again[0, 1].failure == "stalled"
    np.testing.assert_array_equal(again.wavenumber[0], np.arange(8.0))
    for key in ((0, 0), (1, 4)):
        np.testing.assert_array_equal(
            again[key].numbers["flash_temperature"], members[key].numbers["flash_temperature"]
        )


def test_a_summary_of_another_run_or_with_a_flipped_bit_or_of_other_speeds_is_ignored(tmp_path):
    path = tmp_path / "summary.bin"
    filled().save(path, ["this run"], {"count": 3})
    content = path.read_bytes()
    assert table().load(path, ["another run"]) == {}
    fewer = Members([1, 2], [(2.0, 1.5), (1.0, 0.75)], SPEEDS[:2])
    assert fewer.load(path, ["this run"]) == {}
    for place in (0, len(content) // 2, len(content) - 1):
        path.write_bytes(content[:place] + bytes([content[place] ^ 1]) + content[place + 1 :])
        members = table()
        assert members.load(path, ["this run"]) == {}
        assert all(len(rows) == 0 for rows in members.tables)


def test_a_file_is_unchanged_if_size_and_digest_are_and_is_read_only_if_its_time_is_not(path, monkeypatch):
    status, digest = os.stat(path), read_member(path).digest.encode()
    size, changed = status.st_size, status.st_mtime_ns
    assert is_unchanged(path, status, size, changed + 1, digest)  # a copy
    assert not is_unchanged(path, status, size, changed + 1, digest[::-1])
    assert not is_unchanged(path, status, size, changed, digest[::-1])
    content = path.read_bytes()
    path.write_bytes(content[:99] + bytes([content[99] ^ 1]) + content[100:])  # a copy that went wrong has the seal too
    with pytest.raises(rs.RecordError, match="L1-000042.h5 is damaged"):
        is_unchanged(path, status, size, changed + 1, digest)
    with monkeypatch.context() as closed:
        closed.setattr(member_files, "read_bytes", lambda path: pytest.fail("the seal is enough"))
        os.utime(path, ns=(changed, changed))
        assert is_unchanged(path, status, size, changed, digest)
        assert not is_unchanged(path, status, size + 1, changed, digest)
        assert not is_unchanged(path.parent, os.stat(path.parent), os.stat(path.parent).st_size, 0, digest)


def test_a_spectrum_is_read_at_its_place_or_else_from_the_whole_file(path):
    one = read_member(path)
    start = path.read_bytes().find(one.spectrum.tobytes())
    check = member_files.crc32(one.spectrum.tobytes())
    np.testing.assert_array_equal(read_spectrum(path, start, 8, check), one.spectrum)
    for place, count, other in ((start + 8, 8, check), (start, 7, check), (start, 8, check + 1), (10**7, 8, check)):
        np.testing.assert_array_equal(read_spectrum(path, place, count, other), one.spectrum)


def test_a_field_that_is_not_there_or_of_another_shape_is_refused_by_name(path, tmp_path):
    with pytest.raises(rs.RecordError, match=r"L1-000042.h5 is damaged \(it has no pressure\)"):
        read_field(path, "pressure", (24, 20))
    write_member(tmp_path, member())
    np.testing.assert_array_equal(read_field(path, "pressure", (24, 20)), member().fields["pressure"])
    with pytest.raises(rs.RecordError, match=r"holds pressure of shape \(24, 20\), but this run has \(20, 24\)"):
        read_field(path, "pressure", (20, 24))
