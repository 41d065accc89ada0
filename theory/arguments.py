"""Checks of arguments, which refuse a wrong one before any work starts, and the interface of a spectrum."""

from collections.abc import Callable, Sequence
from dataclasses import fields
from functools import lru_cache, wraps
from types import MethodType
from typing import Any, ParamSpec, Protocol, TypeVar, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
P = ParamSpec("P")
R = TypeVar("R")
Several = Sequence[float] | Sequence[Sequence[float]] | NDArray[np.floating | np.integer]
Which = NDArray[np.bool_] | NDArray[np.intp]  # a mask or positions


SIZES = (
    1e-100,
    1e100,
)  # of numbers in SI units: products of three are in the range of double precision


class SpectrumLike(Protocol):
    """A function of the wavenumber that is smooth between its breaks and absent beyond the outer two."""

    @property
    def breaks(self) -> Sequence[float]:
        """Wavenumbers of the ends, kinks and jumps, ascending, rad/m."""

    def __call__(self, q: Array, /) -> Array:
        """Return the density at the wavenumbers `q`, rad/m, elementwise."""


class OfPeclet(Protocol):
    """A function of Péclet numbers."""

    @overload
    def __call__(self, peclet: float) -> float: ...
    @overload
    def __call__(self, peclet: Several) -> Array: ...
    @overload
    def __call__(self, peclet: ArrayLike) -> Array | float: ...


class OfPlace(Protocol):
    """A function of coordinates."""

    @overload
    def __call__(self, x: float, y: float) -> float: ...
    @overload
    def __call__(self, x: Several, y: ArrayLike) -> Array: ...
    @overload
    def __call__(self, x: ArrayLike, y: Several) -> Array: ...
    @overload
    def __call__(self, x: ArrayLike, y: ArrayLike) -> Array | float: ...


def itself(function: Any) -> Any:
    """Return a function, as a decorator that gives it another type: of floats a float, of arrays an array."""
    return function


of_peclet: Callable[[Callable[..., Array | float]], OfPeclet] = itself
of_place: Callable[[Callable[..., Array | float]], OfPlace] = itself


def real_array(name: str, value: ArrayLike, unit: str) -> Array:
    """Return `value` as a finite float64 array of its own shape; TypeError or ValueError naming `name` otherwise."""
    array = np.asarray(value)
    if isinstance(value, np.ma.MaskedArray) or array.dtype.kind not in "iuf":
        raise TypeError(f"{name} = {value!r} must be real numbers in {unit}")
    result = array.astype(np.float64)
    if not np.isfinite(result).all():
        raise ValueError(
            f"{name} holds values that are NaN or infinite; give finite numbers in {unit}"
        )
    return result


def not_negative_array(name: str, value: ArrayLike, unit: str) -> Array:
    """Return `value` as a finite array ≥ 0; TypeError or ValueError naming `name` otherwise."""
    result = real_array(name, value, unit)
    if (result < 0.0).any():
        raise ValueError(f"{name} = {result.min():.6g} {unit} must not be negative")
    return result


def positive(name: str, value: Any, unit: str) -> float:
    """Return `value` as one number > 0 of a size from SIZES; TypeError or ValueError naming `name` otherwise."""
    if value is None:
        raise TypeError(f"{name} is missing; give one positive number in {unit}")
    result = real_array(name, value, unit)
    if result.ndim != 0:
        raise TypeError(f"{name} has shape {result.shape}; one number in {unit} is needed")
    if result <= 0.0:
        raise ValueError(f"{name} = {float(result):.6g} {unit} must be positive")
    if not SIZES[0] <= result <= SIZES[1]:
        raise ValueError(
            f"{name} = {float(result):.6g} {unit} must be of a size from {SIZES[0]:g} to {SIZES[1]:g}: beyond, its "
            "squares leave double precision; check the exponent"
        )
    return float(result)


def float_if_scalar(values: Array | float) -> Array | float:
    """Return one number as a float, and an array with axes as it is."""
    return float(values) if np.ndim(values) == 0 else values


def in_blocks(of: Callable[[Array], Array], values: Array) -> Array:
    """Return `of` each number of an array, in columns of 64, which bound the memory; it returns one number a row."""
    flat = values.ravel()
    parts = [of(flat[i : i + 64, None]) for i in range(0, flat.size, 64)]
    return np.concatenate([np.empty(0), *parts]).reshape(values.shape)


def is_value(item: object) -> bool:
    """Return whether `item` compares by value, so that a result may be kept under it: not if it only equals itself.

    Nor if a part of it does, as of a tuple or of a record whose hash is that of its fields.
    """
    if item is None or isinstance(item, (int, float, str)):
        return True
    if isinstance(item, tuple):
        return all(is_value(part) for part in item)
    if type(item).__hash__ in {None, object.__hash__} or isinstance(item, MethodType):
        return False
    record: Any = item
    if getattr(getattr(record, "__dataclass_params__", None), "eq", False):
        return all(is_value(getattr(record, part.name)) for part in fields(record) if part.compare)
    try:
        hash(item)
    except TypeError:
        return False
    return True


def kept_for_values(made: Callable[P, R]) -> Callable[P, R]:
    """Return a function that keeps its last 64 results, but only for arguments that are values (`is_value`)."""
    kept: Any = lru_cache(maxsize=64, typed=True)(made)

    @wraps(made)
    def result(*arguments: P.args, **named: P.kwargs) -> R:
        values = all(is_value(each) for each in (*arguments, *named.values()))
        found: R = (kept if values else made)(*arguments, **named)
        return found

    return result


def breaks_of(spectrum: SpectrumLike) -> Array:
    """Return the distinct breaks of `spectrum`, ascending; TypeError or ValueError when they bound no interval."""
    if not callable(spectrum) or not hasattr(spectrum, "breaks"):
        raise TypeError(f"spectrum = {spectrum!r} must be a callable C(q) with an attribute breaks")
    breaks = real_array("breaks", spectrum.breaks, "rad/m")
    if breaks.ndim != 1 or breaks.size < 2 or breaks[0] <= 0.0 or (np.diff(breaks) < 0.0).any():
        raise ValueError(
            f"breaks = {spectrum.breaks!r} rad/m must be two or more positive wavenumbers, ascending"
        )
    distinct = np.unique(breaks)
    if distinct.size < 2:
        raise ValueError(
            f"breaks = {spectrum.breaks!r} rad/m enclose no wavenumbers; q_max must exceed q_min"
        )
    return distinct


def density(
    spectrum: SpectrumLike, wavenumber: Array, place: tuple[Array, Array] | None = None
) -> Array:
    """Return `spectrum` at `wavenumber`; ValueError when it is not finite, negative, or of another shape.

    `place` is a break q_k at or below each wavenumber, and ln(q/q_k). It is handed to a spectrum with a method `above`:
    close above a break q alone, a rounded number, has lost its distance from the break.
    """
    above = getattr(spectrum, "above", None)
    result = spectrum(wavenumber) if place is None or above is None else above(wavenumber, *place)
    values = np.asarray(result, dtype=np.float64)
    if values.shape != wavenumber.shape:
        raise ValueError(
            f"spectrum returned shape {values.shape} for wavenumbers of shape {wavenumber.shape}"
        )
    good = np.isfinite(values) & (values >= 0.0)
    if not good.all():
        raise ValueError(
            f"spectrum = {values[~good][0]:.6g} at q = {wavenumber[~good][0]:.6g} rad/m must be finite and not negative"
        )
    return values


def octaves_of_gaps(q: Array, rise: Array, faint: float) -> float:
    """Return the octaves of waves whose part of G is below the share `faint` of the part of waves on both sides.

    `rise` is q⁴C at the rising wavenumbers `q`, in proportion to the part of an octave in G ~ ∫ q³C dq.
    """
    both_sides = np.minimum(np.maximum.accumulate(rise), np.maximum.accumulate(rise[::-1])[::-1])
    below = rise < faint * both_sides
    return float(np.diff(np.log2(q))[below[1:] & below[:-1]].sum())
