"""Share of a spectrum in the modes of a cell: integrals over their Fourier cells."""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import is_dataclass
from functools import lru_cache
from itertools import pairwise, product
from math import ceil, hypot, pi
from typing import Any

import numpy as np

from roughsim.errors import ResolutionError
from roughsim.grid import Array, Grid, Index, Mask
from roughsim.surface.spectrum import Spectrum

_NEAR = 16.0  # cells closer to the origin than this many mode spacings are integrated in polar coordinates
# a spectrum with more breaks is a table: its kinks are mild, only its jumps are sharp
_MANY_BREAKS = 16
_LEAST_SHARE = 1e-12  # of a mode in a directed spectrum


def remembered(find: Callable[..., Any]) -> Callable[..., Any]:
    """Let a function remember 16 results, as the dozen of a run come in turn: of frozen records, and parts of them."""
    kept = lru_cache(maxsize=16)(find)

    def found(spectrum: Spectrum, grid: Grid) -> Any:
        whole: Any = spectrum
        while hasattr(whole, "whole"):
            whole = whole.whole
        fixed = is_dataclass(whole) and vars(type(whole))["__dataclass_params__"].frozen
        return (kept if fixed else find)(spectrum, grid)  # type: ignore[arg-type]

    return found


def check_resolved(spectrum: Spectrum, grid: Grid) -> None:
    """Raise ResolutionError if C(q) reaches beyond the Nyquist wavenumber of a grid."""
    q_max = spectrum.breaks[-1]
    if q_max > grid.nyquist * (1 + 1e-12):
        raise ResolutionError(
            f"q_max = {q_max:.4g} rad/m exceeds the Nyquist wavenumber {grid.nyquist:.4g} rad/m of the grid "
            f"{grid.shape}; refine the grid or lower q_max"
        )


def mode_variance(spectrum: Spectrum, grid: Grid) -> Array:
    """Return ∫ C d²q over the Fourier cell of each mode: its variance on the full plane, m², shape `grid.half_shape`.

    With `grid.multiplicity` it sums to the variance of the surface. q = 0 is zero; a Nyquist mode stands for both its
    signs. ResolutionError if C(q) reaches beyond the Nyquist wavenumber; ValueError if it is negative or not finite; a
    RuntimeWarning if it begins below the lowest mode of the cell, or inside the Fourier cell of q = 0.
    """
    check_resolved(spectrum, grid)
    # a long and narrow cell loses waves above its lowest mode too, in the Fourier cell of q = 0
    x, y = grid.lengths
    lowest = max(2 * pi / max(x, y), hypot(pi / x, pi / y))
    q_min = spectrum.breaks[0]
    if q_min < lowest * (1 - 1e-9):
        warnings.warn(
            f"q_min = {q_min:.4g} rad/m lies below {lowest:.4g} rad/m, the lower end of the modes of the cell: "
            f"roughness of longer waves is left out; enlarge the cell to keep it",
            RuntimeWarning,
            stacklevel=4,
        )
    with np.errstate(invalid="ignore"):
        # an infinite C(q) times an empty part of a cell: refused below
        held = _quadrant(spectrum, holding(spectrum, grid))
    if not ((held >= 0) & np.isfinite(held)).all():
        raise ValueError(
            f"spectrum = {spectrum!r} must give C(q) finite and ≥ 0 between its breaks"
        )
    beyond = [(0, n // 2 + 1 - m) for n, m in zip(grid.shape, held.shape, strict=True)]
    rows = np.arange(grid.shape[0])
    variance = np.pad(held, beyond)[np.minimum(rows, grid.shape[0] - rows)]
    if getattr(spectrum, "directed", False):
        directed = variance * _directed_share(spectrum, grid, variance > 0.0)
        # their sum is kept, to more digits than the shares have
        sums = [float(np.sum(values * grid.multiplicity)) for values in (variance, directed)]
        variance = directed * (sums[0] / sums[1])
    return variance


def _directed_share(spectrum: Any, grid: Grid, chosen: Mask) -> Array:
    """Return ∫ C(q⃗) d²q / ∫ C(q) d²q over the Fourier cells of the chosen modes, shape `grid.half_shape`.

    It is above 0, so that a stream of random phases gives each mode its own, whatever the directions.
    """
    vectors = np.broadcast_arrays(*grid.wavevectors)
    near = grid.wavenumbers < _NEAR * max(grid.mode_spacing)
    # a Nyquist mode stands for both its signs
    limits = (
        pi * n / side if n % 2 == 0 else np.inf
        for n, side in zip(grid.shape, grid.lengths, strict=True)
    )
    edge = np.any(
        [abs(q) > 0.999999 * limit for q, limit in zip(vectors, limits, strict=True)], axis=0
    )
    share = np.ones(grid.half_shape)
    for cells, points in ((chosen & near, 8), (chosen & ~near, 3)):
        nodes = list(zip(*np.polynomial.legendre.leggauss(points), strict=True))
        directed, isotropic = np.zeros((2, np.count_nonzero(cells)))
        for (a, weight_a), (b, weight_b) in product(nodes, nodes):
            qx, qy = (
                q[cells] + 0.5 * node * step
                for q, node, step in zip(vectors, (a, b), grid.mode_spacing, strict=True)
            )
            q = np.hypot(qx, qy)
            angle = np.arctan2(qy, qx)
            weight = weight_a * weight_b
            value = spectrum.at(q, angle)
            both = edge[cells]
            value[both] = 0.5 * (value[both] + spectrum.at(q[both], -angle[both]))
            directed += weight * value
            isotropic += weight * spectrum(q)
        share[cells] = np.where(
            isotropic > 0.0, directed / np.where(isotropic > 0.0, isotropic, 1.0), 1.0
        )
    return np.maximum(share, _LEAST_SHARE)


def mean_over_cells(
    weight: Callable[[Array], Array], spectrum: Spectrum, grid: Grid, modes: Mask
) -> Array:
    """Return ∫ C w d²q / ∫ C d²q over the Fourier cells of some modes, the mean of w weighted by C.

    `weight` is w of wavenumbers within the breaks of the spectrum, rad/m, one-dimensional, smooth between the breaks;
    `modes` selects the modes, bool, shape `grid.half_shape`, all of them with C > 0 somewhere in their cell. The means
    are in the order of `np.nonzero(modes)`.
    """
    breaks = spectrum.breaks

    def both(q: Array) -> Any:
        within = np.clip(q, breaks[0], breaks[-1])
        power = spectrum(q)
        return np.stack((power * weight(within.ravel()).reshape(q.shape), power))

    rows, columns = np.nonzero(modes)
    rows = np.minimum(rows, grid.shape[0] - rows)
    weighted, whole = _polar_cells(both, breaks, rows, columns, grid.mode_spacing)
    return weighted / whole


def holding(spectrum: Spectrum, grid: Grid) -> Grid:
    """Return the grid, or the coarsest one of its cell that holds all modes of a spectrum below its Nyquist modes."""
    x, y = (
        min(points, 2 * ceil(spectrum.breaks[-1] * length / (2 * pi) + 1))
        for points, length in zip(grid.shape, grid.lengths, strict=True)
    )
    return Grid((x, y), grid.lengths)


@remembered  # .02 s for each further grid of a cell, and for a sum over its modes, if C(q) is smoothed by yielding
def _quadrant(spectrum: Spectrum, grid: Grid) -> Array:
    """Cell integrals for k_x, k_y ≥ 0, with the Nyquist rows counted for both signs."""
    nx, ny = grid.shape
    steps = grid.mode_spacing
    kx = np.arange(nx // 2 + 1)[:, None]
    ky = np.arange(ny // 2 + 1)[None, :]
    # shortest and longest wavenumber of each cell
    near = np.hypot(np.maximum(kx - 0.5, 0) * steps[0], np.maximum(ky - 0.5, 0) * steps[1])
    far = np.hypot((kx + 0.5) * steps[0], (ky + 0.5) * steps[1])
    breaks = spectrum.breaks
    result = np.zeros(near.shape)
    covered = (far > breaks[0]) & (near < breaks[-1])
    covered[0, 0] = False
    # of many breaks only jumps of C(q) itself are sharp: both ends, and the ends of each term of a sum
    sharp = np.asarray(breaks, dtype=float)
    if len(breaks) > _MANY_BREAKS:
        below = spectrum(sharp * (1 - 1e-6))
        above = spectrum(sharp * (1 + 1e-6))
        sharp = sharp[abs(above - below) > 1e-3 * np.maximum(above, below)]
    # cells near the origin or over a sharp break are integrated in polar coordinates, the others by Gauss points
    special = np.hypot(kx * steps[0], ky * steps[1]) < _NEAR * max(steps)
    for q in sharp:
        special = special | ((near < q) & (q < far))
    smooth = covered & ~special
    special = covered & special
    rows, columns = np.nonzero(smooth)
    result[smooth] = _smooth_cells(spectrum, rows, columns, steps)
    rows, columns = np.nonzero(special)
    result[special] = _polar_cells(spectrum, breaks, rows, columns, steps)
    # a Nyquist row or column stands for both its signs
    if nx > 1 and nx % 2 == 0:
        result[-1] *= 2.0
    if ny > 1 and ny % 2 == 0:
        result[:, -1] *= 2.0
    return result


def _smooth_cells(spectrum: Spectrum, kx: Index, ky: Index, steps: tuple[float, float]) -> Array:
    """3×3 Gauss points: for cells far from the origin and from the sharp ends (relative error < 1e-8)."""
    total = np.zeros(kx.size)
    points = list(zip(*np.polynomial.legendre.leggauss(3), strict=True))
    for (a, weight_a), (b, weight_b) in product(points, points):
        q = np.hypot((kx + a / 2) * steps[0], (ky + b / 2) * steps[1])
        total += weight_a * weight_b / 4 * spectrum(q)
    return total * steps[0] * steps[1]


def _polar_cells(
    psd: Callable[[Array], Any],
    breaks: Sequence[float],
    kx: Index,
    ky: Index,
    steps: tuple[float, float],
) -> Array:
    """∫ q C(q) θ(q) dq, θ the angle of the circle q inside the cell: exact at sharp ends, in pieces between kinks.

    `psd` may return several spectra at once, along the first axes: then the result has these axes, too.
    """
    # equal cells are integrated once: ±k_x, and in a square cell (k_x, k_y) and (k_y, k_x)
    if steps[0] == steps[1]:
        kx, ky = np.minimum(kx, ky), np.maximum(kx, ky)
    most = int(ky.max(initial=0)) + 1
    cells, entry = np.unique(kx * most + ky, return_inverse=True)
    kx, ky = np.divmod(cells, most)
    # a few cells at a time: the work arrays stay small
    parts = [slice(start, start + 4096) for start in range(0, max(cells.size, 1), 4096)]
    each = [_distinct_polar_cells(psd, breaks, kx[part], ky[part], steps) for part in parts]
    return np.concatenate(each, axis=-1)[..., entry]


def _distinct_polar_cells(
    psd: Callable[[Array], Any],
    breaks: Sequence[float],
    kx: Index,
    ky: Index,
    steps: tuple[float, float],
) -> Any:
    """Return `_polar_cells` of a few cells."""
    # a cell on an axis is twice its half in the quadrant
    x0 = np.maximum(kx - 0.5, 0) * steps[0]
    x1 = (kx + 0.5) * steps[0]
    y0 = np.maximum(ky - 0.5, 0) * steps[1]
    y1 = (ky + 0.5) * steps[1]
    copies = np.where(kx == 0, 2.0, 1.0) * np.where(ky == 0, 2.0, 1.0)
    corners = [np.hypot(x, y) for y in (y0, y1) for x in (x0, x1)]
    inner = [np.clip(np.full(kx.shape, q), corners[0], corners[3]) for q in breaks]
    edges = np.sort(np.stack([*corners, *inner]), axis=0)
    nodes, weights = np.polynomial.legendre.leggauss(20)
    t = (nodes + 1) / 2
    # flattens the square roots of θ(q) at the corners
    smooth = t * t * (3 - 2 * t)
    slope = 6 * t * (1 - t)
    total = np.zeros(kx.size)
    for low, high in pairwise(edges):
        middle = 0.5 * (low + high)
        # cells that the piece meets
        own = np.flatnonzero((high > low) & (middle > breaks[0]) & (middle < breaks[-1]))
        if not own.size:
            continue
        left = low[own, None]
        right = high[own, None]
        span = np.log(right / left)  # steps in ln q: in long cells C(q) falls by decades
        q = left * np.exp(span * smooth)
        value = psd(np.clip(q, left * (1 + 1e-15), right * (1 - 1e-15)))
        # angle of the circle of radius q inside the cell
        radius = np.maximum(q, np.finfo(float).tiny)
        cosines = [np.minimum(x[own, None] / radius, 1) for x in (x0, x1)]
        sines = [np.minimum(y[own, None] / radius, 1) for y in (y0, y1)]
        upper = np.minimum(np.arccos(cosines[0]), np.arcsin(sines[1]))
        lower = np.maximum(np.arccos(cosines[1]), np.arcsin(sines[0]))
        angle = np.maximum(upper - lower, 0.0)
        integrand = np.zeros((*value.shape[:-2], kx.size, t.size))
        integrand[..., own, :] = q * q * value * angle * slope
        length = np.zeros(kx.size)
        length[own] = span[:, 0]
        total = total + length * (integrand @ (weights / 2))
    return copies * total
