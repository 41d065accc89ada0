"""Flash temperature of a rough face with a lay, such as a ground one, in each direction of sliding.

A lay γ stretches isotropic roughness: its heights at (x√γ, y/√γ) are those of an isotropic face at (x, y), with x along
the grooves. So C(q) is that of the isotropic face at q′ = (q_x√γ, q_y/√γ), and with φ the direction of q′

    |q|/|q′| = m(φ) = √(cos²φ/γ + γ sin²φ).

In the stretched frame contact is taken to be isotropic. Its modulus is E* times a mean of m over directions: the
geometric one, e₀ = (√γ + 1/√γ)/2, of light contact, and the quadratic one, e₂ = √((γ + 1/γ)/2), of full contact,

    E_eff = E*[e₀ + (e₂ − e₀) sin(πA_el/2A₀)].

A wave meets the half-space and, in series, the interface of the finer waves, whose compliance ⟨c⟩ is that of
`theory.interface`. So its pressure changes with its direction as r = m/(1 + m⟨c⟩E*q′/2): as m in full contact, and not
at all where all has yielded, as a hardness knows no direction. With the share s of |σ_q′|² that waves make at their own
wavenumber, the rest beside it, the calibrated law with E_eff has in each direction the weight

    w(q′, φ) = s r²/⟨r²⟩ + (1 − s) r^ANSWER/⟨r^ANSWER⟩,    ⟨⟩ the mean over φ.

In the direction θ of sliding, with λ² = q² − iq·v/D,

    T_flash = (μv/κσ₀) ∫ |σ_q′|² w Re[erf√(λ²Dt)/λ] d²q′,   t the time since the start from rest.

Source: docs/lay.md, which compares it with simulations.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import atan2, cos, hypot, inf, log10, pi, sin, sqrt
from typing import NamedTuple, Protocol

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import ArrayLike, NDArray

from theory.arguments import Array, SpectrumLike, positive, real_array
from theory.clipped.field import law_of
from theory.flash import HeatSource, formula_of, heat_source
from theory.picture import FADED, erfc_root, fade, growing
from theory.scattering import ANSWER
from theory.skin import BodyLayers, Skin, along_waves, steady_rise, surface_response
from theory.yielding import YieldingSpectrum

__all__ = [
    "LayStress",
    "error_band",
    "flash_gradient",
    "flash_laplacian",
    "flash_temperature",
    "stress_of_lay",
]

Complex = NDArray[np.complex128]
_POINTS, _WEIGHTS = legendre.leggauss(10)  # of a panel of the angle
_ALL = np.linspace(
    pi / 512, pi / 2 - pi / 512, 128
)  # directions of waves; the others are mirror images
_BAND = 0.06  # at γ = 10; 95 % of 324 departures of T_flash from simulations, beside those of their isotropic twins
_ACCURACY = 1e-5  # of the mean of m in E_eff
_SOONER = 3.0  # oscillations fade at a third of the phase of a picture: sharp ends of C(q) leave 2e-4 open
_FADED = FADED / _SOONER  # rad
_TURN, _TURNS = 8.0, 14  # phase over a panel of q′, rad, and panels of the angle up to `_FADED`
_FAINT = 20.0  # e^(−20) is nothing


class Weighted(Protocol):
    """A stress with a lay, such as `LayStress`."""

    @property
    def stress_spectrum(self) -> SpectrumLike:
        """|σ_q′|², Pa² m², with `breaks`."""

    @property
    def lay(self) -> float:
        """The lay γ."""

    def own_share(self, q: Array) -> Array:
        """Return s at q′, rad/m, elementwise."""

    def response(self, q: Array, ratio: Array) -> Array:
        """Return r at q′, rad/m, and the ratio m; arrays that broadcast."""


@dataclass(frozen=True, slots=True)
class LayStress:
    """The stress of a face with a lay, by the calibrated law.

    Parameters
    ----------
    stress_spectrum : callable
        |σ_q′|² of isotropic contact in the stretched frame, Pa² m², with `breaks` and the areas of contact.
    lay : float
        γ, the correlation length along the grooves over that across.
    effective_modulus : float
        E*, Pa: that of `stress_spectrum` is E_eff.
    """

    stress_spectrum: YieldingSpectrum
    lay: float
    effective_modulus: float

    def own_share(self, q: Array) -> Array:
        """Return the share s of |σ_q′|² that waves make at their own wavenumbers `q`, rad/m."""
        return self.stress_spectrum.own_share(q)

    def response(self, q: Array, ratio: Array) -> Array:
        """Return r of waves of `q`′, rad/m, whose true wavenumber is `ratio` times as large."""
        series = self.stress_spectrum.compliance(q) * self.effective_modulus * q / 2
        return np.asarray(ratio / (1 + ratio * series))


def stiffening(lay: float, elastic_fraction: float) -> float:
    """Return E_eff/E* of contact whose share A_el/A₀ of the nominal area is elastic."""
    light = (sqrt(lay) + 1 / sqrt(lay)) / 2
    full = sqrt((lay + 1 / lay) / 2)
    return light + (full - light) * sin(pi / 2 * elastic_fraction)


def error_band(lay: float, isotropic: float) -> float:
    """Return the relative error, 95 %, of T_flash of a face with a `lay` γ, beside that of the `isotropic` law."""
    return hypot(isotropic, _BAND * log10(lay))


def stress_of_lay(
    spectrum: SpectrumLike,
    lay: float,
    *,
    effective_modulus: float,
    nominal_pressure: float,
    penetration_hardness: float | None = None,
) -> LayStress:
    """Stress of contact of a face with a lay, by the calibrated law in the stretched frame.

    Parameters
    ----------
    spectrum : callable
        C(q′) of the isotropic face that is stretched, m⁴, with `breaks`: that of the face itself has its ⟨h²⟩.
    lay : float
        γ ≥ 1, the correlation length along the grooves over that across.
    effective_modulus, nominal_pressure, penetration_hardness : float
        E*, σ₀ and σ_P, Pa; without σ_P contact is elastic.

    Returns
    -------
    LayStress
        Its `stress_spectrum` has the areas A/A₀ and A_pl/A₀. γ = 1 is the isotropic law.

    Raises
    ------
    TypeError, ValueError
        As `theory.plasticity.stress_spectrum`, or γ < 1.
    """
    ratio = positive("lay", lay, "1")
    if ratio < 1.0:
        raise ValueError(
            f"lay = {ratio:.6g} must be 1 or more: it is along over across the grooves"
        )
    modulus = positive("effective_modulus", effective_modulus, "Pa")

    def law(stretched: float) -> YieldingSpectrum:
        return law_of(
            spectrum,
            effective_modulus=stretched,
            nominal_pressure=nominal_pressure,
            penetration_hardness=penetration_hardness,
        )

    return LayStress(in_stretched_frame(law, ratio, modulus), ratio, modulus)


def in_stretched_frame(
    law: Callable[[float], YieldingSpectrum], lay: float, modulus: float
) -> YieldingSpectrum:
    """Return the `law` of a modulus, Pa, at the E_eff that its own contact of a face with a `lay` γ has."""
    factor, last = stiffening(lay, 0.0), inf
    while True:  # A_el falls with E_eff, by little
        stress = law(factor * modulus)
        following = stiffening(lay, stress.contact_fraction - stress.plastic_fraction)
        change = abs(following - factor)
        if change <= _ACCURACY * factor or change >= last:
            return stress
        factor, last = following, change


class _Wave(NamedTuple):
    """What a wave of the direction of q′ makes of the heat, over the directions."""

    square: Array  # m²
    along: Array  # q·v/(q′v)
    share: Array  # of the stress, times the width of the node over half a turn


Part = Callable[[_Wave], Array | Complex]


def _temperature(_: _Wave) -> Array:
    return np.ones(1)


def _gradient(wave: _Wave) -> Complex:
    return np.asarray(1j * wave.along)


def _laplacian(wave: _Wave) -> Array:
    return -wave.square


@dataclass(frozen=True, slots=True)
class _Face:
    """A face with a lay that slides in one direction over a body."""

    stress: Weighted
    direction: float
    drift: float  # v/D, 1/m
    layers: BodyLayers | None
    part: Part  # of q′κT/q̇ of a wave
    power: float  # of r

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

    def _wave(self, q: Array, angle: Array, width: Array) -> _Wave:
        """Return the waves of q′ (n, 1) at `angle`, rad, from `_resting`, and of some `width` of these angles."""
        lay = self.stress.lay
        square = _square(self._resting + angle, lay)
        mean = np.mean(self._response(q, _square(_ALL, lay)), axis=1, keepdims=True)
        share = self._response(q, square) / mean * width / pi
        return _Wave(square, hypot(*self._velocity) * np.sin(angle), share)

    def _response(self, q: Array, square: Array) -> Array:
        return self.stress.response(q, np.sqrt(square)) ** self.power

    def mean(self, q: Array) -> Array:
        """Return the mean of the part over directions, steady, at q′ (n,)."""
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
        return np.asarray(mean.sum(axis=1))

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
        """Return what the start from rest, since which D t is `spread`, takes off `mean` at q′ (n,), rising.

        It is of long waves, which heat the body deeper than its layers.
        """
        phase = q * hypot(*self._velocity) * abs(self.drift) * spread  # q·v t, the most
        block = np.floor(np.log(np.minimum(phase, _TURN)))
        block += np.floor(np.clip(phase, _TURN, _FADED) / _TURN)
        block += np.floor(np.log(np.maximum(phase, _FADED)))
        late, lay = np.zeros(q.size), max(self.stress.lay, 1 / self.stress.lay)
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
        return np.asarray(((late * self.part(wave)).real * wave.share).sum(axis=1))


def _square(angle: Array, lay: float) -> Array:
    """Return m² in the directions `angle` of q′, rad from the grooves."""
    return np.asarray(np.cos(angle) ** 2 / lay + lay * np.sin(angle) ** 2)


def _panels(edges: Array) -> tuple[Array, Array]:
    """Return nodes and weights of Gauss panels between edges."""
    half = np.diff(edges)[:, None] / 2
    return (edges[:-1, None] + half * (1 + _POINTS)).ravel(), (half * _WEIGHTS).ravel()


class _Sliding(NamedTuple):
    """Faces with a lay that slide; arrays of one shape, that of the result."""

    source: HeatSource
    stress: Weighted
    directions: list[float]
    drifts: list[float]
    spreads: list[float]  # D t since the start from rest, m², ∞ of steady sliding

    def integral(self, part: Part, power: int) -> Array:
        """Return ∫ s(q′) q′^power ⟨part⟩ dq′, the mean over directions, times the factor of the heating."""
        source, stress = self.source, self.stress
        q, moment = source.stress.wavenumber(), source.stress.weighted()
        own, found = stress.own_share(q), []
        for one in zip(self.directions, self.drifts, self.spreads, strict=True):
            total = 0.0
            for share, exponent in ((own, 2.0), (1 - own, ANSWER)):
                face = _Face(stress, *one[:2], source.body.layers, part, exponent)
                mean = along_waves(q, face.mean)
                if one[2] < inf:
                    mean = mean - face.missing(q, one[2])
                total += float(moment * share * q**power @ mean)
            found.append(total)
        return np.asarray(source.heating * np.reshape(found, source.velocity.shape))


def _sliding(
    speed: ArrayLike,
    direction: ArrayLike,
    stress: Weighted,
    *,
    nominal_pressure: float,
    friction_coefficient: float,
    conductivity: float,
    diffusivity: float,
    skin: Skin | None = None,
    heat_depth: float = 0.0,
    slid_distance: ArrayLike = inf,
) -> _Sliding:
    """Check the arguments of the functions below, which `flash_temperature` describes."""
    angle = real_array("direction", direction, "rad")
    distance = np.asarray(slid_distance, dtype=np.float64)
    if not (distance > 0.0).all():
        raise ValueError(
            f"slid_distance = {distance.min():.6g} m must be positive; ∞ is steady sliding"
        )
    velocity = real_array("speed", speed, "m/s")
    velocity, angle, distance = np.broadcast_arrays(velocity, angle, distance)
    source = heat_source(
        velocity,
        stress_spectrum=stress.stress_spectrum,
        nominal_pressure=nominal_pressure,
        friction_coefficient=friction_coefficient,
        conductivity=conductivity,
        diffusivity=diffusivity,
        skin=skin,
        heat_depth=heat_depth,
    )
    _, diffusion, layers = source.body
    drifts = (velocity / diffusion).ravel().tolist()
    spreads = [
        one / abs(drift) if drift else inf
        for one, drift in zip(distance.ravel().tolist(), drifts, strict=True)
    ]
    for spread in spreads:
        if layers is not None and spread < inf:
            steady_rise(layers, spread, "slid_distance")  # refuses a start not long ago
    return _Sliding(source, stress, angle.ravel().tolist(), drifts, spreads)


@formula_of(_sliding)
def flash_temperature(sliding: _Sliding) -> Array:
    """Weighted average flash temperature of a face with a lay in each direction, with all the heat in the body.

    Parameters
    ----------
    speed : array_like
        v, m/s, of either sign.
    direction : array_like
        Angle θ of sliding, rad, from the grooves: 0 is along, π/2 across them; θ, −θ and θ + π are the same.
    stress : LayStress
        From `stress_of_lay`.
    nominal_pressure, friction_coefficient, conductivity, diffusivity, skin, heat_depth
        σ₀ and the body and its heat, as in `theory.flash.flash_temperature`.
    slid_distance : array_like
        Distance slid since the start from rest, m, > 0. ∞ is steady sliding. Of a body with layers the start must be
        so long ago that heat has spread five times as deep as they reach.

    Returns
    -------
    ndarray or float
        K above the background, the shape to which speed, direction and distance broadcast: columns of directions and
        rows of speeds make an array (directions, speeds).

    Raises
    ------
    TypeError, ValueError, theory.quadrature.QuadratureError
        As `theory.flash.flash_temperature`.
    """
    return sliding.integral(_temperature, -1)


@formula_of(_sliding)
def flash_gradient(sliding: _Sliding) -> Array:
    """Weighted slope T′_flash = ⟨∂T σ⟩/⟨σ⟩ along the direction of sliding, K/m; arguments as `flash_temperature`."""
    return sliding.integral(_gradient, 0)


@formula_of(_sliding)
def flash_laplacian(sliding: _Sliding) -> Array:
    """Weighted Laplacian in the plane ∇²T_flash ≤ 0, K/m²; arguments as `flash_temperature`."""
    return sliding.integral(_laplacian, 1)
