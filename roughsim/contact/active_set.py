"""The contact solver of the package: pressure and displacement of a rough surface on a rigid flat.

Minimise ½p·Sp − p·h with 0 ≤ p ≤ σ_P and mean p = σ₀, S(q) = 2/(E*|q|), S(0) = 0: strictly convex, so a small
residual of the optimality conditions is necessary and sufficient (Stanley & Kato 1997; Almqvist et al. 2007 for the
cap). The solve cascades from coarse grids to the finest (Bornemann & Deuflhard 1996). This module checks the arguments,
goes to dimensionless units and back, and judges the result; the algorithm is in `contact.solver`.
"""

import warnings
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from roughsim._kernels import is_loaded, was_compiled
from roughsim._kernels.active_set import contact_sum, to_si
from roughsim.contact import Contact, Solid, checked_load, need_solid
from roughsim.contact.solver.problem import (
    ScaledProblem,
    ScaledSolution,
    coarser,
    dimensionless,
    full_contact,
)
from roughsim.contact.solver.solve import solve_cascade
from roughsim.contact.solver.steps import rounding_floor
from roughsim.errors import ConvergenceError, number, real_field
from roughsim.fourier.blocks import run, spans, total
from roughsim.grid import Field, Grid, need_grid
from roughsim.show.text import note


def solve_contact(
    heights: ArrayLike,
    grid: Grid,
    solid: Solid,
    *,
    nominal_pressure: float,
    tolerance: float = 1e-6,
    max_iterations: int | None = None,
    precision: Literal["double", "single"] = "double",
    start: Contact | None = None,
) -> Contact:
    """Solve for the contact pressure.

    TypeError or ValueError, before any work, for an argument of the wrong kind or out of range; ConvergenceError, with
    residual, iterations and the best pressure, if the tolerance is not met. A RuntimeWarning if the tolerance lies
    below the rounding floor: the solve stops at that floor.

    Parameters
    ----------
    heights : array_like
        Composite heights, shape `grid.shape`, m, positive towards the flat; any real type.
    grid : Grid
        The periodic cell.
    solid : Solid
        E* and, if capped, σ_P.
    nominal_pressure : float
        σ₀ = mean p, Pa, at most σ_P.
    tolerance : float, optional
        Relative pressure error aimed at, through the residual; between 0 and 1.
    max_iterations : int, optional
        Limit on each grid; 1000 if left out.
    precision : {"double", "single"}, optional
        Of the returned fields; how precisely the solve computes follows from the tolerance.
    start : Contact, optional
        An earlier contact of the same cell, on any grid, to begin from: at a neighbouring load, after a small slide, or
        on a coarser grid. It saves work, the result meets the same tolerance.

    Returns
    -------
    Contact
        The fields and how good they are.
    """
    need_grid(grid)
    need_solid(solid)
    load = checked_load("nominal_pressure", nominal_pressure, solid)
    if not 0.0 < number("tolerance", tolerance) < 1.0:
        raise ValueError(f"tolerance = {tolerance:.6g} must lie between 0 and 1")
    if max_iterations is not None and (
        number("max_iterations", max_iterations) < 1 or max_iterations % 1
    ):
        raise ValueError(f"max_iterations = {max_iterations} must be a whole number ≥ 1")
    if precision not in ("double", "single"):
        raise ValueError(f'precision = {precision!r} must be "double" or "single"')
    surface = real_field("heights", heights, grid.shape).astype(float, copy=False)
    earlier = None if start is None else _start_pressure(start)
    note_compilation()
    problem, relief, pressure_unit = dimensionless(
        surface, grid, solid.effective_modulus, load, solid.penetration_hardness
    )
    # if no point lifts off, closed form; else a solve, coarse grids first
    solution = full_contact(problem, relief)
    if solution is None:
        levels = coarser(problem, relief, 0 if earlier is None else earlier.size)
        del relief  # its spectrum is as large as the heights
        limit = 1000 if max_iterations is None else int(max_iterations)
        first = None if earlier is None else earlier / pressure_unit
        solution = solve_cascade(levels, tolerance, limit, first)
        if solution.residual > tolerance:
            _warn_or_raise(solution, problem, tolerance, limit, pressure_unit)
    # back to SI, in place
    pressure, gap, residual, iterations, transforms = solution
    fields = pressure, gap, problem.heights
    units = pressure_unit, problem.unit, problem.middle
    bounds = problem.cap, solid.penetration_hardness

    def convert(first: int, last: int) -> Any:
        return to_si(*(field[first:last].ravel() for field in fields), units, bounds)

    touching, yielded = total(run(convert, spans(*grid.shape)))
    kind = np.float32 if precision == "single" else np.float64
    return Contact(
        pressure=pressure.astype(kind, copy=False),
        displacement=gap.astype(kind, copy=False),
        contact_fraction=float(touching / grid.points),
        plastic_fraction=float(yielded / grid.points),
        residual=residual,
        iterations=iterations,
        transforms=transforms + 1.0,  # of the heights
        grid=grid,
        solid=solid,
    )


def note_compilation() -> None:
    """Print a line if the first kernel of a process is not in numba's cache: then all others follow, one by one."""
    if is_loaded(contact_sum):
        return
    contact_sum(np.ones(1), np.ones(1))
    if was_compiled(contact_sum):
        note("compiling the contact solver, once on this machine: some seconds")


def _start_pressure(start: Contact) -> Field:
    """Return the pressure of an earlier contact as float64; refuse one that no solve can begin from."""
    if not isinstance(start, Contact):
        raise TypeError(
            f"start is a {type(start).__name__}; give the Contact of an earlier solve, or leave it out"
        )
    pressure = real_field("start.pressure", start.pressure).astype(float, copy=False)
    if not pressure.max() > 0.0:
        raise ValueError(
            "start.pressure = 0 Pa everywhere: no solve can begin from it; leave start out"
        )
    return pressure


def _warn_or_raise(
    solution: ScaledSolution,
    problem: ScaledProblem,
    tolerance: float,
    limit: int,
    pressure_unit: float,
) -> None:
    """Warn if rounding ended the solve; raise ConvergenceError if anything else did."""
    pressure, _, residual, iterations, _ = solution
    if residual <= 100.0 * rounding_floor(problem, pressure):
        warnings.warn(
            f"tolerance = {tolerance:.3g} lies below the rounding floor of these heights and this load: the solve "
            f"stopped at residual {residual:.3g}; choose a tolerance above it",
            RuntimeWarning,
            stacklevel=3,
        )
        return
    how = "stopped at the limit" if iterations >= limit else "stalled"
    raise ConvergenceError(
        f"contact solve {how}: residual {residual:.3g} after {iterations} iterations, tolerance "
        f"{tolerance:.3g}; raise max_iterations or tolerance, or refine the grid",
        residual,
        iterations,
        pressure * pressure_unit,
    )
