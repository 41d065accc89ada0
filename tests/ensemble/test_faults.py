"""What befalls a long run: kills, interrupts, full disks, dying workers. Nothing stored is lost or half done."""

import errno
import fcntl
import os
import pty
import resource
import signal
import subprocess
import sys
import termios
import time
from pathlib import Path

import numpy as np
import pytest
from process_cases import begin_process, end_processes, slowness
from stored_cases import count_members, members_of, read_member, with_fields
from storms import children, semaphores, started_workers

import roughsim as rs

ROOT = Path(__file__).parents[2]
SCRIPT = """
import sys, roughsim as rs
if __name__ == "__main__":
    scene, folder, workers, most = sys.argv[1:]
    rs.run(rs.load_scene(scene), folder, workers=int(workers), max_realizations=int(most), until={})
"""

# the first worker that computes leaves its id and waits to be killed; the process that asked is slow until then
WAITING = """
import multiprocessing, os, pathlib, time
from roughsim.ensemble import sources

genuine, mark = sources.solve_problem, pathlib.Path(__file__).with_name("worker.txt")

def solve(*rest):
    if not mark.exists():
        if multiprocessing.parent_process() is None:
            time.sleep(0.05)
        else:
            mark.with_suffix(".new").write_text(str(os.getpid()))
            mark.with_suffix(".new").rename(mark)
            time.sleep(100)
    return genuine(*rest)

sources.solve_problem = solve
"""


@pytest.fixture
def scene_file(quick, tmp_path):
    (tmp_path / "scene.toml").write_text(quick.to_toml())
    (tmp_path / "go.py").write_text(SCRIPT)
    return tmp_path / "scene.toml"


def start(scene_file, folder, workers=2, most=40):
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    words = [sys.executable, scene_file.with_name("go.py"), scene_file, folder, workers, most]
    with open(scene_file.with_name("said.txt"), "w") as said:
        return begin_process(
            words,
            env=environment,
            stdout=said,
            stderr=subprocess.STDOUT,
            preexec_fn=hear_interrupts,
        )


def hear_interrupts():
    """A shell lets what it starts in the background ignore them."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def wait_until(come, what, process, seconds=60):
    end = time.monotonic() + seconds
    while not come():
        assert process.poll() is None, f"it ended before {what}"
        assert time.monotonic() < end, f"no {what}"
        time.sleep(0.01)


def wait_for_members(folder, count, process):
    wait_until(lambda: count_members(folder) >= count, f"{count} members", process)


def wait_for_worker(process):
    """Wait until a worker takes tasks: members come before."""
    wait_until(lambda: started_workers(process.pid), "worker that has started", process)


def assert_all_sound(folder):
    for member in members_of(folder).values():
        with_fields(folder, member)


def assert_same_numbers(folder, other, count):
    for index in range(count):
        a, b = (read_member(place, 0, index) for place in (folder, other))
        for name in a.numbers:
            np.testing.assert_array_equal(a.numbers[name], b.numbers[name])
        np.testing.assert_array_equal(a.moments[0].spectrum, b.moments[0].spectrum)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("which", "workers"),
    [
        (signal.SIGINT, 2),
        (signal.SIGINT, 1),
        (signal.SIGTERM, 1),
        (signal.SIGTERM, 2),
        (signal.SIGHUP, 2),
        (signal.SIGXCPU, 1),
    ],
)
def test_an_interrupt_ends_all_within_a_second(hangup_ends, scene_file, tmp_path, which, workers):
    folder = tmp_path / "run"
    process = start(scene_file, folder, workers=workers, most=100000)
    wait_for_members(folder, 3, process)
    if workers > 1:
        wait_for_worker(process)
    family = children(process.pid)
    before = slowness()
    began = time.monotonic()
    process.send_signal(which)
    process.wait(timeout=100)
    while any(Path(f"/proc/{pid}").exists() for pid in family):
        assert time.monotonic() < began + 100, "a process stayed"
        time.sleep(0.05)
    taken = time.monotonic() - began
    assert taken < 4.0 * max(before, slowness())  # a second on a free machine
    assert process.returncode != 0
    assert "KeyboardInterrupt" in scene_file.with_name("said.txt").read_text()
    assert not (folder / "claims").exists()
    assert_all_sound(folder)


def test_processes_of_a_test_end_with_it():
    process = begin_process([sys.executable, "-c", "import time; time.sleep(1000)"])
    end_processes()  # as after each test
    assert process.returncode == -signal.SIGKILL


@pytest.fixture
def hangup_ends():
    """Processes started here take SIGHUP, also where the tests themselves were started by nohup."""
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    yield
    signal.signal(signal.SIGHUP, before)


@pytest.mark.slow
def test_a_terminal_that_is_closed_leaves_neither_claims_nor_processes_nor_semaphores(
    hangup_ends, scene_file, tmp_path
):
    folder = tmp_path / "run"
    master, slave = pty.openpty()
    words = [sys.executable, scene_file.with_name("go.py"), scene_file, folder, 2, 100000]
    process = begin_process(
        words,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdin=slave,
        stdout=slave,
        stderr=slave,
        start_new_session=True,
        preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0),
    )
    os.close(slave)
    wait_for_members(folder, 3, process)
    wait_for_worker(process)
    family = children(process.pid)
    opened = set().union(*map(semaphores, family))
    assert len(family) >= 2
    assert any(path.exists() for path in opened)
    os.close(master)  # the system sends SIGHUP to all processes of the terminal
    process.wait(timeout=20)
    end = time.monotonic() + 10
    while any(Path(f"/proc/{pid}").exists() for pid in family):
        assert time.monotonic() < end, "a process stayed"
        time.sleep(0.05)
    assert not (folder / "claims").exists()
    assert not any(path.exists() for path in opened)
    assert_all_sound(folder)


@pytest.mark.slow
def test_a_run_that_ignores_closed_terminals_goes_on(scene_file, tmp_path):
    hup = signal.signal(signal.SIGHUP, signal.SIG_IGN)  # as nohup does; inherited
    try:
        process = start(scene_file, tmp_path / "run", workers=1, most=2000)
    finally:
        signal.signal(signal.SIGHUP, hup)
    wait_for_members(tmp_path / "run", 3, process)
    process.send_signal(signal.SIGHUP)
    assert process.wait(timeout=200) == 0


@pytest.mark.slow
def test_workers_do_not_outlive_a_killed_parent(scene_file, tmp_path):
    process = start(scene_file, tmp_path / "run", most=100000)
    wait_for_members(tmp_path / "run", 3, process)
    wait_for_worker(process)
    family = children(process.pid)
    process.kill()
    process.wait()
    end = time.monotonic() + 20
    while any(Path(f"/proc/{pid}").exists() for pid in family):
        assert time.monotonic() < end, "a worker outlived its parent"
        time.sleep(0.1)


@pytest.mark.slow
def test_a_dying_worker_costs_a_retry_not_the_run(quick, scene_file, tmp_path):
    folder = tmp_path / "run"
    (tmp_path / "go.py").write_text(WAITING + SCRIPT)
    process = start(scene_file, folder, most=1000)
    mark = tmp_path / "worker.txt"
    wait_until(mark.exists, "member that a worker computes", process)
    os.kill(int(mark.read_text()), signal.SIGKILL)
    said = tmp_path / "said.txt"
    assert process.wait(timeout=120) == 0, said.read_text()
    assert "a worker has died" in said.read_text()
    assert rs.open_run(folder).realizations == 1000
    undisturbed = rs.run(quick, tmp_path / "undisturbed", max_realizations=10, until={})
    assert_same_numbers(folder, undisturbed.folder, 10)


@pytest.mark.parametrize(("kept", "name"), [(1, "L0-000000.h5"), (0, "members.*-000.h5")])
def test_a_file_size_limit_stops_with_the_path_and_can_be_resumed(quick, tmp_path, kept, name):
    folder = tmp_path / "run"
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (8000, hard))  # room for run.json, not for a member
    try:
        with pytest.raises(OSError, match=rf"cannot write .*{name}"):
            rs.run(quick.with_("numerics.keep_fields", kept), folder, max_realizations=3, until={})
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert list((folder / "members").iterdir()) == []
    assert list(folder.glob("fields/*")) == []
    assert not (folder / "claims").exists()
    assert rs.run(quick, folder, max_realizations=3, until={}).realizations == 3


@pytest.mark.slow
def test_a_run_can_be_read_while_it_is_written(scene_file, tmp_path):
    folder = tmp_path / "run"
    process = start(scene_file, folder, most=2000)
    wait_for_members(folder, 2, process)
    seen = []
    while process.poll() is None:
        time.sleep(0.1)
        run = rs.open_run(folder)
        seen.append(run.realizations)
        if run.realizations >= 2:
            assert np.isfinite(run.estimate("flash_temperature").mean).all()
    assert process.returncode == 0
    assert seen[0] < 2000
    assert seen == sorted(seen)  # a prefix that only grows
    assert rs.open_run(folder).realizations == 2000


def test_a_finished_run_on_a_disk_for_reading_only_is_opened(quick, tmp_path, monkeypatch):
    finished = rs.run(quick, tmp_path / "run", max_realizations=2, until={})

    def refuse(*_, **__):
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    for name in ("replace", "link", "mkdir", "unlink", "rmdir"):
        monkeypatch.setattr(os, name, refuse)
    with pytest.warns(RuntimeWarning, match="claims cannot be made in .*Read-only file system"):
        again = rs.run(quick, finished.folder, max_realizations=2, until={})
    assert again.realizations == 2
