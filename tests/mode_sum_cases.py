"""Full contact of two sliding bodies of few waves, whose stress is known mode by mode: heights, and exact T_flash."""

from math import hypot, pi

import numpy as np

from roughsim.sliding.path import ACROSS

CELL, E = 1e-3, 1e9
HIGHEST = 4  # waves per cell
LOAD = E * 1e-6 * 2 * pi / CELL * HIGHEST * 3


def waves(count, seed, rms=1e-6):
    """A few waves, the same on every grid."""
    rng = np.random.default_rng(seed)
    x = np.arange(count) / count * 2 * pi
    pairs = [
        (i, j) for i in range(-HIGHEST, HIGHEST + 1) for j in range(HIGHEST + 1) if j > 0 or i > 0
    ]
    heights = sum(
        np.cos(i * x[:, None] + j * x + rng.uniform(0, 2 * pi)) / (i * i + j * j) for i, j in pairs
    )
    return rms * heights / heights.std()


def response(body, square, drift):
    """T/q̇ of waves under which the contact moves with q·v = `drift`, K m²/W."""
    below = np.sqrt(square - 1j * drift / body.diffusivity)
    if body.skin is None:
        return 1 / (body.conductivity * below * (1 + below * body.heat_depth))
    d, kappa, diffusivity = body.skin
    within = np.sqrt(square - 1j * drift / diffusivity)
    outer, inner, lag = body.conductivity * below, kappa * within, np.tanh(within * d)
    h = body.heat_depth
    if not h:
        return (inner + outer * lag) / (inner * (outer + inner * lag))
    # reciprocity: the mean, over the depth of release, of the temperature by heat at the surface
    z, weights = np.polynomial.legendre.leggauss(60)
    total = 0.0
    at = d * (1 + z) / 2
    surface = (inner + outer * lag) / (inner * (outer + inner * lag))
    for depth, weight in zip(at, weights * d / 2 * np.exp(-at / h) / h, strict=True):
        total = total + weight * (
            surface * np.cosh(within * depth) - np.sinh(within * depth) / inner
        )
    there = surface * np.cosh(within * d) - np.sinh(within * d) / inner
    return total + there * np.exp(-d / h) / (1 + below * h)


def mode_sum(grid, first, second, distances, speed, moving, resting):
    """T_flash of full contact in the steady state at the given positions, each wave at rest in one body."""
    qx, qy = (2 * pi * np.fft.fftfreq(n, d) for n, d in zip(grid.shape, grid.spacing, strict=True))
    square = qx[:, None] ** 2 + qy**2
    square[0, 0] = 1.0
    drift = speed * (qx[:, None] + ACROSS * qy) / hypot(1, ACROSS)
    # all heat of a wave is shared so that both temperatures agree: the responses in series
    warmed = [
        1 / (1 / response(resting, square, 0 * drift) + 1 / response(moving, square, drift)),
        1 / (1 / response(moving, square, 0 * drift) + 1 / response(resting, square, -drift)),
    ]
    still, riding = (np.fft.fft2(h) / h.size * E * np.sqrt(square) / 2 for h in (first, second))
    still[0, 0] = riding[0, 0] = 0.0
    result = []
    for s in distances:
        phase = np.exp(1j * s * (qx[:, None] + ACROSS * qy) / hypot(1, ACROSS))
        temperature = 0.3 * speed * (still * warmed[0] + riding * phase * warmed[1])
        result.append(np.sum(temperature * (still + riding * phase).conj()).real / LOAD)
    return np.array(result)
