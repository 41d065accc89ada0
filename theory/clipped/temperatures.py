"""Distribution of the temperature over a rough contact, from C(q): drawn clipped fields, and the law for T_flash.

A mean over the contact hides that the hottest hundredth of the heat is set free at two to three times T_flash. A
reaction, melting and wear depend on the whole distribution. T/T_flash is found from the temperature of drawn fields. It
depends little on the shortest waves, so that C(q) may end where a grid of modest size does. T_flash itself is the one
of the calibrated law, of the whole C(q).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, pi

import numpy as np
from numpy.typing import ArrayLike, NDArray

from theory.arguments import Array, Spectrum, breaks_of, positive, real_array
from theory.clipped.distribution import TemperatureDistribution
from theory.clipped.drawing import Cell, amplitudes, draw_pressure, heat_response, temperature
from theory.clipped.field import ClippedField, clipped_field, law_of
from theory.flash import flash_temperature

_WAVES = 4  # longest waves along a side of the cell
_PIXELS = 4  # along the shortest wave
_SMALLEST = 32  # points along a side: 2 q_min is the shortest wave


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
    that is older than half of the cell is even, and left out: longer ways count as that.

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
        Number of fields, 2 or more, and pixels along a side of each, 32 or more.

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
    for name, count, least in (("seed", seed, 0), ("fields", fields, 2), ("points", points, _SMALLEST)):
        if not isinstance(count, (int, np.integer)) or count < least:
            raise ValueError(f"{name} = {count!r} must be a whole number of {least} or more")
    way = inf if slid_distance is None else positive("slid_distance", slid_distance, "m")
    solid = {"effective_modulus": effective_modulus, "nominal_pressure": nominal_pressure}
    stress = law_of(spectrum, **solid, penetration_hardness=penetration_hardness)
    flash = flash_temperature(
        velocity,
        stress_spectrum=stress,
        nominal_pressure=nominal_pressure,
        friction_coefficient=friction_coefficient,
        conductivity=conductivity,
        diffusivity=diffusivity,
    )
    ends = breaks_of(spectrum)
    cell = Cell(points, 2 * pi * _WAVES / float(ends[0]))
    shortest = min(2 * pi * points / (_PIXELS * cell.length), float(ends[-1]))
    field = clipped_field(_Truncated(spectrum, shortest), **solid, penetration_hardness=penetration_hardness)
    responses = [heat_response(cell, v, diffusivity, min(way, cell.length / 2)) for v in velocity.tolist()]
    drawn = _drawn(field, cell, responses, fields, np.random.default_rng(seed))
    return TemperatureDistribution(np.asarray(flash), stress.contact_fraction, *drawn)


def _drawn(
    field: ClippedField, cell: Cell, responses: list[NDArray[np.complex128]], fields: int, rng: np.random.Generator
) -> tuple[Array, Array, NDArray[np.intp], float]:
    """Return T/T_flash, pressure and field of each point of contact of all fields, and the wrong share."""
    amplitude, wrong = amplitudes(field, cell)
    hot, pressed, numbers = [], [], []
    for n in range(fields):
        plane = draw_pressure(field, amplitude, rng)
        contact = plane > 0.0
        hot.append(np.stack([temperature(plane, response)[contact] for response in responses]))
        pressed.append(plane[contact])
        numbers.append(np.full(pressed[-1].size, n))
    kelvin, pressure = np.concatenate(hot, axis=1), np.concatenate(pressed)
    flash = kelvin @ pressure / pressure.sum()
    return kelvin / flash[:, None], pressure, np.concatenate(numbers), wrong


@dataclass(frozen=True, slots=True)
class _Truncated:
    """C(q) up to a wavenumber."""

    spectrum: Spectrum
    q_max: float

    @property
    def breaks(self) -> tuple[float, ...]:
        ends = breaks_of(self.spectrum)
        return (*ends[ends < self.q_max].tolist(), self.q_max)

    def __call__(self, q: ArrayLike) -> Array:
        wavenumber = real_array("q", q, "rad/m")
        return np.where(wavenumber <= self.q_max, self.spectrum(wavenumber), 0.0)
