"""Work in blocks: the same result as on the whole plane, for any number of threads."""

import threading
import time
import weakref

import numpy as np
import pytest

from roughsim import fourier
from roughsim._kernels import watching
from roughsim.fourier import blocks, plans


@pytest.fixture
def unchanged_threads():
    before = fourier.get_threads()
    yield
    fourier.set_threads(before)


@pytest.fixture(params=[1, 2])
def threads(request, unchanged_threads):
    fourier.set_threads(request.param)
    return request.param


@pytest.mark.parametrize("place", [0, 350_000, 699_999])
def test_extremes_are_those_of_the_plane_in_whichever_block_they_lie(threads, place):
    field = np.random.default_rng(1).random((700, 1000))  # three blocks
    field.flat[place], field.flat[-1 - place] = 5.0, -3.0
    assert len(blocks.spans(*field.shape)) == 3
    assert blocks.extremes(field) == (-3.0, 5.0)


@pytest.mark.parametrize("count", [1, 2, 3, 5])
def test_results_are_in_the_order_of_the_blocks(unchanged_threads, count):
    fourier.set_threads(3)
    expected = [(i, 10 * i) for i in range(count)]
    for _ in range(50):
        assert blocks.run(lambda a, b: (a, b), expected) == expected


def meeting():
    """Return a task that ends only if two threads are in it at once, and the names of these threads."""
    time.sleep(0.05)  # a helper that is just about to sleep would not come
    barrier, names = threading.Barrier(2, timeout=20), []

    def task(k):
        names.append(threading.current_thread().name)
        barrier.wait()
        return k

    return task, names


def test_helpers_work_beside_the_caller_and_sleep_when_nothing_comes(unchanged_threads):
    fourier.set_threads(2)
    for _ in range(3):
        task, names = meeting()
        assert blocks.run(task, [(0,), (1,)]) == [0, 1]
        assert len(set(names)) == 2
    team = plans.state.team[1]
    assert not team.helpers[0].cancel()
    deadline = time.monotonic() + 20
    while not team.helpers[0].done():  # else a thread would keep a core busy for nothing
        assert time.monotonic() < deadline
        time.sleep(0.01)


@pytest.mark.skipif(not watching.TURNS, reason="kernels are not compiled: nobody watches")
def test_nobody_waits_for_a_helper_that_watches(unchanged_threads):
    fourier.set_threads(2)
    blocks.run(lambda k: k, [(0,), (1,)])
    team = plans.state.team[1]
    before, team.turns = team.turns, 10**11  # for a minute
    try:
        task = meeting()[0]
        blocks.run(task, [(0,), (1,)])
        helper, start = team.helpers[0], time.monotonic()
        for _ in range(100):
            blocks.run(task, [(0,), (1,)])
        assert time.monotonic() - start < 20.0
        assert team.helpers[0] is helper  # it stayed
    finally:
        team.turns = before
        blocks.run(task, [(0,), (1,)])


@pytest.mark.parametrize("failing", [0, 1])
def test_an_error_in_any_thread_is_raised_after_all_have_ended(unchanged_threads, failing):
    fourier.set_threads(2)
    meet, ended = meeting()[0], []

    def task(k):
        meet(k)
        if k == failing:
            raise ZeroDivisionError
        time.sleep(0.05)
        ended.append(k)

    with pytest.raises(ZeroDivisionError):
        blocks.run(task, [(0,), (1,)])
    assert ended == [1 - failing]
    assert blocks.run(lambda k: k, [(0,), (1,)]) == [0, 1]


def test_a_task_may_share_out_work_of_its_own(unchanged_threads):
    fourier.set_threads(2)
    inner = lambda k: sum(blocks.run(lambda i: i + k, [(i,) for i in range(5)]))  # noqa: E731
    for _ in range(20):
        assert blocks.run(inner, [(k,) for k in range(4)]) == [10, 15, 20, 25]


def test_two_python_threads_share_out_work_at_once(unchanged_threads):
    fourier.set_threads(3)
    results = [None] * 2

    def caller(me):
        results[me] = [blocks.run(lambda k: me + k, [(k,) for k in range(7)]) for _ in range(100)]

    callers = [threading.Thread(target=caller, args=(me,)) for me in range(2)]
    for each in callers:
        each.start()
    for each in callers:
        each.join(60)
    assert results == [[list(range(me, me + 7))] * 100 for me in range(2)]


def test_another_python_thread_may_set_the_number_of_threads_meanwhile(unchanged_threads, monkeypatch):
    numbers = iter([2, 1, 1])  # as two runs in threads of one process do, each with its own
    monkeypatch.setattr(blocks, "get_threads", lambda: next(numbers))
    assert blocks.run(lambda k: k, [(k,) for k in range(5)]) == [0, 1, 2, 3, 4]


def test_what_a_task_held_is_free_once_it_is_done(unchanged_threads):
    fourier.set_threads(3)

    def held():
        field = np.zeros(1000)
        blocks.run(lambda k: field[k], [(k,) for k in range(9)])
        return weakref.ref(field)

    assert held()() is None


def test_who_watches_says_its_word_and_sees_that_of_the_other():
    words = np.zeros(16, np.int64)
    assert not watching.watch(words, 0, 5, 8, 0, 1000)  # nothing came
    assert words[0] == 5
    assert watching.watch(words, 0, 6, 8, 1, 1000)
    if not watching.TURNS:
        pytest.skip("kernels are not compiled: nobody watches")
    # while it watches: another thread can speak, as no GIL is held
    speaker = threading.Timer(0.05, words.__setitem__, (8, 1))
    speaker.start()
    assert watching.watch(words, 0, 7, 8, 0, 10**11)
    speaker.join()
    assert words.tolist() == [7] + 7 * [0] + [1] + 7 * [0]
