"""How heat that entered a half-space with a skin, or in depth, warms its surface later: as a sum of Gaussians.

Heat of the time τ ago warms a wave q of the surface by K(q, τ), the inverse Laplace transform of κT/q̇ of `theory.skin`
with q² + p/D in place of q² − i q·v/D. Part of its way led through the skin, part through the half-space, so that

    K(q, τ) = Σ_j k_j(τ) e^(−c_j q² τ),    c_j between D_s and D:

a mean over the ways. Each term is the kernel √(c_j/πτ) e^(−c_j q² τ) of a bare half-space times ρ_j(τ). Without a skin,
or with D_s = D, there is one term, exactly; without layers ρ = 1.

The contour of the inversion is that of J. A. C. Weideman, SIAM J. Numer. Anal. 44, 2342 (2006).
"""

from math import ceil, log, pi

import numpy as np

from theory.arguments import Array
from theory.skin import BodyLayers, Complex, surface_response

_RATIO = 0.5  # of the logarithms of neighbouring c_j, at most
_LEAST, _MOST = (
    1e-3,
    25.0,
)  # q² τ times the fastest c_j, from which the terms are fitted, and the slowest, up to which
_WAVES_PER_E_FOLD = 4  # at which they are fitted
_CUT = 1e-10  # of the singular values
_POINTS = 24  # of the contour: errors of 1e-13
_THETA = (2 * np.arange(_POINTS // 2) + 1) * pi / _POINTS
_P = _POINTS * (0.5017 * _THETA / np.tan(0.6407 * _THETA) - 0.6122 + 0.2645j * _THETA)
_SLOPE = (
    0.5017 / np.tan(0.6407 * _THETA)
    - 0.5017 * 0.6407 * _THETA / np.sin(0.6407 * _THETA) ** 2
    + 0.2645j
)
_WEIGHT = -2j * _SLOPE * np.exp(_P)
_LONG = 1e-9  # q over 1/√(Dτ) of the mean


def pulses(layers: BodyLayers, diffusivity: float, times: Array) -> tuple[Array, Array]:
    """Return c_j, m²/s, (terms,), and ρ_j at times (n,), s, shape (terms, n), of a half-space with D, m²/s."""
    last = diffusivity / layers.diffusion
    extent = abs(log(layers.diffusion))
    terms = 1 + ceil(extent / _RATIO)
    spreads = np.geomspace(diffusivity, last, terms)
    # q² τ, so that all times share one matrix
    waves = ceil((log(_MOST / _LEAST) + extent) * _WAVES_PER_E_FOLD)
    decays = np.geomspace(_LEAST / spreads.max(), _MOST / spreads.min(), waves)[:, None]
    square = decays / times
    kernel = _inverse_of(square, layers, diffusivity, times, 0)
    kernel *= np.sqrt(pi * times)
    strength = np.linalg.lstsq(np.exp(-decays * spreads), kernel, rcond=_CUT)[0]
    return spreads, strength / np.sqrt(spreads)[:, None]


def uniform_rise(layers: BodyLayers, diffusivity: float, times: Array) -> Array:
    """Return κT/q̇, m, of a uniform flux at times (n,), s, after it began."""
    rise: Array = _inverse_of(
        _LONG**2 / (diffusivity * times[None]), layers, diffusivity, times, 1
    )[0]
    return rise


def _inverse_of(
    square: Array, layers: BodyLayers, diffusivity: float, times: Array, order: int
) -> Array:
    """Return the function of time with the Laplace transform κT/(q̇ p^order), of waves q² (waves, n) at times (n,)."""
    p: Complex = np.asarray(_P / times[:, None])
    q = np.sqrt(square)[..., None]
    response = surface_response(q, 1j * p / diffusivity, layers) / q
    return np.asarray((_WEIGHT * response / p**order).real.sum(axis=-1) / times)
