"""How two sliding bodies share the heat of their contact, on the free half-space.

One number, the paper's rule: s = T₁/(T₁ + T₂) with the flash temperatures that each body would have with all the heat,
T₁ in the resting body and T₂ in the moving one; the mean temperatures agree then, the local ones do not. Pointwise:
the two temperatures agree at every pixel of the contact, (S₁ + S₂) q₂ = S₁ q̇. That flux has singular edges and may
change sign, so its extremes are numbers of the grid and not of the physics.
"""

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from roughsim import fourier
from roughsim.errors import ConvergenceError, need_computed
from roughsim.fourier import convolution
from roughsim.grid import Field, Grid, Mask, need_grid
from roughsim.heat.arguments import checked_duration, checked_flux, need_resolved
from roughsim.heat.body import Body
from roughsim.heat.half_space import axes, influence_response, padded_shape

_TOLERANCE = 1e-8
_RESTART = 40  # applications of the operator in a round of GMRES; 8 to 14 are usual


@dataclass(frozen=True, slots=True)
class Partition:
    """The heat of a contact, shared between two bodies."""

    moving_share: float  # share of all the heat that enters the moving body
    heat_flux: Field  # entering the moving body, W/m²; pointwise it is singular at the edges of the contact
    temperature: Field  # of the surface of the moving body, K, shape `grid.shape`
    flash_temperature: float  # Σ T q̇/Σ q̇ with the whole heat as weight, K
    max_temperature: float  # the highest of the contact, K
    mean_share: float  # the share by the one-number rule
    mismatch: float  # largest |T₁ − T₂| on the contact under the one-number rule, over the highest T it gives there
    residual: float  # ‖T₁ − T₂‖/‖T₁ with all the heat‖ on the contact; 0 for the one-number rule: nothing iterates
    applications: int  # times that the operator S₁ + S₂ was applied


def partition_heat(
    heat_flux: ArrayLike,
    grid: Grid,
    *,
    moving: Body,
    resting: Body,
    pointwise: bool = True,
    time: float = math.inf,
) -> Partition:
    """Share the frictional heat between two bodies on the free half-space.

    Parameters
    ----------
    heat_flux : array_like
        Heat set free in the contact, shape `grid.shape`, W/m², ≥ 0; its positive pixels are the contact, and nothing
        lies around the grid.
    grid : Grid
        The grid of the flux.
    moving, resting : Body
        The shares are of the body `moving`, the rest enters `resting`.
    pointwise : bool
        Equal temperatures at each pixel of the contact; False: one share for all, from equal flash temperatures.
    time : float
        Time since the start from rest, s, > 0, the same for both bodies; inf is the steady state.

    Returns
    -------
    Partition
        Shares, fluxes and temperatures. Without contact both fields are zero and all numbers NaN, with a
        RuntimeWarning.

    Raises
    ------
    TypeError, ValueError
        For an argument of the wrong kind, not finite or out of its range.
    ConvergenceError
        If the two temperatures do not agree to 1e-8 within three rounds of 40 applications of their operator.
    """
    need_grid(grid)
    for body in (moving, resting):
        need_resolved(grid, body.speed, body.diffusivity)
    flux = checked_flux(heat_flux, grid.shape)
    duration = checked_duration(time)
    if not flux.any():
        warnings.warn(
            "heat_flux = 0 W/m² everywhere: there is no contact, and the share is NaN",
            RuntimeWarning,
            stacklevel=2,
        )
        nothing = np.zeros(grid.shape)
        nan = math.nan
        return Partition(nan, nothing, nothing.copy(), nan, nan, nan, nan, nan, 0)
    # in units of the largest flux: the temperatures that each body would have with all the heat, the resting one first
    unit = flux.max()
    contact = flux > 0.0
    flux = flux / unit
    spectra = [body_spectrum(body, grid, duration) for body in (resting, moving)]
    full = [convolution.convolve(flux, spectrum, padded_shape(grid.shape)) for spectrum in spectra]
    flash = [float((temperature * flux).sum() / flux.sum()) for temperature in full]
    # the one-number rule, and the difference of the two temperatures under it
    share = moving_share = flash[0] / sum(flash)
    temperature = share * full[1]
    entering = share * flux
    colder = ((1 - share) * full[0])[contact]
    warmer = temperature[contact]
    mismatch = float(np.abs(colder - warmer).max() / max(colder.max(), warmer.max()))
    residual = 0.0
    applications = 0
    if pointwise:
        total = spectra[0] + spectra[1]
        scale = float(np.linalg.norm(full[0][contact]))
        drifts = [abs(body.speed) / body.diffusivity for body in (resting, moving)]
        inverse = _nearly_inverse(contact, grid, total, min(drifts) * grid.lengths[0])
        change, residual, applications = _close_the_jump(
            colder - warmer, contact, total, inverse, scale
        )
        entering = np.zeros(grid.shape)
        entering[contact] = share * flux[contact] + change
        temperature = convolution.convolve(entering, spectra[1], padded_shape(grid.shape))
        moving_share = float(entering.sum() / flux.sum())
    temperature = temperature * unit
    need_computed("temperature", temperature, "K", "heat_flux and conductivity")
    return Partition(
        moving_share=moving_share,
        heat_flux=entering * unit,
        temperature=temperature,
        flash_temperature=float((temperature * flux).sum() / flux.sum()),
        max_temperature=float(temperature[contact].max()),
        mean_share=share,
        mismatch=mismatch,
        residual=residual,
        applications=applications,
    )


def body_spectrum(body: Body, grid: Grid, time: float) -> Field:
    """Return the padded half spectrum that turns the heat flux into a body into its surface temperature."""
    unit = grid.spacing[0]
    pair = axes(grid, body)
    spread = math.sqrt(body.diffusivity * time) / unit
    layers = body.layers and body.layers.in_units(unit)
    response = influence_response(*pair, 0.0, "d", layers, spread)
    return response * (unit / body.conductivity)


def on_contact(values: Field, contact: Mask, spectrum: Field) -> Field:
    """Convolve values of the contact pixels, zero elsewhere; return the result at the contact pixels."""
    field = np.zeros(contact.shape)
    field[contact] = values
    return convolution.convolve(field, spectrum, padded_shape(contact.shape))[contact]


def _close_the_jump(
    jump: Field,
    contact: Mask,
    total: Field,
    inverse: Callable[[Field], Field],
    scale: float,
) -> tuple[Field, float, int]:
    """Return the change of flux whose S₁ + S₂ (`total`) is the jump of temperature, its residual, and the work.

    By GMRES; the residual is in units of `scale`. ConvergenceError if it is not met.
    """
    from scipy.sparse.linalg import LinearOperator, gmres

    applications = 0

    def temperature_jump(values: Field) -> Field:
        nonlocal applications
        applications += 1
        return on_contact(values, contact, total)

    shape = jump.size, jump.size
    operator = LinearOperator(shape, matvec=temperature_jump, dtype=float)
    preconditioner = LinearOperator(shape, matvec=inverse, dtype=float)
    change, _ = gmres(
        operator,
        jump,
        rtol=0.0,
        atol=_TOLERANCE * scale,
        restart=_RESTART,
        maxiter=3,
        M=preconditioner,
    )
    residual = float(np.linalg.norm(jump - on_contact(change, contact, total))) / scale
    if not residual <= _TOLERANCE:
        raise ConvergenceError(
            f"heat partition: residual = {residual:.3g} after {applications} applications exceeds "
            f"{_TOLERANCE:g}; refine the grid or use pointwise=False",
            residual,
            applications,
        )
    return change, residual, applications


def _nearly_inverse(
    contact: Mask, grid: Grid, spectrum: Field, slower: float
) -> Callable[[Field], Field]:
    """Return an approximate inverse of a convolution restricted to the contact: the preconditioner of GMRES.

    The exact one is the inverse on the whole plane between an extension off the contact and its transpose. The pyramid
    of the contact solver approximates that extension; without any extension GMRES takes twice the steps. `slower` is
    v L/D of the slower body.
    """
    from roughsim.contact.solver.operators import Extension

    shape = padded_shape(grid.shape)
    nx, ny = shape
    dx, dy = grid.spacing
    extension = Extension(Grid(shape, (nx * dx, ny * dy)), np.float64)
    response = np.ascontiguousarray((1 / spectrum).T)
    free = np.zeros(shape, np.int8)
    still = np.zeros(shape)
    mask = free.view(np.bool_)
    mask[: contact.shape[0], : contact.shape[1]] = contact
    # Lines along sliding part from each other when both bodies are fast: less of the extension is kept then. The
    # numbers come from trials with Hertz and rough contacts; they change the steps, never the result.
    weight = np.where(mask, 1.0, max(0.6, 1.0 - 0.1 * math.log10(1.0 + slower)))

    def flux(temperatures: Field) -> Field:
        field = np.zeros(shape)
        field[mask] = temperatures
        extension.extend(free, field)
        field *= weight
        field = fourier.inverse(fourier.forward(field) * response, shape) * weight
        extension.transpose(free, field, still, still)
        return field[mask]

    return flux
