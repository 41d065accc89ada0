"""Members without HDF5: copies of a file of their kind, to the bit what HDF5 writes, and read from their places."""

import hashlib
import io
import json
from dataclasses import replace

import h5py
import numpy as np
import pytest
from damage_cases import member, without_seal

import roughsim as rs
from roughsim.store import member_hdf5
from roughsim.store.member_files import Member, member_path, read_member, write_member


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "realizations").mkdir()
    return tmp_path


def sealed(path, content):
    """Write bytes with a seal that is sound."""
    content += f"\nroughsim {path.name} sha256 ".encode()
    path.write_bytes(content + hashlib.sha256(content).hexdigest().encode() + b"\n")


def with_places(path, **changes):
    """Give the file of a member other places; None leaves one out."""
    content = path.read_bytes()
    data, line = without_seal(content), content[len(without_seal(content)) :].splitlines()[1]
    places = json.loads(line.removeprefix(b"roughsim places ")) | changes
    places = {name: place for name, place in places.items() if place is not None}
    sealed(path, data + b"\nroughsim places " + json.dumps(places).encode())


@pytest.mark.parametrize("seed", range(4))
def test_a_copy_has_the_bytes_that_hdf5_writes(seed):
    rng = np.random.default_rng(seed)
    numbers = [rng.random(3), np.array(rng.random()), 1e300 * rng.standard_normal(40), np.zeros(40)]
    names = ("speed", "contact_fraction", "wavenumber", "stress_spectrum")
    arrays = dict(zip(names, numbers, strict=True))
    header = {"text": "x" * int(rng.integers(5000))}
    content, places = member_hdf5.hdf5_of(header, arrays, {})
    for name, values in arrays.items():
        start, count = places[name]
        np.testing.assert_array_equal(np.frombuffer(content[start : start + count]), np.ravel(values))
    with h5py.File(io.BytesIO(content)) as file:
        text, digest = file.attrs["header"], file.attrs["sha256"]
        for name, values in arrays.items():
            np.testing.assert_array_equal(file[name][()], values)  # HDF5 checks the checksum behind each array
    assert json.loads(text) == header
    assert digest == hashlib.sha256(text.encode() + b"".join(values.tobytes() for values in numbers[1:])).hexdigest()
    assert content == member_hdf5._made(text, digest, arrays)[0]


@pytest.mark.parametrize("words", [[0], [0xFFFF], [0xFFFE, 1], [1, 0xFFFE], [0xFFFF] * 1000, [0, 0, 7], range(721)])
def test_the_checksum_is_that_of_hdf5(words):
    data = np.array(words, ">u2")
    file = h5py.File(io.BytesIO(), "w")
    dataset = file.create_dataset("data", data=data, chunks=data.shape, fletcher32=True)
    _, stored = dataset.id.read_direct_chunk((0,))
    assert member_hdf5.fletcher32(data.tobytes()) == int.from_bytes(stored[-4:], "little")


def test_all_kinds_of_members_are_read_without_hdf5_as_hdf5_reads_them(folder, monkeypatch):
    one = member(fields=False)
    kinds = [
        member(),
        one,
        replace(one, index=43, provenance={"text": "ünïcode " * 200}),
        replace(one, index=44, spectrum=np.zeros(8), numbers={name: 0.0 * x for name, x in one.numbers.items()}),
        replace(one, index=45, speeds=(1.0,), numbers={"peak_volume": np.array([-0.5])}),
        Member(1, 46, failure="stalled", provenance={"residual": 1.0}),
    ]
    for kind in kinds:
        path = member_path(folder, 1, kind.index)
        write_member(folder, kind)
        with h5py.File(path) as file:
            by_hdf5 = {name: np.ravel(file[name][()]) for name in file if isinstance(file[name], h5py.Dataset)}
        with monkeypatch.context() as closed:
            closed.setattr(h5py, "File", lambda *_, **__: pytest.fail("HDF5 is not needed"))
            back = read_member(path)
        for name, values in kind.numbers.items():
            np.testing.assert_array_equal(back.numbers[name], values)
            np.testing.assert_array_equal(by_hdf5[name], values)
        np.testing.assert_array_equal(back.spectrum, kind.spectrum)
        np.testing.assert_array_equal(back.wavenumber, kind.wavenumber)
        assert (back.index, back.failure, back.provenance) == (kind.index, kind.failure, kind.provenance)
        assert (back.speeds, back.lengths, back.kept) == (kind.speeds, kind.lengths, tuple(kind.fields))
        assert back.digest == path.read_bytes().split()[-1].decode()


@pytest.mark.parametrize("fields", [False, True])
@pytest.mark.parametrize("length", [200, 1 << 20, 2 << 20])
def test_members_with_long_headers_are_written_and_read(folder, fields, length):
    one = replace(member(fields=fields), provenance={"text": "x" * length})
    write_member(folder, one)
    path = member_path(folder, 1, 42)
    back = read_member(path, with_fields=True)
    assert back.provenance == one.provenance
    for name, values in {**one.fields, **one.numbers}.items():
        np.testing.assert_array_equal({**back.fields, **back.numbers}[name], values)
    with h5py.File(path) as file:
        assert json.loads(file.attrs["header"])["provenance"] == one.provenance
        if fields:  # heights in one piece, the pressure in chunks that HDF5 guards
            assert file["heights"].chunks is None
            assert (file["pressure"].compression, file["pressure"].fletcher32) == ("gzip", True)


def test_a_digest_behind_many_numbers_is_found(folder):
    many = 200_000
    one = replace(member(fields=True), wavenumber=np.arange(1.0, many + 1.0), spectrum=np.ones(many))
    write_member(folder, one)
    np.testing.assert_array_equal(read_member(member_path(folder, 1, 42), with_fields=True).spectrum, one.spectrum)


def test_a_sealed_file_without_places_is_read_by_hdf5(folder):
    write_member(folder, member())
    path = member_path(folder, 1, 42)
    before = read_member(path)
    sealed(path, without_seal(path.read_bytes()))
    back = read_member(path)
    for name, values in before.numbers.items():
        np.testing.assert_array_equal(back.numbers[name], values)
    np.testing.assert_array_equal(back.spectrum, before.spectrum)


@pytest.mark.parametrize(
    "changes",
    [
        {"flash_temperature": [10**9, 24]},
        {"flash_temperature": [-24, 24]},
        {"flash_temperature": [0, 16]},
        {"flash_temperature": [0, 10**30]},
        {"flash_temperature": ["0", "24"]},
        {"flash_temperature": None},
        {"flash_temperature": 7},
        {"wavenumber": None},
        {"stress_spectrum": [0]},
        {"header": [0, 8]},
        {"header": [10**9, 8]},
        {"header": None},
        {"format_version": None},
        {"format_version": "three"},
    ],
)
def test_places_that_no_writer_makes_are_refused_by_name(folder, changes):
    write_member(folder, member())
    path = member_path(folder, 1, 42)
    with_places(path, **changes)
    with pytest.raises(rs.RecordError, match="L1-000042.h5 is damaged"):
        read_member(path)


def test_a_newer_format_is_refused_by_the_line_of_places_too(folder):
    write_member(folder, member())
    path = member_path(folder, 1, 42)
    with_places(path, format_version=99)
    with pytest.raises(rs.RecordError, match="format version 99; this roughsim reads up to"):
        read_member(path)


@pytest.mark.parametrize(
    ("key", "value", "places"),
    [
        ("numbers", [["flash_temperature", [1]], ["contact_fraction", [1]]], {"flash_temperature": [2000, 8]}),
        ("failure", "stalled", {}),
        ("provenance", [], {}),
    ],
)
def test_a_header_that_no_writer_makes_is_refused_by_what_it_has(folder, key, value, places):
    write_member(folder, member())
    path = member_path(folder, 1, 42)
    content = bytearray(path.read_bytes())
    line = content[len(without_seal(content)) :].splitlines()[1]
    start, count = json.loads(line.removeprefix(b"roughsim places "))["header"]
    header = json.dumps(json.loads(content[start : start + count]) | {key: value}).encode()
    content[start : start + count] = header.ljust(count)
    path.write_bytes(content)
    with_places(path, **places)
    with pytest.raises(rs.RecordError, match=f"its header has {key} that no writer of this format makes"):
        read_member(path)


def test_a_number_that_was_changed_in_a_file_without_a_seal_is_damage(folder):
    write_member(folder, member())
    path = member_path(folder, 1, 42)
    with h5py.File(path, "r+") as file:  # the library leaves the seal out, and mends the checksum of the array
        file["flash_temperature"][0] *= 1.001
    with pytest.raises(rs.RecordError, match="its SHA-256 does not match"):
        read_member(path)
