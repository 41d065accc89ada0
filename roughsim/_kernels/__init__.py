"""Compiled inner loops: the only place that imports numba. Kernels take arrays and numbers, and know nothing else."""

import warnings
from collections.abc import Callable
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar, cast

from numba import njit

Function = TypeVar("Function", bound=Callable[..., Any])

# sums may be reordered (so that they use vector units), but NaN and infinity keep their meaning
REORDER = frozenset({"reassoc", "contract", "nsz"})


def load_arrays_of_numba() -> None:
    """Import what numba imports with its first kernel, but for its look for a BLAS: that would load scipy.linalg.

    No kernel here needs one. Where kernels of others do, numba looks again.
    """
    linear_algebra: Any = import_module("numba.np.linalg")
    look = linear_algebra.ensure_blas
    linear_algebra.ensure_blas = lambda: None
    try:
        import_module("numba.np.arraymath")
    finally:
        linear_algebra.ensure_blas = look


with suppress(AttributeError, ImportError):  # releases of numba that have this elsewhere
    load_arrays_of_numba()


def kernel(
    fastmath: frozenset[str] = frozenset(), inline: bool = False, allocates: bool = False
) -> Callable[[Function], Function]:
    """Return the decorator that all kernels share: compiled once, cached on disk, without the GIL.

    The compiler builds a kernel into the kernels that call it, but not where it loads these from the disk. The last
    bits must not depend on that. So a kernel that others call keeps the order of its sums (no `fastmath`), or it is
    `inline`: then it is always built in.

    A kernel that makes no array, and returns none, needs no counts of who holds its arrays: without them it compiles in
    nine tenths of the time, so those of a contact solve are given their buffers. One that makes any `allocates`.
    """

    def decorate(function: Function) -> Function:
        options: dict[str, Any] = {"cache": True, "nogil": True, "error_model": "numpy", "fastmath": set(fastmath)}
        options["inline"] = "always" if inline else "never"
        options |= {"_nrt": allocates, "no_cfunc_wrapper": True}  # no C function calls a kernel
        try:
            return cast(Function, njit(**options)(function))
        except RuntimeError:  # neither the package's folder nor the user's cache folder can be written
            warnings.warn(
                "compiled code cannot be kept: each process compiles anew, which takes seconds; set NUMBA_CACHE_DIR "
                "to a folder that takes files",
                RuntimeWarning,
                stacklevel=1,
            )
            return cast(Function, njit(**options | {"cache": False})(function))

    return decorate


def found_compiled(function: Callable[..., Any]) -> bool:
    """Whether a kernel that was called came from the cache; True also where nothing is compiled, or can be kept."""
    counts = getattr(function, "stats", None)
    return counts is None or counts.cache_path is None or bool(counts.cache_hits)


def never_compiled(function: Callable[..., Any]) -> bool:
    """Whether the cache holds nothing at all of a kernel: then it need not be called to know that."""
    counts = getattr(function, "stats", None)
    if counts is None or counts.cache_path is None:
        return False
    return not any(Path(counts.cache_path).glob(f"*.{function.__name__}-*.nbi"))
