"""Limits of double precision for a moving source of heat: size of the cell, speed, slid distance."""

import numpy as np

from roughsim.grid import Array, Grid

# sides of cells in m: beyond them the fourth powers of wavenumbers leave double precision
CELLS = 1e-30, 1e30
_FASTEST = 1e20  # v L/D, L the longer side of the cell: far beyond it, no quadrature follows the heat in time
FURTHEST = 1e12  # cells slid since a start from rest: beyond, the phases q·vt are lost in rounding


def need_resolved(grid: Grid, speed: float, diffusivity: float) -> None:
    """Refuse with a ValueError a cell or a Péclet number at which the heat of a moving source is lost in rounding."""
    if min(grid.lengths) < CELLS[0] or max(grid.lengths) > CELLS[1]:
        raise ValueError(
            f"lengths = {grid.lengths[0]:.6g} and {grid.lengths[1]:.6g} m must lie between {CELLS[0]:g} and "
            f"{CELLS[1]:g} m for a temperature; check the unit"
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
    if abs(speed) * longest > FURTHEST * side:
        raise ValueError(
            f"speed = {speed:.6g} m/s over {longest:.6g} s slides further than {FURTHEST:g} cells of {side:.6g} m, "
            "so the phase of a wave is lost in rounding; take the steady state, slid_distance = inf"
        )
