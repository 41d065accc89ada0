"""Work on one array shared out in blocks: the same blocks, and so the same bits, for any number of threads."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from functools import reduce
from operator import add
from typing import Any

from roughsim.fourier.plans import get_threads, thread_cache
from roughsim.grid import Field

POINTS = 1 << 18  # in a block: small enough for the cache, large enough for two threads to gain


def spans(rows: int, columns: int) -> list[tuple[int, int]]:
    """Ranges of an even number of rows, about `POINTS` points each."""
    height = max(POINTS // columns // 2 * 2, 2)
    return [(a, min(a + height, rows)) for a in range(0, rows, height)]


def run(task: Callable[..., Any], blocks: list[Any]) -> list[Any]:
    """Return ``[task(*block) for block in blocks]``, computed by all threads."""
    threads = get_threads()  # read once, as another Python thread may set it meanwhile
    if threads == 1 or len(blocks) == 1:
        return [task(*block) for block in blocks]
    # a pool of each Python thread: a task that shares out work of its own never waits for itself
    pool = thread_cache("pool", threads, lambda: ThreadPoolExecutor(threads), most=1)
    futures = [pool.submit(task, *block) for block in blocks]
    wait(futures)
    return [future.result() for future in futures]


def total(parts: list[Any]) -> Any:
    """Sum tuples of partial sums, in the order of the blocks."""
    if len(parts) == 1:
        return parts[0]
    return tuple(reduce(add, column) for column in zip(*parts, strict=True))


def extremes(field: Field) -> tuple[float, float]:
    """Return the least and the greatest value of a plane."""
    parts = run(lambda a, b: (field[a:b].min(), field[a:b].max()), spans(*field.shape))
    lows, highs = zip(*parts, strict=True)
    return float(min(lows)), float(max(highs))
