"""The lay of a map: by how much its waves are longer along one direction than across it.

A surface whose cell is stretched by √γ along an angle, and shrunk by as much across it, has C(q′) at q⃗ with q⃗′ = (√γ q
along, q across/√γ). Of Gaussian heights each |h(q⃗)|² is exponential about its C, so −ln C − |h|²/C is its
log-likelihood (Whittle). For each γ and angle C(q′) is free: the mean of |h|² over nearby q′.
"""

from math import exp, log, pi
from typing import Any, NamedTuple

import numpy as np

from roughsim.grid import Array, Grid, Mask

_SHARE = 0.95  # of ⟨h²⟩ in the waves that count: the others are partly noise
_LEAST_MODES = 64  # fewer show no lay
_LEAST_OF_OCTAVE = 256
_ENOUGH_MODES = 8_000  # give γ within 2 %; of more every n-th counts
_FEW_MODES = 2_000  # to begin with
_WIDTH = 0.2  # of ln q′, between the values of C that are interpolated
_EVIDENT = 8.0  # of the log-likelihood; isotropic maps reach 6
_STRAIGHTEST = 100.0  # γ of waves without an end
_STRETCHES = (1.5, 3.0, 6.0, 12.0, 30.0)  # tried first, along each of `_WAYS`
_WAYS = np.exp(2j * pi * np.arange(24) / 24)


class Lay(NamedTuple):
    """The lay of the waves between two wavenumbers."""

    ratio: float  # γ of the correlation lengths along and across, ≥ 1; 1 without evidence
    angle: float  # of the long sides, radians from axis 0 towards axis 1, 0 ≤ angle < π
    low: float  # rad/m
    high: float
    evidence: float  # log-likelihood over isotropy


class _Modes(NamedTuple):
    """One mode of each conjugate pair."""

    ln_q: Array
    angle: Array
    power: Array

    def chosen(self, which: Mask | slice) -> "_Modes":
        """Return some of them."""
        return _Modes(*(values[which] for values in self))

    def thinned(self, most: int) -> "_Modes":
        """Return every n-th of them, at most so many."""
        return self.chosen(slice(None, None, 1 + self.ln_q.size // most))


def lays_of(power: Array, grid: Grid, q_max: float, least: float) -> tuple[Lay, list[Lay]]:
    """Return the lay of the longest waves that hold 95 % of ⟨h²⟩, and the lays of octaves.

    An octave is judged with half an octave on both sides, by the highest likelihood near the lay of the longest waves
    or near isotropy: in a ring, another C(q′) fits nearly as well with a far too large γ.

    Parameters
    ----------
    power : ndarray
        |h(q⃗)|² at the modes of `grid.half_shape`, in any unit.
    grid : Grid
        Points and sides of the map.
    q_max : float
        End of the waves that count, rad/m; octaves go down from it.
    least : float
        Share of ⟨h²⟩ or of ⟨|∇h|²⟩ of an octave that counts.
    """
    q = grid.wavenumbers
    qx, qy = (np.broadcast_to(component, q.shape) for component in grid.wavevectors)
    once = (q > 0.0) & (q <= q_max * (1 + 1e-9)) & ((qy > 0.0) | (qx > 0.0))
    q = q[once]
    power = power[once]
    # modes of straight grooves have no power but rounding
    angle = np.arctan2(qy[once], qx[once])
    modes = _Modes(np.log(q), angle, power / power.mean() + 1e-9)
    order = np.argsort(q)
    held = np.cumsum(power[order])
    enough = int(np.searchsorted(held, _SHARE * held[-1]))
    last = max(enough, min(2 * _LEAST_MODES, q.size) - 1)
    high = q[order[last]]
    longest = modes.chosen(q <= high * (1 + 1e-9))
    tried = [log(g) * np.array([way.real, way.imag]) for g in _STRETCHES for way in _WAYS]
    few = longest.thinned(_FEW_MODES)
    begin = min(tried, key=lambda stretch: _loss(stretch, few))
    whole = _fitted(begin, longest, float(q.min()), float(high))
    turn = 2.0 * whole.angle
    usual = log(whole.ratio) * np.array([np.cos(turn), np.sin(turn)])
    octaves = np.log2(q_max / q) + 1e-9
    index = octaves.astype(np.intp)
    count = np.bincount(index)
    heights, slopes = (np.bincount(index, weight) for weight in (power, q * q * power))
    large = (heights > least * heights.sum()) | (slopes > least * slopes.sum())
    found = []
    for k in np.flatnonzero(large & (count >= _LEAST_OF_OCTAVE)).tolist():
        around = modes.chosen(abs(octaves - (k + 0.5)) <= 1.0)
        begin = min((usual, np.zeros(2)), key=lambda stretch: _loss(stretch, around))
        found.append(_fitted(begin, around, q_max * 0.5 ** (k + 1), q_max * 0.5**k))
    return whole, found


def _fitted(begin: Array, modes: _Modes, low: float, high: float) -> Lay:
    """Return the lay of the highest likelihood near `begin`, which stands for the waves between two wavenumbers."""
    from scipy.optimize import minimize  # slow to import

    some = modes.thinned(_ENOUGH_MODES)
    simplex = begin + np.array([[0.0, 0.0], [0.2, 0.0], [0.0, 0.2]])
    options: Any = {"initial_simplex": simplex, "xatol": 5e-3, "fatol": 5e-2}
    best = minimize(_loss, begin.ravel(), (some,), method="Nelder-Mead", options=options)
    evidence = max(_loss(np.zeros(2), some) - float(best.fun), 0.0)
    evident = evidence > _EVIDENT and some.ln_q.size >= _LEAST_MODES
    ratio = min(exp(float(np.hypot(*best.x))), _STRAIGHTEST) if evident else 1.0
    turn = float(np.arctan2(best.x[1], best.x[0]))
    return Lay(ratio, 0.5 * turn % pi, low, high, evidence)


def _loss(stretch: Array, modes: _Modes) -> float:
    """Return less the log-likelihood, up to a constant, of ln γ (cos 2θ, sin 2θ)."""
    # |q′|² = q²(γ cos²(φ − θ) + sin²(φ − θ)/γ) = q²(cosh ln γ + sinh ln γ cos 2(φ − θ))
    size = min(float(np.hypot(*stretch)), log(_STRAIGHTEST))
    turned = 2.0 * modes.angle - np.arctan2(stretch[1], stretch[0])
    squares = np.cosh(size) + np.sinh(size) * np.cos(turned)
    ln_q = modes.ln_q + 0.5 * np.log(squares)
    # ln C at even steps of ln q′: the mean power about each, in which nearer modes weigh more
    at = (ln_q - ln_q.min()) / _WIDTH
    left = at.astype(np.intp)
    share = at - left
    sums = []
    for weight in (modes.power, np.ones_like(share)):
        below = np.bincount(left, (1.0 - share) * weight, left.max() + 2)
        sums.append(below + np.bincount(left + 1, share * weight, left.max() + 2))
    power, count = np.where(sums[1] > 0.0, sums, 1.0)  # a step without modes is not used
    level = np.log(power / count)
    expected = (1.0 - share) * level[left] + share * level[left + 1]
    return float(np.sum(expected + modes.power * np.exp(-expected)))
