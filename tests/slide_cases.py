"""A tiny scene of two rough faces that slide over one another."""

import numpy as np
from scipy import optimize
from small_scene import CAPPED

from roughsim.observables.distribution import BIN_AREAS
from roughsim.scene import parse_scene

LEVELS = """levels = [
  { column = "capped", shape = [32, 32], q_max = 2.5e4 },
  { column = "sliding", shape = [32, 32], q_max = 2.5e4, first = 2 },
]
"""
SLIDING = (
    CAPPED[: CAPPED.index("levels = [")].replace("speed = [0, 0.1, 35]", "speed = [1, 35]") + LEVELS
)
SLIDING = SLIDING.replace("max_realizations = 6", "max_realizations = 4")
MILLIMETRE = 'history = "sliding"\nslid_distance = "1 mm"'


def sliding_scene(history=MILLIMETRE, *changes):
    """The scene with a history, and with changes, each an old and a new text."""
    text = SLIDING.replace("heat_partition = 0.9\n", f"heat_partition = 0.9\n{history}\n")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    return parse_scene(text)


def of_all(temperature, pressure, own, level, *, by_area):
    """A quantile over contacts under one load together, (n, bins), each of which is `own` without the width of bins."""
    weight = BIN_AREAS * (1.0 if by_area else pressure)
    areas = 1.0 / (pressure @ BIN_AREAS) if by_area else np.ones(len(own))
    middles = np.cumsum(weight * np.ones_like(pressure), axis=1) - 0.5 * weight
    middles /= (weight * np.ones_like(pressure)).sum(axis=1)[:, None]

    def below(kelvin):
        each = zip(temperature, middles, strict=True)
        shares = [np.interp(kelvin, *one, left=0.0, right=1.0) for one in each]
        return np.average(shares, weights=areas) - level

    by_bins = [np.interp(level, *one) for one in zip(middles, temperature, strict=True)]
    ends = temperature.min() - 1.0, temperature.max() + 1.0
    return optimize.brentq(below, *ends) + np.mean(own - by_bins)
