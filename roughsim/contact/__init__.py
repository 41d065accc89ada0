"""Elastic and hardness-capped contact of a rough surface with a rigid flat, periodic, under load control.

This module has the material (`Solid`) and the result (`Contact`). `active_set` has `solve_contact`, and `solver` its
algorithm. `patches` measures the connected patches of a contact, `plasticity` its permanent deformation.
"""

from dataclasses import dataclass
from math import inf
from typing import Any

from roughsim.errors import instance, positive
from roughsim.grid import Field, Grid


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


@dataclass(frozen=True, slots=True, repr=False)
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
        Work in real float64 FFTs of the finest grid: one of a coarse grid counts by its points, of float32 as a half.
    grid : Grid or None
        Grid of the fields.
    solid : Solid or None
        The elastic and plastic properties. `solve_contact` sets both; a solver of another package may leave them out.
    """

    pressure: Field
    displacement: Field
    contact_fraction: float
    plastic_fraction: float
    residual: float
    iterations: int
    transforms: float
    grid: Grid | None = None
    solid: Solid | None = None

    def __repr__(self) -> str:
        shape = " × ".join(map(str, self.pressure.shape))
        return (
            f"<Contact on {shape} points: contact_fraction {self.contact_fraction:.4g}, plastic_fraction "
            f"{self.plastic_fraction:.4g}, residual {self.residual:.1e} after {self.iterations} iterations>"
        )


def checked_load(name: str, nominal_pressure: float, solid: Solid) -> float:
    """Return a nominal pressure as a float, Pa; ValueError or TypeError if no contact of the solid can carry it."""
    load = positive(name, nominal_pressure, "Pa")
    if load > solid.penetration_hardness:
        raise ValueError(
            f"{name} = {load:.6g} Pa exceeds penetration_hardness = {solid.penetration_hardness:.6g} Pa; "
            "no contact can carry it"
        )
    return load


def need_solid(solid: Any) -> None:
    """Raise a TypeError unless `solid` is a `Solid`."""
    instance("solid", solid, Solid, "Solid(effective_modulus=1.1e11)")
