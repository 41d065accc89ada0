"""Work on one array shared out in blocks: the same blocks, and so the same bits, for any number of threads."""

import itertools
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from functools import reduce
from operator import add
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughsim.fourier.plans import get_threads, thread_cache

POINTS = 1 << 18  # in a block: small enough for the cache, large enough for two threads to gain
LINE = 8  # words of a line of the cache: what one thread writes costs others nothing


def spans(rows: int, columns: int) -> list[tuple[int, int]]:
    """Ranges of an even number of rows, about `POINTS` points each."""
    height = max(POINTS // columns // 2 * 2, 2)
    return [(a, min(a + height, rows)) for a in range(0, rows, height)]


def nothing() -> None:
    """Do the work between two tasks."""


class Team:
    """The threads that help one Python thread. Between two tasks they watch for the next, and sleep if none comes.

    `words` has a line of the cache for each: the number of the task at hand, and that of the last one each helper did.
    """

    def __init__(self, helpers: int):
        from roughsim._kernels import watching  # not at the top: numba is slow to import

        self.watch, self.turns = watching.watch, watching.TURNS
        self.words = np.zeros(LINE * (helpers + 1), np.int64)
        self.pool = ThreadPoolExecutor(helpers, thread_name_prefix="roughsim")
        self.helpers: list[Future[None] | None] = [None] * helpers
        self.work: Callable[[], None]

    def do(self, work: Callable[[], None], helpers: int) -> None:
        """Call `work`, which raises nothing, here and in the helpers that come in time; return when all have."""
        self.work = work
        number = int(self.words[0]) + 1
        self.words[0] = number
        for k, helper in enumerate(self.helpers[:helpers]):
            if helper is None or helper.done():
                self.helpers[k] = self.pool.submit(self.help, LINE * (k + 1))
        work()
        for k, helper in enumerate(self.helpers):
            own = LINE * (k + 1)
            # until it has done this task, or ended without it, or is known never to begin
            while self.words[own] < number and not (helper is None or helper.done() or helper.cancel()):
                if not self.watch(self.words, 1, number, own, int(self.words[own]), self.turns):
                    time.sleep(1e-5)  # a core for the helper, if it has none
        self.work = nothing  # or the arrays of this task would stay until the next

    def help(self, own: int) -> None:
        """Call what there is to call, until nothing more comes for a while."""
        while True:
            number = int(self.words[0])
            self.work()
            if not self.watch(self.words, own, number, 0, number, self.turns):
                return


def run(task: Callable[..., Any], blocks: list[Any]) -> list[Any]:
    """Return ``[task(*block) for block in blocks]``, computed by all threads."""
    most = get_threads() - 1  # helpers; read once, as another Python thread may set it meanwhile
    helpers = min(most, len(blocks) - 1)
    if helpers < 1:
        return [task(*block) for block in blocks]
    results: list[Any] = [None] * len(blocks)
    errors: list[BaseException] = []
    order = itertools.count()

    def work() -> None:
        try:
            while (k := next(order)) < len(blocks):
                results[k] = task(*blocks[k])
        except BaseException as error:  # of whichever thread: raised below
            errors.append(error)

    thread_cache("team", most, lambda: Team(most), most=1).do(work, helpers)
    if errors:
        raise errors[0]
    return results


def total(parts: list[Any]) -> Any:
    """Sum tuples of partial sums, in the order of the blocks."""
    return parts[0] if len(parts) == 1 else tuple(reduce(add, column) for column in zip(*parts, strict=True))


def extremes(field: NDArray[Any]) -> tuple[float, float]:
    """Return the least and the greatest value of a plane."""
    lows, highs = zip(*run(lambda a, b: (field[a:b].min(), field[a:b].max()), spans(*field.shape)), strict=True)
    return float(min(lows)), float(max(highs))
