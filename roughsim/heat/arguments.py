"""Arguments of temperatures: times and fluxes, checked and as floats, and the limits of double precision."""

import numpy as np
from numpy.typing import ArrayLike

from roughsim.errors import real_field
from roughsim.grid import Array, Grid

# sides of cells in m: beyond them the fourth powers of wavenumbers leave double precision
_CELLS = 1e-30, 1e30
_FASTEST = 1e20  # v L/D, L the longer side of the cell: far beyond it, no quadrature follows the heat in time
_FURTHEST = 1e12  # cells slid since a start from rest: beyond, the phases q·vt are lost in rounding


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


def need_resolved(grid: Grid, speed: float, diffusivity: float) -> None:
    """Refuse with a ValueError a cell or a Péclet number at which the heat of a moving source is lost in rounding."""
    if min(grid.lengths) < _CELLS[0] or max(grid.lengths) > _CELLS[1]:
        raise ValueError(
            f"lengths = {grid.lengths[0]:.6g} and {grid.lengths[1]:.6g} m must lie between {_CELLS[0]:g} and "
            f"{_CELLS[1]:g} m for a temperature; check the unit"
        )
    side = max(grid.lengths)
    laps = abs(speed) / diffusivity * side
    if laps > _FASTEST:
        raise ValueError(
            f"speed = {speed:.6g} m/s and diffusivity = {diffusivity:.6g} m²/s make the Péclet number v L/D = "
            f"{laps:.3g} of a cell of {side:.6g} m; at most {_FASTEST:g} can be computed: check the units"
        )


def need_phases(grid: Grid, speed: float, durations: Array) -> None:
    """Refuse with a ValueError a finite time, s, over which a source slides too many cells to follow its phase."""
    longest = durations[np.isfinite(durations)].max(initial=0.0)
    side = max(grid.lengths)
    if abs(speed) * longest > _FURTHEST * side:
        raise ValueError(
            f"speed = {speed:.6g} m/s over {longest:.6g} s slides further than {_FURTHEST:g} cells of {side:.6g} m, "
            "so the phase of a wave is lost in rounding; take the steady state, slid_distance = inf"
        )
