"""Temperatures of one contact by the field itself, from rest: T_flash along one direction, and their distribution."""

from collections.abc import Iterable, Sequence
from dataclasses import asdict
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from roughsim.errors import need_computed
from roughsim.fourier.convolution import convolutions
from roughsim.grid import Array, Field, Grid
from roughsim.heat.periodic import MovingSource, moving, sliding_temperature, turned_response
from roughsim.observables.distribution import (
    BIN_AREAS,
    LEVELS,
    Bins,
    Distribution,
    area_quantiles,
    binned,
    weighted_quantiles,
)
from roughsim.observables.moments import HeatSource

# ln of the factor on a field, beyond which its distribution is unknown. Below it 655 fields of 28 drawn surfaces with a
# lay had the 99 % quantile of the mean over directions to 4 % (rms; worst 20), 17 beyond it to 15 % (27). 252 fields of
# 84 isotropic surfaces, with 1 to 8 longest waves a side, had a logarithm of at most .08
MOST_SCALED = 0.5
_KEPT = 2**21  # points times speeds up to which the responses of a grid are kept, in 8 MB


class SlideFromRest(NamedTuple):
    """Slide from rest after which the field of temperature is taken, as in `sliding_temperature`."""

    direction: float | tuple[float, ...] = (
        0.0  # radians from axis 0 towards axis 1; or of each speed
    )
    slid_distance: float | None = None  # m; None: half the chord of the cell


def flash_temperature_along(
    pressure: Array,
    grid: Grid,
    sliding: HeatSource,
    direction: float,
    slid_distance: float | None = None,
) -> Array:
    """Return ⟨Tσ⟩/⟨σ⟩ in one direction of sliding, K, at each speed, without q = 0.

    The temperature follows `sliding_temperature` from rest: the steady moments of one direction have every spot in its
    own hot track, for ever, and above v L/(2πD) = 1 they are too high. With the sides four and more longest waves, the
    mean over directions is within 2 % of `measure`.

    Parameters
    ----------
    pressure : ndarray
        Shape `grid.shape`, Pa, periodic.
    grid : Grid
        Its cell.
    sliding : HeatSource
        Speeds, friction, and the body; its own direction is not read.
    direction : float
        Radians from axis 0 towards axis 1.
    slid_distance : float, optional
        Distance slid since the start from rest, m. Default: half the chord of the cell along `direction`.
    """
    frictions = np.broadcast_to(sliding.friction_coefficient, len(sliding.speeds)).tolist()
    mean = float(pressure.mean())
    found = []
    for body, friction in zip(sliding.bodies, frictions, strict=True):
        temperature = sliding_temperature(
            sliding.heat_partition * friction * abs(body.speed) * pressure,
            grid,
            direction=direction,
            slid_distance=slid_distance,
            **asdict(body),
        )
        found.append(float(np.mean(temperature * pressure)) / mean)
    return np.array(found)


def temperature_distribution(
    pressure: Array, grid: Grid, sliding: HeatSource, flash_temperature: Array, slide: SlideFromRest
) -> Distribution:
    """Return the distribution of the temperature over a contact, pressure > 0, at each speed.

    The field gives T over its own heat-weighted mean, and `flash_temperature`, (speeds,), K, multiplies it: of
    isotropic roughness that is the mean over all directions of sliding, which scatters less. Temperatures are NaN, as
    unknown, at a speed at which this changes the field by more than exp(±`MOST_SCALED`): it does not show the contact
    of that T_flash. The fields are computed in single precision, from one transform of the pressure. `pressure` is in
    Pa, shape `grid.shape`, periodic. Without contact all is NaN. ValueError as `sliding_temperature`.
    """
    contact = pressure > 0.0
    speeds = len(sliding.speeds)
    if not contact.any():
        nothing = np.full((speeds, len(LEVELS)), np.nan)
        return Distribution(nothing, nothing, Bins(*np.full((4, speeds, BIN_AREAS.size), np.nan)))
    fields = contact_fields(pressure, grid, sliding, slide)
    heat = pressure[contact]
    with np.errstate(all="ignore"):  # 0/0 at rest, and of a uniform pressure
        factor = flash_temperature / own_flash(fields, heat, pressure.mean(), sliding)
    alike = np.isnan(factor) | ((factor > np.exp(-MOST_SCALED)) & (factor < np.exp(MOST_SCALED)))
    return distribution_of(fields, [heat] * speeds, np.where(alike, flash_temperature, np.nan))


def contact_fields(
    pressure: Array, grid: Grid, sliding: HeatSource, slide: SlideFromRest
) -> list[Field]:
    """Return κT/q̇ at the points of contact, m, at each speed, q̇ the mean heat; arguments and errors as above."""
    contact = pressure > 0.0
    speeds = len(sliding.speeds)
    flux = (pressure / pressure.mean()).astype(np.float32)
    sources = []
    directions = np.broadcast_to(slide.direction, speeds).tolist()
    for body, angle in zip(sliding.bodies, directions, strict=True):
        drift, duration, _ = moving(grid, body.speed, body.diffusivity, angle, slide.slid_distance)
        spread = body.diffusivity * float(duration)
        sources.append(MovingSource(drift, spread, layers=body.layers))
    if flux.min() == flux.max():  # only q = 0, which is left out
        fields = [np.zeros(grid.points, np.float32)] * speeds
    else:
        if grid.points * speeds <= _KEPT:
            responses: Iterable[Field] = _kept_responses(grid, tuple(sources))
        else:
            responses = (turned_response(grid, source, np.float32) for source in sources)
        fields = [field[contact] for field in convolutions(flux, responses, grid.shape)]
    for field in fields:
        need_computed("temperature", field, "m of κT/q̇", "the size of the cell and the speed")
    return fields


def own_flash(
    fields: Sequence[Field], heat: Array, nominal_pressure: float, sliding: HeatSource
) -> Array:
    """Return T_flash of the `contact_fields` themselves, K, (speeds,); `heat` is the pressure at their points."""
    heating = np.multiply(sliding.friction_coefficient, np.abs(sliding.speeds))
    flux = sliding.heat_partition * heating
    own = np.array([field @ heat for field in fields]) / heat.sum()  # κ T_flash/q̇, m
    return flux * nominal_pressure * own / np.asarray(sliding.conductivity)


# half of the time of a contact of 512² points; the grids of a run come in turn
@lru_cache(maxsize=8)
def _kept_responses(grid: Grid, sources: tuple[MovingSource, ...]) -> list[Field]:
    return [turned_response(grid, source, np.float32) for source in sources]


def distribution_of(
    temperatures: Sequence[Field], pressures: Sequence[Field], flash_temperature: Array
) -> Distribution:
    """Return the distribution of temperatures of points at each speed, scaled to a T_flash, (speeds,), K.

    `temperatures` and `pressures`, > 0 in Pa, have an array (points,) for each speed.
    """
    levels = np.array([*LEVELS.values()])
    flashes = np.broadcast_to(flash_temperature, len(temperatures))
    by_heat = []
    by_area = []
    bins = []
    for field, weights, flash in zip(temperatures, pressures, flashes, strict=True):
        order = np.argsort(field)
        values = field[order].astype(float)
        heat = weights[order].astype(float)
        with np.errstate(all="ignore"):  # 0/0 of a uniform pressure
            values *= float(flash) * heat.sum() / (values @ heat)
        by_heat.append(weighted_quantiles(values, heat, levels))
        by_area.append(area_quantiles(values, levels))
        bins.append(binned(values, heat))
    return Distribution(
        np.array(by_heat),
        np.array(by_area),
        Bins(*(np.array(rows) for rows in zip(*bins, strict=True))),
    )
