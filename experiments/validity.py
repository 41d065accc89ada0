"""Where the analytic theory can be trusted: its ratio to boundary-element contacts, with errors, as a map.

    python experiments/validity.py [--toy] [--resume] [-o FOLDER] [--workers N]

Elastic contact over load p/(E*h') 0.002 ... 0.6, H 0.3 ... 1, bandwidth q_1/q_r 4 ... 64 and Peclet number 1e-3 ...
1e3, and hardness-capped contact over sigma_0/sigma_P 0.01 ... 0.5, with the three steel scenes. Each point is one file
in FOLDER/points, so --resume goes on where a run was stopped. Out come FOLDER/validity.h5, which the package ships,
the figures of docs/validity.md, and the test of the calibrated stress spectrum (theory.persson.calibrated_spectrum) on
points that it was not fitted to. --toy computes a few small points.
"""

from __future__ import annotations

import shutil
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
from script import Command
from validity_map import capped, charts, elastic, fit, plastic_charts, report
from validity_map.file import write_validity
from validity_map.tables import capped_tables, elastic_table

from theory.calibrated import LIGHTEST

LOADS = (0.002, 0.006, 0.02, 0.06, 0.15, 0.3, 0.6)
HURSTS = (0.3, 0.55, 0.8, 1.0)
BANDWIDTHS = (4.0, 8.0, 16.0, 32.0, 64.0)
YIELDS = ((1.0, 0.3), (1.0, 0.55), (1.0, 0.8), (2.0, 0.3), (2.0, 0.55), (2.0, 0.8), (4.0, 0.8))  # q_y/q_r, H: capped
Point = elastic.Point | capped.CappedPoint


def whole_map() -> list[Point]:
    """Return the regular grid of elastic and capped points, and the three steels."""
    grid = [elastic.Point(p, h, r) for r in BANDWIDTHS for h in HURSTS for p in LOADS]
    plastic = [capped.CappedPoint(s, y, h) for y, h in YIELDS for s in (0.01, 0.03, 0.1, 0.25, 0.5)]
    return [*grid, *plastic, *capped.steels()]


def families() -> list[elastic.Point]:
    """Return elastic points with other long waves: no plateau, longer ones, and a slope below q_r."""
    shapes = ((1.0, 0.0), (4.0, 0.0), (8.0, 0.0), (8.0, 1.5))
    return [elastic.Point(p, h, 8.0, k, 2, m) for k, m in shapes for h in (0.3, 0.8) for p in (0.02, 0.15)]


def fresh(count: int = 16) -> list[elastic.Point]:
    """Return points off the grid, on streams of their own, that no constant was fitted to."""
    rng = np.random.default_rng(20261121)
    points = []
    for load in np.geomspace(0.0085, 0.5, count):
        hurst, plateau = rng.uniform(0.3, 1.0), np.exp(rng.uniform(0.0, np.log(6.0)))
        most = min(60.0, 512.0 / max(8.0, 4.0 * plateau))  # what the grids can hold
        bandwidth = np.exp(rng.uniform(np.log(4.0), np.log(most)))
        points.append(elastic.Point(*(float(f"{x:.3g}") for x in (load, hurst, bandwidth, plateau)), seed=3))
    return points


def toy_map() -> list[Point]:
    grid = [elastic.Point(p, h, 4.0) for h in (0.3, 0.8) for p in (0.06, 0.15, 0.3)]
    grid.append(elastic.Point(0.2, 0.5, 5.0, 1.5, 3))
    return [*grid, capped.CappedPoint(0.1, 1.0), capped.CappedPoint(0.3, 1.0)]


def compute(task: tuple[Point, bool, Path]) -> float:
    """Measure one point, store it whole or not at all, and return the CPU seconds spent."""
    point, toy, place = task
    start = time.process_time()
    if isinstance(point, elastic.Point):
        work = elastic.effort(point)
        raw = elastic.measure(point, elastic.reduced(work, 4) if toy else work)
    else:
        raw = capped.measure(point, {4.0: 4, 8.0: 4, 16.0: 4} if toy else None)
    temporary = place.with_suffix(".tmp.npz")
    np.savez_compressed(temporary, **raw)
    temporary.replace(place)
    spent = time.process_time() - start
    print(f"{point.name}: {spent:.1f} s", flush=True)
    return spent


def gather(points: list[Point], folder: Path, *, toy: bool, workers: int) -> list[tuple[Point, Any]]:
    """Compute what is missing and read everything back."""
    place = {point: folder / f"{point.name}.npz" for point in points}
    tasks = [(point, toy, path) for point, path in place.items() if not path.exists()]
    tasks.sort(key=lambda task: -getattr(task[0], "bandwidth", np.inf))  # the long ones first: no worker ends alone
    if workers > 1:
        with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
            spent = list(pool.map(compute, tasks))
    else:
        spent = [compute(task) for task in tasks]
    print(f"{len(tasks)} points computed in {sum(spent) / 60:.1f} CPU minutes", flush=True)
    results = []
    for point, path in place.items():
        with np.load(path) as raw:
            results.append((point, dict(raw)))
    return results


def sorted_out(results: list[tuple[Point, Any]]) -> dict[str, list[Any]]:
    """Return the elastic results by their use: the grid, its fitted part, the rest of it, and what lies off it."""
    grid = [pair for pair in results if isinstance(pair[0], elastic.Point) and pair[0].seed == 1]
    axes = [sorted({getattr(p, name) for p, _ in grid}) for name in ("load", "hurst", "bandwidth")]
    off = [pair for pair in results if isinstance(pair[0], elastic.Point) and pair[0].seed != 1]
    return {
        "grid": grid,
        "fitted": [pair for pair in grid if fit.is_fitted(pair[0], *axes)],
        "judged": [pair for pair in grid if not fit.is_fitted(pair[0], *axes)],
        "families": [pair for pair in off if pair[0].seed == 2],
        "fresh": [pair for pair in off if pair[0].seed == 3],
    }


def refit(results: dict[str, list[Any]]) -> None:
    """Fit the constants anew and print them as theory.calibrated holds them."""
    chosen = [pair for pair in [*results["fitted"], *results["families"]] if pair[0].load >= fit.LIGHTEST]
    constants, misses = fit.fit(chosen)
    misses = misses[[point.load >= LIGHTEST for point, _ in chosen]]
    print("constants:", ", ".join(f"{x:.4g}" for x in constants))
    print(f"  rms {np.sqrt((misses**2).mean()):.2%}, worst {abs(misses).max():.1%} over {len(misses)} points")


def main() -> None:
    command = Command(__file__, __doc__, "few and small points, to see it work")
    command.add_argument("--resume", action="store_true", help="keep the points that are there")
    command.add_argument("--refit", action="store_true", help="fit the constants of the calibrated spectrum anew")
    command.add_argument("--workers", type=int, default=1, help="processes")
    options = command.parse()

    folder = options.output / "points"
    if not options.resume:
        shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True, exist_ok=True)
    points = toy_map() if options.toy else [*whole_map(), *families(), *fresh()]
    measured = gather(points, folder, toy=options.toy, workers=options.workers)
    results = sorted_out(measured)
    plastics = [pair for pair in measured if isinstance(pair[0], capped.CappedPoint)]
    tables = {"elastic": elastic_table(results["grid"]), **capped_tables(plastics)}
    write_validity(options.output / "validity.h5", tables, report.provenance())
    if options.refit:
        refit(results)
    report.show(tables, results, plastics)
    charts.draw(tables, results, options.output)
    plastic_charts.draw(tables, plastics, options.output)


if __name__ == "__main__":
    main()
