"""Files: whole or absent, checked to the last byte, readable by other tools."""

import h5py
import numpy as np
import pytest
from damage_cases import without_seal

import roughsim as rs
from roughsim.store import member_files, member_hdf5
from roughsim.store.member_files import Member, member_path, read_member, write_member


def member(**changes):
    rng = np.random.default_rng(0)
    values = {
        "numbers": {
            "flash_temperature": rng.random(3),
            "contact_fraction": rng.random(1),
            "flash_gradient": -rng.random(3),
        },
        "wavenumber": np.arange(8.0),
        "spectrum": rng.random(8),
        "fields": {name: rng.random((40, 30)).astype(np.float32) for name in ("heights", "pressure")},
        "lengths": (2.0, 1.5),
        "speeds": (0.0, 0.5, 3.0),
        "provenance": {"seed": 7, "text": "ünïcode"},
    }
    return Member(1, 42, **(values | changes))


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "realizations").mkdir()
    return tmp_path


def test_what_is_written_is_read(folder):
    one = member()
    write_member(folder, one)
    path = member_path(folder, 1, 42)
    assert path.name == "L1-000042.h5"
    back = read_member(path, with_fields=True)
    assert list(back.numbers) == list(one.numbers)
    for name, values in one.numbers.items():
        np.testing.assert_array_equal(back.numbers[name], values)
    for name, values in one.fields.items():
        np.testing.assert_array_equal(back.fields[name], values)
    np.testing.assert_array_equal(back.spectrum, one.spectrum)
    np.testing.assert_array_equal(back.wavenumber, one.wavenumber)
    assert (back.level, back.index, back.lengths, back.provenance) == (1, 42, one.lengths, one.provenance)
    assert read_member(path).fields == {}
    assert [p.name for p in path.parent.iterdir()] == [path.name]  # nothing temporary stays


def test_a_failure_is_a_record_too(folder):
    write_member(folder, Member(0, 1, failure="stalled"))
    assert read_member(member_path(folder, 0, 1)).failure == "stalled"


def test_other_tools_find_names_axes_and_units(folder):
    write_member(folder, member())
    with h5py.File(member_path(folder, 1, 42)) as file:
        place = file
        while "default" in place.attrs:  # the chain that viewers follow
            place = place[place.attrs["default"]]
        signal = place[place.attrs["signal"]]
        assert (place.attrs["NX_class"], signal.attrs["units"]) == ("NXdata", "Pa")
        assert list(place.attrs["axes"]) == ["x", "y"]
        for axis, (name, length, points) in enumerate((("x", 2.0, 40), ("y", 1.5, 30))):
            scale = signal.dims[axis][0]
            assert scale.attrs["units"] == "m"
            np.testing.assert_allclose(scale[()], np.arange(points) * length / points)
            assert scale.name.endswith(name)
        for name in ("flash_temperature", "flash_gradient"):
            assert file[name].dims[0][0] == file["speed"]


def test_no_flipped_bit_goes_unseen(folder):
    write_member(folder, member())
    path = member_path(folder, 1, 42)
    sound, good = path.read_bytes(), read_member(path, with_fields=True)
    rng = np.random.default_rng(1)
    seen = 0
    for place in rng.integers(0, len(sound), 200):
        damaged = bytearray(sound)
        damaged[place] ^= 1 << int(rng.integers(8))
        path.write_bytes(damaged)
        try:
            back = read_member(path, with_fields=True)
        except rs.RecordError:
            seen += 1
            continue
        for name, values in good.numbers.items():  # the bit lay in padding: nothing may have changed
            np.testing.assert_array_equal(back.numbers[name], values)
        for name, values in good.fields.items():
            np.testing.assert_array_equal(back.fields[name], values)
        assert back.provenance == good.provenance
    assert seen > 100


def test_truncated_files_are_refused_by_name(folder):
    write_member(folder, member())
    path = member_path(folder, 1, 42)
    sound = path.read_bytes()
    for length in (0, 1, 100, len(sound) // 2, len(sound) - 1):
        path.write_bytes(sound[:length])
        with pytest.raises(rs.RecordError, match="L1-000042.h5 is damaged"):
            read_member(path)


def test_a_field_of_another_shape_than_the_header_says_is_damaged(folder):
    write_member(folder, member())
    path = member_path(folder, 1, 42)
    path.write_bytes(without_seal(path.read_bytes()))
    with h5py.File(path, "r+", libver="v110") as file:
        data, digest = file["pressure"][()], file["pressure"].attrs["sha256"]
        del file["pressure"]
        file.create_dataset("pressure", data=data.reshape(30, 40)).attrs["sha256"] = digest  # the same bytes
    with pytest.raises(rs.RecordError, match="the SHA-256 of its pressure does not match"):
        read_member(path, with_fields=True)
    assert read_member(path).kept == ("heights", "pressure")


def test_a_newer_format_is_refused(folder):
    write_member(folder, member())
    path = member_path(folder, 1, 42)
    with h5py.File(path, "r+") as file:
        file.attrs["format_version"] = 99
    with pytest.raises(rs.RecordError, match="format version 99; this roughsim reads up to"):
        read_member(path)


def test_a_missing_folder_is_an_error_that_names_the_path_and_leaves_nothing(tmp_path):
    with pytest.raises(OSError, match="cannot write .*L1-000042.h5"):
        write_member(tmp_path / "none", member())
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_is_no_run_is_refused(tmp_path):
    with pytest.raises(rs.RecordError, match="is no run: it has no run.json"):
        rs.open_run(tmp_path)
    with pytest.raises(rs.RecordError, match="does not exist; start it with"):
        rs.open_run(tmp_path / "none")
    (tmp_path / "run.json").write_text("{")
    with pytest.raises(rs.RecordError, match="run.json is damaged"):
        rs.open_run(tmp_path)
    (tmp_path / "run.json").write_text('{"format_version": 99}')
    with pytest.raises(rs.RecordError, match="format version 99"):
        rs.open_run(tmp_path)


def test_an_older_format_is_read_from_the_oldest_on_and_refused_before(folder, monkeypatch):
    write_member(folder, member())
    path, kept = member_path(folder, 1, 42), {**member_hdf5.KEPT_FIELDS, "displacement": ("m", "elastic")}
    # a later version, which keeps one field more
    monkeypatch.setattr(member_files, "FORMAT", 5)
    monkeypatch.setattr(member_files, "KEPT_FIELDS", kept)
    back = read_member(path, with_fields=True)
    assert back.kept == ("heights", "pressure")
    np.testing.assert_array_equal(back.numbers["contact_fraction"], member().numbers["contact_fraction"])
    monkeypatch.setattr(member_files, "OLDEST", 5)
    with pytest.raises(rs.RecordError, match="has format version 4; this one reads from 5 on: run the scene again"):
        read_member(path)
