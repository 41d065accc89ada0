"""Compiled inner loops: the one door to numba. Kernels take arrays and floats, and know nothing else."""

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

Function = TypeVar("Function", bound=Callable[..., Any])

# sums may be reordered (so that they use vector units), but NaN and infinity keep their meaning
REORDER = frozenset({"reassoc", "contract", "nsz"})


def kernel(fastmath: frozenset[str] = frozenset()) -> Callable[[Function], Function]:
    """Return the decorator that all kernels share: compiled once, cached on disk, without the GIL."""

    def decorate(function: Function) -> Function:
        options: dict[str, Any] = {"cache": True, "nogil": True, "error_model": "numpy", "fastmath": set(fastmath)}
        return cast(Function, njit(**options)(function))

    return decorate
