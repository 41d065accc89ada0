"""How often total errors hold the truth: runs of many seeds against a deep reference of other seeds.

    python experiments/covered.py [--toy] [-o FOLDER] [--only NAME ...] [--seeds N]

`demo` is resolved by its grids; its reference goes from 4 to 32 pixels per shortest wave. `steel` is cut far below
q_max and extrapolated from three cut-offs; its reference has a fourth one, twice as high, and a rest of first order.
`fine` is a steel planned for 0.35 % in all; its reference has cut-offs up to 128 q_y, in a cell of four longest waves.
`rubber` ends at twice the cut-off that its plan reaches, so that its reference has all of C(q). A reference is the mean
of many realizations on its coarsest level, plus the mean differences between neighbours of some. Printed is, for each
speed of T_flash and for r(g = .5), how many of the intervals hold it, and the mean of value/reference − 1. What is in
FOLDER is not computed again. --toy takes two seeds and a shallow reference of a small scene.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import hypot, pi
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from script import Command

import roughsim as rs
from roughsim.estimate.cell_size import choose_lengths
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.observables.record import Sample
from roughsim.planning.plan import statistical_target

NAMES = ("flash_temperature", "correlation_radius_50")
FIRST_SEED, REFERENCE_SEED = 1000, 90001


@dataclass(frozen=True)
class Case:
    """A scene, the target and number of its runs, and the levels of its reference.

    The target is statistical, or, with `total`, that of all errors together. `sides` are the points per side and
    `counts` the realizations of each; `per_wave` is the pixels per shortest wave, or None where all levels have all of
    C(q). `rest` is what follows after the last step, over that step.
    """

    scene: rs.Scene
    target: float
    seeds: int
    sides: tuple[int, ...]
    counts: tuple[int, ...]
    per_wave: int | None
    rest: float
    total: bool = False


def cases(toy: bool) -> dict[str, Case]:
    names = "demo", "steel-1.2GPa", "steel-0.5GPa", "rubber"
    demo, steel, soft, rubber = (rs.load_scene(name) for name in names)
    if toy:
        small = replace(demo, surface=replace(demo.surface, q_roll_off=None, roll_off_exponent=None, q_max=2.5e4))
        return {"toy": Case(small, 0.05, 2, (64, 128), (12, 4), None, 0.6)}
    end = 1.28e5
    short = replace(rubber.surface, q_max=end, rms_height=rubber.spectrum.truncated(q_max=end).rms_height)
    return {
        "demo": Case(demo, 0.05, 41, (512, 1024, 2048, 4096), (1500, 160, 32, 8), None, 0.6),
        "rubber": Case(replace(rubber, surface=short), 0.02, 12, (512, 1024, 2048, 4096), (300, 24, 12, 5), 4, 0.0),
        "steel": Case(steel, 0.02, 16, (512, 1024, 2048, 4096), (300, 24, 12, 5), 4, 1.0),
        "fine": Case(soft, 0.0035, 16, (256, 512, 1024, 2048, 4096, 8192), (4000, 400, 100, 40, 10, 4), 4, 0.6, True),
    }


def reference(name: str, case: Case, folder: Path) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return value and standard error of each observable."""
    end, lengths = case.scene.spectrum.breaks[-1], choose_lengths(case.scene)[0]
    column = "elastic" if case.scene.elastic else "capped"
    steps = [end if case.per_wave is None else min(end, 2 * pi * n / (case.per_wave * lengths[0])) for n in case.sides]
    levels = tuple(rs.Level(column, (n, n), q) for n, q in zip(case.sides, steps, strict=True))
    samples = [
        members(case, rs.Numerics(levels, lengths), k, folder / f"{name}-reference-{k}.npz") for k in range(len(levels))
    ]
    return {
        observable: chained([OBSERVABLES[observable].of_level(s) for s in samples], samples, observable, case.rest)
        for observable in NAMES
    }


def members(case: Case, numerics: rs.Numerics, level: int, path: Path) -> Sample:
    """Return the sample of one level, computed or read."""
    if not path.exists():
        seen = [
            rs.realize(case.scene, numerics, seed=REFERENCE_SEED, level=level, index=i).observables
            for i in range(case.counts[level])
        ]
        np.savez(
            path,
            flash_temperature=[one.flash_temperature for one in seen],
            spectrum=[one.stress_spectrum.variance for one in seen],
            wavenumber=seen[0].stress_spectrum.wavenumber,
        )
    stored = np.load(path)
    rows = np.arange(len(stored["spectrum"]))
    numbers = {"flash_temperature": stored["flash_temperature"]}
    reach = 0.5 * float(np.hypot(*numerics.lengths))
    side, q_max = float(numerics.levels[level].shape[0]), numerics.levels[level].q_max
    return Sample(q_max, side, rows, numbers, stored["wavenumber"], stored["spectrum"], reach)


def chained(
    rows: list[np.ndarray], samples: list[Sample], observable: str, rest: float
) -> tuple[np.ndarray, np.ndarray]:
    """Mean of the coarsest level plus the differences of neighbours over those that have both, and the rest."""
    value, variance, change = rows[0].mean(axis=0), rows[0].var(axis=0, ddof=1) / len(rows[0]), 0.0
    for k in range(1, len(rows)):
        both = samples[k].rows
        difference = rows[k] - OBSERVABLES[observable].of_level(samples[k - 1].at(both))
        change = difference.mean(axis=0)
        value, variance = value + change, variance + difference.var(axis=0, ddof=1) / len(difference)
    return value + rest * change, np.sqrt(variance + (0.25 * rest * change) ** 2)


def runs(name: str, case: Case, folder: Path) -> list[rs.Run]:
    """Return a run for each seed, all with the numerics of one plan."""
    scene, until = case.scene, {"flash_temperature": case.target}
    free = replace(scene, ensemble=replace(scene.ensemble, until={} if case.total else until))
    numerics = rs.plan(free, case.target if case.total else None)
    if case.total and (forecast := numerics.forecast) is not None:  # what the systematic errors leave of the target
        systematic = hypot(forecast.bandwidth, forecast.pixel, forecast.size)
        until = {"flash_temperature": statistical_target(case.target, systematic)}
    result = []
    for seed in range(FIRST_SEED, FIRST_SEED + case.seeds):
        result.append(rs.run(scene, folder / f"{name}-{seed}", numerics=numerics, seed=seed, until=until, workers=1))
        print(f"{name}: seed {seed}, n = {result[-1].realizations}", flush=True)
    return result


def told(
    name: str, case: Case, found: list[rs.Run], truth: dict[str, tuple[np.ndarray, np.ndarray]]
) -> dict[str, np.ndarray]:
    """Print the coverage, and return the deviations in total errors, (seeds, speeds), of each observable."""
    result = {}
    for observable, (value, error) in truth.items():
        estimates = [run.estimate(observable) for run in found]
        share = found[0].heat_partition if observable == "flash_temperature" else 1.0
        off = np.stack([estimate.mean - value * share for estimate in estimates])
        whole = np.stack([estimate.total_error for estimate in estimates])
        result[observable] = off / whole
        for k in range(off.shape[1]):
            mean = value[k] * (share if np.ndim(share) == 0 else share[k])
            speed = f" at {case.scene.speeds[k]:g} m/s" if off.shape[1] > 1 else ""
            held, relative = np.count_nonzero(np.abs(off[:, k]) <= whole[:, k]), 100 * off[:, k] / mean
            print(
                f"{name:8s} {observable + speed:32s} {held:3d} of {len(off)} hold; off {relative.mean():+.2f} ± "
                f"{relative.std(ddof=1):.2f} %, told ± {100 * whole[:, k].mean() / mean:.2f} %, "
                f"reference ± {100 * error[k] / value[k]:.2f} %"
            )
    return result


def chart(results: dict[str, dict[str, np.ndarray]], path: Path) -> None:
    figure = Figure((6.4, 3.4), layout="constrained")
    axes = figure.subplots()
    axes.axhspan(-1, 1, color="0.93")
    for number, (name, observables) in enumerate(results.items()):
        for shift, (observable, off) in zip((-0.12, 0.12), observables.items(), strict=True):
            place = number + shift + 0.05 * np.linspace(-1, 1, off.size)
            axes.plot(place, off.ravel(), ".", ms=3, label=f"{name}, {observable}")
    axes.set(ylabel="(value − reference)/total error", xticks=range(len(results)), xticklabels=list(results))
    axes.legend(frameon=False, fontsize=7)
    figure.savefig(path, dpi=130)


def main() -> None:
    command = Command(__file__, __doc__, "a small scene, two seeds")
    command.add_argument("--only", nargs="*", help="names of scenes")
    command.add_argument("--seeds", type=int, help="runs of each scene")
    options = command.parse()
    chosen = {name: case for name, case in cases(options.toy).items() if name in (options.only or cases(options.toy))}
    results = {}
    for name, of_name in chosen.items():
        case = replace(of_name, seeds=options.seeds or of_name.seeds)
        results[name] = told(name, case, runs(name, case, options.output), reference(name, case, options.output))
    chart(results, options.output / "covered.png")


if __name__ == "__main__":
    main()
