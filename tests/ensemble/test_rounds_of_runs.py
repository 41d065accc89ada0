"""Rounds as they are handed out: in what order, ahead for idle workers, and beside other processes."""

from concurrent.futures import Executor, Future
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from stored_cases import read_member, write_member

import roughsim as rs
from roughsim.ensemble.run import begin
from roughsim.estimate.rounds import Verdict
from roughsim.results import run as run_module
from roughsim.store.claims import Claims
from roughsim.store.member_files import member_name

LEVELS = (
    {"column": "capped", "shape": [32, 32], "q_max": 4e4},
    {"column": "capped", "shape": [64, 64], "q_max": 8e4},
)
ROUNDS = [(4, 2), (6, 2), (6, 4)]


@pytest.fixture
def two_levels(quick):
    return replace(quick, numerics=replace(quick.numerics, levels=LEVELS))


@pytest.fixture
def by_hand(monkeypatch, one_by_one):
    """A judge that goes through these rounds, whatever the members say."""
    monkeypatch.setattr(run_module, "judge", judge)
    monkeypatch.setattr("roughsim.estimate.rounds.first_counts", lambda numerics, most: ROUNDS[0])


def judge(numerics, until, most, counts, totals):
    following = dict(pairwise(ROUNDS)).get(counts)
    needed = (8, 4) if following else counts
    return Verdict(following is None, following, needed, "by hand", {"flash_temperature": 0.5})


class Recording(Executor):
    """A worker that notes what it was given; the members in `held` come back when `release` is called."""

    def __init__(self, *held):
        self.given, self.held = [], dict.fromkeys(held)

    def submit(self, function, jobs, wanted):
        ((index, _),) = wanted
        task, future = (jobs[0].source.level, index), Future()
        self.given.append(task)
        if task in self.held:
            self.held[task] = lambda: future.set_result(function(jobs, wanted))
        else:
            future.set_result(function(jobs, wanted))
        return future


def test_a_round_begins_with_its_largest_grids_and_the_next_one_when_it_is_complete(
    two_levels, tmp_path, by_hand
):
    pool = Recording()
    run = rs.run(two_levels, tmp_path / "run", executor=pool, until={"flash_temperature": 0.1})
    first = [(1, 0), (1, 1), (0, 0), (0, 1), (0, 2), (0, 3)]
    assert pool.given == [*first, (0, 4), (0, 5), (1, 2), (1, 3)]
    assert (run.counts, run.rounds.number, run.target_met) == ((6, 4), 2, True)


def test_an_idle_worker_computes_ahead_what_will_be_needed_and_no_more(
    two_levels, tmp_path, by_hand
):
    # two workers: the first round is complete but for one member, and nothing is known of the next one yet
    pool = Recording((1, 1), (0, 5))

    def observe(run):
        if len(run.members) == 5:
            assert pool.given == [(1, 0), (1, 1), (0, 0), (0, 1), (0, 2), (0, 3)]
            pool.held[1, 1]()
        if run.rounds.number == 1 and (0, 7) in pool.given:  # of the second round (0, 5) is missing
            pool.held.pop((0, 5), int)()

    run = rs.run(
        two_levels,
        tmp_path / "run",
        executor=pool,
        workers=2,
        until={"flash_temperature": 0.1},
        observer=observe,
    )
    assert run.counts == (6, 4)
    # of eight and four that it will take: the level that grows most first
    assert pool.given[6:] == [(0, 4), (0, 5), (0, 6), (0, 7), (1, 2), (1, 3)]
    assert len(run.members) == 12
    again = rs.open_run(tmp_path / "run")
    assert again.missing == []


@pytest.mark.slow
def test_members_ahead_change_nothing_of_a_run(two_levels, tmp_path):
    alone = rs.run(two_levels, tmp_path / "alone", until={}, max_realizations=14)
    more = rs.run(two_levels, tmp_path / "more", until={}, max_realizations=20)
    assert len(more.members) > len(alone.members)
    fewer = rs.run(two_levels, tmp_path / "more", until={}, max_realizations=14)
    assert fewer.counts == alone.counts
    for one, other in ((fewer, alone), (rs.open_run(tmp_path / "more"), alone)):
        np.testing.assert_array_equal(
            one.estimate("flash_temperature").mean, other.estimate("flash_temperature").mean
        )


@pytest.mark.slow
def test_a_process_whose_round_others_complete_computes_ahead(two_levels, tmp_path, by_hand, soon):
    until = {"flash_temperature": 0.1}
    whole = rs.run(two_levels, tmp_path / "whole", until=until)
    folder, pool = tmp_path / "run", Recording()

    def observe(run):
        if run.rounds.number == 1 and not other.held:
            for index in (4, 5):
                other.take(member_name(0, index))
        if (0, 7) in pool.given:  # the other process has done its part
            for index in (4, 5):
                write_member(folder, read_member(whole.folder, 0, index))

    begin(two_levels, folder)
    with Claims(folder) as other:
        run = rs.run(two_levels, folder, until=until, executor=pool, observer=observe)
    assert run.counts == whole.counts
    assert {(0, 4), (0, 5)}.isdisjoint(pool.given)
    assert {(0, 6), (0, 7)} <= set(pool.given)
    for key in ((0, 5), (1, 3)):
        mine, theirs = (read_member(one.folder, *key).numbers for one in (run, whole))
        assert all((mine[name] == theirs[name]).all() for name in theirs)
