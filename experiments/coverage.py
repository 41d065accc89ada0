"""How many total errors hold the truth: runs of many seeds to a target against deep references of their own.

    OMP_NUM_THREADS=1 python experiments/coverage.py [--toy] [-o FOLDER] [--only NAME ...] [--seeds N] [--evidence]
        [--drawn SEED | --materials SEED | --soft SEED | --lays SEED]

Six scenes run to a total error of 1 or 2 % of T_flash, forty times each. Each run is judged by T_flash at every speed,
contact area, g_σ(0), and the share of the heat where there are two bodies. The references are in reference/deep.json,
by reference/make_deep.py. An interval holds the reference if they are no further apart than both errors (95 %, added as
squares) allow. Rows in FOLDER/coverage.json are not computed again. --toy takes two seeds of the demo to 5 %. With
--drawn the scenes are the ten that benchmarks/drawn.py draws with a seed, to 1 %; their references go into
FOLDER/deep-drawn-SEED.json, before the runs, and their rows into FOLDER/coverage-drawn-SEED.json. They have as many
runs as ten minutes of CPU time allow, but at least eight. --materials are likewise a wheel on a rail, brass and ice, to
2 %, with sixty runs each, --soft six soft elastic bodies with wide spectra, to 5 %, with forty, and --lays twenty
scenes of faces with a lay, to 3 %, with two, judged in three directions (the stored ones have the seed 6300).
"""

if (
    __name__ == "coverage"
):  # numba asks for the package of this name, and the folder of the script comes first
    raise ImportError("this is a script, not the package that measures the coverage of tests")

import resource
import sys
import tempfile
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import inf
from pathlib import Path
from typing import Any, NamedTuple

import figures
import numpy as np
from numpy.typing import NDArray
from reference import make_deep
from script import Command, Rows, write_evidence

import roughsim as rs
from roughsim import prediction

sys.path.append(str(Path(__file__).parents[1] / "benchmarks"))
import drawn

Array = NDArray[np.float64]
Pair = tuple[Array, Array]  # value and relative standard error, (speeds,) or (1,)
Result = tuple[
    make_deep.Case, float, list[dict[str, Any]], dict[str, Pair]
]  # target, rows, references
FIRST_SEED = 1000
TARGETS = {"demo": 0.01, "steel-1.2GPa": 0.01}  # relative total errors of T_flash; of the others:
OTHERS = 0.02
FLASH = "flash_temperature"
RUNS = 40  # of each of the six scenes
LEAST_RUNS = 8  # of a drawn scene
MEASURED = {  # observable: its name in the references
    FLASH: FLASH,
    "contact_fraction": "contact_fraction_corrected",
    "pressure_variance": "pressure_variance",
    "heat_partition": "",
}


def drawn_cases(seed: int) -> dict[str, make_deep.Case]:
    """Return the ten scenes that are drawn with a seed, each with the ladder of its reference, by name."""
    return {
        name: make_deep.case_of(rs.load_scene(sections))
        for name, sections in drawn.drawn_scenes(seed).items()
    }


def material_cases(seed: int) -> dict[str, make_deep.Case]:
    """Return the wheel on a rail, brass and ice that are drawn with a seed, each with a ladder of a minute, by name."""
    cases = {
        name: make_deep.case_of(rs.load_scene(sections))
        for name, sections in drawn.material_scenes(seed).items()
    }
    short = {"members": (240, 80, 8), "most_side": 1536}
    return {name: replace(case, first=case.first / 2, **short) for name, case in cases.items()}


def soft_cases(seed: int) -> dict[str, make_deep.Case]:
    """Return six soft bodies that are drawn with a seed, by name.

    Their ladders climb up to 512 q_roll_off in cells of a roll-off wave or more: in half of one the last step of fast
    sliding was 1.06 ± .16 % for .80 ± .15.
    """
    cases = {}
    for name, sections in drawn.soft_scenes(seed).items():
        scene, face = rs.load_scene(sections), sections["surface"]
        kink = face["q_roll_off"]
        top = min(512.0 * kink, face["q_max"])
        first = top / 2 ** round(np.log2(top / (8.0 * kink)))
        waves = 16.0 * face["q_min"] / kink
        cases[name] = make_deep.Case(scene, waves, 2, first, top, (150, 160, 8), 2048)
    return cases


def lay_cases(seed: int) -> dict[str, make_deep.Case]:
    """Return twenty scenes of faces with a lay that are drawn with a seed, by name, with ladders of a minute."""
    cases = {
        name: make_deep.case_of(rs.load_scene(sections))
        for name, sections in drawn.lay_scenes(seed).items()
    }
    return {
        name: replace(case, members=(120, 40, 6), most_side=2048) for name, case in cases.items()
    }


class Draw(NamedTuple):
    """Scenes that are drawn with a seed, and their runs."""

    cases: Callable[[int], dict[str, make_deep.Case]]
    target: float  # relative total error of T_flash
    runs: int  # of a scene at most
    seconds: float  # of CPU time for the runs of a scene
    judged: tuple[str, ...] = tuple(MEASURED)  # observables


DRAWS = {
    "drawn": Draw(drawn_cases, 0.01, 40, 600.0),
    "materials": Draw(material_cases, 0.02, 60, inf),
    # areas and g_σ(0) go on by more than half of their value, so that runs state no error
    "soft": Draw(soft_cases, 0.05, 40, inf, (FLASH, "heat_partition")),
    "lays": Draw(lay_cases, 0.03, 2, inf),
}


def references(case: make_deep.Case, factors: dict[str, Any]) -> dict[str, Pair]:
    """Return value and relative standard error of each observable."""
    found = make_deep.assembled(case, factors)
    pairs = {name: (np.array(row["value"]), np.array(row["error"])) for name, row in found.items()}
    result = {name: pairs[other] for name, other in MEASURED.items() if other}
    if case.scene.counterface_conducts:
        (resting, of_resting), (moving, of_moving) = (
            pairs["resting_flash_temperature"],
            pairs[FLASH],
        )
        bodies = prediction.conduction(case.scene)
        resting = resting * (
            bodies.conductivity / bodies.counter_conductivity
        )  # stored with that of the moving body
        share = resting / (resting + moving)
        result["heat_partition"] = share, (1.0 - share) * np.hypot(of_resting, of_moving)
    return result


def one_run(scene: rs.Scene, numerics: rs.Numerics, target: float, seed: int) -> dict[str, Any]:
    """Run a scene into a folder that is deleted; return mean, total and standard error of each observable."""
    before = resource.getrusage(resource.RUSAGE_SELF)
    with tempfile.TemporaryDirectory() as folder:
        until = {FLASH: target}
        run = rs.run(
            scene, Path(folder) / "run", numerics=numerics, seed=seed, until=until, progress=False
        )
        after = resource.getrusage(resource.RUSAGE_SELF)
        names = [
            name for name in MEASURED if name != "heat_partition" or scene.counterface_conducts
        ]
        estimates = {name: run.estimate(name) for name in names}
        row: dict[str, Any] = {
            name: [
                part.ravel().tolist()
                for part in (found.mean, found.total_error, found.standard_error)
            ]
            for name, found in estimates.items()
        }
        parts = {
            source: float(np.max(np.abs(part / estimates[FLASH].mean)))
            for source, part in estimates[FLASH].budget.items()
        }
        row |= {"parts": parts, "unknown": list(estimates[FLASH].unknown)}
        row |= {"counts": list(run.counts), "met": run.target_met}
    return row | {"seconds": after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime}


def runs(
    name: str, case: make_deep.Case, target: float, seeds: int, rows: Rows, seconds: float = inf
) -> list[dict[str, Any]]:
    """Return a row for each seed; those that are not stored are computed.

    After so many seconds of CPU time in all, and `LEAST_RUNS`, no seed follows.
    """
    sliding = replace(case.scene.sliding, heat_partition="all")
    ensemble = replace(case.scene.ensemble, max_realizations=100_000)
    scene = replace(case.scene, sliding=sliding, ensemble=ensemble)
    numerics = rs.plan(scene, target)
    table = f"{name}, {100 * target:g} %"
    result: list[dict[str, Any]] = []
    for seed in range(FIRST_SEED, FIRST_SEED + seeds):
        if len(result) >= LEAST_RUNS and sum(row["seconds"] for row in result) > seconds:
            break
        result.append(rows.once(table, str(seed), partial(one_run, scene, numerics, target, seed)))
        print(
            f"{table}: seed {seed}, {result[-1]['seconds']:.2f} s, members {result[-1]['counts']}",
            file=sys.stderr,
        )
    return result


def judged(found: list[dict[str, Any]], observable: str, truth: Pair) -> tuple[Array, ...]:
    """Return of each run and speed: relative deviation, total and standard error, and whether the reference is held."""
    value, error = truth
    mean, total, standard = np.moveaxis(np.array([row[observable] for row in found]), 1, 0)
    off, stated = mean / value - 1.0, total / value
    return off, stated, standard / value, np.abs(off) <= np.hypot(stated, 1.96 * error)


def bias(off: Array, stated: Array) -> Array:
    """Return the mean deviation over the mean total error, by speed; zero for shares that are exact."""
    mean, error = off.mean(axis=0), stated.mean(axis=0)
    return np.divide(mean, error, out=np.zeros_like(mean), where=error > 0.0)


def told(
    name: str,
    case: make_deep.Case,
    target: float,
    found: list[dict[str, Any]],
    truth: dict[str, Pair],
) -> None:
    """Print how many intervals hold the references, and how far their means are off, one line for each number."""
    met = sum(bool(row["met"]) for row in found)
    print(
        f"\n**{name}**, for {100 * target:g} %: {met} of {len(found)} runs met it, {seconds_of(found)} CPU s each\n"
    )
    print(
        "| | hold | mean off, % | ± of that | off/stated | stated, % | reference, % | scatter/standard error |"
    )
    print("|---|---|---|---|---|---|---|---|")
    for observable, pair in truth.items():
        off, stated, standard, held = judged(found, observable, pair)
        for k, error in enumerate(pair[1]):
            speed = f" at {case.scene.speeds[k]:g} m/s" if off.shape[1] > 1 else ""
            scatter, own = off[:, k].std(ddof=1), (standard[:, k] ** 2).mean() ** 0.5
            of_mean = np.hypot(scatter / len(off) ** 0.5, error)
            numbers = [f"{100 * off[:, k].mean():+.2f}", f"{100 * of_mean:.2f}"]
            numbers += [f"{bias(off, stated)[k]:+.2f}", f"{100 * stated[:, k].mean():.2f}"]
            numbers += [f"{100 * error:.2f}", f"{scatter / own:.2f}" if own > 0.0 else "–"]
            print(
                f"| {observable}{speed} | {held[:, k].sum()} of {len(off)} | {' | '.join(numbers)} |"
            )


def seconds_of(found: list[dict[str, Any]]) -> str:
    """Return the median of the CPU times, in words."""
    return f"{np.median([row['seconds'] for row in found]):.2g}"


def summary(results: dict[str, Result]) -> list[list[str]]:
    """Return a row for each scene: of each quantity, at the worst speed, how many of the runs hold the reference.

    In brackets is the mean deviation that is largest over the mean stated error.
    """
    table = [["scene, target", "runs", "T_flash", "contact area", "g_σ(0)", "heat share"]]
    for name, (_, target, found, truth) in results.items():
        cells = []
        for observable in MEASURED:
            if observable not in truth:
                cells.append("–")
                continue
            off, stated, _, held = judged(found, observable, truth[observable])
            ratios = bias(off, stated)
            cells.append(f"{held.sum(axis=0).min()} ({ratios[np.argmax(np.abs(ratios))]:+.2f})")
        table.append([f"{name}, {100 * target:g} %", str(len(found)), *cells])
    return table


def counted(results: dict[str, Result]) -> dict[str, float]:
    """Return the number of scenes, of intervals, of those that hold, and the least percentage at a speed.

    They are of T_flash, and "_others" of the other observables.
    """
    numbers: dict[str, float] = {"scenes": len(results)}
    for suffix, is_flash in {"": True, "_others": False}.items():
        held = [
            judged(found, name, truth[name])[3]
            for _, _, found, truth in results.values()
            for name in truth
            if (name == FLASH) == is_flash
        ]
        if held:
            numbers[f"intervals{suffix}"] = sum(each.size for each in held)
            numbers[f"hold{suffix}"] = sum(int(each.sum()) for each in held)
            numbers[f"least_percent{suffix}"] = min(
                100.0 * float(each.mean(axis=0).min()) for each in held
            )
    return numbers


def distances(results: dict[str, Result]) -> list[dict[str, Any]]:
    """Return (run − reference)/total error of every run, by scene and observable at each speed."""
    rows = []
    for name, (case, _, found, truth) in results.items():
        for observable, (value, _) in truth.items():
            mean, total = (np.array([row[observable][i] for row in found]) for i in (0, 1))
            with np.errstate(all="ignore"):  # shares that are exact have no error
                off = (mean - value) / total
            for k in range(off.shape[1]):
                speed = case.scene.speeds[k] if off.shape[1] > 1 else None
                rows.append(
                    {
                        "scene": name,
                        "observable": observable,
                        "speed": speed,
                        "off": off[:, k].tolist(),
                    }
                )
    return rows


def main() -> None:
    command = Command(__file__, __doc__, "two seeds of the demo to 5 %")
    command.add_argument("--only", nargs="*", help="names of scenes")
    command.add_argument("--seeds", type=int, help="runs of each scene, in place of these numbers")
    by = command.add_mutually_exclusive_group()
    by.add_argument(
        "--drawn", type=int, metavar="SEED", help="in place of the six scenes, ten that are drawn"
    )
    by.add_argument(
        "--materials", type=int, metavar="SEED", help="in their place a rail, brass and ice"
    )
    by.add_argument("--soft", type=int, metavar="SEED", help="in their place soft elastic bodies")
    by.add_argument("--lays", type=int, metavar="SEED", help="in their place faces with a lay")
    options = command.parse()
    if options.evidence and (options.toy or options.only):
        command.error("--evidence is of all scenes: leave --toy and --only out")
    kind = next(
        (name for name in DRAWS if getattr(options, name) is not None and not options.toy), ""
    )
    seed, draw = getattr(options, kind, None), DRAWS.get(kind)
    suffix = f"-{kind}-{seed}" * bool(kind)
    cases = draw.cases(seed) if draw else make_deep.cases()
    deep = Rows(options.output / f"deep{suffix}.json" if draw else make_deep.FILE, resume=True)
    rows, results = Rows(options.output / f"coverage{suffix}.json", resume=True), {}
    if unknown := set(options.only or ()) - set(cases):
        command.error(f"--only {', '.join(unknown)}: choose among {', '.join(cases)}")
    for name in ["demo"] if options.toy else options.only or cases:
        case = cases[name]
        target = 0.05 if options.toy else draw.target if draw else TARGETS.get(name, OTHERS)
        if draw:
            make_deep.reference(name, case, deep)
        truth = references(case, deep[name])
        if draw:
            truth = {name: pair for name, pair in truth.items() if name in draw.judged}
        seeds = 2 if options.toy else options.seeds or (draw.runs if draw else RUNS)
        found = runs(name, case, target, seeds, rows, draw.seconds if draw else inf)
        told(name, case, target, found, truth)
        results[name] = case, target, found, truth
    table, off = summary(results), distances(results)
    print(
        "\nintervals that hold the reference, at the worst speed; in brackets the mean deviation over the error:\n"
    )
    print("\n".join(" | ".join(row) for row in table))
    figures.coverage(off, options.output / f"coverage{suffix}.png")
    if options.evidence:
        command_line = f"python experiments/coverage.py{suffix and f' --{kind} {seed}'} --evidence"
        found = {"rows": off, "tables": {"held": table}, "numbers": counted(results)}
        write_evidence("coverage" + f"_{kind}" * bool(kind), command_line, **found)


if __name__ == "__main__":
    main()
