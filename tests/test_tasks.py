"""Who does the members: workers that die, that outlive their parent, and signals."""

import multiprocessing
import os
import signal
import threading
from concurrent.futures import BrokenExecutor, Executor

import pytest

import roughsim as rs
from roughsim.ensemble import aimed, tasks, workers
from roughsim.ensemble.claims import Claims


class Broken(Executor):
    """A pool whose workers are dead."""

    def submit(self, *_, **__):
        raise BrokenExecutor("killed")


def to_do(scene, folder):
    run = rs.run(scene, folder, max_realizations=1)
    run.max_realizations = 2
    scene = aimed(scene, max_realizations=2)
    return tasks.Tasks(scene, run.numerics, folder, run, Claims(folder), lambda: None)


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


def test_workers_that_die_once_are_replaced_and_every_member_is_told(quick, tmp_path):
    work, seen = to_do(quick, tmp_path / "run"), []
    work.observer = lambda run: seen.append(run.realizations)
    work.complete(Force(Broken(), None))
    assert seen[0] == 2
    assert work.result.realizations == 2


def test_an_interrupt_that_was_noted_comes_up_at_the_next_member(quick, tmp_path):
    work = to_do(quick, tmp_path / "run")

    def check():
        raise KeyboardInterrupt

    work.check = check
    with pytest.raises(KeyboardInterrupt):
        work.complete(Force(None))


def test_a_worker_whose_parent_is_gone_leaves_and_hears_no_interrupt(monkeypatch):
    left, codes = threading.Event(), []
    monkeypatch.setattr(os, "_exit", lambda code: codes.append(code) or left.set())
    before = signal.getsignal(signal.SIGINT)
    try:
        workers._begin_worker(os.getppid() + 1)
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
    with workers.Workforce(1, None) as force:
        assert force.pool() is None
    others = multiprocessing.active_children()
    with pytest.raises(BrokenExecutor), workers.Workforce(2, None) as force:
        force.pool().submit(signal.raise_signal, signal.SIGKILL).result()
    assert multiprocessing.active_children() == others
