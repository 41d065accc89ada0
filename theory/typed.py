"""Types of functions of the speed for type checkers: of one speed a float, of an array an array."""

from typing import Protocol, Required, TypedDict, Unpack, overload

from numpy.typing import ArrayLike

from theory.arguments import Array, Several, SpectrumLike
from theory.persson import Weight
from theory.skin import Skin


class Body(TypedDict, total=False):
    """A body that a pressed contact heats, by keyword."""

    nominal_pressure: Required[float]
    friction_coefficient: Required[float]
    conductivity: Required[float]
    diffusivity: Required[float]
    skin: Skin | None
    heat_depth: float


class Load(Body, total=False):
    """A body and its contact, by keyword."""

    effective_modulus: float | None
    gamma: Weight
    stress_spectrum: SpectrumLike | None


class OfSpeed(Protocol):
    """A function of speeds, and of what `theory.flash.heat_source` takes."""

    @overload
    def __call__(
        self, speed: float, spectrum: SpectrumLike | None = None, **load: Unpack[Load]
    ) -> float: ...
    @overload
    def __call__(
        self, speed: Several, spectrum: SpectrumLike | None = None, **load: Unpack[Load]
    ) -> Array: ...
    @overload
    def __call__(
        self, speed: ArrayLike, spectrum: SpectrumLike | None = None, **load: Unpack[Load]
    ) -> Array | float: ...
