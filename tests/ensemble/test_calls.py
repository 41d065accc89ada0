"""Calls of several short members: how many they hold, what they say, and what is left when one is lost."""

import pickle
import time
from concurrent.futures import BrokenExecutor, Executor, Future
from itertools import chain
from types import SimpleNamespace

import pytest
from pool_cases import Force, Forgetful, to_do

import roughsim as rs
from roughsim.ensemble import tasks, workers, workforce


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
    work.counted, force = 200, workforce.Workforce(2, None)
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
