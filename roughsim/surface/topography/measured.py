"""C(q) of maps, in Persson's convention, with the error that a few long waves leave in it.

A map holds a finite number of waves of each length, so that its C(q) scatters about C(q) of the surface. A row of the
table has the standard error of its mean over modes. Neighbouring modes of a map under a window are not independent:
each row counts fewer modes for it, and rows then add up as if they were independent. If several scans cover the same q,
their differences measure in addition how much the surface varies from place to place.
"""

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from roughsim.grid import Array, Grid, Index, Mask
from roughsim.surface.power_laws import TabulatedSpectrum

BINS_PER_DECADE = 20
GAP = 2.0  # q between neighbouring bins that no scan covers: above this factor a message names it
_ROUNDING = 1e-26  # of the largest C: below it there are rounding errors of the heights alone
_FIRST_BINS = 5  # over which the exponent at the lowest wavenumbers is fitted


class MeasuredSpectrum(NamedTuple):
    """C(q) of one map or of several, with its error.

    `errors` (rows, 1 + scans) are relative to C. The first column is the standard error of each row by the finite
    number of its modes, independent from row to row. Each other column is of one scan, if there are several: how C
    changes without it, at all rows together, so that the squares of these columns add up to a variance (jackknife).
    """

    spectrum: TabulatedSpectrum
    errors: Array


@dataclass(frozen=True, eq=False)
class BinnedSpectrum:
    """C(q) of one map, averaged over directions and over bins of log q."""

    q: Array  # rad/m, the mean of ln q of the modes of each bin
    psd: Array  # C(q) there, m⁴
    exponent: Array  # of the power law that C(q) is taken as within the bin
    error: Array  # standard error of C, relative
    index: Index  # of the bin: it goes from 10^(index/20) to 10^((index + 1)/20) rad/m
    variance: float  # ⟨h²⟩ of all modes, m²
    q_max: float  # the end of the reliable range of the map, rad/m

    @property
    def table(self) -> TabulatedSpectrum:
        """The rows, carried on to q_max."""
        q = self.q
        psd = self.psd
        if q[-1] < self.q_max * (1 - 1e-6):
            end = psd[-1] * (self.q_max / q[-1]) ** -self.exponent[-1]
            q = np.append(q, self.q_max)
            psd = np.append(psd, end)
        return TabulatedSpectrum(q, psd)

    @property
    def longest(self) -> float:
        """The wavenumber, rad/m, down to which C(q) goes on below its rows, so that 2π∫qCdq is ⟨h²⟩ of the map."""
        first = float(self.q[0])
        psd = float(self.psd[0])
        missing = self.variance - self.table.moment(0)
        if missing <= 0.0:
            return first
        # 2π ∫ q C dq from q_low to q₁ = 2π C₁ q₁² (1 − (q_low/q₁)^p)/p, p = 2 − exponent, log for p = 0
        share = missing / (2 * np.pi * psd * first**2)
        power = 2.0 - _lowest_exponent(self.q, self.psd)
        inner = 1.0 - share * power
        ratio = 0.0
        if abs(power) < 1e-9:
            ratio = np.exp(-share)
        elif inner > 0.0:
            ratio = inner ** (1.0 / power)
        # a mode at 2π/L stands for no wave longer than about 2L
        return first * float(np.clip(ratio, 0.4, 1.0))


def map_spectrum(
    heights: Array, grid: Grid, *, periodic: bool, reliable: float = np.inf
) -> BinnedSpectrum:
    """Return C(q) of one map, m, up to `reliable`, rad/m; under a window unless the map is periodic.

    The window is a disc as wide as the shorter side. A longer map has several of them along it, each half over the
    next and without its tilt, and C(q) is their mean (Welch).
    """
    q_max = min(grid.nyquist, reliable)
    if periodic:
        return radial_average(_psd_of(heights, grid, np.ones(grid.shape)), grid, q_max)
    parts, part = discs(grid)
    weight = window(part)
    psd = np.zeros(part.half_shape)
    for place in parts:
        own = heights[place]
        psd += _psd_of(levelled(own) if len(parts) > 1 else own, part, weight) / len(parts)
    # modes under a window are correlated: so many of them count as one
    together = float(np.mean(weight**4) / np.mean(weight**2) ** 2)
    share = share_of_scatter(weight, parts)
    return radial_average(psd, part, q_max, together=together, share=share)


def levelled(heights: Array, periodic: bool = False) -> Array:
    """Return the heights of a map or a line scan without their mean, and, if not periodic, without their tilt."""
    heights = heights - heights.mean()
    if not periodic:
        for axis, points in enumerate(heights.shape):
            along = np.arange(points) - 0.5 * (points - 1)
            mean = heights if heights.ndim == 1 else np.mean(heights, axis=1 - axis)
            slope = float(mean @ along / (along @ along))
            heights -= slope * (along[:, None] if axis == 0 and heights.ndim == 2 else along)
    return heights


def _psd_of(heights: Array, grid: Grid, weight: Array) -> Array:
    """Return C at the modes of heights, m, under a window, m⁴, of `grid.half_shape`."""
    modes = np.fft.rfft2(heights * weight)
    psd = modes.real**2 + modes.imag**2
    cell = 4 * np.pi**2 / (grid.lengths[0] * grid.lengths[1])
    return psd / (grid.points**2 * cell * float(np.mean(weight**2)))


def discs(grid: Grid) -> tuple[list[tuple[slice, slice]], Grid]:
    """Return the places of the discs in a map, evenly along its longer side, and the grid of each."""
    along = int(np.argmax(grid.lengths))
    whole = grid.shape[along]
    points = min(max(round(min(grid.lengths) / grid.spacing[along]), 2), whole)
    count = 1 + math.ceil((whole - points) / (0.5 * points))
    starts = np.rint(np.linspace(0, whole - points, count)).astype(int).tolist()
    nx, ny = grid.shape
    x, y = grid.lengths
    length = points * grid.spacing[along]
    part = Grid((nx, points), (x, length)) if along else Grid((points, ny), (length, y))
    places = [(slice(start, start + points), slice(None)) for start in starts]
    return [place[::-1] if along else place for place in places], part


def window_share(chosen: Mask, grid: Grid) -> float:
    """Return the share of some points of a map in its C(q): each counts by the square of the windows over it."""
    parts, part = discs(grid)
    squares = np.zeros(grid.shape)
    for place in parts:
        squares[place] += window(part) ** 2
    return float(squares[chosen].sum() / squares.sum())


def share_of_scatter(weight: Array, parts: Sequence[tuple[slice, slice]]) -> float:
    """Return how much of the scatter of one part the mean over all parts keeps, as these overlap (Welch)."""
    total = float((weight**2).sum())
    starts = np.array([[place.start or 0 for place in pair] for pair in parts])
    shares = []
    for i, j in np.abs(starts[:, None] - starts).reshape(-1, 2):
        nx = max(weight.shape[0] - i, 0)
        ny = max(weight.shape[1] - j, 0)
        common = weight[i:, j:] * weight[:nx, :ny]
        shares.append((float(common.sum()) / total) ** 2)
    return float(np.mean(shares))


def window(grid: Grid) -> Array:
    """Return the Hann window of SurfaceTopography: cos²(πr/2R) within R, half of the shorter side; not normalized."""
    nx, ny = grid.shape
    dx, dy = grid.spacing
    x = (np.arange(nx) - nx // 2) * dx
    y = (np.arange(ny) - ny // 2) * dy
    r = np.minimum(np.hypot(x[:, None], y) / (0.5 * min(grid.lengths)), 1.0)
    return 0.5 + 0.5 * np.cos(np.pi * r)


def radial_average(
    psd: Array, grid: Grid, q_max: float, *, together: float = 1.0, share: float = 1.0
) -> BinnedSpectrum:
    """Average C(q⃗) over directions, in bins of log q.

    `psd` is C(q⃗), m⁴, at the modes of `grid.half_shape`, ∫ C d²q = ⟨h²⟩; the others are as for `binned`.
    """
    q = grid.wavenumbers
    cell = 4 * np.pi**2 / (grid.lengths[0] * grid.lengths[1])
    weight = np.broadcast_to(grid.multiplicity, q.shape)
    q, psd, weight = (values[q > 0.0] for values in (q, psd, weight))
    return binned(q, psd, weight, cell, q_max, together=together, share=share)


def binned(
    q: Array,
    psd: Array,
    weight: Array,
    cell: float,
    q_max: float,
    *,
    together: float = 1.0,
    share: float = 1.0,
) -> BinnedSpectrum:
    """Average C of modes over bins of log q.

    Within a bin C(q) is taken as the power law of its neighbours, so that the value at its centre is not raised by its
    lower edge. The error follows from the scatter of the modes in a bin, at least the scatter of Gaussian heights.

    Parameters
    ----------
    q, psd, weight : array
        Wavenumber of each mode, rad/m, above 0, its C, and for how many modes it stands.
    cell : float
        Of a mode: ∫ C is Σ weight · psd · cell = ⟨h²⟩, m².
    q_max : float
        Upper end, rad/m.
    together : float
        How many modes count as one.
    share : float
        Scatter of the modes of Gaussian heights over the scatter of the modes of one map.

    Raises
    ------
    ValueError
        If fewer than three bins hold modes.
    """
    # all modes up to q_max or to the upper end of a synthetic map
    present = psd > _ROUNDING * psd.max()
    inside = q <= min(q_max, float(q[present].max())) * (1 + 1e-12)
    weight = weight[inside]
    q = q[inside]
    values = psd[inside]
    # their bins, in log q
    low = int(np.floor(BINS_PER_DECADE * np.log10(q.min()) + 1e-9))
    q_max = float(q.max())
    which = np.floor(BINS_PER_DECADE * np.log10(q) + 1e-9).astype(np.intp) - low
    if BINS_PER_DECADE * np.log10(q_max) - low - which.max() < 0.5:
        # less than half a bin: it joins the one below
        which = np.minimum(which, which.max() - 1)
    count = np.bincount(which, weight)
    filled = count > 0
    if filled.sum() < 3:
        raise ValueError(
            f"only {filled.sum()} bins of wavenumbers up to q_max = {q_max:.4g} rad/m hold modes"
        )
    which = (np.cumsum(filled) - 1)[which]
    count = count[filled]
    # the mean of each bin is made the value at its centre, by the power law of its neighbours
    centre = np.exp(np.bincount(which, weight * np.log(q)) / count)
    mean = np.bincount(which, weight * values) / count
    exponent = -np.gradient(np.log(mean), np.log(centre))
    # the power law over the bin, 1 at its centre
    shape = (q / centre[which]) ** -exponent[which]
    mean_shape = np.bincount(which, weight * shape) / count
    level = mean / mean_shape
    # the modes of Gaussian heights scatter by as much as their mean, and q has the same as −q
    apart = values / (level[which] * shape) - 1.0
    scatter = np.bincount(which, weight * apart**2) / count
    error = np.sqrt(2.0 * together * np.maximum(scatter, share) / count)
    variance = float((weight * values).sum()) * cell
    return BinnedSpectrum(
        centre, level, exponent, error, low + np.flatnonzero(filled), variance, q_max
    )


def _lowest_exponent(q: Array, psd: Array) -> float:
    """Return the exponent of the power law over the first rows, from 0 to 4."""
    first = slice(0, _FIRST_BINS)
    slope, _ = np.polyfit(np.log(q[first]), np.log(psd[first]), 1)
    return float(np.clip(-slope, 0.0, 4.0))


def combined(maps: Sequence[BinnedSpectrum]) -> MeasuredSpectrum:
    """Return C(q) of one map, or of several of one surface over all their bands, with its error.

    Several are combined by SurfaceTopography: in each bin the mean over the maps that have it, each with the same
    weight. ImportError without it. A RuntimeWarning names a gap between bands.
    """
    if len(maps) == 1:
        (one,) = maps
        q = one.q
        psd = one.psd
        errors = one.error[:, None]
    else:
        q, psd, errors = _mean_over_maps(maps)
    longest = min(maps, key=lambda one: float(one.q[0])).longest
    return _with_ends(q, psd, errors, longest, max(one.q_max for one in maps))


class _OfContainer(NamedTuple):
    """Interface of a map in a container for the averages of SurfaceTopography."""

    q: Array
    psd: Array

    def to_unit(self, _: str) -> "_OfContainer":
        """All are in m."""
        return self

    def spectrum(self, **_: object) -> tuple[Array, Array]:
        """C(q)."""
        return self.q, self.psd


def _mean_over_maps(maps: Sequence[BinnedSpectrum]) -> tuple[Array, Array, Array]:
    """Return q, rad/m, in the middle of each bin that some map has, the mean C, m⁴, and its errors as they are kept."""
    from SurfaceTopography.Container.Averaging import log_average  # type: ignore[import-not-found,import-untyped,unused-ignore]

    tables = []
    for one in maps:
        middle = 10.0 ** ((one.index + 0.5) / BINS_PER_DECADE)
        tables.append(_OfContainer(middle, one.psd * (middle / one.q) ** -one.exponent))
    found = log_average(tables, "spectrum", "m", nb_points_per_decade=BINS_PER_DECADE)
    present = ~np.ma.getmaskarray(found[1])
    q, psd = (np.asarray(column[present]) for column in found)
    if (step := float(np.max(q[1:] / q[:-1]))) > GAP:
        k = int(np.argmax(q[1:] / q[:-1]))
        warnings.warn(
            f"the scans leave a gap from q = {q[k]:.4g} to {q[k + 1]:.4g} rad/m, a factor {step:.3g}, over which C(q) "
            "is taken as a power law; add a scan of a size between",
            RuntimeWarning,
            stacklevel=2,
        )
    # C of each map in each bin, relative to the mean: (maps, bins), NaN in empty bins
    index = np.rint(BINS_PER_DECADE * np.log10(q) - 0.5).astype(np.intp)
    values = np.full((len(maps), q.size), np.nan)
    scatter = np.zeros((len(maps), q.size))
    for k, (one, table) in enumerate(zip(maps, tables, strict=True)):
        rows = np.searchsorted(index, one.index)
        values[k, rows] = table.psd / psd[rows]
        scatter[k, rows] = one.error * values[k, rows]
    count = np.sum(np.isfinite(values), axis=0)
    sampling = np.sqrt(np.sum(scatter**2, axis=0)) / count
    # without a map the mean is (n − own)/(n − 1); n − 1 over n of the squares of its changes add up to the variance
    with np.errstate(invalid="ignore", divide="ignore"):
        change = (1.0 - values) / (count - 1) * np.sqrt((count - 1) / count)
    without = np.where(count > 1, change, 0.0)
    return q, psd, np.column_stack([sampling, *np.nan_to_num(without)])


def _with_ends(
    q: Array, psd: Array, errors: Array, longest: float, q_max: float
) -> MeasuredSpectrum:
    """Return the table from the wavenumber `longest` to q_max, rad/m, as power laws beyond its first and last rows.

    A row that was added has the error of the row beside it. As they move together, the independent part of both is √2
    times as large: its square then is at least the square of the sum.
    """
    rows = np.flatnonzero(q < q_max * (1 - 1e-6)).tolist()
    lowest_slope = -_lowest_exponent(q, psd)
    rise = np.log(psd[-1] / psd[-2])
    highest_slope = float(rise / np.log(q[-1] / q[-2]))
    last = min(len(rows), q.size - 1)  # the row that the end is nearest to
    first = [0] if longest < 0.999 * q[0] else []
    source = np.array([*first, *rows, last])  # row of the error of each row of the result
    low = psd[first] * (longest / q[first]) ** lowest_slope
    high = psd[last] * (q_max / q[last]) ** highest_slope
    psd = np.concatenate([low, psd[rows], [high]])
    q = np.concatenate([np.full(len(first), longest), q[rows], [q_max]])
    errors = errors[source]
    for twice in np.flatnonzero(source[1:] == source[:-1]):
        errors[twice : twice + 2, 0] *= np.sqrt(2.0)
    return MeasuredSpectrum(TabulatedSpectrum(q, psd), errors)
