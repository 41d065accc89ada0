"""The map as tables: measured/theory with total errors, from the raw members of all points."""

from __future__ import annotations

from math import nan
from typing import Any

import numpy as np
from scipy.stats import t as student

from roughsim.record.validity import Table
from theory import persson, plasticity
from validity_map import capped, elastic, estimates
from validity_map.members import PECLET

GAMMA = 0.45
EXPONENT_DOUBT = 0.25  # of the step from 16 q_y to infinity: the exponent of the extrapolation was 0.9 ... 1.15
ELASTIC = ("load", "hurst", "bandwidth", "plateau", "low_exponent")
CAPPED = ("share", "yields", "hurst", "plateau", "low_exponent")
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
    """Return smoothed/theory, capped/smoothed and capped/theory of capped points."""
    rows = [_capped_row(point, raw) for point, raw in results]
    place = np.array([[getattr(point, name) for name in CAPPED] for point, _ in results], dtype=float)
    labels = tuple(point.label for point, _ in results)
    named = _named(CAPPED_QUANTITIES)
    return {
        name: Table(CAPPED, labels, named, place, *(np.array([row[name][k] for row in rows]) for k in (0, 1)))
        for name in ("smoothed", "steps", "capped")
    }


def _capped_row(point: capped.CappedPoint, raw: Any) -> dict[str, tuple[Any, Any]]:
    load = point.pressures["nominal_pressure"]
    theory = estimates.theory_values(point.smoothed, load, gamma=GAMMA)
    values = {name: np.empty(len(CAPPED_QUANTITIES)) for name in ("smoothed", "steps", "capped")}
    errors = {name: np.empty(len(CAPPED_QUANTITIES)) for name in values}
    for k, quantity in enumerate(CAPPED_QUANTITIES):
        smooth, far, doubt = _columns(raw, quantity)
        half = {"smoothed": _half_width(smooth), "capped": float(np.hypot(_half_width(far), doubt))}
        half["steps"] = float(np.hypot(half["smoothed"], half["capped"]))
        logs = {"smoothed": smooth.mean() - theory[quantity], "steps": far.mean() - smooth.mean()}
        logs["capped"] = far.mean() - theory[quantity]
        for name, value in logs.items():
            values[name][k], errors[name][k] = np.exp(value), half[name]
    return {name: (values[name], errors[name]) for name in values}


def _half_width(members: Any) -> float:
    return float(student.ppf(0.975, members.size - 1) * members.std(ddof=1) / np.sqrt(members.size))


def _columns(raw: Any, quantity: tuple[str, int]) -> tuple[Any, Any, float]:
    """Return ln Q of C_sm and of capped contact at q_c = infinity, linearised per member, and the doubt of the latter.

    The pixel shift comes from the same modes at half the pixel; as the error falls at first order, what is left is the
    shift once more.
    """

    def linearised(functionals: Any) -> Any:
        value, gradient = estimates.linear(functionals.mean(axis=0), quantity)
        return value + functionals @ gradient - (functionals @ gradient).mean()

    near, finest = (linearised(raw[name]) for name in sorted((n for n in raw if n.startswith("capped")), key=_cutoff))
    step, fine = finest - near, linearised(raw["fine"])
    pixel = float((fine - near[: fine.size]).mean())
    doubt = float(np.hypot(EXPONENT_DOUBT * step.mean(), 0.5 * pixel))
    return linearised(raw["smoothed"]), finest + step + 2 * pixel, doubt


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
