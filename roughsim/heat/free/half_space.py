"""Frictional heat on the free half-space: one source, and nothing around it.

The flux is constant over each pixel, and temperatures are those at the centres of the pixels. The sum over all
pixels is a convolution without wrap-around: the field is padded with zeros.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

from numpy.typing import ArrayLike, NDArray
from scipy.fft import next_fast_len

from roughsim.errors import not_negative, number, positive, real_field
from roughsim.fourier import convolution
from roughsim.grid import Grid
from roughsim.heat.free.influence import Axis, one_sided_influence
from roughsim.heat.response import checked_times, fields_over_time, unit_vector

Field = NDArray[Any]


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
) -> Field:
    """Return the temperature that a sliding heat source leaves in a half-space, with no heat outside the grid.

    Parameters
    ----------
    heat_flux : array_like
        Heat entering the body, shape `grid.shape`, W/m²: the mean over each pixel. float32 stays float32.
    grid : Grid
        The pixels; here the cell is not periodic.
    speed : float
        Speed of the source through the body, m/s; a negative speed is the opposite direction.
    conductivity : float
        κ, W/(m K).
    diffusivity : float
        D, m²/s.
    direction : float
        Angle of sliding, radians from axis 0 towards axis 1.
    time : float or array_like
        Time since the start from rest, s, ≥ 0; inf is the steady state. A 1-D array adds a leading axis.
    depth : float
        Distance below the surface, m, ≥ 0.

    Returns
    -------
    ndarray
        T above the body's temperature far away, K, at the centres of the pixels, shape `grid.shape` or
        `(len(time), *grid.shape)`.

    Raises
    ------
    TypeError, ValueError
        An argument of the wrong kind, not finite or out of its range.
    """
    flux = real_field("heat_flux", heat_flux, grid.shape)
    drift = number("speed", speed, "m/s") / positive("diffusivity", diffusivity, "m²/s")
    scale = grid.spacing[0] / positive("conductivity", conductivity, "W/(m K)")
    depth, times = not_negative("depth", depth, "m"), checked_times(time)
    ux, uy = unit_vector(direction)

    def response(spread: float, kept: bool) -> Field:
        drifts = (drift * ux, drift * uy)
        return influence_spectrum(grid, drifts, depth, math.sqrt(spread), flux.dtype.char, kept=kept)

    fields = fields_over_time(flux, diffusivity * times.ravel(), response, padded_shape(grid.shape), scale)
    return fields.reshape(times.shape + grid.shape)


def padded_shape(shape: tuple[int, int]) -> tuple[int, int]:
    """Return a shape for fast transforms that holds every offset between two pixels once."""
    nx, ny = (next_fast_len(2 * n - 1, real=True) for n in shape)
    return nx, ny


def influence_spectrum(
    grid: Grid,
    drift: tuple[float, float],
    depth: float,
    spread: float,
    precision: str = "d",
    *,
    kept: bool = True,
) -> Field:
    """Return the padded half spectrum, turned, that makes T of q̇Δx/κ by `convolution.convolve`; Δx is along x.

    `drift` is v/D along x and y, 1/m; `depth` and `spread` are z and √(Dt), m; `precision` is "d" or "f". A kept one
    serves the next call with the same dimensionless numbers: the latest four are kept.
    """
    unit = grid.spacing[0]
    x, y = axes(grid, drift)
    build = _kept_spectrum if kept else axes_spectrum
    return build(x, y, depth / unit, spread / unit, precision)


def axes(grid: Grid, drift: tuple[float, float]) -> tuple[Axis, Axis]:
    """Return the axes in units of the pixel along x: with depth and time in it, all that an influence depends on."""
    unit, side = grid.spacing
    return Axis(grid.shape[0], 1.0, drift[0] * unit), Axis(grid.shape[1], side / unit, drift[1] * unit)


def axes_spectrum(x: Axis, y: Axis, depth: float, spread: float, precision: str) -> Field:
    """Return what `influence_spectrum` does, with all lengths in units of the pixel along x."""
    influence = one_sided_influence(x, y, depth=depth, end=spread)
    spectrum = convolution.influence_spectrum(influence, y.count, padded_shape((x.count, y.count)), precision)
    spectrum.flags.writeable = False
    return spectrum


_kept_spectrum = lru_cache(maxsize=4)(axes_spectrum)
