"""Compiled inner loops, of arrays and numbers alone; the only place that imports numba."""

import multiprocessing
import warnings
from collections.abc import Callable
from typing import Any

from numba import njit

# sums may be reordered (so that they use vector units), but NaN and infinity keep their meaning
REORDER = frozenset({"reassoc", "contract", "nsz"})


def kernel(
    fastmath: frozenset[str] = frozenset(), inline: bool = False
) -> Callable[[Callable[..., Any]], Any]:
    """Return the decorator that all kernels share: compiled once, cached on disk, without the GIL.

    The compiler builds a kernel into the kernels that call it, but not if it loads these from the disk. The last bits
    must not depend on that. So a kernel that others call keeps the order of its sums (no `fastmath`), or it is
    `inline`: then it is always built in.
    """
    options: Any = {
        "cache": True,
        "nogil": True,
        "error_model": "numpy",
        "fastmath": set(fastmath),
        "inline": "always" if inline else "never",
    }

    def decorate(function: Callable[..., Any]) -> Any:
        try:
            return njit(**options)(function)
        except RuntimeError:
            # neither the package's folder nor the user's cache folder can be written; a worker's parent has warned
            if multiprocessing.current_process().name == "MainProcess":
                warnings.warn(
                    "compiled code cannot be kept: each process compiles again, which takes seconds; set "
                    "NUMBA_CACHE_DIR to a folder that takes files",
                    RuntimeWarning,
                    stacklevel=1,
                )
            return njit(**options | {"cache": False})(function)

    return decorate


def is_loaded(function: Callable[..., Any]) -> bool:
    """Whether a kernel is ready in this process, from the cache or compiled."""
    return bool(getattr(function, "signatures", True))  # there are none with NUMBA_DISABLE_JIT=1


def was_compiled(function: Callable[..., Any]) -> bool:
    """Whether this process compiled a kernel and keeps it for later ones; False if it came from the cache."""
    statistics = getattr(function, "stats", None)  # there are none with NUMBA_DISABLE_JIT=1
    return (
        statistics is not None
        and statistics.cache_path is not None
        and bool(statistics.cache_misses)
    )
