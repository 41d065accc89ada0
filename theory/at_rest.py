"""Temperature of a contact at rest: it walks with the pressure over the magnifications, without chance and constant.

A wave of pressure at Q makes the temperature σ_Q/Q at rest, in units of μv/κ_th. A shell i of the waves of
`theory.interface`, at q_i, adds dσ = κ dh to the pressure of a place; `theory.scattering` says which parts s_Q of its
variance lie at which Q, q_i itself among them. Given dσ, the temperature of the same waves is normal:

    dT = β_i dσ + noise,    β_i = Σ s_Q/Q,    variance of the noise  s_Q (1/Q − β_i)² (dσ)²  from each Q.

Waves with Q ≥ q_i are as strong as the place makes them, (dσ)² = ∫ κ² dv. Those with Q < q_i are even over places that
differ less than 1/Q: their noise is laid at the shell of Q, with the mean of (dσ)² given the pressure there. So
⟨σT⟩ = Σ|σ_Q|²/Q. With the characteristic function f(σ; w) = ⟨e^{iwT}; σ⟩ a shell takes f = e^{iwβσ} g to

    g ← e^{−w²n/4} (1 − L + L²/2)⁻¹ e^{−w²n/4} g,    L the diffusion of the pressure, n(σ) the variance of the noise.

A cell of side L_c holds no waves with Q < 2√π/L_c: the mean has that part of the plane of wavenumbers.

Source: docs/reactions.md, which compares it with solved contacts.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, pi, sqrt

import numpy as np
import scipy
from numpy.typing import NDArray

from theory.arguments import Array
from theory.full_contact import half_variance
from theory.interface import (
    STEP,
    UNREACHED,
    Diffusion,
    backwards,
    carried_back,
    diffuse,
    diffused,
    forwards,
)
from theory.scattering import Shares, shares_of
from theory.validity import octaves_missing
from theory.yielding import YieldingSpectrum

# of z of `theory.interface`, and at σ₀ at most that many standard deviations of the pressure, for full contact: with
# wider steps the tails are too long
_SPACING, _WIDEST = 0.05, 0.14
_WAVES = 80  # w, from 0 on: with twice as many no quantile of 44 contacts changes by 1e-5
_POINTS = 1024  # T
# ends of T, which the transform repeats: standard deviations below 0, and above it these and T_flash
_BELOW, _ABOVE = 6.0, 7.0


@dataclass(frozen=True, slots=True, eq=False)
class AtRest:
    """Pressure and temperature of the places of a contact at rest; T is in μv/κ_th Pa m.

    Attributes
    ----------
    pressure : ndarray
        σ of m nodes, Pa.
    start, period : float
        T runs from `start` on, and repeats itself after the `period`.
    characteristic : ndarray
        ⟨e^{iw(T − start)}; σ⟩ at w = 2π n/period, n from 0 on, shape (m, n).
    """

    pressure: Array
    start: float
    period: float
    characteristic: NDArray[np.complex128]

    def joint(self) -> tuple[Array, Array]:
        """Return temperatures T, (k,), and the probability of each pressure and T, (m, k)."""
        found = scipy.fft.irfft(np.conj(self.characteristic), n=_POINTS, axis=1)
        return self._temperature, found

    @property
    def _temperature(self) -> Array:
        return self.start + self.period * np.linspace(0.0, 1.0, _POINTS, endpoint=False)

    def over_flash(self, share: Array) -> Array:
        """Return T/T_flash below which each `share`, 0 to 1, of the heat is set free, dimensionless."""
        heat = scipy.fft.irfft(self.pressure @ np.conj(self.characteristic), n=_POINTS)
        below = np.maximum.accumulate(np.cumsum(heat / heat.sum()))
        middle = self._temperature + self.period / _POINTS / 2
        flash = float(heat @ self._temperature / heat.sum())
        return np.asarray(np.interp(share, below, middle / flash))


def holds(law: YieldingSpectrum) -> bool:
    """Return whether the walk was compared with contacts of such a `law`: C(q) has no gaps."""
    return octaves_missing(law.spectrum) == 0.0


def at_rest(
    law: YieldingSpectrum, length: float, *, step: float = STEP, spacing: float | None = None
) -> AtRest:
    """Return pressure and temperature of a contact at rest.

    Parameters
    ----------
    law : YieldingSpectrum
        The calibrated law of the contact.
    length : float
        Side of its periodic cell, m, > 0.
    step, spacing : float, optional
        Of ln q and of z in `theory.interface`, dimensionless.
    """
    mean, modulus = law.nominal_pressure, law.effective_modulus
    spacing = spacing or _spacing(law)
    diffusion = diffuse(
        law.spectrum, modulus, mean, law.penetration_hardness, step=step, spacing=spacing
    )
    shares = shares_of(diffusion, modulus)
    least = 2 * sqrt(pi) / length
    q, beside = np.exp(shares.place), np.exp(shares.grid)
    shares = shares._replace(beside=shares.beside * (beside >= least))
    flash, square = (
        float((shares.kept / q**n + shares.grown * (shares.beside @ beside**-n)).sum())
        for n in (1.0, 2.0)
    )
    deviation = sqrt(square)
    start = -_BELOW * deviation
    period = _ABOVE * (flash / mean + deviation) - start
    w: Array = 2 * pi / period * np.arange(_WAVES, dtype=np.float64)
    found = _walk(diffusion, *_steps(diffusion, shares), w)
    pressure = diffusion.pressure + (mean - diffusion.pressure @ diffusion.probability[0])
    return AtRest(pressure, start, period, found * np.exp(-1j * w * start))


def _spacing(law: YieldingSpectrum) -> float:
    """Return the spacing of z for a contact."""
    end, mean = law.spectrum.breaks[-1], law.nominal_pressure
    half = half_variance(end, law.spectrum, effective_modulus=law.effective_modulus)
    spread = sqrt(2 * float(half))
    mean = min(mean, UNREACHED * spread)
    highest = min(law.penetration_hardness, mean + UNREACHED * spread)
    deviation = min(spread, sqrt(mean * (highest - mean)))
    z = float(scipy.special.ndtri(mean / highest))
    slope = highest * exp(-(z**2) / 2) / sqrt(2 * pi)  # dσ/dz
    return min(_SPACING, _WIDEST * deviation / slope)


def _steps(diffusion: Diffusion, shares: Shares) -> tuple[Array, Array]:
    """Return β of each shell, m, (n,), and the variance of the noise laid there at each pressure, m² Pa², (n + 1, m).

    The first row of the noise lies before all shells. That of the wavenumber of the shell itself, 2·10⁻⁴ of ⟨T²⟩, is
    left out.
    """
    beside = np.exp(shares.grid)
    slope = shares.kept / shares.grown / np.exp(shares.place) + shares.beside @ (1 / beside)
    sides = shares.beside * (1 / beside - slope[:, None]) ** 2
    return slope, _laid(diffusion, shares, sides)


def _laid(diffusion: Diffusion, shares: Shares, sides: Array) -> Array:
    """Lay the noise of each shell over its growth, from `sides` at each Q, (n, Q), m²."""
    coarse = shares.grid < shares.place[:, None]
    local = np.where(coarse, 0.0, sides).sum(axis=1)
    result = np.zeros((local.size + 1, diffusion.pressure.size))
    result[1:] = local[:, None] * diffusion.growth
    inner = result[:, 1:-1]  # at the walls nothing grows
    sides = np.where(coarse, sides, 0.0)
    edges = np.log(diffusion.wavenumber)
    shell = np.searchsorted(edges, shares.grid, side="right") - 1  # of each Q, −1 before all
    steps = backwards(diffusion.growth, diffusion.gap)
    strength = np.zeros((inner.shape[1], shell.size))
    for i in range(local.size - 1, -1, -1):
        strength = carried_back(strength, steps[i])
        strength += np.outer(diffusion.growth[i, 1:-1], sides[i])
        here = shell == i
        inner[i + 1] += strength[:, here].sum(axis=1)
        strength[:, here] = 0.0
    inner[0] = strength.sum(axis=1)
    return result


def _walk(diffusion: Diffusion, slope: Array, noise: Array, w: Array) -> NDArray[np.complex128]:
    """Return ⟨e^{iwT}; σ⟩ at the end of the walk, shape (m, w)."""
    pressure = diffusion.pressure - diffusion.pressure @ diffusion.probability[0]
    w = w[:, None]
    g = diffusion.probability[0] * np.exp(-noise[0] * w**2 / 2) + 0j  # (w, m)
    before, spread = 0.0, np.zeros(pressure.size)
    matrices = forwards(diffusion.growth, diffusion.gap)
    for matrix, beta, added in zip(matrices, slope, noise[1:], strict=True):
        g *= np.exp(1j * (before - beta) * pressure * w - (spread + added) * w**2 / 4)
        before, spread = beta, added
        g = diffused(g.T, matrix).T
    return np.asarray((g * np.exp(1j * before * pressure * w - spread * w**2 / 4)).T)
