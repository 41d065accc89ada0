"""Work on one array shared out in blocks: the same blocks, and so the same bits, for any number of threads."""

import itertools
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import reduce
from operator import add
from typing import Any

from numpy.typing import NDArray

from roughsim.fourier.plans import get_threads

POINTS = 1 << 18  # in a block: small enough for the cache, large enough for two threads to gain
_pools: dict[tuple[int, int], ThreadPoolExecutor] = {}


def spans(rows: int, columns: int) -> list[tuple[int, int]]:
    """Ranges of an even number of rows, about `POINTS` points each."""
    height = max(POINTS // columns // 2 * 2, 2)
    return [(a, min(a + height, rows)) for a in range(0, rows, height)]


def run(task: Callable[..., Any], blocks: list[Any]) -> list[Any]:
    """Return ``[task(*block) for block in blocks]``, computed by all threads."""
    threads = min(get_threads(), len(blocks))
    if threads <= 1:
        return [task(*block) for block in blocks]
    results: list[Any] = [None] * len(blocks)
    order = itertools.count()

    def work() -> None:
        while (k := next(order)) < len(blocks):
            results[k] = task(*blocks[k])

    key = os.getpid(), threads - 1  # threads do not survive a fork
    if key not in _pools:
        _pools[key] = ThreadPoolExecutor(threads - 1, thread_name_prefix="roughsim")
    others = [_pools[key].submit(work) for _ in range(threads - 1)]
    try:
        work()
    finally:
        for other in others:
            other.result()
    return results


def total(parts: list[Any]) -> Any:
    """Sum tuples of partial sums, in the order of the blocks."""
    return parts[0] if len(parts) == 1 else tuple(reduce(add, column) for column in zip(*parts, strict=True))


def extremes(field: NDArray[Any]) -> tuple[float, float]:
    """Return the least and the greatest value of a plane."""
    lows, highs = zip(*run(lambda a, b: (field[a:b].min(), field[a:b].max()), spans(*field.shape)), strict=True)
    return float(min(lows)), float(max(highs))
