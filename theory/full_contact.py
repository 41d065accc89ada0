"""Full contact of rough surfaces: the variance of its pressure, in which Persson's theory measures roughness."""

from math import pi

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import erf

from theory import quadrature
from theory.arguments import (
    Array,
    SpectrumLike,
    breaks_of,
    density,
    kept_for_values,
    not_negative_array,
    positive,
)


def half_variance(q: ArrayLike, spectrum: SpectrumLike, *, effective_modulus: float) -> Array:
    """Half the variance of the pressure in full contact from the roughness up to `q`.

    G(q) = (π/4) E*² ∫ q³ C dq from q_min to q.

    Parameters
    ----------
    q : array_like
        Wavenumbers ≥ 0 of any shape, rad/m: below q_min G = 0, beyond q_max it stays.
    spectrum : callable
        C(q), m⁴, with `breaks`.
    effective_modulus : float
        E*, Pa, > 0.

    Returns
    -------
    ndarray
        G in Pa², the shape of `q`.

    Raises
    ------
    TypeError, ValueError
        If an argument is not real, finite and of the right sign.
    """
    wavenumber = not_negative_array("q", q, "rad/m")
    modulus = positive("effective_modulus", effective_modulus, "Pa")
    return np.asarray(pi / 4 * modulus**2 * half_variance_table(spectrum)(wavenumber))


@kept_for_values  # .005 s each, asked for a dozen times in a comparison
def half_variance_table(spectrum: SpectrumLike) -> quadrature.Primitive:
    """Return ∫ q³ C dq from the first break, dimensionless, as a function of q."""
    return quadrature.primitive(
        lambda q, place: q**3 * density(spectrum, q, place), breaks_of(spectrum)
    )


def probability(half_variance: Array, pressure: float) -> Array:
    """Return P = erf(σ₀ / 2√G) of checked arguments ≥ 0; G = 0 is full contact, σ₀ = 0 none."""
    if pressure == 0.0:
        return np.zeros(half_variance.shape)
    with np.errstate(divide="ignore"):
        return np.asarray(erf(pressure / (2 * np.sqrt(half_variance))))
