"""Slow work of the page: done in a thread, one task after the other, and only the latest of those that wait."""

from asyncio import gather, get_running_loop, run, to_thread
from inspect import iscoroutinefunction
from threading import Event

import pytest

pytest.importorskip("bokeh")
from roughsim.explore.tasks import LatestTask


class Session:
    """A document of an open page, without Bokeh's server: callbacks are called by the loop of a test."""

    session_context = "open"

    def __init__(self):
        self.called = []

    def add_next_tick_callback(self, callback):
        if iscoroutinefunction(callback):
            self.called.append(get_running_loop().create_task(callback()))
        else:
            callback()

    async def all_done(self):
        await gather(*self.called)


def test_only_the_latest_of_many_tasks_is_done():
    shown, failures, started, go = [], [], Event(), Event()

    def slow():
        started.set()
        go.wait(5)
        return "first"

    async def ask():
        latest = LatestTask(session := Session(), failures.append)
        latest.ask(slow, shown.append)
        await to_thread(started.wait, 5)
        for k in range(20):
            latest.ask(lambda k=k: k, shown.append)
        go.set()
        await session.all_done()
        assert shown == [
            "first",
            19,
        ]  # what had begun is shown, what waited is dropped but for the last
        latest.ask(lambda: "once more", shown.append)
        await session.all_done()

    run(ask())
    assert shown == ["first", 19, "once more"]
    assert failures == []


def test_a_failing_task_is_reported_and_the_next_is_done():
    failures, shown = [], []

    async def ask():
        latest = LatestTask(session := Session(), failures.append)
        for work in (lambda: 1 / 0, lambda: 2):
            latest.ask(work, shown.append)
            await session.all_done()

    run(ask())
    assert isinstance(failures[0], ZeroDivisionError)
    assert shown == [2]


def test_nothing_is_shown_on_a_page_that_was_closed():
    shown = []

    async def ask():
        latest = LatestTask(session := Session(), shown.append)
        latest.ask(lambda: setattr(session, "session_context", None), shown.append)
        await session.all_done()

    run(ask())
    assert shown == []
