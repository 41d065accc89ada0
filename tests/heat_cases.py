"""Bodies, grids and comparisons that the tests of the heat solvers share."""

import json
import warnings
from math import inf
from pathlib import Path

import numpy as np

from roughsim import sliding_temperature
from roughsim.heat.influence import one_sided_influence

REFERENCE = json.loads((Path(__file__).parent / "reference" / "heat.json").read_text())
UNIT = {"conductivity": 1.0, "diffusivity": 1.0}
STEEL = {"conductivity": 30.0, "diffusivity": 7.6e-6}


def points(grid):
    return np.meshgrid(
        *(np.arange(n) * d for n, d in zip(grid.shape, grid.spacing, strict=True)), indexing="ij"
    )


def steady(*args, **kwargs):
    """The paper's kernel; that it warns has a test of its own."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=r"v L/\(2πD\)")
        return sliding_temperature(*args, slid_distance=inf, **kwargs)


def close(actual, expected, tolerance):
    scale = np.abs(expected).max()
    np.testing.assert_allclose(actual, expected, rtol=0, atol=tolerance * scale)


def pixel_influence(x, y, **options):
    """κT at all offsets from −(n − 1) to n − 1 pixels, also where it is even along y."""
    result = one_sided_influence(x, y, **options)
    return np.concatenate((result[:, :0:-1], result), axis=1) if y.mirrored else result
