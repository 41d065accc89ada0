"""Claims: who computes what, who is gone, and that nothing depends on it."""

import os
import resource
import subprocess
import sys
import time
from pathlib import Path

import pytest
from claims_cases import ONE, TWO, silent

from roughsim.store.claims import Claims, process_space, writer


def names(folder):
    return sorted(path.name for path in (folder / "claims").iterdir())


def test_a_member_is_taken_by_one_process_until_it_gives_it_up(tmp_path):
    with Claims(tmp_path) as mine, Claims(tmp_path) as other:
        assert mine.take(ONE)
        assert not other.take(ONE)
        assert other.take(TWO)
        mine.release(ONE)
        assert other.take(ONE)
    assert list(tmp_path.iterdir()) == []


def test_an_interrupt_as_soon_as_a_claim_is_made_leaves_none(tmp_path, monkeypatch):
    genuine = Claims._made

    def made(claims, path):
        genuine(claims, path)
        if path.name == ONE:
            raise KeyboardInterrupt

    monkeypatch.setattr(Claims, "_made", made)
    with pytest.raises(KeyboardInterrupt), Claims(tmp_path) as mine:
        mine.take(ONE)
    assert list(tmp_path.iterdir()) == []


def test_a_process_that_begins_while_the_last_one_leaves_signs_in_a_folder_of_its_own(
    tmp_path, monkeypatch
):
    genuine, calls = Path.mkdir, []

    def mkdir(folder, **options):
        genuine(folder, **options)
        calls.append(folder)
        if len(calls) == 1:
            folder.rmdir()  # as the other process does

    monkeypatch.setattr(Path, "mkdir", mkdir)
    with Claims(tmp_path) as mine:  # without a warning
        assert mine.path.read_text().startswith("0" * 20)
        assert mine.take(ONE)


def test_of_processes_that_leave_at_once_one_is_the_last(tmp_path, monkeypatch):
    mine, other = Claims(tmp_path).__enter__(), Claims(tmp_path).__enter__()
    genuine, removed = Path.rmdir, []

    def rmdir(folder):
        removed.append(folder)
        if len(removed) == 1:
            other.__exit__()  # as this one is about to remove the folder
        genuine(folder)

    monkeypatch.setattr(Path, "rmdir", rmdir)
    mine.__exit__()
    assert (mine.was_last, other.was_last) == (False, True)
    with Claims(tmp_path) as stays:
        with Claims(tmp_path) as leaves:
            pass
        with Claims(tmp_path) as slept:
            slept.path.unlink()  # by a process that took it for ended, and may leave before
    assert (leaves.was_last, slept.was_last, stays.was_last) == (False, True, True)


def test_a_process_that_gives_signs_of_life_keeps_its_claims_longer_than_a_lease(tmp_path, soon):
    with Claims(tmp_path) as mine, Claims(tmp_path) as other:
        mine.take(ONE)
        end = time.monotonic() + 0.7
        while time.monotonic() < end:
            assert not other.take(ONE)
            time.sleep(0.02)


def test_a_silent_process_loses_its_claims_after_a_lease_on_the_clock_of_the_reader(tmp_path, soon):
    silent(tmp_path)
    began = time.monotonic()
    with Claims(tmp_path) as mine:
        assert not mine.take(ONE)
        while not mine.take(ONE):
            time.sleep(0.01)
        assert time.monotonic() - began >= 0.3
        assert (tmp_path / "claims" / ONE).read_text() == mine.name
    assert list(tmp_path.iterdir()) == []  # what the silent one left is gone too


@pytest.mark.parametrize("killed", [False, True])
def test_of_two_that_find_a_stale_claim_at_once_one_takes_it(tmp_path, soon, monkeypatch, killed):
    silent(tmp_path)
    if killed:  # another one, as it was about to take the claim
        (tmp_path / "claims" / f"process-{ONE}").write_text("elsewhere-1-ab")
    with Claims(tmp_path) as first, Claims(tmp_path) as second:
        time.sleep(0.35)
        genuine, taken = Claims._is_stale, []

        def is_stale(claims, path):
            stale = genuine(claims, path)
            if claims is second and not taken:
                taken.append(first.take(ONE))  # after the look of the second one
            return stale

        monkeypatch.setattr(Claims, "_is_stale", is_stale)
        assert not second.take(ONE)
        assert taken == [True]
        assert (tmp_path / "claims" / ONE).read_text() == first.name
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("moment", [0.0, 1e9, 1e10], ids=["1970", "2001", "2286"])
def test_the_times_of_files_count_for_nothing(tmp_path, moment, soon):
    # a server or another machine may have any clock
    silent(tmp_path)
    for path in (tmp_path / "claims").iterdir():
        os.utime(path, (moment, moment))
    with Claims(tmp_path) as mine:
        assert not mine.take(ONE)
    with Claims(tmp_path) as other, Claims(tmp_path) as mine:
        other.take(TWO)
        end = time.monotonic() + 0.4
        while time.monotonic() < end:
            for path in (tmp_path / "claims").iterdir():
                os.utime(path, (moment, moment))
            assert not mine.take(TWO)
            time.sleep(0.02)


def test_a_container_that_starts_again_with_the_same_host_and_number_is_another_process(
    tmp_path, soon
):
    # its number is that of the dead one: it lives, so only silence tells
    with Claims(tmp_path) as before:
        host = before.name.rsplit("-", 2)[0]
    silent(tmp_path, f"{host}-{os.getpid()}-ab", host=host, pid=os.getpid(), space=process_space())
    with Claims(tmp_path) as mine:
        assert not mine.take(ONE)
        time.sleep(0.35)
        assert mine.take(ONE)


def test_a_process_of_this_machine_that_has_ended_is_gone_at_once(tmp_path):
    ended = subprocess.run(
        [sys.executable, "-c", "import os; print(os.getpid())"], capture_output=True, check=True
    )
    silent(tmp_path, pid=int(ended.stdout), space=process_space())
    (tmp_path / "claims" / TWO).write_text("elsewhere-1-ab")
    with Claims(tmp_path) as mine:
        assert mine.take(ONE)
    assert list(tmp_path.iterdir()) == []  # nor stay claims of members that nobody needed


def test_the_same_number_in_another_container_says_nothing(tmp_path):
    silent(tmp_path, pid=2**22 + 1, space="another start of another machine")
    with Claims(tmp_path) as mine:
        assert not mine.take(ONE)


def test_a_suspended_process_that_was_taken_for_gone_removes_no_claim_of_its_heir(tmp_path, soon):
    suspended = Claims(tmp_path)
    suspended.folder.mkdir()
    suspended.sign(0)  # and no thread that goes on
    assert suspended.take(ONE)
    with Claims(tmp_path) as heir:
        time.sleep(0.35)
        assert heir.take(ONE)
        suspended.release(ONE)
        assert names(tmp_path) == sorted([ONE, f"process-{heir.name}", f"process-{suspended.name}"])
        suspended.sign(1)  # it lives after all
        assert not suspended.take(ONE)
    assert names(tmp_path) == [f"process-{suspended.name}"]


@pytest.mark.parametrize("content", ["", "x" * 5000, "../../etc/passwd", "\0\1\2"])
def test_a_claim_that_names_no_process_is_stale_after_a_lease(tmp_path, content, soon):
    (tmp_path / "claims").mkdir()
    (tmp_path / "claims" / ONE).write_text(content)
    with Claims(tmp_path) as mine:
        assert not mine.take(ONE)
        time.sleep(0.35)
        assert mine.take(ONE)


def test_a_folder_that_goes_and_a_full_disk_cost_claims_only(tmp_path):
    with Claims(tmp_path) as mine:
        (tmp_path / "claims" / f"process-{mine.name}").unlink()
        (tmp_path / "claims").rmdir()
        assert mine.take(ONE)

        before = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (0, before[1]))
        try:
            with pytest.warns(RuntimeWarning, match="File too large"):
                assert mine.take(TWO)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)
        assert mine.take("L0-000002")  # and says no more


def test_a_claim_that_cannot_be_removed_costs_claims_only(tmp_path, soon):
    # as that of another user, whose process has ended, in a folder of a group; of a directory nobody's can
    (tmp_path / "claims" / ONE / "kept").mkdir(parents=True)
    with Claims(tmp_path) as mine:
        assert not mine.take(ONE)
        time.sleep(0.35)
        with pytest.warns(RuntimeWarning, match="the run goes on without them"):
            assert mine.take(ONE)
        assert not mine.take(ONE)  # this process has it


def test_a_silent_process_is_waited_for_once_until_it_signs_again(tmp_path, monkeypatch):
    monkeypatch.setattr("roughsim.store.claims.RENEWAL", 0.1)
    silent(tmp_path)
    times = []
    for _ in range(2):
        began = time.monotonic()
        assert writer(tmp_path) is None
        times.append(time.monotonic() - began)
    assert times[0] >= 0.3
    assert times[1] < 0.15
    with Claims(tmp_path):
        assert writer(tmp_path).startswith(f"process {os.getpid()} on ")


def test_working_counts_those_that_give_signs_of_life(tmp_path, soon):
    assert writer(tmp_path) is None
    silent(tmp_path)
    assert writer(tmp_path) is None
    with Claims(tmp_path):
        assert writer(tmp_path).startswith(f"process {os.getpid()} on ")
        with Claims(tmp_path):
            assert writer(tmp_path).startswith("2 processes on ")
    assert writer(tmp_path) is None
