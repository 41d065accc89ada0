"""Who does the members: workers that die, that outlive their parent, and signals."""

import multiprocessing
import os
import re
import signal
import socket
import sys
import threading
import time
from concurrent.futures import BrokenExecutor, Executor, Future
from dataclasses import replace
from types import SimpleNamespace

import pytest
from pool_cases import Force, Forgetful, to_do

import roughsim as rs
from roughsim.ensemble import tasks, workforce
from roughsim.ensemble.signals import stopped_by_signals
from roughsim.store.member_files import member_path


class Broken(Executor):
    """A pool whose workers are dead."""

    def submit(self, *_, **__):
        raise BrokenExecutor("killed")


def test_workers_that_die_again_and_again_end_the_run_with_advice(quick, tmp_path):
    force = Force(*(Broken() for _ in range(9)))
    with pytest.raises(RuntimeError, match=r"workers died 4 times without storing a member, last: killed; see memory"):
        to_do(quick, tmp_path / "run").complete(force)
    assert force.used == tasks.RETRIES + 1


def test_an_executor_whose_workers_died_is_not_asked_again_and_what_ended_them_is_said(quick, tmp_path):
    # a pool of the caller's stays broken; in a script without a guard its processes die at their start
    asked = []

    class Dead(Broken):
        def submit(self, *_, **__):
            asked.append(1)
            return super().submit()

    words = r"workers of the executor died \(killed\): .* the same call goes on .* `if __name__ == \"__main__\":`"
    with pytest.raises(RuntimeError, match=words):
        rs.run(quick, tmp_path / "run", executor=Dead())
    assert len(asked) == 1


def test_processes_for_a_script_from_the_standard_input_are_refused_before_any_work(quick, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "__main__", SimpleNamespace(__file__="<stdin>", __spec__=None))
    with pytest.raises(ValueError, match=r"<stdin> is no file; save the script in a file, or .* workers=1"):
        rs.run(quick, tmp_path / "run", workers=2)
    assert not (tmp_path / "run").exists()
    assert rs.run(quick, tmp_path / "run", workers=1, max_realizations=1).realizations == 1


def test_workers_that_die_once_are_replaced_and_every_member_is_told(quick, tmp_path):
    work, seen = to_do(quick, tmp_path / "run"), []
    work.observer = lambda run: seen.append(run.realizations)
    work.complete(Force(Broken(), workforce.SerialExecutor()))
    assert seen[0] == 2
    assert work.runs[0].run.realizations == 2


def test_an_interrupt_that_was_noted_comes_up_at_the_next_member(quick, tmp_path):
    work = to_do(quick, tmp_path / "run")

    def check():
        raise KeyboardInterrupt

    work.check = check
    with pytest.raises(KeyboardInterrupt):
        work.complete(Force(workforce.SerialExecutor()))


def test_a_worker_whose_parent_is_gone_leaves_and_hears_no_interrupt(monkeypatch):
    left, codes = threading.Event(), []
    monkeypatch.setattr(os, "_exit", lambda code: codes.append(code) or left.set())
    before = signal.getsignal(signal.SIGINT)
    try:
        workforce.begin_worker(os.getppid() + 1)
        assert signal.getsignal(signal.SIGINT) == signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, before)
    assert left.wait(5)
    assert codes == [1]


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_is_an_interrupt_until_the_run_ends_and_then_what_it_was(number):
    before = signal.getsignal(number)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    own = signal.getsignal(number)
    try:
        with stopped_by_signals() as check:
            check()
            with pytest.raises(KeyboardInterrupt):
                signal.raise_signal(number)
            with pytest.raises(KeyboardInterrupt):
                check()
        assert signal.getsignal(number) is own
    finally:
        signal.signal(number, before)


def test_an_error_ends_the_workers_at_once_and_leaves_a_given_executor_alone():
    given = Broken()
    with workforce.Workforce(2, given) as force:
        assert force.pool() is given
        assert force.in_flight == 4
    with workforce.Workforce(1, None) as force:
        assert force.pool().submit(os.getpid).result() == os.getpid()
        assert force.in_flight == 1
    others = multiprocessing.active_children()
    with pytest.raises(BrokenExecutor), workforce.Workforce(2, None) as force:
        force.pool().submit(signal.raise_signal, signal.SIGKILL).result()
    assert multiprocessing.active_children() == others


class Elsewhere(Executor):
    """A worker that was started in another folder, or, with another root, on a machine that shares no disk."""

    def __init__(self, root, other=None):
        self.root, self.other = root, other

    def submit(self, function, jobs, index):
        here, future = os.getcwd(), Future()
        os.chdir(self.root)
        try:
            future.set_result(function([replace(job, folder=self.other or job.folder) for job in jobs], index))
        except Exception as error:
            future.set_exception(error)
        finally:
            os.chdir(here)
        return future


def test_workers_that_started_elsewhere_write_into_the_run_folder(quick, tmp_path, monkeypatch):
    (tmp_path / "here").mkdir()
    (tmp_path / "there").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    run = rs.run(quick, "run", max_realizations=3, executor=Elsewhere(tmp_path / "there"))
    assert run.realizations == 3
    assert len(list((tmp_path / "here" / "run" / "realizations").iterdir())) == 3
    assert list((tmp_path / "there").iterdir()) == []


def test_a_file_system_that_is_not_shared_is_named_and_no_member_counts(quick, tmp_path, monkeypatch):
    monkeypatch.setattr(tasks, "LATE", 0.05)
    host = re.escape(socket.gethostname())
    unseen = rf"a worker on {host} does not see .*none: it was moved, or the file system is not shared"
    with pytest.raises(rs.RecordError, match=unseen):
        rs.run(quick, tmp_path / "run", executor=Elsewhere(tmp_path, tmp_path / "none"))
    rs.run(quick, tmp_path / "other", max_realizations=1)  # a folder of the same name on the disk of the worker
    with pytest.raises(rs.RecordError, match=rf"a worker on {host} wrote .*run.realizations.L0-00000..h5, but this"):
        rs.run(quick, tmp_path / "run", executor=Elsewhere(tmp_path, tmp_path / "other"))
    assert rs.open_run(tmp_path / "run").realizations == 0


def test_a_member_that_a_slow_file_system_shows_late_counts(quick, tmp_path, monkeypatch):
    genuine, looks = tasks.Assignment.unseen, []

    def late(one):
        looks.append(one)
        return genuine.fget(one) if len(looks) > 4 else [member_path(tmp_path / "run", one.level, one.index)]

    monkeypatch.setattr(tasks.Assignment, "unseen", property(late))
    assert rs.run(quick, tmp_path / "run", max_realizations=1).realizations == 1


def test_a_member_that_never_comes_back_is_waited_for_with_a_limit_and_computed_here(quick, tmp_path, monkeypatch):
    monkeypatch.setattr(tasks, "LEAST_WAIT", 0.05)
    monkeypatch.setattr(tasks, "LONGEST_WAITS", 0.0)
    monkeypatch.setattr(tasks, "PAUSE", 0.01)
    began = time.monotonic()
    with pytest.warns(RuntimeWarning, match=r"L0-000000 has not come back from a worker for 0 s \(limit 0 s") as told:
        run = rs.run(quick, tmp_path / "run", max_realizations=1, executor=Forgetful())
    assert run.realizations == 1
    assert time.monotonic() - began >= 0.05
    assert len(told) == 1
    assert "it is computed in this process" in str(told[0].message)


def test_the_limit_is_ten_times_the_longest_member_and_ten_minutes_at_least(quick, tmp_path):
    work = to_do(quick, tmp_path / "run")
    assert work.limit == 600.0
    work.longest = 100.0
    assert work.limit == 1000.0


def test_an_executor_that_drops_what_it_was_given_ends_the_run_with_a_sentence(quick, tmp_path):
    class Dropping(Executor):
        def submit(self, *_, **__):
            future = Future()
            future.cancel()
            return future

    with pytest.raises(RuntimeError, match="its scheduler or its workers have ended; all finished members are stored"):
        rs.run(quick, tmp_path / "run", executor=Dropping())
    assert not (tmp_path / "run" / "claims").exists()


def test_a_script_without_a_guard_is_told_what_it_lacks_and_not_started_again(quick, tmp_path, monkeypatch):
    force = Force(Broken())
    monkeypatch.setattr(Force, "unguarded", True)
    with pytest.raises(
        RuntimeError, match='the script lacks `if __name__ == "__main__":`: each worker imports'
    ) as told:
        to_do(quick, tmp_path / "run").complete(force)
    assert force.used == 1
    assert told.value.__suppress_context__  # one error, not two
    codes = []
    monkeypatch.setattr(os, "_exit", codes.append)
    workforce.check_workers(1, None)
    assert codes == []
    monkeypatch.setattr(multiprocessing.current_process(), "_name", workforce.WORKER)
    workforce.check_workers(1, None)
    assert codes == [workforce.UNGUARDED]
    # and the parent tells such an end from others
    force = workforce.Workforce(2, None)
    assert not force.unguarded
    force.context.born += [SimpleNamespace(exitcode=code) for code in (None, -15, workforce.UNGUARDED)]
    assert force.unguarded


@pytest.mark.slow
def test_a_worker_that_hangs_does_not_hold_up_the_end(tmp_path):
    began = time.monotonic()
    with workforce.Workforce(2, None) as force:
        pool = force.pool()
        future = pool.submit(time.sleep, 1000.0)
        while not future.running():
            time.sleep(0.01)
        force.stuck = True
    assert time.monotonic() - began < 60.0
    assert not any(child.is_alive() for child in force.context.born)
