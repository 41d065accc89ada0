"""The stress spectrum of one member by bins of |q|, and the functionals of it that are reported.

Dimensionless: wavenumbers in units of q_roll_off, pressures in units of E*h', heat with mu = kappa = D = 1, so that a
speed is the Peclet number v/(D q_roll_off). A functional is a sum over modes, w(q) f(q); all of them are one product
of the radial table w with a matrix of f.
"""

from __future__ import annotations

from functools import lru_cache
from math import pi
from typing import Any, NamedTuple

import numpy as np

import roughsim as rs
from roughsim import fourier
from roughsim.observables.moments import angular_means

PECLET = np.logspace(-3, 3, 7)
_FINE = 8  # bins per mode spacing: the mean |q| of a bin stands for its modes


def spectrum_of(
    hurst: float, plateau: float, q_max: float, low_exponent: float
) -> rs.SelfAffineSpectrum:
    """C(q) with rms slope 1 and q_r = 1."""
    return rs.SelfAffineSpectrum.from_rms_slope(
        1.0,
        hurst=hurst,
        q_min=1.0 / plateau,
        q_roll_off=1.0,
        q_max=q_max,
        roll_off_exponent=low_exponent,
    )


class Radial(NamedTuple):
    """A quantity per bin of |q|: mean wavenumber of the bin, number of modes, bin of each entry of the half plane."""

    wavenumber: Any
    count: Any
    place: Any


@lru_cache(maxsize=3)
def radial(grid: rs.Grid) -> Radial:
    """Return the bins of a grid; empty ones have the wavenumber 1, so that nothing divides by 0."""
    step = 2 * pi / grid.lengths[0]
    place = np.rint(grid.wavenumbers * (_FINE / step)).astype(np.int32).ravel()
    ones = np.broadcast_to(grid.multiplicity, grid.half_shape).ravel().astype(float)
    count = np.bincount(place, ones)
    mean = np.bincount(place, ones * grid.wavenumbers.ravel()) / np.maximum(count, 1)
    return Radial(np.where(count > 0, np.maximum(mean, step / 2), 1.0), count, place)


def table(grid: rs.Grid, half_plane: Any) -> Any:
    """Return the sum of a quantity of the modes by bin, without q = 0."""
    weighted = (half_plane * grid.multiplicity).ravel()
    sums = np.bincount(radial(grid).place, weighted, minlength=radial(grid).count.size)
    sums[0] = 0.0
    return sums


def kernel_matrix(q: Any) -> Any:
    """Return f of T_flash at all Péclet numbers and of g_sigma(0) at wavenumbers q: shape (bins, functionals)."""
    temperature = [pe * angular_means(pe / q)[0] / q for pe in PECLET]
    return np.stack([*temperature, np.ones_like(q)], axis=1)


def stress_table(pressure: Any, grid: rs.Grid) -> Any:
    """Return |sigma_q|^2 summed by bin."""
    return table(grid, np.abs(fourier.forward(pressure)) ** 2)
