"""A skin on the half-space, and heat released in depth: the response of one wave to the frictional heat.

A skin of thickness d has its own conductivity κ_s and diffusivity D_s. The heat q̇ of the contact is released at the
surface, or below it with the density q̇ e^(−z/h)/h. With λ = √(q² − i q·v/D), λ_s = √(q² − i q·v/D_s), k = κ_s/κ and
E = e^(−λ_s d), the temperature of the surface by heat released at the depth z is

    κT/q̇ = [(kλ_s + λ) e^(−λ_s z) + (kλ_s − λ) E e^(−λ_s(d − z))]/(kλ_s N)    z ≤ d,
           2 E e^(−λ(z − d))/N                                                z ≥ d,
    N = kλ_s(1 − E²) + λ(1 + E²),

as it is the temperature at z by heat released at the surface. Its mean over e^(−z/h)/h is `steady_response`. Nothing
overflows, because Re λ and Re λ_s are positive.
"""

import math
from typing import NamedTuple

import numpy as np

from roughsim.errors import sized
from roughsim.grid import Array, Complex, Field
from roughsim.heat import laplace
from roughsim.heat.waves import FORGOTTEN

_CLOSE = 0.5  # |d/h − λ_s d| below which two exponentials of the depth cancel
_ACCURACY = 17.0  # −½ ln of the error of a mean over directions: 2e-15
_EXTRA_NODES = 4


class Skin(NamedTuple):
    """A layer of another material on a half-space, such as an oxide or a worked layer.

    Attributes
    ----------
    thickness : float
        d, m.
    conductivity : float
        κ_s, W/(m K).
    diffusivity : float
        D_s, m²/s.
    """

    thickness: float
    conductivity: float
    diffusivity: float


SkinLike = tuple[float, float, float]  # a Skin, or three numbers in its order


class Layering(NamedTuple):
    """A skin in units of the half-space under it, and the depth of release; without a skin `thickness` is 0."""

    thickness: float  # d, m
    conduction: float  # κ_s/κ
    diffusion: float  # D/D_s
    heat_depth: float  # h, m

    def in_units(self, length: float) -> "Layering":
        """Return the layers with lengths in units of `length`, m."""
        return self._replace(thickness=self.thickness / length, heat_depth=self.heat_depth / length)


def checked_skin(skin: SkinLike | None) -> Skin | None:
    """Return a skin of three positive numbers, in the order of `Skin`, or None; TypeError or ValueError otherwise."""
    if skin is None:
        return None
    if not isinstance(skin, (tuple, list)) or len(skin) != len(Skin._fields):
        raise TypeError(
            f"skin = {skin!r} must be three numbers, for example Skin(thickness=3e-7, conductivity=3.0, "
            "diffusivity=9e-7)"
        )
    thickness, conductivity, diffusivity = skin
    return Skin(
        sized("thickness of the skin", thickness, "m"),
        sized("conductivity of the skin", conductivity, "W/(m K)"),
        sized("diffusivity of the skin", diffusivity, "m²/s"),
    )


def steady_response(
    square: Field, advection: Field | Complex, layers: Layering, depth: float = 0.0
) -> Complex:
    """Return κT/q̇, m, of waves with q² = `square` > 0 and q·v/D = `advection`, both 1/m², in the steady state.

    κ and D are those of the half-space. With ip/D in place of q·v/D it is the Laplace transform over time. `depth` is
    the distance below the surface, m, ≥ 0. The two arrays have one shape, or shapes that broadcast.
    """
    if depth > 0.0:
        return _response_below(square, advection, layers, depth)
    below: Complex = np.sqrt(square - 1j * advection)  # λ
    spread = below * layers.heat_depth
    if layers.thickness == 0.0:
        return 1 / (below * (1 + spread))
    within: Complex = np.sqrt(square - 1j * (layers.diffusion * advection))  # λ_s
    x = within * layers.thickness
    inner = layers.conduction * within
    faded = np.exp(-2 * x)
    lost = -np.expm1(-2 * x)  # 1 − E² without cancellation
    determinant = inner * lost + below * (1 + faded)
    if layers.heat_depth == 0.0:
        released = inner * (1 + faded) + below * lost
    else:
        y = layers.thickness / layers.heat_depth
        crossing = np.exp(-x)
        released = (inner + below) * -np.expm1(-x - y) / (1 + within * layers.heat_depth)
        released += (inner - below) * crossing * _depth_mean(x, y)
        released += 2 * inner * crossing * math.exp(-y) / (1 + spread)
    return released / (inner * determinant)


def response_from_rest(
    square: Field, advection: Field, layers: Layering, depth: float = 0.0, spread: float = math.inf
) -> Complex:
    """Return `steady_response` a time t after the start from rest; `spread` is D t, m², inf in the steady state.

    F(s) with q² + s in place of q² − i q·v/D is regular at a = −i q·v/D, so that the response from rest is

        F(a) + e^(−aDt)/2πi ∫ e^(sDt) [F(s) − F(a)]/(s − a) ds.
    """
    response = steady_response(square, advection, layers, depth)
    young = square * spread < FORGOTTEN * max(1.0, layers.diffusion)
    if math.isinf(spread) or not young.any():
        return response
    square = square[young]
    start = -1j * advection[young]
    steady = response[young]
    integral = np.zeros(steady.shape, complex)
    for node, weight in zip(laplace.NODES / spread, laplace.WEIGHTS / (2 * spread), strict=True):
        here = steady_response(square, 1j * node, layers, depth)
        integral += weight * (here - steady) / (node - start)
        integral += weight.conj() * (here.conj() - steady) / (node.conj() - start)
    response[young] += np.exp(-start * spread) * integral
    return response


def _depth_mean(x: Complex, y: float) -> Complex:
    """Return (e^(−x) − e^(−y))/(1 − x/y) for Re x > 0 and y > 0, also where x = y."""
    difference = y - x
    close = np.abs(difference) < _CLOSE
    mean: Complex = np.asarray((np.exp(-x) - math.exp(-y)) / np.where(close, 1.0, 1 - x / y))
    small = difference[close]
    equal = small == 0.0
    quotient = -np.expm1(-small) / np.where(equal, 1.0, small)
    mean[close] = np.exp(-x[close]) * y * np.where(equal, 1.0, quotient)
    return mean


def _response_below(
    square: Field, advection: Field | Complex, layers: Layering, depth: float
) -> Complex:
    """Return κT/q̇ at a depth z > 0.

    Above the interface T is that of a half-space of the skin and B cosh(λ_s z). Below it is that of a half-space whose
    surface lies there, by the heat released in it, and C e^(−λ(z − d)). B and C make T and the heat flux continuous.
    """
    below: Complex = np.sqrt(square - 1j * advection)  # λ
    if layers.thickness == 0.0:
        return _uniform_body(below, layers.heat_depth, depth)[0]
    within: Complex = np.sqrt(square - 1j * (layers.diffusion * advection))  # λ_s
    inner = layers.conduction * within
    here, crossing = _uniform_body(within, layers.heat_depth, layers.thickness)
    # share of the half-space
    deep = math.exp(-layers.thickness / layers.heat_depth) if layers.heat_depth else 0.0
    own = deep / (below * (1 + below * layers.heat_depth))
    faded = np.exp(-2 * within * layers.thickness)
    # B cosh(λ_s d)
    lag = -np.expm1(-2 * within * layers.thickness) / (1 + faded)  # tanh(λ_s d)
    image = (own - here / layers.conduction + crossing / below) / (1 + inner * lag / below)
    if depth <= layers.thickness:
        rise = np.exp(within * (depth - layers.thickness))
        rise = rise + np.exp(-within * (depth + layers.thickness))
        skin = _uniform_body(within, layers.heat_depth, depth)[0] / layers.conduction
        return skin + image * rise / (1 + faded)
    beyond = depth - layers.thickness
    entering = crossing - inner * image * lag
    own_heat = _uniform_body(below, layers.heat_depth, beyond)[0]
    return deep * own_heat + entering / below * np.exp(-below * beyond)


def _uniform_body(root: Complex, heat_depth: float, depth: float) -> tuple[Complex, Complex]:
    """Return κT/q̇ at a depth > 0 of a half-space of one material with λ = `root`, and the share of heat that passes.

    They are [M + e^(−z/h)]/(λ(1 + λh)) and M/(1 + λh) with M = (e^(−λz) − e^(−z/h))/(1 − λh).
    """
    if heat_depth == 0.0:
        passing = np.exp(-root * depth)
        return passing / root, passing
    mean = _depth_mean(root * depth, depth / heat_depth)
    share = 1 / (1 + root * heat_depth)
    return (mean + math.exp(-depth / heat_depth)) * share / root, mean * share


def direction_means(wavenumber: Array, rate: float, layers: Layering) -> tuple[Array, Array]:
    """Return the means over the direction of sliding of Re F and Re(i cosφ F), F = |q|κT/q̇, at each wavenumber.

    `wavenumber` is |q| > 0, rad/m, shape (n,); `rate` is v/D ≥ 0 of the half-space, 1/m. For a bare half-space they
    are (2/π)A and (2/π)B of `roughsim.observables.moments.angular_means`.
    """
    # F has its singularities at imaginary q: in ln q, π/2 off the real axis. A polynomial through n points is exact to
    # degree n − 1, a quadrature to 2n − 1
    if not wavenumber.size:
        return wavenumber, wavenumber
    low = math.log(wavenumber.min())
    high = math.log(wavenumber.max())
    count = 2 * _node_count(max(high - low, 1.0))
    if count >= wavenumber.size:
        return _quarter_turn(wavenumber, rate, layers)
    points = np.polynomial.chebyshev.chebpts1(count)
    nodes = np.exp(low + 0.5 * (high - low) * (1 + points))
    means = np.stack(_quarter_turn(nodes, rate, layers), axis=1)
    coefficients = np.polynomial.chebyshev.chebfit(points, means, count - 1)
    place = 2 * (np.log(wavenumber) - low) / (high - low) - 1
    even, odd = np.polynomial.chebyshev.chebval(place, coefficients)
    return even, odd


def _quarter_turn(wavenumber: Array, rate: float, layers: Layering) -> tuple[Array, Array]:
    """Return the two means of `direction_means` by quadrature over a quarter turn."""
    # π/2 − φ = sinh(u)/a: in u the singularities at cosφ = −i/a and beyond are π/2 off the real axis
    ratio = np.maximum(rate / wavenumber * max(1.0, layers.diffusion), 1.0)[:, None]
    extent = np.arcsinh(0.5 * math.pi * ratio)
    nodes, weights = np.polynomial.legendre.leggauss(_node_count(float(extent.max())))
    u = 0.5 * extent * (1 + nodes)
    cosine = np.sin(np.sinh(u) / ratio)
    share = extent * weights * np.cosh(u) / (math.pi * ratio)  # du over the quarter turn
    q = wavenumber[:, None]
    response = q * steady_response(q**2, (rate * q) * cosine, layers)
    even = np.sum(share * response.real, axis=1)
    odd = np.sum(share * cosine * -response.imag, axis=1)
    return even, odd


def _node_count(extent: float) -> int:
    """Return how many nodes an interval of this length needs, with singularities π/2 off the real axis."""
    return math.ceil(_ACCURACY / math.asinh(math.pi / extent)) + _EXTRA_NODES
