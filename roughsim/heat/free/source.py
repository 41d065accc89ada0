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
from roughsim.heat.response import checked_times, unit_vector

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
    flux = _not_negative_field("heat_flux", heat_flux, grid)
    weights = (flux > 0.0).astype(float) if covered is None else _not_negative_field("covered", covered, grid)
    drift = number("speed", speed, "m/s") / positive("diffusivity", diffusivity, "m²/s")
    scale = grid.spacing[0] / positive("conductivity", conductivity, "W/(m K)")
    instant, below = checked_times(time), not_negative("depth", depth, "m") / grid.spacing[0]
    if instant.ndim or instant == 0.0:
        raise ValueError(f"time = {time} s must be one positive number")
    if not flux.any():
        warnings.warn("heat_flux = 0 W/m² everywhere: no source has no temperature", RuntimeWarning, stacklevel=2)
        return SourceTemperature(math.nan, math.nan, math.nan, (math.nan, math.nan))
    ux, uy = unit_vector(direction)
    spread = math.sqrt(diffusivity * float(instant)) / grid.spacing[0]
    source = _Source(flux, axes(grid, (drift * ux, drift * uy)), below, spread)
    mean, (hottest, (i, j)) = source.means(), source.hottest()
    return SourceTemperature(
        flash_temperature=scale * float((mean * flux).sum() / flux.sum()),
        mean_temperature=scale * float((mean * weights).sum() / weights.sum()),
        max_temperature=scale * hottest,
        hottest_point=(i * grid.spacing[0], j * grid.spacing[1]),
    )


class _Source:
    """A source in units of the pixel along x; temperatures are κT."""

    def __init__(self, flux: Vector, pair: tuple[Axis, Axis], depth: float, end: float):
        self.flux, self.axes, self.depth, self.end = flux, pair, depth, end

    def means(self) -> Vector:
        """Mean over each pixel."""
        x, y = self.axes
        (field,) = self._fields([(replace(x, averaged=True), replace(y, averaged=True))])
        return field

    def hottest(self) -> tuple[float, Place]:
        """Highest temperature and its place: of four points of each pixel, then along the axes of sliding."""
        (x, y), best = self.axes, (-math.inf, (0.0, 0.0))
        shifts = list(product(*((0.0, _trailing_point(axis)) for axis in (x, y))))
        fields = self._fields([(replace(x, shift=sx), replace(y, shift=sy)) for sx, sy in shifts])
        for field, (sx, sy) in zip(fields, shifts, strict=True):
            i, j = np.unravel_index(int(field.argmax()), field.shape)
            best = max(best, (float(field[i, j]), (float(i) + sx, float(j) + sy)))
        fast = [k for k, axis in enumerate(self.axes) if _peclet(axis) > _SLOW]
        for k in fast * len(fast):
            best = max(best, self._climbed(k, best[1]))
        return best

    def _climbed(self, k: int, place: Place) -> tuple[float, Place]:
        """Highest temperature along axis k inside the pixel of `place`: its trailing edge is colder than just ahead.

        The distance from that edge is halved until heat no longer drifts over it, and then a parabola is laid through
        the three points around the best.
        """
        axis, sense = self.axes[k], math.copysign(1.0, self.axes[k].drift)
        pixel = sense * math.floor(sense * place[k] + 0.5)
        halvings = np.arange(0.0, 1.0 + math.ceil(math.log2(10 * _peclet(axis))))

        def point(halving: float) -> tuple[float, Place]:
            position = pixel + sense * (2.0**-halving - 0.5)
            moved = (position, place[1]) if k == 0 else (place[0], position)
            return self._at(moved), moved

        values = [point(float(halving)) for halving in halvings]
        n = min(max(int(np.argmax([value for value, _ in values])), 1), len(values) - 2)
        low, middle, high = (value for value, _ in values[n - 1 : n + 2])
        bend = low - 2 * middle + high
        top = halvings[n] + (low - high) / (2 * bend) if bend < 0.0 else halvings[n]
        return max([*values, point(float(np.clip(top, halvings[0], halvings[-1])))])

    def _at(self, place: Place) -> float:
        pixel = [min(max(math.floor(s + 0.5), 0), axis.count - 1) for s, axis in zip(place, self.axes, strict=True)]
        x, y = (replace(axis, shift=s - i) for axis, s, i in zip(self.axes, place, pixel, strict=True))
        return temperature_at((pixel[0], pixel[1]), self.flux, x, y, depth=self.depth, end=self.end)

    def _fields(self, pairs: list[tuple[Axis, Axis]]) -> Iterator[Vector]:
        """κT at the points that each pair of axes names, from one forward transform."""
        spectra = (axes_spectrum(x, y, self.depth, self.end, "d") for x, y in pairs)
        shape = padded_shape((self.flux.shape[0], self.flux.shape[1]))
        return convolution.convolutions(self.flux, spectra, shape)


def _peclet(axis: Axis) -> float:
    """Péclet number of a pixel."""
    return abs(axis.drift) * axis.size


def _trailing_point(axis: Axis) -> float:
    """A shift to where a pixel that ends the source is hottest: 2 to 5 D/v before its trailing edge."""
    inside = min(0.25, 3 / _peclet(axis)) if _peclet(axis) > _SLOW else 0.0
    return -math.copysign(0.5 - inside, axis.drift)


def _not_negative_field(name: str, value: ArrayLike, grid: Grid) -> Vector:
    field: Vector = real_field(name, value, grid.shape).astype(np.float64)
    if field.min() < 0.0:
        raise ValueError(f"{name} = {field.min():.6g} must not be negative anywhere")
    return field
