"""Statistics of a temperature field: means, distributions, correlation, hot spots, profiles, effective properties.

Weights are the heat set free, as in T_flash = Σ T q̇/Σ q̇; for uniform μ and v the pressure will do. An empty contact
gives NaN with a warning.
"""

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import ArrayLike

from roughsim import fourier
from roughsim.contact.patches import Patches, patch_sizes
from roughsim.errors import ConvergenceError, number, positive, real_field
from roughsim.grid import Array, Field, Grid, distinct_wavenumbers
from roughsim.heat.arguments import checked_flux

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
    """Return T_flash, T_max and the distribution of temperature over the contact, `heat_flux` > 0.

    Both are fields of one shape, K and W/m², the flux ≥ 0; TypeError or ValueError otherwise. All is NaN, with a
    RuntimeWarning, for an empty contact.
    """
    values, weights = _contact_pixels(temperature, heat_flux)
    if not values.size:
        return ContactTemperature(math.nan, math.nan, math.nan, values, values.copy())
    order = np.argsort(values)
    values = values[order]
    weights = weights[order]
    cooler = np.cumsum(weights) / weights.sum()
    flash = float((values * weights).sum() / weights.sum())
    return ContactTemperature(flash, float(values.mean()), float(values[-1]), values, cooler)


def share_above(
    temperature: ArrayLike,
    heat_flux: ArrayLike,
    threshold: float,
    *,
    background_temperature: float = 0.0,
) -> float:
    """Return the fraction of the contact area with T₀ + T above a threshold, K, such as a melting temperature.

    Fields as in `contact_temperature`; T₀ is the background temperature, K.
    """
    excess = number("threshold", threshold, "K") - number(
        "background_temperature", background_temperature, "K"
    )
    values, _ = _contact_pixels(temperature, heat_flux)
    return float((values > excess).mean()) if values.size else math.nan


@dataclass(frozen=True, slots=True)
class JointDistribution:
    """Shares of the contact area by pressure and temperature; they add up to 1."""

    share: Array  # (bins of the pressure, bins of the temperature)
    pressure: Array  # edges of the bins, Pa, ascending
    temperature: Array  # the same, K above the background of the field


def joint_distribution(
    temperature: ArrayLike, pressure: ArrayLike, *, bins: int = 64
) -> JointDistribution:
    """Return the joint distribution of pressure and temperature over the contact area, `pressure` > 0.

    Both are fields of one shape, K and Pa, the pressure ≥ 0. A rate that stress and heat raise together, such as
    exp((σV − E)/k_B T), is summed over these shares. `bins` ≥ 1 is their number from the least to the largest value,
    along both axes. TypeError or ValueError otherwise; a contact without pixels has shares of NaN, with a
    RuntimeWarning.
    """
    if isinstance(bins, bool) or not isinstance(bins, (int, np.integer)) or bins < 1:
        raise ValueError(f"bins = {bins!r} must be a whole number of at least 1")
    values, weights = _contact_pixels(temperature, pressure)
    counts, *edges = np.histogram2d(weights, values, bins)
    with np.errstate(invalid="ignore"):  # 0/0 without contact
        return JointDistribution(counts / values.size, edges[0], edges[1])


def rms_temperature(temperature: ArrayLike) -> float:
    """Return the root mean square of a temperature field about its mean, over the whole cell, K."""
    return float(real_field("temperature", temperature).std(dtype=float))


def temperature_correlation(temperature: ArrayLike, grid: Grid, r: ArrayLike) -> Array:
    """Return ⟨T(x)T(x′)⟩ of a periodic field about its mean, averaged over all directions of x − x′.

    `temperature` is in K, shape `grid.shape`; `r` are distances, m, from 0 to half the diagonal of the cell. The result
    is Σ_q |T(q)|² J₀(|q|r), K², in the shape of `r`, the square of `rms_temperature` at r = 0. TypeError or ValueError
    for a field or a distance out of its range.
    """
    field = real_field("temperature", temperature, grid.shape)
    distance = np.asarray(r, float)
    limit = 0.5 * math.hypot(*grid.lengths)
    outside = ~((distance >= 0.0) & (distance <= limit * (1 + 1e-12)))
    if outside.any():
        raise ValueError(
            f"r = {distance[outside].ravel()[0]:.6g} m must lie between 0 and half the diagonal of the cell, "
            f"{limit:.6g} m; give a larger cell"
        )
    from roughsim.fourier.power import gathered_power  # loads numba

    amplitude = fourier.forward(field.astype(float, copy=False))
    wavenumber, entry = distinct_wavenumbers(grid)
    _, power = gathered_power(amplitude, grid.multiplicity, entry, wavenumber.size)
    values = [
        float(power[1:] @ scipy.special.j0(wavenumber[1:] * x)) for x in distance.ravel().tolist()
    ]
    return np.reshape(values, distance.shape)


def wake_profile(
    temperature: ArrayLike,
    heat_flux: ArrayLike,
    grid: Grid,
    distances: ArrayLike,
    *,
    periodic: bool = True,
) -> Array:
    """Return the mean temperature of the tracks at distances behind the rim of the contact, K: how fast they cool.

    For a source that moves along +x, so that its tracks lie at smaller x. A track begins behind each contact pixel
    (`heat_flux` > 0) whose neighbour at smaller x is none, at half a pixel from its centre, and ends at the next
    contact, or, unless `periodic`, at the side of the grid. The mean at a distance is over the tracks that are longer:
    over their width, not weighted by heat. Between the centres of pixels the temperature is linear. Rim and width are
    exact to a pixel. A contact of n rows errs by up to 1/n: one row more or less is at its cold sides. At 16 pixels per
    radius the mean behind a Hertz contact is 2.7 % too high with its centre on a pixel, within .1 % with its centre
    between four, and .7 % too high on the mean of positions, as of many contacts.

    Parameters
    ----------
    temperature, heat_flux : array_like
        K and W/m², both of shape `grid.shape`, the flux ≥ 0.
    grid : Grid
        The points of both.
    distances : array_like
        Distances behind the rim, m, at least half a pixel along x, shape (n,).
    periodic : bool
        Whether tracks go on over the sides of the cell; False is for fields of the free half-space.

    Returns
    -------
    ndarray
        K above the background of the field, shape (n,); NaN if no track is as long.

    Raises
    ------
    TypeError, ValueError
        If a field is not real, finite and of this shape, the flux is negative, or a distance is less than half a pixel.
    """
    field = real_field("temperature", temperature, grid.shape)
    contact = checked_flux(heat_flux, grid.shape) > 0.0
    behind = np.atleast_1d(np.asarray(distances, float))
    # from the centre of the last pixel of the contact, in pixels
    steps = behind / grid.spacing[0] + 0.5
    if not (np.isfinite(steps) & (steps >= 1.0)).all():
        raise ValueError(
            f"distances = {behind.min():.6g} m must be finite and at least half a pixel, {0.5 * grid.spacing[0]:.6g} "
            "m: nearer to the rim the grid has no point of the track; refine the grid"
        )
    i, j = np.nonzero(contact & ~np.roll(contact, 1, axis=0))
    means = np.full(behind.shape, math.nan)
    for step in range(1, 1 + min(grid.shape[0], math.ceil(steps.max(initial=0.0)))):
        longer = ~contact[i - step, j] & (periodic | (i >= step))
        i = i[longer]
        j = j[longer]
        here = (steps > step - 1) & (steps <= step)
        if i.size and here.any():
            before, now = (field[i - k, j].mean(dtype=float) for k in (step - 1, step))
            means[here] = now + (step - steps[here]) * (before - now)
    return means


def hot_spots(
    temperature: ArrayLike, grid: Grid, threshold: float, *, periodic: bool = True
) -> Patches:
    """Return the regions hotter than a threshold, K, largest first; pixels are joined by their sides.

    `periodic` also joins them over the sides of the cell; False is for fields of the free half-space.
    """
    hot = real_field("temperature", temperature, grid.shape) > number("threshold", threshold, "K")
    return Patches(patch_sizes(hot, periodic=periodic), math.prod(grid.spacing))


def profiles(
    temperature: ArrayLike, grid: Grid, point: tuple[int, int] | None = None
) -> tuple[Array, Array]:
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
    background T₀, for a constant κ. ValueError if κ or T_flash is not finite, or κ ≤ 0; ConvergenceError as
    `effective_temperature`.
    """

    def at(temperature: float) -> float:
        return positive("conductivity", conductivity(temperature), "W/(m K)")

    hot = effective_temperature(
        lambda t: flash_temperature(at(t)), background_temperature=background_temperature
    )
    return at(hot)


def effective_temperature(
    flash_temperature: Callable[[float], float], *, background_temperature: float = 0.0
) -> float:
    """Return T = T₀ + 0.75 T_flash, with T_flash by the properties at T: the fixed point next above T₀.

    `flash_temperature` gives T_flash, K above the background T₀, for properties at a temperature on the scale of T₀ +
    T, K. ValueError if T_flash is not finite; ConvergenceError without a fixed point in 100 steps.
    """
    start = number("background_temperature", background_temperature, "K")
    value = start
    weight = 1.0
    last = 0.0
    for _ in range(_STEPS):
        target = start + 0.75 * number("flash_temperature", flash_temperature(value), "K")
        change = target - value
        if abs(change) <= 1e-11 * abs(target):
            return target
        if change * last < 0.0:  # beyond the fixed point: smaller steps, for good
            weight *= 0.5
        value = value + weight * change
        last = change
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
    return field[contact].astype(float), flux[contact]
