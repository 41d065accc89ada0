"""Levels made by hand, of one observable, by default T_flash, with a T_flash of slow contact of the same numbers."""

from dataclasses import replace

import numpy as np

from roughsim.estimate.mean import mean_of
from roughsim.estimate.telescoping import LevelMean, telescoped
from roughsim.observables.record import Sample

NAME = "flash_temperature"
SLOW = "resting_flash_temperature"
GRADIENT = "flash_gradient"
END = 4.15e7  # rad/m, of the steel
SPEEDS = 7  # of the steel
BOUND = 90e6 / 1.2e9  # σ₀/σ_P of the steel
VARIANCE = 90e6 * 1.2e9 - 90e6**2  # Pa², of a pressure that is σ_P or nothing


def sample(values, q_max=1.0, *, side=64.0, part=False, name=NAME, **numbers):
    """The values of one level, (n, speeds), under the name of an observable."""
    n, numbers = len(values), {name: values, SLOW: values, **numbers}
    return Sample(q_max, side, np.arange(n), numbers, np.ones(1), np.ones((n, 1)), 1.0, part)


def at_level(sample, level, stream, below=None):
    """The sample as of a level with surfaces of a stream, and the level below on the same ones."""
    return replace(sample, level=level, stream=stream, below=below)


def step(level, fine, coarse, cut_offs, *, sides=(64.0, 128.0), stream=None, **names):
    """A level above the lowest: values on the same surfaces at two cut-offs and points per side, the lower first."""
    below, above = (
        sample(values, q_max, side=side, **names)
        for values, q_max, side in zip((coarse, fine), cut_offs, sides, strict=True)
    )
    return at_level(above, level, level if stream is None else stream, below)


def lowest(values, q_max=1.0, *, level=0, stream=0, **names):
    """The lowest level of a column."""
    return at_level(sample(values, q_max, **names), level, stream)


def ladder(means, cut_offs, *, n=6, scatter=0.0, seed=0, **names):
    """Levels with these means, (speeds,) each, at these cut-offs: n surfaces each, alike at a level and below it.

    Their relative scatter has no mean, so that all means and all ratios of means are those given.
    """
    rng = np.random.default_rng(seed)
    pairs = []
    for k, (mean, q_max) in enumerate(zip(means, cut_offs, strict=True)):
        chance = scatter * rng.standard_normal((n, 1))
        factor = 1.0 + chance - chance.mean()
        if k == 0:
            pairs.append(lowest(factor * np.atleast_1d(mean), q_max, **names))
        else:
            below = factor * np.atleast_1d(means[k - 1])
            pairs.append(
                step(k, factor * np.atleast_1d(mean), below, (cut_offs[k - 1], q_max), **names)
            )
    return pairs


def part_of(sample, chosen):
    """A sample of some of its realizations."""
    numbers = {name: values[chosen] for name, values in sample.numbers.items()}
    bins = (
        None
        if sample.bins is None
        else type(sample.bins)(*(values[chosen] for values in sample.bins))
    )
    return replace(
        sample,
        rows=sample.rows[chosen],
        numbers=numbers,
        spectrum=sample.spectrum[chosen],
        bins=bins,
    )


def at_speeds(*means, speeds=SPEEDS):
    return [np.full(speeds, mean) for mean in means]


def with_partner(pairs, change, cut_off, *, speeds=SPEEDS):
    """The levels and one that shows a relative change by half the pixel at a cut-off, of six surfaces."""
    name, values = next(iter(pairs[0].numbers.items()))
    rows = np.full((6, speeds), 3.0 * np.sign(values[0]))
    return [*pairs, step(9, (1.0 + change) * rows, rows, (cut_off, cut_off), name=name)]


def rungs_at(means, cut_offs=(4.0, 8.0, 16.0), **names):
    """Rungs of a ladder of these means."""
    return telescoped(lambda sample: sample.numbers[NAME], ladder(means, cut_offs, **names))


def scattered(means, errors, cut_offs=(4.0, 8.0, 16.0)):
    """Rungs whose means are independent, with these standard errors."""
    rungs = []
    for stream, (mean, error, q_max) in enumerate(zip(means, errors, cut_offs, strict=True)):
        rungs.append(LevelMean(q_max, mean_of(stream, mean + error * np.array([[1.0], [-1.0]]))))
    return rungs


def power_law(q, exponent, limit=7.0, c=3.0):
    return limit + c * np.asarray(q) ** -exponent
