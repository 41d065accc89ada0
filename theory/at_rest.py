"""Temperature of a contact at rest: it walks with the pressure over the magnifications, without chance and constant.

A wave of pressure at Q makes the temperature σ_Q/Q at rest, in units of μv/κ_th. A shell i of the waves of
`theory.interface`, at q_i, adds dσ = κ dh to the pressure of a place; `theory.scattering` says which parts s_Q of its
variance lie at which Q, q_i itself among them. Given dσ, the temperature of the same waves is normal:

    dT = β_i dσ + noise,    β_i = Σ s_Q/Q,    variance of the noise  s_Q (1/Q − β_i)² (dσ)²  from each Q.

Waves with Q ≥ q_i are as strong as the place makes them, (dσ)² = ∫ κ² dv. Those with Q < q_i are even over places that
differ less than 1/Q: their noise is laid at the shell of Q, with the mean of (dσ)² given the pressure there. So
⟨σT⟩ = Σ|σ_Q|²/Q. With the characteristic function f(σ; w) = ⟨e^{iwT}; σ⟩ a shell takes f = e^{iwβσ} g to

    g ← e^{−w²n/4} (1 − L + L²/2)⁻¹ e^{−w²n/4} g,    L the diffusion of the pressure, n(σ) the variance of the noise.

A cell of side L_c holds no waves with Q < 2√π/L_c, whose share of its wavenumbers the mean has.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, sqrt

import numpy as np
import scipy
from numpy.typing import ArrayLike

from theory.arguments import Array
from theory.interface import Diffusion, diffuse
from theory.scattering import BIN, Shares, carried_back, shares_of
from theory.yielding import YieldingSpectrum

_STEP, _SPACING = 0.02, 0.05  # of ln v and ln q, and of z of `theory.interface`
_WAVES = 257  # w, from 0 on
_BELOW, _ABOVE = 6.0, 7.0  # T of the period of the transform, in standard deviations, and of T_flash


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
    characteristic: Array

    def joint(self) -> tuple[Array, Array]:
        """Return temperatures T, (k,), and the probability of each pressure and T, (m, k)."""
        count = 2 * (self.characteristic.shape[1] - 1)
        found = scipy.fft.irfft(np.conj(self.characteristic), n=count, axis=1)
        return self.start + self.period / count * np.arange(count), found

    def over_flash(self, share: ArrayLike) -> Array:
        """Return T/T_flash below which each `share`, 0 to 1, of the heat is set free."""
        temperature, density = self.joint()
        heat = np.maximum(self.pressure @ density, 0.0)
        heat /= heat.sum()
        below = np.cumsum(heat)
        flash = temperature @ heat
        step = temperature[1] - temperature[0]
        return np.interp(share, below, temperature + step / 2) / flash


def at_rest(
    law: YieldingSpectrum, length: float, *, step: float = _STEP, spacing: float = _SPACING
) -> AtRest:
    """Walk over the magnifications of a contact in a cell of side `length`, m."""
    mean, hardness = law.nominal_pressure, law.penetration_hardness
    diffusion = diffuse(
        law.spectrum, law.effective_modulus, mean, hardness, step=step, spacing=spacing
    )
    shares = shares_of(diffusion, law.effective_modulus)
    slope, own, sides = _split(shares, 2 * sqrt(pi) / length)
    noise = _noise(diffusion, shares, own, sides)
    q = np.exp(shares.place)
    present = np.exp(shares.grid) >= 2 * sqrt(pi) / length
    each = shares.beside * present / np.exp(shares.grid)
    flash = float((shares.kept / q + shares.grown * each.sum(axis=1)).sum()) / mean
    each /= np.exp(shares.grid)
    deviation = sqrt(float((shares.kept / q**2 + shares.grown * each.sum(axis=1)).sum()))
    start = -_BELOW * deviation
    period = _ABOVE * (flash + deviation) - start
    w = 2 * pi / period * np.arange(_WAVES)
    found = _walk(diffusion, slope, noise, w)
    pressure = diffusion.pressure + (mean - diffusion.pressure @ diffusion.probability[0])
    return AtRest(pressure, start, period, found * np.exp(-1j * w * start))


def _split(shares: Shares, least: float) -> tuple[Array, Array, Array]:
    """Return β of each shell, m, and its noise over its growth at its own q, (n,), and beside it, (n, Q), m²."""
    q, beside = np.exp(shares.place), np.exp(shares.grid)
    kept = shares.kept / shares.grown
    sides = shares.beside * (beside >= least)
    slope = kept / q + sides @ (1 / beside)
    own = kept * (1 / q - slope) ** 2
    return slope, own, sides * (1 / beside - slope[:, None]) ** 2


def _noise(diffusion: Diffusion, shares: Shares, own: Array, sides: Array) -> Array:
    """Return the variance of the noise laid at each shell and pressure, m² Pa², (n + 1, m); the first before all."""
    logs = np.log(diffusion.wavenumber)
    coarse = shares.grid[None, :] < shares.place[:, None]
    local = own + np.where(coarse, 0.0, sides).sum(axis=1)
    result = np.zeros((local.size + 1, diffusion.pressure.size))
    result[1:] = local[:, None] * diffusion.growth
    laid = np.searchsorted(logs, shares.grid, side="right") - 1  # shell of each Q, −1 before all
    sides = np.where(coarse, sides, 0.0)
    strength = np.zeros((diffusion.pressure.size, shares.grid.size))
    for i in range(local.size - 1, -1, -1):
        at = (laid == i)
        strength = carried_back(strength, diffusion.growth[i], diffusion.rates)
        result[i + 1] += strength[:, at].sum(axis=1)
        strength[:, at] = 0.0
        strength += diffusion.growth[i][:, None] * sides[i] * ~at
        result[i + 1] += (diffusion.growth[i][:, None] * sides[i] * at).sum(axis=1)
    result[0] = strength.sum(axis=1)
    return result


def _walk(diffusion: Diffusion, slope: Array, noise: Array, w: Array) -> Array:
    """Return ⟨e^{iwT}; σ⟩ at the end of the walk, shape (m, w)."""
    pressure = diffusion.pressure - diffusion.pressure @ diffusion.probability[0]
    up, down = diffusion.rates
    g = diffusion.probability[0][:, None] * np.exp(-noise[0][:, None] * w**2 / 2)
    before, spread = 0.0, np.zeros(pressure.size)
    for growth, beta, added in zip(diffusion.growth, slope, noise[1:], strict=True):
        turn = 1j * (before - beta) * pressure[:, None] * w
        g = g * np.exp(turn - (spread + added)[:, None] * w**2 / 4)
        before, spread = beta, added
        below, above = (growth * up)[:-1] + 0j, (growth * down)[1:] + 0j
        diagonal = -growth * (up + down) - (1 + 1j)
        parts = np.concatenate([g.real, g.imag], axis=1)
        solved = 2 * scipy.linalg.lapack.zgtsv(below, diagonal, above, parts + 0j)[3].imag
        g = solved[:, : w.size] + 1j * solved[:, w.size :]
    return g * np.exp(1j * before * pressure[:, None] * w - spread[:, None] * w**2 / 4)
