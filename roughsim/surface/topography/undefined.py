"""Undefined points: numbers that stand for them, and filling them."""

import numpy as np

from roughsim.grid import Array, Mask
from roughsim.surface.topography.instruments import library

# numbers by which programs mark a point without a height: gridded files, 16-bit instruments, missing data of netCDF
MARKS = (-9999.0, -99999.0, -32768.0, 32767.0, 65535.0, 9999.0, 99999.0)
_LARGEST = 1e30  # beyond it a number is a mark
_FAR = 100.0  # ranges of all other heights: a value that far away and there twice or more is a mark
_NAMED = 3  # so many marks beyond `_LARGEST` are named
_OFTEN = 10  # times as often as any other value


def without_marks(heights: Array) -> tuple[Array, list[float]]:
    """Return the heights with NaN in place of marks, and the marks that were found.

    A mark is a number beyond 1e30; one of `MARKS` that is farther from all other heights than these are from each
    other, or ten times as frequent as any of them; and a lowest or highest value that is there several times, a
    hundred of their ranges away.
    """
    heights = np.where(np.isfinite(heights), heights, np.nan)
    beyond = np.abs(heights) >= _LARGEST
    found = [float(mark) for mark in np.unique(heights[beyond])[:_NAMED]]
    heights = np.where(beyond, np.nan, heights)
    for _ in range(4):  # both ends, and a second mark at each
        present = heights[np.isfinite(heights)]
        if not present.size:
            break
        ends = float(present.min()), float(present.max())
        candidates = *ends, *(mark for mark in MARKS if ends[0] < mark < ends[1])
        mark = next((value for value in candidates if _is_mark(present, value)), None)
        if mark is None:
            break
        found.append(mark)
        heights = np.where(heights == mark, np.nan, heights)
    return heights, found


def _is_mark(present: Array, value: float) -> bool:
    """Whether a value stands for undefined points."""
    others = present[present != value]
    count = present.size - others.size
    if not count or not others.size:
        return False
    extent = float(np.ptp(others))
    away = float(np.abs(others - value).min())
    if value not in MARKS:
        return count > 1 and extent > 0.0 and away > _FAR * extent
    most = np.unique(others, return_counts=True)[1].max()
    return bool(away > extent or count > _OFTEN * max(1, most))


def filled(heights: Array, undefined: Mask) -> Array:
    """Return the heights with undefined points filled by harmonic interpolation (SurfaceTopography)."""
    kind = library().Topography if heights.ndim == 2 else library().UniformLineScan
    shape = heights.shape if heights.ndim == 2 else heights.size
    masked = kind(np.ma.masked_array(heights, undefined), shape)
    return np.ascontiguousarray(masked.interpolate_undefined_data().heights(), dtype=float)
