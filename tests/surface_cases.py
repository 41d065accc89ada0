"""Spectra, grids and integrals over Fourier cells that the tests of surfaces share."""

import itertools

import numpy as np

from roughsim.grid import Grid
from roughsim.surface.power_laws import SelfAffineSpectrum
from roughsim.surface.synthesis import synthesize

CIRCLE = 2 * np.pi  # in a cell of this side, modes lie at whole wavenumbers
BOTH = ["fixed", "gaussian"]
STEEP = {"hurst": 0.8, "q_roll_off": 5.3, "roll_off_exponent": 1.5}
SPECTRUM = SelfAffineSpectrum.from_rms_height(1.0, q_min=2.3, q_max=13.4, **STEEP)
WIDE = SelfAffineSpectrum.from_rms_height(1.0, q_min=2.3, q_max=55.5, **STEEP)
NODES, WEIGHTS = np.polynomial.legendre.leggauss(40)


def panels(edges):
    """Points and weights between sorted edges (first axis); a cubic map flattens square roots at the edges."""
    t = (NODES + 1) / 2
    width = np.diff(edges, axis=0)[..., None]
    points = edges[:-1, ..., None] + width * (t * t * (3 - 2 * t))
    return points, width * (6 * t * (1 - t) * WEIGHTS / 2)


def cell_integral(spectrum, k, steps):
    """∫ C d²q over the cell of mode k in Cartesian coordinates, panels cut where a break's circle crosses."""
    (x0, x1), (y0, y1) = (
        ((n - 0.5) * step, (n + 0.5) * step) for n, step in zip(k, steps, strict=True)
    )
    circles = np.array(spectrum.breaks)
    ends = [x0, x1, 0.0, *circles, *-circles]
    for y in (y0, y1):
        root = np.sqrt(circles[circles > abs(y)] ** 2 - y * y)
        ends += [*root, *-root]
    x, weight = panels(np.unique(np.clip(ends, x0, x1)))
    x, weight = x.ravel(), weight.ravel()
    roots = np.sqrt(np.maximum(circles[:, None] ** 2 - x**2, 0.0))
    zero = np.zeros((1, x.size))
    y, inner = panels(
        np.sort(
            np.clip(np.concatenate([zero + y0, zero, zero + y1, roots, -roots]), y0, y1), axis=0
        )
    )
    return float(weight @ (spectrum(np.hypot(x[:, None], y)) * inner).sum(axis=(0, 2)))


def square(n, length=CIRCLE):
    return Grid((n, n), (length, length))


def variance_by_quadrature(spectrum, n):
    """The whole table of a square cell of side 2π, n odd or C zero at Nyquist, by symmetry from one octant."""
    half = n // 2 + 1
    table = np.zeros((half, half))
    for i, j in itertools.combinations_with_replacement(range(half), 2):
        table[i, j] = table[j, i] = cell_integral(spectrum, (i, j), (1.0, 1.0)) if i + j else 0.0
    rows = np.arange(n)
    return table[np.minimum(rows, n - rows)]


def modes_of(heights):
    return np.fft.rfft2(heights) / heights.size


def draws(spectrum, grid, amplitudes, count, seed=1):
    rng = np.random.default_rng(seed)
    return np.stack(
        [modes_of(synthesize(spectrum, grid, rng, amplitudes=amplitudes)) for _ in range(count)]
    )


# --- variance of a mode ---------------------------------------------------------------------------------------------
