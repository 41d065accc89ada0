"""Flash temperature, its gradient and Laplacian, width and slope length of rough contact (Eqs. 4, 7, 9, 25, 26).

Beside them the temperature of the whole surface: its root mean square and its correlation, in closed form too.

The angular integrals are closed, so each quantity is one integral over wavenumber. With s(q) = (π/2) E*² q³ C W:
T_flash = (2/π)(μ|v|/κσ₀) ∫ (s/q) A(v/Dq) dq, T′ the same with s B, ∇²T the same with −s q A, and
T_rms² = (2/π)(μv/κ)² ∫ (s/q²) K(−(v/Dq)²) dq.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import pi

import numpy as np
import scipy
from numpy.polynomial.chebyshev import Chebyshev, cheb2poly
from numpy.polynomial.polynomial import polyval
from numpy.typing import ArrayLike

from theory.arguments import Array, Spectrum, float_if_scalar, not_negative_array, positive, real_array
from theory.hankel import hankel_transform
from theory.persson import StressDensity, Weight, stress_density

Kernel = Callable[[Array], Array]

_DEGREE = 24  # K − D has its singularity at m = 1, far from 0 ≤ m ≤ 1/2: the interpolation errs by 6^(−24)
_BLOCK = 64  # speeds at a time: bounds the memory


def _k_less_d() -> Array:
    """Return the coefficients of K(m) − D(m) in powers of 4m − 1: R_D costs ten times as much at each node."""
    interpolant = Chebyshev.interpolate(
        lambda m: scipy.special.ellipk(m) - scipy.special.elliprd(0.0, 1 - m, 1.0) / 3, _DEGREE, domain=[0.0, 0.5]
    )
    return np.asarray(cheb2poly(interpolant.coef))


_K_LESS_D = _k_less_d()


def angular_integrals(a: ArrayLike) -> tuple[Array, Array]:
    """Integrals over the sliding direction in Eqs. (4) and (7), a = v/Dq.

    A = Re ∫₀^{π/2} (1 − ia cos φ)^(−1/2) dφ and B = Re ∫₀^{π/2} i cos φ (1 − ia cos φ)^(−1/2) dφ. With h = √(1 + a²)
    and m = (h − 1)/2h: A = K(m)/√h and B = −a [K(m) − D(m)]/(√h (h + 1)), D = (K − E)/m by Carlson's R_D; no term
    cancels at any a. A is even and falls from π/2 as 1.854 |a|^(−1/2); B is odd, −πa/8 first, then −0.847 |a|^(−1/2).

    Parameters
    ----------
    a : array_like
        v/Dq, dimensionless, finite, of either sign and any shape.

    Returns
    -------
    (A, B) : ndarray, ndarray
        Dimensionless, the shape of `a`.

    Raises
    ------
    TypeError, ValueError
        If `a` is not real and finite.
    """
    ratio = real_array("a", a, "1")
    return even_integral(ratio), odd_integral(ratio)


def even_integral(a: Array) -> Array:
    """Return A of checked ratios a = v/Dq."""
    h = np.hypot(1.0, a)
    return np.asarray(scipy.special.ellipk(_parameter(a, h)) / np.sqrt(h))


def odd_integral(a: Array) -> Array:
    """Return B of checked ratios a = v/Dq."""
    h = np.hypot(1.0, a)
    return np.asarray(-a / (h + 1) * polyval(4 * _parameter(a, h) - 1, _K_LESS_D) / np.sqrt(h))


def square_integral(a: Array) -> Array:
    """Return ∫₀^{π/2} (1 + a² cos²φ)^(−1/2) dφ = K(−a²) of checked ratios a = v/Dq: π/2 at rest, then ln(4|a|)/|a|."""
    h = np.hypot(1.0, a)
    # K(−a²) = K(1 − 1/h²)/h; for large h, before h² overflows, K(1 − 1/h²) is ln 4h to rounding
    return np.asarray(np.where(h < 1e9, scipy.special.ellipkm1(np.minimum(h, 1e9) ** -2.0), np.log(4.0 * h)) / h)


def _parameter(a: Array, h: Array) -> Array:
    return np.asarray((a / h) * (a / (h + 1)) / 2)


@dataclass(frozen=True, slots=True)
class _HeatSource:
    """The heat of a contact that slides: its stress s(q), and checked numbers of the heating."""

    stress: StressDensity
    velocity: Array  # v, m/s, any shape
    heating: Array  # μ|v|/κσ₀, the factor of Eqs. (4), (7) and (9), of that shape
    diffusivity: float  # D, m²/s

    def integral(self, kernel: Kernel, power: int) -> Array:
        """Return (2/π) ∫ s(q) q^power kernel(v/Dq) dq at each velocity, Pa² m^(−power)."""
        return bracket(self.velocity, self.diffusivity, self.stress, kernel, power)


def _heat_source(
    stress: StressDensity,
    speed: ArrayLike,
    friction_coefficient: float,
    conductivity: float,
    diffusivity: float,
    nominal_pressure: float,
) -> _HeatSource:
    """Check the numbers of the heating, in SI."""
    velocity = real_array("speed", speed, "m/s")
    friction = positive("friction_coefficient", friction_coefficient, "1")
    kappa = positive("conductivity", conductivity, "W/(m K)")
    heating = np.asarray(friction * np.abs(velocity) / (kappa * positive("nominal_pressure", nominal_pressure, "Pa")))
    return _HeatSource(stress, velocity, heating, positive("diffusivity", diffusivity, "m²/s"))


def flash_temperature(
    speed: ArrayLike,
    spectrum: Spectrum | None = None,
    *,
    nominal_pressure: float,
    friction_coefficient: float,
    conductivity: float,
    diffusivity: float,
    effective_modulus: float | None = None,
    gamma: Weight = 0.45,
    stress_spectrum: Spectrum | None = None,
) -> Array | float:
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
    stress = stress_density(spectrum, stress_spectrum, effective_modulus, nominal_pressure, gamma)
    source = _heat_source(stress, speed, friction_coefficient, conductivity, diffusivity, nominal_pressure)
    return float_if_scalar(source.heating * source.integral(even_integral, -1))


def flash_gradient(
    speed: ArrayLike,
    spectrum: Spectrum | None = None,
    *,
    nominal_pressure: float,
    friction_coefficient: float,
    conductivity: float,
    diffusivity: float,
    effective_modulus: float | None = None,
    gamma: Weight = 0.45,
    stress_spectrum: Spectrum | None = None,
) -> Array | float:
    """Weighted slope T′_flash = ⟨∂ₓT σ⟩/⟨σ⟩ along x, K/m. Eq. (7).

    Negative for a speed > 0, as the body is hotter behind the contact; positive for a speed < 0, 0 at rest.
    Parameters, errors: as `flash_temperature`.
    """
    stress = stress_density(spectrum, stress_spectrum, effective_modulus, nominal_pressure, gamma)
    source = _heat_source(stress, speed, friction_coefficient, conductivity, diffusivity, nominal_pressure)
    return float_if_scalar(source.heating * source.integral(odd_integral, 0))


def flash_laplacian(
    speed: ArrayLike,
    spectrum: Spectrum | None = None,
    *,
    nominal_pressure: float,
    friction_coefficient: float,
    conductivity: float,
    diffusivity: float,
    effective_modulus: float | None = None,
    gamma: Weight = 0.45,
    stress_spectrum: Spectrum | None = None,
) -> Array | float:
    """Weighted Laplacian in the plane ∇²T_flash = ⟨∇²T σ⟩/⟨σ⟩ ≤ 0, K/m². Eq. (9).

    Parameters, errors: as `flash_temperature`.
    """
    stress = stress_density(spectrum, stress_spectrum, effective_modulus, nominal_pressure, gamma)
    source = _heat_source(stress, speed, friction_coefficient, conductivity, diffusivity, nominal_pressure)
    return float_if_scalar(-source.heating * source.integral(even_integral, 1))


def flash_width(
    speed: ArrayLike,
    spectrum: Spectrum | None = None,
    *,
    nominal_pressure: float,
    friction_coefficient: float,
    conductivity: float,
    diffusivity: float,
    effective_modulus: float | None = None,
    gamma: Weight = 0.45,
    stress_spectrum: Spectrum | None = None,
) -> Array | float:
    """Width of the hot spots D_flash = √(−T_flash/∇²T_flash), m; at rest its limit for v → 0. Eq. (25).

    Parameters, errors: as `flash_temperature`; μ and κ cancel.
    """
    stress = stress_density(spectrum, stress_spectrum, effective_modulus, nominal_pressure, gamma)
    source = _heat_source(stress, speed, friction_coefficient, conductivity, diffusivity, nominal_pressure)
    curvature = _defined(source.integral(even_integral, 1))
    return float_if_scalar(np.sqrt(source.integral(even_integral, -1) / curvature))


def slope_length(
    speed: ArrayLike,
    spectrum: Spectrum | None = None,
    *,
    nominal_pressure: float,
    friction_coefficient: float,
    conductivity: float,
    diffusivity: float,
    effective_modulus: float | None = None,
    gamma: Weight = 0.45,
    stress_spectrum: Spectrum | None = None,
) -> Array | float:
    """Slope length d_flash = T_flash/|T′_flash|, m: 4D/|v| for v → 0, ∞ at rest. Eq. (26).

    Parameters, errors: as `flash_temperature`; μ and κ cancel.
    """
    stress = stress_density(spectrum, stress_spectrum, effective_modulus, nominal_pressure, gamma)
    source = _heat_source(stress, speed, friction_coefficient, conductivity, diffusivity, nominal_pressure)
    temperature = _defined(source.integral(even_integral, -1))
    with np.errstate(divide="ignore"):
        return float_if_scalar(temperature / np.abs(source.integral(odd_integral, 0)))


def rms_temperature(
    speed: ArrayLike,
    spectrum: Spectrum | None = None,
    *,
    nominal_pressure: float,
    friction_coefficient: float,
    conductivity: float,
    diffusivity: float,
    effective_modulus: float | None = None,
    gamma: Weight = 0.45,
    stress_spectrum: Spectrum | None = None,
) -> Array | float:
    """Root mean square T_rms = √⟨T²⟩ of the temperature over the whole surface, about its mean, K; 0 at rest.

    Of one wave T_q = μvσ_q/(κ √(q² − iq_x v/D)). Its square, averaged over the directions of sliding, is
    ⟨|T_q|²⟩ = (μv/κq)² |σ_q|² (2/π) K(−a²) with a = v/Dq and K of the parameter m = −a², so that
    T_rms² = 2π ∫ q ⟨|T_q|²⟩ dq. Isotropic roughness has the same T_rms in each direction.

    Parameters, errors: as `flash_temperature`; without `spectrum` the nominal pressure does not enter.
    """
    stress = stress_density(spectrum, stress_spectrum, effective_modulus, nominal_pressure, gamma)
    source = _heat_source(stress, speed, friction_coefficient, conductivity, diffusivity, nominal_pressure)
    rate = nominal_pressure * source.heating
    return float_if_scalar(rate * np.sqrt(source.integral(square_integral, -2)))


def temperature_correlation(
    r: ArrayLike,
    speed: float,
    spectrum: Spectrum | None = None,
    *,
    nominal_pressure: float,
    friction_coefficient: float,
    conductivity: float,
    diffusivity: float,
    effective_modulus: float | None = None,
    gamma: Weight = 0.45,
    stress_spectrum: Spectrum | None = None,
) -> Array:
    """Temperature correlation ⟨T(x)T(x′)⟩ over the whole surface, without its mean, averaged over directions.

    2π ∫ q ⟨|T_q|²⟩ J₀(qr) dq with ⟨|T_q|²⟩ of `rms_temperature`, at the distance r of x and x′. The temperature has
    tracks along the direction of sliding; this is the mean over all directions of x − x′.

    `r` are distances ≥ 0 of any shape, m, and `speed` is one speed of either sign, m/s. Returns K² in the shape of `r`;
    T_rms² at r = 0. Other parameters, errors: as `flash_temperature`; QuadratureError also if the integral with J₀
    does not reach its accuracy, 1e-11 of T_rms².
    """
    distance = not_negative_array("r", r, "m")
    stress = stress_density(spectrum, stress_spectrum, effective_modulus, nominal_pressure, gamma)
    source = _heat_source(stress, speed, friction_coefficient, conductivity, diffusivity, nominal_pressure)
    if source.velocity.ndim:
        raise TypeError(f"speed has shape {source.velocity.shape}; give one speed in m/s")
    rate = nominal_pressure * source.heating
    q = stress.panels.nodes()[0]
    response = 2 / pi * square_integral(source.velocity / (source.diffusivity * q)) / q**2
    correlation = hankel_transform(stress.panels, stress.values * response, distance)
    return np.asarray(rate**2 * correlation)


def bracket(velocity: Array, diffusivity: float, stress: StressDensity, kernel: Kernel, power: int) -> Array:
    """Return (2/π) ∫ s(q) q^power kernel(v/Dq) dq at each checked velocity, Pa² m^(−power)."""
    q = stress.wavenumber()
    moment = 2 / pi * stress.weighted() * q**power
    diffusive = positive("diffusivity", diffusivity, "m²/s") * q
    flat = velocity.ravel()
    blocks = [flat[i : i + _BLOCK, None] / diffusive for i in range(0, flat.size, _BLOCK)]
    sums = [kernel(a) @ moment for a in blocks]
    return np.concatenate(sums).reshape(velocity.shape) if sums else np.empty(velocity.shape)


def _defined(integral: Array) -> Array:
    if (integral == 0.0).any():
        raise ValueError(
            "the stress is uniform (its spectrum is 0), so the flash temperature has no width and no slope; give a "
            "rough surface"
        )
    return integral
