"""What the map says, as text."""

from __future__ import annotations

from typing import Any

import numpy as np

import roughsim
from theory import persson
from validity_map import capped, elastic, estimates
from validity_map.tables import area_ratios

SCORED = [
    *(("flash_temperature", k) for k in (0, 3, 6)),
    ("pressure_variance", 0),
    *(("flash_width", k) for k in (0, 3, 6)),
    *(("slope_length", k) for k in (3, 6)),
]


def provenance() -> dict[str, Any]:
    return {"program": f"roughsim {roughsim.__version__}", "script": "experiments/validity.py", "gamma": 0.45}


def show(tables: Any, elastics: list[Any], plastics: list[Any]) -> None:
    table = tables["elastic"]
    print(f"elastic: {len(elastics)} points, measured/theory (gamma 0.45), median and range, median total error")
    for k, (name, peclet) in enumerate(table.quantities):
        value = table.value[:, k]
        where = "" if np.isnan(peclet) else f" Pe {peclet:g}"
        print(
            f"  {name + where:32}{np.median(value):7.3f}  {value.min():6.3f} ... {value.max():6.3f}"
            f"  +- {np.median(table.error[:, k]):.3f}"
        )
    _score("calibrated spectrum on the map", elastics)
    for point, raw in plastics:
        for row in area_ratios(point, raw):
            print(
                f"  {point.name} q_c/q_y {row['factor']:4g}: area/theory {row['total'] / row['theory_total']:.3f}, "
                f"yielded {row['plastic'] / row['theory_plastic']:.3f}"
            )


def misses(point: elastic.Point, raw: Any) -> tuple[Any, Any]:
    """Return ln(calibrated/measured) of the scored quantities, and their standard errors."""
    measured = estimates.estimate(raw)
    spectrum = persson.calibrated_spectrum(point.spectrum, effective_modulus=1.0, nominal_pressure=point.load)
    form = estimates.theory_values(point.spectrum, point.load, stress_spectrum=spectrum)
    return (
        np.array([form[q] - measured[q][0] for q in SCORED]),
        np.array([measured[q][1] / 2 for q in SCORED]),
    )


def _score(title: str, elastics: list[Any]) -> None:
    rows = [misses(point, raw) for point, raw in elastics if point.load >= 0.005]
    error, standard = (np.array([row[k] for row in rows]) for k in (0, 1))
    print(f"{title}: rms {np.sqrt((error**2).mean()):.2%}, worst {abs(error).max():.2%}")
    print(f"  beyond 5 % + 2 standard errors: {(abs(error) > 0.05 + 2 * standard).sum()} of {error.size}")


__all__ = ["capped", "misses", "provenance", "show"]
