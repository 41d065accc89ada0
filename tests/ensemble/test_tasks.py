"""Who does the members: workers that die, that outlive their parent, and signals."""

import multiprocessing
import os
import pickle
import re
import signal
import socket
import sys
import threading
import time
from concurrent.futures import BrokenExecutor, Executor, Future
from dataclasses import replace
from itertools import chain
from types import SimpleNamespace

import pytest

import roughsim as rs
from roughsim.ensemble import tasks, workers
from roughsim.ensemble.run import aimed
from roughsim.store.claims import Claims


class Broken(Executor):
    """A pool whose workers are dead."""

    def submit(self, *_, **__):
        raise BrokenExecutor("killed")


def to_do(scene, folder):
    run = rs.run(scene, folder, max_realizations=1)
    run.max_realizations = 2
    scene = aimed(scene, max_realizations=2)
    return tasks.Tasks([tasks.AtWork(scene, run.numerics, folder, run)], Claims(folder), lambda: None)


class Force(workers.Workforce):
    """Pools that are handed in."""

    def __init__(self, *pools):
        super().__init__(2, None)
        self.pools, self.used = iter(pools), 0

    def pool(self):
        self.used += 1
        return next(self.pools)


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
    work.complete(Force(Broken(), workers.ThisProcess()))
    assert seen[0] == 2
    assert work.runs[0].run.realizations == 2


def test_an_interrupt_that_was_noted_comes_up_at_the_next_member(quick, tmp_path):
    work = to_do(quick, tmp_path / "run")

    def check():
        raise KeyboardInterrupt

    work.check = check
    with pytest.raises(KeyboardInterrupt):
        work.complete(Force(workers.ThisProcess()))


def test_a_worker_whose_parent_is_gone_leaves_and_hears_no_interrupt(monkeypatch):
    left, codes = threading.Event(), []
    monkeypatch.setattr(os, "_exit", lambda code: codes.append(code) or left.set())
    before = signal.getsignal(signal.SIGINT)
    try:
        workers.begin_worker(os.getppid() + 1)
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
        with workers.stopped_by_signals() as check:
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
    with workers.Workforce(2, given) as force:
        assert force.pool() is given
        assert force.in_flight == 4
    with workers.Workforce(1, None) as force:
        assert force.pool().submit(os.getpid).result() == os.getpid()
        assert force.in_flight == 1
    others = multiprocessing.active_children()
    with pytest.raises(BrokenExecutor), workers.Workforce(2, None) as force:
        force.pool().submit(signal.raise_signal, signal.SIGKILL).result()
    assert multiprocessing.active_children() == others


@pytest.mark.slow
def test_own_workers_may_start_before_they_are_asked_for():
    with workers.Workforce(2, None) as force:
        force.start()
        started = {process.pid for process in force.context.born}
        assert len(started) == 2
        early = force.pool()
        assert early.submit(os.getpid).result() in started
        assert force.pool() is early
        force.broken = True
        assert force.pool() is not early
    for count, given in ((1, None), (2, Broken())):  # this process, or an executor of the caller
        with workers.Workforce(count, given) as force:
            force.start()
            assert not force.context.born


class Elsewhere(Executor):
    """A worker that was started in another folder, or, with another root, on a machine that shares no disk."""

    def __init__(self, root, other=None):
        self.root, self.other = root, other

    def submit(self, fn, members):
        here, future = os.getcwd(), Future()
        os.chdir(self.root)
        try:
            moved = [
                ([replace(job, folder=self.other or job.folder) for job in jobs], index) for jobs, index in members
            ]
            future.set_result(fn(moved))
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
    genuine, looks = tasks.AtWork.is_stored, []

    def late(work, task):
        looks.append(task)
        return genuine(work, task) and len(looks) > 4

    monkeypatch.setattr(tasks.AtWork, "is_stored", late)
    assert rs.run(quick, tmp_path / "run", max_realizations=1).realizations == 1


class Timed(Executor):
    """One worker, whose members are said to take so many seconds at each level; it keeps the calls."""

    def __init__(self, *seconds):
        self.seconds, self.calls = seconds, []

    def submit(self, function, members):
        future = Future()
        host, measured = function(members)
        levels = [jobs[0].level for jobs, _ in members]
        assert len(measured) == len(members)
        assert all(took > 0 for took in measured)
        self.calls.append([(level, index) for level, (_, index) in zip(levels, members, strict=True)])
        future.set_result((host, [self.seconds[level] for level in levels]))
        return future


def test_short_members_share_a_call_once_so_many_are_done_that_every_worker_has_its_share(quick, tmp_path):
    pool = Timed(0.02)
    run = rs.run(quick, tmp_path / "run", max_realizations=260, until={}, executor=pool, workers=2)
    assert run.realizations == 260
    assert [*chain(*pool.calls)] == [(0, index) for index in range(260)]  # in order, each once
    handed = 0
    for call in pool.calls:
        assert len(call) <= max(1, handed // 16)  # four calls are out at a time, with a quarter of what was done
        handed += len(call)
    assert max(map(len, pool.calls)) == int(tasks.CALL / 0.02)


@pytest.mark.parametrize("seconds", [(1.0, 1.0, 1.0), (1e-3, 1e-3, 1.0), (1.0, 1e-3, 1e-3)])
def test_where_members_of_any_level_take_long_each_has_a_call_of_its_own(capped_scene, tmp_path, seconds):
    # a short member that waits in a call for a march of an hour would hold up all others
    pool = Timed(*seconds)
    rs.run(capped_scene, tmp_path / "run", max_realizations=8, until={}, executor=pool)
    assert {len(call) for call in pool.calls} == {1}
    pool = Timed(1e-3, 1e-3, 1e-3)
    rs.run(capped_scene, tmp_path / "short", max_realizations=8, until={}, executor=pool)
    assert max(map(len, pool.calls)) > 1


def test_the_time_of_each_level_is_known_before_calls_have_several_members(capped_scene, tmp_path):
    work = to_do(capped_scene, tmp_path / "run")
    work.runs[0].run.max_realizations = 12
    work.complete(Force(Timed(0.01, 0.02, 0.03)))
    assert work.seconds == {0: 0.01, 1: 0.02, 2: 0.03}
    work.runs[0].run.max_realizations = 100
    work.counted, force = 200, workers.Workforce(2, None)
    assert len(work._next_call(force)) == int(tasks.CALL / 0.03)
    del work.seconds[1]  # not yet, though the others are short: it may be a march
    assert len(work._next_call(force)) == 1
    work.claims.release_all()


def test_a_run_without_workers_shows_every_member(quick, tmp_path):
    seen = []
    rs.run(quick, tmp_path / "run", max_realizations=60, until={}, observer=lambda run: seen.append(run.realizations))
    assert seen == list(range(1, 61))


def test_how_long_calls_are_out_is_measured(quick, tmp_path):
    class Slow(Timed):
        def submit(self, function, members):
            time.sleep(0.01 * len(members))
            return super().submit(function, members)

    work = to_do(quick, tmp_path / "run")
    work.runs[0].run.max_realizations = 60
    pool, began = Slow(1e-3), time.monotonic()
    work.complete(Force(pool))
    assert 0.01 * max(map(len, pool.calls)) <= work.longest <= time.monotonic() - began
    assert max(map(len, pool.calls)) > 1


def test_a_call_says_how_long_each_of_its_members_took(monkeypatch):
    clock = [100.0]

    def store(jobs, index):
        clock[0] += index
        return "host"

    monkeypatch.setattr(workers, "time", SimpleNamespace(perf_counter=lambda: clock[0]))
    monkeypatch.setattr(workers, "store_members", store)
    assert workers.store_in_turn([([], 5), ([], 0), ([], 3)]) == ("host", [5.0, 0.0, 3.0])


def test_calls_of_several_members_stop_at_the_same_realization(quick, tmp_path):
    goal = {"flash_temperature": 0.015}
    alone = rs.run(quick, tmp_path / "alone", max_realizations=400, until=goal)
    pool = Timed(1e-3)
    run = rs.run(quick, tmp_path / "run", max_realizations=400, until=goal, executor=pool)
    assert alone.target_met
    assert (run.target_met, run.realizations) == (True, alone.realizations)
    assert run.estimate("flash_temperature").mean.tolist() == alone.estimate("flash_temperature").mean.tolist()
    assert max(map(len, pool.calls)) > 1


def test_what_a_call_had_stored_when_its_worker_died_is_not_computed_again(quick, tmp_path):
    class Dies(Timed):
        def submit(self, function, members):
            if len(members) < 3:
                return super().submit(function, members)
            super().submit(function, members[:2])
            raise BrokenExecutor("killed")

    first, second, seen = Dies(1e-3), Timed(1e-3), []
    work = to_do(quick, tmp_path / "run")
    work.runs[0].run.max_realizations = 40
    work.observer = lambda run: seen.append(run.realizations)
    work.complete(Force(first, second))
    computed = chain(*first.calls, *second.calls)
    assert sorted(computed) == [(0, index) for index in range(1, 40)]
    assert first.calls[-1] not in second.calls
    assert seen[-1] == 40


def test_of_a_call_that_never_comes_back_only_what_is_missing_is_computed_here(quick, tmp_path, monkeypatch):
    class Stuck(Timed):
        def submit(self, function, members):
            if len(members) < 3:
                return super().submit(function, members)
            super().submit(function, members[:2])
            return Forgetful().submit()

    monkeypatch.setattr(tasks, "LEAST_WAIT", 0.2)
    monkeypatch.setattr(tasks, "LONGEST_WAITS", 0.0)
    monkeypatch.setattr(tasks, "PAUSE", 0.01)
    pool, here, genuine = Stuck(1e-3), [], tasks.store_members
    monkeypatch.setattr(tasks, "store_members", lambda jobs, index: here.append((0, index)) or genuine(jobs, index))
    with pytest.warns(RuntimeWarning, match="has not come back from a worker"):
        run = rs.run(quick, tmp_path / "run", max_realizations=40, until={}, executor=pool)
    assert run.realizations == 40
    assert here
    assert sorted(chain(here, *pool.calls)) == [(0, index) for index in range(40)]


def test_a_job_is_pickled_once_and_read_once_whatever_its_members(quick, tmp_path):
    job = to_do(quick, tmp_path / "run").runs[0].job(0)
    (content,), (same,) = (job.__reduce__()[1] for _ in range(2))
    assert content is same
    first, second = (pickle.loads(pickle.dumps([([job], index)])) for index in (1, 2))
    assert (first[0][1], second[0][1]) == (1, 2)
    again = first[0][0][0]
    assert second[0][0][0] is again
    for name in job.__slots__:
        assert getattr(again, name) == getattr(job, name)


class Forgetful(Executor):
    """A pool that never comes back with what it was handed."""

    def submit(self, *_):
        future = Future()
        future.set_running_or_notify_cancel()
        return future


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
    workers.leave_if_imported()
    assert codes == []
    monkeypatch.setattr(multiprocessing.current_process(), "_name", workers.WORKER)
    workers.leave_if_imported()
    assert codes == [workers.UNGUARDED]
    # and the parent tells such an end from others
    force = workers.Workforce(2, None)
    assert not force.unguarded
    force.context.born += [SimpleNamespace(exitcode=code) for code in (None, -15, workers.UNGUARDED)]
    assert force.unguarded


@pytest.mark.slow
def test_a_worker_that_hangs_does_not_hold_up_the_end(tmp_path):
    began = time.monotonic()
    with workers.Workforce(2, None) as force:
        pool = force.pool()
        future = pool.submit(time.sleep, 1000.0)
        while not future.running():
            time.sleep(0.01)
        force.stuck = True
    assert time.monotonic() - began < 60.0
    assert not any(child.is_alive() for child in force.context.born)
