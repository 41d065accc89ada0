"""The whole way to one number: T_flash(35 m/s) of a steel scene to 1 % in all, beside a plain pipeline with tamaas.

    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python benchmarks/pipeline.py [--scene steel-1.2GPa] [--largest 512]

Ours is one run at one thread: its total error includes statistics, bandwidth, pixel, cell and solver. The plain
pipeline has the same scatter and extrapolates the two highest cut-offs of the run, but solves both for every
realization, capped contact by tamaas (`KatoSaturated`, pip install 'roughsim[peers]') at the loosest tolerance whose
pressure is within 1e-3. tamaas is timed on the lowest rung, halved until it has `--largest` points per side; larger
ones are counted as if its time grew with the number of points only, and its heat costs nothing, so that the ratio is a
lower bound.
"""

from __future__ import annotations

import argparse
import importlib.util
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.stats import t as student

import roughsim as rs
from roughsim.planning.realization import realize

ERROR = 1e-3  # relative pressure error that the plain pipeline allows itself


def ours(scene: rs.Scene, target: float) -> tuple[rs.Numerics, list[int], float, float, float]:
    """Numerics, the two highest levels, CPU seconds, total and lowest scatter of T_flash at 35 m/s, relative."""
    start = time.process_time()
    with tempfile.TemporaryDirectory() as folder:
        run = rs.run(scene, Path(folder) / "run", until={"flash_temperature": target})
        found = run.estimate("flash_temperature")
        seconds = time.process_time() - start
        k = run.scene.speeds.index(35.0)
        samples = run.samples("capped")
        rows = samples[0].numbers["flash_temperature"][:, k]
        levels = [sample.level for sample in samples if not run.numerics.is_refined(sample.level)]
        print(found.explain().splitlines()[1 + k])
    error, scatter = found.total_error[k] / found.mean[k], rows.std(ddof=1) / rows.mean()
    return run.numerics, levels[-2:], seconds, float(error), float(scatter)


def tamaas_seconds(scene: rs.Scene, numerics: rs.Numerics, level: int) -> float:
    """CPU seconds of tamaas for one surface of a level, at the loosest tolerance that meets the error."""
    tm = importlib.import_module("tamaas")
    tm.set_log_level(tm.LogLevel.error)
    one = realize(scene, replace(numerics, tolerance=1e-7), seed=1, level=level)
    grid, hardness, load = one.grid, scene.penetration_hardness, scene.sliding.nominal_pressure
    scale, unit = scene.effective_modulus, grid.lengths[0]  # its tolerances are not free of units
    best = np.inf
    for tolerance in (10.0 ** (-k / 2) for k in range(4, 17)):
        model = tm.ModelFactory.createModel(
            tm.model_type.basic_2d, [1.0, grid.lengths[1] / unit], list(grid.shape)
        )
        model.E, model.nu = 1.0, 0.0
        solver = tm.KatoSaturated(model, one.heights / unit, tolerance, hardness / scale)
        solver.max_iter = 20000
        start = time.process_time()
        solver.solve(load / scale)
        seconds = time.process_time() - start
        difference = np.array(model.traction) * scale - one.contact.pressure
        best = min(best, float(np.linalg.norm(difference) / np.linalg.norm(one.contact.pressure)))
        if best <= ERROR:
            print(
                f"  tamaas {grid.shape[0]}²: {seconds:.1f} s at tolerance {tolerance:.1g}, pressure error {best:.1e}"
            )
            return seconds
    print(
        f"  tamaas {grid.shape[0]}²: pressure error {best:.1e} at its tightest tolerance, {seconds:.1f} s"
    )
    return seconds


def main() -> None:
    options = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    options.add_argument("--scene", default="steel-1.2GPa")
    options.add_argument("--target", type=float, default=0.01, help="relative error in all")
    options.add_argument(
        "--largest", type=int, default=512, help="points per side up to which tamaas is timed"
    )
    given = options.parse_args()
    scene = rs.load_scene(given.scene)
    rs.realize(scene, rs.plan(scene, 0.05), seed=9)  # compiled before the clock starts
    numerics, finest, cpu, total, scatter = ours(scene, given.target)
    print(f"roughsim: {cpu:.1f} s of CPU, ± {100 * total:.2f} % in all")
    if importlib.util.find_spec("tamaas") is None:
        raise SystemExit(
            "tamaas is not installed, so that nothing stands beside it: pip install 'roughsim[peers]'"
        )
    base = numerics.levels[numerics.of_column("capped")[0]]
    while max(base.shape) > given.largest:
        base = replace(base, shape=(base.shape[0] // 2, base.shape[1] // 2), q_max=base.q_max / 2)
    small = replace(numerics, levels=(base,))
    per_point = tamaas_seconds(scene, small, 0) / small.grid(0).points
    count = 12
    while float(student.ppf(0.975, count - 1)) * scatter / count**0.5 > total:
        count += 1
    # a pipeline without corrections solves them in the run's cell
    points = [numerics.grid(i).points * numerics.levels[i].parts ** 2 for i in finest]
    plain = count * per_point * sum(points)
    print(
        f"plain pipeline: {count} realizations of {len(finest)} levels, at least {plain:.0f} s of CPU in tamaas alone"
    )
    print(f"ratio: at least {plain / cpu:.0f}")


if __name__ == "__main__":
    main()
