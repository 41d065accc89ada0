"""Many members: a summary beside them spares time and decides nothing; what is missing or unreadable is named."""

import builtins
import errno
import os
import shutil
from dataclasses import replace

import numpy as np
import pytest
from damage_cases import PASSING, without_seal
from summary_cases import COUNT, bits

import roughsim as rs
from roughsim.estimate import errors
from roughsim.estimate.errors import relative_half_width
from roughsim.estimate.ladder import values_of
from roughsim.results import members, reader
from roughsim.results.members import SUMMARY, Members
from roughsim.store import member_files
from roughsim.store.member_files import check_member, member_path, read_member, write_member


@pytest.fixture
def eager(monkeypatch):
    """A summary for so few members, too, and all files opened are noted."""
    monkeypatch.setattr(reader, "LEAST_NEW", 1)
    opened, true = [], reader.member_of
    monkeypatch.setattr(reader, "member_of", lambda path, content: opened.append(path.name) or true(path, content))
    return opened


def empty_members(run, speeds):
    """A table without members for as many speeds."""
    lengths = [run.numerics.lengths] * len(run.numerics.levels)
    return Members([level.every for level in run.numerics.levels], lengths, speeds)


def test_a_run_is_read_from_its_summary_to_the_last_bit_and_each_member_once(folder, whole, eager, monkeypatch):
    before = bits(whole)
    assert bits(rs.open_run(folder)) == before
    assert len(eager) == len(set(eager)) == COUNT + 5
    eager.clear()
    monkeypatch.setattr(member_files, "read_member", lambda path: pytest.fail("a spectrum needs no whole file"))
    run = rs.open_run(folder)
    assert bits(run) == before
    assert eager == []
    for key, member in whole.members.items():
        other = run.members[key]
        assert (other.provenance, other.kept) == (member.provenance, member.kept)


def test_a_run_that_ends_leaves_a_summary_of_few_members_too(whole, eager, tmp_path, monkeypatch):
    monkeypatch.setattr(reader, "LEAST_NEW", 1000)
    run = rs.run(whole.scene, tmp_path / "run", numerics=whole.numerics, max_realizations=2)
    assert not (run.folder / SUMMARY).exists()  # three are read in no time
    monkeypatch.setattr(reader, "LEAST_AT_END", 4)
    run = rs.run(whole.scene, tmp_path / "run", numerics=whole.numerics, max_realizations=3)
    assert (run.folder / SUMMARY).exists()
    eager.clear()
    assert bits(rs.open_run(run.folder)) == bits(run)
    assert eager == []


def test_a_member_that_came_or_changed_since_is_read_and_wins(folder, whole, eager):
    rs.open_run(folder)
    eager.clear()
    one = read_member(member_path(folder, 0, 3))
    numbers = {name: 2.0 * values for name, values in one.numbers.items()}
    write_member(folder, replace(one, numbers=numbers, spectrum=3.0 * one.spectrum))
    (found,) = (sample for sample in rs.open_run(folder).samples() if sample.q_max < 3e4)
    assert eager == ["L0-000003.h5"]
    (true,) = (sample for sample in whole.samples() if sample.q_max < 3e4)
    expected = true.numbers["flash_temperature"] * np.where(np.arange(COUNT) == 3, 2.0, 1.0)[:, None]
    np.testing.assert_array_equal(found.numbers["flash_temperature"], expected)
    np.testing.assert_array_equal(found.spectrum, true.spectrum * np.where(np.arange(COUNT) == 3, 3.0, 1.0)[:, None])


def test_a_member_damaged_after_the_summary_is_named(folder, eager):
    rs.open_run(folder)
    path = member_path(folder, 1, 4)
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    with pytest.raises(rs.RecordError, match="L1-000004.h5 is damaged"):
        rs.open_run(folder)


def test_a_member_of_the_same_size_and_time_but_another_digest_is_read(folder, eager):
    rs.open_run(folder)
    path = member_path(folder, 0, 3)
    one, before = read_member(path), path.stat()
    write_member(folder, replace(one, spectrum=3.0 * one.spectrum))
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
    assert path.stat().st_size == before.st_size
    eager.clear()
    rs.open_run(folder)
    assert eager == ["L0-000003.h5"]


def test_copied_members_keep_their_summary(folder, tmp_path, eager):
    rs.open_run(folder)
    eager.clear()
    copy = shutil.copytree(folder, tmp_path / "copy", copy_function=shutil.copy)  # with other times
    assert rs.open_run(copy).realizations == COUNT
    watched = rs.open_run(copy, damaged="skip")
    watched.refresh()  # the times of the copies are no change
    assert watched.realizations == COUNT
    assert eager == []


def spoiled(kind, folder, whole, tmp_path):
    """The bytes of a summary that is not the one of this folder as it is."""
    sound = (folder / SUMMARY).read_bytes()
    if kind == "of another run":
        scene = replace(whole.scene, ensemble=replace(whole.scene.ensemble, seed=8))
        other = rs.run(scene, tmp_path / "other", numerics=whole.numerics, max_realizations=COUNT)
        rs.open_run(other.folder)
        return (other.folder / SUMMARY).read_bytes()
    return {"empty": b"", "cut": sound[: len(sound) // 2], "longer": sound + b"\0", "text": b"hello"}[kind]


@pytest.mark.parametrize(
    "kind", ["empty", "cut", "longer", "text", pytest.param("of another run", marks=pytest.mark.slow)]
)
def test_a_summary_that_is_none_is_made_anew(folder, whole, tmp_path, eager, kind):
    before = bits(rs.open_run(folder))
    sound = (folder / SUMMARY).read_bytes()
    (folder / SUMMARY).write_bytes(spoiled(kind, folder, whole, tmp_path))
    eager.clear()
    assert bits(rs.open_run(folder)) == before
    assert len(eager) == COUNT + 5
    assert (folder / SUMMARY).read_bytes() == sound


@pytest.mark.slow
def test_members_of_another_run_with_their_own_summary_are_refused(folder, whole, tmp_path, eager):
    scene = replace(whole.scene, ensemble=replace(whole.scene.ensemble, seed=8))
    other = rs.run(scene, tmp_path / "other", numerics=whole.numerics, max_realizations=COUNT)
    shutil.copytree(other.folder / "realizations", folder / "realizations", dirs_exist_ok=True)
    shutil.copy(other.folder / SUMMARY, folder)
    with pytest.raises(rs.RecordError, match="L0-000000.h5 is of another run"):
        rs.open_run(folder)


def test_no_flipped_byte_of_a_summary_is_believed(folder, eager):
    rs.open_run(folder)
    path = folder / SUMMARY
    sound = path.read_bytes()
    run = rs.open_run(folder)

    def read():
        table = empty_members(run, run.scene.speeds)
        table.load(folder / SUMMARY, run._reader.identity)
        return any(rows.size for rows in table.tables)

    assert read()
    for place in np.linspace(0, len(sound) - 1, 60, dtype=int):
        broken = bytearray(sound)
        broken[place] ^= 1 << (place % 8)
        path.write_bytes(broken)
        assert not read()
    path.unlink()
    path.mkdir()
    assert not read()
    assert rs.open_run(folder).realizations == COUNT  # and it cannot be written either


def test_a_summary_of_another_layout_is_as_none(folder, whole, eager):
    run = rs.open_run(folder)
    other = empty_members(run, run.scene.speeds * 2)
    for key, member in run.members.items():
        numbers = {name: values.repeat(2 if len(values) > 1 else 1) for name, values in member.numbers.items()}
        other.put(key, replace(member, numbers=numbers), size=1)
    other.save(folder / SUMMARY, run._reader.identity, {"count": 3})
    assert empty_members(run, run.scene.speeds * 2).load(folder / SUMMARY, run._reader.identity) == {"count": 3}
    eager.clear()
    assert bits(rs.open_run(folder)) == bits(whole)
    assert len(eager) == COUNT + 5


def test_a_folder_that_takes_no_files_is_read_all_the_same(folder, whole, eager, monkeypatch):
    def refuse(*_, **__):
        raise PermissionError(errno.EROFS, "Read-only file system")

    monkeypatch.setattr(members, "place_bytes", refuse)
    assert bits(rs.open_run(folder)) == bits(whole)
    assert not (folder / SUMMARY).exists()


def test_what_did_not_suffice_is_not_tried_again_unless_targets_members_or_code_change(folder, eager, monkeypatch):
    from roughsim.results import stopping as module

    monkeypatch.setattr(errors, "LEAST", 2)
    tried, true = [], module.relative_half_width
    monkeypatch.setattr(module, "relative_half_width", lambda values: tried.append(len(values.base)) or true(values))

    def counts(goal):
        tried.clear()
        run = rs.open_run(folder)
        run.until = {"flash_temperature": goal}
        assert run.realizations == COUNT
        return list(tried)

    assert counts(1e-6) == list(range(2, COUNT + 1))
    assert counts(1e-6) == []
    assert counts(2e-6) == list(range(2, COUNT + 1))
    assert counts(2e-6) == []
    one = read_member(member_path(folder, 0, 1))
    write_member(folder, replace(one, provenance=one.provenance | {"written": "2026-01-01T00:00:00Z"}))
    assert counts(2e-6) == list(range(2, COUNT + 1))
    monkeypatch.setattr(reader, "code_digest", lambda: "other code")
    assert counts(2e-6) == list(range(2, COUNT + 1))


def test_a_run_stops_where_prefixes_that_are_tried_afresh_say(folder, monkeypatch):
    monkeypatch.setattr(errors, "LEAST", 2)
    run = rs.open_run(folder)
    observable = "correlation_radius_50"  # of the spectra
    width = {
        count: relative_half_width(
            values_of(run.scene, run.column(None), observable, run.samples(None, list(range(count))))
        )
        for count in range(2, COUNT + 1)
    }
    for goal in sorted(width.values())[1:-1]:
        again = rs.open_run(folder)
        again.until = {observable: goal}
        first = next(count for count in width if width[count] <= goal)
        assert again.realizations == first
        again.refresh()
        assert again.realizations == first
        assert again.target_met


@pytest.mark.slow
def test_a_long_run_stops_at_the_first_look_that_meets_the_target_as_it_grows_and_when_it_is_opened(quick, tmp_path):
    count = 300
    run = rs.run(quick, tmp_path / "run", max_realizations=1)
    one, rng = read_member(member_path(run.folder, 0, 0)), np.random.default_rng(2)
    rows = 10.0 + rng.standard_normal((count, 3)) * [0.0, 0.6, 0.2]
    for index, row in enumerate(rows):
        write_member(run.folder, replace(one, index=index, numbers=one.numbers | {"flash_temperature": row}))
    run = rs.open_run(run.folder)
    run.max_realizations = count
    run.refresh()
    (sample,) = run.samples(None, list(range(count)))
    width = {
        n: relative_half_width(values_of(run.scene, "capped", "flash_temperature", [sample.first(n)]))
        for n in range(12, count)
    }
    # the least width so far, at a number at which no run looks: it stops at a later one
    goal = next(width[n] for n in range(257, count, 2) if width[n] < min(width[m] for m in range(12, n)))
    stop = next(n for n in range(258, count, 2) if width[n] <= goal)
    growing = rs.open_run(run.folder)
    growing.until = {"flash_temperature": goal}
    for growing.max_realizations in range(1, count):
        growing.refresh()
        if growing.target_met:
            break
    opened = rs.open_run(run.folder)
    opened.until, opened.max_realizations = {"flash_temperature": goal}, count
    opened.refresh()
    for result in (growing, opened):
        assert result.target_met
        assert result.realizations == stop


@pytest.mark.slow
def test_old_runs_have_a_summary_too(folder, whole, eager):
    for path in (folder / "realizations").iterdir():
        path.write_bytes(without_seal(path.read_bytes()))
    assert bits(rs.open_run(folder)) == bits(whole)
    eager.clear()
    assert bits(rs.open_run(folder)) == bits(whole)
    assert eager == []
    path = member_path(folder, 0, 5)
    content = bytearray(path.read_bytes())
    content[len(content) // 2 :] = bytes(len(content) - len(content) // 2)
    path.write_bytes(content)
    with pytest.raises(rs.RecordError, match="L0-000005.h5 is damaged"):
        rs.open_run(folder)


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
    assert rs.open_run(folder).realizations == COUNT


def test_members_that_did_not_converge_stand_in_the_summary_too(folder, eager):
    for level, index in ((0, 3), *((1, index) for index in range(0, COUNT, 2))):
        one = read_member(member_path(folder, level, index))
        empty = {"numbers": {}, "wavenumber": np.empty(0), "spectrum": np.empty(0)}
        write_member(folder, replace(one, failure=f"stalled at {index}", **empty))
    for _ in range(2):
        run = rs.open_run(folder)
        assert (run.realizations, run.failed, run.sound(COUNT)) == (COUNT, 6, [1, 5, 7])
        assert run.members[0, 3].failure == "stalled at 3"
        assert run.members[1, 8].numbers == {}
    assert len(eager) == COUNT + 5


@pytest.mark.parametrize("name", ["heights", "pressure"])
def test_a_flipped_bit_in_a_kept_field_is_found_and_mended(folder, whole, name):
    path = member_path(folder, 0, 0)
    import h5py

    with h5py.File(path) as file:
        field = file[name].id
        chunk = field.get_chunk_info(0) if file[name].chunks else None
        start, size = (chunk.byte_offset, chunk.size) if chunk else (field.get_offset(), field.get_storage_size())
    content = bytearray(path.read_bytes())
    content[start + size // 2] ^= 1
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
