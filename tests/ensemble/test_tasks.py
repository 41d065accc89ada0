"""Executors of a run: workers that die, that outlive their parent, other machines, and signals."""

import contextlib
import multiprocessing
import os
import signal
import time
from concurrent.futures import BrokenExecutor, Executor, Future
from math import inf

import pytest
from pool_cases import GivenPools, to_do
from stored_cases import members_of

import roughsim as rs
from roughsim.ensemble import tasks
from roughsim.ensemble.executors import SerialExecutor, Workers


class Broken(Executor):
    """A pool whose workers are dead."""

    def submit(self, *_, **__):
        raise BrokenExecutor("killed")


@pytest.mark.filterwarnings("ignore:a worker has died")
def test_workers_that_die_again_and_again_end_the_run_with_advice(quick, tmp_path):
    workers = GivenPools(*(Broken() for _ in range(9)))
    with pytest.raises(
        RuntimeError, match=r"workers died 4 times without storing a member; check memory"
    ):
        to_do(quick, tmp_path / "run").complete(workers)
    assert workers.used == tasks.RETRIES + 1


def test_an_executor_whose_workers_died_is_not_asked_again_and_the_error_has_the_reason(
    quick, tmp_path
):
    # a pool of the caller's stays broken; in a script without a guard its processes die at their start
    asked = []

    class Dead(Broken):
        def submit(self, *_, **__):
            asked.append(1)
            return super().submit()

    words = r"the executor has lost a member \(killed\): .* the same call continues .* `if __name__ == \"__main__\":`"
    with pytest.raises(RuntimeError, match=words):
        rs.run(quick, tmp_path / "run", executor=Dead())
    assert len(asked) == 1


class Client:
    """As of dask: it takes calls, and its futures are of its own class."""

    def submit(self, *_, **__):
        return self


@pytest.mark.parametrize(
    ("executor", "words"),
    [
        (
            "dask",
            r"executor = 'dask' has no method submit; give a concurrent\.futures\.Executor; .*get_executor",
        ),
        (
            Client(),
            r"executor\.submit returned a \S*\.Client, not a concurrent\.futures\.Future; .*get_executor",
        ),
    ],
    ids=["no executor", "client of dask"],
)
def test_what_is_no_executor_of_concurrent_futures_is_refused_with_the_right_one(
    quick, tmp_path, executor, words
):
    with pytest.raises(TypeError, match=words):
        rs.run(quick, tmp_path / "run", executor=executor)
    assert not (tmp_path / "run" / "claims").exists()


@pytest.mark.filterwarnings("ignore:a worker has died")
def test_workers_that_die_once_are_replaced_and_the_observer_sees_every_member(quick, tmp_path):
    work, seen = to_do(quick, tmp_path / "run"), []
    work.observer = lambda run: seen.append(run.realizations)
    work.complete(GivenPools(Broken(), SerialExecutor()))
    assert seen[0] == 2
    assert work.runs[0].realizations == 2


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_is_an_interrupt_until_the_run_ends_and_then_its_default(number):
    before = signal.signal(number, signal.SIG_DFL)
    try:
        with Workers(1), pytest.raises(KeyboardInterrupt):
            signal.raise_signal(number)
        assert signal.getsignal(number) is signal.SIG_DFL
    finally:
        signal.signal(number, before)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_an_interrupt_that_python_drops_ends_the_run_after_the_member(quick, tmp_path):
    class Callback:
        def __del__(self):
            signal.raise_signal(signal.SIGINT)  # "Exception ignored in", and the program goes on

    work = to_do(quick, tmp_path / "run")
    work.runs[0].max_realizations = 5
    work.observer = lambda run: Callback() and None
    before = signal.signal(
        signal.SIGINT, signal.default_int_handler
    )  # a shell lets its background ignore it
    try:
        with pytest.raises(KeyboardInterrupt), Workers(1) as workers:
            work.complete(workers)
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, before)
    assert work.runs[0].realizations == 2


def test_a_handler_of_the_program_is_kept():
    heard = []
    before = signal.signal(signal.SIGTERM, lambda *_: heard.append(1))
    try:
        with Workers(1):
            signal.raise_signal(signal.SIGTERM)
    finally:
        signal.signal(signal.SIGTERM, before)
    assert heard == [1]


@pytest.mark.slow
def test_a_given_executor_is_left_alone_and_a_broken_pool_leaves_no_process():
    given = Broken()
    with Workers(2, given) as workers:
        assert workers.executor() is given
        assert workers.in_flight == 4
    with Workers(1) as workers:
        assert workers.executor().submit(os.getpid).result() == os.getpid()
        assert workers.in_flight == 1
    others = multiprocessing.active_children()
    with pytest.raises(BrokenExecutor), Workers(2) as workers:
        pool_of(workers).submit(signal.raise_signal, signal.SIGKILL).result()
    assert multiprocessing.active_children() == others


@pytest.mark.slow
def test_an_error_ends_a_busy_worker_at_once():
    others = multiprocessing.active_children()
    with pytest.raises(KeyError):
        fail_while_a_worker_sleeps()
    assert multiprocessing.active_children() == others


def test_workers_that_still_start_end_at_once():
    others = {*multiprocessing.active_children()}
    with Workers(3) as workers:
        workers.executor()
        starting = {*multiprocessing.active_children()} - others
    assert {process.exitcode for process in starting} == {-signal.SIGTERM}


def pool_of(workers):
    """Two processes beside this one, as for long members."""
    workers.fit(1.0, "largest grid", 1, seconds=inf)
    return workers.executor()


def fail_while_a_worker_sleeps():
    with Workers(2) as workers:
        pool_of(workers).submit(time.sleep, 1000.0)
        pool_of(workers).submit(os.getpid).result()  # by a worker that has begun
        raise KeyError


class Elsewhere(Executor):
    """A worker that was started in another folder, as on a machine that shares no disk."""

    def __init__(self, root):
        self.root = root

    def submit(self, function, jobs, wanted):
        here, future = os.getcwd(), Future()
        os.chdir(self.root)
        try:
            future.set_result(function(jobs, wanted))
        except Exception as error:
            future.set_exception(error)
        finally:
            os.chdir(here)
        return future


def test_workers_that_started_elsewhere_need_no_run_folder(quick, tmp_path):
    (tmp_path / "here").mkdir()
    (tmp_path / "there").mkdir()
    with contextlib.chdir(tmp_path / "here"):
        run = rs.run(quick, "run", max_realizations=3, executor=Elsewhere(tmp_path / "there"))
    assert run.realizations == 3
    assert len(members_of(tmp_path / "here" / "run")) == 3
    assert list((tmp_path / "there").iterdir()) == []


def test_an_executor_that_drops_its_calls_ends_the_run_with_a_sentence(quick, tmp_path):
    class Dropping(Executor):
        def submit(self, *_, **__):
            future = Future()
            future.cancel()
            return future

    with pytest.raises(
        RuntimeError,
        match="its scheduler or its workers have ended; all finished members are stored",
    ):
        rs.run(quick, tmp_path / "run", executor=Dropping())
    assert not (tmp_path / "run" / "claims").exists()


@pytest.mark.parametrize("seconds", [0.0025, 0.0078, 0.05, 0.3, 1.5, inf])
def test_claims_of_a_level_are_few_short_and_never_overlap(seconds):
    claims, index = [], 0
    while index < 10_000:
        claim = tasks.claim_on(index, seconds)
        assert claim.start == index
        assert all(tasks.claim_on(each, seconds) == claim for each in claim)
        assert len(claim) == 1 or len(claim) * seconds <= tasks.INTERVAL
        assert len(claim) <= max(index // 8, 1, tasks.BATCH / seconds)
        claims.append(claim)
        index = claim.stop
    if seconds < 0.01:
        assert len(claims) < 130


@pytest.mark.slow
def test_a_run_has_few_files_at_any_moment(quick, tmp_path):
    most = []

    def count(run):
        nonlocal most
        files = [path.name for path in run.folder.rglob("*") if path.is_file()]
        most = max(most, files, key=len)

    run = rs.run(quick, tmp_path / "run", max_realizations=300, until={}, observer=count)
    assert run.realizations == 300
    # 38 by the rule of claims if a slow disk delays every save
    assert 5 < len(most) < 100, most
    assert sum(path.is_file() for path in run.folder.rglob("*")) == 4  # with the kept fields


def test_many_new_members_do_not_delay_the_next_save(quick, tmp_path, monkeypatch):
    # parts that are full are written once, whenever that is: only the last one is written again
    now = [0.0]

    class Saver:
        parts = 1

        def save(self):
            now[0] += 0.03 * self.parts
            return self.parts

    work = to_do(quick, tmp_path / "run")
    work._savers = [Saver()]
    monkeypatch.setattr(tasks.time, "monotonic", lambda: now[0])
    pauses = []
    for Saver.parts in (1, 10):
        work._save()
        pauses.append(work._pause)
    assert pauses == pytest.approx([1.5, 1.5])
