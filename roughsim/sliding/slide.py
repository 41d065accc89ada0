"""Two rough bodies that slide over one another: contact and temperatures of both bodies, step by step."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from roughsim import fourier
from roughsim.contact import Contact, Solid, checked_load
from roughsim.contact.active_set import solve_contact
from roughsim.errors import ConvergenceError, not_negative, number, positive, real_field
from roughsim.grid import Array, Field, Grid
from roughsim.heat.equal_temperatures import equalize
from roughsim.heat.history import History, Spectrum
from roughsim.heat.partition import Body
from roughsim.sliding.path import Path, oblique_path

_EQUAL = 1e-5  # ‖T₁ − T₂‖ over ‖T₁ + T₂‖ on the contact
_ROUNDS = 10  # of conjugate gradients in single precision: 1 is usual
_ANCHORS = 8  # positions with which the stress of later ones is correlated


@dataclass(frozen=True, slots=True, eq=False)
class Slide:
    """What two sliding bodies did, over the slid distance.

    Arrays have shape (steps,); those that depend on the speed (speeds, steps) where an array of speeds was given.
    Temperatures are above that of both bodies before sliding.

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
        ⟨Tσ⟩/⟨σ⟩, background included, K: that of both bodies.
    residual : ndarray
        ‖T₁ − T₂‖/‖T₁ + T₂‖ on the contact.
    contact_fraction, plastic_fraction : ndarray
        Share of points with σ > 0, and with σ = σ_P.
    stress_correlation : ndarray
        ⟨δσ(s) δσ(s + Δ)⟩/⟨δσ²⟩ at points of the resting body, with Δ = `slid_distance`, mean over several s.
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
    contact_fraction: Array
    plastic_fraction: Array
    stress_correlation: Array
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
    the contact moves along +x through it); left out it is flat. At each step the contact is solved anew, and the heat
    μvσ of each point of the contact is shared so that both surfaces have one temperature there. Each half-space keeps
    the history of its own heat, exactly in the last step; nothing is steady and nothing is averaged. The path is
    slightly oblique to the cell, so that other rows meet when it wraps around.

    First encounter only: each position meets fresh surfaces, without the deformation by earlier contacts.

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
        μ ≥ 0.
    speed : float or array_like
        v of the moving body over the resting one, m/s, not 0, of either sign; several in an array, all of one sign.
        The contact is solved once for all of them.
    moving, resting : Body
        κ and D. moving.speed − resting.speed must equal `speed`; with several speeds both are 0.
    slid_distance : float
        m, at least one pixel; taken to the nearest whole step.
    steps : int, optional
        About how many; each is a whole number of pixels along x. Left out: one pixel each.
    tolerance : float
        Of each contact solve.

    TypeError or ValueError for an argument of the wrong kind or out of its range; ConvergenceError where a contact or
    the share of its heat is not found.
    """
    load = checked_load("nominal_pressure", nominal_pressure, solid)
    friction = not_negative("friction_coefficient", friction_coefficient)
    speeds = _checked_speeds(speed, moving, resting)
    distance = positive("slid_distance", slid_distance, "m")
    if steps is not None and (number("steps", steps) < 1 or steps % 1):
        raise ValueError(f"steps = {steps} must be a whole number ≥ 1")
    path = oblique_path(grid, distance, None if steps is None else int(steps), backwards=bool(speeds[0] < 0))
    resting_heights = real_field("heights", heights, grid.shape).astype(np.float64, copy=False)
    moving_heights = None
    if counter_heights is not None:
        moving_heights = real_field("counter_heights", counter_heights, grid.shape).astype(np.float64, copy=False)
    pairs: list[Pair] = []
    correlation = StressCorrelation(grid, path.steps)
    rows, fractions = np.empty((path.steps, len(_ROWS), speeds.size)), np.empty((path.steps, 2))
    for n, contact in enumerate(contacts(resting_heights, moving_heights, grid, solid, load, path, tolerance)):
        stress = fourier.forward(contact.pressure)
        correlation.add(n, stress)
        if n == 0:
            pairs = [Pair(grid, friction * abs(v), (resting, moving), stress, path, abs(v)) for v in speeds]
            continue
        fractions[n - 1] = contact.contact_fraction, contact.plastic_fraction
        for k, pair in enumerate(pairs):
            rows[n - 1, :, k] = pair.advance(contact, stress)
    columns = rows.transpose(1, 2, 0).reshape(len(_ROWS), *np.shape(speed), path.steps)
    return Slide(
        slid_distance=path.distance[1:],
        **dict(zip(_ROWS, columns, strict=True)),
        contact_fraction=fractions[:, 0],
        plastic_fraction=fractions[:, 1],
        stress_correlation=correlation.mean(),
        contact=contact,
    )


def contacts(
    heights: Field, counter_heights: Field | None, grid: Grid, solid: Solid, load: float, path: Path, tolerance: float
) -> Iterator[Contact]:
    """Yield the contact at each position of the path, each solve begun from the last; one for all over a flat."""
    contact = None
    for offset in path.offsets:
        if contact is None or counter_heights is not None:
            composite = heights
            if counter_heights is not None:
                composite = heights + np.roll(counter_heights, -offset, axis=(0, 1))
            contact = solve_contact(composite, grid, solid, nominal_pressure=load, tolerance=tolerance, start=contact)
        yield contact


_ROWS = (
    "flash_temperature",
    "resting_flash_temperature",
    "moving_share",
    "background",
    "resting_background",
    "contact_temperature",
    "residual",
)


class Pair:
    """Both bodies at one speed: their histories, and the share of the heat of the latest step."""

    def __init__(
        self, grid: Grid, heating: float, bodies: tuple[Body, Body], stress: Spectrum, path: Path, speed: float
    ) -> None:
        self.grid, self.path, self.heating = grid, path, heating
        # at first heat flows straight down into both: the share of their effusivities, at every point
        resting, moving = (body.conductivity / math.sqrt(body.diffusivity) for body in bodies)
        share = moving / (resting + moving)
        step = (path.distance[1] - path.distance[0]) / speed
        self.resting, self.moving = (
            History(grid, body.conductivity, body.diffusivity, step, path.steps, part * heating * stress)
            for body, part in zip(bodies, (1 - share, share), strict=True)
        )
        self.response = self.resting.response + self.moving.response
        self.share, self.step = np.full(grid.shape, share), 0

    def advance(self, contact: Contact, stress: Spectrum) -> tuple[float, ...]:
        """Share the heat of the next step, and return the numbers of `_ROWS`."""
        self.step += 1
        phase = phases(self.grid, self.path.offsets[self.step])
        known, moving_known = self.resting.known(), self.moving.known() * phase
        heat = self.heating * stress
        touching = contact.pressure > 0.0
        released = self.heating * contact.pressure[touching]
        # as the heat was shared in the last step; then the change that makes the temperatures equal, until they are
        entering = np.zeros(self.grid.shape)
        entering[touching] = self.share[touching] * released
        for _ in range(_ROUNDS):
            moving_heat = fourier.forward(entering)
            resting_temperature = known + self.resting.response * (heat - moving_heat)
            moving_temperature = moving_known + self.moving.response * moving_heat
            jump = fourier.inverse(resting_temperature - moving_temperature, self.grid.shape)[touching]
            load, both = stress[0, 0].real, mean_product(self.grid, resting_temperature + moving_temperature, stress)
            scale = abs(both) / load * math.sqrt(jump.size)
            residual = float(np.linalg.norm(jump)) / scale
            if residual <= _EQUAL:
                break
            entering[touching] += equalize(touching, jump, self.response, _EQUAL / 2 * scale)
        else:
            raise ConvergenceError(
                f"temperatures of the two bodies: after {_ROUNDS} rounds they differ by {residual:.3g} of their norm "
                f"on the contact, {_EQUAL:g} is allowed; take more steps or a finer grid",
                residual,
                _ROUNDS,
            )
        # points that touch in the next step and not in this one begin with the mean share
        share = moving_heat[0, 0].real / heat[0, 0].real
        self.share.fill(share)
        self.share[touching] = np.clip(entering[touching] / released, 0.0, 1.0)  # at edges it has no bounds
        self.resting.advance(heat - moving_heat)
        self.moving.advance(moving_heat * phase.conj())
        resting_total, moving_total = (
            mean_product(self.grid, temperature, stress) / load
            for temperature in (resting_temperature, moving_temperature)
        )
        resting_background, background = resting_temperature[0, 0].real, moving_temperature[0, 0].real
        return (
            moving_total - background,
            resting_total - resting_background,
            share,
            background,
            resting_background,
            moving_total,
            residual,
        )


class StressCorrelation:
    """Correlation of the stress at points of the resting body with that at several earlier positions."""

    def __init__(self, grid: Grid, steps: int) -> None:
        self.grid, self.every = grid, math.ceil((steps + 1) / _ANCHORS)
        self.anchors: list[Spectrum] = []
        self.sums, self.counts = np.zeros(steps + 1), np.zeros(steps + 1, np.intp)

    def add(self, n: int, stress: Spectrum) -> None:
        """Take the stress at step n, the next one."""
        if n % self.every == 0:
            self.anchors.append(stress)
        square = stress[0, 0].real ** 2
        for index, earlier in enumerate(self.anchors):
            lag = n - index * self.every
            self.sums[lag] += mean_product(self.grid, earlier, stress) - square
            self.counts[lag] += 1

    def mean(self) -> Array:
        """Return the correlation at lags of 1, 2 … steps, relative to the mean variance."""
        correlation = self.sums / self.counts
        relative: Array = correlation[1:] / correlation[0]
        return relative


def phases(grid: Grid, offset: Any) -> Spectrum:
    """Return e^(iq·s) of each mode: it brings a spectrum from the frame of the moving body to that of the resting."""
    qx, qy = grid.wavevectors
    along, across = (1j * q * (n * d) for q, n, d in zip((qx, qy), offset, grid.spacing, strict=True))
    phase: Spectrum = np.exp(along) * np.exp(across)
    return phase


def mean_product(grid: Grid, first: Spectrum, second: Spectrum) -> float:
    """Return the mean over the cell of the product of two real fields, from their half spectra."""
    edges = [0] if grid.shape[1] % 2 else [0, -1]  # columns that stand for themselves; the others for two
    return float(2 * np.vdot(first, second).real - sum(np.vdot(first[:, k], second[:, k]).real for k in edges))


def _checked_speeds(speed: ArrayLike, moving: Body, resting: Body) -> Array:
    """Return the relative speeds, m/s, shape (speeds,), of one sign and not 0."""
    array = np.asarray(speed)
    if array.dtype.kind not in "iuf" or array.ndim > 1 or array.size == 0:
        raise TypeError(f"speed = {speed!r} must be one real number or a 1-D array of them, in m/s")
    speeds = np.atleast_1d(array.astype(np.float64))
    if not np.isfinite(speeds).all() or not (speeds.min() > 0.0 or speeds.max() < 0.0):
        raise ValueError(f"speed = {speed!r} m/s must be finite, not 0, and of one sign: the bodies slide one way")
    difference = moving.speed - resting.speed
    if array.ndim == 0 and difference != speeds[0]:
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
