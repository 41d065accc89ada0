"""What tolerance and pixel of one contact change: numbers of docs/accuracy.md and docs/errors.md.

    python experiments/tolerance.py [--toy] [-o FOLDER] [--evidence]

The rough contacts of contact_solvers.py: error of the pressure over the tolerance, against a solve to 1e-10, and
the transforms of a solve to 1e-6. Then surfaces of the lowest capped level of the three steels: T_flash at
the tolerance of a run over that of a solve to 1e-8, and on half the pixel over the pixel of the level. Draws the first.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from contact_solvers import PROBLEMS, TOLERANCES, solvers
from figures.style import BLACK, legend_below, new_figure
from script import Command, write_evidence

import roughsim as rs
from roughsim.pipeline import solve_problem
from roughsim.planning.realization import level_problem
from roughsim.surface.topography.periodic import band_limited

STEELS = ("steel-0.5GPa", "steel-1.2GPa", "steel-2.0GPa")
TIGHT, OF_PEERS = 1e-8, 1e-6


@dataclass(frozen=True)
class Solves:
    """Solves of one rough contact."""

    problem: str
    points: int
    off: list[float]  # error of the pressure over the tolerance, at TOLERANCES
    transforms: int


def solves(problem: str, points: int) -> Solves:
    """Solve one contact to all tolerances."""
    load, cap = PROBLEMS[problem]
    task = solvers.problem(points, load, cap)
    solve = partial(
        rs.solve_contact, task.heights, task.grid, rs.Solid(1.0, cap), nominal_pressure=load
    )
    exact = solve(tolerance=1e-10).pressure
    off = [
        float(
            np.linalg.norm(solve(tolerance=tolerance).pressure - exact)
            / np.linalg.norm(exact)
            / tolerance
        )
        for tolerance in TOLERANCES
    ]
    return Solves(problem, points, off, int(solve(tolerance=OF_PEERS).transforms))


def steel_changes(name: str, members: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the relative changes of T_flash by the tolerance and by half the pixel, (members, speeds)."""
    scene = rs.load_scene(name)
    numerics = rs.plan(scene)
    problem = level_problem(scene, numerics, numerics.of_column("capped")[0])
    grid = problem.grid
    fine = rs.Grid((2 * grid.shape[0], 2 * grid.shape[1]), grid.lengths)
    changes = []
    for member in range(members):
        heights = rs.synthesize(problem.spectrum, grid, np.random.default_rng((7, member)))
        finer = band_limited(heights, grid, fine.shape, float(problem.spectrum.breaks[-1]))
        as_run, tight, half = (
            solve_problem(one, heights=surface).observables.flash_temperature
            for one, surface in (
                (problem, heights),
                (replace(problem, tolerance=TIGHT), heights),
                (replace(problem, grid=fine), finer),
            )
        )
        changes.append((as_run / tight - 1, half / as_run - 1))
    by_tolerance, by_pixel = np.array(changes).transpose(1, 0, 2)
    return by_tolerance, by_pixel


def quoted(
    rows: list[Solves], steels: dict[str, tuple[np.ndarray, np.ndarray]]
) -> dict[str, float]:
    """Return the numbers of the pages: changes in per cent, by the pixel as means over members."""
    transforms = [row.transforms for row in rows]
    by_pixel = [100 * np.abs(pixel.mean(axis=0)) for _, pixel in steels.values()]
    return {
        "over_tolerance": max(max(row.off) for row in rows),
        "transforms_least": min(transforms),
        "transforms_most": max(transforms),
        "by_tolerance": 100 * max(np.abs(tolerance).max() for tolerance, _ in steels.values()),
        "by_pixel_least": min(changes.min() for changes in by_pixel),
        "by_pixel_most": max(changes.max() for changes in by_pixel),
    }


def draw(rows: list[Solves], path: Path) -> None:
    """Draw the error of the pressure over the tolerance."""
    with new_figure(path, 2.8) as figure:
        axes = figure.subplots()
        for problem, marker in zip(PROBLEMS, "ov^s", strict=True):
            for k, row in enumerate(row for row in rows if row.problem == problem):
                axes.loglog(TOLERANCES, row.off, marker, label=None if k else problem)
        axes.axhline(1.0, color=BLACK, lw=0.8)
        axes.set(xlabel="tolerance", ylabel="error of the pressure over it")
        legend_below(figure, [axes], 2)


def main() -> None:
    options = Command(__file__, __doc__, "one small grid and one member of the demo").parse()
    sizes, steels, members = (
        ((64,), ("demo",), 1) if options.toy else ((512, 1024, 2048), STEELS, 8)
    )
    rows = [solves(problem, points) for points in sizes for problem in PROBLEMS]
    for row in rows:
        ratios = " ".join(f"{ratio:.2g}" for ratio in row.off)
        print(
            f"{row.problem}, {row.points}²: error over tolerance {ratios}; {row.transforms} transforms",
            flush=True,
        )
    changes = {name: steel_changes(name, members) for name in steels}
    numbers = quoted(rows, changes)
    print("\n".join(f"{name:20}{value:10.4g}" for name, value in numbers.items()))
    draw(rows, options.output / "tolerance.png")
    if options.evidence:
        records = [{"problem": row.problem, "points": row.points, "off": row.off} for row in rows]
        write_evidence(
            "tolerance", "python experiments/tolerance.py --evidence", rows=records, numbers=numbers
        )


if __name__ == "__main__":
    main()
