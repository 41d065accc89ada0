"""The memory of a half-space with a skin, or heated in depth: weights of its past heat, for each wave and for the mean.

The temperature by heat that enters evenly in time has the Laplace transform F(q, p)/p, with F = κT/q̇ as in
`roughsim.heat.skin` and q² + p/D in place of q² − iq·v/D. All its singularities have p ≤ −min(D, D_s) q². So the
temperature by a pulse of heat is e^(−min(D, D_s) q² τ) times a function of τ that decays at most with rates ≥ 0:
exponentials of fixed rates, in geometric sequence, with weights of each wave by least squares. Integrals over the
latest step, and the weights of the mean, are those of the kernel itself.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from roughsim.errors import ConvergenceError
from roughsim.grid import Array, Complex, Field, Grid
from roughsim.heat.laplace import interpolation, inverse
from roughsim.heat.skin import Layering, steady_response

_KERNEL_ERROR = 5e-5  # of the sum of exponentials times √τ, relative to the largest kernel times √τ, or latest step
_TERMS = range(8, 48, 4)  # exponentials: 16 to 28 are usual
_FASTEST, _SLOWEST = 5.0, 0.1  # rates: per step, and over the whole history
_TIMES_PER_E_FOLD = 12  # at which the weights are fitted
_CUT = 1e-12  # of the singular values: weights stay small
_NEAR = 16  # steps up to which second differences of integrals do not cancel


class LayeredKernel(NamedTuple):
    """The memory in units of the step; times 1/κ it gives temperatures of fluxes. Half spectra, and m if not stated."""

    decay: float  # m²: times q² the least rate of all that a wave remembers
    rates: Array  # of the exponentials, on top of that, (terms,); dimensionless
    weights: Array  # of the exponentials for each mode, (*half_shape, terms)
    late: Field  # response to the flux at the end of the latest step
    early: Field  # to the flux at its beginning
    mean_weights: Array  # for q = 0: of the flux m steps before the end, (steps + 1,)
    first_weights: Array  # for q = 0: of the flux at time 0 after n steps, (steps + 1,)


def layered_kernel(
    grid: Grid, diffusivity: float, layers: Layering, step: float, steps: int
) -> LayeredKernel:
    """Return the memory of a body with D, m²/s, over `steps` steps of `step`, s; ConvergenceError if no sum fits."""
    spread = diffusivity * step
    slowest = spread * min(1.0, 1.0 / layers.diffusion)
    qx, qy = grid.wavevectors
    waves = np.sqrt(qx**2 + qy**2)
    waves[0, 0] = waves.ravel()[1:].min()  # any: the mean has weights of its own
    low = float(waves.min())
    high = float(waves.max())
    nodes, interpolated = interpolation(low, high)

    def pulse(time: Array) -> Array:
        """Return the temperature by a pulse, without its slowest decay; (nodes, times)."""
        squares = nodes[:, None, None] ** 2
        return inverse(lambda p: _transform(squares, p - slowest * squares, spread, layers), time)

    square = nodes[:, None] ** 2
    end = np.ones(1)
    once, twice = (_integral(order, square, spread, layers, end) for order in (1, 2))
    rates, fitted = _exponentials(pulse, steps, float(twice.max()))
    table = np.column_stack([twice, once - twice, fitted])
    of_wave = interpolated(table)
    values = np.stack([of_wave(row) for row in waves])
    mean, first = _mean_weights(spread, layers, steps)
    late = np.ascontiguousarray(values[..., 0])
    early = np.ascontiguousarray(values[..., 1])
    late[0, 0] = mean[0]
    early[0, 0] = first[min(1, steps)]
    weights = np.ascontiguousarray(values[..., 2:])
    return LayeredKernel(slowest, rates, weights, late, early, mean, first)


def uniform_rise(spread: float, layers: Layering) -> float:
    """Return κT/q̇ of a uniform flux since a time t, m; `spread` is D t, m²."""
    return float(_integral(1, 0.0, spread, layers, np.ones(1))[0])


def _transform(square: Any, p: Complex, spread: float, layers: Layering) -> Complex:
    """Return F, m, of waves with q², 1/m²; p is per step, `spread` is D Δt, m²."""
    return steady_response(square, 1j * p / spread, layers)


def _integral(order: int, square: Any, spread: float, layers: Layering, time: Array) -> Array:
    """Return the integral over time, or that of it for `order` 2, of the temperature by a pulse of heat."""
    return inverse(lambda p: _transform(square, p, spread, layers) / p**order, time)


def _exponentials(
    pulse: Callable[[Array], Array], steps: int, latest: float
) -> tuple[Array, Array]:
    """Return rates (terms,) and weights (nodes, terms) of a kernel for times from 1 to `steps`.

    `latest` is the largest response to heat of the latest step: less than a part of it is nothing.
    """
    last = max(float(steps), 2.0)
    times = np.geomspace(1.0, last, max(60, math.ceil(_TIMES_PER_E_FOLD * math.log(last))))
    between = np.sqrt(times[1:] * times[:-1])
    root = np.sqrt(times)[:, None]
    kernel = pulse(times).T * root
    unseen = pulse(between).T * np.sqrt(between)[:, None]
    scale = max(latest, float(np.abs(kernel).max()))
    for terms in _TERMS:
        rates = np.geomspace(_SLOWEST / last, _FASTEST, terms)
        weights = np.linalg.lstsq(np.exp(-np.outer(times, rates)) * root, kernel, rcond=_CUT)[0]
        values = np.exp(-np.outer(between, rates)) * np.sqrt(between)[:, None] @ weights
        error = float(np.abs(values - unseen).max())
        if error <= _KERNEL_ERROR * scale:
            return rates, weights.T
    raise ConvergenceError(
        f"memory of the heat under a skin over {steps} steps: no sum of {terms} exponentials comes within "
        f"{_KERNEL_ERROR:g} of it; take fewer steps",
        error / scale,
        terms,
    )


def _mean_weights(spread: float, layers: Layering, steps: int) -> tuple[Array, Array]:
    """Return ∫ K f du for f linear between whole steps: of f, m = 0 … `steps` before the end, and of f(0) after n."""
    near = np.arange(1.0, min(_NEAR, steps) + 2)
    once, twice = (np.append(0.0, _integral(order, 0.0, spread, layers, near)) for order in (1, 2))
    mean = np.append(twice[1], twice[2:] - 2 * twice[1:-1] + twice[:-2])
    first = np.append(0.0, once[1:-1] - np.diff(twice)[:-1])
    if steps > _NEAR:
        far = np.arange(_NEAR + 1.0, steps + 1)
        nodes, interpolated = interpolation(_NEAR, 2.0 * steps)
        # a hat of two steps, and a ramp from 0 to 1 over the last step, in p times the step
        hat = inverse(
            lambda p: _transform(0.0, p, spread, layers) * (2 * np.sinh(p / 2) / p) ** 2, nodes
        )
        ramp = inverse(
            lambda p: _transform(0.0, p, spread, layers) * (p + np.expm1(-p)) / p**2, nodes
        )
        # over 1/√time they change slowly
        both = np.column_stack([hat, ramp]) * np.sqrt(nodes)[:, None]
        values = interpolated(both)(far) / np.sqrt(far)[:, None]
        mean = np.append(mean, values[:, 0])
        first = np.append(first, values[:, 1])
    return mean, first
