"""Work in blocks: the same result as on the whole plane, for any number of threads."""

import threading
import time
import weakref

import numpy as np
import pytest

from roughsim import fourier
from roughsim.fourier import blocks


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
    barrier, names = threading.Barrier(2, timeout=20), []

    def task(k):
        names.append(threading.current_thread().name)
        barrier.wait()
        return k

    return task, names


def test_blocks_are_computed_at_once(unchanged_threads):
    fourier.set_threads(2)
    for _ in range(3):
        task, names = meeting()
        assert blocks.run(task, [(0,), (1,)]) == [0, 1]
        assert len(set(names)) == 2


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


def test_what_a_task_held_is_free_once_it_is_done(unchanged_threads):
    fourier.set_threads(3)

    def held():
        field = np.zeros(1000)
        blocks.run(lambda k: field[k], [(k,) for k in range(9)])
        return weakref.ref(field)

    assert held()() is None
