"""A skin on the half-space, and heat released in depth: temperature of the surface by one wave of heat.

The skin, of thickness d, has κ_s and D_s. The heat q̇ is released at the surface, or below it with the density
q̇ e^(−z/h)/h. With λ = √(q² − i q·v/D), λ_s = √(q² − i q·v/D_s), k = κ_s/κ and t = tanh(λ_s d), heat at the surface
makes

    κT/q̇ = (kλ_s + λt)/(kλ_s (λ + kλ_s t)).

Heat in depth gives T = T_s + B cosh(λ_s z) in the skin, T_s that of a half-space of the skin alone, and below it the
temperature of a half-space that begins at z = d, with the heat released in it and the heat that comes out of the skin:

    κT_s = [M + e^(−z/h)]/(kλ_s(1 + λ_s h)),    M = (e^(−λ_s z) − e^(−z/h))/(1 − λ_s h).

B makes T and the flux continuous. Without a skin κT/q̇ = 1/(λ(1 + λh)).
"""

from collections.abc import Callable
from math import ceil, exp, log, pi
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from theory.arguments import Array, not_negative_array, positive

Complex = NDArray[np.complex128]
Skin = tuple[float, float, float]  # d, m, κ_s, W/(m K), and D_s, m²/s
Part = Callable[[Array, Complex], Array]  # a real function of cosφ and F = |q|κT/q̇

_GROWTH = 4.0  # of an angle over a panel: its 10 nodes are exact to 3^(−20) = 3e-10
_LATE = 25.0  # D t over the square of the depth of layers, from which on backgrounds are within 3 % of the image series
_WIDEST, _NODES = 1.0, 12  # of a panel in ln q, and its nodes: exact to 6.4^(−12) = 2e-10
_BLOCK = 32  # wavenumbers that share their directions
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(10)


class BodyLayers(NamedTuple):
    """A skin in units of the half-space under it, and the depth of release; without a skin `thickness` is 0."""

    thickness: float  # d, m
    conduction: float  # κ_s/κ
    diffusion: float  # D/D_s
    heat_depth: float  # h, m


def layers_of(
    skin: Skin | None, heat_depth: float, conductivity: float, diffusivity: float
) -> BodyLayers | None:
    """Return the layers of a body with checked κ, W/(m K), and D, m²/s; None of a bare one that is heated in its plane.

    `skin` is None, or d, κ_s and D_s in this order; TypeError or ValueError otherwise, and for a negative `heat_depth`.
    """
    released = not_negative_array("heat_depth", heat_depth, "m")
    if released.ndim:
        raise TypeError(f"heat_depth has shape {released.shape}; one number in m is needed")
    depth = float(released)
    if skin is None:
        return BodyLayers(0.0, 1.0, 1.0, depth) if depth else None
    if not isinstance(skin, (tuple, list)) or len(skin) != 3:
        raise TypeError(
            f"skin = {skin!r} must be thickness, conductivity and diffusivity, in this order"
        )
    thickness = positive("thickness of the skin", skin[0], "m")
    kappa = positive("conductivity of the skin", skin[1], "W/(m K)")
    return BodyLayers(
        thickness,
        kappa / conductivity,
        diffusivity / positive("diffusivity of the skin", skin[2], "m²/s"),
        depth,
    )


class ThermalBody(NamedTuple):
    """A half-space with checked numbers."""

    conductivity: float  # κ, W/(m K)
    diffusivity: float  # D, m²/s
    layers: BodyLayers | None  # None of a bare one that is heated in its plane


def body_of(
    conductivity: float | None,
    diffusivity: float | None,
    skin: Skin | None,
    heat_depth: float,
    like: ThermalBody | None = None,
) -> ThermalBody:
    """Return a body; of the one at rest, κ and D that are None are those of the moving body, `like`."""
    name = "" if like is None else "resting_"
    if like is not None:
        conductivity = like.conductivity if conductivity is None else conductivity
        diffusivity = like.diffusivity if diffusivity is None else diffusivity
    kappa = positive(f"{name}conductivity", conductivity, "W/(m K)")
    diffusion = positive(f"{name}diffusivity", diffusivity, "m²/s")
    return ThermalBody(kappa, diffusion, layers_of(skin, heat_depth, kappa, diffusion))


def surface_response(q: Array, advection: Array | Complex, layers: BodyLayers) -> Complex:
    """Return F = |q|κT/q̇ of waves |q|, rad/m, with q·v/D = `advection`, 1/m²; arrays that broadcast.

    With ip/D in place of q·v/D it is the Laplace transform over time.
    """
    below: Complex = np.sqrt(q**2 - 1j * advection)
    if layers.thickness == 0.0:
        bare: Complex = q / (below * (1 + below * layers.heat_depth))
        return bare
    within: Complex = np.sqrt(q**2 - 1j * (layers.diffusion * advection))
    inner = layers.conduction * within
    lag = np.tanh(within * layers.thickness)
    if layers.heat_depth == 0.0:
        result: Complex = q * (inner + below * lag) / (inner * (below + inner * lag))
        return result
    depth, d = layers.heat_depth, layers.thickness
    mean = _depth_mean(within * d, d / depth)
    surface = 1 / (inner * (1 + within * depth))
    above = (mean + exp(-d / depth)) * surface  # κT_s at z = d
    passing = mean / (1 + within * depth)  # its heat flux there, over q̇
    own = exp(-d / depth) / (below * (1 + below * depth))
    image = (own - above + passing / below) / (1 + inner * lag / below)  # B cosh(λ_s d)
    fading = np.exp(-within * d)
    deep: Complex = q * (surface + image * 2 * fading / (1 + fading**2))
    return deep


def _depth_mean(x: Complex, y: float) -> Complex:
    """Return (e^(−x) − e^(−y))/(1 − x/y), also where x = y."""
    half = (y - x) / 2
    near = np.abs(half) < 1.0
    apart = np.where(near, 2.0, 1 - x / y)
    result = (np.exp(-x) - exp(-y)) / apart
    small = np.where(half[near] == 0.0, 1e-300, half[near])
    result[near] = y * np.exp(-(x[near] + y) / 2) * np.sinh(small) / small
    return np.asarray(result)


def even_part(_: Array, response: Complex) -> Array:
    """Return Re F: its mean over directions is (2/π)A of a bare half-space."""
    return response.real


def odd_part(cosine: Array, response: Complex) -> Array:
    """Return Re(i cosφ F): its mean over directions is (2/π)B of a bare half-space."""
    return -cosine * response.imag


def square_part(_: Array, response: Complex) -> Array:
    """Return |F|²."""
    return response.real**2 + response.imag**2


def direction_mean(q: Array, drift: float, layers: BodyLayers, part: Part) -> Array:
    """Return the mean over the directions of sliding of a part of F, at wavenumbers (n,), rad/m, for v/D, 1/m."""
    return along_waves(q, lambda waves: _mean_at(waves, drift, layers, part))


def along_waves(q: Array, mean_at: Callable[[Array], Array]) -> Array:
    """Return `mean_at` wavenumbers (n,), rad/m, of many by polynomials in ln q: analytic within ±iπ/2.

    It returns one number or a row of them for each.
    """
    if q.size == 0:
        return np.empty(0)
    log_q = np.log(q)
    low, extent = float(log_q.min()), float(np.ptp(log_q))
    panels = ceil(extent / _WIDEST)
    if q.size <= panels * _NODES or panels == 0:
        return mean_at(q)
    width, nodes = extent / panels, chebyshev.chebpts1(_NODES)
    panel = np.minimum(((log_q - low) / width).astype(int), panels - 1)
    starts = low + width * np.arange(panels)[:, None]
    waves = np.exp(starts + width * (1 + nodes) / 2)
    values = mean_at(waves.ravel())
    rows = values.reshape(panels, _NODES, -1)
    series = np.moveaxis(rows, 1, 0).reshape(_NODES, -1)
    coefficients = chebyshev.chebfit(nodes, series, _NODES - 1).reshape(_NODES, panels, -1)
    place = 2 * (log_q - starts[panel, 0]) / width - 1
    means: Array = chebyshev.chebval(place[:, None], coefficients[:, panel], tensor=False)
    return means.reshape(q.size, *values.shape[1:])


def _mean_at(q: Array, drift: float, layers: BodyLayers, part: Part) -> Array:
    """Return `direction_mean` by quadrature over the angle."""
    means = []
    for start in range(0, q.size, _BLOCK):  # short waves need fewer directions
        waves = q[start : start + _BLOCK, None]
        cosine, weights = _directions(abs(drift) / float(waves.min()) * max(1.0, layers.diffusion))
        response = surface_response(waves, drift * waves * cosine, layers)
        means.append(part(cosine, np.broadcast_to(response, (waves.size, cosine.size))) @ weights)
    return np.concatenate(means)


def _directions(steepest: float) -> tuple[Array, Array]:
    """Return cosφ over a quarter turn, and weights with the sum 1.

    F varies within π/2 − φ = 1/`steepest`. From there on the panels grow.
    """
    panels = ceil(log(max(steepest, 1.0) * pi / 2) / log(_GROWTH))
    edges = np.append(0.0, pi / 2 * _GROWTH ** -np.arange(panels, -1.0, -1.0))
    half = np.diff(edges)[:, None] / 2
    angle = (edges[:-1, None] + half * (1 + _POINTS)).ravel()
    return np.sin(angle), (half * _WEIGHTS).ravel() * 2 / pi


def steady_rise(layers: BodyLayers, spread: float, limit: str = "duration") -> float:
    """Return how far layers raise κT₀/q̇ of a uniform flux, m, a time t after it began; `spread` is D t, m².

    (d/k)(1 − (e_s/e)²) − (h/k)(1 − e^(−d/h)) − h e^(−d/h), e and e_s the effusivities κ/√D of body and skin. It is the
    limit for t ≫ d²/D, d²/D_s, that times (e_s/e)², and h²/D; ValueError for a time below 25 of them, which names the
    quantity that is the `limit`.
    """
    k, d, h = layers.conduction, layers.thickness, layers.heat_depth
    depth = max(d, d * np.sqrt(layers.diffusion), d * k * layers.diffusion, h)
    if spread < _LATE * depth**2:
        raise ValueError(
            f"{limit}: heat spreads {np.sqrt(spread):.3g} m deep in it, less than {np.sqrt(_LATE):g} times the "
            f"{depth:.3g} m of the skin or the heat_depth, which have not warmed through then; take "
            f"{_LATE * depth**2 / spread:.3g} times the {limit}, or more"
        )
    rise = d / k * (1 - k**2 * layers.diffusion)
    if h > 0.0:
        rise -= h / k * -np.expm1(-d / h) + h * exp(-d / h)
    return float(rise)
