"""What the peaks of a surface say of its contact, and what a second contact of the surface upside down would.

    python experiments/peak_volume.py [--toy] [-o FOLDER] [--only NAME ...] [--pairs N]

Each scene is solved at the coarsest level of its plan, N surfaces h and each also as −h. Printed is, for T_flash at the
slowest and fastest speed, g_σ(0) and the contact area: the scatter of one contact; the correlation of h with −h; the
variance × cost of pairs over that of single contacts; and what a regression leaves of the variance, which takes no
further contact: on the peak volume of the surface, as runs do, and on the skewness ⟨h³⟩/⟨h²⟩^(3/2). For the step to
twice the cut-off the correlation of h with −h, over 12 of the surfaces. --toy takes 10 small surfaces.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure
from script import Command

import roughsim as rs
from roughsim.pipeline import Problem, solve_problem
from roughsim.planning.realization import level_problem

SCENES = ("demo", "steel-0.5GPa", "steel-1.2GPa", "steel-2.0GPa", "granite")
TITLES = ("T_flash, slowest", "T_flash, fastest", "g(0)", "area")
SEED, OF_STEP = 77, 12


def numbers_of(solution: rs.Solution) -> list[float]:
    """Return the numbers of `TITLES` of one contact."""
    moments = solution.observables
    temperature, variance = moments.flash_temperature, moments.stress_spectrum.variance.sum()
    return [temperature[0], temperature[-1], variance, solution.contact.contact_fraction]


def pairs(problem: Problem, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the numbers (count, 2, 4) of h and −h, the peak volume (count, 1) and the skewness (count, 1) of h."""
    numbers, volumes, skewness = [], [], []
    for index in range(count):
        drawn = replace(problem, seed=SEED, index=index)
        upright = solve_problem(drawn)
        heights = upright.heights
        numbers.append([numbers_of(upright), numbers_of(solve_problem(drawn, heights=-heights))])
        volumes.append([upright.peak_volume])
        skewness.append([(heights**3).mean() / (heights**2).mean() ** 1.5])
    return np.array(numbers), np.array(volumes), np.array(skewness)


def explained(numbers: np.ndarray, controls: np.ndarray) -> np.ndarray:
    """Return the part of numbers (n, 4), less their mean, that follows controls (n, any) in a regression."""
    off, known = numbers - numbers.mean(axis=0), controls - controls.mean(axis=0)
    result: np.ndarray = known @ np.linalg.lstsq(known, off, rcond=None)[0]
    return result


def left(numbers: np.ndarray, controls: np.ndarray) -> np.ndarray:
    """Return the share of the variance of numbers (n, 4) that a regression on controls (n, any) leaves."""
    residuals = numbers - numbers.mean(axis=0) - explained(numbers, controls)
    freedom = len(numbers) - 1 - np.linalg.matrix_rank(controls)
    with np.errstate(invalid="ignore"):  # at rest
        return np.asarray((residuals**2).sum(axis=0) / freedom / numbers.var(axis=0, ddof=1))


def correlation_of_pairs(numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the variance of numbers (n, 2, 4), and the correlation of the first with the second of each pair."""
    off = numbers - numbers.mean(axis=(0, 1))
    variance = (off**2).mean(axis=(0, 1))
    with np.errstate(invalid="ignore"):  # at rest, or without a step
        return variance, (off[:, 0] * off[:, 1]).mean(axis=0) / variance


def main() -> None:
    command = Command(__file__, __doc__, "10 small surfaces")
    command.add_argument("--only", nargs="*", help="names of scenes")
    command.add_argument("--pairs", type=int, default=200, help="surfaces of each scene: 200")
    options = command.parse()
    figure = Figure((4.4, 4.2), layout="constrained")
    axes = figure.subplots()
    for name in options.only or (SCENES[:1] if options.toy else SCENES):
        scene = rs.load_scene(name)
        numerics = rs.plan(scene)
        first_level = numerics.levels[numerics.of_column(numerics.columns[-1])[0]]
        if options.toy:
            first_level = replace(first_level, shape=(64, 64), q_max=2e4)
        finer, end = tuple(2 * points for points in first_level.shape), scene.spectrum.breaks[-1]
        levels = (
            first_level,
            replace(first_level, shape=finer, q_max=min(2 * first_level.q_max, end)),
        )
        numerics = replace(numerics, levels=levels)
        count = 10 if options.toy else options.pairs
        first, volumes, skewness = pairs(level_problem(scene, numerics, 0), count)
        whole, (variance, correlation) = first.mean(axis=(0, 1)), correlation_of_pairs(first)
        upright = first[:, 0]
        by_volumes, by_skewness = left(upright, volumes), left(upright, skewness)
        for k, title in enumerate(TITLES):
            print(
                f"{name:14s} {title:16s} scatter {100 * np.sqrt(variance[k]) / whole[k]:.2f} %, h and −h correlated by "
                f"{correlation[k]:+.2f}: pairs cost {1 + correlation[k]:.2f}; regression on the peak volume leaves "
                f"{by_volumes[k]:.2f}, on skewness {by_skewness[k]:.2f}",
                flush=True,
            )
        few = min(count, OF_STEP)
        second, _, _ = pairs(level_problem(scene, numerics, 1), few)
        steps = correlation_of_pairs(second - first[:few])[1]
        words = ", ".join(f"{title} {steps[k]:+.2f}" for k, title in enumerate(TITLES))
        print(
            f"{name}, step from {levels[0].shape[0]}² to {levels[1].shape[0]}², h and −h: {words}",
            flush=True,
        )
        off = upright[:, 1] - upright[:, 1].mean()
        told = explained(upright, volumes)[:, 1]
        axes.plot(100 * told / whole[1], 100 * off / whole[1], ".", ms=4, label=name)
    axes.axline((0.0, 0.0), slope=1.0, color="0.7", lw=0.8, zorder=0)
    axes.set(
        xlabel="what the peak volume says (%)",
        ylabel="T_flash at the fastest speed, off its mean (%)",
        aspect="equal",
    )
    axes.legend(frameon=False, fontsize=7)
    figure.savefig(options.output / "peak_volume.png", dpi=130)


if __name__ == "__main__":
    main()
