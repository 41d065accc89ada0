"""Power spectra C(q) of isotropic roughness: their interface, sums of spectra, and a wrapper for any callable.

Each spectrum is a callable C(q) in m⁴ that is zero outside its ends, and has `breaks`: the ends and the kinks between
which it is smooth. The two public classes, self-affine and tabulated, are in `power_laws`.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from itertools import chain, pairwise
from math import ceil, inf, log, pi, sqrt
from typing import Any, Protocol, Self

import numpy as np
from numpy.typing import ArrayLike

from roughsim.errors import positive
from roughsim.grid import Array


class Spectrum(Protocol):
    """The interface that every stage uses: C(q), and the wavenumbers between which it is smooth."""

    __slots__ = ()

    @property
    def breaks(self) -> tuple[float, ...]:
        """Ends and kinks of C(q), rad/m, rising."""

    def __call__(self, q: Any, /) -> Any:
        """C(q) in m⁴ at wavenumbers in rad/m; zero outside the ends."""


class Face(Spectrum, ABC):
    """A spectrum with moments: of one face of a contact, or of several faces added up."""

    __slots__ = ()

    @abstractmethod
    def moment(self, order: float) -> float:
        """Return 2π ∫ q^(1 + order) C(q) dq over the whole spectrum, m^(2 − order)."""

    @abstractmethod
    def scaled(self, factor: float) -> Self:
        """Return the spectrum times `factor`; 2 stands for two faces of the same roughness, uncorrelated."""

    @abstractmethod
    def truncated(self, *, q_max: float) -> Self:
        """Return the spectrum cut off at `q_max`, rad/m; ValueError if nothing is left."""

    @property
    def directed(self) -> bool:
        """Whether C depends on the direction of the wave: then `at(q, angle)` gives it."""
        return hasattr(self, "at")

    @property
    def rms_height(self) -> float:
        """√⟨h²⟩ = √(2π ∫ q C dq), m."""
        return sqrt(self.moment(0))

    @property
    def rms_slope(self) -> float:
        """√⟨|∇h|²⟩ = √(2π ∫ q³ C dq), dimensionless."""
        return sqrt(self.moment(2))

    def __add__(self, other: "Face") -> "SumSpectrum":
        """Return the spectrum of the sum of two uncorrelated surfaces."""
        if not isinstance(other, Face):
            return NotImplemented
        terms = (getattr(face, "terms", (face,)) for face in (self, other))
        return SumSpectrum(tuple(chain(*terms)))


@dataclass(frozen=True, slots=True)
class SumSpectrum(Face):
    """The spectrum of a sum of uncorrelated surfaces: C = Σ C_i, made by `+`."""

    terms: tuple[Face, ...]

    @property
    def breaks(self) -> tuple[float, ...]:
        """Ends, kinks and jumps of C(q), rad/m, rising."""
        return tuple(sorted({q for term in self.terms for q in term.breaks}))

    def __call__(self, q: ArrayLike) -> Any:
        """Return C(q) in m⁴ at wavenumbers in rad/m (any shape)."""
        return sum(term(q) for term in self.terms)

    @property
    def directed(self) -> bool:
        """Whether a term depends on the direction of the wave."""
        return any(term.directed for term in self.terms)

    def at(self, q: Array, angle: Array) -> Array:
        """Return C(q⃗), m⁴, at wavenumbers, rad/m, and angles, radians."""
        terms = (term.at(q, angle) if term.directed else term(q) for term in self.terms)  # type: ignore[attr-defined]
        return sum(terms)

    def moment(self, order: float) -> float:
        """Return 2π ∫ q^(1 + order) C(q) dq over the whole spectrum, m^(2 − order)."""
        return sum(term.moment(order) for term in self.terms)

    def scaled(self, factor: float) -> "SumSpectrum":
        """Return the spectrum times `factor`."""
        return SumSpectrum(tuple(term.scaled(factor) for term in self.terms))

    def truncated(self, *, q_max: float) -> "SumSpectrum":
        """Return the spectrum cut off at `q_max`, rad/m; ValueError if nothing is left."""
        q_max = positive("q_max", q_max, "rad/m")
        kept = tuple(term.truncated(q_max=q_max) for term in self.terms if term.breaks[0] < q_max)
        if not kept:
            raise ValueError(
                f"q_max = {q_max:.6g} rad/m must exceed the first wavenumber {self.breaks[0]:.6g} rad/m"
            )
        return SumSpectrum(kept)


@dataclass(frozen=True, slots=True)
class TruncatedSpectrum(Face):
    """Any callable with `breaks`, times `factor` and cut off at `q_max`, rad/m.

    It is for spectra without a method `truncated` of their own.
    """

    whole: Spectrum
    q_max: float = inf
    factor: float = 1.0

    @property
    def breaks(self) -> tuple[float, ...]:
        """Ends and kinks of C(q), rad/m, rising."""
        end = min(self.q_max, float(self.whole.breaks[-1]))
        return (*(float(q) for q in self.whole.breaks if q < end), end)

    def __call__(self, q: ArrayLike) -> Any:
        """Return C(q) in m⁴ at wavenumbers in rad/m (any shape); zero outside the ends."""
        q = np.asarray(q, dtype=float)
        last = self.breaks[-1]
        first = float(self.whole.breaks[0])
        value = self.factor * self.whole(np.clip(q, first, last))
        return np.where((first <= q) & (q <= last), value, 0.0)

    def above(self, q: Any, start: Any, rise: Any) -> Any:
        """Return C(q) in m⁴ at q = start·e^rise ≤ q_max, rad/m, with the precision of `whole` close above a break."""
        above = getattr(self.whole, "above", lambda at, *_: self.whole(at))
        return self.factor * above(q, start, rise)

    def moment(self, order: float) -> float:
        """Return 2π ∫ q^(1 + order) C(q) dq, m^(2 − order); ValueError if C(q) is not smooth between its breaks."""
        # Gauss panels between neighbouring breaks, of at most so wide a step in ln q
        nodes, weights = np.polynomial.legendre.leggauss(16)
        integrals = [0.0, 0.0]
        for k, width in enumerate((0.5, 0.25)):
            for left, right in pairwise(self.breaks):
                edges = np.linspace(log(left), log(right), 1 + ceil(log(right / left) / width))
                half = 0.5 * np.diff(edges)[:, None]
                q = np.exp(edges[:-1, None] + half * (1.0 + nodes))
                terms = weights * half * q ** (2.0 + order) * self(q)
                integrals[k] += 2 * pi * float(np.sum(terms))
        coarse, fine = integrals
        if not abs(fine - coarse) <= 1e-9 * abs(fine):
            raise ValueError(
                f"C(q) is not smooth between its breaks {self.breaks} rad/m; name its kinks there"
            )
        return fine

    def scaled(self, factor: float) -> "TruncatedSpectrum":
        """Return the spectrum times `factor`; 2 stands for two faces of the same roughness, uncorrelated."""
        return replace(self, factor=self.factor * positive("factor", factor))

    def truncated(self, *, q_max: float) -> "TruncatedSpectrum":
        """Return the spectrum cut off at `q_max`, rad/m; its level does not change."""
        return replace(self, q_max=min(positive("q_max", q_max, "rad/m"), self.q_max))
