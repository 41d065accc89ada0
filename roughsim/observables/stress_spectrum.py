"""The compact stress spectrum: the variance of the stress by wavenumber, from which every moment is summed.

Σ_q |σ(q)|² f(|q|) needs f at up to a million wavenumbers. Here f is J₀(qr) with r inside the cell, or the response
A(v/Dq)/q and the like, whose singularities in the complex plane of q lie on the imaginary axis. Either is smooth on the
scale 1/r_max, once q is many times that. So each mode is spread over uniform nodes with the weights of Lagrange's
interpolation; the few modes of longest wavelength, at which A/q is not smooth, stay as they are. The sum of f over the
compact entries then equals the sum over the modes to rounding.
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from roughsim.errors import number
from roughsim.grid import Array, Complex, Grid, Index, distinct_wavenumbers

# nodes that one mode is spread over; modes below as many node spacings are kept as they are
_STENCIL = 24
# powers of the distance from the middle of a cell, as many as in `_kernels.gathering`: for the next one J₀ has
# 0.3¹²/12! = 1e-15, responses less
_POWERS = 12
# shares of half the diagonal: within the smaller ones fewer nodes suffice
_NEARER = 1 / 8, 1 / 4, 1.0
_FOURTH, _FALLING = 0.375, 6.0  # |J₀⁗(x)| ≤ 3/8 (1 + (x/6)²)^(−1/4) at any x
_NODE_PHASE = 0.6  # node spacing times the half-diagonal; J₀ then errs by 7e-15; by 1.4e-13 at 0.7


@dataclass(frozen=True, slots=True, eq=False)
class StressSpectrum:
    """The variance of the stress by wavenumber, compact enough to be stored, and linear in |σ(q)|².

    Its wavenumbers depend on the grid alone, so spectra of one grid may be averaged entry by entry. All but the longest
    waves are spread over the 24 nodes around them. Single entries may therefore be negative; sums against J₀(qr) and
    against the response of the moving body at any speed are exact to rounding.
    """

    wavenumber: Array  # q of the entries, rad/m, > 0, increasing
    variance: Array  # share of ⟨σ²⟩ − σ₀² at each, Pa²; sums to g_σ(0)
    reach: float  # half the diagonal of the cell, m: the largest distance that the cell holds and the nodes resolve

    @property
    def pressure_variance(self) -> float:
        """g_σ(0) = ⟨σ²⟩ − σ₀², Pa²."""
        return float(self.variance.sum())

    def pressure_correlation(self, r: ArrayLike) -> Array:
        """Return g_σ(r) = Σ_q |σ(q)|² J₀(|q|r), Pa², of the shape of r, averaged over directions. Eqs. (1), (2)

        TypeError or ValueError at a distance, m, that is not a number, negative, or beyond `reach`.
        """
        from scipy.special import j0  # slow to import, and measuring a member does not need it

        distance = np.asarray(r)
        if distance.dtype.kind not in "iuf":
            raise TypeError(f"r has dtype {distance.dtype}; real numbers in m are needed")
        limit = self.reach * (1 + 1e-12)
        outside = ~((distance >= 0) & (distance <= limit))
        if outside.any():
            raise ValueError(
                f"r = {distance[outside].ravel()[0]:.6g} m must lie between 0 and half the diagonal of the cell, "
                f"{self.reach:.6g} m; simulate a larger cell"
            )
        # sums of products: BLAS would split long ones among threads, with other bits
        at = distance.ravel().tolist()
        values = [float(np.sum(self.variance * j0(self.wavenumber * x))) for x in at]
        return np.reshape(values, distance.shape)

    def correlation_radius(self, fraction: float, *, start: float = 0.0) -> float:
        """Return the smallest r ≥ start, m, with g_σ(r) = fraction·g_σ(0); NaN if there is none within `reach`.

        From r the curve cannot fall below its cubic by more than Ds⁴/24 within s, D = Σ|σ(q)|²|J₀⁗|q⁴ ≥ |g⁗|. Each step
        goes to the first s at which that bound meets the target: it never steps over a crossing, and converges faster
        than Newton's method. TypeError or ValueError unless `fraction` is a number in [0, 1).
        """
        from scipy.special import j0, j1  # slow to import, as above

        fraction = number("fraction", fraction)
        if not 0.0 <= fraction < 1.0:
            raise ValueError(
                f"fraction = {fraction:.6g} must be ≥ 0 and below 1, the value at r = 0"
            )
        if not self.pressure_variance > 0.0:
            return math.nan
        r = start
        bounded = -1.0
        for reach in (self.reach * part for part in _NEARER):
            near = self.gathered(reach) if r <= reach else self
            # g(r)/g(0) = Σ share·J₀(qr)
            q = near.wavenumber
            share = near.variance / self.pressure_variance
            even = share * q ** np.array([[0], [2]])
            odd = share * q ** np.array([[1], [3]])
            while r <= reach:
                x = q * r
                g, g2 = np.einsum("kq,q->k", even, j0(x)).tolist()
                g1, g3 = np.einsum("kq,q->k", odd, j1(x)).tolist()
                excess = g - fraction
                if excess <= 0.0:
                    return r
                if r > 2.0 * bounded:  # the bound at a smaller r holds as well
                    fourth = _FOURTH / np.hypot(1.0, x / _FALLING) ** 0.5
                    bound = float(np.sum(np.abs(odd[1]) * q * fourth))
                    bounded = r
                second, third = further_derivatives(r, g1, g2, g3)
                # a step that the falling terms alone allow: Newton's method for the s at which they use up the excess
                falling = [
                    max(0.0, term) for term in (g1, -0.5 * second, -third / 6.0, bound / 24.0)
                ]
                step = first_root(excess, falling)
                if step < 1e-14 * self.reach:
                    return r
                r += step
        return math.nan

    def gathered(self, reach: float) -> "StressSpectrum":
        """Return the same spectrum for distances up to `reach`, m, alone: with fewer nodes, exact to rounding there."""
        spacing = _NODE_PHASE / reach
        cells = int(self.wavenumber[-1] / spacing) - _STENCIL + 1
        if reach >= self.reach or cells < 1:
            return self
        low = self.wavenumber < _STENCIL * spacing
        position = self.wavenumber[~low] / spacing - _STENCIL
        cell = np.minimum(position.astype(np.intp), cells - 1)
        offset = position - cell - 0.5
        power = self.variance[~low]
        moments = np.empty((_POWERS, cells))
        for row in moments:
            row[:] = np.bincount(cell, power, minlength=cells)
            power = power * offset
        variance = np.zeros(cells + _STENCIL - 1)
        for j, part in enumerate(_LAGRANGE[:, :_POWERS] @ moments):
            variance[j : j + cells] += part
        nodes = spacing * (np.arange(variance.size) + _STENCIL // 2 + 1)
        wavenumber = np.concatenate((self.wavenumber[low], nodes))
        order = np.argsort(wavenumber, kind="stable")
        variance = np.concatenate((self.variance[low], variance))
        return StressSpectrum(wavenumber[order], variance[order], reach)


class Gathering(NamedTuple):
    """How the modes of a grid are gathered by their wavenumber."""

    nodes: "_UniformNodes"  # compact wavenumbers
    waves: "_NyquistWaves"  # without a derivative along an axis


@lru_cache(maxsize=8)  # 10 ms for 768² points; the grids of a run come in turn
def gathering(grid: Grid) -> Gathering:
    """Return how the modes of a grid are gathered."""
    return Gathering(uniform_nodes(grid), nyquist_waves(grid))


def stress_spectrum(
    amplitude: Complex, grid: Grid, gathered: Gathering
) -> tuple[StressSpectrum, Array]:
    """Return the spectrum of the stress, and the part of it without a derivative along an axis, Pa².

    `amplitude` is σ(q), shape `grid.half_shape`, Pa. That part is given at each wavenumber of `nyquist_waves`.
    """
    from roughsim.fourier.power import gathered_power  # loads numba

    nodes, waves = gathered
    quarter, sums = gathered_power(amplitude, grid.multiplicity, nodes.slot, nodes.slots)
    share = quarter.ravel()[waves.mode] * waves.unseen_share
    unseen = np.bincount(waves.entry, share, minlength=waves.wavenumber.size)
    reach = 0.5 * math.hypot(*grid.lengths)
    spectrum = StressSpectrum(nodes.entries, nodes.compacted(sums), reach)
    return spectrum, unseen.astype(float, copy=False)


class _NyquistWaves(NamedTuple):
    """The modes of the quarter plane at the Nyquist wavenumber of an axis, and their distinct wavenumbers.

    Such a wave has no derivative along that axis on the points of the grid. Averaged over directions it keeps q_y²/q²
    (or q_x²/q², or nothing) of its gradient; the rest is not seen.
    """

    mode: Index  # place of each in the flattened quarter plane
    unseen_share: Array  # of each, 0 to 1
    entry: Index  # of each among the wavenumbers
    wavenumber: Array  # rad/m, increasing


def nyquist_waves(grid: Grid) -> _NyquistWaves:
    """Return the waves of a grid that have no derivative along an axis."""
    nx, ny = grid.shape
    qx, qy = grid.wavevectors
    wavenumber, entry = distinct_wavenumbers(grid)
    q = wavenumber[entry].reshape(nx // 2 + 1, ny // 2 + 1)
    share = np.zeros_like(q)
    if nx % 2 == 0:
        share[-1] = (qx[nx // 2] / q[-1]) ** 2
    if ny % 2 == 0:
        share[:, -1] = (qy[0, -1] / q[:, -1]) ** 2
    if nx % 2 == 0 and ny % 2 == 0:
        share[-1, -1] = 1.0  # both derivatives vanish: exactly all of it
    mode = np.flatnonzero(share)
    present, own = np.unique(entry[mode], return_inverse=True)
    return _NyquistWaves(mode, share.ravel()[mode], own, wavenumber[present])


def further_derivatives(r: float, g1: float, g2: float, g3: float) -> tuple[float, float]:
    """Return g″ and g‴ at r, m, of g = Σ w J₀(qr) from Σ w q J₁, Σ w q² J₀ and Σ w q³ J₁.

    J₀″ = J₁/x − J₀ and J₀‴ = J₁ + J₀/x − 2J₁/x²; at x = 0 they are −½ and 0.
    """
    if r == 0.0:
        return -0.5 * g2, 0.0
    return g1 / r - g2, g3 + (g2 - 2.0 * g1 / r) / r


def first_root(excess: float, terms: list[float]) -> float:
    """Return the s > 0 at which the sum of terms·s, s², s³, s⁴ (each ≥ 0, the last > 0) reaches an excess > 0."""
    a, b, c, d = terms
    # not below it: from there on Newton's method falls towards it
    s = math.sqrt(math.sqrt(excess / d))
    for _ in range(60):
        value = s * (a + s * (b + s * (c + s * d))) - excess
        step = value / (a + s * (2.0 * b + s * (3.0 * c + 4.0 * s * d)))
        s -= step
        if step <= 1e-9 * s:
            break
    return s * (1.0 - 1e-9)


class _UniformNodes(NamedTuple):
    """How the modes of a grid are gathered at compact wavenumbers: for smooth f both give the same sum of variance·f.

    The distinct wavenumbers below `kept` keep entries of their own. All others are spread over the nodes around them,
    by cells of one node spacing: entry (k, c) of a table is the k-th wavenumber in cell c.
    """

    # of each mode of the quarter plane: q = 0, the kept wavenumbers, the flattened table
    slot: Index
    kept: int  # wavenumbers with entries of their own, q = 0 among them
    offset: Array  # from the middle of the cell, in node spacings: shape of the table
    order: Index  # of kept wavenumbers and nodes that sorts them
    entries: Array  # these wavenumbers sorted, rad/m

    @property
    def slots(self) -> int:
        """How many slots there are."""
        return self.kept + self.offset.size

    def compacted(self, sums: Array) -> Array:
        """Return the variance at each entry from the variance in each slot."""
        own = sums[1 : self.kept]
        table: Array = sums[self.kept :].reshape(self.offset.shape)
        cells = table.shape[1]
        half = _STENCIL // 2
        spread = np.zeros(self.entries.size - own.size)
        if cells:
            from roughsim._kernels.gathering import POWERS, moments_of_columns  # loads numba

            # the transpose of Lagrange's interpolation: the moments of the variance about the middle of each cell,
            # times the coefficients of the polynomials
            moments = np.zeros((POWERS, cells))
            moments_of_columns(table, self.offset, moments)
            # the polynomials of nodes ±x are mirror images: their even powers are equal, their odd ones opposite
            coefficients = _LAGRANGE[:half, :POWERS]
            # products of matrices: these sums are too short for a BLAS to share them among threads
            even, odd = (coefficients[:, s::2] @ moments[s::2] for s in (0, 1))
            for j, part in enumerate((*(even + odd), *(even - odd)[::-1])):
                spread[j : j + cells] += part
        return np.concatenate((own, spread), dtype=float)[self.order]


def uniform_nodes(grid: Grid) -> _UniformNodes:
    """Return the compact wavenumbers of a grid; every mode keeps its own if there are not fewer nodes than modes."""
    wavenumber, entry = distinct_wavenumbers(grid)
    spacing = _NODE_PHASE / (0.5 * math.hypot(*grid.lengths))
    split = _STENCIL * spacing  # modes below it keep entries of their own
    cells = int((wavenumber[-1] - split) / spacing) + 1
    nodes = spacing * np.arange(_STENCIL // 2 + 1, _STENCIL // 2 + cells + _STENCIL)
    if cells < 1 or nodes.size >= wavenumber.size:
        split = math.inf
        cells = 0
        nodes = nodes[:0]
    kept = int(np.searchsorted(wavenumber, split))
    # positions in units of the spacing: a cell lies between the nodes 0 and 1 of the nodes −11 … 12 around it
    position = wavenumber[kept:] / spacing - _STENCIL
    cell = np.minimum(position.astype(np.intp), cells - 1)
    row = np.arange(cell.size) - np.searchsorted(cell, cell)  # wavenumbers increase
    offset = np.zeros((row.max(initial=-1) + 1, cells))
    offset[row, cell] = position - cell - 0.5
    slot = np.concatenate((np.arange(kept), kept + row * cells + cell))
    unsorted = np.concatenate((wavenumber[1:kept], nodes))
    order = np.argsort(unsorted, kind="stable")
    entries = unsorted[order]
    entries.flags.writeable = False  # all spectra of the grid share them
    return _UniformNodes(slot[entry], kept, offset, order, entries)


def _lagrange_coefficients() -> Array:
    """Coefficients, by powers of the distance from the middle, of the 24 Lagrange polynomials with nodes ±½, ±3/2 …"""
    # twice the distances: whole numbers, so that all is exact
    nodes = range(1 - _STENCIL, _STENCIL, 2)
    product = [1]  # Π (y − node), its coefficients by falling powers
    for node in nodes:
        product = [a - node * b for a, b in zip((*product, 0), (0, *product), strict=True)]
    rows = []
    for own in nodes:
        others = product[:1]  # the product over y − own
        for coefficient in product[1:-1]:
            others.append(coefficient + own * others[-1])
        scale = math.prod(own - node for node in nodes if node != own)
        rows.append([(c << power) / scale for power, c in enumerate(reversed(others))])
    return np.array(rows)


_LAGRANGE = _lagrange_coefficients()
