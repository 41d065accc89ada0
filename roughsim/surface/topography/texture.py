"""The texture of a measured map: the lay of its waves, and how far its heights are from Gaussian ones.

C(q) is averaged over directions and has no phases. Surfaces drawn from C(q) are alike in all directions, and have
Gaussian heights. The texture of a map measures its difference from them.
"""

from collections.abc import Iterator
from math import degrees, pi
from typing import NamedTuple

import numpy as np

from roughsim.grid import Array, Grid
from roughsim.show.remarks import Remark
from roughsim.surface.topography.lay import lays_of
from roughsim.surface.topography.periodic import periodic_part

UNEVEN = 1.25  # γ: above, T_flash along and across differs from the mean by more than 5 %
_BY_SLOPES = 1.5  # γ, by the ratio of slopes, of isotropic maps of older scenes
_LEAST_SHARE = 0.01  # of ⟨|∇h|²⟩ or of ⟨h²⟩: an octave of less is of no account
_ROWS = 4.0  # degrees from a scan axis
_KURTOSIS = 6.0  # isotropic Gaussian maps with few long waves reach 5.8
_OUTLYING = 8.0  # rms heights: Gaussian maps have no point beyond, however large they are
_TOPS = 0.05  # share of the points that are the highest
# of Gaussian maps: below there are flattened tops or deep pits, above sharp summits
_SLOPE_OF_TOPS = 2 / 3, 3 / 2
DRAWN = "the theory and drawn surfaces are isotropic"
_INSTEAD = "`roughsim press` computes the map itself"


class Texture(NamedTuple):
    """The texture of one map, in the order of the rows of `psd_texture` in a scene."""

    ratio: float  # γ of the correlation lengths along and across the lay, of waves with 95 % of ⟨h²⟩; 1 without evidence
    angle: float  # of the lay: radians from axis 0 towards axis 1, 0 ≤ angle < π
    band_ratio: float  # the same of the octave of waves with the largest ratio; of all waves if no octave has enough
    band_angle: float
    band_low: float  # its wavenumbers, rad/m
    band_high: float
    skewness: float  # ⟨h³⟩/⟨h²⟩^(3/2), 0 of Gaussian heights
    kurtosis: float  # ⟨h⁴⟩/⟨h²⟩², 3 of Gaussian heights
    outlying: float  # share of the points beyond 8 rms heights
    slope_of_tops: float  # rms slope of the highest 5 % of the points over the rms slope of all, 1 of Gaussian heights
    evidence: float  # log-likelihood of the lay over isotropy

    @classmethod
    def of_row(cls, row: list[float]) -> "Texture":
        """Return the texture of a row of a scene; TypeError for another count.

        Rows of older scenes lack the evidence: there the slopes gave γ, up to 1.5 of isotropic maps.
        """
        if len(row) == len(cls._fields) - 1:
            row = [*row, 0.0]
            for ratio in (0, 2):
                row[ratio] = 1.0 if 1.0 < row[ratio] <= _BY_SLOPES else row[ratio]
        return cls(*row)

    @property
    def isotropic(self) -> bool:
        """Whether nothing shows a lay that counts, above `UNEVEN`."""
        return max(self.ratio, self.band_ratio) <= UNEVEN

    @property
    def gaussian(self) -> bool:
        """Whether nothing shows that the heights are not Gaussian."""
        low, high = _SLOPE_OF_TOPS
        inside = self.kurtosis <= _KURTOSIS and self.outlying == 0.0
        return inside and low <= self.slope_of_tops <= high

    @property
    def lay(self) -> float:
        """The angle of the lay, radians: of the octave with the largest ratio if that alone is uneven."""
        return self.angle if self.ratio > UNEVEN or self.isotropic else self.band_angle

    def waves(self) -> str:
        """Return the lay in words."""
        text = f"waves {self.ratio:.2g} times as long along {_in_degrees(self.angle)} as across"
        if f"{self.ratio:.2g}" == "1":
            text = "waves as long in all directions"
        if self.band_ratio > UNEVEN * self.ratio:
            waves = f"waves of {2e6 * pi / self.band_high:.2g} to {2e6 * pi / self.band_low:.2g} µm"
            text += f", {self.band_ratio:.2g} times along {_in_degrees(self.band_angle)} in {waves}"
        return text

    @property
    def of_instrument(self) -> bool:
        """Whether rows of the instrument may make the lay, as it is along a scan axis."""
        from_axis = (degrees(self.lay) + 45.0) % 90.0 - 45.0
        return not self.isotropic and abs(from_axis) <= _ROWS

    def heights(self) -> str:
        """Return the distribution of the heights in words."""
        return f"skewness {self.skewness:.2g}, kurtosis {self.kurtosis:.4g}"

    def extremes(self) -> str:
        """Return in words how steep the highest points are, and how many lie far out."""
        outlying = f"; {100 * self.outlying:.2g} % of the points lie beyond {_OUTLYING:g} rms"
        tops = f"the highest {100 * _TOPS:g} % of the points have {self.slope_of_tops:.2g} of the rms slope of all"
        return tops + outlying * (self.outlying > 0.0)

    def warnings(self, face: str, *, drawn: bool = False) -> Iterator[Remark]:
        """Yield a warning for each way in which drawn surfaces are not like the map of a face.

        `drawn` is whether they have the directions of the map.
        """
        if not self.isotropic and not drawn:
            yield Remark(
                "caution",
                f"isotropy of [{face}]",
                f"the map of [{face}] is not isotropic: {self.waves()}; {DRAWN}, and T_flash "
                f"differs between the directions of sliding; {_INSTEAD}, and gives T_flash along and across the lay",
            )
        if self.of_instrument:
            yield Remark(
                "caution",
                f"rows of [{face}]",
                f"the lay of [{face}] is within {_ROWS:g}° of a scan axis: if its lines are rows of the instrument and "
                "no grooves, level them row by row before",
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

    Waves count that the map resolves alike in all directions, up to the lower of its two Nyquist wavenumbers, of the
    periodic part of the map. So neither edges nor oblong pixels make a lay.

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
    power = modes.real**2 + modes.imag**2
    whole, octaves = lays_of(power, grid, min(grid.nyquist, reliable), _LEAST_SHARE)
    other = max(octaves, default=whole)
    standard = heights - heights.mean()
    standard = standard / np.sqrt(np.mean(standard**2))
    return Texture(
        *whole[:2],
        *other[:4],
        skewness=float(np.mean(standard**3)),
        kurtosis=float(np.mean(standard**4)),
        outlying=float(np.mean(np.abs(standard) > _OUTLYING)),
        slope_of_tops=slope_of_tops(heights, grid),
        evidence=whole.evidence,
    )


def slope_of_tops(heights: Array, grid: Grid) -> float:
    """Return the rms slope of the highest points (share `_TOPS`) over the rms slope of all, by central differences."""
    inner = heights[1:-1, 1:-1]
    dx, dy = grid.spacing
    along_x = heights[2:, 1:-1] - heights[:-2, 1:-1]
    along_y = heights[1:-1, 2:] - heights[1:-1, :-2]
    squares = (along_x / dx) ** 2 + (along_y / dy) ** 2
    top = inner >= np.quantile(inner, 1.0 - _TOPS)
    return float(np.sqrt(squares[top].mean() / squares.mean()))
