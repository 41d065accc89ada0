"""Patches of a contact: their number and sizes, and contact areas corrected for the pixels along their edges.

A contact is a set of pixels of the periodic grid. A pixel counts as a whole as soon as it carries pressure, so counted
areas are too large by a strip along the edge of the contact: 0.100 ± 0.001 pixels for each side of a pixel on the edge,
the mean over all directions. So it was measured on Westergaard's wave, turned on the grid, whose contact is known, at
20 to 80 pixels per wave and any load, and on Hertz contacts. Yastrebov, Anciaux & Molinari (Tribology International
114, 2017, 161) have (π − 1 + ln 2)/24 = 0.118 from how straight edges cut the pixels; rough elastic contact on less
than half of the area then lacks .5 to 2 % of it at 6 pixels per shortest wave.

Yielded patches are the mirror image: with σ_P − p for p and −h for h, the points at the hardness become the points
without contact. So a yielded area is counted too small, by the same strip. An edge from no contact to the hardness
between two pixels has no known bias, and is not corrected.
"""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from roughsim.errors import positive, real_field
from roughsim.fourier.blocks import run, spans, total
from roughsim.grid import Array, Field, Grid, Index, Mask, need_grid

_EDGE_SHARE = 0.1  # pixels by which each side of a pixel on the edge enlarges the contact
RESOLVED = 4  # pixels: the size of a smaller patch is set by the grid, not by the contact


class SizeDistribution(NamedTuple):
    """Patches by size, in bins that double: 1, 2–3, 4–7, … pixels."""

    edges: Array  # bounds of the bins, m², shape (n + 1,)
    counts: Index  # number of patches in each bin, shape (n,)
    areas: Array  # their area together, m², shape (n,)

    @property
    def density(self) -> Array:
        """Patches per area of patch in each bin, 1/m²: counts over widths, which follows a power law if n(A) does."""
        return self.counts / np.diff(self.edges)


@dataclass(frozen=True, slots=True, eq=False)
class Patches:
    """The connected patches of a set of pixels."""

    pixels: Index  # of each patch, largest first
    pixel_area: float  # m²

    @property
    def count(self) -> int:
        """Number of patches."""
        return self.pixels.size

    @property
    def areas(self) -> Array:
        """Area of each patch by its pixels, m², largest first."""
        return np.multiply(self.pixels, self.pixel_area, dtype=float)

    @property
    def largest(self) -> float:
        """Area of the largest patch, m²; 0 if there is none."""
        return float(self.areas[0]) if self.count else 0.0

    @property
    def unresolved(self) -> int:
        """Number of patches below 4 pixels: their size is set by the grid, not by the contact."""
        return int(np.count_nonzero(self.pixels < RESOLVED))

    @property
    def unresolved_share(self) -> float:
        """Fraction of the area that lies in patches below 4 pixels; NaN if there is none."""
        if not self.count:
            return math.nan
        return float(self.pixels[self.pixels < RESOLVED].sum() / self.pixels.sum())

    def size_distribution(self) -> SizeDistribution:
        """Return numbers and areas of the patches in bins of size."""
        powers = 2 ** np.arange(int(self.pixels.max(initial=0)).bit_length() + 1)
        counts, _ = np.histogram(self.pixels, powers)
        pixels, _ = np.histogram(self.pixels, powers, weights=self.pixels)
        return SizeDistribution(
            self.pixel_area * powers.astype(float), counts, self.pixel_area * pixels.astype(float)
        )


def contact_patches(mask: ArrayLike, grid: Grid) -> Patches:
    """Return the connected patches of a set of pixels; pixels join by their sides, also over the sides of the cell.

    Parameters
    ----------
    mask : array_like of bool
        Shape `grid.shape`, for example `contact.pressure > 0`.
    grid : Grid
        The grid of the mask.

    Returns
    -------
    Patches
        An empty contact has no patches, full contact has one.

    Raises
    ------
    TypeError, ValueError
        If `mask` is not of bool or not of `grid.shape`.
    """
    need_grid(grid)
    return Patches(patch_sizes(_pixels(mask, grid)), math.prod(grid.spacing))


def corrected_area(mask: ArrayLike, grid: Grid) -> float:
    """Return the area of a contact, corrected for the bias of the pixels along its edge.

    A − 0.1 S Δx, S the length of the edge as the pixels draw it; for oblong pixels the strip along each side has the
    pixel's width across it. Two things are assumed. The edges have all directions alike, as in rough contact: along a
    row of pixels the strip is 0.19 pixel wide. And the pressure falls to zero as a square root, as on any smooth
    surface: a surface that has yielded and is pressed again has steep edges, whose pixels add less. For a capped
    contact use `corrected_fractions`.

    Parameters
    ----------
    mask : array_like of bool
        Shape `grid.shape`, true at the points with p > 0.
    grid : Grid
        The grid of the mask.

    Returns
    -------
    float
        m².

    Raises
    ------
    TypeError, ValueError
        If `mask` is not of bool or not of `grid.shape`.
    """
    need_grid(grid)
    pixels = _pixels(mask, grid)
    touching, _, outer, _ = _counts(pixels, math.inf)
    return (touching - _EDGE_SHARE * outer) * math.prod(grid.spacing)


def corrected_fractions(
    pressure: ArrayLike, penetration_hardness: float = math.inf
) -> tuple[float, float]:
    """Return contact and plastic fraction, both corrected for the pixels along the edges.

    Along an edge of elastic contact with no contact the pixels add a tenth of a pixel per side; along its edge with
    yielded contact they take as much from the yielded. A side between no contact and yielded contact has no elastic
    strip that the grid resolves, and is not corrected: a contact which has all yielded keeps A = σ₀/σ_P.

    Parameters
    ----------
    pressure : array_like
        p of the whole periodic cell, 0 ≤ p ≤ σ_P, Pa.
    penetration_hardness : float
        σ_P, Pa; inf is elastic.

    Returns
    -------
    float, float
        0 ≤ plastic ≤ contact ≤ 1, the contact fraction first.

    Raises
    ------
    TypeError, ValueError
        If `pressure` is no finite real field or leaves its bounds, or the hardness is not positive.
    """
    field = real_field("pressure", pressure)
    return edge_corrected(field, _checked_hardness(field, penetration_hardness))


def edge_corrected(field: Field, hardness: Any) -> tuple[float, float]:
    """Return `corrected_fractions` of a pressure within its bounds (not checked again)."""
    touching, yielded, outer, inner = _counts(field, hardness)
    touching = touching - _EDGE_SHARE * outer
    yielded = yielded + _EDGE_SHARE * inner
    return touching / field.size, yielded / field.size


def yielded_points(pressure: Field, penetration_hardness: float) -> Mask:
    """Return the mask of p = σ_P, in the precision of the field; ValueError for pressures beyond the hardness."""
    return pressure == _checked_hardness(pressure, penetration_hardness)


def _checked_hardness(pressure: Field, penetration_hardness: float) -> Any:
    """Return σ_P in the precision of the field; ValueError for pressures beyond the hardness."""
    if penetration_hardness != math.inf:
        positive("penetration_hardness", penetration_hardness, "Pa")
    limit = pressure.dtype.type(penetration_hardness)
    if pressure.min() < 0.0 or pressure.max() > limit:
        raise ValueError(
            f"pressure = {pressure.min():.6g} to {pressure.max():.6g} Pa leaves the range from 0 to "
            f"penetration_hardness = {penetration_hardness:.6g} Pa; give the solid that the contact was solved with"
        )
    return limit


def patch_sizes(mask: Mask, *, periodic: bool = True) -> Index:
    """Return the pixels of each connected patch, largest first; `periodic` joins them over the sides of the cell."""
    labels, count = labelled_patches(mask, periodic=periodic)
    return np.sort(np.bincount(labels.ravel(), minlength=count + 1)[1:])[::-1]


def labelled_patches(mask: Mask, *, periodic: bool = True) -> tuple[Index, int]:
    """Return the number of each pixel's patch, from 1, 0 off all patches; and how many there are."""
    from scipy import ndimage
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    labels, count = ndimage.label(mask)
    if periodic and count:
        # parts that meet over a side of the cell are one region
        first, last = (np.concatenate((labels[end], labels[:, end])) for end in (0, -1))
        both = (first > 0) & (last > 0)
        pairs = first[both] - 1, last[both] - 1
        joins = coo_array((np.ones(pairs[0].size), pairs), shape=(count, count))
        count, joined = connected_components(joins, directed=False)
        labels = np.concatenate([[0], joined + 1])[labels]
    return labels.astype(np.int64, copy=False), int(count)


def _counts(field: Field, hardness: Any) -> tuple[float, ...]:
    """Count the points with p > 0 and with p = σ_P, and the sides of elastic points: to empty ones, to yielded ones."""
    capped = hardness < math.inf

    def count(start: int, stop: int) -> tuple[Any, ...]:
        # with the row before, periodic: 0 without contact, 1 elastic, 3 yielded
        kind = np.empty((1 + stop - start, field.shape[1]), np.uint8)
        before = kind[:1]
        own = kind[1:]
        for rows, part in ((before, field[start - 1][None]), (own, field[start:stop])):
            np.greater(part, 0, out=rows.view(np.bool_))
            if capped:
                np.add(rows, 2 * (part == hardness).view(np.uint8), out=rows)
        # the three pairs of unlike neighbours differ by different bits. Pairs along the rows are taken from all rows as
        # one line, several times as fast; the first column is then put right
        along = np.empty(own.shape, np.uint8)
        np.bitwise_xor(own.ravel()[1:], own.ravel()[:-1], out=along.ravel()[1:])
        np.bitwise_xor(own[:, 0], own[:, -1], out=along[:, 0])
        across = own ^ kind[:-1]
        touching = np.count_nonzero(own)
        outer = np.count_nonzero(along == 0 ^ 1) + np.count_nonzero(across == 0 ^ 1)
        if not capped:
            return touching, 0, outer, 0
        yielded = np.count_nonzero(own == 3)
        inner = np.count_nonzero(along == 1 ^ 3) + np.count_nonzero(across == 1 ^ 3)
        return touching, yielded, outer, inner

    return total(run(count, spans(*field.shape)))


def _pixels(mask: ArrayLike, grid: Grid) -> Mask:
    pixels = np.asarray(mask)
    if pixels.dtype != np.bool_:
        raise TypeError(
            f"mask has dtype {pixels.dtype}; give true or false for each pixel, for example pressure > 0"
        )
    if pixels.shape != grid.shape:
        raise ValueError(f"mask has shape {pixels.shape}, but the grid has shape {grid.shape}")
    return pixels
