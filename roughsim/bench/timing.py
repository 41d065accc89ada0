"""How long something takes: CPU seconds of one thread, the least of a few calls."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any


def cpu_seconds(work: Callable[[], Any], *, repeats: int = 3, enough: float = 1.0) -> float:
    """Return the least CPU time of up to `repeats` calls, s, after a first one that fills caches; `enough` s end it."""
    start = time.process_time()
    work()
    if time.process_time() - start > enough:
        return time.process_time() - start
    spent: list[float] = []
    while len(spent) < repeats and sum(spent) < enough:
        start = time.process_time()
        work()
        spent.append(time.process_time() - start)
    return min(spent)
