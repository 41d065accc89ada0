"""Flash temperature, its gradient and Laplacian, width and slope length of rough contact (Eqs. 4, 7, 9, 25, 26).

Beside them the temperature of the whole surface: its root mean square and its correlation, in closed form too.

The angular integrals are closed, so each quantity is one integral over wavenumber. With s(q) = (π/2) E*² q³ C W:
T_flash = (2/π)(μ|v|/κσ₀) ∫ (s/q) A(v/Dq) dq, T′ the same with s B, ∇²T the same with −s q A, and
T_rms² = (2/π)(μv/κ)² ∫ (s/q²) K(−(v/Dq)²) dq.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from inspect import signature
from math import pi
from typing import Any, NamedTuple, ParamSpec, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from theory.arguments import (
    Array,
    SpectrumLike,
    float_if_scalar,
    in_blocks,
    not_negative_array,
    positive,
    real_array,
)
from theory.directions import angular_integrals, even_integral, odd_integral, square_integral
from theory.hankel import hankel_transform
from theory.persson import StressDensity, Weight, stress_density
from theory.skin import (
    Part,
    Skin,
    ThermalBody,
    body_of,
    direction_mean,
    even_part,
    odd_part,
    square_part,
)
from theory.typed import OfSpeed

__all__ = [
    "angular_integrals",
    "flash_gradient",
    "flash_laplacian",
    "flash_temperature",
    "flash_width",
    "rms_temperature",
    "slope_length",
    "temperature_correlation",
]


P = ParamSpec("P")
Checked = TypeVar("Checked")  # such as a `HeatSource`


class Kernel(NamedTuple):
    """A mean over the directions of sliding: closed, as a function of v/Dq, and the mean of a part of F."""

    closed: Callable[[Array], Array]  # of a bare half-space, times π/2
    part: Part  # of one with a skin, or heated in depth


EVEN = Kernel(even_integral, even_part)
ODD = Kernel(odd_integral, odd_part)
SQUARE = Kernel(square_integral, square_part)


@dataclass(frozen=True, slots=True)
class HeatSource:
    """The heat of a contact that slides: its stress s(q), and checked numbers of the heating."""

    stress: StressDensity
    velocity: Array  # v, m/s, any shape
    pressure: float  # σ₀, Pa
    heating: Array  # μ|v|/κσ₀, the factor of Eqs. (4), (7) and (9), of that shape
    body: ThermalBody

    def integral(self, kernel: Kernel, power: int) -> Array:
        """Return (2/π) ∫ s(q) q^power kernel(v/Dq) dq at each velocity, Pa² m^(−power)."""
        return bracket(self.velocity, self.body, self.stress, kernel, power)

    def mean(self, kernel: Kernel, q: Array) -> Array:
        """Return the mean over directions at wavenumbers of any shape, rad/m, at a single velocity."""
        _, diffusivity, layers = self.body
        if layers is None:
            return 2 / pi * kernel.closed(self.velocity / (diffusivity * q))
        drift = float(self.velocity) / diffusivity
        return direction_mean(q.ravel(), drift, layers, kernel.part).reshape(q.shape)


def heat_source(  # noqa: PLR0913  (load, body, skin and depth of the heat)
    speed: ArrayLike,
    spectrum: SpectrumLike | None = None,
    *,
    nominal_pressure: float,
    friction_coefficient: float,
    conductivity: float,
    diffusivity: float,
    effective_modulus: float | None = None,
    gamma: Weight = 0.45,
    stress_spectrum: SpectrumLike | None = None,
    skin: Skin | None = None,
    heat_depth: float = 0.0,
) -> HeatSource:
    """Check the arguments of every function below, which `flash_temperature` describes."""
    stress = stress_density(spectrum, stress_spectrum, effective_modulus, nominal_pressure, gamma)
    velocity = real_array("speed", speed, "m/s")
    friction = positive("friction_coefficient", friction_coefficient, "1")
    pressure = positive("nominal_pressure", nominal_pressure, "Pa")
    body = body_of(conductivity, diffusivity, skin, heat_depth)
    heating = friction * np.abs(velocity) / (body.conductivity * pressure)
    return HeatSource(stress, velocity, pressure, heating, body)


def formula_of(source: Callable[P, Checked]) -> Callable[[Callable[[Checked], Array]], Any]:
    """Return a decorator that turns a formula of what `source` has checked into a function of its arguments."""

    def decorated(formula: Callable[[Checked], Array]) -> Any:
        @wraps(source)
        def function(*arguments: P.args, **named: P.kwargs) -> Array | float:
            return float_if_scalar(formula(source(*arguments, **named)))

        function.__name__ = function.__qualname__ = formula.__name__
        function.__doc__ = formula.__doc__
        shown = signature(source).replace(return_annotation=Array | float)
        function.__dict__["__signature__"] = shown
        return function

    return decorated


_of_speed: Callable[[Callable[[HeatSource], Array]], OfSpeed] = formula_of(heat_source)


@_of_speed
def flash_temperature(source: HeatSource) -> Array:
    """Weighted average flash temperature T_flash = ⟨Tσ⟩/⟨σ⟩ with all the heat in the body. Eq. (4).

    Parameters
    ----------
    speed : array_like
        v, m/s, of either sign and any shape.
    spectrum : callable
        C(q), m⁴, with `breaks`.
    nominal_pressure : float
        σ₀, Pa.
    friction_coefficient : float
        μ, dimensionless, > 0.
    conductivity, diffusivity : float
        κ in W/(m K) and D in m²/s of the body whose temperature is computed.
    effective_modulus : float
        E*, Pa. Not used with `stress_spectrum`.
    gamma : float or callable
        γ of W = P[γ + (1 − γ)P²], from 0 to 1, or a weight W(P, q). Not used with `stress_spectrum`.
    stress_spectrum : callable, optional
        |σ_q|², Pa² m², with `breaks`, in place of `spectrum`: g_σ(0) = 2π ∫ q |σ_q|² dq.
    skin : three floats, optional
        A layer on the body: thickness, m, conductivity, W/(m K), and diffusivity, m²/s, such as a `roughsim.Skin`.
    heat_depth : float
        Depth h, m, ≥ 0, in which the heat is released, with the density q̇ e^(−z/h)/h; 0 is the surface.

    Returns
    -------
    ndarray or float
        K above the background, ≥ 0, the shape of `speed`; a float for one speed. 0 at rest.

    Raises
    ------
    TypeError, ValueError
        If an argument is not real, finite and of the right sign, or both spectra or none are given.
    theory.quadrature.QuadratureError
        If an integral does not reach its accuracy, 1e-11.
    """
    return source.heating * source.integral(EVEN, -1)


@_of_speed
def flash_gradient(source: HeatSource) -> Array:
    """Weighted slope T′_flash = ⟨∂ₓT σ⟩/⟨σ⟩ along x, K/m. Eq. (7).

    Negative for a speed > 0, as the body is hotter behind the contact; positive for a speed < 0, 0 at rest.

    Parameters
    ----------
    speed, spectrum, stress_spectrum, nominal_pressure, effective_modulus, gamma
        Velocity and load, as in `flash_temperature`.
    friction_coefficient, conductivity, diffusivity, skin, heat_depth
        The body and its heat, as in `flash_temperature`.

    Returns
    -------
    ndarray or float
        T′ in K/m, the shape of `speed`; a float for one speed.

    Raises
    ------
    TypeError, ValueError, theory.quadrature.QuadratureError
        As `flash_temperature`.
    """
    return source.heating * source.integral(ODD, 0)


@_of_speed
def flash_laplacian(source: HeatSource) -> Array:
    """Weighted Laplacian in the plane ∇²T_flash = ⟨∇²T σ⟩/⟨σ⟩ ≤ 0, K/m². Eq. (9).

    Parameters
    ----------
    speed, spectrum, stress_spectrum, nominal_pressure, effective_modulus, gamma
        Velocity and load, as in `flash_temperature`.
    friction_coefficient, conductivity, diffusivity, skin, heat_depth
        The body and its heat, as in `flash_temperature`.

    Returns
    -------
    ndarray or float
        ∇²T in K/m², the shape of `speed`; a float for one speed.

    Raises
    ------
    TypeError, ValueError, theory.quadrature.QuadratureError
        As `flash_temperature`.
    """
    return -source.heating * source.integral(EVEN, 1)


@_of_speed
def flash_width(source: HeatSource) -> Array:
    """Width of the hot spots D_flash = √(−T_flash/∇²T_flash), m; at rest its limit for v → 0. Eq. (25).

    Parameters
    ----------
    speed, spectrum, stress_spectrum, nominal_pressure, effective_modulus, gamma
        Velocity and load, as in `flash_temperature`.
    friction_coefficient, conductivity, diffusivity, skin, heat_depth
        The body and its heat, as in `flash_temperature`.

    Returns
    -------
    ndarray or float
        D_flash in m, the shape of `speed`; a float for one speed. μ and κ cancel.

    Raises
    ------
    TypeError, ValueError, theory.quadrature.QuadratureError
        As `flash_temperature`, or the stress is uniform.
    """
    curvature = _defined(source.integral(EVEN, 1))
    return np.sqrt(source.integral(EVEN, -1) / curvature)


@_of_speed
def slope_length(source: HeatSource) -> Array:
    """Slope length d_flash = T_flash/|T′_flash|, m: 4D/|v| for v → 0, ∞ at rest. Eq. (26).

    Parameters
    ----------
    speed, spectrum, stress_spectrum, nominal_pressure, effective_modulus, gamma
        Velocity and load, as in `flash_temperature`.
    friction_coefficient, conductivity, diffusivity, skin, heat_depth
        The body and its heat, as in `flash_temperature`.

    Returns
    -------
    ndarray or float
        d_flash in m, the shape of `speed`; a float for one speed. μ and κ cancel.

    Raises
    ------
    TypeError, ValueError, theory.quadrature.QuadratureError
        As `flash_temperature`, or the stress is uniform.
    """
    temperature = _defined(source.integral(EVEN, -1))
    with np.errstate(divide="ignore"):
        return temperature / np.abs(source.integral(ODD, 0))


@_of_speed
def rms_temperature(source: HeatSource) -> Array:
    """Root mean square T_rms = √⟨T²⟩ of the temperature over the whole surface, about its mean, K; 0 at rest.

    Of one wave T_q = μvσ_q/(κ √(q² − iq_x v/D)). Its square, averaged over the directions of sliding, is
    ⟨|T_q|²⟩ = (μv/κq)² |σ_q|² (2/π) K(−a²) with a = v/Dq and K of the parameter m = −a², so that
    T_rms² = 2π ∫ q ⟨|T_q|²⟩ dq. Isotropic roughness has the same T_rms in each direction.

    Parameters
    ----------
    speed, spectrum, stress_spectrum, nominal_pressure, effective_modulus, gamma
        Velocity and load, as in `flash_temperature`.
    friction_coefficient, conductivity, diffusivity, skin, heat_depth
        The body and its heat, as in `flash_temperature`.

    Returns
    -------
    ndarray or float
        T_rms in K, the shape of `speed`; a float for one speed. Without `spectrum` the nominal
        pressure does not enter.

    Raises
    ------
    TypeError, ValueError, theory.quadrature.QuadratureError
        As `flash_temperature`.
    """
    rate = source.pressure * source.heating
    return rate * np.sqrt(source.integral(SQUARE, -2))


def temperature_correlation(  # noqa: PLR0913  (load, body, skin and depth of the heat)
    r: ArrayLike,
    speed: float,
    spectrum: SpectrumLike | None = None,
    *,
    nominal_pressure: float,
    friction_coefficient: float,
    conductivity: float,
    diffusivity: float,
    effective_modulus: float | None = None,
    gamma: Weight = 0.45,
    stress_spectrum: SpectrumLike | None = None,
    skin: Skin | None = None,
    heat_depth: float = 0.0,
) -> Array:
    """Temperature correlation ⟨T(x)T(x′)⟩ over the whole surface, without its mean, averaged over directions.

    2π ∫ q ⟨|T_q|²⟩ J₀(qr) dq with ⟨|T_q|²⟩ of `rms_temperature`, at the distance r of x and x′. The temperature has
    tracks along the direction of sliding; this is the mean over all directions of x − x′.

    Parameters
    ----------
    r : array_like
        Distances ≥ 0 of any shape, m.
    speed : float
        One speed of either sign, m/s.
    spectrum, stress_spectrum, nominal_pressure, effective_modulus, gamma
        The load, as in `flash_temperature`.
    friction_coefficient, conductivity, diffusivity, skin, heat_depth
        The body and its heat, as in `flash_temperature`.

    Returns
    -------
    ndarray
        K², the shape of `r`; T_rms² at r = 0.

    Raises
    ------
    TypeError, ValueError, theory.quadrature.QuadratureError
        As `flash_temperature`, also if the integral with J₀ does not reach its accuracy, 1e-11 of T_rms².
    """
    distance = not_negative_array("r", r, "m")
    source = heat_source(
        speed,
        spectrum,
        nominal_pressure=nominal_pressure,
        friction_coefficient=friction_coefficient,
        conductivity=conductivity,
        diffusivity=diffusivity,
        effective_modulus=effective_modulus,
        gamma=gamma,
        stress_spectrum=stress_spectrum,
        skin=skin,
        heat_depth=heat_depth,
    )
    if source.velocity.ndim:
        raise TypeError(f"speed has shape {source.velocity.shape}; give one speed in m/s")
    rate = source.pressure * source.heating
    stress = source.stress
    q = stress.panels.nodes()[0]
    response = source.mean(SQUARE, q) / q**2
    correlation = hankel_transform(stress.panels, stress.values * response, distance)
    return np.asarray(rate**2 * correlation)


def bracket(
    velocity: Array, body: ThermalBody, stress: StressDensity, kernel: Kernel, power: int
) -> Array:
    """Return (2/π) ∫ s(q) q^power kernel(v/Dq) dq at each checked velocity, Pa² m^(−power)."""
    _, diffusivity, layers = body
    q = stress.wavenumber()
    if layers is None:
        moment = 2 / pi * stress.weighted() * q**power
        return in_blocks(lambda v: kernel.closed(v / (diffusivity * q)) @ moment, velocity)
    moment = stress.weighted() * q**power
    drifts = (velocity / diffusivity).ravel().tolist()
    means = [direction_mean(q, drift, layers, kernel.part) @ moment for drift in drifts]
    return np.array(means).reshape(velocity.shape)


def _defined(integral: Array) -> Array:
    """Return an integral of the stress that is not 0; ValueError otherwise."""
    if (integral == 0.0).any():
        raise ValueError(
            "the stress is uniform (its spectrum is 0), so the flash temperature has no width and no slope; give a "
            "rough surface"
        )
    return integral
