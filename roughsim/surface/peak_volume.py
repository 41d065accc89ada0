"""Volume of the peaks of a surface: predicts most of T_flash without a contact solve.

A contact that covers a share f of the cell touches, roughly, the highest points: those above the level t that a share f
of a normal surface exceeds. The volume of material above it, ⟨h − t; h > t⟩ per area (the peak material volume of ISO
25178), differs from surface to surface, and T_flash follows it. Its mean over all surfaces with the same modes is known
exactly, so the chance part of one surface can be subtracted (a control variate).

At each point h is a sum of independent a cos φ with random phases φ, one of each mode. So

    ⟨e^(s h)⟩ = Π I₀(a s),        ⟨h − t; h > t⟩ = (1/π) Re ∫ ⟨e^(s (h − t))⟩ /s² du,   s = 1 + iu,  u > 0.

Modes that are their own conjugate have only a sign by chance: cosh(a s) takes the place of I₀(a s).
"""

from math import erf, pi, sqrt
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from roughsim.grid import Array, Complex, Grid
from roughsim.surface.modes import remembered
from roughsim.surface.spectrum import Spectrum
from roughsim.surface.synthesis import independent_modes

MOST_SHARE = 0.45  # beyond, the level is no longer near the peaks
LEAST_SHARE = 1e-4
# per side: finer grids are thinned out. The mean over surfaces is the same for any points
_ENOUGH_POINTS = 512
STEP, NODES = 0.1, 128  # of u: the error is below 1e-10 for surfaces of many modes
_MOST_NODES = 1 << 15  # for surfaces of a few modes, whose ⟨e^(s h)⟩ falls slowly
LARGE = 0.05  # amplitude over the rms height; smaller modes enter by a power series


class HeightsAtAPoint(NamedTuple):
    """Heights of all surfaces with the same modes at one point."""

    rms: float  # m
    rms_slope: float
    s: Complex  # 1/rms
    mean_exponential: Complex  # ⟨e^(s h)⟩ at each s


def peak_volume(
    spectrum: Spectrum, grid: Grid, heights: Array, load: float, hardness: float
) -> float:
    """Return ⟨h − t; h > t⟩ of a drawn surface over its rms height, less its mean over surfaces.

    That mean over surfaces with the same modes, fixed amplitudes and random phases is zero exactly. The level t is that
    above which a normal surface has the expected contact area.

    Parameters
    ----------
    spectrum : Spectrum
        C(q) that the surface was drawn from, m⁴; a frozen record.
    grid : Grid
        The periodic cell.
    heights : ndarray
        h, shape `grid.shape`, m, as `synthesize` draws it with fixed amplitudes.
    load, hardness : float
        σ₀/E* and σ_P/E*; infinite hardness for elastic contact.

    Returns
    -------
    float
        Zero for a flat surface.
    """
    point = heights_at_a_point(spectrum, grid)
    if point.rms_slope == 0.0:
        return 0.0
    share = expected_share(point.rms_slope, load, hardness)
    return excess(heights, -NormalDist().inv_cdf(share), point)


def excess(heights: Array, level: float, point: HeightsAtAPoint) -> float:
    """Return ⟨h − t; h > t⟩ of a surface less its mean over all surfaces, both in units of the rms height, as is t."""
    if point.rms == 0.0:
        return 0.0
    thinned = heights[tuple(slice(None, None, max(n // _ENOUGH_POINTS, 1)) for n in heights.shape)]
    above = thinned[thinned > level * point.rms] / point.rms - level
    return float(above.sum()) / thinned.size - mean_above(level, point)


def expected_share(rms_slope: float, load: float, hardness: float) -> float:
    """Return the fraction of the area in contact, elastic or yielded, the larger one (Persson 2001), within limits.

    `load` σ₀/E* and `hardness` σ_P/E*. A level that fits less well leaves more scatter; it biases nothing.
    """
    share = max(erf(sqrt(2.0) * load / rms_slope), load / hardness)
    return min(max(share, LEAST_SHARE), MOST_SHARE)


def mean_above(level: float, point: HeightsAtAPoint) -> float:
    """Return ⟨h − t; h > t⟩ over all surfaces in units of their rms height, as is `level`, t > 0."""
    terms = point.mean_exponential * np.exp(-level * point.s) / point.s**2
    terms[0] *= 0.5  # trapezoids
    return float(np.sum(terms.real)) * STEP / pi


@remembered  # .01 s for each member, as long as the smallest contacts take
def heights_at_a_point(spectrum: Spectrum, grid: Grid) -> HeightsAtAPoint:
    """Return how the heights of surfaces with fixed amplitudes are distributed at any point."""
    modes = independent_modes(spectrum, grid)
    phased = np.full(modes.place.shape, True)
    phased[modes.real] = False
    amplitude = np.where(phased, 2.0, 1.0) * modes.deviation
    squares = np.where(phased, 0.5, 1.0) * amplitude**2
    variance = float(squares.sum())
    slope = sqrt(float((squares * grid.wavenumbers.ravel()[modes.place] ** 2).sum()))
    nodes = NODES
    while True:
        s = np.array(1.0 + 1j * STEP * np.arange(nodes), dtype=complex)
        mean = np.ones(nodes, dtype=complex)
        if variance > 0.0:
            own = amplitude / sqrt(variance)
            mean = mean_exponential(own[phased], own[modes.real], s)
        if nodes >= _MOST_NODES or variance == 0.0 or abs(mean[-1] / s[-1]) <= 1e-10 * abs(mean[0]):
            return HeightsAtAPoint(sqrt(variance), slope, s, mean)
        nodes *= 4


def mean_exponential(phased: Array, signed: Array, s: Complex) -> Complex:
    """Return Π I₀(a s) Π cosh(b s) over amplitudes a with random phases and b with random signs."""
    small = phased[phased <= LARGE]
    # ln I₀(x) = x²/4 − x⁴/64 + x⁶/576 − 11 x⁸/49152 + …
    logarithm = sum(
        coefficient * float((small**power).sum()) * s**power
        for power, coefficient in ((2, 1 / 4), (4, -1 / 64), (6, 1 / 576), (8, -11 / 49152))
    )
    mean = np.exp(logarithm)
    # modes of one |q| have the same amplitude
    equal, counts = np.unique(np.round(phased[phased > LARGE], 13), return_counts=True)
    for a, count in zip(equal, counts, strict=True):
        mean *= bessel(a * s) ** count
    for b in signed:
        mean *= np.cosh(b * s)
    return mean


def bessel(z: Complex) -> Complex:
    """Return I₀(z), the mean of e^(z cos φ) over all φ."""
    if abs(z).max() > 30.0:
        from scipy.special import iv  # slow to import, and only surfaces of a few waves need it

        return iv(0, z)
    # trapezoids of a periodic function: at 64 angles the error is 2 I₆₄(|z|) < 1e-13 I₀(|z|). A quarter of a turn is
    # enough, as cos φ has both signs there
    angles = np.arange(17) * (pi / 32)
    weights = np.where((angles == 0.0) | (angles == angles[-1]), 0.5, 1.0) / 32
    one_sign = np.exp(z[:, None] * np.cos(angles))
    return (one_sign + 1.0 / one_sign) @ weights
