"""Trends of a study: the change of an observable between neighbours with the same surfaces."""

from collections.abc import Iterator, Mapping
from itertools import pairwise
from math import log, nan
from typing import Any

import numpy as np

from roughsim.estimate.errors import quotient
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.results.run import Run
from roughsim.studies.results import StudyResults
from roughsim.studies.vary import Point
from roughsim.table import Estimate


def trends_of(study: StudyResults, observable: str, column: str | None) -> Iterator[dict[str, Any]]:
    """Yield the trends of an observable along each varied number; see `Study.trends`."""
    runs = {point.name: run for point, run in study.results}
    for key in study.numeric_keys:
        for line in _lines_along(study, key):
            for before, point in pairwise(point for point in line if point.name in runs):
                run, run_before = runs[point.name], runs[before.name]
                if run.scene.cases != run_before.scene.cases or _surfaces(run) != _surfaces(
                    run_before
                ):
                    continue
                start, end = before.values[key], point.values[key]
                head = {"point": point.name, "before": before.name}
                head |= {study.keys[other]: value for other, value in point.values.items()}
                head |= {"key": study.keys[key], "from": start, "to": end}
                log_of_key = log(end / start) if min(start, end) > 0.0 and start != end else nan
                for change in _changes(run, run_before, observable, column, log_of_key):
                    yield head | change


def _lines_along(study: StudyResults, key: str) -> list[list[Point]]:
    """Return lines of points that differ only in a key and the keys coupled to it, in ascending order of the key."""
    together = next(axis.keys for axis in study.axes if key in axis.keys)
    lines: dict[tuple[str, ...], list[Point]] = {}
    for point in study.points:
        others = tuple(str(value) for other, value in point.values.items() if other not in together)
        lines.setdefault(others, []).append(point)
    return [sorted(line, key=lambda point: float(point.values[key])) for line in lines.values()]


def _changes(
    run: Run, before: Run, observable: str, column: str | None, log_of_key: float
) -> Iterator[dict[str, Any]]:
    """Yield the ratio of two runs and the exponent at each speed, but at rest.

    `log_of_key` is the logarithm of the ratio of their values of a key; NaN if it has none.
    """
    ratio = paired_ratio(run, before, observable, column)
    kinds, kinds_before = _kinds(run, observable, column), _kinds(before, observable, column)
    no_speed: list[Mapping[str, float | None]] = [{"speed": None}]
    for k, at in enumerate(run.scene.cases if OBSERVABLES[observable].per_speed else no_speed):
        value = ratio.mean[k]
        if not value > 0.0:
            continue
        same_kind = kinds[k] == kinds_before[k]
        exponent = float(np.log(value) / log_of_key)
        error = float(ratio.budget["statistical"][k] / (value * abs(log_of_key)))
        yield {
            **at,
            "ratio": float(value),
            "standard_error": float(ratio.standard_error[k]),
            "total_error": float(ratio.total_error[k]),
            "unknown": ", ".join(ratio.unknown_at(k)),
            "exponent": exponent if same_kind else nan,
            "exponent_error": error if same_kind else nan,
        }


def _kinds(run: Run, observable: str, column: str | None) -> list[tuple[tuple[str, ...], str]]:
    """Return the unknown parts and the note of each value: values that differ in them make no trend."""
    name = run.column(column)
    estimate = run.estimate(observable, name)
    places = np.ndindex(estimate.mean.shape)
    return [(estimate.unknown_at(*place), str(estimate.note[place])) for place in places]


def _surfaces(run: Run) -> tuple[Any, ...]:
    """Return seed, levels and cell, which are equal in runs with the same surfaces."""
    return run.seed, run.numerics.levels, run.numerics.lengths


def paired_ratio(above: Run, below: Run, observable: str, column: str | None = None) -> Estimate:
    """Return the ratio of an observable of two runs with the same levels and surfaces, and its paired errors.

    Temperatures include the heat share of each run. A surface of only one of them adds its whole scatter. ValueError
    for runs without common surfaces.
    """
    if _surfaces(above) != _surfaces(below):
        raise ValueError(
            f"{above.folder} and {below.folder} have other levels or surfaces: their rows are no pairs"
        )
    numerator, denominator = above.reported(observable, column), below.reported(observable, column)
    return quotient(numerator, denominator, scanned=above.scene.scanned)
