"""Waves of a face with a lay that slides: means over their directions, by quadrature.

The formulas stand in `theory.lay`. Panels of the angle of q⃗′ are dense about the direction in which q·v = 0, and along
the grooves. Of C(q⃗) with harmonics M each has its own mean, which is smooth in ln q′ whatever M is.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import atan2, cos, hypot, pi, sin, sqrt
from typing import NamedTuple, Protocol

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from theory.arguments import Array, SpectrumLike
from theory.picture import FADED, erfc_root, fade, growing
from theory.skin import BodyLayers, along_waves, surface_response
from theory.slope_frame import Directions

Complex = NDArray[np.complex128]
_POINTS, _WEIGHTS = legendre.leggauss(10)  # of a panel of the angle
_ALL = np.linspace(
    pi / 512, pi / 2 - pi / 512, 128
)  # directions of waves; the others are mirror images
_SOONER = 3.0  # oscillations fade at a third of the phase of a picture: sharp ends of C(q) leave 2e-4 open
_FADED = FADED / _SOONER  # rad
_TURN, _TURNS = 8.0, 14  # phase over a panel of q′, rad, and panels of the angle up to `_FADED`
_FAINT = 20.0  # e^(−20) is nothing


class Weighted(Protocol):
    """A stress with a lay, such as `theory.lay.LayStress`."""

    @property
    def stress_spectrum(self) -> SpectrumLike:
        """|σ_q′|², Pa² m², with `breaks`."""

    @property
    def lay(self) -> float:
        """The lay γ."""

    @property
    def directions(self) -> Directions:
        """M(q′, φ) of the waves at their own wavenumbers."""

    @property
    def angle(self) -> float:
        """Of the grooves, rad."""

    def own_share(self, q: Array) -> Array:
        """Return s at q′, rad/m, elementwise."""

    def response(self, q: Array, ratio: Array) -> Array:
        """Return r at q′, rad/m, and the ratio m; arrays that broadcast."""


class Wave(NamedTuple):
    """What a wave of the direction of q′ makes of the heat, over the directions."""

    square: Array  # m²
    along: Array  # q·v/(q′v)
    share: Array  # of the stress, times the width of the node over half a turn
    harmonics: Array  # 1, cos 2φ, sin 2φ, … along a last axis

    def sums(self, parts: Array) -> Array:
        """Return the sums of `parts` (q′, directions) times each harmonic: (q′, harmonics)."""
        return np.asarray((parts[:, None] @ self.harmonics)[:, 0])


Part = Callable[[Wave], Array | Complex]


def temperature(_: Wave) -> Array:
    """Return the part of T."""
    return np.ones(1)


def gradient(wave: Wave) -> Complex:
    """Return the part of ∂T along sliding, over q′."""
    return np.asarray(1j * wave.along)


def laplacian(wave: Wave) -> Array:
    """Return the part of ∇²T, over q′²."""
    return -wave.square


@dataclass(frozen=True, slots=True)
class Face:
    """A face with a lay that slides in one direction over a body."""

    stress: Weighted
    direction: float
    drift: float  # v/D, 1/m
    layers: BodyLayers | None
    part: Part  # of q′κT/q̇ of a wave
    power: float  # of r
    directions: Directions  # M

    @property
    def _velocity(self) -> tuple[float, float]:
        """q·v = q′v·(these two, times cosφ and sinφ)."""
        ux, uy = (
            one if abs(one) > 1e-15 else 0.0 for one in (cos(self.direction), sin(self.direction))
        )
        return ux / sqrt(self.stress.lay), uy * sqrt(self.stress.lay)

    @property
    def _resting(self) -> float:
        """The direction of q′, rad, in which q·v = 0."""
        along, across = self._velocity
        return atan2(-along, across)

    def _wave(self, q: Array, angle: Array, width: Array) -> Wave:
        """Return the waves of q′ (n, 1) at `angle`, rad, from `_resting`, and of some `width` of these angles."""
        lay = self.stress.lay
        square = _square(self._resting + angle, lay)
        mean = np.mean(self._response(q, _square(_ALL, lay)), axis=1, keepdims=True)
        share = self._response(q, square) / mean * width / pi
        harmonics = self.directions.waves(self._resting + angle)
        return Wave(square, hypot(*self._velocity) * np.sin(angle), share, harmonics)

    def _response(self, q: Array, square: Array) -> Array:
        return self.stress.response(q, np.sqrt(square)) ** self.power

    def mean(self, q: Array) -> Array:
        """Return the mean of the part over directions, steady, at q′ (n,), times each harmonic: (n, harmonics)."""
        layers, waves = self.layers, q[:, None]
        steep = abs(self.drift) / float(q.min())
        wave = self._wave(
            waves, *self._nodes(steep * (max(1.0, layers.diffusion) if layers else 1.0))
        )
        advection = self.drift * waves * wave.along
        length = waves * np.sqrt(wave.square)
        if layers is None:
            root: Complex = np.sqrt(length**2 - 1j * advection)
            response: Complex = length / root
        else:
            response = surface_response(length, advection, layers)
        mean = (response * self.part(wave) / np.sqrt(wave.square)).real * wave.share
        return wave.sums(mean)

    def _nodes(self, steep: float) -> tuple[Array, Array]:
        """Return angles from `_resting` over half a turn, dense there and along the grooves, and their widths."""
        lay = self.stress.lay
        narrow = float(_square(np.array(self._resting), lay)) / hypot(*self._velocity)
        at_rest = growing(min(1.0, narrow / steep if steep else 1.0), pi / 2)
        grooves = growing(1 / max(lay, 1 / lay), pi / 2)
        grooves = np.append(-grooves, grooves) - self._resting
        turned = (grooves + pi / 2) % pi - pi / 2
        return _panels(np.unique(np.concatenate([-at_rest, at_rest, turned])))

    def missing(self, q: Array, spread: float) -> Array:
        """Return what the start from rest, since which D t is `spread`, takes off `mean` at q′ (n,), which rise.

        It is of long waves, which heat the body deeper than its layers.
        """
        phase = q * hypot(*self._velocity) * abs(self.drift) * spread  # q·v t, the most
        block = np.floor(np.log(np.minimum(phase, _TURN)))
        block += np.floor(np.clip(phase, _TURN, _FADED) / _TURN)
        block += np.floor(np.log(np.maximum(phase, _FADED)))
        late = np.zeros((q.size, self.directions.at(q[:1]).shape[1]))
        lay = max(self.stress.lay, 1 / self.stress.lay)
        for at in np.split(np.arange(q.size), np.flatnonzero(np.diff(block)) + 1):
            if q[at[0]] ** 2 * spread < _FAINT * lay:
                late[at] = along_waves(q[at], partial(self._late, spread=spread))
        return late

    def _late(self, q: Array, spread: float) -> Array:
        turned = abs(self.drift) * spread * q[:, None]
        last = np.arcsin(np.minimum(_FADED / (hypot(*self._velocity) * turned), 1.0))
        half = np.append(growing(1e-6, 1 / _TURNS)[:-1], np.linspace(1 / _TURNS, 1.0, _TURNS))
        angle, width = _panels(np.append(-half[:0:-1], half))
        wave = self._wave(q[:, None], last * angle, last * width)
        square: Complex = np.asarray(wave.square - 1j * (self.drift * wave.along / q[:, None]))
        late: Complex = erfc_root((q[:, None] ** 2 * spread) * square) / np.sqrt(square)
        late *= fade(np.abs(wave.along) * turned * _SOONER)
        return wave.sums((late * self.part(wave)).real * wave.share)


def _square(angle: Array, lay: float) -> Array:
    """Return m² in the directions `angle` of q′, rad from the grooves."""
    return np.asarray(np.cos(angle) ** 2 / lay + lay * np.sin(angle) ** 2)


def _panels(edges: Array) -> tuple[Array, Array]:
    """Return nodes and weights of Gauss panels between edges."""
    half = np.diff(edges)[:, None] / 2
    return (edges[:-1, None] + half * (1 + _POINTS)).ravel(), (half * _WEIGHTS).ravel()
