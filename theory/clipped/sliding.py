"""Distribution of the temperature over two rough faces that slide over one another, from C(q) and T_flash.

Drawn clipped fields, `theory.clipped.two_faces`, give T/T_flash of the moving body, without a contact. T_flash itself
is that of `theory.two_bodies`. C(q) is drawn up to 16 q_min. If it goes on, T − T_flash grows on as at the hottest
hundredth of the heat of a frozen contact.
"""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from theory.arguments import (
    Array,
    Spectrum,
    breaks_of,
    need_whole,
    not_negative_array,
    positive,
    real_array,
)
from theory.clipped.distribution import TemperatureDistribution
from theory.clipped.drawing import Cell, amplitudes, heights
from theory.clipped.field import clipped_field, law_of
from theory.clipped.temperatures import Truncated, temperature_distribution
from theory.clipped.two_faces import LAST, Body, Pair, Way, oblique_way, pressures

_WAVES = (
    2.0,
    8.0,
)  # longest waves along a side of the cell: few leave room for short ones, and many are slow
_PIXELS = 6  # along the shortest wave
_POSITIONS = 8
_SMALLEST = 48  # points along a side
_DOUBT = 0.15  # of `TemperatureDistribution`, chosen wide: beside solved slides .11 rms, at most .26, at 99 %
_HOT = 0.99  # quantile
_EVEN = 0.01  # of T_flash: a contact whose hottest hundredth is not above it by more is even


def sliding_temperature_distribution(  # noqa: PLR0913  (contact, two bodies, and numbers of the drawing)
    speed: ArrayLike,
    spectrum: Spectrum,
    *,
    effective_modulus: float,
    nominal_pressure: float,
    penetration_hardness: float | None = None,
    conductivity: float,
    diffusivity: float,
    resting_conductivity: float | None = None,
    resting_diffusivity: float | None = None,
    moving_roughness: float = 0.5,
    slid_distance: float,
    flash_temperature: ArrayLike,
    seed: int = 0,
    fields: int = 6,
    points: int = 192,
) -> TemperatureDistribution:
    """Distribution of the temperature of the moving one of two rough bodies over their contact.

    Parameters
    ----------
    speed : array_like
        v, m/s, of either sign, not 0; one number or shape (speeds,).
    spectrum : callable
        C(q) of both faces together, m⁴, with `breaks`.
    effective_modulus, nominal_pressure, penetration_hardness : float
        E*, σ₀ and σ_P, Pa; without σ_P contact is elastic.
    conductivity, diffusivity : float
        κ, W/(m K), and D, m²/s, of the moving body.
    resting_conductivity, resting_diffusivity : float, optional
        The same of the resting body; None: as the moving one.
    moving_roughness : float
        f, the part of C(q) that rides with the moving body, from 0 to 1.
    slid_distance : float
        m since both bodies were cold, > 0. T/T_flash is that around three quarters of it.
    flash_temperature : array_like
        T_flash of the moving body, K, ≥ 0, as from `theory.two_bodies.sliding_temperatures`; one number, or one for
        each speed.
    seed : int
        Of the random numbers, ≥ 0.
    fields, points : int
        Number of pairs of drawn faces, 2 or more, and pixels along a side of each, 48 or more.

    Returns
    -------
    TemperatureDistribution
        The speeds in their order. Its temperatures are those with the moving body's own share of the heat.

    Raises
    ------
    TypeError, ValueError
        If an argument is not real, finite and of the right sign, or the contact lies outside the range of the law of
        its stress spectrum, as `plasticity.stress_spectrum` and `persson.calibrated_spectrum` explain. The part of C(q)
        up to the shortest drawn wave must lie in it too.
    ArithmeticError
        If the temperatures of both bodies do not become equal over the contact.
    """
    velocity = np.atleast_1d(np.abs(real_array("speed", speed, "m/s")))
    if not (velocity > 0.0).all():
        raise ValueError(
            f"speed = {velocity.min():.6g} m/s must be positive: heat is kept over the way slid"
        )
    flash = np.broadcast_to(
        not_negative_array("flash_temperature", flash_temperature, "K"), velocity.shape
    )
    for name, count, least in (
        ("seed", seed, 0),
        ("fields", fields, 2),
        ("points", points, _SMALLEST),
    ):
        need_whole(name, count, least)
    part = float(real_array("moving_roughness", moving_roughness, "1"))
    if not 0.0 <= part <= 1.0:
        raise ValueError(f"moving_roughness = {part:.6g} must lie from 0 to 1")
    distance = positive("slid_distance", slid_distance, "m")
    moving = Body(
        positive("conductivity", conductivity, "W/(m K)"),
        positive("diffusivity", diffusivity, "m²/s"),
    )
    kappa = moving.conductivity if resting_conductivity is None else resting_conductivity
    diffusion = moving.diffusivity if resting_diffusivity is None else resting_diffusivity
    resting = Body(
        positive("resting_conductivity", kappa, "W/(m K)"),
        positive("resting_diffusivity", diffusion, "m²/s"),
    )
    solid: dict[str, Any] = {
        "effective_modulus": effective_modulus,
        "nominal_pressure": nominal_pressure,
    }
    solid["penetration_hardness"] = penetration_hardness

    longest, end = float(breaks_of(spectrum)[0]), float(breaks_of(spectrum)[-1])
    waves = min(max(points / _PIXELS * longest / end, _WAVES[0]), _WAVES[1])
    cell = Cell(points, 2 * pi * waves / longest)
    drawn = Truncated(spectrum, min(longest * points / (_PIXELS * waves), end))
    field = clipped_field(drawn, **solid)
    amplitude, wrong = amplitudes(field, cell)
    rng = np.random.default_rng(seed)
    still, riding = (
        np.stack([heights(amplitude, rng.standard_normal((points, points))) for _ in range(fields)])
        for _ in range(2)
    )
    way, late = _way(distance, cell)
    bodies = [
        Pair(cell, way, fields, speed=v, moving=moving, resting=resting) for v in velocity.tolist()
    ]
    hot, pressed, numbers = [], [], []
    for k, contact in enumerate(pressures(field, still, riding, part, way)):
        surfaces = [pair.advance(contact) for pair in bodies]
        if k in late:
            touching = contact > 0.0
            hot.append(np.stack([surface[touching] for surface in surfaces]))
            pressed.append(contact[touching])
            numbers.append(np.nonzero(touching)[0])
    number = np.concatenate(numbers)
    order = np.argsort(number, kind="stable")
    kelvin = np.concatenate(hot, axis=1, dtype=np.float64)[:, order]
    pressure = np.concatenate(pressed, dtype=np.float64)[order]
    ratio = kelvin / (kelvin @ pressure / pressure.sum())[:, None]
    if drawn.q_max < end:
        ratio = 1 + _growth(velocity, drawn, spectrum, solid, moving)[:, None] * (ratio - 1)
    area = law_of(spectrum, **solid).contact_fraction
    return TemperatureDistribution(
        flash, area, ratio, nominal_pressure * pressure, number[order], wrong, _DOUBT
    )


def _way(slid_distance: float, cell: Cell) -> tuple[Way, set[int]]:
    """Return the steps up to and around the middle of the last half of a distance, and those at which T is taken."""
    middle = 0.75 * slid_distance
    beside = min(0.25 * slid_distance, LAST / 2 * cell.length / cell.points)
    way = oblique_way(middle + beside, cell)
    first = int(np.searchsorted(np.cumsum(way.length), middle - beside))
    return way, set(
        np.rint(np.linspace(first, len(way.length) - 1, _POSITIONS)).astype(int).tolist()
    )


def _growth(
    velocity: Array, drawn: Spectrum, whole: Spectrum, solid: dict[str, Any], body: Body
) -> Array:
    """Return the growth of T − T_flash at the hottest hundredth of frozen contacts, from the drawn waves to all."""
    heat: dict[str, Any] = {"friction_coefficient": 1.0} | body._asdict()
    above = []
    for spectrum in (drawn, whole):
        found = temperature_distribution(velocity, spectrum, **solid, **heat)
        above.append(found.quantiles(_HOT).value[0] / found.flash_temperature - 1)
    return np.where(above[0] > _EVEN, above[1] / np.maximum(above[0], _EVEN), 1.0)
