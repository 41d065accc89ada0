"""Contact as a pressure that diffuses while finer roughness yields to it: the law between mean gap and local pressure.

σ(x; q) is the pressure at x averaged over all roughness finer than q, d(σ; q) the mean gap that this roughness keeps
at the local pressure σ. A wave of q, of height dh, meets that interface and the half-space in series:

    δσ = κ dh,    1/κ = c + 2/(E*q),    c(σ; q) = −∂d/∂σ, the compliance of the waves beyond q.

The mean over one shell of waves, dv = 2π q C dq, gives two equations and nothing else:

    backwards from q_max    ∂c/∂v = ½ ∂/∂σ [κ² ∂c/∂σ],     v(q) = 2π ∫ k C dk from q to q_max
    forwards from q_min     −∂P/∂v = ½ ∂²/∂σ² [κ² P],      P = δ(σ − σ₀) at q_min

At q_max stand hard walls: c = 0 for 0 < σ < σ_P, and σ can reach neither wall before. P is the probability of the local
pressure; its mean stays σ₀, and its variance grows by ⟨κ²⟩ dv. For κ = E*q/2 everywhere this is Persson's diffusion.

The pressures are σ = σ_P Φ(z) on a uniform grid of z, with a node at σ₀. There c = √v E/(σ_P φ(z)), and E is 1
wherever roughness is stiff against the half-space; E obeys, with t = ln v and m = 2σ_P φ/(E*q √v),

    ∂E/∂t = −E/2 + ½ ∂/∂z [(∂E/∂z + zE)/(m + E)²].
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import ceil, isinf, pi, sqrt
from typing import Any

import numpy as np
import scipy
from scipy.special import ndtr, ndtri

from theory.arguments import Array, SpectrumLike, breaks_of, density

_FURTHEST = 6.5  # of z on both sides: the pressures run from 4e-11 σ_P to σ_P less that
# With half of _SPACING, of STEP and of the bins and angles of theory.scattering, T_flash of 91 contacts changes by .4 %
# (rms; 1.1 % at most), g_σ(0) by .3 % (1.2 %), the contact area by .4 % (1.4 %); g_σ(0) stays for q_max → ∞.
_SPACING = 0.2  # of z
STEP = 0.25  # in ln v and ln q
UNREACHED = 7.0  # standard deviations of the full-contact pressure above σ₀: no pressure is higher
_SMOOTHED = 3e-3  # the walls start smoothed by the waves of the last .3 % of an e-fold: they would be jumps otherwise
# steps of ln v are so many times finer at q_min, where P is a point and spreads at once; it fades as (v/v(q_min))²
_FIRST = 8.0
_FINE = 400  # points of the tables a piece between breaks
_GAMMA = 1 - 1 / sqrt(2)  # Rosenbrock's second-order step that damps all stiff modes
_Matrix = tuple[Array, Array, Array]


@dataclass(frozen=True, slots=True, eq=False)
class Diffusion:
    """The local pressure at each wavenumber; n wavenumbers, m pressures."""

    wavenumber: Array  # q, rad/m, rising, (n,)
    variance: Array  # v, height variance of the waves beyond q, m², (n,)
    pressure: Array  # σ, Pa, rising, (m,)
    stiffness: Array  # κ, Pa/m, (n, m)
    probability: Array  # of each pressure, (n, m); rows sum to 1, their mean is σ₀
    growth: Array  # ∫ κ² dv from each wavenumber to the next, Pa², (n − 1, m)
    gap: Array  # from each pressure to the next, Pa, (m − 1,)


def diffuse(
    spectrum: SpectrumLike,
    modulus: float,
    pressure: float,
    hardness: float,
    *,
    step: float = STEP,
    spacing: float = _SPACING,
) -> Diffusion:
    """Solve both equations for checked numbers: C(q) in m⁴, E*, σ₀ and σ_P in Pa; σ_P = ∞ is elastic contact."""
    wavenumber, variance, spread = _shells(spectrum, modulus, step)
    if isinf(hardness):
        pressure = min(
            pressure, UNREACHED * spread
        )  # contact is full: more load changes no stress but the mean
    highest = min(hardness, pressure + UNREACHED * spread)
    start = float(ndtri(pressure / highest))
    below, above = ceil((start + _FURTHEST) / spacing), ceil((_FURTHEST - start) / spacing)
    z: Array = start + spacing * np.arange(-below, above + 1, dtype=np.float64)
    ramp = 2 * highest / (modulus * wavenumber)  # 2σ_P/(E*q), m
    bell = np.exp(-(z**2) / 2) / sqrt(2 * pi)
    compliance = np.sqrt(variance)[:, None] * interface_law(z, variance, ramp)  # times σ_P φ
    stiffness = highest * bell / (ramp[:, None] * bell + compliance)
    stiffness[:, [0, -1]] = 0.0  # the walls absorb
    growth = between_shells(stiffness**2, variance)
    # without cancellation at either end
    gap = highest * np.where(z[:-1] < 0, np.diff(ndtr(z)), -np.diff(ndtr(-z)))
    probability = np.zeros(stiffness.shape)
    probability[0, below] = 1.0
    for i, matrix in enumerate(forwards(growth, gap)):
        probability[i + 1] = diffused(probability[i], matrix)
    return Diffusion(wavenumber, variance, highest * ndtr(z), stiffness, probability, growth, gap)


def _shells(spectrum: SpectrumLike, modulus: float, step: float) -> tuple[Array, Array, float]:
    """Return wavenumbers, v there, and the standard deviation of the pressure in full contact, √(2G)."""
    breaks = breaks_of(spectrum)
    pieces = [np.geomspace(low, high, _FINE + 1) for low, high in pairwise(breaks)]
    share, weights = np.polynomial.legendre.leggauss(2)
    logs = np.log(np.unique(np.concatenate(pieces)))
    width = np.diff(logs)
    inner = np.exp(logs[:-1, None] + width[:, None] * (1 + share) / 2)
    power = (
        2 * pi * inner**2 * density(spectrum, inner) @ weights / 2 * width
    )  # 2π ∫ q C dq of each interval
    square = np.exp(2 * (logs[:-1] + width / 2))  # q² at its middle
    spread = sqrt(modulus**2 / 4 * float(np.sum(power * square)))
    end = np.array(breaks[-1:])  # and not exp(ln q_max): rounding may put it beyond C(q), at C = 0
    last = 2 * pi * float((end**2 * density(spectrum, end))[0]) * _SMOOTHED
    beyond = np.append(np.cumsum(power[::-1])[::-1], 0.0)
    table = max(last, _SMOOTHED * power[-1]) + beyond  # v at each of `logs`
    log_variance = np.log(table)
    finer = 1 + (_FIRST - 1) * (table[:-1] / table[0]) ** 2
    steps = np.maximum(-finer * np.diff(log_variance), width) / step
    count = np.append(0.0, np.cumsum(steps))
    even = np.linspace(0.0, count[-1], ceil(count[-1]) + 1)
    at = np.interp(even, count, logs)
    variance = np.exp(np.interp(at, logs, log_variance))
    return np.exp(at), variance, spread


def interface_law(z: Array, variance: Array, ramp: Array) -> Array:
    """Return E at each wavenumber and pressure, shape (variance, z): 1 for stiff roughness, 0 in full contact.

    Parameters
    ----------
    z : ndarray
        Φ⁻¹(σ/σ_P), uniform.
    variance, ramp : ndarray
        v in m² and 2σ_P/(E*q) in m of each shell, both falling.
    """
    spacing = z[1] - z[0]
    first = z[0] - spacing / 2
    last = z[-1] + spacing / 2
    middle = np.concatenate([[first], (z[1:] + z[:-1]) / 2, [last]])
    bell = np.exp(-(middle**2) / 2) / sqrt(2 * pi)
    steps = np.log(variance[:-1] / variance[1:])
    mean_variance = np.sqrt(variance[:-1] * variance[1:])
    series = bell * np.sqrt(ramp[:-1] * ramp[1:] / mean_variance)[:, None]  # m
    drift = middle / 2 + 1 / spacing, middle / 2 - 1 / spacing
    result = np.empty((variance.size, z.size))
    result[-1] = _walls(z, ramp[-1] / sqrt(variance[-1]))
    for i in range(variance.size - 2, -1, -1):
        result[i] = _rosenbrock(result[i + 1], steps[i], drift, series[i], spacing)
    return result


def _walls(z: Array, ramp: float) -> Array:
    """Return E of hard walls `ramp` apart, smoothed by waves of unit variance: an exact bed of springs.

    Its tails, E up to 1.6, are cut to 1, the limit of stiff roughness, which the next waves lead to in any case.
    """
    x = np.concatenate([np.linspace(-9, 9, _FINE), np.linspace(-9, 9, _FINE) - ramp])
    if ramp > 18.0:
        x = np.concatenate([x, np.linspace(9 - ramp, -9, 60)])
    x = -np.sort(-x)  # falling, so that the pressure rises

    def touched(t: Array) -> Array:
        return np.exp(-(t**2) / 2) / sqrt(2 * pi) - t * ndtr(-t)

    lower = x > -ramp / 2  # each half from its own wall: nothing cancels
    low = touched(x) - touched(x + ramp)
    high = touched(-x - ramp) - touched(-x)
    above = ndtr(x)
    below = ndtr(-x - ramp)
    free = above + below
    inside = np.where(lower, ndtr(-x) - below, ndtr(x + ramp) - above)
    tiny = np.finfo(float).tiny
    from_low = ndtri(np.clip(low / ramp, tiny, 0.5))
    from_high = ndtri(np.clip(high / ramp, tiny, 0.5))
    position = np.where(lower, from_low, -from_high)
    ratio = np.log(np.maximum(free, tiny)) - np.log(np.maximum(inside, tiny))  # ln of c E*q/2
    compliance = np.exp(np.interp(z, position, ratio))
    law = compliance * ramp * np.exp(-(z**2) / 2) / sqrt(2 * pi)
    return np.asarray(np.minimum(law, 1.0))


def _rosenbrock(
    law: Array, step: float, drift: tuple[Array, Array], series: Array, spacing: float
) -> Array:
    """Return E one `step` of ln v further: second order, no limit on the step.

    `series` is m at the midpoints; `drift` are the factors there of E at the next higher and lower z in ∂E/∂z + zE.
    """
    of_higher, of_lower = drift
    each = step / (2 * spacing)

    def flux(values: Array) -> tuple[Array, Array]:
        wide = np.concatenate((values[:1], values, values[-1:]))
        higher = wide[1:]
        lower = wide[:-1]
        share = 1 / (series + 0.5 * (higher + lower))
        return (of_higher * higher + of_lower * lower) * (share * share), share

    def change(values: Array, through: Array) -> Array:
        return (through[1:] - through[:-1]) * each - values * (step / 2)

    through, share = flux(law)
    square = share * share
    falls = through * share  # as E of either side grows
    scale = _GAMMA * each
    later = (of_higher * square - falls) * scale
    earlier = (of_lower * square - falls) * scale
    here = (1 + _GAMMA * step / 2) + later[:-1] - earlier[1:]
    here[0] += earlier[0]
    here[-1] -= later[-1]
    matrix = (earlier[1:-1], here, -later[1:-1])
    first = scipy.linalg.lapack.dgtsv(*matrix, change(law, through))[3]
    middle = law + first
    through, _ = flux(middle)
    second = scipy.linalg.lapack.dgtsv(*matrix, change(middle, through) - 2 * first)[3]
    return np.asarray(law + 1.5 * first + 0.5 * second)


def between_shells(square: Array, variance: Array) -> Array:
    """Return ∫ κ² dv from each row to the next: a power of v between them, exact for full contact with C ~ q^n."""
    safe = np.maximum(square, 1e-100 * square.max())
    column = (-1, *[1] * (square.ndim - 1))
    volume = safe * variance.reshape(column)  # κ²v
    before = volume[:-1]
    after = volume[1:]
    ratio = np.log(before / after)
    fall = np.log(variance[:-1] / variance[1:]).reshape(column)
    level = np.abs(ratio) < 1e-6
    logarithmic = (before - after) / np.where(level, 1.0, ratio)
    mean = np.where(level, after, logarithmic)
    return np.where(square[:-1] > 0.0, mean * fall, 0.0)


def forwards(growth: Array, gap: Array) -> list[_Matrix]:
    """Return the diagonals of L − 1 − i, from the lowest, for each row of ∫ κ² dv: L spreads the probability by it."""
    both = gap[1:] + gap[:-1]
    up, down = (np.pad(1 / (each * both), 1) for each in (gap[1:], gap[:-1]))
    below = (growth * up)[:, :-1] + 0j
    diagonal = -growth * (up + down) - (1 + 1j)
    above = (growth * down)[:, 1:] + 0j
    return list(zip(below, diagonal, above, strict=True))


def diffused(values: Any, matrix: _Matrix) -> Any:
    """Return `values`, (pressures, ...), after the pressure has spread by one of the matrices of `forwards`.

    (1 − L + L²/2)⁻¹ is the difference of two complex solves, conjugate to each other for real values.
    """
    below, diagonal, above = matrix
    first = scipy.linalg.lapack.zgtsv(below, diagonal, above, values)[3]
    if np.isrealobj(values):
        return 2 * first.imag
    second = scipy.linalg.lapack.zgtsv(below, diagonal.conj(), above, values)[3]
    return -1j * (first - second)


def backwards(growth: Array, gap: Array) -> list[_Matrix]:
    """Return w, and the diagonals of w (1 − L), for each row of ∫ κ² dv: L is the adjoint of that of `forwards`.

    It is between the walls; w makes it symmetric.
    """
    weight = (gap[1:] + gap[:-1]) / growth[:, 1:-1]
    diagonal = weight + (1 / gap[1:] + 1 / gap[:-1])
    beside = -1 / gap[1:-1]
    return [(*both, beside) for both in zip(weight, diagonal, strict=True)]


def carried_back(values: Array, matrix: _Matrix) -> Any:
    """Return the mean of `values`, (pressures between the walls, ...), given the pressure one implicit step before.

    It is of the first order, for values that vanish at the walls, by one of the matrices of `backwards`.
    """
    weight, diagonal, beside = matrix
    weighted = (weight * values.T).T
    return scipy.linalg.lapack.dptsv(diagonal, beside, weighted, overwrite_b=True)[2]
