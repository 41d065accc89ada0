"""One way to compute something: what it errs by, and what it costs."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from math import nan
from typing import Any, NamedTuple


class Point(NamedTuple):
    """One method at one setting.

    Attributes
    ----------
    stage, observable, method, setting : str
        What was measured of what, and how; points of one method form a line.
    error : float
        Relative error; NaN where the method failed.
    seconds : float
        CPU seconds of one thread.
    chosen : bool
        Whether the plan computes it so.
    pairs : float
        The same cost in pairs of transforms of `PAIR_SIDE`² points.
    """

    stage: str
    observable: str
    method: str
    setting: str
    error: float
    seconds: float
    chosen: bool = False
    pairs: float = nan

    def row(self, pair: float) -> dict[str, float | str]:
        """Return it as a row of a file, its cost also in pairs of transforms of `pair` seconds."""
        values: dict[str, float | str] = self._asdict() | {"pairs": self.seconds / pair, "chosen": float(self.chosen)}
        del values["stage"]
        return values

    @classmethod
    def from_row(cls, stage: str, row: Mapping[str, Any]) -> Point:
        """Return the point that `row` gave."""
        return cls(stage, **{**row, "chosen": bool(row["chosen"])})


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
