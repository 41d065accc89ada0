"""Files of others are opened in a process that can be ended: what spins or crashes there ends nothing here."""

import ctypes
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py
import numpy as np
import pytest
from damage_cases import member, without_seal

import roughsim as rs
from roughsim import untrusted
from roughsim.store import member_files
from roughsim.store.member_files import check_member, member_path, read_member, write_member
from roughsim.untrusted import ChildEndedError, call_in_child, check_measured_file

SPIN = (re.match, "(a+)+$", "a" * 60 + "b")  # in C, for years


def test_what_is_asked_is_answered_and_what_is_raised_there_is_raised_here():
    assert call_in_child(divmod, 17, 5, seconds=5.0) == (3, 2)
    with pytest.raises(FileNotFoundError, match="none"):
        call_in_child(os.stat, "/none", seconds=5.0)
    assert (
        call_in_child(os.getpid, seconds=5.0) == call_in_child(os.getpid, seconds=5.0) != os.getpid()
    )  # one process for all


def test_what_does_not_come_back_is_ended_and_the_next_is_served():
    with pytest.raises(ChildEndedError, match="did not come back in 0 s of computing"):
        call_in_child(*SPIN, seconds=0.2)
    assert call_in_child(len, "four", seconds=5.0) == 4


def test_waiting_is_not_spinning():
    call_in_child(time.sleep, 0.5, seconds=0.2)  # a disk that is slow is no damage: CPU time counts


def test_a_crash_is_told_from_an_end_from_outside():
    with pytest.raises(ChildEndedError, match="the library crashed, signal 11"):
        call_in_child(ctypes.string_at, 0, seconds=5.0)
    with pytest.raises(OSError, match="was ended from outside") as told:
        call_in_child(os._exit, 3, seconds=5.0)
    assert not isinstance(told.value, rs.RecordError)
    assert call_in_child(len, "four", seconds=5.0) == 4


def test_an_interrupt_comes_through_and_the_next_answer_is_not_that_of_the_last_call(monkeypatch):
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    signal.setitimer(signal.ITIMER_REAL, 0.3)
    try:
        with pytest.raises(KeyboardInterrupt):
            call_in_child(*SPIN, seconds=30.0)
    finally:
        signal.signal(signal.SIGALRM, before)
    assert call_in_child(len, "four", seconds=5.0) == 4


def test_a_process_that_cannot_be_had_is_no_damage(monkeypatch, tmp_path):
    monkeypatch.setattr(untrusted, "_children", {})
    monkeypatch.setattr(sys, "executable", "/bin/false")
    path = old_member(tmp_path)
    with pytest.raises(OSError, match="did not start") as told:
        check_member(path)
    assert not isinstance(told.value, rs.RecordError)


@pytest.mark.slow
def test_a_script_without_a_guard_may_read_old_files_and_leaves_no_process(tmp_path):
    path = old_member(tmp_path)
    script = tmp_path / "script.py"
    script.write_text(
        "from pathlib import Path\nfrom roughsim.store.member_files import read_member\n"
        "from roughsim import untrusted\n"
        f"print(read_member(Path({str(path)!r})).index, *(h.pid for h in untrusted._children.values()))\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(Path(rs.__file__).parents[1])}
    said = subprocess.run([sys.executable, script], env=environment, capture_output=True, text=True, check=True)
    index, helper = said.stdout.split()
    assert (index, said.stderr) == ("42", "")
    with pytest.raises(ProcessLookupError):
        os.kill(int(helper), 0)


def old_member(folder):
    """The file of a member as it was before files had a digest of all their bytes."""
    (folder / "realizations").mkdir()
    write_member(folder, member(fields=False))
    path = member_path(folder, 1, 42)
    path.write_bytes(without_seal(path.read_bytes()))
    return path


def zeroed(content, step=64):
    """Yield the content with 64 bytes zeroed, at each place where that changes it."""
    for place in range(0, len(content), step):
        broken = bytearray(content)
        broken[place : place + 64] = bytes(len(broken[place : place + 64]))
        if broken != content:
            yield bytes(broken)


@pytest.mark.slow
def test_an_old_file_on_which_the_library_spins_is_named_as_damaged(tmp_path, monkeypatch):
    path = old_member(tmp_path)
    content, whole = path.read_bytes(), read_member(path)
    assert whole.index == 42
    monkeypatch.setattr(member_files, "call_in_child", lambda *given, seconds: call_in_child(*given, seconds=0.3))
    refused = []
    for broken in zeroed(content[:1024]):
        path.write_bytes(broken + content[1024:])
        with pytest.raises(rs.RecordError, match=r"L1-000042.h5 is damaged \(") as told:
            check_member(path)
        refused.append(str(told.value))
        if "did not come back in" in refused[-1]:
            break
    assert "did not come back in" in refused[-1], "no place was found where the library spins"


@pytest.mark.slow
def test_64_zeroed_bytes_anywhere_in_an_old_file_end_in_an_answer(tmp_path, monkeypatch):
    path = old_member(tmp_path)
    content, good = path.read_bytes(), read_member(path)
    monkeypatch.setattr(member_files, "call_in_child", lambda *given, seconds: call_in_child(*given, seconds=0.3))
    refused = []
    for broken in zeroed(content):
        path.write_bytes(broken)
        try:
            back = read_member(path)
        except rs.RecordError as error:
            refused.append(str(error))
            continue
        assert back.provenance == good.provenance
        for name, values in good.numbers.items():
            np.testing.assert_array_equal(back.numbers[name], values)
    assert len(refused) > 50
    assert all("L1-000042.h5 is damaged (" in reason for reason in refused)


def test_a_topography_on_which_the_library_spins_is_refused_by_name(tmp_path, monkeypatch):
    path = tmp_path / "scan.h5"
    with h5py.File(path, "w") as file:
        file["heights"] = np.random.default_rng(0).random((16, 16))
        file["heights"].attrs["unit"] = "m"
    check_measured_file(path)

    def ended(*_, **__):
        raise ChildEndedError("the library did not come back in 5 s of computing")

    monkeypatch.setattr("roughsim.untrusted.call_in_child", ended)
    with pytest.raises(rs.RecordError, match="scan.h5 cannot be read: the library did not come back"):
        check_measured_file(path)


@pytest.mark.slow
def test_64_zeroed_bytes_anywhere_in_a_file_of_an_instrument_end_in_an_answer(tmp_path, monkeypatch):
    path = tmp_path / "scan.h5"
    with h5py.File(path, "w") as file:
        file["surface"] = np.random.default_rng(0).random((16, 16))
        file.create_dataset("more/mask", data=np.zeros((40, 40)), chunks=(10, 10), compression="gzip")
        file["more"].attrs["text"] = "made by hand"
    monkeypatch.setattr("roughsim.untrusted.call_in_child", lambda *given, seconds: call_in_child(*given, seconds=0.4))
    ends = []
    for broken in zeroed(path.read_bytes()):
        path.write_bytes(broken)
        try:
            check_measured_file(path)
        except (rs.RecordError, OSError, ValueError, LookupError, RuntimeError) as error:
            ends.append(str(error))
    assert any("did not come back" in end for end in ends)
