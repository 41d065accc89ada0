"""The temperatures of one source on the free half-space, beyond what the centres of the pixels show.

A source with a steep edge is hottest behind the last centre: 1–4 % are lost at 8 pixels per radius. And the mean of
the temperatures at the centres is not the mean over the pixels. For heat that is constant over each pixel both are
computed here without any such error: T_flash and T_av from the influence on the mean over each pixel, T_max from
four points of each pixel and a search along sliding inside the hottest.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughsim.errors import not_negative, number, positive, real_field
from roughsim.fourier import convolution
from roughsim.grid import Grid
from roughsim.heat.free.half_space import axes, axes_spectrum, padded_shape
from roughsim.heat.free.influence import Axis, temperature_at
from roughsim.heat.response import checked_duration, checked_flux, unit_vector

Vector = NDArray[np.float64]
_SLOW = 0.25  # Péclet number of a pixel, below which the temperature is smooth over it
Place = tuple[float, float]  # in pixels from the centre of the first


@dataclass(frozen=True, slots=True)
class SourceTemperature:
    """Temperatures of a source, K above that of the body far away.

    Attributes
    ----------
    flash_temperature : float
        Σ T q̇/Σ q̇ with T the mean over each pixel: exact for heat that is constant over each pixel.
    mean_temperature : float
        Mean over the contact area.
    max_temperature : float
        The highest of all points of the surface, not of the centres of pixels alone.
    hottest_point : (float, float)
        Where that is, m from the centre of the pixel (0, 0).
    """

    flash_temperature: float
    mean_temperature: float
    max_temperature: float
    hottest_point: tuple[float, float]


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

    Parameters
    ----------
    heat_flux : array_like
        Heat entering the body, shape `grid.shape`, W/m², ≥ 0: the mean over each pixel.
    grid, speed, conductivity, diffusivity, direction, depth
        As in `half_space_temperature`.
    time : float
        Time since the start from rest, s, > 0; inf is the steady state.
    covered : array_like, optional
        Share of each pixel that belongs to the contact, 0 to 1, for `mean_temperature`. Default: `heat_flux` > 0.

    Returns
    -------
    SourceTemperature
        NaN, with a RuntimeWarning, if there is no heat.

    Raises
    ------
    TypeError, ValueError
        An argument of the wrong kind, not finite or out of its range.
    """
    flux = checked_flux(heat_flux, grid.shape)
    weights = (flux > 0.0 if covered is None else real_field("covered", covered, grid.shape)).astype(np.float64)
    if weights.min() < 0.0:
        raise ValueError(f"covered = {weights.min():.6g} must not be negative anywhere")
    drift = number("speed", speed, "m/s") / positive("diffusivity", diffusivity, "m²/s")
    scale = grid.spacing[0] / positive("conductivity", conductivity, "W/(m K)")
    duration, below = checked_duration(time), not_negative("depth", depth, "m") / grid.spacing[0]
    if not flux.any():
        warnings.warn("heat_flux = 0 W/m² everywhere: no source has no temperature", RuntimeWarning, stacklevel=2)
        return SourceTemperature(math.nan, math.nan, math.nan, (math.nan, math.nan))
    ux, uy = unit_vector(direction)
    x, y = axes(grid, (drift * ux, drift * uy))
    source = Source(flux, (x, y), below, math.sqrt(diffusivity * duration) / grid.spacing[0])
    (mean,) = source.fields([(replace(x, averaged=True), replace(y, averaged=True))])
    hottest, (i, j) = source.hottest()
    return SourceTemperature(
        flash_temperature=scale * float((mean * flux).sum() / flux.sum()),
        mean_temperature=scale * float((mean * weights).sum() / weights.sum()),
        max_temperature=scale * hottest,
        hottest_point=(i * grid.spacing[0], j * grid.spacing[1]),
    )


class Source:
    """A source in units of the pixel along x; temperatures are κT."""

    def __init__(self, flux: Vector, pair: tuple[Axis, Axis], depth: float, end: float):
        self.flux, self.axes, self.depth, self.end = flux, pair, depth, end

    def fields(self, pairs: list[tuple[Axis, Axis]]) -> Iterator[Vector]:
        """Yield κT at the points that each pair of axes names, from one forward transform."""
        spectra = (axes_spectrum(x, y, self.depth, self.end, "d") for x, y in pairs)
        return convolution.convolutions(self.flux, spectra, padded_shape((self.flux.shape[0], self.flux.shape[1])))

    def hottest(self) -> tuple[float, Place]:
        """Return the highest temperature and where it is: of four points of each pixel, then along sliding."""
        (x, y), best = self.axes, (-math.inf, (0.0, 0.0))
        # a pixel that ends the source is hottest 2 to 5 D/v before its trailing edge
        inside = [min(0.25, 3 / axis.peclet) if axis.peclet > _SLOW else 0.0 for axis in self.axes]
        trailing = [-math.copysign(0.5 - part, axis.drift) for part, axis in zip(inside, self.axes, strict=True)]
        shifts = list(product(*((0.0, shift) for shift in trailing)))
        fields = self.fields([(replace(x, shift=sx), replace(y, shift=sy)) for sx, sy in shifts])
        for field, (sx, sy) in zip(fields, shifts, strict=True):
            i, j = np.unravel_index(int(field.argmax()), field.shape)
            best = max(best, (float(field[i, j]), (float(i) + sx, float(j) + sy)))
        fast = [k for k, axis in enumerate(self.axes) if axis.peclet > _SLOW]
        for k in fast * len(fast):
            best = max(best, self.hottest_along(k, best[1]))
        return best

    def hottest_along(self, k: int, place: Place) -> tuple[float, Place]:
        """Return the highest temperature along axis k inside the pixel of `place`, and where it is.

        The trailing edge of the pixel is colder than just ahead of it. The distance from that edge is halved until heat
        no longer drifts over it, and then a parabola is laid through the three points around the best.
        """
        axis, sense = self.axes[k], math.copysign(1.0, self.axes[k].drift)
        pixel = sense * math.floor(sense * place[k] + 0.5)
        halvings = np.arange(0.0, 1.0 + math.ceil(math.log2(10 * axis.peclet)))

        def point(halving: float) -> tuple[float, Place]:
            position = pixel + sense * (2.0**-halving - 0.5)
            moved = (position, place[1]) if k == 0 else (place[0], position)
            i, j = (min(max(math.floor(s + 0.5), 0), a.count - 1) for s, a in zip(moved, self.axes, strict=True))
            x, y = (replace(a, shift=s - n) for a, s, n in zip(self.axes, moved, (i, j), strict=True))
            return temperature_at((i, j), self.flux, x, y, depth=self.depth, end=self.end), moved

        values = [point(float(halving)) for halving in halvings]
        n = min(max(int(np.argmax([value for value, _ in values])), 1), len(values) - 2)
        low, middle, high = (value for value, _ in values[n - 1 : n + 2])
        bend = low - 2 * middle + high
        top = halvings[n] + (low - high) / (2 * bend) if bend < 0.0 else halvings[n]
        return max([*values, point(float(np.clip(top, halvings[0], halvings[-1])))])
