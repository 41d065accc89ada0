"""The slide of two sliding bodies: at each position the contact, and the temperatures of both bodies."""

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from roughsim import fourier
from roughsim.contact import Contact, Solid
from roughsim.errors import ConvergenceError
from roughsim.grid import Array, Complex, Field, Grid
from roughsim.heat.body import Body
from roughsim.heat.equal_temperatures import equalize
from roughsim.heat.history import History
from roughsim.heat.layered_history import uniform_rise
from roughsim.sliding.correlation import mean_product
from roughsim.sliding.path import Path

_EQUAL = 1e-5  # ‖T₁ − T₂‖ over ‖T₁ + T₂‖ on the contact
_ROUNDS = 10  # of conjugate gradients in single precision: 1 is usual
NUMBERS = (  # of a step at each speed, as `Slide` explains them
    "flash_temperature",
    "resting_flash_temperature",
    "moving_share",
    "background",
    "resting_background",
    "contact_temperature",
    "residual",
)


class Step(NamedTuple):
    """One position of two sliding bodies.

    Attributes
    ----------
    slid_distance : float
        m; 0 at the start, with both bodies still cold.
    contact : Contact
        In the frame of the resting body.
    stress : ndarray
        Half spectrum of its pressure, Pa.
    numbers : ndarray
        The `NUMBERS` at each speed, shape (numbers, speeds); NaN after the distance of a speed.
    temperatures : list of ndarray or None
        Half spectrum of the surface temperature of the moving body at each speed, K, at its present position; None at
        the start, and after the distance of a speed.
    """

    slid_distance: float
    contact: Contact
    stress: Complex
    numbers: Array
    temperatures: list[Complex | None]


class Motion(NamedTuple):
    """How the contact moves and heats at one speed."""

    speed: float  # v > 0 of the moving body over the resting one, m/s
    friction_coefficient: float
    moving: Body
    resting: Body
    slid_distance: float = math.inf  # m, to the nearest step; beyond it this speed is not followed


def walk(
    contacts: Iterable[Contact], grid: Grid, path: Path, motions: Sequence[Motion]
) -> Iterator[Step]:
    """Yield each position of a path with the temperatures of both bodies, at several speeds.

    `contacts` yields one contact at each position, the first included.
    """
    pairs: list[HeatedBodies | None] = []
    last = path.steps_to([motion.slid_distance for motion in motions])
    numbers = np.zeros((len(motions), len(NUMBERS)))
    for n, contact in enumerate(contacts):
        stress = fourier.forward(contact.pressure)
        if n == 0:
            pairs = [HeatedBodies(grid, motion, stress, path) for motion in motions]
        else:
            pairs = [pair if n <= end else None for pair, end in zip(pairs, last, strict=True)]
            nothing = (math.nan,) * len(NUMBERS)
            numbers = np.array(
                [pair.advance(contact, stress) if pair else nothing for pair in pairs]
            )
        temperatures = [pair.temperature if pair else None for pair in pairs]
        yield Step(float(path.distance[n]), contact, stress, numbers.T, temperatures)


def contacts(
    heights: Field,
    counter_heights: Field | None,
    grid: Grid,
    solid: Solid,
    load: float,
    path: Path,
    tolerance: float,
) -> Iterator[Contact]:
    """Yield the contact at each position of the path, each solve begun from the last; one for all over a flat."""
    from roughsim.contact.active_set import (
        solve_contact,
    )  # loads numba: who plans and leads a run may do without

    contact = None
    for offset in path.offsets:
        if contact is None or counter_heights is not None:
            composite = heights
            if counter_heights is not None:
                composite = heights + np.roll(counter_heights, -offset, axis=(0, 1))
            contact = solve_contact(
                composite, grid, solid, nominal_pressure=load, tolerance=tolerance, start=contact
            )
        yield contact


class HeatedBodies:
    """Both bodies at one speed: their histories, and the share of the heat of the latest step."""

    def __init__(self, grid: Grid, motion: Motion, stress: Complex, path: Path) -> None:
        heating = motion.friction_coefficient * motion.speed
        bodies = (motion.resting, motion.moving)
        self.grid = grid
        self.path = path
        self.heating = heating
        step = (path.distance[1] - path.distance[0]) / motion.speed
        # at first heat flows straight down into both, and warms them alike: bare ones share it by their effusivities
        resting, moving = (1 / uniform_warming(body, step) for body in bodies)
        share = moving / (resting + moving)
        self.resting, self.moving = (
            History(
                grid,
                body.conductivity,
                body.diffusivity,
                step,
                path.steps,
                part * heating * stress,
                body.layers,
            )
            for body, part in zip(bodies, (1 - share, share), strict=True)
        )
        self.response = self.resting.response + self.moving.response
        self.share = np.full(grid.shape, share)
        self.step = 0
        self.temperature: Complex | None = None  # of the surface of the moving body, K

    def advance(self, contact: Contact, stress: Complex) -> tuple[float, ...]:
        """Share the heat of the next step, and return the `NUMBERS`."""
        self.step += 1
        phase = phases(self.grid, self.path.offsets[self.step])
        known = self.resting.known()
        moving_known = self.moving.known() * phase
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
            jump = fourier.inverse(resting_temperature - moving_temperature, self.grid.shape)[
                touching
            ]
            load = stress[0, 0].real
            both = mean_product(self.grid, resting_temperature + moving_temperature, stress)
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
        self.share[touching] = np.clip(
            entering[touching] / released, 0.0, 1.0
        )  # at edges it has no bounds
        self.temperature = moving_temperature
        self.resting.advance(heat - moving_heat)
        self.moving.advance(moving_heat * phase.conj())
        resting_total, moving_total = (
            mean_product(self.grid, temperature, stress) / load
            for temperature in (resting_temperature, moving_temperature)
        )
        resting_background = resting_temperature[0, 0].real
        background = moving_temperature[0, 0].real
        return (
            moving_total - background,
            resting_total - resting_background,
            share,
            background,
            resting_background,
            moving_total,
            residual,
        )


def uniform_warming(body: Body, time: float) -> float:
    """Return the temperature that a uniform flux of 1 W/m² gives the surface of a body in a time, s; K."""
    if body.layers is None:
        return 2 * math.sqrt(body.diffusivity * time / math.pi) / body.conductivity
    return uniform_rise(body.diffusivity * time, body.layers) / body.conductivity


def phases(grid: Grid, offset: Any) -> Complex:
    """Return e^(iq·s) of each mode: it brings a spectrum from the frame of the moving body to the resting frame."""
    qx, qy = grid.wavevectors
    along, across = (
        1j * q * (n * d) for q, n, d in zip((qx, qy), offset, grid.spacing, strict=True)
    )
    return np.exp(along) * np.exp(across)
