"""The texture of a measured map: the lay of its slopes, and how far its heights are from Gaussian ones.

C(q) is averaged over directions and has no phases. Surfaces drawn from C(q) have slopes that are alike in all
directions, and Gaussian heights. The texture of a map measures its difference from them.
"""

from collections.abc import Iterator
from math import degrees, pi
from typing import NamedTuple

import numpy as np

from roughsim.grid import Array, Grid
from roughsim.show.remarks import Remark
from roughsim.surface.topography.periodic import periodic_part

_UNEVEN = 1.5  # rms slope across over along: above, T_flash differs by as much and more from direction to direction
LEAST_SHARE = 0.01  # of ⟨|∇h|²⟩ or of ⟨h²⟩: an octave of less is of no account
_LEAST_MODES = 64  # of a band: isotropic ones of fewer modes have a ratio above 1.5 by chance
_STRAIGHT = 1e6  # the largest ratio: straight grooves have no slope along them but rounding
_KURTOSIS = 6.0  # isotropic Gaussian maps with few long waves reach 5.8
_OUTLYING = 8.0  # rms heights: Gaussian maps have no point beyond, however large they are
_TOPS = 0.05  # share of the points that are the highest
# of Gaussian maps: below there are flattened tops or deep pits, above sharp summits
_SLOPE_OF_TOPS = 2 / 3, 3 / 2
DRAWN = "the theory and drawn surfaces are isotropic"
_INSTEAD = "`roughsim press` computes the map itself"


class Texture(NamedTuple):
    """The texture of one map, in the order of the rows of `psd_texture` in a scene."""

    ratio: float  # ratio of the rms slopes across and along the lay, ≥ 1, of all waves
    angle: float  # of the lay, the direction of least slopes: radians from axis 0 towards axis 1, 0 ≤ angle < π
    band_ratio: float  # the same of the octave of waves with the largest ratio; of all waves if no octave has enough
    band_angle: float
    band_low: float  # its wavenumbers, rad/m
    band_high: float
    skewness: float  # ⟨h³⟩/⟨h²⟩^(3/2), 0 of Gaussian heights
    kurtosis: float  # ⟨h⁴⟩/⟨h²⟩², 3 of Gaussian heights
    outlying: float  # share of the points beyond 8 rms heights
    slope_of_tops: float  # rms slope of the highest 5 % of the points over the rms slope of all, 1 of Gaussian heights

    @property
    def isotropic(self) -> bool:
        """Whether slopes are as steep in all directions, within `_UNEVEN`."""
        return max(self.ratio, self.band_ratio) <= _UNEVEN

    @property
    def gaussian(self) -> bool:
        """Whether nothing shows that the heights are not Gaussian."""
        low, high = _SLOPE_OF_TOPS
        inside = self.kurtosis <= _KURTOSIS and self.outlying == 0.0
        return inside and low <= self.slope_of_tops <= high

    @property
    def lay(self) -> float:
        """The angle of the lay, radians: of the octave with the largest ratio if that alone is uneven."""
        return self.angle if self.ratio > _UNEVEN or self.isotropic else self.band_angle

    def slopes(self) -> str:
        """Return the lay in words."""
        text = f"slopes {self.ratio:.2g} times as steep across as along {_in_degrees(self.angle)}"
        if f"{self.ratio:.2g}" == "1":
            text = "slopes as steep in all directions"
        if self.band_ratio > max(_UNEVEN, self.ratio):
            waves = f"waves of {2e6 * pi / self.band_high:.2g} to {2e6 * pi / self.band_low:.2g} µm"
            text += f", {self.band_ratio:.2g} times along {_in_degrees(self.band_angle)} in {waves}"
        return text

    def heights(self) -> str:
        """Return the distribution of the heights in words."""
        return f"skewness {self.skewness:.2g}, kurtosis {self.kurtosis:.4g}"

    def extremes(self) -> str:
        """Return in words how steep the highest points are, and how many lie far out."""
        outlying = f"; {100 * self.outlying:.2g} % of the points lie beyond {_OUTLYING:g} rms"
        tops = f"the highest {100 * _TOPS:g} % of the points have {self.slope_of_tops:.2g} of the rms slope of all"
        return tops + outlying * (self.outlying > 0.0)

    def warnings(self, face: str) -> Iterator[Remark]:
        """Yield a warning for each way in which surfaces drawn from C(q) are not like the map of a face."""
        if not self.isotropic:
            yield Remark(
                "caution",
                f"isotropy of [{face}]",
                f"the map of [{face}] is not isotropic: {self.slopes()}, above {_UNEVEN:g}; {DRAWN}, and T_flash "
                f"differs between the directions of sliding; {_INSTEAD}, and gives T_flash along and across the lay",
            )
        if not self.gaussian:
            write_nan = f"; if the points beyond {_OUTLYING:g} rms are spikes of the instrument, write nan for them"
            spikes = write_nan * (self.outlying > 0.0)
            yield Remark(
                "caution",
                f"heights of [{face}]",
                f"the heights of the map of [{face}] are not Gaussian: {self.heights()} (Gaussian 0 and 3); "
                f"{self.extremes()} (Gaussian 1){spikes}; drawn surfaces have its C(q), but Gaussian heights without "
                f"its pits, flattened tops or dust, and T_flash may be off by a factor; {_INSTEAD}, and gives the "
                "ratio of the map to a Gaussian twin",
            )


def _in_degrees(angle: float) -> str:
    """Return the angle of an axis in whole degrees, from "0°" to "179°"."""
    return f"{round(degrees(angle)) % 180}°"


def texture_of(heights: Array, grid: Grid, *, periodic: bool, reliable: float = np.inf) -> Texture:
    """Return the texture of a map without mean and tilt.

    Slopes include all waves that the map resolves alike in all directions, up to the lower of its two Nyquist
    wavenumbers, and of the periodic part of the map. So neither edges nor oblong pixels make a lay.

    Parameters
    ----------
    heights : ndarray
        Shape `grid.shape`, m, not all equal.
    grid : Grid
        Points and sides.
    periodic : bool
        Whether the map goes on at its edges; else its `periodic_part` is taken.
    reliable : float
        Wavenumber up to which the instrument resolves, rad/m.
    """
    modes = np.fft.rfft2(heights if periodic else periodic_part(heights))
    power = (modes.real**2 + modes.imag**2) * grid.multiplicity
    whole, octaves = lays(power, grid, min(grid.nyquist, reliable))
    steepest = max(octaves, key=lambda octave: octave[0], default=whole)
    standard = heights - heights.mean()
    standard = standard / np.sqrt(np.mean(standard**2))
    return Texture(
        *whole[:2],
        *steepest,
        skewness=float(np.mean(standard**3)),
        kurtosis=float(np.mean(standard**4)),
        outlying=float(np.mean(np.abs(standard) > _OUTLYING)),
        slope_of_tops=slope_of_tops(heights, grid),
    )


_OneLay = tuple[float, float, float, float]  # ratio, angle, and the lowest and highest wavenumber


def lays(power: Array, grid: Grid, q_max: float) -> tuple[_OneLay, list[_OneLay]]:
    """Return the lay of all waves up to `q_max`, rad/m, and the lays of octaves with enough modes.

    `power` is |h(q⃗)|² at the modes of `grid.half_shape`, times their multiplicity.
    """
    q = grid.wavenumbers
    qx, qy = (np.broadcast_to(component, q.shape) for component in grid.wavevectors)
    inside = (q > 0.0) & (q <= q_max * (1 + 1e-9))
    weighted = power[inside]
    count = np.broadcast_to(grid.multiplicity, q.shape)[inside]
    octave = np.floor(np.log2(q_max / q[inside]) + 1e-9).astype(np.intp)
    # ⟨∇h ∇hᵀ⟩ of each octave, up to a common factor
    products = [(qx * qx)[inside], (qx * qy)[inside], (qy * qy)[inside]]
    sums = np.stack([np.bincount(octave, part * weighted) for part in products], axis=1)
    modes = 0.5 * np.bincount(octave, count)
    slopes = sums[:, 0] + sums[:, 2]
    heights = np.bincount(octave, weighted)
    steep = slopes > LEAST_SHARE * slopes.sum()
    high = heights > LEAST_SHARE * heights.sum()
    enough = np.flatnonzero((steep | high) & (modes >= _LEAST_MODES)).tolist()
    octaves = [(*_principal_axes(*sums[k]), q_max * 0.5 ** (k + 1), q_max * 0.5**k) for k in enough]
    whole = *_principal_axes(*sums.sum(axis=0)), float(q[inside].min()), q_max
    return whole, octaves


def _principal_axes(xx: float, xy: float, yy: float) -> tuple[float, float]:
    """Return the ratio of the rms slopes across and along, and the angle of the axis along, of ⟨∇h ∇hᵀ⟩."""
    mean, apart = 0.5 * (xx + yy), float(np.hypot(0.5 * (xx - yy), xy))
    ratio = float(np.sqrt((mean + apart) / max(mean - apart, (mean + apart) / _STRAIGHT**2)))
    across = 0.5 * float(np.arctan2(2.0 * xy, xx - yy))  # of the larger eigenvalue
    return ratio, (across + 0.5 * pi) % pi


def slope_of_tops(heights: Array, grid: Grid) -> float:
    """Return the rms slope of the highest points (share `_TOPS`) over the rms slope of all, by central differences."""
    inner, (dx, dy) = heights[1:-1, 1:-1], grid.spacing
    along_x = heights[2:, 1:-1] - heights[:-2, 1:-1]
    along_y = heights[1:-1, 2:] - heights[1:-1, :-2]
    squares = (along_x / dx) ** 2 + (along_y / dy) ** 2
    top = inner >= np.quantile(inner, 1.0 - _TOPS)
    return float(np.sqrt(squares[top].mean() / squares.mean()))
