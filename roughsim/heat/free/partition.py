"""How two sliding bodies share the heat of their contact, on the free half-space.

One number, the paper's rule: s = T₁/(T₁ + T₂) with the flash temperatures that each body would have with all the heat,
T₁ in the resting body and T₂ in the moving one; the mean temperatures agree then, the local ones do not. Pointwise:
the two temperatures agree at every pixel of the contact, (S₁ + S₂) q₂ = S₁ q̇. That flux has singular edges and may
change sign, so its extremes are numbers of the grid and not of the physics.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughsim import fourier
from roughsim.errors import ConvergenceError, number, positive, real_field
from roughsim.fourier import convolution
from roughsim.grid import Grid
from roughsim.heat.free.half_space import influence_spectrum, padded_shape
from roughsim.heat.response import checked_times

Field = NDArray[Any]
_TOLERANCE = 1e-8
_RESTART = 40  # applications of the operator; 8 to 14 are usual


@dataclass(frozen=True, slots=True)
class Body:
    """A half-space that the contact slides over.

    Parameters
    ----------
    conductivity, diffusivity : float
        κ, W/(m K); D, m²/s.
    speed : float
        Speed of the contact through this body along axis 0, m/s, of either sign.

    Raises
    ------
    TypeError, ValueError
        A value that is not one finite number, or κ or D ≤ 0.
    """

    conductivity: float
    diffusivity: float
    speed: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "conductivity", positive("conductivity", self.conductivity, "W/(m K)"))
        object.__setattr__(self, "diffusivity", positive("diffusivity", self.diffusivity, "m²/s"))
        object.__setattr__(self, "speed", number("speed", self.speed, "m/s"))


@dataclass(frozen=True, slots=True)
class Partition:
    """The heat of a contact, shared between two bodies.

    Attributes
    ----------
    moving_share : float
        Share of all the heat that enters the moving body.
    heat_flux : ndarray
        Heat entering the moving body, W/m². Pointwise it is singular at the edges of the contact.
    temperature : ndarray
        Temperature of the surface of the moving body, K, shape `grid.shape`.
    flash_temperature, max_temperature : float
        T_flash = Σ T q̇/Σ q̇ with the whole heat as weight, and the highest T of the contact, K.
    mean_share : float
        The share by the one-number rule.
    mismatch : float
        Largest |T₁ − T₂| on the contact under the one-number rule, over the highest T that it gives there.
    residual : float
        ‖T₁ − T₂‖/‖T₁ with all the heat‖ on the contact; 0 for the one-number rule, which does not iterate.
    applications : int
        Times that the operator S₁ + S₂ was applied.
    """

    moving_share: float
    heat_flux: Field
    temperature: Field
    flash_temperature: float
    max_temperature: float
    mean_share: float
    mismatch: float
    residual: float
    applications: int


def partition_heat(
    heat_flux: ArrayLike, grid: Grid, *, moving: Body, resting: Body, pointwise: bool = True, time: float = math.inf
) -> Partition:
    """Share the frictional heat between two bodies on the free half-space.

    Parameters
    ----------
    heat_flux : array_like
        Heat set free in the contact, shape `grid.shape`, W/m², ≥ 0; the contact is where it is positive.
    grid : Grid
        The pixels; here the cell is not periodic.
    moving, resting : Body
        The two bodies; the shares are those of `moving`.
    pointwise : bool
        Equal temperatures at each pixel of the contact; False: one share for all, from equal flash temperatures.
    time : float
        Time since the start from rest, s, > 0; inf is the steady state. It is the same for both bodies.

    Returns
    -------
    Partition
        NaN everywhere, with a RuntimeWarning, if there is no contact.

    Raises
    ------
    TypeError, ValueError
        An argument of the wrong kind, not finite or out of its range.
    ConvergenceError
        The two temperatures do not agree to 1e-8 within three rounds of 40 applications.
    """
    flux = real_field("heat_flux", heat_flux, grid.shape).astype(np.float64)
    if flux.min() < 0.0:
        raise ValueError(f"heat_flux = {flux.min():.6g} W/m² must not be negative: friction only heats")
    instant = checked_times(time)
    if instant.ndim or instant == 0.0:
        raise ValueError(f"time = {time} s must be one positive number")
    if not flux.any():
        return _no_contact(grid)
    pair = _Pair(flux, grid, (resting, moving), float(instant))
    return pair.pointwise() if pointwise else pair.one_number()


class _Pair:
    """Two bodies in one contact; index 0 rests, index 1 moves. The heat flux is in units of its maximum."""

    def __init__(self, flux: Field, grid: Grid, bodies: tuple[Body, Body], time: float):
        self.grid, self.bodies, self.time = grid, bodies, time
        self.unit = flux.max()
        self.flux, self.contact = flux / self.unit, flux > 0.0
        self.spectra = [self._spectrum(body) for body in bodies]
        self.full = [self._convolved(self.flux, spectrum) for spectrum in self.spectra]
        self.flash = [self._weighted(temperature) for temperature in self.full]
        self.mean_share = self.flash[0] / sum(self.flash)
        self.applications = 0

    def one_number(self) -> Partition:
        flux = self.mean_share * self.flux
        return self._result(self.mean_share, flux, self.mean_share * self.full[1], 0.0)

    def pointwise(self) -> Partition:
        flux, residual = self._solve()
        temperature = self._convolved(flux, self.spectra[1])
        return self._result(float(flux.sum() / self.flux.sum()), flux, temperature, residual)

    def _solve(self) -> tuple[Field, float]:
        """Heat flux into the moving body: GMRES from the one-number rule on."""
        from scipy.sparse.linalg import LinearOperator, gmres

        size, total = int(self.contact.sum()), self.spectra[0] + self.spectra[1]
        inverse = _Inverse(self.contact, self.grid, total, self._reach())

        def temperature_jump(values: Field) -> Field:
            self.applications += 1
            return self._within(values, total)

        resting, moving = (temperature[self.contact] for temperature in self.full)
        jump = (1 - self.mean_share) * resting - self.mean_share * moving  # of the one-number rule: the start
        scale = float(np.linalg.norm(resting))
        operator = LinearOperator((size, size), matvec=temperature_jump, dtype=np.float64)
        preconditioner = LinearOperator((size, size), matvec=inverse, dtype=np.float64)
        change, _ = gmres(
            operator, jump, rtol=0.0, atol=_TOLERANCE * scale, restart=_RESTART, maxiter=3, M=preconditioner
        )
        residual = float(np.linalg.norm(jump - self._within(change, total))) / scale
        values = self.mean_share * self.flux[self.contact] + change
        flux = np.zeros(self.grid.shape)
        flux[self.contact] = values
        if not residual <= _TOLERANCE:
            raise ConvergenceError(
                f"heat partition: residual = {residual:.3g} after {self.applications} applications exceeds "
                f"{_TOLERANCE:g}; refine the grid or use pointwise=False",
                residual,
                self.applications,
            )
        return flux, residual

    def _reach(self) -> float:
        """How much of the extension to keep: lines along sliding part from each other when both bodies are fast.

        The numbers come from trials with Hertz and rough contacts; they change the steps, never the result.
        """
        slower = min(abs(body.speed) / body.diffusivity for body in self.bodies) * self.grid.lengths[0]
        return max(0.6, 1.0 - 0.1 * math.log10(1.0 + slower))

    def _spectrum(self, body: Body) -> Field:
        spread = math.sqrt(body.diffusivity * self.time)
        response = influence_spectrum(self.grid, (body.speed / body.diffusivity, 0.0), 0.0, spread)
        scaled: Field = response * (self.grid.spacing[0] / body.conductivity)
        return scaled

    def _within(self, values: Field, spectrum: Field) -> Field:
        """Apply a convolution from the contact to the contact."""
        field = np.zeros(self.grid.shape)
        field[self.contact] = values
        result: Field = self._convolved(field, spectrum)[self.contact]
        return result

    def _convolved(self, field: Field, spectrum: Field) -> Field:
        return convolution.convolve(field, spectrum, padded_shape(self.grid.shape))

    def _weighted(self, temperature: Field) -> float:
        return float((temperature * self.flux).sum() / self.flux.sum())

    def _mismatch(self) -> float:
        resting, moving = (1 - self.mean_share) * self.full[0], self.mean_share * self.full[1]
        hottest = max(resting[self.contact].max(), moving[self.contact].max())
        return float(np.abs(resting - moving)[self.contact].max() / hottest)

    def _result(self, share: float, flux: Field, temperature: Field, residual: float) -> Partition:
        temperature = temperature * self.unit
        return Partition(
            moving_share=share,
            heat_flux=flux * self.unit,
            temperature=temperature,
            flash_temperature=self._weighted(temperature),
            max_temperature=float(temperature[self.contact].max()),
            mean_share=self.mean_share,
            mismatch=self._mismatch(),
            residual=residual,
            applications=self.applications,
        )


class _Inverse:
    """Nearly the inverse of a convolution that is cut to the contact: it preconditions the iteration.

    That inverse is the one of the whole plane between an extension off the contact and its transpose. The pyramid of
    the contact solve stands in for the extension that would make it exact; zeros in its place cost twice the steps.
    Off the contact it is multiplied by `reach`, at most 1.
    """

    def __init__(self, contact: NDArray[np.bool_], grid: Grid, spectrum: Field, reach: float):
        from roughsim.contact.solver.preconditioner import Extension

        shape = padded_shape(grid.shape)
        padded = Grid(shape, (shape[0] * grid.spacing[0], shape[1] * grid.spacing[1]))
        self.contact, self.response = contact, np.ascontiguousarray((1 / spectrum).T)
        self.free, self.still = np.zeros(shape, np.int8), np.zeros(shape)
        self.free[: contact.shape[0], : contact.shape[1]] = contact
        self.weight = np.where(self.free > 0, 1.0, reach)
        self.extension = Extension(padded, np.float64)

    def __call__(self, values: Field) -> Field:
        shape = (self.free.shape[0], self.free.shape[1])
        field = np.zeros(shape)
        self._part(field)[self.contact] = values
        self.extension.extend(self.free, field)
        field *= self.weight
        field = fourier.inverse(fourier.forward(field) * self.response, shape) * self.weight
        self.extension.transpose(self.free, field, self.still, self.still)
        result: Field = self._part(field)[self.contact]
        return result

    def _part(self, field: Field) -> Field:
        return field[: self.contact.shape[0], : self.contact.shape[1]]


def _no_contact(grid: Grid) -> Partition:
    warnings.warn("heat_flux = 0 W/m² everywhere: no contact, and nothing to share", RuntimeWarning, stacklevel=3)
    empty = np.full(grid.shape, math.nan)
    nan = math.nan
    return Partition(nan, empty, empty.copy(), nan, nan, nan, nan, nan, 0)
