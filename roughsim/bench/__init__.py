"""Speed against accuracy: what each stage of a scene, and the whole chain, errs by at what cost.

Errors are against exact or tightly converged values, costs are CPU seconds of one thread. Their ratio to one pair of
transforms, timed in the same run, is what carries over to other machines.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Collection, Iterator
from math import isnan
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from roughsim import fourier
from roughsim.bench.chain import KNOWN, chain
from roughsim.bench.stages import contact, cpu_seconds, heat, moments, surface, theory
from roughsim.charts import error_over_cost_chart
from roughsim.charts.error_over_cost import Point, front
from roughsim.planning.plan import plan
from roughsim.show.table import Column, Number, Row, Table
from roughsim.store.rows import Rows

if TYPE_CHECKING:
    from roughsim.scene import Scene
    from roughsim.scene.numerics import Numerics

STAGES: dict[str, Callable[[Scene, Numerics, int], Iterator[Point]]] = {
    stage.__name__: stage for stage in (surface, contact, heat, moments, theory, chain)
}
PAIR_SIDE = 512  # points per side of the transforms that costs are compared with


def bench(
    scene: Scene,
    *,
    numerics: Numerics | None = None,
    stages: Collection[str] = tuple(STAGES),
    realizations: int = 8,
    rows: Rows | None = None,
) -> list[Point]:
    """Measure error and cost of the ways to compute a scene, stage by stage.

    `numerics` is the choice that is marked, what `plan` makes of the scene if left out. Scatter and bias are measured
    over `realizations` ≥ 4. Points are stored in `rows`; a stage that is there already is not measured again.
    ValueError if a stage is unknown, there are too few realizations, or nothing slides.
    """
    for name in stages:
        if name not in STAGES:
            raise ValueError(f"stage = {name!r} is unknown; choose one of {', '.join(STAGES)}")
    if max(scene.speeds) <= 0.0:
        raise ValueError("speed = 0 m/s is the highest of the scene; nothing heats, give one above zero")
    if isinstance(realizations, bool) or int(realizations) != realizations or realizations < 4:
        raise ValueError(f"realizations = {realizations!r} must be a whole number ≥ 4: it gives scatter and bias")
    numerics = plan(scene) if numerics is None else numerics
    rows = Rows(None) if rows is None else rows
    pair = float(rows.once("pair", f"{PAIR_SIDE}²", lambda: {"seconds": pair_seconds(PAIR_SIDE)})["seconds"])
    for name in stages:
        if rows[name]:
            continue
        measured: dict[str, dict[str, float | str]] = {}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # the errors that they warn of are what is charted
            for point in STAGES[name](scene, numerics, realizations):
                row = point._asdict() | {"pairs": point.seconds / pair, "chosen": float(point.chosen)}
                del row["stage"]
                measured[f"{point.observable} | {point.method} | {point.setting}"] = row
        rows.extend(name, measured)
    stored: list[tuple[str, dict[str, Any]]] = [(name, dict(row)) for name in stages for row in rows[name].values()]
    return [Point(name, **row | {"chosen": bool(row["chosen"])}) for name, row in stored]


def pair_seconds(side: int) -> float:
    """CPU seconds of one forward and one inverse real transform of `side`² points, float64, one thread."""
    transform = fourier.Transform((side, side), np.float64)
    transform.field[...] = np.random.default_rng(1).random((side, side))

    def pair() -> None:
        transform.forward()
        transform.inverse()

    return cpu_seconds(pair)


def panels(points: list[Point]) -> dict[str, list[Point]]:
    """Return the points of each chart: one per stage and observable."""
    result: dict[str, list[Point]] = {}
    for point in points:
        if point.method != KNOWN:
            result.setdefault(f"{point.stage}: {point.observable}", []).append(point)
    return result


def bench_chart(points: list[Point], path: Path) -> None:
    """Draw all charts of some points into one picture: error over cost, the front, and the choice of the plan."""
    doubt = {f"{p.stage}: {p.observable}": p.error for p in points if p.method == KNOWN}
    error_over_cost_chart(panels(points), path, doubt=doubt, pair=f"FFT pairs of {PAIR_SIDE}²")


def bench_dict(points: list[Point]) -> dict[str, Any]:
    """Return points as JSON values, NaN as None, with `front` where no other one of its chart is better."""
    best = {id(point) for group in panels(points).values() for point in front(group)}
    entries = [point._asdict() | {"front": id(point) in best} for point in points if point.method != KNOWN]
    undefined = ({key for key, value in e.items() if isinstance(value, float) and isnan(value)} for e in entries)
    return {"points": [e | dict.fromkeys(keys) for e, keys in zip(entries, undefined, strict=True)]}


def bench_tables(points: list[Point]) -> list[Table]:
    """Return a table per stage and observable: the front, the choice of the plan, and what failed."""
    tables = []
    for title, group in panels(points).items():
        best = {id(point) for point in front(group)}
        rows: list[Row] = [
            (
                *(Number(x, digits=2) for x in (point.error, point.seconds, point.pairs)),
                point.method,
                point.setting,
                ", ".join(["front"] * (id(point) in best) + ["plan"] * point.chosen),
            )
            for point in group
            if id(point) in best or point.chosen or isnan(point.error)
        ]
        columns = [Column(name, number=True) for name in ("error", "CPU s", "FFT pairs")]
        tables.append(Table([*columns, Column("method"), Column("setting"), Column("")], rows, title))
    return tables


__all__ = ["PAIR_SIDE", "STAGES", "Point", "bench", "bench_chart", "bench_dict", "bench_tables", "front", "panels"]
