"""Contact and temperature of two drawn rough faces that slide over one another; no contact is solved.

A part f of C(q) rides with the moving body. In the frame of the body at rest, and with s the slid distance along −x,

    z(x, s) = √(1 − f) z₁(x) + √f z₂(x + s),    σ = F(z),

with two drawn fields z₁ and z₂. At each position the heat μvσ is shared so that both surfaces have one temperature
wherever they touch. Each body keeps the history of its own heat, as a half-space that was cold:

    κ T(q, t) = √(D/π) ∫₀^t dτ τ^(−1/2) e^(−D q² τ) q̇(q, t − τ)

(H.S. Carslaw & J.C. Jaeger, Conduction of Heat in Solids, 2nd ed., 10.7). The flux is linear over the latest step. For
older heat τ^(−1/2) is a sum of exponentials, π^(−1/2) ∫ dy e^(y/2) exp(−e^y τ) by the trapezoidal rule. So each wave
keeps a few numbers and not its past.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import ceil, exp, floor, log, log2, pi, sqrt
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from theory.arguments import Array
from theory.clipped.drawing import Cell
from theory.clipped.field import ClippedField

_ACROSS = (
    (sqrt(5.0) - 1.0) / 2.0
) ** 4  # dy/dx of the way: a wave meets new rows when the cell repeats
LAST = 32  # steps of one pixel at the end of the way; before, steps grow with the distance from the end
_LEAST = 16  # steps of a way, which are shorter than a pixel if it is
_OF_RATES = 1.25  # ln of the ratio of rates of exponentials: τ^(−1/2) then errs by 5e-4
_SLOWEST, _FASTEST = 0.03, 8.0  # of these rates, times the longest and over the shortest time
_EQUAL = 0.01  # of the deviation of T over the contact: root mean square difference of both bodies
_ROUNDS = 50  # of conjugate gradients; 1 to 3 are usual
_HIGHEST, _PER_UNIT = 7.0, 1000  # of z, and intervals of z in which it is one rank

Plane = NDArray[np.float32]
Waves = NDArray[np.complex64]


class Body(NamedTuple):
    """κ, W/(m K), and D, m²/s, of a half-space."""

    conductivity: float
    diffusivity: float


class Way(NamedTuple):
    """Steps of the moving body: pixels that it has moved towards −x and −y, (steps, 2), and length of each, m."""

    offset: NDArray[np.intp]
    length: Array


def oblique_way(distance: float, cell: Cell) -> Way:
    """Return the steps over a `distance`, m, nearly along x, in whole pixels.

    The last are of a pixel. Steps are doubled where the end is further, since older heat has spread.
    """
    pixel = cell.length / cell.points * sqrt(1 + _ACROSS**2)
    shortest = min(pixel, distance / _LEAST)
    lengths, left = [], distance
    while left > 1e-6 * shortest:
        doublings = max(0, floor(log2(max((distance - left) / (LAST * shortest), 1.0))))
        lengths.append(min(shortest * 2**doublings, left))
        left -= lengths[-1]
    length = np.array(lengths[::-1])
    along = np.rint(np.cumsum(length) / pixel)
    return Way(np.stack([along, np.rint(_ACROSS * along)], axis=1).astype(np.intp), length)


def pressures(
    field: ClippedField, resting: Array, moving: Array, part: float, way: Way
) -> Iterator[Plane]:
    """Yield the pressure over its mean at the end of each step of a way, in the frame of the body at rest.

    `resting` and `moving` are z₁ and z₂ of several pairs of faces, shape (pairs, points, points), as the pressure;
    `part` is f. F is applied to the rank of z in the cell, as in `draw_pressure`, so that each has the nominal load.
    """
    still, riding = (
        (sqrt(1 - part) * resting).astype(np.float32),
        (sqrt(part) * moving).astype(np.float32),
    )
    size = still[0].size
    contact, last = np.empty_like(still), None
    for offset in way.offset.tolist():
        if last is None or (part > 0.0 and offset != last):
            contact, last = np.empty_like(still), offset
            z = still + np.roll(riding, (-offset[0], -offset[1]), axis=(1, 2))
            places = (np.clip(z + _HIGHEST, 0.0, 2 * _HIGHEST) * _PER_UNIT).astype(np.intp)
            for pair, place in enumerate(places):
                count = np.bincount(place.ravel())
                rank = (np.cumsum(count) - count / 2) / size
                sigma = field.pressure(scipy.special.ndtri(np.clip(rank, 1e-12, 1 - 1e-12)))
                contact[pair] = (sigma / (sigma @ count / size)).astype(np.float32)[place]
        yield contact


class Pair:
    """Two bodies at one speed, for several pairs of faces: the share of the heat of each step, and its history.

    Parameters
    ----------
    cell, way
        The periodic cell, and the steps.
    pairs : int
        Number of pairs of faces.
    speed : float
        v > 0, m/s.
    moving, resting : Body
        The half-spaces.
    """

    def __init__(
        self, cell: Cell, way: Way, pairs: int, *, speed: float, moving: Body, resting: Body
    ) -> None:
        # lengths in pixels and times of a step of one pixel: all numbers are of a size for single precision
        pixel = cell.length / cell.points
        self._wavenumbers = along, across = [q * pixel for q in cell.wavenumbers()]
        times = way.length / pixel
        self._steps = iter(zip(way.offset, times.tolist(), strict=True))
        self._resting, self._moving = (
            _HalfSpace(
                along**2 + across**2,
                pairs,
                times,
                conductivity=body.conductivity / moving.conductivity,
                diffusivity=body.diffusivity / (speed * pixel),
            )
            for body in (resting, moving)
        )

    def advance(self, pressure: Plane) -> Plane:
        """Return the temperature of the moving body above its mean at the end of the next step.

        Both are in the frame of the resting body, of shape (pairs, points, points): the pressure over its mean, and the
        temperature in a unit that is the same at all steps.
        """
        (along, across), (offset, time) = self._wavenumbers, next(self._steps)
        still, riding, shape = self._resting, self._moving, pressure.shape[1:]
        still.begin(time)
        riding.begin(time)
        phase = (np.exp(1j * along * offset[0]) * np.exp(1j * across * offset[1])).astype(
            np.complex64
        )
        known, riding_known = still.known(), riding.known() * phase
        response = still.response + riding.response
        # first as two bodies in full contact share it, then the change that makes the temperatures equal
        share = np.float32(still.unit / (still.unit + riding.unit))
        released, entering = scipy.fft.rfft2(pressure), share * pressure
        surface = known + still.response * ((1 - share) * released)
        jump = surface - riding_known - riding.response * (share * released)
        surface[:, 0, 0] = 0.0
        fields = [scipy.fft.irfft2(waves, s=shape) for waves in (jump, surface)]
        entering += _equalizing(pressure > 0.0, fields[0], fields[1], response)
        heat = scipy.fft.rfft2(entering)
        still.advance(released - heat)
        riding.advance(heat * phase.conj())
        surface = riding_known + riding.response * heat
        surface[:, 0, 0] = 0.0
        return np.asarray(scipy.fft.irfft2(surface, s=shape))


def _equalizing(
    touching: NDArray[np.bool_], jump: Plane, temperature: Plane, response: Plane
) -> Plane:
    """Return the change of the heat that closes a jump of temperature over the contact; none enters elsewhere.

    Conjugate gradients, with the inverse of `response` on the whole plane. ArithmeticError if it stays open.
    """
    contact, shape = touching.astype(np.float32), jump.shape[1:]
    # in units of the largest jump and response: no square leaves single precision
    jump = jump * contact
    kelvin, unit = float(np.abs(jump).max()), float(response.max())
    limit = _EQUAL * float(np.linalg.norm(temperature[touching]))
    change, direction, last = np.zeros_like(jump), np.zeros_like(jump), 1.0
    if kelvin == 0.0:
        return change
    jump /= kelvin
    response = response / unit
    inverse = np.reciprocal(response)

    def on_contact(field: Plane, factor: Plane) -> Plane:
        return np.asarray(scipy.fft.irfft2(scipy.fft.rfft2(field) * factor, s=shape) * contact)

    for _ in range(_ROUNDS):
        if float(np.linalg.norm(jump)) <= limit / kelvin:
            break
        steepest = on_contact(jump, inverse)
        power = float(np.vdot(jump, steepest))
        direction = steepest + (power / last) * direction
        closed = on_contact(direction, response)
        length = power / float(np.vdot(direction, closed))
        change += length * direction
        jump -= length * closed
        last = power
    else:
        left = float(np.linalg.norm(jump)) * kelvin / limit * _EQUAL
        raise ArithmeticError(
            f"temperatures of the two bodies: after {_ROUNDS} rounds they differ by {left:.3g} of the temperature over "
            f"the contact, {_EQUAL:g} is allowed; take other numbers of fields and points"
        )
    return change * np.float32(kelvin / unit)


class _HalfSpace:
    """History of the heat of one body, in its own frame."""

    def __init__(
        self, square: Array, pairs: int, times: Array, *, conductivity: float, diffusivity: float
    ) -> None:
        first = floor(log(_SLOWEST / times.sum()) / _OF_RATES)
        rates = np.exp(
            _OF_RATES * np.arange(first, ceil(log(_FASTEST / times.min()) / _OF_RATES) + 1)
        )
        weights = _OF_RATES * np.sqrt(rates / pi)
        # slower ones count as constant; their weights are a geometric series
        self._rates = np.append(0.0, rates)[:, None, None]
        self._weights = np.append(weights[0] / (exp(_OF_RATES / 2) - 1), weights)[:, None, None]
        self.unit = sqrt(diffusivity / pi) / conductivity
        self._square, self._time = diffusivity * square, 0.0
        self._memory = np.zeros((pairs, self._rates.size, *square.shape), np.complex64)
        self._heat: Waves = np.zeros((pairs, *square.shape), np.complex64)

    def begin(self, time: float) -> None:
        """Begin a step that takes this time."""
        if abs(time - self._time) <= 1e-6 * time:
            return
        self._time = time
        decay = np.maximum((self._rates + self._square) * time, 1e-12)
        with np.errstate(under="ignore"):
            self._fading = np.exp(-decay).astype(np.float32)
        # in what is older than the latest step, the heat of a step counts as even over it
        self._entering = (self.unit * time / 2 * self._weights * -np.expm1(-decay) / decay).astype(
            np.float32
        )
        x = np.maximum(self._square * time, 1e-12)
        whole = np.sqrt(pi / x) * scipy.special.erf(np.sqrt(x))
        earlier = scipy.special.gamma(1.5) * scipy.special.gammainc(1.5, x) / x**1.5
        self.response = (self.unit * sqrt(time) * (whole - earlier)).astype(np.float32)
        self._earlier = (self.unit * sqrt(time) * earlier).astype(np.float32)

    def known(self) -> Waves:
        """Return the temperature that earlier heat leaves at the end of the step."""
        self._memory *= self._fading
        return np.asarray(self._memory.sum(axis=1) + self._earlier * self._heat)

    def advance(self, heat: Waves) -> None:
        """End the step, with the heat at its end."""
        self._memory += self._entering * (heat + self._heat)[:, None]
        self._heat = heat
