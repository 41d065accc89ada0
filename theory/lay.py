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

A face whose waves have lays of their own, such as a scan, has this law in the frame of `theory.slope_frame`. There the
first part has the weight M(q′, φ) r²/⟨r²⟩, e₀ is f times as large, and in full contact all is exact.

In the direction θ of sliding, with λ² = q² − iq·v/D,

    T_flash = (μv/κσ₀) ∫ |σ_q′|² w Re[erf√(λ²Dt)/λ] d²q′,   t the time since the start from rest.

Source: docs/lay.md, which compares it with simulations.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import hypot, inf, log10, pi, sin, sqrt
from typing import NamedTuple, Protocol, Unpack, overload

import numpy as np
from numpy.typing import ArrayLike

from theory.arguments import Array, SpectrumLike, breaks_of, positive, real_array
from theory.clipped.field import law_of
from theory.flash import HeatSource, formula_of, heat_source
from theory.lay_waves import Face, Part, Weighted, gradient, laplacian, temperature
from theory.scattering import ANSWER
from theory.skin import Skin, along_waves, steady_rise
from theory.slope_frame import ISOTROPIC, DirectedSpectrum, Directions, slope_frame
from theory.typed import Body
from theory.validity import UpTo
from theory.yielding import YieldingSpectrum

__all__ = [
    "LayStress",
    "error_band",
    "flash_gradient",
    "flash_laplacian",
    "flash_temperature",
    "stress_of_lay",
    "stress_of_waves",
]

_BAND = 0.06  # at γ = 10; 95 % of 324 departures of T_flash from simulations, beside those of their isotropic twins
# 138 of 144 departures of T_flash from simulations of 18 faces are inside, rms 3.4 %, worst +13 %; isotropic rms 17 %
_OF_WAVES = 0.09
_ACCURACY = 1e-5  # of the mean of m in E_eff


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
    directions : Directions
        M(q′, φ); 1 of a face with one lay.
    angle : float
        Of the grooves, rad, from the axis from which directions of sliding count.
    """

    stress_spectrum: YieldingSpectrum
    lay: float
    effective_modulus: float
    directions: Directions = ISOTROPIC
    angle: float = 0.0

    def own_share(self, q: Array) -> Array:
        """Return the share s of |σ_q′|² that waves make at their own wavenumbers `q`, rad/m."""
        return self.stress_spectrum.own_share(q)

    def response(self, q: Array, ratio: Array) -> Array:
        """Return r of waves of `q`′, rad/m, whose true wavenumber is `ratio` times as large."""
        series = self.stress_spectrum.compliance(q) * self.effective_modulus * q / 2
        return np.asarray(ratio / (1 + ratio * series))


def stiffening(lay: float, elastic_fraction: float, softer: float = 1.0) -> float:
    """Return E_eff/E* of contact whose share A_el/A₀ of the nominal area is elastic; `softer` is f of light contact."""
    light = softer * (sqrt(lay) + 1 / sqrt(lay)) / 2
    full = sqrt((lay + 1 / lay) / 2)
    return light + (full - light) * sin(pi / 2 * elastic_fraction)


def error_band(lay: float, isotropic: float, *, own_lays: bool = False) -> float:
    """Return the relative error, 95 %, of T_flash of a face with a `lay` γ, beside that of the `isotropic` law.

    `own_lays` is whether its waves have lays of their own, by `stress_of_waves`.
    """
    return hypot(isotropic, _BAND * log10(lay), _OF_WAVES * own_lays)


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
    law: Callable[[float], YieldingSpectrum], lay: float, modulus: float, softer: float = 1.0
) -> YieldingSpectrum:
    """Return the `law` of a modulus, Pa, at the E_eff that its own contact of a face with a `lay` γ has.

    `softer` is f of light contact.
    """
    factor, last = stiffening(lay, 0.0, softer), inf
    while True:  # A_el falls with E_eff, by little
        stress = law(factor * modulus)
        following = stiffening(lay, stress.between_walls()[0], softer)
        change = abs(following - factor)
        if change <= _ACCURACY * factor or change >= last:
            return stress
        factor, last = following, change


def stress_of_waves(
    spectrum: DirectedSpectrum,
    *,
    effective_modulus: float,
    nominal_pressure: float,
    penetration_hardness: float | None = None,
) -> LayStress:
    """Stress of contact of a face whose waves have lays of their own, by the calibrated law in its slope frame.

    Parameters
    ----------
    spectrum : DirectedSpectrum
        C(q⃗) of the face, m⁴, and its mean C(q) over directions, whose numbers must lie in the range of the law.
    effective_modulus, nominal_pressure, penetration_hardness : float
        As in `stress_of_lay`; errors, too.
    """
    frame = slope_frame(spectrum)
    modulus = positive("effective_modulus", effective_modulus, "Pa")
    steeper = stiffening(frame.lay, 1.0)

    def law(stretched: float) -> YieldingSpectrum:
        found = law_of(
            spectrum,
            effective_modulus=stretched / steeper,
            nominal_pressure=nominal_pressure,
            penetration_hardness=penetration_hardness,
        )
        end = sqrt(frame.lay) * breaks_of(found.spectrum)[-1]
        return replace(
            found,
            spectrum=UpTo(frame.spectrum, min(end, frame.spectrum.breaks[-1])),
            effective_modulus=stretched,
        )

    stress = in_stretched_frame(law, frame.lay, modulus, frame.softer)
    return LayStress(stress, frame.lay, modulus, frame.directions, frame.angle)


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
            for share, exponent, each in (
                (own, 2.0, stress.directions),
                (1 - own, ANSWER, ISOTROPIC),
            ):
                face = Face(stress, *one[:2], source.body.layers, part, exponent, each)
                mean = along_waves(q, face.mean)
                if one[2] < inf:
                    mean = mean - face.missing(q, one[2])
                total += float(moment * share * q**power @ (mean * each.at(q)).sum(axis=1))
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
    angle = real_array("direction", direction, "rad") - stress.angle
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


class _OfDirection(Protocol):
    @overload
    def __call__(
        self,
        speed: float,
        direction: float,
        stress: Weighted,
        *,
        slid_distance: float = inf,
        **body: Unpack[Body],
    ) -> float: ...
    @overload
    def __call__(
        self,
        speed: ArrayLike,
        direction: ArrayLike,
        stress: Weighted,
        *,
        slid_distance: ArrayLike = inf,
        **body: Unpack[Body],
    ) -> Array | float: ...


_of_direction: Callable[[Callable[[_Sliding], Array]], _OfDirection] = formula_of(_sliding)


@_of_direction
def flash_temperature(sliding: _Sliding) -> Array:
    """Weighted average flash temperature of a face with a lay in each direction, with all the heat in the body.

    Parameters
    ----------
    speed : array_like
        v, m/s, of either sign.
    direction : array_like
        Angle θ of sliding, rad, from the grooves: 0 is along, π/2 across them; θ, −θ and θ + π are the same. By
        `stress_of_waves` from x, and only θ and θ + π are the same.
    stress : LayStress
        From `stress_of_lay` or `stress_of_waves`.
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
    return sliding.integral(temperature, -1)


@_of_direction
def flash_gradient(sliding: _Sliding) -> Array:
    """Weighted slope T′_flash = ⟨∂T σ⟩/⟨σ⟩ along the direction of sliding, K/m; arguments as `flash_temperature`."""
    return sliding.integral(gradient, 0)


@_of_direction
def flash_laplacian(sliding: _Sliding) -> Array:
    """Weighted Laplacian in the plane ∇²T_flash ≤ 0, K/m²; arguments as `flash_temperature`."""
    return sliding.integral(laplacian, 1)
