"""Contacts made by hand, and their modes by numpy's transform: what the tests of the moments share."""

import json
from dataclasses import dataclass
from math import pi
from pathlib import Path

import numpy as np

from roughsim import Grid

ANGULAR = json.loads((Path(__file__).parent / "reference" / "heat.json").read_text())["angular"]
BODY = {"friction_coefficient": 0.11, "conductivity": 30.0, "diffusivity": 7.6e-6}
UNIT = {"friction_coefficient": 1.0, "conductivity": 1.0, "diffusivity": 1.0}
CELLS = [
    Grid((16, 16), (1.0, 1.0)),
    Grid((15, 13), (1.0, 1.0)),
    Grid((14, 17), (1.0, 1.7)),
    Grid((12, 10), (2.0, 0.6)),
]


@dataclass
class Pressed:
    """A contact made by hand."""

    pressure: np.ndarray
    contact_fraction: float = 0.25
    plastic_fraction: float = 0.125


def points(grid):
    return np.meshgrid(
        *(np.arange(n) * d for n, d in zip(grid.shape, grid.spacing, strict=True)), indexing="ij"
    )


def patches(grid, seed=1):
    """A rough nonnegative field, mostly zero, with power at all wavenumbers."""
    return np.maximum(np.random.default_rng(seed).standard_normal(grid.shape), 0.3) - 0.3


def plane(pressure, grid):
    """(q_x, q_y, |σ(q)|²) of the whole plane by numpy's transform, without q = 0."""
    qx, qy = (2 * pi * np.fft.fftfreq(n, d) for n, d in zip(grid.shape, grid.spacing, strict=True))
    variance = np.abs(np.fft.fft2(pressure) / pressure.size) ** 2
    variance[0, 0] = 0.0
    return *np.meshgrid(qx, qy, indexing="ij"), variance
