"""The frame in which a face whose C(q⃗) has directions is as steep in all of them.

The slope tensor ⟨∂h ∂h⟩ has the eigenvalues a ≥ b, along and across the steepest direction, to which the grooves are
normal. With γ = √(a/b) and q⃗ = (q′_x/√γ, q′_y √γ), x along the grooves, the rms slope is the same in all directions
of q′. There

    C(q⃗) = C′(q′) M(q′, φ),    M = 1 + Σ a_n(q′) cos 2nφ + b_n(q′) sin 2nφ,

with C′ the mean over the directions φ of q⃗′. A face with one lay has M = 1.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import atan2, cosh, hypot, log, pi, sinh, sqrt
from typing import Protocol

import numpy as np

from theory.arguments import Array, breaks_of, kept_for_values
from theory.quadrature import WEIGHTS, panels_between

_ANGLES = 180  # over half a turn
_PER_DECADE = 40  # rows of C′ and M
_MOST = 24  # harmonics: maps are smoothed over 4°
_FAINT = 1e-4  # of the largest C′ q′⁴, and of the mean: less is nothing


class DirectedSpectrum(Protocol):
    """C(q), m⁴, the mean over directions, with its `breaks`, and C(q⃗)."""

    @property
    def breaks(self) -> Sequence[float]:
        """Ends, kinks and jumps, rad/m, ascending."""

    def __call__(self, q: Array, /) -> Array:
        """Return C(q) at wavenumbers, rad/m."""

    def at(self, q: Array, angle: Array) -> Array:
        """Return C(q⃗) at wavenumbers, rad/m, and angles, radians from x; arrays that broadcast."""


@dataclass(frozen=True, slots=True)
class Directions:
    """M(q′, φ) by its harmonics, linear in ln q′ between rows; without rows it is 1."""

    log_q: tuple[float, ...] = ()
    rows: tuple[tuple[float, ...], ...] = ()  # a₁, b₁, a₂, …

    @property
    def _order(self) -> int:
        return len(self.rows[0]) // 2 if self.rows else 0

    def at(self, q: Array) -> Array:
        """Return 1, a₁, b₁, … at wavenumbers q′ (n,), rad/m, shape (n, harmonics)."""
        result = np.ones((q.size, 1 + 2 * self._order))
        for k, column in enumerate(zip(*self.rows, strict=True), start=1):
            result[:, k] = np.interp(np.log(q), self.log_q, column)
        return result

    def waves(self, angle: Array) -> Array:
        """Return 1, cos 2φ, sin 2φ, … at angles φ of q⃗′, radians from the grooves, along a last axis."""
        turned = 2 * np.arange(1, 1 + self._order) * angle[..., None]
        both = np.stack([np.cos(turned), np.sin(turned)], axis=-1).reshape(*angle.shape, -1)
        return np.concatenate([np.ones((*angle.shape, 1)), both], axis=-1)


ISOTROPIC = Directions()


@dataclass(frozen=True, slots=True)
class MeanSpectrum:
    """C′(q′), m⁴: a power law between rows."""

    log_q: tuple[float, ...]
    log_level: tuple[float, ...]

    @property
    def breaks(self) -> tuple[float, ...]:
        """The rows, rad/m."""
        return tuple(np.exp(self.log_q).tolist())

    def __call__(self, q: Array) -> Array:
        """Return C′ at wavenumbers q′, rad/m."""
        inside = (q >= self.breaks[0]) & (q <= self.breaks[-1])
        level = np.exp(np.interp(np.log(np.maximum(q, 1e-300)), self.log_q, self.log_level))
        return np.where(inside, level, 0.0)


@dataclass(frozen=True, slots=True)
class SlopeFrame:
    """The stretched frame of a face."""

    lay: float  # γ ≥ 1
    angle: float  # of the grooves, radians from x
    spectrum: MeanSpectrum
    directions: Directions

    @property
    def softer(self) -> float:
        """f, by which light contact is softer than by γ alone: the mean of √[½ + √(ab)/(a + b)] of each q′."""
        q, level = np.exp(self.spectrum.log_q), np.exp(self.spectrum.log_level)
        waves = self.directions.at(q)
        if waves.shape[1] == 1:
            return 1.0
        uneven = np.minimum(np.hypot(waves[:, 1], waves[:, 2]) / 2, 1.0)  # (a − b)/(a + b)
        weight = q**4 * level  # rows are even in ln q′
        return float(weight @ np.sqrt((1 + np.sqrt(1 - uneven**2)) / 2) / weight.sum())


@kept_for_values  # .02 s for each quantity
def slope_frame(spectrum: DirectedSpectrum) -> SlopeFrame:
    """Return the frame in which a face with C(q⃗) is as steep in all directions."""
    q, slope = panels_between(breaks_of(spectrum)).nodes()
    angle: Array = np.arange(_ANGLES, dtype=np.float64) * (pi / _ANGLES)
    wave = np.stack([np.ones(_ANGLES), np.cos(2 * angle), np.sin(2 * angle)])
    weight = (q**3 * slope * WEIGHTS).ravel()
    whole, even, odd = wave @ (weight @ spectrum.at(q.ravel()[:, None], angle))
    turned = hypot(even, odd)
    lay, grooves = sqrt((whole + turned) / (whole - turned)), atan2(-odd, -even) / 2
    ends = np.log(breaks_of(spectrum))
    wide = np.concatenate([ends - log(lay) / 2, ends, ends + log(lay) / 2])[[0, -1]]
    count = 2 + round(_PER_DECADE * np.ptp(wide) / log(10.0))
    rows: Array = np.linspace(wide[0], wide[1], count)
    # |q|²/|q′|² = cosh ln γ − sinh ln γ cos 2φ
    stretch = np.sqrt(cosh(log(lay)) - sinh(log(lay)) * np.cos(2 * angle))
    true = grooves + np.arctan2(lay * np.sin(angle), np.cos(angle))
    level = spectrum.at(np.exp(rows)[:, None] * stretch, true)
    mean = level.mean(axis=1)
    steep = mean * np.exp(4 * rows)
    first, last = np.flatnonzero(steep > _FAINT**2 * steep.max())[[0, -1]]
    rows, level, mean = (each[first : last + 1] for each in (rows, level, mean))
    mean = np.maximum(mean, np.finfo(float).tiny)
    waves = np.fft.rfft(level / mean[:, None], axis=1)[:, 1 : 1 + _MOST] * (2 / _ANGLES)
    large = np.flatnonzero(np.abs(waves).max(axis=0) > _FAINT)
    waves = waves[:, : 1 + int(large.max(initial=-1))]
    both = np.stack([waves.real, -waves.imag], axis=2).reshape(rows.size, -1)
    table = tuple(rows.tolist())
    return SlopeFrame(
        lay,
        grooves,
        MeanSpectrum(table, tuple(np.log(mean).tolist())),
        Directions(table, tuple(map(tuple, both.tolist()))) if waves.size else ISOTROPIC,
    )
