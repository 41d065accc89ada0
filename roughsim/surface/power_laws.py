"""Spectra that are power laws between their breaks, with exact moments: self-affine, and a table."""

from abc import abstractmethod
from dataclasses import dataclass, replace
from math import expm1, log, pi
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from roughsim.errors import number, positive, sized
from roughsim.grid import Array
from roughsim.surface.spectrum import Face

# One stretch of C(q): from q_left to q_right, C(q) = psd_left (q/q_left)^(−exponent).
_Piece = tuple[float, float, float, float]


class PowerLaws(Face):
    """A spectrum that is a power law between each two neighbouring breaks."""

    __slots__ = ()

    @property
    @abstractmethod
    def pieces(self) -> tuple[_Piece, ...]:
        """The stretches (q_left, q_right, C(q_left), exponent), rising in q."""

    @property
    def breaks(self) -> tuple[float, ...]:
        """Ends and kinks of C(q), rad/m, rising."""
        return (*(piece[0] for piece in self.pieces), self.pieces[-1][1])

    def moment(self, order: float) -> float:
        """Return 2π ∫ q^(1 + order) C(q) dq over the whole spectrum, m^(2 − order)."""
        total = 0.0
        for left, right, psd, exponent in self.pieces:
            power = 2.0 + order - exponent
            span = log(right / left)
            growth = expm1(power * span) / power if power else span
            total += psd * left ** (2.0 + order) * growth
        return 2 * pi * total

    def __call__(self, q: ArrayLike) -> Any:
        """Return C(q) in m⁴ at wavenumbers in rad/m (any shape); zero outside [q_min, q_max]."""
        q = np.asarray(q, dtype=float)
        left, right, psd, exponent = (np.array(column) for column in zip(*self.pieces, strict=True))
        inside = (q >= left[0]) & (q <= right[-1])
        index = np.clip(np.searchsorted(left, q, side="right") - 1, 0, len(left) - 1)
        ratio = np.where(inside, q, left[index]) / left[index]
        value = np.where(inside, psd[index] * ratio ** (-exponent[index]), 0.0)
        return value if value.ndim else float(value)


@dataclass(frozen=True, slots=True)
class SelfAffineSpectrum(PowerLaws):
    """C(q) ∝ q^(−m) from q_min to q_roll_off and ∝ q^(−2−2H) from there to q_max, sharp at both ends.

    Use `from_rms_height` or `from_rms_slope`. The plain constructor takes the value at the roll-off, so that a
    truncated spectrum keeps its level. TypeError or ValueError for an argument of the wrong kind or out of its range.

    Parameters
    ----------
    psd_at_roll_off : float
        C(q_roll_off), m⁴.
    hurst : float
        H in [0, 1].
    q_min, q_roll_off, q_max : float
        Ends and kink, rad/m, q_min < q_max. A kink outside the ends is no kink.
    roll_off_exponent : float
        m of the low-q branch; 0 is a plateau.
    """

    psd_at_roll_off: float
    hurst: float
    q_min: float
    q_roll_off: float
    q_max: float
    roll_off_exponent: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(
            self, "psd_at_roll_off", positive("psd_at_roll_off", self.psd_at_roll_off, "m⁴")
        )
        for name in ("q_min", "q_roll_off", "q_max"):
            object.__setattr__(self, name, sized(name, getattr(self, name), "rad/m"))
        for name in ("hurst", "roll_off_exponent"):
            object.__setattr__(self, name, number(name, getattr(self, name)))
        if not 0.0 <= self.hurst <= 1.0:
            raise ValueError(f"hurst = {self.hurst:.6g} must lie in [0, 1]")
        if self.q_min >= self.q_max:
            raise ValueError(
                f"q_min = {self.q_min:.6g} rad/m must be below q_max = {self.q_max:.6g} rad/m"
            )

    @classmethod
    def from_rms_height(
        cls,
        rms_height: float,
        *,
        hurst: float,
        q_min: float,
        q_max: float,
        q_roll_off: float | None = None,
        roll_off_exponent: float = 0.0,
    ) -> Self:
        """Return the spectrum with a given `rms_height` = √⟨h²⟩ over the whole band, m.

        The other arguments are as in `SelfAffineSpectrum`, with q_roll_off in [q_min, q_max]; q_min if left out.
        """
        unit = cls._of_unit_level(hurst, q_min, q_roll_off, q_max, roll_off_exponent)
        return unit.scaled((sized("rms_height", rms_height, "m") / unit.rms_height) ** 2)

    @classmethod
    def from_rms_slope(
        cls,
        rms_slope: float,
        *,
        hurst: float,
        q_min: float,
        q_max: float,
        q_roll_off: float | None = None,
        roll_off_exponent: float = 0.0,
    ) -> Self:
        """Return the spectrum with a given slope `rms_slope` = √⟨|∇h|²⟩ over the whole band; see `from_rms_height`."""
        unit = cls._of_unit_level(hurst, q_min, q_roll_off, q_max, roll_off_exponent)
        return unit.scaled((sized("rms_slope", rms_slope) / unit.rms_slope) ** 2)

    @classmethod
    def _of_unit_level(
        cls,
        hurst: float,
        q_min: float,
        q_roll_off: float | None,
        q_max: float,
        roll_off_exponent: float,
    ) -> Self:
        kink = q_min if q_roll_off is None else q_roll_off
        unit = cls(1.0, hurst, q_min, kink, q_max, roll_off_exponent)
        if not q_min <= kink <= q_max:
            ends = f"q_min = {q_min:.6g} and q_max = {q_max:.6g} rad/m"
            raise ValueError(f"q_roll_off = {kink:.6g} rad/m must lie between {ends}")
        return unit

    @property
    def pieces(self) -> tuple[_Piece, ...]:
        """The stretches (q_left, q_right, C(q_left), exponent), rising in q."""
        low = self.roll_off_exponent
        high = 2.0 + 2.0 * self.hurst
        kink = min(max(self.q_roll_off, self.q_min), self.q_max)
        return tuple(
            (left, right, self.psd_at_roll_off * (left / self.q_roll_off) ** -exponent, exponent)
            for left, right, exponent in ((self.q_min, kink, low), (kink, self.q_max, high))
            if left < right
        )

    def scaled(self, factor: float) -> Self:
        """Return the spectrum times `factor`; 2 stands for two faces of the same roughness, uncorrelated."""
        return replace(self, psd_at_roll_off=self.psd_at_roll_off * positive("factor", factor))

    def truncated(self, *, q_max: float) -> Self:
        """Return the spectrum cut off at `q_max`, rad/m; its level does not change."""
        return replace(self, q_max=min(positive("q_max", q_max, "rad/m"), self.q_max))


@dataclass(frozen=True, slots=True, eq=False)
class TabulatedSpectrum(PowerLaws):
    """C(q) from a table, a power law between each two points and zero outside.

    TypeError or ValueError for a column of the wrong kind, length or order.

    Parameters
    ----------
    q : array_like
        Wavenumbers, rad/m, at least two, positive and rising.
    psd : array_like
        C(q), m⁴, in Persson's convention (see `roughsim`), positive. A spectrum in SurfaceTopography's convention
        is 4π² larger.
    """

    q: Array
    psd: Array

    def __post_init__(self) -> None:
        for name, unit in (("q", "rad/m"), ("psd", "m⁴")):
            column = getattr(self, name)
            if isinstance(column, np.ma.MaskedArray) or np.asarray(column).dtype.kind not in "uif":
                kind = f"{type(column).__name__} of dtype {np.asarray(column).dtype}"
                raise TypeError(
                    f"{name} is a {kind}; a plain array of real numbers in {unit} is needed"
                )
            array = np.array(column, dtype=float)
            if array.ndim != 1 or array.size < 2:
                raise ValueError(
                    f"{name} has shape {array.shape}; a table of at least two points is needed"
                )
            lawful = (array > 0) & np.isfinite(array)
            if not lawful.all():
                raise ValueError(
                    f"{name} holds {array[~lawful][0]} {unit}; every value must be finite and positive"
                )
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        if self.q.shape != self.psd.shape:
            raise ValueError(f"q has {self.q.size} points but psd has {self.psd.size}")
        falls = np.flatnonzero(np.diff(self.q) <= 0)
        if falls.size:
            raise ValueError(
                f"q = {self.q[falls[0] + 1]:.6g} rad/m follows q = {self.q[falls[0]]:.6g} rad/m and must exceed it; "
                f"sort the table and drop repeated points"
            )

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, TabulatedSpectrum):
            return NotImplemented
        return np.array_equal(self.q, other.q) and np.array_equal(self.psd, other.psd)

    def __hash__(self) -> int:
        return hash((self.q.tobytes(), self.psd.tobytes()))

    def __reduce__(self) -> tuple[Any, ...]:
        """Rebuild the copy, so that its arrays are read-only too."""
        return type(self), (self.q, self.psd)

    @property
    def pieces(self) -> tuple[_Piece, ...]:
        """The stretches (q_left, q_right, C(q_left), exponent), rising in q."""
        exponent = -np.diff(np.log(self.psd)) / np.diff(np.log(self.q))
        columns = self.q[:-1], self.q[1:], self.psd[:-1], exponent
        return tuple(zip(*(column.tolist() for column in columns), strict=True))

    def scaled(self, factor: float) -> "TabulatedSpectrum":
        """Return the spectrum times `factor`; 2 stands for two faces of the same roughness, uncorrelated."""
        return TabulatedSpectrum(self.q, self.psd * positive("factor", factor))

    def truncated(self, *, q_max: float) -> "TabulatedSpectrum":
        """Return the spectrum cut off at `q_max`, rad/m; ValueError if nothing is left."""
        end = min(positive("q_max", q_max, "rad/m"), float(self.q[-1]))
        if end <= self.q[0]:
            raise ValueError(
                f"q_max = {end:.6g} rad/m must exceed the first wavenumber {self.q[0]:.6g} rad/m"
            )
        below = self.q < end
        return TabulatedSpectrum(
            np.append(self.q[below], end), np.append(self.psd[below], self(end))
        )
