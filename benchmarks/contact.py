"""Time contact solvers on the same surfaces at the same measured error, one thread each, in CPU seconds.

    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python benchmarks/contact.py            # 512 and 1024
    ... python benchmarks/contact.py --sizes 512 --loads 0.02 0.1 --caps inf 0.6 --error 1e-3

"home-made" is benchmarks/preconditioned.py, as an able user writes it with the right paper. The error is ‖p −
p*‖/‖p*‖ against our solution at 1e-10, so a peer that meets it also checks that solution. Every solver is run at the
loosest of its tolerances that meets the error, which also warms it up. Solvers that are not installed (`pip install
'roughsim[peers]' aspher`; the last is compiled, with Eigen) or do not converge are listed as such.
"""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import roughsim as rs


@dataclass(frozen=True)
class Problem:
    """Rough contact with E* = 1, h′ = 1 in the unit cell: H = 0.8, roll-off 4 waves, 8 pixels per shortest wave."""

    points: int
    load: float
    cap: float
    heights: np.ndarray = field(repr=False)

    @property
    def grid(self) -> rs.Grid:
        """The unit cell."""
        return rs.Grid((self.points, self.points), (1.0, 1.0))


def problem(points: int, load: float, cap: float) -> Problem:
    spectrum = rs.SelfAffineSpectrum.from_rms_slope(
        1.0, hurst=0.8, q_min=2 * np.pi, q_roll_off=8 * np.pi, q_max=2 * np.pi * points / 8
    )
    grid = rs.Grid((points, points), (1.0, 1.0))
    return Problem(points, load, cap, rs.synthesize(spectrum, grid, np.random.default_rng(0)))


def ours(task: Problem, tolerance: float) -> np.ndarray:
    solid = rs.Solid(1.0, task.cap)
    return rs.solve_contact(
        task.heights, task.grid, solid, nominal_pressure=task.load, tolerance=tolerance
    ).pressure


def tamaas_solver(task: Problem, tolerance: float) -> np.ndarray:
    tm = importlib.import_module("tamaas")
    tm.set_log_level(tm.LogLevel.error)
    model = tm.ModelFactory.createModel(tm.model_type.basic_2d, [1.0, 1.0], [task.points] * 2)
    model.E, model.nu = 1.0, 0.0
    if np.isfinite(task.cap):
        solver = tm.KatoSaturated(model, task.heights, tolerance, task.cap)
        solver.max_iter = 20000
    else:
        solver = tm.PolonskyKeerRey(model, task.heights, tolerance)
    solver.solve(task.load)
    return np.array(model.traction)


def contact_mechanics(task: Problem, tolerance: float) -> np.ndarray:
    cm = importlib.import_module("ContactMechanics")
    topography = importlib.import_module("SurfaceTopography").Topography
    solve = importlib.import_module("ContactMechanics.Optimization").constrained_conjugate_gradients
    half_space = cm.PeriodicFFTElasticHalfSpace((task.points,) * 2, 1.0, (1.0, 1.0))
    surface = topography(task.heights, physical_sizes=(1.0, 1.0))
    pixel = 1.0 / task.points**2
    result = solve(
        half_space,
        surface,
        hardness=task.cap * pixel if np.isfinite(task.cap) else None,
        external_force=task.load,
        pentol=tolerance * np.std(task.heights),
        forcetol=tolerance * pixel,
        maxiter=20000,
    )
    if not result.success:
        raise RuntimeError(result.message)
    return np.array(result.jac) / pixel


def numpi(task: Problem, tolerance: float) -> np.ndarray:
    if np.isfinite(task.cap):
        raise ValueError("one bound only")
    solve = importlib.import_module("NuMPI.Optimization").constrained_conjugate_gradients
    fft = importlib.import_module("scipy.fft")
    shape, q = task.heights.shape, task.grid.wavenumbers
    compliance = np.divide(2.0, q, out=np.zeros_like(q), where=q > 0)

    def response(p: np.ndarray) -> np.ndarray:
        return fft.irfft2(compliance * fft.rfft2(p.reshape(shape)), s=shape).ravel()

    def objective(p: np.ndarray) -> tuple[float, np.ndarray]:
        displacement = response(p)
        gap = displacement - task.heights.ravel()
        return 0.0, gap

    start = np.full(task.heights.size, task.load)
    result = solve(
        objective,
        response,
        start,
        mean_val=task.load,
        gtol=tolerance * np.std(task.heights),
        maxiter=20000,
    )
    if not result.success:
        raise RuntimeError(result.message)
    return np.asarray(result.x).reshape(shape)


def aspher(task: Problem, tolerance: float) -> np.ndarray:
    if np.isfinite(task.cap):
        raise ValueError("one bound only")
    found = importlib.import_module("hmatrix_contact").solve_nested(
        grid_size=task.points,
        gap=-task.heights.ravel(),
        p_nominal=task.load,
        coarsest=min(64, task.points),
        tol=tolerance,
        backend="periodic",
        precision="float" if tolerance >= 1e-5 else "float_then_double",
    )
    if found.status != "converged":
        raise RuntimeError(found.status)
    return np.array(found.pressure).reshape(task.heights.shape)


def preconditioned(task: Problem, tolerance: float) -> np.ndarray:
    if np.isfinite(task.cap):
        raise ValueError("one bound only")
    return importlib.import_module("preconditioned").solve(task.heights, task.load, tolerance)


LADDER = tuple(10.0 ** (-k / 2) for k in range(8, 21))  # half decades from 1e-4 to 1e-10
OWN = 5  # times that roughsim is timed at least: a solve of a tenth of a second, and the first one follows a peer's
Solver = Callable[[Problem, float], np.ndarray]
PEERS: dict[str, tuple[str, Solver, tuple[float, ...]]] = {
    "home-made": ("preconditioned", preconditioned, LADDER),
    "aspher": ("hmatrix_contact", aspher, LADDER),
    "tamaas": ("tamaas", tamaas_solver, LADDER),
    "ContactMechanics": ("ContactMechanics", contact_mechanics, LADDER),
    "NuMPI": ("NuMPI", numpi, LADDER),
}


@dataclass
class Run:
    """A solver at the tolerance that meets the error."""

    name: str
    solve: Solver
    tolerance: float
    error: float
    seconds: list[float]

    @property
    def median(self) -> float:
        """Median CPU seconds."""
        return statistics.median(self.seconds)


def timed(solve: Solver, task: Problem, tolerance: float) -> tuple[np.ndarray, float]:
    start = time.process_time()
    pressure = solve(task, tolerance)
    return pressure, time.process_time() - start


def first_rungs(ladder: tuple[float, ...], start: float) -> tuple[float, ...]:
    """The ladder from the tolerance that sufficed on a smaller grid."""
    return tuple(t for t in ladder if t <= 1.001 * start)


def calibrated(
    name: str,
    solve: Solver,
    ladder: tuple[float, ...],
    task: Problem,
    exact: np.ndarray,
    goal: float,
) -> Any:
    """Return the run at the loosest tolerance that meets the goal, or words on why there is none."""
    best = np.inf
    for tolerance in ladder:
        try:
            pressure, seconds = timed(solve, task, tolerance)
        except (RuntimeError, ValueError) as reason:
            return f"refused: {reason}" if best == np.inf else f"error {best:.1e}, then: {reason}"
        best = min(best, float(np.linalg.norm(pressure - exact) / np.linalg.norm(exact)))
        if best <= goal:
            return Run(name, solve, tolerance, best, [seconds])
    return f"error {best:.1e} at its tightest tolerance, {seconds:.1f} s"


def compare(
    task: Problem, goal: float, peers: list[str], repeats: int, start: dict[str, float]
) -> None:
    exact = ours(task, 1e-10)
    runs: list[Any] = [calibrated("roughsim", ours, (goal, goal / 3, goal / 10), task, exact, goal)]
    for name in peers:
        module, solve, ladder = PEERS[name]
        if importlib.util.find_spec(module) is None:
            print(f"    {name:18s} not installed")
            continue
        result = calibrated(
            name, solve, first_rungs(ladder, start.get(name, 1.0)), task, exact, goal
        )
        if isinstance(result, str):
            print(f"    {name:18s} {result}")
        else:
            runs.append(result)
            start[name] = result.tolerance
    for run in runs:
        run.seconds = run.seconds if run.name != "roughsim" and repeats == 1 else []
    for _ in range(max(repeats, OWN)):  # alternating
        for run in runs:
            if run.name == "roughsim" or repeats > 1:
                run.seconds.append(timed(run.solve, task, run.tolerance)[1])
    for run in runs:
        accuracy = f"error {run.error:.1e}  tolerance {run.tolerance:.0e}"
        print(
            f"    {run.name:18s} {run.median:9.4f} s  {accuracy}  × {run.median / runs[0].median:.1f}",
            flush=True,
        )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sizes", type=int, nargs="+", default=[512, 1024])
    parser.add_argument("--loads", type=float, nargs="+", default=[0.02, 0.1], help="σ₀/(E* h′)")
    parser.add_argument("--caps", type=float, nargs="+", default=[np.inf], help="σ_P/(E* h′)")
    parser.add_argument("--error", type=float, default=1e-6, help="relative pressure error to meet")
    parser.add_argument("--peers", nargs="*", choices=list(PEERS), default=list(PEERS))
    options = parser.parse_args()
    start: dict[str, float] = {}
    for points in options.sizes:
        for load in options.loads:
            for cap in options.caps:
                print(
                    f"{points}², load {load:g}, cap {cap:g}, relative pressure error ≤ {options.error:g}",
                    flush=True,
                )
                repeats = max(round((512 / points) ** 2), 3) if points <= 512 else 1
                compare(problem(points, load, cap), options.error, options.peers, repeats, start)


if __name__ == "__main__":
    main()
