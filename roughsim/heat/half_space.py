"""Temperatures on the free half-space: one source of heat, without periodic images.

The flux is constant over each pixel. `half_space_temperature` gives the field at the centres of the pixels: a
convolution of the flux with the `influence` of one pixel, padded with zeros so that nothing wraps around. A source with
a steep edge is hottest behind the last centre (1–4 % are lost at 8 pixels per radius), and the mean over the centres is
not the mean over the pixels. `source_temperature` has neither error: T_flash and T_av come from the influence on the
mean over each pixel, T_max from four points of each pixel and a search along sliding inside the hottest.

A skin, or heat released in depth, has an influence of its own, `roughsim.heat.layered_influence`.
"""

import math
import warnings
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from itertools import product

import numpy as np
import scipy
from numpy.typing import ArrayLike

from roughsim.errors import need_computed, not_negative, real_field
from roughsim.fourier import convolution
from roughsim.grid import Field, Grid, need_grid
from roughsim.heat.arguments import (
    checked_duration,
    checked_flux,
    checked_times,
    need_resolved,
)
from roughsim.heat.body import Body
from roughsim.heat.influence import PixelAxis, buried, one_sided_influence, temperature_at
from roughsim.heat.layered_influence import layered_influence
from roughsim.heat.periodic import fields_over_time, unit_vector
from roughsim.heat.skin import Layering, SkinLike

Place = tuple[float, float]  # along x and y, in pixels from the centre of the first pixel
_SLOW = 0.25  # Péclet number of a pixel, below which the temperature is smooth over it


def half_space_temperature(
    heat_flux: ArrayLike,
    grid: Grid,
    *,
    speed: float,
    conductivity: float,
    diffusivity: float,
    direction: float = 0.0,
    time: ArrayLike = math.inf,
    depth: float = 0.0,
    skin: SkinLike | None = None,
    heat_depth: float = 0.0,
) -> Field:
    """Return the temperature that a sliding heat source leaves in a half-space, with no heat outside the grid.

    Parameters
    ----------
    heat_flux : array_like
        Heat entering the body, shape `grid.shape`, W/m²: the mean over each pixel; float32 stays float32.
    grid : Grid
        The grid of the flux.
    speed, conductivity, diffusivity : float
        v, m/s; κ, W/(m K); D, m²/s.
    direction : float
        Of sliding, radians from axis 0 towards axis 1.
    time : float or 1-D array_like
        Time since the start from rest, s, ≥ 0; inf is the steady state, an array adds a leading axis.
    depth : float
        Below the surface, m, ≥ 0.
    skin, heat_depth
        As in `sliding_temperature`.

    Returns
    -------
    ndarray
        T above the body's temperature far away, K, at the centres of the pixels, shape `grid.shape` or
        `(len(time), *grid.shape)`.

    Raises
    ------
    TypeError, ValueError
        For an argument of the wrong kind, not finite or out of range.
    """
    need_grid(grid)
    flux = real_field("heat_flux", heat_flux, grid.shape)
    body = Body(conductivity, diffusivity, speed, skin, heat_depth)
    need_resolved(grid, body.speed, body.diffusivity)
    unit = grid.spacing[0]
    depth = not_negative("depth", depth, "m")
    times = checked_times(time)
    spreads = np.sqrt(body.diffusivity * times.ravel()) / unit
    # a series would only replace the responses that are kept
    response = partial(
        influence_response if spreads.size == 1 else influence_response.__wrapped__,
        *axes(grid, body, direction),
        depth / unit,
        flux.dtype.char,
        body.layers and body.layers.in_units(unit),
    )
    shape = padded_shape(grid.shape)
    fields = fields_over_time(flux, spreads, response, shape, unit / body.conductivity)
    need_computed("temperature", fields, "K", "heat_flux and conductivity")
    return fields.reshape(times.shape + grid.shape)


def padded_shape(shape: tuple[int, int]) -> tuple[int, int]:
    """Return a shape for fast transforms that holds every offset between two pixels once."""
    nx, ny = (scipy.fft.next_fast_len(2 * n - 1, real=True) for n in shape)
    return nx, ny


def axes(grid: Grid, body: Body, direction: float = 0.0) -> tuple[PixelAxis, PixelAxis]:
    """Return the axes in units of the pixel along x, for a source that slides in a direction, rad."""
    unit, side = grid.spacing
    ux, uy = unit_vector(direction)
    drift = body.speed / body.diffusivity
    x = PixelAxis(grid.shape[0], 1.0, drift * ux * unit)
    return x, PixelAxis(grid.shape[1], side / unit, drift * uy * unit)


# a field takes 3 to 10 times as long if its response is not known, .2 s of 1024² points
@lru_cache(maxsize=4)
def influence_response(
    x: PixelAxis, y: PixelAxis, depth: float, precision: str, layers: Layering | None, spread: float
) -> Field:
    """Return the response that makes T of q̇Δx/κ by `convolution.convolve`, Δx the pixel along x.

    `depth` is z and `spread` √(Dt), in units of Δx like the axes and the layers: so all cases with the same
    dimensionless numbers share one response. `precision` is "d" or "f".
    """
    if layers is None:
        influence = one_sided_influence(x, y, fading=buried(depth), end=spread)
    else:
        influence = layered_influence(x, y, depth=depth, end=spread, layers=layers)
    response = convolution.influence_spectrum(
        influence, y.count, padded_shape((x.count, y.count)), precision
    )
    response.flags.writeable = False
    return response


@dataclass(frozen=True, slots=True)
class SourceTemperature:
    """Temperatures of a source, K above the temperature of the body far away."""

    # Σ T q̇/Σ q̇ with T the mean over each pixel: exact for heat constant over each pixel
    flash_temperature: float
    mean_temperature: float  # mean over the contact area
    # the highest of all points of the surface, not of the centres of pixels alone
    max_temperature: float
    hottest_point: tuple[float, float]  # its position, m from the centre of the pixel (0, 0)


def source_temperature(
    heat_flux: ArrayLike,
    grid: Grid,
    *,
    speed: float,
    conductivity: float,
    diffusivity: float,
    direction: float = 0.0,
    time: float = math.inf,
    depth: float = 0.0,
    covered: ArrayLike | None = None,
) -> SourceTemperature:
    """Return T_flash, T_av and T_max of a sliding source on the free half-space, no heat outside the grid.

    Arguments as in `half_space_temperature`, with `heat_flux` ≥ 0 and one `time` > 0. For the mean over the contact
    area `covered`, shape `grid.shape`, is the share of each pixel that belongs to the contact, 0 to 1; default: the
    pixels with `heat_flux` > 0. All is NaN, with a RuntimeWarning, if there is no heat. TypeError or ValueError for an
    argument of the wrong kind, not finite or out of its range.
    """
    flux = checked_flux(heat_flux, grid.shape)
    weights = real_field("covered", flux > 0.0 if covered is None else covered, grid.shape)
    weights = weights.astype(float)
    if weights.min() < 0.0:
        raise ValueError(f"covered = {weights.min():.6g} must not be negative anywhere")
    body = Body(conductivity, diffusivity, speed)
    need_resolved(grid, body.speed, body.diffusivity)
    unit = grid.spacing[0]
    scale = unit / body.conductivity
    duration = checked_duration(time)
    below = not_negative("depth", depth, "m") / unit
    if not flux.any():
        warnings.warn(
            "heat_flux = 0 W/m² everywhere: there is no source, and its temperature is NaN",
            RuntimeWarning,
            stacklevel=2,
        )
        return SourceTemperature(math.nan, math.nan, math.nan, (math.nan, math.nan))
    pair = axes(grid, body, direction)
    end = math.sqrt(body.diffusivity * duration) / unit
    # from one forward transform: the means over the pixels, then the temperatures at four points of each pixel. A pixel
    # that ends the source is hottest 2 to 5 D/v before its trailing edge
    inside = [min(0.25, 3 / axis.peclet) if axis.peclet > _SLOW else 0.0 for axis in pair]
    trailing = [-math.copysign(0.5 - s, axis.drift) for s, axis in zip(inside, pair, strict=True)]
    shifts = list(product(*((0.0, shift) for shift in trailing)))
    averaged = replace(pair[0], averaged=True), replace(pair[1], averaged=True)
    shifted = [(replace(pair[0], shift=sx), replace(pair[1], shift=sy)) for sx, sy in shifts]
    response = influence_response.__wrapped__
    spectra = (response(*axes, below, "d", None, end) for axes in (averaged, *shifted))
    fields = convolution.convolutions(flux, spectra, padded_shape(grid.shape))
    mean = next(fields)
    hottest = (-math.inf, (0.0, 0.0))
    for field, (sx, sy) in zip(fields, shifts, strict=True):
        i, j = np.unravel_index(int(field.argmax()), field.shape)
        hottest = max(hottest, (float(field[i, j]), (float(i) + sx, float(j) + sy)))
    # then along sliding inside the hottest pixel
    fast = [k for k, axis in enumerate(pair) if axis.peclet > _SLOW]
    for k in fast * len(fast):
        hottest = max(hottest, _hottest_along(k, hottest[1], flux, pair, below, end))
    return SourceTemperature(
        flash_temperature=scale * float((mean * flux).sum() / flux.sum()),
        mean_temperature=scale * float((mean * weights).sum() / weights.sum()),
        max_temperature=scale * hottest[0],
        hottest_point=(hottest[1][0] * grid.spacing[0], hottest[1][1] * grid.spacing[1]),
    )


def _hottest_along(
    k: int, place: Place, flux: Field, pair: tuple[PixelAxis, PixelAxis], depth: float, end: float
) -> tuple[float, Place]:
    """Return the highest κT along axis k inside the pixel of `place`, and its position.

    The trailing edge of the pixel is colder than just ahead of it. The distance from that edge is halved until heat no
    longer drifts over it, and then a parabola is laid through the three points around the best.
    """
    axis = pair[k]
    sense = math.copysign(1.0, axis.drift)
    pixel = sense * math.floor(sense * place[k] + 0.5)
    halvings = np.arange(0.0, 1.0 + math.ceil(math.log2(10 * axis.peclet)))

    def point(halving: float) -> tuple[float, Place]:
        position = pixel + sense * (2.0**-halving - 0.5)
        moved = (position, place[1]) if k == 0 else (place[0], position)
        i, j = (
            min(max(math.floor(at + 0.5), 0), axis.count - 1)
            for at, axis in zip(moved, pair, strict=True)
        )
        x = replace(pair[0], shift=moved[0] - i)
        y = replace(pair[1], shift=moved[1] - j)
        return temperature_at((i, j), flux, x, y, fading=buried(depth), end=end), moved

    points = [point(float(halving)) for halving in halvings]
    values = [value for value, _ in points]
    n = min(max(int(np.argmax(values)), 1), len(values) - 2)
    low, middle, high = values[n - 1 : n + 2]
    bend = low - 2 * middle + high
    top = halvings[n]
    if bend < 0.0:
        top = halvings[n] + (low - high) / (2 * bend)
    vertex = float(np.clip(top, halvings[0], halvings[-1]))
    return max([*points, point(vertex)])
