"""Permanent deformation by hardness-capped contact: the plastic displacement, and how it acts on later loads.

The material is elastic and perfectly plastic (Almqvist et al. 2007): at p = σ_P the elastic surface would overlap the
flat, gap < d, and the overlap w = d − gap is the plastic displacement. On the surface h − w the same pressures meet the
conditions of elastic contact. So the same load repeats them without new yielding, lower loads are elastic, and higher
ones continue the first loading: plastic displacements add up to the displacement of the highest load. The plastic work
is σ_P times the volume, since the pressure stays at σ_P while w grows. Pile-up is left out: the volume counts
pressed-in material, which real metals push up beside the contact.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import pi, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from roughsim.contact import Contact, Solid, checked_load, need_solid
from roughsim.contact.active_set import solve_contact
from roughsim.contact.patches import yielded_points
from roughsim.errors import real_field
from roughsim.grid import Array, Field, Grid, need_grid


@dataclass(frozen=True, slots=True, eq=False)
class PlasticDeformation:
    """The permanent deformation of a surface by one contact."""

    displacement: Array  # w ≥ 0, shape `grid.shape`, m, away from the flat, left after unloading
    heights: Array  # the deformed surface, heights − w, m
    volume: float  # ∫ w, m³; times σ_P it is the plastic work, J
    flat_height: float  # height of the flat under load, m, on the scale of the heights; higher ones are pressed down


class LoadStep(NamedTuple):
    """One step of a history of loads: its contact, and the deformation that this step adds."""

    contact: Contact
    deformation: PlasticDeformation


def plastic_deformation(
    contact: Contact, heights: ArrayLike, grid: Grid, solid: Solid
) -> PlasticDeformation:
    """Return the permanent deformation by a solved contact; zero if it is elastic.

    Without any elastic contact the flat may lie anywhere between the lowest yielded point and the highest free one: the
    smallest displacement is taken.

    Parameters
    ----------
    contact : Contact
        A solved contact; the displacement is known to the tolerance of its solve.
    heights, grid, solid
        As `solve_contact` got them.

    Returns
    -------
    PlasticDeformation
        The displacement of the surface, m, and the surface after it.

    Raises
    ------
    TypeError, ValueError
        For fields that are not finite, real and of `grid.shape`, for pressures beyond the hardness, and for heights
        whose gap is not constant over the elastic contact: they, or the cell, do not belong to the contact.
    """
    need_grid(grid)
    need_solid(solid)
    surface = real_field("heights", heights, grid.shape).astype(float, copy=False)
    pressure = real_field("pressure", contact.pressure, grid.shape)
    if not pressure.any():
        raise ValueError(
            "pressure = 0 Pa everywhere: without contact the height of the flat is not known; press harder"
        )
    yielded = yielded_points(pressure, solid.penetration_hardness)
    gap = real_field("displacement", contact.displacement, grid.shape) - surface
    free = gap[(pressure > 0.0) & ~yielded]
    offset = float(free.mean() if free.size else gap[yielded].max())
    if free.size:
        # the residual bounds the errors of the gap: κ‖gap − d‖ ≤ residual ‖p‖ over the elastic contact, κ ≥ πE*/L
        stiffness = pi * solid.effective_modulus / max(grid.lengths)
        largest = float(pressure.max())
        norm = largest * sqrt(float(np.square(pressure / largest).sum()))
        rounding = (
            4
            * float(np.finfo(contact.displacement.dtype).eps)
            * float(np.ptp(contact.displacement))
        )
        rounding += 64 * float(np.finfo(np.float64).eps) * float(np.abs(surface).max())
        limit = 4 * contact.residual * norm / stiffness + rounding * sqrt(free.size)
        error = float(np.abs(free - offset).max())
        if error > limit:
            raise ValueError(
                f"heights: the gap over the elastic contact varies by {error:.6g} m, but the contact was solved to "
                f"{limit:.6g} m; give the heights, the grid and the solid it was solved with"
            )
    displacement = np.where(yielded, np.maximum(offset - gap, 0.0), 0.0)
    volume = float(displacement.mean()) * grid.lengths[0] * grid.lengths[1]
    return PlasticDeformation(displacement, surface - displacement, volume, -offset)


def follow_loads(
    heights: ArrayLike,
    grid: Grid,
    solid: Solid,
    *,
    nominal_pressures: Sequence[float],
    tolerance: float = 1e-6,
) -> Iterator[LoadStep]:
    """Press the surface of a `solid` with one load after another, each on the surface that the last one left.

    Parameters
    ----------
    heights : array_like
        The new surface, shape `grid.shape`, m.
    grid, solid
        As of `solve_contact`.
    nominal_pressures : sequence of float
        σ₀ of each step, Pa, rising or falling; all are checked before the first solve.
    tolerance : float
        Of each solve.

    Yields
    ------
    LoadStep
        The `contact` of a step, and the `deformation` that it adds, whose `heights` are the surface after it.

    Raises
    ------
    TypeError, ValueError, ConvergenceError
        As `solve_contact`.
    """
    need_grid(grid)
    need_solid(solid)
    surface = real_field("heights", heights, grid.shape)
    loads = [checked_load("nominal_pressures", load, solid) for load in nominal_pressures]

    def steps(surface: Field) -> Iterator[LoadStep]:
        for load in loads:
            contact = solve_contact(
                surface, grid, solid, nominal_pressure=load, tolerance=tolerance
            )
            deformation = plastic_deformation(contact, surface, grid, solid)
            surface = deformation.heights
            yield LoadStep(contact, deformation)

    return steps(surface)
