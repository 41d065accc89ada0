"""Spectra C(q⃗) that depend on the direction of the wave: of measured maps, and of faces with several lays.

C(q⃗) is the isotropic C(q), its mean over directions, times a factor M(q, φ) with mean 1 over φ, and M(φ + π) = M(φ).
Theory, cell and cut-offs follow from C(q); only the variances of the modes have M, so surfaces keep their rms height.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import cosh, log, pi, sinh, sqrt
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from roughsim.grid import Array, Grid
from roughsim.surface.power_laws import TabulatedSpectrum
from roughsim.surface.spectrum import Face

ANGLES = 45  # of a measured table over half a turn
_SMOOTH = (
    0.12,
    pi / 45,
)  # standard deviations in ln q and angle over which a periodogram is averaged
_FINE = 0.03, 180  # steps of ln q, and angles over half a turn, of the averages
_ROWS = 0.12  # of ln q between rows
_MOST_ROWS = 60
_CROSSED = 0.3  # of cos 4φ: of two lays of 2 at right angles; isotropic maps of four longest waves reach 0.22
_WIDTH = 0.2  # of ln q, over which the mean over directions is taken
_PER_DECADE, _MANY_ANGLES = 120, 720  # of the mean of lays over directions


@dataclass(frozen=True, slots=True)
class Directions:
    """A table of M(q, φ), linear between its rows in ln q and its even angles, constant beyond the rows.

    Attributes
    ----------
    q : tuple of float
        Wavenumbers of the rows, rad/m, rising.
    rows : tuple of tuples of float
        M at even angles φ of q⃗ from axis 0 towards axis 1, from 0 on, below π; each row is divided by its mean.
    """

    q: tuple[float, ...]
    rows: tuple[tuple[float, ...], ...]

    def __post_init__(self) -> None:
        q, rows = np.array(self.q), [np.array(row) for row in self.rows]
        if q.size < 1 or len(rows) != q.size or not (np.diff(q) > 0.0).all() or not q[0] > 0.0:
            raise ValueError("directions need a row for each of some rising wavenumbers above 0")
        if len({row.size for row in rows}) > 1 or not all(
            row.min(initial=0.0) >= 0.0 and 0.0 < row.sum() < np.inf for row in rows
        ):
            raise ValueError("directions need rows of equal length, ≥ 0 and not all 0")

    @property
    def crossed(self) -> bool:
        """Whether lays cross, of which no γ tells: by the part of cos 4φ, the mean over the rows."""
        table = np.array(self.rows)
        wave = np.exp(4j * pi * np.arange(table.shape[1]) / table.shape[1])  # φ below π
        part = 2.0 * (table @ wave) / table.sum(axis=1)
        return bool(abs(part.mean()) > _CROSSED)

    def __call__(self, q: ArrayLike, angle: ArrayLike) -> Array:
        """Return M at wavenumbers, rad/m, and angles, radians."""
        table = np.array(self.rows)
        table = table / table.mean(axis=1, keepdims=True)
        rows, angles = table.shape
        place = np.interp(np.log(q), np.log(self.q), np.arange(rows))
        row = np.minimum(place.astype(np.intp), max(rows - 2, 0))
        turn = np.mod(angle, pi) * (angles / pi)
        left = turn.astype(np.intp) % angles
        right = (left + 1) % angles
        between = turn - np.floor(turn)

        def of_row(k: Any) -> Array:
            return np.asarray(table[k, left] + between * (table[k, right] - table[k, left]))

        low, high = of_row(row), of_row(np.minimum(row + 1, rows - 1))
        return low + (place - row) * (high - low)


@dataclass(frozen=True, slots=True)
class Lays:
    """C(q⃗) of the sum of surfaces with a lay each, whose cells are stretched by √γ along it and shrunk across it."""

    terms: tuple[tuple[Face, float, float], ...]  # C(q′), m⁴, γ, and angle of the lay, radians
    mean: TabulatedSpectrum  # C(q), m⁴, the mean over directions

    def __call__(self, q: ArrayLike) -> Any:
        """Return the mean C(q), m⁴, at wavenumbers, rad/m."""
        return self.mean(q)

    def at(self, q: ArrayLike, angle: ArrayLike) -> Array:
        """Return C(q⃗), m⁴, at wavenumbers, rad/m, and angles, radians."""
        return of_lays(self.terms, q, angle)


@dataclass(frozen=True, slots=True)
class DirectedSpectrum(Face):
    """C(q⃗) = C(q) M(q, φ): called with q alone it is C(q), the mean over directions."""

    whole: Face
    factor: "Directions | DirectionsOf"

    @property
    def breaks(self) -> tuple[float, ...]:
        """Ends and kinks of C(q), rad/m, rising."""
        return self.whole.breaks

    def __call__(self, q: ArrayLike) -> Any:
        """Return C(q) in m⁴ at wavenumbers in rad/m (any shape)."""
        return self.whole(q)

    def at(self, q: Array, angle: Array) -> Array:
        """Return C(q⃗), m⁴, at wavenumbers, rad/m, and angles, radians."""
        return np.asarray(self.whole(q) * self.factor(q, angle))

    def above(self, q: Any, start: Any, rise: Any) -> Any:
        """Return C(q) in m⁴ at q = start·e^rise, rad/m, with the precision of `whole` close above a break."""
        above = getattr(self.whole, "above", lambda at, *_: self.whole(at))
        return above(q, start, rise)

    def moment(self, order: float) -> float:
        """Return 2π ∫ q^(1 + order) C(q) dq over the whole spectrum, m^(2 − order)."""
        return self.whole.moment(order)

    def scaled(self, factor: float) -> "DirectedSpectrum":
        """Return the spectrum times `factor`."""
        return replace(self, whole=self.whole.scaled(factor))

    def truncated(self, *, q_max: float) -> "DirectedSpectrum":
        """Return the spectrum cut off at |q⃗| = q_max, rad/m; ValueError if nothing is left."""
        return replace(self, whole=self.whole.truncated(q_max=q_max))


@dataclass(frozen=True, slots=True)
class DirectionsOf:
    """M(q, φ) of another spectrum."""

    spectrum: Any

    def __call__(self, q: ArrayLike, angle: ArrayLike) -> Array:
        """Return M at wavenumbers, rad/m, and angles, radians."""
        mean = self.spectrum(q)
        return np.where(mean > 0.0, self.spectrum.at(q, angle) / np.where(mean > 0, mean, 1), 1)


def directed_as(like: Face, spectrum: Face) -> Face:
    """Return a spectrum with the directions of another, if that has any."""
    return DirectedSpectrum(spectrum, DirectionsOf(like)) if like.directed else spectrum


def of_lays(terms: Sequence[tuple[Face, float, float]], q: ArrayLike, angle: ArrayLike) -> Array:
    """Return Σ C(q′), m⁴, of surfaces with a lay each, at wavenumbers, rad/m, and angles, radians."""
    total = np.zeros(np.broadcast_shapes(np.shape(q), np.shape(angle)))
    for face, ratio, lay in terms:
        # |q′|² = q²(γ cos² + sin²/γ) of the angle to the lay
        turned = np.cos(2.0 * (np.asarray(angle) - lay))
        total += face(np.asarray(q) * np.sqrt(cosh(log(ratio)) + sinh(log(ratio)) * turned))
    return total


def with_lays(terms: Sequence[tuple[Face, float, float]]) -> DirectedSpectrum:
    """Return C(q⃗) of the sum of uncorrelated surfaces with a lay each, on square pixels.

    A surface with γ reaches from q_min/√γ to q_max √γ: it takes γ times the points of an isotropic one with as fine
    pixels across the lay.

    Parameters
    ----------
    terms : sequence of (Face, float, float)
        C(q′) of each surface before its cell is stretched, m⁴; γ ≥ 1; the angle of its lay, radians.
    """
    for _, ratio, lay in terms:
        if not (1.0 <= ratio < np.inf and abs(lay) < np.inf):
            raise ValueError(
                f"lay = {ratio:g} at {lay:g} rad must be ≥ 1 and finite; exchange along and across below 1"
            )
    low = min(face.breaks[0] / sqrt(ratio) for face, ratio, _ in terms) * (1 + 1e-9)
    high = max(face.breaks[-1] * sqrt(ratio) for face, ratio, _ in terms) * (1 - 1e-9)
    q = np.geomspace(low, high, 2 + round(_PER_DECADE * np.log10(high / low)))
    angles = (np.arange(_MANY_ANGLES) + 0.5) * (pi / _MANY_ANGLES)
    mean = of_lays(terms, q[:, None], angles).mean(axis=1)
    inside = mean > 0.0  # at the ends a narrow range of angles may lie between the angles
    table = TabulatedSpectrum(q[inside], mean[inside])
    table = table.scaled(sum(face.moment(0) for face, *_ in terms) / table.moment(0))
    return DirectedSpectrum(table, DirectionsOf(Lays(tuple(terms), table)))


def measured_directions(power: Array, grid: Grid, q_max: float) -> Directions:
    """Return M(q, φ) of a periodic map up to `q_max`, rad/m: its periodogram, smoothed, over the mean over directions.

    `power` is |h(q⃗)|² at the modes of `grid.half_shape`, in any unit.
    """
    from scipy.ndimage import gaussian_filter1d  # slow to import

    q = grid.wavenumbers
    qx, qy = (np.broadcast_to(component, q.shape) for component in grid.wavevectors)
    once = (q > 0.0) & (q <= q_max * (1 + 1e-9)) & ((qy > 0.0) | (qx > 0.0))
    ln_q, angle, power = np.log(q[once]), np.arctan2(qy[once], qx[once]), power[once]
    # the mean over directions, so that a steep C(q) has no weight in an average over ln q
    ring = ((ln_q - ln_q.min()) / _WIDTH).astype(np.intp)
    count = np.bincount(ring)
    filled = count > 0
    centre = np.bincount(ring, ln_q)[filled] / count[filled]
    level = np.bincount(ring, power)[filled] / count[filled]
    level = np.maximum(level, 1e-12 * level.max())
    white = power / np.exp(np.interp(ln_q, centre, np.log(level)))
    # sums over small steps of ln q and angle, smoothed; far tails weigh the nearest modes where there are few
    step, angles = _FINE
    column = np.rint((np.mod(angle, pi)) * (angles / pi)).astype(np.intp) % angles
    line = np.rint((ln_q - ln_q.min()) / step).astype(np.intp)
    shape = int(line.max()) + 1, angles
    smooth: Callable[..., Any] = gaussian_filter1d
    sums = []
    for weight in (white, np.ones_like(white)):
        fine = np.bincount(line * angles + column, weight, shape[0] * angles).reshape(shape)
        fine = smooth(fine, _SMOOTH[1] * angles / pi, axis=1, mode="wrap", truncate=22.0)
        sums.append(smooth(fine, _SMOOTH[0] / step, axis=0, mode="constant", truncate=12.0))
    every = max(round(_ROWS / step), -(-shape[0] // _MOST_ROWS))
    chosen = slice(None, None, every), slice(None, None, angles // ANGLES)
    factor = sums[0][chosen] / sums[1][chosen]
    factor = factor / factor.mean(axis=1, keepdims=True)
    rows = tuple(tuple(float(f"{value:.3g}") for value in row) for row in factor)
    first = float(np.exp(ln_q.min()))
    return Directions(
        tuple(float(f"{first * np.exp(every * step * k):.6g}") for k in range(len(rows))), rows
    )
