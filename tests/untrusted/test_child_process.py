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

import roughsim as rs
from roughsim import untrusted
from roughsim.untrusted import ChildEndedError, call_in_child, check_measured_file

SPIN = (re.match, "(a+)+$", "a" * 60 + "b")  # in C, for years


def test_a_child_reads_relative_paths_of_the_present_folder(tmp_path, monkeypatch):
    call_in_child(os.getpid, seconds=5.0)
    monkeypatch.chdir(tmp_path)
    assert call_in_child(os.getcwd, seconds=5.0) == str(tmp_path.resolve())


def test_what_is_asked_is_answered_and_what_is_raised_there_is_raised_here():
    assert call_in_child(divmod, 17, 5, seconds=5.0) == (3, 2)
    with pytest.raises(FileNotFoundError, match="none"):
        call_in_child(os.stat, "/none", seconds=5.0)
    assert (
        call_in_child(os.getpid, seconds=5.0)
        == call_in_child(os.getpid, seconds=5.0)
        != os.getpid()
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


def test_an_interrupt_comes_through_and_the_next_answer_is_not_that_of_the_last_call():
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    signal.setitimer(signal.ITIMER_REAL, 0.3)
    try:
        with pytest.raises(KeyboardInterrupt):
            call_in_child(*SPIN, seconds=30.0)
    finally:
        signal.signal(signal.SIGALRM, before)
    assert call_in_child(len, "four", seconds=5.0) == 4


def test_a_process_that_cannot_be_had_is_no_damage(monkeypatch):
    monkeypatch.setattr(untrusted, "_children", {})
    monkeypatch.setattr(sys, "executable", "/bin/false")
    with pytest.raises(OSError, match="did not start") as told:
        call_in_child(len, "four", seconds=5.0)
    assert not isinstance(told.value, rs.RecordError)


@pytest.mark.slow
def test_a_script_without_a_guard_may_read_files_of_instruments_and_leaves_no_process(tmp_path):
    path, script = tmp_path / "scan.h5", tmp_path / "script.py"
    with h5py.File(path, "w") as file:
        file["heights"] = np.zeros((16, 16))
    script.write_text(
        "from pathlib import Path\nfrom roughsim import untrusted\n"
        f"untrusted.check_measured_file(Path({str(path)!r}))\n"
        "print(*(h.pid for h in untrusted._children.values()))\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(Path(rs.__file__).parents[1])}
    said = subprocess.run(
        [sys.executable, script], env=environment, capture_output=True, text=True, check=True
    )
    assert said.stderr == ""
    with pytest.raises(ProcessLookupError):
        os.kill(int(said.stdout), 0)


def zeroed(content, step=64):
    """Yield the content with 64 bytes zeroed, at each place where that changes it."""
    for place in range(0, len(content), step):
        broken = bytearray(content)
        broken[place : place + 64] = bytes(len(broken[place : place + 64]))
        if broken != content:
            yield bytes(broken)


def test_a_topography_on_which_the_library_spins_is_refused_by_name(tmp_path, monkeypatch):
    path = tmp_path / "scan.h5"
    with h5py.File(path, "w") as file:
        file["heights"] = np.random.default_rng(0).random((16, 16))
        file["heights"].attrs["unit"] = "m"
    check_measured_file(path)

    def ended(*_, **__):
        raise ChildEndedError("the library did not come back in 5 s of computing")

    monkeypatch.setattr("roughsim.untrusted.call_in_child", ended)
    with pytest.raises(
        rs.RecordError, match="scan.h5 cannot be read: the library did not come back"
    ):
        check_measured_file(path)


@pytest.mark.slow
def test_64_zeroed_bytes_anywhere_in_a_file_of_an_instrument_end_in_an_answer(
    tmp_path, monkeypatch
):
    path = tmp_path / "scan.h5"
    with h5py.File(path, "w") as file:
        file["surface"] = np.random.default_rng(0).random((16, 16))
        file.create_dataset(
            "more/mask", data=np.zeros((40, 40)), chunks=(10, 10), compression="gzip"
        )
        file["more"].attrs["text"] = "made by hand"
    monkeypatch.setattr(
        "roughsim.untrusted.call_in_child",
        lambda *given, seconds: call_in_child(*given, seconds=0.4),
    )
    ends = []
    for broken in zeroed(path.read_bytes()):
        path.write_bytes(broken)
        try:
            check_measured_file(path)
        except (rs.RecordError, OSError, ValueError, LookupError, RuntimeError) as error:
            ends.append(str(error))
    assert any("did not come back" in end for end in ends)
