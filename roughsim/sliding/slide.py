"""Two rough bodies that slide over one another: contact and temperatures of both bodies, step by step."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from roughsim.contact import Contact, Solid, checked_load, need_solid
from roughsim.errors import instance, number, positive, real_field, sized
from roughsim.grid import Array, Grid, need_grid
from roughsim.heat.arguments import need_resolved
from roughsim.heat.body import Body
from roughsim.sliding.history import follow
from roughsim.sliding.path import oblique_path
from roughsim.sliding.stepping import Motion, contacts


@dataclass(frozen=True, slots=True, eq=False)
class Slide:
    """Observables of two sliding bodies over the slid distance.

    Arrays have shape (steps,); for an array of speeds those that depend on the speed (speeds, steps). Temperatures are
    above the initial temperature of both bodies.

    Attributes
    ----------
    slid_distance : ndarray
        At the end of each step, m.
    flash_temperature, resting_flash_temperature : ndarray
        ⟨Tσ⟩/⟨σ⟩ of the moving and the resting body above the background of each, K.
    moving_share : ndarray
        Share of the heat of the step that enters the moving body.
    background, resting_background : ndarray
        Mean temperature of the surface of the moving and the resting body, K.
    contact_temperature : ndarray
        ⟨Tσ⟩/⟨σ⟩, background included, K; the same for both bodies.
    residual : ndarray
        ‖T₁ − T₂‖/‖T₁ + T₂‖ on the contact.
    frozen_flash_temperature : ndarray
        T_flash if the contact there slid on unchanged with all heat in the moving body, in the steady state, K.
    contact_fraction, plastic_fraction : ndarray
        Share of points with σ > 0, and with σ = σ_P.
    stress_correlation : ndarray
        ⟨δσ(s) δσ(s + Δ)⟩/⟨δσ²⟩ at points of the resting body, with Δ = `slid_distance`, mean over several s; NaN
        of a uniform stress.
    spot_survival : ndarray
        Share of the contact spots of 4 pixels or more, born on the way, that live for longer than `slid_distance`; NaN
        beyond the observed lives, and over a flat.
    contact : Contact
        The last one, in the frame of the resting body.
    """

    slid_distance: Array
    flash_temperature: Array
    resting_flash_temperature: Array
    moving_share: Array
    background: Array
    resting_background: Array
    contact_temperature: Array
    residual: Array
    frozen_flash_temperature: Array
    contact_fraction: Array
    plastic_fraction: Array
    stress_correlation: Array
    spot_survival: Array
    contact: Contact


def slide(  # noqa: PLR0913  (two bodies)
    heights: ArrayLike,
    grid: Grid,
    solid: Solid,
    *,
    nominal_pressure: float,
    friction_coefficient: float,
    speed: ArrayLike,
    moving: Body,
    resting: Body,
    counter_heights: ArrayLike | None = None,
    slid_distance: float,
    steps: int | None = None,
    tolerance: float = 3e-3,
) -> Slide:
    """Slide one rough body over another, and follow the contact and the temperatures of both.

    `heights` rest with the resting body. `counter_heights` ride with the moving one, which moves towards −x (so that
    the contact moves along +x through it); left out it is flat. At each step the contact is solved again, and the heat
    μvσ of each point of the contact is shared so that both surfaces have one temperature there. Each half-space keeps
    the history of its own heat, exactly in the last step; nothing is steady and nothing is averaged. The path is
    slightly oblique to the cell, so that other rows meet when it wraps around.

    First encounter only: each position meets fresh surfaces, without the deformation by earlier contacts.

    TypeError or ValueError for an argument of the wrong kind or out of its range; ConvergenceError if a contact or the
    share of its heat is not found.

    Parameters
    ----------
    heights, counter_heights : array_like
        Shape `grid.shape`, m, each positive towards the other body.
    grid : Grid
        The periodic cell.
    solid : Solid
        E* and, if capped, σ_P of the pair.
    nominal_pressure : float
        σ₀, Pa.
    friction_coefficient : float
        μ > 0: without friction there is no heat to share.
    speed : float or array_like
        v of the moving body over the resting one, m/s, not 0, of either sign; several in an array, all of one sign.
        The contact is solved once for all of them.
    moving, resting : Body
        κ and D, and of each a skin and the depth in which its heat is released. moving.speed − resting.speed must equal
        `speed`; with several speeds both are 0.
    slid_distance : float
        m, at least one pixel; taken to the nearest whole step.
    steps : int, optional
        About how many; each is a whole number of pixels along x. Left out: one pixel each.
    tolerance : float
        Of each contact solve.
    """
    need_grid(grid)
    need_solid(solid)
    for name, body in (("moving", moving), ("resting", resting)):
        instance(name, body, Body, "Body(conductivity=30.0, diffusivity=7.6e-6)")
    load = checked_load("nominal_pressure", nominal_pressure, solid)
    friction = sized("friction_coefficient", friction_coefficient)
    speeds = _checked_speeds(speed, moving, resting)
    distance = positive("slid_distance", slid_distance, "m")
    if steps is not None and (number("steps", steps) < 1 or steps % 1):
        raise ValueError(f"steps = {steps} must be a whole number ≥ 1")
    for body in (moving, resting):
        for v in (body.speed, float(np.abs(speeds).max())):
            need_resolved(grid, v, body.diffusivity)
    path = oblique_path(
        grid, distance, None if steps is None else int(steps), backwards=bool(speeds[0] < 0)
    )
    still = real_field("heights", heights, grid.shape).astype(float, copy=False)
    riding = None
    if counter_heights is not None:
        riding = real_field("counter_heights", counter_heights, grid.shape).astype(
            np.float64, copy=False
        )
    motions = [Motion(abs(v), friction, moving, resting) for v in speeds]
    contacts_along = contacts(still, riding, grid, solid, load, path, tolerance)
    history = follow(contacts_along, grid, path, motions)
    shape = *np.shape(speed), path.steps
    curves = {
        name: values.reshape(shape) if values.ndim == 2 else values
        for name, values in history.curves.items()
    }
    return Slide(**curves, contact=history.contact)


def _checked_speeds(speed: ArrayLike, moving: Body, resting: Body) -> Array:
    """Return the relative speeds, m/s, shape (speeds,), of one sign and not 0."""
    array = np.asarray(speed)
    if array.dtype.kind not in "iuf" or array.ndim > 1 or array.size == 0:
        raise TypeError(f"speed = {speed!r} must be one real number or a 1-D array of them, in m/s")
    speeds = np.atleast_1d(array.astype(float))
    if not np.isfinite(speeds).all() or not (speeds.min() > 0.0 or speeds.max() < 0.0):
        raise ValueError(
            f"speed = {speed!r} m/s must be finite, not 0, and of one sign: the bodies slide one way"
        )
    difference = moving.speed - resting.speed
    if array.ndim == 0 and not math.isclose(difference, speeds[0], rel_tol=1e-9):
        raise ValueError(
            f"moving.speed − resting.speed = {difference:.6g} m/s, but speed = {speeds[0]:.6g} m/s; give the bodies "
            "the speeds of the contact through them"
        )
    if array.ndim and (moving.speed or resting.speed):
        raise ValueError(
            f"several speeds, but moving.speed = {moving.speed:.6g} m/s and resting.speed = {resting.speed:.6g} m/s; "
            "leave both at 0"
        )
    return speeds
