"""Pressure of the waves of an uneven contact: at their own wavenumber, and beside it.

With κ and P of `theory.interface`, a wave of q and height dh makes the pressure κ dh. κ differs from place to place
with the coarser waves, so that the wave makes pressure at its own q and at |q + k|, k < q:

    coherent     C ⟨κ⟩² [1 + 2 Σ_K N (ρ − 1)],   ρ = mean over angles of [g(|q + K|)/g(q)]^ANSWER
    sidebands    2πqC dq ⟨κ⟩² N(q, K) at Q = |q + K|, times [g(Q)/g(q)]^(2 ANSWER),   uniform in angle

⟨κ⟩² N(q, K) is the variance of κ(q) at the wavenumber K. Shell k makes the part V(q, k) of it: the mean of κ(q), given
the pressure at k, is a martingale, and obeys the adjoint of the forward equation. The waves of that part are modulated
by coarser ones as the pressure of k is: a share V(q, k)/⟨κ²⟩ of the pressure of q has a wave k added to it, a share of
this a further wave k′, as vector sums with random directions. The half-space behind a mean interface responds with
g(Q) = 1/(⟨c⟩ + 2/E*Q), ⟨c⟩ = ⟨κ⟩/⟨κ²⟩ − 2/E*q. Where 2 Σ_K N (ρ − 1) is negative, 1/(1 + |sum|) stands for the bracket.
Both parts are scaled so that without the responses g they add up to the growth ⟨κ²⟩ dv.
"""

from math import pi
from typing import NamedTuple

import numpy as np

from theory.arguments import Array
from theory.interface import Diffusion, backwards, between_shells, carried_back

ANSWER = 0.8  # power of g(Q)/g(q) with which the half-space answers beside q: 1 to second order
BIN = 0.125  # of ln q, in which sidebands are counted
_ANGLES = 48
_BELOW = 1.0  # e-folds below q_min down to which sidebands are resolved; below they are constant
_ABOVE = 2.5  # and above q_max
_FURTHER = 20  # bins above q that the sums of waves up to q can reach
_LAST = 1e-4  # of the sidebands is cut off at the upper end
_FAINT = 1e-2  # the least weight of a bin of sidebands, for bins that hardly a wave reaches
_NOTHING = 1e-14  # of the largest variance of a bin: full contact has no sidebands, but they have a logarithm


class ScatteringTable(NamedTuple):
    """A logarithm over ln q, and how much each entry counts in a fit."""

    place: Array  # ln q, rising
    value: Array
    weight: Array


class Shares(NamedTuple):
    """Variance of the pressure by the shells of waves between wavenumbers, n shells."""

    place: Array  # ln q of each shell, rising, (n,)
    grown: Array  # by which each raises the variance of the pressure, Pa², (n,)
    kept: Array  # of it at its own wavenumber, Pa², (n,)
    beside: Array  # at each ln Q of `grid`, over `grown`, (n, m)
    grid: Array  # uniform, (m,)
    full: Array  # what each raises it by in full contact, Pa², (n,)
    compliance: Array  # ⟨c⟩ of the interface there, m/Pa, (n,)


class Scattering(NamedTuple):
    """Pressure of the waves by wavenumber."""

    coherent: ScatteringTable  # |σ_q|²/[(E*q/2)² C]
    sidebands: ScatteringTable  # |σ_Q|², Pa² m²
    compliance: tuple[Array, Array]  # ln q, rising, and ⟨c⟩ of the interface there, m/Pa


def scatter(diffusion: Diffusion, modulus: float) -> Scattering:
    """Return the pressure of the waves at their own wavenumber and beside it; E* in Pa."""
    x, grown, kept, sides, grid, full, compliance = shares_of(diffusion, modulus)
    logs = np.log(diffusion.wavenumber)
    values = np.pad(np.log(kept / full), 1, mode="edge")
    values[0] = 1.5 * values[1] - 0.5 * values[2]
    weight = np.pad(np.sqrt(np.maximum(kept / kept.max(), _FAINT**2)), 1, mode="edge")
    coherent = ScatteringTable(np.concatenate([logs[:1], x, logs[-1:]]), values, weight)
    return Scattering(coherent, _density(grid, grown @ sides), (x, compliance))


def shares_of(diffusion: Diffusion, modulus: float) -> Shares:
    """Return where each shell puts the pressure that it adds; E* in Pa."""
    logs = np.log(diffusion.wavenumber)
    x = (logs[1:] + logs[:-1]) / 2  # a shell of waves between any two wavenumbers
    q = np.exp(x)
    mean_pressure = diffusion.pressure @ diffusion.probability[0]
    total = diffusion.probability @ (diffusion.pressure - mean_pressure) ** 2
    grown = np.diff(total)
    full = between_shells((modulus * diffusion.wavenumber / 2) ** 2, diffusion.variance)
    mean = middle(np.einsum("ij,ij->i", diffusion.probability, diffusion.stiffness))
    square = middle(np.einsum("ij,ij->i", diffusion.probability, diffusion.stiffness**2))
    uneven = np.diff(stiffness_variance(diffusion), axis=1)  # V(q, k), k in the same shells
    whole = mean**2 + uneven.sum(axis=1)
    own = mean**2 / whole  # before the response g, coherent part and sidebands add up to the growth
    grid = np.arange(x[0] - _BELOW, x[-1] + _ABOVE, BIN)
    sides = beside(x, own, uneven / whole[:, None], grid)
    compliance = np.maximum(mean / square - 2 / (modulus * q), 0.0)
    own_softness, softness = (
        compliance[:, None] + 2 / (modulus * at) for at in (q[:, None], np.exp(grid))
    )  # 1/g(q), 1/g(Q)
    response = (own_softness / softness) ** ANSWER
    change = 2 * np.sum(sides * (response - 1), axis=1) / own
    factor = np.where(change < 0.0, 1 / (1 + np.abs(change)), 1 + change)
    return Shares(x, grown, own * grown * factor, sides * response**2, grid, full, compliance)


def middle(values: Array) -> Array:
    """Return the means of neighbours."""
    return (values[1:] + values[:-1]) / 2


def beside(x: Array, own: Array, share: Array, grid: Array) -> Array:
    """Return the part of the pressure of each shell at each ln Q of a uniform `grid`, beside its own ln q = `x`.

    κ of a shell holds the share `own` that is the same everywhere, and `share` (shell, k) of waves k. These waves are
    modulated as the pressure of k is: part `own` of them lies at k, the rest beside it.
    """
    count = grid.size
    table = sums_of_waves(count)
    at = (x - grid[0]) / BIN
    low, part = at.astype(np.intp), at - at.astype(np.intp)
    rows = np.arange(x.size)
    lies = np.zeros((x.size, count))  # all the pressure of a shell
    lies[rows, low], lies[rows, low + 1] = 1 - part, part
    result = np.zeros((x.size, count))
    for i in range(x.size):
        end = min(low[i] + _FURTHER, count)  # hardly a sum of waves up to q is longer
        # waves of the shell itself are modulated like the waves of the shell before
        waves = share[i, :i] @ lies[:i, :end] + share[i, i] * lies[max(i - 1, 0), :end]
        for bin_of_q, weight in ((low[i], 1 - part[i]), (low[i] + 1, part[i])):
            start = count - bin_of_q
            result[i, :end] += weight * (waves @ table[start : start + end, start : start + end])
        result[i, 0] += waves.sum() - result[i].sum()  # the part below the grid
        lies[i] = own[i] * lies[i] + result[i]
    return result


def sums_of_waves(count: int) -> Array:
    """Return the chance of ln |q + k| in bins from ln q, by ln k in bins from ln q: both from −count to count − 1."""
    apart = np.arange(-count, count)
    steep = np.exp(BIN * apart)[:, None]
    at = (
        np.log(1 + steep**2 + 2 * steep * np.cos((np.arange(_ANGLES) + 0.5) * pi / _ANGLES))
        / (2 * BIN)
        + count
    )
    low = np.clip(at.astype(np.intp), 0, 2 * count - 2)
    part = np.clip(at - low, 0.0, 1.0)
    result = np.zeros((2 * count, 2 * count))
    rows = np.broadcast_to(np.arange(2 * count)[:, None], low.shape)
    np.add.at(result, (rows, low), (1 - part) / _ANGLES)
    np.add.at(result, (rows, low + 1), part / _ANGLES)
    return result


def stiffness_variance(diffusion: Diffusion) -> Array:
    """Return the variance of κ in the middle of each shell that waves up to each wavenumber make, (Pa/m)².

    Its shape is (shells, wavenumbers). κ there is carried back as its mean at each coarser wavenumber, given the
    pressure there, by implicit steps of the first order.
    """
    stiffness, probability = diffusion.stiffness[:, 1:-1], diffusion.probability[:, 1:-1]
    here, there = middle(stiffness), middle(probability)
    square = np.einsum("ij,ij->i", there, here**2)
    mean = np.einsum("ij,ij->i", there, here)
    from_middle, steps = (
        backwards(growth, diffusion.gap) for growth in (diffusion.growth / 2, diffusion.growth)
    )
    carried = np.empty(here.shape).T
    result = np.repeat(square[:, None], mean.size + 1, axis=1)
    for i in range(mean.size - 1, -1, -1):
        carried[:, i] = carried_back(here[i], from_middle[i])
        result[i:, i] = probability[i] @ carried[:, i:] ** 2
        if i:
            carried[:, i:] = carried_back(carried[:, i:], steps[i - 1])
    return np.maximum.accumulate(np.maximum(result - mean[:, None] ** 2, 0.0), axis=1)


def _density(grid: Array, held: Array) -> ScatteringTable:
    """Return ln of the density per area of wavenumbers of the power `held` at each ln q of a uniform grid."""
    total = held.sum()
    highest = held.max()
    last = int(np.searchsorted(np.cumsum(held), (1 - _LAST) * total)) + 1
    place = grid[:last]
    power = held[:last]
    area = 2 * pi * np.exp(2 * place) * BIN
    area[0] = pi * np.exp(2 * grid[0])  # of the whole disc below
    least = _NOTHING * highest + np.finfo(float).tiny
    density = np.maximum(power, least) / area
    weight = np.ones(last)
    if held.any():
        weight = np.sqrt(np.maximum(power / highest, _FAINT**2))
    return ScatteringTable(place, np.log(density), weight)
