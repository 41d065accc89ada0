"""Compiled inner loops: the one door to numba. Kernels take arrays and floats, and know nothing else."""

import warnings
from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

Function = TypeVar("Function", bound=Callable[..., Any])

# sums may be reordered (so that they use vector units), but NaN and infinity keep their meaning
REORDER = frozenset({"reassoc", "contract", "nsz"})


def kernel(fastmath: frozenset[str] = frozenset(), inline: bool = False) -> Callable[[Function], Function]:
    """Return the decorator that all kernels share: compiled once, cached on disk, without the GIL.

    A kernel that others call is a part of them when they are compiled but not when they come from the disk. So that
    the last bits do not depend on that, it keeps the order of its sums, or it is `inline`: always a part of them.
    """

    def decorate(function: Function) -> Function:
        options: dict[str, Any] = {"cache": True, "nogil": True, "error_model": "numpy", "fastmath": set(fastmath)}
        options["inline"] = "always" if inline else "never"
        try:
            return cast(Function, njit(**options)(function))
        except RuntimeError:  # neither the package's folder nor the user's own takes files
            warnings.warn(
                "compiled code cannot be kept: each process compiles anew, which takes seconds; set NUMBA_CACHE_DIR "
                "to a folder that takes files",
                RuntimeWarning,
                stacklevel=1,
            )
            return cast(Function, njit(**options | {"cache": False})(function))

    return decorate
