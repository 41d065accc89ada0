"""Power spectra C(q) of isotropic roughness: self-affine, tabulated, any other callable, and sums of them.

Each spectrum is a callable C(q) in m⁴ that is zero outside its ends, and knows its `breaks`: the ends and the kinks
between which it is smooth. Those that are power laws between breaks have exact moments.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from math import ceil, expm1, inf, log, pi, sqrt
from typing import Any, Protocol, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughsim.errors import number, positive

# One stretch of C(q): from q_left to q_right, C(q) = psd_left (q/q_left)^(−exponent).
Piece = tuple[float, float, float, float]


class Spectrum(Protocol):
    """What every stage asks of a spectrum: C(q) and the wavenumbers between which it is smooth."""

    @property
    def breaks(self) -> tuple[float, ...]:
        """Wavenumbers where C(q) starts, has kinks, and ends, rad/m, rising."""

    def __call__(self, q: Any, /) -> Any:
        """C(q) in m⁴ at wavenumbers in rad/m; zero outside the ends."""


class _Moments(ABC):
    """Moments and algebra shared by all spectra."""

    __slots__ = ()

    @abstractmethod
    def moment(self, order: float) -> float:
        """Return 2π ∫ q^(1 + order) C(q) dq over the whole spectrum, m^(2 − order)."""

    @property
    def rms_height(self) -> float:
        """√⟨h²⟩ = √(2π ∫ q C dq), m."""
        return sqrt(self.moment(0))

    @property
    def rms_slope(self) -> float:
        """√⟨|∇h|²⟩ = √(2π ∫ q³ C dq), dimensionless."""
        return sqrt(self.moment(2))

    def __add__(self, other: Face | SumSpectrum) -> SumSpectrum:
        """Return the spectrum of the sum of two uncorrelated surfaces."""
        if not isinstance(other, _Moments):
            return NotImplemented
        return SumSpectrum((*_terms(self), *_terms(other)))


class PowerLaws(_Moments):
    """A spectrum that is a power law between each two neighbouring breaks."""

    __slots__ = ()

    @property
    @abstractmethod
    def pieces(self) -> tuple[Piece, ...]:
        """The stretches (q_left, q_right, C(q_left), exponent), rising in q."""

    @property
    def breaks(self) -> tuple[float, ...]:
        """Wavenumbers where C(q) starts, has kinks, and ends, rad/m, rising."""
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
        q = np.asarray(q, dtype=np.float64)
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
    truncated spectrum keeps its level.

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

    Raises
    ------
    TypeError, ValueError
        Naming the argument, its value and its limit.
    """

    psd_at_roll_off: float
    hurst: float
    q_min: float
    q_roll_off: float
    q_max: float
    roll_off_exponent: float = 0.0

    def __post_init__(self) -> None:
        for name, unit in (("psd_at_roll_off", "m⁴"), ("q_min", "rad/m"), ("q_roll_off", "rad/m"), ("q_max", "rad/m")):
            object.__setattr__(self, name, positive(name, getattr(self, name), unit))
        for name in ("hurst", "roll_off_exponent"):
            object.__setattr__(self, name, number(name, getattr(self, name)))
        if not 0.0 <= self.hurst <= 1.0:
            raise ValueError(f"hurst = {self.hurst:.6g} must lie in [0, 1]")
        if self.q_min >= self.q_max:
            raise ValueError(f"q_min = {self.q_min:.6g} rad/m must be below q_max = {self.q_max:.6g} rad/m")

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
        """Return the spectrum with a given rms height.

        Parameters
        ----------
        rms_height : float
            √⟨h²⟩ over the whole band, m.
        hurst : float
            H in [0, 1].
        q_min, q_max : float
            Ends of the band, rad/m.
        q_roll_off : float, optional
            Where the self-affine branch begins, rad/m, in [q_min, q_max]; q_min if left out.
        roll_off_exponent : float, optional
            m of C ∝ q^(−m) below q_roll_off.

        Raises
        ------
        TypeError, ValueError
            Naming the argument, its value and its limit.
        """
        unit = cls._of_unit_level(hurst, q_min, q_roll_off, q_max, roll_off_exponent)
        return unit.scaled((positive("rms_height", rms_height, "m") / unit.rms_height) ** 2)

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
        return unit.scaled((positive("rms_slope", rms_slope) / unit.rms_slope) ** 2)

    @classmethod
    def _of_unit_level(
        cls, hurst: float, q_min: float, q_roll_off: float | None, q_max: float, roll_off_exponent: float
    ) -> Self:
        kink = q_min if q_roll_off is None else q_roll_off
        unit = cls(1.0, hurst, q_min, kink, q_max, roll_off_exponent)
        if not q_min <= kink <= q_max:
            raise ValueError(
                f"q_roll_off = {kink:.6g} rad/m must lie between q_min = {q_min:.6g} and q_max = {q_max:.6g} rad/m"
            )
        return unit

    @property
    def pieces(self) -> tuple[Piece, ...]:
        """The stretches (q_left, q_right, C(q_left), exponent), rising in q."""
        low, high = self.roll_off_exponent, 2.0 + 2.0 * self.hurst
        kink = min(max(self.q_roll_off, self.q_min), self.q_max)
        stretches = [(self.q_min, kink, low), (kink, self.q_max, high)]
        return tuple(
            (left, right, self.psd_at_roll_off * (left / self.q_roll_off) ** -exponent, exponent)
            for left, right, exponent in stretches
            if left < right
        )

    def scaled(self, factor: float) -> Self:
        """Return the spectrum times `factor`; 2 stands for two faces of the same roughness, uncorrelated."""
        return replace(self, psd_at_roll_off=self.psd_at_roll_off * positive("factor", factor))

    def truncated(self, *, q_max: float) -> Self:
        """Return the spectrum without what lies above `q_max`, rad/m; its level does not change."""
        return replace(self, q_max=min(positive("q_max", q_max, "rad/m"), self.q_max))


@dataclass(frozen=True, slots=True, eq=False)
class TabulatedSpectrum(PowerLaws):
    """C(q) from a table, a power law between each two points and zero outside.

    Parameters
    ----------
    q : array_like
        Wavenumbers, rad/m, at least two, positive and rising.
    psd : array_like
        C(q), m⁴, in Persson's convention (see `roughsim`), positive. A spectrum in SurfaceTopography's convention
        is 4π² larger.

    Raises
    ------
    TypeError, ValueError
        Naming the column, its value and its limit.
    """

    q: NDArray[np.float64]
    psd: NDArray[np.float64]

    def __post_init__(self) -> None:
        for name, unit in (("q", "rad/m"), ("psd", "m⁴")):
            array = _column(name, getattr(self, name), unit)
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
        return isinstance(other, TabulatedSpectrum) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)

    def __reduce__(self) -> tuple[Any, ...]:
        """Build the copy anew, so that its arrays are read-only too."""
        return type(self), (self.q, self.psd)

    @property
    def _key(self) -> tuple[bytes, bytes]:
        return self.q.tobytes(), self.psd.tobytes()

    @property
    def pieces(self) -> tuple[Piece, ...]:
        """The stretches (q_left, q_right, C(q_left), exponent), rising in q."""
        exponent = -np.diff(np.log(self.psd)) / np.diff(np.log(self.q))
        rows = np.stack([self.q[:-1], self.q[1:], self.psd[:-1], exponent], axis=1)
        return tuple((float(a), float(b), float(c), float(d)) for a, b, c, d in rows)

    def scaled(self, factor: float) -> TabulatedSpectrum:
        """Return the spectrum times `factor`; 2 stands for two faces of the same roughness, uncorrelated."""
        return TabulatedSpectrum(self.q, self.psd * positive("factor", factor))

    def truncated(self, *, q_max: float) -> TabulatedSpectrum:
        """Return the spectrum without what lies above `q_max`, rad/m; ValueError if nothing is left."""
        end = min(positive("q_max", q_max, "rad/m"), float(self.q[-1]))
        if end <= self.q[0]:
            raise ValueError(f"q_max = {end:.6g} rad/m must exceed the first wavenumber {self.q[0]:.6g} rad/m")
        below = self.q < end
        return TabulatedSpectrum(np.append(self.q[below], end), np.append(self.psd[below], self(end)))


@dataclass(frozen=True, slots=True)
class SumSpectrum(_Moments):
    """The spectrum of a sum of uncorrelated surfaces: C = Σ C_i, made by `+`."""

    terms: tuple[Face, ...]

    @property
    def breaks(self) -> tuple[float, ...]:
        """Wavenumbers where C(q) starts, has kinks or jumps, and ends, rad/m, rising."""
        return tuple(sorted({q for term in self.terms for q in term.breaks}))

    def __call__(self, q: ArrayLike) -> Any:
        """Return C(q) in m⁴ at wavenumbers in rad/m (any shape)."""
        return sum(term(q) for term in self.terms)

    def moment(self, order: float) -> float:
        """Return 2π ∫ q^(1 + order) C(q) dq over the whole spectrum, m^(2 − order)."""
        return sum(term.moment(order) for term in self.terms)

    def scaled(self, factor: float) -> SumSpectrum:
        """Return the spectrum times `factor`."""
        return SumSpectrum(tuple(term.scaled(factor) for term in self.terms))

    def truncated(self, *, q_max: float) -> SumSpectrum:
        """Return the spectrum without what lies above `q_max`, rad/m; ValueError if nothing is left."""
        q_max = positive("q_max", q_max, "rad/m")
        kept = tuple(term.truncated(q_max=q_max) for term in self.terms if term.breaks[0] < q_max)
        if not kept:
            raise ValueError(f"q_max = {q_max:.6g} rad/m must exceed the first wavenumber {self.breaks[0]:.6g} rad/m")
        return SumSpectrum(kept)


def _column(name: str, given: Any, unit: str) -> NDArray[np.float64]:
    """Return one column of a table as a read-only copy, finite and positive."""
    kind = np.asarray(given).dtype
    if isinstance(given, np.ma.MaskedArray) or kind.kind not in "uif":
        found = f"{name} is a {type(given).__name__} of dtype {kind}"
        raise TypeError(f"{found}; a plain array of real numbers in {unit} is needed")
    array = np.array(given, dtype=np.float64)
    if array.ndim != 1 or array.size < 2:
        raise ValueError(f"{name} has shape {array.shape}; a table of at least two points is needed")
    if not (np.isfinite(array).all() and (array > 0).all()):
        bad = array[~(array > 0) | ~np.isfinite(array)][0]
        raise ValueError(f"{name} holds {bad} {unit}; every value must be finite and positive")
    array.flags.writeable = False
    return array


def _terms(spectrum: Any) -> tuple[Any, ...]:
    return spectrum.terms if isinstance(spectrum, SumSpectrum) else (spectrum,)


@dataclass(frozen=True, slots=True)
class TruncatedSpectrum(_Moments):
    """Any callable with `breaks`, times `factor` and without what lies above `q_max`, rad/m.

    Spectra with a method `truncated` of their own are cut by that; this is for all others.
    """

    whole: Spectrum
    q_max: float = inf
    factor: float = 1.0

    @property
    def breaks(self) -> tuple[float, ...]:
        """Wavenumbers where C(q) starts, has kinks, and ends, rad/m, rising."""
        end = min(self.q_max, float(self.whole.breaks[-1]))
        return (*(float(q) for q in self.whole.breaks if q < end), end)

    def __call__(self, q: ArrayLike) -> Any:
        """Return C(q) in m⁴ at wavenumbers in rad/m (any shape); zero outside the ends."""
        q, first, last = np.asarray(q, dtype=np.float64), float(self.whole.breaks[0]), self.breaks[-1]
        value = self.factor * self.whole(np.clip(q, first, last))
        return np.where((first <= q) & (q <= last), value, 0.0)

    def above(self, q: Any, start: Any, rise: Any) -> Any:
        """Return C(q) in m⁴ at q = start·e^rise ≤ q_max, rad/m, with the precision of `whole` close above a break."""
        return self.factor * getattr(self.whole, "above", lambda at, *_: self.whole(at))(q, start, rise)

    def moment(self, order: float) -> float:
        """Return 2π ∫ q^(1 + order) C(q) dq over the whole spectrum, m^(2 − order).

        Raises
        ------
        ValueError
            If C(q) is not smooth between its breaks, so that two resolutions disagree.
        """
        coarse, fine = (sum(_panels(self, order, width)) for width in (0.5, 0.25))
        if not abs(fine - coarse) <= 1e-9 * abs(fine):
            raise ValueError(f"C(q) is not smooth between its breaks {self.breaks} rad/m; name its kinks there")
        return fine

    def scaled(self, factor: float) -> TruncatedSpectrum:
        """Return the spectrum times `factor`; 2 stands for two faces of the same roughness, uncorrelated."""
        return replace(self, factor=self.factor * positive("factor", factor))

    def truncated(self, *, q_max: float) -> TruncatedSpectrum:
        """Return the spectrum without what lies above `q_max`, rad/m; its level does not change."""
        return replace(self, q_max=min(positive("q_max", q_max, "rad/m"), self.q_max))


Face = SelfAffineSpectrum | TabulatedSpectrum | TruncatedSpectrum


def _panels(spectrum: TruncatedSpectrum, order: float, width: float) -> Iterator[float]:
    """2π ∫ q^(1 + order) C(q) dq between neighbouring breaks, by Gauss panels of at most `width` in ln q."""
    nodes, weights = np.polynomial.legendre.leggauss(16)
    for left, right in pairwise(spectrum.breaks):
        edges = np.linspace(log(left), log(right), 1 + ceil(log(right / left) / width))
        half = 0.5 * np.diff(edges)[:, None]
        q = np.exp(edges[:-1, None] + half * (1.0 + nodes))
        yield 2 * pi * float(np.sum(weights * half * q ** (2.0 + order) * spectrum(q)))
