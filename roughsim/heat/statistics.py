"""Statistics of a temperature field over the contact: means, distribution, hot spots, profiles, effective properties.

Weights are the heat set free, as in T_flash = Σ T q̇/Σ q̇; where μ and v are the same everywhere the pressure will do. An
empty contact gives NaN with a warning.
"""

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from roughsim.contact.patches import Patches, patch_sizes
from roughsim.errors import ConvergenceError, number, positive, real_field
from roughsim.grid import Array, Field, Grid
from roughsim.heat.periodic import checked_flux

_STEPS = 100  # of the fixed point


@dataclass(frozen=True, slots=True)
class ContactTemperature:
    """Temperatures of the contact, K above the background of the field."""

    flash_temperature: float  # mean weighted by the heat
    mean_temperature: float  # mean over the area
    max_temperature: float  # the highest of a pixel
    temperatures: Array  # of all contact pixels, ascending
    cooler: Array  # share of the heat that is set free at each of `temperatures` or below


def contact_temperature(temperature: ArrayLike, heat_flux: ArrayLike) -> ContactTemperature:
    """Return T_flash, T_max and the distribution of temperature over the contact, where `heat_flux` > 0.

    Both are fields of one shape, K and W/m², the flux ≥ 0; TypeError or ValueError otherwise. All is NaN, with a
    RuntimeWarning, for an empty contact.
    """
    values, weights = _contact_pixels(temperature, heat_flux)
    if not values.size:
        return ContactTemperature(math.nan, math.nan, math.nan, values, values.copy())
    order = np.argsort(values)
    values, weights = values[order], weights[order]
    cooler = np.cumsum(weights) / weights.sum()
    flash = float((values * weights).sum() / weights.sum())
    return ContactTemperature(flash, float(values.mean()), float(values[-1]), values, cooler)


def share_above(
    temperature: ArrayLike, heat_flux: ArrayLike, threshold: float, *, background_temperature: float = 0.0
) -> float:
    """Return the share of the contact area where T₀ + T exceeds a threshold, K, such as a melting temperature.

    The fields are those of `contact_temperature`; T₀ is the background temperature, K.
    """
    excess = number("threshold", threshold, "K") - number("background_temperature", background_temperature, "K")
    values, _ = _contact_pixels(temperature, heat_flux)
    return float((values > excess).mean()) if values.size else math.nan


def hot_spots(temperature: ArrayLike, grid: Grid, threshold: float, *, periodic: bool = True) -> Patches:
    """Return the regions hotter than a threshold, K, largest first; pixels are joined by their sides.

    `periodic` also joins them over the sides of the cell; False is for fields of the free half-space.
    """
    hot = real_field("temperature", temperature, grid.shape) > number("threshold", threshold, "K")
    return Patches(patch_sizes(hot, periodic=periodic), math.prod(grid.spacing))


def profiles(temperature: ArrayLike, grid: Grid, point: tuple[int, int] | None = None) -> tuple[Array, Array]:
    """Return the temperature along x and along y, K, through a pixel given by its indices; default: the hottest.

    For sliding in the x direction they run along and across it, shapes (n_x,) and (n_y,).
    """
    field = real_field("temperature", temperature, grid.shape)
    i, j = hottest_pixel(field) if point is None else point
    if not (0 <= i < grid.shape[0] and 0 <= j < grid.shape[1]):
        raise ValueError(f"point = {point} lies outside the grid {grid.shape}")
    return field[:, j].copy(), field[i].copy()


def hottest_pixel(temperature: ArrayLike) -> tuple[int, int]:
    """Return the indices of the hottest pixel."""
    field = real_field("temperature", temperature)
    i, j = np.unravel_index(int(field.argmax()), field.shape)
    return int(i), int(j)


def depth_profile(field_at: Callable[[float], Field], depths: ArrayLike) -> Array:
    """Return the temperature, K, straight below the hottest point of the surface, at `depths`, m, shape (n,).

    `field_at(depth)` gives the field there: `sliding_temperature` or `half_space_temperature` with all else fixed.
    """
    point = hottest_pixel(field_at(0.0))
    return np.array([field_at(float(depth))[point] for depth in np.atleast_1d(depths)], np.float64)


def effective_conductivity(
    conductivity: Callable[[float], float],
    flash_temperature: Callable[[float], float],
    *,
    background_temperature: float = 0.0,
) -> float:
    """Return the constant κ that replaces a κ(T): its value at T₀ + 0.75 T_flash, by fixed point.

    It is meant for a κ(T) that varies smoothly. A hardness σ_P(T) or a step in μ(T) changes the contact itself, and no
    effective constant can replace it.

    `conductivity` is κ(T), W/(m K), on the scale of T₀ + T, K; `flash_temperature` gives T_flash, K above the
    background T₀, for a constant κ. ValueError where κ or T_flash is not finite, or κ ≤ 0; ConvergenceError as
    `effective_temperature`.
    """

    def at(temperature: float) -> float:
        return positive("conductivity", conductivity(temperature), "W/(m K)")

    hot = effective_temperature(lambda t: flash_temperature(at(t)), background_temperature=background_temperature)
    return at(hot)


def effective_temperature(flash_temperature: Callable[[float], float], *, background_temperature: float = 0.0) -> float:
    """Return T = T₀ + 0.75 T_flash where T_flash depends on the properties at T: the fixed point next above T₀.

    `flash_temperature` gives T_flash, K above the background T₀, for properties at a temperature on the scale of
    T₀ + T, K. ValueError where T_flash is not finite; ConvergenceError without a fixed point in 100 steps.
    """
    start = number("background_temperature", background_temperature, "K")
    value, weight, last = start, 1.0, 0.0
    for _ in range(_STEPS):
        target = start + 0.75 * number("flash_temperature", flash_temperature(value), "K")
        change = target - value
        if abs(change) <= 1e-11 * abs(target):
            return target
        if change * last < 0.0:  # beyond the fixed point: smaller steps, for good
            weight *= 0.5
        value, last = value + weight * change, change
    residual = abs(change / target)
    raise ConvergenceError(
        f"temperature = {value:.6g} K still changes by {100 * residual:.3g} % after {_STEPS} steps: there is no fixed "
        "point at T₀ + 0.75 T_flash; check that the property varies smoothly",
        residual,
        _STEPS,
    )


def _contact_pixels(temperature: ArrayLike, heat_flux: ArrayLike) -> tuple[Array, Array]:
    """Temperatures and heat fluxes of the contact pixels."""
    field = real_field("temperature", temperature)
    flux = checked_flux(heat_flux, (field.shape[0], field.shape[1]))
    contact = flux > 0.0
    if not contact.any():
        warnings.warn(
            "heat_flux = 0 W/m² everywhere: there is no contact, and its temperature is NaN",
            RuntimeWarning,
            stacklevel=3,
        )
    return field[contact].astype(np.float64), flux[contact]
