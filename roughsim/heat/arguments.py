"""Times since a start from rest, and heat fluxes, as arguments: checked, and as floats."""

import numpy as np
from numpy.typing import ArrayLike

from roughsim.errors import real_field
from roughsim.grid import Array


def checked_times(time: ArrayLike) -> Array:
    """`time` as a float array of at most one axis, s, ≥ 0; inf may stay."""
    instants = np.asarray(time)
    if instants.dtype.kind not in "iuf":
        raise TypeError(f"time has dtype {instants.dtype}; real numbers in s are needed")
    if instants.ndim > 1 or instants.size == 0:
        raise ValueError(f"time has shape {instants.shape}; give one number or a 1-D array, in s")
    if not (instants >= 0).all():
        raise ValueError(f"time = {instants.min()} s must not be negative or NaN")
    return instants.astype(float)


def checked_duration(time: ArrayLike) -> float:
    """`time` as one number, s, > 0; inf may stay."""
    instant = checked_times(time)
    if instant.ndim or instant == 0.0:
        raise ValueError(f"time = {time!r} s must be one positive number")
    return float(instant)


def checked_flux(heat_flux: ArrayLike, shape: tuple[int, int]) -> Array:
    """`heat_flux` as a float64 field of `shape`, W/m², ≥ 0."""
    flux = real_field("heat_flux", heat_flux, shape).astype(float)
    if flux.min() < 0.0:
        raise ValueError(
            f"heat_flux = {flux.min():.6g} W/m² must not be negative: friction only heats"
        )
    return flux
