"""One member: a surface, its contact, and every functional of its stress spectrum that the map reports.

Dimensionless: wavenumbers in units of q_roll_off, pressures in units of E*h', heat with mu = kappa = D = 1, so that a
speed is the Peclet number v/(D q_roll_off). A functional is a sum over modes, w(q) f(q); all of them are one product
of the radial table w with a matrix of f.
"""

from __future__ import annotations

from functools import lru_cache
from math import pi
from typing import Any, NamedTuple

import numpy as np
from scipy.special import j0

import roughsim as rs
from roughsim import fourier
from roughsim.observables.moments import angular_means
from roughsim.surface.modes import mode_variance

PECLET = np.logspace(-3, 3, 7)
DISTANCES = np.geomspace(0.02, 8.0, 72)  # of g_sigma(r), in 1/q_roll_off
_FINE = 8  # bins per mode spacing: the mean |q| of a bin stands for its modes


def spectrum_of(hurst: float, plateau: float, q_max: float, low_exponent: float) -> rs.SelfAffineSpectrum:
    """C(q) with rms slope 1 and q_r = 1."""
    return rs.SelfAffineSpectrum.from_rms_slope(
        1.0, hurst=hurst, q_min=1.0 / plateau, q_roll_off=1.0, q_max=q_max, roll_off_exponent=low_exponent
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


@lru_cache(maxsize=6)
def roughness(spectrum: Any, grid: rs.Grid) -> Any:
    """Return the variance of the heights by bin."""
    return table(grid, mode_variance(spectrum, grid))


@lru_cache(maxsize=3)
def kernels(grid: rs.Grid) -> Any:
    """Return f of T, T', lap T (all Peclet numbers each), g(0) and g(r) by bin: shape (bins, functionals)."""
    return kernel_matrix(radial(grid).wavenumber)


def kernel_matrix(q: Any) -> Any:
    """Return f of every functional at wavenumbers q, for the variance of the stress; loads and signs left out."""
    means = [angular_means(pe / q) for pe in PECLET]
    temperature = [pe * even / q for pe, (even, _) in zip(PECLET, means, strict=True)]
    gradient = [-pe * odd for pe, (_, odd) in zip(PECLET, means, strict=True)]
    laplacian = [pe * even * q for pe, (even, _) in zip(PECLET, means, strict=True)]
    return np.stack([*temperature, *gradient, *laplacian, np.ones_like(q), *(j0(q * r) for r in DISTANCES)], axis=1)


COLUMNS = {
    "flash_temperature": slice(0, 7),
    "flash_gradient": slice(7, 14),
    "flash_laplacian": slice(14, 21),
    "pressure_variance": slice(21, 22),
    "correlation": slice(22, 22 + DISTANCES.size),
}
FUNCTIONALS = 22 + DISTANCES.size


class Member(NamedTuple):
    """What is kept of one solve: functionals, raw area, its perimeter correction, and the radial stress table."""

    functionals: Any
    area: float
    corrected: float
    stress: Any


def solve(spectrum: Any, grid: rs.Grid, load: float, seed: Any, tolerance: float = 1e-4) -> Member:
    """Draw a surface from the stream `seed`, press it elastically to `load` (units of E*), and reduce the stress."""
    heights = rs.synthesize(spectrum, grid, np.random.default_rng(seed))
    contact = rs.solve_contact(heights, grid, rs.Solid(1.0), nominal_pressure=load, tolerance=tolerance)
    stress = stress_table(contact.pressure, grid)
    corrected, _ = rs.corrected_fractions(contact.pressure)
    return Member(stress @ kernels(grid), contact.contact_fraction, corrected, stress)


def stress_table(pressure: Any, grid: rs.Grid) -> Any:
    """Return |sigma_q|^2 summed by bin."""
    return table(grid, np.abs(fourier.forward(pressure)) ** 2)
