"""The temperature that one heated pixel makes at all others, on a half-space with a skin or heated in depth.

Heat of the time τ ago warms a wave q by K(q, τ), the inverse Laplace transform of κT/q̇ of `roughsim.heat.skin` with
q² + p/D in place of q² − i q·v/D. Part of its way led through the skin, part through the body: K is a mean over ways,

    K(q, τ) = Σ_j ρ_j(τ) √(D_j/πτ) e^(−D_j q² τ),    D_j from D_s to D.

Each term is the kernel of a bare half-space times ρ_j. So the influence of a pixel is a sum of bare ones, in which ρ_j
multiplies the heat by its age: on the free half-space, and from any time since the start on.
"""

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np

from roughsim.grid import Array
from roughsim.heat.influence import Fading, PixelAxis, one_sided_influence
from roughsim.heat.laplace import interpolation, inverse
from roughsim.heat.skin import Layering, steady_response

_RATIO = 0.4  # of the logarithms of neighbouring D_j, at most; with one D_j more on each side K errs by 3e-5
# D_j q² τ of the fastest term, from which K is fitted, and of the slowest, up to which
_LEAST = 1e-3
_MOST = 25.0
_WAVES_PER_E_FOLD = 4  # at which K is fitted
_CUT = 1e-10  # of the singular values: ρ_j stay small
# ρ_j is taken as constant before and after, in units of the first and last √(Dτ)
_EARLY = 1e-3
_LATE = 1e4
# pixels: no layer matters that is thinner, or by how much it is thicker
_SHORTEST = 1e-12
_LONGEST = 1e15


def layered_influence(
    x: PixelAxis, y: PixelAxis, *, depth: float, end: float, layers: Layering
) -> Array:
    """Return κT as `one_sided_influence` of a bare body; `layers` are in the unit of length of the axes."""
    terms = []
    for ratio, strength in _ways(layers, depth):
        along, across = (replace(axis, drift=axis.drift / ratio) for axis in (x, y))
        terms.append(
            one_sided_influence(along, across, fading=strength, end=math.sqrt(ratio) * end)
        )
    return np.sum(terms, axis=0)


@lru_cache(maxsize=2)  # .1 s for each body, the same at all times of a series
def _ways(layers: Layering, depth: float) -> list[tuple[float, Fading]]:
    """Return D_j/D and ρ_j, by least squares over waves at each age."""
    extent = abs(math.log(layers.diffusion))
    steps = math.ceil(extent / _RATIO)
    width = -math.log(layers.diffusion) / max(steps, 1)
    ratios = np.exp(width * np.arange(-1.0, steps + 2)) if steps else np.ones(1)
    waves = math.ceil((math.log(_MOST / _LEAST) + extent) * _WAVES_PER_E_FOLD)
    decays = np.geomspace(_LEAST / ratios.max(), _MOST / ratios.min(), waves)  # D q² τ
    first, last = _ages(layers, depth)
    ages, interpolated = interpolation(_EARLY * first, _LATE * last)
    square = decays[:, None, None] / ages[:, None] ** 2
    kernel = (
        inverse(lambda p: steady_response(square, 1j * p, layers, depth), ages**2)
        * ages
        * math.sqrt(math.pi)
    )
    strengths = np.linalg.lstsq(np.exp(-np.outer(decays, ratios)), kernel, rcond=_CUT)[0]

    def fading(root: float, strength: Array) -> Fading:
        function = interpolated(strength[:, None] / root)
        return Fading(
            lambda u: function(np.clip(u / root, ages[0], ages[-1]))[:, 0],
            root * first,
            root * last,
        )

    return [
        (float(ratio), fading(math.sqrt(ratio), row))
        for ratio, row in zip(ratios, strengths, strict=True)
    ]


def _ages(layers: Layering, depth: float) -> tuple[float, float]:
    """Return √(Dτ) of heat that has not met another material, or the depth, and of heat far beyond all layers."""
    d, k, ratio, h = layers
    # e^(−13²/4) = 4e-19
    first = min(length for length in (d, h, depth) if length) * min(1.0, math.sqrt(ratio)) / 13
    last = 4 * max(d, d * k, d * math.sqrt(ratio), d * k * ratio, h, depth)
    return min(max(first, _SHORTEST), _LONGEST), min(max(last, _SHORTEST), _LONGEST)
