"""The trends of a study: how an observable changes between neighbours that see the same surfaces.

`study` is a `roughsim.Study` everywhere; its method `trends` calls `trends_of`.
"""

from collections.abc import Iterator
from itertools import pairwise
from math import log, nan
from typing import Any

import numpy as np

from roughsim.estimate.errors import Uncertain, quotient
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.results.marks import notes_of, unknown_words
from roughsim.results.run import Run
from roughsim.studies.vary import Point


def trends_of(study: Any, observable: str, column: str | None) -> Iterator[dict[str, Any]]:
    """Yield the trends of an observable along each varied number; see `Study.trends`."""
    runs = {point.name: run for point, run in study.results}
    for key in study.numeric_keys:
        together = next(axis.keys for axis in study.axes if key in axis.keys)
        lines: dict[tuple[str, ...], list[Point]] = {}
        for point in study.points:
            others = tuple(str(value) for other, value in point.values.items() if other not in together)
            lines.setdefault(others, []).append(point)
        for line in lines.values():
            line.sort(key=lambda point: float(point.values[key]))
            for low, high in pairwise(point for point in line if point.name in runs):
                run, before = runs[high.name], runs[low.name]
                if run.scene.speeds != before.scene.speeds or surfaces(run) != surfaces(before):
                    continue
                names = {study.keys[other]: value for other, value in high.values.items()}
                start, end = low.values[key], high.values[key]
                head = {"point": high.name, "before": low.name, **names}
                head |= {"key": study.keys[key], "from": start, "to": end}
                log_of_key = log(end / start) if min(start, end) > 0.0 and start != end else nan
                for change in changes(run, before, observable, column, log_of_key):
                    yield head | change


def changes(run: Run, before: Run, observable: str, column: str | None, log_of_key: float) -> Iterator[dict[str, Any]]:
    """Yield the ratio of two runs and the exponent for each speed at which something is warm.

    `log_of_key` is the logarithm of the ratio of their values of a key; NaN where it has none.
    """
    ratio = paired_ratio(run, before, observable, column)
    kinds, kinds_before = (kinds_of(each, observable, column) for each in (run, before))
    speeds = run.scene.speeds if OBSERVABLES[observable].per_speed else (None,)
    for k, speed in enumerate(speeds):
        value = ratio.mean[k]
        if not value > 0.0:  # at rest
            continue
        exponent = np.log(value) / log_of_key
        error = ratio.budget["statistical"][k] / (value * abs(log_of_key))
        same_kind = kinds[k] == kinds_before[k]
        yield {
            "speed": speed,
            "ratio": float(value),
            "standard_error": float(ratio.standard_error[k]),
            "total_error": float(ratio.total_error[k]),
            "unknown": unknown_words(ratio.unknown_at(k)),
            "exponent": float(exponent) if same_kind else nan,
            "exponent_error": float(error) if same_kind else nan,
        }


def kinds_of(run: Run, observable: str, column: str | None = None) -> list[tuple[tuple[str, ...], str]]:
    """Return the unknown parts and the note of each entry of an estimate: values that differ in them make no trend."""
    name = run.column(column)
    estimate = run.estimate(observable, name)
    return [(estimate.unknown_at(k), note) for k, note in enumerate(notes_of(run, name, estimate))]


def surfaces(run: Run) -> tuple[Any, ...]:
    """Return what two runs must have in common so that their rows are pairs."""
    return run.seed, run.numerics.levels, run.numerics.lengths


def paired_ratio(above: Run, below: Run, observable: str, column: str | None = None) -> Uncertain:
    """Return the ratio of an observable of two runs with the same levels and surfaces, and its paired errors.

    Temperatures are those of the heat share of each run. Of a surface that only one of them has, the scatter counts in
    full. Without common surfaces (another seed or other levels) ValueError.
    """
    if surfaces(above) != surfaces(below):
        raise ValueError(f"{above.folder} and {below.folder} have other levels or surfaces: their rows are no pairs")
    over, under = (run.reported(observable, column) for run in (above, below))
    sizes = [run.size_error(observable, run.column(column), own) for run, own in ((above, over), (below, under))]
    return quotient(
        over,
        under,
        size=np.hypot(*sizes),
        solver=OBSERVABLES[observable].solver_share * max(above.numerics.tolerance, below.numerics.tolerance),
        scanned=above.scene.scanned,
    )
