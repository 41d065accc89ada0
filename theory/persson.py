"""Contact of a rough elastic surface: half variance G, contact probability P, weight W, stress correlation (Eq. 2)."""

from collections.abc import Callable
from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import ArrayLike

from theory import quadrature
from theory.arguments import (
    Array,
    SpectrumLike,
    breaks_of,
    density,
    kept_for_values,
    not_negative_array,
    positive,
    real_array,
)
from theory.full_contact import half_variance, half_variance_table, probability
from theory.hankel import first_crossing, hankel_transform
from theory.yielding import calibrated_spectrum

__all__ = [
    "StressDensity",
    "calibrated_spectrum",
    "contact_probability",
    "correlation_radius",
    "effective_modulus",
    "half_variance",
    "pressure_correlation",
    "stress_density",
    "stress_weight",
    "wang_mueser",
]

Weight = float | Callable[[Array, Array], Array]


def effective_modulus(youngs_modulus: ArrayLike, poisson_ratio: ArrayLike) -> float:
    """Composite modulus of the bodies in contact, 1/E* = Σ (1 − ν²)/E. After Eq. (2).

    Parameters
    ----------
    youngs_modulus : array_like
        E > 0 of each deformable body, Pa: one number, or two for two bodies.
    poisson_ratio : array_like
        ν of each, above −1 and at most 0.5.

    Returns
    -------
    float
        E* in Pa.

    Raises
    ------
    TypeError, ValueError
        If an argument is not real and finite, E ≤ 0, or no solid has such a ν.
    """
    modulus = real_array("youngs_modulus", youngs_modulus, "Pa")
    ratio = real_array("poisson_ratio", poisson_ratio, "1")
    if modulus.shape not in {(), (1,), (2,)} or ratio.shape not in {(), modulus.shape}:
        raise ValueError(
            f"youngs_modulus and poisson_ratio have shapes {modulus.shape} and {ratio.shape}; "
            "give one or two numbers each"
        )
    if (modulus <= 0.0).any():
        raise ValueError(f"youngs_modulus = {modulus.min():.6g} Pa must be positive")
    possible = (ratio > -1.0) & (ratio <= 0.5)
    if not possible.all():
        raise ValueError(
            f"poisson_ratio = {ratio[~possible].flat[0]:.6g} must lie above −1 and be at most 0.5"
        )
    return float(np.sum((1 - ratio**2) / modulus) ** -1.0)


def contact_probability(
    q: ArrayLike, spectrum: SpectrumLike, *, effective_modulus: float, nominal_pressure: float
) -> Array:
    """Relative contact area when roughness up to `q` is seen: P = erf(σ₀ / 2√G), dimensionless, the shape of `q`.

    Parameters
    ----------
    q : array_like
        Wavenumbers ≥ 0 of any shape, rad/m.
    spectrum, effective_modulus
        As in `half_variance`.
    nominal_pressure : float
        σ₀, Pa, > 0.

    Returns
    -------
    ndarray
        P, dimensionless, the shape of `q`.

    Raises
    ------
    TypeError, ValueError
        As `half_variance`.
    """
    pressure = positive("nominal_pressure", nominal_pressure, "Pa")
    return probability(half_variance(q, spectrum, effective_modulus=effective_modulus), pressure)


def stress_weight(
    q: ArrayLike,
    spectrum: SpectrumLike,
    *,
    effective_modulus: float,
    nominal_pressure: float,
    gamma: Weight = 0.45,
) -> Array:
    """Share of the full-contact stress spectrum that is left at `q`: W = P[γ + (1 − γ)P²], the shape of `q`.
    from 0 to 1 (1: W = P) or a callable W(P, q).

    Parameters
    ----------
    q, spectrum, effective_modulus, nominal_pressure
        As in `contact_probability`.
    gamma : float or callable
        γ from 0 to 1 (1: W = P), or a weight W(P, q).

    Returns
    -------
    ndarray
        W, dimensionless, the shape of `q`.

    Raises
    ------
    TypeError, ValueError
        As `contact_probability`, or `gamma` gives no weight.
    """
    share = contact_probability(
        q, spectrum, effective_modulus=effective_modulus, nominal_pressure=nominal_pressure
    )
    return weight(share, np.asarray(q, dtype=np.float64), gamma)


def wang_mueser(share: Array, wavenumber: Array) -> Array:
    """Weight of Wang and Müser, W = P[γ − (2/9)P² + (11/9 − γ)P⁴] with γ = 5/9: pass it as `gamma`.

    Source: A. Wang and M.H. Müser, Tribology Letters 65(3) (2017), in the form that the public code
    PerssonModelFudgeFactor (Persson_LE_SE_WM17) gives it. There P follows from the stress spectrum so weighted; here,
    as everywhere in this package, from full contact.

    Parameters
    ----------
    share : ndarray
        P, dimensionless, any shape.
    wavenumber : ndarray
        q, rad/m; the form does not depend on it.

    Returns
    -------
    ndarray
        W, dimensionless, the shape of `share`; 1 in full contact.
    """
    return share * (5 / 9 - 2 / 9 * share**2 + 2 / 3 * share**4)


def pressure_correlation(
    r: ArrayLike,
    spectrum: SpectrumLike | None = None,
    *,
    nominal_pressure: float | None = None,
    effective_modulus: float | None = None,
    gamma: Weight = 0.45,
    stress_spectrum: SpectrumLike | None = None,
) -> Array:
    """Stress-stress correlation g_σ(r) = (π/2) E*² ∫ q³ C W J₀(qr) dq, without σ₀². Eq. (2).

    Parameters
    ----------
    r : array_like
        Distances ≥ 0 of any shape, m.
    spectrum, effective_modulus, nominal_pressure, gamma
        As in `stress_weight`.
    stress_spectrum : callable, optional
        |σ_q|² in Pa² m² with `breaks`, in place of all four: g_σ(r) = 2π ∫ q |σ_q|² J₀(qr) dq.

    Returns
    -------
    ndarray
        g_σ in Pa², the shape of `r`; negative at some r whenever q_min > 0.

    Raises
    ------
    TypeError, ValueError
        If an argument is not real, finite and of the right sign, or both spectra or none are given.
    theory.quadrature.QuadratureError
        If the integral does not reach its accuracy, 1e-11 of g_σ(0).
    """
    distance = not_negative_array("r", r, "m")
    stress = stress_density(spectrum, stress_spectrum, effective_modulus, nominal_pressure, gamma)
    return hankel_transform(stress.panels, stress.values, distance)


def correlation_radius(
    fraction: float,
    spectrum: SpectrumLike | None = None,
    *,
    nominal_pressure: float | None = None,
    effective_modulus: float | None = None,
    gamma: Weight = 0.45,
    stress_spectrum: SpectrumLike | None = None,
) -> float:
    """Smallest distance r with g_σ(r) = `fraction` · g_σ(0), m; `fraction` = 0 is the first zero.

    At `fraction` = α, e.g. 0.1, it is the effective diameter of the macroasperity contacts (Sec. 2, after Eq. 2).

    Parameters
    ----------
    fraction : float
        From 0 up to, not including, 1.
    spectrum, nominal_pressure, effective_modulus, gamma, stress_spectrum
        As in `pressure_correlation`.

    Returns
    -------
    float
        r in m.

    Raises
    ------
    TypeError, ValueError, theory.quadrature.QuadratureError
        As `pressure_correlation`, or g_σ never falls so far.
    """
    level = float(real_array("fraction", fraction, "1"))
    if not 0.0 <= level < 1.0:
        raise ValueError(f"fraction = {level:.6g} must lie from 0 up to, not including, 1")
    stress = stress_density(spectrum, stress_spectrum, effective_modulus, nominal_pressure, gamma)
    return first_crossing(stress.panels, stress.values, level)


def weight(share: Array, wavenumber: Array, gamma: Weight) -> Array:
    """Return W of the contact probability `share` at `wavenumber`; ValueError when `gamma` gives no weight."""
    if not callable(gamma):
        constant = float(real_array("gamma", gamma, "1"))
        if not 0.0 <= constant <= 1.0:
            raise ValueError(f"gamma = {constant:.6g} must lie from 0 to 1")
        return share * (constant + (1 - constant) * share**2)
    values = np.asarray(gamma(share, wavenumber), dtype=np.float64)
    if values.shape != share.shape or not (np.isfinite(values) & (values >= 0.0)).all():
        raise ValueError("gamma(P, q) must return finite weights ≥ 0 in the shape of P")
    return values


@dataclass(frozen=True, slots=True, eq=False)
class StressDensity:
    """s(q) dq/dt at the nodes of `panels`, Pa²: g_σ(r) = ∫ s J₀(qr) dq with s = (π/2) E*² q³ C W = 2π q |σ_q|²."""

    panels: quadrature.Panels
    values: Array

    def wavenumber(self) -> Array:
        """Return the nodes as one array, rad/m."""
        return self.panels.nodes()[0].ravel()

    def weighted(self) -> Array:
        """Return s dq at the nodes as one array, Pa²: its sum is g_σ(0)."""
        return (self.values * quadrature.WEIGHTS).ravel()


@kept_for_values  # .01 s for each quantity of one surface at each speed, .4 s in a comparison
def stress_density(
    spectrum: SpectrumLike | None = None,
    stress_spectrum: SpectrumLike | None = None,
    effective_modulus: float | None = None,
    nominal_pressure: float | None = None,
    gamma: Weight = 0.45,
) -> StressDensity:
    """Return s(q) on panels that resolve ∫ s/q, ∫ s and ∫ s q to 1e-11; arguments as in `pressure_correlation`.

    The results for spectra that compare by value are kept: all quantities of one surface share them, at every speed.
    """
    if spectrum is not None and stress_spectrum is not None:
        raise TypeError("spectrum and stress_spectrum are both given; give one of them")
    if spectrum is not None:
        start, stress = _stress_of(spectrum, effective_modulus, nominal_pressure, gamma)
    elif stress_spectrum is not None:
        start, stress = _stress_itself(stress_spectrum)
    else:
        raise TypeError("spectrum is missing; give spectrum or stress_spectrum")

    def moments(panels: quadrature.Panels) -> Array:
        q, slope = panels.nodes()
        s = stress(panels, q) * slope
        return np.stack([s / q, s, s * q])

    panels, values = quadrature.refine(moments, start)
    values[1].setflags(write=False)
    return StressDensity(panels, values[1])


_Stress = Callable[[quadrature.Panels, Array], Array]


def _stress_itself(stress_spectrum: SpectrumLike) -> tuple[quadrature.Panels, _Stress]:
    panels = quadrature.panels_between(breaks_of(stress_spectrum))
    return panels, lambda at, q: 2 * pi * q * density(stress_spectrum, q, at.place())


def _stress_of(
    spectrum: SpectrumLike,
    effective_modulus: float | None,
    nominal_pressure: float | None,
    gamma: Weight,
) -> tuple[quadrature.Panels, _Stress]:
    """Return s of Eq. (2), and panels fine enough for the thin layer of wavenumbers in which contact is lost."""
    modulus = positive("effective_modulus", effective_modulus, "Pa")
    pressure = positive("nominal_pressure", nominal_pressure, "Pa")
    table = half_variance_table(spectrum)

    def stress(panels: quadrature.Panels, q: Array) -> Array:
        piece = np.broadcast_to(panels.piece[:, None], q.shape)
        half = pi / 4 * modulus**2 * table.at(piece, panels.coordinates())
        whole = pi / 2 * modulus**2 * q**3 * density(spectrum, q, panels.place())
        return whole * weight(probability(half, pressure), q, gamma)

    layers = table.layers(pressure**2 / (pi * modulus**2))  # at G = σ₀²/4, P = erf(1)
    return quadrature.graded(quadrature.panels_between(breaks_of(spectrum)), layers), stress
