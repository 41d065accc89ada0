"""How often 95 % intervals hold the truth, when a run stops itself and fine levels are solved for few realizations.

    python experiments/intervals.py [--toy] [-o FOLDER] [--runs NAME ...] [--seeds N]

A made-up observable with a known limit: T(q_c) = 10 + 8/q_c on three cut-offs, every fourth realization at the finer
ones, scatter of 3 % between realizations (normal, or skewed as a gamma distribution) and of 0.2 or 2 % of each step.
The steps are differences, as those of elastic contact. In one series two made-up peak volumes add three times the
variance. Each trial stops at the first n ≥ 12 whose relative half-width meets the target, as a run does.

--runs runs scenes instead, with N seeds each, and asks how many statistical intervals of T_flash hold the mean of all
other seeds: with the regression on the peak volume of the surfaces, and without it on the same members. Runs in FOLDER
are not computed again. --toy makes few trials, or two seeds of a coarse level.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from script import Command

import roughsim as rs
from roughsim.estimate.errors import LEAST, Estimate, estimate, relative_half_width
from roughsim.estimate.ladder import Values, observe, values_of
from roughsim.estimate.regression import CONTROLS
from roughsim.observables.record import Sample

NAME, LIMIT, MOST = "flash_temperature", 10.0, 240
TARGETS = (0.03, 0.02, 0.015, 0.012, 0.01)
RUNS = {"demo": 0.003, "granite": 0.02, "rubber": 0.015, "steel-0.5GPa": 0.005, "steel-1.2GPa": 0.01}  # their targets
FIRST_SEED = 3000
SERIES = (
    ("normal scatter", 0.0, 0.002, False, "#0072b2"),
    ("gamma scatter, skewness 1", 0.5, 0.002, False, "#d55e00"),
    ("normal scatter, steps scatter 2 %", 0.0, 0.02, False, "#009e73"),
    ("normal scatter beside two peak volumes", 0.0, 0.002, True, "#cc79a7"),
)


def level(values: np.ndarray, volumes: np.ndarray, q_max: float, every: int) -> Sample:
    rows = np.arange(0, len(values), every)
    numbers = {NAME: values[rows], **dict(zip(CONTROLS, volumes[:, rows], strict=True))}
    return Sample(q_max, 64.0 * q_max, rows, numbers, np.ones(1), np.ones((len(rows), 1)), 1.0)


def trial(rng: np.random.Generator, target: float, skew: float, step: float, *, follows: bool) -> tuple[bool, int]:
    """Return whether the interval of one run holds the limit, and where the run stopped."""
    noise = rng.gamma(1.0 / skew**2, skew**2, MOST) - 1.0 if skew else rng.standard_normal(MOST)
    base = LIMIT * (1.0 + 0.03 * noise / (skew or 1.0))[:, None] + 8.0
    middle = base - 4.0 * (1.0 + step * rng.standard_normal((MOST, 1)))
    top = middle - 2.0 * (1.0 + step * rng.standard_normal((MOST, 1)))
    volumes = rng.standard_normal((2, MOST)) if follows else np.zeros((2, MOST))
    by_volume = LIMIT * 0.03 * np.sqrt(1.5) * volumes.sum(axis=0)[:, None]  # three times the variance of the rest
    ladder = (base + by_volume, 1.0, 1), (middle + by_volume, 2.0, 4), (top + by_volume, 4.0, 4)

    def seen(n: int) -> Values:
        return observe(NAME, [level(rows[:n], volumes[:, :n], q, every) for rows, q, every in ladder], capped=False)

    stop = next((n for n in range(LEAST, MOST) if relative_half_width(seen(n)) <= target), MOST)
    found = estimate(NAME, seen(stop))
    return bool(abs(found.mean[0] - LIMIT) <= found.half_width[0]), stop


def coverage(
    trials: int, target: float, skew: float, seed: int, step: float = 0.002, *, follows: bool = False
) -> tuple[float, float]:
    """Return the share of intervals that hold the limit, and the mean number of realizations."""
    rng = np.random.default_rng(seed)
    told = np.array([trial(rng, target, skew, step, follows=follows) for _ in range(trials)], dtype=float)
    return float(told[:, 0].mean()), float(told[:, 1].mean())


def of_members(run: rs.Run, *, regression: bool) -> Estimate:
    """Return T_flash of a run, with the regression on the peak volume or without it."""
    column, samples = run.column(None), run.samples(spectra=False)
    if not regression:
        samples = [
            replace(sample, numbers={name: x for name, x in sample.numbers.items() if name not in CONTROLS})
            for sample in samples
        ]
    return estimate(NAME, values_of(run.scene, column, NAME, samples))


def runs_told(name: str, folder: Path, seeds: int, *, toy: bool) -> None:
    """Run a scene with several seeds, and print how many intervals hold the mean of all other seeds, at each speed."""
    stop, scene = RUNS[name], rs.load_scene(name)
    column = "elastic" if scene.elastic else "capped"
    numerics = rs.plan(replace(scene, ensemble=replace(scene.ensemble, until={})), 2.0 * stop)
    # without the partners of half the pixel, which would take most of the time: the first level of each cut-off
    distinct = {(numerics.grid(i).lengths, numerics.levels[i].q_max): i for i in reversed(numerics.of_column(column))}
    levels = tuple(numerics.levels[i] for i in reversed(distinct.values()))
    numerics = replace(numerics, levels=(rs.Level("capped", (64, 64), 2e4),) if toy else levels, keep_fields=0)
    runs = []
    for seed in range(FIRST_SEED, FIRST_SEED + seeds):
        limits = {"max_realizations": 8} if toy else {"until": {NAME: stop}}
        runs.append(rs.run(scene, folder / f"{name}-{seed}", numerics=numerics, seed=seed, **limits))
        print(f"{name}: seed {seed}, n = {runs[-1].realizations}", flush=True)
    for regression in (True, False):
        found = [of_members(run, regression=regression) for run in runs]
        means, errors, halves = (
            np.stack([getattr(each, part) for each in found]) for part in ("mean", "standard_error", "half_width")
        )
        others = (means.sum(axis=0) - means) / (seeds - 1)
        held = np.abs(means - others) <= halves * np.sqrt(1.0 + 1.0 / (seeds - 1))  # the others scatter too
        way = "at the mean peak volume" if regression else "surfaces as they are"
        for k, speed in enumerate(scene.speeds):
            percent = 100.0 / means[:, k].mean()
            print(
                f"{name}, {way}, {speed:g} m/s: {np.count_nonzero(held[:, k])} of {seeds} hold; means scatter by "
                f"{percent * means[:, k].std(ddof=1):.3f} %, standard error {percent * errors[:, k].mean():.3f} %, "
                f"half-width {percent * halves[:, k].mean():.3f} %, mean {means[:, k].mean():.5g} K before its share"
            )


def main() -> None:
    command = Command(__file__, __doc__, "few trials")
    command.add_argument("--runs", nargs="*", choices=sorted(RUNS), help="scenes to run in place of trials")
    command.add_argument("--seeds", type=int, default=40, help="seeds of each scene: 40")
    options = command.parse()
    if options.runs:
        for name in options.runs:
            runs_told(name, options.output, 2 if options.toy else options.seeds, toy=options.toy)
        return
    trials = 40 if options.toy else 5000
    figure = Figure((5.6, 3.4), layout="constrained")
    axes = figure.subplots()
    axes.axhspan(92.5, 97.0, color="0.93")
    axes.axhline(95.0, color="0.5", lw=0.8)
    for words, skew, step, follows, colour in SERIES:
        shares = []
        for target in TARGETS:
            share, count = coverage(trials, target, skew, 3, step, follows=follows)
            shares.append(100 * share)
            print(f"{words}, target {100 * target:g} %: {100 * share:.2f} % covered, mean n = {count:.1f}", flush=True)
        error = 100 * np.sqrt(0.05 * 0.95 / trials)
        axes.errorbar(100 * np.array(TARGETS), shares, yerr=2 * error, fmt="o-", color=colour, label=words, capsize=2)
    axes.set(xlabel="target: relative half-width (%)", ylabel="intervals that hold the limit (%)", ylim=(90, 100))
    axes.legend(frameon=False)
    figure.savefig(options.output / "intervals.png", dpi=130)


if __name__ == "__main__":
    main()
