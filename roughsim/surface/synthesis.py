"""Random surfaces with a given power spectrum.

The modes are drawn in an order that depends on the cell alone, outwards from the origin. So the same random stream
gives the same surface on every grid: a finer grid or a higher q_max only adds modes. Paired solves rest on this. (A
Nyquist mode stands for two modes of a finer grid and equals neither; a spectrum that ends below it has none.)
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import is_dataclass
from functools import lru_cache
from itertools import pairwise
from math import hypot, pi
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughsim import fourier
from roughsim.errors import ResolutionError
from roughsim.grid import Grid
from roughsim.surface.spectrum import Spectrum

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Steps = tuple[float, float]
_NEAR = 16.0  # cells closer to the origin than this many mode spacings are integrated in polar coordinates
_MANY_BREAKS = 16  # a spectrum with more breaks is a table: its kinks are mild, only its jumps are sharp


def synthesize(
    spectrum: Spectrum,
    grid: Grid,
    rng: np.random.Generator,
    *,
    amplitudes: Literal["fixed", "gaussian"] = "fixed",
) -> Array:
    """Draw a surface whose modes have the variance ∫C d²q over their Fourier cells.

    Parameters
    ----------
    spectrum : Spectrum
        C(q), m⁴, with `breaks`; its end must not lie beyond the Nyquist wavenumber of the grid.
    grid : Grid
        The periodic cell.
    rng : numpy.random.Generator
        The random stream; the same stream gives the same surface, whatever the grid.
    amplitudes : {"fixed", "gaussian"}
        "fixed": each mode has exactly its standard deviation as amplitude and a random phase, so rms height and slope
        are the same for every draw. "gaussian": complex normal modes, a Gaussian random field.

    Returns
    -------
    ndarray
        Heights, shape `grid.shape`, m, with mean zero.

    Raises
    ------
    ResolutionError
        If C(q) reaches beyond the Nyquist wavenumber.
    TypeError, ValueError
        If `rng` is no generator or `amplitudes` is neither word, or if C(q) is negative or not finite.

    Warns
    -----
    RuntimeWarning
        If C(q) begins below the lowest mode of the cell: that part is left out.
    """
    if not isinstance(rng, np.random.Generator):
        raise TypeError(f"rng = {rng!r} must be a numpy Generator; make one with np.random.default_rng(seed)")
    if amplitudes not in ("fixed", "gaussian"):
        raise ValueError(f'amplitudes = {amplitudes!r} must be "fixed" or "gaussian"')
    find: Callable[[Any, Grid], _Modes] = _modes if _fixed(spectrum) else _find_modes
    modes = find(spectrum, grid)
    values = _draw(modes, rng, amplitudes)
    half = np.zeros(grid.half_shape, dtype=np.complex128)
    half.flat[modes.place] = values
    half.flat[modes.partner[modes.paired]] = values[modes.paired].conj()
    return fourier.inverse(half, grid.shape)


class _Modes(NamedTuple):
    """The independent modes of a surface in the order in which they are drawn."""

    kept: NDArray[np.bool_]  # of all modes that are drawn: a Nyquist mode of this grid is two modes of a finer one
    place: NDArray[np.int64]  # flat place in the half spectrum, of those kept
    partner: NDArray[np.int64]  # flat place of the conjugate, where that also lies in the half spectrum
    paired: NDArray[np.bool_]  # whether it does
    real: NDArray[np.bool_]  # whether the mode is its own conjugate
    deviation: Array  # √variance of one mode of the full plane, m


def _draw(modes: _Modes, rng: np.random.Generator, amplitudes: str) -> NDArray[Any]:
    count = modes.kept.size
    if amplitudes == "gaussian":
        normal = rng.standard_normal((count, 2))[modes.kept]
        complex_normal = (normal[:, 0] + 1j * normal[:, 1]) * np.sqrt(0.5)
        return modes.deviation * np.where(modes.real, normal[:, 0], complex_normal)
    turn = rng.random(count)[modes.kept]
    return modes.deviation * np.where(modes.real, np.where(turn < 0.5, 1.0, -1.0), np.exp(2j * pi * turn))


def _fixed(spectrum: Any) -> bool:
    """Whether a spectrum cannot change, so that its modes may be kept: a frozen record, or a cut of one."""
    whole = getattr(spectrum, "whole", spectrum)
    return is_dataclass(whole) and bool(vars(type(whole))["__dataclass_params__"].frozen)


@lru_cache(maxsize=4)
def _modes(spectrum: Any, grid: Grid) -> _Modes:
    return _find_modes(spectrum, grid)


def _find_modes(spectrum: Spectrum, grid: Grid) -> _Modes:
    variance = mode_variance(spectrum, grid)
    (nx, ny), half = grid.shape, grid.half_shape
    kx, ky = _in_order(*np.divmod(np.flatnonzero(variance), half[1]), grid)
    kept = (2 * kx != -nx) & ((2 * ky != ny) | (kx >= 0))
    kx, ky = kx[kept] % nx, ky[kept]
    mirror = (nx - kx) % nx
    lone_column = (ky == 0) | (2 * ky == ny)  # columns that hold both a mode and its conjugate
    real = lone_column & (mirror == kx)
    place = kx * half[1] + ky
    return _Modes(kept, place, mirror * half[1] + ky, lone_column & ~real, real, np.sqrt(variance.flat[place]))


def _in_order(kx: Index, ky: Index, grid: Grid) -> tuple[Index, Index]:
    """Signed indices of one mode of each conjugate pair, in the order of the shortest wavenumber of their cells.

    A cell has variance if q_max lies above that wavenumber, so the modes of a lower q_max come first. Nyquist modes
    are listed with both signs, as on a finer grid.
    """
    nx = grid.shape[0]
    half_plane = (ky > 0) | (2 * kx <= nx)
    kx, ky = kx[half_plane], ky[half_plane]
    twins = (2 * kx == nx) & (ky > 0)
    kx = np.concatenate([np.where(2 * kx > nx, kx - nx, kx), -kx[twins]])
    ky = np.concatenate([ky, ky[twins]])
    x, y = np.maximum(abs(kx) - 0.5, 0) / grid.lengths[0], np.maximum(ky - 0.5, 0) / grid.lengths[1]
    order = np.lexsort((kx, ky, x * x + y * y))
    return kx[order], ky[order]


def mode_variance(spectrum: Spectrum, grid: Grid) -> Array:
    """Return ∫ C d²q over the Fourier cell of each mode.

    Parameters
    ----------
    spectrum : Spectrum
        C(q), m⁴.
    grid : Grid
        The periodic cell.

    Returns
    -------
    ndarray
        Variance of one mode of the full plane, shape `grid.half_shape`, m²; with `grid.multiplicity` it sums to the
        variance of the surface. q = 0 is zero. A Nyquist mode stands for both its signs.

    Raises
    ------
    ResolutionError
        If C(q) reaches beyond the Nyquist wavenumber.
    ValueError
        If C(q) is negative or not finite.

    Warns
    -----
    RuntimeWarning
        If C(q) begins below the lowest mode of the cell, or inside the Fourier cell of q = 0.
    """
    ends = spectrum.breaks[0], spectrum.breaks[-1]
    if ends[1] > grid.nyquist * (1 + 1e-12):
        raise ResolutionError(
            f"q_max = {ends[1]:.4g} rad/m exceeds the Nyquist wavenumber {grid.nyquist:.4g} rad/m of the grid "
            f"{grid.shape}; refine the grid or lower q_max"
        )
    # a long and narrow cell loses waves above its lowest mode too: those in the Fourier cell of q = 0
    lowest = max(2 * pi / max(grid.lengths), hypot(pi / grid.lengths[0], pi / grid.lengths[1]))
    if ends[0] < lowest * (1 - 1e-9):
        warnings.warn(
            f"q_min = {ends[0]:.4g} rad/m lies below {lowest:.4g} rad/m, what the lowest modes of the cell reach: "
            f"roughness of longer waves is left out; enlarge the cell to keep it",
            RuntimeWarning,
            stacklevel=3,
        )
    rows = np.arange(grid.shape[0])
    with np.errstate(invalid="ignore"):  # an infinite C(q) times an empty part of a cell: refused below
        quadrant = _quadrant(spectrum, grid)
    if not ((quadrant >= 0) & np.isfinite(quadrant)).all():
        raise ValueError(f"spectrum = {spectrum!r} must give C(q) finite and ≥ 0 between its breaks")
    return quadrant[np.minimum(rows, grid.shape[0] - rows)]


def mean_over_cells(weight: Callable[[Array], Array], spectrum: Spectrum, grid: Grid, modes: Array) -> Array:
    """Return ∫ C w d²q / ∫ C d²q over the Fourier cells of some modes: the mean that their roughness sees.

    Parameters
    ----------
    weight : callable
        w of wavenumbers within the breaks of the spectrum, rad/m, one-dimensional; smooth between the breaks.
    spectrum : Spectrum
        C(q), m⁴.
    grid : Grid
        The periodic cell.
    modes : ndarray
        Which modes, bool, shape `grid.half_shape`; all of them with C > 0 somewhere in their cell.

    Returns
    -------
    ndarray
        A mean for each mode in the order of `np.nonzero(modes)`, in units of w.
    """
    rows, columns = np.nonzero(modes)
    cells = np.minimum(rows, grid.shape[0] - rows), columns
    steps = 2 * pi / grid.lengths[0], 2 * pi / grid.lengths[1]
    inside: Array = _polar_cells(_Weighted(spectrum, weight), *cells, steps) / _polar_cells(spectrum, *cells, steps)
    return inside


class _Weighted(NamedTuple):
    """C(q) w(q) with the breaks of C(q)."""

    spectrum: Spectrum
    weight: Callable[[Array], Array]

    @property
    def breaks(self) -> Any:
        return self.spectrum.breaks

    def __call__(self, q: Array) -> Any:
        within = np.clip(q, self.breaks[0], self.breaks[-1])
        return self.spectrum(q) * self.weight(within.ravel()).reshape(q.shape)


def _quadrant(spectrum: Spectrum, grid: Grid) -> Array:
    """Cell integrals for k_x, k_y ≥ 0, with the Nyquist rows counted for both signs."""
    nx, ny = grid.shape
    steps = 2 * pi / grid.lengths[0], 2 * pi / grid.lengths[1]
    kx, ky = np.arange(nx // 2 + 1)[:, None], np.arange(ny // 2 + 1)[None, :]
    near, far = _extremes(kx, ky, steps)
    breaks = spectrum.breaks
    result = np.zeros(near.shape)
    covered = (far > breaks[0]) & (near < breaks[-1])
    covered[0, 0] = False
    sharp = _jumps(spectrum) if len(breaks) > _MANY_BREAKS else breaks
    special = np.hypot(kx * steps[0], ky * steps[1]) < _NEAR * max(steps)
    for q in sharp:
        special = special | ((near < q) & (q < far))
    smooth = covered & ~special
    for where, integral in ((smooth, _smooth_cells), (covered & special, _polar_cells)):
        rows, columns = np.nonzero(where)
        result[where] = integral(spectrum, rows, columns, steps)
    if nx > 1 and nx % 2 == 0:
        result[-1] *= 2.0
    if ny > 1 and ny % 2 == 0:
        result[:, -1] *= 2.0
    return result


def _jumps(spectrum: Spectrum) -> Array:
    """Breaks where C(q) itself jumps: both ends, and the ends of each term of a sum."""
    breaks = np.asarray(spectrum.breaks, dtype=np.float64)
    below, above = spectrum(breaks * (1 - 1e-6)), spectrum(breaks * (1 + 1e-6))
    jumps: Array = breaks[abs(above - below) > 1e-3 * np.maximum(above, below)]
    return jumps


def _extremes(kx: Index, ky: Index, steps: Steps) -> tuple[Array, Array]:
    """Shortest and longest wavenumber of each cell."""
    near = np.hypot(np.maximum(kx - 0.5, 0) * steps[0], np.maximum(ky - 0.5, 0) * steps[1])
    return near, np.hypot((kx + 0.5) * steps[0], (ky + 0.5) * steps[1])


def _smooth_cells(
    spectrum: Spectrum, kx: NDArray[np.int64], ky: NDArray[np.int64], steps: tuple[float, float]
) -> Array:
    """3×3 Gauss points: for cells far from the origin and from the sharp ends (relative error < 1e-8)."""
    nodes, weights = np.polynomial.legendre.leggauss(3)
    total = np.zeros(kx.size)
    for a, weight_a in zip(nodes, weights, strict=True):
        for b, weight_b in zip(nodes, weights, strict=True):
            q = np.hypot((kx + a / 2) * steps[0], (ky + b / 2) * steps[1])
            total += weight_a * weight_b / 4 * spectrum(q)
    return total * steps[0] * steps[1]


def _polar_cells(spectrum: Spectrum, kx: Index, ky: Index, steps: Steps) -> Array:
    """∫ q C(q) θ(q) dq, θ the angle of the circle q inside the cell: exact at sharp ends, in pieces between kinks."""
    total = np.zeros(kx.size)
    for start in range(0, kx.size, 4096):
        part = slice(start, start + 4096)
        total[part] = _polar_chunk(spectrum, kx[part], ky[part], steps)
    return total


def _polar_chunk(spectrum: Spectrum, kx: Index, ky: Index, steps: Steps) -> Array:
    # a cell on an axis is twice its half in the quadrant
    x0, x1 = np.maximum(kx - 0.5, 0) * steps[0], (kx + 0.5) * steps[0]
    y0, y1 = np.maximum(ky - 0.5, 0) * steps[1], (ky + 0.5) * steps[1]
    copies = np.where(kx == 0, 2.0, 1.0) * np.where(ky == 0, 2.0, 1.0)
    corners = [np.hypot(x0, y0), np.hypot(x1, y0), np.hypot(x0, y1), np.hypot(x1, y1)]
    inner = [np.clip(np.full(kx.shape, q), corners[0], corners[3]) for q in spectrum.breaks]
    edges = np.sort(np.stack([*corners, *inner]), axis=0)
    nodes, weights = np.polynomial.legendre.leggauss(20)
    t = (nodes + 1) / 2
    smooth, slope = t * t * (3 - 2 * t), 6 * t * (1 - t)  # flattens the square roots of θ(q) at the corners
    total = np.zeros(kx.size)
    for left, right in pairwise(edges):
        if not (right > left).any():
            continue
        span = np.log(right / left)  # steps in ln q: in long cells C(q) falls by decades
        q = left[:, None] * np.exp(span[:, None] * smooth)
        middle = 0.5 * (left + right)
        value = spectrum(np.clip(q, left[:, None] * (1 + 1e-15), right[:, None] * (1 - 1e-15)))
        angle = _angle(q, x0[:, None], x1[:, None], y0[:, None], y1[:, None])
        inside = (middle > spectrum.breaks[0]) & (middle < spectrum.breaks[-1])
        total += np.where(inside, span, 0.0) * ((q * q * value * angle * slope) @ (weights / 2))
    return copies * total


def _angle(q: Array, x0: Any, x1: Any, y0: Any, y1: Any) -> Array:
    """Angle of the circle of radius q inside the rectangle [x0, x1] × [y0, y1] of the first quadrant."""
    q = np.maximum(q, np.finfo(float).tiny)
    upper = np.minimum(np.arccos(np.minimum(x0 / q, 1)), np.arcsin(np.minimum(y1 / q, 1)))
    lower = np.maximum(np.arccos(np.minimum(x1 / q, 1)), np.arcsin(np.minimum(y0 / q, 1)))
    angle: Array = np.maximum(upper - lower, 0.0)
    return angle
