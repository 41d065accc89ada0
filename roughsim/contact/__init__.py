"""Elastic and hardness-capped contact of a rough surface with a rigid flat, periodic, under load control.

Minimise ½p·Sp − p·h with 0 ≤ p ≤ σ_P and mean p = σ₀, S(q) = 2/(E*|q|), S(0) = 0: strictly convex, so a small
residual of the optimality conditions is necessary and sufficient (Stanley & Kato 1997; Almqvist et al. 2007 for the
cap). The solve cascades from coarse grids (Bornemann & Deuflhard 1996); the solve itself is in `contact.solver`.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from math import inf
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughsim.contact.solver.cascade import coarser, solve_cascade
from roughsim.contact.solver.full_contact import FullContact, full_contact
from roughsim.contact.solver.half_space import half_space
from roughsim.contact.solver.state import Problem, State, rounding_floor
from roughsim.errors import ConvergenceError, number, positive, real_field
from roughsim.grid import Grid


@dataclass(frozen=True, slots=True)
class Solid:
    """The elastic and plastic properties of the contact.

    Parameters
    ----------
    effective_modulus : float
        E*, Pa: 1/E* = Σ (1 − ν²)/E over both bodies.
    penetration_hardness : float, optional
        σ_P, Pa: the highest pressure. Left out: elastic.
    """

    effective_modulus: float
    penetration_hardness: float = inf

    def __post_init__(self) -> None:
        positive("effective_modulus", self.effective_modulus, "Pa")
        if self.penetration_hardness != inf:
            positive("penetration_hardness", self.penetration_hardness, "Pa")


@dataclass(frozen=True, slots=True)
class Contact:
    """A solved contact.

    Attributes
    ----------
    pressure : ndarray
        p ≥ 0, shape `grid.shape`, Pa; its mean is the nominal pressure.
    displacement : ndarray
        Elastic displacement S p with mean zero, m, positive away from the flat.
    contact_fraction, plastic_fraction : float
        Share of points with p > 0, and with p = σ_P.
    residual : float
        ‖p − clip(p − κ(gap − d), 0, σ_P)‖/‖p‖ of these very fields; it is close to the relative pressure error.
    iterations : int
        Iterations on the finest grid.
    transforms : float
        Work in real float64 FFTs of the finest grid: coarse grids counted by their points, float32 ones as a half.
    """

    pressure: NDArray[Any]
    displacement: NDArray[Any]
    contact_fraction: float
    plastic_fraction: float
    residual: float
    iterations: int
    transforms: float


def solve_contact(
    heights: ArrayLike,
    grid: Grid,
    solid: Solid,
    *,
    nominal_pressure: float,
    tolerance: float = 1e-6,
    max_iterations: int | None = None,
    precision: Literal["double", "single"] = "double",
) -> Contact:
    """Solve for the contact pressure.

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

    Returns
    -------
    Contact
        The fields and how good they are.

    Raises
    ------
    ConvergenceError
        If the tolerance is not met; it carries residual, iterations and the best pressure.
    TypeError, ValueError
        Naming the argument, its value and its limit, before any work.

    Warns
    -----
    RuntimeWarning
        If the tolerance lies below what rounding allows: the solve stops at that floor.
    """
    heights = _checked(heights, grid, solid, nominal_pressure, tolerance, max_iterations, precision)
    limit = 1000 if max_iterations is None else int(max_iterations)
    problem, spectrum, pressure_unit = _dimensionless(heights, grid, solid, nominal_pressure)
    units = problem.unit, pressure_unit, solid.penetration_hardness
    full = full_contact(problem, spectrum)
    if full is not None:
        return _contact(problem, full, units, precision, transforms=2.0)
    levels = coarser(problem, spectrum)
    del spectrum
    state, transforms = solve_cascade(levels, tolerance, limit)
    _judge(state, tolerance, limit, pressure_unit)
    return _contact(problem, state, units, precision, transforms=transforms + 1.0)


def _checked(
    heights: ArrayLike,
    grid: Grid,
    solid: Solid,
    nominal_pressure: float,
    tolerance: float,
    max_iterations: int | None,
    precision: str,
) -> NDArray[np.float64]:
    positive("nominal_pressure", nominal_pressure, "Pa")
    if nominal_pressure > solid.penetration_hardness:
        raise ValueError(
            f"nominal_pressure = {nominal_pressure:.6g} Pa exceeds penetration_hardness = "
            f"{solid.penetration_hardness:.6g} Pa; no contact can carry it"
        )
    if not 0.0 < number("tolerance", tolerance) < 1.0:
        raise ValueError(f"tolerance = {tolerance:.6g} must lie between 0 and 1")
    if max_iterations is not None and (number("max_iterations", max_iterations) < 1 or max_iterations % 1):
        raise ValueError(f"max_iterations = {max_iterations} must be a whole number ≥ 1")
    if precision not in ("double", "single"):
        raise ValueError(f'precision = {precision!r} must be "double" or "single"')
    return real_field("heights", heights, grid.shape).astype(np.float64, copy=False)


def _dimensionless(
    heights: NDArray[np.float64], grid: Grid, solid: Solid, nominal_pressure: float
) -> tuple[Problem, NDArray[Any], float]:
    """Scale lengths to the longer side, heights to their range, and E* to 1; return also the heights' spectrum."""
    low, high = float(heights.min()), float(heights.max())
    middle = 0.5 * (high + low)
    side = max(grid.lengths)
    unit = max(high - middle, middle - low) or side
    pressure_unit = solid.effective_modulus * (unit / side)
    unit_grid = Grid(grid.shape, (grid.lengths[0] / side, grid.lengths[1] / side))
    load, cap = nominal_pressure / pressure_unit, solid.penetration_hardness / pressure_unit
    spectrum = half_space(unit_grid, np.float64).forward((heights - middle) / unit)
    stiffness = _stiffness(spectrum, unit_grid)
    return Problem(heights, middle, unit, unit_grid, load, cap, stiffness), spectrum, pressure_unit


def _stiffness(spectrum: NDArray[Any], grid: Grid) -> float:
    """κ = q_s/2, q_s the highest wavenumber present in the heights."""
    power = np.abs(spectrum)
    present = power > 1e-12 * power.max()
    highest = float(np.max(grid.wavenumbers.T, initial=0.0, where=present))
    return 0.5 * max(highest, 2 * np.pi / max(grid.lengths))


def _judge(solution: State, tolerance: float, limit: int, pressure_unit: float) -> None:
    """Warn at the rounding floor, raise above it."""
    if solution.residual <= tolerance:
        return
    floor = rounding_floor(solution)
    if solution.residual <= 100.0 * floor:
        warnings.warn(
            f"tolerance = {tolerance:.3g} lies below what rounding allows for these heights and this load: stopped at "
            f"residual {solution.residual:.3g}",
            RuntimeWarning,
            stacklevel=3,
        )
        return
    how = "stopped at the limit" if solution.iterations >= limit else "stalled"
    raise ConvergenceError(
        f"contact solve {how}: residual {solution.residual:.3g} after {solution.iterations} iterations, tolerance "
        f"{tolerance:.3g}; raise max_iterations or tolerance, or refine the grid",
        solution.residual,
        solution.iterations,
        solution.pressure * pressure_unit,
    )


def _contact(
    problem: Problem,
    solution: State | FullContact,
    units: tuple[float, float, float],
    precision: str,
    *,
    transforms: float,
) -> Contact:
    length_unit, pressure_unit, hardness = units
    kind = np.float32 if precision == "single" else np.float64
    yielded = solution.pressure >= problem.cap
    contact_fraction = float(np.mean(solution.pressure > 0.0))
    pressure, displacement = solution.pressure, solution.gap
    pressure *= pressure_unit
    if hardness < inf:  # exactly the hardness, not the hardness to rounding
        np.minimum(pressure, hardness, out=pressure)
        pressure[yielded] = hardness
    displacement *= length_unit
    displacement += problem.heights
    displacement -= problem.middle
    return Contact(
        pressure=pressure.astype(kind, copy=False),
        displacement=displacement.astype(kind, copy=False),
        contact_fraction=contact_fraction,
        plastic_fraction=float(np.mean(yielded)),
        residual=solution.residual,
        iterations=solution.iterations,
        transforms=transforms,
    )


__all__ = ["Contact", "Solid", "solve_contact"]
