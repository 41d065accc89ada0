"""Marches whose worker dies, or never comes back with them: each is an executor that a caller may hand in."""

import multiprocessing
import os
import signal
import time
from concurrent.futures import Executor, Future, ProcessPoolExecutor

import numpy as np
import pytest
from march_cases import sliding_scene

import roughsim as rs
from roughsim.ensemble import tasks
from roughsim.store.member_files import member_path, read_member

MARCH = 1  # its level


def dies_on_the_way(work, *arguments):
    """What a worker does that is killed in the middle of a march."""
    from roughsim.sliding import course

    genuine = course.walk

    def walk(*words):
        for n, step in enumerate(genuine(*words)):
            if n == 8:
                os.kill(os.getpid(), signal.SIGKILL)
            yield step

    course.walk = walk
    return work(*arguments)


class Dying(ProcessPoolExecutor):
    """One process, which is killed in its first march."""

    def __init__(self):
        super().__init__(1, multiprocessing.get_context("spawn"))

    def submit(self, work, *arguments):
        return super().submit(dies_on_the_way, work, *arguments)


class LosesMarches(Executor):
    """Never comes back with a march; all else is computed at once."""

    def __init__(self):
        self.lost = []

    def submit(self, work, jobs, index):
        future = Future()
        if any(job.level == MARCH for job in jobs):
            self.lost.append(time.monotonic())
            future.set_running_or_notify_cancel()
        else:
            future.set_result(work(jobs, index))
        return future


def assert_same(run, other):
    for index in (0, 1):
        mine, his = (read_member(member_path(one.folder, MARCH, index)) for one in (run, other))
        for name, values in his.numbers.items():
            np.testing.assert_array_equal(mine.numbers[name], values)
        for name, values in his.curves.items():
            np.testing.assert_array_equal(mine.curves[name], values)


@pytest.mark.slow
def test_a_worker_that_dies_in_a_march_ends_the_run_with_a_sentence_and_the_next_goes_on(sliding_run, tmp_path):
    with Dying() as pool, pytest.raises(RuntimeError, match=r"workers of the executor died .* the same call goes on"):
        rs.run(sliding_scene(), tmp_path / "run", executor=pool)
    assert not list((tmp_path / "run").glob(f"realizations/*L{MARCH}*"))  # nothing half done
    assert not (tmp_path / "run" / "claims").exists()
    again = rs.run(sliding_scene(), tmp_path / "run")
    assert again.realizations == 4
    assert_same(again, sliding_run)


@pytest.mark.slow
def test_a_march_that_never_comes_back_is_waited_for_as_long_as_marches_take(sliding_run, tmp_path, monkeypatch):
    monkeypatch.setattr(tasks, "LEAST_WAIT", 0.01)
    monkeypatch.setattr(tasks, "LONGEST_WAITS", 2.0)
    monkeypatch.setattr(tasks, "PAUSE", 0.01)
    asked = []
    monkeypatch.setattr(tasks, "seconds_of_march", lambda problem: asked.append(problem) or 0.75)
    pool = LosesMarches()
    with pytest.warns(RuntimeWarning, match=r"has not come back from a worker for \d+ s \(limit \d+ s") as told:
        run = rs.run(sliding_scene(), tmp_path / "run", executor=pool)
    assert run.realizations == 4
    assert {str(one.message)[:10] for one in told} == {"L1-000000 ", "L1-000001 "}
    assert time.monotonic() - pool.lost[0] >= 1.5
    assert asked[0].steps == 16
    assert_same(run, sliding_run)
