"""Errors, and checks that refuse arguments before any work starts.

Every message names the quantity, its value with unit, the limit, and the remedy.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughsim.show.text import plain

# of numbers in SI units: products of three are in the range of double precision
_SIZES = 1e-100, 1e100


class RoughsimError(Exception):
    """Base class of the errors that roughsim itself defines; names in its message cannot command a terminal."""

    def __str__(self) -> str:
        return plain(super().__str__())


class ConvergenceError(RoughsimError, RuntimeError):
    """An iteration did not reach its tolerance.

    Attributes
    ----------
    residual : float
        The residual at the last iteration, dimensionless.
    iterations : int
        Iterations done on the finest grid.
    pressure : ndarray or None
        The pressure at the last iteration, Pa: for inspection, not for use.
    """

    def __init__(
        self,
        message: str,
        residual: float,
        iterations: int,
        pressure: NDArray[np.float64] | None = None,
    ):
        super().__init__(message)
        self.residual = residual
        self.iterations = iterations
        self.pressure = pressure

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the attributes too, so that they come back from a worker process."""
        return type(self), (str(self), self.residual, self.iterations, self.pressure)


class RecordError(RoughsimError, ValueError):
    """A stored file or run folder is damaged, of another format, or of another run."""


class ResolutionError(RoughsimError, ValueError):
    """A grid is too coarse, or a machine too small, for the computation."""


def instance(name: str, value: Any, kind: type, example: str) -> None:
    """Raise TypeError if a value is not of a class; `example` is a call that makes one."""
    if not isinstance(value, kind):
        raise TypeError(f"{name} = {value!r} must be a {kind.__name__}, as {example}")


def number(name: str, value: Any, unit: str = "") -> float:
    """Return `value` as a finite float; ValueError or TypeError naming `name` otherwise."""
    try:
        if isinstance(value, (bool, np.bool_, str, bytes, complex)) or np.ndim(value) != 0:
            raise TypeError
        result = float(value)
    except OverflowError:  # a whole number of hundreds of digits
        result = math.inf
    except (TypeError, ValueError):
        raise TypeError(
            f"{name} = {value!r} must be one real number" + (f" in {unit}" if unit else "")
        ) from None
    if not math.isfinite(result):
        raise ValueError(f"{name} = {result} {unit}".rstrip() + " must be finite")
    return result


def positive(name: str, value: Any, unit: str = "") -> float:
    """Return `value` as a finite float > 0; ValueError or TypeError naming `name` otherwise."""
    result = number(name, value, unit)
    if result <= 0.0:
        raise ValueError(f"{name} = {result:.6g} {unit}".rstrip() + " must be positive")
    return result


def sized(name: str, value: Any, unit: str = "") -> float:
    """Return `value` as a float of a size from SIZES; ValueError or TypeError naming `name` otherwise."""
    result = positive(name, value, unit)
    if not _SIZES[0] <= result <= _SIZES[1]:
        raise ValueError(
            f"{name} = {result:.6g} {unit}".rstrip()
            + f" must be of a size from {_SIZES[0]:g} to {_SIZES[1]:g}: beyond, its squares leave double precision; "
            "check the exponent"
        )
    return result


def need_computed(name: str, values: NDArray[Any], unit: str, causes: str) -> None:
    """Refuse with a ValueError a result that has left double precision; `causes` names the arguments it came from."""
    if not np.isfinite(values).all():
        raise ValueError(
            f"{name} exceeds 1.8e+308 {unit}, the range of double precision; check the sizes of {causes}"
        )


def not_negative(name: str, value: Any, unit: str = "") -> float:
    """Return `value` as a finite float ≥ 0; ValueError or TypeError naming `name` otherwise."""
    result = number(name, value, unit)
    if result < 0.0:
        raise ValueError(f"{name} = {result:.6g} {unit}".rstrip() + " must not be negative")
    return result


def real_field(name: str, value: ArrayLike, shape: tuple[int, ...] | None = None) -> NDArray[Any]:
    """Return `value` as a finite real 2-D array: float32 stays, everything else real becomes float64.

    TypeError for masked, complex, string and object arrays, which a conversion would silently change; ValueError if it
    is not two-dimensional, not of `shape`, empty, or holds NaN or infinity.
    """
    array = real_plane(name, value, shape)
    need_finite(name, array)
    return array


def need_finite(name: str, array: NDArray[Any]) -> None:
    """Refuse NaN and infinity with a ValueError."""
    if not np.isfinite(array).all():
        raise ValueError(
            f"{name} holds {int((~np.isfinite(array)).sum())} values that are NaN or infinite"
        )


def real_plane(name: str, value: ArrayLike, shape: tuple[int, ...] | None = None) -> NDArray[Any]:
    """Return `value` as `real_field` does, but do not look for NaN and infinity: for callers that do so themselves."""
    if isinstance(value, np.ma.MaskedArray):
        raise TypeError(f"{name} is a masked array; fill or crop the masked points first")
    array = np.asarray(value)
    if array.dtype.kind not in "buif":
        raise TypeError(f"{name} has dtype {array.dtype}; a real numeric array is needed")
    if array.ndim != 2 or array.size == 0:
        raise ValueError(
            f"{name} has shape {array.shape}; a 2-D array with at least one point is needed"
        )
    if shape is not None and array.shape != shape:
        raise ValueError(f"{name} has shape {array.shape}, but the grid has shape {shape}")
    single = array.dtype.kind == "f" and array.dtype.itemsize == 4
    return np.ascontiguousarray(array, dtype=np.float32 if single else np.float64)
