"""What the map says, as text."""

from __future__ import annotations

from typing import Any

import numpy as np

import roughsim
from theory import persson
from theory.calibrated import LIGHTEST
from validity_map import capped, elastic, estimates
from validity_map.fit import SCORED
from validity_map.tables import GAMMA, area_ratios, limits


def provenance() -> dict[str, Any]:
    """Return what made the map."""
    return {"program": f"roughsim {roughsim.__version__}", "script": "experiments/validity.py", "gamma": GAMMA}


def show(tables: Any, results: dict[str, list[Any]], plastics: list[Any]) -> None:
    """Print the map, how well the calibrated spectrum does on each set of points, and the capped part."""
    _ratios("elastic, all points: simulated / theory", tables["elastic"])
    score("published form (gamma 0.45), all points", results["grid"], gamma=GAMMA)
    for name, words in (
        ("fitted", "calibrated form, fitted part of the grid"),
        ("judged", "calibrated form, the rest of the grid"),
        ("families", "calibrated form, other long waves"),
        ("fresh", "calibrated form, fresh points off the grid"),
    ):
        if results.get(name):
            score(words, results[name])
    for name in ("smoothed", "steps", "capped"):
        _ratios(f"capped part, {name}, C(q) without end", limits(tables[name]))
    for point, raw in plastics:
        _show_capped(point, raw)


def _ratios(title: str, table: Any) -> None:
    print(f"{title} ({table.place.shape[0]} points): median, range, largest total error")
    for k, (name, peclet) in enumerate(table.quantities):
        value, error = table.value[:, k], table.error[:, k]
        words = name if np.isnan(peclet) else f"{name} Pe {peclet:g}"
        print(
            f"  {words:30}{np.median(value):7.3f}  {value.min():6.3f} … {value.max():6.3f}  ± {100 * error.max():.1f} %"
        )


_KNOWN: dict[tuple[elastic.Point, float | None], tuple[Any, Any]] = {}  # the score and the chart ask for the same


def misses(point: elastic.Point, raw: Any, gamma: float | None = None) -> tuple[Any, Any]:
    """Return ln(form/simulated) of the scored quantities and their standard errors; calibrated if `gamma` is None."""
    if (point, gamma) not in _KNOWN:
        weight: dict[str, Any] = {"gamma": gamma}
        if gamma is None:
            pressures = {"effective_modulus": 1.0, "nominal_pressure": point.load}
            weight = {"stress_spectrum": persson.calibrated_spectrum(point.spectrum, **pressures)}
        form, measured = estimates.theory_values(point.spectrum, point.load, **weight), estimates.estimate(raw)
        logs = np.array([form[q] - measured[q][0] for q in SCORED])
        _KNOWN[point, gamma] = logs, np.array([measured[q][1] / 2 for q in SCORED])
    return _KNOWN[point, gamma]


def score(title: str, results: list[Any], gamma: float | None = None) -> None:
    """Print rms and worst of form/simulated − 1 over points in the calibrated range."""
    rows = [misses(point, raw, gamma) for point, raw in results if point.load >= LIGHTEST]
    logs, standard = (np.array([row[k] for row in rows]) for k in (0, 1))
    error = np.expm1(logs)
    place = np.unravel_index(np.argmax(abs(error)), error.shape)
    points = [point for point, _ in results if point.load >= LIGHTEST]
    name, k = SCORED[place[1]]
    print(
        f"{title}: {len(rows)} points, {error.size} numbers, rms {np.sqrt((error**2).mean()):.2%}, worst "
        f"{error[place]:+.1%} ({name}, speed {k}, {points[place[0]].name}), "
        f"beyond 5 % + 2 standard errors: {(abs(error) > 0.05 + 2 * standard).sum()}"
    )
    print("  rms by quantity:", ", ".join(f"{n}[{k}] {r:.1%}" for (n, k), r in zip(SCORED, _rms(error), strict=True)))


def _rms(error: Any) -> Any:
    return np.sqrt((error**2).mean(axis=0))


def _show_capped(point: capped.CappedPoint, raw: Any) -> None:
    ratios = ", ".join(
        f"{row['factor']:g}: {row['total'] / row['theory_total']:.2f} (pixels counted "
        f"{row['raw_total'] / row['theory_total']:.2f}), yielded {row['plastic'] / row['theory_plastic']:.2f}"
        for row in area_ratios(point, raw)
    )
    kept = np.nanmean(raw["psd_ratio"], axis=0)
    print(f"  {point.name}: area/theory at q_c/q_y {ratios}")
    print(
        f"    worn surface keeps {np.nanmin(kept):.2f} … {np.nanmax(kept):.2f} "
        f"of C(q); its elastic reload differs by {raw['reload'].max():.1e}"
    )
