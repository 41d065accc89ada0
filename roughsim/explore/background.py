"""A thread in which the latest task is done, so that the page stays quick."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any


class LatestTask:
    """A thread that does the latest of its tasks; a task that has not begun when the next one comes is dropped.

    `deliver` takes a function without arguments and calls it in the thread of the page. There `failed` is called with
    the error of a task.
    """

    def __init__(self, deliver: Callable[[Callable[[], None]], None], failed: Callable[[Exception], None]):
        self._deliver, self._failed = deliver, failed
        self._pool = ThreadPoolExecutor(1)
        self._ticket = object()

    def ask(self, work: Callable[[], Any], show: Callable[[Any], None]) -> None:
        """Do `work` in the thread, then `show` its result in the thread of the page."""
        self._ticket = ticket = object()

        def task() -> None:
            if self._ticket is not ticket:
                return
            try:
                result = work()
            except Exception as error:  # whatever it is, the page shows it
                failure = error
                self._deliver(lambda: self._failed(failure))
            else:
                self._deliver(lambda: show(result))

        self._pool.submit(task)

    def close(self) -> None:
        """End the thread; what it is doing is finished, what waits is dropped."""
        self._pool.shutdown(wait=False, cancel_futures=True)
