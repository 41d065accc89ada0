"""The map as tables: measured/theory with total errors, from the raw members of all points."""

from __future__ import annotations

from itertools import pairwise
from math import inf, nan
from typing import Any, NamedTuple

import numpy as np
from scipy.stats import t as student

from roughsim.comparison.validity_map import Table
from theory import persson, plasticity
from validity_map import capped, elastic, estimates
from validity_map.members import PECLET

GAMMA = 0.45
LONGEST, SHORTEST = 0.2, 0.8  # what a step of the ladder may be of the one before: exponents 2.3 ... 0.3
PIXEL_DOUBT = 0.002  # of elastic contact on C_sm: T_flash changes by less with finer pixels and a later end
REST_DOUBT = 0.1  # of what lies beyond the ladder, beside what its last rung changed of the limit
CROSSED = 5.0  # q_c/q_r over the Péclet number at which the share of a step is halfway to that of slow sliding
OCTAVES = 80  # that are followed
UNTRIED = 0.5  # of it with three rungs: no limit without the last one is there
ELASTIC = ("load", "hurst", "bandwidth", "plateau", "low_exponent")
CAPPED = ("share", "yields", "hurst", "plateau", "low_exponent")
LAST_PIXELS = 0.5  # of what 8 pixels per shortest wave change of 4: what finer ones still change, give or take as much
UNSEEN_PIXELS = 0.5  # of what the pixels change where it is only inferred from the rungs below
CAPPED_QUANTITIES = [*(("flash_temperature", k) for k in range(PECLET.size)), ("pressure_variance", 0)]


def _named(quantities: list[tuple[str, int]]) -> tuple[tuple[str, float], ...]:
    per_speed = estimates.PER_SPEED
    return tuple((name, float(PECLET[k]) if name in per_speed else nan) for name, k in quantities)


def elastic_table(results: list[tuple[elastic.Point, Any]]) -> Table:
    """Return measured/theory (gamma = GAMMA) of elastic points."""
    quantities = [*estimates.QUANTITIES, ("contact_fraction", 0)]
    rows = [_elastic_row(point, raw, quantities) for point, raw in results]
    place = np.array([[getattr(point, name) for name in ELASTIC] for point, _ in results], dtype=float)
    value, error = (np.array([row[k] for row in rows]) for k in (0, 1))
    return Table(ELASTIC, ("",) * len(rows), _named(quantities), place, value, error)


def _elastic_row(point: elastic.Point, raw: Any, quantities: list[tuple[str, int]]) -> tuple[Any, Any]:
    measured = estimates.estimate(raw)
    theory = estimates.theory_values(point.spectrum, point.load, gamma=GAMMA)
    value = np.exp([measured[q][0] - theory[q] for q in quantities])
    return value, np.array([measured[q][1] for q in quantities])


def capped_tables(results: list[tuple[capped.CappedPoint, Any]]) -> dict[str, Table]:
    """Return smoothed/theory, capped/smoothed and capped/theory of capped points; the last also by q_max/q_y."""
    rows = [_capped_row(point, raw) for point, raw in results]
    place = np.array([[getattr(point, name) for name in CAPPED] for point, _ in results], dtype=float)
    labels = tuple(point.label for point, _ in results)
    named = _named(CAPPED_QUANTITIES)
    tables = {
        name: Table(CAPPED, labels, named, place, *(np.array([row[name][k] for row in rows]) for k in (0, 1)))
        for name in ("smoothed", "steps", "capped")
    }
    return tables | {"capped": by_depth(tables["capped"], results)}


def limits(table: Table) -> Table:
    """Return the rows of a table for C(q) without end: all, if q_max/q_y is no coordinate of it."""
    if "depth" not in table.coordinates:
        return table
    rows = np.flatnonzero(np.isinf(table.place[:, -1]))
    labels = tuple(table.labels[k] for k in rows)
    return Table(CAPPED, labels, table.quantities, table.place[rows, :-1], table.value[rows], table.error[rows])


def by_depth(limits: Table, results: list[tuple[capped.CappedPoint, Any]]) -> Table:
    """Return capped/theory with q_max/q_y as one more coordinate: the limits, and where C(q) ends before."""
    finite = [
        (point, depth, *_at_depth(point, raw, depth))
        for point, raw in results
        for depth in capped.DEPTHS
        if f"capped{depth:g}" in raw
    ]
    place = [[*(getattr(point, name) for name in CAPPED), depth] for point, depth, _, _ in finite]
    return Table(
        (*CAPPED, "depth"),
        (*limits.labels, *(point.label for point, *_ in finite)),
        limits.quantities,
        np.vstack([np.column_stack([limits.place, np.full(len(limits.place), inf)]), np.array(place)]),
        np.vstack([limits.value, *(value for *_, value, _ in finite)]),
        np.vstack([limits.error, *(error for *_, error in finite)]),
    )


def _at_depth(point: capped.CappedPoint, raw: Any, depth: float) -> tuple[Any, Any]:
    """Return capped/theory and its error for C(q) that ends at q_max = depth q_y."""
    cut = point.spectrum.truncated(q_max=depth * point.yields)
    smoothed = plasticity.smoothed_spectrum(cut, **point.pressures)
    theory = estimates.theory_values(smoothed, point.pressures["nominal_pressure"], gamma=GAMMA)
    factors = [f for f in sorted(_cutoff(name) for name in raw if name.startswith("capped")) if f <= depth]
    logs, errors = [], []
    for quantity in CAPPED_QUANTITIES:
        first, steps, scatter = chain([_linearised(raw[f"capped{f:g}"], quantity) for f in factors])
        pixels, doubt = _pixels(raw, quantity, depth)
        logs.append(first + float(steps.sum()) + pixels - theory[quantity])
        errors.append(float(np.hypot(np.linalg.norm(scatter[-1]), doubt)))
    return np.exp(logs), np.array(errors)


def _pixels(raw: Any, quantity: tuple[str, int], depth: float) -> tuple[float, float]:
    """Return what vanishing pixels change of ln Q at a rung with two pixels per shortest wave, and its error."""

    def change(rung: float, pixels: int) -> tuple[float, float]:
        fine = raw[f"finer{pixels}-{rung:g}"]
        coarse = raw[f"capped{rung:g}"][: fine.shape[0]]
        each = _linearised(fine, quantity) - _linearised(coarse, quantity)
        return float(each.mean()), half_width(each)

    measured = [rung for rung, many in capped.FINER.items() if len(many) > 1]
    rung = min(depth, measured[-1])
    four, (eight, scatter) = change(rung, 4)[0], change(rung, 8)
    value, doubt = eight + LAST_PIXELS * (eight - four), LAST_PIXELS * abs(eight - four)
    if depth > rung:  # the same share of what 4 pixels change, which falls from rung to rung
        share = np.clip(change(2 * rung, 4)[0] / four, 0.0, 1.0) if four else 0.0
        value, doubt, scatter = (x * share ** np.log2(depth / rung) for x in (value, doubt, scatter))
        if depth > 2 * rung:
            doubt = np.hypot(doubt, UNSEEN_PIXELS * value)
    return float(value), float(np.hypot(doubt, scatter))


def _capped_row(point: capped.CappedPoint, raw: Any) -> dict[str, tuple[Any, Any]]:
    load = point.pressures["nominal_pressure"]
    theory = estimates.theory_values(point.smoothed, load, gamma=GAMMA)
    rows: dict[str, list[tuple[float, float]]] = {name: [] for name in ("smoothed", "steps", "capped")}
    for quantity in CAPPED_QUANTITIES:
        smooth, scatter = _mean(raw["smoothed"], quantity)
        smooth_error = float(np.hypot(scatter, PIXEL_DOUBT))
        far, error = limit(raw, quantity, point.yields)
        rows["smoothed"].append((smooth - theory[quantity], smooth_error))
        rows["steps"].append((far - smooth, float(np.hypot(smooth_error, error))))
        rows["capped"].append((far - theory[quantity], error))
    return {name: (np.exp([ln for ln, _ in row]), np.array([error for _, error in row])) for name, row in rows.items()}


def _linearised(functionals: Any, quantity: tuple[str, int]) -> Any:
    """Return ln Q of the mean, spread over the members to first order."""
    value, gradient = estimates.linear(functionals.mean(axis=0), quantity)
    return value + functionals @ gradient - (functionals @ gradient).mean()


def _mean(functionals: Any, quantity: tuple[str, int]) -> tuple[float, float]:
    members = _linearised(functionals, quantity)
    return float(members.mean()), half_width(members)


def limit(raw: Any, quantity: tuple[str, int], yields: float = 1.0) -> tuple[float, float]:
    """Return ln Q of capped contact at q_c = infinity, and its total 95 % error.

    Rungs are chained by regression over the members that they share: members with few large spots change least. Beyond
    the last rung each step is a share of the one before, from the last two steps. That share is lower for slow sliding
    than for fast one, and once q_c/q_r passes the Péclet number it goes over to the slow one. The error: scatter of
    every rung, what the last one changed, and a part of what lies beyond. `yields` is q_y/q_r.
    """
    factors = sorted(_cutoff(name) for name in raw if name.startswith("capped"))
    rungs = [raw[f"capped{factor:g}"] for factor in factors]
    levels, slow, place = [_linearised(rung, quantity) for rung in rungs], None, 0.0
    if quantity[0] == "flash_temperature":
        slow = [_linearised(rung, ("flash_temperature", 0)) for rung in rungs]
        place = factors[-1] * yields / PECLET[quantity[1]]
    end = ladder_end(levels, slow, place)
    return end.value, float(np.hypot(np.linalg.norm(end.scatter), end.doubt))


class LadderEnd(NamedTuple):
    """Where a ladder goes to: ln Q, its 95 % errors from the scatter of each rung, its doubt, ln Q of the last rung."""

    value: float
    scatter: Any
    doubt: float
    last: float


def ladder_end(levels: list[Any], slow: list[Any] | None = None, place: float = 0.0) -> LadderEnd:
    """Return the end of a ladder from ln Q of the members of each rung; `slow`: T_flash at rest, `place` as `_end`."""
    first, steps, scatter = chain(levels)
    resting = steps if slow is None else chain(slow)[1]
    value = _end(steps, resting, place)
    slopes = np.array([_end(steps + unit, resting + unit, place) - value for unit in 1e-5 * np.eye(steps.size)]) / 1e-5
    total = scatter[0] + slopes @ np.diff(scatter, axis=0)
    rest = value - steps.sum()
    doubt = UNTRIED * rest
    if steps.size > 2:
        doubt = np.hypot(value - _end(steps[:-1], resting[:-1], place / 2), REST_DOUBT * rest)
    return LadderEnd(first + value, total, float(abs(doubt)), first + float(steps.sum()))


def chain(levels: list[Any]) -> tuple[float, Any, Any]:
    """Return ln Q of the first rung, the steps to the others, and their 95 % errors by independent causes."""
    steps, scatter = np.empty(len(levels) - 1), np.zeros((len(levels), len(levels)))
    first = here = float(levels[0].mean())
    scatter[0, 0] = half_width(levels[0])
    for k, (coarse, fine) in enumerate(pairwise(levels)):
        steps[k], slope, own = _step(coarse[: fine.size], fine, here)
        scatter[k + 1] = (1.0 + slope) * scatter[k]
        here, scatter[k + 1, k + 1] = here + steps[k], own
    return first, steps, scatter


def _step(coarse: Any, fine: Any, level: float) -> tuple[float, float, float]:
    """Return the step between rungs where the coarse one is `level`, how it goes with it, and its own 95 % error."""
    change, n = fine - coarse, fine.size
    slope = float(np.cov(change, coarse)[0, 1] / coarse.var(ddof=1)) if coarse.std() > 1e-12 else 0.0
    rest = change - slope * (coarse - level)
    return float(rest.mean()), slope, float(student.ppf(0.975, n - 2) * rest.std(ddof=2) / np.sqrt(n))


def _end(steps: Any, slow: Any, place: float) -> float:
    """Return ln of the limit over the first rung; `slow`: steps at rest, `place`: q_c/q_r over the Péclet number."""
    (last, share), (_, least) = _last(steps), _last(slow)
    total, share_now = 0.0, last
    for octave in range(1, OCTAVES):
        over = (1.0 + (place / CROSSED) ** 2) / (1.0 + (place * 2.0**octave / CROSSED) ** 2)
        share_now *= least + (share - least) * over
        total += share_now
    return float(np.log(np.exp(steps.sum()) + total))


def _last(steps: Any) -> tuple[float, float]:
    """Return the last step of Q itself, and its share of the one before."""
    q = np.exp(np.concatenate([[0.0], np.cumsum(steps)]))
    last, before = q[-1] - q[-2], q[-2] - q[-3]
    return float(last), float(np.clip(last / before, LONGEST, SHORTEST)) if before != 0.0 else LONGEST


def half_width(members: Any) -> float:
    return float(student.ppf(0.975, members.size - 1) * members.std(ddof=1) / np.sqrt(members.size))


def _cutoff(name: str) -> float:
    return float(name.removeprefix("capped"))


def area_ratios(point: capped.CappedPoint, raw: Any) -> list[dict[str, float]]:
    """Return, per magnification, theory and measured elastic, plastic and total area, corrected and extrapolated."""
    rows = []
    factors = [f for f in capped.MAGNIFICATIONS if f * point.yields > 1.5 / point.plateau]
    for factor, areas in zip(factors, raw["areas"], strict=True):
        variance = persson.half_variance(factor * point.yields, point.spectrum, effective_modulus=1.0)
        _, elastic_area, plastic_area = plasticity.area_fractions(
            variance, point.pressures["nominal_pressure"], point.hardness
        )
        coarse, fine = areas.mean(axis=1)
        total, yielded = 2 * fine[1] - coarse[1], 2 * fine[3] - coarse[3]
        rows.append(
            {
                "factor": factor,
                "theory_total": float(elastic_area + plastic_area),
                "theory_plastic": float(plastic_area),
                "total": float(total),
                "plastic": float(yielded),
                "total_error": float(0.5 * abs(fine[1] - coarse[1])),
                "plastic_error": float(0.5 * abs(fine[3] - coarse[3])),
                "raw_total": float(coarse[0]),
            }
        )
    return rows
