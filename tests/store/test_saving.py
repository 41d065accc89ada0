"""Saving members in parts, and putting them into one file: whatever ends a process, no member on disk is lost."""

import os
from contextlib import suppress
from multiprocessing import get_context
from pathlib import Path
from threading import Barrier, BrokenBarrierError, Thread

import numpy as np
import pytest
from damage_cases import member
from some_rows import some
from stored_cases import OF_RUN, members_of

from roughsim.store import saving
from roughsim.store.disk import place_bytes
from roughsim.store.parts import Part, read_part, write_part
from roughsim.store.saving import Saver, listed, merge, part_path


class KilledError(BaseException):
    """The end of a process, which runs no code of its own afterwards."""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "members").mkdir()
    return tmp_path


def bare(*indices):
    return [member(index, fields=False) for index in indices]


def saved(folder, owner, *indices):
    saver = Saver(folder, owner, OF_RUN)
    for one in bare(*indices):
        saver.add(one)
    saver.save()
    return saver


def all_of(folder):
    """Reads all members as a process that merges does."""
    return lambda: Part(OF_RUN, [*members_of(folder).values()])


def indices(folder):
    return sorted(index for _, index in members_of(folder))


def names(folder):
    return sorted(path.name for path in listed(folder))


def test_a_process_fills_its_last_part_and_leaves_full_ones_alone(folder, monkeypatch):
    monkeypatch.setattr(saving, "MOST", 4)
    saver = saved(folder, "here-1-ab", *range(3))
    assert names(folder) == ["here-1-ab-000.h5"]
    for index in range(3, 10):
        saver.add(member(index, fields=False))
    before = part_path(folder, "here-1-ab", 0).stat().st_mtime_ns
    saver.save()
    full = part_path(folder, "here-1-ab", 0)
    assert full.stat().st_mtime_ns > before
    assert [len(read_part(path).members) for path in listed(folder)] == [4, 4, 2]
    before = full.stat().st_mtime_ns
    saver.save()  # nothing is new
    saver.add(member(10, fields=False))
    saver.save()
    assert full.stat().st_mtime_ns == before
    assert indices(folder) == [*range(11)]
    for (_, index), one in members_of(folder).items():
        np.testing.assert_array_equal(
            one.moments[0].spectrum, member(index, fields=False).moments[0].spectrum
        )


def test_fields_are_on_disk_before_the_part_that_names_them(folder, monkeypatch):
    saver, written = Saver(folder, "here-1-ab", OF_RUN), []
    genuine = place_bytes

    def place(path, *content, **options):
        written.append(path.name)
        genuine(path, *content, **options)

    monkeypatch.setattr("roughsim.store.member_files.place_bytes", place)
    kept = saver.add(member(7))
    saver.save()
    assert written == ["L1-000007.h5", "here-1-ab-000.h5"]
    assert (kept.fields, kept.kept) == ({}, {"heights": (24, 20), "pressure": (24, 20)})


def test_a_save_that_the_disk_refuses_keeps_the_members_for_the_next_one(folder, monkeypatch):
    saver = saved(folder, "here-1-ab", 0, 1)
    saver.add(member(2, fields=False))

    def full(*_):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr(os, "fsync", full)
        with pytest.raises(OSError, match="cannot write .*-000.h5"):
            saver.save()
    assert indices(folder) == [0, 1]
    saver.save()
    assert indices(folder) == [0, 1, 2]


def test_one_part_is_renamed_and_several_become_one_file(folder):
    saved(folder, "here-1-ab", 0, 1)
    content = part_path(folder, "here-1-ab", 0).read_bytes()
    merge(folder, "here-1-ab", all_of(folder))
    assert names(folder) == ["members.h5"]
    assert (folder / "members.h5").read_bytes() == content
    merge(folder, "here-2-cd", all_of(folder))  # nothing to do
    assert (folder / "members.h5").read_bytes() == content
    saved(folder, "here-2-cd", 2, 3)
    saved(folder, "there-1-ab", 1, 4)
    merge(folder, "here-2-cd", all_of(folder))
    assert names(folder) == ["members.h5"]
    assert indices(folder) == [0, 1, 2, 3, 4]
    assert list((folder / "members").iterdir()) == []


@pytest.mark.parametrize("parts", [1, 3])
def test_without_hard_links_the_one_file_stays_a_part_and_replaces_none(folder, monkeypatch, parts):
    def refuse(*_):
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr(os, "link", refuse)
    for index in range(parts):
        saved(folder, f"here-{index}-ab", index)
    for owner in ("here-0-ab", "there-1-ab", "there-2-cd"):
        merge(folder, owner, all_of(folder))
        assert len(names(folder)) == 1
        assert indices(folder) == [*range(parts)]


CALLS = ("rename", "link", "unlink", "fsync")


@pytest.mark.parametrize("late", some([False, True], 2))
@pytest.mark.parametrize("whole", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_a_kill_at_any_step_of_merging_loses_no_member(folder, monkeypatch, whole, late):
    steps = 0
    while True:
        for path in listed(folder):
            path.unlink()
        saved(folder, "here-1-ab", 0, 1)
        if whole:
            merge(folder, "here-1-ab", all_of(folder))
        saved(folder, "there-2-cd", 2)
        saved(folder, "away-3-ef", 3)
        left = [steps]
        with monkeypatch.context() as patched:
            for name in CALLS:
                genuine = getattr(os, name)

                def step(*arguments, genuine=genuine, left=left, **options):
                    if left[0] == 0 and not late:
                        raise KilledError
                    result = genuine(*arguments, **options)
                    if left[0] == 0:
                        raise KilledError
                    left[0] -= 1
                    return result

                patched.setattr(os, name, step)
            try:
                merge(folder, "here-4-ab", all_of(folder))
                ended = True
            except KilledError:
                ended = False
        assert indices(folder) == [0, 1, 2, 3]
        if ended:
            break
        merge(folder, "here-5-ab", all_of(folder))
        assert names(folder) == ["members.h5"]
        assert indices(folder) == [0, 1, 2, 3]
        steps += 1
    assert steps > 5


def test_two_processes_that_merge_at_once_lose_no_member(folder, monkeypatch):
    # the other one merges at each step of this one
    genuine, count = os.rename, 0
    for other_at in range(8):
        for path in listed(folder):
            path.unlink()
        saved(folder, "here-1-ab", 0, 1)
        merge(folder, "here-1-ab", all_of(folder))
        for index, owner in enumerate(("a-2-cd", "b-3-ef", "c-4-ab")):
            saved(folder, owner, 2 + index)
        steps = 0

        def rename(source, target, other_at=other_at):
            nonlocal steps
            steps += 1
            if steps == other_at + 1:
                merge(folder, "other-9-ab", all_of(folder))
            genuine(source, target)

        with monkeypatch.context() as patched:
            patched.setattr(os, "rename", rename)
            merge(folder, "here-1-ab", all_of(folder))
        count += steps > other_at
        assert indices(folder) == [*range(5)]
        merge(folder, "here-1-ab", all_of(folder))
        assert names(folder) == ["members.h5"]
    assert count > 2


def test_a_process_that_slept_saves_its_last_part_again(folder):
    sleeper = saved(folder, "here-1-ab", 0, 1)
    saved(folder, "there-2-cd", 2)
    merge(folder, "there-2-cd", all_of(folder))
    sleeper.add(member(3, fields=False))
    sleeper.save()
    assert names(folder) == ["here-1-ab-000.h5", "members.h5"]
    assert indices(folder) == [0, 1, 2, 3]


def test_a_process_whose_files_others_take_again_and_again_waits_at_random_and_ends(
    folder, monkeypatch
):
    for index, owner in enumerate(("a-2-cd", "b-3-ef")):
        saved(folder, owner, index)
    genuine, pauses = os.rename, []

    def taken(source, target):
        if len(pauses) < 6:
            raise FileNotFoundError(source)
        genuine(source, target)

    monkeypatch.setattr(os, "rename", taken)
    monkeypatch.setattr(saving.time, "sleep", pauses.append)
    monkeypatch.setattr(saving.random, "uniform", lambda least, most: (least, most))
    merge(folder, "here-1-ab", all_of(folder))
    assert pauses == [(0.0, 0.02 * 2**tried) for tried in range(6)]
    assert names(folder) == ["members.h5"]
    assert indices(folder) == [0, 1]


def test_processes_that_take_files_of_each_other_while_they_write_for_long_write_few_times(
    folder, monkeypatch
):
    genuine, together, written = write_part, Barrier(2), []

    def slow(path, run, members):
        written.append(path)
        with suppress(BrokenBarrierError):  # the other one has ended
            together.wait()
        genuine(path, run, members)

    def merged(owner):
        merge(folder, owner, all_of(folder))
        together.abort()

    for index, owner in enumerate(("a-2-cd", "b-3-ef")):
        saved(folder, owner, index)
    monkeypatch.setattr(saving, "write_part", slow)
    threads = [Thread(target=merged, args=(owner,)) for owner in ("a-2-cd", "b-3-ef")]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert names(folder) == ["members.h5"]
    assert indices(folder) == [0, 1]
    assert len(written) <= 3


def save_and_merge(folder, index, together):
    owner = f"here-{index}-ab"
    saved(folder, owner, index)
    together.wait()
    merge(folder, owner, all_of(folder))


@pytest.mark.slow
@pytest.mark.filterwarnings(
    "ignore:.*multi-threaded:DeprecationWarning"
)  # fork: its threads have ended
def test_processes_that_leave_at_one_moment_leave_one_file(tmp_path):
    context = get_context("fork")
    for turn in range(30):  # with three tries, without a pause, one in seven left parts
        folder = tmp_path / f"run-{turn}"
        (folder / "members").mkdir(parents=True)
        together = context.Barrier(3)
        processes = [
            context.Process(target=save_and_merge, args=(folder, index, together))
            for index in range(3)
        ]
        for process in processes:
            process.start()
        for process in processes:
            process.join()
        assert [process.exitcode for process in processes] == [0, 0, 0]
        assert names(folder) == ["members.h5"]
        assert indices(folder) == [0, 1, 2]


def test_a_part_that_grows_while_another_process_merges_stays(folder):
    sleeper = saved(folder, "here-1-ab", 0, 1)
    saved(folder, "there-2-cd", 2)

    def read():
        sleeper.add(member(3, fields=False))
        sleeper.save()
        own = [path for path in listed(folder) if path.name.startswith("there-2-cd")]
        return Part(OF_RUN, [one for path in own for one in read_part(path).members])

    merge(folder, "there-2-cd", read)
    assert indices(folder) == [0, 1, 2, 3]


def test_readers_see_each_member_at_every_moment_of_a_move(folder, monkeypatch):
    saved(folder, "here-1-ab", 0, 1)
    part, whole = part_path(folder, "here-1-ab", 0), folder / "members.h5"
    genuine, calls = saving._stamps, []

    def stamps(home):
        found = genuine(home)
        calls.append(found)
        if len(calls) == 1:  # between two looks
            os.rename(part, whole)
        return found

    monkeypatch.setattr(saving, "_stamps", stamps)
    assert [*listed(folder)] == [whole]
    assert len(calls) == 3


def test_a_file_that_moves_twice_while_a_reader_looks_is_seen(folder, monkeypatch):
    saved(folder, "here-1-ab", 0, 1)
    part, whole = part_path(folder, "here-1-ab", 0), folder / "members.h5"
    other = part_path(folder, "there-2-cd", 0)
    genuine, looks = os.stat, []

    def stat(path, **options):
        if path == str(whole):
            looks.append(path)
            if len(looks) == 2:
                os.rename(whole, other)  # by a second process, after the look into the folder
        try:
            return genuine(path, **options)
        finally:
            if looks == [path]:
                os.rename(part, whole)  # by a first one, after the look at the whole

    monkeypatch.setattr(os, "stat", stat)
    assert [*listed(folder)] == [other]


def test_a_damaged_file_is_moved_aside_after_its_sound_members_are_stored_again(folder):
    path = part_path(folder, "here-1-ab", 0)
    write_part(path, OF_RUN, bare(0, 1, 2))
    content = path.read_bytes()
    path.write_bytes(content.replace(member(1).moments[0].spectrum.tobytes(), bytes(64)))
    kept = saving.replace_damaged(path, folder, saving.sound_part(path))
    assert kept == folder / "damaged" / "here-1-ab-000.h5"
    assert indices(folder) == [0, 2]
    assert not path.exists()


def test_a_dangling_link_in_the_place_of_a_part_is_no_part(folder):
    part_path(folder, "here-1-ab", 0).symlink_to(Path("nowhere"))
    assert listed(folder) == {}
