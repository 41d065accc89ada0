"""Temperatures of one contact by the field itself, which starts from rest: their distribution over the contact."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from roughsim.grid import Array, Grid
from roughsim.heat.periodic import sliding_temperature
from roughsim.observables.distribution import BIN_AREAS, LEVELS, Bins, Distribution, binned, weighted_quantiles
from roughsim.observables.moments import HeatSource


class Slide(NamedTuple):
    """Slide from rest after which the field of temperature is taken, as in `sliding_temperature`."""

    direction: float = 0.0  # radians from axis 0 towards axis 1
    slid_distance: float | None = None  # m; None: half the chord of the cell


def temperature_distribution(
    pressure: Array, grid: Grid, sliding: HeatSource, flash_temperature: Array, slide: Slide
) -> Distribution:
    """Return the distribution of the temperature over a contact, pressure > 0, at each speed.

    The field gives T over its own heat-weighted mean, and `flash_temperature`, (speeds,), K, multiplies it: of
    isotropic roughness that is the mean over all directions of sliding, which scatters less. The field is computed in
    single precision. `pressure` is in Pa, shape `grid.shape`, periodic; of `sliding` the speeds and the body are read.
    Without contact all is NaN. ValueError as `sliding_temperature`.
    """
    contact = pressure > 0.0
    speeds = len(sliding.speeds)
    if not contact.any():
        nothing = np.full((speeds, len(LEVELS)), np.nan)
        return Distribution(nothing, nothing, Bins(*np.full((4, speeds, BIN_AREAS.size), np.nan)))
    flux = (pressure / pressure.mean()).astype(np.float32)
    fields = []
    for speed, conductivity, diffusivity in np.broadcast(sliding.speeds, sliding.conductivity, sliding.diffusivity):
        field = sliding_temperature(
            flux,
            grid,
            speed=float(speed),
            conductivity=float(conductivity),
            diffusivity=float(diffusivity),
            skin=sliding.skin,
            heat_depth=sliding.heat_depth,
            direction=slide.direction,
            slid_distance=slide.slid_distance,
        )
        fields.append(field[contact])
    return distribution_of(fields, [pressure[contact]] * speeds, flash_temperature)


def distribution_of(
    temperatures: Sequence[Array], pressures: Sequence[Array], flash_temperature: Array
) -> Distribution:
    """Return the distribution of temperatures of points at each speed, scaled to a T_flash, (speeds,), K.

    `temperatures` and `pressures`, > 0 in Pa, have an array (points,) for each speed.
    """
    levels = np.array([*LEVELS.values()])
    flashes = np.broadcast_to(flash_temperature, len(temperatures))
    by_heat, by_area, bins = [], [], []
    for field, weights, flash in zip(temperatures, pressures, flashes, strict=True):
        values = field.astype(np.float64)
        order = np.argsort(values)
        values, heat = values[order], weights[order].astype(np.float64, copy=False)
        with np.errstate(all="ignore"):  # 0/0 of a uniform pressure
            values = values * (float(flash) * heat.sum() / (values @ heat))
        by_heat.append(weighted_quantiles(values, heat, levels))
        by_area.append(weighted_quantiles(values, np.ones_like(values), levels))
        bins.append(binned(values, heat))
    return Distribution(
        np.array(by_heat), np.array(by_area), Bins(*(np.array(rows) for rows in zip(*bins, strict=True)))
    )
