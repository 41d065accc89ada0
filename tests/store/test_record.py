"""Files: whole or absent, checked to the last byte, readable by other tools."""

import json
from dataclasses import replace

import h5py
import numpy as np
import pytest
from damage_cases import forged, level_of, member, with_header
from stored_cases import OF_RUN, member_path, read_file, write_member

import roughsim as rs
from roughsim.observables.catalogue import NUMBERS
from roughsim.observables.member import Member, StoredMoments
from roughsim.store.hdf5 import write_arrays
from roughsim.store.member_files import fields_path, read_fields
from roughsim.store.parts import read_part, write_part


@pytest.fixture
def path(tmp_path):
    """The part of a member with the level below."""
    (tmp_path / "members").mkdir()
    write_member(tmp_path, member())
    return member_path(tmp_path, 1, 42)


@pytest.fixture
def kept(path):
    """The file with the fields of the member."""
    return fields_path(path.parents[1], 1, 42)


def assert_the_same(one, other):
    assert (one.level, one.index, one.failure) == (other.level, other.index, other.failure)
    assert (one.lengths, one.speeds, one.provenance) == (
        other.lengths,
        other.speeds,
        other.provenance,
    )
    for a, b in zip(one.moments, other.moments, strict=True):
        assert list(a.numbers) == list(b.numbers)
        for name, values in a.numbers.items():
            np.testing.assert_array_equal(b.numbers[name], values)
        np.testing.assert_array_equal(b.wavenumber, a.wavenumber)
        np.testing.assert_array_equal(b.spectrum, a.spectrum)


KINDS = {
    "with fields": member(),
    "without fields": member(fields=False),
    "lowest level": member(fields=False, below=False),
    "one speed": replace(
        member(),
        speeds=(1.0,),
        moments=(
            StoredMoments(
                {"peak_volume": np.array([-0.5])}, np.arange(8.0), np.linspace(0.0, 1.0, 8)
            ),
        ),
    ),
    "long header": replace(member(), provenance={"text": "ü" * 200_000}),
    "failed": Member(1, 42, failure="stalled at ½", provenance={"residual": 1.0}),
}


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_written_is_read(path, tmp_path, kind):
    one = KINDS[kind]
    write_member(tmp_path, one)
    back = read_file(path)
    assert_the_same(one, back)
    assert back.kept == {name: values.shape for name, values in one.fields.items()}
    for name, values in one.fields.items():
        np.testing.assert_array_equal(back.fields[name], values)
    assert read_part(path).members[0].fields == {}
    assert [p.name for p in path.parent.iterdir()] == [path.name]  # nothing temporary stays


def test_members_of_a_part_are_read_in_order_but_those_known(path):
    others = [
        replace(member(index, fields=False), level=level) for level, index in ((2, 7), (1, 43))
    ]
    failed = replace(KINDS["failed"], index=44)
    write_part(path, OF_RUN, [failed, *others, member(fields=False)])
    header, back = read_part(path)
    assert {key: header[key] for key in OF_RUN} == OF_RUN
    assert [(one.level, one.index) for one in back] == [(1, 42), (1, 43), (1, 44), (2, 7)]
    for one, stored in zip((member(), others[1], failed, others[0]), back, strict=True):
        assert_the_same(replace(one, lengths=stored.lengths), stored)
    assert [one.index for one in read_part(path, {(1, 42), (2, 7)}).members] == [43, 44]


def test_a_number_of_either_level_lies_where_its_axes_say(path):
    one = member()
    with h5py.File(path) as whole:
        file = whole["L1"]
        names = [name.decode() for name in file["number"]]
        for name, values in one.numbers.items():
            place = names.index(name)
            assert file["unit"][place].decode() == NUMBERS[name].unit
            for below, numbers in enumerate(part.numbers for part in one.moments):
                row = file["numbers"][0, below, place]
                np.testing.assert_array_equal(row[: len(values)], numbers[name])
                assert np.isnan(row[len(values) :]).all()
        np.testing.assert_array_equal(file["stress_spectrum"][0, 0], one.moments[0].spectrum)
        np.testing.assert_array_equal(
            file["stress_spectrum"][0, 1], [*one.moments[1].spectrum, *[np.nan] * 3]
        )
        for name, axes in {
            "numbers": ("realization", "below", "number", "speed"),
            "stress_spectrum": ("realization", "below", "wavenumber"),
        }.items():
            assert [file[name].dims[axis][0] for axis in range(len(axes))] == [
                file[axis] for axis in axes
            ]
            assert file[name].dtype == np.float64
            assert not file[
                name
            ].fletcher32  # readers by reference do not know it; the file has its SHA-256


def test_levels_with_wavenumbers_of_their_own_are_told_apart(path, tmp_path):
    own, below = (
        StoredMoments(member().numbers, np.array([1.0, 2.0, 4.0]), np.array([1.0, -0.5, 0.0])),
        member().moments[1],
    )
    below = below._replace(wavenumber=np.array([1.0, 3.0]), spectrum=np.array([7.0, 8.0]))
    write_member(tmp_path, replace(member(), moments=(own, below)))
    assert_the_same(replace(member(), moments=(own, below)), read_file(path))
    with h5py.File(path) as file:
        np.testing.assert_array_equal(file["L1/wavenumber"], [1.0, 2.0, 3.0, 4.0])
        np.testing.assert_array_equal(file["L1/stress_spectrum"][0, 1], [7.0, np.nan, 8.0, np.nan])


def test_other_tools_find_names_axes_and_units(kept):
    with h5py.File(kept) as file:
        place = file
        while "default" in place.attrs:  # the chain that viewers follow
            place = place[place.attrs["default"]]
        signal = place[place.attrs["signal"]]
        assert (place.attrs["NX_class"], signal.attrs["units"]) == ("NXdata", "Pa")
        assert (signal.compression, signal.compression_opts, signal.shuffle, signal.fletcher32) == (
            "gzip",
            1,
            False,
            False,
        )
        heights = file["heights"]  # noise, which gzip hardly makes smaller
        assert (heights.compression, heights.fletcher32) == (None, False)
        assert list(place.attrs["axes"]) == ["x", "y"]
        for axis, (name, length, points) in enumerate((("x", 2.0, 24), ("y", 1.5, 20))):
            scale = signal.dims[axis][0]
            assert scale.attrs["units"] == "m"
            np.testing.assert_allclose(scale[()], np.arange(points) * length / points)
            assert scale.name.endswith(name)


def test_pressures_are_not_shuffled_as_that_doubles_them(tmp_path):
    # a shuffle gathers the noisy bytes of the few points in contact, among zeros that gzip packs as they are
    pressure = np.zeros((64, 64), np.float32)
    spots = np.random.default_rng(2).integers(0, 56, (8, 2))
    for x, y in spots:
        pressure[x : x + 5, y : y + 5] = np.random.default_rng(x).random((5, 5))
    sizes = []
    for name in ("pressure", "other"):
        with h5py.File(tmp_path / f"{name}.h5", "w") as file:
            write_arrays(file, [(name, (), pressure, {})])
            np.testing.assert_array_equal(file[name][()], pressure)
            sizes.append(file[name].id.get_storage_size())
    assert sizes[0] < 0.8 * sizes[1]


def test_a_field_that_is_not_there_is_refused_by_name(kept):
    with forged(kept) as file:
        file.attrs["header"] = json.dumps(json.loads(file.attrs["header"]) | {"fields": []})
    with pytest.raises(rs.RecordError, match=r"L1-000042.h5 is damaged \(it has no pressure\)"):
        read_fields(kept, ("pressure",))
    kept.unlink()
    with pytest.raises(FileNotFoundError, match=r"L1-000042.h5 is lost; repeat the command"):
        read_fields(kept, ("pressure",))


@pytest.mark.parametrize(
    "changes",
    [
        {"level": 2},
        {"level": "one"},
        {"numbers": []},
        {"numbers": ["speed"]},
        {"numbers": ["flash_temperature"]},
        {"numbers": 5},
        {"speeds": [0.0, 0.5]},
        {"speeds": ["fast", 0.5, 1.0]},
        {"curves": ["slide_background"]},
        {"bins": True},
        {"lengths": [1.0]},
        {"provenance": []},
    ],
    ids=str,
)
def test_a_header_that_no_writer_makes_is_refused(path, changes):
    with level_of(path) as level:
        level.update(changes)
    with pytest.raises(rs.RecordError, match="L1-000042.h5 is damaged"):
        read_part(path)


@pytest.mark.parametrize(
    "about",
    [{"failure": 7}, {"provenance": []}, {"kept": 5}, {"kept": {"pressure": ["x"]}}],
    ids=str,
)
def test_data_of_a_member_that_no_writer_makes_are_refused(path, about):
    with forged(path) as file:
        stored = json.loads(file["L1/about"][0]) | about
        del file["L1/about"]
        file["L1"].create_dataset("about", data=[json.dumps(stored).encode()], chunks=(1,))
    with pytest.raises(rs.RecordError, match="L1-000042.h5 is damaged"):
        read_part(path)


@pytest.mark.parametrize("changes", [{"level": 2}, {"index": 43}, {"fields": ["film_pressure"]}])
def test_a_header_of_other_fields_is_refused(kept, changes):
    with_header(kept, **changes)
    with pytest.raises(rs.RecordError, match="L1-000042.h5 is damaged"):
        read_fields(kept)


def test_what_another_package_has_stored_is_kept_where_it_is_not_installed(path, kept):
    with level_of(path) as level:
        level.update(numbers=["flash_temperature", "gap"], curves=["wear"])
    with_header(kept, fields=["displacement", "pressure"])
    (back,) = read_part(path).members
    assert list(back.numbers) == ["flash_temperature", "gap"]
    assert back.curves == {}
    assert list(read_fields(kept)[1]) == ["pressure"]
    write_part(path, OF_RUN, [back])
    np.testing.assert_array_equal(read_part(path).members[0].numbers["gap"], back.numbers["gap"])


def test_text_that_is_no_header_is_refused(path):
    for text in ("", "{", "[]", "5", "[" * 100_000, 5, [1.0, 2.0], ["{}", "{}"], np.void(b"{}")):
        with forged(path) as file:
            file.attrs["header"] = text
        with pytest.raises(rs.RecordError, match="L1-000042.h5 is damaged"):
            read_part(path)


@pytest.mark.parametrize("name", ["numbers", "wavenumber", "stress_spectrum", "about"])
def test_a_file_without_an_array_that_its_header_names_is_damaged(path, name):
    with forged(path) as file:
        del file[f"L1/{name}"]
    with pytest.raises(rs.RecordError, match="L1-000042.h5 is damaged"):
        read_part(path)


def test_fields_without_an_array_that_their_header_names_are_damaged(kept):
    with forged(kept) as file:
        del file["pressure"]
    with pytest.raises(rs.RecordError, match="L1-000042.h5 is damaged"):
        read_fields(kept)


def test_a_newer_format_is_refused(path):
    with_header(path, format_version=99)
    with pytest.raises(
        rs.RecordError, match=r"format version 99; this roughsim reads 8: update it"
    ):
        read_part(path)


@pytest.mark.parametrize(("version", "words"), [("0.9.1", r" \(0\.9\.1\)$"), (None, "$")])
def test_an_older_format_is_refused_in_one_sentence(path, version, words):
    versions = {"roughsim": version} if version else "unknown"
    with_header(path, format_version=4, versions=versions)
    said = "has the older format 4, and this roughsim reads 8; read or export it with the roughsim that wrote it"
    with pytest.raises(rs.RecordError, match=said + words):
        read_part(path)


def test_a_missing_folder_is_an_error_that_names_the_path_and_leaves_nothing(tmp_path):
    with pytest.raises(OSError, match="cannot write .*L1-000042.h5"):
        write_part(member_path(tmp_path / "none", 1, 42), OF_RUN, [member()])
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_is_no_run_is_refused(tmp_path):
    with pytest.raises(rs.RecordError, match="is no run: it has no run.json"):
        rs.open_run(tmp_path)
    with pytest.raises(rs.RecordError, match="does not exist; start it with"):
        rs.open_run(tmp_path / "none")
    (tmp_path / "run.json").write_text("{")
    with pytest.raises(rs.RecordError, match="run.json is damaged"):
        rs.open_run(tmp_path)
    for version, words in (
        (99, "format version 99"),
        (4, r"older format 4, and .* reads 8; .* wrote it \(1.2\)"),
    ):
        (tmp_path / "run.json").write_text(
            json.dumps({"format_version": version, "versions": {"roughsim": "1.2"}})
        )
        with pytest.raises(rs.RecordError, match=words):
            rs.open_run(tmp_path)
