"""As many workers as memory and cores allow, which the run says; a worker that the system kills ends in a sentence."""

import multiprocessing
import signal
import threading
import time
from concurrent.futures import BrokenExecutor, ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from pool_cases import to_do

import roughsim as rs
from roughsim.ensemble import executors
from roughsim.ensemble.executors import SerialExecutor, Workers
from roughsim.ensemble.run import begin
from roughsim.ensemble.status import expected_seconds
from roughsim.ensemble.workers import computed_members
from roughsim.estimate.rounds import first_counts, work
from roughsim.machine import Available
from roughsim.planning import reasons
from roughsim.scene.numerics import Level, Numerics


def started(workers, seconds_left=60.0):
    """The pool of some workers, when they have started."""
    while isinstance(pool := workers.executor(lambda: seconds_left), SerialExecutor):
        time.sleep(0.01)
    return pool


@pytest.fixture
def job(monkeypatch, memory):
    """A job with so many cores and GB."""

    def of(cores, gigabytes):
        memory(1e9 * gigabytes)
        for module in (reasons, executors):
            monkeypatch.setattr(
                module, "usable_cores", lambda: Available(cores, "cores of the test")
            )

    return of


def test_the_plan_has_as_many_workers_as_cores_and_memory_allow(job, quick):
    def planned(**keys):
        numerics = rs.plan(replace(quick, numerics=replace(quick.numerics, **keys)))
        return next((r.value, r.text) for r in numerics.reasons if r.quantity == "workers")

    job(128, 1000.0)
    assert planned()[0] == "128"
    assert planned(threads=4)[0] == "32"
    job(1, 1000.0)
    assert planned()[0] == "1"
    job(128, 1.0)  # a process takes a quarter of it, and its member next to nothing
    assert planned()[0] == "3"
    assert planned()[1].startswith(
        "128 would need more than 80 % of the 1 GB that are available (limit of the test)"
    )


def test_workers_that_were_asked_for_are_lowered_by_memory_with_a_warning(job):
    job(8, 25.3)
    with Workers(2) as workers, pytest.warns(RuntimeWarning) as said:
        workers.fit(18e9, "largest grid", 1)
    assert workers.count == 1
    assert str(said[0].message) == (
        "workers = 2 would need 2 × 18.2 GB, more than 80 % of the 25.3 GB that are available (limit of the test); "
        "the run has 1"
    )


def test_a_log_names_the_number_of_workers(job, caplog):
    job(8, 25.3)
    caplog.set_level("INFO", "roughsim")
    with Workers(None) as workers:
        assert workers.count == 8
        workers.fit(4e9, "largest grid", 1)
        assert workers.count == 4
        assert "the run has 4" in caplog.text
        caplog.clear()
        workers.fit(
            1e9, "largest grid", 4
        )  # the next points of a study may have room for more: here two of four threads
        assert workers.count == 2
        assert caplog.text == ""


def test_a_short_computation_starts_no_processes_unless_their_number_is_given(job, monkeypatch):
    # threads stand for processes, which take a second to start
    monkeypatch.setattr(
        executors, "ProcessPoolExecutor", lambda count, *_: ThreadPoolExecutor(count)
    )
    job(2, 25.3)
    with Workers(None) as workers:
        assert isinstance(workers.executor(lambda: 0.5), SerialExecutor)
        assert workers.in_flight == 1
        pool = started(workers)
        assert isinstance(pool, ThreadPoolExecutor)
        assert (workers.helps, workers.in_flight) == (True, 2)  # one process beside this one
        assert workers.executor(lambda: 0.5) is pool
    with Workers(2) as workers:
        assert isinstance(started(workers, 0.5), ThreadPoolExecutor)


def test_the_process_of_a_run_computes_until_others_have_started(job, monkeypatch):
    begun, go = [], threading.Event()
    monkeypatch.setattr(executors, "computed_members", lambda *_: begun.append(go.wait()))
    monkeypatch.setattr(
        executors, "ProcessPoolExecutor", lambda count, *_: ThreadPoolExecutor(count)
    )
    job(8, 25.3)
    with Workers(3) as workers:
        for _ in range(2):
            assert isinstance(workers.executor(), SerialExecutor)
            assert (workers.helps, workers.in_flight) == (False, 1)
        go.set()
        pool = started(workers)
        assert begun == [True, True]
        assert (workers.helps, workers.others, workers.in_flight) == (True, 2, 4)
        assert workers.fit(1e6, "largest grid", 1, seconds=1.9, busy=True)
        assert workers.executor() is pool
    with Workers(16) as workers:
        started(workers)
        assert (workers.helps, workers.others, workers.in_flight) == (False, 16, 32)


def test_the_process_of_a_run_computes_no_long_members_beside_others(job, monkeypatch):
    # they would delay the saving of members that others return
    monkeypatch.setattr(
        executors, "ProcessPoolExecutor", lambda count, *_: ThreadPoolExecutor(count)
    )
    job(8, 25.3)
    with Workers(2) as workers:
        pool = started(workers)
        assert not workers.fit(1e6, "largest grid", 1, seconds=10.0, busy=True)
        assert workers.fit(1e6, "largest grid", 1, seconds=10.0)
        assert workers.executor() is not pool
        assert (workers.helps, workers.others, workers.in_flight) == (False, 2, 4)


def test_the_expected_time_is_the_planned_one_in_the_first_round_and_the_measured_one_later(
    quick, tmp_path
):
    numerics = rs.plan(quick)
    begin(quick, tmp_path / "new", numerics)
    planned = expected_seconds(rs.open_run(tmp_path / "new"))
    works = [work(numerics, level) for level in range(len(numerics.levels))]
    assert planned == pytest.approx(
        5e-9 * np.dot(first_counts(numerics, quick.ensemble.max_realizations), works)
    )
    assert expected_seconds(rs.run(quick, tmp_path / "ended")) == 0.0


def test_what_workers_take_does_not_count_against_them(job):
    job(8, 25.3)
    with Workers(2) as workers:
        job(8, 1.0)  # while they compute
        workers.fit(9e9, "largest grid", 1)
        assert workers.count == 2


def test_a_member_without_room_is_refused_before_a_folder_is_made(job, quick, tmp_path):
    job(2, 1.0)
    numerics = Numerics((Level("capped", (4096, 4096), 1e5),), (2e-3, 2e-3))
    with pytest.raises(
        rs.ResolutionError, match=r"memory = 2.01 GB \(largest grid\) exceeds 80 % of the 1 GB"
    ):
        rs.run(quick, tmp_path / "run", numerics=numerics)
    assert not (tmp_path / "run").exists()


def kill_first(marker, *arguments):
    """End this process as the system does where memory runs out, if it is the first one or there is no marker."""
    if marker is None or not marker.exists():
        if marker is not None:
            marker.touch()
        signal.raise_signal(signal.SIGKILL)
    return computed_members(*arguments)


class Killing(Workers):
    """Two workers; the first one, or each, is killed at its member."""

    def __init__(self, marker):
        super().__init__(2)
        self.marker = marker

    def executor(self, seconds_left=lambda: np.inf):
        self.fit(1.0, "largest grid", 1, seconds=np.inf)  # only workers compute
        pool, marker = super().executor(seconds_left), self.marker

        class Handing(SerialExecutor):
            def submit(self, function, *arguments):
                return pool.submit(kill_first, marker, *arguments)

        return Handing()


@pytest.mark.slow
def test_a_killed_worker_is_named_with_numbers_and_the_run_continues_with_one_fewer(
    quick, tmp_path
):
    work = to_do(quick, tmp_path / "run")
    with Killing(tmp_path / "killed") as workers, pytest.warns(RuntimeWarning) as said:
        work.complete(workers)
    assert work.runs[0].realizations == 2
    assert workers.count == 1
    (words,) = {str(one.message) for one in said}
    assert words.startswith("a worker has died (")
    assert "2 workers need about 2 × 0.25 GB, and " in words
    assert words.endswith("ask for more memory, or for fewer workers; the run continues with 1")


def test_a_worker_that_is_killed_while_it_starts_has_died_and_no_script_is_blamed():
    others = multiprocessing.active_children()
    with Workers(2) as workers:
        workers.executor()
        (worker,) = [each for each in multiprocessing.active_children() if each not in others]
        worker.kill()
        with pytest.raises(BrokenExecutor):
            started(workers)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:a worker has died", "ignore:workers = ")
def test_after_the_death_of_a_worker_the_process_of_the_run_computes_no_member_itself():
    with Workers(2) as workers:
        workers.replace_broken(BrokenExecutor("killed"))
        assert isinstance(workers.executor(), ProcessPoolExecutor)
        assert (workers.count, workers.in_flight) == (1, 2)
        workers.fit(1e6, "largest grid", 1)  # of a later round
        assert isinstance(workers.executor(), ProcessPoolExecutor)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:a worker has died")
def test_workers_that_are_always_killed_end_the_run(quick, tmp_path):
    work = to_do(quick, tmp_path / "run")
    with (
        Killing(None) as workers,
        pytest.raises(RuntimeError, match="^workers died 4 times without storing a member"),
    ):
        work.complete(workers)
