"""What the skewness of a surface says of its contact, and what a second contact of the surface upside down would.

    python experiments/skewness.py [--toy] [-o FOLDER] [--only NAME ...] [--pairs N]

Each scene is solved at the coarsest level of its plan, N surfaces h and each also as −h. Printed is, for T_flash at the
slowest and fastest speed, g_σ(0) and the contact area: the scatter of one contact; the correlation of h with −h; the
variance × cost of pairs over that of single contacts; and what a regression on the skewness of the long waves leaves of
the variance, which takes no further contact. The same for the step to twice the cut-off, over 12 of the surfaces. --toy
takes 10 small surfaces.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure
from script import Command

import roughsim as rs
from roughsim.observables.moments import measure
from roughsim.pipeline import Problem
from roughsim.planning.realization import level_problem
from roughsim.surface.skewness import long_wave_skewness
from roughsim.surface.synthesis import synthesize

SCENES = ("demo", "steel-0.5GPa", "steel-1.2GPa", "steel-2.0GPa", "rubber", "granite")
TITLES = ("T_flash, slowest", "T_flash, fastest", "g(0)", "area")
SEED, OF_STEP = 77, 12


def solved(problem: Problem, heights: np.ndarray) -> list[float]:
    """Return the numbers of `TITLES` of one contact."""
    contact = rs.solve_contact(
        heights,
        problem.grid,
        problem.solid,
        nominal_pressure=problem.nominal_pressure,
        tolerance=problem.tolerance,
    )
    moments = measure(contact, problem.grid, problem.sliding)
    temperature, variance = moments.flash_temperature, moments.stress_spectrum.variance.sum()
    return [temperature[0], temperature[-1], variance, contact.contact_fraction]


def pairs(problem: Problem, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the numbers (count, 2, 4) of h and −h, and the skewness (count,) of h."""
    numbers, skewness = [], []
    for index in range(count):
        stream = np.random.default_rng(np.random.SeedSequence(SEED, spawn_key=(problem.stream, index)))
        heights = synthesize(problem.spectrum, problem.grid, stream)
        numbers.append([solved(problem, heights), solved(problem, -heights)])
        skewness.append(long_wave_skewness(heights, problem.grid))
    return np.array(numbers), np.array(skewness)


def told(words: str, numbers: np.ndarray, skewness: np.ndarray, whole: np.ndarray) -> np.ndarray:
    """Print a line for each number, and return the share of variance that the regression leaves."""
    off = numbers - numbers.mean(axis=(0, 1))
    variance = (off**2).mean(axis=(0, 1))
    with np.errstate(invalid="ignore"):  # at rest, or without a step
        correlation = (off[:, 0] * off[:, 1]).mean(axis=0) / variance
        both, control = np.concatenate([off[:, 0], off[:, 1]]), np.concatenate([skewness, -skewness])
        slope = control @ both / (control @ control)
        left = ((both - control[:, None] * slope) ** 2).mean(axis=0) / variance
    for k, title in enumerate(TITLES):
        print(
            f"{words:28s} {title:16s} scatter {100 * np.sqrt(variance[k]) / whole[k]:.2f} %, h and −h correlated by "
            f"{correlation[k]:+.2f}: pairs cost {1 + correlation[k]:.2f}, regression leaves {left[k]:.2f}",
            flush=True,
        )
    return left


def main() -> None:
    command = Command(__file__, __doc__, "10 small surfaces")
    command.add_argument("--only", nargs="*", help="names of scenes")
    command.add_argument("--pairs", type=int, default=50, help="surfaces of each scene: 50")
    options = command.parse()
    figure = Figure((6.4, 3.4), layout="constrained")
    axes = figure.subplots()
    for name in options.only or (SCENES[:1] if options.toy else SCENES):
        scene = rs.load_scene(name)
        numerics = rs.plan(scene)
        first_level = numerics.levels[numerics.of_column(numerics.columns[-1])[0]]
        if options.toy:
            first_level = replace(first_level, shape=(64, 64), q_max=2e4)
        finer, end = tuple(2 * points for points in first_level.shape), scene.spectrum.breaks[-1]
        levels = (first_level, replace(first_level, shape=finer, q_max=min(2 * first_level.q_max, end)))
        numerics = replace(numerics, levels=levels)
        count = 10 if options.toy else options.pairs
        first, skewness = pairs(level_problem(scene, numerics, 0), count)
        whole = first.mean(axis=(0, 1))
        told(name, first, skewness, whole)
        few = min(count, OF_STEP)
        second, _ = pairs(level_problem(scene, numerics, 1), few)
        told(f"{name}, step to {levels[1].shape[0]}²", second - first[:few], skewness[:few], whole)
        relative = 100 * (np.concatenate([first[:, 0, 1], first[:, 1, 1]]) / whole[1] - 1)
        axes.plot(np.concatenate([skewness, -skewness]), relative, ".", ms=4, label=name)
    axes.set(xlabel="skewness of the long waves", ylabel="T_flash at the fastest speed, off its mean (%)")
    axes.legend(frameon=False, fontsize=7)
    figure.savefig(options.output / "skewness.png", dpi=130)


if __name__ == "__main__":
    main()
