"""Distribution of the temperature over a rough contact, from C(q): drawn clipped fields, and the law for T_flash.

A mean over the contact hides that the hottest hundredth of the heat is set free at two to three times T_flash. A
reaction, melting and wear depend on the whole distribution. T/T_flash is found from the temperature of drawn fields. It
depends little on the shortest waves, so that a grid of modest size suffices. T_flash itself is the one of the
calibrated law, of the whole C(q).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import inf, pi
from typing import Any

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import ArrayLike, NDArray

from theory.arguments import Array, Spectrum, breaks_of, need_whole, positive, real_array
from theory.clipped.distribution import TemperatureDistribution, form_doubt
from theory.clipped.drawing import (
    Cell,
    amplitudes,
    draw_pressure,
    halved,
    heat_response,
    temperature,
)
from theory.clipped.field import ClippedField, clipped_field, law_of
from theory.flash import flash_temperature

_WAVES = 4  # longest waves along a side of the cell
_PIXELS = 4  # along the shortest wave
_FURTHEST = 2.0  # steps of the cut-off, to twice as high a one, by which fields are continued
_SMALLEST = (
    64  # points along a side: 4 q_min is the shortest wave, and 2 q_min that of the coarse fields
)
_PER_PIECE = 32
_SLOWEST = 1e-12  # m/s: at rest T_flash is 0, and T/T_flash that of a very slow source


@dataclass(frozen=True, slots=True, eq=False)
class Drawn:
    """Temperatures of drawn fields for C(q) up to their shortest wave; as in `TemperatureDistribution`."""

    flash_temperature: Array  # of the law, K, (speeds,)
    ratio: Array
    pressure: Array
    field: NDArray[np.intp]
    wrong_share: float


def temperature_distribution(  # noqa: PLR0913  (contact, heat, and numbers of the drawing)
    speed: ArrayLike,
    spectrum: Spectrum,
    *,
    effective_modulus: float,
    nominal_pressure: float,
    penetration_hardness: float | None = None,
    friction_coefficient: float,
    conductivity: float,
    diffusivity: float,
    slid_distance: float | None = None,
    seed: int = 0,
    fields: int = 8,
    points: int = 512,
) -> TemperatureDistribution:
    """Distribution of the temperature over a rough contact, from C(q) alone.

    Fields of four longest waves a side are drawn for C(q) up to the waves of four pixels. They slide from rest. Heat
    that is older than half of the cell is even, and left out: longer ways count as that. If C(q) goes on, fields with
    half of the waves are drawn too, and the temperatures are continued in proportion to the T_flash of the law.

    Parameters
    ----------
    speed : array_like
        v, m/s, of either sign, one number or shape (speeds,).
    spectrum : callable
        C(q), m⁴, with `breaks`.
    effective_modulus, nominal_pressure, penetration_hardness : float
        E*, σ₀ and σ_P, Pa; without σ_P contact is elastic.
    friction_coefficient : float
        μ, dimensionless, > 0.
    conductivity, diffusivity : float
        κ, W/(m K), and D, m²/s.
    slid_distance : float, optional
        m since the start from rest, > 0; None: half of the cell.
    seed : int
        Of the random numbers, ≥ 0.
    fields, points : int
        Number of fields, 2 or more, and pixels along a side of each, 64 or more.

    Returns
    -------
    TemperatureDistribution
        The speeds in their order; one number counts as one speed.

    Raises
    ------
    TypeError, ValueError
        If an argument is not real, finite and of the right sign, or the contact lies outside the range of the law of
        its stress spectrum, as `plasticity.stress_spectrum` and `persson.calibrated_spectrum` explain. The part of C(q)
        up to the shortest drawn wave must lie in it too.
    """
    velocity = np.atleast_1d(np.abs(real_array("speed", speed, "m/s")))
    for name, count, least in (
        ("seed", seed, 0),
        ("fields", fields, 2),
        ("points", points, _SMALLEST),
    ):
        need_whole(name, count, least)
    way = inf if slid_distance is None else positive("slid_distance", slid_distance, "m")
    solid: dict[str, Any] = {
        "effective_modulus": effective_modulus,
        "nominal_pressure": nominal_pressure,
    }
    solid["penetration_hardness"] = penetration_hardness
    heat: dict[str, Any] = {
        "nominal_pressure": nominal_pressure,
        "friction_coefficient": friction_coefficient,
        "conductivity": conductivity,
        "diffusivity": diffusivity,
    }
    stress = law_of(spectrum, **solid)
    flash = np.asarray(flash_temperature(velocity, stress_spectrum=stress, **heat))
    longest, end = float(breaks_of(spectrum)[0]), float(breaks_of(spectrum)[-1])
    rng = np.random.default_rng(seed)
    white = [rng.standard_normal((points, points)) for _ in range(fields)]
    moving = np.where(velocity > 0.0, velocity, _SLOWEST)

    def flash_of(law: Spectrum) -> Array:
        return np.asarray(flash_temperature(moving, stress_spectrum=law, **heat))

    def drawn(noise: list[Array]) -> Drawn:
        cell = Cell(noise[0].shape[0], 2 * pi * _WAVES / longest)
        cut = Truncated(spectrum, min(_shortest(cell.points, longest), end))
        distance = min(way, cell.length / 2)
        responses = [heat_response(cell, v, diffusivity, distance) for v in velocity.tolist()]
        return _drawn(
            clipped_field(cut, **solid), cell, responses, noise, flash_of(law_of(cut, **solid))
        )

    fine = drawn(white)
    ratio = fine.ratio
    if _shortest(points, longest) < end:
        ratio = continued(fine, drawn([halved(noise) for noise in white]), flash_of(stress))
    doubt = form_doubt(velocity / diffusivity * _length_of_slopes(spectrum))
    area = stress.contact_fraction
    return TemperatureDistribution(
        flash, area, ratio, fine.pressure, fine.field, fine.wrong_share, doubt
    )


def _length_of_slopes(spectrum: Spectrum) -> float:
    """Return h_rms/h′, m, to .1 %: C(q) is summed over ln q, `_PER_PIECE` points between two breaks."""
    squares = np.zeros(2)
    for low, high in pairwise(breaks_of(spectrum).tolist()):
        log_q, weight = leggauss(_PER_PIECE)
        half = 0.5 * np.log(high / low)
        q = low * np.exp(half * (log_q + 1.0))
        squares += half * (weight * spectrum(q)) @ np.stack([q**2, q**4], axis=1)
    return float(np.sqrt(squares[0] / squares[1]))


def _shortest(points: int, longest: float) -> float:
    """Return the wavenumber of the wave of `_PIXELS` points, where `_WAVES` of the `longest` one are a side, rad/m."""
    return longest * points / (_WAVES * _PIXELS)


def continued(fine: Drawn, coarse: Drawn, flash: Array) -> Array:
    """Return T/T_flash of the fine fields continued to all of C(q), where T_flash is `flash`, K, (speeds,).

    The temperature below which a share of the heat is set free is linear in T_flash along the cut-offs: it goes on as
    from the coarse fields, with half of the waves, to the fine ones.
    """
    result = np.empty(fine.ratio.shape)
    for n, (end, top, below) in enumerate(
        zip(flash, fine.flash_temperature, coarse.flash_temperature, strict=True)
    ):
        going_on = (end - top) / (top - below) if top != below else 0.0
        order, order_below = np.argsort(fine.ratio[n]), np.argsort(coarse.ratio[n])
        kelvin = top * fine.ratio[n, order]
        kelvin_below = below * np.interp(
            _shares(fine.pressure[order]),
            _shares(coarse.pressure[order_below]),
            coarse.ratio[n, order_below],
        )
        result[n, order] = kelvin + min(max(going_on, 0.0), _FURTHEST) * (kelvin - kelvin_below)
    return np.asarray(result / (result @ fine.pressure / fine.pressure.sum())[:, None])


def _shares(heat: Array) -> Array:
    """Return the share of the heat up to the middle of each point."""
    up_to = np.cumsum(heat)
    return np.asarray((up_to - heat / 2) / up_to[-1])


def _drawn(
    field: ClippedField,
    cell: Cell,
    responses: list[NDArray[np.complex128]],
    white: list[Array],
    flash: Array,
) -> Drawn:
    """Return the temperature at the points of contact of all fields."""
    amplitude, wrong = amplitudes(field, cell)
    hot, pressed, numbers = [], [], []
    for n, noise in enumerate(white):
        plane = draw_pressure(field, amplitude, noise)
        contact = plane > 0.0
        hot.append(np.stack([temperature(plane, response)[contact] for response in responses]))
        pressed.append(plane[contact])
        numbers.append(np.full(pressed[-1].size, n))
    kelvin, pressure = np.concatenate(hot, axis=1), np.concatenate(pressed)
    mean = kelvin @ pressure / pressure.sum()
    return Drawn(flash, kelvin / mean[:, None], pressure, np.concatenate(numbers), wrong)


@dataclass(frozen=True, slots=True)
class Truncated:
    """C(q) up to a wavenumber."""

    spectrum: Spectrum
    q_max: float

    @property
    def breaks(self) -> tuple[float, ...]:
        """Ends, kinks and jumps, rad/m."""
        ends = breaks_of(self.spectrum)
        return (*ends[ends < self.q_max].tolist(), self.q_max)

    def __call__(self, q: ArrayLike) -> Array:
        """Return C at the wavenumbers `q`, rad/m, elementwise, m⁴."""
        wavenumber = real_array("q", q, "rad/m")
        return np.where(wavenumber <= self.q_max, self.spectrum(wavenumber), 0.0)
