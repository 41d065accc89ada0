"""Memory in the course of a run: only levels that it comes to need must fit, each with as many workers as do."""

from concurrent.futures import Executor, Future
from dataclasses import replace
from itertools import pairwise
from math import inf

import pytest
from stored_cases import member_path, split_members

import roughsim as rs
from roughsim.ensemble import tasks
from roughsim.ensemble.executors import Workers
from roughsim.ensemble.run import begin
from roughsim.estimate.rounds import Verdict
from roughsim.machine import PROCESS
from roughsim.results import run as run_module
from roughsim.store.claims import Claims

SIDES = 32, 64, 128
BYTES = [
    120 * side**2 for side in SIDES
]  # of a member of each level: 120 for each point, as the pages say
BETWEEN = (
    0.5 * sum(BYTES[1:]) / 0.8
)  # memory that has room for the middle level, but not for the highest
FIRST, SECOND = (4, 2, 0), (4, 2, 2)
TARGET = {"flash_temperature": 0.1}


@pytest.fixture
def scene(quick):
    levels = [{"column": "capped", "shape": [n, n], "q_max": 1250.0 * n} for n in SIDES]
    return replace(quick, numerics=replace(quick.numerics, levels=levels))


@pytest.fixture
def rounds(monkeypatch):
    """A judge that ends a run after the first round, or adds the highest level in the second."""

    def of(*numbers, needed=None):
        def judge(numerics, until, most, counts, totals):
            following = dict(pairwise(numbers)).get(counts)
            return Verdict(
                following is None,
                following,
                needed or following or counts,
                "by hand",
                {"flash_temperature": 0.5},
            )

        monkeypatch.setattr(run_module, "judge", judge)
        monkeypatch.setattr(
            "roughsim.estimate.rounds.first_counts", lambda numerics, most: numbers[0]
        )

    return of


def test_a_level_that_is_never_needed_may_be_too_large(scene, tmp_path, rounds, memory):
    rounds(FIRST)
    memory(BETWEEN)
    workers = {reason.quantity: reason for reason in rs.plan(scene).reasons}["workers"]
    assert workers.text.endswith("a run that comes to need it ends there with an error")
    run = rs.run(scene, tmp_path / "run", until=TARGET)
    assert (run.finished, run.counts) == (True, FIRST)
    numerics = run.numerics
    assert rs.run(scene, tmp_path / "stated", numerics=numerics, until=TARGET).counts == FIRST


def test_a_run_that_needs_a_level_without_room_says_so_and_continues_where_there_is_room(
    scene, tmp_path, rounds, memory
):
    rounds(FIRST, SECOND)
    memory(BETWEEN)
    with pytest.raises(rs.ResolutionError) as said:
        rs.run(scene, tmp_path / "run", until=TARGET)
    assert str(said.value) == (
        "memory = 0.00197 GB (largest grid) exceeds 80 % of the 0.00154 GB that are available (limit of the test); "
        "lower the levels' shape, or ask for more memory; stored members stay, and the same call continues from them"
    )
    stored = rs.open_run(tmp_path / "run")
    assert (stored.finished, stored.counts) == (False, FIRST)
    memory(inf)
    assert rs.run(scene, tmp_path / "run", until=TARGET).counts == SECOND
    memory(1.0)  # all is there
    for numerics in None, stored.numerics:
        assert rs.run(scene, tmp_path / "run", numerics=numerics, until=TARGET).finished


def test_a_round_of_small_members_has_room_whatever_is_stored_of_large_ones(
    scene, tmp_path, rounds, memory
):
    rounds(SECOND)
    rs.run(scene, tmp_path / "run", until=TARGET)
    member_path(split_members(tmp_path / "run"), 0, 3).unlink()
    memory(BETWEEN)
    assert rs.run(scene, tmp_path / "run", until=TARGET).counts == SECOND


class Late(Workers):
    """Two workers whose members are computed when the run waits for them; notes each `fit` that changes the number."""

    others = in_flight = 2

    def __init__(self):
        super().__init__(2)
        self.waiting, self.fits = [], []

    def fit(self, *arguments, busy, **options):
        before, waiting = self.count, len(self.waiting)
        fits = super().fit(*arguments, busy=busy, **options)
        self.fits += [(waiting, fits, self.count)] if (waiting, self.count) != (0, before) else []
        return fits

    def executor(self, seconds_left=lambda: inf):
        outer = self

        class Queue(Executor):
            def submit(self, function, *arguments):
                future = Future()
                outer.waiting.append(lambda: future.set_result(function(*arguments)))
                return future

        return Queue()

    def wait(self, futures, **_):
        if futures:
            self.waiting.pop(0)()


def test_the_number_of_workers_changes_when_those_at_work_have_ended(
    scene, tmp_path, rounds, memory, monkeypatch
):
    rounds(FIRST, (6, 2, 0), (6, 2, 2), needed=(8, 2, 2))
    memory((2 * (BYTES[1] + PROCESS) + 1e3) / 0.8)  # two workers, or one with the highest level
    begin(scene, tmp_path)
    run = rs.open_run(tmp_path)
    run.until = TARGET
    with Late() as workers, Claims(tmp_path) as claims:
        monkeypatch.setattr(tasks, "wait", workers.wait)
        with pytest.warns(RuntimeWarning, match="the run has 1$"):
            tasks.Tasks([run], claims).complete(workers)
    assert run.counts == (6, 2, 2)
    assert workers.fits == [(1, False, 2), (0, True, 1)]  # one is at work on a member ahead
