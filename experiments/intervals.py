"""How often 95 % intervals hold the truth, when a run stops itself and fine levels are solved for few realizations.

    python experiments/intervals.py [--toy] [-o FOLDER]

A made-up observable with a known limit: T(q_c) = 10 + 8/q_c on three cut-offs, every fourth realization at the finer
ones, scatter of 3 % between realizations (normal, or skewed as a gamma distribution) and of 0.2 or 2 % of each step.
Each trial stops at the first n ≥ 12 whose relative half-width meets the target, as a run does. --toy makes few trials.
"""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from script import Command

from roughsim.estimate.errors import LEAST, estimate, relative_half_width
from roughsim.estimate.ladder import Values, observe
from roughsim.observables.record import Sample

NAME, LIMIT, MOST = "flash_temperature", 10.0, 240
TARGETS = (0.03, 0.02, 0.015, 0.012, 0.01)
SERIES = (
    ("normal scatter", 0.0, 0.002, "#0072b2"),
    ("gamma scatter, skewness 1", 0.5, 0.002, "#d55e00"),
    ("normal scatter, steps scatter 2 %", 0.0, 0.02, "#009e73"),
)


def level(values: np.ndarray, q_max: float, every: int) -> Sample:
    rows = np.arange(0, len(values), every)
    chosen = values[rows]
    return Sample(q_max, 64.0 * q_max, rows, {NAME: chosen}, np.ones(1), np.ones((len(chosen), 1)), 1.0)


def trial(rng: np.random.Generator, target: float, skew: float, step: float) -> tuple[bool, int]:
    """Return whether the interval of one run holds the limit, and where the run stopped."""
    noise = rng.gamma(1.0 / skew**2, skew**2, MOST) - 1.0 if skew else rng.standard_normal(MOST)
    base = LIMIT * (1.0 + 0.03 * noise / (skew or 1.0))[:, None] + 8.0
    middle = base - 4.0 * (1.0 + step * rng.standard_normal((MOST, 1)))
    top = middle - 2.0 * (1.0 + step * rng.standard_normal((MOST, 1)))

    def seen(n: int) -> Values:
        return observe(NAME, [level(base[:n], 1.0, 1), level(middle[:n], 2.0, 4), level(top[:n], 4.0, 4)], capped=True)

    stop = next((n for n in range(LEAST, MOST) if relative_half_width(seen(n)) <= target), MOST)
    found = estimate(NAME, seen(stop))
    return bool(abs(found.mean[0] - LIMIT) <= found.half_width[0]), stop


def coverage(trials: int, target: float, skew: float, seed: int, step: float = 0.002) -> tuple[float, float]:
    """Return the share of intervals that hold the limit, and the mean number of realizations."""
    rng = np.random.default_rng(seed)
    told = np.array([trial(rng, target, skew, step) for _ in range(trials)], dtype=float)
    return float(told[:, 0].mean()), float(told[:, 1].mean())


def main() -> None:
    options = Command(__file__, __doc__, "few trials").parse()
    trials = 40 if options.toy else 5000
    figure = Figure((5.6, 3.4), layout="constrained")
    axes = figure.subplots()
    axes.axhspan(92.5, 97.0, color="0.93")
    axes.axhline(95.0, color="0.5", lw=0.8)
    for words, skew, step, colour in SERIES:
        shares = []
        for target in TARGETS:
            share, count = coverage(trials, target, skew, 3, step)
            shares.append(100 * share)
            print(f"{words}, target {100 * target:g} %: {100 * share:.2f} % covered, mean n = {count:.1f}", flush=True)
        error = 100 * np.sqrt(0.05 * 0.95 / trials)
        axes.errorbar(100 * np.array(TARGETS), shares, yerr=2 * error, fmt="o-", color=colour, label=words, capsize=2)
    axes.set(xlabel="target: relative half-width (%)", ylabel="intervals that hold the limit (%)", ylim=(90, 100))
    axes.legend(frameon=False)
    figure.savefig(options.output / "intervals.png", dpi=130)


if __name__ == "__main__":
    main()
